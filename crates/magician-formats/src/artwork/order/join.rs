//! Lines that go on where others end.

use super::super::{Stroke, distance};
use super::kd_tree::{Entry, KdTree};

/// Makes one line of open lines whose ends are no farther apart than `within`; how many others have been taken up.
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
        // On from its end, then on from its beginning.
        for _ in 0..2 {
            while let Some((other, from_end)) = ends.near(strokes, at) {
                ends.remove(other);
                if let Some(taken) = taken.get_mut(other) {
                    *taken = true;
                }
                joined += 1;
                go_on(strokes, at, other, from_end);
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

fn go_on(strokes: &mut [Stroke], at: usize, other: usize, from_end: bool) {
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

/// A line whose ends meet is closed.
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

/// The ends of open lines.
struct Ends {
    within: f64,
    near: KdTree,
    /// Which of them is the first of each line.
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

    /// The line that begins or ends nearest to where one ends, if that is near enough, and whether it ends there.
    fn near(&self, strokes: &[Stroke], at: usize) -> Option<(usize, bool)> {
        let end = *strokes.get(at)?.points.last()?;
        let found = self.near.nearest(end)?;
        (distance(end, found.at) <= self.within).then_some((found.owner, found.which == 1))
    }
}
