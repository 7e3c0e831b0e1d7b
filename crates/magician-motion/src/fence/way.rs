//! Check of a whole motion against a fence: its path and its speed.
//!
//! Between two times the tip deviates from the straight line between its two positions by at most
//! an eighth of its highest acceleration times the time squared. A stretch is clear if its line is
//! further than that from a bound. Any other stretch is halved, until the line is accurate enough
//! to decide. Straight paths are their own lines.

use super::{Breach, Fence, FencePart, TOLERANCE};
use crate::angle::DEGREES_PER_RADIAN;
use crate::arc_segment::ArcSegment;
use crate::joint_segment::JointSegment;
use crate::move_segment::MoveSegment;
use crate::{Geometry, Trajectory};

/// Largest deviation of the tip from the line of a stretch at which the line alone decides, mm.
/// Half of the tolerance at a bound.
const CHORD_TOLERANCE: f64 = 0.005;
/// Longest stretch for which a crossing is reported, us: the accuracy of its time.
const CROSSING_RESOLUTION_US: u64 = 500;
/// Shortest stretch that is halved, us. A curve still undecided counts as a crossing.
const MIN_STRETCH_US: u64 = 8;
/// Rounding allowance per motion for a tip that is already beyond a bound, mm.
const ROUNDING: f64 = 1e-6;
/// Fewest and most samples of the speed of a joint motion. The upper limit bounds the work.
const MIN_SAMPLES: u64 = 64;
const MAX_SAMPLES: u64 = 2000;
/// Distance between samples, us, within those numbers.
const SAMPLE_SPACING_US: u64 = 4_000;
/// Factor for a speed between two samples. A choice: 0.2 % at 4 ms spacing.
const SPEED_MARGIN: f64 = 1.002;

/// Greatest depth beyond a bound that is allowed on a path that begins at depth `start`, mm.
fn limit(start: f64) -> f64 {
    if start > TOLERANCE {
        start + CHORD_TOLERANCE
    } else {
        TOLERANCE
    }
}

/// Greatest depth beyond a bound that is allowed at the end, mm. From beyond a bound only a
/// rounding error is added to `start`, so that repeated motions do not creep outwards.
pub(super) fn end_limit(start: f64) -> f64 {
    if start > TOLERANCE {
        start + ROUNDING
    } else {
        TOLERANCE
    }
}

/// A stretch of a path: two times, and the tip at both.
#[derive(Clone, Copy)]
struct Stretch {
    from_us: u64,
    to_us: u64,
    from: [f64; 3],
    to: [f64; 3],
}

impl Fence {
    /// Checks that the tip of a motion neither crosses a bound nor moves further beyond one.
    ///
    /// # Errors
    /// The bound crossed first, and the greatest distance of the tip beyond it.
    pub fn check_motion(&self, motion: &Trajectory) -> Result<(), Breach> {
        match self.first_crossing(motion) {
            None => Ok(()),
            Some((at_us, part)) => Err(self.deepest(motion, at_us, part)),
        }
    }

    /// Returns the time of the first crossing, in microseconds from the start, and the part of the
    /// fence that is crossed. The time may be too early, never too late.
    #[must_use]
    pub fn first_crossing(&self, motion: &Trajectory) -> Option<(u64, FencePart)> {
        let found = self.parts().filter_map(|part| {
            let at_us = self.crossing_of(part, motion)?;
            Some((at_us, part))
        });
        found.min_by_key(|(at_us, _)| *at_us)
    }

