//! Whether the tool leaves a line.

use magician_host::{ArmState, PtpMove, Set};

use crate::rehearse::{RehearseOptions, kind_of, tool_of};
use crate::{Plan, Surface, Tool};

/// So far above the surface a pen still draws, mm.
const TOUCH: f64 = 0.5;

pub(super) struct Pen {
    /// It is a laser: it must be lit.
    laser: bool,
    /// It was switched on.
    lit: bool,
    surface: Option<Surface>,
}

impl Pen {
    pub(super) fn of(plan: &Plan) -> Self {
        Self {
            laser: plan.tool == Some(Tool::Laser)
                || plan.steps.iter().any(|step| step.action.is_of_a_laser()),
            lit: false,
            surface: match kind_of(plan, tool_of(plan, &RehearseOptions::default())) {
                Tool::Suction | Tool::Gripper => plan.surface,
                _ => plan.drawn_on(),
            },
        }
    }

    pub(super) fn note(&mut self, command: &Set) {
        if let Set::SetEndEffectorLaser(laser) = command {
            self.lit = laser.enable_ctrl.is_on() && laser.on.is_on();
        }
    }

    /// Whether the laser was switched on, with all its power.
    pub(super) fn is_lit(&self) -> bool {
        self.lit
    }

    /// Whether a command draws or burns on its way.
    pub(super) fn draws(&self, command: &Set, from: &ArmState, to: &ArmState) -> bool {
        let touches = |surface: Surface| {
            let on = |at: &ArmState| at.pose.z - surface.at([at.pose.x, at.pose.y]) <= TOUCH;
            on(from) && on(to)
        };
        match command {
            Set::CpLeCmd(segment) if self.laser => self.lit || segment.velocity_or_power > 0.0,
            _ if self.laser => self.lit,
            Set::CpCmd(_) => self.surface.is_none_or(touches),
            _ => is_shaped(command) && self.surface.is_some_and(touches),
        }
    }
}

/// Whether a command says what its way looks like.
fn is_shaped(command: &Set) -> bool {
    match command {
        Set::ArcCmd(_) | Set::CircleCmd(_) => true,
        _ => PtpMove::from_command(command).is_some_and(|to| to.mode.is_line()),
    }
}
