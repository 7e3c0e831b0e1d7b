//! R6 and R7: a hostile arm. Frames of every kind, garbage, silence, replies that are early, late,
//! duplicated and wrong; resets and lost lines. The host must not panic, hang or grow.

use std::error::Error;

use magician::connection::{Connection, Event, Failure, Priority, Request, Settings, Ticket};
use magician::faults::Dice;
use magician::pair::Digest;
use magician::stream::{Stream, StreamSettings};
use magician_protocol::commands::{DeviceTime, Pose, QueuedCmdCurrentIndex, WaitCmd};
use magician_protocol::{BAUD_RATE, Ctrl, FrameBuf, NoArgs};

use super::{Scope, SoakResult, heap, program};
use crate::bench::figure::Figure;

const SECOND: u64 = 1_000_000;
/// Timeout of every request, and of a stream's own requests.
const REQUEST_TIMEOUT: u64 = 5 * SECOND;

/// Host under attack, with its clock.
struct AttackedHost {
    dice: Dice,
    now: u64,
    host: Connection,
    stream: Stream,
    /// Open requests with their deadlines.
    open: Vec<(Ticket, u64)>,
    /// Frames that the host sent and the arm may still answer, newest last.
    sent_frames: Vec<FrameBuf>,
    /// Largest number of own requests that the host has open.
    most: usize,
    index: u64,
    number: u64,
    late: u64,
    ended: u64,
    streams: u64,
    digest: Digest,
}

impl AttackedHost {
    fn new(seed: u64) -> Self {
        let mut dice = Dice::new(seed);
        let settings = match dice.below(4) {
            0 => Settings::DATAGRAMS,
            1 => Settings {
                window: 4,
                baud: Some(BAUD_RATE),
                ..Settings::ORDERED
            },
            _ => Settings::ORDERED,
        };
        Self {
            host: Connection::new(settings),
            stream: stream(&mut dice),
            dice,
            now: 0,
            open: Vec::with_capacity(256),
            sent_frames: Vec::with_capacity(16),
            most: 200,
            index: 1,
            number: 0,
            late: 0,
            ended: 0,
            streams: 1,
            digest: Digest::default(),
        }
    }

    fn step(&mut self) {
        match self.dice.below(16) {
            0..=4 => self.answer(),
            5 => self.send_unsolicited(),
            6..=7 => self.submit(),
            8..=9 => self.offer(),
            10..=13 => self.pass(),
            14 => self.disturb(),
            _ => {
                let cut = self.dice.below(20) as usize;
                let bytes: [u8; 20] = std::array::from_fn(|_| self.dice.byte());
                self.receive(bytes.get(..cut).unwrap_or(&bytes));
            }
        }
        self.exchange();
    }

    fn receive(&mut self, bytes: &[u8]) {
        self.digest.add(self.now, bytes);
        self.host.receive(self.now, bytes);
    }

    /// Sends a reply to one of these frames, more or less correct.
    fn answer(&mut self) {
        let count = self.sent_frames.len() as u64;
        let Some(asked) = self
            .sent_frames
            .get(self.dice.below(count) as usize)
            .copied()
        else {
            return;
        };
        let view = asked.frame();
        let mut params = [0; 64];
        let length = match (view.ctrl().queued(), view.id()) {
            (true, _) | (_, 246) => 8,
            (_, 247 | 4) => 4,
            (_, 10) => 32,
            (_, 20) => 16,
            _ => self.dice.below(40) as usize,
        };
        let number = match view.id() {
            247 => 32 - self.dice.below(3),
            4 => self.now / 1_000,
            246 => self.index.saturating_sub(self.dice.below(3)),
            _ if view.ctrl().queued() => {
                self.index += 1;
                self.index
            }
            _ => 0,
        };
        params[..8].copy_from_slice(&number.to_le_bytes());
        if self.dice.chance(0.1) {
            params[self.dice.below(8) as usize] = self.dice.byte();
        }
        let ctrl = match self.dice.below(20) {
            0 => view.ctrl().with_error(),
            1 => Ctrl(self.dice.byte()),
            _ => view.ctrl(),
        };
        let length = if self.dice.chance(0.02) { 3 } else { length };
        if let Ok(reply) = FrameBuf::new(view.id(), ctrl, &params[..length]) {
            let mut bytes = [0; 300];
            let whole = reply.bytes();
            bytes[..whole.len()].copy_from_slice(whole);
            if self.dice.chance(0.05) {
                bytes[self.dice.below(whole.len() as u64) as usize] = self.dice.byte();
            }
            for _ in 0..=u64::from(self.dice.chance(0.05)) {
                let count = whole.len();
                self.receive(&bytes[..count]);
            }
        }
        if !self.dice.chance(0.3) {
            self.sent_frames
                .retain(|other| other.bytes() != asked.bytes());
        }
    }

