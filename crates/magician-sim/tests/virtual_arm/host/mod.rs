//! A hostile host driven by bytes: it sends frames and garbage over several links, lets time pass,
//! falls silent and leaves. The fuzz target, the property tests and the soak run of the example
//! share it.
#![allow(dead_code, unreachable_pub)]

use magician_protocol::{Ctrl, FrameBuf, MAX_PARAMS, TABLE};
use magician_sim::{ArmInstant, Controller, LinkId, Profile};

/// Links in use: more than the controller keeps.
const LINKS: u8 = 70;
/// Upper bound of the events of a full queue: ends, waits, outputs and limits of 32 commands and
/// one immediate motion.
const MOST_EVENTS: u32 = 4_000;
/// Numbers that tend to break programs.
const TELLING: [f32; 16] = [
    0.0,
    -0.0,
    1e-45,
    1e-30,
    1e-4,
    1.0,
    45.0,
    90.0,
    135.0,
    -150.0,
    59.7,
    1e9,
    f32::MAX,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
];

/// Bytes that drive the host, consumed from the front. Once they are used up, zeros follow.
struct Script<'a>(&'a [u8]);

impl Script<'_> {
    fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else {
            return 0;
        };
        self.0 = rest;
        *first
    }

    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        std::array::from_fn(|_| self.byte())
    }

    /// A number: mostly ordinary, sometimes extreme or arbitrary bits.
    fn number(&mut self) -> f32 {
        match self.byte() {
            kind @ 0..=31 => TELLING[usize::from(kind % 16)],
            32..=47 => f32::from_bits(u32::from_le_bytes(self.bytes())),
            48..=127 => f32::from(self.byte() as i8),
            _ => f32::from(i16::from_le_bytes(self.bytes())) / 100.0,
        }
    }

    fn numbers<const N: usize>(&mut self) -> [u8; N] {
        let mut params = [0; N];
        for four in params.chunks_mut(4) {
            let number = self.number().to_le_bytes();
            four.copy_from_slice(&number[..four.len()]);
        }
        params
    }

    fn link(&mut self) -> LinkId {
        match self.byte() {
            byte @ 0..=223 => LinkId(u32::from(byte % 3)),
            byte => LinkId(u32::from(byte.wrapping_mul(37) % LINKS)),
        }
    }
}

/// A run of the hostile host against one arm.
pub struct Life {
    pub arm: Controller,
    /// Number of steps so far.
    pub steps: u64,
    /// Hash of everything visible so far, replies and states, bit for bit.
    pub story: u64,
    /// Longest step by which the clock advances, us.
    piece: u64,
    current: u64,
}

impl Default for Life {
    fn default() -> Self {
        Self {
            arm: Controller::new(Profile::default()),
            steps: 0,
            story: 0,
            piece: u64::MAX,
            current: 0,
        }
    }
}

impl Life {
    /// A run whose clock advances in small steps; its hash must equal that of a default run.
    pub fn in_pieces() -> Self {
        Self {
            piece: 1_234_567,
            ..Self::default()
        }
    }

    /// Executes all steps and checks the arm after each.
    pub fn live(&mut self, script: &[u8]) {
        let mut script = Script(script);
        while !script.0.is_empty() {
            self.step(&mut script);
            self.steps += 1;
            self.check();
        }
    }

    fn step(&mut self, script: &mut Script<'_>) {
        match script.byte() % 20 {
            0 => {
                let (link, count) = (script.link(), usize::from(script.byte() % 64));
                let (bytes, rest) = script.0.split_at(count.min(script.0.len()));
                script.0 = rest;
                self.arm.receive(link, bytes);
            }
            1 => self.pass(u64::from(u16::from_le_bytes(script.bytes()))),
            2 => self.pass(u64::from(u32::from_le_bytes(script.bytes())) % 100_000_000),
            3 => {
                // A motion may outlast the clock, so skip events more than an hour away.
                let near = self.arm.now().after_micros(3_600_000_000);
                if let Some(at) = self.arm.poll_timeout().filter(|at| *at < near) {
                    self.arm.advance(at);
                }
            }
            4 => self.arm.expire(script.link()),
            5 => self.arm.close(script.link()),
            6 => self.drain(script.link()),
            7 => {
                let id = [240, 240, 240, 241, 242, 245, 20, 21, 31][usize::from(script.byte() % 9)];
                self.send(script.link(), id, Ctrl::SET, &[]);
            }
            8..=11 => {
                let ctrl = [Ctrl::QUEUED, Ctrl::QUEUED, Ctrl::SET][usize::from(script.byte() % 3)];
                let mut params = [script.byte() % 11; 17];
                params[1..].copy_from_slice(&script.numbers::<16>());
                self.send(LinkId(0), 84, ctrl, &params);
            }
            12 => {
                let mut params = [0; 61];
                params[0] = script.byte() % 10;
                params[1..17].copy_from_slice(&script.numbers::<16>());
                for (at, byte) in params[17..].iter_mut().enumerate() {
                    let below = [110, 22, 1, 2][at % 4];
                    *byte = script.byte() % below;
                }
                let outputs = usize::from(script.byte() % 12);
                self.send(LinkId(1), 88, Ctrl::QUEUED, &params[..17 + 4 * outputs]);
            }
            13 => {
                let milliseconds = u32::from(u16::from_le_bytes(script.bytes()));
                self.send(LinkId(1), 110, Ctrl::QUEUED, &milliseconds.to_le_bytes());
            }
            14 => {
                // Any command of the table, its parameters filled with up to nine numbers.
                let row = &TABLE[usize::from(script.byte()) % TABLE.len()];
                let size = row.set.and_then(|set| set.size()).unwrap_or(8).min(36);
                let ctrl = [Ctrl::QUEUED, Ctrl::SET][usize::from(script.byte() % 2)];
                let params = script.numbers::<36>();
                self.send(LinkId(2), row.id, ctrl, &params[..size]);
            }
            15 | 16 => {
                // A segment of a path, mostly a short one.
                let mut params = [0; 17];
                params[0] = script.byte() % 3;
                params[1..].copy_from_slice(&script.numbers::<16>());
                if params[0] == 0 {
                    for (at, step) in params[1..13].chunks_mut(4).enumerate() {
                        let step_by = f32::from(script.byte() as i8) / [8.0, 8.0, 16.0][at];
                        step.copy_from_slice(&step_by.to_le_bytes());
                    }
                }
                let (id, ctrl) = (91 + script.byte() % 2, script.byte());
                let ctrl = if ctrl < 32 { Ctrl::SET } else { Ctrl::QUEUED };
                self.send(LinkId(0), id, ctrl, &params);
            }
            17 => {
                let places = [200.0, 0.0, 0.0, 0.0, 200.0, 0.0, 0.0, 0.0];
                let mut params = [0; 36];
                for (four, place) in params.chunks_mut(4).zip(places) {
                    let place: f32 = place + f32::from(script.byte() as i8) / 2.0;
                    four.copy_from_slice(&place.to_le_bytes());
                }
                params[32] = script.byte() % 4;
                let ctrl = [Ctrl::QUEUED, Ctrl::SET][usize::from(script.byte() % 2)];
                match script.byte() % 2 {
                    0 => self.send(LinkId(0), 101, ctrl, &params[..32]),
                    _ => self.send(LinkId(0), 102, ctrl, &params),
                }
            }
            18 => {
                let ctrl = [Ctrl::QUEUED, Ctrl::SET][usize::from(script.byte() % 2)];
                let params = [script.byte() % 2, script.byte() % 12];
                self.send(script.link(), 73, ctrl, &params);
            }
            _ => {
                let [id, ctrl, count] = script.bytes();
                let count = usize::from(count).min(MAX_PARAMS).min(script.0.len());
                let (params, rest) = script.0.split_at(count);
                script.0 = rest;
                self.send(script.link(), id, Ctrl(ctrl), params);
            }
        }
    }

