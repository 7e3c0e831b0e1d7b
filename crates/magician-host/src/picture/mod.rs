//! What is known of an arm's settings without asking it.

use magician_protocol::commands::{
    PtpJump2Params, PtpJumpParams, QueuedCmdClear, QueuedCmdCurrentIndex, QueuedCmdStartDownload,
};
use magician_protocol::{
    Ctrl, Effect, Frame, FrameBuf, NoArgs, QueuedCmdIndex, Readable, Row, Set, Writable,
};

use crate::connection::Micros;
use crate::preflight::check_numbers;

/// Values that are remembered: more than a check depends on.
const MOST: usize = 48;

/// The settings of an arm, as they were read or set over one connection: a check that needs them need not read them again.
///
/// A value is forgotten before anything is sent that may change it, and known again when the arm has answered. What was
/// queued counts when the arm has finished it, and until then nothing read in between is kept. Resets, lost lines and foreign
/// commands are not seen here: the caller reports them ([`forget`](Self::forget), [`reset`](Self::reset)).
///
/// It keeps at most 48 values.
///
/// ```
/// use magician_host::protocol::{EncodeError, Readable};
/// use magician_host::{Ctrl, FrameBuf, ArmPicture, commands::PtpCommonParams, words};
///
/// let mut picture = ArmPicture::default();
/// let request = FrameBuf::set(&words::speed(80.0, 60.0), Ctrl::SET)?;
/// let reply = FrameBuf::new(PtpCommonParams::ROW.id, Ctrl::SET, &[])?;
/// picture.sends(&request.frame());
/// assert_eq!(picture.get::<PtpCommonParams>(0), None);
/// picture.answered(5_000, &request.frame(), &reply.frame());
/// let known: PtpCommonParams = picture.get(0).unwrap();
/// assert_eq!(known.velocity_ratio, 80.0);
/// # Ok::<(), EncodeError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct ArmPicture {
    values: Vec<Value>,
    /// What commands on their way, or in the arm's queue, will change: the last one of each row.
    pending: Vec<Pending>,
}

/// What an arm answers to a get.
#[derive(Clone, Debug)]
struct Value {
    id: u8,
    query: Vec<u8>,
    params: Vec<u8>,
    /// When that was so.
    at: Micros,
}

/// A queued command that changes something.
#[derive(Clone, Copy, Debug)]
struct Pending {
    row: &'static Row,
    /// Nothing before the arm has told it.
    index: Option<u64>,
    /// What it sets, if that is known.
    value: Option<FrameBuf>,
}

/// Hear.
impl ArmPicture {
    /// A request goes out: what it may change is not known any more.
    pub fn sends(&mut self, request: &Frame<'_>) {
        let ctrl = request.ctrl();
        if !ctrl.write() && !ctrl.queued() {
            return;
        }
        let Some(row) = Row::with_id(request.id()) else {
            return self.forget();
        };
        match row.effect {
            // A program that the arm keeps sets what it likes.
            Effect::Queue if row.id == QueuedCmdStartDownload::ROW.id => self.forget(),
            Effect::Store => self.forget(),
            _ if changes(row) => {
                self.drop_changed(row);
                if ctrl.queued() {
                    self.wait_for(row, None, None);
                }
            }
            _ => {}
        }
    }

    /// A request was answered at `now`, us.
    pub fn answered(&mut self, now: Micros, request: &Frame<'_>, reply: &Frame<'_>) {
        let Some(row) = Row::with_id(request.id()) else {
            return;
        };
        let ctrl = request.ctrl();
        if ctrl.queued() {
            if let (true, Ok(QueuedCmdIndex(index))) = (changes(row), reply.read()) {
                self.wait_for(row, Some(index), as_value(row, request));
            }
        } else if !ctrl.write() {
            self.read(now, row, request, reply);
        } else if row.id == QueuedCmdClear::ROW.id {
            self.pending.clear();
        } else if let Some(value) = as_value(row, request) {
            self.keep(now, row, &[], value.frame().params());
        }
    }

    /// The arm has taken a command into its queue under this index.
    pub fn accepted(&mut self, index: u64, command: &Set) {
        let row = command.row();
        if changes(row) {
            let frame = FrameBuf::set(command, Ctrl::QUEUED).ok();
            let value = frame.and_then(|frame| as_value(row, &frame.frame()));
            self.wait_for(row, Some(index), value);
        }
    }

    /// Nothing is known any more: the line was lost, or another program has used the arm. What waits in its queue may
    /// still do.
    pub fn forget(&mut self) {
        self.values.clear();
        self.pending.iter_mut().for_each(|one| one.value = None);
    }

