//! Paths of a tool that has finished its work: straight up, and to its parking position.

use std::time::Duration;

use magician_motion::{ArmState, Pose};
use magician_protocol::Set;

use super::Preflight;
use crate::build::{line_speed, line_to, move_to, speed};
use crate::message;
use crate::{Error, ErrorCode, Result};

/// Longest duration of a lift at the speeds in force; a slower lift sets its own speeds.
// A choice: a pen is then up within two seconds of a stop.
const MAX_LIFT_TIME: Duration = Duration::from_millis(800);
/// Speed (mm/s) and acceleration (mm/s2) of a lift that sets its own, within the arm's ceilings
/// (model section 6).
const QUICK_SPEED: [f32; 2] = [200.0, 400.0];
/// Resolution of the height of a lift cut short by the reach, mm.
const HEIGHT_RESOLUTION: f64 = 0.05;
/// Largest dip of a path to the park below the lower of its ends, mm: the error of `f32` and of a
/// sampled curve.
const MAX_DIP: f64 = 0.5;
/// Number of samples of each motion of such a path.
const SAMPLES: u64 = 64;
/// Distance below which no move is needed, mm.
const MIN_DISTANCE: f64 = 1e-3;

/// Path straight up from the arm's present position.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Lift {
    /// Height of the lift, mm. 0 if the arm cannot move up at all.
    pub by: f64,
    /// Commands to send: a straight line, preceded by speeds if those in force are too slow. Empty
    /// if there is nowhere to go.
    pub commands: Vec<Set>,
}

impl Preflight {
    /// Plans a lift straight up by `height` (mm), or as far as the arm reaches.
    ///
    /// It takes less than 1.5 s for heights up to 150 mm, whatever speeds are in force, unless a
    /// fence limits the speed.
    ///
    /// ```
    /// use magician_host::build;
    /// use magician_host::preflight::Preflight;
    /// use magician_host::{JointAngles, ToolBias};
    ///
    /// let mut arm = Preflight::at(JointAngles::HOME, ToolBias::NONE);
    /// arm.check(&build::line_to(250.0, 0.0, -40.0, 0.0))?;
    /// assert_eq!(arm.lift(10.0)?.commands, [build::line_to(250.0, 0.0, -30.0, 0.0)]);
    /// // Higher than the arm reaches at this position.
    /// let lift = arm.lift(500.0)?;
    /// assert!((139.0..140.0).contains(&lift.by), "{lift:?}");
    /// # Ok::<(), magician_host::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`InvalidInput`](crate::ErrorKind::InvalidInput) for a negative height, or if the arm's
    /// position is unknown.
    pub fn lift(&self, height: f64) -> Result<Lift> {
        if !(height.is_finite() && height >= 0.0) {
            return Err(Error::invalid(message!(
                "the lift is {height} mm, it must be 0 or more",
                height
            )));
        }
        let from = self.stands()?.pose;
        // A fence may limit the speed of the lift, but must not prevent it.
        let top = self.held_fence().and_then(|fence| fence.top_speed());
        let [velocity, acceleration] = QUICK_SPEED;
        let velocity = top.map_or(velocity, |top| velocity.min(top as f32));
        let quick = [line_speed(velocity, acceleration), speed(100.0, 100.0)];
        let mut start = self.clone();
        if top.is_some() {
            // The speeds in force may exceed those of the fence.
            for command in &quick {
                start.check(command)?;
            }
        }
        let up = |by: f64| {
            let command = line(Pose {
                z: from.z + by,
                ..from
            });
            let step = start.clone().check(&command).ok()?;
            Some((by, command, step.time))
        };
        // Bisection is valid because a longer line begins with the shorter one: above a refused
        // height every height is refused.
        let found = up(height).or_else(|| {
            let (mut low, mut high) = (0.0, height);
            while high - low > HEIGHT_RESOLUTION {
                let middle = f64::midpoint(low, high);
                match up(middle) {
                    Some(_) => low = middle,
                    None => high = middle,
                }
            }
            up(low)
        });
        let Some((by, command, time)) = found.filter(|(by, ..)| *by > MIN_DISTANCE) else {
            return Ok(Lift {
                by: 0.0,
                commands: Vec::new(),
            });
        };
        // Speeds are changed only if necessary, because they stay in force afterwards.
        let commands = if top.is_some() || time > MAX_LIFT_TIME {
            quick.into_iter().chain([command]).collect()
        } else {
            vec![command]
        };
        Ok(Lift { by, commands })
    }

