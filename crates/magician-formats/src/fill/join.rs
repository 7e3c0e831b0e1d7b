//! Connecting hatch lines to long paths.
//!
//! A greedy walk starts at the line with the fewest continuations and prefers such lines, because
//! they would otherwise be left over. Then paths whose ends are connected by the edge are
//! concatenated. The result has at most a third more paths than the optimum on the shapes of the
//! tests.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

use crate::artwork::distance;

/// Points where hatch lines meet the edge (*ends*); two ends make a line.
#[derive(Debug, Default)]
pub(super) struct Graph {
    ends: Vec<End>,
    /// Piece of edge behind each end, up to the next.
    pieces: Vec<Piece>,
}

/// A piece of edge between two ends.
#[derive(Clone, Debug, Default)]
pub(super) struct Piece {
    /// Vertices between the ends.
    pub(super) corners: Vec<[f64; 2]>,
    /// Area left bare beside the piece unless it is drawn, mm2.
    pub(super) bare: f64,
}

#[derive(Clone, Copy, Debug)]
struct End {
    at: [f64; 2],
    /// Index of the line.
    level: usize,
    /// Position along the line.
    along: f64,
    /// The other end of the line's piece inside the shape.
    mate: usize,
    /// Neighbouring ends along the edge, before and behind.
    beside: [usize; 2],
}

/// A path: for each line the end at which the pen arrives.
type Path = VecDeque<usize>;

impl Graph {
    /// Adds a ring of the edge: its ends in order (point, line, position along the line), and the
    /// piece behind each.
    pub(super) fn ring(&mut self, ends: &[([f64; 2], usize, f64)], pieces: Vec<Piece>) {
        let (first, count) = (self.ends.len(), ends.len());
        for (nth, (at, level, along)) in ends.iter().enumerate() {
            let around = |by: usize| first + (nth + by) % count;
            self.ends.push(End {
                at: *at,
                level: *level,
                along: *along,
                mate: usize::MAX,
                beside: [around(count - 1), around(1)],
            });
        }
        self.pieces.extend(pieces);
    }

    /// Returns the paths, connected along pieces of edge of at most `longest`. Pieces that would
    /// leave more than `bare` uncovered are drawn in any case.
    pub(super) fn paths(&self, longest: f64, bare: f64) -> Vec<Vec<[f64; 2]>> {
        let ways = EdgeConnections::new(self, longest);
        let paths = ways.joined(ways.greedy_paths());
        let mut wanted: Vec<bool> = self.pieces.iter().map(|piece| piece.bare > bare).collect();
        for path in &paths {
            let passed = path.iter().zip(path.iter().skip(1));
            for (from, to) in passed {
                wanted[ways.piece(self.mate(*from), *to).0] = false;
            }
        }
        let mut lines: Vec<_> = paths
            .iter()
            .map(|path| ways.drawn(path, &mut wanted))
            .collect();
        for (end, wanted) in wanted.iter().enumerate() {
            if *wanted {
                let points = [self.at(end)].into_iter().chain(self.corners(end));
                lines.push(points.chain([self.at(self.ends[end].beside[1])]).collect());
            }
        }
        lines
    }

    fn corners(&self, end: usize) -> impl DoubleEndedIterator<Item = [f64; 2]> + '_ {
        self.pieces[end].corners.iter().copied()
    }

    /// Pairs the ends of each line, once all are added: every second interval is inside the shape.
    pub(super) fn pair(&mut self) {
        let mut order: Vec<usize> = (0..self.ends.len()).collect();
        order.sort_by(|one, other| {
            let [one, other] = [one, other].map(|which| &self.ends[*which]);
            { one.level.cmp(&other.level) }.then(one.along.total_cmp(&other.along))
        });
        for pair in order.chunks_exact(2) {
            self.ends[pair[0]].mate = pair[1];
            self.ends[pair[1]].mate = pair[0];
        }
    }

    fn at(&self, end: usize) -> [f64; 2] {
        self.ends[end].at
    }

    fn mate(&self, end: usize) -> usize {
        self.ends[end].mate
    }
}

