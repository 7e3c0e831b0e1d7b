//! The tool's path through a plan, sorted by what it leaves.

use magician_host::words::Preflight;

use super::markers::Marker;
use super::purpose::PlanPurpose;
use super::tracer::PathTracer;
use super::track::Track;
use crate::{Color, Plan, Report};

/// As coarse a picture may become to stay a picture, mm.
const COARSEST: f64 = 0.2;
/// From so many corners on it becomes coarser.
const MANY: usize = 150_000;
/// Powers of the laser that are told apart.
pub(super) const SHADES: usize = 10;
/// Refused steps that are marked.
pub(super) const MOST_REFUSED: usize = 3;

/// What a part of the way leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum StrokeKind {
    /// Nothing.
    Nothing,
    /// Nothing, and the tool holds something.
    Carried,
    /// A pen's line, in its colour or that of its part if it has one.
    Ink(Option<Color>),
    /// A burnt line, by how dark it is: 1 to [`SHADES`].
    Burn(usize),
    /// Nothing: the arm does not come there.
    Unreachable,
}

impl StrokeKind {
    /// How dark it is, percent: the power of a laser, 100 of everything else.
    pub(super) fn power(self) -> u8 {
        match self {
            Self::Burn(shade) => (100 * shade / SHADES) as u8,
            _ => 100,
        }
    }
}

/// Lines that look the same, seen from above and from the side (distance from the base axis and z).
#[derive(Clone, Debug)]
pub(super) struct Layer {
    pub(super) leaves: StrokeKind,
    pub(super) above: Track,
    pub(super) side: Track,
}

/// The path of the tool through a plan.
#[derive(Clone, Debug)]
pub(super) struct Toolpath {
    pub(super) layers: Vec<Layer>,
    pub(super) markers: Vec<Marker>,
    /// Where it begins and ends, where that is known.
    pub(super) ends: Option<[[f64; 3]; 2]>,
    /// Where the first refused steps are.
    pub(super) refused_steps: Vec<(usize, Option<[f64; 3]>)>,
    /// How long the way is that leaves something, mm, and the other.
    pub(super) drawn: f64,
    pub(super) other: f64,
    /// The least and the greatest corner of what is left.
    pub(super) bounds: Option<[[f64; 2]; 2]>,
    /// What it is for.
    pub(super) purpose: PlanPurpose,
    /// Whether it is shown from the side.
    pub(super) has_side: bool,
}

impl Toolpath {
    /// Goes through a plan.
    pub(super) fn through(
        plan: &Plan,
        report: &Report,
        start: &Preflight,
        side: Option<bool>,
    ) -> Self {
        let mut tracer = PathTracer::from(plan, report, start, side);
        tracer.through(plan);
        tracer.finish(plan.steps.len())
    }
}

impl Toolpath {
    /// Makes it coarser than this, as long as it has too many corners.
    pub(super) fn thin(&mut self, mut tolerance: f64) {
        while self.corners() > MANY && tolerance < COARSEST {
            tolerance *= 2.0;
            for layer in &mut self.layers {
                layer.above = layer.above.thinned(tolerance);
                layer.side = layer.side.thinned(tolerance);
            }
        }
    }

    fn corners(&self) -> usize {
        let layers = self.layers.iter();
        layers
            .map(|layer| layer.above.len() + layer.side.len())
            .sum()
    }
}
