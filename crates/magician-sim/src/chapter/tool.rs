//! The tool at the end of the arm (document 1.8).

use magician_protocol::commands::*;
use magician_protocol::{Flag, NoArgs};

use crate::convert::micros;
use crate::core::Core;
use crate::dispatch::{Apply, Report, Step, Turn, stored};
use crate::world::Grip;
use crate::{Micros, Output};

// The reported pose follows the bias at once: it is computed from the joints when asked for.
stored!(EndEffectorParams in bias);

/// What was set last: two flags, as they came, and how long the tool takes to get there.
#[derive(Clone, Copy, Debug, Default)]
struct Actuator {
    control: Flag,
    on: Flag,
    /// The state before, until `settled`.
    before: bool,
    settled: Micros,
}

impl Actuator {
    /// Without control the pump is off whatever the second flag says (model section 13).
    fn commanded(&self) -> bool {
        self.control.is_on() && self.on.is_on()
    }

    fn at(&self, now: Micros) -> Output {
        let commanded = self.commanded();
        let reached = if now < self.settled {
            self.before
        } else {
            commanded
        };
        Output { commanded, reached }
    }

    fn command(&mut self, control: Flag, on: Flag, now: Micros, delay: Micros) {
        let was = self.at(now);
        (self.control, self.on) = (control, on);
        if self.commanded() != was.commanded {
            self.before = was.reached;
            self.settled = now.saturating_add(delay);
        }
    }
}

/// The tools that can be switched.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Actuators {
    laser: Actuator,
    suction: Actuator,
    gripper: Actuator,
    /// Power of the laser along a continuous path, percent.
    path_power: f64,
}

impl Actuators {
    /// The laser burns with so much power along a continuous path; 0 turns it off.
    pub(crate) fn burn(&mut self, power: f64) {
        self.path_power = if power > 0.0 { power.min(100.0) } else { 0.0 };
    }

    pub(crate) fn suction(&self, now: Micros) -> Output {
        self.suction.at(now)
    }

    pub(crate) fn gripper(&self, now: Micros) -> Output {
        self.gripper.at(now)
    }

    pub(crate) fn laser_burns(&self) -> bool {
        self.laser.commanded() || self.path_power > 0.0
    }

    /// When a tool next comes to what it was told.
    pub(crate) fn next_change(&self, now: Micros) -> Option<Micros> {
        [self.suction.settled, self.gripper.settled]
            .into_iter()
            .filter(|at| *at > now)
            .min()
    }

    /// What the world feels of the tools.
    fn grip(&self, now: Micros) -> Grip {
        Grip {
            sucking: self.suction(now).reached,
            closed: self.gripper(now).reached,
            laser: if self.laser.commanded() {
                100.0
            } else {
                self.path_power
            },
        }
    }
}

impl Core {
    /// Tells the world what has become of the tool.
    pub(crate) fn feel_grip(&mut self) {
        let grip = self.actuators.grip(self.now);
        if grip != self.grip {
            self.grip = grip;
            let posture = self.posture();
            // What is to come of a motion looks different with another tool.
            self.end_course();
            self.world.grip(self.now, grip, &posture);
            self.show_course();
            self.tell_incidents();
        }
    }
}

impl Report for EndEffectorLaser {
    fn report(core: &mut Core, _: &NoArgs) -> Self {
        let Actuator { control, on, .. } = core.actuators.laser;
        Self {
            is_ctrl_enabled: control,
            is_on: on,
        }
    }
}

impl Apply for SetEndEffectorLaser {
    fn apply(&self, core: &mut Core, _: Turn) -> Step {
        let (control, on) = (self.enable_ctrl, self.on);
        core.actuators.laser.command(control, on, core.now, 0);
        Step::Done
    }
}

impl Report for EndEffectorSuctionCup {
    fn report(core: &mut Core, _: &NoArgs) -> Self {
        let Actuator { control, on, .. } = core.actuators.suction;
        Self {
            is_ctrl_enabled: control,
            is_sucked: on,
        }
    }
}

impl Apply for SetEndEffectorSuctionCup {
    fn apply(&self, core: &mut Core, _: Turn) -> Step {
        let delay = micros(core.profile.tools.vacuum_delay);
        let (control, on) = (self.enable_ctrl, self.suck);
        core.actuators.suction.command(control, on, core.now, delay);
        Step::Done
    }
}

impl Report for EndEffectorGripper {
    fn report(core: &mut Core, _: &NoArgs) -> Self {
        let Actuator { control, on, .. } = core.actuators.gripper;
        Self {
            is_ctrl_enabled: control,
            is_gripped: on,
        }
    }
}

impl Apply for SetEndEffectorGripper {
    fn apply(&self, core: &mut Core, _: Turn) -> Step {
        let delay = micros(core.profile.tools.gripper_delay);
        let (control, on) = (self.enable_ctrl, self.grip);
        core.actuators.gripper.command(control, on, core.now, delay);
        Step::Done
    }
}