/// Connections between ends along the edge.
struct EdgeConnections<'a> {
    graph: &'a Graph,
    /// Length of the piece of edge behind each end; `None` if it is too long to use.
    lengths: Vec<Option<f64>>,
}

impl<'a> EdgeConnections<'a> {
    fn new(graph: &'a Graph, longest: f64) -> Self {
        let length = |(end, piece): (&End, &Piece)| {
            let next = graph.at(end.beside[1]);
            let mut at = end.at;
            let mut length = 0.0;
            for to in piece.corners.iter().chain([&next]) {
                length += distance(at, *to);
                at = *to;
            }
            (length <= longest).then_some(length)
        };
        let lengths = graph.ends.iter().zip(&graph.pieces).map(length).collect();
        Self { graph, lengths }
    }

    /// Iterates over the ends reachable along the edge, with the distance.
    fn from(&self, end: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let [before, behind] = self.graph.ends[end].beside;
        let ways = [(before, self.lengths[before]), (behind, self.lengths[end])];
        let other = move |to: usize| to != end && to != self.graph.mate(end);
        ways.into_iter()
            .filter_map(move |(to, length)| Some((to, length.filter(|_| other(to))?)))
    }

    /// Returns the piece between two neighbouring ends, and true if it is followed in the direction
    /// of the edge.
    fn piece(&self, from: usize, to: usize) -> (usize, bool) {
        if self.graph.ends[from].beside[1] == to && self.lengths[from].is_some() {
            (from, true)
        } else {
            (to, false)
        }
    }

    /// Returns the points of a path. Wanted pieces at either end are drawn along with it.
    fn drawn(&self, path: &Path, wanted: &mut [bool]) -> Vec<[f64; 2]> {
        let graph = self.graph;
        let mut points = Vec::new();
        let mut left = None;
        for end in path {
            if let Some(left) = left {
                match self.piece(left, *end) {
                    (piece, true) => points.extend(graph.corners(piece)),
                    (piece, false) => points.extend(graph.corners(piece).rev()),
                }
            }
            points.extend([*end, graph.mate(*end)].map(|end| graph.at(end)));
            left = Some(graph.mate(*end));
        }
        for end in [left, path.front().copied()].into_iter().flatten() {
            let [before, behind] = graph.ends[end].beside;
            if std::mem::take(&mut wanted[end]) {
                points.extend(graph.corners(end).chain([graph.at(behind)]));
            } else if std::mem::take(&mut wanted[before]) {
                points.extend(graph.corners(before).rev().chain([graph.at(before)]));
            }
            points.reverse();
        }
        points
    }

    /// Number of lines that can follow a line.
    fn free(&self, end: usize, seen: &[bool]) -> usize {
        let ends = [end, self.graph.mate(end)];
        let ways = ends.into_iter().flat_map(|end| self.from(end));
        ways.filter(|(to, _)| !seen[*to]).count()
    }

    fn greedy_paths(&self) -> Vec<Path> {
        let count = self.graph.ends.len();
        let mut seen = vec![false; count];
        let mut paths = Vec::new();
        // Priority queue by number of continuations. Entries go stale as lines are used, so an
        // outdated one is pushed again with its current number.
        let mut next: BinaryHeap<Reverse<(usize, usize, usize)>> = { 0..count }
            .map(|end| Reverse((self.free(end, &seen), self.graph.ends[end].level, end)))
            .collect();
        while let Some(Reverse((free, level, end))) = next.pop() {
            if seen[end] {
                continue;
            }
            let now = self.free(end, &seen);
            if now != free {
                next.push(Reverse((now, level, end)));
                continue;
            }
            let mut path = Path::new();
            self.take(end, &mut seen);
            path.push_back(end);
            let mut from = self.graph.mate(end);
            while let Some(to) = self.best(from, &seen) {
                self.take(to, &mut seen);
                path.push_back(to);
                from = self.graph.mate(to);
            }
            let mut from = end;
            while let Some(to) = self.best(from, &seen) {
                self.take(to, &mut seen);
                path.push_front(self.graph.mate(to));
                from = self.graph.mate(to);
            }
            paths.push(path);
        }
        paths
    }

