//! Settings of bounded jogs, and the calls that wait until they are restored.
//!
//! The pieces need certain speeds, so a jog changes settings and owes their old values. Other calls
//! must not see or overwrite the temporary ones: they wait for the end of the jog. Settings that
//! could not be restored over a broken line are restored over the next one.

use std::pin::Pin;
use std::sync::Arc;

use magician_host::MotionSettings;
use magician_motion::JogAxis;
use magician_protocol::commands::{PtpCommonParams, PtpJointParams};
use magician_protocol::{Effect, FrameBuf, Row, Set};
use tokio::time::{Instant, timeout_at};

use super::pace::{Pace, PieceEnd};
use crate::arm::driver::sets_going;
use crate::arm::fenced_jog::{jog_of, jog_rates};
use crate::arm::link::Link;
use crate::arm::shared::lock;
use crate::arm::{Arm, SettingsBackup, Shared};
use crate::build::{self, JogDirection};
use crate::connection::Request;
use crate::gate::JogId;
use crate::{Error, ErrorCode, ErrorKind, Result, message};

/// Bounded jogs of a connection.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::arm) struct BoundedJogs {
    /// The last one requested: it replaces all earlier ones.
    newest: Option<JogId>,
    /// The one whose task currently controls the arm or its settings.
    led: Option<Led>,
}

#[derive(Clone, Copy, Debug)]
struct Led {
    jog: JogId,
    /// True while it ends: the arm comes to rest and gets its settings back.
    ends: bool,
}

/// Answer to a request that waits for the end of a jog.
type Later<'a> = Pin<Box<dyn Future<Output = Result<FrameBuf>> + Send + 'a>>;

impl Shared {
    /// Notes a request for a bounded jog.
    pub(super) fn asks_bounded(&self, jog: JogId) {
        self.bounded.send_modify(|jogs| jogs.newest = Some(jog));
    }

    pub(super) fn is_replaced(&self, jog: JogId) -> bool {
        self.bounded.borrow().newest != Some(jog)
    }

    fn ends_bounded(&self, jogs: &BoundedJogs) -> bool {
        jogs.led
            .is_some_and(|led| led.ends || self.gate().is_ending_jog(led.jog))
    }

    /// Marks a bounded jog as ending: other calls wait until the settings are restored.
    pub(in crate::arm) fn led_ends(&self, jog: JogId) {
        self.bounded.send_if_modified(|jogs| {
            let led = jogs.led.as_mut().filter(|led| led.jog == jog && !led.ends);
            led.map(|led| led.ends = true).is_some()
        });
    }
}

/// Time during which the task of a jog controls the arm or its settings.
pub(super) struct JogControl {
    shared: Arc<Shared>,
    jog: JogId,
}

impl JogControl {
    pub(super) fn new(shared: &Arc<Shared>, jog: JogId) -> Self {
        let led = Led { jog, ends: false };
        shared.bounded.send_modify(|jogs| jogs.led = Some(led));
        let shared = Arc::clone(shared);
        Self { shared, jog }
    }

    /// Restores settings that a broken line prevented, over the next line. Does not keep the
    /// connection open.
    pub(super) async fn settle(self, arm: Arm, mut restored: Result<()>) {
        let mut link = self.shared.link.subscribe();
        let (inner, patience) = (Arc::downgrade(&arm.inner), arm.patience);
        drop(arm);
        while restored.is_err_and(|error| error.kind() == ErrorKind::Port) {
            // A strong handle here would keep the connection open for as long as the line is lost.
            let found = link.wait_for(|link| !matches!(link, Link::Lost { sought: true, .. }));
            let is_up = found.await.is_ok_and(|link| matches!(*link, Link::Up));
            let Some(inner) = inner.upgrade().filter(|_| is_up) else {
                return;
            };
            let arm = Arm {
                inner,
                allows_laser: false,
                passes_jogs: false,
                leads: true,
                allows_unhomed: false,
                patience,
            };
            restored = arm.restore_settings().await;
        }
    }
}

impl Drop for JogControl {
    fn drop(&mut self) {
        self.shared.bounded.send_if_modified(|jogs| {
            let led = jogs.led.take_if(|led| led.jog == self.jog);
            led.is_some()
        });
    }
}

