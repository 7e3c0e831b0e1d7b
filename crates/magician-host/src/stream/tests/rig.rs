//! A stream, its connection and a virtual arm on one virtual clock.

use std::collections::VecDeque;

use magician_protocol::commands::{
    CpCmd, CpLeCmd, PtpCmd, QueuedCmdStartExec, SetEndEffectorLaser, WaitCmd,
};
use magician_protocol::{CpMode, Ctrl, Flag, FrameBuf, PtpMode, Set};
use magician_sim::Event;

use crate::connection::{Failure, Request, Settings};
use crate::pair::{Faults, Pair};
use crate::stream::{Item, Stream, StreamEvent, StreamFailure, StreamSettings};

pub(super) const SECOND: u64 = 1_000_000;
/// Pose of the arm at power-up.
pub(super) const START: [f64; 3] = [259.104, 0.0, -8.485];

pub(super) struct Rig {
    pub(super) pair: Pair,
    pub(super) stream: Stream,
    pub(super) settings: StreamSettings,
    /// Commands that the caller has yet to offer.
    pub(super) feed: VecDeque<Item>,
    pub(super) events: Vec<StreamEvent>,
    /// Number of commands of the program that the controller has taken, as last reported.
    pub(super) reported_accepted: u64,
    /// Indices in the order in which the arm began them.
    pub(super) started: Vec<u64>,
}

impl Rig {
    pub(super) fn new(line: Settings, settings: StreamSettings, program: &[Item]) -> Self {
        Self {
            pair: Pair::new(line, Faults::default(), 1),
            stream: Stream::new(settings),
            settings,
            feed: program.iter().copied().collect(),
            events: Vec::new(),
            reported_accepted: 0,
            started: Vec::new(),
        }
    }

    /// Processes the next event, but not beyond `end`.
    pub(super) fn turn(&mut self, end: u64) {
        self.advance();
        let due = self.stream.poll_timeout().unwrap_or(end);
        self.pair.step(due.clamp(self.pair.now, end));
        while let Some(event) = self.pair.arm.poll_event() {
            if let Event::Started { index, .. } = event {
                self.started.push(index);
            }
        }
        self.deliver();
        self.advance();
    }

    pub(super) fn advance(&mut self) {
        while self.stream.room() > 0
            && let Some(item) = self.feed.pop_front()
        {
            self.stream.offer(item).unwrap();
        }
        if self.feed.is_empty() {
            self.stream.finish();
        }
        self.stream.advance(self.pair.now, &mut self.pair.host);
        while let Some(event) = self.stream.poll_event() {
            if let StreamEvent::Sent { accepted, .. } = event {
                self.reported_accepted = accepted;
            }
            self.events.push(event);
        }
    }

    pub(super) fn deliver(&mut self) {
        let mut ended: Vec<_> = self.pair.results.drain().collect();
        // The order in a `HashMap` is random, and a test must be repeatable.
        ended.sort_by_key(|(ticket, _)| *ticket);
        for (ticket, result) in ended {
            (self.stream).answered(self.pair.now, ticket, &result, &mut self.pair.host);
        }
    }

    /// Runs until the stream is over.
    pub(super) fn run(&mut self, patience: u64) -> Result<(), StreamFailure> {
        let end = self.pair.now + patience;
        while !self.stream.is_over() {
            assert!(self.pair.now < end, "no end: {:?}", self.stream);
            self.turn(end);
        }
        while let Some(event) = self.stream.poll_event() {
            self.events.push(event);
        }
        assert_eq!(self.pair.cuts, 0, "no motion is cut short");
        match self.failure() {
            Some(failure) => Err(failure),
            None => Ok(()),
        }
    }

    pub(super) fn failure(&self) -> Option<StreamFailure> {
        match self.events.last() {
            Some(StreamEvent::Failed(failure)) => Some(*failure),
            _ => None,
        }
    }

    /// Breaks the line.
    pub(super) fn interrupt(&mut self) {
        self.stream.interrupt(Failure::Lost);
        self.pair.pull_cable();
        let now = self.pair.now;
        self.pair.step(now);
        self.deliver();
    }

    /// Restores the line and continues the program.
    pub(super) fn resume(&mut self) {
        self.pair.put_cable_back();
        self.go_on();
    }

    /// Continues the program on the line as it is.
    pub(super) fn go_on(&mut self) {
        let stream = std::mem::replace(&mut self.stream, Stream::new(self.settings));
        while let Some(event) = self.stream.poll_event() {
            self.events.push(event);
        }
        self.events.clear();
        self.stream = Stream::resume(stream.leftover(), self.settings);
    }

    /// Commands that the arm took, as positions in the program. `None` for commands outside of it.
    pub(super) fn taken(&self, program: &[Item]) -> Vec<Option<usize>> {
        let bytes: Vec<_> = program.iter().map(params).collect();
        // Commands are distinguished by their bytes, so the commands of a program must all differ.
        let place = |taken: &Vec<u8>| bytes.iter().position(|bytes| bytes == taken);
        self.pair
            .accepted
            .iter()
            .map(|(taken, _)| place(taken))
            .collect()
    }

    /// Commands that the arm executed, in order, as positions in the program.
    pub(super) fn done(&self, program: &[Item]) -> Vec<usize> {
        let taken = self.taken(program);
        let place = |index: &u64| {
            let at = self
                .pair
                .accepted
                .iter()
                .position(|(_, given)| given == index);
            at.and_then(|at| taken[at])
        };
        self.started.iter().filter_map(place).collect()
    }

