//! Streams of short segments over a line of 115200 baud, simulated to the byte in virtual time,
//! with a host that pauses.
//!
//! The virtual arm slows down when its queue gets short, because it must be able to stop at the
//! end. These tests use an arm that does not: every segment takes its time, whatever follows.

use std::collections::VecDeque;

use magician_protocol::commands::{
    CpCmd, Pose, QueuedCmdCurrentIndex, QueuedCmdLeftSpace, QueuedCmdStartExec,
};
use magician_protocol::{CpMode, Ctrl, FrameBuf, QueuedCmdIndex, Readable, Writable};

use super::rig::SECOND;
use crate::connection::{Connection, Event, Micros, Settings};
use crate::stream::{Item, Stream, StreamEvent, StreamSettings};

const PLACES: u64 = 32;
/// Time from the last byte of a request to the first of its reply, us.
const TURNAROUND: Micros = 1_000;

/// Frames that travel in one direction of the line.
#[derive(Default)]
struct Wire {
    /// Instant at which it is free, ns.
    free: u64,
    under_way: VecDeque<(Micros, FrameBuf)>,
}

impl Wire {
    fn put(&mut self, from: Micros, frame: FrameBuf) {
        let bytes = frame.bytes().len() as u64;
        self.free = self.free.max(from * 1000) + bytes * 10_000_000_000 / 115_200;
        self.under_way.push_back((self.free.div_ceil(1000), frame));
    }

    fn next(&self) -> Micros {
        self.under_way.front().map_or(Micros::MAX, |(at, _)| *at)
    }

    fn take(&mut self, now: Micros) -> Option<FrameBuf> {
        if self.next() > now {
            return None;
        }
        self.under_way.pop_front().map(|(_, frame)| frame)
    }
}

/// A queue in which every command takes the same time.
#[derive(Default)]
struct Arm {
    each: Micros,
    given: u64,
    current: u64,
    started: bool,
    /// Instant at which the current command ends, or the last one ended.
    until: Micros,
    /// Time without work between commands.
    dry: Micros,
}

impl Arm {
    fn advance(&mut self, now: Micros) {
        while self.started && self.current < self.given && self.until <= now {
            self.current += 1;
            self.until += self.each * u64::from(self.current < self.given);
        }
    }

    fn accept(&mut self, now: Micros) -> QueuedCmdIndex {
        if self.current == self.given && self.started {
            // The time before the first command is no gap.
            self.dry += now.saturating_sub(self.until) * u64::from(self.given > 0);
            self.until = now + self.each;
        }
        self.given += 1;
        assert!(self.given - self.current <= PLACES, "the queue is full");
        QueuedCmdIndex(self.given)
    }

    fn answer(&mut self, now: Micros, request: &FrameBuf) -> FrameBuf {
        self.advance(now);
        let (id, ctrl) = (request.frame().id(), request.frame().ctrl());
        let current = QueuedCmdCurrentIndex {
            queued_cmd_current_index: self.current,
        };
        let left = QueuedCmdLeftSpace {
            left_space: (PLACES - (self.given - self.current)) as u32,
        };
        let reply = match (id, ctrl) {
            (id, Ctrl::QUEUED) => FrameBuf::encode(id, ctrl, &self.accept(now)),
            (id, Ctrl::GET) if id == <Pose as Readable>::ROW.id => {
                FrameBuf::new(id, ctrl, &[0; 32])
            }
            (id, Ctrl::GET) if id == QueuedCmdLeftSpace::ROW.id => {
                FrameBuf::encode(id, ctrl, &left)
            }
            (id, Ctrl::GET) => FrameBuf::encode(id, ctrl, &current),
            (id, _) => {
                self.started = id == QueuedCmdStartExec::ROW.id;
                self.until = now + self.each;
                FrameBuf::new(id, ctrl, &[])
            }
        };
        reply.unwrap()
    }
}

/// A host that pauses now and then.
struct Host {
    connection: Connection,
    stream: Stream,
    count: u64,
    offered: u64,
    time: Micros,
    /// Number of times that the stream reported a dry queue.
    starved: u64,
    /// Bytes of readings sent.
    polled: usize,
    /// Number of readings of left space among them.
    left: u64,
}

