//! Intersection of a sensor's line of sight with boxes.

use super::{ObjectPose, rotate};
use crate::scenario::Beam;

/// Longest belt travel considered, mm. It bounds the polygon and is beyond any belt.
const MAX_BELT_TRAVEL: f64 = 1e5;

/// A box at a position.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solid {
    pub(super) place: ObjectPose,
    /// Length, width, height, mm.
    pub(super) size: [f64; 3],
}

impl Solid {
    /// Converts a point to the frame of the box's centre.
    fn local(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [x, y] = self.place.local([x, y]);
        [x, y, z - self.place.z - self.size[2] / 2.0]
    }

    /// Position along the beam at which it enters the box: 0 at the sensor, 1 at the end of its
    /// range. `None` if the beam misses the box.
    pub(super) fn meets(&self, beam: &Beam) -> Option<f64> {
        let (from, to) = (self.local(beam.from), self.local(beam.to));
        let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
        for axis in 0..3 {
            let (start, way) = (from[axis], to[axis] - from[axis]);
            let half = self.size[axis] / 2.0;
            // Parallel to this pair of sides: no division.
            if way == 0.0 {
                if start.abs() > half {
                    return None;
                }
                continue;
            }
            let (one, other) = ((-half - start) / way, (half - start) / way);
            enters = enters.max(one.min(other));
            leaves = leaves.min(one.max(other));
        }
        (enters <= leaves).then_some(enters)
    }

    /// Range of shifts of the box along a direction for which the beam hits it, mm; `None` if the
    /// beam misses the box at every shift.
    ///
    /// Let `u` be the position on the beam and `s` the shift. The beam's point is in the box if `u`
    /// and `s` satisfy six linear inequalities, which define a convex polygon. The result is the
    /// extent of the polygon in `s`.
    pub(super) fn meets_shifted(&self, beam: &Beam, direction: f64) -> Option<[f64; 2]> {
        let (from, to) = (self.local(beam.from), self.local(beam.to));
        let [shift_x, shift_y] = rotate([1.0, 0.0], direction - self.place.yaw);
        let shift = [shift_x, shift_y, 0.0];
        let mut polygon = vec![
            [0.0, -MAX_BELT_TRAVEL],
            [1.0, -MAX_BELT_TRAVEL],
            [1.0, MAX_BELT_TRAVEL],
            [0.0, MAX_BELT_TRAVEL],
        ];
        for axis in 0..3 {
            let (start, way, half) = (from[axis], to[axis] - from[axis], self.size[axis] / 2.0);
            for side in [1.0, -1.0] {
                let room = |[u, s]: [f64; 2]| half - side * (start + way * u - shift[axis] * s);
                polygon = clip(&polygon, room);
            }
        }
        let shifts = polygon.iter().map(|[_, s]| *s);
        let (least, most) = (
            shifts.clone().fold(f64::INFINITY, f64::min),
            shifts.fold(f64::NEG_INFINITY, f64::max),
        );
        (least <= most).then_some([least, most])
    }
}

/// Clips a convex polygon to the half plane where the linear function `room` is not negative.
fn clip(polygon: &[[f64; 2]], room: impl Fn([f64; 2]) -> f64) -> Vec<[f64; 2]> {
    let mut left = Vec::with_capacity(polygon.len() + 1);
    let next = polygon.iter().cycle().skip(1);
    for (&here, &there) in polygon.iter().zip(next) {
        let (room_here, room_there) = (room(here), room(there));
        if room_here >= 0.0 {
            left.push(here);
        }
        if (room_here < 0.0) != (room_there < 0.0) {
            let share = room_here / (room_here - room_there);
            left.push([
                here[0] + (there[0] - here[0]) * share,
                here[1] + (there[1] - here[1]) * share,
            ]);
        }
    }
    left
}
