//! Cost of a path segment in processor time of the whole process: through the driver to an
//! in-process arm, by both handles, and for comparison the parts of it without a task, a channel
//! and a timer.
//!
//! `cargo bench -p magician --bench segments [-- SEGMENTS [PART]]`. Results are the median of
//! several rounds, with the best in brackets.

use std::hint::black_box;
use std::time::Duration;

use magician::build;
use magician::commands::{ClearAllAlarmsState, QueuedCmdStartExec};
use magician::connection::{Connection, Event, Settings};
use magician::preflight::Preflight;
use magician::sim::{Controller, LinkId};
use magician::stream::{Item, Stream, StreamEvent, StreamSettings};
use magician::{Arm, Ctrl, FrameBuf, Options, Set, Target, VirtualArm, blocking};
use rustix::time::{ClockId, clock_gettime};

const LINK: LinkId = LinkId(0);
const ROUNDS: usize = 7;
/// Highest acceptable cost of a segment through the driver, us.
const GOAL: f64 = 8.0;

/// Sends a path to an arm.
type Part = fn(&[Set]);

fn main() {
    let words: Vec<String> = (std::env::args().skip(1))
        .filter(|word| !word.starts_with("--"))
        .collect();
    let count = words.iter().find_map(|word| word.parse().ok());
    let count = count.unwrap_or(100_000);
    let part = words.iter().find(|word| word.parse::<u32>().is_err());
    let parts: [(&str, Part); 6] = [
        ("simulation", simulation),
        ("check", check),
        ("engines", engines),
        ("async", |path| with_runtime(path, Options::default())),
        ("blocking", with_blocking),
        ("window-4", |path| {
            with_runtime(path, Options::default().window(4));
        }),
    ];
    let path = path(count);
    let mut yardstick = None;
    for (name, work) in parts {
        if part.is_some_and(|part| part != name) {
            continue;
        }
        work(&path);
        let mut rounds: Vec<f64> = (0..ROUNDS)
            .map(|_| cost(|| work(&path)).as_secs_f64() * 1e6 / path.len() as f64)
            .collect();
        rounds.sort_by(f64::total_cmp);
        let (median, best) = (rounds[ROUNDS / 2], rounds[0]);
        let times = median / *yardstick.get_or_insert(median);
        let goal = match name {
            "async" | "blocking" if median <= GOAL => ", goal met",
            "async" | "blocking" => ", goal MISSED",
            _ => "",
        };
        println!(
            "{name:<12}{median:>8.2} us a segment ({best:.2}), {times:.1} times the simulation{goal}"
        );
    }
}

/// Returns the processor time of all threads, including the system's time for them.
fn cost(work: impl FnOnce()) -> Duration {
    let spent = || Duration::try_from(clock_gettime(ClockId::ProcessCPUTime)).unwrap_or_default();
    let before = spent();
    work();
    spent() - before
}

/// Returns a line of 100 mm back and forth in segments of 1 mm, repeated, after an approach.
fn path(count: i32) -> Vec<Set> {
    let segments = (1..=count).map(|at| {
        let y = 50 - (at % 200 - 100).abs();
        build::path_to(220.0, y as f32, 10.0)
    });
    begin().into_iter().chain(segments).collect()
}

fn begin() -> [Set; 2] {
    [
        build::path_speed(100.0, 100.0),
        build::line_to(220.0, -50.0, 10.0, 0.0),
    ]
}

fn controller() -> Controller {
    let arm = VirtualArm::default();
    let mut arm = arm.with(|arm| arm.clone());
    let sets: [Set; 2] = [ClearAllAlarmsState {}.into(), QueuedCmdStartExec {}.into()];
    for set in sets {
        let frame = FrameBuf::set(&set, Ctrl::SET).expect("it fits");
        arm.receive(LINK, frame.bytes());
        arm.poll_transmit(LINK).expect("an answer");
    }
    arm
}

