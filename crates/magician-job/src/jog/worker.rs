//! The arm at the orders of a pendant: one thing moves it at a time, and a stop overtakes it.

use std::collections::VecDeque;
use std::future::{Future, poll_fn};
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::Poll;
use std::time::Duration;

use magician::commands::{JogCommonParams, PtpCommonParams};
use magician::preflight::Guards;
use magician::{Arm, ErrorCode, Jog, JogOptions, RunOptions, SettingsBackup};
use magician_program::{Ending, Plan, Program};
use tokio::runtime::Handle;
use tokio::time::Instant;

use super::{Activity, JogDirection, OrderDone, OrderError, PendantOrder};
use crate::{JobHandle, JobSpec, NoJournal, SavedSettings, Start};

type Worked = Result<Option<Jog>, OrderError>;
type Work = Pin<Box<dyn Future<Output = Worked> + Send>>;
/// The program that runs, or ran last.
type Running = Arc<Mutex<Option<JobHandle>>>;

struct Job {
    activity: Activity,
    work: Work,
}

/// The settings that jogs and moves go by, as they were found.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpeedRatios {
    /// Of jogs.
    pub(super) jog: JogCommonParams,
    /// Of moves.
    pub(super) moves: PtpCommonParams,
}

/// The arm at the orders of a pendant.
pub(super) struct ArmWorker {
    arm: Arm,
    saved: SavedSettings,
    ratios: SpeedRatios,
    /// Whether the ratios are not those that were found.
    changed: bool,
    jog: Option<(JogDirection, Jog)>,
    /// What moves it.
    moving: Option<Job>,
    /// What is to move it once the stop under way has ended, and when that was ordered, or kept up, last.
    waiting: Option<(PendantOrder, Instant)>,
    /// What is done beside.
    beside: VecDeque<Job>,
    /// The program that runs, or ran last.
    program: Running,
    /// Where a stop is sent from when this is dropped.
    runtime: Handle,
}

/// What is under way stops: a jog by its guard, a program by its handle, a move by a stop of its own.
impl Drop for ArmWorker {
    fn drop(&mut self) {
        if self.jogs() {
            return;
        }
        if self.moving.take().is_some() {
            let arm = self.arm.clone();
            // The receiver is gone.
            self.runtime.spawn(async move { arm.stop().await.ok() });
        }
    }
}

impl ArmWorker {
    /// At this arm; what it changes is restored by `saved`. Within a runtime.
    pub(super) fn new(arm: &Arm, saved: SavedSettings, ratios: SpeedRatios) -> Self {
        Self {
            arm: arm.clone(),
            saved,
            ratios,
            changed: false,
            jog: None,
            moving: None,
            waiting: None,
            beside: VecDeque::new(),
            program: Running::default(),
            runtime: Handle::current(),
        }
    }

    /// What moves the arm, as far as this knows.
    pub(super) fn activity(&self) -> Option<Activity> {
        let jog = self
            .jog
            .as_ref()
            .map(|(direction, _)| Activity::Jog(*direction));
        self.moving.as_ref().map(|job| job.activity).or(jog)
    }

    /// The step of the program that the arm is at, from 0, once that is known.
    pub(super) fn step(&self) -> Option<usize> {
        let program = lock(&self.program).clone();
        usize::try_from(program?.progress().step).ok()
    }

