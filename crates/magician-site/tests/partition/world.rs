//! Model of the search: stations, users, and the connections between them.

use std::collections::VecDeque;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::time::Duration;

use magician_protocol::HostInstant;
use magician_station::control::{
    ArmId, Control, Effect, LEASE_TIMEOUT, LeaseId, PersonId, RECONNECT_GRACE, RequestId,
    SessionId, Slot, WorkKind,
};

use crate::bug::Bug;
use crate::laws::{Checked, must};
use crate::search::Explored;

pub(crate) const USERS: usize = 3;
const STATIONS: usize = 3;
pub(crate) const ARM: ArmId = ArmId(0);
/// Length of a slot. The first user may hold an arm in the first slot, the second one in the next;
/// the third is a teacher.
pub(crate) const SLOT: Duration = Duration::from_secs(12);
/// Time without events that the search skips: longer than the lease timeout.
const SILENCE: Duration = Duration::from_secs(6);
/// Most messages in flight on a connection. A choice that keeps the exhaustive search feasible.
const IN_FLIGHT: usize = 2;

/// Message of a user.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum UserMessage {
    Acquire,
    Move,
    Release,
}

/// Event of the search. Users and stations are numbered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Event {
    /// A user opens a line.
    Open(usize, usize),
    Send(usize, usize, UserMessage),
    /// The first message in flight arrives.
    Arrive(usize, usize),
    /// The cable is unplugged for longer than a connection lasts: messages in flight are lost, and
    /// neither end knows yet.
    Cut(usize, usize),
    /// The user's end of a line is gone: the program was killed, or it has noticed the cut.
    UserGone(usize, usize),
    /// The station notices that a line is dead.
    StationNotices(usize, usize),
    /// A motion ends.
    Finish(usize),
    /// The clock of a station advances to its next deadline.
    Pass(usize),
    /// A station is killed and restarted.
    Kill(usize),
    /// A single request, without a session.
    Call(usize, usize),
}

/// Station end of a line.
#[derive(Clone, Debug)]
pub(crate) struct End {
    pub(crate) session: SessionId,
    /// Time of the last message, by the station's clock.
    pub(crate) heard: HostInstant,
}

/// Connection between a user and a station: ordered and without loss until it is cut.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    /// True while the user's end exists.
    open: bool,
    cut: bool,
    messages: VecDeque<UserMessage>,
    pub(crate) end: Option<End>,
}

#[derive(Clone, Copy, Debug, Hash)]
pub(crate) struct Motion {
    pub(crate) session: SessionId,
    pub(crate) request: RequestId,
    /// True if its lease was released. The motion continues to its end.
    pub(crate) free: bool,
}

#[derive(Clone)]
pub(crate) struct StationModel {
    pub(crate) control: Control,
    /// Time by the station's own clock.
    pub(crate) now: HostInstant,
    /// Time that control was given last.
    control_time: HostInstant,
    /// End of the first slot.
    pub(crate) slot: HostInstant,
    pub(crate) motions: Vec<Motion>,
    lease: Option<(SessionId, LeaseId)>,
    /// Sessions whose line has ended, with the time.
    pub(crate) left: Vec<(SessionId, HostInstant)>,
}

/// State of the search.
#[derive(Clone)]
pub(crate) struct World {
    pub(crate) bug: Option<Bug>,
    pub(crate) stations: Vec<StationModel>,
    /// Lines by user, then by station.
    pub(crate) lines: Vec<Vec<Option<Line>>>,
    /// Number of stations that have had an event. The others are interchangeable.
    used: usize,
}

impl StationModel {
    fn new(now: HostInstant, slot: HostInstant, forgets: bool) -> Self {
        let mut control = Control::new(1);
        let slots = [(None, slot, 0), (Some(slot), slot + SLOT, 1)];
        let slots = slots.map(|(from, until, person)| Slot {
            from,
            until,
            who: [PersonId(person)].into(),
        });
        control.set_slots(now, ARM, (!forgets).then(|| slots.to_vec()));
        Self {
            control,
            now,
            control_time: now,
            slot,
            motions: Vec::new(),
            lease: None,
            left: Vec::new(),
        }
    }

    /// Carries out the decisions of control.
    fn obey_effects(&mut self) {
        while let Some(effect) = self.control.poll_effect() {
            match effect {
                Effect::Granted { lease, .. } => {
                    self.lease = self.control.holder(ARM).map(|holder| (holder, lease));
                }
                Effect::Holder { holder: None, .. } => self.lease = None,
                Effect::EndWork { requests, .. } => {
                    let ended = |motion: &Motion| requests.contains(&motion.request);
                    self.motions.retain(|motion| !ended(motion));
                }
                Effect::SessionOver(session) => self.left.retain(|(gone, _)| *gone != session),
                _ => {}
            }
        }
    }

    fn free_request(&self) -> RequestId {
        let used = |id: &RequestId| self.motions.iter().any(|motion| motion.request == *id);
        let free = (0..).map(RequestId).find(|id| !used(id));
        free.expect("numbers do not end")
    }