    /// The arm was reset: nothing is known, and nothing waits.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    fn read(&mut self, now: Micros, row: &'static Row, request: &Frame<'_>, reply: &Frame<'_>) {
        if row.id == <QueuedCmdCurrentIndex as Readable>::ROW.id {
            if let Ok(read) = reply.read::<QueuedCmdCurrentIndex>() {
                self.finished(now, read.queued_cmd_current_index);
            }
        } else if matches!(row.effect, Effect::Setting | Effect::Laser) {
            self.keep(now, row, request.params(), reply.params());
        }
    }

    /// The arm has finished the commands of its queue up to this index.
    fn finished(&mut self, now: Micros, current: u64) {
        let over = |one: &Pending| one.index.is_some_and(|index| index <= current);
        let done: Vec<Pending> = self.pending.extract_if(.., |one| over(one)).collect();
        for one in done {
            self.drop_changed(one.row);
            if let Some(value) = one.value {
                self.keep(now, one.row, &[], value.frame().params());
            }
        }
    }

    fn wait_for(&mut self, row: &'static Row, index: Option<u64>, value: Option<FrameBuf>) {
        self.pending.retain(|one| one.row.id != row.id);
        self.pending.push(Pending { row, index, value });
    }

    fn keep(&mut self, at: Micros, row: &'static Row, query: &[u8], params: &[u8]) {
        if self.pending.iter().any(|one| reaches(one.row, row)) {
            return;
        }
        let (id, query) = (row.id, query.to_vec());
        self.values
            .retain(|value| value.id != id || value.query != query);
        if self.values.len() >= MOST {
            self.values.remove(0);
        }
        self.values.push(Value {
            id,
            query,
            params: params.to_vec(),
            at,
        });
    }

    fn drop_changed(&mut self, row: &Row) {
        self.values.retain(|value| {
            let other = Row::with_id(value.id);
            !other.is_some_and(|other| reaches(row, other))
        });
    }
}

/// Look.
impl ArmPicture {
    /// A value, if it is known and was so at `since` (us) or later.
    #[must_use]
    pub fn get<T: Readable<Query = NoArgs>>(&self, since: Micros) -> Option<T> {
        self.get_with(&NoArgs, since)
    }

    /// As [`get`](Self::get), of a value that depends on something.
    #[must_use]
    pub fn get_with<T: Readable>(&self, query: &T::Query, since: Micros) -> Option<T> {
        let query = FrameBuf::get(query, T::ROW).ok()?;
        let query = query.frame();
        let is_it = |value: &&Value| {
            value.id == T::ROW.id && value.query == query.params() && value.at >= since
        };
        let value = self.values.iter().find(is_it)?;
        T::decode(&value.params).ok()
    }
}

/// Whether a command of this row changes what a get answers.
fn changes(row: &Row) -> bool {
    row.may_burn || matches!(row.effect, Effect::Setting | Effect::Laser)
}

/// Whether a command of `row` changes the value of `other`: its own, the laser of what may burn, and the heights of jumps,
/// which have two commands (model section 7).
fn reaches(row: &Row, other: &Row) -> bool {
    const JUMPS: [u8; 2] = [
        <PtpJumpParams as Writable>::ROW.id,
        <PtpJump2Params as Writable>::ROW.id,
    ];
    row.id == other.id
        || row.may_burn && other.effect == Effect::Laser
        || JUMPS.contains(&row.id) && JUMPS.contains(&other.id)
}

/// A set whose parameters are what a get answers then: of a row that has one layout for both, in its full form, with numbers
/// that an arm takes.
fn as_value(row: &Row, request: &Frame<'_>) -> Option<FrameBuf> {
    let one_layout = row.value.zip(row.set);
    let one_layout = one_layout.is_some_and(|(value, set)| value.name == set.name);
    let asks = row.query.is_some_and(|query| !query.fields.is_empty());
    if !one_layout || asks {
        return None;
    }
    let command = Set::decode(row.id, request.params()).ok()?;
    let frame = FrameBuf::set(&command, Ctrl::SET).ok()?;
    let exact = frame.frame().params() == request.params();
    (exact && check_numbers(&command).is_ok()).then_some(frame)
}

#[cfg(test)]
mod tests {
    use magician_protocol::Flag;
    use magician_protocol::commands::{
        EndEffectorLaser, IoMultiplexing, PtpCommonParams, QueuedCmdStartExec,
    };

    use super::*;
    use crate::words;

    const JUMP: PtpJumpParams = PtpJumpParams {
        jump_height: 20.0,
        z_limit: 100.0,
    };

    #[derive(Default)]
    struct Rig(ArmPicture);

    impl Rig {
        fn answer(&mut self, request: FrameBuf, params: &[u8]) {
            let request = request.frame();
            let reply = FrameBuf::new(request.id(), request.ctrl(), params).unwrap();
            self.0.sends(&request);
            self.0.answered(7, &request, &reply.frame());
        }

        fn sets(&mut self, command: impl Into<Set>) {
            let request = FrameBuf::set(&command.into(), Ctrl::SET).unwrap();
            self.answer(request, &[]);
        }

        fn queues(&mut self, index: u64, command: impl Into<Set>) {
            let request = FrameBuf::set(&command.into(), Ctrl::QUEUED).unwrap();
            self.answer(request, &index.to_le_bytes());
        }

        fn reads<T: Readable<Query = NoArgs>>(&mut self, value: &T) {
            let value = FrameBuf::encode(T::ROW.id, Ctrl::GET, value).unwrap();
            let request = FrameBuf::get(&NoArgs, T::ROW).unwrap();
            self.answer(request, value.frame().params());
        }

