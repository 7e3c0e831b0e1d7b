//! How the table becomes exported functions, one set a family.
//!
//! [`export!`](crate::export) is what a shared library consists of. It hands the table to `export_row!`, which makes a
//! function of every row that the family has, with the family's ids before the row's arguments.

use std::ffi::c_int;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::code::{Code, Fault, Outcome};
use crate::session::{self, Session};
use crate::{notice, stand_in};

/// One of the vendor's three incompatible libraries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// No ids: one arm.
    V1,
    /// A `dobotId` first.
    V2,
    /// A `masterId` and a `slaveId` first.
    V3,
}

/// The ids that a function begins with, in the families that have ids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ids {
    /// None in any family: it is about no arm.
    None,
    /// The arm's, `v3` without the slave's: it is about the id, whether an arm has it or not.
    Master,
    /// The arm's.
    Arm,
}

/// What a function comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Answered by this library.
    Host,
    /// A command of the protocol.
    Command,
    /// A command that is sent only if `MAGICIAN_ALLOW` or `MagicianAllow` names it: it can brick, unlearn or unlock
    /// something.
    Guarded,
    /// It makes no sense for this arm: 0, and neutral results.
    Neutral,
}

/// A function of the interface, as the table has it.
#[derive(Clone, Copy, Debug)]
pub struct Function {
    /// Exported name.
    pub name: &'static str,
    /// What it does.
    pub doc: &'static str,
    /// Families that have it with these arguments.
    pub families: &'static [Family],
    /// The ids it begins with.
    pub ids: Ids,
    /// What it comes to.
    pub kind: Kind,
    /// Names and Rust types of the arguments after the ids.
    pub arguments: &'static [(&'static str, &'static str)],
    /// Its body as it stands in the table, for pages about it.
    pub body: &'static str,
}

/// Runs the body of an exported function: nothing unwinds into C.
pub fn guard<T: Send>(name: &'static str, otherwise: T, body: impl FnOnce() -> T + Send) -> T {
    let listening = || {
        notice::listen();
        body()
    };
    let message = match catch_unwind(AssertUnwindSafe(|| stand_in::run(listening))) {
        Ok(Ok(result)) => return result,
        Ok(Err(error)) => format!("this thread cannot wait for the arm: {error}"),
        Err(_) => "this is a bug in the library; please report it".to_owned(),
    };
    // If reporting itself fails, that failure cannot be reported.
    let tell = || notice::fault(name, &Fault::new(Code::Timeout, message));
    let _ = catch_unwind(AssertUnwindSafe(tell));
    otherwise
}

/// Runs the body of a function that is about a connected arm.
pub fn on_arm(
    family: Family,
    name: &'static str,
    id: c_int,
    body: impl FnOnce(&Session) -> Outcome + Send,
) -> c_int {
    guard(name, Code::Timeout as c_int, || {
        session::run(family, name, id, body)
    })
}

/// Makes the exported functions of a family: `export!(v1);`, and no more, is a shared library.
#[macro_export]
macro_rules! export {
    ($family:ident) => {
        /// The exported functions.
        #[allow(unsafe_code, non_snake_case, clippy::missing_safety_doc, clippy::too_many_arguments)]
        pub mod exported {
            #[allow(unused_imports)]
            use $crate::functions::names::*;
            $crate::functions!($crate export_rows $family);
        }
    };
}

/// All rows of the table for one family.
#[doc(hidden)]
#[macro_export]
macro_rules! export_rows {
    ($family:ident $(
        $(#[doc = $doc:literal])+
        $kind:ident $ids:ident $name:ident ( $($arg:ident : $type:ty),* $(,)? ) in [$($in:ident)*] = $body:expr;
    )*) => {
        $( $crate::export_row!($family [$($in)*] $ids [$($doc)+] $name ($($arg: $type),*) $body); )*
    };
}

/// One row of the table: a function, if the family is among the row's.
#[doc(hidden)]
#[macro_export]
macro_rules! export_row {
    (v1 [v1 $($more:ident)*] $ids:ident $doc:tt $name:ident $args:tt $body:expr) => {
        $crate::export_function!(V1 $ids [] $doc $name $args $body);
    };
    (v2 [v2 $($more:ident)*] $ids:ident $doc:tt $name:ident $args:tt $body:expr) => {
        $crate::export_function!(V2 $ids [id] $doc $name $args $body);
    };
    (v3 [v3 $($more:ident)*] Master $doc:tt $name:ident $args:tt $body:expr) => {
        $crate::export_function!(V3 Master [master] $doc $name $args $body);
    };
    (v3 [v3 $($more:ident)*] $ids:ident $doc:tt $name:ident $args:tt $body:expr) => {
        $crate::export_function!(V3 $ids [master slave] $doc $name $args $body);
    };
    ($family:ident [$other:ident $($more:ident)*] $($row:tt)*) => {
        $crate::export_row!($family [$($more)*] $($row)*);
    };
    ($family:ident [] $($row:tt)*) => {};
}

/// An exported function with the ids of its family.
#[doc(hidden)]
#[macro_export]
macro_rules! export_function {
    ($family:ident None $given:tt [$($doc:literal)+] $name:ident ($($arg:ident: $type:ty),*) $body:expr) => {
        $(#[doc = $doc])+
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name($($arg: $type),*) -> ::std::ffi::c_int {
            let body: fn($crate::Family $(, $type)*) -> ::std::ffi::c_int = $body;
            $crate::guard(stringify!($name), 2, move || body($crate::Family::$family $(, $arg)*))
        }
    };
    ($family:ident Master [$($given:ident)*] [$($doc:literal)+] $name:ident ($($arg:ident: $type:ty),*) $body:expr) => {
        $(#[doc = $doc])+
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name($($given: ::std::ffi::c_int,)* $($arg: $type),*) -> ::std::ffi::c_int {
            let body: fn(::std::ffi::c_int $(, $type)*) -> ::std::ffi::c_int = $body;
            let id = $crate::functions::first(&[$($given),*]);
            $crate::guard(stringify!($name), 2, move || body(id $(, $arg)*))
        }
    };
    ($family:ident $ids:ident [$($given:ident)*] [$($doc:literal)+] $name:ident ($($arg:ident: $type:ty),*) $body:expr) => {
        $(#[doc = $doc])+
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name($($given: ::std::ffi::c_int,)* $($arg: $type),*) -> ::std::ffi::c_int {
            let body: fn(&$crate::session::Session $(, $type)*) -> $crate::Outcome = $body;
            let id = $crate::functions::first(&[$($given),*]);
            $crate::on_arm($crate::Family::$family, stringify!($name), id, move |arm| body(arm $(, $arg)*))
        }
    };
}

/// The table as a constant.
#[doc(hidden)]
#[macro_export]
macro_rules! list_rows {
    (list $(
        $(#[doc = $doc:literal])+
        $kind:ident $ids:ident $name:ident ( $($arg:ident : $type:ty),* $(,)? ) in [$($in:ident)*] = $body:expr;
    )*) => {
        &[$(
            $crate::Function {
                name: stringify!($name),
                doc: concat!($($doc, "\n"),+),
                families: &[$($crate::family!($in)),*],
                ids: $crate::Ids::$ids,
                kind: $crate::Kind::$kind,
                arguments: &[$((stringify!($arg), stringify!($type))),*],
                body: stringify!($body),
            }
        ),*]
    };
}

/// A family by its short name.
#[doc(hidden)]
#[macro_export]
macro_rules! family {
    (v1) => {
        $crate::Family::V1
    };
    (v2) => {
        $crate::Family::V2
    };
    (v3) => {
        $crate::Family::V3
    };
}
