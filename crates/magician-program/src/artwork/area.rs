//! Where on a surface the tool can be, and where a drawing finds room there.

use magician_motion::{Geometry, JointAngles, Limits, MotionError, Pose, ToolBias};

use super::distance;
use crate::Surface;

/// Distance of the grid on which reach is remembered, mm.
const CELL: f64 = 2.0;
/// Nothing beyond is ever reached by a tool of reasonable length, mm from the base axis.
const FARTHEST: f64 = 600.0;
/// Places for the middle of a drawing are tried on a grid of this distance, mm.
const STEP: f64 = 6.0;
/// Between two points a line is looked at each so many mm.
const BETWEEN: f64 = 4.0;

/// A surface under an arm, as far as the arm reaches with a tool: down to it, and so far above it.
#[derive(Clone, Debug)]
pub(crate) struct Area {
    geometry: Geometry,
    surface: Surface,
    lift: f64,
}

impl Area {
    pub(crate) fn new(tool: ToolBias, surface: Surface, lift: f64) -> Self {
        let geometry = Geometry::magician(tool);
        Self {
            geometry,
            surface,
            lift,
        }
    }

    /// The joints that bring the tool so far above a point of the surface, J4 at zero.
    pub(crate) fn joints(&self, at: [f64; 2], above: f64) -> Result<JointAngles, MotionError> {
        let [x, y] = at;
        let pose = |r| Pose::new(x, y, self.surface.at(at) + above, r);
        let turned = self.geometry.inverse(&pose(0.0))?;
        (self.geometry).inverse_within(&pose(turned.j1), &Limits::CONTROLLER)
    }

    /// Why a point cannot be worked on.
    pub(crate) fn refusal(&self, at: [f64; 2]) -> Option<MotionError> {
        let down = self.joints(at, 0.0).err();
        down.or_else(|| self.joints(at, self.lift).err())
    }

    pub(crate) fn reaches(&self, at: [f64; 2]) -> bool {
        self.refusal(at).is_none()
    }

    /// Whether the tool gets from one point to another on a straight line so far above the surface; both ends are known
    /// to be reached.
    pub(crate) fn leads(&self, from: [f64; 2], to: [f64; 2], above: f64) -> bool {
        // In front of the base only the hole around it can be in the way; beside and behind it is the stop of J1, too.
        let mut between = match from[0] > 0.0 && to[0] > 0.0 {
            true => vec![nearest_to_base(from, to)],
            false => samples(from, to).collect(),
        };
        between.retain(|point| *point != from && *point != to);
        between.iter().all(|at| self.joints(*at, above).is_ok())
    }

    /// How far out and how far in straight ahead is reached, mm.
    pub(crate) fn depth(&self) -> Option<[f64; 2]> {
        let mut ahead = (0..FARTHEST as u32)
            .map(f64::from)
            .filter(|x| self.reaches([*x, 0.0]));
        let first = ahead.next()?;
        Some([first, ahead.next_back().unwrap_or(first)])
    }

    /// Where the middle of a drawing goes best: the place nearest to the middle of what is reached straight ahead where all of
    /// it is reached. The drawing is given by points with its middle at the origin.
    pub(crate) fn best_place(&self, shape: &Shape, scale: f64) -> Option<[f64; 2]> {
        let [near, far] = self.depth()?;
        let middle = [f64::midpoint(near, far), 0.0];
        let count = (FARTHEST / STEP) as i32;
        let grid = |nth: i32| f64::from(nth) * STEP;
        let mut places: Vec<[f64; 2]> = (-count..=count)
            .flat_map(|i| (-count..=count).map(move |j| (i, j)))
            .map(|(i, j)| [middle[0] + grid(i), grid(j)])
            .filter(|place| place[0].hypot(place[1]) < FARTHEST)
            .collect();
        places.sort_by(|one, other| distance(*one, middle).total_cmp(&distance(*other, middle)));
        let mut known = Known::new(self);
        places.into_iter().find(|at| {
            let put = |point: &[f64; 2]| [at[0] + scale * point[0], at[1] + scale * point[1]];
            shape.coarse.iter().all(|point| known.reaches(put(point)))
                && shape.is_within(self, *at, scale)
        })
    }
}

