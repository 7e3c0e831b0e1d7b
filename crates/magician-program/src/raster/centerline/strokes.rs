//! Strokes of a skeleton: without spurs, straight through crossings, and with sharp corners where
//! the skeleton rounds them.
//!
//! A skeleton has artefacts near junctions: short spurs at line ends, a bridge between two
//! junctions where thick lines cross, and a common tail where two lines meet at an acute angle. The
//! lengths below are in half thicknesses of the line, since artefacts grow with it. They are
//! choices, tested on scanned text.

use super::graph::{Branch, Graph};
use crate::artwork::distance;

/// Longest branch with a free end that counts as a spur, in half thicknesses.
const MAX_SPUR: f64 = 1.5;
/// Largest distance of two junctions that are one crossing, in half thicknesses.
const MAX_CROSSING: f64 = 2.2;
/// Distance from a junction within which the skeleton is not the centre of any line, in half
/// thicknesses.
const SMEARED_RADIUS: f64 = 1.5;
/// Distance beyond that over which the direction of a branch is measured, in half thicknesses.
const DIRECTION_SPAN: f64 = 4.0;
/// Largest turn of a line through a junction: cosine of 40 degrees.
const STRAIGHT_COSINE: f64 = 0.766;
/// Longest common tail of two lines that meet at a sharp corner, in half thicknesses.
const MAX_TAIL: f64 = 8.0;
/// Largest distance of the corner from the end of that tail, in half thicknesses.
const MAX_CORNER_DISTANCE: f64 = 3.0;
/// Smallest turn that leaves such a tail: cosine of 120 degrees.
const SHARP_COSINE: f64 = -0.5;
/// Largest share of a branch cut off at one end.
const MAX_CUT_SHARE: f64 = 0.4;

type Point = [f64; 2];
/// Branch, and which of its ends (0 or 1).
type End = (usize, usize);

/// Returns the strokes in pixels; dots are single points.
pub(super) fn of(mut graph: Graph) -> Vec<Vec<Point>> {
    for branch in &mut graph.branches {
        smooth(&mut branch.points);
    }
    graph.remove_spurs();
    graph.merge_crossings();
    graph.remove_spurs();
    let mut strokes = Joints::of(&graph).strokes(&graph);
    strokes.extend(graph.dots.iter().map(|dot| vec![*dot]));
    strokes
}

/// Smooths the pixel steps of a line; its ends stay.
fn smooth(points: &mut [Point]) {
    const SMOOTHING_PASSES: usize = 3;
    let closed = points.len() > 3 && points.first() == points.last();
    for _ in 0..SMOOTHING_PASSES {
        let before = points.to_vec();
        let Some(last) = before.len().checked_sub(1) else {
            return;
        };
        let mean = |one: Point, middle: Point, other: Point| {
            [0, 1].map(|axis| (one[axis] + 2.0 * middle[axis] + other[axis]) / 4.0)
        };
        for at in 1..last {
            points[at] = mean(before[at - 1], before[at], before[at + 1]);
        }
        if closed {
            points[0] = mean(before[last - 1], before[0], before[1]);
            points[last] = points[0];
        }
    }
}

impl Graph {
    /// Ends of branches at each node.
    fn ends(&self) -> Vec<Vec<End>> {
        let mut ends = vec![Vec::new(); self.nodes.len()];
        for (nth, branch) in self.branches.iter().enumerate() {
            for (end, node) in branch.ends.into_iter().flatten().enumerate() {
                ends[node].push((nth, end));
            }
        }
        ends
    }

    fn remove_spurs(&mut self) {
        self.remove_small_loops();
        loop {
            let ends = self.ends();
            let mut spurs = Vec::new();
            for (node, at_node) in ends.iter().enumerate().filter(|(_, ends)| ends.len() > 2) {
                let most = MAX_SPUR * self.nodes[node].thick;
                let lengths = at_node.iter().filter_map(|(branch, end)| {
                    let other = self.branches[*branch].ends?[1 - end];
                    let length = self.branches[*branch].length();
                    let is_spur = ends[other].len() == 1 && length < most;
                    (is_spur && !self.has_corner(node, &ends)).then_some((*branch, length))
                });
                // Remove one at a time: without it the other branches may form a line.
                spurs.extend(lengths.min_by(|one, other| one.1.total_cmp(&other.1)));
            }
            if spurs.is_empty() {
                return;
            }
            let mut nth = 0;
            self.branches.retain(|_| {
                nth += 1;
                !spurs.iter().any(|(spur, _)| *spur == nth - 1)
            });
            // Without a spur its junction is the middle of a line: join the two halves before the
            // next round.
            self.join_through();
        }
    }