    /// Does what is ordered, or says what came of it at once. What was ordered before and is not done yet gives way only to a
    /// stop, and a jog to another jog; what moves the arm by hand waits for the end of a stop, the newest order for all.
    pub(super) fn order(&mut self, order: PendantOrder) -> Option<OrderDone> {
        if self.stops() && moves(&order) {
            self.waiting = Some((order, Instant::now()));
            return None;
        }
        match order {
            PendantOrder::Keep => self.keep(),
            PendantOrder::EndJog => {
                self.end_jog();
                None
            }
            PendantOrder::Stop => {
                self.jog = None;
                self.waiting = None;
                // The last that holds it, but for what waits for it and is let go of here: it stops.
                drop(lock(&self.program).take());
                // What has not been sent would come after it: a laser that is switched on, say.
                self.beside
                    .retain(|job| !matches!(job.activity, Activity::Tool(_)));
                let arm = self.arm.clone();
                let work = async move { Ok(arm.stop().await.map(|()| None)?) };
                self.begin(Activity::Stop, work);
                None
            }
            PendantOrder::ClearAlarms => {
                let arm = self.arm.clone();
                let work = async move { Ok(arm.clear_alarms().await.map(|()| None)?) };
                self.beside(Activity::ClearAlarms, work)
            }
            PendantOrder::Tool(tool) => {
                // The caller has made sure that it may burn.
                let arm = self.arm.allowing_laser();
                let work = async move { Ok(arm.set_any(&tool.command()).await.map(|()| None)?) };
                self.beside(Activity::Tool(tool), work)
            }
            PendantOrder::Speed(percent) => self.speed(percent),
            PendantOrder::Jog { direction, keep } => self.start_jog(direction, keep),
            PendantOrder::Step {
                direction,
                length,
                burning,
            } => {
                let activity = Activity::Step(direction);
                let command = direction.axis.step(direction.signed(length));
                let guards = Guards::default().laser(!burning);
                let arm = self.arm.clone();
                let work = async move {
                    // From where it has come to rest: a jog may be ending.
                    arm.wait_still().await?;
                    arm.run_with(&[command], RunOptions::default().guards(guards), |_| {})
                        .await?;
                    Ok(None)
                };
                self.begin_if_free(activity, work)
            }
            PendantOrder::Home => {
                let arm = self.arm.clone();
                let work = async move { Ok(arm.home().await.map(|()| None)?) };
                self.begin_if_free(Activity::Home, work)
            }
            PendantOrder::Run { plan, from } => {
                let program = Arc::clone(&self.program);
                let work = run(self.arm.clone(), *plan, from, program);
                self.begin_if_free(Activity::Run, work)
            }
        }
    }

    /// Waits until something is done.
    pub(super) async fn next(&mut self) -> OrderDone {
        let (activity, outcome) = poll_fn(|context| {
            if let Some(job) = &mut self.moving
                && let Poll::Ready(outcome) = job.work.as_mut().poll(context)
            {
                let activity = job.activity;
                self.moving = None;
                if activity == Activity::Stop {
                    self.begin_waiting(outcome.is_ok());
                }
                return Poll::Ready((activity, outcome));
            }
            if let Some(job) = self.beside.front_mut()
                && let Poll::Ready(outcome) = job.work.as_mut().poll(context)
            {
                let activity = job.activity;
                self.beside.pop_front();
                return Poll::Ready((activity, outcome));
            }
            Poll::Pending
        })
        .await;
        let outcome = outcome.map(|jog| {
            if let (Activity::Jog(direction), Some(jog)) = (activity, jog) {
                self.jog = Some((direction, jog));
            }
        });
        OrderDone { activity, outcome }
    }

    /// Ends what is under way: what moves is stopped, and settings are given back.
    ///
    /// # Errors
    /// When the arm does not confirm that it stands, and as [`SavedSettings::restore`].
    pub(super) async fn finish(mut self) -> magician::Result<()> {
        self.moving = None;
        self.beside.clear();
        let program = lock(&self.program).take();
        if let Some(program) = program {
            program.stop();
            // It gives back its settings.
            let _ = program.outcome().await;
        }
        if let Some((_, jog)) = self.jog.take() {
            jog.stop().await?;
        }
        if self.arm.moving() {
            self.arm.stop().await?;
        }
        self.saved.restore(&self.arm).await
    }

    fn keep(&mut self) -> Option<OrderDone> {
        if let Some((_, kept)) = &mut self.waiting {
            *kept = Instant::now();
        }
        if self.jogs() {
            // The one before gives way to the one that begins: its end is no news of the control that is held.
            return None;
        }
        let (direction, jog) = self.jog.as_ref()?;
        let (activity, kept) = (Activity::Jog(*direction), jog.keep());
        let error = kept.err()?;
        self.jog = None;
        // That it was kept up too late is how a control ends whose hold was reported too late.
        let outcome = match error.code() {
            ErrorCode::NotKept => Ok(()),
            _ => Err(error.into()),
        };
        Some(OrderDone { activity, outcome })
    }

