//! An arm while a person moves it by hand: orders go in, what comes of them and what the arm reports comes out.

use std::time::Duration;

use magician::commands::{DeviceName, DeviceWithL, JogCommonParams, PoseL, PtpCommonParams};
use magician::{Arm, ErrorKind, Event, Events, Result, StateWatch, Status};

use super::worker::{ArmWorker, SpeedRatios};
use super::{Activity, OrderDone, Pendant, PendantOrder, ToolState};
use crate::{Polled, SavedSettings};

/// Readings a second.
const RATE: f64 = 20.0;
/// Looks at the rail are so far apart.
const RAIL: Duration = Duration::from_millis(250);

/// What a session tells.
#[derive(Debug)]
#[non_exhaustive]
pub enum PendantEvent {
    /// An order is done, or was refused.
    Done(OrderDone),
    /// The arm was read, 20 times a second.
    Status(Status),
    /// Something happened to the arm or its line.
    Arm(Event),
    /// Where on its rail it is, mm.
    Rail(f32),
}

/// The arm while a pendant is used. One thing moves it at a time, and a stop overtakes it. A jog goes on only while it is kept up;
/// what is under way when a session is dropped is stopped.
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
    /// Reads what a pendant has to know. `saved` restores the speeds that orders change; clones of it may save more.
    ///
    /// # Errors
    /// As [`Laser::check_off`](magician::Laser::check_off): not while the laser burns; and as [`Arm::get`].
    pub async fn open(arm: &Arm, saved: &SavedSettings) -> Result<(Self, Pendant)> {
        arm.laser().check_off().await?;
        let ratios = SpeedRatios {
            jog: arm.get::<JogCommonParams>().await?,
            moves: arm.get::<PtpCommonParams>().await?,
        };
        let rail = known(arm.get::<DeviceWithL>().await)?.is_some_and(|rail| rail.with_l.is_on());
        let tools = ToolState::read(arm).await?;
        let pendant = Pendant::new(ratios.jog.velocity_ratio, tools, rail);
        let session = Self {
            worker: ArmWorker::new(arm, saved.clone(), ratios),
            state: arm.state(RATE)?,
            events: arm.events(),
            rail: rail.then(|| rail_position(arm)),
            arm: arm.clone(),
        };
        Ok((session, pendant))
    }

    /// Begins what is ordered, or says at once why not. What was ordered before and is not done yet gives way only to a stop, and
    /// a jog to another jog, which begins along another axis when the arm stands; everything else is [`OrderError::Busy`](super::OrderError::Busy) then, but for tools, speeds and
    /// alarms, which are seen to meanwhile, one after the other. While a stop is under way the newest order for a jog, a
    /// step or homing waits for its end; a jog begins then only if it is kept up, and [`PendantOrder::EndJog`] drops it and a step.
    pub fn order(&mut self, order: PendantOrder) -> Option<OrderDone> {
        self.worker.order(order)
    }

    /// What moves the arm by an order.
    #[must_use]
    pub fn activity(&self) -> Option<Activity> {
        self.worker.activity()
    }

    /// The step of the program that the arm is at, from 0, once that is known.
    #[must_use]
    pub fn step(&self) -> Option<usize> {
        self.worker.step()
    }

    /// Waits for what happens next. Has to be called again and again: orders go on in here. Dropping the future loses nothing.
    ///
    /// # Errors
    /// When the connection is closed for good.
    pub async fn next(&mut self) -> Result<PendantEvent> {
        tokio::select! {
            biased;
            done = self.worker.next() => Ok(PendantEvent::Done(done)),
            status = self.state.changed() => status.map(PendantEvent::Status),
            Some(event) = self.events.next() => Ok(PendantEvent::Arm(event)),
            Some(rail) = next_of(&mut self.rail) => Ok(PendantEvent::Rail(rail)),
        }
    }

    /// Ends it: what moves the arm is stopped, the settings are as they were, and a laser that may burn goes dark.
    ///
    /// # Errors
    /// When the arm does not confirm that it stands, does not take its settings, or cannot be darkened.
    pub async fn close(self, pendant: &Pendant) -> Result<()> {
        let finished = self.worker.finish().await;
        if pendant.may_burn() {
            self.arm.laser().switch_off().await?;
        }
        finished
    }
}

/// Where the carriage on the rail is, mm, four times a second.
#[must_use]
pub fn rail_position(arm: &Arm) -> Polled<f32> {
    let arm = arm.clone();
    Polled::every(RAIL, move || {
        let arm = arm.clone();
        // What cannot be read now is read the next time.
        async move { arm.get::<PoseL>().await.ok().map(|at| at.pose_l) }
    })
}

/// The name that was given to the arm; empty if it has none, or does not tell.
///
/// # Errors
/// As [`Arm::get`], but for an arm that does not know the command.
pub async fn device_name(arm: &Arm) -> Result<String> {
    let name = known(arm.get::<DeviceName>().await)?.map(|name| name.device_name.to_string());
    Ok(name.unwrap_or_default())
}

/// Nothing where an arm has no such thing.
pub(super) fn known<T>(answer: Result<T>) -> Result<Option<T>> {
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

/// The next reading, if anything is read at all.
async fn next_of<T: Clone + Send + Sync + 'static>(polled: &mut Option<Polled<T>>) -> Option<T> {
    match polled {
        Some(polled) => Some(polled.next().await),
        None => None,
    }
}
