//! Reconnecting: opening the line again, and making sure that the same arm is on it.
//!
//! The stages are those of [`Stage`]: lost, opening, identifying (reads the identity of the arm),
//! settling (read clock, index and places), up. Any failure leads back to lost and to another
//! attempt.

use std::io;
use std::task::{Context, Poll};
use std::time::Duration;

use magician_protocol::NoArgs;
use magician_protocol::commands::{
    DeviceSn, DeviceTime, QueuedCmdCurrentIndex, QueuedCmdLeftSpace,
};
use tokio::time::Instant;

use super::identification::{Identification, IdentityResult};
use super::line::{RECONNECT_INTERVAL, Stage};
use super::{Driver, ReplyTarget};
use crate::Result;
use crate::arm::events::Event;
use crate::arm::link::Link;
use crate::connection::{Micros, Request};
use crate::{Message, message};

/// Interval of the attempts after another arm was found. Choice: slower, since a person has to
/// replug.
const OTHER_ARM_RETRY_INTERVAL: Micros = 1_000_000;
/// Delay after connecting before the identity is read, so that short programs do not pay for it.
/// Choice.
pub(super) const IDENTITY_READ_DELAY: Micros = 100_000;
/// Longest time for non-urgent answers. Choice.
const ANSWER_TIMEOUT: Duration = Duration::from_millis(500);
/// Longest time for the state reads on a reconnected line. Choice.
const MAX_SETTLING_TIME: Duration = Duration::from_secs(1);

impl Driver {
    /// Advances the search for the line; true if anything happened.
    pub(super) fn search_line(&mut self, cx: &mut Context<'_>, now: Micros) -> bool {
        match &mut self.line.stage {
            Stage::Lost(Some(look)) if *look <= now => {
                let Some(opener) = &mut self.line.opener else {
                    return false;
                };
                self.line.stage = Stage::Opening(opener());
                true
            }
            Stage::Opening(opening) => {
                let Poll::Ready(opened) = opening.as_mut().poll(cx) else {
                    return false;
                };
                match opened {
                    Ok(line) => {
                        let laser_off = self.laser_off_requests();
                        let is_named = self.shared.picture().serial().is_some();
                        let identification = Identification::new(now, line, is_named, laser_off);
                        self.line.stage = Stage::Identifying(identification);
                    }
                    Err(error) => {
                        tracing::debug!(%error, "{}: not found yet", self.shared.name);
                        self.schedule_search(RECONNECT_INTERVAL);
                    }
                }
                true
            }
            Stage::Identifying(identification) => {
                if self.owes_halt {
                    identification.stop_instead();
                }
                let (busy, identity) = identification.poll(cx, now);
                if let Some(identity) = identity {
                    self.handle_identity(identity);
                }
                busy
            }
            Stage::Lost(_) | Stage::Up(_) | Stage::Settling { .. } => false,
        }
    }

    /// Decides if the line leads to the known arm.
    fn handle_identity(&mut self, identity: IdentityResult) {
        match identity {
            Err(why) => {
                tracing::debug!("{}: {why}", self.shared.name);
                self.schedule_search(RECONNECT_INTERVAL);
            }
            Ok(serial) => {
                let known = self.shared.picture().serial().map(str::to_owned);
                match known.filter(|known| Some(known) != serial.as_ref()) {
                    Some(known) => {
                        let other_arm = self.describe_other_arm(&known, serial.as_deref());
                        self.refuse_other_arm(other_arm);
                    }
                    None => self.settle(),
                }
            }
        }
    }

    fn describe_other_arm(&self, known: &str, other: Option<&str>) -> Message {
        let other = other.map_or_else(
            || message!("it has no serial number"),
            |other| message!("its serial number is {other}", other),
        );
        message!(
            "another arm answers at {name}: {other}, and this connection is to {known}; plug that \
                one in again, or reconnect",
            name = self.shared.name,
            other,
            known
        )
    }

