//! Null pointers, to every function of the family.
#![allow(unsafe_code)]

#[path = "../../tests/line/mod.rs"]
mod line;

use dobotdll_v2::exported;
use line::{Line, Slot, text};
use magician_capi::Kind;
use magician_capi::functions::names::*;
use magician_capi::pointer::Plain;

include!("../../tests/line/nothing.rs");

#[test]
fn null_pointers_are_survived() {
    let line = Line::open();
    let port = text(line.name().as_bytes());
    let mut id = Slot::new(4);
    // SAFETY: null is allowed.
    let code = unsafe {
        exported::ConnectDobot(port, 115_200, Nothing::nothing(), Nothing::nothing(), id.out())
    };
    assert_eq!(code, 0);
    let rows = magician_capi::functions!(crate nought_rows v2);
    hold_to_nothing(&line, &rows);
}
