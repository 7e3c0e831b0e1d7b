use magician_protocol::commands::PtpPoWithLCmd;
use magician_protocol::{Ctrl, FrameBuf, PoCmd, PoList, PtpMode};

use super::rig::{Rig, SECOND, increment, jump, laser, mixed, path, segment, started, wait};
use crate::connection::{Failure, Settings};
use crate::pair::Faults;
use crate::stream::{
    Entry, INSERTED_CAPACITY, Item, MAX_KEPT, MAX_WAITING, Refused, Stream, StreamEvent,
    StreamFailure, StreamSettings,
};

fn all(program: &[Item]) -> Vec<Option<usize>> {
    (0..program.len()).map(Some).collect()
}

#[test]
fn a_program_runs_in_order_and_is_finished_when_the_arm_is() {
    let program = mixed();
    let mut rig = Rig::new(Settings::ORDERED, StreamSettings::default(), &program);
    rig.run(60 * SECOND).unwrap();
    assert_eq!(rig.taken(&program), all(&program));
    assert_eq!(rig.done(&program), (0..program.len()).collect::<Vec<_>>());
    let finished = StreamEvent::Finished { last: Some(21) };
    assert_eq!(rig.events.last(), Some(&finished));
    let state = rig.pair.arm.state();
    assert_eq!(state.queue.current_index, 21);
    let sent = |event: &&StreamEvent| matches!(event, StreamEvent::Sent { accepted: 20, .. });
    assert!(rig.events.iter().any(|event| sent(&event)));
}

#[test]
fn nothing_is_lost_doubled_or_swapped_at_window_1_however_bad_the_line() {
    let program = [mixed(), path(150, 1.5, 12_000)].concat();
    let mut interrupted = 0;
    for seed in 0..12 {
        let mut rig = Rig::new(Settings::ORDERED, StreamSettings::default(), &program);
        rig.pair.dice = crate::pair::Dice::new(seed);
        rig.pair.set_faults(Faults {
            drop_chunk: 0.04,
            flip: 0.002,
            ..Faults::default()
        });
        // A command in doubt is settled on resuming.
        while let Err(failure) = rig.run(600 * SECOND) {
            assert!(
                matches!(failure, StreamFailure::Request(Failure::Uncertain { .. })),
                "{failure}"
            );
            interrupted += 1;
            rig.go_on();
        }
        assert_eq!(rig.taken(&program), all(&program), "seed {seed}");
        assert_eq!(rig.done(&program), (0..program.len()).collect::<Vec<_>>());
    }
    // The connection repeats most of what is lost, so doubt must stay rare.
    assert!(interrupted < 12, "{interrupted}");
}

/// Runs a program. Returns the longest motion in the arm, the largest number of commands, and the
/// longest time without work between the first and the last command.
fn watch(program: &[Item], settings: StreamSettings) -> (u64, usize, u64) {
    let mut rig = started(Rig::new(Settings::ORDERED, settings, program));
    let (mut most, mut most_count, mut idle) = (0, 0, 0);
    let end = 600 * SECOND;
    while !rig.stream.is_over() {
        let before = rig.pair.now;
        let works = rig.pair.arm.state().queue.running.is_some();
        let between = !rig.started.is_empty() && rig.pair.accepted.len() < program.len();
        rig.turn(end);
        if !works && between {
            idle += rig.pair.now - before;
        }
        let (time, count) = rig.queued(program);
        // Two commands are allowed however long they take.
        if count > 2 {
            most = most.max(time);
        }
        most_count = most_count.max(count);
    }
    assert_eq!(rig.failure(), None);
    (most, most_count, idle)
}

#[test]
fn never_more_than_the_horizon_and_never_fewer_than_two() {
    let jumps = |time: u64, count: usize| -> Vec<Item> {
        let y = |at: usize| if at.is_multiple_of(2) { -60.0 } else { 60.0 };
        (0..count)
            .map(|at| jump([220.0, y(at) + at as f64 / 100.0, 20.0], time))
            .collect()
    };
    // Moves of 1.5 s: two at a time, without a pause in between.
    let (_, count, idle) = watch(&jumps(1_500_000, 8), StreamSettings::default());
    assert_eq!(count, 2);
    assert_eq!(idle, 0);
    // Commands of unknown duration.
    let (_, count, _) = watch(&jumps(u64::MAX, 5), StreamSettings::default());
    assert_eq!(count, 2);
    // Enough commands to fill the horizon.
    let waits = |ms: u32| (0..60).map(move |at| wait(ms + at % 3, [200.0, 0.0, 0.0]));
    let (time, count, idle) = watch(&waits(200).collect::<Vec<_>>(), StreamSettings::default());
    assert!((1_800_000..=2_000_000).contains(&time), "{time}");
    assert!(count >= 9);
    assert_eq!(idle, 0);
    let shorter = StreamSettings {
        horizon: 500_000,
        ..StreamSettings::default()
    };
    let (time, _, _) = watch(&waits(100).collect::<Vec<_>>(), shorter);
    assert!((400_000..=500_000).contains(&time), "{time}");
    // Short commands fill the queue and never more.
    let (time, count, _) = watch(&path(300, 1.5, 15_000), StreamSettings::default());
    assert!(time <= 32 * 15_000);
    assert_eq!(count, 32);
}

#[test]
fn the_queue_is_never_overrun() {
    let program = path(300, 1.0, 10_000);
    let mut rig = started(Rig::new(
        Settings::ORDERED,
        StreamSettings::default(),
        &program,
    ));
    rig.run(60 * SECOND).unwrap();
    assert_eq!(rig.pair.arm.state().queue.overflows, 0);
}

