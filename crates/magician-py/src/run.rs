//! Plans on their way through an arm.

use std::sync::Arc;
use std::time::Duration;

use magician::commands::{
    ArcParams, CpParams, DeviceTime, EndEffectorLaser, EndEffectorParams, Pose, PtpCommonParams,
    PtpCoordinateParams, PtpJointParams, PtpJump2Params, PtpLParams,
};
use magician::words::{Guards, Preflight};
use magician::{
    Arm, Ctrl, Error, ErrorKind, FrameBuf, Geometry, JointAngles, Ran, Result, RunOptions, Set,
    ToolBias,
};
use magician_program::preview::{Snapshot, Standing};
use magician_program::resume::Tally;
use magician_program::{Plan, Report, check};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use tokio::sync::watch;

use crate::call::{Call, Reporter};
use crate::core::Core;
use crate::picture::Picture;
use crate::program::{PyPlan, SURFACE_ARGUMENT, Source, Start, findings, kinds, refusal};

/// The longest that is waited for a run which somebody has stopped, to give settings back.
const LEAVING: Duration = Duration::from_secs(5);

/// How a plan is run.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct How {
    /// Counted from 1.
    first_step: i64,
    check: bool,
    keep: bool,
    require_homed: bool,
    allow_laser: bool,
    restore: bool,
    watched: bool,
}

impl How {
    /// The step that it begins with, counted from 0.
    fn first(&self) -> usize {
        usize::try_from(self.first_step - 1).unwrap_or(usize::MAX)
    }
}

/// What a run has come to.
struct Done {
    ran: Ran,
    steps: u64,
    seconds: f64,
    report: Report,
}

impl Done {
    fn parts(&self, py: Python<'_>, source: &Source) -> PyResult<Py<PyAny>> {
        let parts = PyDict::new(py);
        parts.set_item("steps", self.steps)?;
        parts.set_item("commands", self.ran.commands)?;
        parts.set_item("seconds", self.seconds)?;
        parts.set_item("first_index", self.ran.first.map(|index| index.0))?;
        parts.set_item("last_index", self.ran.last.map(|index| index.0))?;
        parts.set_item("report", findings(py, &self.report, source)?)?;
        Ok(parts.into_any().unbind())
    }
}

/// A plan, an arm, and how it is run.
struct Drive {
    arm: Arm,
    plan: Arc<Plan>,
    source: Source,
    burns: bool,
    how: How,
    reporter: Reporter,
    /// Stops of before, which are not its own.
    stops: u64,
    /// Whether it may have changed what it gives back.
    owing: watch::Sender<bool>,
}

/// What was found before anything moves.
struct Found {
    plan: Arc<Plan>,
    /// Commands before the first step.
    lead: u64,
    start: Preflight,
    report: Report,
    /// How long it takes up to each command, seconds.
    sums: Vec<f64>,
}

impl Drive {
    async fn run(self) -> Result<Done> {
        self.permit()?;
        let guards = Guards::default().require_homed(self.how.require_homed);
        let first: Vec<Set> = self.plan.commands().take(1).collect();
        self.arm.check_alarms(&first, guards).await?;
        if self.arm.get::<EndEffectorLaser>().await?.is_on.is_on() {
            return Err(Error::invalid(
                "the laser is on, and a program begins with it dark; nothing was sent",
            ));
        }
        if !self.how.keep {
            // A run of nothing says whether commands of others wait: better than a check from a start that nobody knows.
            self.arm.run([], |_| {}).await?;
        }
        let found = self.look_ahead().await?;
        let owed = match self.how.restore {
            true => owed(&self.arm, &found.plan).await?,
            false => Vec::new(),
        };
        let begun = self.clock().await?;
        self.owing.send_replace(true);
        let outcome = self.perform(&found).await;
        if outcome.is_err() && self.arm.stop().await.is_ok() {
            // The error that is on its way is the better story.
            let _ = give_back(&self.arm, &owed).await;
        }
        let ran = outcome?;
        give_back(&self.arm, &owed).await?;
        let clock = self.clock().await?;
        let steps = self.plan.steps.len().saturating_sub(self.how.first()) as u64;
        Ok(Done {
            ran,
            steps,
            seconds: f64::from(clock.wrapping_sub(begun)) / 1000.0,
            report: found.report,
        })
    }

    /// What a person has to say first.
    fn permit(&self) -> Result<()> {
        if is_virtual(&self.arm) {
            return Ok(());
        }
        if self.source.assumed {
            return Err(Error::invalid(SURFACE_ARGUMENT));
        }
        if self.burns && !self.how.allow_laser {
            return Err(Error::invalid(format!(
                "this burns with the laser of the arm at {}; nothing was sent: put on goggles for its wavelength, clear what \
                 must not burn, stay with it, and say allow_laser=True",
                self.arm.name()
            )));
        }
        Ok(())
    }

