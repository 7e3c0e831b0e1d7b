//! Purpose of a plan, which decides the marks its motion leaves.

use super::{POWER_SHADES, StrokeKind};
use crate::rehearse::{RehearseOptions, tool_kind, tool_of};
use crate::{Plan, Surface, Tool};

/// Height above the surface that still counts as on it, mm.
const SURFACE_TOLERANCE: f64 = 0.05;

/// Purpose of a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlanPurpose {
    /// A pen draws on a surface.
    Draws(Option<Surface>),
    /// A laser burns wherever it is on.
    Burns(Option<Surface>),
    /// Something is carried; the value is the lowest stop, mm.
    Carries(Option<f64>),
}

impl PlanPurpose {
    /// Determines the purpose of a plan from its tool, or from its steps if it has no tool.
    pub(super) fn of(plan: &Plan) -> Self {
        let lowest = || {
            let steps = plan.steps.iter().map(|step| &step.action);
            let heights = steps.filter_map(|action| Some(f64::from(action.target()?[2])));
            heights.filter(|z| z.is_finite()).reduce(f64::min)
        };
        let tool = tool_kind(plan, tool_of(plan, &RehearseOptions::default()));
        match tool {
            // Without a surface it burns at the height of its targets.
            Tool::Laser => Self::Burns(plan.surface.or_else(|| lowest().map(Surface::level))),
            Tool::Suction | Tool::Gripper => Self::Carries(lowest()),
            Tool::None | Tool::Pen | Tool::Bias(_) => match plan.drawn_on() {
                None => Self::Carries(lowest()),
                surface => Self::Draws(surface),
            },
            #[cfg(not(magician_workspace))]
            _ => unreachable!(),
        }
    }

    /// Mark left by a straight motion.
    pub(super) fn mark(&self, ends: [[f64; 3]; 2], power: Option<f64>, holds: bool) -> StrokeKind {
        let power = power.unwrap_or(0.0);
        if power > 0.0 {
            // The conversion from float saturates.
            let shade = (power / 100.0 * POWER_SHADES as f64).ceil() as usize;
            return StrokeKind::Burn(shade.clamp(1, POWER_SHADES));
        }
        match self {
            Self::Draws(Some(surface)) => {
                let down = |[x, y, z]: [f64; 3]| z <= surface.at([x, y]) + SURFACE_TOLERANCE;
                if ends.into_iter().all(down) {
                    StrokeKind::Ink(None)
                } else {
                    StrokeKind::Nothing
                }
            }
            _ if holds => StrokeKind::Carried,
            _ => StrokeKind::Nothing,
        }
    }

    /// True if heights matter.
    pub(super) fn is_deep(&self) -> bool {
        matches!(self, Self::Carries(_))
    }

    /// Surface on which the tool draws or burns.
    #[must_use]
    pub fn surface(&self) -> Option<Surface> {
        match self {
            Self::Draws(surface) | Self::Burns(surface) => *surface,
            Self::Carries(lowest) => lowest.map(Surface::level),
        }
    }
}
