//! A better order from a good one: stretches turned round, lines moved elsewhere, as long as it gets shorter.

use super::super::{Stroke, distance};
use super::Leg;
use super::near::{Entry, Near};

/// As many points near an end are looked at.
const NEIGHBOURS: usize = 8;
/// Less is not worth a change, mm.
const WORTH: f64 = 1e-9;

/// Improves until nothing near helps any more, or the effort is spent.
pub(super) fn improve(legs: &mut Vec<Leg>, effort: u64) {
    if legs.len() < 2 {
        return;
    }
    let mut search = Search::new(std::mem::take(legs), effort);
    while search.effort > 0 && search.pass() {}
    *legs = search.legs;
}

struct Search {
    legs: Vec<Leg>,
    /// Where each line is in the order.
    position: Vec<usize>,
    /// Near each line's two ends, by line: the lines that end there.
    near: Vec<[Vec<usize>; 2]>,
    effort: u64,
}

impl Search {
    fn new(legs: Vec<Leg>, effort: u64) -> Self {
        let most = legs.iter().map(|leg| leg.stroke + 1).max().unwrap_or(0);
        let mut position = vec![0; most];
        for (at, leg) in legs.iter().enumerate() {
            if let Some(position) = position.get_mut(leg.stroke) {
                *position = at;
            }
        }
        let ends =
            |leg: &Leg| [(leg.start, 0), (leg.end, 1)].map(|(at, which)| (at, leg.stroke, which));
        let entries =
            legs.iter()
                .flat_map(ends)
                .map(|(at, owner, which)| Entry { at, owner, which });
        let points = Near::new(entries.collect());
        let mut near = vec![[Vec::new(), Vec::new()]; most];
        for leg in &legs {
            let around = |at| {
                let mut owners: Vec<usize> = points
                    .neighbours(at, leg.stroke, NEIGHBOURS)
                    .into_iter()
                    .map(|entry| entry.owner)
                    .collect();
                owners.dedup();
                owners
            };
            let both = [around(leg.start), around(leg.end)];
            if let Some(near) = near.get_mut(leg.stroke) {
                *near = both;
            }
        }
        Self {
            legs,
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
                better |= self.turn(stroke, *other) || self.shift(stroke, *other);
            }
        }
        better
    }

    fn at(&self, stroke: usize) -> usize {
        self.position.get(stroke).copied().unwrap_or(0)
    }

    /// The way from the line at one place to the next; none before the first and behind the last.
    fn gap(&self, from: Option<&Leg>, to: Option<&Leg>) -> f64 {
        match (from, to) {
            (Some(from), Some(to)) => distance(from.end, to.start),
            _ => 0.0,
        }
    }

    fn leg(&self, at: usize) -> Option<&Leg> {
        self.legs.get(at)
    }

    fn before(&self, at: usize) -> Option<&Leg> {
        at.checked_sub(1).and_then(|at| self.leg(at))
    }

    /// Turns the stretch round that ends one line at the other: either what lies behind both, or what begins with both.
    fn turn(&mut self, one: usize, other: usize) -> bool {
        let (first, last) = (
            self.at(one).min(self.at(other)),
            self.at(one).max(self.at(other)),
        );
        let behind = first + 1..last + 1;
        let with = first..last;
        for range in [behind, with] {
            if range.len() > 1 && self.turned(&range) < -WORTH && self.afford(range.len()) {
                self.reverse(range);
                return true;
            }
        }
        false
    }

    /// How much longer it gets if a stretch is drawn the other way round.
    fn turned(&self, range: &std::ops::Range<usize>) -> f64 {
        let (before, after) = (self.before(range.start), self.leg(range.end));
        let (first, last) = (self.leg(range.start), self.before(range.end));
        let now = self.gap(before, first) + self.gap(last, after);
        let (first, last) = (
            first.map(|leg| leg.reversed()),
            last.map(|leg| leg.reversed()),
        );
        self.gap(before, last.as_ref()) + self.gap(first.as_ref(), after) - now
    }

    fn afford(&mut self, steps: usize) -> bool {
        let enough = self.effort > steps as u64;
        self.effort = self.effort.saturating_sub(steps as u64);
        enough
    }

    fn reverse(&mut self, range: std::ops::Range<usize>) {
        if let Some(stretch) = self.legs.get_mut(range.clone()) {
            stretch.reverse();
            stretch.iter_mut().for_each(|leg| *leg = leg.reversed());
        }
        self.renumber(range);
    }

    fn renumber(&mut self, range: std::ops::Range<usize>) {
        for at in range {
            let stroke = self.legs.get(at).map(|leg| leg.stroke);
            if let Some(position) = stroke.and_then(|stroke| self.position.get_mut(stroke)) {
                *position = at;
            }
        }
    }

    /// Moves one line to just before or behind the other, either way round.
    fn shift(&mut self, one: usize, other: usize) -> bool {
        let (from, beside) = (self.at(one), self.at(other));
        let (Some(leg), Some(before), after) = (self.leg(from), from.checked_sub(1), from + 1)
        else {
            return self.shift_first(one, other);
        };
        let (leg, before) = (*leg, self.leg(before));
        let saved = self.gap(before, Some(&leg)) + self.gap(Some(&leg), self.leg(after))
            - self.gap(before, self.leg(after));
        self.put(from, beside, leg, saved)
    }

    fn shift_first(&mut self, one: usize, other: usize) -> bool {
        let (from, beside) = (self.at(one), self.at(other));
        let Some(leg) = self.leg(from).copied() else {
            return false;
        };
        let saved = self.gap(Some(&leg), self.leg(from + 1));
        self.put(from, beside, leg, saved)
    }

    /// Puts the line at one place to one of the sides of another, if that costs less than it saves.
    fn put(&mut self, from: usize, beside: usize, leg: Leg, saved: f64) -> bool {
        for to in [beside, beside + 1] {
            // To where it already is.
            if to == from || to == from + 1 {
                continue;
            }
            let (before, after) = (self.before(to).copied(), self.leg(to).copied());
            let (before, after) = (before.as_ref(), after.as_ref());
            let there = self.gap(before, after);
            for leg in [leg, leg.reversed()] {
                let cost = self.gap(before, Some(&leg)) + self.gap(Some(&leg), after) - there;
                if cost - saved < -WORTH && self.afford(from.abs_diff(to)) {
                    self.carry(from, to, leg);
                    return true;
                }
            }
        }
        false
    }

    fn carry(&mut self, from: usize, to: usize, leg: Leg) {
        let (range, at) = if from < to {
            (from..to, to - 1)
        } else {
            (to..from + 1, to)
        };
        if let Some(stretch) = self.legs.get_mut(range.clone()) {
            match from < to {
                true => stretch.rotate_left(1),
                false => stretch.rotate_right(1),
            }
        }
        if let Some(place) = self.legs.get_mut(at) {
            *place = leg;
        }
        self.renumber(range);
    }
}

/// Has each closed line begin at the corner that is best on the way from the line before to the one behind.
pub(super) fn turn_closed(legs: &mut [Leg], strokes: &[Stroke]) {
    for at in 0..legs.len() {
        let before = at
            .checked_sub(1)
            .and_then(|at| legs.get(at))
            .map(|leg| leg.end);
        let after = legs.get(at + 1).map(|leg| leg.start);
        let Some(leg) = legs.get_mut(at) else {
            return;
        };
        let Some(stroke) = strokes.get(leg.stroke).filter(|stroke| stroke.is_closed()) else {
            continue;
        };
        let cost = |point: [f64; 2]| {
            let from = before.map_or(0.0, |before| distance(before, point));
            from + after.map_or(0.0, |after| distance(point, after))
        };
        let mut best = (cost(leg.start) - WORTH, leg.start, leg.corner);
        for (corner, point) in stroke.points.iter().enumerate().skip(1) {
            if cost(*point) < best.0 {
                best = (cost(*point), *point, corner);
            }
        }
        let last = stroke.points.len() - 1;
        (leg.start, leg.end, leg.corner) = (best.1, best.1, best.2 % last);
    }
}
