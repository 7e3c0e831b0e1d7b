#![no_main]
//! Host against a hostile device: arbitrary bytes and times, replies that are correct, wrong, late
//! and duplicated, requests of every kind, stops and cancellations. The host must not panic, time
//! must advance, and every request must end exactly once, by its deadline.

use std::collections::{HashMap, VecDeque};

use libfuzzer_sys::fuzz_target;
use magician::connection::{Connection, Event, Priority, Request, Settings, Ticket};
use magician_protocol::{Ctrl, FrameBuf};

/// Ids of the requests: reads of the queue, queue control, motions, parameters, one unknown id.
const IDS: [u8; 16] = [
    10, 20, 31, 73, 80, 84, 91, 110, 131, 240, 242, 245, 246, 247, 3, 255,
];
/// Rounds at one instant after which time counts as stuck.
const STANDING: u32 = 10_000;

struct Bench<'a> {
    script: &'a [u8],
    host: Connection,
    now: u64,
    /// Deadlines of the requests that have not ended.
    open: HashMap<Ticket, u64>,
    tickets: Vec<Ticket>,
    /// Frames sent recently.
    sent: VecDeque<FrameBuf>,
    index: u64,
}

impl Bench<'_> {
    fn byte(&mut self) -> u8 {
        let (first, rest) = self.script.split_first().unwrap_or((&0, &[]));
        self.script = rest;
        *first
    }

    fn submit(&mut self) {
        let (id, kind, patience) = (self.byte(), self.byte(), self.byte());
        let id = IDS[usize::from(id % 16)];
        let params = [self.byte(); 17];
        let params = &params[..usize::from(kind >> 4).min(17)];
        let request = Request::raw(id, Ctrl(kind & 3), params).expect("it is short");
        let request = match kind & 0x0C {
            0x04 => request.priority(Priority::Stop),
            0x08 => request.priority(Priority::Poll),
            _ => request,
        };
        let deadline = self.now + 20_000 * u64::from(patience);
        let ticket = self.host.submit(request.deadline(deadline));
        assert!(self.open.insert(ticket, deadline).is_none());
        self.tickets.push(ticket);
    }

    /// Sends a reply to one of these frames, more or less correct.
    fn answer(&mut self) {
        let (which, how) = (self.byte(), self.byte());
        let Some(request) = self.sent.get(usize::from(which) % self.sent.len().max(1)) else {
            return;
        };
        let (id, ctrl) = (request.frame().id(), request.frame().ctrl());
        self.index = match how >> 5 {
            0 => self.index,
            1 => self.index.wrapping_sub(1),
            2 => self.index.wrapping_add(u64::from(how & 31)),
            3 => u64::from(how & 31),
            4 => u64::MAX - u64::from(how & 31),
            _ => self.index.wrapping_add(1),
        };
        let long = self.index.to_le_bytes();
        let short = u32::from(how & 63).to_le_bytes();
        let params: &[u8] = match id {
            247 => &short,
            _ if ctrl.queued() || id == 246 => &long,
            _ => &long[..usize::from(how & 7)],
        };
        let reply = FrameBuf::new(id, ctrl, params).expect("it is short");
        let bytes = reply.bytes().to_vec();
        self.host.receive(self.now, &bytes);
    }

    fn noise(&mut self) {
        let count = usize::from(self.byte()).min(self.script.len());
        let (bytes, rest) = self.script.split_at(count);
        self.script = rest;
        self.host.receive(self.now, bytes);
    }

    /// Takes all output. Asserts that requests end once and by their deadlines.
    fn drain(&mut self) {
        let mut out = 0;
        while let Some(frame) = self.host.poll_transmit(self.now) {
            out += 1;
            assert!(out < 64, "it floods the line");
            if self.sent.len() >= 16 {
                self.sent.pop_front();
            }
            self.sent.push_back(frame);
        }
        while let Some(event) = self.host.poll_event() {
            if let Event::Done { ticket, .. } = event {
                let deadline = self.open.remove(&ticket).expect("it ends once");
                assert!(self.now <= deadline, "it ended late");
            }
        }
    }

    /// Advances time, from one timeout of the connection to the next.
    fn pass(&mut self, end: u64) {
        let mut standing = 0;
        loop {
            self.drain();
            let next = self.host.poll_timeout().unwrap_or(u64::MAX).min(end);
            standing = if next > self.now { 0 } else { standing + 1 };
            assert!(standing < STANDING, "time stands still");
            self.now = self.now.max(next);
            self.host.handle_timeout(self.now);
            self.drain();
            if self.now >= end {
                return;
            }
        }
    }
}

fuzz_target!(|data: &[u8]| {
    let Some((mode, script)) = data.split_first() else {
        return;
    };
    let settings = match mode & 1 {
        0 => Settings::ORDERED,
        _ => Settings::DATAGRAMS,
    };
    let mut bench = Bench {
        script,
        host: Connection::new(Settings {
            window: usize::from(mode >> 1 & 7),
            ..settings
        }),
        now: 0,
        open: HashMap::new(),
        tickets: Vec::new(),
        sent: VecDeque::new(),
        index: 0,
    };
    while !bench.script.is_empty() {
        match bench.byte() % 8 {
            0 | 1 => bench.submit(),
            2 | 3 | 4 => bench.answer(),
            5 => bench.noise(),
            6 => {
                let by = u64::from(bench.byte());
                bench.pass(bench.now + by * by * 50);
            }
            _ => {
                let at = usize::from(bench.byte());
                if let Some(ticket) = bench.tickets.get(at % bench.tickets.len().max(1)) {
                    bench.host.cancel(*ticket);
                }
            }
        }
        bench.drain();
    }
    let end = bench.open.values().copied().max().unwrap_or(bench.now);
    bench.pass(end.max(bench.now));
    assert!(
        bench.open.is_empty(),
        "{} requests have no end",
        bench.open.len()
    );
});
