//! Worker that carries out a pendant's orders: one activity moves the arm at a time, and a stop
//! overtakes it.
//!
//! Work is a set of futures that only [`ArmWorker::next`] polls, so the session needs no task of
//! its own. Three slots hold it: `moving` for the activity that moves the arm, `side_orders` for
//! tools, speeds and alarms in order, and `waiting` for the newest order that a stop holds back.

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

type OrderOutcome = Result<Option<Jog>, OrderError>;
type OrderFuture = Pin<Box<dyn Future<Output = OrderOutcome> + Send>>;
/// The running or last program.
type Running = Arc<Mutex<Option<JobHandle>>>;

struct RunningOrder {
    activity: Activity,
    future: OrderFuture,
}

/// Speed ratios of jogs and moves as first read.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpeedRatios {
    /// Ratio for jogs.
    pub(super) jog: JogCommonParams,
    /// Ratio for moves.
    pub(super) moves: PtpCommonParams,
}

/// Worker for the orders of a pendant.
pub(super) struct ArmWorker {
    arm: Arm,
    saved: SavedSettings,
    ratios: SpeedRatios,
    /// True if the ratios were changed.
    changed: bool,
    jog: Option<(JogDirection, Jog)>,
    /// Activity that moves the arm.
    moving: Option<RunningOrder>,
    /// Order that waits for the current stop, and when it was last given or kept alive.
    waiting: Option<(PendantOrder, Instant)>,
    /// Work that does not move the arm, in order.
    side_orders: VecDeque<RunningOrder>,
    /// The running or last program.
    program: Running,
    /// Runtime on which the drop sends its stop.
    runtime: Handle,
}

/// Stops the current activity: a jog by its guard, a program by its handle, a move by an explicit
/// stop.
impl Drop for ArmWorker {
    fn drop(&mut self) {
        // A jog that is about to begin ends with its future.
        if self.is_jog_pending() {
            return;
        }
        if self.moving.take().is_some() {
            let arm = self.arm.clone();
            // The result is ignored: the session that would receive it is gone.
            self.runtime.spawn(async move { arm.stop().await.ok() });
        }
    }
}

impl ArmWorker {
    /// Creates a worker; `saved` restores what it changes. Must be called within a runtime.
    pub(super) fn new(arm: &Arm, saved: SavedSettings, ratios: SpeedRatios) -> Self {
        Self {
            arm: arm.clone(),
            saved,
            ratios,
            changed: false,
            jog: None,
            moving: None,
            waiting: None,
            side_orders: VecDeque::new(),
            program: Running::default(),
            runtime: Handle::current(),
        }
    }

    /// Activity that moves the arm, as far as the worker knows.
    pub(super) fn activity(&self) -> Option<Activity> {
        let jog = self
            .jog
            .as_ref()
            .map(|(direction, _)| Activity::Jog(*direction));
        self.moving.as_ref().map(|job| job.activity).or(jog)
    }

    /// Current step of the program, from 0, once known.
    pub(super) fn step(&self) -> Option<usize> {
        let program = lock(&self.program).clone();
        usize::try_from(program?.progress().step).ok()
    }

