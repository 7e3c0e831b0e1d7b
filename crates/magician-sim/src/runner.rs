//! A controller on a wall clock, with paced serial lines to its peers.
//!
//! The controller knows only its own clock. A [`Runner`] adds the wall clock: it delays bytes by
//! the baud rate and replies by the turnaround, measures the inter-byte timeout, and advances the
//! arm's clock by its [`Speed`]. Input is handed over in pieces that end where a frame can end, so
//! that each request is handled at the instant at which its last byte has passed the line.

use std::collections::BTreeMap;
use std::time::Duration;

use magician_protocol::{FrameBuf, INTER_BYTE_TIMEOUT_MS};

use crate::pace::{ArmClock, LineTiming, Speed};
use crate::{Controller, ExternalEvent, HostInstant, LinkId, Observer};

mod link;

use link::Link;

const INTER_BYTE_TIMEOUT: Duration = Duration::from_millis(INTER_BYTE_TIMEOUT_MS);
/// Bytes that a serial driver buffers for a port before its writer has to wait.
const LINE_BUFFER_BYTES: usize = 4096;

/// Runs a [`Controller`] on the wall clock: arm speed, baud rate, turnaround and inter-byte
/// timeout.
///
/// A runner has no clock and no I/O. The wall clock shows 0 when the runner is created, is passed
/// to every call, and never runs back. The same calls give the same answers bit for bit, and extra
/// calls of [`handle_timeout`](Self::handle_timeout) change nothing.
///
/// * [`receive`](Self::receive): a peer has put bytes on its line.
/// * [`poll_timeout`](Self::poll_timeout), [`handle_timeout`](Self::handle_timeout): the next
///   instant, and the call to make then.
/// * [`poll_transmit`](Self::poll_transmit): replies that have passed the line; poll after every
///   other call.
/// * [`room`](Self::room): number of bytes that a peer may still put on its line before a serial
///   driver would make it wait.
/// * Faults, at the latest instant: [`unplug`](Self::unplug), [`plug`](Self::plug),
///   [`set_delay`](Self::set_delay).
///
/// An [`Observer`] ([`observe`](Self::observe)) does not affect arm and replies, unless it asks for
/// more than 100,000 samples in one jump of the arm's clock (half an hour at 50 a second). Then
/// pending requests are read before the jump continues, and a clock below full speed falls behind.
///
/// ```
/// use magician_protocol::{FrameBuf, NoArgs, Readable, commands::Pose};
/// use magician_sim::{Controller, HostInstant, LineTiming, LinkId, Profile, Runner, Speed};
///
/// let line = LineTiming { baud: Some(115_200), ..LineTiming::default() };
/// let mut runner = Runner::new(Controller::new(Profile::default()), Speed::Max, line);
/// let request = FrameBuf::get(&NoArgs, Pose::ROW)?;
/// runner.receive(HostInstant::ZERO, LinkId(0), request.bytes());
/// let mut now = HostInstant::ZERO;
/// let reply = loop {
///     if let Some(reply) = runner.poll_transmit(now, LinkId(0)) {
///         break reply;
///     }
///     now = runner.poll_timeout().expect("the reply is on its way");
///     runner.handle_timeout(now);
/// };
/// assert_eq!((now.as_micros(), reply.bytes().len()), (3820, 38)); // 44 bytes at 86.8 us
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Runner {
    controller: Controller,
    observer: Option<Box<dyn Observer + Send>>,
    clock: ArmClock,
    line: LineTiming,
    wall: HostInstant,
    links: BTreeMap<LinkId, Link>,
    /// Pull count of the controller at the last check: a higher count means that the links have to
    /// be dropped.
    pulls: u64,
}

impl Runner {
    /// Puts a controller on the wall clock, which shows 0.
    #[must_use]
    pub fn new(controller: Controller, speed: Speed, line: LineTiming) -> Self {
        Self {
            clock: ArmClock::new(speed, controller.now()),
            pulls: controller.line().pulls,
            controller,
            observer: None,
            line,
            wall: HostInstant::ZERO,
            links: BTreeMap::new(),
        }
    }

    /// Replaces the observer. To keep access to it, pass a clone of an `Arc<Mutex<_>>`.
    pub fn observe(&mut self, mut observer: impl Observer + Send + 'static) {
        observer.observe(&self.controller);
        self.observer = Some(Box::new(observer));
    }

    /// True if there is an observer.
    #[must_use]
    pub fn is_observed(&self) -> bool {
        self.observer.is_some()
    }

    /// Removes the observer.
    pub fn unobserve(&mut self) {
        self.observer = None;
    }

