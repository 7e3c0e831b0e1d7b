// Calls every function that sends, as C would. This file is included where `call!` defines how to
// call a family, and `own_calls` and `circle` define what only that family has.

/// A queued call. The index must be the arm's answer.
macro_rules! queued {
    ($name:literal $function:ident($($arg:expr),*) $said:literal) => {
        Call::new($name, || {
            let mut index = Slot::new(8);
            let code = call!($function($($arg,)* $said, index.out()));
            (code, index.bytes().to_vec())
        })
    };
    ($function:ident($($arg:expr),*)) => {
        queued!(stringify $function($($arg),*))
    };
    (stringify $function:ident($($arg:expr),*)) => {
        Call::new(stringify!($function), || {
            let mut index = Slot::new(8);
            // `isQueued` is false, but the function ignores it.
            let code = call!($function($($arg,)* 0, index.out()));
            (code, index.bytes().to_vec())
        })
    };
}

/// An immediate call of a function that obeys `isQueued`. The index must stay untouched.
macro_rules! immediate {
    ($name:literal $function:ident($($arg:expr),*)) => {
        Call::new($name, || {
            let mut index = Slot::new(8);
            let code = call!($function($($arg,)* 0, index.out()));
            assert!(index.is_untouched());
            (code, Vec::new())
        })
    };
}

/// A call without results.
macro_rules! plain {
    ($function:ident($($arg:expr),*)) => {
        plain!(stringify!($function), $function($($arg),*))
    };
    ($name:expr, $function:ident($($arg:expr),*)) => {
        Call::new($name, || (call!($function($($arg),*)), Vec::new()))
    };
}

/// A call whose results are consecutive in the reply.
macro_rules! got {
    ($function:ident($($arg:expr),*) $($slot:ident $size:literal)+) => {
        Call::new(stringify!($function), || {
            $(let mut $slot = Slot::new($size);)+
            let code = call!($function($($arg,)* $($slot.out()),+));
            (code, [$($slot.bytes()),+].concat())
        })
    };
}

/// A call whose result is a C enum, one byte in the reply.
macro_rules! got_enum {
    ($function:ident) => {
        Call::new(stringify!($function), || {
            let mut slot = Slot::new(4);
            let code = call!($function(slot.out()));
            assert_eq!(slot.bytes()[1..], [0; 3]);
            (code, slot.bytes()[..1].to_vec())
        })
    };
}

/// A call whose result is text with a NUL.
macro_rules! got_text {
    ($function:ident $text:literal) => {
        Call::new(stringify!($function), || {
            let mut slot = Slot::new(100);
            let code = call!($function(slot.text(), 100));
            let end = slot
                .bytes()
                .iter()
                .position(|byte| *byte == 0)
                .expect("a NUL");
            assert_eq!(slot.bytes()[..end], *$text);
            (code, slot.bytes()[..=end].to_vec())
        })
    };
}

/// A call whose text is truncated. Its NUL must stay.
macro_rules! got_truncated {
    ($function:ident) => {
        Call::new(stringify!($function), || {
            let mut slot = Slot::new(3);
            let code = call!($function(slot.text(), 3));
            assert_eq!(slot.bytes()[2], 0);
            (code, slot.bytes()[..2].to_vec())
        })
    };
}

/// A call that takes the pin's address from the memory for the result.
macro_rules! got_pin {
    ($function:ident $pin:literal $size:literal) => {
        Call::new(stringify!($function), || {
            let mut said = [0xEE; $size];
            said[0] = $pin;
            let mut slot = Slot::with(&said);
            let code = call!($function(slot.out()));
            (code, slot.bytes().to_vec())
        })
    };
}

/// Point-to-point mode and coordinates.
fn point(mode: u8, numbers: &[f32]) -> Vec<u8> {
    [vec![mode], floats(numbers)].concat()
}

/// Two points of an arc or circle.
fn two_points() -> Vec<u8> {
    floats(&[210.0, 10.0, 40.0, 1.0, 220.0, 0.0, 40.0, 2.0])
}

/// Two outputs to switch on the way: ratio, address, level.
const OUTPUTS: [u8; 8] = [25, 4, 0, 1, 75, 5, 1, 0];

/// Starts the queue, so that queued settings are in effect when they are read.
fn beginning() -> Vec<Call> {
    vec![
        plain!(ClearAllAlarmsState()),
        plain!(SetQueuedCmdStartExec()),
    ]
}

