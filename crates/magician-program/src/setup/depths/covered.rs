//! Record of lines already cut, so that deeper passes are drawn once.
//!
//! Lines are indexed by direction and offset, rounded to the tolerances below, and on each line by
//! intervals. A deeper pass counts as covered if earlier intervals together contain it.

use std::collections::{BTreeMap, BTreeSet};

use super::HEIGHT_TOLERANCE;
use crate::artwork::distance;

/// Largest difference in direction of lines that count as collinear, rad.
const DIRECTION_TOLERANCE: f64 = 1e-3;
/// Largest distance of lines that count as collinear, mm.
const OFFSET_TOLERANCE: f64 = 0.02;
/// Largest gap that is ignored, micrometres: tabs are longer, rounded ends are not.
const MAX_GAP: i64 = 20;

/// Lines, arcs and dots by position, with the Z of the first cut there.
pub(super) struct CutRecord {
    /// Scale of the drawing. The tolerances apply at this scale.
    scale: f64,
    /// Pieces by direction and offset of their line, then by their start on it, micrometres. The
    /// value is the end of the piece and its Z.
    lines: BTreeMap<[i64; 2], BTreeMap<i64, (i64, f64)>>,
    arcs: BTreeMap<[i64; 6], f64>,
    dots: BTreeSet<[i64; 2]>,
}

fn micrometres(mm: f64) -> i64 {
    (mm * 1000.0).round() as i64
}

/// Two positions in an order independent of the drawing direction.
fn sorted(mut ends: [[i64; 2]; 2]) -> [[i64; 2]; 2] {
    ends.sort_unstable();
    ends
}

impl CutRecord {
    pub(super) fn new(scale: f64) -> Self {
        Self {
            scale,
            lines: BTreeMap::new(),
            arcs: BTreeMap::new(),
            dots: BTreeSet::new(),
        }
    }

    fn scaled(&self, at: [f64; 2]) -> [f64; 2] {
        at.map(|value| value * self.scale)
    }

    /// Records a line. True if it was cut before, and is deeper now.
    pub(super) fn line(&mut self, from: [f64; 2], to: [f64; 2], z: f64) -> bool {
        let [from, to] = [from, to].map(|end| self.scaled(end));
        let way = distance(from, to);
        if way <= HEIGHT_TOLERANCE {
            return false;
        }
        let angle = libm::atan2(to[1] - from[1], to[0] - from[0]).rem_euclid(std::f64::consts::PI);
        let turns = (std::f64::consts::PI / DIRECTION_TOLERANCE).round() as i64;
        let nth = (angle / DIRECTION_TOLERANCE).round() as i64 % turns;
        // Directions just below half a turn wrap to 0.
        let angle = if nth == 0 { 0.0 } else { angle };
        let (sin, cos) = libm::sincos(angle);
        let along = |[x, y]: [f64; 2]| micrometres(cos * x + sin * y);
        let [mx, my] = [0, 1].map(|axis| f64::midpoint(from[axis], to[axis]));
        let offset = ((cos * my - sin * mx) / OFFSET_TOLERANCE).round() as i64;
        let (one, other) = (along(from), along(to));
        let (begin, end) = (one.min(other), one.max(other));
        let pieces = self.lines.entry([nth, offset]).or_default();
        let (mut at, mut deeper) = (begin, true);
        while at + MAX_GAP < end {
            let before = pieces.range(..=at + MAX_GAP).next_back();
            match before.filter(|(_, (to, _))| *to > at) {
                Some((_, (to, first))) => {
                    deeper &= *first > z + HEIGHT_TOLERANCE;
                    at = *to;
                }
                None => break,
            }
        }
        if at + MAX_GAP >= end {
            return deeper;
        }
        pieces.entry(begin).or_insert((end, z));
        false
    }

    /// Records an arc. True if it was cut before, and is deeper now.
    pub(super) fn arc(&mut self, [from, via, to]: [[f64; 2]; 3], z: f64) -> bool {
        let [a, b] = sorted([from, to].map(|end| self.scaled(end).map(micrometres)));
        let via = self.scaled(via).map(micrometres);
        let first = self.arcs.entry([a[0], a[1], via[0], via[1], b[0], b[1]]);
        *first.or_insert(z) > z + HEIGHT_TOLERANCE
    }

    /// Records a dot. True if it was there before.
    pub(super) fn dot(&mut self, at: [f64; 2]) -> bool {
        let at = self.scaled(at);
        !self.dots.insert(at.map(micrometres))
    }
}