    fn refuse_other_arm(&mut self, other_arm: Message) {
        self.schedule_search(OTHER_ARM_RETRY_INTERVAL);
        if let Some(lost) = &mut self.line.lost
            && lost.other_arm.as_ref() != Some(&other_arm)
        {
            tracing::warn!("{other_arm}");
            lost.other_arm = Some(other_arm);
            self.publish_loss();
        }
    }

    /// Reads the progress of the known arm before the line is used again.
    fn settle(&mut self) {
        // Taken out of the state, because the wire moves on to the next stage.
        let stage = std::mem::replace(&mut self.line.stage, Stage::Lost(None));
        let Stage::Identifying(identification) = stage else {
            return;
        };
        let requests = [
            Request::get::<DeviceTime>(&NoArgs),
            Request::get::<QueuedCmdCurrentIndex>(&NoArgs),
            Request::get::<QueuedCmdLeftSpace>(&NoArgs),
        ];
        let laser_switched_off = identification.switches_laser_off();
        let still_moves = identification.to_stop() && !self.owes_halt;
        self.shared
            .picture()
            .found_dark(identification.laser_off_pose());
        self.line.stage = Stage::Settling {
            wire: identification.into_wire(),
            left: requests.len(),
            reset: false,
        };
        // The connection keeps its indices: they decide which commands the arm has taken.
        self.connection.restored();
        if laser_switched_off {
            self.connection.was_cleared();
            self.shared.cleared();
            tracing::warn!(
                "{}: the laser may have burnt while the line was lost: it was switched off, and \
                    the arm's queue was cleared",
                self.shared.name
            );
        }
        if still_moves {
            // The outcome of the motion in progress is unknown, so a run ends with it.
            self.shared.stop();
            tracing::warn!("{}: the arm still moved, and was stopped", self.shared.name);
        }
        // Before the state reads, so that a requested stop is not delayed by them.
        if self.owes_halt || still_moves {
            self.halt(Vec::new());
        }
        let deadline = Instant::now() + MAX_SETTLING_TIME;
        for request in requests.into_iter().flatten() {
            self.submit(request, deadline, ReplyTarget::Settling);
        }
    }

    /// Handles an answer of a reconnected arm.
    pub(super) fn handle_settling_answer(&mut self, answer: Result<()>) {
        let Stage::Settling { left, .. } = &mut self.line.stage else {
            return;
        };
        if answer.is_err() {
            // The line fell silent again, and the state of its queue is unknown.
            self.lose(&io::ErrorKind::TimedOut.into());
            return;
        }
        *left = left.saturating_sub(1);
        if *left > 0 {
            return;
        }
        let stage = std::mem::replace(&mut self.line.stage, Stage::Lost(None));
        if let Stage::Settling { wire, reset, .. } = stage {
            self.line.stage = Stage::Up(wire);
            // Only now: until the state is read, calls fail with the original cause.
            self.line.lost = None;
            tracing::info!(reset, "{}: the line is up again", self.shared.name);
            self.publish_link(Link::Up);
            self.happens(Event::LinkFound { reset });
            if self.owes_halt {
                self.halt(Vec::new());
            }
        }
    }

    /// Notes a reset of the arm, perhaps while the line was lost.
    pub(super) fn note_reset(&mut self) {
        if let Stage::Settling { reset, .. } = &mut self.line.stage {
            *reset = true;
        }
    }

    /// Reads the identity of the arm once, and its clock, which later shows a reset.
    pub(super) fn read_identity(&mut self, now: Micros) {
        if self.identity_read_at.take_if(|at| *at <= now).is_none() {
            return;
        }
        let deadline = self.at(now) + ANSWER_TIMEOUT;
        let requests = [
            Request::get::<DeviceSn>(&NoArgs),
            Request::get::<DeviceTime>(&NoArgs),
        ];
        for request in requests.into_iter().flatten() {
            self.submit(request, deadline, ReplyTarget::Discard);
        }
    }
}
