//! A host's connection and a virtual controller on one virtual clock, with a line between them that loses, damages,
//! doubles and delays, all from a seed.

use std::collections::{HashMap, VecDeque};

use crate::connection::{Connection, Event, Failure, Request, Settings, Ticket};
use magician_protocol::{Deframer, FrameBuf, Layout, QueuedCmdIndex};
use magician_sim::{Controller, LinkId, Profile};

pub(crate) type Micros = u64;

/// A small generator of numbers (xorshift64*), the same on every platform.
pub(crate) struct Dice(u64);

impl Dice {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    pub(crate) fn roll(&mut self, sides: u64) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 16) % sides
    }

    /// True in `per_mille` of a thousand cases.
    pub(crate) fn chance(&mut self, per_mille: u64) -> bool {
        self.roll(1000) < per_mille
    }
}

/// What the line does to a frame; chances in per mille.
#[derive(Clone, Copy, Default)]
pub(crate) struct Faults {
    pub(crate) lose: u64,
    pub(crate) damage: u64,
    pub(crate) double: u64,
    /// A frame that is late is late by up to this many us.
    pub(crate) late: u64,
    pub(crate) late_by: Micros,
    /// Frames may overtake each other.
    pub(crate) reorder: bool,
}

struct Line {
    faults: Faults,
    under_way: VecDeque<(Micros, Vec<u8>)>,
    latest: Micros,
    delay: Micros,
    lose_next: bool,
}

impl Line {
    fn put(&mut self, now: Micros, frame: &[u8], dice: &mut Dice) {
        if std::mem::take(&mut self.lose_next) {
            return;
        }
        let Faults {
            lose,
            damage,
            double,
            late,
            late_by,
            reorder,
        } = self.faults;
        for _ in 0..=u32::from(dice.chance(double)) {
            if dice.chance(lose) {
                continue;
            }
            let mut bytes = frame.to_vec();
            if dice.chance(damage) {
                let at = dice.roll(bytes.len() as u64) as usize;
                bytes[at] ^= 1 << dice.roll(8);
            }
            let mut at = now + self.delay;
            if dice.chance(late) {
                at += dice.roll(late_by);
            }
            if !reorder {
                at = at.max(self.latest);
                self.latest = at;
            }
            self.under_way.push_back((at, bytes));
        }
    }

    fn take(&mut self, now: Micros) -> Option<Vec<u8>> {
        let at = self.under_way.iter().position(|(at, _)| *at <= now)?;
        self.under_way.remove(at).map(|(_, bytes)| bytes)
    }

    fn next(&self) -> Option<Micros> {
        self.under_way.iter().map(|(at, _)| *at).min()
    }
}

pub(crate) struct Pair {
    pub(crate) now: Micros,
    pub(crate) host: Connection,
    pub(crate) arm: Controller,
    pub(crate) dice: Dice,
    /// When the arm was switched on last.
    booted: Micros,
    to_arm: Line,
    to_host: Line,
    arm_ear: Deframer,
    /// What the arm accepted into its queue: parameters and index, in order.
    pub(crate) accepted: Vec<(Vec<u8>, u64)>,
    /// Every frame that the arm got whole.
    pub(crate) heard: Vec<FrameBuf>,
    pub(crate) results: HashMap<Ticket, Result<FrameBuf, Failure>>,
    pub(crate) resets: u32,
    pub(crate) unaccounted: u32,
    standing: u32,
    /// The arm hears and does not answer.
    pub(crate) mute: bool,
}

impl Pair {
    pub(crate) fn new(settings: Settings, faults: Faults, seed: u64) -> Self {
        let line = || Line {
            faults,
            under_way: VecDeque::new(),
            latest: 0,
            delay: 1_000,
            lose_next: false,
        };
        Self {
            now: 0,
            host: Connection::new(settings),
            arm: Controller::new(Profile::default()),
            dice: Dice::new(seed),
            booted: 0,
            to_arm: line(),
            to_host: line(),
            arm_ear: Deframer::new(),
            accepted: Vec::new(),
            heard: Vec::new(),
            results: HashMap::new(),
            resets: 0,
            unaccounted: 0,
            standing: 0,
            mute: false,
        }
    }

    pub(crate) fn set_faults(&mut self, faults: Faults) {
        self.to_arm.faults = faults;
        self.to_host.faults = faults;
    }

    pub(crate) fn set_reply_faults(&mut self, faults: Faults) {
        self.to_host.faults = faults;
    }

    /// Every reply takes so long.
    pub(crate) fn delay_replies(&mut self, by: Micros) {
        self.to_host.delay = by;
    }