impl Arm {
    /// True if a request has to wait for the end of a bounded jog: a setting it changes would be
    /// reverted, and a setting it reads is temporary. Stops, state reads, laser and motors never
    /// wait.
    pub(in crate::arm) fn waits_for_jog(&self, request: &Request) -> bool {
        let shared = &self.inner.shared;
        let frame = request.frame().frame();
        let is_setting = Row::with_id(frame.id()).is_some_and(|row| row.effect == Effect::Setting);
        let waits = !self.leads && (is_setting || sets_going(&frame));
        let is_up = matches!(*shared.link.borrow(), Link::Up);
        waits && is_up && shared.ends_bounded(&shared.bounded.borrow())
    }

    /// Sends a request after the end of the jog. Boxed: almost no call waits, and every call would
    /// carry the future.
    pub(in crate::arm) fn ask_behind_jog(&self, request: Request, deadline: Instant) -> Later<'_> {
        Box::pin(async move {
            let shared = &self.inner.shared;
            let mut jogs = shared.bounded.subscribe();
            let over = jogs.wait_for(|jogs| !shared.ends_bounded(jogs));
            if timeout_at(deadline, over).await.is_err() {
                let message = message!("it was not sent: a jog has not come to its end");
                return Err(Error::new(ErrorCode::NotSent, message));
            }
            self.ask_until(request, deadline).await
        })
    }

    /// Restores the settings that a jog has changed and still owes.
    pub(super) async fn restore_settings(&self) -> Result<()> {
        // Taken out before the await: no lock is held while the arm is asked.
        let mut owed = std::mem::take(&mut *lock(&self.inner.shared.owed));
        let mut again = owed.clone();
        let restored = owed.restore(self).await;
        if restored.is_err() {
            let mut owed = lock(&self.inner.shared.owed);
            again.append(std::mem::take(&mut *owed));
            *owed = again;
        }
        restored
    }
}

/// Sets the speeds for the pieces of a jog, returns its pace, and notes the previous values as
/// owed.
pub(super) async fn set_pace(
    arm: &Arm,
    direction: JogDirection,
    within: f64,
) -> Result<(Pace, Vec<Set>)> {
    let (law, ceilings) = (arm.model().law, &arm.model().ceilings);
    let whole = Set::from(PtpCommonParams {
        velocity_ratio: 100.0,
        acceleration_ratio: 100.0,
    });
    let (pace, settings) = match jog_of(direction).map(|jog| jog.axis) {
        Some(axis @ (JogAxis::X | JogAxis::Y | JogAxis::Z)) => {
            let jog = jog_rates(arm, axis).await?;
            let pace = Pace::new(PieceEnd::Through, jog, ceilings.of_axis(axis), within, law);
            let speed =
                build::path_speed(pace.rates.velocity as f32, pace.rates.acceleration as f32);
            (pace, vec![speed])
        }
        Some(axis) => {
            // A jog of r turns joint 4 alone.
            let (joint, turning) = match axis {
                JogAxis::J1 => (0, axis),
                JogAxis::J2 => (1, axis),
                JogAxis::J3 => (2, axis),
                _ => (3, JogAxis::J4),
            };
            let jog = jog_rates(arm, axis).await?;
            let pace = Pace::new(
                PieceEnd::AtRest,
                jog,
                ceilings.of_axis(turning),
                within,
                law,
            );
            let mut speeds: PtpJointParams = arm.known().setting().await?;
            speeds.velocity[joint] = pace.rates.velocity as f32;
            speeds.acceleration[joint] = pace.rates.acceleration as f32;
            (pace, vec![speeds.into(), whole])
        }
        None => {
            let mut settings = MotionSettings::at_power_up(arm.model());
            settings.jog_rail = arm.known().setting().await?;
            settings.jog_common = arm.known().setting().await?;
            let jog = settings.rail_jog().ok_or_else(|| {
                Error::invalid(message!(
                    "speeds on the rail and their ratios must be above 0"
                ))
            })?;
            // The limits of a rail are unknown, so its jog speed is never exceeded.
            let pace = Pace::new(PieceEnd::AtRest, jog, jog, within, law);
            let speed =
                build::rail_speed(pace.rates.velocity as f32, pace.rates.acceleration as f32);
            (pace, vec![speed, whole])
        }
    };
    let before = SettingsBackup::read(arm, &settings).await?;
    for (setting, before) in settings.iter().zip(before.settings()) {
        if setting != before {
            lock(&arm.inner.shared.owed).save(*before);
            arm.set_any(setting).await?;
        }
    }
    Ok((pace, settings))
}
