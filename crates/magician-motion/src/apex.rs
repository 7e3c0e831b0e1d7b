//! Highest point of the tool while the joints move.
//!
//! Between two heights the joints swing the arm along arcs that bulge upwards, so the path may rise
//! above both of its ends. The joint speeds bound the second derivative of the height: within a
//! time span the height exceeds the higher end by at most an eighth of that bound times the span
//! squared. The search bisects: a span that cannot beat the highest known point is dropped, any
//! other is halved. Only a few spans are left near the summit.

use crate::Geometry;
use crate::angle::{DEGREES_PER_RADIAN, sin_cos};
use crate::axis_motion::AxisMotion;
use crate::joint_segment::JointSegment;

/// Accuracy of the summit, mm. Far below a motor step and far above rounding errors.
const HEIGHT_TOLERANCE: f64 = 1e-6;
/// Most spans examined. A jump needs dozens; only values that no arm has would need more.
const MAX_SPANS: u32 = 5_000;

/// Greatest height of the tool on a segment, mm. `None` if it does not exceed `ceiling`.
pub(crate) fn above(segment: &JointSegment, geometry: &Geometry, ceiling: f64) -> Option<f64> {
    if bound(segment, geometry) <= ceiling {
        return None;
    }
    let search = Search {
        segment,
        geometry,
        curvature: curvature(segment, geometry),
    };
    let mut from = search.at(0.0);
    let mut highest = from.height.max(search.at(segment.duration()).height);
    let mut spans_left = MAX_SPANS;
    for corner in segment.corners() {
        let to = search.at(corner);
        highest = highest.max(to.height);
        search.raise(&mut highest, from, to, &mut spans_left);
        from = to;
    }
    let highest = highest + HEIGHT_TOLERANCE;
    (highest > ceiling + 2.0 * HEIGHT_TOLERANCE).then_some(highest)
}

/// Upper bound of the height from the range of each joint alone, without a search.
fn bound(segment: &JointSegment, geometry: &Geometry) -> f64 {
    let (from, to) = (segment.from.joints, segment.to.joints);
    let within = |angle: f64, a: f64, b: f64| a.min(b) <= angle && angle <= a.max(b);
    let cos = if within(0.0, from.j2, to.j2) {
        1.0
    } else {
        sin_cos(from.j2).1.max(sin_cos(to.j2).1)
    };
    let sin = sin_cos(from.j3).0.min(sin_cos(to.j3).0);
    geometry.rear_arm * cos - geometry.forearm * sin - geometry.tool.z
}

/// Upper bound of the second derivative of the height, mm/s2.
fn curvature(segment: &JointSegment, geometry: &Geometry) -> f64 {
    let [_, rear, fore, _] = &segment.axes;
    let swing = |length: f64, axis: &AxisMotion| {
        let (velocity, acceleration) = axis.profile().curve_extremes();
        let turning = velocity / DEGREES_PER_RADIAN;
        length * (turning * turning + acceleration / DEGREES_PER_RADIAN)
    };
    swing(geometry.rear_arm, rear) + swing(geometry.forearm, fore)
}

#[derive(Clone, Copy)]
struct Point {
    t: f64,
    height: f64,
}

struct Search<'a> {
    segment: &'a JointSegment,
    geometry: &'a Geometry,
    curvature: f64,
}

impl Search<'_> {
    fn at(&self, t: f64) -> Point {
        let joints = self.segment.joints_at(t);
        let (_, cos) = sin_cos(joints.j2);
        let (sin, _) = sin_cos(joints.j3);
        let Geometry {
            rear_arm,
            forearm,
            tool,
        } = *self.geometry;
        Point {
            t,
            height: rear_arm * cos - forearm * sin - tool.z,
        }
    }

    fn raise(&self, highest: &mut f64, from: Point, to: Point, spans_left: &mut u32) {
        let span = to.t - from.t;
        let possible = from.height.max(to.height) + 0.125 * self.curvature * span * span;
        if *spans_left > 0 && possible > *highest + HEIGHT_TOLERANCE {
            *spans_left -= 1;
            let middle = self.at(0.5 * (from.t + to.t));
            *highest = highest.max(middle.height);
            self.raise(highest, from, middle, spans_left);
            self.raise(highest, middle, to, spans_left);
        }
    }
}
