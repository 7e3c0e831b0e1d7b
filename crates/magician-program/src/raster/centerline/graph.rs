//! Graph of a skeleton: nodes, and branches between them.

use super::thin::Mask;
use crate::artwork::distance;

/// End or junction of branches.
#[derive(Clone, Debug)]
pub(super) struct Node {
    /// Position, in pixels of the image.
    pub(super) at: [f64; 2],
    /// Half the thickness of the line at the node, pixels.
    pub(super) thick: f64,
    /// Half the thickness, clamped to what a line can have.
    pub(super) radius: f64,
}

/// Line between two nodes, or a loop.
#[derive(Clone, Debug)]
pub(super) struct Branch {
    /// Nodes at the ends; `None` for a loop without a node.
    pub(super) ends: Option<[usize; 2]>,
    pub(super) points: Vec<[f64; 2]>,
}

impl Branch {
    pub(super) fn length(&self) -> f64 {
        let pairs = self.points.windows(2);
        pairs.map(|pair| distance(pair[0], pair[1])).sum()
    }
}

#[derive(Clone, Debug, Default)]
pub(super) struct Graph {
    pub(super) nodes: Vec<Node>,
    pub(super) branches: Vec<Branch>,
    /// Spots without branches.
    pub(super) dots: Vec<[f64; 2]>,
}

/// Marker: the pixel belongs to no node.
const NO_NODE: u32 = u32::MAX;

impl Graph {
    /// Creates the graph of lines at most `line` pixels in half thickness; thicker shapes are
    /// areas.
    pub(super) fn of(skeleton: &Mask, thickness: &[u16], line: f64) -> Self {
        let tracer = Tracer {
            skeleton,
            thickness,
            line,
            node_of: vec![NO_NODE; skeleton.dark.len()],
            passed: vec![false; skeleton.dark.len()],
            graph: Self::default(),
        };
        tracer.graph()
    }
}

struct Tracer<'m> {
    skeleton: &'m Mask,
    thickness: &'m [u16],
    line: f64,
    node_of: Vec<u32>,
    passed: Vec<bool>,
    graph: Graph,
}

impl Tracer<'_> {
    fn graph(mut self) -> Graph {
        let dark = (0..self.skeleton.dark.len()).filter(|at| self.skeleton.dark[*at]);
        let dark: Vec<usize> = dark.collect();
        for at in dark.iter().copied() {
            match self.neighbours(at).count() {
                0 => self.graph.dots.push(self.place(at)),
                2 => {}
                _ if self.node_of[at] == NO_NODE => self.node(at),
                _ => {}
            }
        }
        for at in dark.iter().copied() {
            if self.node_of[at] != NO_NODE {
                let near: Vec<usize> = self.neighbours(at).collect();
                near.into_iter().for_each(|next| self.branch(at, next));
            }
        }
        let ends = self.graph.branches.iter().filter_map(|branch| branch.ends);
        let used: std::collections::HashSet<usize> = ends.flatten().collect();
        let alone = self.graph.nodes.iter().enumerate();
        let alone = alone.filter(|(node, _)| !used.contains(node));
        let alone: Vec<_> = alone.map(|(_, node)| node.at).collect();
        self.graph.dots.extend(alone);
        // Remaining pixels form loops without nodes.
        for at in dark {
            if self.neighbours(at).count() == 2 && !self.passed[at] {
                self.ring(at);
            }
        }
        self.graph
    }

    fn neighbours(&self, at: usize) -> impl Iterator<Item = usize> + use<'_> {
        let around = self.skeleton.neighbours(at).into_iter();
        around.filter(|near| self.skeleton.dark[*near])
    }

    fn place(&self, at: usize) -> [f64; 2] {
        let stride = self.skeleton.stride;
        [(at % stride) as f64 - 0.5, (at / stride) as f64 - 0.5]
    }

    /// Creates a node from an end pixel, or from all pixels of a junction.
    fn node(&mut self, first: usize) {
        let nth = self.graph.nodes.len() as u32;
        self.node_of[first] = nth;
        let mut group = vec![first];
        let mut next = 0;
        while let Some(at) = group.get(next).copied() {
            next += 1;
            if self.neighbours(first).count() < 3 {
                break;
            }
            let near: Vec<usize> = self.neighbours(at).collect();
            for near in near {
                if self.node_of[near] == NO_NODE && self.neighbours(near).count() > 2 {
                    self.node_of[near] = nth;
                    group.push(near);
                }
            }
        }
        let places = group.iter().map(|at| self.place(*at));
        let sum = places.fold([0.0; 2], |sum, at| [sum[0] + at[0], sum[1] + at[1]]);
        let thick = group.iter().map(|at| self.thickness[*at]).max();
        let thick = f64::from(thick.unwrap_or(1)).max(1.0);
        self.graph.nodes.push(Node {
            at: sum.map(|sum| sum / group.len() as f64),
            thick,
            radius: thick.min(self.line),
        });
    }

    /// Follows a branch from a node's pixel through `next` to the next node.
    fn branch(&mut self, from: usize, next: usize) {
        let first = self.node_of[from];
        // Skip pixels of the same node, and branches already followed.
        if self.node_of[next] == first || self.passed[next] {
            return;
        }
        let mut points = vec![self.graph.nodes[first as usize].at];
        let (mut last, mut at) = (from, next);
        while self.node_of[at] == NO_NODE {
            self.passed[at] = true;
            points.push(self.place(at));
            let onward = |near: &usize| *near != last && !self.passed[*near];
            let nodes = |near: &usize| self.node_of[*near] != NO_NODE;
            // Return to the starting node only if there is no other way on.
            let on = self.neighbours(at).filter(onward);
            let on = on.max_by_key(|near| u8::from(nodes(near) && self.node_of[*near] != first));
            let Some(on) = on else {
                break;
            };
            (last, at) = (at, on);
        }
        let to = self.node_of[at];
        if to == NO_NODE {
            return;
        }
        // Adjacent nodes are found from both sides: keep one.
        if points.len() == 1 && to < first {
            return;
        }
        points.push(self.graph.nodes[to as usize].at);
        self.graph.branches.push(Branch {
            ends: Some([first as usize, to as usize]),
            points,
        });
    }

    fn ring(&mut self, first: usize) {
        let mut points = Vec::new();
        let mut at = Some(first);
        while let Some(here) = at {
            self.passed[here] = true;
            points.push(self.place(here));
            let next = self.neighbours(here).find(|near| !self.passed[*near]);
            at = next;
        }
        points.push(self.place(first));
        self.graph.branches.push(Branch { ends: None, points });
    }
}
