use std::collections::{BTreeMap, VecDeque};

use magician_protocol::{Deframer, Event, FrameBuf, INTER_BYTE_TIMEOUT_MS};

use crate::pace::{ArmClock, Line, Speed, Wire};
use crate::{Controller, LinkId, Micros, Observer};

const INTER_BYTE_TIMEOUT: Micros = INTER_BYTE_TIMEOUT_MS * 1000;
/// What a serial driver holds for a port before its writer has to wait.
const BACKLOG: usize = 4096;

/// A [`Controller`] on the wall clock: arm speed, baud rate, turnaround and inter-byte timeout.
///
/// There is no clock and no I/O inside. The wall clock is microseconds since the runner was made,
/// given with every call, and never runs back. The same calls give the same answers bit for bit,
/// and extra [`handle_timeout`](Self::handle_timeout) calls change nothing.
///
/// * [`receive`](Self::receive): a peer put bytes on its line now.
/// * [`poll_timeout`](Self::poll_timeout), [`handle_timeout`](Self::handle_timeout): when to call
///   again, and the call.
/// * [`poll_transmit`](Self::poll_transmit): the replies that have passed the line by now; ask
///   after every other call.
/// * [`room`](Self::room): how many bytes a peer may still put on its line before a serial driver
///   would make it wait.
///
/// An [`Observer`] may look on ([`observed`](Runner::observed)). It changes nothing, unless more than 100,000 instants
/// are to be shown to it in one leap of the arm's clock (half an hour at 50 a second): then requests that have come are
/// read before the leap goes on, and a clock that is not at full speed stays behind.
///
/// ```
/// use magician_protocol::{FrameBuf, NoArgs, Readable, commands::Pose};
/// use magician_sim::{Controller, Line, LinkId, Profile, Runner, Speed};
///
/// let line = Line { baud: Some(115_200), turnaround: 0 };
/// let mut runner = Runner::new(Controller::new(Profile::default()), Speed::Max, line);
/// let request = FrameBuf::get(&NoArgs, Pose::ROW)?;
/// runner.receive(0, LinkId(0), request.bytes());
/// let mut now = 0;
/// let reply = loop {
///     if let Some(reply) = runner.poll_transmit(now, LinkId(0)) {
///         break reply;
///     }
///     now = runner.poll_timeout().expect("the reply is on its way");
///     runner.handle_timeout(now);
/// };
/// assert_eq!((now, reply.bytes().len()), (3820, 38)); // 44 bytes at 86.8 us
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Runner<O = ()> {
    controller: Controller,
    observer: O,
    clock: ArmClock,
    line: Line,
    wall: Micros,
    links: BTreeMap<LinkId, Link>,
}

impl Runner {
    /// Puts a controller on the wall clock, which shows 0.
    #[must_use]
    pub fn new(controller: Controller, speed: Speed, line: Line) -> Self {
        Self::observed(controller, speed, line, ())
    }
}

impl<O: Observer> Runner<O> {
    /// As [`new`](Runner::new), with somebody who looks on.
    #[must_use]
    pub fn observed(controller: Controller, speed: Speed, line: Line, mut observer: O) -> Self {
        observer.look(&controller);
        Self {
            clock: ArmClock::new(speed, controller.now()),
            controller,
            observer,
            line,
            wall: 0,
            links: BTreeMap::new(),
        }
    }

    /// Who looks on.
    #[must_use]
    pub fn observer(&self) -> &O {
        &self.observer
    }

    /// Who looks on, to be told things.
    pub fn observer_mut(&mut self) -> &mut O {
        &mut self.observer
    }

    /// The controller, as it stood at the last instant given.
    #[must_use]
    pub fn controller(&self) -> &Controller {
        &self.controller
    }

    /// The controller, to take its events or to change its world.
    pub fn controller_mut(&mut self) -> &mut Controller {
        &mut self.controller
    }

