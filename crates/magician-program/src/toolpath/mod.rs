//! Path of a plan's tool as values, for previews and other displays.
//!
//! [`Toolpath`] has all motion, sorted by the marks it leaves. [`Outline`] has the drawn lines with
//! a limited number of points, [`DrawnLine`] the same by step.

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

/// Largest tolerance of a picture, mm: larger deviations would be visible.
const MAX_TOLERANCE: f64 = 0.2;
/// Number of corners from which the tolerance is increased. Bounds the size of pictures.
const MAX_CORNERS: usize = 150_000;
/// Number of distinguished laser powers.
pub const POWER_SHADES: usize = 10;
/// Largest number of marked refused steps.
pub const MAX_MARKED_REFUSALS: usize = 3;

/// Mark left by a part of the path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StrokeKind {
    /// No mark.
    Nothing,
    /// No mark; the tool carries something.
    Carried,
    /// Pen line, in its own colour or that of its part, if any.
    Ink(Option<Color>),
    /// Burnt line, by darkness: 1 to [`POWER_SHADES`].
    Burn(usize),
    /// No mark: out of reach.
    Unreachable,
}

impl StrokeKind {
    /// Darkness in percent: the power of a laser, 100 for everything else.
    pub(super) fn power(self) -> u8 {
        match self {
            Self::Burn(shade) => (100 * shade / POWER_SHADES) as u8,
            _ => 100,
        }
    }
}

/// Lines with the same look, from above and from the side (distance from the base axis, and z).
#[derive(Clone, Debug)]
pub struct Layer {
    /// Mark that they leave.
    pub mark: StrokeKind,
    /// View from above: x and y, mm.
    pub above: Track,
    /// View from the side: distance from the base axis and z, mm; empty without that view.
    pub side: Track,
}

/// Path of the tool through a plan.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Toolpath {
    /// Lines by the mark they leave.
    pub layers: Vec<Layer>,
    /// Places with events.
    pub markers: Vec<Marker>,
    /// First and last position; `None` if unknown.
    pub ends: Option<[[f64; 3]; 2]>,
    /// First refused steps with their positions, at most [`MAX_MARKED_REFUSALS`].
    pub refused_steps: Vec<(usize, Option<[f64; 3]>)>,
    /// Length of marks, mm.
    pub drawn: f64,
    /// Length of other motion, mm.
    pub other: f64,
    /// Bounds of the marks, mm; `None` without marks.
    pub bounds: Option<[[f64; 2]; 2]>,
    /// Purpose of the plan.
    pub purpose: PlanPurpose,
    /// True if there is a view from the side.
    pub has_side: bool,
}

impl Toolpath {
    /// Follows a plan from this state of the arm. `side` selects the view from the side; `None`
    /// shows it for plans that pick and place.
    #[must_use]
    pub fn trace(plan: &Plan, report: &Report, start: &Preflight, side: Option<bool>) -> Self {
        let mut tracer = PathTracer::from(plan, report, start, side);
        tracer.trace(plan);
        tracer.finish(plan.steps.len())
    }

    /// Increases the tolerance while there are too many corners.
    fn thin(&mut self, mut tolerance: f64) {
        while self.corners() > MAX_CORNERS && tolerance < MAX_TOLERANCE {
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