/// Calls that all families have with the same arguments. Values are set before they are read.
/// Motions come last, because they may end at a limit, whose alarm blocks the queue.
fn common_calls() -> Vec<Call> {
    vec![
        plain!(SetDeviceSN(text(b"DT0102"))),
        got_text!(GetDeviceSN b"DT0102"),
        got_truncated!(GetDeviceSN),
        plain!(SetDeviceName(text(b"dobot"))),
        got_text!(GetDeviceName b"dobot"),
        got_truncated!(GetDeviceName),
        got!(GetDeviceTime() time 4),
        got!(GetPose() pose 32),
        got!(GetKinematics() kinematics 8),
        Call::new("GetAlarmsState", || {
            let (mut state, mut length) = (Slot::new(16), Slot::new(4));
            let code = call!(GetAlarmsState(state.first(), length.out(), 16));
            assert_eq!(length.bytes(), 16u32.to_le_bytes());
            (code, state.bytes().to_vec())
        }),
        // Writes as many as fit, but reports their full number.
        Call::new("GetAlarmsState", || {
            let (mut state, mut length) = (Slot::new(2), Slot::new(4));
            let code = call!(GetAlarmsState(state.first(), length.out(), 2));
            assert_eq!(length.bytes(), 16u32.to_le_bytes());
            (code, state.bytes().to_vec())
        }),
        queued!(SetHOMEParams(give(&floats(&[200.0, 0.0, 40.0, 0.0])))),
        got!(GetHOMEParams() value 16),
        plain!(SetHHTTrigMode(1)),
        got_enum!(GetHHTTrigMode),
        plain!(SetHHTTrigOutputEnabled(1)),
        got!(GetHHTTrigOutputEnabled() on 1),
        got!(GetHHTTrigOutput() triggered 1),
        queued!(SetEndEffectorParams(give(&floats(&[59.7, 0.5, -1.5])))),
        got!(GetEndEffectorParams() value 12),
        queued!(SetEndEffectorLaser(1, 200)),
        Call::new("GetEndEffectorLaser", || {
            let (mut enabled, mut on) = (Slot::new(1), Slot::new(1));
            let code = call!(GetEndEffectorLaser(enabled.out(), on.out()));
            // A C bool is 1, whatever byte the arm stores.
            assert_eq!((enabled.bytes(), on.bytes()), (&[1][..], &[1][..]));
            (code, vec![1])
        }),
        queued!(SetEndEffectorSuctionCup(1, 1)),
        got!(GetEndEffectorSuctionCup() enabled 1 sucked 1),
        queued!(SetEndEffectorGripper(1, 0)),
        got!(GetEndEffectorGripper() enabled 1 gripped 1),
        queued!(SetArmOrientation(1)),
        got_enum!(GetArmOrientation),
        queued!(SetJOGJointParams(give(&floats(&[
            11.0, 12.0, 13.0, 14.0, 15.0, 16.0, 17.0, 18.0
        ])))),
        got!(GetJOGJointParams() value 32),
        queued!(SetJOGCoordinateParams(give(&floats(&[
            21.0, 22.0, 23.0, 24.0, 25.0, 26.0, 27.0, 28.0
        ])))),
        got!(GetJOGCoordinateParams() value 32),
        immediate!("SetJOGLParams at once" SetJOGLParams(give(&floats(&[100.0, 100.0])))),
        queued!("SetJOGLParams queued" SetJOGLParams(give(&floats(&[100.0, 100.0]))) 1),
        got!(GetJOGLParams() value 8),
        immediate!("SetJOGCommonParams at once" SetJOGCommonParams(give(&floats(&[50.0, 50.0])))),
        queued!("SetJOGCommonParams queued" SetJOGCommonParams(give(&floats(&[50.0, 50.0]))) 1),
        got!(GetJOGCommonParams() value 8),
        queued!(SetPTPJointParams(give(&floats(&[200.0; 8])))),
        got!(GetPTPJointParams() value 32),
        queued!(SetPTPCoordinateParams(give(&floats(&[200.0; 4])))),
        got!(GetPTPCoordinateParams() value 16),
        queued!(SetPTPLParams(give(&floats(&[60.0, 70.0])))),
        got!(GetPTPLParams() value 8),
        queued!(SetPTPJumpParams(give(&floats(&[10.0, 200.0])))),
        got!(GetPTPJumpParams() value 8),
        queued!(SetPTPJump2Params(give(&floats(&[10.0, 20.0, 100.0])))),
        got!(GetPTPJump2Params() value 12),
        queued!(SetPTPCommonParams(give(&floats(&[100.0, 100.0])))),
        got!(GetPTPCommonParams() value 8),
        queued!(SetCPParams(give(
            &[floats(&[50.0, 50.0, 50.0]), vec![0]].concat()
        ))),
        got!(GetCPParams() value 13),
        queued!(SetARCParams(give(&floats(&[50.0; 4])))),
        got!(GetARCParams() value 16),
        queued!(SetIOMultiplexing(give(&[2, 2]))),
        got_pin!(GetIOMultiplexing 2 2),
        queued!(SetIODO(give(&[2, 1]))),
        got_pin!(GetIODO 2 2),
        queued!(SetIOPWM(give(&[vec![4], floats(&[1000.0, 50.0])].concat()))),
        got_pin!(GetIOPWM 4 9),
        got_pin!(GetIODI 15 2),
        got_pin!(GetIOADC 12 3),
        queued!(SetEMotor(give(
            &[&[0, 1][..], &(-10_000i32).to_le_bytes()].concat()
        ))),
        queued!(SetEMotorS(give(
            &[
                &[1, 1][..],
                &(-10_000i32).to_le_bytes(),
                &2000u32.to_le_bytes()
            ]
            .concat()
        ))),
        got!(GetColorSensor() r 1 g 1 b 1),
        got!(GetInfraredSensor(2) value 1),
        plain!(SetAngleSensorStaticError(0.5, -0.25)),
        got!(GetAngleSensorStaticError() rear 4 front 4),
        plain!(SetAngleSensorCoef(1.5, 0.75)),
        got!(GetAngleSensorCoef() rear 4 front 4),
        plain!(SetBaseDecoderStaticError(0.125)),
        got!(GetBaseDecoderStaticError() error 4),
        plain!(SetWIFIConfigMode(1)),
        got!(GetWIFIConfigMode() on 1),
        plain!(SetWIFISSID(text(b"net"))),
        got_text!(GetWIFISSID b"net"),
        got_truncated!(GetWIFISSID),
        plain!(SetWIFIPassword(text(b"\xB0\xA1secret"))),
        got_text!(GetWIFIPassword b"\xB0\xA1secret"),
        got_truncated!(GetWIFIPassword),
        plain!(SetWIFIIPAddress(give(&[0, 192, 168, 1, 5]))),
        got!(GetWIFIIPAddress() value 5),
        plain!(SetWIFINetmask(give(&[255, 255, 255, 0]))),
        got!(GetWIFINetmask() value 4),
        plain!(SetWIFIGateway(give(&[192, 168, 1, 1]))),
        got!(GetWIFIGateway() value 4),
        plain!(SetWIFIDNS(give(&[8, 8, 4, 4]))),
        got!(GetWIFIDNS() value 4),
        got!(GetWIFIConnectStatus() connected 1),
        plain!(UpdateFirmware(give(&[2]))),
        plain!(SetFirmwareMode(give(&[1, 2]))),
        got!(GetFirmwareMode() value 2),
        got!(GetUserParams() value 32),
        got!(GetAutoLevelingResult() precision 4),
        got!(GetPTPTime(give(&point(1, &[210.0, 10.0, 40.0, 5.0]))) time 4),
        got!(GetQueuedCmdCurrentIndex() index 8),
        plain!(SetQueuedCmdStartDownload(2, 3)),
        plain!(SetQueuedCmdStopDownload()),
        queued!(SetWAITCmd(give(&1500u32.to_le_bytes()))),
        queued!(SetTRIGCmd(give(&[4, 0, 0, 0, 0]))),
        queued!(SetPTPCmd(give(&point(4, &[10.0, 20.0, 30.0, 40.0])))),
        queued!(SetPTPWithLCmd(give(&point(
            1,
            &[200.0, 0.0, 50.0, 0.0, 120.0]
        )))),
        got!(GetPoseL() l 4),
        queued!(SetPTPPOCmd(
            give(&point(1, &[210.0, 10.0, 40.0, 5.0])),
            give(&OUTPUTS),
            2
        )),
        queued!("SetPTPPOCmd none" SetPTPPOCmd(give(&point(1, &[210.0, 10.0, 40.0, 5.0])), null_in(), 0) 0),
        queued!(SetPTPPOWithLCmd(
            give(&point(1, &[210.0, 10.0, 40.0, 5.0, 130.0])),
            give(&OUTPUTS),
            2
        )),
        queued!(SetCPCmd(give(&point(1, &[200.0, 10.0, -5.0, 50.0])))),
        queued!(SetCPLECmd(give(&point(1, &[200.0, 10.0, -5.0, 80.0])))),
        queued!(SetARCCmd(give(&two_points()))),
        queued!(SetLostStepCmd()),
        queued!(SetHOMECmd(give(&[0; 4]))),
        queued!(SetAutoLevelingCmd(give(
            &[vec![1], floats(&[0.02])].concat()
        ))),
        queued!("SetJOGCmd queued" SetJOGCmd(give(&[1, 4])) 1),
        immediate!("SetJOGCmd at once" SetJOGCmd(give(&[0, 0]))),
        plain!(ResetPose(1, 45.0, 30.0)),
        plain!(SetQueuedCmdStopExec()),
        plain!(SetQueuedCmdForceStopExec()),
        plain!(SetQueuedCmdClear()),
    ]
}

/// All calls of a family: the common ones, its own, and `more`.
fn every_call(more: Vec<Call>) -> Vec<Call> {
    let parts = [
        beginning(),
        own_calls(),
        more,
        common_calls(),
        vec![circle()],
    ];
    parts.into_iter().flatten().collect()
}
