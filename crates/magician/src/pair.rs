//! A host's connection and a virtual arm on one virtual clock, with a line between them that loses, damages, doubles and
//! delays, all from a seed: what reliability is tried with, deterministically and without waiting.

use std::collections::{HashMap, VecDeque};

use crate::connection::{Connection, Event, Failure, Micros, Request, Settings, Ticket};
use magician_protocol::{Deframer, FrameBuf, Layout, QueuedCmdIndex};
use magician_sim::{Controller, LinkId, Profile};

/// A small generator of numbers (xorshift64*), the same on every platform.
pub struct Dice(u64);

impl Dice {
    /// The numbers of this seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// A number from 0 to below `sides`.
    pub fn roll(&mut self, sides: u64) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 16) % sides
    }

    /// True in `per_mille` of a thousand cases.
    pub fn chance(&mut self, per_mille: u64) -> bool {
        self.roll(1000) < per_mille
    }
}

/// What the line does to a frame; chances in per mille.
#[derive(Clone, Copy, Default)]
pub struct Faults {
    /// Frames that come to nothing.
    pub lose: u64,
    /// Frames of which one bit is turned.
    pub damage: u64,
    /// Frames that come twice.
    pub double: u64,
    /// Frames that are late.
    pub late: u64,
    /// A frame that is late is late by up to this many us.
    pub late_by: Micros,
    /// Frames may overtake each other.
    pub reorder: bool,
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

/// The host, the arm, and the line between them.
pub struct Pair {
    /// The clock of all three, us.
    pub now: Micros,
    /// The host's end.
    pub host: Connection,
    /// The virtual arm.
    pub arm: Controller,
    /// Where chance comes from.
    pub dice: Dice,
    /// When the arm was switched on last.
    booted: Micros,
    to_arm: Line,
    to_host: Line,
    arm_ear: Deframer,
    /// What the arm accepted into its queue: parameters and index, in order.
    pub accepted: Vec<(Vec<u8>, u64)>,
    /// Every frame that the arm got whole.
    pub heard: Vec<FrameBuf>,
    /// How requests ended that nobody has fetched with [`finish`](Self::finish).
    pub results: HashMap<Ticket, Result<FrameBuf, Failure>>,
    /// How often the host noticed that the arm was reset.
    pub resets: u32,
    /// How often the host noticed commands that nobody sent, or sent once.
    pub unaccounted: u32,
    standing: u32,
    /// The arm hears and does not answer.
    pub mute: bool,
}

impl Pair {
    /// A host, and an arm that has just been switched on.
    #[must_use]
    pub fn new(settings: Settings, faults: Faults, seed: u64) -> Self {
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

    /// From now on the line does this, both ways.
    pub fn set_faults(&mut self, faults: Faults) {
        self.to_arm.faults = faults;
        self.to_host.faults = faults;
    }

    /// From now on the line does this to what the arm says.
    pub fn set_reply_faults(&mut self, faults: Faults) {
        self.to_host.faults = faults;
    }

    /// Every reply takes so long.
    pub fn delay_replies(&mut self, by: Micros) {
        self.to_host.delay = by;
    }

    /// The next frame to the arm comes to nothing.
    pub fn lose_next_request(&mut self) {
        self.to_arm.lose_next = true;
    }

    /// The next frame from the arm comes to nothing.
    pub fn lose_next_reply(&mut self) {
        self.to_host.lose_next = true;
    }

    /// Switches the arm off and on.
    pub fn power_cycle(&mut self) {
        self.arm = Controller::new(Profile::default());
        self.booted = self.now;
    }

    /// The cable is pulled: what is under way is lost, and the host is told.
    pub fn pull_cable(&mut self) {
        self.to_arm.under_way.clear();
        self.to_host.under_way.clear();
        self.arm_ear = Deframer::new();
        self.host.interrupt();
    }

    /// The cable is back, and the host is told.
    pub fn put_cable_back(&mut self) {
        self.host.restored();
    }

    /// Puts bytes on the line to the host that the arm never sent.
    pub fn inject(&mut self, bytes: &[u8]) {
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
    ///
    /// # Panics
    /// When time stands still.
    pub fn step(&mut self, end: Micros) {
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

    /// Lets time pass.
    pub fn run_until(&mut self, end: Micros) {
        while self.now < end {
            self.step(end);
        }
    }

    /// Runs until the request has ended; fails when it ends after its deadline.
    ///
    /// # Errors
    /// How the request failed.
    ///
    /// # Panics
    /// When it has not ended by the deadline.
    pub fn finish(&mut self, ticket: Ticket, deadline: Micros) -> Result<FrameBuf, Failure> {
        loop {
            if let Some(result) = self.results.remove(&ticket) {
                return result;
            }
            assert!(self.now < deadline, "no end by the deadline {deadline}");
            self.step(deadline);
        }
    }

    /// One request from submission to its end.
    ///
    /// # Errors
    /// How the request failed.
    pub fn ask(&mut self, request: Request, patience: Micros) -> Result<FrameBuf, Failure> {
        let deadline = self.now + patience;
        let ticket = self.host.submit(request.deadline(deadline));
        self.finish(ticket, deadline)
    }
}

/// The index in the answer to a queued command.
///
/// # Panics
/// When there is none.
#[must_use]
pub fn index_of(frame: &FrameBuf) -> u64 {
    QueuedCmdIndex::decode(frame.frame().params())
        .expect("an index")
        .0
}
