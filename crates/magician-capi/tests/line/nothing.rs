//! Null pointers for every function on a connected arm. The calls are generated from the table, so
//! that every function is covered.
#![allow(unsafe_code, unreachable_pub)]

use std::ffi::c_int;
use std::ptr;

use magician_capi::Kind;
use magician_capi::pointer::{Buffer, In, Out, Plain, Text};

use crate::line::{Line, Slot, give, text};

/// Arguments that are null or zero.
#[derive(Clone, Copy)]
pub enum Missing {
    All,
    One(usize),
    None,
}

/// Creates the arguments of a call, and owns the memory for its results.
pub struct CallArguments {
    missing: Missing,
    /// Number of arguments created so far.
    created: usize,
    /// Memory for results.
    pub slots: Vec<Slot>,
}

impl CallArguments {
    pub fn without(missing: Missing) -> Self {
        let slots = Vec::new();
        Self {
            missing,
            created: 0,
            slots,
        }
    }

    fn is_missing(&mut self) -> bool {
        let index = self.created;
        self.created += 1;
        match self.missing {
            Missing::All => true,
            Missing::One(one) => one == index,
            Missing::None => false,
        }
    }

    fn slot(&mut self, size: usize) -> &mut Slot {
        self.slots.push(Slot::new(size));
        self.slots.last_mut().expect("it was just put there")
    }
}

/// Argument type of a function.
pub trait Argument {
    /// True if the argument is a pointer.
    const IS_POINTER: bool = true;

    fn create(arguments: &mut CallArguments) -> Self;
}

macro_rules! numbers {
    ($($type:ident)*) => {
        $(
            impl Argument for $type {
                const IS_POINTER: bool = false;

                fn create(arguments: &mut CallArguments) -> Self {
                    u8::from(!arguments.is_missing()).into()
                }
            }
        )*
    };
}

numbers!(u8 u32 i32 f32);

impl<T: Plain> Argument for In<T> {
    fn create(arguments: &mut CallArguments) -> Self {
        if arguments.is_missing() {
            // SAFETY: null is allowed.
            unsafe { Self::new(ptr::null()) }
        } else {
            give(&vec![0; size_of::<T>()])
        }
    }
}

impl<T: Plain> Argument for Out<T> {
    fn create(arguments: &mut CallArguments) -> Self {
        if arguments.is_missing() {
            // SAFETY: null is allowed.
            unsafe { Self::new(ptr::null_mut()) }
        } else {
            arguments.slot(size_of::<T>()).out()
        }
    }
}

impl Argument for Text {
    fn create(arguments: &mut CallArguments) -> Self {
        if arguments.is_missing() {
            // SAFETY: null is allowed.
            unsafe { Self::new(ptr::null()) }
        } else {
            text(b"text")
        }
    }
}

impl Argument for Buffer {
    fn create(arguments: &mut CallArguments) -> Self {
        if arguments.is_missing() {
            // SAFETY: null is allowed.
            unsafe { Self::new(ptr::null_mut()) }
        } else {
            arguments.slot(1).text()
        }
    }
}

/// A function on a connected arm.
pub struct Row {
    pub name: &'static str,
    pub kind: Kind,
    /// Names of the arguments, and true for each pointer.
    pub arguments: &'static [(&'static str, bool)],
    pub call: fn(&mut CallArguments) -> c_int,
}

impl Row {
    /// Indices of arguments that must not be null: all pointers except the one for the index of a
    /// queued command.
    fn needed(&self) -> impl Iterator<Item = usize> {
        let queued = self.arguments.iter().any(|(name, _)| *name == "queued");
        let numbered = self.arguments.iter().enumerate();
        let needed = numbered
            .filter(move |(_, (name, is_pointer))| *is_pointer && !(queued && *name == "index"));
        needed.map(|(at, _)| at)
    }
}

