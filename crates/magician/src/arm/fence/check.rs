//! Checks of outgoing frames against the fence.

use magician_host::picture::{is_near, place};
use magician_protocol::commands::{Pose, QueuedCmdStartExec};
use magician_protocol::{Frame, Row, Set, Writable};
use tokio::time::{Instant, sleep, timeout_at};

use super::{FenceState, FrameClass, SendPermit};
use crate::arm::Arm;
use crate::arm::disruptions::Disruptions;
use crate::arm::halt::REST_POLL_INTERVAL;
use crate::preflight::{Guards, Needs, Preflight, Readings};
use crate::{Action, Error, ErrorCode, Message, Result, message};

/// Connection with its fence.
#[derive(Clone, Copy)]
pub(in crate::arm) struct FenceCheck<'a> {
    pub(super) arm: &'a Arm,
    pub(super) held: &'a FenceState,
}

impl<'a> FenceCheck<'a> {
    fn disruptions(self) -> &'a Disruptions {
        &self.arm.inner.shared.disruptions
    }

    /// Invalidates the prediction: the arm has to be read again.
    fn forget(self) {
        self.disruptions().depart();
    }

    /// Checks a frame. Returns the right to send it now, or `None` if it needs none.
    pub(in crate::arm) async fn hold_frame(
        self,
        frame: &Frame<'_>,
        deadline: Instant,
    ) -> Result<Option<SendPermit<'a>>> {
        let turn = match FrameClass::of(frame) {
            FrameClass::Free => self.check_power(frame).map(|()| None),
            FrameClass::Ends => {
                self.forget();
                Ok(None)
            }
            FrameClass::Unknown(_) | FrameClass::Releases if !self.held.bounds_motion() => Ok(None),
            FrameClass::Unknown(why) => Err(refused(&Message::word(why))),
            FrameClass::Releases => self.hold_release(frame, deadline).await.map(Some),
            FrameClass::Governs(command) => {
                self.check_power(frame)?;
                if self.held.bounds_motion() {
                    let queued = frame.ctrl().queued();
                    let turn = self.hold_command(&command, queued, deadline).await;
                    turn.map(Some)
                } else {
                    Ok(None)
                }
            }
        };
        turn.map_err(|error| match error.command() {
            Some(_) => error,
            None => error.with_command(crate::arm::driver::command_name(frame)),
        })
    }

    /// Checks the laser power, which does not depend on the arm's position.
    fn check_power(self, frame: &Frame<'_>) -> Result<()> {
        let ctrl = frame.ctrl();
        let burns = self.held.fence().and_then(|fence| fence.strongest_laser());
        if burns.is_none() || !(ctrl.write() || ctrl.queued()) {
            return Ok(());
        }
        let may = Row::with_id(frame.id()).is_some_and(|row| row.may_burn);
        match Set::decode(frame.id(), frame.params()) {
            Ok(command) => self
                .arm
                .fenced(Preflight::new(&Readings::default()))
                .check_power(&command),
            Err(_) if may => Err(refused(&message!("its parameters cannot be read"))),
            // A command that never burns may have any parameters.
            Err(_) => Ok(()),
        }
    }

    async fn take(self, deadline: Instant) -> Result<SendPermit<'a>> {
        let prediction = timeout_at(deadline, self.held.prediction.lock()).await;
        let prediction = prediction.map_err(|_| {
            let message = message!(
                "a run is under way, or another call is being checked against the arm's fence"
            );
            Error::new(ErrorCode::NotSent, message)
        })?;
        Ok(SendPermit {
            disruptions: self.disruptions(),
            prediction,
            then: None,
            first: false,
            breaks: self.disruptions().total(),
        })
    }

    /// Checks a motion, or a setting that affects motion.
    async fn hold_command(
        self,
        command: &Set,
        queued: bool,
        deadline: Instant,
    ) -> Result<SendPermit<'a>> {
        let mut turn = self.take(deadline).await?;
        let mut check = if queued {
            self.course_end(&mut turn).await?
        } else {
            self.read_standing(&mut turn).await?
        };
        check.check(command)?;
        if queued {
            turn.then = Some(check);
        } else {
            // The end of an immediate motion is not observed.
            self.forget();
        }
        Ok(turn)
    }

    /// Returns the check at the end of all waiting commands.
    async fn course_end(self, turn: &mut SendPermit<'_>) -> Result<Preflight> {
        if turn.prediction.breaks == turn.breaks
            && let Some(end) = turn.prediction.end.clone()
            && self.waits_in_order(turn).await?
        {
            return Ok(end);
        }
        self.read_standing(turn).await
    }

    /// True if the predicted commands still wait or run, and no others do.
    async fn waits_in_order(self, turn: &mut SendPermit<'_>) -> Result<bool> {
        let waiting = u64::from(self.arm.queue().waiting().await?);
        let ours = turn
            .prediction
            .waiting(self.arm.queue().current_index().await?.0);
        // The command in progress may be counted as waiting or not, so fewer is fine too.
        Ok(ours > 0 && waiting <= ours)
    }

    /// Reads everything a motion depends on, from an arm at rest with an empty queue.
    async fn read_standing(self, turn: &mut SendPermit<'_>) -> Result<Preflight> {
        self.arm.come_to_rest().await?;
        let look = self.arm.known().read_queue().await?;
        if look.waiting() > 0 {
            return Err(refused(&message!(
                "its queue has unchecked commands, waiting or running; wait until they have \
                    finished"
            ))
            .remedy(Action::Stop, DROPS));
        }
        if self.arm.moving() {
            self.arm.wait_still().await?;
        }
        let on_rail = (self
            .arm
            .known()
            .setting::<magician_protocol::commands::DeviceWithL>()
            .await)
            .is_ok_and(|rail| rail.with_l.is_on());
        let check = self.arm.read(Needs::all(on_rail), on_rail, &look).await?;
        let Some(start) = check.arm().map(|start| start.pose.to_array()) else {
            return Err(refused(&message!("it moves; wait until it has stopped")));
        };
        turn.first = true;
        turn.prediction.end = None;
        turn.prediction.last = look.current;
        turn.prediction.stations.clear();
        turn.prediction
            .stations
            .push_back((look.current, Some(start)));
        Ok(check.guards(Guards::NONE.reach(true).unknown_start(true)))
    }

    /// Checks a frame that starts the queue: only commands checked from where the arm stands may
    /// wait in it.
    async fn hold_release(self, frame: &Frame<'_>, deadline: Instant) -> Result<SendPermit<'a>> {
        let turn = self.take(deadline).await?;
        let waiting = self.arm.queue().waiting().await?;
        if waiting == 0 {
            // Clearing an alarm may also release a motion outside of the queue.
            if frame.id() != QueuedCmdStartExec::ROW.id {
                self.forget();
            }
            return Ok(turn);
        }
        let current = self.arm.queue().current_index().await?.0;
        let known = turn.prediction.breaks == turn.breaks && turn.prediction.end.is_some();
        let ours = turn.prediction.waiting(current);
        if !known || u64::from(waiting) > ours {
            let unchecked = match waiting {
                1 => {
                    message!("1 command waits in its queue that was not checked from its position")
                }
                _ => message!("commands wait in its queue that were not checked from its position"),
            };
            return Err(refused(&unchecked).remedy(Action::Stop, DROPS));
        }
        if frame.id() == QueuedCmdStartExec::ROW.id {
            if self.arm.picture().motion().stopped() {
                self.stands_at_station(&turn, current).await?;
            }
            return Ok(turn);
        }
        // Commands that an alarm has cut short count as finished, wherever the arm was.
        if self.arm.alarms().await?.blocking() {
            return Err(refused(&message!(
                "an alarm holds commands in its queue that were planned from another position"
            ))
            .remedy(Action::Stop, DROPS));
        }
        let before: Pose = self.arm.get().await?;
        // Twice the interval of rest reads, so that even a slow motion shows as two different
        // poses.
        sleep(2 * REST_POLL_INTERVAL).await;
        if self.arm.get::<Pose>().await? == before {
            self.stands_at_station(&turn, current).await?;
        }
        Ok(turn)
    }

    /// Checks that an arm at rest was not moved since its last command.
    async fn stands_at_station(self, turn: &SendPermit<'_>, current: u64) -> Result<()> {
        let mut stations = turn.prediction.stations.iter().rev();
        let station = stations.find(|(index, _)| *index <= current);
        let station = station.and_then(|(_, pose)| *pose);
        let stands = place(&self.arm.get().await?);
        let is_there = station.is_some_and(|station| is_near(station, stands));
        if is_there {
            Ok(())
        } else {
            let why = message!("it is not where its last command left it");
            Err(refused(&why).remedy(Action::Stop, DROPS))
        }
    }

    /// Acquires the right to jog, with the start position.
    pub(in crate::arm) async fn hold_jog(
        self,
        deadline: Instant,
    ) -> Result<Option<(SendPermit<'a>, Preflight)>> {
        if !self.held.bounds_motion() {
            return Ok(None);
        }
        let mut turn = self.take(deadline).await?;
        let check = self.read_standing(&mut turn).await?;
        self.forget();
        Ok(Some((turn, check)))
    }

    /// Acquires the right to run a program, with its start position.
    pub(in crate::arm) async fn hold_run(self, begins: bool) -> Result<Option<SendPermit<'a>>> {
        if !self.held.bounds_motion() {
            return Ok(None);
        }
        let mut turn = self.take(self.arm.call_deadline()).await?;
        if begins {
            turn.then = Some(self.course_end(&mut turn).await?);
        }
        Ok(Some(turn))
    }
}

/// Effect of a stop on the queue, as a remedy.
const DROPS: &str = "drops the waiting commands";

/// Returns the error for a frame that cannot be checked against a fence.
fn refused(why: &Message) -> Error {
    Error::guarded(
        "fence",
        message!("this arm has a fence, and {why}; nothing was sent", why),
    )
}