    /// Sends an unsolicited frame.
    fn send_unsolicited(&mut self) {
        let mut params = [0; 64];
        params.fill_with(|| self.dice.byte());
        let length = self.dice.below(64) as usize;
        let (id, ctrl) = (self.dice.byte(), Ctrl(self.dice.byte()));
        if let Ok(frame) = FrameBuf::new(id, ctrl, &params[..length]) {
            self.receive(frame.bytes());
        }
    }

    fn submit(&mut self) {
        if self.open.len() >= self.most {
            return;
        }
        self.number += 1;
        let request = match self.dice.below(8) {
            0 => Request::get::<Pose>(&NoArgs),
            1 => Request::get::<QueuedCmdCurrentIndex>(&NoArgs),
            2 => Request::get::<DeviceTime>(&NoArgs),
            3 => Request::queued(&WaitCmd { timeout: 1 }),
            4 => Request::raw(self.dice.byte(), Ctrl(self.dice.byte()), &[1, 2, 3]),
            5 => Request::halt().map(|[stop, _, _]| stop),
            6 => Request::halt().map(|[_, _, clear]| clear),
            _ => Ok(program::request(&program::mixed(self.number)).repeatable()),
        };
        let Ok(request) = request else { return };
        let end = self.now + self.dice.below(REQUEST_TIMEOUT);
        let request = if self.dice.chance(0.02) {
            request.priority(Priority::Stop)
        } else {
            request
        };
        let ticket = self.host.submit(request.deadline(end));
        if self.dice.chance(0.05) {
            self.host.cancel(ticket);
        }
        self.open.push((ticket, end));
    }

    fn offer(&mut self) {
        for _ in 0..self.dice.below(5) {
            self.number += 1;
            self.stream.offer(program::item(self.number)).ok();
        }
    }

    fn pass(&mut self) {
        let due = [self.host.poll_timeout(), self.stream.poll_timeout()];
        let due = due.into_iter().flatten().min();
        let by = match self.dice.below(8) {
            0 => self.dice.below(3 * SECOND),
            1..=3 => self.dice.below(20_000),
            _ => due.unwrap_or(self.now).saturating_sub(self.now),
        };
        self.now += by.min(10 * SECOND);
        self.host.handle_timeout(self.now);
    }

    /// Loses and restores the line, resets the arm, or ends the stream.
    fn disturb(&mut self) {
        match self.dice.below(40) {
            0 => {
                self.stream.interrupt(Failure::Lost);
                self.host.interrupt();
                self.sent_frames.clear();
            }
            1..=20 => self.host.restored(),
            21 => self.index = 0,
            22 => self.stream.finish(),
            _ => {}
        }
    }

    /// Exchanges frames and events with the host after every call, as the I/O layer of a connection
    /// does.
    fn exchange(&mut self) {
        for _ in 0..64 {
            self.stream.advance(self.now, &mut self.host);
            let mut quiet = true;
            while let Some(frame) = self.host.poll_transmit(self.now) {
                self.digest.add(self.now, frame.bytes());
                if self.sent_frames.len() == self.sent_frames.capacity() {
                    self.sent_frames.remove(0);
                }
                self.sent_frames.push(frame);
                quiet = false;
            }
            while let Some(event) = self.host.poll_event() {
                self.note_event(event);
                quiet = false;
            }
            while self.stream.poll_event().is_some() {}
            if quiet {
                break;
            }
        }
        // Overdue requests are counted after time has passed.
        let now = self.now;
        self.late += self.open.iter().filter(|(_, end)| *end + 1 < now).count() as u64;
        if self.stream.is_over() {
            let leftover = std::mem::replace(&mut self.stream, stream(&mut self.dice)).leftover();
            self.streams += 1;
            if self.dice.chance(0.7) && leftover.len() < 40 {
                self.stream = Stream::resume(leftover, StreamSettings::default());
            }
        }
    }

