//! Frames that every exported function of the family sends, and results from the replies.
#![allow(unsafe_code)]

#[path = "../../tests/line/mod.rs"]
mod line;

use dobotdll_v3::exported;
use line::{Call, Line, Slot, check_golden, floats, give, invalid_out, null_in, text};
use magician_capi::Family;

macro_rules! call {
    ($name:ident($($arg:expr),* $(,)?)) => {
        // SAFETY: what the pointers say is there.
        unsafe { exported::$name(0, 0, $($arg),*) }
    };
}

include!("../../tests/line/calls.rs");
include!("../../tests/line/more_calls.rs");

/// Calls that differ in this family.
fn own_calls() -> Vec<Call> {
    vec![
        Call::new("GetDeviceVersion", || {
            let mut version = Slot::new(8);
            let code = call!(GetDeviceVersion(version.out()));
            assert_eq!(version.bytes()[3..], [0; 5]);
            (code, version.bytes()[..3].to_vec())
        }),
        immediate!("v3 SetDeviceWithL at once" SetDeviceWithL(1, 1)),
        queued!("v3 SetDeviceWithL queued" SetDeviceWithL(1, 1) 1),
        got!(GetDeviceWithL() on 1),
        got!(GetDeviceID() value 12),
        immediate!("v3 SetColorSensor at once" SetColorSensor(1, 1, 1)),
        queued!("v3 SetColorSensor queued" SetColorSensor(1, 1, 1) 1),
        immediate!("v3 SetInfraredSensor at once" SetInfraredSensor(1, 2, 1)),
        queued!("v3 SetInfraredSensor queued" SetInfraredSensor(1, 2, 1) 1),
    ]
}

/// `SetCircleCmd` without a count: one turn.
fn circle() -> Call {
    queued!(SetCircleCmd(give(&two_points())))
}

#[test]
fn every_function_sends_its_frame() {
    let mut info = Slot::new(336);
    // SAFETY: the pointer says what is there.
    let line = Line::connected(
        |port| unsafe { exported::ConnectDobot(port, 115_200, info.out()) },
        // SAFETY: a slot of two bytes is there.
        |pin| unsafe { exported::GetIODO(0, 0, pin.out()) },
    );
    assert_eq!(info.bytes()[..4], [0; 4]);
    // SAFETY: the text stays for ever.
    let allow = |name| unsafe { exported::MagicianAllow(name) };
    check_golden(&line, Family::V3, &every_call(more_calls()), allow);
}