    fn send(&mut self, link: LinkId, id: u8, ctrl: Ctrl, params: &[u8]) {
        if let Ok(frame) = FrameBuf::new(id, ctrl, params) {
            self.arm.receive(link, frame.bytes());
        }
    }

    fn pass(&mut self, span: u64) {
        let to = self.arm.now().after_micros(span);
        while self.arm.now() < to {
            let next = self.arm.now().after_micros(self.piece).min(to);
            self.arm.advance(next);
            assert_eq!(self.arm.now(), next);
        }
    }

    fn tell(&mut self, bits: u64) {
        self.story = (self.story ^ bits)
            .wrapping_mul(0x9E37_79B9_7F4A_7C15)
            .rotate_left(29);
    }

    fn drain(&mut self, link: LinkId) {
        let mut bytes = 0;
        while let Some(reply) = self.arm.poll_transmit(link) {
            bytes += reply.bytes().len();
            reply
                .bytes()
                .iter()
                .for_each(|byte| self.tell(u64::from(*byte)));
        }
        assert!(bytes <= 32 * 1024, "{bytes} bytes of replies");
    }

    fn check(&mut self) {
        let state = self.arm.state();
        let due = self.arm.poll_timeout();
        assert!(
            due.is_none_or(|at| at > state.now),
            "what is due is done: {due:?}, {state:?}"
        );
        assert!(state.joints.is_finite(), "{state:?}");
        let queue = state.queue;
        let taken = queue.waiting + usize::from(queue.running.is_some());
        assert!(taken <= queue.capacity, "{queue:?}");
        assert!(
            queue.current_index >= self.current,
            "the current index falls"
        );
        self.current = queue.current_index;
        let ([x, y, z, r], [j1, j2, j3, j4]) = (state.pose.to_array(), state.joints.to_array());
        for number in [x, y, z, r, j1, j2, j3, j4] {
            self.tell(number.to_bits());
        }
        for code in state.alarms.codes() {
            self.tell(u64::from(code));
        }
        let bits = [
            state.now.as_micros(),
            due.map_or(0, ArmInstant::as_micros),
            queue.current_index,
            taken as u64,
        ];
        bits.into_iter().for_each(|bits| self.tell(bits));
        assert!(queue.running.is_none_or(|index| index > self.current));
        assert!(
            due.is_some()
                || !state.moving && (queue.running.is_none() || state.awaits_input.is_some()),
            "what runs ends, but for a trigger: {state:?}"
        );
    }

    /// Lets everything end and checks that the arm then accepts commands like a new one.
    pub fn end(&mut self) {
        let mut events = 0;
        while let Some(at) = self.arm.poll_timeout() {
            assert!(at > self.arm.now());
            self.arm.advance(at);
            events += 1;
            assert!(
                events <= MOST_EVENTS,
                "no end after {events} events: {:?}",
                self.arm.state()
            );
        }
        assert!((0..=256).contains(&std::iter::from_fn(|| self.arm.poll_event()).count()));
        let link = LinkId(u32::MAX);
        for id in [241, 245, 247] {
            self.send(link, id, Ctrl(u8::from(id != 247)), &[]);
        }
        let replies: Vec<FrameBuf> = std::iter::from_fn(|| self.arm.poll_transmit(link)).collect();
        let [_, clear, left] = &replies[..] else {
            panic!("a reply each, not {replies:?}")
        };
        assert_eq!(clear.frame().params(), [0u8; 0]);
        assert_eq!(left.frame().params(), 32u32.to_le_bytes());
    }
}
