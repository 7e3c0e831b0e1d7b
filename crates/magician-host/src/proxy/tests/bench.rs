//! A proxy, a virtual arm and clients on one virtual clock.

use std::collections::{BTreeMap, VecDeque};

use magician_protocol::commands::{IoDo, JogCmd, PtpCommonParams};
use magician_protocol::{Ctrl, Deframer, Flag, FrameBuf, JogCommand, Readable, Writable};
use magician_sim::{ArmInstant, Controller, LinkId, Profile};

use super::super::{Client, Event, Proxy, Settings};
use crate::connection::Micros;
use crate::pair::Dice;

pub(super) const MS: Micros = 1_000;
pub(super) const USB: LinkId = LinkId(0);

/// Faults of the line to the arm.
#[derive(Clone, Copy)]
pub(super) struct Faults {
    /// Frames lost, per mille, in each direction.
    pub(super) lose: u64,
    /// Replies delayed, per mille, and the longest delay.
    pub(super) late: (u64, Micros),
}

pub(super) const NONE: Faults = Faults {
    lose: 0,
    late: (0, 0),
};

/// The proxy between an arm and its clients.
pub(super) struct ProxyRig {
    pub(super) now: Micros,
    pub(super) proxy: Proxy,
    pub(super) arm: Controller,
    pub(super) dice: Dice,
    pub(super) faults: Faults,
    pub(super) to_arm: VecDeque<(Micros, Vec<u8>)>,
    pub(super) from_arm: VecDeque<(Micros, Vec<u8>)>,
    /// All frames sent to the arm.
    pub(super) sent: Vec<FrameBuf>,
    pub(super) events: Vec<Event>,
    pub(super) inboxes: BTreeMap<Client, VecDeque<FrameBuf>>,
}

impl ProxyRig {
    pub(super) fn new(settings: Settings, faults: Faults, seed: u64) -> Self {
        Self {
            now: 0,
            proxy: Proxy::new(settings),
            arm: Controller::new(Profile::default()),
            dice: Dice::new(seed),
            faults,
            to_arm: VecDeque::new(),
            from_arm: VecDeque::new(),
            sent: Vec::new(),
            events: Vec::new(),
            inboxes: BTreeMap::new(),
        }
    }

    pub(super) fn with_clients(count: u32) -> Self {
        let mut bench = Self::new(Settings::default(), NONE, 1);
        (0..count).for_each(|number| bench.open(number));
        bench
    }

    pub(super) fn open(&mut self, number: u32) {
        self.proxy.open(Client(number));
        self.inboxes.insert(Client(number), VecDeque::new());
    }

    pub(super) fn close(&mut self, number: u32) {
        self.proxy.close(Client(number));
        self.exchange();
    }

    pub(super) fn say(&mut self, number: u32, frame: &FrameBuf) {
        self.proxy.receive(self.now, Client(number), frame.bytes());
        self.exchange();
    }

    pub(super) fn exchange(&mut self) {
        loop {
            let mut quiet = true;
            while let Some(bytes) = self.proxy.poll_transmit_to_arm(self.now) {
                self.put(bytes.bytes());
                quiet = false;
            }
            for (client, inbox) in &mut self.inboxes {
                while let Some(frame) = self.proxy.poll_transmit(*client) {
                    inbox.push_back(frame);
                    quiet = false;
                }
            }
            self.events
                .extend(std::iter::from_fn(|| self.proxy.poll_event()));
            if due(&self.to_arm, self.now)
                && let Some((_, bytes)) = self.to_arm.pop_front()
            {
                self.arm_hears(&bytes);
                quiet = false;
            }
            if due(&self.from_arm, self.now)
                && let Some((_, bytes)) = self.from_arm.pop_front()
            {
                self.proxy.receive_from_arm(self.now, &bytes);
                quiet = false;
            }
            if quiet {
                return;
            }
        }
    }

    pub(super) fn put(&mut self, bytes: &[u8]) {
        let mut input = bytes;
        if let Some(magician_protocol::Event::Frame { frame, .. }) =
            Deframer::new().next(&mut input)
        {
            self.sent.push(FrameBuf::from(frame));
        }
        if self.dice.below(1000) >= self.faults.lose {
            self.to_arm.push_back((self.now + MS, bytes.to_vec()));
        }
    }

    pub(super) fn arm_hears(&mut self, bytes: &[u8]) {
        for reply in self.arm.exchange(USB, bytes) {
            let (late, by) = self.faults.late;
            let late = if self.dice.below(1000) < late {
                self.dice.below(by)
            } else {
                0
            };
            // An ordered line: a late frame delays those behind it.
            let last = self.from_arm.back().map_or(0, |(at, _)| *at);
            let at = (self.now + MS + late).max(last);
            if self.dice.below(1000) >= self.faults.lose {
                self.from_arm.push_back((at, reply.bytes().to_vec()));
            }
        }
    }

    /// Advances to the next event, but not beyond `end`.
    pub(super) fn step(&mut self, end: Micros) {
        let lines = [&self.to_arm, &self.from_arm];
        let arrivals = lines.into_iter().filter_map(|line| line.front());
        let next = arrivals.map(|(at, _)| *at).chain(self.proxy.poll_timeout());
        self.now = next.chain([end]).min().unwrap_or(end).clamp(self.now, end);
        self.arm.advance(ArmInstant::from_micros(self.now));
        self.proxy.handle_timeout(self.now);
        self.exchange();
    }

    pub(super) fn run_until(&mut self, end: Micros) {
        let mut steps = 0;
        while self.now < end {
            self.step(end);
            steps += 1;
            assert!(steps < 1_000_000, "time stands still at {}", self.now);
        }
    }

    pub(super) fn run_for(&mut self, time: Micros) {
        self.run_until(self.now + time);
    }

    /// Frames that a client has received since the last call.
    pub(super) fn received(&mut self, number: u32) -> Vec<FrameBuf> {
        let inbox = self.inboxes.get_mut(&Client(number));
        inbox.map_or_else(Vec::new, |inbox| inbox.drain(..).collect())
    }

    /// Sends a request and waits for the reply.
    pub(super) fn ask(&mut self, number: u32, frame: &FrameBuf) -> FrameBuf {
        self.say(number, frame);
        self.run_for(50 * MS);
        let mut received = self.received(number);
        assert_eq!(received.len(), 1, "one answer");
        received.remove(0)
    }

    pub(super) fn ids_sent(&self) -> Vec<u8> {
        self.sent.iter().map(|frame| frame.frame().id()).collect()
    }
}

pub(super) fn due(line: &VecDeque<(Micros, Vec<u8>)>, now: Micros) -> bool {
    line.front().is_some_and(|(at, _)| *at <= now)
}

pub(super) fn get<T: Readable>() -> FrameBuf {
    FrameBuf::new(T::ROW.id, Ctrl::GET, &[]).unwrap()
}

pub(super) fn set<T: Writable>(value: &T) -> FrameBuf {
    FrameBuf::encode(T::ROW.id, Ctrl::SET, value).unwrap()
}

pub(super) fn get_output(pin: u8) -> FrameBuf {
    FrameBuf::new(<IoDo as Readable>::ROW.id, Ctrl::GET, &[pin]).unwrap()
}

pub(super) fn ratio(percent: f32) -> FrameBuf {
    set(&PtpCommonParams {
        velocity_ratio: percent,
        acceleration_ratio: percent,
    })
}

pub(super) fn jog(cmd: JogCommand) -> FrameBuf {
    let is_joint = Flag::OFF;
    set(&JogCmd { is_joint, cmd })
}
