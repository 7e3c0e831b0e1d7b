//! Teaching: a program from points that a person shows the arm, by hand or by call.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use magician::commands::{EndEffectorParams, Pose};
use magician::{Arm, Error, ErrorCode, Events, Link};
use magician_job::SavedSettings;
use magician_job::teach::{ProgramModel, TeachEditor, TeachStep, guided_points};
use magician_program::{Action, Grip, Tool, Travel};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use tokio::sync::watch;
use tokio::task::AbortHandle;

use crate::call::Call;
use crate::core::Core;
use crate::errors;
use crate::program::{PyPlan, Source};
use crate::runtime::Local;
use crate::values::shortest;

/// A program that is taught.
#[pyclass(frozen, module = "magician._magician")]
pub(crate) struct Lesson {
    inner: Local<Inner>,
}

struct Inner {
    arm: Arm,
    saved: SavedSettings,
    taught: Arc<Taught>,
    /// Task that stores points taught by hand. `None` if the arm does not report them.
    hand: Option<AbortHandle>,
}

struct Taught {
    editor: Mutex<TeachEditor>,
    /// Points taught by hand, in order.
    by_hand: watch::Sender<Vec<Point>>,
}

impl Taught {
    fn editor(&self) -> MutexGuard<'_, TeachEditor> {
        self.editor.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn guided(&self, pose: &Pose) {
        let Some(name) = self.editor().store_guided(pose) else {
            return;
        };
        let place = [pose.x, pose.y, pose.z, pose.r];
        let point = (name, place.map(shortest));
        self.by_hand.send_modify(|points| points.push(point));
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        if let Some(hand) = &self.hand {
            hand.abort();
        }
    }
}

/// Completes when the line to the arm is lost for good. Returns the reason.
async fn wait_for_loss(arm: &Arm, mut events: Events) -> Error {
    loop {
        match arm.link() {
            Link::Up | Link::Lost { sought: true, .. } => {}
            Link::Lost { why, .. } => return Error::new(ErrorCode::LineLost, why.to_string()),
            _ => break,
        }
        if events.next().await.is_none() {
            break;
        }
    }
    Error::new(ErrorCode::Closed, "the connection was closed")
}

#[pymethods]
impl Core {
    /// Starts a lesson with this motion type to its points.
    fn teach(&self, py: Python<'_>, title: String, by: &str, unhomed: bool) -> PyResult<Call> {
        let arm = self.arm(py)?;
        let arm = if unhomed { arm.allowing_unhomed() } else { arm };
        let by = match by {
            "joints" => Travel::Joints,
            "line" => Travel::Line,
            "jump" => Travel::Jump,
            other => {
                let message = format!("by is \"joints\", \"line\" or \"jump\", not \"{other}\"");
                return Err(errors::raise(py, &Error::invalid(message)));
            }
        };
        let begun = async move {
            arm.homing().check().await?;
            let tool = Tool::from(&arm.get::<EndEffectorParams>().await?);
            let saved = SavedSettings::default();
            let hand = guided_points(&arm, &saved).await?;
            let mut editor = TeachEditor::new(ProgramModel::new(title, Some(tool)));
            editor.program.reach_by(by);
            editor.hand_guiding = hand.as_ref().map(|_| true);
            let taught = Arc::new(Taught {
                editor: Mutex::new(editor),
                by_hand: watch::Sender::default(),
            });
            let hand = hand.map(|mut hand| {
                let taught = Arc::clone(&taught);
                let storing = async move {
                    loop {
                        taught.guided(&hand.next().await);
                    }
                };
                tokio::spawn(storing).abort_handle()
            });
            Ok::<_, Error>(Inner {
                arm,
                saved,
                taught,
                hand,
            })
        };
        Ok(Call::start(begun, |py, inner| {
            let inner = Local::new(inner);
            Lesson { inner }.into_py_any(py)
        }))
    }
}

