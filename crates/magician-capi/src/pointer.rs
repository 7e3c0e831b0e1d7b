//! What C hands over: the only place that reads and writes the caller's memory.
//!
//! A value of these types is a promise of the C caller's: it is null, or it points to as many bytes as its type says,
//! for the time of the call. Null is always survived; nothing needs to be aligned.
#![allow(unsafe_code)]

use std::ffi::{CStr, c_char};
use std::ptr;

use crate::code::{Fault, Outcome};

/// A structure or number that C hands in.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct In<T>(*const T);

/// Where C wants a structure or number.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Out<T>(*mut T);

/// Text that C hands in.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Text(*const c_char);

/// Where C wants text; how much fits comes beside it, or is known.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Buffer(*mut c_char);

/// The promise is for the time of the call, whichever thread sees to it.
macro_rules! promised_to_any_thread {
    ($($pointer:ident $(<$of:ident>)?),*) => {
        // SAFETY: as above; the memory is the caller's, and the caller waits meanwhile.
        $(unsafe impl $(<$of>)? Send for $pointer $(<$of>)? {})*
    };
}

promised_to_any_thread!(In<T>, Out<T>, Text, Buffer);

/// Where C wants what belongs together: a place, or several.
pub trait Places: Copy {
    /// What goes there.
    type Values;

    /// Whether all are there: what would be asked for nothing is not asked.
    ///
    /// # Errors
    /// [`Code::InvalidParams`](crate::Code::InvalidParams) for a null pointer.
    fn check(self) -> Outcome;

    /// Puts them where there is a place.
    fn fill(self, values: Self::Values);

    /// Makes all that is there zero.
    fn clear(self);
}

impl<T: Plain> Places for Out<T> {
    type Values = T;

    fn check(self) -> Outcome {
        Out::check(self)
    }

    fn fill(self, value: T) {
        self.put(value);
    }

    fn clear(self) {
        if !self.0.is_null() {
            // SAFETY: not null, so the caller's promise holds, and zeros are a value.
            unsafe { ptr::write_bytes(self.0.cast::<u8>(), 0, size_of::<T>()) }
        }
    }
}

/// [`Places`] for several.
macro_rules! several_places {
    ($($place:ident $at:tt)*) => {
        impl<$($place: Places),*> Places for ($($place,)*) {
            type Values = ($($place::Values,)*);

            fn check(self) -> Outcome {
                $(self.$at.check()?;)*
                Ok(())
            }

            fn fill(self, _values: Self::Values) {
                $(self.$at.fill(_values.$at);)*
            }

            fn clear(self) {
                $(self.$at.clear();)*
            }
        }
    };
}

several_places!();
several_places!(A 0 B 1);
several_places!(A 0 B 1 C 2);
several_places!(A 0 B 1 C 2 D 3);

/// What may lie in the memory of C: every pattern of bytes is a value, and no value has padding.
///
/// # Safety
/// Just that must be true of the type.
pub unsafe trait Plain: Copy {}

// SAFETY: numbers have no padding and no invalid patterns.
unsafe impl Plain for u8 {}
// SAFETY: as above.
unsafe impl Plain for u16 {}
// SAFETY: as above.
unsafe impl Plain for u32 {}
// SAFETY: as above.
unsafe impl Plain for i32 {}
// SAFETY: as above.
unsafe impl Plain for u64 {}
// SAFETY: as above.
unsafe impl Plain for f32 {}

impl<T: Plain> In<T> {
    /// # Safety
    /// The pointer is null, or good for reading a `T` as long as this is used.
    #[must_use]
    pub const unsafe fn new(pointer: *const T) -> Self {
        Self(pointer)
    }

    /// What is there.
    ///
    /// # Errors
    /// [`Code::InvalidParams`](crate::Code::InvalidParams) for a null pointer.
    pub fn read(self) -> Result<T, Fault> {
        if self.0.is_null() {
            return Err(Fault::invalid("null pointer: a value is needed"));
        }
        // SAFETY: not null, so the caller's promise holds.
        Ok(unsafe { ptr::read_unaligned(self.0) })
    }

