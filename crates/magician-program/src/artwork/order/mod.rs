//! The order in which lines are drawn: as little way as possible without drawing.

mod greedy;
mod improve;
pub(super) mod join;
mod kd_tree;

use super::{Artwork, Stroke, distance};

/// How lines are put in order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Order {
    /// Whether lines may be drawn in another order and the other way round, and closed ones from elsewhere.
    pub rearrange: bool,
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
            joining: 0.01,
            effort: 200_000_000,
        }
    }
}

impl Order {
    /// As the file has it, with the pen lifted after each line.
    pub const OF_FILE: Self = Self {
        rearrange: false,
        joining: -1.0,
        effort: 0,
    };

    /// The same for lines that are drawn in this size: lengths are those of what is drawn.
    pub(crate) fn to_draw(self, scale: f64) -> Self {
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
    /// joins lines whose ends do not quite meet; the ways never become longer. The same lines always come out in the same
    /// order.
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
                let candidate = rearranged(candidate, order.effort);
                // What is not better is not worth a change.
                if travel(&candidate) < travel(strokes) {
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

fn rearranged(strokes: Vec<Stroke>, effort: u64) -> Vec<Stroke> {
    let mut stops = greedy::tour(&strokes);
    // Where closed lines begin depends on their neighbours, and their neighbours on where they begin.
    let left = improve::improve(&mut stops, effort);
    improve::rotate_closed(&mut stops, &strokes);
    if strokes.iter().any(Stroke::is_closed) {
        improve::improve(&mut stops, left);
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

/// Has a closed line begin at another of its corners.
fn begin_at(stroke: &mut Stroke, corner: usize) {
    if corner == 0 || !stroke.is_closed() {
        return;
    }
    stroke.points.pop();
    stroke.points.rotate_left(corner);
    stroke.points.extend(stroke.points.first().copied());
}