/// Name of a point, and x, y, z, r.
type Point = (String, [f64; 4]);

fn point(step: &TeachStep) -> Option<Point> {
    match &step.motion {
        Some(Action::Move { to, .. }) => Some((step.name.clone(), to.map(shortest))),
        _ => None,
    }
}

#[pymethods]
impl Lesson {
    /// True if the arm reports its unlock key.
    fn is_guided(&self, py: Python<'_>) -> PyResult<bool> {
        Ok(self.inner.get(py)?.hand.is_some())
    }

    /// Points so far, in order.
    fn points(&self, py: Python<'_>) -> PyResult<Vec<Point>> {
        let taught = &self.inner.get(py)?.taught;
        Ok(taught
            .editor()
            .program
            .steps()
            .iter()
            .filter_map(point)
            .collect())
    }

    /// Number of points taught by hand.
    fn by_hand(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.inner.get(py)?.taught.by_hand.borrow().len())
    }

    /// Waits for the hand-taught point with this index. Returns its name and position.
    fn next(&self, py: Python<'_>, nth: usize) -> PyResult<Call> {
        let inner = self.inner.get(py)?;
        let (arm, mut points) = (inner.arm.clone(), inner.taught.by_hand.subscribe());
        let events = arm.events();
        Ok(Call::start(
            async move {
                let gone = wait_for_loss(&arm, events);
                tokio::select! {
                    biased;
                    taught = points.wait_for(|points| points.len() > nth) => {
                        let taught = taught.ok().and_then(|points| points.get(nth).cloned());
                        taught.ok_or_else(|| Error::new(ErrorCode::Closed, "the lesson has ended"))
                    }
                    error = gone => Err(error),
                }
            },
            |py, point| point.into_py_any(py),
        ))
    }

    /// Stores the arm's pose as a point, after it has come to rest. Returns name and position.
    fn store(
        &self,
        py: Python<'_>,
        name: Option<String>,
        suction: Option<bool>,
        gripper: Option<i8>,
        pause: u32,
    ) -> PyResult<Call> {
        let inner = self.inner.get(py)?;
        let (arm, taught) = (inner.arm.clone(), Arc::clone(&inner.taught));
        let gripper = gripper.map(|grip| match grip {
            1 => Grip::Close,
            0 => Grip::Open,
            _ => Grip::Off,
        });
        let stored = async move {
            arm.wait_still().await?;
            let pose = arm.get::<Pose>().await?;
            let program = &mut taught.editor().program;
            program.store(&pose);
            // Cannot fail: the step that was just stored is selected and takes all of these.
            let _ = name.map(|name| program.rename(&name));
            let _ = program.set_tools(gripper, suction);
            let _ = program.set_pause(pause);
            let step = program.steps().get(program.selected()).and_then(point);
            Ok::<_, Error>(step)
        };
        Ok(Call::start(stored, |py, step| step.into_py_any(py)))
    }

    /// Removes the last point.
    fn pop(&self, py: Python<'_>) -> PyResult<Option<Point>> {
        let program = &mut self.inner.get(py)?.taught.editor().program;
        let last = program.steps().last().and_then(point);
        // The last step is selected. Without steps there is nothing to delete.
        let _ = program.delete();
        Ok(last)
    }

    /// Program with the points so far.
    fn plan(&self, py: Python<'_>) -> PyResult<PyPlan> {
        let plan = self.inner.get(py)?.taught.editor().program.plan(0);
        Ok(PyPlan::of(plan, Source::default()))
    }

    /// Ends the lesson and restores the arm's settings.
    fn close(&self, py: Python<'_>) -> PyResult<Call> {
        let inner = self.inner.get(py)?;
        if let Some(hand) = &inner.hand {
            hand.abort();
        }
        let (arm, saved) = (inner.arm.clone(), inner.saved.clone());
        Ok(Call::lasting(async move { saved.restore(&arm).await }))
    }
}
