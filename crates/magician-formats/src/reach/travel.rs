//! Approximate checks of straight moves by sampling, much cheaper than planning them exactly.

use magician_motion::Pose;

use super::Reach;
use crate::artwork::distance;

/// Height above travel at which a tool first approaches its work, and passes where a straight move
/// is impossible, mm.
///
/// A joint move lowers the tool on its way if the arm is stretched out and low. A move that ends
/// this much higher stays above a level surface if the tool starts at least 3 mm above it.
pub const APPROACH_HEIGHT: f64 = 50.0;
/// Step between positions to try towards the base and away from it if the tool cannot be that high,
/// as a share of the distance from the base.
const SIDEWAYS_STEP: f64 = 0.05;
/// Number of such steps in each direction.
const MAX_SIDEWAYS_STEPS: i32 = 8;

/// Distance of samples along a straight move, mm. A choice: the exact check before a run finds what
/// falls between samples.
const SAMPLE_DISTANCE: f64 = 4.0;
/// Largest number of samples per move. It bounds time for coordinates far out of reach.
const MAX_PIECES: f64 = 1000.0;

/// Number of samples along a joint move. A choice between accuracy and time.
const JOINT_MOVE_SAMPLES: u32 = 64;
/// Largest angle of a straight piece around the base, deg. Over 30 deg a chord comes closer to the
/// base than its ends by only 3 %.
const MAX_TURN_PER_PIECE: f64 = 30.0;

/// A point of the surface, and a height above it, mm.
pub type Above = ([f64; 2], f64);

impl Reach {
    /// Returns a position at a height above a point, from which a straight move leads to it.
    ///
    /// The position may be shifted towards the base or away from it. If no such position can be
    /// reached, returns the highest reachable position above the point.
    #[must_use]
    pub fn over(&self, end: Above, height: f64) -> Above {
        let ([x, y], above) = end;
        let asides = (0..=MAX_SIDEWAYS_STEPS).flat_map(|nth| [-nth, nth]);
        let places = asides.map(|nth| 1.0 + f64::from(nth) * SIDEWAYS_STEP);
        let mut places = places.map(|share| ([x * share, y * share], height));
        if let Some(place) = places.find(|place| self.is_straight_move_possible(*place, end)) {
            return place;
        }
        let tenths = (1..=10).rev().map(|tenth| f64::from(tenth) / 10.0);
        let heights = tenths.map(|share| above + share * (height - above));
        let mut places = heights.map(|height| ([x, y], height));
        places
            .find(|place| self.is_straight_move_possible(*place, end))
            .unwrap_or(end)
    }

    /// True if a straight move between two positions is within reach.
    #[must_use]
    pub fn is_straight_move_possible(&self, from: Above, to: Above) -> bool {
        let count = (libm::hypot(distance(from.0, to.0), to.1 - from.1) / SAMPLE_DISTANCE).ceil();
        let count = count.clamp(1.0, MAX_PIECES);
        (0..=count as u32).all(|nth| {
            let share = f64::from(nth) / count;
            let lift = from.1 + share * (to.1 - from.1);
            self.joints(between(from.0, to.0, share), lift).is_some()
        })
    }

    /// True if a joint move stays at least this far above the surface.
    pub(crate) fn clears(&self, from: Above, to: Above, least: f64) -> bool {
        let (Some(from), Some(to)) = (self.joints(from.0, from.1), self.joints(to.0, to.1)) else {
            return false;
        };
        let (from, to) = (from.to_array(), to.to_array());
        (0..=JOINT_MOVE_SAMPLES).all(|nth| {
            let share = f64::from(nth) / f64::from(JOINT_MOVE_SAMPLES);
            let joints = [0, 1, 2, 3].map(|joint| from[joint] + share * (to[joint] - from[joint]));
            let Pose { x, y, z, .. } = self.geometry.forward(&joints.into());
            z - self.surface.at([x, y]) >= least
        })
    }

    /// Returns the corners of a way around the base, `lift` mm above the surface, with straight
    /// moves between them. `None` if no such way is within reach.
    #[must_use]
    pub fn corners_around_base(
        &self,
        from: [f64; 2],
        to: [f64; 2],
        lift: f64,
    ) -> Option<Vec<[f64; 2]>> {
        let [near, far] = self.ahead()?;
        let radius = f64::midpoint(near, far);
        let [begin, end] = [from, to].map(|[x, y]| libm::atan2(y, x));
        let count = ((end - begin).abs().to_degrees() / MAX_TURN_PER_PIECE)
            .ceil()
            .max(1.0);
        let corners: Vec<_> = (0..=count as u32)
            .map(|nth| {
                let (sin, cos) = libm::sincos(begin + (end - begin) * f64::from(nth) / count);
                [radius * cos, radius * sin]
            })
            .collect();
        let ends = [from].into_iter().chain(corners.iter().copied());
        let mut ways = ends.zip(corners.iter().copied().chain([to]));
        let reached = |corner: &[f64; 2]| self.joints(*corner, lift).is_some();
        (corners.iter().all(reached)
            && ways.all(|(from, to)| self.is_lifted_line_possible(from, to, lift)))
        .then_some(corners)
    }

    /// True if a straight move between two points, `lift` mm above the surface, is within reach.
    /// Both ends must be within reach.
    #[must_use]
    pub fn is_lifted_line_possible(&self, from: [f64; 2], to: [f64; 2], lift: f64) -> bool {
        let is_reached = |point| self.joints(point, lift).is_some();
        is_reached(nearest_to_base(from, to)) && pieces(from, to).all(is_reached)
    }

    /// True if a polyline is within reach on the surface and at the lift above it.
    pub(crate) fn has_line(&self, corners: impl Iterator<Item = [f64; 2]>) -> bool {
        let mut last = None;
        for corner in corners {
            let reached = match last.replace(corner) {
                Some(last) => {
                    let nearest = nearest_to_base(last, corner);
                    pieces(last, corner)
                        .chain([nearest])
                        .all(|point| self.has(point))
                }
                None => self.has(corner),
            };
            if !reached {
                return false;
            }
        }
        true
    }
}

/// Iterates over samples along a segment, the last of which is its end.
fn pieces(from: [f64; 2], to: [f64; 2]) -> impl Iterator<Item = [f64; 2]> {
    let count = (distance(from, to) / SAMPLE_DISTANCE)
        .ceil()
        .clamp(1.0, MAX_PIECES);
    (1..=count as u32).map(move |nth| between(from, to, f64::from(nth) / count))
}

fn nearest_to_base(from: [f64; 2], to: [f64; 2]) -> [f64; 2] {
    let way = [to[0] - from[0], to[1] - from[1]];
    let square = way[0] * way[0] + way[1] * way[1];
    if square == 0.0 {
        return from;
    }
    let share = -(from[0] * way[0] + from[1] * way[1]) / square;
    between(from, to, share.clamp(0.0, 1.0))
}

fn between(from: [f64; 2], to: [f64; 2], share: f64) -> [f64; 2] {
    match share {
        1.0 => to,
        _ => [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis])),
    }
}