#[test]
fn a_batch_moves_only_when_all_of_it_is_in() {
    for running in [false, true] {
        let program = path(20, 1.0, 20_000);
        let mut rig = Rig::new(Settings::ORDERED, StreamSettings::default(), &program);
        if running {
            rig = started(rig);
        }
        while rig.pair.accepted.len() < program.len() {
            rig.turn(SECOND);
            assert!(rig.started.is_empty());
        }
        rig.run(10 * SECOND).unwrap();
        assert_eq!(rig.started.len(), program.len());
        assert!(rig.pair.arm.state().queue.started);
    }
}

#[test]
fn a_single_command_neither_stops_the_queue_nor_waits_for_more() {
    let program = [segment([264.7, 0.0, 0.0], 100_000)];
    let mut rig = Rig::new(Settings::ORDERED, StreamSettings::default(), &program);
    rig.run(10 * SECOND).unwrap();
    let stops = rig
        .pair
        .heard
        .iter()
        .filter(|frame| frame.frame().id() == 241);
    assert_eq!(stops.count(), 0);
    assert!(rig.pair.now < SECOND);
}

#[test]
fn a_caller_who_only_fills_the_queue_finds_it_as_it_was() {
    let settings = StreamSettings {
        start: false,
        ..StreamSettings::default()
    };
    // Longer than the horizon, and more commands than there are places.
    let program: Vec<_> = (1..40).map(|at| wait(500 + at, [0.0; 3])).collect();
    let mut rig = Rig::new(Settings::ORDERED, settings, &program);
    while rig.pair.now < 5 * SECOND {
        rig.turn(5 * SECOND);
    }
    assert_eq!(rig.pair.accepted.len(), 32);
    assert!(rig.started.is_empty());
    assert!(!rig.pair.arm.state().queue.started);
    assert_eq!(rig.pair.arm.state().queue.overflows, 0);
}

#[test]
fn idle_stream_does_not_poll_and_a_waiting_one_polls_rarely() {
    let mut rig = Rig::new(Settings::ORDERED, StreamSettings::default(), &[]);
    rig.stream = Stream::new(StreamSettings::default());
    rig.stream.advance(0, &mut rig.pair.host);
    assert_eq!(rig.stream.poll_timeout(), None);
    assert!(rig.pair.host.is_idle());

    let program = [wait(20_000, [0.0; 3])];
    let mut rig = Rig::new(Settings::ORDERED, StreamSettings::default(), &program);
    rig.run(30 * SECOND).unwrap();
    let polls = rig.pair.heard.len();
    // At most 12 requests per second during a wait of 20 s.
    assert!(polls < 20 * 12, "{polls}");
}

#[test]
fn what_cannot_be_queued_is_refused_and_so_is_what_has_no_room() {
    let mut stream = Stream::new(StreamSettings::default());
    let clear = magician_protocol::commands::QueuedCmdClear {};
    let item = Item {
        command: clear.into(),
        ..laser(false, [0.0; 3])
    };
    assert_eq!(stream.offer(item), Err(Refused::NotQueueable));
    // A frame has room for 57 outputs, but not together with a rail position.
    let outputs = |count: usize| Item {
        command: PtpPoWithLCmd {
            ptp_mode: PtpMode::MovlXyz,
            x: 220.0,
            y: 0.0,
            z: 20.0,
            r: 0.0,
            l: 0.0,
            po: PoList::new(&vec![PoCmd::default(); count]).expect("a list"),
        }
        .into(),
        ..laser(false, [0.0; 3])
    };
    let mut other = Stream::new(StreamSettings::default());
    assert_eq!(other.offer(outputs(57)), Err(Refused::TooLong));
    for count in [0, 56] {
        let item = outputs(count);
        assert_eq!(other.offer(item), Ok(()));
        assert!(FrameBuf::set(&item.command, Ctrl::QUEUED).is_ok());
    }
    let step = increment([0.0; 3], [1.0, 0.0, 0.0], 1000);
    for left in (0..MAX_WAITING).rev() {
        assert_eq!(stream.offer(step), Ok(()));
        assert_eq!(stream.room(), left);
    }
    assert_eq!(stream.offer(step), Err(Refused::Full));
    stream.finish();
    assert_eq!(stream.offer(step), Err(Refused::Over));
}

#[test]
fn a_queue_that_somebody_clears_ends_the_stream() {
    let program: Vec<_> = (1..60).map(|at| wait(150 + at, [0.0; 3])).collect();
    let mut rig = Rig::new(Settings::ORDERED, StreamSettings::default(), &program);
    while rig.pair.now < 2 * SECOND {
        rig.turn(2 * SECOND);
    }
    // Directly at the arm, unknown to this host.
    let clear = magician_protocol::FrameBuf::new(245, magician_protocol::Ctrl::SET, &[]).unwrap();
    rig.pair.arm.receive(magician_sim::LinkId(7), clear.bytes());
    let failure = rig.run(60 * SECOND).unwrap_err();
    assert!(
        matches!(failure, StreamFailure::Dropped { .. }),
        "{failure}"
    );
}

#[test]
fn a_stream_is_small() {
    let kept = (MAX_WAITING + MAX_KEPT + INSERTED_CAPACITY) * size_of::<Entry>();
    println!("{} and {kept} bytes", size_of::<Stream>());
    assert!(size_of::<Stream>() + kept < 32 * 1024);
}
