//! The bound of a jog under a fence: when its stop has to go out, so that the tool is at rest before it.
//!
//! It is a jog like any other, with this instant as a bound of its deadline in the [`Gate`](crate::gate::Gate). Pieces in its place
//! would cost a person the joints, which rest at the end of each piece, and twice the time to start.

use magician_host::MotionSettings;
use magician_motion::{ArmState, JogAxis, KinematicLimits, Plan, Planner, Trajectory};
use magician_protocol::commands::{JogCmd, Pose};
use tokio::time::Instant;

use super::Arm;
use super::driver::micros;
use super::fence::Turn;
use crate::build::JogDirection;
use crate::connection::Micros;
use crate::preflight::{Preflight, state_at};
use crate::{Error, Result};

/// What may pass between the instant at which a stop is due and the arm that obeys it, besides the line's own time.
const LATE: Micros = 60_000;
/// Round trips that the stop may have to wait for.
const TRIPS: Micros = 4;

/// A jog that has to be stopped.
#[derive(Clone, Debug)]
pub(super) struct FencedJog {
    motion: Trajectory,
    axis: JogAxis,
    positive: bool,
    /// The stop has to go out at this time of the jog at the latest, us.
    stop: Micros,
}

impl FencedJog {
    /// The right to jog, and the bound: nothing without a fence, no bound where none is in the way.
    pub(super) async fn hold(
        arm: &Arm,
        direction: JogDirection,
        deadline: Instant,
    ) -> Result<Option<(Turn<'_>, Option<Self>)>> {
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
        let fenced = fenced(&check, &planner, jog, rates, LATE + TRIPS * trip)?;
        Ok(Some((turn, fenced)))
    }

    /// When it has to be stopped if it begins now: it cannot have begun before.
    pub(super) fn latest(&self, now: Micros) -> Micros {
        now.saturating_add(self.stop)
    }

    /// The same, where the arm was seen on its way by a look that was asked for then.
    pub(super) fn latest_after(&self, asked: Micros, pose: &Pose) -> Micros {
        let seen = state_at(pose);
        let sign = if self.positive { 1.0 } else { -1.0 };
        let place = |state: &ArmState| sign * self.axis.value(state);
        let reached = place(&seen);
        let (mut early, mut late) = (0, self.motion.duration_us());
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

/// How fast the arm jogs along an axis, as it is set.
pub(super) async fn jog_rates(arm: &Arm, axis: JogAxis) -> Result<KinematicLimits> {
    let mut settings = MotionSettings::at_power_up(arm.model());
    settings.jog_joint = arm.known().setting().await?;
    settings.jog_coordinate = arm.known().setting().await?;
    settings.jog_common = arm.known().setting().await?;
    Ok(settings.jog(axis, &arm.model().ceilings)?)
}

/// How far a jog may go from where the arm stands; `late` passes until a stop is obeyed.
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
    // From rest: the gate begins no jog of another axis before the arm stands, and a reversal under a fence stops first.
    let Plan { trajectory, .. } = planner.jog(from, jog, rates, 0.0)?;
    fence.check_speed_of(&trajectory).map_err(Error::fenced)?;
    let Some((crossing, _)) = fence.first_crossing(&trajectory) else {
        return Ok(None);
    };
    let stops_before = |at_us| {
        let stop = planner.jog_stop(&trajectory, at_us, rates.acceleration);
        fence.first_crossing(&stop.trajectory).is_none()
    };
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
        // So near that it would be beyond before it stands again.
        fence.check_way(&trajectory).map_err(Error::fenced)?;
    }
    Ok(Some(FencedJog {
        motion: trajectory,
        axis: jog.axis,
        positive: jog.positive,
        stop: early - late,
    }))
}
