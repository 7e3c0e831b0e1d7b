//! Drawings as ink along lines, in its order.

use std::collections::HashMap;

use magician::sim::world::{Drawing, StrokeKind};

/// Largest deviation of a line from itself when it is followed in other steps, mm: the accuracy of
/// a drawing's corners.
pub(crate) const CORNER_ACCURACY: f64 = 0.02;
/// Largest distance of equal points, mm.
const POINT_TOLERANCE: f64 = 1e-6;
/// Sampling distance along a line, mm.
const SAMPLE_STEP: f64 = 0.1;

/// Width of the cells used to search the nearest piece, mm.
const CELL_WIDTH: f64 = 1.0;
/// Largest distance computed, mm; everything farther counts as this far.
const MAX_DISTANCE: f64 = 8.0;

/// Straight piece of ink.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    kind: StrokeKind,
    power: f64,
    from: [f64; 2],
    to: [f64; 2],
}

impl Piece {
    fn length(&self) -> f64 {
        distance(self.from, self.to)
    }
}

/// All ink in drawing order.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Ink {
    pieces: Vec<Piece>,
    /// Length of ink before each piece, and in all, mm.
    upto: Vec<f64>,
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

impl Ink {
    pub(crate) fn of(drawing: &Drawing) -> Self {
        let mut pieces = Vec::new();
        for stroke in drawing.strokes() {
            let ends = stroke.points.iter().zip(stroke.points.iter().skip(1));
            pieces.extend(ends.map(|(from, to)| Piece {
                kind: stroke.kind,
                power: stroke.power,
                from: *from,
                to: *to,
            }));
        }
        let mut sum = 0.0;
        let mut upto = vec![0.0];
        for piece in &pieces {
            sum += piece.length();
            upto.push(sum);
        }
        Self { pieces, upto }
    }

    /// Length of the ink, mm.
    pub(crate) fn length(&self) -> f64 {
        self.upto.last().copied().unwrap_or(0.0)
    }

    /// Position after this length of ink.
    fn at(&self, length: f64) -> Option<[f64; 2]> {
        let begun = self.upto.partition_point(|upto| *upto <= length);
        let next = begun.clamp(1, self.pieces.len().max(1)) - 1;
        let piece = self.pieces.get(next)?;
        let begun = self.upto.get(next).copied().unwrap_or(length);
        let share = ((length - begun) / piece.length().max(POINT_TOLERANCE)).clamp(0.0, 1.0);
        Some([0, 1].map(|axis| piece.from[axis] + share * (piece.to[axis] - piece.from[axis])))
    }

    /// True if both have the same strokes to the millionth of a millimetre, however often they were
    /// interrupted and continued at the same place.
    pub(crate) fn equals(&self, other: &Self) -> bool {
        let (one, two) = (self.joined(), other.joined());
        let same = |a: [f64; 2], b: [f64; 2]| distance(a, b) <= POINT_TOLERANCE;
        one.len() == two.len()
            && one.iter().zip(&two).all(|(one, two)| {
                one.kind == two.kind
                    && one.power == two.power
                    && same(one.from, two.from)
                    && same(one.to, two.to)
            })
    }

    /// Ink that the other drawing lacks: length farther from it than `within`, and the largest
    /// distance, mm.
    pub(crate) fn beyond(&self, other: &Self, within: f64) -> (f64, f64) {
        let cells = Cells::of(other);
        let (mut length, mut worst) = (0.0, 0.0_f64);
        for piece in self
            .pieces
            .iter()
            .filter(|piece| piece.length() > POINT_TOLERANCE)
        {
            let looks = (piece.length() / SAMPLE_STEP).ceil();
            for nth in 0..looks as u64 {
                let share = (nth as f64 + 0.5) / looks;
                let off = cells.distance(piece.at(share));
                worst = worst.max(off);
                length += if off > within {
                    piece.length() / looks
                } else {
                    0.0
                };
            }
        }
        (length, worst)
    }