impl Host {
    fn work(&mut self, now: Micros, to_arm: &mut Wire, to_host: &mut Wire) {
        self.connection.handle_timeout(now);
        while let Some(reply) = to_host.take(now) {
            self.connection.receive(now, reply.bytes());
        }
        while let Some(Event::Done { ticket, result }) = self.connection.poll_event() {
            (self.stream).answered(now, ticket, &result, &mut self.connection);
        }
        while self.stream.room() > 0 && self.offered < self.count {
            self.offered += 1;
            self.stream.offer(segment(self.offered, self.time)).unwrap();
        }
        if self.offered == self.count {
            self.stream.finish();
        }
        self.stream.advance(now, &mut self.connection);
        while let Some(frame) = self.connection.poll_transmit(now) {
            let poll = frame.frame().ctrl() == Ctrl::GET;
            self.polled += frame.bytes().len() * usize::from(poll);
            self.left += u64::from(frame.frame().id() == QueuedCmdLeftSpace::ROW.id);
            to_arm.put(now, frame);
        }
        while let Some(event) = self.stream.poll_event() {
            match event {
                StreamEvent::Starved { times } => self.starved = times,
                StreamEvent::Failed(failure) => panic!("{failure}"),
                _ => {}
            }
        }
    }

    fn next(&self) -> Micros {
        let own = [self.connection.poll_timeout(), self.stream.poll_timeout()];
        own.into_iter().flatten().min().unwrap_or(Micros::MAX)
    }
}

fn segment(count: u64, time: Micros) -> Item {
    let command = CpCmd {
        cp_mode: CpMode::Absolute,
        x: 200.0 + (count % 100) as f32 * 0.2,
        y: 0.0,
        z: 20.0,
        velocity_or_power: 0.0,
    };
    Item {
        command: command.into(),
        time,
        end: None,
        laser: false,
    }
}

/// Result of a drawing.
struct Drawn {
    /// Time without work in between, us.
    dry: Micros,
    /// Number of times that the stream reported it.
    starved: u64,
    /// Share of the line used by readings.
    polls: f64,
    /// Readings of left space per second.
    left: f64,
}

/// Sends segments of `each` us in this window, with a host that pauses for `pause` us once a
/// second.
fn draw(window: usize, count: u64, each: Micros, pause: Micros) -> Drawn {
    let settings = Settings {
        window,
        ..Settings::ORDERED
    };
    let mut host = Host {
        connection: Connection::new(settings),
        stream: Stream::new(StreamSettings {
            window,
            ..StreamSettings::default()
        }),
        count,
        offered: 0,
        time: each,
        starved: 0,
        polled: 0,
        left: 0,
    };
    let mut arm = Arm {
        each,
        ..Arm::default()
    };
    let (mut to_arm, mut to_host) = (Wire::default(), Wire::default());
    let (mut now, mut wakes, mut next_pause) = (0, 0, SECOND / 2);
    while !host.stream.is_over() {
        if now >= next_pause {
            (wakes, next_pause) = (now + pause, next_pause + SECOND);
        }
        if now >= wakes {
            host.work(now, &mut to_arm, &mut to_host);
        }
        // A pausing host leaves replies in the buffer of its operating system.
        let hosts = host.next().min(to_host.next()).max(wakes);
        let next = hosts.min(to_arm.next()).min(next_pause);
        assert!(next < Micros::MAX && now < 120 * SECOND, "it stands still");
        now = next.max(now + 1);
        while let Some(request) = to_arm.take(now) {
            let reply = arm.answer(now, &request);
            to_host.put(now + TURNAROUND, reply);
        }
    }
    assert_eq!(arm.given, count);
    Drawn {
        dry: arm.dry,
        starved: host.starved,
        polls: host.polled as f64 * 1e7 / 115_200.0 / now as f64,
        left: host.left as f64 * 1e6 / now as f64,
    }
}

#[test]
fn short_segments_keep_coming_although_the_host_pauses() {
    // The line carries at most 500 of these segments per second.
    for (rate, pause) in [(450, 10_000), (200, 50_000)] {
        let Drawn {
            dry,
            starved,
            polls,
            ..
        } = draw(4, 60 * rate, SECOND / rate, pause);
        println!("{rate}/s: dry for {dry} us, starved {starved} times, readings {polls:.3}");
        assert_eq!((dry, starved), (0, 0), "{rate}/s");
        assert!(polls < 0.06, "{polls}");
    }
}

#[test]
fn starvation_is_reported_when_the_arm_outpaces_the_line() {
    let drawn = draw(4, 2_000, SECOND / 1_000, 0);
    assert!(drawn.dry > 0);
    assert!(drawn.starved > 0);
}

#[test]
fn readings_leave_a_full_line_to_the_commands() {
    // Window 1, because larger windows need readings as settle points. There is always room in the
    // queue, so a reading only displaces a command.
    let drawn = draw(1, 4_000, SECOND / 1_000, 0);
    println!(
        "readings {:.4}, left space {:.2}/s",
        drawn.polls, drawn.left
    );
    assert!(drawn.polls < 0.006, "{}", drawn.polls);
    assert!(drawn.left < 1.1, "{}", drawn.left);
}