/// Lists a `Row` for each function of a family that acts on an arm.
#[macro_export]
macro_rules! rows_about_an_arm {
    ($family:ident $(
        $(#[doc = $doc:literal])+
        $kind:ident $ids:ident $name:ident ( $($arg:ident : $type:ty),* $(,)? ) in [$($in:ident)*] = $body:expr;
    )*) => {{
        let mut rows: Vec<Row> = Vec::new();
        $( $crate::row_about_an_arm!($family [$($in)*] rows $kind $ids $name ($($arg: $type),*)); )*
        rows
    }};
}

/// Expands one row, if the family has it.
#[macro_export]
macro_rules! row_about_an_arm {
    // Rows that concern no arm or end the connection are left out.
    ($family:ident $in:tt $rows:ident $kind:ident None $name:ident $args:tt) => {};
    ($family:ident $in:tt $rows:ident Host $ids:ident $name:ident $args:tt) => {};
    (v1 [v1 $($more:ident)*] $($row:tt)*) => { $crate::call_about_an_arm!([] $($row)*); };
    (v2 [v2 $($more:ident)*] $($row:tt)*) => { $crate::call_about_an_arm!([0] $($row)*); };
    (v3 [v3 $($more:ident)*] $($row:tt)*) => { $crate::call_about_an_arm!([0, 0] $($row)*); };
    ($family:ident [$other:ident $($more:ident)*] $($row:tt)*) => {
        $crate::row_about_an_arm!($family [$($more)*] $($row)*);
    };
    ($family:ident [] $($row:tt)*) => {};
}

/// Adds a `Row` that calls a function with the ids that its family takes.
#[macro_export]
macro_rules! call_about_an_arm {
    ([$($id:literal),*] $rows:ident $kind:ident $ids:ident $name:ident ($($arg:ident: $type:ty),*)) => {
        $rows.push(Row {
            name: stringify!($name),
            kind: Kind::$kind,
            arguments: &[$((stringify!($arg), <$type as Argument>::IS_POINTER)),*],
            // SAFETY: any pointer may be null; the others refer to live memory of the size needed.
            call: |_arguments| unsafe { exported::$name($($id,)* $(<$type as Argument>::create(_arguments)),*) },
        });
    };
}

/// Checks calls with null for every argument: if a pointer is required the call fails, and nothing
/// is sent.
pub fn check_all_null(line: &Line, rows: &[Row]) {
    assert!(rows.len() > 120);
    for row in rows {
        let (name, needs) = (row.name, row.needed().next().is_some());
        line.take_exchanges();
        let code = (row.call)(&mut CallArguments::without(Missing::All));
        let exchanges = line.take_call_exchanges();
        let expected = match row.kind {
            // Refused, because the test does not allow it with `MagicianAllow`.
            Kind::Guarded => 3,
            Kind::Command if needs => 3,
            _ => 0,
        };
        assert_eq!(code, expected, "{name}");
        let sends = row.kind == Kind::Command && !needs;
        assert_eq!(!exchanges.is_empty(), sends, "{name} sent {exchanges:02X?}");
    }
}

/// Checks calls with one null pointer: nothing is sent, and all results stay untouched.
pub fn check_one_null(line: &Line, rows: &[Row]) {
    for row in rows.iter().filter(|row| row.kind == Kind::Command) {
        for missing in row.needed() {
            let (name, argument) = (row.name, row.arguments[missing].0);
            let mut arguments = CallArguments::without(Missing::One(missing));
            line.take_exchanges();
            assert_eq!((row.call)(&mut arguments), 3, "{name} without {argument}");
            assert!(
                line.take_call_exchanges().is_empty(),
                "{name} without {argument}"
            );
            assert!(
                arguments.slots.iter().all(Slot::is_untouched),
                "{name} without {argument}"
            );
        }
    }
}

/// Checks functions that this arm does not support: all results are zero, and nothing is sent.
pub fn check_neutral(line: &Line, rows: &[Row]) {
    for row in rows.iter().filter(|row| row.kind == Kind::Neutral) {
        let mut arguments = CallArguments::without(Missing::None);
        line.take_exchanges();
        assert_eq!((row.call)(&mut arguments), 0, "{}", row.name);
        assert!(line.take_call_exchanges().is_empty(), "{}", row.name);
        let zero = |slot: &Slot| slot.bytes().iter().all(|byte| *byte == 0);
        assert!(arguments.slots.iter().all(zero), "{}", row.name);
    }
}
