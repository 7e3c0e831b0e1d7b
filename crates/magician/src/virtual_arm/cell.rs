//! Cell: the virtual arm shared by its handles, the lines to it, and its clock.
//!
//! At full speed and in virtual time the arm advances its clock itself: each command takes full
//! effect at once. For a run that is too early, because its next commands are still on their way,
//! so connections with a run lead the clock: while there is one, the clock stands, the arm moves at
//! normal speed, and time passes in their leaps. Without one, the clock of an arm at full speed
//! follows the wall clock (a jog, a belt), and in virtual time it stands until it is advanced.

use std::collections::BTreeMap;
use std::task::Waker;
use std::time::Duration;

use magician_protocol::MAX_FRAME;
use magician_sim::{ArmInstant, HostInstant, LinkId, Runner, Speed};
use tokio::time::Instant;

use super::sampling::Samplers;
use crate::transport::{Leap, LeapTo, STEP};

/// Most events in one leap before others get access to the arm. Choice.
const EVENTS: usize = 1000;
/// Smallest step of the clock.
const INSTANT: Duration = Duration::from_micros(1);

/// Virtual arm with its waiters.
pub(crate) struct Cell {
    pub(crate) runner: Runner,
    begun: Instant,
    /// True in virtual time: the host clock that the arm sees always stands.
    stands: bool,
    /// True while a connection leads, so that the clock stands for now.
    led: bool,
    /// Time of that clock while it stands; otherwise the time when it was started.
    ahead: HostInstant,
    lines: BTreeMap<LinkId, End>,
    /// Wakers of servers for other programs, woken when the arm was touched.
    servers: Vec<Waker>,
    /// Speed of the arm while no connection leads it.
    free: Speed,
    /// Samplers of the arm, once there is one.
    samplers: Option<Samplers>,
    /// True if lines break when the cable is pulled; otherwise frames are lost meanwhile.
    breaks: bool,
}

/// Host end of a line.
#[derive(Default)]
struct End {
    /// Waker of the connection, woken when the arm was touched by another.
    waker: Option<Waker>,
    leads: bool,
    /// True for the reserved line of a remote client that has not sent anything yet.
    idle: bool,
}

impl Cell {
    pub(super) fn new(runner: Runner) -> Self {
        Self {
            begun: Instant::now(),
            stands: false,
            led: false,
            ahead: HostInstant::ZERO,
            lines: BTreeMap::new(),
            servers: Vec::new(),
            free: runner.speed(),
            samplers: None,
            breaks: false,
            runner,
        }
    }

    /// Returns the host clock that the arm sees.
    pub(crate) fn now(&self) -> HostInstant {
        if self.stands || self.led {
            self.ahead
        } else {
            self.ahead + self.begun.elapsed()
        }
    }

    /// Returns when that clock will reach an instant by itself; `None` if it stands.
    pub(crate) fn comes(&self, at: HostInstant) -> Option<Instant> {
        (!self.stands && !self.led).then(|| self.begun.checked_add(at - self.ahead))?
    }

    /// True if a run may lead the clock: the arm does not follow the wall clock.
    pub(crate) fn can_be_led(&self) -> bool {
        self.stands || self.free == Speed::Max
    }

    /// Stops the clock for good.
    pub(super) fn stand(&mut self) {
        let begun = self.runner.controller().now() > ArmInstant::ZERO;
        (self.ahead, self.stands) = (if begun { self.now() } else { HostInstant::ZERO }, true);
    }

    pub(super) fn put_forward(&mut self, time: Duration) {
        self.ahead += time;
    }

    /// Returns the samplers; `None` if the runner already has an observer of its creator's.
    pub(super) fn samplers(&mut self) -> Option<Samplers> {
        if self.samplers.is_none() && !self.runner.is_observed() {
            let samplers = Samplers::default();
            self.runner.observe(samplers.clone());
            self.samplers = Some(samplers);
        }
        self.samplers.clone()
    }