    /// Plans a path to the parking position (x, y, z of the tool's tip).
    ///
    /// The path leads straight up if the parking position is higher, across at the height of the
    /// higher end, and straight down; no part is below both ends. The path across is a straight
    /// line, or a move of all joints together if the base is in the way. The tool turns with the
    /// arm.
    ///
    /// # Errors
    /// [`Unreachable`](crate::ErrorKind::Unreachable) with value and limit if the position or every
    /// path to it is out of reach; [`InvalidInput`](crate::ErrorKind::InvalidInput) if the arm's
    /// position is unknown.
    pub fn way_to_park(&self, place: [f64; 3]) -> Result<Vec<Set>> {
        let from = self.stands()?.pose;
        let [x, y, z] = place;
        let turned = libm::atan2(y, x) - libm::atan2(from.y, from.x);
        let to = Pose {
            x,
            y,
            z,
            r: from.r + turned.to_degrees(),
        };
        // Check the position itself first: its error is more useful than that of a missing path.
        self.clone().check(&joints(to))?;
        // The higher of both ends clears what the arm has worked on.
        let height = from.z.max(z);
        let above = |end: Pose| Pose { z: height, ..end };
        let across = [line(above(to)), joints(above(to))];
        let by_way_of_height = across.map(|across| vec![line(above(from)), across, line(to)]);
        // Fallbacks for positions without room above.
        let straight = [line(to), joints(to)].map(|command| vec![command]);
        let mut refusal = None;
        for way in by_way_of_height.into_iter().chain(straight) {
            match self.followed(way, from.z.min(z)) {
                Ok(way) => return Ok(way),
                Err(error) => refusal = refusal.or(Some(error)),
            }
        }
        let none = || Error::new(ErrorCode::OutOfReach, message!("there is no path to it"));
        Err(refusal.unwrap_or_else(none))
    }

    /// Returns the commands of a path that move the arm, if the arm can follow it without going
    /// below this height.
    fn followed(&self, way: Vec<Set>, lowest: f64) -> Result<Vec<Set>> {
        let mut arm = self.clone();
        let mut kept = Vec::new();
        for command in way {
            let before = *arm.stands()?;
            let trajectory = arm.motion_of(&before, &command);
            let after = arm.check(&command)?.end.unwrap_or(before);
            if before.pose.distance_to(&after.pose) < MIN_DISTANCE {
                continue;
            }
            let dips = trajectory.is_none_or(|trajectory| {
                let end = trajectory.duration_us();
                let heights = (0..=SAMPLES).map(|nth| trajectory.curve(end / SAMPLES * nth).pose.z);
                heights.fold(f64::INFINITY, f64::min) < lowest - MAX_DIP
            });
            if dips {
                return Err(Error::new(
                    ErrorCode::OutOfReach,
                    message!(
                        "the base is in the way, and the path around it dips below both of its ends"
                    ),
                ));
            }
            kept.push(command);
        }
        Ok(kept)
    }

    fn stands(&self) -> Result<&ArmState> {
        self.arm().ok_or_else(|| {
            Error::new(
                ErrorCode::PositionUnknown,
                message!("the arm's position is unknown"),
            )
        })
    }
}

fn line(to: Pose) -> Set {
    let [x, y, z, r] = to.to_array().map(|value| value as f32);
    line_to(x, y, z, r)
}

fn joints(to: Pose) -> Set {
    let [x, y, z, r] = to.to_array().map(|value| value as f32);
    move_to(x, y, z, r)
}

#[cfg(test)]
mod tests {
    use magician_motion::{JointAngles, ToolBias};

    use super::*;

    fn at(x: f32, y: f32, z: f32) -> Preflight {
        let mut arm = Preflight::at(JointAngles::HOME, ToolBias::PEN);
        arm.check(&move_to(x, y, z, 0.0)).expect("within reach");
        arm
    }