    /// A peer put bytes on its line. All are taken, whatever [`room`](Self::room) says. The link
    /// begins with its first bytes.
    pub fn receive(&mut self, now: Micros, link: LinkId, bytes: &[u8]) {
        self.handle_timeout(now);
        let now = self.wall;
        let line = self.line;
        self.links
            .entry(link)
            .or_insert_with(|| Link::new(line))
            .put(now, bytes);
        self.handle_timeout(now);
    }

    /// The peer left. What it has put on its line still arrives and is obeyed, as on a serial
    /// port that is closed; replies to it, and a frame that it began, are dropped.
    pub fn close(&mut self, link: LinkId) {
        let Some(state) = self.links.get_mut(&link) else {
            self.observer.closed(link);
            return;
        };
        state.replies.hang_up();
        if state.pieces.is_empty() {
            self.forget(link);
        }
    }

    /// Bytes that the peer may put on its line before it should wait: a serial driver holds 4096
    /// for it, less what is still under way in either direction.
    #[must_use]
    pub fn room(&self, link: LinkId) -> usize {
        let under_way = self.links.get(&link).map_or(0, Link::under_way);
        BACKLOG.saturating_sub(under_way)
    }

    /// The wall clock shows `now`: what is due happens.
    pub fn handle_timeout(&mut self, now: Micros) {
        let now = now.max(self.wall);
        while let Some((at, link)) = self.next_input().filter(|(at, _)| *at <= now) {
            self.clock
                .pass(&mut self.controller, &mut self.observer, at);
            self.arrive(at, link);
        }
        self.clock
            .pass(&mut self.controller, &mut self.observer, now);
        self.wall = now;
    }

    /// When [`handle_timeout`](Self::handle_timeout) or [`poll_transmit`](Self::poll_transmit)
    /// has something to do next; `None`: not before bytes are received. It may be in the past.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Micros> {
        let input = self.next_input().map(|(at, _)| at);
        let output = self.links.values().filter_map(|link| link.replies.due());
        let event = self.clock.next(&self.controller, self.wall);
        let look = self.observer.next_look();
        let look = look.and_then(|look| self.clock.next_look(look, self.wall));
        input
            .into_iter()
            .chain(output)
            .chain(event)
            .chain(look)
            .min()
    }

    /// The next reply whose last byte has passed the link's line, whole.
    pub fn poll_transmit(&mut self, now: Micros, link: LinkId) -> Option<FrameBuf> {
        self.links.get_mut(&link)?.replies.pop(now)
    }

    /// The first arrival or silence on any link. Links of the same instant go by their number.
    fn next_input(&self) -> Option<(Micros, LinkId)> {
        let due = |(id, link): (&LinkId, &Link)| Some((link.input_due()?, *id));
        self.links.iter().filter_map(due).min()
    }

    fn arrive(&mut self, at: Micros, id: LinkId) {
        let answered = at.saturating_add(self.line.turnaround);
        let Self {
            controller,
            clock,
            observer,
            ..
        } = self;
        let Some(link) = self.links.get_mut(&id) else {
            return;
        };
        match link.pieces.pop_front() {
            Some(piece) => {
                let mut input = &link.bytes.make_contiguous()[..piece.count];
                loop {
                    let (before, now) = (input, controller.now());
                    let handled = controller.receive_one(id, &mut input);
                    observer.request_bytes(now, id, &before[..before.len() - input.len()]);
                    link.replies.take_from(controller, observer, id, answered);
                    observer.look(controller);
                    if !handled {
                        break;
                    }
                    clock.jump(controller, observer, at);
                }
                link.bytes.drain(..piece.count);
                link.silent = Some(at.saturating_add(INTER_BYTE_TIMEOUT));
            }
            None => {
                observer.silence(controller.now(), id);
                controller.expire(id);
                link.replies.take_from(controller, observer, id, answered);
                observer.look(controller);
                clock.jump(controller, observer, at);
                link.fall_silent();
            }
        }
        if link.replies.hung_up && link.pieces.is_empty() {
            self.forget(id);
        }
    }

    fn forget(&mut self, link: LinkId) {
        self.links.remove(&link);
        self.controller.close(link);
        self.observer.closed(link);
    }
}

