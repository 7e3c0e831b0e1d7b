//! Settings as read or set.

use magician_protocol::commands::{
    PtpJump2Params, PtpJumpParams, SetEndEffectorGripper, SetEndEffectorSuctionCup,
};
use magician_protocol::{Ctrl, Effect, Frame, FrameBuf, Readable, Row, Set, Writable};

use crate::connection::Micros;
use crate::preflight::check_numbers;

/// Largest number of values kept: more than a check depends on.
pub(super) const MAX_VALUES: usize = 48;

/// Replies that the arm would give now to gets of its settings.
#[derive(Clone, Debug, Default)]
pub(super) struct SettingValues(Vec<Value>);

/// Reply to a get of a setting.
#[derive(Clone, Debug)]
struct Value {
    id: u8,
    query: Vec<u8>,
    params: Vec<u8>,
    /// Instant at which it was valid.
    at: Micros,
}

impl SettingValues {
    pub(super) fn get_with<T: Readable>(&self, query: &T::Query, since: Micros) -> Option<T> {
        let query = FrameBuf::get(query, T::ROW).ok()?;
        let query = query.frame();
        let is_it = |value: &&Value| {
            value.id == T::ROW.id && value.query == query.params() && value.at >= since
        };
        let value = self.0.iter().find(is_it)?;
        T::decode(&value.params).ok()
    }

    pub(super) fn keep(&mut self, at: Micros, row: &Row, query: &[u8], params: &[u8]) {
        let (id, query) = (row.id, query.to_vec());
        self.0
            .retain(|value| value.id != id || value.query != query);
        // The oldest goes: it can be read again.
        if self.0.len() >= MAX_VALUES {
            self.0.remove(0);
        }
        self.0.push(Value {
            id,
            query,
            params: params.to_vec(),
            at,
        });
    }

    pub(super) fn drop_changed(&mut self, row: &Row) {
        self.0.retain(|value| {
            let other = Row::with_id(value.id);
            !other.is_some_and(|other| reaches(row, other))
        });
    }

    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }
}

/// True if a command of this row changes the reply to a get.
pub(super) fn changes(row: &Row) -> bool {
    row.may_burn || matches!(row.effect, Effect::Setting | Effect::Laser)
}

/// True if a command of `row` changes the value of `other`.
///
/// A command changes its own value. One that may burn also changes the laser's state. The two
/// commands for jump heights change each other's value (model section 7), and so do the commands of
/// the two tools that share the pump (model section 13).
pub(super) fn reaches(row: &Row, other: &Row) -> bool {
    const JUMPS: [u8; 2] = [
        <PtpJumpParams as Writable>::ROW.id,
        <PtpJump2Params as Writable>::ROW.id,
    ];
    const AIR: [u8; 2] = [
        SetEndEffectorSuctionCup::ROW.id,
        SetEndEffectorGripper::ROW.id,
    ];
    row.id == other.id
        || row.may_burn && other.effect == Effect::Laser
        || JUMPS.contains(&row.id) && JUMPS.contains(&other.id)
        || AIR.contains(&row.id) && AIR.contains(&other.id)
}

/// Converts a set into the reply that a get gives afterwards. `None` unless the row has one layout
/// for both, and the frame has its full form and numbers that an arm accepts.
pub(super) fn as_value(row: &Row, request: &Frame<'_>) -> Option<FrameBuf> {
    let one_layout = row.value.zip(row.set);
    let one_layout = one_layout.is_some_and(|(value, set)| value.name == set.name);
    let asks = row.query.is_some_and(|query| !query.fields.is_empty());
    // Values selected by an address are read, not derived.
    if !one_layout || asks {
        return None;
    }
    let command = Set::decode(row.id, request.params()).ok()?;
    let frame = FrameBuf::set(&command, Ctrl::SET).ok()?;
    let exact = frame.frame().params() == request.params();
    // A short form or a refused number may be stored differently by the arm.
    (exact && check_numbers(&command).is_ok()).then_some(frame)
}