    /// Removes loops no larger than the thickness of the line. An isolated loop becomes a dot.
    fn remove_small_loops(&mut self) {
        let ends = self.ends();
        let (nodes, dots) = (&self.nodes, &mut self.dots);
        self.branches.retain(|branch| match branch.ends {
            Some([node, other])
                if node == other && branch.length() < MAX_CROSSING * nodes[node].radius =>
            {
                if ends[node].len() == 2 {
                    dots.push(nodes[node].at);
                }
                false
            }
            _ => true,
        });
    }

    /// True if one of the three branches is the tail of a sharp corner.
    fn has_corner(&self, node: usize, ends: &[Vec<End>]) -> bool {
        corner_at(self, ends, &branch_exits(self, ends, node)).is_some()
    }

    /// Joins two branches that meet where no other does.
    fn join_through(&mut self) {
        let mut ends = self.ends();
        for node in 0..self.nodes.len() {
            let &[(one, end), (other, other_end)] = ends[node].as_slice() else {
                continue;
            };
            if one == other {
                continue;
            }
            let far = |(branch, end): End| self.branches[branch].ends.map(|ends| ends[1 - end]);
            let (Some(first), Some(last)) = (far((one, end)), far((other, other_end))) else {
                continue;
            };
            let mut points = std::mem::take(&mut self.branches[one].points);
            if end == 0 {
                points.reverse();
            }
            let mut on = std::mem::take(&mut self.branches[other].points);
            if other_end == 1 {
                on.reverse();
            }
            // The centre of a spurious junction is beside the line.
            points.pop();
            points.extend(on.into_iter().skip(1));
            self.branches[one] = Branch {
                ends: Some([first, last]),
                points,
            };
            self.branches[other].ends = None;
            for (node, old, new) in [
                (first, (one, 1 - end), (one, 0)),
                (last, (other, 1 - other_end), (one, 1)),
            ] {
                for end in ends[node].iter_mut().filter(|end| **end == old) {
                    *end = new;
                }
            }
            ends[node].clear();
        }
        self.branches.retain(|branch| !branch.points.is_empty());
    }

    /// Merges the two junctions at a crossing of thick lines.
    fn merge_crossings(&mut self) {
        loop {
            let ends = self.ends();
            let bridge = self.branches.iter().position(|branch| {
                let Some([one, other]) = branch.ends else {
                    return false;
                };
                let radius = self.nodes[one].radius.max(self.nodes[other].radius);
                let junctions = ends[one].len() > 2 && ends[other].len() > 2;
                one != other && junctions && branch.length() < MAX_CROSSING * radius
            });
            let Some(bridge) = bridge else {
                return;
            };
            let Some([one, other]) = self.branches.swap_remove(bridge).ends else {
                return;
            };
            let [from, to] = [self.nodes[one].at, self.nodes[other].at];
            let radius = self.nodes[other].radius;
            self.nodes[one].at = [0, 1].map(|axis| f64::midpoint(from[axis], to[axis]));
            self.nodes[one].radius = self.nodes[one].radius.max(radius);
            let at = self.nodes[one].at;
            for branch in &mut self.branches {
                for (end, node) in branch.ends.iter_mut().flatten().enumerate() {
                    if *node != one && *node != other {
                        continue;
                    }
                    *node = one;
                    let point = match end {
                        0 => branch.points.first_mut(),
                        _ => branch.points.last_mut(),
                    };
                    if let Some(point) = point {
                        *point = at;
                    }
                }
            }
            // Loops between the two junctions are within the crossing.
            let least = MAX_CROSSING * self.nodes[one].radius;
            self.branches
                .retain(|branch| branch.ends != Some([one, one]) || branch.length() > least);
        }
    }
}

/// Direction in which a branch leaves a junction.
struct BranchExit {
    end: End,
    /// Number of points left out.
    cut: usize,
    /// First point that is kept.
    from: Point,
    /// Direction there.
    way: Point,
}

