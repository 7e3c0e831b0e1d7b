use std::collections::BTreeMap;
use std::time::Duration;

use magician_protocol::{FrameBuf, INTER_BYTE_TIMEOUT_MS};

use crate::pace::{ArmClock, LineTiming, Speed};
use crate::{Controller, ExternalEvent, HostInstant, LinkId, Observer};

mod link;

use link::Link;

const INTER_BYTE_TIMEOUT: Duration = Duration::from_millis(INTER_BYTE_TIMEOUT_MS);
/// What a serial driver holds for a port before its writer has to wait.
const BACKLOG: usize = 4096;

/// A [`Controller`] on the wall clock: arm speed, baud rate, turnaround and inter-byte timeout.
///
/// There is no clock and no I/O inside. The wall clock shows 0 when the runner is made, is
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
/// * Faults, at the instant given last: [`unplug`](Self::unplug), [`plug`](Self::plug),
///   [`set_delay`](Self::set_delay).
///
/// An [`Observer`] may look on ([`observe`](Self::observe)). It changes nothing, unless more than 100,000 instants are to
/// be shown to it in one leap of the arm's clock (half an hour at 50 a second): then requests that have come are read
/// before the leap goes on, and a clock that is not at full speed stays behind.
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
    /// Pulls of the cable that the links know of.
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

    /// Sets the only observer from now on. To use the observer elsewhere too, keep an `Arc<Mutex<_>>` of it.
    pub fn observe(&mut self, mut observer: impl Observer + Send + 'static) {
        observer.observe(&self.controller);
        self.observer = Some(Box::new(observer));
    }

    /// Whether there is an observer.
    #[must_use]
    pub fn is_observed(&self) -> bool {
        self.observer.is_some()
    }

    /// Removes the observer.
    pub fn unobserve(&mut self) {
        self.observer = None;
    }

    /// How fast the arm's clock runs.
    #[must_use]
    pub fn speed(&self) -> Speed {
        self.clock.speed()
    }

    /// From now on the arm's clock runs so fast. What an arm at full speed is busy with is done with the next call.
    pub fn set_speed(&mut self, now: HostInstant, speed: Speed) {
        self.handle_timeout(now);
        self.clock = self.clock.at_speed(speed, self.controller.now(), self.wall);
    }

    /// Whether the arm is [busy](Controller::busy) with what has an end within 100 days, or bytes are on their way on any line.
    #[must_use]
    pub fn busy(&self) -> bool {
        ArmClock::jump_to(&self.controller).is_some()
            || (self.links.values()).any(|link| !link.bytes.is_empty())
            || self.next_arrival().is_some()
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

    /// Puts another controller in the place of this one, a snapshot of it taken before: the arm's clock goes on from what that
    /// shows. What is on its way on any line is lost, and what the snapshot knows of its peers is forgotten.
    pub fn replace(&mut self, controller: Controller) {
        while let Some((link, _)) = self.links.pop_first() {
            self.observer.closed(link);
        }
        self.clock = (self.clock).at_speed(self.clock.speed(), controller.now(), self.wall);
        self.pulls = controller.line().pulls;
        self.controller = controller.without_peers();
    }

    /// A peer put bytes on its line. All are taken, whatever [`room`](Self::room) says. The link
    /// begins with its first bytes. Without the cable they are lost.
    pub fn receive(&mut self, now: HostInstant, link: LinkId, bytes: &[u8]) {
        self.handle_timeout(now);
        if !self.plugged() {
            return;
        }
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

    /// The cable is pulled at the arm's end, now: what is on its way in either direction is lost on
    /// every link, half-received frames and replies not taken among it, and so is what comes until
    /// it is [plugged](Self::plug) in again. The arm goes on with what it has.
    pub fn unplug(&mut self) {
        self.controller
            .inject(ExternalEvent::Cable { plugged: false });
        self.follow_cable();
    }

    /// The cable is back, now. Every link begins anew with its next bytes.
    pub fn plug(&mut self) {
        self.controller
            .inject(ExternalEvent::Cable { plugged: true });
    }

    /// Whether the cable is in.
    #[must_use]
    pub fn plugged(&self) -> bool {
        self.controller.line().plugged
    }

    /// How many times the cable has been pulled. It shows a pull even to a caller that only looks after the cable was
    /// plugged in again.
    #[must_use]
    pub fn pulls(&self) -> u64 {
        self.controller.line().pulls
    }

    /// From now on the arm takes so much longer to answer, beyond the line's
    /// turnaround; none is the arm as it was. Answers that are under way are not held up, and none
    /// overtakes another.
    pub fn set_delay(&mut self, delay: Duration) {
        self.controller.inject(ExternalEvent::Delay(delay));
    }

    /// Bytes that the peer may put on its line before it should wait: a serial driver holds 4096
    /// for it, less what is still under way in either direction.
    #[must_use]
    pub fn room(&self, link: LinkId) -> usize {
        let under_way = self.links.get(&link).map_or(0, Link::under_way);
        BACKLOG.saturating_sub(under_way)
    }

    /// The wall clock shows `now`: what is due happens.
    pub fn handle_timeout(&mut self, now: HostInstant) {
        let now = now.max(self.wall);
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

    /// Bytes on their way when the cable was pulled are lost, however it was pulled.
    fn follow_cable(&mut self) {
        if self.pulls != self.pulls() {
            self.pulls = self.pulls();
            while let Some((link, _)) = self.links.pop_first() {
                self.controller.close(link);
                self.observer.closed(link);
            }
        }
    }

    /// When [`handle_timeout`](Self::handle_timeout) or [`poll_transmit`](Self::poll_transmit)
    /// has something to do next; `None`: not before bytes are received. It may be in the past.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<HostInstant> {
        let output = self.links.values().filter_map(|link| link.replies.due());
        self.next_step().into_iter().chain(output).min()
    }

    /// As [`poll_timeout`](Self::poll_timeout), but for replies that have come: a peer that does not take his is nothing to
    /// wait for.
    #[must_use]
    pub fn poll_change(&self) -> Option<HostInstant> {
        let changes = [self.next_step(), self.next_arrival()];
        changes.into_iter().flatten().min()
    }

    /// When [`handle_timeout`](Self::handle_timeout) has something to do next.
    fn next_step(&self) -> Option<HostInstant> {
        let input = self.next_input().map(|(at, _)| at);
        let event = self.clock.next(&self.controller, self.wall);
        let look = self.observer.next_sample();
        let look = look.and_then(|look| self.clock.next_sample(look, self.wall));
        [input, event, look].into_iter().flatten().min()
    }

    /// When the next of the replies that are still on their way has come.
    fn next_arrival(&self) -> Option<HostInstant> {
        let links = self.links.values();
        links
            .filter_map(|link| link.replies.due_after(self.wall))
            .min()
    }

    /// The next reply whose last byte has passed the link's line, whole.
    pub fn poll_transmit(&mut self, now: HostInstant, link: LinkId) -> Option<FrameBuf> {
        self.links.get_mut(&link)?.replies.pop(now)
    }

    /// When the last byte of the next reply to a link has passed its line.
    #[must_use]
    pub fn next_reply(&self, link: LinkId) -> Option<HostInstant> {
        self.links.get(&link)?.replies.due()
    }

    /// The first arrival or silence on any link. Links of the same instant go by their number.
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
                    clock.jump(controller, observer, at);
                }
                link.bytes.drain(..piece.count);
                link.silent = Some(at + INTER_BYTE_TIMEOUT);
            }
            None => {
                observer.silence(controller.now(), id);
                controller.expire(id);
                link.replies.take_from(controller, observer, id, answered);
                observer.observe(controller);
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
