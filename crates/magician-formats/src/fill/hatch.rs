//! Hatching: parallel lines, and the graph of the edge pieces that connect their ends.
//!
//! Drawing each hatch line separately would lift the pen at each end. Instead neighbouring lines
//! are connected along the edge of the shape. This module computes where lines meet the edge;
//! `join` finds the paths.

use super::join::{Graph, Piece};
use super::region::Region;

/// Distance by which lines at the very edge are moved inwards, mm, so that they are not collinear
/// with it.
const EDGE_INSET: f64 = 1e-6;
/// Longest piece of edge that may connect two lines, in spacings. A longer way costs more than
/// lifting the pen.
pub(super) const MAX_CONNECTION: f64 = 25.0;

/// Bare area beside a piece of edge above which the piece itself is drawn, in squares of the
/// spacing. This happens where an edge runs along the lines.
const MAX_BARE_AREA: f64 = 2.0;

/// Returns lines that fill a shape in a direction (degrees), connected along its edge.
pub(super) fn lines(shape: &Region, spacing: f64, angle: f64) -> Vec<Vec<[f64; 2]>> {
    graph(shape, spacing, angle).paths(MAX_CONNECTION * spacing, MAX_BARE_AREA * spacing * spacing)
}

/// Computes the lines that fill a shape, and the edge pieces between their ends.
pub(super) fn graph(shape: &Region, spacing: f64, angle: f64) -> Graph {
    let (sin, cos) = libm::sincos(angle.to_radians());
    let along = |[x, y]: [f64; 2]| x * cos + y * sin;
    let across = |[x, y]: [f64; 2]| y * cos - x * sin;
    let (least, most) = shape.extent(across);
    if most <= least || shape.is_empty() {
        return Graph::default();
    }
    let levels = Levels::new(least, most, spacing);
    let mut graph = Graph::default();
    for ring in shape.rings() {
        let mut ends = Vec::new();
        // The piece before the first end belongs behind the last one.
        let mut pieces = vec![Piece::default()];
        let next = ring.iter().cycle().skip(1);
        for (from, to) in ring.iter().zip(next) {
            let sides = [across(*from), across(*to)];
            let mut last = *from;
            for level in levels.between(sides) {
                let share = (levels.at(level) - sides[0]) / (sides[1] - sides[0]);
                let at = [0, 1].map(|side| from[side] + (to[side] - from[side]) * share);
                if let Some(piece) = pieces.last_mut() {
                    piece.bare +=
                        levels.bare([last, at].map(|point| [along(point), across(point)]));
                }
                last = at;
                ends.push((at, level, along(at)));
                pieces.push(Piece::default());
            }
            if let Some(piece) = pieces.last_mut() {
                piece.bare += levels.bare([last, *to].map(|point| [along(point), across(point)]));
                piece.corners.push(*to);
            }
        }
        let before = pieces.remove(0);
        if let Some(last) = pieces.last_mut() {
            last.corners.extend(before.corners);
            last.bare += before.bare;
            graph.ring(&ends, pieces);
        }
    }
    graph.pair();
    graph
}

/// Positions of the lines across their direction.
struct Levels {
    first: f64,
    step: f64,
    count: usize,
}

impl Levels {
    fn new(least: f64, most: f64, spacing: f64) -> Self {
        let inner = (most - least - 2.0 * EDGE_INSET).max(0.0);
        if inner < spacing * 0.05 {
            return Self {
                first: f64::midpoint(least, most),
                step: 1.0,
                count: 1,
            };
        }
        let gaps = (inner / spacing - 1e-3).ceil().max(1.0);
        Self {
            first: least + EDGE_INSET,
            step: inner / gaps,
            count: gaps as usize + 1,
        }
    }

    fn at(&self, level: usize) -> f64 {
        self.first + self.step * level as f64
    }

    /// Area left bare between an edge and the next line on its inner side, which is its left.
    fn bare(&self, [from, to]: [[f64; 2]; 2]) -> f64 {
        let middle = f64::midpoint(from[1], to[1]);
        let strip = ((middle - self.first) / self.step).floor();
        let above = middle - (self.first + strip * self.step);
        let far = if to[0] < from[0] {
            above
        } else {
            self.step - above
        };
        (to[0] - from[0]).abs() * (far - self.step / 2.0).max(0.0)
    }

    /// Iterates over the lines that an edge crosses, in crossing order. The lower end of the edge
    /// is inclusive, its upper end exclusive.
    fn between(&self, [from, to]: [f64; 2]) -> impl Iterator<Item = usize> + use<> {
        let index = |at: f64| {
            let guess = ((at - self.first) / self.step).ceil().max(0.0) as usize;
            let guess = guess.min(self.count);
            // Correct the guess by one in either direction, because division rounds.
            let down = guess > 0 && self.at(guess - 1) >= at;
            let up = guess < self.count && self.at(guess) < at;
            guess - usize::from(down) + usize::from(up)
        };
        let range = index(from.min(to))..index(from.max(to));
        let rises = from <= to;
        let count = range.len();
        (0..count).map(move |nth| {
            if rises {
                range.start + nth
            } else {
                range.end - 1 - nth
            }
        })
    }
}
