//! Identifies the arm at the end of a line that was found again.

use std::task::Context;

use magician_host::picture::{Darkness, serial_number};
use magician_protocol::NoArgs;
use magician_protocol::commands::{DeviceSn, DeviceVersion, Pose, QueuedCmdClear};

use super::wire::Wire;
use crate::connection::{Connection, Event, Micros, Priority, Request, Settings, Ticket};
use crate::transport::Line;
use crate::{REST_READ_INTERVAL, RestDetector};

/// How long it may take to identify itself.
const PATIENCE: Micros = 1_000_000;
/// Longest time for the motion under way to end by itself: its laser may burn on that long. A piece of a burn lasts the laser
/// horizon of its run at most, 1 s unless the caller sets another, and then the arm slows down and has to be seen at rest.
const MOTION_END: Micros = 2_000_000;

/// Wait for an arm whose queue is held to come to rest, so that the queue can be cleared. A Clear may end a motion where it is,
/// and the arm would count it as finished (model section 14).
#[derive(Debug)]
struct Clearing {
    rest: RestDetector,
    /// When the next pose is due.
    due: Micros,
    /// Deadline: an arm that still moves is stopped.
    until: Micros,
}

/// A line on which the arm is identified, over a connection of its own: what another arm answers must not be taken
/// for the word of the one of before.
pub(super) struct Greeting {
    wire: Wire,
    connection: Connection,
    /// Requests that put a laser out and empty the queue, which were not answered yet. They go out
    /// before anything is asked.
    dark: Vec<Ticket>,
    clearing: Option<Clearing>,
    /// True if the queue has still to be cleared, by a stop.
    to_stop: bool,
    darkens: bool,
    /// Where the arm was when its laser was put out, and the question for it.
    darkness: Option<Darkness>,
    pose: Option<Ticket>,
    /// Not identified yet; whether its serial number is needed too.
    asks: Option<bool>,
    /// Questions that have not been answered.
    version: Option<Ticket>,
    serial: Option<Ticket>,
    /// What it says its serial number is.
    said: Option<String>,
}

/// The identity: a serial number, `None` when it was not asked for or there is none. Or why there is no arm.
pub(super) type Met = Result<Option<String>, String>;

impl Greeting {
    /// `ask_serial`: a serial number is known that it can be compared with. `dark`: what is said first.
    pub(super) fn new(now: Micros, line: Line, ask_serial: bool, dark: Vec<Request>) -> Self {
        let settings = Settings {
            window: 1,
            ..line.settings
        };
        let mut greeting = Self {
            wire: Wire::new(line.transport),
            connection: Connection::new(settings),
            darkens: !dark.is_empty(),
            darkness: (!dark.is_empty()).then(|| Darkness::with_pose_asked(now)),
            pose: None,
            dark: Vec::new(),
            clearing: (!dark.is_empty()).then(|| Clearing {
                rest: RestDetector::default(),
                due: now,
                until: now.saturating_add(MOTION_END),
            }),
            to_stop: false,
            asks: Some(ask_serial),
            version: None,
            serial: None,
            said: None,
        };
        greeting.dark = (dark.into_iter())
            .map(|request| greeting.connection.submit(request.deadline(until(now))))
            .collect();
        if greeting.darkens {
            // Behind them, in the lane that waits for nothing else.
            let pose = Request::get::<Pose>(&NoArgs).ok();
            let pose = pose.map(|pose| pose.priority(Priority::Stop));
            greeting.pose = pose.map(|pose| greeting.connection.submit(pose.deadline(until(now))));
        }
        greeting.ask(now);
        greeting
    }

    /// Asks for the identity, once the laser is off and the queue is empty; true if anything was asked.
    fn ask(&mut self, now: Micros) -> bool {
        if !self.dark.is_empty() {
            return false;
        }
        if self.clearing.is_some() {
            return self.clear(now);
        }
        let Some(serial) = self.asks.take() else {
            return false;
        };
        let connection = &mut self.connection;
        let mut ask = |request: Result<Request, _>| {
            let request: Option<Request> = request.ok();
            request.map(|request| connection.submit(request.deadline(until(now))))
        };
        self.version = ask(Request::get::<DeviceVersion>(&NoArgs));
        self.serial = serial
            .then(|| ask(Request::get::<DeviceSn>(&NoArgs)))
            .flatten();
        true
    }

