//! Lists of outputs that a move switches on its way (`PTPPOCmd` and `PTPPOWithLCmd`).

use core::fmt;

use crate::check::{Number, RangeError, check_count, check_number};
use crate::{DecodeError, Field, FieldType, MAX_PARAMS, Range, Reader, Wire, Writer};

/// An output to switch at a share of a move (document 1.10.9, errata E29).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PoCmd {
    /// Share of the move done, 0 to 100 percent.
    pub ratio: u8,
    /// EIO address, 1 to 20.
    pub address: u16,
    /// Level to output, 0 or 1.
    pub level: u8,
}

/// Number in an output, with its range.
struct Part {
    name: &'static str,
    value: u16,
    unit: &'static str,
    range: Range,
}

impl Part {
    fn check(&self, field: &'static Field) -> Result<(), RangeError> {
        let value = Number::Integer(self.value.into());
        check_number(value, field, self.range).map_err(|error| RangeError {
            part: Some(self.name),
            unit: self.unit,
            ..error
        })
    }
}

impl PoCmd {
    fn parts(&self) -> [Part; 3] {
        let part = |name, value, unit, least, most| Part {
            name,
            value,
            unit,
            range: Range::Within(least, most),
        };
        [
            part("ratio", self.ratio.into(), "percent", 0, 100),
            part("address", self.address, "EIO address", 1, 20),
            part("level", self.level.into(), "level", 0, 1),
        ]
    }
}

// Ratio, address (two bytes), level.
const SIZE: usize = 4;
// 17 bytes precede the list in PTPPOCmd: mode and four numbers. PTPPOWithLCmd has 4 more, for
// which the range in the command table is stricter.
const CAPACITY: usize = (MAX_PARAMS - 17) / SIZE;

/// Outputs that a move switches on its way, at most [`PoList::CAPACITY`].
#[derive(Clone, Copy)]
pub struct PoList {
    items: [PoCmd; CAPACITY],
    len: u8,
    /// True if the frame carried a count byte. Shown in traces, never written.
    counted: bool,
}

impl PoList {
    /// Largest number of outputs in a frame.
    pub const CAPACITY: usize = CAPACITY;

    /// Creates a list in the given order. `None` for more than [`PoList::CAPACITY`] outputs.
    #[must_use]
    pub fn new(outputs: &[PoCmd]) -> Option<Self> {
        let mut items = [PoCmd::default(); CAPACITY];
        items.get_mut(..outputs.len())?.copy_from_slice(outputs);
        Some(Self {
            items,
            len: outputs.len() as u8,
            counted: false,
        })
    }

    /// Outputs in order.
    #[must_use]
    pub fn as_slice(&self) -> &[PoCmd] {
        self.items.get(..usize::from(self.len)).unwrap_or_default()
    }

    /// True if the frame carried a count byte (errata E29).
    #[must_use]
    pub fn counted(&self) -> bool {
        self.counted
    }
}

impl Wire for PoList {
    const TYPE: FieldType = FieldType::Outputs;

    fn read(reader: &mut Reader<'_>) -> Result<Self, DecodeError> {
        let found = reader.remaining();
        let bytes = reader.rest();
        let (entries, counted) = match (found % SIZE, bytes.split_first()) {
            (0, _) => (bytes, false),
            // A byte beyond whole entries is taken as their count if it is correct (E29).
            (1, Some((count, rest))) if usize::from(*count) == rest.len() / SIZE => (rest, true),
            _ => return Err(DecodeError::List { found }),
        };
        let mut items = [PoCmd::default(); CAPACITY];
        let mut len = 0;
        for (to, from) in items.iter_mut().zip(entries.chunks_exact(SIZE)) {
            *to = PoCmd {
                ratio: from[0],
                address: u16::from_le_bytes([from[1], from[2]]),
                level: from[3],
            };
            len += 1;
        }
        Ok(Self {
            items,
            len,
            counted,
        })
    }

    fn write(&self, writer: &mut Writer<'_>) {
        for item in self.as_slice() {
            let [low, high] = item.address.to_le_bytes();
            writer.put(&[item.ratio, low, high, item.level]);
        }
    }

    fn check(&self, field: &'static Field, range: Range) -> Result<(), RangeError> {
        check_count(self.as_slice().len(), field, range)?;
        let mut items = self.as_slice().iter().enumerate();
        items.try_for_each(|(at, item)| {
            let checked = item
                .parts()
                .into_iter()
                .try_for_each(|part| part.check(field));
            checked.map_err(|error| error.with_item(at))
        })
    }
}

impl Default for PoList {
    fn default() -> Self {
        Self {
            items: [PoCmd::default(); CAPACITY],
            len: 0,
            counted: false,
        }
    }
}

impl PartialEq for PoList {
    fn eq(&self, other: &Self) -> bool {
        self.as_slice() == other.as_slice()
    }
}

impl fmt::Debug for PoList {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.as_slice()).finish()
    }
}

impl fmt::Display for PoList {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (at, item) in self.as_slice().iter().enumerate() {
            let comma = if at == 0 { "" } else { "," };
            write!(f, "{comma}{}:{}:{}", item.ratio, item.address, item.level)?;
        }
        Ok(())
    }
}