    fn crossing_of(&self, part: FencePart, motion: &Trajectory) -> Option<u64> {
        let start = self.depth(part, tip(motion, 0));
        let end = self.depth(part, tip(motion, motion.duration_us()));
        // A path that is NaN anywhere cannot be checked, so it counts as a crossing at once.
        if !start.is_finite() || !end.is_finite() {
            return Some(0);
        }
        let limit = limit(start);
        let on_the_way = motion
            .timed_segments()
            .find_map(|(segment, begin_us, end_us)| {
                let acceleration = deviating_acceleration(segment, motion.geometry());
                let mut from_us = begin_us;
                let corners = segment
                    .corners_us()
                    .map(|at_us| (begin_us + at_us).min(end_us));
                corners.chain([end_us]).find_map(|to_us| {
                    let stretch = Stretch {
                        from_us,
                        to_us,
                        from: tip(motion, from_us),
                        to: tip(motion, to_us),
                    };
                    from_us = to_us;
                    (stretch.from_us < to_us)
                        .then(|| self.search(part, limit, acceleration, stretch, motion))?
                })
            });
        on_the_way.or_else(|| (end > end_limit(start)).then(|| motion.duration_us()))
    }

    /// Returns the first time in a stretch at which the tip may be deeper than `limit`.
    fn search(
        &self,
        part: FencePart,
        limit: f64,
        acceleration: f64,
        stretch: Stretch,
        motion: &Trajectory,
    ) -> Option<u64> {
        let Stretch {
            from_us,
            to_us,
            from,
            to,
        } = stretch;
        let duration_us = to_us.saturating_sub(from_us);
        let seconds = duration_us as f64 / 1e6;
        let deviation = if acceleration > 0.0 {
            acceleration * seconds * seconds / 8.0
        } else {
            0.0
        };
        if !self.reaches(part, from, to, limit - deviation) {
            return None;
        }
        let is_decided = deviation <= CHORD_TOLERANCE && duration_us <= CROSSING_RESOLUTION_US;
        if is_decided || duration_us <= MIN_STRETCH_US {
            return Some(from_us);
        }
        let middle_us = from_us + duration_us / 2;
        let middle = tip(motion, middle_us);
        let first = Stretch {
            to_us: middle_us,
            to: middle,
            ..stretch
        };
        let second = Stretch {
            from_us: middle_us,
            from: middle,
            ..stretch
        };
        self.search(part, limit, acceleration, first, motion)
            .or_else(|| self.search(part, limit, acceleration, second, motion))
    }

    /// True if a point of a straight line may lie deeper than `depth` beyond a part.
    fn reaches(&self, part: FencePart, from: [f64; 3], to: [f64; 3], depth: f64) -> bool {
        let FencePart::KeepOut(nth) = part else {
            // Beyond a plane the depth is greatest at an end. NaN counts as not clear.
            let clear = self.depth(part, from) <= depth && self.depth(part, to) <= depth;
            return !clear;
        };
        let Some(keep_out) = self.keep_outs().get(nth) else {
            return false;
        };
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        let sides = keep_out.min.into_iter().zip(keep_out.max);
        for ((min, max), (a, b)) in sides.zip(from.into_iter().zip(to)) {
            let (min, max) = (min + depth, max - depth);
            let way = b - a;
            if way == 0.0 {
                if a <= min || a >= max {
                    return false;
                }
                continue;
            }
            let (first, second) = ((min - a) / way, (max - a) / way);
            enter = enter.max(first.min(second));
            leave = leave.min(first.max(second));
            if min >= max {
                return false;
            }
        }
        enter < leave
    }

    /// Returns the breach at the deepest point of a crossing motion, for the message.
    fn deepest(&self, motion: &Trajectory, at_us: u64, part: FencePart) -> Breach {
        // The message needs one decimal, so 64 samples of the rest of the motion suffice.
        let (duration, samples) = (motion.duration_us(), 64);
        let left = duration.saturating_sub(at_us);
        let points = (0..=samples).map(|nth| tip(motion, at_us + left / samples * nth));
        let points = points.chain([tip(motion, duration)]);
        let deepest = points.max_by(|a, b| {
            let [a, b] = [*a, *b].map(|at| self.depth(part, at));
            a.total_cmp(&b)
        });
        self.breach_at(part, deepest.unwrap_or_default())
    }

