//! Binary codec for numbers, texts and lists. No input panics.

use std::borrow::Cow;
use std::sync::{Mutex, PoisonError};

/// Remaining input.
pub(super) struct Input<'b>(pub(super) &'b [u8]);

impl<'b> Input<'b> {
    /// Reads a count of values. `None` if they cannot fit into the remaining input, so that nothing
    /// is allocated for them.
    pub(super) fn count<T: Wire>(&mut self) -> Option<usize> {
        let count = usize::take(self)?;
        (count <= self.0.len() / T::MIN_SIZE).then_some(count)
    }

    pub(super) fn bytes(&mut self, count: usize) -> Option<&'b [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }
}

pub(super) trait Wire: Sized {
    /// Smallest encoded size, bytes.
    const MIN_SIZE: usize = 1;

    fn put(&self, out: &mut Vec<u8>);
    fn take(input: &mut Input<'_>) -> Option<Self>;
}

/// Little endian.
macro_rules! numbers {
    ($($number:ty),*) => {$(
        impl Wire for $number {
            const MIN_SIZE: usize = size_of::<Self>();

            fn put(&self, out: &mut Vec<u8>) {
                out.extend(self.to_le_bytes());
            }

            fn take(input: &mut Input<'_>) -> Option<Self> {
                let bytes = input.bytes(size_of::<Self>())?;
                Some(Self::from_le_bytes(bytes.try_into().ok()?))
            }
        }
    )*};
}
numbers!(u8, f32, f64);

/// Base 128: seven bits per byte, lowest first.
impl Wire for u64 {
    fn put(&self, out: &mut Vec<u8>) {
        let mut left = *self;
        while left >= 0x80 {
            out.push(left as u8 | 0x80);
            left >>= 7;
        }
        out.push(left as u8);
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        let mut number = 0;
        for shift in (0..64).step_by(7) {
            let byte = u8::take(input)?;
            number |= u64::from(byte & 0x7F) << shift;
            if byte < 0x80 {
                return Some(number);
            }
        }
        None
    }
}

macro_rules! counts {
    ($($number:ty),*) => {$(
        impl Wire for $number {
            fn put(&self, out: &mut Vec<u8>) {
                (*self as u64).put(out);
            }

            fn take(input: &mut Input<'_>) -> Option<Self> {
                u64::take(input)?.try_into().ok()
            }
        }
    )*};
}
counts!(u32, usize);

impl Wire for bool {
    fn put(&self, out: &mut Vec<u8>) {
        out.push(u8::from(*self));
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        match u8::take(input)? {
            0 => Some(false),
            1 => Some(true),
            _ => None,
        }
    }
}

impl<T: Wire> Wire for Box<T> {
    const MIN_SIZE: usize = T::MIN_SIZE;

    fn put(&self, out: &mut Vec<u8>) {
        (**self).put(out);
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        Wire::take(input).map(Self::new)
    }
}

impl<T: Wire> Wire for Option<T> {
    fn put(&self, out: &mut Vec<u8>) {
        self.is_some().put(out);
        if let Some(what) = self {
            what.put(out);
        }
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        if bool::take(input)? {
            T::take(input).map(Some)
        } else {
            Some(None)
        }
    }
}

impl<T: Wire + Copy + Default, const N: usize> Wire for [T; N] {
    const MIN_SIZE: usize = N * T::MIN_SIZE;

    fn put(&self, out: &mut Vec<u8>) {
        self.iter().for_each(|one| one.put(out));
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        let mut all = [T::default(); N];
        for one in &mut all {
            *one = T::take(input)?;
        }
        Some(all)
    }
}

impl<T: Wire> Wire for Vec<T> {
    fn put(&self, out: &mut Vec<u8>) {
        self.len().put(out);
        self.iter().for_each(|one| one.put(out));
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        let count = input.count::<T>()?;
        let mut all = Self::with_capacity(count);
        for _ in 0..count {
            all.push(T::take(input)?);
        }
        Some(all)
    }
}

impl Wire for String {
    fn put(&self, out: &mut Vec<u8>) {
        self.len().put(out);
        out.extend(self.as_bytes());
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        let count = usize::take(input)?;
        let text = std::str::from_utf8(input.bytes(count)?).ok()?;
        Some(text.to_owned())
    }
}

impl Wire for Cow<'static, str> {
    fn put(&self, out: &mut Vec<u8>) {
        self.as_ref().to_owned().put(out);
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        String::take(input).map(Cow::Owned)
    }
}

/// Largest number of static words accepted so far, and their largest length: they are leaked, so
/// both are bounded.
const MAX_LEAKED_WORDS: usize = 256;
const MAX_WORD_LENGTH: usize = 64;

/// Static word of our own code. A bounded number of them is kept for the life of the program.
impl Wire for &'static str {
    fn put(&self, out: &mut Vec<u8>) {
        (*self).to_owned().put(out);
    }

    fn take(input: &mut Input<'_>) -> Option<Self> {
        static LEAKED_WORDS: Mutex<Vec<&'static str>> = Mutex::new(Vec::new());
        let word = String::take(input)?;
        let mut known = LEAKED_WORDS.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = known.iter().find(|known| **known == word) {
            return Some(*found);
        }
        if known.len() == MAX_LEAKED_WORDS || word.len() > MAX_WORD_LENGTH {
            return None;
        }
        let word: &'static str = Box::leak(word.into_boxed_str());
        known.push(word);
        Some(word)
    }
}