/// The points that decide whether a drawing is within reach, around its middle.
pub(crate) struct Shape {
    /// Few, to look for a place.
    coarse: Vec<[f64; 2]>,
    /// All, to be sure of it.
    fine: Vec<[f64; 2]>,
}

impl Shape {
    /// Of lines, each from point to point.
    pub(crate) fn of<'a>(lines: impl Iterator<Item = &'a [[f64; 2]]>) -> Self {
        let mut fine = Vec::new();
        for line in lines {
            fine.extend(line.first());
            for (from, to) in line.iter().zip(line.iter().skip(1)) {
                fine.extend(samples(*from, *to));
            }
        }
        // One of each cell.
        let mut cells = std::collections::HashSet::new();
        let mut coarse = fine.clone();
        coarse.retain(|point| cells.insert(point.map(|value| (value / CELL) as i64)));
        // What is farthest out is refused first.
        coarse
            .sort_by(|one, other| distance(*other, [0.0; 2]).total_cmp(&distance(*one, [0.0; 2])));
        Self { coarse, fine }
    }

    /// Whether all of it is reached with its middle there.
    pub(crate) fn is_within(&self, area: &Area, at: [f64; 2], scale: f64) -> bool {
        let put = |point: &[f64; 2]| [at[0] + scale * point[0], at[1] + scale * point[1]];
        self.fine.iter().all(|point| area.reaches(put(point)))
    }
}

/// Reach on a grid, looked up once.
struct Known<'a> {
    area: &'a Area,
    across: usize,
    nodes: Vec<Option<bool>>,
}

impl<'a> Known<'a> {
    fn new(area: &'a Area) -> Self {
        let across = (2.0 * FARTHEST / CELL) as usize + 2;
        let nodes = vec![None; across * across];
        Self {
            area,
            across,
            nodes,
        }
    }

    /// All four corners of the cell.
    fn reaches(&mut self, at: [f64; 2]) -> bool {
        let [i, j] = at.map(|value| ((value + FARTHEST) / CELL).floor());
        let (i, j) = (i as usize, j as usize);
        self.node(i, j) && self.node(i + 1, j) && self.node(i, j + 1) && self.node(i + 1, j + 1)
    }

    fn node(&mut self, i: usize, j: usize) -> bool {
        if i >= self.across || j >= self.across {
            return false;
        }
        let place = |nth: usize| nth as f64 * CELL - FARTHEST;
        let area = self.area;
        self.nodes
            .get_mut(i * self.across + j)
            .is_some_and(|node| *node.get_or_insert_with(|| area.reaches([place(i), place(j)])))
    }
}

/// The other end of a line, what is nearest to the base on it, and points between.
fn samples(from: [f64; 2], to: [f64; 2]) -> impl Iterator<Item = [f64; 2]> {
    let pieces = (distance(from, to) / BETWEEN).ceil().clamp(1.0, 1000.0) as u32;
    (1..=pieces).map(move |nth| mix(from, to, f64::from(nth) / f64::from(pieces)))
}

fn nearest_to_base(from: [f64; 2], to: [f64; 2]) -> [f64; 2] {
    let way = [to[0] - from[0], to[1] - from[1]];
    let square = way[0] * way[0] + way[1] * way[1];
    if square == 0.0 {
        return from;
    }
    let share = -(from[0] * way[0] + from[1] * way[1]) / square;
    mix(from, to, share.clamp(0.0, 1.0))
}

fn mix(from: [f64; 2], to: [f64; 2], share: f64) -> [f64; 2] {
    let between = |axis: usize| from[axis] + share * (to[axis] - from[axis]);
    match share {
        1.0 => to,
        _ => [between(0), between(1)],
    }
}