    pub(crate) fn lose_next_request(&mut self) {
        self.to_arm.lose_next = true;
    }

    pub(crate) fn lose_next_reply(&mut self) {
        self.to_host.lose_next = true;
    }

    /// Switches the arm off and on.
    pub(crate) fn power_cycle(&mut self) {
        self.arm = Controller::new(Profile::default());
        self.booted = self.now;
    }

    /// Puts bytes on the line to the host that the arm never sent.
    pub(crate) fn inject(&mut self, bytes: &[u8]) {
        self.to_host
            .under_way
            .push_back((self.now + 1, bytes.to_vec()));
    }

    fn arm_hears(&mut self, bytes: &[u8]) {
        let mut input = bytes;
        let mut frames = Vec::new();
        while let Some(event) = self.arm_ear.next(&mut input) {
            if let magician_protocol::Event::Frame { frame, .. } = event {
                frames.push(FrameBuf::from(frame));
            }
        }
        // The line fell silent after every write.
        self.arm_ear.expire();
        while let Some(event) = self.arm_ear.next(&mut &[][..]) {
            if let magician_protocol::Event::Frame { frame, .. } = event {
                frames.push(FrameBuf::from(frame));
            }
        }
        for frame in frames {
            self.heard.push(frame);
            self.arm.receive(LinkId(0), frame.bytes());
            while let Some(reply) = self.arm.poll_transmit(LinkId(0)) {
                let view = frame.frame();
                let index = reply.frame().read::<QueuedCmdIndex>();
                if let (true, false, Ok(QueuedCmdIndex(index))) =
                    (view.ctrl().queued(), reply.frame().ctrl().error(), index)
                {
                    self.accepted.push((view.params().to_vec(), index));
                }
                if !self.mute {
                    self.to_host.put(self.now, reply.bytes(), &mut self.dice);
                }
            }
        }
    }

    fn exchange(&mut self) {
        loop {
            let mut quiet = true;
            while let Some(frame) = self.host.poll_transmit(self.now) {
                self.to_arm.put(self.now, frame.bytes(), &mut self.dice);
                quiet = false;
            }
            while let Some(bytes) = self.to_arm.take(self.now) {
                self.arm_hears(&bytes);
                quiet = false;
            }
            while let Some(bytes) = self.to_host.take(self.now) {
                self.host.receive(self.now, &bytes);
                quiet = false;
            }
            while let Some(event) = self.host.poll_event() {
                match event {
                    Event::Done { ticket, result } => {
                        let before = self.results.insert(ticket, result);
                        assert!(before.is_none(), "a ticket comes back once");
                    }
                    Event::Reset => self.resets += 1,
                    Event::Unaccounted { .. } => self.unaccounted += 1,
                }
                quiet = false;
            }
            if quiet {
                return;
            }
        }
    }

    /// Goes to the next instant at which something happens, but not beyond `end`.
    pub(crate) fn step(&mut self, end: Micros) {
        self.exchange();
        let soonest = [
            self.host.poll_timeout(),
            self.arm.poll_timeout().map(|at| at + self.booted),
            self.to_arm.next(),
            self.to_host.next(),
        ];
        let next = soonest.into_iter().flatten().min().unwrap_or(end).min(end);
        self.standing = if next > self.now {
            0
        } else {
            self.standing + 1
        };
        assert!(self.standing < 1000, "time stands still at {next}");
        self.now = next.max(self.now);
        self.arm.advance(self.now - self.booted);
        self.host.handle_timeout(self.now);
        self.exchange();
    }

    pub(crate) fn run_until(&mut self, end: Micros) {
        while self.now < end {
            self.step(end);
        }
    }

    /// Runs until the request has ended; fails when it ends after its deadline.
    pub(crate) fn finish(&mut self, ticket: Ticket, deadline: Micros) -> Result<FrameBuf, Failure> {
        loop {
            if let Some(result) = self.results.remove(&ticket) {
                return result;
            }
            assert!(self.now < deadline, "no end by the deadline {deadline}");
            self.step(deadline);
        }
    }

    /// One request from submission to its end.
    pub(crate) fn ask(&mut self, request: Request, patience: Micros) -> Result<FrameBuf, Failure> {
        let deadline = self.now + patience;
        let ticket = self.host.submit(request.deadline(deadline));
        self.finish(ticket, deadline)
    }
}

pub(crate) fn index_of(frame: &FrameBuf) -> u64 {
    QueuedCmdIndex::decode(frame.frame().params())
        .expect("an index")
        .0
}
