//! Joining of strokes that continue where others end.

use super::super::{Stroke, distance};
use super::kd_tree::{Entry, KdTree};

/// Joins open strokes whose ends are at most `within` apart. Returns the number of strokes
/// absorbed; a negative or NaN distance joins nothing.
pub(in crate::artwork) fn join(strokes: &mut Vec<Stroke>, within: f64) -> usize {
    if within.is_nan() || within < 0.0 {
        return 0;
    }
    let mut ends = Ends::new(strokes, within);
    let mut taken = vec![false; strokes.len()];
    let mut joined = 0;
    for at in 0..strokes.len() {
        let is_open = strokes
            .get(at)
            .is_some_and(|stroke| stroke.points.len() > 1 && !stroke.is_closed());
        if !is_open || taken.get(at).copied().unwrap_or(true) {
            continue;
        }
        ends.remove(at);
        // Extend the end, reverse, and extend the other end. The second reversal restores the
        // direction.
        for _ in 0..2 {
            while let Some((other, from_end)) = ends.near(strokes, at) {
                ends.remove(other);
                if let Some(taken) = taken.get_mut(other) {
                    *taken = true;
                }
                joined += 1;
                append_stroke(strokes, at, other, from_end);
            }
            if let Some(stroke) = strokes.get_mut(at) {
                stroke.points.reverse();
            }
        }
        close(strokes.get_mut(at), within);
    }
    let mut taken = taken.into_iter();
    strokes.retain(|_| !taken.next().unwrap_or(false));
    joined
}

fn append_stroke(strokes: &mut [Stroke], at: usize, other: usize, from_end: bool) {
    let Some(mut more) = strokes
        .get_mut(other)
        .map(|other| std::mem::take(&mut other.points))
    else {
        return;
    };
    if from_end {
        more.reverse();
    }
    if let Some(stroke) = strokes.get_mut(at) {
        let same = stroke.points.last() == more.first();
        stroke
            .points
            .extend(more.into_iter().skip(usize::from(same)));
    }
}

/// Closes a stroke whose ends meet.
fn close(stroke: Option<&mut Stroke>, within: f64) {
    let Some(stroke) = stroke else {
        return;
    };
    if let (Some(first), Some(last)) = (stroke.points.first().copied(), stroke.points.last())
        && stroke.points.len() > 3
        && first != *last
        && distance(first, *last) <= within
    {
        stroke.points.push(first);
    }
}

/// Ends of the open strokes.
struct Ends {
    within: f64,
    near: KdTree,
    /// Index of the first of both entries of each stroke.
    firsts: Vec<Option<usize>>,
}

impl Ends {
    fn new(strokes: &[Stroke], within: f64) -> Self {
        let mut entries = Vec::new();
        let mut firsts = vec![None; strokes.len()];
        for (owner, (stroke, its_first)) in strokes.iter().zip(&mut firsts).enumerate() {
            if let ([first, .., last], false) = (stroke.points.as_slice(), stroke.is_closed()) {
                *its_first = Some(entries.len());
                let both = [first, last].into_iter().enumerate();
                entries.extend(both.map(|(which, at)| Entry {
                    at: *at,
                    owner,
                    which,
                }));
            }
        }
        Self {
            within,
            near: KdTree::new(entries),
            firsts,
        }
    }

    fn remove(&mut self, at: usize) {
        if let Some(first) = self.firsts.get(at).copied().flatten() {
            self.near.remove(first);
            self.near.remove(first + 1);
        }
    }

    /// Returns the stroke with the nearest end, if it is near enough, and true if it is that
    /// stroke's last point.
    fn near(&self, strokes: &[Stroke], at: usize) -> Option<(usize, bool)> {
        let end = *strokes.get(at)?.points.last()?;
        let found = self.near.nearest(end)?;
        (distance(end, found.at) <= self.within).then_some((found.owner, found.which == 1))
    }
}
