//! The path of a plan's tool as values: what pictures of it and others show.
//!
//! [`Toolpath`] is all of it, sorted by what it leaves; [`Outline`] the lines that are left, as few
//! points as are asked for; [`DrawnLine`] the same step by step.

mod drawn_line;
mod markers;
mod outline;
mod purpose;
mod tracer;
mod track;

use magician_host::preflight::Preflight;

pub use drawn_line::DrawnLine;
pub use markers::{Marker, MarkerKind};
pub use outline::Outline;
pub use purpose::PlanPurpose;
use tracer::PathTracer;
pub use track::Track;

use crate::{Color, Plan, Report};

/// As coarse a picture may become to stay a picture, mm.
const COARSEST: f64 = 0.2;
/// From so many corners on it becomes coarser.
const MANY: usize = 150_000;
/// Number of laser powers that are told apart.
pub const SHADES: usize = 10;
/// Largest number of refused steps that are marked.
pub const MOST_REFUSED: usize = 3;

/// What a part of the path leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StrokeKind {
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
pub struct Layer {
    /// What they leave.
    pub leaves: StrokeKind,
    /// X and y, mm.
    pub above: Track,
    /// Distance from the base axis and z, mm; empty without a view from the side.
    pub side: Track,
}

/// The path of the tool through a plan.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Toolpath {
    /// Its lines, by what they leave.
    pub layers: Vec<Layer>,
    /// Places at which something happens.
    pub markers: Vec<Marker>,
    /// Its first and last place; `None` if they are unknown.
    pub ends: Option<[[f64; 3]; 2]>,
    /// The first refused steps and their places, [`MOST_REFUSED`] at most.
    pub refused_steps: Vec<(usize, Option<[f64; 3]>)>,
    /// Length of what leaves something, mm.
    pub drawn: f64,
    /// Length of the rest, mm.
    pub other: f64,
    /// The least and the greatest corner of what is left, mm; `None` if nothing is.
    pub bounds: Option<[[f64; 2]; 2]>,
    /// What the plan is for.
    pub purpose: PlanPurpose,
    /// True if it has lines from the side.
    pub has_side: bool,
}

impl Toolpath {
    /// Follows a plan from where the arm stands: with a view from the side or without; if `side`
    /// does not say, with one for plans that pick and place.
    #[must_use]
    pub fn through(plan: &Plan, report: &Report, start: &Preflight, side: Option<bool>) -> Self {
        let mut tracer = PathTracer::from(plan, report, start, side);
        tracer.through(plan);
        tracer.finish(plan.steps.len())
    }

    /// Makes it coarser than this, as long as it has too many corners.
    fn thin(&mut self, mut tolerance: f64) {
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