/// Connections at the ends of branches.
struct Joints {
    /// Number of points cut off at the ends of each branch.
    cuts: Vec<[usize; 2]>,
    /// End that each end continues with, if any.
    links: Vec<[Option<End>; 2]>,
    /// Corner point that each end is extended to, if any.
    corners: Vec<[Option<Point>; 2]>,
    /// True for spurious branches.
    dropped: Vec<bool>,
}

impl Joints {
    fn of(graph: &Graph) -> Self {
        let count = graph.branches.len();
        let mut joints = Self {
            cuts: vec![[0; 2]; count],
            links: vec![[None; 2]; count],
            corners: vec![[None; 2]; count],
            dropped: vec![false; count],
        };
        let ends = graph.ends();
        for (node, at_node) in ends.iter().enumerate() {
            match at_node.as_slice() {
                [] | [_] => {}
                [one, other] => joints.link(*one, *other),
                _ => joints.junction(graph, node, &ends),
            }
        }
        joints
    }

    fn link(&mut self, one: End, other: End) {
        self.links[one.0][one.1] = Some(other);
        self.links[other.0][other.1] = Some(one);
    }

    fn junction(&mut self, graph: &Graph, node: usize, ends: &[Vec<End>]) {
        let (middle, radius) = (graph.nodes[node].at, graph.nodes[node].radius);
        let leaving = branch_exits(graph, ends, node);
        if let Some(([tail, one, other], corner)) = corner_at(graph, ends, &leaving) {
            self.dropped[tail.end.0] = true;
            for leaving in [one, other] {
                self.cuts[leaving.end.0][leaving.end.1] = leaving.cut;
                self.corners[leaving.end.0][leaving.end.1] = Some(corner);
            }
            self.link(one.end, other.end);
            return;
        }
        let mut pairs = Vec::new();
        for (nth, one) in leaving.iter().enumerate() {
            for other in leaving.iter().skip(nth + 1) {
                let straight = -(one.way[0] * other.way[0] + one.way[1] * other.way[1]);
                if straight > STRAIGHT_COSINE {
                    pairs.push((straight, one, other));
                }
            }
        }
        pairs.sort_by(|one, other| other.0.total_cmp(&one.0));
        let mut through = Vec::new();
        for (_, one, other) in pairs {
            let is_free = |end: End| self.links[end.0][end.1].is_none();
            if is_free(one.end) && is_free(other.end) {
                self.link(one.end, other.end);
                through.push([one.from, other.from]);
            }
        }
        for leaving in &leaving {
            let (branch, end) = leaving.end;
            self.cuts[branch][end] = leaving.cut;
            if self.links[branch][end].is_none() {
                let meets = through.iter().filter_map(|[from, to]| {
                    let way = [to[0] - from[0], to[1] - from[1]];
                    crossing([*from, way], [leaving.from, leaving.way])
                });
                let near = meets.filter(|at| distance(*at, middle) < 2.0 * radius);
                let nearest = near.min_by(|one, other| {
                    distance(*one, middle).total_cmp(&distance(*other, middle))
                });
                self.corners[branch][end] = Some(nearest.unwrap_or(middle));
            }
        }
    }

    fn strokes(&self, graph: &Graph) -> Vec<Vec<Point>> {
        let count = graph.branches.len();
        let mut done = self.dropped.clone();
        let mut strokes = Vec::new();
        // Open strokes first, then loops.
        let starts = (0..count).flat_map(|branch| [(branch, 0), (branch, 1)]);
        let open = starts.filter(|(branch, end)| self.next((*branch, *end)).is_none());
        let around = (0..count).map(|branch| (branch, 0));
        for start in open.chain(around) {
            if done[start.0] {
                continue;
            }
            let mut points: Vec<Point> = self.corners[start.0][start.1].into_iter().collect();
            let mut at = Some(start);
            let mut closed = false;
            while let Some((branch, end)) = at {
                if done[branch] {
                    closed = (branch, end) == start;
                    break;
                }
                done[branch] = true;
                points.extend(self.points_of(graph, (branch, end)));
                points.extend(self.corners[branch][1 - end]);
                at = self.next((branch, 1 - end));
            }
            points.dedup();
            if closed && points.first() != points.last() {
                points.extend(points.first().copied());
            }
            strokes.push(points);
        }
        strokes
    }

    fn next(&self, (branch, end): End) -> Option<End> {
        self.links[branch][end].filter(|(next, _)| !self.dropped[*next])
    }