/// A peer's line: what is on its way to the arm, and the replies.
struct Link {
    input: Wire,
    /// Looks ahead along a paced line for the bytes that complete a frame.
    scout: Option<Box<Deframer>>,
    /// Stream position up to which bytes stand in `pieces`.
    cut: u64,
    pieces: VecDeque<Piece>,
    /// The bytes of all pieces.
    bytes: VecDeque<u8>,
    /// When the line will have been silent for too long to go on with a frame.
    silent: Option<Micros>,
    replies: Replies,
}

/// Replies on their way to a peer.
struct Replies {
    output: Wire,
    /// With the time by which the last byte has passed.
    queue: VecDeque<(Micros, FrameBuf)>,
    /// Nobody waits for them.
    hung_up: bool,
}

/// Bytes that can be handed to the controller in one go: none but the last can complete a frame.
struct Piece {
    /// When the last of them has arrived.
    at: Micros,
    count: usize,
}

impl Link {
    fn new(line: Line) -> Self {
        let paced = line.baud.is_some_and(|baud| baud > 0);
        Self {
            input: Wire::new(line),
            scout: paced.then(Box::default),
            cut: 0,
            pieces: VecDeque::new(),
            bytes: VecDeque::new(),
            silent: None,
            replies: Replies {
                output: Wire::new(line),
                queue: VecDeque::new(),
                hung_up: false,
            },
        }
    }

    fn put(&mut self, now: Micros, bytes: &[u8]) {
        self.replies.hung_up = false;
        self.bytes.extend(bytes);
        let end = self.cut + bytes.len() as u64;
        if let Some(mut scout) = self.scout.take() {
            let mut input = bytes;
            while let Some(event) = scout.next(&mut input) {
                if let Some(end) = decided_at(&event) {
                    self.cut_at(now, end);
                }
            }
            self.scout = Some(scout);
        }
        self.cut_at(now, end);
    }

    /// Ends a piece before stream position `end`, unless one ends there or later.
    fn cut_at(&mut self, now: Micros, end: u64) {
        let count = end.saturating_sub(self.cut) as usize;
        if count > 0 {
            let at = self.input.carry(now, count);
            self.pieces.push_back(Piece { at, count });
            self.cut = end;
        }
    }

    fn fall_silent(&mut self) {
        self.silent = None;
        if let Some(scout) = &mut self.scout {
            scout.expire();
            while scout.next(&mut &[][..]).is_some() {}
        }
    }

    fn input_due(&self) -> Option<Micros> {
        let arrival = self.pieces.front().map(|piece| piece.at);
        arrival.or(self.silent)
    }

    fn under_way(&self) -> usize {
        let replies = self.replies.queue.iter();
        self.bytes.len() + replies.map(|(_, frame)| frame.bytes().len()).sum::<usize>()
    }
}

impl Replies {
    /// Puts the controller's replies on the line, not before `from`.
    fn take_from<O: Observer>(
        &mut self,
        controller: &mut Controller,
        observer: &mut O,
        link: LinkId,
        from: Micros,
    ) {
        while let Some(frame) = controller.poll_transmit(link) {
            if !self.hung_up {
                observer.reply(controller.now(), link, &frame);
                let at = self.output.carry(from, frame.bytes().len());
                self.queue.push_back((at, frame));
            }
        }
    }

    fn due(&self) -> Option<Micros> {
        self.queue.front().map(|(at, _)| *at)
    }

    fn pop(&mut self, now: Micros) -> Option<FrameBuf> {
        let due = self.due().is_some_and(|at| at <= now);
        let (_, frame) = due.then(|| self.queue.pop_front())??;
        Some(frame)
    }

    fn hang_up(&mut self) {
        self.hung_up = true;
        self.queue.clear();
    }
}

/// Stream position just after the byte that decided this: a frame's last, or the one that showed
/// a candidate to be none, which may bring frames inside it to light.
fn decided_at(event: &Event<'_>) -> Option<u64> {
    match event {
        Event::Frame { offset, frame } => Some(offset + frame.bytes().len() as u64),
        Event::Rejected { offset, bytes, .. } => Some(offset + bytes.len() as u64),
        Event::Noise { .. } => None,
    }
}
