//! Segments that may be lost between others without changing the drawing.

use super::item::Entry;
use super::{MAX_KEPT, Stream};

/// Largest distance of a lost vertex from the line that replaces it, mm: a quarter of the arm's
/// repeatability.
pub const LINE_TOLERANCE: f64 = 0.05;

impl Stream {
    /// True if the same line is drawn whichever unconfirmed segments are lost: each line to the new
    /// vertex, from a position where the arm may then stand, passes all vertices left out.
    pub(super) fn keeps_line(&self, entry: &Entry) -> bool {
        // Anything but a dark absolute segment would do something else from another start.
        let Some(to) = entry.vertex() else {
            return false;
        };
        let confirmed = self.confirmed;
        let is_certain = |entry: &Entry| entry.index().is_some_and(|at| Some(at) <= confirmed);
        let gone = self.entries.iter().take_while(|entry| !entry.is_waiting());
        // On the stack: this runs for each command sent.
        let (mut places, mut count) = ([[0.0; 3]; MAX_KEPT + 1], 0);
        let mut start = self.last_position;
        for entry in gone {
            if is_certain(entry) {
                start = entry.place();
                continue;
            }
            let (Some(place), Some(free)) = (entry.vertex(), places.get_mut(count + 1)) else {
                return false;
            };
            *free = place;
            count += 1;
        }
        let (Some(start), Some(places)) = (start, places.get_mut(..=count)) else {
            return false;
        };
        if let Some(first) = places.first_mut() {
            *first = start;
        }
        // The arm may stand at any of these positions when it takes the new segment.
        (0..places.len()).all(|nth| {
            let (_, rest) = places.split_at(nth);
            let Some((from, passed)) = rest.split_first() else {
                return true;
            };
            passed
                .iter()
                .all(|place| distance_to_segment(*place, *from, to) <= LINE_TOLERANCE)
        })
    }
}

/// Distance of a point from the segment between two others, mm.
pub(super) fn distance_to_segment(place: [f64; 3], from: [f64; 3], to: [f64; 3]) -> f64 {
    let way = [0, 1, 2].map(|axis| to[axis] - from[axis]);
    let gone = [0, 1, 2].map(|axis| place[axis] - from[axis]);
    let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(&b).map(|(a, b)| a * b).sum::<f64>();
    // The lower bound avoids 0/0 for a segment without length.
    let share = (dot(gone, way) / dot(way, way).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    distance(gone, way.map(|way| share * way))
}

/// Distance of two points, mm.
pub(super) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let squares = a.iter().zip(&b).map(|(a, b)| (a - b) * (a - b));
    squares.sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_as_far_from_a_line_as_from_its_nearest_point() {
        let (from, to) = ([0.0, 0.0, 5.0], [10.0, 0.0, 5.0]);
        for (place, expected) in [
            ([4.0, 3.0, 5.0], 3.0),
            ([-3.0, 0.0, 9.0], 5.0),
            ([13.0, 4.0, 5.0], 5.0),
            ([10.0, 0.0, 5.0], 0.0),
        ] {
            assert!(
                (distance_to_segment(place, from, to) - expected).abs() < 1e-12,
                "{place:?}"
            );
        }
        assert_eq!(distance_to_segment([3.0, 4.0, 5.0], from, from), 5.0);
    }
}