    fn note_event(&mut self, event: Event) {
        match event {
            Event::Done { ticket, result } => {
                if let Some(at) = self.open.iter().position(|(open, _)| *open == ticket) {
                    self.open.swap_remove(at);
                    self.ended += 1;
                } else {
                    (self.stream).answered(self.now, ticket, &result, &mut self.host);
                }
            }
            Event::Reset => self.stream.reset(),
            Event::Unaccounted { .. } => {}
            #[cfg(not(magician_workspace))]
            _ => unreachable!(),
        }
    }
}

fn stream(dice: &mut Dice) -> Stream {
    Stream::new(StreamSettings {
        window: 1 + dice.below(4) as usize,
        start: dice.chance(0.8),
        trust_pose: dice.chance(0.5),
        ..StreamSettings::default()
    })
}

/// R6: sessions of some thousand steps each.
pub(super) fn sessions(scope: Scope) -> Result<SoakResult, Box<dyn Error>> {
    // Steps of a session. A choice: long enough to fill the host's queues, short enough for many
    // fresh hosts.
    const STEPS_PER_SESSION: u64 = 5_000;
    let (mut late, mut ended, mut streams, mut open) = (0, 0, 0, 0);
    let mut digest = Digest::default();
    for life in 0..scope.cases.div_ceil(STEPS_PER_SESSION) {
        let mut attacked = AttackedHost::new(scope.seed.wrapping_mul(1_000_003).wrapping_add(life));
        for _ in 0..STEPS_PER_SESSION {
            attacked.step();
        }
        // Without further attacks everything must end.
        let end = attacked.now + 2 * REQUEST_TIMEOUT;
        while attacked.now < end {
            attacked.now += 10_000;
            attacked.pass();
            attacked.exchange();
        }
        (late, ended) = (late + attacked.late, ended + attacked.ended);
        streams += attacked.streams;
        open += attacked.open.len() as u64;
        digest.add(attacked.now, &attacked.digest.0.to_le_bytes());
    }
    Ok(SoakResult {
        figures: vec![
            Figure::new(
                "steps",
                (scope.cases.div_ceil(STEPS_PER_SESSION) * STEPS_PER_SESSION) as f64,
                "",
            ),
            Figure::new("requests that ended", ended as f64, ""),
            Figure::new("streams", streams as f64, ""),
            Figure::new("requests beyond their deadline", late as f64, "").at_most(0.0),
            Figure::new("requests that never ended", open as f64, "").at_most(0.0),
        ],
        digest: Some(digest.0),
    })
}

/// R7: one session over this many seconds of its time. Measures its largest memory.
pub(super) fn memory(scope: Scope) -> Result<SoakResult, Box<dyn Error>> {
    let before = heap::in_use();
    let mut attacked = Box::new(AttackedHost::new(scope.seed));
    // Memory of the test itself, which does not count.
    let own = attacked.open.capacity() * size_of::<(Ticket, u64)>()
        + attacked.sent_frames.capacity() * size_of::<FrameBuf>();
    // The number that a driver keeps open.
    attacked.most = 8;
    let (mut most, mut steps) = (0, 0_u64);
    let inline = size_of::<AttackedHost>();
    while attacked.now < scope.cases * SECOND {
        attacked.step();
        steps += 1;
        most = most.max(heap::in_use().saturating_sub(before));
    }
    let session = most.saturating_sub(own) as f64 / 1024.0;
    Ok(SoakResult {
        figures: vec![
            Figure::new("steps", steps as f64, ""),
            Figure::new(
                "hours of the session's time",
                attacked.now as f64 / 3.6e9,
                "h",
            ),
            Figure::new("memory at most", session, "KiB")
                .with("of which inline", inline as f64 / 1024.0)
                .at_most(64.0),
        ],
        digest: Some(attacked.digest.0),
    })
}