    /// Points of a branch from one of its ends on, without those cut off.
    fn points_of(&self, graph: &Graph, (branch, end): End) -> Vec<Point> {
        let points = &graph.branches[branch].points;
        let [first, last] = self.cuts[branch];
        let kept = points.get(first..points.len().saturating_sub(last));
        let mut kept = kept.unwrap_or_default().to_vec();
        if end == 1 {
            kept.reverse();
        }
        kept
    }
}

fn branch_exit(graph: &Graph, end: End, middle: Point, radius: f64) -> BranchExit {
    let branch = &graph.branches[end.0];
    let mut points = branch.points.clone();
    if end.1 == 1 {
        points.reverse();
    }
    let most = (points.len() as f64 * MAX_CUT_SHARE) as usize;
    let beyond = |far: f64| points.iter().position(|at| distance(*at, middle) >= far);
    let cut = beyond(SMEARED_RADIUS * radius).unwrap_or(most).min(most);
    let look = beyond((SMEARED_RADIUS + DIRECTION_SPAN) * radius).unwrap_or(points.len() - 1);
    let from = points.get(cut).copied().unwrap_or(middle);
    let to = points.get(look.max(cut + 1));
    let to = to.or(points.last()).copied().unwrap_or(middle);
    // A branch of a single remaining point has its direction from the junction.
    let (from_way, to) = if distance(from, to) > 1e-9 {
        (from, to)
    } else {
        (middle, from)
    };
    let length = distance(from_way, to).max(1e-9);
    BranchExit {
        end,
        cut,
        from,
        way: [0, 1].map(|axis| (to[axis] - from_way[axis]) / length),
    }
}

fn branch_exits(graph: &Graph, ends: &[Vec<End>], node: usize) -> Vec<BranchExit> {
    let (middle, radius) = (graph.nodes[node].at, graph.nodes[node].radius);
    let ends = ends[node].iter();
    ends.map(|end| branch_exit(graph, *end, middle, radius))
        .collect()
}

/// Corner at which two of three branches meet, if the third (returned first) is the tail of it:
/// short, with a free end, and towards the intersection of the other two.
fn corner_at<'l>(
    graph: &Graph,
    ends: &[Vec<End>],
    leaving: &'l [BranchExit],
) -> Option<([&'l BranchExit; 3], Point)> {
    let [one, two, three] = leaving else {
        return None;
    };
    let turns = [[one, two, three], [two, three, one], [three, one, two]];
    turns.into_iter().find_map(|turn| {
        let [tail, one, other] = turn;
        let branch = &graph.branches[tail.end.0];
        let nodes = branch.ends?;
        let [node, far] = [nodes[tail.end.1], nodes[1 - tail.end.1]].map(|node| &graph.nodes[node]);
        let free = ends[nodes[1 - tail.end.1]].len() == 1;
        let radius = node.radius;
        if !free || branch.length() > MAX_TAIL * radius || one.end.0 == other.end.0 {
            return None;
        }
        let dot = |[a, b]: Point, [c, d]: Point| a * c + b * d;
        let between = |from: Point, to: Point| [to[0] - from[0], to[1] - from[1]];
        let meet = crossing([one.from, one.way], [other.from, other.way])?;
        let ahead = |leaving: &BranchExit| dot(between(leaving.from, meet), leaving.way) < 0.0;
        let (out, tail_way) = (between(node.at, meet), between(node.at, far.at));
        let lengths = libm::hypot(out[0], out[1]) * libm::hypot(tail_way[0], tail_way[1]);
        let is_corner = ahead(one)
            && ahead(other)
            && dot(one.way, other.way) > SHARP_COSINE
            && dot(out, tail_way) > STRAIGHT_COSINE * lengths
            && distance(meet, far.at) < MAX_CORNER_DISTANCE * radius;
        is_corner.then_some((turn, meet))
    })
}

/// Intersection of two infinite lines, each given by a point and a direction. `None` if they are
/// nearly parallel.
fn crossing([from, way]: [Point; 2], [other, along]: [Point; 2]) -> Option<Point> {
    let turn = way[0] * along[1] - way[1] * along[0];
    let length = libm::hypot(way[0], way[1]) * libm::hypot(along[0], along[1]);
    if turn.abs() <= 0.05 * length {
        return None;
    }
    let between = [other[0] - from[0], other[1] - from[1]];
    let share = (between[0] * along[1] - between[1] * along[0]) / turn;
    Some([0, 1].map(|axis| from[axis] + share * way[axis]))
}
