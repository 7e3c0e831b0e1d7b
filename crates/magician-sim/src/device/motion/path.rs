//! Continuous paths: one segment after the other without a stop between (model section 8).

use magician_motion::{CpSegment, JointAngles, KinematicLimits, LookAhead, Planner, Pose};
use magician_protocol::CpMode;

use crate::convert::from_wire;

/// Where a segment leads, as its command says.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathPoint {
    pub(crate) mode: CpMode,
    pub(crate) numbers: [f32; 3],
}

/// Where a segment leads, and how it gets there from the end of the one before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PathLine {
    to: [f64; 3],
    segment: CpSegment,
    /// Whether its end can be reached: the arm comes to rest before one that cannot.
    reachable: bool,
}

/// A segment under way: what it needs to be planned anew when more becomes known of what follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Segment {
    way: PathLine,
    look_ahead: LookAhead,
    /// It came through the queue, and the queue's next segments follow it without a stop.
    queued: bool,
}

impl PathLine {
    /// The way of a segment that begins at a point.
    pub(crate) fn from(planner: &Planner, start: [f64; 3], point: PathPoint) -> Self {
        let mut to = from_wire(point.numbers);
        if point.mode == CpMode::Relative {
            for (to, start) in to.iter_mut().zip(start) {
                *to += start;
            }
        }
        let [x, y, z] = to;
        let joints = planner.geometry.inverse(&Pose::new(x, y, z, 0.0));
        Self {
            to,
            segment: CpSegment::between(start, to),
            // J4 stands still, so its limits have no part in it.
            reachable: joints.is_ok_and(|joints| {
                let j4 = planner.limits.j4.min;
                planner.limits.check(&JointAngles { j4, ..joints }).is_ok()
            }),
        }
    }

    /// Where it ends.
    pub(crate) fn to(&self) -> [f64; 3] {
        self.to
    }

    /// Whether it leads nowhere.
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

    /// Where it ends.
    pub(super) fn to(&self) -> [f64; 3] {
        self.way.to
    }

    /// The speeds along it.
    pub(super) fn rates(&self) -> KinematicLimits {
        self.look_ahead.rates(&self.way.segment)
    }

    pub(crate) fn is_queued(&self) -> bool {
        self.queued
    }

    /// The speed at which it may end before what follows it at once.
    pub(crate) fn exit_speed<'a>(&self, next: impl Iterator<Item = &'a PathLine>) -> f64 {
        let next = next.take_while(|way| way.reachable);
        let next = next.map(|way| &way.segment);
        self.look_ahead.exit_speed(&self.way.segment, next)
    }
}