    /// Speed of the arm's clock.
    #[must_use]
    pub fn speed(&self) -> Speed {
        self.clock.speed()
    }

    /// Changes the speed of the arm's clock. After a change to full speed, the next call of
    /// [`handle_timeout`](Self::handle_timeout) or [`receive`](Self::receive) completes pending
    /// motion.
    pub fn set_speed(&mut self, now: HostInstant, speed: Speed) {
        self.handle_timeout(now);
        self.clock = self.clock.at_speed(speed, self.controller.now(), self.wall);
    }

    /// True if the arm is [busy](Controller::busy) with something that ends within 100 days, or
    /// bytes are in flight on any line.
    #[must_use]
    pub fn busy(&self) -> bool {
        ArmClock::jump_target(&self.controller).is_some()
            || (self.links.values()).any(|link| !link.bytes.is_empty())
            || self.next_arrival().is_some()
    }

    /// The controller at the latest instant.
    #[must_use]
    pub fn controller(&self) -> &Controller {
        &self.controller
    }

    /// Mutable access to the controller, to take its events or to change its world.
    pub fn controller_mut(&mut self) -> &mut Controller {
        &mut self.controller
    }

    /// Replaces the controller, usually by an earlier snapshot. The arm's clock continues from that
    /// of the snapshot.
    ///
    /// Bytes in flight on any line are lost, and so are the links of the snapshot.
    pub fn replace(&mut self, controller: Controller) {
        while let Some((link, _)) = self.links.pop_first() {
            self.observer.closed(link);
        }
        self.clock = (self.clock).at_speed(self.clock.speed(), controller.now(), self.wall);
        // The snapshot has its own count; a difference would look like a pull.
        self.pulls = controller.line().pulls;
        self.controller = controller.without_peers();
    }

    /// Puts bytes of a peer on its line. All are taken, whatever [`room`](Self::room) says.
    ///
    /// A link is created by its first bytes. With the cable pulled the bytes are lost.
    pub fn receive(&mut self, now: HostInstant, link: LinkId, bytes: &[u8]) {
        self.handle_timeout(now);
        if !self.plugged() {
            return;
        }
        let now = self.wall;
        let line = self.line;
        self.links
            .entry(link)
            // Datagram peers announce themselves by their first bytes.
            .or_insert_with(|| Link::new(line))
            .put(now, bytes);
        self.handle_timeout(now);
    }

    /// Closes a link. Bytes already on the line still arrive and are obeyed, as on a serial port
    /// that is closed; replies and a partial frame are dropped.
    pub fn close(&mut self, link: LinkId) {
        let Some(state) = self.links.get_mut(&link) else {
            self.observer.closed(link);
            return;
        };
        // A closed serial port still delivers what was written, so only the replies are dropped.
        state.replies.hang_up();
        // With bytes still in flight the link lives on until the last has arrived.
        if state.pieces.is_empty() {
            self.forget(link);
        }
    }

    /// Pulls the cable at the arm's end.
    ///
    /// Everything in flight in either direction is lost on every link, including partial frames and
    /// pending replies, and so are all bytes until the cable is [plugged](Self::plug) in again. The
    /// arm continues with the commands that it has.
    pub fn unplug(&mut self) {
        self.controller
            .inject(ExternalEvent::Cable { plugged: false });
        self.follow_cable();
    }

    /// Plugs the cable in again. Every link starts anew with its next bytes.
    pub fn plug(&mut self) {
        self.controller
            .inject(ExternalEvent::Cable { plugged: true });
    }

    /// True if the cable is plugged in.
    #[must_use]
    pub fn plugged(&self) -> bool {
        self.controller.line().plugged
    }

    /// Number of times that the cable was pulled. It reveals a pull even to a caller that looks
    /// only after the cable was plugged in again.
    #[must_use]
    pub fn pulls(&self) -> u64 {
        self.controller.line().pulls
    }

    /// Sets an additional delay of answers, on top of the line's turnaround; zero removes it.
    ///
    /// Replies in flight are not delayed further, and no reply overtakes another.
    pub fn set_delay(&mut self, delay: Duration) {
        self.controller.inject(ExternalEvent::Delay(delay));
    }

    /// Number of bytes that the peer may put on its line before it should wait.
    ///
    /// A serial driver buffers 4096 bytes; the bytes in flight in either direction count against
    /// them.
    #[must_use]
    pub fn room(&self, link: LinkId) -> usize {
        let bytes_in_flight = self.links.get(&link).map_or(0, Link::bytes_in_flight);
        LINE_BUFFER_BYTES.saturating_sub(bytes_in_flight)
    }

