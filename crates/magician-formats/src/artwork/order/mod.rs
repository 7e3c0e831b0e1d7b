//! Order of strokes: as little travel as possible.
//!
//! The order is a travelling-salesman tour over strokes, which may also be reversed or, if closed,
//! begin at another vertex. Strokes whose ends meet are joined first. `greedy` builds a
//! nearest-neighbour tour, and `improve` shortens it by local search with a fixed effort. If inner
//! shapes must come first, `nesting` finds what lies within which closed line, and each level is a
//! separate tour.
//!
//! Effort is counted in steps and not in time: the same strokes give the same order on every
//! machine.

mod greedy;
mod improve;
pub(super) mod join;
mod kd_tree;
mod nesting;

use std::borrow::Cow;

use super::{Artwork, Stroke, distance};
use crate::Origin;

/// Options for the order of strokes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Order {
    /// True if strokes may be reordered and reversed, and closed ones may begin at another vertex.
    pub rearrange: bool,
    /// True if everything within a closed line comes before it, even if that takes longer: a part
    /// that is cut out may move or drop.
    pub inside_first: bool,
    /// Largest gap between strokes that are joined, mm. A negative number joins none.
    pub joining: f64,
    /// Effort of the search, steps. A second has about a hundred million.
    pub effort: u64,
}

impl Default for Order {
    /// Reordered, with gaps up to 0.01 mm joined, and about two seconds of search at most.
    fn default() -> Self {
        Self {
            rearrange: true,
            inside_first: false,
            joining: 0.01,
            effort: 200_000_000,
        }
    }
}

impl Order {
    /// The order of the file, with the pen lifted after each stroke.
    pub const OF_FILE: Self = Self {
        rearrange: false,
        inside_first: false,
        joining: -1.0,
        effort: 0,
    };

    /// Converts to the units of artwork that is drawn `scale` times as large: lengths here are on
    /// paper.
    #[must_use]
    pub fn to_draw(self, scale: f64) -> Self {
        Self {
            joining: self.joining / scale,
            ..self
        }
    }
}

/// Effect of ordering.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Saving {
    /// Travel between strokes before, mm.
    pub before_mm: f64,
    /// Travel between strokes after, mm.
    pub after_mm: f64,
    /// Number of strokes that now continue another one.
    pub joined: usize,
}

impl Artwork {
    /// Travel between the strokes, mm.
    #[must_use]
    pub fn travel(&self) -> f64 {
        travel(&self.strokes)
    }

    /// Orders the strokes of each part for short travel.
    ///
    /// The drawing stays the same bit for bit, except for gaps that are closed by joining. Travel
    /// becomes longer only if inner shapes have to come first. The result is deterministic.
    pub fn put_in_order(&mut self, order: &Order) -> Saving {
        let before_mm = self.travel();
        let mut saving = Saving {
            before_mm,
            after_mm: before_mm,
            ..Saving::default()
        };
        if order.rearrange {
            self.change_parts(|strokes| {
                let mut candidate = strokes.clone();
                if !candidate
                    .iter()
                    .all(|stroke| stroke.is_finite() && !stroke.points.is_empty())
                {
                    return;
                }
                let joined = join::join(&mut candidate, order.joining);
                let around = if order.inside_first {
                    nesting::enclosing_strokes(&candidate)
                } else {
                    vec![None; candidate.len()]
                };
                let is_wrong = order.inside_first && !is_inside_first(strokes);
                let candidate = rearranged(candidate, &around, order.effort);
                // Keep the order of the file unless the new one is really shorter.
                if is_wrong || travel(&candidate) < travel(strokes) {
                    *strokes = candidate;
                    saving.joined += joined;
                }
            });
        }
        saving.after_mm = self.travel();
        saving
    }
}

fn travel(strokes: &[Stroke]) -> f64 {
    let pairs = strokes.iter().zip(strokes.iter().skip(1));
    let ways = pairs
        .filter_map(|(one, other)| Some(distance(*one.points.last()?, *other.points.first()?)));
    ways.sum()
}