    /// Starts an order, or returns its refusal at once. A stop replaces any activity, and a jog
    /// replaces a jog; nothing else replaces an activity. During a stop, the newest motion order
    /// waits until the stop has ended.
    pub(super) fn order(&mut self, order: PendantOrder) -> Option<OrderDone> {
        if self.is_stopping() && moves_arm(&order) {
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
                // A program stops when all its handles are dropped: this one, and the clone in the
                // running future, which `begin` replaces below.
                drop(lock(&self.program).take());
                // Tool orders not sent yet are dropped: sent after the stop, one could switch the
                // laser on.
                self.side_orders
                    .retain(|job| !matches!(job.activity, Activity::Tool(_)));
                let arm = self.arm.clone();
                let future = async move { Ok(arm.stop().await.map(|()| None)?) };
                self.begin(Activity::Stop, future);
                None
            }
            PendantOrder::ClearAlarms => {
                let arm = self.arm.clone();
                let future = async move { Ok(arm.clear_alarms().await.map(|()| None)?) };
                self.push_side_order(Activity::ClearAlarms, future)
            }
            PendantOrder::Tool(tool) => {
                // The caller has verified that the laser may burn.
                let arm = self.arm.allowing_laser();
                let future = async move { Ok(arm.set_any(&tool.command()).await.map(|()| None)?) };
                self.push_side_order(Activity::Tool(tool), future)
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
                let future = async move {
                    // Wait for rest: a jog may still be braking.
                    arm.wait_still().await?;
                    arm.run_with(&[command], RunOptions::default().guards(guards), |_| {})
                        .await?;
                    Ok(None)
                };
                self.begin_if_free(activity, future)
            }
            PendantOrder::Home => {
                let arm = self.arm.clone();
                let future = async move { Ok(arm.home().await.map(|()| None)?) };
                self.begin_if_free(Activity::Home, future)
            }
            PendantOrder::Run { plan, from } => {
                let program = Arc::clone(&self.program);
                let future = run(self.arm.clone(), *plan, from, program);
                self.begin_if_free(Activity::Run, future)
            }
        }
    }

    /// Waits until an order is done.
    pub(super) async fn next(&mut self) -> OrderDone {
        let (activity, outcome) = poll_fn(|context| {
            if let Some(job) = &mut self.moving
                && let Poll::Ready(outcome) = job.future.as_mut().poll(context)
            {
                let activity = job.activity;
                self.moving = None;
                if activity == Activity::Stop {
                    self.begin_waiting(outcome.is_ok());
                }
                return Poll::Ready((activity, outcome));
            }
            if let Some(job) = self.side_orders.front_mut()
                && let Poll::Ready(outcome) = job.future.as_mut().poll(context)
            {
                let activity = job.activity;
                self.side_orders.pop_front();
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

    /// Ends the current activity and restores the settings.
    ///
    /// # Errors
    /// Fails if the arm does not confirm that it stands; else as [`SavedSettings::restore`].
    pub(super) async fn finish(mut self) -> magician::Result<()> {
        self.moving = None;
        self.side_orders.clear();
        let program = lock(&self.program).take();
        if let Some(program) = program {
            program.stop();
            // Waits for the program to restore its settings.
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
        if self.is_jog_pending() {
            // A new jog is about to replace the old one: that the old jog has ended does not matter
            // for the control that is held now.
            return None;
        }
        let (direction, jog) = self.jog.as_ref()?;
        let (activity, kept) = (Activity::Jog(*direction), jog.keep());
        let error = kept.err()?;
        self.jog = None;
        // A keep-alive that came too late is a normal end: the control was released, and its last
        // report was late.
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
        if self.is_jog_pending() {
            self.moving = None;
        }
    }

    /// True if a jog is about to begin.
    fn is_jog_pending(&self) -> bool {
        (self.moving.as_ref()).is_some_and(|job| matches!(job.activity, Activity::Jog(_)))
    }

    /// True if a stop is in progress.
    fn is_stopping(&self) -> bool {
        (self.moving.as_ref()).is_some_and(|job| job.activity == Activity::Stop)
    }

    /// Starts the order that waited for a stop, if the arm stands and the control is still held.
    fn begin_waiting(&mut self, stands: bool) {
        let Some((order, kept)) = self.waiting.take().filter(|_| stands) else {
            return;
        };
        if !matches!(order, PendantOrder::Jog { keep, .. } if kept.elapsed() >= keep) {
            // Cannot be refused: nothing moves the arm.
            self.order(order);
        }
    }

    fn start_jog(&mut self, direction: JogDirection, keep: Duration) -> Option<OrderDone> {
        if self.is_jog_pending() {
            self.moving = None;
        }
        let arm = self.arm.clone();
        let options = JogOptions::default().keep(keep);
        let future = async move { Ok(arm.jog_with(direction, options).await.map(Some)?) };
        // The guard of the current jog is kept until the new one begins: in the opposite direction
        // the arm reverses without a stop. Along another axis the driver first ends the jog and
        // waits for rest. If the control is released in the meantime, the new jog does not start.
        self.begin_if_free(Activity::Jog(direction), future)
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
        let future = async move {
            if first {
                saved.save_all(&arm, before).await;
            }
            arm.set(&jog).await?;
            arm.set(&moves).await?;
            Ok(None)
        };
        self.push_side_order(Activity::Speed(percent), future)
    }

    fn begin_if_free(
        &mut self,
        activity: Activity,
        future: impl Future<Output = OrderOutcome> + Send + 'static,
    ) -> Option<OrderDone> {
        let may_replace_jog = matches!(activity, Activity::Jog(_)) || self.jog.is_none();
        if self.moving.is_none() && may_replace_jog {
            self.begin(activity, future);
            return None;
        }
        let outcome = Err(OrderError::Busy);
        Some(OrderDone { activity, outcome })
    }

    fn begin(
        &mut self,
        activity: Activity,
        future: impl Future<Output = OrderOutcome> + Send + 'static,
    ) {
        let future = Box::pin(future);
        self.moving = Some(RunningOrder { activity, future });
    }

    fn push_side_order(
        &mut self,
        activity: Activity,
        future: impl Future<Output = OrderOutcome> + Send + 'static,
    ) -> Option<OrderDone> {
        let future = Box::pin(future);
        self.side_orders
            .push_back(RunningOrder { activity, future });
        None
    }
}

/// True for orders that move the arm, except for programs.
fn moves_arm(order: &PendantOrder) -> bool {
    matches!(
        order,
        PendantOrder::Jog { .. } | PendantOrder::Step { .. } | PendantOrder::Home
    )
}

/// Checks a program from step `from` on, and runs it.
async fn run(arm: Arm, plan: Plan, from: usize, program: Running) -> OrderOutcome {
    drop(lock(&program).take());
    arm.wait_still().await?;
    // A stop leaves the tool where it is: the person at the pendant decides where it goes.
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

    /// Holds a control for `ms` with the keep-alives of a pendant; returns the orders that failed.
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
    async fn other_axis_starts_at_rest_and_continues_while_held() {
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
        // The arm braked along x; none of that speed turned into motion along y in the wrong
        // direction.
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
    async fn later_stop_drops_pending_tool_orders() {
        let arm = Arm::connect("sim").await.unwrap();
        let mut worker = worker(&arm).await;
        let laser = PendantOrder::Tool(ToolOrder::Laser(true));
        assert!(worker.order(laser).is_none());
        assert!(worker.order(PendantOrder::Stop).is_none());
        assert_eq!(worker.next().await.activity, Activity::Stop);
        assert!(worker.side_orders.is_empty());
        // Orders given after the stop are carried out.
        let suction = ToolOrder::Suction(true);
        assert!(worker.order(PendantOrder::Tool(suction)).is_none());
        assert_eq!(worker.next().await.activity, Activity::Tool(suction));
        let laser = arm.get::<EndEffectorLaser>().await.unwrap();
        assert!(!laser.is_on.is_on());
    }
}
