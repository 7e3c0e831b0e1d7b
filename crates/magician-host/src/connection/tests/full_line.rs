//! A line of 115200 baud, simulated to the byte in virtual time: its utilisation, and the delay of
//! a stop.

use std::time::Duration;

use magician_protocol::commands::{
    CpCmd, Pose, QueuedCmdCurrentIndex, QueuedCmdForceStopExec, QueuedCmdLeftSpace,
    QueuedCmdStartExec, WaitCmd,
};
use magician_protocol::{CpMode, NoArgs, Writable};
use magician_sim::{Controller, HostInstant, LineTiming, LinkId, Profile, Runner, Speed};

use super::SECOND;
use crate::connection::{
    Connection, Event, Failure, IndexLaw, Micros, Priority, Request, Settings, Ticket,
};
use crate::pair::Dice;

const BAUD: u32 = 115_200;
/// Time of the 23 bytes of a CP command on the line, us.
const CP_TIME: Micros = 1_997;

/// A host and an arm on a line of [`BAUD`], in virtual time.
pub(super) struct Paced {
    pub(super) host: Connection,
    arm: Runner,
    pub(super) now: Micros,
    /// Instant at which the line to the arm is free, ns.
    free: u64,
    pub(super) results: Vec<(Ticket, Result<(), Failure>)>,
    pub(super) answered: u32,
    vertex: u32,
    pub(super) waiting: usize,
    /// Instant of the first byte of the latest stop.
    stop_begins: Option<Micros>,
    /// True if the arm accepts one frame at a time, and loses others that arrive before the reply.
    pub(super) takes_one: bool,
    /// Frames that the arm accepted and has not answered.
    unanswered: u32,
    /// Frames lost because the arm had not answered the previous one.
    pub(super) lost: u32,
}

impl Paced {
    fn new(window: usize, turnaround: Micros, baud: Option<u32>) -> Self {
        let settings = Settings {
            window,
            baud,
            ..Settings::ORDERED
        };
        Self::with(settings, turnaround)
    }

    pub(super) fn with(settings: Settings, turnaround: Micros) -> Self {
        let line = LineTiming {
            baud: Some(BAUD),
            turnaround: Duration::from_micros(turnaround),
        };
        let controller = Controller::new(Profile::default());
        let mut paced = Self {
            host: Connection::new(settings),
            arm: Runner::new(controller, Speed::Max, line),
            now: 0,
            free: 0,
            results: Vec::new(),
            answered: 0,
            vertex: 0,
            waiting: 0,
            stop_begins: None,
            takes_one: false,
            unanswered: 0,
            lost: 0,
        };
        // The queue runs, so the commands of the tests do not fill it.
        paced.ask(Request::set(&QueuedCmdStartExec {}).unwrap());
        paced.ask(Request::get::<QueuedCmdLeftSpace>(&NoArgs).unwrap());
        // The window opens only when some commands have shown that the arm follows the law.
        for _ in 0..4 {
            paced.ask(Request::queued(&WaitCmd { timeout: 0 }).unwrap());
        }
        assert_eq!(paced.host.law(), IndexLaw::Followed);
        paced
    }

    fn ask(&mut self, request: Request) {
        let ticket = self.host.submit(request.deadline(self.now + SECOND));
        while !self.results.iter().any(|(done, _)| *done == ticket) {
            self.step(self.now + SECOND);
        }
        assert!(self.results.iter().all(|(_, result)| result.is_ok()));
        self.results.clear();
        self.answered = 0;
    }

    fn wall(&self) -> HostInstant {
        HostInstant::from_micros(self.now)
    }

    fn exchange(&mut self) {
        while let Some(reply) = self.arm.poll_transmit(self.wall(), LinkId(0)) {
            self.unanswered = self.unanswered.saturating_sub(1);
            self.host.receive(self.now, reply.bytes());
        }
        while let Some(frame) = self.host.poll_transmit(self.now) {
            let begins = self.free.max(self.now * 1000);
            // Ten bits per byte, with start and stop bit.
            self.free = begins + frame.bytes().len() as u64 * 10_000_000_000 / u64::from(BAUD);
            if frame.frame().id() == QueuedCmdForceStopExec::ROW.id {
                self.stop_begins = Some(begins.div_ceil(1000));
            }
            if self.takes_one && self.unanswered > 0 {
                self.lost += 1;
                continue;
            }
            self.unanswered += 1;
            let wall = self.wall();
            self.arm.receive(wall, LinkId(0), frame.bytes());
        }
        while let Some(event) = self.host.poll_event() {
            if let Event::Done { ticket, result } = event {
                self.answered +=
                    u32::from(result.is_ok_and(|reply| reply.frame().id() == CpCmd::ROW.id));
                self.results.push((ticket, result.map(|_| ())));
            }
        }
    }