    /// What is there, should it be the first of several; null is fine where there are none.
    ///
    /// # Errors
    /// [`Code::InvalidParams`](crate::Code::InvalidParams) for a null pointer.
    pub fn several(self, count: usize) -> Result<Vec<T>, Fault> {
        if self.0.is_null() && count > 0 {
            return Err(Fault::invalid("null pointer: a list is needed"));
        }
        (0..count)
            .map(|at| Self(self.0.wrapping_add(at)).read())
            .collect()
    }
}

impl<T: Plain> Out<T> {
    /// # Safety
    /// The pointer is null, or good for reading and writing a `T` as long as this is used.
    #[must_use]
    pub const unsafe fn new(pointer: *mut T) -> Self {
        Self(pointer)
    }

    /// What is there, where C says what it wants in the place where it gets it.
    ///
    /// # Errors
    /// [`Code::InvalidParams`](crate::Code::InvalidParams) for a null pointer.
    pub fn read(self) -> Result<T, Fault> {
        In(self.0.cast_const()).read()
    }

    /// Whether there is a place at all: what would be asked for nothing is not asked.
    ///
    /// # Errors
    /// [`Code::InvalidParams`](crate::Code::InvalidParams) for a null pointer.
    pub fn check(self) -> Outcome {
        if self.0.is_null() {
            return Err(Fault::invalid("null pointer: the result needs a place"));
        }
        Ok(())
    }

    /// Puts it there, if there is a place.
    pub fn put(self, value: T) {
        if !self.0.is_null() {
            // SAFETY: not null, so the caller's promise holds.
            unsafe { ptr::write_unaligned(self.0, value) }
        }
    }
}

impl Out<u8> {
    /// Puts as many bytes there as fit, if there is a place.
    pub fn put_bytes(self, bytes: &[u8], fits: usize) {
        if !self.0.is_null() {
            // SAFETY: not null, so `fits` bytes may be written, and no more are.
            unsafe {
                ptr::copy_nonoverlapping(bytes.as_ptr(), self.0, bytes.len().min(fits));
            }
        }
    }
}

impl Text {
    /// # Safety
    /// The pointer is null, or points to text that ends with a NUL and stays as long as this is used.
    #[must_use]
    pub const unsafe fn new(pointer: *const c_char) -> Self {
        Self(pointer)
    }

    /// The bytes before the NUL.
    ///
    /// # Errors
    /// [`Code::InvalidParams`](crate::Code::InvalidParams) for a null pointer.
    pub fn read(self) -> Result<Vec<u8>, Fault> {
        if self.0.is_null() {
            return Err(Fault::invalid("null pointer: text is needed"));
        }
        Ok(self.bytes())
    }

    /// The bytes before the NUL; none for a null pointer.
    #[must_use]
    pub fn bytes(self) -> Vec<u8> {
        if self.0.is_null() {
            return Vec::new();
        }
        // SAFETY: not null, so the caller's promise holds.
        unsafe { CStr::from_ptr(self.0) }.to_bytes().to_vec()
    }
}

impl Buffer {
    /// # Safety
    /// The pointer is null, or good for writing as many bytes as are said to fit, as long as this is used.
    #[must_use]
    pub const unsafe fn new(pointer: *mut c_char) -> Self {
        Self(pointer)
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_null(self) -> bool {
        self.0.is_null()
    }

    /// Whether there is a place at all: what would be asked for nothing is not asked.
    ///
    /// # Errors
    /// [`Code::InvalidParams`](crate::Code::InvalidParams) for a null pointer.
    pub fn check(self) -> Outcome {
        if self.is_null() {
            return Err(Fault::invalid("null pointer: the text needs a place"));
        }
        Ok(())
    }

    /// Writes as much of the text as fits before a NUL, and the NUL; nothing where nothing fits.
    pub fn put(self, text: &[u8], fits: usize) {
        let Some(most) = fits.checked_sub(1).filter(|_| !self.is_null()) else {
            return;
        };
        let count = text.len().min(most);
        // SAFETY: not null, so `fits` bytes may be written, and no more are.
        unsafe {
            ptr::copy_nonoverlapping(text.as_ptr(), self.0.cast(), count);
            self.0.add(count).write(0);
        }
    }
}