    async fn clock(&self) -> Result<u32> {
        Ok(self.arm.get::<DeviceTime>().await?.g_systick)
    }

    /// Checks it from where the arm stands. That may take a while, and others have connections to be served.
    async fn look_ahead(&self) -> Result<Found> {
        let start = self.arm.preflight_for(&kinds(&self.plan)).await?;
        let (plan, first, watched) = (Arc::clone(&self.plan), self.how.first(), self.how.watched);
        let looked = tokio::task::spawn_blocking(move || ahead(plan, first, start, watched));
        let found = looked
            .await
            .map_err(|error| Error::new(ErrorKind::Closed, error.to_string()))??;
        match refusal(&found.report, &self.source).filter(|_| self.how.check) {
            Some(refusal) => Err(refusal),
            None => Ok(found),
        }
    }

    async fn perform(&self, found: &Found) -> Result<Ran> {
        let first = self.how.first() as u64;
        let mut tally = Tally::new(found.lead, true);
        let plan = Arc::clone(&found.plan);
        let commands: Vec<Set> = plan.commands().collect();
        let options = RunOptions::default().keep(self.how.keep);
        let run = self.arm.begin(commands, options).along(found.start.clone());
        let mut run = run.unless_stopped_since(self.stops);
        let ran = run
            .finish(|progress| {
                tally.note(progress.sent, progress.last.0);
                let done = tally.finished(progress.current.0).least;
                self.reach(first + done, found.left(done));
            })
            .await?;
        self.reach(self.plan.steps.len() as u64, Some(Duration::ZERO));
        Ok(ran)
    }

    /// Tells how many steps are finished, over all, and how long the rest takes.
    fn reach(&self, steps: u64, left: Option<Duration>) {
        // How fast a virtual arm's clock runs is not known here.
        let left = left.filter(|left| left.is_zero() || !is_virtual(&self.arm));
        let left = left.map(|left| left.as_secs_f64());
        self.reporter
            .report(move |py| Ok((steps, left).into_pyobject(py)?.into_any().unbind()));
    }
}

impl Found {
    /// How long the rest takes when so many steps are done.
    fn left(&self, done: u64) -> Option<Duration> {
        let all = self.report.time?;
        let at = usize::try_from(self.lead + done).unwrap_or(usize::MAX);
        let spent = at
            .checked_sub(1)
            .and_then(|at| self.sums.get(at))
            .copied()
            .unwrap_or(0.0);
        Some(all.saturating_sub(Duration::try_from_secs_f64(spent).unwrap_or_default()))
    }
}

/// Checks a plan from one of its steps on, counted from 0.
fn ahead(plan: Arc<Plan>, first: usize, start: Preflight, watched: bool) -> Result<Found> {
    let (whole, plan) = match first {
        0 => (plan.steps.len(), plan),
        first => (
            plan.steps.len() - first.min(plan.steps.len()),
            Arc::new(plan.from_step(first, &start)?.plan),
        ),
    };
    let report = check(&plan, &start);
    let told = plan.preamble().into_iter().count();
    let mut course = start.clone().guards(Guards::NONE);
    let mut sum = 0.0;
    let commands = plan.commands().take(if watched { usize::MAX } else { 0 });
    let sums = commands.map(|command| {
        let time = course
            .check(&command)
            .map_or(Duration::ZERO, |step| step.time);
        sum += if time == Duration::MAX {
            0.0
        } else {
            time.as_secs_f64()
        };
        sum
    });
    let sums = sums.collect();
    Ok(Found {
        lead: (told + plan.steps.len().saturating_sub(whole)) as u64,
        plan,
        start,
        report,
        sums,
    })
}

/// Whether it is in this process: nothing burns, and nothing is run into.
fn is_virtual(arm: &Arm) -> bool {
    arm.name() == "sim" || arm.name().starts_with("sim:")
}

/// The settings that a plan changes, as they are now: speeds and heights of jumps. The tool stays, and so does what is no
/// setting of a motion.
async fn owed(arm: &Arm, plan: &Plan) -> Result<Vec<Set>> {
    let mut owed: Vec<Set> = Vec::new();
    let mut known = Vec::new();
    for change in plan.settings() {
        let kind = std::mem::discriminant(change);
        if known.contains(&kind) {
            continue;
        }
        known.push(kind);
        owed.push(match change {
            Set::PtpJointParams(_) => arm.get::<PtpJointParams>().await?.into(),
            Set::PtpCoordinateParams(_) => arm.get::<PtpCoordinateParams>().await?.into(),
            Set::PtpCommonParams(_) => arm.get::<PtpCommonParams>().await?.into(),
            // One height is both heights of the second set.
            Set::PtpJumpParams(_) | Set::PtpJump2Params(_) => {
                arm.get::<PtpJump2Params>().await?.into()
            }
            Set::PtpLParams(_) => arm.get::<PtpLParams>().await?.into(),
            Set::CpParams(_) => arm.get::<CpParams>().await?.into(),
            Set::ArcParams(_) => arm.get::<ArcParams>().await?.into(),
            _ => continue,
        });
    }
    Ok(owed)
}

