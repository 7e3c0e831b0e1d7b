//! Binary form of an arm's state, for subscriptions at a high rate.
//!
//! A frame has a fixed size and a fixed layout, so that a client reads it without a JSON parser:
//! two bytes of mark and version, subscription, sequence number, then one `f64` for each name in
//! [`FRAME_FIELDS`]. All numbers are little endian.

use std::fmt;

/// Names of the values in a frame, in wire order.
pub const FRAME_FIELDS: [&str; 13] = [
    "t",
    "x",
    "y",
    "z",
    "r",
    "j1",
    "j2",
    "j3",
    "j4",
    "rail",
    "current_index",
    "left_space",
    "flags",
];

/// First byte of a frame, and the version of the layout. A layout with other fields gets another
/// version.
const MARK: [u8; 2] = [0x4D, 1];

/// Bytes before the values: mark, version, subscription (2), sequence number (4).
const HEADER_SIZE: usize = 8;

/// Size of a frame, bytes.
pub const FRAME_SIZE: usize = HEADER_SIZE + 8 * FRAME_FIELDS.len();

/// State of an arm, as sent to a subscription with `frame: "binary"`: 112 bytes, little endian.
///
/// ```
/// use magician_station::StateFrame;
///
/// let frame = StateFrame { subscription: 3, sequence: 0, values: [1.5; 13] };
/// assert_eq!(StateFrame::read(&frame.to_bytes()), Ok(frame));
/// assert_eq!(frame.value("x"), Some(1.5));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateFrame {
    /// Id of the subscription.
    pub subscription: u16,
    /// Number of the state within the subscription, from 0. A number is skipped if a newer state
    /// replaced an unsent one.
    pub sequence: u32,
    /// Values in the order of [`FRAME_FIELDS`]: Unix seconds, mm, degrees, counts. NaN if unknown.
    pub values: [f64; FRAME_FIELDS.len()],
}

/// Reason why bytes are not a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FrameError {
    /// Wrong length: this many bytes instead of 112.
    Length(usize),
    /// Wrong mark or unknown version: the first two bytes.
    Mark([u8; 2]),
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length(length) => {
                write!(f, "a frame has {FRAME_SIZE} bytes, and here are {length}")
            }
            Self::Mark([mark, version]) => write!(
                f,
                "a frame begins with {:#04x} and version {}, and not with {mark:#04x} and {version}",
                MARK[0], MARK[1]
            ),
        }
    }
}

impl std::error::Error for FrameError {}

impl StateFrame {
    /// Decodes a frame.
    ///
    /// # Errors
    /// [`FrameError`] for a wrong length, mark or version.
    pub fn read(bytes: &[u8]) -> Result<Self, FrameError> {
        let Ok(frame): Result<&[u8; FRAME_SIZE], _> = bytes.try_into() else {
            return Err(FrameError::Length(bytes.len()));
        };
        let (head, rest) = frame.split_at(HEADER_SIZE);
        // Always matches, because `HEADER_SIZE` is 8.
        let &[mark, version, s0, s1, n0, n1, n2, n3] = head else {
            return Err(FrameError::Length(bytes.len()));
        };
        if [mark, version] != MARK {
            return Err(FrameError::Mark([mark, version]));
        }
        let mut values = [f64::NAN; FRAME_FIELDS.len()];
        for (value, bytes) in values.iter_mut().zip(rest.as_chunks().0) {
            *value = f64::from_le_bytes(*bytes);
        }
        Ok(Self {
            subscription: u16::from_le_bytes([s0, s1]),
            sequence: u32::from_le_bytes([n0, n1, n2, n3]),
            values,
        })
    }

    /// Encodes the frame.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(FRAME_SIZE);
        bytes.extend(MARK);
        bytes.extend(self.subscription.to_le_bytes());
        bytes.extend(self.sequence.to_le_bytes());
        bytes.extend(self.values.iter().flat_map(|value| value.to_le_bytes()));
        bytes
    }

    /// Returns the value of a field. `None` if the name is not in [`FRAME_FIELDS`].
    #[must_use]
    pub fn value(&self, name: &str) -> Option<f64> {
        let at = FRAME_FIELDS.iter().position(|field| *field == name)?;
        self.values.get(at).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_frame_reports_its_fault() {
        let frame = StateFrame {
            subscription: 0x0102,
            sequence: 0x0304_0506,
            values: std::array::from_fn(|at| at as f64),
        };
        let bytes = frame.to_bytes();
        assert_eq!(bytes[..8], [0x4D, 1, 2, 1, 6, 5, 4, 3]);
        assert_eq!(StateFrame::read(&bytes), Ok(frame));
        assert_eq!(frame.value("left_space"), Some(11.0));
        assert_eq!(frame.value("nothing"), None);
        for length in [0, 1, FRAME_SIZE - 1] {
            let short = StateFrame::read(&bytes[..length]);
            assert_eq!(short, Err(FrameError::Length(length)));
        }
        let mut other = bytes;
        other[1] = 2;
        assert_eq!(StateFrame::read(&other), Err(FrameError::Mark([0x4D, 2])));
        other.push(0);
        assert_eq!(
            StateFrame::read(&other),
            Err(FrameError::Length(FRAME_SIZE + 1))
        );
    }
}