    fn end_jog(&mut self) {
        self.jog = None;
        self.waiting.take_if(|(order, _)| {
            matches!(order, PendantOrder::Jog { .. } | PendantOrder::Step { .. })
        });
        if self.jogs() {
            self.moving = None;
        }
    }

    /// Whether what moves it is a jog that begins.
    fn jogs(&self) -> bool {
        (self.moving.as_ref()).is_some_and(|job| matches!(job.activity, Activity::Jog(_)))
    }

    /// Whether a stop is under way.
    fn stops(&self) -> bool {
        (self.moving.as_ref()).is_some_and(|job| job.activity == Activity::Stop)
    }

    /// A stop has ended: what waited for that begins, if the arm stands and its control is still held.
    fn begin_waiting(&mut self, stands: bool) {
        let Some((order, kept)) = self.waiting.take().filter(|_| stands) else {
            return;
        };
        if !matches!(order, PendantOrder::Jog { keep, .. } if kept.elapsed() >= keep) {
            // Nothing moves the arm, so that nothing refuses it.
            self.order(order);
        }
    }

    fn start_jog(&mut self, direction: JogDirection, keep: Duration) -> Option<OrderDone> {
        if self.jogs() {
            self.moving = None;
        }
        let arm = self.arm.clone();
        let options = JogOptions::default().keep(keep);
        let work = async move { Ok(arm.jog_with(direction, options).await.map(Some)?) };
        // The guard of the one under way is kept until this one begins: in the opposite direction the arm goes over into it.
        // Along another axis the driver ends that first and sees the arm at rest; what is released meanwhile starts nothing.
        self.begin_if_free(Activity::Jog(direction), work)
    }

    fn speed(&mut self, percent: f32) -> Option<OrderDone> {
        let first = !std::mem::replace(&mut self.changed, true);
        let mut before = SettingsBackup::default();
        before.save(self.ratios.jog);
        before.save(self.ratios.moves);
        let jog = JogCommonParams {
            velocity_ratio: percent,
            ..self.ratios.jog
        };
        let moves = PtpCommonParams {
            velocity_ratio: percent,
            ..self.ratios.moves
        };
        let (arm, saved) = (self.arm.clone(), self.saved.clone());
        let work = async move {
            if first {
                saved.save_all(&arm, before).await;
            }
            arm.set(&jog).await?;
            arm.set(&moves).await?;
            Ok(None)
        };
        self.beside(Activity::Speed(percent), work)
    }

    fn begin_if_free(
        &mut self,
        activity: Activity,
        work: impl Future<Output = Worked> + Send + 'static,
    ) -> Option<OrderDone> {
        let jog_for_jog = matches!(activity, Activity::Jog(_)) || self.jog.is_none();
        if self.moving.is_none() && jog_for_jog {
            self.begin(activity, work);
            return None;
        }
        let outcome = Err(OrderError::Busy);
        Some(OrderDone { activity, outcome })
    }

    fn begin(&mut self, activity: Activity, work: impl Future<Output = Worked> + Send + 'static) {
        let work = Box::pin(work);
        self.moving = Some(Job { activity, work });
    }

    fn beside(
        &mut self,
        activity: Activity,
        work: impl Future<Output = Worked> + Send + 'static,
    ) -> Option<OrderDone> {
        let work = Box::pin(work);
        self.beside.push_back(Job { activity, work });
        None
    }
}

/// Whether an order moves the arm by hand.
fn moves(order: &PendantOrder) -> bool {
    matches!(
        order,
        PendantOrder::Jog { .. } | PendantOrder::Step { .. } | PendantOrder::Home
    )
}