async fn give_back(arm: &Arm, owed: &[Set]) -> Result<()> {
    for setting in owed {
        let order = FrameBuf::set(setting, Ctrl::SET)?;
        let order = order.frame();
        arm.raw(order.id(), order.ctrl(), order.params()).await?;
    }
    Ok(())
}

#[pymethods]
impl Core {
    /// Whether it is a virtual arm in this process.
    fn is_virtual(&self, py: Python<'_>) -> PyResult<bool> {
        Ok(is_virtual(&self.arm(py)?))
    }

    /// Asks the arm what a check of a plan depends on.
    fn start_of(&self, py: Python<'_>, plan: &PyPlan) -> PyResult<Call> {
        let (arm, plan) = (self.arm(py)?, Arc::clone(&plan.plan));
        let ask = async move { arm.preflight_for(&kinds(&plan)).await };
        Ok(Call::start(ask, |py, preflight| {
            Ok(Py::new(py, Start { preflight })?.into_any())
        }))
    }

    /// Checks a plan, runs it and waits for its end. The second call ends when nothing of it is left to do: it outlives the
    /// first one, which may be let go of.
    fn run(&self, py: Python<'_>, plan: &PyPlan, how: How) -> PyResult<(Call, Call)> {
        if how.first_step < 1 {
            let error = Error::invalid("steps are counted from 1");
            return Err(crate::errors::raise(py, &error));
        }
        let (arm, source, burns) = (self.arm(py)?, plan.source.clone(), plan.burns());
        let (plan, of_report) = (Arc::clone(&plan.plan), source.clone());
        let (owing, mut owed) = watch::channel(false);
        let drive = |reporter| Drive {
            stops: arm.stops(),
            arm: arm.clone(),
            plan,
            source,
            burns,
            how,
            reporter,
            owing,
        };
        let task = |reporter| {
            let drive = drive(reporter);
            async move {
                // Who lets go of a run stops the arm, and then it still gives the settings back.
                let running = tokio::spawn(drive.run());
                let bug = |error: tokio::task::JoinError| {
                    Error::new(ErrorKind::Closed, error.to_string())
                };
                running.await.map_err(bug)?
            }
        };
        let call = Call::moving(&arm, task, move |py, done: Done| done.parts(py, &of_report));
        let over = async move {
            // What was stopped before anything was sent sends nothing, however long its check goes on.
            let rest = async { while *owed.borrow_and_update() && owed.changed().await.is_ok() {} };
            let _ = tokio::time::timeout(LEAVING, rest).await;
            Ok(())
        };
        let over = Call::waiting(over);
        Ok((call, over))
    }

    /// The arm as it stands, drawn.
    fn snapshot(&self, py: Python<'_>) -> PyResult<Call> {
        let arm = self.arm(py)?;
        let look = async move {
            let pose = arm.get::<Pose>().await?;
            let bias = arm.get::<EndEffectorParams>().await?;
            let mut standing = Standing::default();
            standing.title = format!("Arm at {}", arm.name());
            standing.joints = pose.joint_angle.map(f64::from).into();
            let [x, y, z] = [bias.x_bias, bias.y_bias, bias.z_bias].map(f64::from);
            standing.tool = ToolBias::new(x, y, z);
            standing.alarms = arm.alarms().await?;
            let index = arm.current_index().await?;
            standing.facts = vec![format!("queue index {} finished", index.0)];
            Ok(standing)
        };
        Ok(Call::start(look, |py, standing| {
            let svg = Snapshot::of_arm(&standing).to_svg().to_owned();
            Ok(Py::new(py, Picture::new(svg))?.into_any())
        }))
    }
}

/// An arm that says that it stands so, drawn.
#[pyfunction]
pub(crate) fn draw_arm(
    py: Python<'_>,
    title: &str,
    pose: [f64; 4],
    joints: [f64; 4],
    alarms: Vec<u8>,
    facts: Vec<String>,
) -> Picture {
    let mut standing = Standing::default();
    standing.title = title.to_owned();
    standing.joints = joints.into();
    standing.tool = between(&standing.joints, pose);
    for code in alarms {
        standing.alarms.insert(code);
    }
    standing.facts = facts;
    Picture::new(py.detach(|| Snapshot::of_arm(&standing).to_svg().to_owned()))
}

/// Where the tool is, seen from the wrist, if the joints stand so and the tool is there.
fn between(joints: &JointAngles, [x, y, z, _]: [f64; 4]) -> ToolBias {
    let wrist = Geometry::default().forward(joints);
    let (sin, cos) = joints.j1.to_radians().sin_cos();
    let [dx, dy] = [x - wrist.x, y - wrist.y];
    ToolBias::new(dx * cos + dy * sin, dy * cos - dx * sin, wrist.z - z)
}
