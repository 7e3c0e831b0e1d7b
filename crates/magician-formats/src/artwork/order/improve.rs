//! Improvement of a tour by iterated local search.
//!
//! 2-opt reverses stretches and or-opt moves short chains of strokes elsewhere, until no change
//! nearby shortens the tour. Then a kick swaps two neighbouring stretches, the local search runs
//! again around them, and the result is undone unless the tour became shorter.
//!
//! The search is deterministic: it counts steps instead of time, and its random numbers have a
//! fixed seed, so the same strokes always come out in the same order.

use std::collections::VecDeque;
use std::ops::Range;

use super::super::{Stroke, distance};
use super::TourStop;
use super::kd_tree::{Entry, KdTree};

/// Number of nearest points to consider per end. A choice usual for 2-opt with neighbour lists.
const NEIGHBOUR_COUNT: usize = 8;
/// Smallest gain that counts, mm. It absorbs rounding, so that the search cannot cycle.
const MIN_GAIN: f64 = 1e-9;
/// Longest chain that or-opt moves, strokes.
const MAX_CHAIN: usize = 3;
/// Number of kicks per stroke. A choice between time and quality.
const KICKS_PER_STROKE: usize = 10;
/// Effort that all kicks together may use, steps.
const MAX_KICK_EFFORT: u64 = 25_000_000;
/// Longest stretch that a kick swaps, strokes. Short stretches keep the damage local, so that the
/// local search can repair it.
const MAX_SWAPPED_STROKES: usize = 30;
/// Effort of examining two neighbouring strokes, steps.
const PAIR_EFFORT: u64 = 50;

/// Improves the tour until no change near a stroke shortens it, then by kicks. Returns the
/// remaining effort.
pub(super) fn improve(stops: &mut Vec<TourStop>, effort: u64) -> u64 {
    if stops.len() < 3 {
        return improve_pair(stops, effort);
    }
    let mut search = LocalSearch::new(std::mem::take(stops), effort);
    search.queue.extend(0..search.near.len());
    search.queued.fill(true);
    search.settle();
    let mut random = RandomSource(search.stops.len() as u64);
    let enough = search.effort.saturating_sub(MAX_KICK_EFFORT);
    for _ in 0..KICKS_PER_STROKE * search.stops.len() {
        if search.effort <= enough {
            break;
        }
        search.kick(&mut random);
    }
    *stops = search.stops;
    search.effort
}

/// Tries all directions of two strokes.
fn improve_pair(stops: &mut [TourStop], effort: u64) -> u64 {
    if let [one, other] = stops {
        let ways = [(false, false), (false, true), (true, false), (true, true)];
        let turned = |stop: TourStop, turn: bool| if turn { stop.reversed() } else { stop };
        let pairs = ways.map(|(a, b)| (turned(*one, a), turned(*other, b)));
        let gap = |(one, other): &(TourStop, TourStop)| distance(one.end, other.start);
        for pair in pairs {
            if gap(&pair) < gap(&(*one, *other)) - MIN_GAIN {
                (*one, *other) = pair;
            }
        }
    }
    effort
}

/// Linear congruential generator with a fixed seed.
struct RandomSource(u64);

impl RandomSource {
    fn below(&mut self, most: usize) -> usize {
        self.0 = (self.0)
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % most.max(1) as u64) as usize
    }
}

struct LocalSearch {
    stops: Vec<TourStop>,
    /// Index in the tour of each stroke.
    position: Vec<usize>,
    /// Strokes that end near either end of each stroke, with their distance, nearest first.
    near: Vec<Vec<(usize, f64)>>,
    /// Strokes to examine, and which of them are in the queue.
    queue: VecDeque<usize>,
    queued: Vec<bool>,
    /// Stretches reversed since the last kick, and the change in length, mm.
    turned: Vec<Range<usize>>,
    longer: f64,
    effort: u64,
}

