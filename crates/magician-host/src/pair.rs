//! A connection of the host and a virtual arm on one virtual clock, with a faulty line between
//! them, all from a seed.
//!
//! Reliability tests run on it deterministically and without waiting: hours of a bad line take
//! seconds, and a failure is repeated by its seed.

use std::collections::{HashMap, VecDeque};

use crate::connection::{Connection, Event, Failure, Micros, Request, Settings, Ticket};
pub use crate::faults::{Dice, Faults};
use crate::faults::{Injector, Passed, Side};
use magician_protocol::commands::{QueuedCmdClear, QueuedCmdStartExec};
use magician_protocol::{
    Deframer, FrameBuf, INTER_BYTE_TIMEOUT_MS, Layout, QueuedCmdIndex, Writable,
};
use magician_sim::{ArmInstant, Controller, LinkId, Profile};

/// Single direction of the line: faults, then a delay.
struct Line {
    injector: Injector,
    under_way: VecDeque<(Micros, Vec<u8>)>,
    delay: Micros,
    lose_next: bool,
}

impl Line {
    fn new(faults: Faults, seed: u64) -> Self {
        Self {
            injector: Injector::new(faults, seed),
            under_way: VecDeque::new(),
            // A millisecond each way, about what a real line adds.
            delay: 1_000,
            lose_next: false,
        }
    }

    /// Sets the faults from now on. Bytes under way arrive as before.
    fn set_faults(&mut self, now: Micros, faults: Faults, seed: u64) {
        let mut old = std::mem::replace(&mut self.injector, Injector::new(faults, seed));
        while let Some(at) = old.poll_timeout() {
            if let Some(Passed::Bytes(bytes)) = old.poll(at) {
                self.under_way.push_back((at.max(now) + self.delay, bytes));
            }
        }
    }

    fn put(&mut self, now: Micros, frame: &[u8]) {
        if !std::mem::take(&mut self.lose_next) {
            self.injector.push(now, frame);
        }
    }

    /// Returns bytes that have passed, or another event of the line. `None` if there is nothing.
    fn take(&mut self, now: Micros) -> Option<Passed> {
        while let Some(passed) = self.injector.poll(now) {
            match passed {
                Passed::Bytes(bytes) => self.under_way.push_back((now + self.delay, bytes)),
                other => return Some(other),
            }
        }
        // Not only the first: after a change of faults or delays, later bytes may be due earlier.
        let at = self.under_way.iter().position(|(at, _)| *at <= now)?;
        let (_, bytes) = self.under_way.remove(at)?;
        Some(Passed::Bytes(bytes))
    }

    fn next(&self) -> Option<Micros> {
        let delayed = self.under_way.iter().map(|(at, _)| *at);
        delayed.chain(self.injector.poll_timeout()).min()
    }

    fn clear(&mut self) {
        self.under_way.clear();
        self.injector.plug_in();
    }
}

/// Hash of everything that passed (FNV-1a), to compare runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digest(pub u64);

impl Default for Digest {
    fn default() -> Self {
        Self(0xCBF2_9CE4_8422_2325)
    }
}

impl Digest {
    /// Adds bytes that passed at `now`.
    pub fn add(&mut self, now: Micros, bytes: &[u8]) {
        for byte in now.to_le_bytes().iter().chain(bytes) {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01B3);
        }
    }
}

/// Host, arm, and the line between them.
pub struct Pair {
    /// Clock of all three, us.
    pub now: Micros,
    /// Connection of the host.
    pub host: Connection,
    /// The virtual arm.
    pub arm: Controller,
    profile: Profile,
    /// Source of random numbers.
    pub dice: Dice,
    /// Instant of the arm's last power-up.
    booted: Micros,
    to_arm: Line,
    to_host: Line,
    arm_ear: Deframer,
    /// Instant at which the arm last received bytes.
    arm_heard: Micros,
    /// True if the plug is out: pulled by a test, or by a fault that the host was not notified of
    /// yet.
    pub unplugged: bool,
    /// Number of power cycles of the arm.
    pub boots: u32,
    /// Commands accepted into the arm's queue: parameters and index, in order.
    pub accepted: Vec<(Vec<u8>, u64)>,
    /// Frames that the arm received whole.
    pub heard: Vec<FrameBuf>,
    /// Number of starts and clears of the queue during motion; each may end the motion (model
    /// section 14).
    pub cuts: u32,
    /// Results of requests that were not fetched with [`finish`](Self::finish) yet.
    pub results: HashMap<Ticket, Result<FrameBuf, Failure>>,
    /// Number of resets that the host noticed.
    pub resets: u32,
    /// Number of [`Event::Unaccounted`]: times that the host noticed commands in the queue that it
    /// had not sent, or second copies of its own.
    pub unaccounted: u32,
    /// First and last index of each [`Event::Unaccounted`], until a test takes them.
    pub reports: Vec<(u64, u64)>,
    standing: u32,
    /// Hash of all bytes that the host sent and received, with their times: equal for equal seeds.
    pub digest: Digest,
    /// True if the arm executes commands but does not reply.
    pub mute: bool,
}

