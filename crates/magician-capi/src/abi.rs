//! Expansion of the function table into exported functions, one set per family.
//!
//! A shared library consists of one [`export!`](crate::export). That passes the table to
//! `export_row!`, which generates a function for each row that the family has, with the family's
//! ids before the row's own arguments.

use std::ffi::c_int;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::code::{Code, Fault, Outcome};
use crate::session::{self, Session};
use crate::{helper_thread, notice};

/// Family of the vendor's libraries. The three families are incompatible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Functions take no ids: there is one arm.
    V1,
    /// Functions begin with a `dobotId`.
    V2,
    /// Functions begin with a `masterId` and a `slaveId`.
    V3,
}

/// Leading ids of a function, in the families that have ids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ids {
    /// No id in any family: the function does not concern an arm.
    None,
    /// Id of the arm, without the slave's id in `v3`. The id may be unconnected.
    Master,
    /// Id of a connected arm.
    Arm,
}

/// Class of a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Handled by this library itself.
    Host,
    /// Sends a command of the protocol.
    Command,
    /// Sends a dangerous command, which can brick the arm or lose its calibration. Refused unless
    /// `MAGICIAN_ALLOW` or `MagicianAllow` names it.
    Guarded,
    /// Meaningless for this arm: returns 0 and zeroed results.
    Neutral,
}

/// Row of the function table.
#[derive(Clone, Copy, Debug)]
pub struct Function {
    /// Exported name.
    pub name: &'static str,
    /// Description, as in the table.
    pub doc: &'static str,
    /// Families that export it with these arguments.
    pub families: &'static [Family],
    /// Ids with which it begins.
    pub ids: Ids,
    /// Class of the function.
    pub kind: Kind,
    /// Names and Rust types of the arguments after the ids.
    pub arguments: &'static [(&'static str, &'static str)],
    /// Source text of its body, for generated pages.
    pub body: &'static str,
}

/// Runs the body of an exported function and catches panics, because unwinding into C is undefined
/// behaviour. Returns `otherwise` after a panic.
pub fn guard<T: Send>(name: &'static str, otherwise: T, body: impl FnOnce() -> T + Send) -> T {
    let listening = || {
        notice::install_log();
        body()
    };
    let message = match catch_unwind(AssertUnwindSafe(|| helper_thread::run(listening))) {
        Ok(Ok(result)) => return result,
        Ok(Err(error)) => format!("this thread cannot wait for the arm: {error}"),
        Err(_) => "this is a bug in the library; please report it".to_owned(),
    };
    // Reporting may panic too. That failure has nowhere to be reported.
    let tell = || notice::fault(name, &Fault::new(Code::Timeout, message));
    let _ = catch_unwind(AssertUnwindSafe(tell));
    otherwise
}

/// Runs the body of a function on a connected arm, and returns the code for C.
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

/// Generates the exported functions of a family. A shared library is just `export!(v1);`.
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

/// Expands all rows of the table for one family.
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

/// Expands one row: a function if the family has it, otherwise nothing.
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

/// Expands to an exported function with the ids of its family.
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

/// Expands the table to a constant.
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

/// Maps the short name of a family to [`Family`](crate::Family).
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