    fn acquire(&mut self, session: SessionId) {
        let request = self.free_request();
        self.control
            .acquire(self.control_time, session, ARM, request, Duration::ZERO);
        self.obey_effects();
    }

    /// Starts a motion. Returns false if control refuses it.
    fn begin(&mut self, session: SessionId) -> bool {
        let request = self.free_request();
        let kind = WorkKind::Motion;
        let begun = self
            .control
            .begin(self.control_time, session, ARM, request, kind);
        if begun.is_ok() {
            self.motions.push(Motion {
                session,
                request,
                free: false,
            });
        }
        begun.is_ok()
    }

    /// Releases a lease. A running motion continues to its end.
    fn release(&mut self, session: SessionId) {
        if let Some((holder, lease)) = self.lease
            && holder == session
        {
            self.control.release(self.control_time, session, lease);
            for motion in &mut self.motions {
                motion.free |= motion.session == session;
            }
            self.obey_effects();
        }
    }

    fn leave(&mut self, session: SessionId) {
        self.control.leave(self.control_time, session);
        self.left.push((session, self.now));
        self.obey_effects();
    }
}

impl World {
    pub(crate) fn new(bug: Option<Bug>) -> Self {
        // All clocks differ.
        let model = |station: u64| {
            let now = HostInstant::from_micros(60_000_000 + 1_000_000 * station);
            StationModel::new(now, now + SLOT, false)
        };
        Self {
            bug,
            stations: (0..STATIONS as u64).map(model).collect(),
            lines: vec![vec![None; STATIONS]; USERS],
            used: 0,
        }
    }

    pub(crate) fn has(&self, bug: Bug) -> bool {
        self.bug == Some(bug)
    }

    fn events_of(&self, user: usize, station: usize, out: &mut Vec<Event>) {
        out.push(Event::Call(user, station));
        let Some(line) = &self.lines[user][station] else {
            out.push(Event::Open(user, station));
            return;
        };
        if line.open && !line.cut && line.messages.len() < IN_FLIGHT {
            let said = [
                UserMessage::Acquire,
                UserMessage::Move,
                UserMessage::Release,
            ];
            out.extend(said.map(|said| Event::Send(user, station, said)));
        }
        if !line.messages.is_empty() {
            out.push(Event::Arrive(user, station));
        }
        if !line.cut {
            out.push(Event::Cut(user, station));
        }
        if line.open {
            out.push(Event::UserGone(user, station));
        }
        if line.end.is_some() {
            out.push(Event::StationNotices(user, station));
        }
    }

    /// Applies an event and checks all laws.
    fn apply(&mut self, before: &Self, event: Event) -> Checked {
        use Event::*;
        let furthest = self.stations.iter().map(|model| model.now).max();
        for model in &mut self.stations {
            model.control_time = match self.bug {
                Some(Bug::ForeignClock) => furthest.unwrap_or(model.now),
                _ => model.now,
            };
        }
        let station = match event {
            Open(_, at) | Send(_, at, _) | Arrive(_, at) | Cut(_, at) => at,
            UserGone(_, at) | StationNotices(_, at) | Call(_, at) => at,
            Finish(at) | Pass(at) | Kill(at) => at,
        };
        self.used = self.used.max(station + 1);
        match event {
            Open(user, at) => {
                let end = self.opened(user, at);
                self.lines[user][at] = Some(Line {
                    open: true,
                    cut: false,
                    messages: VecDeque::new(),
                    end: Some(end),
                });
            }
            Send(user, at, said) => self.line(user, at)?.messages.push_back(said),
            Arrive(user, at) => self.arrive(user, at)?,
            Cut(user, at) => {
                let line = self.line(user, at)?;
                line.cut = true;
                line.messages.clear();
            }
            UserGone(user, at) => self.line(user, at)?.open = false,
            StationNotices(user, at) => {
                let end = self.line(user, at)?.end.take().ok_or("an end")?;
                self.end(at, end.session);
            }
            Finish(at) => {
                let model = &mut self.stations[at];
                let motion = model.motions.remove(0);
                must(
                    model
                        .control
                        .finish(model.control_time, ARM, motion.request),
                    "what moves an arm is known",
                )?;
            }
            Pass(at) => self.pass(at),
            Kill(at) => self.kill(at),
            Call(user, at) => self.call(user, at)?,
        }
        self.stations
            .iter_mut()
            .for_each(StationModel::obey_effects);
        for line in self.lines.iter_mut().flatten() {
            // A line without ends carries no messages.
            line.take_if(|line| !line.open && line.end.is_none());
        }
        self.check(before, event)
    }

    fn line(&mut self, user: usize, at: usize) -> Result<&mut Line, String> {
        self.lines[user][at]
            .as_mut()
            .ok_or_else(|| "a line".to_owned())
    }

