//! Outlines of the dark areas of an image.
//!
//! Marching squares on the grey values: a contour crosses the edge between two pixels where the
//! interpolated grey equals the level, so it is exact to a fraction of a pixel.

use super::{Raster, Trace};
use crate::{Origin, Stroke};
use magician_formats::simplify::simplified;

/// Largest side in pixels that is processed; a larger image is reduced first.
const MAX_SIDE: usize = 2000;

/// Returns the outlines of dark areas as closed lines, and the number of specks left out.
pub(super) fn strokes(image: &Raster, page: [f64; 2], trace: &Trace) -> (Vec<Stroke>, usize) {
    let small = super::trace::reduced(image, page, 0.0, MAX_SIDE);
    let (width, height) = (small.width, small.height);
    let nodes = Nodes {
        grey: small.grey,
        width,
        height,
        level: trace.level,
    };
    let pixel = [page[0] / width as f64, page[1] / height as f64];
    let mut strokes = Vec::new();
    let mut specks = 0;
    for outline in nodes.outlines() {
        let first_row = outline.first().map_or(0.0, |[_, y]| *y);
        let points: Vec<_> = outline
            .into_iter()
            .map(|[x, y]| [x * pixel[0], page[1] - y * pixel[1]])
            .collect();
        if longer_side(&points) < trace.despeckle {
            specks += 1;
            continue;
        }
        let row = (first_row * image.height as f64 / height as f64) as u32;
        let stroke = Stroke {
            points: simplified(&points, trace.tolerance),
            origin: Origin {
                line: row.saturating_add(1).min(image.height as u32),
                ..Origin::NONE
            },
            style: crate::artwork::Style::default(),
        };
        if stroke.is_closed() {
            strokes.push(stroke);
        }
    }
    (strokes, specks)
}

/// Longer side of the bounding box of points.
fn longer_side(points: &[[f64; 2]]) -> f64 {
    let side = |axis: usize| {
        let along = || points.iter().map(|point| point[axis]);
        along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
    };
    side(0).max(side(1))
}

/// Grid of grey values at the pixel centres, surrounded by a white border. Outlines cross the edges
/// between a dark and a light neighbour (marching squares).
struct Nodes {
    grey: Vec<u8>,
    width: usize,
    height: usize,
    level: u8,
}

/// Marker: no outline leaves through this edge.
const NO_EDGE: u32 = u32::MAX;

impl Nodes {
    /// Outlines in pixels from the upper left corner; each ends where it begins.
    fn outlines(&self) -> Vec<Vec<[f64; 2]>> {
        let mut next = self.crossings();
        let mut outlines = Vec::new();
        for start in 0..next.len() {
            let mut outline = Vec::new();
            let mut at = start;
            while let Some(to) = next.get_mut(at).filter(|to| **to != NO_EDGE) {
                outline.push(self.crossing(at));
                at = std::mem::replace(to, NO_EDGE) as usize;
            }
            if !outline.is_empty() {
                outline.push(self.crossing(at));
                outlines.push(outline);
            }
        }
        outlines
    }

    /// Nodes in a row, border included.
    fn stride(&self) -> usize {
        self.width + 2
    }

    fn grey_at(&self, [x, y]: [usize; 2]) -> u8 {
        let (Some(x), Some(y)) = (x.checked_sub(1), y.checked_sub(1)) else {
            return 255;
        };
        if x >= self.width {
            return 255;
        }
        self.grey.get(y * self.width + x).copied().unwrap_or(255)
    }

    fn is_dark(&self, node: [usize; 2]) -> bool {
        self.grey_at(node) < self.level
    }

    /// For each edge through which an outline enters a square of four nodes, the edge through which
    /// it leaves. The index of an edge is twice the index of its first node (left or upper), plus
    /// one for an edge that leads down.
    fn crossings(&self) -> Vec<u32> {
        let mut next = vec![NO_EDGE; 2 * self.stride() * (self.height + 2)];
        for y in 0..=self.height {
            for x in 0..=self.width {
                let nodes = [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]];
                let dark = nodes.map(|node| self.is_dark(node));
                if dark == [true; 4] || dark == [false; 4] {
                    continue;
                }
                let first = 2 * (y * self.stride() + x);
                let below = first + 2 * self.stride();
                let edges = [first, first + 3, below, first + 1];
                for (from, to) in self.pairs(nodes, dark) {
                    if let Some(slot) = next.get_mut(edges[from]) {
                        *slot = u32::try_from(edges[to]).unwrap_or(NO_EDGE);
                    }
                }
            }
        }
        next
    }

    /// Pairs of edges of a square that an outline connects. Clockwise around the square, the
    /// outline enters through an edge where dark ends, and leaves through an edge where dark
    /// begins. If two outlines cross the square (a saddle), the mean grey decides: a dark centre
    /// connects the dark corners, so the outline leaves through the next edge clockwise, else
    /// through the previous.
    fn pairs(
        &self,
        nodes: [[usize; 2]; 4],
        dark: [bool; 4],
    ) -> impl Iterator<Item = (usize, usize)> {
        let sum: u32 = nodes
            .iter()
            .map(|node| u32::from(self.grey_at(*node)))
            .sum();
        let step = if sum < 4 * u32::from(self.level) {
            1
        } else {
            3
        };
        let ends = move |edge: usize| dark[edge] && !dark[(edge + 1) % 4];
        let begins = move |edge: usize| !dark[edge] && dark[(edge + 1) % 4];
        (0..4)
            .filter(move |edge| ends(*edge))
            .filter_map(move |from| {
                let mut around = (1..4).map(move |steps| (from + steps * step) % 4);
                around.find(|edge| begins(*edge)).map(|to| (from, to))
            })
    }

    /// Crossing of an outline and an edge, in pixels.
    fn crossing(&self, edge: usize) -> [f64; 2] {
        let node = [edge / 2 % self.stride(), edge / 2 / self.stride()];
        let other = match edge % 2 {
            0 => [node[0] + 1, node[1]],
            _ => [node[0], node[1] + 1],
        };
        let [one, next] = [node, other].map(|node| f64::from(self.grey_at(node)));
        // The threshold lies between two grey levels, so that no crossing is at a node.
        let share = (f64::from(self.level) - 0.5 - one) / (next - one);
        let size = [self.width, self.height].map(|side| side as f64);
        [0, 1].map(|axis| {
            let way = (other[axis] - node[axis]) as f64;
            (node[axis] as f64 - 0.5 + way * share).clamp(0.0, size[axis])
        })
    }
}