impl Pair {
    /// Creates a host and an arm that was just switched on.
    #[must_use]
    pub fn new(settings: Settings, faults: Faults, seed: u64) -> Self {
        let mut dice = Dice::new(seed);
        Self {
            now: 0,
            host: Connection::new(settings),
            arm: Controller::new(Profile::default()),
            profile: Profile::default(),
            booted: 0,
            to_arm: Line::new(faults.on(Side::Requests), dice.number()),
            to_host: Line::new(faults.on(Side::Replies), dice.number()),
            dice,
            arm_ear: Deframer::new(),
            arm_heard: 0,
            unplugged: false,
            boots: 0,
            accepted: Vec::new(),
            heard: Vec::new(),
            cuts: 0,
            results: HashMap::new(),
            resets: 0,
            unaccounted: 0,
            reports: Vec::new(),
            standing: 0,
            digest: Digest::default(),
            mute: false,
        }
    }

    /// Replaces the arm by another, which gives this index to its first queued command. Real arms
    /// were seen to begin with 2.
    #[cfg(test)]
    pub(crate) fn count_from(&mut self, first: u64) {
        self.profile.queue.first_index = first;
        self.arm = Controller::new(self.profile.clone());
    }

    /// Sets the faults of both directions from now on.
    pub fn set_faults(&mut self, faults: Faults) {
        let seed = self.dice.number();
        (self.to_arm).set_faults(self.now, faults.on(Side::Requests), seed);
        self.set_reply_faults(faults);
    }

    /// Sets the faults of the arm's replies from now on.
    pub(crate) fn set_reply_faults(&mut self, faults: Faults) {
        let seed = self.dice.number();
        (self.to_host).set_faults(self.now, faults.on(Side::Replies), seed);
    }

    /// Delays every reply by this time.
    #[cfg(test)]
    pub(crate) fn delay_replies(&mut self, by: Micros) {
        self.to_host.delay = by;
    }

    /// Loses the next frame to the arm.
    #[cfg(test)]
    pub(crate) fn lose_next_request(&mut self) {
        self.to_arm.lose_next = true;
    }

    /// Loses the next frame from the arm.
    #[cfg(test)]
    pub(crate) fn lose_next_reply(&mut self) {
        self.to_host.lose_next = true;
    }

    /// Breaks the line: everything under way on it is lost.
    pub fn cut(&mut self) {
        self.to_arm.clear();
        self.to_host.clear();
    }

    /// Switches the arm off and on.
    pub fn power_cycle(&mut self) {
        self.arm = Controller::new(self.profile.clone());
        self.booted = self.now;
        // Settings, queue and indices start anew, and so does the deframer at the arm's end.
        self.boots += 1;
        self.arm_ear = Deframer::new();
    }

    /// Pulls the cable and notifies the host. Everything under way is lost.
    #[cfg(test)]
    pub(crate) fn pull_cable(&mut self) {
        self.unplug();
        self.host.interrupt();
    }

    fn unplug(&mut self) {
        self.cut();
        self.unplugged = true;
        self.arm_ear = Deframer::new();
    }

    /// Reconnects the cable and notifies the host.
    pub fn put_cable_back(&mut self) {
        self.cut();
        self.unplugged = false;
        self.host.restored();
    }

    /// Puts bytes on the line to the host that the arm did not send.
    pub fn inject(&mut self, bytes: &[u8]) {
        self.to_host
            .under_way
            .push_back((self.now + 1, bytes.to_vec()));
    }

    fn arm_hears(&mut self, bytes: &[u8]) {
        let mut input = bytes;
        self.arm_heard = self.now;
        while let Some(event) = self.arm_ear.next(&mut input) {
            let magician_protocol::Event::Frame { frame, .. } = event else {
                continue;
            };
            let frame = FrameBuf::from(frame);
            self.heard.push(frame);
            let steers = [QueuedCmdStartExec::ROW.id, QueuedCmdClear::ROW.id];
            let cuts = steers.contains(&frame.frame().id()) && self.arm.state().moving;
            self.cuts += u32::from(cuts);
            for reply in self.arm.exchange(LinkId(0), frame.bytes()) {
                self.arm_says(&frame, &reply);
            }
        }
    }

    fn arm_says(&mut self, request: &FrameBuf, reply: &FrameBuf) {
        let view = request.frame();
        let index = reply.frame().read::<QueuedCmdIndex>();
        if let (true, false, Ok(QueuedCmdIndex(index))) =
            (view.ctrl().queued(), reply.frame().ctrl().error(), index)
        {
            self.accepted.push((view.params().to_vec(), index));
        }
        // A command that was executed but not answered is the hardest case for a host.
        if !self.mute && !self.unplugged {
            self.to_host.put(self.now, reply.bytes());
        }
    }