    /// Advances to the next event, at most to `end`.
    pub(super) fn step(&mut self, end: Micros) {
        self.exchange();
        let arm = self.arm.poll_timeout().map(HostInstant::as_micros);
        let soonest = [self.host.poll_timeout(), arm];
        let next = soonest.into_iter().flatten().min().unwrap_or(end).min(end);
        self.now = next.max(self.now + 1).min(end);
        self.arm.handle_timeout(self.wall());
        self.host.handle_timeout(self.now);
        self.exchange();
    }

    /// Keeps segments waiting, so that the window is always full.
    pub(super) fn feed(&mut self) {
        let told = self.results.len();
        self.waiting = self.waiting.saturating_sub(told);
        while self.waiting < 12 {
            self.vertex += 1;
            let segment = CpCmd {
                cp_mode: CpMode::Absolute,
                x: 200.0 + (self.vertex % 100) as f32 * 0.2,
                y: 0.0,
                z: 50.0,
                velocity_or_power: 0.0,
            };
            let request = Request::queued(&segment).unwrap().repeatable();
            self.host.submit(request.deadline(self.now + 5 * SECOND));
            self.waiting += 1;
        }
    }
}

/// Commands per second with reads of pose, index and left space at 20 Hz, and the longest duration
/// of a read.
fn rate(window: usize, turnaround: Micros) -> (f64, Micros) {
    let mut paced = Paced::new(window, turnaround, Some(BAUD));
    let begun = paced.now;
    let end = begun + 5 * SECOND;
    let mut next_reads = begun;
    let mut reads: Vec<(Ticket, Micros)> = Vec::new();
    let (mut slowest, mut commands) = (0, 0);
    while paced.now < end {
        if paced.now >= next_reads {
            next_reads += 50_000;
            for read in [
                Request::get::<Pose>(&NoArgs).unwrap(),
                Request::get::<QueuedCmdCurrentIndex>(&NoArgs).unwrap(),
                Request::get::<QueuedCmdLeftSpace>(&NoArgs).unwrap(),
            ] {
                let ticket = paced.host.submit(read.deadline(paced.now + SECOND));
                reads.push((ticket, paced.now));
            }
        }
        for (ticket, result) in &paced.results {
            assert_eq!(*result, Ok(()));
            if let Some(at) = reads.iter().position(|(read, _)| read == ticket) {
                slowest = slowest.max(paced.now - reads.swap_remove(at).1);
                // `feed` counts every result as a segment, and this one is a read.
                paced.waiting += 1;
            }
        }
        commands += std::mem::take(&mut paced.answered);
        paced.feed();
        paced.results.clear();
        paced.step(end.min(next_reads));
    }
    assert!(paced.host.confirmed_index().is_some());
    (f64::from(commands) / 5.0, slowest)
}

#[test]
fn four_in_flight_fill_the_line_and_reads_have_their_turn() {
    for turnaround in [0, 500, 1_000] {
        let (rate, slowest) = rate(4, turnaround);
        println!("window 4, turnaround {turnaround} us: {rate} CP/s, reads within {slowest} us");
        // The line carries 11,520 bytes/s. Requests of the reads take 360, which leaves 485
        // segments of 23 bytes.
        assert!(rate >= 460.0, "{rate}");
        assert!(slowest < 50_000, "{slowest}");
    }
}

#[test]
fn one_at_a_time_is_as_fast_as_stop_and_wait_can_be() {
    // A segment takes 37 bytes in both directions and a turnaround. The reads take 80 bytes and
    // three turnarounds, 20 times a second.
    for (turnaround, computed) in [(0, 268.0), (2_000, 142.0), (4_000, 86.0)] {
        let (rate, slowest) = rate(1, turnaround);
        println!("window 1, turnaround {turnaround} us: {rate} CP/s, reads within {slowest} us");
        assert!(rate >= 0.95 * computed, "{rate}");
    }
}

/// Longest wait of a stop in a saturated stream, from submission to its first byte.
fn longest_wait(baud: Option<u32>) -> Micros {
    let mut dice = Dice::new(5);
    let mut longest = 0;
    for round in 0..400 {
        let mut paced = Paced::new(4, dice.below(1_000), baud);
        // Random instants, so that stops come at all phases of a frame.
        let at = paced.now + 20_000 + dice.below(20_000);
        while paced.now < at {
            paced.feed();
            paced.results.clear();
            paced.step(at);
        }
        let stop = Request::set(&QueuedCmdForceStopExec {}).unwrap();
        let stop = stop.priority(Priority::Stop);
        paced.host.submit(stop.deadline(at + SECOND));
        paced.exchange();
        let begins = paced
            .stop_begins
            .unwrap_or_else(|| panic!("{round}: held back"));
        longest = longest.max(begins - at);
    }
    longest
}

#[test]
fn a_stop_waits_for_the_frame_under_way_and_a_millisecond() {
    let longest = longest_wait(Some(BAUD));
    println!("a stop waits for at most {longest} us");
    assert!(longest <= CP_TIME + 1_000, "{longest}");
    // Without pacing, it waits for everything handed to the operating system.
    assert!(longest_wait(None) > CP_TIME + 1_000);
}
