//! Session of manual jogging: takes orders, returns their outcomes and the arm's reports.
//!
//! One task owns the session and calls [`PendantSession::next`] in a loop; there the orders make
//! progress, and readings and events arrive.

use std::time::Duration;

use magician::commands::{DeviceName, DeviceWithL, JogCommonParams, PoseL, PtpCommonParams};
use magician::{Arm, ErrorKind, Event, Events, Result, StateWatch, Status};

use super::worker::{ArmWorker, SpeedRatios};
use super::{Activity, OrderDone, Pendant, PendantOrder, ToolState};
use crate::{Polled, SavedSettings};

/// Rate of pose readings, Hz.
const POSE_RATE: f64 = 20.0;
/// Interval between readings of the rail. A choice: each reading costs a request besides the pose.
const RAIL_POLL_INTERVAL: Duration = Duration::from_millis(250);

/// Event of a session.
#[derive(Debug)]
#[non_exhaustive]
pub enum PendantEvent {
    /// An order is done or was refused.
    Done(OrderDone),
    /// A reading of the arm; 20 a second.
    Status(Status),
    /// An event of the arm or its line.
    Arm(Event),
    /// Position on the rail, mm.
    Rail(f32),
}

/// An arm controlled by a pendant. One activity moves it at a time, and a stop overtakes any other.
/// A jog lasts only while it is kept alive. Dropping the session stops whatever moves.
///
/// ```
/// use std::time::Duration;
///
/// use magician::Arm;
/// use magician_job::SavedSettings;
/// use magician_job::jog::{Axis, JogDirection, PendantOrder, PendantEvent, PendantSession, Activity};
///
/// # #[tokio::main(flavor = "current_thread")]
/// # async fn main() -> magician::Result<()> {
/// let arm = Arm::connect("sim").await?;
/// let (mut session, mut pendant) = PendantSession::open(&arm, &SavedSettings::default()).await?;
/// let up = JogDirection { axis: Axis::Z, forward: true };
/// if let Some(order) = pendant.press(up, Duration::ZERO) {
///     if let Some(refused) = session.order(order) {
///         pendant.done(&refused);
///     }
///     pendant.activity = session.activity();
/// }
/// assert_eq!(pendant.activity, Some(Activity::Step(up)));
/// while pendant.activity.is_some() {
///     if let PendantEvent::Done(done) = session.next().await? {
///         pendant.done(&done);
///     }
///     pendant.activity = session.activity();
/// }
/// session.close(&pendant).await?;
/// # Ok(())
/// # }
/// ```
pub struct PendantSession {
    arm: Arm,
    worker: ArmWorker,
    state: StateWatch,
    events: Events,
    rail: Option<Polled<f32>>,
}

impl PendantSession {
    /// Opens a session and reads the initial state of the pendant. `saved` restores the speeds that
    /// orders change; its clones may save more settings.
    ///
    /// # Errors
    /// Same as [`Laser::check_off`](magician::Laser::check_off) if the laser burns; else as
    /// [`Arm::get`].
    pub async fn open(arm: &Arm, saved: &SavedSettings) -> Result<(Self, Pendant)> {
        arm.laser().check_off().await?;
        let ratios = SpeedRatios {
            jog: arm.get::<JogCommonParams>().await?,
            moves: arm.get::<PtpCommonParams>().await?,
        };
        let rail = none_if_unsupported(arm.get::<DeviceWithL>().await)?
            .is_some_and(|rail| rail.with_l.is_on());
        let tools = ToolState::read(arm).await?;
        let pendant = Pendant::new(ratios.jog.velocity_ratio, tools, rail);
        let session = Self {
            worker: ArmWorker::new(arm, saved.clone(), ratios),
            state: arm.state(POSE_RATE)?,
            events: arm.events(),
            rail: rail.then(|| rail_position(arm)),
            arm: arm.clone(),
        };
        Ok((session, pendant))
    }

    /// Starts an order, or returns its refusal at once.
    ///
    /// Only a stop replaces the current activity, and a jog replaces a jog (along another axis it
    /// begins once the arm stands). All other motion is refused with
    /// [`OrderError::Busy`](super::OrderError::Busy). Tools, speeds and alarms are handled in
    /// parallel, one after the other. During a stop the newest jog, step or homing waits for its
    /// end. A waiting jog then begins only if it was kept alive, and [`PendantOrder::EndJog`] drops
    /// a waiting jog or step.
    pub fn order(&mut self, order: PendantOrder) -> Option<OrderDone> {
        self.worker.order(order)
    }

    /// Activity that moves the arm, if any.
    #[must_use]
    pub fn activity(&self) -> Option<Activity> {
        self.worker.activity()
    }

    /// Current step of the running program, from 0, once known.
    #[must_use]
    pub fn step(&self) -> Option<usize> {
        self.worker.step()
    }

    /// Waits for the next event. Call it in a loop: orders make progress only in here. Dropping the
    /// future loses nothing.
    ///
    /// # Errors
    /// Fails when the connection is closed for good.
    pub async fn next(&mut self) -> Result<PendantEvent> {
        tokio::select! {
            biased;
            done = self.worker.next() => Ok(PendantEvent::Done(done)),
            status = self.state.changed() => status.map(PendantEvent::Status),
            Some(event) = self.events.next() => Ok(PendantEvent::Arm(event)),
            Some(rail) = next_reading(&mut self.rail) => Ok(PendantEvent::Rail(rail)),
        }
    }

    /// Ends the session: stops motion, restores the settings, and switches off a laser that may
    /// burn.
    ///
    /// # Errors
    /// Fails if the arm does not confirm that it stands, refuses its settings, or cannot switch the
    /// laser off.
    pub async fn close(self, pendant: &Pendant) -> Result<()> {
        let finished = self.worker.finish().await;
        if pendant.may_burn() {
            self.arm.laser().switch_off().await?;
        }
        finished
    }
}

/// Polls the position of the carriage on the rail, mm, four times a second.
#[must_use]
pub fn rail_position(arm: &Arm) -> Polled<f32> {
    let arm = arm.clone();
    Polled::every(RAIL_POLL_INTERVAL, move || {
        let arm = arm.clone();
        // A failed reading is retried at the next interval.
        async move { arm.get::<PoseL>().await.ok().map(|at| at.pose_l) }
    })
}

/// Name given to the arm; empty if it has none, or does not report it.
///
/// # Errors
/// Same as [`Arm::get`], except for an arm that does not know the command.
pub async fn device_name(arm: &Arm) -> Result<String> {
    let name = none_if_unsupported(arm.get::<DeviceName>().await)?
        .map(|name| name.device_name.to_string());
    Ok(name.unwrap_or_default())
}

/// Turns the errors of an arm that lacks a function into `None`. A timeout counts too, for an arm
/// that leaves an unknown command unanswered.
pub(super) fn none_if_unsupported<T>(answer: Result<T>) -> Result<Option<T>> {
    match answer {
        Ok(answer) => Ok(Some(answer)),
        Err(error)
            if matches!(
                error.kind(),
                ErrorKind::Timeout | ErrorKind::Unsupported | ErrorKind::Unexpected
            ) =>
        {
            Ok(None)
        }
        Err(error) => Err(error),
    }
}

/// Next reading of `polled`; `None` if nothing is polled.
async fn next_reading<T: Clone + Send + Sync + 'static>(
    polled: &mut Option<Polled<T>>,
) -> Option<T> {
    match polled {
        Some(polled) => Some(polled.next().await),
        None => None,
    }
}