        fn finishes(&mut self, current: u64) {
            self.reads(&QueuedCmdCurrentIndex {
                queued_cmd_current_index: current,
            });
        }

        fn ratio(&self) -> Option<f32> {
            let known = self.0.get::<PtpCommonParams>(0);
            known.map(|known| known.velocity_ratio)
        }
    }

    fn ratio(velocity_ratio: f32) -> PtpCommonParams {
        PtpCommonParams {
            velocity_ratio,
            acceleration_ratio: 50.0,
        }
    }

    #[test]
    fn what_was_read_or_set_is_known_until_it_may_change() {
        let mut rig = Rig::default();
        rig.reads(&ratio(40.0));
        assert_eq!(rig.ratio(), Some(40.0));
        let request = FrameBuf::set(&ratio(60.0).into(), Ctrl::SET).unwrap();
        rig.0.sends(&request.frame());
        assert_eq!(rig.ratio(), None, "it is unknown whether the arm took it");
        rig.sets(ratio(60.0));
        assert_eq!(rig.ratio(), Some(60.0));
        assert!(rig.0.get::<PtpCommonParams>(8).is_none(), "it is too old");
        rig.0.forget();
        assert_eq!(rig.ratio(), None);
    }

    #[test]
    fn what_is_queued_counts_when_it_is_done() {
        let mut rig = Rig::default();
        rig.sets(ratio(40.0));
        rig.queues(5, ratio(70.0));
        rig.finishes(4);
        // Between them the arm may change it at any time.
        rig.reads(&ratio(40.0));
        assert_eq!(rig.ratio(), None);
        rig.queues(6, ratio(90.0));
        rig.finishes(5);
        assert_eq!(rig.ratio(), None);
        rig.finishes(6);
        assert_eq!(rig.ratio(), Some(90.0));
        rig.queues(7, ratio(10.0));
        rig.sets(magician_protocol::commands::QueuedCmdClear {});
        rig.finishes(8);
        assert_eq!(rig.ratio(), None, "it was dropped, or not");
        rig.reads(&ratio(90.0));
        assert_eq!(rig.ratio(), Some(90.0));
    }

    #[test]
    fn a_queue_that_goes_on_after_a_lost_line_changes_settings_still() {
        let mut rig = Rig::default();
        rig.queues(5, ratio(70.0));
        rig.0.forget();
        rig.reads(&ratio(40.0));
        assert_eq!(rig.ratio(), None);
        rig.finishes(5);
        assert_eq!(rig.ratio(), None);
        rig.reads(&ratio(70.0));
        assert_eq!(rig.ratio(), Some(70.0));
        rig.queues(6, ratio(80.0));
        rig.0.reset();
        rig.reads(&ratio(50.0));
        assert_eq!(rig.ratio(), Some(50.0), "nothing waits after a reset");
    }

    #[test]
    fn one_height_is_both_heights_and_whatever_may_burn_touches_the_laser() {
        let mut rig = Rig::default();
        let both = PtpJump2Params {
            start_jump_height: 1.0,
            end_jump_height: 2.0,
            z_limit: 3.0,
        };
        rig.sets(both);
        assert_eq!(rig.0.get::<PtpJump2Params>(0), Some(both));
        rig.sets(JUMP);
        assert_eq!(rig.0.get::<PtpJump2Params>(0), None);
        let dark = EndEffectorLaser {
            is_ctrl_enabled: Flag::OFF,
            is_on: Flag::OFF,
        };
        for light in [words::laser(true), words::output(2, true)] {
            rig.reads(&dark);
            assert_eq!(rig.0.get::<EndEffectorLaser>(0), Some(dark));
            rig.sets(light);
            assert_eq!(rig.0.get::<EndEffectorLaser>(0), None, "{light:?}");
        }
        rig.queues(9, words::laser(true));
        rig.reads(&dark);
        assert_eq!(
            rig.0.get::<EndEffectorLaser>(0),
            None,
            "it may be lit by now"
        );
    }

    #[test]
    fn what_says_nothing_of_settings_changes_none_and_what_nobody_knows_all() {
        let mut rig = Rig::default();
        rig.sets(ratio(40.0));
        rig.sets(QueuedCmdStartExec {});
        rig.queues(1, words::move_to(220.0, 0.0, 0.0, 0.0));
        assert_eq!(rig.ratio(), Some(40.0));
        rig.sets(ratio(f32::NAN));
        assert_eq!(rig.ratio(), None, "what an arm makes of that is unknown");
        rig.sets(ratio(40.0));
        let unknown = FrameBuf::new(99, Ctrl::SET, &[1]).unwrap();
        rig.answer(unknown, &[]);
        assert_eq!(rig.ratio(), None);
    }

    #[test]
    fn it_keeps_a_bounded_number_of_values() {
        let mut rig = Rig::default();
        for query in 0..=255_u8 {
            let row = <IoMultiplexing as Readable>::ROW;
            let request = FrameBuf::new(row.id, Ctrl::GET, &[query]).unwrap();
            rig.answer(request, &[query, 0]);
        }
        assert_eq!(rig.0.values.len(), MOST);
    }
}
