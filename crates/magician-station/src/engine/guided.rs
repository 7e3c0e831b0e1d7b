//! Teaching by hand: reports the pose at each release of the arm's unlock key.
//!
//! The holder of the lease switches reporting on and off. Each switch takes several commands, which
//! change or restore settings of the arm. A state machine completes one switch before it starts the
//! next, so the arm's original settings are restored however quickly a client toggles.

use std::future::{Future, pending};
use std::pin::Pin;

use magician::commands::Pose;
use magician::{Arm, ErrorKind, message};
use magician_job::teach::guided_points;
use magician_job::{Polled, SavedSettings};
use magician_program::Travel;
use serde_json::Value;

use super::EngineTask;
use super::reads::capture;
use crate::api::{ArmEvent, RpcError};
use crate::control::RequestId;
use crate::order::{ArmReport, Outcome};

/// State of the reporting, and the state that is wanted.
#[derive(Default)]
pub(super) struct Guided {
    wanted: bool,
    /// True to report even if the arm is not known to be homed.
    unhomed: bool,
    now: GuideState,
    /// Requests that are answered when the wanted state is reached.
    requests: Vec<RequestId>,
    /// Settings of the arm that were changed for the reporting.
    saved: SavedSettings,
}

#[derive(Default)]
enum GuideState {
    #[default]
    Off,
    Starting(Pin<Box<dyn Future<Output = Result<Polled<Pose>, RpcError>> + Send>>),
    On(Polled<Pose>),
    Stopping(Pin<Box<dyn Future<Output = ()> + Send>>),
}

/// Event of the reporting.
pub(super) enum GuideEvent {
    /// The key was released with the arm at this pose.
    Released(Pose),
    Started(Result<Polled<Pose>, RpcError>),
    Stopped,
}

impl Guided {
    /// Returns the next event. Pending for ever while reporting is off.
    pub(super) async fn next(&mut self) -> GuideEvent {
        match &mut self.now {
            GuideState::Off => pending().await,
            GuideState::Starting(begins) => GuideEvent::Started(begins.await),
            GuideState::On(points) => GuideEvent::Released(points.next().await),
            GuideState::Stopping(ends) => {
                ends.await;
                GuideEvent::Stopped
            }
        }
    }

    /// Takes the next step towards the wanted state. Returns true when it is reached.
    fn advance(&mut self, arm: &Arm) -> bool {
        let saved = self.saved.clone();
        let arm = if self.unhomed {
            arm.allowing_unhomed()
        } else {
            arm.clone()
        };
        match (&self.now, self.wanted) {
            (GuideState::Off, false) | (GuideState::On(_), true) => return true,
            // Wait for the change in progress.
            (GuideState::Starting(_) | GuideState::Stopping(_), _) => {}
            (GuideState::Off, true) => self.now = GuideState::Starting(Box::pin(begin(arm, saved))),
            (GuideState::On(_), false) => {
                self.now = GuideState::Stopping(Box::pin(end(arm, saved)))
            }
        }
        false
    }
}

async fn begin(arm: Arm, saved: SavedSettings) -> Result<Polled<Pose>, RpcError> {
    guided_points(&arm, &saved).await?.ok_or_else(|| {
        let why = message!("the arm does not tell when its unlock key is released");
        RpcError::arm(ErrorKind::Unsupported, why)
    })
}

async fn end(arm: Arm, saved: SavedSettings) {
    // Fails on a lost line. The saved settings then stay stored, and the next program that moves or
    // sets restores them.
    let _ = saved.restore(&arm).await;
}

impl EngineTask {
    /// Switches reporting on or off. The request is answered when the arm has done it.
    pub(super) fn guide(&mut self, request: Option<RequestId>, on: bool, unhomed: bool) {
        (self.guided.wanted, self.guided.unhomed) = (on, unhomed);
        self.guided.requests.extend(request);
        self.advance_guide();
    }

    pub(super) fn handle_guide_event(&mut self, event: GuideEvent) {
        match event {
            GuideEvent::Released(pose) => return self.hand_trigger(&pose),
            GuideEvent::Stopped => self.guided.now = GuideState::Off,
            GuideEvent::Started(Ok(points)) => self.guided.now = GuideState::On(points),
            GuideEvent::Started(Err(error)) => {
                // Beginning may have changed some settings before it failed: restore them.
                let ends = end(self.arm.clone(), self.guided.saved.clone());
                self.guided.now = GuideState::Stopping(Box::pin(ends));
                // Otherwise `advance_guide` would start reporting again without end.
                self.guided.wanted = false;
                self.answer_guides(&Err(error));
            }
        }
        self.advance_guide();
    }

    fn advance_guide(&mut self) {
        if self.guided.advance(&self.arm) {
            self.answer_guides(&Ok(Outcome::Value(Value::Null)));
        }
    }

    fn answer_guides(&mut self, outcome: &Result<Outcome, RpcError>) {
        for request in std::mem::take(&mut self.guided.requests) {
            let outcome = outcome.clone();
            (self.report)(ArmReport::Done { request, outcome });
        }
    }

    fn hand_trigger(&self, pose: &Pose) {
        // By joints: the hand has put the arm there, so the joint angles are reachable.
        let step = capture(pose, Travel::Joints).map(|mut captured| captured["step"].take());
        let fields = vec![("step", step.unwrap_or_default())];
        let event = ArmEvent::HandTrigger;
        (self.report)(ArmReport::Event { event, fields });
    }
}