    /// Notes that the arm was touched from outside, or observed.
    pub(super) fn touched(&self) {
        if let Some(samplers) = &self.samplers {
            samplers.touched(self.runner.controller());
        }
    }

    /// Wakes all connections and servers.
    pub(super) fn wake(&mut self) {
        let wakers = self.lines.values_mut().filter_map(|end| end.waker.take());
        wakers.chain(self.servers.drain(..)).for_each(Waker::wake);
    }

    /// Wakes all but this connection, which looks anyway.
    fn wake_others(&mut self, link: LinkId) {
        let others = self.lines.iter_mut().filter(|(other, _)| **other != link);
        let wakers = others.filter_map(|(_, end)| end.waker.take());
        wakers.chain(self.servers.drain(..)).for_each(Waker::wake);
    }
}

/// Lines.
impl Cell {
    /// Opens a line for a connection.
    pub(crate) fn open(&mut self) -> LinkId {
        let mut link = LinkId(0);
        while self.lines.contains_key(&link) {
            link.0 += 1;
        }
        self.lines.insert(link, End::default());
        link
    }

    /// Opens a line for a remote client that may come.
    #[cfg(feature = "serve")]
    pub(crate) fn expect_client(&mut self) -> LinkId {
        let link = self.open();
        if let Some(end) = self.lines.get_mut(&link) {
            end.idle = true;
        }
        link
    }

    pub(crate) fn is_connected(&self) -> bool {
        self.lines.values().any(|end| !end.idle)
    }

    /// Registers a waker, to be woken when the arm is touched.
    #[cfg(feature = "serve")]
    pub(crate) fn watch(&mut self, waker: &Waker) {
        if !self.servers.iter().any(|known| known.will_wake(waker)) {
            self.servers.push(waker.clone());
        }
    }

    pub(super) fn break_lines(&mut self) {
        self.breaks = true;
    }

    /// True if lines break, at each change of the [pulls](Runner::pulls) of the cable.
    pub(crate) fn breaks(&self) -> bool {
        self.breaks
    }

    /// True if no line can be opened because the cable is unplugged.
    pub(crate) fn is_gone(&self) -> bool {
        self.breaks && !self.runner.plugged()
    }

    /// Closes a line; the arm's pending bytes for it are dropped.
    pub(crate) fn close(&mut self, link: LinkId) {
        self.runner.close(link);
        self.lead(link, false);
        self.lines.remove(&link);
    }

    pub(crate) fn listen(&mut self, link: LinkId, waker: &Waker) {
        if let Some(end) = self.lines.get_mut(&link) {
            match &mut end.waker {
                Some(known) => known.clone_from(waker),
                none => *none = Some(waker.clone()),
            }
        }
    }

    /// Reads replies of the arm on this line, as many whole frames as fit.
    pub(crate) fn hear(&mut self, now: HostInstant, link: LinkId, bytes: &mut [u8]) -> usize {
        let mut count = 0;
        while count == 0 || bytes.len() - count >= MAX_FRAME {
            let Some(frame) = self.runner.poll_transmit(now, link) else {
                break;
            };
            // A caller's buffer smaller than a frame cuts it; the transport's own buffers are
            // larger.
            let (frame, rest) = (frame.bytes(), bytes.get_mut(count..).unwrap_or_default());
            let most = frame.len().min(rest.len());
            if let (Some(to), Some(from)) = (rest.get_mut(..most), frame.get(..most)) {
                to.copy_from_slice(from);
            }
            count += most;
        }
        count
    }

    pub(crate) fn receive(&mut self, link: LinkId, bytes: &[u8]) {
        if let Some(end) = self.lines.get_mut(&link) {
            end.idle = false;
        }
        let now = self.now();
        self.runner.receive(now, link, bytes);
        // The leading connection may be waiting for the clock to start again.
        if (self.lines.iter()).any(|(other, end)| end.leads && *other != link) {
            self.wake();
        }
    }
}

