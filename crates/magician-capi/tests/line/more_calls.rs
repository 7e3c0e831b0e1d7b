// Calls that `v2` lacks. This file is included like `calls.rs`.

fn pulses() -> Vec<u8> {
    floats(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
}

fn more_calls() -> Vec<Call> {
    vec![
        got!(GetDeviceInfo() value 16),
        plain!(SetCPRHoldEnable(1)),
        got!(GetCPRHoldEnable() on 1),
        queued!(SetCPCommonParams(give(&floats(&[60.0, 70.0])))),
        got!(GetCPCommonParams() value 8),
        queued!(SetARCCommonParams(give(&floats(&[60.0, 70.0])))),
        got!(GetARCCommonParams() value 8),
        // Older callers leave garbage in these arguments, so they must be ignored.
        plain!(SetLostStepParams(5.0, 0xEE, invalid_out())),
        got!(GetUART4PeripheralsType() kind 1),
        plain!(SetUART4PeripheralsEnable(1)),
        got!(GetUART4PeripheralsEnable() on 1),
        got!(GetQueuedCmdMotionFinish() finished 1),
        immediate!("SendPluse at once" SendPluse(give(&pulses()))),
        queued!("SendPluse queued" SendPluse(give(&pulses())) 1),
        plain!(SendPluseEx(give(&pulses()))),
    ]
}
