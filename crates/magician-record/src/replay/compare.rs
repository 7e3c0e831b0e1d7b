//! Comparison of two answers to the same request.

use magician_protocol::{
    Description, Direction, Field, FieldValue, Frame, Layout, QueuedCmdIndex, Readable, commands,
    describe,
};

use super::report::DifferenceKind;
use super::{Ignored, Tolerances};

/// Compares answers, and tracks the offsets between both sessions.
#[derive(Clone, Debug)]
pub(super) struct Comparer {
    tolerances: Tolerances,
    ignored: Vec<Ignored>,
    /// Recorded index minus replayed index.
    indices: Option<u64>,
    /// Recorded clock minus replayed clock, ms.
    clocks: Option<u32>,
    pub(super) fields: u64,
    pub(super) left_out: u64,
}

impl Comparer {
    pub(super) fn new(tolerances: Tolerances, ignored: Vec<Ignored>) -> Self {
        Self {
            tolerances,
            ignored,
            indices: None,
            clocks: None,
            fields: 0,
            left_out: 0,
        }
    }

    /// True if this command, or this field of it, is excluded.
    pub(super) fn ignores(&self, id: u8, field: Option<&str>) -> bool {
        self.ignored.iter().any(|ignored| ignored.covers(id, field))
    }

    /// Returns the differences between two answers.
    pub(super) fn compare(
        &mut self,
        recorded: &Frame<'_>,
        replayed: &Frame<'_>,
    ) -> Vec<DifferenceKind> {
        let id = recorded.id();
        if self.ignores(id, None) {
            self.left_out += 1;
            return Vec::new();
        }
        // An answer with another Ctrl, such as the error bit, has another meaning.
        let meaning = |frame: &Frame<'_>| frame.ctrl() == recorded.ctrl();
        let both = meaning(replayed).then(|| {
            let recorded = describe(recorded, Direction::Reply).ok()?;
            Some((recorded, describe(replayed, Direction::Reply).ok()?))
        });
        match both {
            Some(Some((recorded, replayed))) => self.fields_of(&recorded, &replayed),
            _ if recorded == replayed => Vec::new(),
            _ => vec![DifferenceKind::Form],
        }
    }

    fn fields_of(
        &mut self,
        recorded: &Description<'_>,
        replayed: &Description<'_>,
    ) -> Vec<DifferenceKind> {
        let mut found = Vec::new();
        for field in recorded.layout.fields {
            let (before, now) = (value(recorded, field), value(replayed, field));
            if before.is_none() && now.is_none() {
                continue;
            }
            if self.ignores(recorded.row.id, Some(field.name)) {
                self.left_out += 1;
                continue;
            }
            self.fields += 1;
            let same = match (before, now) {
                (Some(before), Some(now)) => self.same(recorded, before, now),
                _ => false,
            };
            if !same {
                found.push(DifferenceKind::Value(field));
            }
        }
        found
    }

    fn same(&mut self, of: &Description<'_>, before: FieldValue<'_>, now: FieldValue<'_>) -> bool {
        let id = of.row.id;
        match (before, now) {
            (FieldValue::Unsigned(before), FieldValue::Unsigned(now)) => {
                if of.layout.name == QueuedCmdIndex::INFO.name {
                    self.same_index(before, now)
                } else if id == commands::QueuedCmdCurrentIndex::ROW.id {
                    let shift = before.wrapping_sub(now);
                    self.indices.is_none_or(|known| known == shift)
                } else if id == commands::DeviceTime::ROW.id {
                    self.same_clock(before as u32, now as u32)
                } else {
                    before == now
                }
            }
            (FieldValue::Float(before), FieldValue::Float(now)) => self.same_float(of, before, now),
            (FieldValue::Array(..), FieldValue::Array(..)) => {
                let pairs = before.items().zip(now.items());
                pairs.into_iter().all(|pair| match pair {
                    (FieldValue::Float(before), FieldValue::Float(now)) => {
                        self.same_float(of, before, now)
                    }
                    (before, now) => before == now,
                })
            }
            (before, now) => before == now,
        }
    }

    /// Compares indices. Index 0 means that a command was not accepted; all others are consecutive.
    fn same_index(&mut self, before: u64, now: u64) -> bool {
        if before == 0 || now == 0 {
            return before == now;
        }
        let shift = before.wrapping_sub(now);
        self.indices
            .replace(shift)
            .is_none_or(|known| known == shift)
    }

    // Wrapping arithmetic: the clock wraps after 49.7 days.
    fn same_clock(&mut self, before: u32, now: u32) -> bool {
        let shift = before.wrapping_sub(now);
        let Some(known) = self.clocks.replace(shift) else {
            return true;
        };
        let apart = shift.wrapping_sub(known);
        apart.min(apart.wrapping_neg()) <= self.tolerances.time_ms
    }

    /// Compares floats. A value that can be set must be equal bit for bit; a read-only value is a
    /// measurement.
    fn same_float(&self, of: &Description<'_>, before: f32, now: f32) -> bool {
        let measured = of.row.set.is_none();
        let near = (before - now).abs() <= self.tolerances.measured;
        before.to_bits() == now.to_bits() || measured && near
    }
}

fn value<'a>(of: &Description<'a>, field: &Field) -> Option<FieldValue<'a>> {
    let mut values = of.values().ok()?;
    values.find_map(|(own, value)| (own.name == field.name).then_some(value))
}
