//! A state as a frame of bytes, for those who read often.

use std::fmt;

/// The names of a frame's values, in their order.
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

/// The first byte of a frame, and the version that follows it.
const MARK: [u8; 2] = [0x4D, 1];

/// Bytes before the values: mark, version, subscription, sequence number.
const HEAD: usize = 8;

/// Bytes of a frame.
pub const FRAME: usize = HEAD + 8 * FRAME_FIELDS.len();

/// A state of an arm as a subscription with `frame: "binary"` gets it: 112 bytes, little endian.
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
    /// What was subscribed.
    pub subscription: u16,
    /// Counts the states of the subscription from 0; numbers are missing where a newer state took the place of one.
    pub sequence: u32,
    /// The values by [`FRAME_FIELDS`]: Unix seconds, mm, degrees, counts; NaN is unknown.
    pub values: [f64; FRAME_FIELDS.len()],
}

/// Why bytes are no frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FrameError {
    /// There are so many bytes, and not 112.
    Length(usize),
    /// They begin otherwise: with another mark, or another version.
    Mark([u8; 2]),
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length(length) => write!(f, "a frame has {FRAME} bytes, and here are {length}"),
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
    /// Reads one.
    ///
    /// # Errors
    /// [`FrameError`].
    pub fn read(bytes: &[u8]) -> Result<Self, FrameError> {
        let Ok(frame): Result<&[u8; FRAME], _> = bytes.try_into() else {
            return Err(FrameError::Length(bytes.len()));
        };
        let (head, rest) = frame.split_at(HEAD);
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

    /// As bytes.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(FRAME);
        bytes.extend(MARK);
        bytes.extend(self.subscription.to_le_bytes());
        bytes.extend(self.sequence.to_le_bytes());
        bytes.extend(self.values.iter().flat_map(|value| value.to_le_bytes()));
        bytes
    }

    /// The value of a field by its name; `None` for a name that is not among [`FRAME_FIELDS`].
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
    fn what_is_no_frame_says_why() {
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
        for length in [0, 1, FRAME - 1] {
            let short = StateFrame::read(&bytes[..length]);
            assert_eq!(short, Err(FrameError::Length(length)));
        }
        let mut other = bytes;
        other[1] = 2;
        assert_eq!(StateFrame::read(&other), Err(FrameError::Mark([0x4D, 2])));
        other.push(0);
        assert_eq!(StateFrame::read(&other), Err(FrameError::Length(FRAME + 1)));
    }
}