    /// Advances the wall clock to `now` and does everything that is due.
    pub fn handle_timeout(&mut self, now: HostInstant) {
        // A caller's clock may step back; ours never does.
        let now = now.max(self.wall);
        // In order of arrival over all links: a request must see the effects of every earlier one.
        while let Some((at, link)) = self.next_input().filter(|(at, _)| *at <= now) {
            self.pass(at);
            self.follow_cable();
            self.arrive(at, link);
        }
        self.pass(now);
        self.follow_cable();
        self.wall = now;
    }

    fn pass(&mut self, wall: HostInstant) {
        let Self {
            clock,
            controller,
            observer,
            ..
        } = self;
        clock.pass(controller, observer, wall);
    }

    /// Drops the links after a pull of the cable, by [`unplug`](Self::unplug) or by a fault of the
    /// scenario.
    fn follow_cable(&mut self) {
        if self.pulls != self.pulls() {
            self.pulls = self.pulls();
            while let Some((link, _)) = self.links.pop_first() {
                self.controller.close(link);
                self.observer.closed(link);
            }
        }
    }

    /// Next instant at which [`handle_timeout`](Self::handle_timeout) or
    /// [`poll_transmit`](Self::poll_transmit) has something to do; the instant may be in the past.
    /// `None` if there is nothing to do until bytes are received.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<HostInstant> {
        let output = self.links.values().filter_map(|link| link.replies.due());
        self.next_step().into_iter().chain(output).min()
    }

    /// Like [`poll_timeout`](Self::poll_timeout), but ignores replies that have arrived.
    ///
    /// A peer that does not read its replies is not worth waiting for.
    #[must_use]
    pub fn poll_change(&self) -> Option<HostInstant> {
        let changes = [self.next_step(), self.next_arrival()];
        changes.into_iter().flatten().min()
    }

    /// Next instant at which [`handle_timeout`](Self::handle_timeout) has something to do.
    fn next_step(&self) -> Option<HostInstant> {
        let input = self.next_input().map(|(at, _)| at);
        let event = self.clock.next(&self.controller, self.wall);
        let sample = self.observer.next_sample();
        let sample = sample.and_then(|sample| self.clock.next_sample(sample, self.wall));
        [input, event, sample].into_iter().flatten().min()
    }

    /// Arrival of the next reply in flight.
    fn next_arrival(&self) -> Option<HostInstant> {
        let links = self.links.values();
        links
            .filter_map(|link| link.replies.due_after(self.wall))
            .min()
    }

    /// Returns the next reply whose last byte has passed the line.
    pub fn poll_transmit(&mut self, now: HostInstant, link: LinkId) -> Option<FrameBuf> {
        self.links.get_mut(&link)?.replies.pop(now)
    }

    /// Arrival of the last byte of the next reply on a link.
    #[must_use]
    pub fn next_reply(&self, link: LinkId) -> Option<HostInstant> {
        self.links.get(&link)?.replies.due()
    }

    /// Next arrival or silence on any link. Links with the same instant are ordered by their
    /// number.
    fn next_input(&self) -> Option<(HostInstant, LinkId)> {
        let due = |(id, link): (&LinkId, &Link)| Some((link.input_due()?, *id));
        self.links.iter().filter_map(due).min()
    }

    fn arrive(&mut self, at: HostInstant, id: LinkId) {
        let turnaround = self
            .line
            .turnaround
            .saturating_add(self.controller.line().delay);
        let answered = at + turnaround;
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
                // A piece may hold several frames, if an earlier one became complete only by a
                // timeout or by a rejected candidate: handle them one at a time.
                let mut input = &link.bytes.make_contiguous()[..piece.count];
                loop {
                    let (before, now) = (input, controller.now());
                    let handled = controller.receive_one(id, &mut input);
                    observer.request_bytes(now, id, &before[..before.len() - input.len()]);
                    link.replies.take_from(controller, observer, id, answered);
                    observer.observe(controller);
                    if !handled {
                        break;
                    }
                    // At full speed the queued command finishes before the next request is read.
                    clock.jump(controller, observer, at);
                }
                link.bytes.drain(..piece.count);
                // Any byte restarts the inter-byte timeout (E04: 50 ms).
                link.silent = Some(at + INTER_BYTE_TIMEOUT);
            }
            // No bytes are left, so the due input is the inter-byte timeout.
            None => {
                observer.silence(controller.now(), id);
                controller.expire(id);
                link.replies.take_from(controller, observer, id, answered);
                observer.observe(controller);
                clock.jump(controller, observer, at);
                link.fall_silent();
            }
        }
        // Closed, and the last byte has arrived.
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
