//! Pointers of the C caller: the only module that reads and writes its memory.
//!
//! Each type stands for a promise of the caller: the pointer is null, or points to enough bytes for
//! its type during the call. Null is always handled. Alignment is not required.
#![allow(unsafe_code)]

use std::ffi::{CStr, c_char};
use std::ptr;

use crate::code::{Fault, Outcome};

/// Pointer to a value for the library to read. May be null.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct In<T>(*const T);

/// Pointer to memory for a result. May be null.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Out<T>(*mut T);

/// Pointer to NUL-terminated input text. May be null.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Text(*const c_char);

/// Pointer to memory for text. May be null. Its size is passed separately, or known.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Buffer(*mut c_char);

/// Implements `Send`: the caller's promise holds for the duration of the call, on any thread.
macro_rules! impl_send {
    ($($pointer:ident $(<$of:ident>)?),*) => {
        // SAFETY: as above; the memory is the caller's, and the caller waits meanwhile.
        $(unsafe impl $(<$of>)? Send for $pointer $(<$of>)? {})*
    };
}

impl_send!(In<T>, Out<T>, Text, Buffer);

/// Memory locations, one or more, for the results of a call.
pub trait Places: Copy {
    /// Values that belong there.
    type Values;

    /// Checks that no pointer is null. Done before sending, so that no command is sent whose result
    /// would be lost.
    ///
    /// # Errors
    /// [`Code::InvalidParams`](crate::Code::InvalidParams) for a null pointer.
    fn check(self) -> Outcome;

    /// Writes the values, except where the pointer is null.
    fn fill(self, values: Self::Values);

    /// Zeroes the memory, except where the pointer is null.
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

/// Implements [`Places`] for tuples.
macro_rules! impl_places {
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

impl_places!();
impl_places!(A 0 B 1);
impl_places!(A 0 B 1 C 2);
impl_places!(A 0 B 1 C 2 D 3);

/// Types that may lie in the memory of C: every bit pattern is valid, and there is no padding.
///
/// # Safety
/// The type must have these two properties.
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

    /// Reads the value.
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

    /// Reads `count` consecutive values. The pointer may be null if `count` is 0.
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

    /// Reads the value, for functions whose caller puts a query into the memory for the result.
    ///
    /// # Errors
    /// [`Code::InvalidParams`](crate::Code::InvalidParams) for a null pointer.
    pub fn read(self) -> Result<T, Fault> {
        In(self.0.cast_const()).read()
    }

    /// Checks that the pointer is not null. Done before sending, so that no command is sent whose
    /// result would be lost.
    ///
    /// # Errors
    /// [`Code::InvalidParams`](crate::Code::InvalidParams) for a null pointer.
    pub fn check(self) -> Outcome {
        if self.0.is_null() {
            return Err(Fault::invalid("null pointer: the result needs a place"));
        }
        Ok(())
    }

    /// Writes the value, unless the pointer is null.
    pub fn put(self, value: T) {
        if !self.0.is_null() {
            // SAFETY: not null, so the caller's promise holds.
            unsafe { ptr::write_unaligned(self.0, value) }
        }
    }
}

impl Out<u8> {
    /// Writes as many bytes as fit, unless the pointer is null.
    pub fn write_truncated(self, bytes: &[u8], fits: usize) {
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
    /// The pointer is null, or points to text that ends with a NUL and stays valid as long as this
    /// is used.
    #[must_use]
    pub const unsafe fn new(pointer: *const c_char) -> Self {
        Self(pointer)
    }

    /// Reads the bytes before the NUL.
    ///
    /// # Errors
    /// [`Code::InvalidParams`](crate::Code::InvalidParams) for a null pointer.
    pub fn read(self) -> Result<Vec<u8>, Fault> {
        if self.0.is_null() {
            return Err(Fault::invalid("null pointer: text is needed"));
        }
        Ok(self.bytes())
    }

    /// Reads the bytes before the NUL. Empty for a null pointer.
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
    /// The pointer is null, or good for writing as many bytes as are said to fit, as long as this
    /// is used.
    #[must_use]
    pub const unsafe fn new(pointer: *mut c_char) -> Self {
        Self(pointer)
    }

    /// True for a null pointer.
    #[must_use]
    pub fn is_null(self) -> bool {
        self.0.is_null()
    }

    /// Checks that the pointer is not null. Done before sending, so that no command is sent whose
    /// result would be lost.
    ///
    /// # Errors
    /// [`Code::InvalidParams`](crate::Code::InvalidParams) for a null pointer.
    pub fn check(self) -> Outcome {
        if self.is_null() {
            return Err(Fault::invalid("null pointer: the text needs a place"));
        }
        Ok(())
    }

    /// Writes the text, truncated so that it fits with a final NUL. Writes nothing if `fits` is 0
    /// or the pointer is null.
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
