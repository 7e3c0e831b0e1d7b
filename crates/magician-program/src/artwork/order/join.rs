//! Lines that go on where others end, and lines that are there twice.

use std::collections::{HashMap, HashSet};

use super::super::{Stroke, distance};

/// Drops lines that another one is the same as, corner by corner, in either direction.
pub(super) fn drop_repeated(strokes: &mut Vec<Stroke>) {
    let bits = |points: &mut dyn Iterator<Item = &[f64; 2]>| -> Vec<[u64; 2]> {
        points.map(|point| point.map(f64::to_bits)).collect()
    };
    let mut known = HashSet::new();
    strokes.retain(|stroke| {
        let forth = bits(&mut stroke.points.iter());
        let back = bits(&mut stroke.points.iter().rev());
        known.insert(forth.min(back))
    });
}

/// Makes one line of open lines whose ends are no farther apart than `within`; how many others have been taken up.
pub(super) fn join(strokes: &mut Vec<Stroke>, within: f64) -> usize {
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

/// The ends of open lines, in cells as large as they may be apart.
struct Ends {
    within: f64,
    cells: HashMap<[i64; 2], Vec<(usize, bool)>>,
    places: Vec<[[i64; 2]; 2]>,
}

impl Ends {
    fn new(strokes: &[Stroke], within: f64) -> Self {
        let mut ends = Self {
            within,
            cells: HashMap::new(),
            places: Vec::with_capacity(strokes.len()),
        };
        for (at, stroke) in strokes.iter().enumerate() {
            let both = [stroke.points.first(), stroke.points.last()];
            let places = both.map(|point| point.map_or([0; 2], |point| ends.place(*point)));
            ends.places.push(places);
            if stroke.points.len() > 1 && !stroke.is_closed() {
                for (place, is_end) in places.into_iter().zip([false, true]) {
                    ends.cells.entry(place).or_default().push((at, is_end));
                }
            }
        }
        ends
    }

    fn place(&self, point: [f64; 2]) -> [i64; 2] {
        let cell = self.within.max(1e-9);
        point.map(|value| (value / cell).floor() as i64)
    }

    fn remove(&mut self, at: usize) {
        for place in self.places.get(at).copied().unwrap_or_default() {
            if let Some(cell) = self.cells.get_mut(&place) {
                cell.retain(|(owner, _)| *owner != at);
            }
        }
    }

    /// The line that begins or ends nearest to where one ends, if that is near enough.
    fn near(&self, strokes: &[Stroke], at: usize) -> Option<(usize, bool)> {
        let end = *strokes.get(at)?.points.last()?;
        let [i, j] = self.place(end);
        let around = (-1..=1)
            .flat_map(|x| (-1..=1).map(move |y| [i.saturating_add(x), j.saturating_add(y)]));
        let mut best: Option<(f64, usize, bool)> = None;
        for (owner, is_end) in around.filter_map(|place| self.cells.get(&place)).flatten() {
            let points = &strokes.get(*owner)?.points;
            let point = if *is_end {
                points.last()
            } else {
                points.first()
            };
            let way = distance(end, *point?);
            if way <= self.within && best.is_none_or(|(known, ..)| way < known) {
                best = Some((way, *owner, *is_end));
            }
        }
        best.map(|(_, owner, is_end)| (owner, is_end))
    }
}