/// Leading the clock.
impl Cell {
    /// Gives this line's connection control of the clock, or takes it back; returns true if it
    /// leads.
    pub(crate) fn lead(&mut self, link: LinkId, leads: bool) -> bool {
        if !self.can_be_led() {
            return false;
        }
        let (now, was_led) = (self.now(), self.led);
        if let Some(end) = self.lines.get_mut(&link) {
            end.leads = leads;
        }
        self.led = self.lines.values().any(|end| end.leads);
        match (was_led, self.led) {
            (false, true) => {
                self.ahead = now;
                self.runner.set_speed(now, Speed::Times(1.0));
            }
            (true, false) => {
                self.begun = Instant::now();
                self.runner.set_speed(now, self.free);
                self.runner.handle_timeout(now);
                self.wake();
            }
            // Another leader came or went, and the clock keeps its state.
            _ => {}
        }
        leads
    }

    /// Lets up to `most` pass at once, less if a reply arrives on this line or the event comes
    /// first.
    pub(crate) fn leap(&mut self, link: LinkId, most: Duration, to: LeapTo) -> Option<Leap> {
        // An arm at rest has nothing to leap to. But its cable is plugged in again by its own
        // clock, which follows the wall clock until then; otherwise a run waiting for an answer
        // would wait forever.
        let comes_back = !self.runner.plugged() && most <= STEP;
        if !self.led || !(self.runner.busy() || comes_back || to == LeapTo::Instant) {
            return None;
        }
        let (from, before) = (self.ahead, self.runner.controller().current_index());
        let end = from + most.max(INSTANT);
        let was_busy = self.runner.busy();
        let mut news = false;
        for _ in 0..EVENTS {
            let next = self.runner.poll_change().unwrap_or(end);
            self.ahead = next.max(self.ahead + INSTANT).min(end);
            self.runner.handle_timeout(self.ahead);
            let ended = to != LeapTo::Rest && self.runner.controller().current_index() != before;
            let rests = !self.runner.busy() && (was_busy || to != LeapTo::Instant);
            news = ended || rests;
            let heard = self.runner.next_reply(link);
            if news && to != LeapTo::Instant
                || self.ahead >= end
                || heard.is_some_and(|at| at <= self.ahead)
            {
                break;
            }
        }
        self.wake_others(link);
        Some(Leap {
            time: self.ahead - from,
            news,
        })
    }
}

#[cfg(test)]
mod tests {
    use magician_protocol::commands::{Pose, QueuedCmdStartExec, WaitCmd};
    use magician_protocol::{Ctrl, FrameBuf, NoArgs, Readable};
    use magician_sim::Controller;

    use super::*;

    #[test]
    fn an_answer_that_nobody_takes_holds_no_time_up() {
        let mut cell = Cell::new(Runner::new(
            Controller::default(),
            Speed::Max,
            magician_sim::LineTiming::default(),
        ));
        cell.stand();
        let (leader, other) = (cell.open(), cell.open());
        let ask = FrameBuf::get(&NoArgs, Pose::ROW).unwrap();
        cell.receive(other, ask.bytes());
        assert!(cell.lead(leader, true));
        let start = FrameBuf::set(&QueuedCmdStartExec {}.into(), Ctrl::SET).unwrap();
        let wait = FrameBuf::set(&WaitCmd { timeout: 5000 }.into(), Ctrl::QUEUED).unwrap();
        for frame in [start, wait] {
            cell.receive(leader, frame.bytes());
            while cell
                .runner
                .poll_transmit(HostInstant::ZERO, leader)
                .is_some()
            {}
        }
        let leap = cell
            .leap(leader, Duration::MAX, LeapTo::Rest)
            .expect("it waits");
        assert_eq!((leap.time, leap.news), (Duration::from_secs(5), true));
        assert!(cell.leap(leader, Duration::MAX, LeapTo::Rest).is_none());
    }
}
