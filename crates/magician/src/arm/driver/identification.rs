//! Identification of the arm on a reconnected line.
//!
//! The line may lead to another arm, so the arm is examined over a separate connection. If the
//! laser may have burnt while the line was lost, the first frames switch it off and pause the
//! queue; the queue is cleared once the arm is at rest. Only then is the arm asked for its version.
//! It is asked for its serial number too if the serial number of the known arm can be compared.

use std::task::Context;

use magician_host::picture::{LaserOffTracker, serial_number};
use magician_protocol::NoArgs;
use magician_protocol::commands::{DeviceSn, DeviceVersion, Pose, QueuedCmdClear};

use super::wire::Wire;
use crate::connection::{Connection, Event, Micros, Priority, Request, Settings, Ticket};
use crate::transport::Line;
use crate::{REST_READ_INTERVAL, RestDetector};

/// Longest time for an answer during identification. Choice: afterwards the search opens the line
/// again.
const ANSWER_TIMEOUT: Micros = 1_000_000;
/// Longest wait for the motion in progress to end by itself; its laser may burn on that long. A
/// piece of a burn lasts at most the laser horizon of its run (1 s by default); the rest is for
/// slowing down and for seeing the arm at rest.
const MOTION_END: Micros = 2_000_000;

/// Wait until an arm with a paused queue is at rest, so that the queue can be cleared. A Clear
/// could cut off the motion, which the arm would count as finished (model section 14).
#[derive(Debug)]
struct Clearing {
    rest: RestDetector,
    /// Time of the next pose reading.
    due: Micros,
    /// Deadline: an arm that still moves then is stopped.
    until: Micros,
}

/// Line on which the arm is being identified, over a separate connection: answers of another arm
/// must not be attributed to the known one.
pub(super) struct Identification {
    wire: Wire,
    connection: Connection,
    /// Unanswered requests that switch the laser off and clear the queue. They precede every
    /// question.
    laser_off_requests: Vec<Ticket>,
    clearing: Option<Clearing>,
    /// True if a stop has to clear the queue, because the arm did not come to rest in time.
    to_stop: bool,
    switches_laser_off: bool,
    /// Pose at which the laser was switched off.
    laser_off_pose: Option<LaserOffTracker>,
    /// Unanswered read of the pose.
    pose: Option<Ticket>,
    /// Set until the identity was requested; true if the serial number is needed too.
    asks: Option<bool>,
    /// Unanswered questions.
    version: Option<Ticket>,
    serial: Option<Ticket>,
    /// Serial number in the answer.
    serial_number: Option<String>,
}

/// Identity of the arm: its serial number, or `None` if it was not asked for or the arm has none.
/// The error says why no arm was identified.
pub(super) type IdentityResult = Result<Option<String>, String>;

impl Identification {
    /// Starts identification on a line. With `ask_serial` the serial number is read as well, for
    /// comparison with the known one. The requests in `laser_off`, which switch the laser off, are
    /// sent first.
    pub(super) fn new(now: Micros, line: Line, ask_serial: bool, laser_off: Vec<Request>) -> Self {
        let settings = Settings {
            // An unknown arm may not take requests back to back.
            window: 1,
            ..line.settings
        };
        let mut identification = Self {
            wire: Wire::new(line.transport),
            connection: Connection::new(settings),
            switches_laser_off: !laser_off.is_empty(),
            laser_off_pose: (!laser_off.is_empty()).then(|| LaserOffTracker::with_pose_asked(now)),
            pose: None,
            laser_off_requests: Vec::new(),
            clearing: (!laser_off.is_empty()).then(|| Clearing {
                rest: RestDetector::default(),
                due: now,
                until: now.saturating_add(MOTION_END),
            }),
            to_stop: false,
            asks: Some(ask_serial),
            version: None,
            serial: None,
            serial_number: None,
        };
        identification.laser_off_requests = (laser_off.into_iter())
            .map(|request| {
                identification
                    .connection
                    .submit(request.deadline(until(now)))
            })
            .collect();
        if identification.switches_laser_off {
            // The pose is read after those requests, at stop priority, which waits for no other
            // request.
            let pose = Request::get::<Pose>(&NoArgs).ok();
            let pose = pose.map(|pose| pose.priority(Priority::Stop));
            identification.pose =
                pose.map(|pose| identification.connection.submit(pose.deadline(until(now))));
        }
        identification.ask(now);
        identification
    }

