//! Null pointers for every function of the family, and functions that this arm does not support.
#![allow(unsafe_code)]

#[path = "../../tests/line/mod.rs"]
mod line;
#[path = "../../tests/line/nothing.rs"]
mod nothing;

use dobotdll_v2::exported;
use line::{Line, Slot, none};
use magician_capi::Kind;
use magician_capi::functions::names::*;
use nothing::{Argument, Row, check_all_null, check_neutral, check_one_null};

#[test]
fn null_pointers_are_refused() {
    let mut id = Slot::new(4);
    // SAFETY: null is allowed.
    let line = Line::connected(
        |port| unsafe { exported::ConnectDobot(port, 115_200, none(), none(), id.out()) },
        // SAFETY: a slot of two bytes is there.
        |pin| unsafe { exported::GetIODO(0, pin.out()) },
    );
    let rows = magician_capi::functions!(crate rows_about_an_arm v2);
    check_all_null(&line, &rows);
    check_one_null(&line, &rows);
    check_neutral(&line, &rows);
}