    /// End of a path, and its lowest z.
    fn follow(arm: &Preflight, way: &[Set]) -> ([f64; 3], f64) {
        let (mut arm, mut lowest) = (arm.clone(), f64::INFINITY);
        for command in way {
            let before = *arm.arm().expect("known");
            let trajectory = arm.motion_of(&before, command).expect("a move");
            for nth in 0..=100 {
                let at = trajectory.curve(trajectory.duration_us() * nth / 100);
                lowest = lowest.min(at.pose.z);
            }
            arm.check(command).expect("it was found so");
        }
        let pose = arm.arm().expect("known").pose;
        ([pose.x, pose.y, pose.z], lowest)
    }

    #[test]
    fn a_lift_is_straight_up_and_never_beyond_reach() {
        for (x, y, z) in [(240.0, 0.0, -50.0), (200.0, 120.0, 60.0), (290.0, 0.0, 0.0)] {
            let arm = at(x, y, z);
            let mut before = 0.0;
            for height in [0.0, 1.0, 10.0, 60.0, 150.0, 400.0] {
                let lift = arm.lift(height).expect("a height");
                assert!(
                    lift.by <= height && lift.by >= before - 2.0 * HEIGHT_RESOLUTION,
                    "{lift:?}"
                );
                before = lift.by;
                if lift.commands.is_empty() {
                    assert!(lift.by == 0.0, "{lift:?}");
                    continue;
                }
                let time = arm.estimate(&lift.commands).expect("checked");
                assert!(height > 150.0 || time < Duration::from_millis(1500));
                let last = lift.commands.last().copied().expect("a line");
                let (end, _) = follow(&arm, &[last]);
                let expected = [f64::from(x), f64::from(y), f64::from(z) + lift.by];
                let off = end.iter().zip(expected).map(|(is, wanted)| is - wanted);
                assert!({ off }.all(|off| off.abs() < 1e-3), "{end:?} {expected:?}");
            }
            let most = arm.lift(400.0).expect("a height").by;
            assert!(
                arm.clone()
                    .check(&line_to(x, y, z + most as f32 + 0.2, 0.0))
                    .is_err()
            );
        }
        assert!(at(240.0, 0.0, 0.0).lift(-1.0).is_err());
    }

    #[test]
    fn a_slow_arm_lifts_at_speeds_of_its_own() {
        let mut arm = at(240.0, 0.0, -50.0);
        assert_eq!(arm.lift(10.0).expect("a height").commands.len(), 1);
        arm.check(&speed(1.0, 1.0)).expect("a speed");
        let lift = arm.lift(10.0).expect("a height");
        assert_eq!(lift.commands.len(), 3);
        let time = arm.estimate(&lift.commands).expect("checked");
        assert!(time < Duration::from_millis(500), "{time:?}");
    }

    #[test]
    fn the_way_to_the_park_is_never_lower_than_its_ends() {
        let place = [180.0, -150.0, 40.0];
        for (x, y, z) in [
            (240.0, 60.0, -40.0),
            (200.0, 0.0, 90.0),
            (180.0, -150.0, -50.0),
            (20.0, 220.0, -30.0),
        ] {
            let arm = at(x, y, z);
            let way = arm.way_to_park(place).expect("a way");
            let (end, lowest) = follow(&arm, &way);
            let off = end.iter().zip(place).map(|(is, wanted)| is - wanted);
            assert!({ off }.all(|off| off.abs() < 1e-3), "{end:?}");
            assert!(
                lowest >= f64::from(z).min(place[2]) - 2.0 * MAX_DIP,
                "{lowest}"
            );
        }
        let arm = at(180.0, -150.0, 40.0);
        assert_eq!(arm.way_to_park(place).expect("a way"), []);
    }

    #[test]
    fn a_park_out_of_reach_says_by_how_much() {
        let error = at(240.0, 0.0, 0.0).way_to_park([400.0, 0.0, 0.0]);
        let error = error.expect_err("too far");
        assert_eq!(error.kind(), crate::ErrorKind::Unreachable);
        assert!(error.value() > error.limit(), "{error}");
    }
}