    /// Total time of the commands in the arm's queue, and their number.
    pub(super) fn queued(&self, program: &[Item]) -> (u64, usize) {
        let current = self.pair.arm.state().queue.current_index;
        let queued = self.pair.accepted.iter().zip(self.taken(program));
        let queued = queued.filter(|((_, index), _)| *index > current);
        let times = queued.map(|(_, place)| place.map_or(0, |place| program[place].time));
        times.fold((0, 0), |(sum, count): (u64, _), time| {
            (sum.saturating_add(time), count + 1)
        })
    }
}

pub(super) fn params(item: &Item) -> Vec<u8> {
    let frame = FrameBuf::set(&item.command, Ctrl::QUEUED).unwrap();
    frame.frame().params().to_vec()
}

/// Starts the queue before the stream begins.
pub(super) fn started(mut rig: Rig) -> Rig {
    rig.pair
        .ask(Request::set(&QueuedCmdStartExec {}).unwrap(), SECOND)
        .unwrap();
    rig
}

fn item(command: impl Into<Set>, time: u64, end: Option<[f64; 3]>) -> Item {
    Item {
        command: command.into(),
        time,
        end: end.map(|[x, y, z]| [x, y, z, libm::atan2(y, x).to_degrees()]),
        laser: false,
    }
}

/// An absolute segment to a point.
pub(super) fn segment([x, y, z]: [f64; 3], time: u64) -> Item {
    let command = CpCmd {
        cp_mode: CpMode::Absolute,
        x: x as f32,
        y: y as f32,
        z: z as f32,
        velocity_or_power: 100.0,
    };
    item(command, time, Some([x, y, z]))
}

/// An absolute segment with laser power.
pub(super) fn burnt([x, y, z]: [f64; 3], time: u64) -> Item {
    let command = CpLeCmd {
        cp_mode: CpMode::Absolute,
        x: x as f32,
        y: y as f32,
        z: z as f32,
        velocity_or_power: 50.0,
    };
    Item {
        laser: true,
        ..item(command, time, Some([x, y, z]))
    }
}

/// An increment from the end of the previous command, which is at `from`.
pub(super) fn increment(from: [f64; 3], by: [f64; 3], time: u64) -> Item {
    let end = [from[0] + by[0], from[1] + by[1], from[2] + by[2]];
    let command = CpCmd {
        cp_mode: CpMode::Relative,
        x: by[0] as f32,
        y: by[1] as f32,
        z: by[2] as f32,
        velocity_or_power: 100.0,
    };
    item(command, time, Some(end))
}

/// An absolute joint move.
pub(super) fn jump([x, y, z]: [f64; 3], time: u64) -> Item {
    let command = PtpCmd {
        ptp_mode: PtpMode::MovjXyz,
        x: x as f32,
        y: y as f32,
        z: z as f32,
        r: libm::atan2(y, x).to_degrees() as f32,
    };
    item(command, time, Some([x, y, z]))
}

/// A pause at a point.
pub(super) fn wait(ms: u32, at: [f64; 3]) -> Item {
    item(WaitCmd { timeout: ms }, u64::from(ms) * 1000, Some(at))
}

pub(super) fn laser(on: bool, at: [f64; 3]) -> Item {
    let command = SetEndEffectorLaser {
        enable_ctrl: Flag::ON,
        on: Flag::from(on),
    };
    Item {
        laser: on,
        ..item(command, 0, Some(at))
    }
}

/// A point this far along a zigzag, all of whose points are different.
pub(super) fn along(step: f64, count: usize) -> [f64; 3] {
    bent(7.0, step, count)
}

/// The same on a sine curve whose phase advances by one radian per `length`, mm.
fn bent(length: f64, step: f64, count: usize) -> [f64; 3] {
    let there = count as f64 * step;
    [
        START[0] + 20.0 - libm::sin(there / length) * 20.0,
        there % 60.0,
        START[2] + there / 1000.0,
    ]
}

/// Duration of a segment from rest to rest at 100 mm/s^2, us: longer than between other segments.
pub(super) fn rest_to_rest(step: f64, count: usize) -> u64 {
    let (from, to) = (along(step, count - 1), along(step, count));
    let squares = from
        .iter()
        .zip(&to)
        .map(|(from, to)| (to - from) * (to - from));
    (2e6 * (squares.sum::<f64>().sqrt() / 100.0).sqrt()) as u64
}

/// Segments of a zigzag of lines straight enough to share a window.
pub(super) fn path(count: usize, step: f64, time: u64) -> Vec<Item> {
    (1..=count)
        .map(|at| segment(bent(150.0, step, at), time))
        .collect()
}

/// A program of jumps, waits and increments, all of them different.
pub(super) fn mixed() -> Vec<Item> {
    let mut at = [210.0, 0.0, 0.0];
    let mut all = vec![jump(at, 400_000)];
    for count in 1..=19 {
        let by = [0.0, 2.0 + f64::from(count) / 10.0, 1.0];
        let next = match count % 4 {
            0 => wait(40 + count as u32, at),
            1 => jump([at[0] + by[0], at[1] + by[1], at[2] + by[2]], 150_000),
            _ => increment(at, by, 150_000),
        };
        if let Some([x, y, z, _]) = next.end {
            at = [x, y, z];
        }
        all.push(next);
    }
    all
}
