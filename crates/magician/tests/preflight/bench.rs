//! Virtual arm in virtual time, and random numbers from a seed.

use magician::preflight::Readings;
use magician::protocol::{FrameBuf, NoArgs, Readable, Writable};
use magician::sim::{ArmInstant, Controller, LinkId, Profile};
use magician::{Ctrl, Set};

const LINK: LinkId = LinkId(0);

/// Virtual arm without a driver.
#[derive(Clone)]
pub(crate) struct LoneArm {
    pub(crate) arm: Controller,
    pub(crate) now: ArmInstant,
}

impl LoneArm {
    pub(crate) fn new() -> Self {
        Self::with(Profile::default())
    }

    pub(crate) fn with(firmware: Profile) -> Self {
        Self {
            arm: Controller::new(firmware),
            now: ArmInstant::ZERO,
        }
    }

    fn ask(&mut self, frame: &FrameBuf) -> FrameBuf {
        self.arm.exchange(LINK, frame.bytes()).remove(0)
    }

    pub(crate) fn get<T: Readable<Query = NoArgs>>(&mut self) -> T {
        self.get_with(&NoArgs)
    }

    pub(crate) fn get_with<T: Readable>(&mut self, query: &T::Query) -> T {
        let reply = self.ask(&FrameBuf::get(query, T::ROW).unwrap());
        T::decode(reply.frame().params()).unwrap()
    }

    /// Sets a value at once, and waits until nothing is pending.
    pub(crate) fn set<T: Writable>(&mut self, value: &T) {
        self.ask(&FrameBuf::encode(T::ROW.id, Ctrl::SET, value).unwrap());
        while self.pass() {}
    }

    pub(crate) fn enqueue(&mut self, command: &Set) {
        self.ask(&FrameBuf::set(command, Ctrl::QUEUED).unwrap());
    }

    /// Advances time to the next event, if there is one.
    pub(crate) fn pass(&mut self) -> bool {
        let next = self.arm.poll_timeout();
        if let Some(at) = next {
            self.now = at.max(self.now);
            self.arm.advance(self.now);
        }
        next.is_some()
    }

    /// Runs one command through the queue to its end, or to an alarm; returns the time it took.
    pub(crate) fn run(&mut self, command: &Set) -> u64 {
        let begun = self.now;
        let index = self.arm.state().queue.current_index + 1;
        self.enqueue(command);
        while self.arm.state().queue.current_index < index && self.pass() {}
        self.now.micros_since(begun)
    }

    /// Runs a program with a full queue; returns the time it took.
    pub(crate) fn run_all(&mut self, program: &[Set]) -> u64 {
        let begun = self.now;
        let mut rest = program.iter();
        // The first index is 2.
        let last = self.arm.state().queue.current_index.max(1) + program.len() as u64;
        while self.arm.state().queue.current_index < last {
            let queue = self.arm.state().queue;
            let taken = queue.waiting + usize::from(queue.running.is_some());
            for command in rest.by_ref().take(queue.capacity - taken) {
                self.enqueue(command);
            }
            // A start in the middle of a motion would cut it off.
            if !queue.started {
                self.start();
            }
            // Commands that take no time are finished by now.
            if self.arm.state().queue.current_index < last && !self.pass() {
                break;
            }
        }
        self.now.micros_since(begun)
    }

    pub(crate) fn start(&mut self) {
        self.set_now(&magician::commands::QueuedCmdStartExec {});
    }

    /// Sets a value at once.
    pub(crate) fn set_now<T: Writable>(&mut self, value: &T) {
        self.ask(&FrameBuf::encode(T::ROW.id, Ctrl::SET, value).unwrap());
    }

    pub(crate) fn alarmed(&self) -> bool {
        self.arm.state().alarms.blocking()
    }

    /// Reads everything that a program reads of an arm first.
    pub(crate) fn readings(&mut self) -> Readings {
        let mut read = Readings::default();
        read.pose = Some(self.get());
        read.settings.tool = self.get();
        read.laser = self.get();
        read.home = Some(self.get());
        read.settings.ptp_joint = self.get();
        read.settings.ptp_coordinate = self.get();
        read.settings.ptp_common = self.get();
        read.settings.ptp_jump2 = self.get();
        read.settings.cp = self.get();
        read.settings.rail_setting.with_l = self.get::<magician::commands::DeviceWithL>().with_l;
        read.rail = Some(self.get::<magician::commands::PoseL>().pose_l);
        read.settings.ptp_rail = self.get();
        read
    }
}

/// Random numbers from a seed, the same on all platforms (xorshift64*).
pub(crate) struct Dice(u64);

impl Dice {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// Returns a number from 0 to below `sides`.
    pub(crate) fn roll(&mut self, sides: u64) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 16) % sides
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.roll(1 << 32) as f64 / (1u64 << 32) as f64
    }

    pub(crate) fn number(&mut self, low: f32, high: f32) -> f32 {
        self.between(low.into(), high.into()) as f32
    }

    pub(crate) fn numbers<const N: usize>(&mut self, ranges: [(f32, f32); N]) -> [f32; N] {
        ranges.map(|(low, high)| self.number(low, high))
    }
}