    /// Checks the speed of the tip along a motion.
    ///
    /// # Errors
    /// A breach of [`FencePart::TopSpeed`] with the highest speed on the path.
    pub fn check_speed_of(&self, motion: &Trajectory) -> Result<(), Breach> {
        let Some(top) = self.top_speed else {
            return Ok(());
        };
        let fastest = motion.timed_segments().map(|(segment, from_us, to_us)| {
            let at_most = highest_speed(segment, motion.geometry());
            // The bound for joint motions adds up all joints at their fastest and is often far too
            // high, so sample before refusing. For all other paths it is exact.
            match segment {
                MoveSegment::Joints(_) if at_most > top => sampled_speed(motion, from_us, to_us),
                _ => at_most,
            }
        });
        self.check_speed(fastest.fold(0.0, f64::max))
    }
}

fn tip(motion: &Trajectory, at_us: u64) -> [f64; 3] {
    let pose = motion.curve(at_us).pose;
    [pose.x, pose.y, pose.z]
}

/// Upper bounds of the lever arms of the tip about J1, J2 and J3, mm.
fn lever_arms(geometry: &Geometry) -> [f64; 3] {
    let Geometry {
        rear_arm,
        forearm,
        tool,
    } = geometry;
    let out = rear_arm + forearm + libm::fabs(tool.x);
    let base = libm::sqrt(out * out + tool.y * tool.y);
    [base, *rear_arm, *forearm]
}

/// Highest speeds (rad/s) and accelerations (rad/s2) of J1 to J3.
fn joint_rates(segment: &JointSegment) -> [(f64, f64); 3] {
    let [first, second, third, _] = &segment.axes;
    [first, second, third].map(|axis| {
        let (velocity, acceleration) = axis.profile().curve_extremes();
        (
            libm::fabs(velocity) / DEGREES_PER_RADIAN,
            libm::fabs(acceleration) / DEGREES_PER_RADIAN,
        )
    })
}

/// Upper bound of the acceleration by which the tip deviates from uniform motion on the straight
/// line, mm/s2; 0 for a straight path, which cannot leave its line.
fn deviating_acceleration(segment: &MoveSegment, geometry: &Geometry) -> f64 {
    match segment {
        MoveSegment::Line(_) | MoveSegment::Path(_) => 0.0,
        MoveSegment::Arc(ArcSegment { arc, along, .. }) => {
            let (velocity, acceleration) = along.curve_extremes();
            libm::fabs(acceleration) + velocity * velocity * arc.curvature()
        }
        MoveSegment::Joints(segment) => {
            let [base, rear, fore] = lever_arms(geometry);
            let [(w1, a1), (w2, a2), (w3, a3)] = joint_rates(segment);
            let turning = base * (w1 * w1 + a1);
            let across = 2.0 * w1 * (rear * w2 + fore * w3);
            turning + across + rear * (w2 * w2 + a2) + fore * (w3 * w3 + a3)
        }
    }
}

/// Upper bound of the speed of a segment, mm/s; exact except for joint motions.
fn highest_speed(segment: &MoveSegment, geometry: &Geometry) -> f64 {
    match segment {
        MoveSegment::Line(segment) => segment.along.highest_speed(),
        MoveSegment::Path(segment) => segment.along.highest_speed(),
        MoveSegment::Arc(segment) => segment.along.highest_speed(),
        MoveSegment::Joints(segment) => {
            let [base, rear, fore] = lever_arms(geometry);
            let [(w1, _), (w2, _), (w3, _)] = joint_rates(segment);
            let (across, along) = (base * w1, rear * w2 + fore * w3);
            libm::sqrt(across * across + along * along)
        }
    }
}

fn sampled_speed(motion: &Trajectory, from_us: u64, to_us: u64) -> f64 {
    let duration_us = to_us.saturating_sub(from_us);
    let count = (duration_us / SAMPLE_SPACING_US).clamp(MIN_SAMPLES, MAX_SAMPLES);
    let speeds = (0..=count).map(|nth| {
        let part = u128::from(duration_us) * u128::from(nth) / u128::from(count);
        let velocity = motion.tool_velocity(from_us + part as u64);
        libm::sqrt(velocity.x * velocity.x + velocity.y * velocity.y + velocity.z * velocity.z)
    });
    SPEED_MARGIN * speeds.fold(0.0, f64::max)
}
