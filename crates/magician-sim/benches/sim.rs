//! Speed and memory of the virtual arm.
//!
//! `ptp_mix` is figure S1: arm seconds per wall second, with full bytes in and out. divan's item
//! rate counts arm milliseconds, so `1 Gitem/s` is 1,000,000 arm seconds per second. Allocations
//! are counted; the steady state has none. `idle` is figure S4, printed before the benchmarks.

use divan::counter::ItemsCount;
use divan::{AllocProfiler, Bencher, black_box};
use magician_protocol::commands::{EndEffectorParams, Pose, PtpCmd, QueuedCmdStartExec};
use magician_protocol::{Ctrl, FrameBuf, PtpMode, Writable};
use magician_sim::{Controller, LinkId, Profile};

#[global_allocator]
static ALLOCATOR: AllocProfiler = AllocProfiler::system();

const LINK: LinkId = LinkId(0);

fn main() {
    println!(
        "size of Controller itself: {} bytes",
        size_of::<Controller>()
    );
    divan::main();
}

fn frame<T: Writable>(ctrl: Ctrl, value: &T) -> FrameBuf {
    FrameBuf::encode(T::ROW.id, ctrl, value).unwrap()
}

/// Lines, joint moves and jumps around a workplace, like a pick-and-place program.
fn mix() -> Vec<FrameBuf> {
    let places = [
        [250.0, 0.0, 20.0, 0.0],
        [220.0, 120.0, -30.0, 30.0],
        [180.0, -140.0, 10.0, -20.0],
        [280.0, 40.0, -40.0, 0.0],
    ];
    let mut frames = Vec::new();
    for round in 0..8 {
        for (at, [x, y, z, r]) in places.into_iter().enumerate() {
            let ptp_mode = [PtpMode::MovjXyz, PtpMode::MovlXyz, PtpMode::JumpXyz][(at + round) % 3];
            let command = PtpCmd {
                ptp_mode,
                x,
                y,
                z,
                r,
            };
            frames.push(frame(Ctrl::QUEUED, &command));
        }
    }
    frames
}

fn started() -> Controller {
    let mut arm = Controller::new(Profile::default());
    let bias = EndEffectorParams {
        x_bias: 59.7,
        y_bias: 0.0,
        z_bias: 0.0,
    };
    arm.receive(LINK, frame(Ctrl::SET, &bias).bytes());
    arm.exchange(LINK, frame(Ctrl::SET, &QueuedCmdStartExec {}).bytes());
    arm
}

fn run(arm: &mut Controller, frames: &[FrameBuf]) {
    for frame in frames {
        arm.receive(LINK, black_box(frame.bytes()));
        black_box(arm.poll_transmit(LINK));
    }
    while let Some(at) = arm.poll_timeout() {
        arm.advance(at);
    }
    while arm.poll_event().is_some() {}
}

/// 32 moves per round, from event to event.
#[divan::bench]
fn ptp_mix(bencher: Bencher<'_, '_>) {
    let (mut arm, frames) = (started(), mix());
    run(&mut arm, &frames);
    let before = arm.now();
    run(&mut arm, &frames);
    let round = arm.now().micros_since(before);
    assert!(arm.state().alarms.codes().all(|code| code == 0));
    bencher
        .counter(ItemsCount::new(round / 1000))
        .bench_local(|| run(&mut arm, &frames));
}

/// The same with a read of the pose every millisecond: S2.
#[divan::bench]
fn ptp_mix_traced_at_1_khz(bencher: Bencher<'_, '_>) {
    let (mut arm, frames) = (started(), mix());
    run(&mut arm, &frames);
    let before = arm.now();
    run(&mut arm, &frames);
    let round = arm.now().micros_since(before);
    bencher
        .counter(ItemsCount::new(round / 1000))
        .bench_local(|| {
            for frame in &frames {
                arm.receive(LINK, frame.bytes());
                black_box(arm.poll_transmit(LINK));
            }
            while arm.poll_timeout().is_some() {
                arm.advance(arm.now().after_micros(1000));
                black_box(arm.state());
            }
            while arm.poll_event().is_some() {}
        });
}

/// GetPose, bytes to bytes, at rest.
#[divan::bench]
fn get_pose(bencher: Bencher<'_, '_>) {
    let mut arm = started();
    let request = FrameBuf::new(
        <Pose as magician_protocol::Readable>::ROW.id,
        Ctrl::GET,
        &[],
    )
    .unwrap();
    bencher.counter(ItemsCount::new(1u32)).bench_local(|| {
        arm.receive(LINK, black_box(request.bytes()));
        black_box(arm.poll_transmit(LINK))
    });
}

/// A new arm; its allocations are the heap of an idle one.
#[divan::bench]
fn switch_on(bencher: Bencher<'_, '_>) {
    let profile = Profile::default();
    bencher
        .with_inputs(|| profile.clone())
        .bench_values(Controller::new);
}
