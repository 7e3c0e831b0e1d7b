//! Programs that the benchmarks run on arms.

use magician_protocol::commands::{
    ClearAllAlarmsState, CpCmd, CpParams, EndEffectorParams, PtpCmd, QueuedCmdStartExec,
};
use magician_protocol::{CpMode, Ctrl, Flag, FrameBuf, PtpMode, Writable};
use magician_sim::{Controller, Event, LinkId};

pub(super) const USB: LinkId = LinkId(0);

/// Encodes a command as a frame.
pub(super) fn frame<T: Writable>(ctrl: Ctrl, value: &T) -> FrameBuf {
    FrameBuf::encode(T::ROW.id, ctrl, value).expect("a command fits a frame")
}

/// Position of the tool: x, y, z in mm, r in deg.
pub(super) type Position = [f32; 4];

/// Four positions of a workplace.
pub(super) const POSITIONS: [Position; 4] = [
    [250.0, 0.0, 20.0, 0.0],
    [220.0, 120.0, -30.0, 30.0],
    [180.0, -140.0, 10.0, -20.0],
    [280.0, 40.0, -40.0, 0.0],
];

/// Returns joint moves, lines and jumps between the four positions in equal numbers, as in pick and
/// place.
pub(super) fn pick_and_place() -> Vec<PtpCmd> {
    let modes = [PtpMode::MovjXyz, PtpMode::MovlXyz, PtpMode::JumpXyz];
    (0..24)
        .map(|at| {
            let [x, y, z, r] = POSITIONS[at % 4];
            let ptp_mode = modes[(at + at / 4) % 3];
            PtpCmd {
                ptp_mode,
                x,
                y,
                z,
                r,
            }
        })
        .collect()
}

/// Returns a circle with a radius of 40 mm, in segments of 1 mm. It ends where it starts, so that
/// it can be repeated.
pub(super) fn ring() -> Vec<CpCmd> {
    // One for each mm of the circumference, 2π × 40 mm.
    const SEGMENTS: u32 = 251;
    (1..=SEGMENTS)
        .map(|at| {
            let (sin, cos) =
                (f64::from(at) / f64::from(SEGMENTS) * std::f64::consts::TAU).sin_cos();
            CpCmd {
                cp_mode: CpMode::Absolute,
                x: (220.0 - 40.0 * cos) as f32,
                y: (40.0 * sin) as f32,
                z: 10.0,
                velocity_or_power: 0.0,
            }
        })
        .collect()
}

/// Returns two lines of 100 mm, there and back, in segments of 1 mm.
pub(super) fn hatching() -> Vec<CpCmd> {
    (1..=200i16)
        .map(|at| CpCmd {
            cp_mode: CpMode::Absolute,
            x: 180.0,
            y: f32::from(50 - (at - 100).abs()),
            z: 10.0,
            velocity_or_power: 0.0,
        })
        .collect()
}

/// Creates an arm that has a suction cup and accepts commands.
pub(super) fn arm() -> Controller {
    let mut arm = Controller::default();
    let bias = EndEffectorParams {
        x_bias: 59.7,
        y_bias: 0.0,
        z_bias: 0.0,
    };
    send(&mut arm, &frame(Ctrl::SET, &ClearAllAlarmsState {}));
    send(&mut arm, &frame(Ctrl::SET, &bias));
    send(&mut arm, &frame(Ctrl::SET, &QueuedCmdStartExec {}));
    arm
}

/// Creates such an arm at the start of a path, with this acceleration and speed along it.
pub(super) fn plotter(plan_acc: f32, junction_vel: f32) -> Controller {
    let mut arm = arm();
    let speeds = CpParams {
        plan_acc,
        junction_vel,
        acc_or_period: 100.0,
        real_time_track: Flag::OFF,
    };
    send(&mut arm, &frame(Ctrl::SET, &speeds));
    let there = PtpCmd {
        ptp_mode: PtpMode::MovjXyz,
        x: 180.0,
        y: 0.0,
        z: 10.0,
        r: 0.0,
    };
    send(&mut arm, &frame(Ctrl::QUEUED, &there));
    while let Some(at) = arm.poll_timeout() {
        arm.advance(at);
    }
    while arm.poll_event().is_some() {}
    arm
}

/// Sends a frame and takes the reply.
pub(super) fn send(arm: &mut Controller, frame: &FrameBuf) {
    arm.receive(USB, frame.bytes());
    std::hint::black_box(arm.poll_transmit(USB)).expect("every request is answered");
}

/// Acts as a host that keeps the queue full: it sends a command whenever one has finished. Every
/// command is a frame with a reply. `between` is called before the clock advances to the next
/// event of the arm, with the instant of that event.
pub(super) fn stream(
    arm: &mut Controller,
    frames: &[FrameBuf],
    mut between: impl FnMut(&mut Controller, magician_sim::ArmInstant),
) {
    let mut left = arm.state().queue.capacity;
    let mut next = frames.iter();
    loop {
        for frame in next.by_ref().take(left) {
            send(arm, frame);
        }
        let Some(at) = arm.poll_timeout() else { return };
        between(arm, at);
        arm.advance(at);
        left = 0;
        while let Some(event) = arm.poll_event() {
            left += usize::from(matches!(event, Event::Finished { .. }));
        }
    }
}
