//! Bound of a jog under a fence: the latest time for its stop, so that the tool comes to rest
//! inside.
//!
//! The jog itself is the arm's own, with this time as a bound of its deadline in the
//! [`Gate`](crate::gate::Gate). Bounded jogs would not do as well: joints would rest at the end of
//! each piece, and a jog would take twice the time to start.

use magician_host::MotionSettings;
use magician_motion::{ArmState, JogAxis, KinematicLimits, Plan, Planner, Trajectory};
use magician_protocol::commands::{JogCmd, Pose};
use tokio::time::Instant;

use super::Arm;
use super::driver::micros;
use super::fence::SendPermit;
use crate::build::JogDirection;
use crate::connection::Micros;
use crate::preflight::{Preflight, state_at};
use crate::{Error, Result};

/// Longest delay, us, between the due time of a stop and its effect, besides the round trips of the
/// line. Choice: a busy host and a period of the controller fit.
const STOP_LATENCY_MARGIN: Micros = 60_000;
/// Round trips that the stop may have to wait for. Choice: retransmissions, and requests before it.
const STOP_ROUND_TRIPS: Micros = 4;

/// Jog that has to be stopped before the fence.
#[derive(Clone, Debug)]
pub(super) struct FencedJog {
    motion: Trajectory,
    axis: JogAxis,
    positive: bool,
    /// Latest time of the stop since the start of the jog, us.
    stop: Micros,
}

impl FencedJog {
    /// Acquires the right to jog, with the bound. `None` without a fence; no bound if the fence is
    /// not in the way.
    pub(super) async fn hold(
        arm: &Arm,
        direction: JogDirection,
        deadline: Instant,
    ) -> Result<Option<(SendPermit<'_>, Option<Self>)>> {
        let (Some(turn), Some(jog)) = (
            arm.fence_check().hold_jog(deadline).await?,
            jog_of(direction),
        ) else {
            return Ok(None);
        };
        let (turn, check) = turn;
        let planner = check.jog_planner();
        let rates = jog_rates(arm, jog.axis).await?;
        let asked = Instant::now();
        arm.get::<Pose>().await?;
        let trip = micros(asked.elapsed());
        let fenced = fenced(
            &check,
            &planner,
            jog,
            rates,
            STOP_LATENCY_MARGIN + STOP_ROUND_TRIPS * trip,
        )?;
        Ok(Some((turn, fenced)))
    }

    /// Returns the latest time of the stop if the jog begins at `now`, the earliest possible start.
    pub(super) fn latest(&self, now: Micros) -> Micros {
        now.saturating_add(self.stop)
    }

    /// Returns the latest time of the stop, after a position read that was requested at `asked`.
    pub(super) fn latest_after(&self, asked: Micros, pose: &Pose) -> Micros {
        let seen = state_at(pose);
        let sign = if self.positive { 1.0 } else { -1.0 };
        // Bisection: finds when the planned jog is at the position read. A faster arm is further
        // along, so its stop comes sooner.
        let place = |state: &ArmState| sign * self.axis.value(state);
        let reached = place(&seen);
        let (mut early, mut late) = (0, self.motion.duration_us());
        // To a millisecond: far below the delays that the bound includes.
        while late - early > 1000 {
            let middle = early + (late - early) / 2;
            if place(&self.motion.sample(middle)) < reached {
                early = middle;
            } else {
                late = middle;
            }
        }
        asked.saturating_add(self.stop.saturating_sub(early))
    }
}

pub(super) fn jog_of(direction: JogDirection) -> Option<magician_motion::Jog> {
    let command = JogCmd::from(direction);
    let (number, positive) = command.cmd.axis()?;
    magician_motion::Jog::numbered(command.is_joint.is_on(), number, positive)
}

/// Returns the jog rates of an axis from the arm's settings.
pub(super) async fn jog_rates(arm: &Arm, axis: JogAxis) -> Result<KinematicLimits> {
    let mut settings = MotionSettings::at_power_up(arm.model());
    settings.jog_joint = arm.known().setting().await?;
    settings.jog_coordinate = arm.known().setting().await?;
    settings.jog_common = arm.known().setting().await?;
    Ok(settings.jog(axis, &arm.model().ceilings)?)
}

/// Plans a jog from where the arm stands; `late` is the delay until a stop takes effect.
fn fenced(
    check: &Preflight,
    planner: &Planner,
    jog: magician_motion::Jog,
    rates: KinematicLimits,
    late: Micros,
) -> Result<Option<FencedJog>> {
    let (Some(fence), Some(from)) = (check.held_fence(), check.arm()) else {
        return Ok(None);
    };
    // From rest: the gate starts no jog of another axis before the arm is at rest, and under a
    // fence a reversal stops first.
    let Plan { trajectory, .. } = planner.jog(from, jog, rates, 0.0)?;
    fence.check_speed_of(&trajectory).map_err(Error::fenced)?;
    let Some((crossing, _)) = fence.first_crossing(&trajectory) else {
        return Ok(None);
    };
    let stops_before = |at_us| {
        let stop = planner.jog_stop(&trajectory, at_us, rates.acceleration);
        fence.first_crossing(&stop.trajectory).is_none()
    };
    // Bisection for the latest stop whose braking stays inside, to 0.5 ms.
    let (mut early, mut latest) = (0, crossing);
    while latest - early > 500 {
        let middle = early + (latest - early) / 2;
        if stops_before(middle) {
            early = middle;
        } else {
            latest = middle;
        }
    }
    if early <= late {
        // Too close: the arm would be outside before it is at rest again.
        fence.check_motion(&trajectory).map_err(Error::fenced)?;
    }
    Ok(Some(FencedJog {
        motion: trajectory,
        axis: jog.axis,
        positive: jog.positive,
        stop: early - late,
    }))
}
