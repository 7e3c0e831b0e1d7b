//! Whether the way of a tip crosses a fence, and how fast it goes there.
//!
//! Between two moments the tip is nowhere further from the straight line between its two places than an eighth of its
//! highest acceleration times the square of the time between them. A stretch whose line is that far from a bound is clear;
//! any other one is halved, until its line tells nearly all. Straight ways are their own lines.

use super::{Breach, Fence, FencePart, TOLERANCE};
use crate::angle::DEGREES_PER_RADIAN;
use crate::arc_segment::ArcSegment;
use crate::joint_segment::JointSegment;
use crate::move_segment::MoveSegment;
use crate::{Geometry, Trajectory};

/// A line that is so near to its curve tells all, mm.
const EXACT: f64 = 0.005;
/// A crossing is found to this, us.
const INSTANT: u64 = 500;
/// No stretch is halved below this, us: a curve that is not told by then counts as crossing.
const SHORTEST: u64 = 8;
/// What the rounding of one motion may add to a tip that is beyond a bound already, mm.
const ROUNDING: f64 = 1e-6;
/// Speeds along a way of joints are looked at in so many places at least and at most.
const LEAST_SAMPLES: u64 = 64;
const MOST_SAMPLES: u64 = 2000;
/// And so far apart, us.
const APART: u64 = 4_000;
/// What lies between two of these is less than that share faster.
const BETWEEN: f64 = 1.002;

/// How deep the tip may be on its way that begins at this depth.
fn limit(start: f64) -> f64 {
    if start > TOLERANCE {
        start + EXACT
    } else {
        TOLERANCE
    }
}

/// How deep it may be at the end: no number of motions leads further out.
pub(super) fn end_limit(start: f64) -> f64 {
    if start > TOLERANCE {
        start + ROUNDING
    } else {
        TOLERANCE
    }
}

/// A stretch of a way: two moments, and the tip at both.
#[derive(Clone, Copy)]
struct Stretch {
    from_us: u64,
    to_us: u64,
    from: [f64; 3],
    to: [f64; 3],
}

impl Fence {
    /// Whether the tip of this motion crosses a bound on its way, or gets further out of one that it is beyond.
    ///
    /// # Errors
    /// What is crossed first, and how far the tip would get beyond it.
    pub fn check_way(&self, motion: &Trajectory) -> Result<(), Breach> {
        match self.first_crossing(motion) {
            None => Ok(()),
            Some((at_us, part)) => Err(self.deepest(motion, at_us, part)),
        }
    }

