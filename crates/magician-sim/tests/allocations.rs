//! A controller in steady state allocates nothing.
#![allow(
    unsafe_code,
    reason = "counting allocations takes an allocator, and an allocator is unsafe"
)]

#[path = "virtual_arm/arm/mod.rs"]
mod arm;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::time::Duration;

use arm::{USB, home, joints_to, ptp, running_arm, suck, wait};
use magician_protocol::commands::{Pose, PtpCmd, QueuedCmdCurrentIndex, WaitCmd};
use magician_protocol::{Ctrl, FrameBuf, NoArgs, Readable, Writable};
use magician_sim::{Controller, HostInstant, LineTiming, Runner, Speed};

thread_local! {
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

struct Counting;

fn count() {
    // During thread exit the counter may already be destroyed.
    let _ = COUNT.try_with(|count| count.set(count.get() + 1));
}

// SAFETY: every call is forwarded to the system allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: as promised by the caller.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: as promised by the caller.
        unsafe { System.dealloc(memory, layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: as promised by the caller.
        unsafe { System.realloc(memory, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn queued<T: Writable>(value: &T) -> FrameBuf {
    FrameBuf::encode(T::ROW.id, Ctrl::QUEUED, value).unwrap()
}

/// Parameters of a joint move to the home angles, with the carriage of the rail at `l` mm.
fn on_rail(l: f32) -> Vec<u8> {
    let mut params = vec![4];
    params.extend(
        [0.0, 45.0, 45.0, 0.0, l]
            .iter()
            .flat_map(|n: &f32| n.to_le_bytes()),
    );
    params
}

fn read<T: Readable<Query = NoArgs>>() -> FrameBuf {
    FrameBuf::get(&NoArgs, T::ROW).unwrap()
}

/// Sends all frames, then advances until nothing is scheduled; sends all polls at every event.
fn round(arm: &mut Controller, frames: &[FrameBuf], polls: &[FrameBuf]) {
    for frame in frames {
        arm.receive(USB, frame.bytes());
        while arm.poll_transmit(USB).is_some() {}
    }
    while let Some(at) = arm.poll_timeout() {
        arm.advance(at);
        for poll in polls {
            arm.receive(USB, poll.bytes());
            assert!(arm.poll_transmit(USB).is_some());
        }
        assert!(arm.state().joints.is_finite());
    }
    while arm.poll_event().is_some() {}
}

#[test]
fn a_steady_state_allocates_nothing() {
    // Moves of every kind, a refused one, waits, outputs, path segments, an unknown id, and more
    // commands than the queue holds.
    let mut frames: Vec<FrameBuf> = (0..10)
        .map(|mode| {
            let target = match mode {
                3..=5 => [10.0, 40.0, 40.0, 0.0],
                6..=8 => [1.0, -2.0, 3.0, 0.0],
                _ => [210.0, -40.0, 12.5, -20.0],
            };
            queued::<PtpCmd>(&ptp(mode, target))
        })
        .collect();
    frames.extend([
        queued(&home()),
        queued(&suck(true)),
        queued::<WaitCmd>(&wait(20)),
        // Along the rail and back, an output, a trigger that is met, a motor that counts pulses.
        FrameBuf::new(3, Ctrl::SET, &[1, 0]).unwrap(),
        FrameBuf::new(86, Ctrl::QUEUED, &on_rail(100.0)).unwrap(),
        FrameBuf::new(86, Ctrl::QUEUED, &on_rail(0.0)).unwrap(),
        FrameBuf::new(130, Ctrl::QUEUED, &[16, 1]).unwrap(),
        FrameBuf::new(131, Ctrl::QUEUED, &[16, 1]).unwrap(),
        FrameBuf::new(120, Ctrl::QUEUED, &[9, 0, 0, 0, 0]).unwrap(),
        FrameBuf::new(136, Ctrl::QUEUED, &[0, 1, 100, 0, 0, 0, 50, 0, 0, 0]).unwrap(),
        queued(&joints_to([140.0, 45.0, 45.0, 0.0])),
        FrameBuf::new(91, Ctrl::QUEUED, &[0; 17]).unwrap(),
        FrameBuf::new(88, Ctrl::QUEUED, &[7; 17 + 40]).unwrap(),
        FrameBuf::new(20, Ctrl::SET, &[]).unwrap(),
        FrameBuf::new(99, Ctrl::SET, &[]).unwrap(),
        queued(&home()),
    ]);
    frames.extend((0..40).map(|_| queued::<WaitCmd>(&wait(1))));
    frames.push(FrameBuf::new(31, Ctrl::SET, &[]).unwrap());
    frames.push(FrameBuf::new(20, Ctrl::SET, &[]).unwrap());
    let polls = [read::<Pose>(), read::<QueuedCmdCurrentIndex>()];
    let mut arm = running_arm().arm;
    // Each round starts where the previous one ended. After a few rounds all buffers have their
    // final size.
    for _ in 0..4 {
        round(&mut arm, &frames, &polls);
    }
    let before = COUNT.get();
    let finished = arm.state().queue.current_index;
    for _ in 0..50 {
        round(&mut arm, &frames, &polls);
    }
    assert_eq!(COUNT.get(), before);
    assert!(arm.state().queue.current_index > finished + 500);
    // Check that the allocator does count.
    drop(std::hint::black_box(vec![0u8; 10]));
    assert!(COUNT.get() > before);
}

#[test]
fn a_line_in_a_steady_state_allocates_nothing() {
    for baud in [None, Some(115_200)] {
        let line = LineTiming {
            baud,
            turnaround: Duration::from_millis(2),
        };
        let mut runner = Runner::new(Controller::default(), Speed::default(), line);
        let mut now = HostInstant::ZERO;
        let requests = [read::<Pose>(), read::<QueuedCmdCurrentIndex>()];
        let mut round = || {
            for request in &requests {
                runner.set_delay(Duration::from_micros(now.as_micros() % 3));
                runner.receive(now, USB, request.bytes());
                while runner.poll_transmit(now, USB).is_none() {
                    now = runner.poll_timeout().unwrap();
                    runner.handle_timeout(now);
                }
            }
        };
        (0..10).for_each(|_| round());
        let before = COUNT.get();
        (0..1_000).for_each(|_| round());
        assert_eq!(COUNT.get(), before);
    }
}
