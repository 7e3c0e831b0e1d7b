//! Straight ways, looked at in pieces: for less work than following them exactly.

use super::Reach;
use crate::artwork::distance;

/// Ways are looked at in pieces of this length, mm.
const PIECE: f64 = 4.0;
/// In no more pieces than this.
const MOST_PIECES: f64 = 1000.0;

impl Reach {
    /// Whether the tool gets from one point to another on a straight way so far above the surface. Both ends are known to be
    /// reached.
    pub(crate) fn leads(&self, from: [f64; 2], to: [f64; 2], lift: f64) -> bool {
        let is_reached = |point| self.joints(point, lift).is_some();
        // In front of the base only the hole around it can be in the way; beside and behind it is the stop of J1, too.
        match from[0] > 0.0 && to[0] > 0.0 {
            true => is_reached(nearest_to_base(from, to)),
            false => pieces(from, to).all(is_reached),
        }
    }

    /// Whether a line of these corners is reached on the surface and above it.
    pub(crate) fn has_line(&self, corners: impl Iterator<Item = [f64; 2]>) -> bool {
        let mut last = None;
        for corner in corners {
            let reached = match last.replace(corner) {
                Some(last) => pieces(last, corner).all(|point| self.has(point)),
                None => self.has(corner),
            };
            if !reached {
                return false;
            }
        }
        true
    }
}

/// Points on a straight way, the last of them its end.
fn pieces(from: [f64; 2], to: [f64; 2]) -> impl Iterator<Item = [f64; 2]> {
    let count = (distance(from, to) / PIECE).ceil().clamp(1.0, MOST_PIECES);
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
