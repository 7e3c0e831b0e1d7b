//! Frames that every exported function of the family sends, and results from the replies.
#![allow(unsafe_code)]

#[path = "../../tests/line/mod.rs"]
mod line;

use dobotdll_v1::exported;
use line::{Call, Line, Slot, check_golden, floats, give, invalid_out, none, null_in, text};
use magician_capi::Family;

macro_rules! call {
    ($name:ident($($arg:expr),* $(,)?)) => {
        // SAFETY: what the pointers say is there.
        unsafe { exported::$name($($arg),*) }
    };
}

include!("../../tests/line/calls.rs");
include!("../../tests/line/more_calls.rs");

/// Calls that differ in this family.
fn own_calls() -> Vec<Call> {
    vec![
        got!(GetDeviceVersion() major 1 minor 1 revision 1),
        immediate!("v1 SetDeviceWithL at once" SetDeviceWithL(1)),
        queued!("v1 SetDeviceWithL queued" SetDeviceWithL(1) 1),
        got!(GetDeviceWithL() on 1),
        got!(GetPoseEx() pose 32),
        plain!(SetColorSensor(1, 1)),
        plain!(SetInfraredSensor(1, 2)),
    ]
}

/// `SetCircleCmd` with the caller's count.
fn circle() -> Call {
    queued!("v1 SetCircleCmd" SetCircleCmd(give(&[two_points(), 2u32.to_le_bytes().to_vec()].concat())) 0)
}

#[test]
fn every_function_sends_its_frame() {
    // SAFETY: null is allowed.
    let line = Line::connected(
        |port| unsafe { exported::ConnectDobot(port, 115_200, none(), none()) },
        // SAFETY: a slot of two bytes is there.
        |pin| unsafe { exported::GetIODO(pin.out()) },
    );
    // SAFETY: the text stays for ever.
    let allow = |name| unsafe { exported::MagicianAllow(name) };
    check_golden(&line, Family::V1, &every_call(more_calls()), allow);
}