    /// Starts a session at the station.
    fn opened(&mut self, user: usize, at: usize) -> End {
        let model = &mut self.stations[at];
        let used = |id: &SessionId| {
            let ends = self.lines.iter().filter_map(|lines| lines[at].as_ref());
            let mut ends = ends.filter_map(|line| line.end.as_ref());
            ends.any(|end| end.session == *id) || model.left.iter().any(|(left, _)| left == id)
        };
        let mut ids = (user as u64..).step_by(USERS).map(SessionId);
        let session = ids.find(|id| !used(id)).unwrap_or(SessionId(0));
        model.control.join(model.control_time, session);
        if user < 2 {
            let person = Some(PersonId(user as u64));
            model.control.identify(model.control_time, session, person);
        }
        End {
            session,
            heard: model.now,
        }
    }

    /// Ends the socket of a session.
    fn end(&mut self, at: usize, session: SessionId) {
        if !self.has(Bug::LineOutlived) {
            self.stations[at].leave(session);
        }
    }

    fn arrive(&mut self, user: usize, at: usize) -> Checked {
        let line = self.line(user, at)?;
        let said = line.messages.pop_front().ok_or("a message")?;
        let Some(mut end) = line.end.take() else {
            return Ok(());
        };
        let model = &mut self.stations[at];
        end.heard = model.now;
        model.control.keep_alive(model.control_time, end.session);
        match said {
            UserMessage::Acquire => model.acquire(end.session),
            UserMessage::Move => {
                model.begin(end.session);
            }
            UserMessage::Release => model.release(end.session),
        }
        self.line(user, at)?.end = Some(end);
        Ok(())
    }

    fn pass(&mut self, at: usize) {
        let model = &mut self.stations[at];
        let due = model.control.poll_timeout();
        model.now = due.unwrap_or(model.now + SILENCE).max(model.now);
        model.control_time = model.control_time.max(model.now);
        model.control.handle_timeout(model.control_time);
        let now = model.now;
        model.left.retain(|(_, left)| now - *left < RECONNECT_GRACE);
    }

    /// Replaces a station by a restarted one, whose arm stands still.
    fn kill(&mut self, at: usize) {
        let (forgets, keeps) = (
            self.has(Bug::ScheduleForgotten),
            self.has(Bug::LeaseOutlivesKill),
        );
        let old = &self.stations[at];
        let mut new = StationModel::new(old.now, old.slot, forgets);
        if keeps {
            new.control = old.control.clone();
        }
        self.stations[at] = new;
        for lines in &mut self.lines {
            if let Some(line) = &mut lines[at] {
                line.end = None;
            }
        }
    }

    /// Makes one move in a session that ends at once.
    fn call(&mut self, user: usize, at: usize) -> Checked {
        let model = &mut self.stations[at];
        let session = SessionId(1_000_000 + user as u64);
        model.control.join(model.control_time, session);
        if user < 2 {
            let person = Some(PersonId(user as u64));
            model.control.identify(model.control_time, session, person);
        }
        model.acquire(session);
        if model.begin(session) {
            let motion = model.motions.pop().ok_or("a motion")?;
            model
                .control
                .finish(model.control_time, ARM, motion.request);
        }
        model.control.release_all(model.control_time, session);
        model.control.expel(model.control_time, session);
        Ok(())
    }
}

impl Explored for World {
    type Event = Event;

    fn events(&self) -> Vec<Event> {
        let mut out = Vec::new();
        for station in (0..STATIONS).take_while(|station| *station <= self.used) {
            for user in 0..USERS {
                self.events_of(user, station, &mut out);
            }
            let model = &self.stations[station];
            if !model.motions.is_empty() {
                out.push(Event::Finish(station));
            }
            out.extend([Event::Pass(station), Event::Kill(station)]);
        }
        out
    }

    fn step(&mut self, before: &Self, event: Event) -> Checked {
        self.apply(before, event)
    }

    fn key(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.used.hash(&mut hasher);
        for model in &self.stations {
            model.control.canonical(model.now).hash(&mut hasher);
            let age = |at: &HostInstant| model.now - *at;
            model.motions.hash(&mut hasher);
            // Only two slots matter; after them all times are alike.
            let slot = (model.now - model.slot, model.slot - model.now);
            (slot.0.min(SLOT), slot.1).hash(&mut hasher);
            for (session, at) in &model.left {
                (session, age(at)).hash(&mut hasher);
            }
            model.lease.map(|(session, _)| session).hash(&mut hasher);
        }
        for line in self
            .lines
            .iter()
            .flat_map(|lines| self.stations.iter().zip(lines))
        {
            let (model, Some(line)) = line else {
                false.hash(&mut hasher);
                continue;
            };
            (line.open, line.cut, &line.messages).hash(&mut hasher);
            if let Some(end) = &line.end {
                let silent = (model.now - end.heard).min(LEASE_TIMEOUT);
                (end.session, silent).hash(&mut hasher);
            }
        }
        if self.has(Bug::ForeignClock) {
            let nows = self.stations.iter().map(|model| model.now);
            nows.collect::<Vec<_>>().hash(&mut hasher);
        }
        hasher.finish()
    }
}
