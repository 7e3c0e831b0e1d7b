//! The order in which lines are drawn: as little way as possible without drawing.

mod greedy;
mod improve;
pub(super) mod join;
mod kd_tree;
mod nesting;

use std::borrow::Cow;

use super::{Artwork, Stroke, distance};
use crate::Origin;

/// How lines are put in order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Order {
    /// Whether lines may be drawn in another order and the other way round, and closed ones from elsewhere.
    pub rearrange: bool,
    /// Whether whatever lies within a closed line comes before it, however long the way: what is cut out may move or drop.
    pub inside_first: bool,
    /// Lines whose ends are no farther apart are drawn as one, mm. None are with a negative number.
    pub joining: f64,
    /// How long is looked for something better, in steps of which a second has about a hundred million.
    pub effort: u64,
}

impl Default for Order {
    /// Rearranged, joined within 0.01 mm.
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
    /// As the file has it, with the pen lifted after each line.
    pub const OF_FILE: Self = Self {
        rearrange: false,
        inside_first: false,
        joining: -1.0,
        effort: 0,
    };

    /// The same order for lines that are drawn `scale` times as large: its lengths count on the paper.
    #[must_use]
    pub fn to_draw(self, scale: f64) -> Self {
        Self {
            joining: self.joining / scale,
            ..self
        }
    }
}

/// What putting lines in order has saved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Saving {
    /// How long the ways between the lines were, mm.
    pub before_mm: f64,
    /// How long they are now, mm.
    pub after_mm: f64,
    /// How many lines go on from another one now.
    pub joined: usize,
}

impl Artwork {
    /// How long the ways between its lines are, mm.
    #[must_use]
    pub fn travel(&self) -> f64 {
        travel(&self.strokes)
    }

    /// Puts the lines of each part in an order with short ways between them. What is drawn stays the same to the last bit, but for what
    /// joins lines whose ends do not quite meet. The ways become longer only where an inside has to come first. The same lines
    /// always come out in the same order.
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
                    nesting::surrounding(&candidate)
                } else {
                    vec![None; candidate.len()]
                };
                let is_wrong = order.inside_first && !is_inside_first(strokes);
                let candidate = rearranged(candidate, &around, order.effort);
                // What is not better is not worth a change.
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

/// One line on the way: where it is entered and left.
#[derive(Clone, Copy, Debug)]
struct TourStop {
    stroke: usize,
    start: [f64; 2],
    end: [f64; 2],
    /// Drawn from its last corner to its first.
    reversed: bool,
    /// The corner that a closed line begins at.
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

/// True if whatever lies within a closed line comes before it.
fn is_inside_first(strokes: &[Stroke]) -> bool {
    let around = nesting::surrounding(strokes);
    let mut pairs = around.iter().enumerate();
    pairs.all(|(inner, outer)| outer.is_none_or(|outer| inner < outer))
}

/// The lines in an order with short ways, each after those that it is around.
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
    // What is still to be put in order, last first: a closed line stands behind what is within.
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

/// A short way along some of the lines, from its end to its beginning. Of a line that is around others its place counts.
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
    // Where closed lines begin depends on their neighbours, and their neighbours on where they begin.
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

/// Has a closed line begin at another of its corners.
fn begin_at(stroke: &mut Stroke, corner: usize) {
    if corner == 0 || !stroke.is_closed() {
        return;
    }
    stroke.points.pop();
    stroke.points.rotate_left(corner);
    stroke.points.extend(stroke.points.first().copied());
}