impl LocalSearch {
    fn new(stops: Vec<TourStop>, effort: u64) -> Self {
        let most = stops.iter().map(|stop| stop.stroke + 1).max().unwrap_or(0);
        let ends = |stop: &TourStop| {
            [(stop.start, 0), (stop.end, 1)].map(|(at, which)| (at, stop.stroke, which))
        };
        let entries =
            stops
                .iter()
                .flat_map(ends)
                .map(|(at, owner, which)| Entry { at, owner, which });
        let points = KdTree::new(entries.collect());
        let mut near = vec![Vec::new(); most];
        for stop in &stops {
            let around = |at| {
                let found = points.neighbours(at, stop.stroke, NEIGHBOUR_COUNT);
                (found.into_iter()).map(move |entry| (entry.owner, distance(at, entry.at)))
            };
            let mut owners: Vec<_> = [stop.start, stop.end]
                .into_iter()
                .flat_map(around)
                .collect();
            owners.sort_by(|(_, one), (_, other)| one.total_cmp(other));
            let mut known = Vec::with_capacity(owners.len());
            owners.retain(|(owner, _)| {
                let new = !known.contains(owner);
                known.push(*owner);
                new
            });
            if let Some(near) = near.get_mut(stop.stroke) {
                *near = owners;
            }
        }
        let mut search = Self {
            position: vec![0; most],
            near,
            queue: VecDeque::new(),
            queued: vec![false; most],
            turned: Vec::new(),
            longer: 0.0,
            effort,
            stops,
        };
        search.renumber(0..search.stops.len());
        search
    }

    /// Examines the strokes in the queue, and those whose gaps change, until nothing gets shorter.
    fn settle(&mut self) {
        while let Some(stroke) = self.queue.pop_front() {
            if let Some(queued) = self.queued.get_mut(stroke) {
                *queued = false;
            }
            while self.effort > 0 && self.shorten(stroke) {}
        }
    }

    /// Applies the first change that shortens a gap at a stroke. Returns false without such a
    /// change.
    fn shorten(&mut self, stroke: usize) -> bool {
        let at = self.at(stroke);
        let ways = [at, at + 1].map(|at| self.gap(self.before(at), self.stop(at)));
        let longest = ways[0].max(ways[1]);
        for nth in 0..self.near.get(stroke).map_or(0, Vec::len) {
            let near = self.near.get(stroke).and_then(|near| near.get(nth));
            // A new gap gains nothing unless it is shorter than the gap it replaces. Neighbours are
            // sorted, so no later neighbour gains anything either.
            let Some((other, _)) = near.copied().filter(|(_, far)| *far <= longest + MIN_GAIN)
            else {
                return false;
            };
            self.effort = self.effort.saturating_sub(PAIR_EFFORT);
            if self.two_opt(stroke, other) || self.or_opt(stroke, other) {
                return true;
            }
        }
        false
    }

    /// Swaps two neighbouring stretches and repairs the tour. Undone unless the tour ends up
    /// shorter.
    fn kick(&mut self, random: &mut RandomSource) {
        let count = self.stops.len();
        let longest = MAX_SWAPPED_STROKES.min(count / 2);
        let [first, second] = [(); 2].map(|()| 1 + random.below(longest));
        let from = random.below(count - first - second + 1);
        let (middle, to) = (from + first, from + first + second);
        let ways = |search: &Self| -> f64 {
            let gaps = [from, middle, to].map(|at| search.gap(search.before(at), search.stop(at)));
            gaps.iter().sum()
        };
        self.turned.clear();
        self.longer = -ways(self);
        for range in [from..to, from..from + second, from + second..to] {
            self.reverse(range);
        }
        let split = from + second;
        let gaps = [from, split, to].map(|at| self.gap(self.before(at), self.stop(at)));
        self.longer += gaps.iter().sum::<f64>();
        [from, split, to]
            .into_iter()
            .for_each(|at| self.enqueue_around(at));
        self.settle();
        if self.longer > -MIN_GAIN {
            while let Some(range) = self.turned.pop() {
                self.turn(range);
            }
        }
    }

    /// Queues the strokes on both sides of a gap.
    fn enqueue_around(&mut self, at: usize) {
        for at in [at.checked_sub(1), Some(at)].into_iter().flatten() {
            let Some(stroke) = self.stops.get(at).map(|stop| stop.stroke) else {
                continue;
            };
            if let Some(queued) = self.queued.get_mut(stroke)
                && !std::mem::replace(queued, true)
            {
                self.queue.push_back(stroke);
            }
        }
    }

    fn at(&self, stroke: usize) -> usize {
        self.position.get(stroke).copied().unwrap_or(0)
    }

    /// Length of a gap; 0 before the first stroke and after the last.
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