    /// Time of the arm's clock, which starts at 0 at power-up.
    fn arm_clock(&self) -> ArmInstant {
        ArmInstant::from_micros(self.now - self.booted)
    }

    /// Time of the host's clock at an instant of the arm's clock.
    fn host_clock(&self, at: ArmInstant) -> Micros {
        self.booted + at.as_micros()
    }

    /// Instant at which a partial frame at the arm expires. `None` without a partial frame.
    fn arm_expires(&self) -> Option<Micros> {
        let pending = self.arm_ear.pending();
        pending.then_some(self.arm_heard + INTER_BYTE_TIMEOUT_MS * 1000)
    }

    fn exchange(&mut self) {
        loop {
            let mut quiet = true;
            while let Some(frame) = self.host.poll_transmit(self.now) {
                self.digest.add(self.now, frame.bytes());
                if !self.unplugged {
                    self.to_arm.put(self.now, frame.bytes());
                }
                quiet = false;
            }
            while let Some(passed) = self.to_arm.take(self.now) {
                match passed {
                    Passed::Bytes(bytes) => self.arm_hears(&bytes),
                    Passed::Unplugged => self.unplug(),
                    Passed::Reset => self.power_cycle(),
                }
                quiet = false;
            }
            while let Some(passed) = self.to_host.take(self.now) {
                match passed {
                    Passed::Bytes(bytes) => {
                        self.digest.add(self.now, &bytes);
                        self.host.receive(self.now, &bytes);
                    }
                    Passed::Unplugged => self.unplug(),
                    Passed::Reset => self.power_cycle(),
                }
                quiet = false;
            }
            while let Some(event) = self.host.poll_event() {
                match event {
                    Event::Done { ticket, result } => {
                        // A second result would hide the first, so it is an error of the
                        // connection.
                        let before = self.results.insert(ticket, result);
                        assert!(before.is_none(), "a ticket comes back once");
                    }
                    Event::Reset => self.resets += 1,
                    Event::Unaccounted { from, to } => {
                        self.unaccounted += 1;
                        self.reports.push((from, to));
                    }
                }
                quiet = false;
            }
            if quiet {
                return;
            }
        }
    }

    /// Advances to the next event, but not beyond `end`.
    ///
    /// # Panics
    /// If time does not advance any more.
    pub fn step(&mut self, end: Micros) {
        self.exchange();
        let soonest = [
            self.host.poll_timeout(),
            self.arm.poll_timeout().map(|at| self.host_clock(at)),
            self.to_arm.next(),
            self.to_host.next(),
            self.arm_expires(),
        ];
        let next = soonest.into_iter().flatten().min().unwrap_or(end).min(end);
        self.standing = if next > self.now {
            0
        } else {
            self.standing + 1
        };
        // A thousand steps without progress are a loop of events that cause each other.
        assert!(self.standing < 1000, "time stands still at {next}");
        self.now = next.max(self.now);
        // Time first, then bytes and timers, as for a real arm.
        self.arm.advance(self.arm_clock());
        // The arm, too, drops a partial frame after a silence (errata E04).
        if self.arm_expires().is_some_and(|at| at <= self.now) {
            self.arm_ear.expire();
            self.arm_hears(&[]);
        }
        self.host.handle_timeout(self.now);
        self.exchange();
    }

    /// Advances to `end`.
    pub fn run_until(&mut self, end: Micros) {
        while self.now < end {
            self.step(end);
        }
    }

    /// Runs until the request has ended.
    ///
    /// # Errors
    /// The failure of the request.
    ///
    /// # Panics
    /// If the request has not ended by the deadline.
    pub fn finish(&mut self, ticket: Ticket, deadline: Micros) -> Result<FrameBuf, Failure> {
        loop {
            if let Some(result) = self.results.remove(&ticket) {
                return result;
            }
            assert!(self.now < deadline, "no end by the deadline {deadline}");
            self.step(deadline);
        }
    }

    /// Submits a request and runs until it has ended.
    ///
    /// # Errors
    /// The failure of the request.
    pub fn ask(&mut self, request: Request, patience: Micros) -> Result<FrameBuf, Failure> {
        let deadline = self.now + patience;
        let ticket = self.host.submit(request.deadline(deadline));
        self.finish(ticket, deadline)
    }
}

/// Index in the reply to a queued command.
///
/// # Panics
/// If the reply has no index.
#[must_use]
pub fn index_of(frame: &FrameBuf) -> u64 {
    QueuedCmdIndex::decode(frame.frame().params())
        .expect("an index")
        .0
}