    /// Asks for the identity once the laser is off and the queue is cleared; true if anything was
    /// asked.
    fn ask(&mut self, now: Micros) -> bool {
        if !self.laser_off_requests.is_empty() {
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

    /// Clears the queue once the arm is at rest, and reads poses until then; true if anything was
    /// sent.
    fn clear(&mut self, now: Micros) -> bool {
        let Some(clearing) = &mut self.clearing else {
            return false;
        };
        if clearing.rest.is_at_rest() {
            self.clearing = None;
            let clear = Request::set(&QueuedCmdClear {}).ok();
            // At stop priority: the clear must not wait behind other questions.
            let clear = clear.map(|clear| clear.priority(Priority::Stop).deadline(until(now)));
            self.laser_off_requests = (clear.into_iter())
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

    /// Leaves clearing the queue to a stop, which follows as soon as the arm is identified, so that
    /// nothing waits for the end of a motion.
    pub(super) fn stop_instead(&mut self) {
        self.to_stop |= self.clearing.take().is_some();
    }

    pub(super) fn poll_timeout(&self) -> Option<Micros> {
        let clearing = self
            .clearing
            .as_ref()
            .filter(|_| self.laser_off_requests.is_empty());
        let clearing = clearing.filter(|_| self.pose.is_none());
        let pose = clearing.map(|clearing| clearing.due);
        self.connection.poll_timeout().into_iter().chain(pose).min()
    }

    pub(super) fn handle_timeout(&mut self, now: Micros) {
        if self.connection.poll_timeout().is_some_and(|at| at <= now) {
            self.connection.handle_timeout(now);
        }
    }

    /// Reads and writes; returns whether anything happened, and the identity once it is known.
    pub(super) fn poll(
        &mut self,
        cx: &mut Context<'_>,
        now: Micros,
    ) -> (bool, Option<IdentityResult>) {
        let read = self.wire.read(cx, now, &mut self.connection);
        let wrote = self.wire.write(cx, now, &mut self.connection, |_| {});
        if let Some(identity) = self.handle_events(now) {
            return (true, Some(identity));
        }
        let asked = self.ask(now);
        match (read, wrote) {
            (Ok(read), Ok(wrote)) => (read || wrote || asked, None),
            // Another attempt opens the line anew, so the kind of error does not matter.
            (Err(error), _) | (_, Err(error)) => (true, Some(Err(error.to_string()))),
        }
    }

    fn handle_events(&mut self, now: Micros) -> Option<IdentityResult> {
        while let Some(event) = self.connection.poll_event() {
            let Event::Done { ticket, result } = event else {
                continue;
            };
            if self.pose.take_if(|asked| *asked == ticket).is_some() {
                // An arm that does not answer this read is still present.
                let pose = result
                    .ok()
                    .and_then(|reply| reply.frame().read::<Pose>().ok());
                if let (Some(laser_off_pose), Some(pose)) = (&mut self.laser_off_pose, pose) {
                    laser_off_pose.see(now, pose);
                }
                if let (Some(clearing), Some(pose)) = (&mut self.clearing, pose) {
                    clearing.rest.see(now, pose);
                }
                continue;
            }
            let Ok(reply) = result else {
                return Some(Err("a line is there but no arm answers yet".to_owned()));
            };
            if let Some(at) = self
                .laser_off_requests
                .iter()
                .position(|said| *said == ticket)
            {
                self.laser_off_requests.swap_remove(at);
            } else if self.version.take_if(|asked| *asked == ticket).is_none() {
                self.serial = None;
                self.serial_number = serial_number(reply.frame().params());
            }
        }
        let asked = [self.version, self.serial, self.pose];
        let known = self.asks.is_none() && asked.iter().all(Option::is_none);
        known.then(|| Ok(self.serial_number.take()))
    }

    /// True if the laser was switched off, and the queue cleared or left to a stop.
    pub(super) fn switches_laser_off(&self) -> bool {
        self.switches_laser_off
    }

    /// True if a stop has to clear the queue.
    pub(super) fn to_stop(&self) -> bool {
        self.to_stop
    }

    /// Returns the pose at which the laser was switched off, as far as known.
    pub(super) fn laser_off_pose(&self) -> Option<LaserOffTracker> {
        self.laser_off_pose
    }

    pub(super) fn into_wire(self) -> Wire {
        self.wire
    }
}

/// Returns the deadline of a request sent now.
fn until(now: Micros) -> Micros {
    now.saturating_add(ANSWER_TIMEOUT)
}
