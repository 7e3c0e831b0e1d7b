//! A better tour from a good one by local search, as long as it gets shorter: 2-opt turns stretches round, or-opt moves lines elsewhere.

use super::super::{Stroke, distance};
use super::TourStop;
use super::kd_tree::{Entry, KdTree};

/// As many points near an end are looked at.
const NEIGHBOURS: usize = 8;
/// Less is not worth a change, mm.
const WORTH: f64 = 1e-9;

/// Improves until nothing near helps any more, or the effort is spent.
pub(super) fn improve(stops: &mut Vec<TourStop>, effort: u64) {
    if stops.len() < 2 {
        return;
    }
    let mut search = LocalSearch::new(std::mem::take(stops), effort);
    while search.effort > 0 && search.pass() {}
    *stops = search.stops;
}

struct LocalSearch {
    stops: Vec<TourStop>,
    /// Where each line is in the order.
    position: Vec<usize>,
    /// Near each line's two ends, by line: the lines that end there.
    near: Vec<[Vec<usize>; 2]>,
    effort: u64,
}

impl LocalSearch {
    fn new(stops: Vec<TourStop>, effort: u64) -> Self {
        let most = stops.iter().map(|stop| stop.stroke + 1).max().unwrap_or(0);
        let mut position = vec![0; most];
        for (at, stop) in stops.iter().enumerate() {
            if let Some(position) = position.get_mut(stop.stroke) {
                *position = at;
            }
        }
        let ends = |stop: &TourStop| {
            [(stop.start, 0), (stop.end, 1)].map(|(at, which)| (at, stop.stroke, which))
        };
        let entries =
            stops
                .iter()
                .flat_map(ends)
                .map(|(at, owner, which)| Entry { at, owner, which });
        let points = KdTree::new(entries.collect());
        let mut near = vec![[Vec::new(), Vec::new()]; most];
        for stop in &stops {
            let around = |at| {
                let mut owners: Vec<usize> = points
                    .neighbours(at, stop.stroke, NEIGHBOURS)
                    .into_iter()
                    .map(|entry| entry.owner)
                    .collect();
                owners.dedup();
                owners
            };
            let both = [around(stop.start), around(stop.end)];
            if let Some(near) = near.get_mut(stop.stroke) {
                *near = both;
            }
        }
        Self {
            stops,
            position,
            near,
            effort,
        }
    }

    /// Looks at every line once; whether anything got shorter.
    fn pass(&mut self) -> bool {
        let mut better = false;
        for stroke in 0..self.near.len() {
            let near = self.near.get(stroke).cloned().unwrap_or_default();
            for other in near.iter().flatten() {
                if self.effort == 0 {
                    return false;
                }
                self.effort = self.effort.saturating_sub(20);
                better |= self.two_opt(stroke, *other) || self.or_opt(stroke, *other);
            }
        }
        better
    }

    fn at(&self, stroke: usize) -> usize {
        self.position.get(stroke).copied().unwrap_or(0)
    }

    /// The way from the line at one place to the next; none before the first and behind the last.
    fn gap(&self, from: Option<&TourStop>, to: Option<&TourStop>) -> f64 {
        match (from, to) {
            (Some(from), Some(to)) => distance(from.end, to.start),
            _ => 0.0,
        }
    }

    fn stop(&self, at: usize) -> Option<&TourStop> {
        self.stops.get(at)
    }

    fn before(&self, at: usize) -> Option<&TourStop> {
        at.checked_sub(1).and_then(|at| self.stop(at))
    }

    /// A step of 2-opt: turns the stretch round that ends one line at the other: either what lies behind both, or what begins with both.
    fn two_opt(&mut self, one: usize, other: usize) -> bool {
        let (first, last) = (
            self.at(one).min(self.at(other)),
            self.at(one).max(self.at(other)),
        );
        let behind = first + 1..last + 1;
        let with = first..last;
        for range in [behind, with] {
            if range.len() > 1 && self.two_opt_gain(&range) < -WORTH && self.afford(range.len()) {
                self.reverse(range);
                return true;
            }
        }
        false
    }

    /// How much longer it gets if a stretch is drawn the other way round.
    fn two_opt_gain(&self, range: &std::ops::Range<usize>) -> f64 {
        let (before, after) = (self.before(range.start), self.stop(range.end));
        let (first, last) = (self.stop(range.start), self.before(range.end));
        let now = self.gap(before, first) + self.gap(last, after);
        let (first, last) = (
            first.map(|stop| stop.reversed()),
            last.map(|stop| stop.reversed()),
        );
        self.gap(before, last.as_ref()) + self.gap(first.as_ref(), after) - now
    }