    fn take(&self, end: usize, seen: &mut [bool]) {
        seen[end] = true;
        seen[self.graph.mate(end)] = true;
    }

    /// Returns the best continuation: the line with the fewest continuations itself, then the
    /// nearest.
    fn best(&self, from: usize, seen: &[bool]) -> Option<usize> {
        let ways = self.from(from).filter(|(to, _)| !seen[*to]);
        let rated = ways.map(|(to, length)| (self.free(to, seen), length, to));
        rated
            .min_by(|one, other| one.0.cmp(&other.0).then(one.1.total_cmp(&other.1)))
            .map(|(_, _, to)| to)
    }

    /// Concatenates paths whose ends are connected along the edge.
    fn joined(&self, paths: Vec<Path>) -> Vec<Path> {
        let mut owner = vec![usize::MAX; self.graph.ends.len()];
        let mut joined: Vec<Path> = Vec::new();
        // The end where the pen leaves the last line, and the one where it arrives at the first.
        let last = |path: &Path| path.back().map(|end| self.graph.mate(*end));
        let first = |path: &Path| path.front().copied();
        for mut path in paths {
            for _ in 0..2 {
                let found = last(&path).into_iter().flat_map(|end| self.from(end));
                let found = found.map(|(to, _)| to).find(|to| owner[*to] != usize::MAX);
                if let Some(to) = found {
                    let other = std::mem::take(&mut joined[owner[to]]);
                    for end in [first(&other), last(&other)].into_iter().flatten() {
                        owner[end] = usize::MAX;
                    }
                    if first(&other) == Some(to) {
                        path.extend(other)
                    } else {
                        path.extend(self.turned(other))
                    }
                }
                path = self.turned(path);
            }
            for end in [first(&path), last(&path)].into_iter().flatten() {
                owner[end] = joined.len();
            }
            joined.push(path);
        }
        joined.retain(|path| !path.is_empty());
        joined
    }

    fn turned(&self, path: Path) -> Path {
        path.iter().rev().map(|end| self.graph.mate(*end)).collect()
    }
}

#[cfg(test)]
impl Graph {
    /// Smallest number of paths, found by exhaustive search; `None` if that would take too long.
    pub(super) fn fewest(&self, longest: f64) -> Option<usize> {
        let ways = EdgeConnections::new(self, longest);
        let pieces: Vec<[usize; 2]> = { 0..self.ends.len() }
            .filter(|end| ways.lengths[*end].is_some())
            .map(|end| [end, self.ends[end].beside[1]])
            .filter(|[from, to]| from != to && self.mate(*from) != *to)
            .collect();
        if pieces.len() > 26 {
            return None;
        }
        let lines: Vec<usize> = { 0..self.ends.len() }
            .map(|end| end.min(self.mate(end)))
            .collect();
        let count = self.ends.len() / 2;
        let mut most = 0;
        join_most(
            &pieces,
            0,
            &mut vec![false; self.ends.len()],
            &lines,
            &mut most,
        );
        Some(count - most)
    }
}

/// Largest number of pieces usable together: each end once, and no closed path.
#[cfg(test)]
fn join_most(
    pieces: &[[usize; 2]],
    joined: usize,
    used: &mut [bool],
    group: &[usize],
    most: &mut usize,
) {
    *most = joined.max(*most);
    let Some(([from, to], rest)) = pieces.split_first() else {
        return;
    };
    if joined + pieces.len() <= *most {
        return;
    }
    if !used[*from] && !used[*to] && group[*from] != group[*to] {
        let (one, other) = (group[*from], group[*to]);
        let one_path: Vec<usize> = { group.iter() }
            .map(|which| if *which == other { one } else { *which })
            .collect();
        (used[*from], used[*to]) = (true, true);
        join_most(rest, joined + 1, used, &one_path, most);
        (used[*from], used[*to]) = (false, false);
    }
    join_most(rest, joined, used, group, most);
}
