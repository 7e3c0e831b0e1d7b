//! Segments of continuous paths (model section 8).

use magician_motion::{CpSegment, JointAngles, KinematicLimits, LookAhead, Planner, Pose};
use magician_protocol::CpMode;

use crate::convert::from_wire;

/// Target of a segment, as its command gives it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathPoint {
    pub(crate) mode: CpMode,
    pub(crate) numbers: [f32; 3],
}

/// Line of a segment from the end of the previous one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PathLine {
    to: [f64; 3],
    segment: CpSegment,
    /// False if its end is out of reach: the arm comes to rest before it.
    reachable: bool,
}

/// A running segment, with everything needed to replan it when more of the path becomes known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Segment {
    way: PathLine,
    look_ahead: LookAhead,
    /// True if it came through the queue, so that the next queued segment may follow without a
    /// stop.
    queued: bool,
}

impl PathLine {
    /// Resolves the line of a segment that starts at a point.
    pub(crate) fn from(planner: &Planner, start: [f64; 3], point: PathPoint) -> Self {
        let mut to = from_wire(point.numbers);
        // Relative to the end of the previous segment, not to the present position (model section
        // 8).
        if point.mode == CpMode::Relative {
            for (to, start) in to.iter_mut().zip(start) {
                *to += start;
            }
        }
        let [x, y, z] = to;
        // r does not matter: only J1 to J3 decide whether the point is in reach.
        let joints = planner.geometry.inverse(&Pose::new(x, y, z, 0.0));
        Self {
            to,
            segment: CpSegment::between(start, to),
            // J4 does not move on a path, so its limits do not apply: any allowed angle will do.
            reachable: joints.is_ok_and(|joints| {
                let j4 = planner.limits.j4.min;
                planner.limits.check(&JointAngles { j4, ..joints }).is_ok()
            }),
        }
    }

    /// End of the line.
    pub(crate) fn to(&self) -> [f64; 3] {
        self.to
    }

    /// True if the line has no length.
    pub(crate) fn is_empty(&self) -> bool {
        self.segment.is_empty()
    }
}

impl Segment {
    pub(crate) fn new(way: PathLine, look_ahead: LookAhead, queued: bool) -> Self {
        Self {
            way,
            look_ahead,
            queued,
        }
    }

    /// End of the segment.
    pub(super) fn to(&self) -> [f64; 3] {
        self.way.to
    }

    /// Velocity and acceleration along it.
    pub(super) fn rates(&self) -> KinematicLimits {
        self.look_ahead.rates(&self.way.segment)
    }

    pub(crate) fn is_queued(&self) -> bool {
        self.queued
    }

    /// Highest exit speed, given the lines that follow without a stop.
    pub(crate) fn exit_speed<'a>(&self, next: impl Iterator<Item = &'a PathLine>) -> f64 {
        // Lines beyond one out of reach do not matter: the path ends before it.
        let next = next.take_while(|way| way.reachable);
        let next = next.map(|way| &way.segment);
        self.look_ahead.exit_speed(&self.way.segment, next)
    }
}