    /// 2-opt move: reverses a stretch so that two strokes become neighbours, either with their ends
    /// or with their starts.
    fn two_opt(&mut self, one: usize, other: usize) -> bool {
        let (first, last) = (
            self.at(one).min(self.at(other)),
            self.at(one).max(self.at(other)),
        );
        for range in [first + 1..last + 1, first..last, first..last + 1] {
            let gain = self.two_opt_gain(&range);
            if gain < -MIN_GAIN && self.afford(range.len()) {
                self.longer += gain;
                self.enqueue_around(range.start);
                self.enqueue_around(range.end);
                self.reverse(range);
                return true;
            }
        }
        false
    }

    /// Change in length if a stretch is reversed; negative is shorter.
    fn two_opt_gain(&self, range: &Range<usize>) -> f64 {
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

    fn reverse(&mut self, range: Range<usize>) {
        self.turned.push(range.clone());
        self.turn(range);
    }

    fn turn(&mut self, range: Range<usize>) {
        if let Some(stretch) = self.stops.get_mut(range.clone()) {
            stretch.reverse();
            stretch.iter_mut().for_each(|stop| *stop = stop.reversed());
        }
        self.renumber(range);
    }

    fn renumber(&mut self, range: Range<usize>) {
        for at in range {
            let stroke = self.stops.get(at).map(|stop| stop.stroke);
            if let Some(position) = stroke.and_then(|stroke| self.position.get_mut(stroke)) {
                *position = at;
            }
        }
    }

    /// Or-opt move: moves a stroke and up to two of its neighbours next to another stroke, in
    /// either direction.
    fn or_opt(&mut self, one: usize, other: usize) -> bool {
        let (at, beside) = (self.at(one), self.at(other));
        for long in 1..=MAX_CHAIN {
            let ahead = at..at + long;
            let behind = (at + 1).saturating_sub(long)..at + 1;
            for chain in [ahead, behind] {
                let is_there = chain.end <= self.stops.len() && chain.len() == long;
                if is_there && !chain.contains(&beside) && self.try_insert(&chain, beside) {
                    return true;
                }
            }
        }
        false
    }

    /// Moves a chain next to a stroke if that shortens the tour.
    fn try_insert(&mut self, chain: &Range<usize>, beside: usize) -> bool {
        let (before, after) = (self.before(chain.start), self.stop(chain.end));
        let (Some(first), Some(last)) = (self.stop(chain.start), self.before(chain.end)) else {
            return false;
        };
        let saved =
            self.gap(before, Some(first)) + self.gap(Some(last), after) - self.gap(before, after);
        let ways = [(*first, *last), (last.reversed(), first.reversed())];
        for to in [beside, beside + 1] {
            // The chain is already there.
            if (chain.start..=chain.end).contains(&to) {
                continue;
            }
            let (before, after) = (self.before(to), self.stop(to));
            let there = self.gap(before, after);
            for (turned, (first, last)) in [false, true].into_iter().zip(&ways) {
                let cost = self.gap(before, Some(first)) + self.gap(Some(last), after) - there;
                let gain = cost - saved;
                if gain < -MIN_GAIN {
                    return self.relocate(chain.clone(), to, turned, gain);
                }
            }
        }
        false
    }

    fn relocate(&mut self, chain: Range<usize>, to: usize, turned: bool, gain: f64) -> bool {
        let whole = chain.start.min(to)..chain.end.max(to);
        if !self.afford(2 * whole.len()) {
            return false;
        }
        self.longer += gain;
        [chain.start, chain.end, to]
            .into_iter()
            .for_each(|at| self.enqueue_around(at));
        let long = chain.len();
        // Reversing the whole range swaps chain and others; then each of the two is reversed back
        // unless it shall stay reversed.
        self.reverse(whole.clone());
        let (others, chain) = if to > chain.end {
            (whole.start..whole.end - long, whole.end - long..whole.end)
        } else {
            (
                whole.start + long..whole.end,
                whole.start..whole.start + long,
            )
        };
        self.reverse(others);
        if !turned {
            self.reverse(chain);
        }
        true
    }
}

/// Starts each closed stroke at the vertex with the shortest way from the stroke before to the one
/// after.
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
        let mut best = (cost(stop.start) - MIN_GAIN, stop.start, stop.corner);
        for (corner, point) in stroke.points.iter().enumerate().skip(1) {
            if cost(*point) < best.0 {
                best = (cost(*point), *point, corner);
            }
        }
        let last = stroke.points.len() - 1;
        (stop.start, stop.end, stop.corner) = (best.1, best.1, best.2 % last);
    }
}
