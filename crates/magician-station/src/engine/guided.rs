//! Points that a hand teaches: the arm is asked whether its unlock key was released, as long as the holder of the lease wants it.

use std::future::{Future, pending};
use std::pin::Pin;

use magician::commands::Pose;
use magician::{Arm, ErrorKind};
use magician_job::teach::guided_points;
use magician_job::{Polled, SavedSettings};
use magician_program::Travel;
use serde_json::Value;

use super::Work;
use super::reads::capture;
use crate::api::{ArmEvent, RpcError};
use crate::control::RequestId;
use crate::order::{ArmReport, Outcome};

/// Whether the arm is asked, and is to be. What has begun comes to its end before it is changed again, so that no wish, however
/// close to another one, leaves the arm's settings changed.
#[derive(Default)]
pub(super) struct Guided {
    wanted: bool,
    /// It is wanted of an arm that is not known to be homed, too.
    unhomed: bool,
    now: Now,
    /// Requests that are answered when what is wanted is so.
    asked: Vec<RequestId>,
    /// What was changed of the arm for it.
    saved: SavedSettings,
}

#[derive(Default)]
enum Now {
    #[default]
    Off,
    Begins(Pin<Box<dyn Future<Output = Result<Polled<Pose>, RpcError>> + Send>>),
    On(Polled<Pose>),
    Ends(Pin<Box<dyn Future<Output = ()> + Send>>),
}

/// Something new of it.
pub(super) enum News {
    /// The key was released with the arm there.
    Released(Pose),
    Begun(Result<Polled<Pose>, RpcError>),
    Ended,
}

impl Guided {
    /// What is new; never while it is off.
    pub(super) async fn next(&mut self) -> News {
        match &mut self.now {
            Now::Off => pending().await,
            Now::Begins(begins) => News::Begun(begins.await),
            Now::On(points) => News::Released(points.next().await),
            Now::Ends(ends) => {
                ends.await;
                News::Ended
            }
        }
    }

    /// Goes on to what is wanted. True when it is so.
    fn turn(&mut self, arm: &Arm) -> bool {
        let saved = self.saved.clone();
        let arm = if self.unhomed {
            arm.allowing_unhomed()
        } else {
            arm.clone()
        };
        match (&self.now, self.wanted) {
            (Now::Off, false) | (Now::On(_), true) => return true,
            (Now::Begins(_) | Now::Ends(_), _) => {}
            (Now::Off, true) => self.now = Now::Begins(Box::pin(begin(arm, saved))),
            (Now::On(_), false) => self.now = Now::Ends(Box::pin(end(arm, saved))),
        }
        false
    }
}

async fn begin(arm: Arm, saved: SavedSettings) -> Result<Polled<Pose>, RpcError> {
    guided_points(&arm, &saved).await?.ok_or_else(|| {
        let why = "the arm does not tell when its unlock key is released";
        RpcError::arm(ErrorKind::Unsupported, why)
    })
}

async fn end(arm: Arm, saved: SavedSettings) {
    // A line that is lost: the next program that sets something restores it.
    let _ = saved.restore(&arm).await;
}

impl Work {
    /// The arm is to be asked, or no more; the request is answered when it is so.
    pub(super) fn guide(&mut self, request: Option<RequestId>, on: bool, unhomed: bool) {
        (self.guided.wanted, self.guided.unhomed) = (on, unhomed);
        self.guided.asked.extend(request);
        self.turn_guided();
    }

    pub(super) fn take_guided(&mut self, news: News) {
        match news {
            News::Released(pose) => return self.hand_trigger(&pose),
            News::Ended => self.guided.now = Now::Off,
            News::Begun(Ok(points)) => self.guided.now = Now::On(points),
            News::Begun(Err(error)) => {
                // What was changed for asking is restored at once.
                let ends = end(self.arm.clone(), self.guided.saved.clone());
                self.guided.now = Now::Ends(Box::pin(ends));
                self.guided.wanted = false;
                self.answer_guides(&Err(error));
            }
        }
        self.turn_guided();
    }

    fn turn_guided(&mut self) {
        if self.guided.turn(&self.arm) {
            self.answer_guides(&Ok(Outcome::Value(Value::Null)));
        }
    }

    fn answer_guides(&mut self, outcome: &Result<Outcome, RpcError>) {
        for request in std::mem::take(&mut self.guided.asked) {
            let outcome = outcome.clone();
            (self.report)(ArmReport::Done { request, outcome });
        }
    }

    fn hand_trigger(&self, pose: &Pose) {
        let step = capture(pose, Travel::Joints).map(|mut captured| captured["step"].take());
        let fields = vec![("step", step.unwrap_or_default())];
        let event = ArmEvent::HandTrigger;
        (self.report)(ArmReport::Event { event, fields });
    }
}
