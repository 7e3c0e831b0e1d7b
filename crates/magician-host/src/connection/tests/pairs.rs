//! A read beside a queued command at window 1: the line time it saves, and controllers that do not
//! accept it.

use magician_protocol::commands::{Pose, QueuedCmdCurrentIndex};
use magician_protocol::{FrameBuf, NoArgs, Readable};

use super::SECOND;
use super::full_line::Paced;
use crate::connection::{Failure, Micros, Request, Settings, Ticket};

/// Commands between two readings of a stream.
const PER_LOOK: u32 = 28;
/// Time of a CP command and its reply on the line, us.
const CP_TIME: Micros = 3_212;

fn serial(reads_beside: bool) -> Settings {
    Settings {
        baud: Some(115_200),
        reads_beside,
        ..Settings::ORDERED
    }
}

/// Result of a stream with a reading every [`PER_LOOK`] commands, and poses at a given rate.
struct Run {
    /// Commands per second.
    rate: f64,
    /// Answered reads.
    reads: usize,
    slowest_read: Micros,
    failures: Vec<Failure>,
    /// Frames lost by an arm that accepts one at a time.
    lost: u32,
}

fn run(settings: Settings, turnaround: Micros, poses: u64, takes_one: bool, seconds: u64) -> Run {
    let mut paced = Paced::with(settings, turnaround);
    paced.takes_one = takes_one;
    let begun = paced.now;
    let end = begun + seconds * SECOND;
    let mut next_pose = if poses > 0 { begun } else { Micros::MAX };
    let mut reads: Vec<(Ticket, Micros)> = Vec::new();
    let mut run = Run {
        rate: 0.0,
        reads: 0,
        slowest_read: 0,
        failures: Vec::new(),
        lost: 0,
    };
    let mut commands = 0;
    let mut looked = 0;
    while paced.now < end {
        let read = |paced: &mut Paced, request: Result<Request, _>| {
            let request: Request = request.unwrap();
            let ticket = paced.host.submit(request.deadline(paced.now + 10 * SECOND));
            (ticket, paced.now)
        };
        if paced.now >= next_pose {
            next_pose += SECOND / poses;
            reads.push(read(&mut paced, Request::get::<Pose>(&NoArgs)));
        }
        if commands >= looked + PER_LOOK {
            looked = commands;
            reads.push(read(
                &mut paced,
                Request::get::<QueuedCmdCurrentIndex>(&NoArgs),
            ));
        }
        for (ticket, result) in std::mem::take(&mut paced.results) {
            if let Err(failure) = result {
                run.failures.push(failure);
            }
            match reads.iter().position(|(read, _)| *read == ticket) {
                Some(at) => {
                    run.slowest_read = run.slowest_read.max(paced.now - reads.swap_remove(at).1);
                    run.reads += 1;
                }
                None => paced.waiting = paced.waiting.saturating_sub(1),
            }
        }
        commands += std::mem::take(&mut paced.answered);
        paced.feed();
        paced.step(end.min(next_pose));
    }
    run.rate = f64::from(commands) / seconds as f64;
    run.lost = paced.lost;
    run
}

/// Rate of a loop that only writes a command and waits for its reply, commands per second.
fn write_read_loop(turnaround: Micros) -> f64 {
    1e6 / (CP_TIME + turnaround) as f64
}

#[test]
fn a_look_costs_next_to_nothing_beside_a_command() {
    for turnaround in [0, 2_000, 4_000] {
        for poses in [0, 20] {
            let computed = write_read_loop(turnaround);
            let alone = run(serial(false), turnaround, poses, false, 5);
            let beside = run(serial(true), turnaround, poses, false, 5);
            println!(
                "turnaround {turnaround} us, {poses} poses/s: {:.3} of the loop, reads beside {:.3}, within {} us",
                alone.rate / computed,
                beside.rate / computed,
                beside.slowest_read,
            );
            assert!(beside.failures.is_empty() && alone.failures.is_empty());
            assert!(
                beside.rate >= 0.99 * computed || poses > 0,
                "{}",
                beside.rate
            );
            assert!(beside.rate > alone.rate);
        }
    }
}

#[test]
pub(super) fn a_controller_that_takes_one_frame_at_a_time_is_left_alone_after_a_few_losses() {
    let seen = run(serial(true), 1_000, 20, true, 60);
    println!("{} frames lost, {} commands/s", seen.lost, seen.rate);
    assert!(seen.failures.is_empty(), "{:?}", seen.failures);
    assert!((1..=8).contains(&seen.lost), "{}", seen.lost);
    assert!(seen.rate > 0.9 * run(serial(false), 1_000, 20, true, 60).rate);
}

#[test]
fn at_most_one_read_and_one_queued_command_are_in_flight() {
    let mut paced = Paced::with(serial(true), 2_000);
    let end = paced.now + 2 * SECOND;
    let mut most = [0; 2];
    while paced.now < end {
        for read in [
            FrameBuf::get(&NoArgs, Pose::ROW),
            FrameBuf::get(&NoArgs, QueuedCmdCurrentIndex::ROW),
        ] {
            let request = Request::of(read.unwrap());
            paced.host.submit(request.deadline(end + SECOND));
        }
        paced.feed();
        paced.results.clear();
        paced.step(end);
        let flying = paced.host.in_flight();
        most = [most[0].max(flying[0]), most[1].max(flying[1])];
    }
    assert_eq!(most, [1, 1], "reads, queued commands");
}