    /// Clears the queue once the arm stands, and reads its pose until then; true if anything was sent.
    fn clear(&mut self, now: Micros) -> bool {
        let Some(clearing) = &mut self.clearing else {
            return false;
        };
        if clearing.rest.is_at_rest() {
            self.clearing = None;
            let clear = Request::set(&QueuedCmdClear {}).ok();
            let clear = clear.map(|clear| clear.priority(Priority::Stop).deadline(until(now)));
            self.dark = (clear.into_iter())
                .map(|clear| self.connection.submit(clear))
                .collect();
            return true;
        }
        if self.pose.is_some() {
            return false;
        }
        if clearing.until <= now {
            self.stop_instead();
            return true;
        }
        if now < clearing.due {
            return false;
        }
        let pose = Request::get::<Pose>(&NoArgs).ok();
        clearing.due = now.saturating_add(REST_READ_INTERVAL);
        self.pose = pose.map(|pose| self.connection.submit(pose.deadline(until(now))));
        true
    }

    /// Leaves the queue to a stop, which clears it and follows as soon as the arm is identified: nothing waits for a motion to
    /// end any more.
    pub(super) fn stop_instead(&mut self) {
        self.to_stop |= self.clearing.take().is_some();
    }

    pub(super) fn poll_timeout(&self) -> Option<Micros> {
        let clearing = self.clearing.as_ref().filter(|_| self.dark.is_empty());
        let clearing = clearing.filter(|_| self.pose.is_none());
        let pose = clearing.map(|clearing| clearing.due);
        self.connection.poll_timeout().into_iter().chain(pose).min()
    }

    pub(super) fn let_time_pass(&mut self, now: Micros) {
        if self.connection.poll_timeout().is_some_and(|at| at <= now) {
            self.connection.handle_timeout(now);
        }
    }

    /// Reads and writes; returns whether anything happened, and the identity once it is known.
    pub(super) fn go_on(&mut self, cx: &mut Context<'_>, now: Micros) -> (bool, Option<Met>) {
        let read = self.wire.read(cx, now, &mut self.connection);
        let wrote = self.wire.write(cx, now, &mut self.connection, |_| {});
        if let Some(met) = self.hear(now) {
            return (true, Some(met));
        }
        let asked = self.ask(now);
        match (read, wrote) {
            (Ok(read), Ok(wrote)) => (read || wrote || asked, None),
            (Err(error), _) | (_, Err(error)) => (true, Some(Err(error.to_string()))),
        }
    }

    fn hear(&mut self, now: Micros) -> Option<Met> {
        while let Some(event) = self.connection.poll_event() {
            let Event::Done { ticket, result } = event else {
                continue;
            };
            if self.pose.take_if(|asked| *asked == ticket).is_some() {
                // An arm that does not tell it is there all the same.
                let pose = result
                    .ok()
                    .and_then(|reply| reply.frame().read::<Pose>().ok());
                if let (Some(darkness), Some(pose)) = (&mut self.darkness, pose) {
                    darkness.see(now, pose);
                }
                if let (Some(clearing), Some(pose)) = (&mut self.clearing, pose) {
                    clearing.rest.see(now, pose);
                }
                continue;
            }
            let Ok(reply) = result else {
                return Some(Err("a line is there but no arm answers yet".to_owned()));
            };
            if let Some(at) = self.dark.iter().position(|said| *said == ticket) {
                self.dark.swap_remove(at);
            } else if self.version.take_if(|asked| *asked == ticket).is_none() {
                self.serial = None;
                self.said = serial_number(reply.frame().params());
            }
        }
        let asked = [self.version, self.serial, self.pose];
        let known = self.asks.is_none() && asked.iter().all(Option::is_none);
        known.then(|| Ok(self.said.take()))
    }

    /// True if it has put a laser out, and emptied the queue or left that to a stop.
    pub(super) fn darkens(&self) -> bool {
        self.darkens
    }

    /// True if a stop has to clear the queue.
    pub(super) fn to_stop(&self) -> bool {
        self.to_stop
    }

    /// Where the arm was when its laser was put out, as far as that is known.
    pub(super) fn darkness(&self) -> Option<Darkness> {
        self.darkness
    }

    pub(super) fn into_wire(self) -> Wire {
        self.wire
    }
}

/// When it has to have answered.
fn until(now: Micros) -> Micros {
    now.saturating_add(PATIENCE)
}
