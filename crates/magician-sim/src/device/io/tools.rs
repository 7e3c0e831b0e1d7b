//! What the tool does: one air line for suction cup and gripper, and the laser (model section 13).
//!
//! The pump, the valve and the laser's two wires are EIO pins of the arm. The firmware drives them for the commands of
//! the end effectors, unless a pin is multiplexed to an output: then its wire follows the pin.

use magician_protocol::Flag;

use crate::convert::micros;
use crate::device::Device;
use crate::world::Grip;
use crate::{Micros, Output};

/// EIO address of the air line's valve.
const VALVE: u8 = 16;
/// EIO address of the pump.
const PUMP: u8 = 17;
/// EIO address of the laser's supply.
const LASER_SUPPLY: u8 = 2;
/// EIO address of the laser's modulation.
const LASER_POWER: u8 = 4;

/// Which tool the air line is for: they share the pump, so only one of them works.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum AirTool {
    #[default]
    Suction,
    Gripper,
}

/// Two flags as a host set them.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Told {
    pub(crate) control: Flag,
    pub(crate) on: Flag,
}

impl Told {
    fn is_on(self) -> bool {
        self.control.is_on() && self.on.is_on()
    }
}

/// What takes its time to come to what it is told.
#[derive(Clone, Copy, Debug, Default)]
struct Actuator {
    commanded: bool,
    /// The state before, until `settled`.
    before: bool,
    settled: Micros,
}

impl Actuator {
    fn at(&self, now: Micros) -> Output {
        let commanded = self.commanded;
        let reached = if now < self.settled {
            self.before
        } else {
            commanded
        };
        Output { commanded, reached }
    }

    fn command(&mut self, commanded: bool, now: Micros, delay: Micros) {
        let was = self.at(now);
        if commanded != was.commanded {
            *self = Self {
                commanded,
                before: was.reached,
                settled: now.saturating_add(delay),
            };
        }
    }
}

/// The tools that can be switched.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Actuators {
    pub(crate) laser_told: Told,
    pub(crate) suction_told: Told,
    pub(crate) gripper_told: Told,
    /// The tool whose command came last, and that command: it has the pump.
    air: (AirTool, Told),
    /// Power of the laser along a continuous path, percent.
    path_power: f64,
    suction: Actuator,
    gripper: Actuator,
    /// The laser's power, percent.
    laser: f64,
}

/// What the wires to the tools carry.
#[derive(Clone, Copy, Debug)]
struct Wires {
    pump: bool,
    valve: bool,
    /// Power of the laser, percent.
    laser: f64,
}

impl Actuators {
    /// A command for a tool of the air line.
    pub(crate) fn tell_air(&mut self, tool: AirTool, told: Told) {
        match tool {
            AirTool::Suction => self.suction_told = told,
            AirTool::Gripper => self.gripper_told = told,
        }
        self.air = (tool, told);
    }

    /// A command for the laser.
    pub(crate) fn tell_laser(&mut self, told: Told) {
        self.laser_told = told;
    }

    /// The laser burns with so much power along a continuous path; 0 turns it off.
    pub(crate) fn burn(&mut self, power: f64) {
        self.path_power = if power > 0.0 { power.min(100.0) } else { 0.0 };
    }

    /// What the firmware makes of the laser, percent.
    fn laser_driven(&self) -> f64 {
        if self.laser_told.is_on() {
            100.0
        } else {
            self.path_power
        }
    }

    pub(crate) fn suction(&self, now: Micros) -> Output {
        self.suction.at(now)
    }

    pub(crate) fn gripper(&self, now: Micros) -> Output {
        self.gripper.at(now)
    }

    /// Power of the laser, percent; 0 is off.
    pub(crate) fn laser_power(&self) -> f64 {
        self.laser
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
            laser: self.laser,
        }
    }
}

impl Device {
    /// What the wires carry: each what its pin puts out, else what the firmware drives it to.
    fn wires(&self) -> Wires {
        let (_, told) = self.actuators.air;
        let laser_driven = self.actuators.laser_driven();
        let level = |address, driven: bool| {
            let share = self.signal(address).share();
            share.map_or(driven, |share| share > 0.0)
        };
        let supplied = level(LASER_SUPPLY, laser_driven > 0.0);
        let power = self.signal(LASER_POWER).share().unwrap_or(laser_driven);
        Wires {
            pump: level(PUMP, told.control.is_on()),
            valve: level(VALVE, told.on.is_on()),
            laser: if supplied { power } else { 0.0 },
        }
    }

    /// Lets the tools follow their wires, and tells the world what has become of them.
    pub(crate) fn feel_grip(&mut self) {
        let (wires, now) = (self.wires(), self.now);
        // The pump blows while the valve is closed: there is no vacuum then, and the gripper opens.
        let active = wires.pump && wires.valve;
        let delays = &self.profile.tools;
        let tools = &mut self.actuators;
        let (tool, _) = tools.air;
        let has_air = |wanted| active && tool == wanted;
        let (vacuum, grip) = (micros(delays.vacuum_delay), micros(delays.gripper_delay));
        (tools.suction).command(has_air(AirTool::Suction), now, vacuum);
        (tools.gripper).command(has_air(AirTool::Gripper), now, grip);
        tools.laser = wires.laser;
        let grip = tools.grip(now);
        if grip != self.grip {
            self.grip = grip;
            let posture = self.posture();
            // What is to come of a motion looks different with another tool.
            self.end_course();
            self.world.grip(now, grip, &posture);
            self.show_course();
            self.tell_incidents();
        }
    }
}