    /// When the tip of this motion crosses a bound, microseconds from its start and not later than it does, and which.
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
        if !start.is_finite() || !end.is_finite() {
            return Some(0);
        }
        let limit = limit(start);
        let on_the_way = motion
            .timed_segments()
            .find_map(|(segment, begin_us, end_us)| {
                let bend = bend(segment, motion.geometry());
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
                        .then(|| self.search(part, limit, bend, stretch, motion))?
                })
            });
        on_the_way.or_else(|| (end > end_limit(start)).then(|| motion.duration_us()))
    }

    /// The first moment of a stretch at which the tip may be deeper than `limit`.
    fn search(
        &self,
        part: FencePart,
        limit: f64,
        bend: f64,
        stretch: Stretch,
        motion: &Trajectory,
    ) -> Option<u64> {
        let Stretch {
            from_us,
            to_us,
            from,
            to,
        } = stretch;
        let lasting = to_us.saturating_sub(from_us);
        let seconds = lasting as f64 / 1e6;
        let off = if bend > 0.0 {
            bend * seconds * seconds / 8.0
        } else {
            0.0
        };
        if !self.reaches(part, from, to, limit - off) {
            return None;
        }
        let is_told = off <= EXACT && lasting <= INSTANT;
        if is_told || lasting <= SHORTEST {
            return Some(from_us);
        }
        let middle_us = from_us + lasting / 2;
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
        self.search(part, limit, bend, first, motion)
            .or_else(|| self.search(part, limit, bend, second, motion))
    }

    /// Whether a straight line has a place that is deeper beyond a part than this.
    fn reaches(&self, part: FencePart, from: [f64; 3], to: [f64; 3], depth: f64) -> bool {
        let FencePart::KeepOut(nth) = part else {
            // The depth beyond a plane is highest at an end. What is not a number is not clear.
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

    /// How far beyond a part a way gets that crosses it: what people want to hear.
    fn deepest(&self, motion: &Trajectory, at_us: u64, part: FencePart) -> Breach {
        let (duration, most) = (motion.duration_us(), 64);
        let left = duration.saturating_sub(at_us);
        let places = (0..=most).map(|nth| tip(motion, at_us + left / most * nth));
        let places = places.chain([tip(motion, duration)]);
        let deepest = places.max_by(|a, b| {
            let [a, b] = [*a, *b].map(|at| self.depth(part, at));
            a.total_cmp(&b)
        });
        self.told(part, deepest.unwrap_or_default())
    }

    /// Whether the tip of this motion goes faster than it may.
    ///
    /// # Errors
    /// [`FencePart::TopSpeed`] with the highest speed on the way.
    pub fn check_speed_of(&self, motion: &Trajectory) -> Result<(), Breach> {
        let Some(top) = self.top_speed else {
            return Ok(());
        };
        let fastest = motion.timed_segments().map(|(segment, from_us, to_us)| {
            let at_most = highest_speed(segment, motion.geometry());
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

/// The lengths of the arms with which J1, J2 and J3 move the tip, at most.
fn arms(geometry: &Geometry) -> [f64; 3] {
    let Geometry {
        rear_arm,
        forearm,
        tool,
    } = geometry;
    let out = rear_arm + forearm + libm::fabs(tool.x);
    let base = libm::sqrt(out * out + tool.y * tool.y);
    [base, *rear_arm, *forearm]
}

/// The highest speeds (rad/s) and accelerations (rad/s2) of J1 to J3.
fn rates(segment: &JointSegment) -> [(f64, f64); 3] {
    let [first, second, third, _] = &segment.axes;
    [first, second, third].map(|axis| {
        let (velocity, acceleration) = axis.profile().curve_extremes();
        (
            libm::fabs(velocity) / DEGREES_PER_RADIAN,
            libm::fabs(acceleration) / DEGREES_PER_RADIAN,
        )
    })
}

/// The highest acceleration of the tip that bends its way or makes the middle of it come late, mm/s2; 0 for a straight one.
fn bend(segment: &MoveSegment, geometry: &Geometry) -> f64 {
    match segment {
        MoveSegment::Line(_) | MoveSegment::Segment(_) => 0.0,
        MoveSegment::Arc(ArcSegment { arc, along, .. }) => {
            let (velocity, acceleration) = along.curve_extremes();
            libm::fabs(acceleration) + velocity * velocity * arc.curvature()
        }
        MoveSegment::Joints(segment) => {
            let [base, rear, fore] = arms(geometry);
            let [(w1, a1), (w2, a2), (w3, a3)] = rates(segment);
            let turning = base * (w1 * w1 + a1);
            let across = 2.0 * w1 * (rear * w2 + fore * w3);
            turning + across + rear * (w2 * w2 + a2) + fore * (w3 * w3 + a3)
        }
    }
}

/// No part of a segment is faster, mm/s; exact but for joints.
fn highest_speed(segment: &MoveSegment, geometry: &Geometry) -> f64 {
    match segment {
        MoveSegment::Line(segment) => segment.along.highest_speed(),
        MoveSegment::Segment(segment) => segment.along.highest_speed(),
        MoveSegment::Arc(segment) => segment.along.highest_speed(),
        MoveSegment::Joints(segment) => {
            let [base, rear, fore] = arms(geometry);
            let [(w1, _), (w2, _), (w3, _)] = rates(segment);
            let (across, along) = (base * w1, rear * w2 + fore * w3);
            libm::sqrt(across * across + along * along)
        }
    }
}

fn sampled_speed(motion: &Trajectory, from_us: u64, to_us: u64) -> f64 {
    let lasting = to_us.saturating_sub(from_us);
    let count = (lasting / APART).clamp(LEAST_SAMPLES, MOST_SAMPLES);
    let speeds = (0..=count).map(|nth| {
        let part = u128::from(lasting) * u128::from(nth) / u128::from(count);
        let velocity = motion.tool_velocity(from_us + part as u64);
        libm::sqrt(velocity.x * velocity.x + velocity.y * velocity.y + velocity.z * velocity.z)
    });
    BETWEEN * speeds.fold(0.0, f64::max)
}
