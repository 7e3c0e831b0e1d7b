//! Decides which motion leaves a line.

use magician_host::{ArmState, PtpMove, Set};

use crate::rehearse::{RehearseOptions, tool_kind, tool_of};
use crate::{Plan, Surface, Tool};

/// Height above the surface up to which a pen is taken to draw, mm. A choice, far below the default
/// lift.
const TOUCH_HEIGHT: f64 = 0.5;

pub(super) struct Pen {
    /// True for a laser, which draws only while it is on.
    laser: bool,
    /// True if the laser was switched on.
    lit: bool,
    surface: Option<Surface>,
}

impl Pen {
    pub(super) fn of(plan: &Plan) -> Self {
        Self {
            laser: plan.tool == Some(Tool::Laser)
                || plan.steps.iter().any(|step| step.action.is_of_a_laser()),
            lit: false,
            surface: match tool_kind(plan, tool_of(plan, &RehearseOptions::default())) {
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

    /// True if the laser was switched on by a separate command, at full power.
    pub(super) fn is_lit(&self) -> bool {
        self.lit
    }

    /// True if the motion of a command draws or burns.
    pub(super) fn draws(&self, command: &Set, from: &ArmState, to: &ArmState) -> bool {
        let touches = |surface: Surface| {
            let on = |at: &ArmState| at.pose.z - surface.at([at.pose.x, at.pose.y]) <= TOUCH_HEIGHT;
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

/// True if a command defines the shape of its path.
fn is_shaped(command: &Set) -> bool {
    match command {
        Set::ArcCmd(_) | Set::CircleCmd(_) => true,
        _ => PtpMove::from_command(command).is_some_and(|to| to.mode.is_line()),
    }
}