    /// Pieces, with those on a straight line merged.
    fn joined(&self) -> Vec<Piece> {
        let mut joined: Vec<Piece> = Vec::new();
        for piece in self
            .pieces
            .iter()
            .filter(|piece| piece.length() > POINT_TOLERANCE)
        {
            match joined.last_mut() {
                Some(last) if last.continues_in(piece) => last.to = piece.to,
                _ => joined.push(*piece),
            }
        }
        joined
    }

    /// Largest distance from the beginning of another drawing, mm; `None` if it is longer than
    /// that.
    pub(crate) fn distance_from_beginning_of(&self, whole: &Self) -> Option<f64> {
        if self.length() > whole.length() + CORNER_ACCURACY {
            return None;
        }
        let looks = (self.length() / SAMPLE_STEP).ceil() as u64;
        let off = (0..=looks).filter_map(|nth| {
            let length = (nth as f64 * SAMPLE_STEP).min(self.length());
            // Rounding adds up along a curve, so the nearest position around there counts.
            let at = self.at(length)?;
            let near = (-4..=4)
                .filter_map(|shift| whole.at(length + f64::from(shift) * CORNER_ACCURACY / 2.0));
            near.map(|there| distance(at, there)).min_by(f64::total_cmp)
        });
        Some(off.fold(0.0, f64::max))
    }
}

/// Pieces by position.
struct Cells<'i> {
    ink: &'i Ink,
    cells: HashMap<[i64; 2], Vec<usize>>,
}

fn cell(at: [f64; 2]) -> [i64; 2] {
    at.map(|at| (at / CELL_WIDTH).floor() as i64)
}

impl<'i> Cells<'i> {
    fn of(ink: &'i Ink) -> Self {
        let mut cells: HashMap<_, Vec<_>> = HashMap::new();
        for (nth, piece) in ink.pieces.iter().enumerate() {
            let (from, to) = (cell(piece.from), cell(piece.to));
            for x in from[0].min(to[0])..=from[0].max(to[0]) {
                for y in from[1].min(to[1])..=from[1].max(to[1]) {
                    cells.entry([x, y]).or_default().push(nth);
                }
            }
        }
        Self { ink, cells }
    }

    /// Distance of a position from the nearest piece, at most [`MAX_DISTANCE`].
    fn distance(&self, at: [f64; 2]) -> f64 {
        let [x, y] = cell(at);
        let mut nearest = MAX_DISTANCE;
        let mut ring = 0_i64;
        // Everything beyond this many rings of cells is farther away.
        while (ring as f64 - 1.0) * CELL_WIDTH < nearest {
            for dx in -ring..=ring {
                for dy in -ring..=ring {
                    if dx.abs().max(dy.abs()) < ring {
                        continue;
                    }
                    let here = self.cells.get(&[x + dx, y + dy]).into_iter().flatten();
                    let here = here.filter_map(|nth| self.ink.pieces.get(*nth));
                    nearest = here.map(|piece| piece.distance(at)).fold(nearest, f64::min);
                }
            }
            ring += 1;
        }
        nearest
    }
}

impl Piece {
    fn at(&self, share: f64) -> [f64; 2] {
        [0, 1].map(|axis| self.from[axis] + share * (self.to[axis] - self.from[axis]))
    }

    fn distance(&self, at: [f64; 2]) -> f64 {
        let way = [self.to[0] - self.from[0], self.to[1] - self.from[1]];
        let along = (at[0] - self.from[0]) * way[0] + (at[1] - self.from[1]) * way[1];
        let share = along / self.length().powi(2).max(POINT_TOLERANCE * POINT_TOLERANCE);
        distance(at, self.at(share.clamp(0.0, 1.0)))
    }

    fn continues_in(&self, next: &Self) -> bool {
        let way = self.length() + next.length();
        self.kind == next.kind
            && self.power == next.power
            && distance(self.to, next.from) <= POINT_TOLERANCE
            && way - distance(self.from, next.to) <= POINT_TOLERANCE * way.max(1.0)
    }
}
