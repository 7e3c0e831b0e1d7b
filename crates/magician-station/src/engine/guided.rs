//! Points that a hand teaches: the arm is asked whether its unlock key was released, as long as somebody who teaches wants it.

use magician::ErrorKind;
use magician::commands::Pose;
use magician_job::teach::guided_points;
use magician_job::{Polled, SavedSettings};
use magician_program::Travel;
use serde_json::Value;

use super::reads::capture;
use super::{TaskResult, Work};
use crate::api::RpcError;
use crate::control::RequestId;
use crate::order::{ArmReport, Outcome};

/// An arm that is asked.
pub(super) struct Guided {
    points: Polled<Pose>,
    /// What was changed of the arm for it.
    saved: SavedSettings,
}

impl Work {
    /// Begins, or ends, and answers.
    pub(super) fn guide(&mut self, request: RequestId, on: bool) {
        if on && self.guided.is_none() {
            let arm = self.arm.clone();
            self.side.spawn(async move {
                let saved = SavedSettings::default();
                let points = guided_points(&arm, &saved).await;
                let points = points.map_err(RpcError::from).and_then(|points| {
                    points.ok_or_else(|| {
                        let why = "the arm does not tell when its unlock key is released";
                        RpcError::arm(ErrorKind::Unsupported, why)
                    })
                });
                TaskResult::Guided(request, points.map(|points| Guided { points, saved }))
            });
            return;
        }
        if !on {
            self.end_guided();
        }
        let outcome = Ok(Outcome::Value(Value::Null));
        (self.report)(ArmReport::Done { request, outcome });
    }

    pub(super) fn guides(&mut self, request: RequestId, guided: Result<Guided, RpcError>) {
        let outcome = guided.map(|guided| {
            self.guided = Some(guided);
            Outcome::Value(Value::Null)
        });
        (self.report)(ArmReport::Done { request, outcome });
    }

    /// Ends, and restores what was changed.
    pub(super) fn end_guided(&mut self) {
        if let Some(Guided { saved, .. }) = self.guided.take() {
            let arm = self.arm.clone();
            self.side.spawn(async move {
                // A line that is lost: the next program that sets something restores it.
                let _ = saved.restore(&arm).await;
                TaskResult::Nothing
            });
        }
    }

    /// The unlock key was released with the arm there.
    pub(super) fn hand_trigger(&self, pose: &Pose) {
        let step = capture(pose, Travel::Joints).map(|mut captured| captured["step"].take());
        let fields = vec![("step", step.unwrap_or_default())];
        let name = "hand-trigger";
        (self.report)(ArmReport::Event { name, fields });
    }
}

/// Where the unlock key was released; never while that is not asked.
pub(super) async fn released(guided: &mut Option<Guided>) -> Pose {
    match guided {
        Some(guided) => guided.points.next().await,
        None => std::future::pending().await,
    }
}