/// A stroke in a tour: where it is entered and left.
#[derive(Clone, Copy, Debug)]
struct TourStop {
    stroke: usize,
    start: [f64; 2],
    end: [f64; 2],
    /// True if drawn from its last vertex to its first.
    reversed: bool,
    /// Vertex at which a closed stroke begins.
    corner: usize,
}

impl TourStop {
    fn reversed(self) -> Self {
        Self {
            start: self.end,
            end: self.start,
            reversed: !self.reversed,
            ..self
        }
    }
}

/// True if everything within a closed line comes before it.
fn is_inside_first(strokes: &[Stroke]) -> bool {
    let around = nesting::enclosing_strokes(strokes);
    let mut pairs = around.iter().enumerate();
    pairs.all(|(inner, outer)| outer.is_none_or(|outer| inner < outer))
}

/// Orders the strokes for short travel, each after the strokes within it.
fn rearranged(strokes: Vec<Stroke>, around: &[Option<usize>], effort: u64) -> Vec<Stroke> {
    let mut within = vec![Vec::new(); strokes.len()];
    let mut outermost = Vec::new();
    for (inner, outer) in around.iter().enumerate() {
        match outer {
            Some(outer) => within[*outer].push(inner),
            None => outermost.push(inner),
        }
    }
    let mut left = effort;
    let mut stops = Vec::with_capacity(strokes.len());
    // Stack of strokes still to emit: a closed stroke waits below those within it.
    let mut ahead = tour(&strokes, &outermost, &within, &mut left);
    while let Some(stop) = ahead.pop() {
        match std::mem::take(&mut within[stop.stroke]) {
            inner if inner.is_empty() => stops.push(stop),
            inner => {
                ahead.push(stop);
                ahead.extend(tour(&strokes, &inner, &within, &mut left));
            }
        }
    }
    if stops.len() > outermost.len() {
        improve::rotate_closed(&mut stops, &strokes);
    }
    let mut strokes: Vec<Option<Stroke>> = strokes.into_iter().map(Some).collect();
    let drawn = stops.iter().filter_map(|stop| {
        let mut stroke = strokes.get_mut(stop.stroke)?.take()?;
        begin_at(&mut stroke, stop.corner);
        if stop.reversed {
            stroke.points.reverse();
        }
        Some(stroke)
    });
    drawn.collect()
}

/// Returns a short tour along some strokes, last stop first. A stroke that contains others counts
/// as a point, because its own order is decided elsewhere.
fn tour(
    strokes: &[Stroke],
    some: &[usize],
    within: &[Vec<usize>],
    effort: &mut u64,
) -> Vec<TourStop> {
    let place = |at: usize| strokes[at].points.first().copied().into_iter().collect();
    let lines = if some.len() == strokes.len() {
        Cow::Borrowed(strokes)
    } else {
        let own = some.iter().map(|at| {
            if within[*at].is_empty() {
                strokes[*at].clone()
            } else {
                Stroke::new(place(*at), Origin::NONE)
            }
        });
        own.collect()
    };
    let mut stops = greedy::tour(&lines);
    // The best start of a closed stroke depends on its neighbours and vice versa, so alternate
    // once.
    *effort = improve::improve(&mut stops, *effort);
    improve::rotate_closed(&mut stops, &lines);
    if lines.iter().any(Stroke::is_closed) {
        *effort = improve::improve(&mut stops, *effort);
        improve::rotate_closed(&mut stops, &lines);
    }
    let stops = stops.into_iter().rev();
    {
        stops.map(|stop| TourStop {
            stroke: some[stop.stroke],
            ..stop
        })
    }
    .collect()
}

/// Rotates a closed stroke to begin at another vertex.
fn begin_at(stroke: &mut Stroke, corner: usize) {
    if corner == 0 || !stroke.is_closed() {
        return;
    }
    stroke.points.pop();
    stroke.points.rotate_left(corner);
    stroke.points.extend(stroke.points.first().copied());
}
