//! Frames that every exported function of the family sends, and results from the replies.
#![allow(unsafe_code)]

#[path = "../../tests/line/mod.rs"]
mod line;

use dobotdll_v2::exported;
use line::{Call, Line, Slot, check_golden, floats, give, none, null_in, text};
use magician_capi::Family;

macro_rules! call {
    ($name:ident($($arg:expr),* $(,)?)) => {
        // SAFETY: what the pointers say is there.
        unsafe { exported::$name(0, $($arg),*) }
    };
}

include!("../../tests/line/calls.rs");

/// Calls that differ in this family.
fn own_calls() -> Vec<Call> {
    vec![
        got!(GetDeviceVersion() major 1 minor 1 revision 1),
        plain!("v2 SetDeviceWithL", SetDeviceWithL(1)),
        got!(GetDeviceWithL() on 1),
        got!(GetPoseEx() pose 32),
        plain!(SetColorSensor(1, 1)),
        plain!(SetInfraredSensor(1, 2)),
        plain!(SetLostStepParams(5.0)),
    ]
}

/// `SetCircleCmd` without a count: one turn.
fn circle() -> Call {
    queued!(SetCircleCmd(give(&two_points())))
}

#[test]
fn every_function_sends_its_frame() {
    let mut id = Slot::new(4);
    // SAFETY: null is allowed.
    let line = Line::connected(
        |port| unsafe { exported::ConnectDobot(port, 115_200, none(), none(), id.out()) },
        // SAFETY: a slot of two bytes is there.
        |pin| unsafe { exported::GetIODO(0, pin.out()) },
    );
    assert_eq!(id.bytes(), [0; 4]);
    // SAFETY: the text stays for ever.
    let allow = |name| unsafe { exported::MagicianAllow(name) };
    check_golden(&line, Family::V2, &every_call(Vec::new()), allow);
}