    fn afford(&mut self, steps: usize) -> bool {
        let enough = self.effort > steps as u64;
        self.effort = self.effort.saturating_sub(steps as u64);
        enough
    }

    fn reverse(&mut self, range: std::ops::Range<usize>) {
        if let Some(stretch) = self.stops.get_mut(range.clone()) {
            stretch.reverse();
            stretch.iter_mut().for_each(|stop| *stop = stop.reversed());
        }
        self.renumber(range);
    }

    fn renumber(&mut self, range: std::ops::Range<usize>) {
        for at in range {
            let stroke = self.stops.get(at).map(|stop| stop.stroke);
            if let Some(position) = stroke.and_then(|stroke| self.position.get_mut(stroke)) {
                *position = at;
            }
        }
    }

    /// A step of or-opt: moves one line to just before or behind the other, either way round.
    fn or_opt(&mut self, one: usize, other: usize) -> bool {
        let (from, beside) = (self.at(one), self.at(other));
        let (Some(stop), Some(before), after) = (self.stop(from), from.checked_sub(1), from + 1)
        else {
            return self.or_opt_first(one, other);
        };
        let (stop, before) = (*stop, self.stop(before));
        let saved = self.gap(before, Some(&stop)) + self.gap(Some(&stop), self.stop(after))
            - self.gap(before, self.stop(after));
        self.put(from, beside, stop, saved)
    }

    fn or_opt_first(&mut self, one: usize, other: usize) -> bool {
        let (from, beside) = (self.at(one), self.at(other));
        let Some(stop) = self.stop(from).copied() else {
            return false;
        };
        let saved = self.gap(Some(&stop), self.stop(from + 1));
        self.put(from, beside, stop, saved)
    }

    /// Puts the line at one place to one of the sides of another, if that costs less than it saves.
    fn put(&mut self, from: usize, beside: usize, stop: TourStop, saved: f64) -> bool {
        for to in [beside, beside + 1] {
            // To where it already is.
            if to == from || to == from + 1 {
                continue;
            }
            let (before, after) = (self.before(to).copied(), self.stop(to).copied());
            let (before, after) = (before.as_ref(), after.as_ref());
            let there = self.gap(before, after);
            for stop in [stop, stop.reversed()] {
                let cost = self.gap(before, Some(&stop)) + self.gap(Some(&stop), after) - there;
                if cost - saved < -WORTH && self.afford(from.abs_diff(to)) {
                    self.relocate(from, to, stop);
                    return true;
                }
            }
        }
        false
    }

    fn relocate(&mut self, from: usize, to: usize, stop: TourStop) {
        let (range, at) = if from < to {
            (from..to, to - 1)
        } else {
            (to..from + 1, to)
        };
        if let Some(stretch) = self.stops.get_mut(range.clone()) {
            match from < to {
                true => stretch.rotate_left(1),
                false => stretch.rotate_right(1),
            }
        }
        if let Some(place) = self.stops.get_mut(at) {
            *place = stop;
        }
        self.renumber(range);
    }
}

/// Has each closed line begin at the corner that is best on the way from the line before to the one behind.
pub(super) fn rotate_closed(stops: &mut [TourStop], strokes: &[Stroke]) {
    for at in 0..stops.len() {
        let before = at
            .checked_sub(1)
            .and_then(|at| stops.get(at))
            .map(|stop| stop.end);
        let after = stops.get(at + 1).map(|stop| stop.start);
        let Some(stop) = stops.get_mut(at) else {
            return;
        };
        let Some(stroke) = strokes.get(stop.stroke).filter(|stroke| stroke.is_closed()) else {
            continue;
        };
        let cost = |point: [f64; 2]| {
            let from = before.map_or(0.0, |before| distance(before, point));
            from + after.map_or(0.0, |after| distance(point, after))
        };
        let mut best = (cost(stop.start) - WORTH, stop.start, stop.corner);
        for (corner, point) in stroke.points.iter().enumerate().skip(1) {
            if cost(*point) < best.0 {
                best = (cost(*point), *point, corner);
            }
        }
        let last = stroke.points.len() - 1;
        (stop.start, stop.end, stop.corner) = (best.1, best.1, best.2 % last);
    }
}