/// Runs the virtual arm alone: bytes in, bytes out, and a host that keeps its queue full.
fn simulation(path: &[Set]) {
    let mut arm = controller();
    let mut left = arm.state().queue.capacity;
    let mut next = path.iter();
    loop {
        for command in next.by_ref().take(left) {
            let frame = FrameBuf::set(command, Ctrl::QUEUED).expect("it fits");
            arm.receive(LINK, frame.bytes());
            black_box(arm.poll_transmit(LINK)).expect("an answer");
        }
        let Some(at) = arm.poll_timeout() else { return };
        arm.advance(at);
        left = 0;
        while let Some(event) = arm.poll_event() {
            left += usize::from(matches!(event, magician::sim::Event::Finished { .. }));
        }
    }
}

/// Runs the preflight check, which gives the stream the duration of each segment.
fn check(path: &[Set]) {
    let mut check = Preflight::at(controller().state().joints, magician::ToolBias::SUCTION);
    for command in path {
        black_box(check.check(command)).expect("the path is within reach");
    }
}

/// Runs connection and stream on the virtual arm, on one clock and without a task.
fn engines(path: &[Set]) {
    let mut arm = controller();
    let mut host = Connection::new(Settings {
        free_clock: true,
        ..Settings::ORDERED
    });
    let mut stream = Stream::new(StreamSettings::default());
    let mut next = path.iter();
    stream.leap_clock(0, Duration::ZERO, false);
    let now = 0;
    loop {
        while stream.room() > 0 {
            let Some(command) = next.next() else {
                stream.finish();
                break;
            };
            let item = Item {
                command: *command,
                time: 10_000,
                end: None,
                laser: false,
            };
            stream.offer(item).expect("there is room");
        }
        stream.advance(now, &mut host);
        let mut quiet = true;
        while let Some(frame) = host.poll_transmit(now) {
            arm.receive(LINK, frame.bytes());
            while let Some(reply) = arm.poll_transmit(LINK) {
                host.receive(now, reply.bytes());
            }
            quiet = false;
        }
        while let Some(event) = host.poll_event() {
            if let Event::Done { ticket, result } = event {
                stream.answered(now, ticket, &result, &mut host);
            }
            quiet = false;
        }
        while let Some(event) = stream.poll_event() {
            match event {
                StreamEvent::Finished { .. } => return,
                StreamEvent::Failed(failure) => panic!("{failure}"),
                _ => {}
            }
        }
        if quiet {
            let (from, before) = (arm.now(), arm.current_index());
            let patience = stream.patience(now).unwrap_or(Duration::MAX);
            let (end, ends) = (from + patience, stream.wants_room());
            while let Some(at) = arm.poll_timeout()
                && arm.now() < end
                && !(ends && arm.current_index() != before)
            {
                arm.advance(at.min(end));
            }
            while arm.poll_event().is_some() {}
            stream.leap_clock(now, arm.now() - from, true);
        }
    }
}

/// Runs the async handle on a runtime of one thread.
fn with_runtime(path: &[Set], options: Options) {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .expect("a runtime");
    runtime.block_on(async {
        let arm = Arm::connect_with(&target(), options).await;
        let arm = arm.expect("the arm is in this process");
        arm.clear_alarms().await.expect("it answers");
        let ran = arm.start(path.iter().copied()).wait(|_| {}).await;
        assert_eq!(ran.expect("it runs").commands, path.len() as u64);
        arm.close().await;
    });
}

/// Runs the blocking handle, which serves its runtime on a background thread.
fn with_blocking(path: &[Set]) {
    let arm = blocking::Arm::connect(target()).expect("the arm is in this process");
    arm.clear_alarms().expect("it answers");
    let ran = arm
        .start(path.iter().copied())
        .wait(|_| {})
        .expect("it runs");
    assert_eq!(ran.commands, path.len() as u64);
    arm.close();
}

fn target() -> Target {
    "sim".parse().expect("a target")
}