/// Checks a program from here on, and runs it.
async fn run(arm: Arm, plan: Plan, from: usize, program: Running) -> Worked {
    drop(lock(&program).take());
    arm.wait_still().await?;
    // A stop leaves the tool where it is.
    let ending = Ending {
        stay: true,
        ..Ending::default()
    };
    let spec = JobSpec::new(Program::new(plan, Some(1)))
        .start(Start::Step(from as u64))
        .ending(ending);
    let job = crate::Job::start(&arm, spec, NoJournal);
    lock(&program).replace(job.clone());
    match job.outcome().await {
        Ok(_) => Ok(None),
        Err(error) => Err(OrderError::Program(error)),
    }
}

fn lock(program: &Running) -> MutexGuard<'_, Option<JobHandle>> {
    program.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use magician::commands::EndEffectorLaser;

    use super::super::ToolOrder;
    use super::*;

    async fn worker(arm: &Arm) -> ArmWorker {
        let ratios = SpeedRatios {
            jog: arm.get::<JogCommonParams>().await.unwrap(),
            moves: arm.get::<PtpCommonParams>().await.unwrap(),
        };
        ArmWorker::new(arm, SavedSettings::default(), ratios)
    }

    /// A control that is held for so long, kept up as a pendant does; what was refused or ended of it.
    async fn hold(worker: &mut ArmWorker, axis: &str, ms: u64) -> Vec<OrderDone> {
        let direction: JogDirection = axis.parse().unwrap();
        let keep = Duration::from_millis(300);
        let mut told = Vec::from_iter(worker.order(PendantOrder::Jog { direction, keep }));
        for _ in 0..ms / 50 {
            let turn = tokio::time::timeout(Duration::from_millis(50), worker.next());
            if let Ok(done) = turn.await {
                told.push(done);
                tokio::time::sleep(Duration::from_millis(50)).await;
            }
            told.extend(worker.order(PendantOrder::Keep));
        }
        told.retain(|done| done.outcome.is_err());
        told
    }

    #[tokio::test(start_paused = true)]
    async fn another_axis_begins_at_rest_and_goes_on_while_it_is_held() {
        let sim = magician::VirtualArm::new(
            magician::sim::Controller::default(),
            magician::SimSpeed::Times(1.0),
        );
        let arm = Arm::simulated(sim.clone(), magician::Options::default());
        let arm = arm.await.unwrap();
        let mut worker = worker(&arm).await;
        assert!(hold(&mut worker, "x+", 1000).await.is_empty());
        let before = sim.state().pose;
        let told = hold(&mut worker, "y-", 2000).await;
        assert!(told.is_empty(), "{told:?}");
        let after = sim.state().pose;
        assert!(after.y < before.y - 10.0, "{before:?} {after:?}");
        // It braked along x, and nothing of that speed went into y the wrong way.
        assert!(after.x > before.x && after.x < before.x + 10.0);
        // A key that is released while the arm comes to rest starts nothing.
        let direction = "z+".parse().unwrap();
        let keep = Duration::from_millis(300);
        assert!(
            worker
                .order(PendantOrder::Jog { direction, keep })
                .is_none()
        );
        let _ = tokio::time::timeout(Duration::from_millis(100), worker.next()).await;
        let z = sim.state().pose.z;
        worker.order(PendantOrder::EndJog);
        tokio::time::sleep(Duration::from_secs(2)).await;
        assert!(!sim.state().moving);
        assert_eq!(sim.state().pose.z, z);
    }

    #[tokio::test]
    async fn nothing_is_switched_on_after_a_stop_that_was_asked_for_later() {
        let arm = Arm::connect("sim").await.unwrap();
        let mut worker = worker(&arm).await;
        let laser = PendantOrder::Tool(ToolOrder::Laser(true));
        assert!(worker.order(laser).is_none());
        assert!(worker.order(PendantOrder::Stop).is_none());
        assert_eq!(worker.next().await.activity, Activity::Stop);
        assert!(worker.beside.is_empty());
        // What is asked for after it is done.
        let suction = ToolOrder::Suction(true);
        assert!(worker.order(PendantOrder::Tool(suction)).is_none());
        assert_eq!(worker.next().await.activity, Activity::Tool(suction));
        let laser = arm.get::<EndEffectorLaser>().await.unwrap();
        assert!(!laser.is_on.is_on());
    }
}
