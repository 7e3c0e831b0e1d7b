//! What the tool does: one air line for suction cup and gripper, and the laser (model section 13).
//!
//! The pump, the valve and the laser's two wires are EIO pins of the arm. The firmware drives them
//! for the commands of the end effectors, unless a pin is multiplexed to an output: then its wire
//! follows the pin.

use magician_protocol::Flag;

use super::pins::Pins;
use crate::convert::micros;
use crate::world::ToolState;
use crate::{ArmInstant, Micros};

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
pub(crate) struct Commanded {
    pub(crate) control: Flag,
    pub(crate) on: Flag,
}

impl Commanded {
    fn is_on(self) -> bool {
        self.control.is_on() && self.on.is_on()
    }
}

/// A tool that takes its time to do what it is told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Output {
    /// What it was told.
    pub commanded: bool,
    /// What it has come to.
    pub reached: bool,
}

/// What takes its time to come to what it is told.
#[derive(Clone, Copy, Debug, Default)]
struct Actuator {
    commanded: bool,
    /// The state before, until `settled`.
    before: bool,
    settled: ArmInstant,
}

impl Actuator {
    fn at(&self, now: ArmInstant) -> Output {
        let commanded = self.commanded;
        let reached = if now < self.settled {
            self.before
        } else {
            commanded
        };
        Output { commanded, reached }
    }

    fn command(&mut self, commanded: bool, now: ArmInstant, delay: Micros) {
        let was = self.at(now);
        if commanded != was.commanded {
            *self = Self {
                commanded,
                before: was.reached,
                settled: now.after_micros(delay),
            };
        }
    }
}

/// The tools that can be switched.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Actuators {
    laser_set: Commanded,
    suction_set: Commanded,
    gripper_set: Commanded,
    /// The tool whose command came last, and that command: it has the pump.
    air: (AirTool, Commanded),
    /// Power of the laser along a continuous path, percent.
    path_power: f64,
    suction: Actuator,
    gripper: Actuator,
    /// The laser's power, percent.
    laser: f64,
    vacuum_delay: Micros,
    gripper_delay: Micros,
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
    pub(crate) fn new(delays: &crate::profile::Tools) -> Self {
        Self {
            vacuum_delay: micros(delays.vacuum_delay),
            gripper_delay: micros(delays.gripper_delay),
            ..Self::default()
        }
    }

    /// A command for a tool of the air line.
    pub(crate) fn set_air(&mut self, tool: AirTool, commanded: Commanded) {
        match tool {
            AirTool::Suction => self.suction_set = commanded,
            AirTool::Gripper => self.gripper_set = commanded,
        }
        self.air = (tool, commanded);
    }

    /// A command for the laser.
    pub(crate) fn set_laser(&mut self, commanded: Commanded) {
        self.laser_set = commanded;
    }

    /// The command that a tool of the air line had last, whichever has the air.
    pub(crate) fn air_set(&self, tool: AirTool) -> Commanded {
        match tool {
            AirTool::Suction => self.suction_set,
            AirTool::Gripper => self.gripper_set,
        }
    }

    /// The command that the laser had last.
    pub(crate) fn laser_set(&self) -> Commanded {
        self.laser_set
    }

    /// The laser burns with so much power along a continuous path; 0 turns it off.
    pub(crate) fn burn(&mut self, power: f64) {
        self.path_power = if power > 0.0 { power.min(100.0) } else { 0.0 };
    }

    /// What the firmware makes of the laser, percent.
    fn laser_driven(&self) -> f64 {
        if self.laser_set.is_on() {
            100.0
        } else {
            self.path_power
        }
    }

    pub(crate) fn suction(&self, now: ArmInstant) -> Output {
        self.suction.at(now)
    }

    pub(crate) fn gripper(&self, now: ArmInstant) -> Output {
        self.gripper.at(now)
    }

    /// Power of the laser, percent; 0 is off.
    pub(crate) fn laser_power(&self) -> f64 {
        self.laser
    }

    /// When a tool next comes to what it was commanded to.
    pub(crate) fn next_event(&self, now: ArmInstant) -> Option<ArmInstant> {
        [self.suction.settled, self.gripper.settled]
            .into_iter()
            .filter(|at| *at > now)
            .min()
    }

    /// What the wires carry: each what its pin puts out, else what the firmware drives it to.
    fn wires(&self, pins: &Pins) -> Wires {
        let (_, commanded) = self.air;
        let laser_driven = self.laser_driven();
        let level = |address, driven: bool| {
            let share = pins.signal(address).share();
            share.map_or(driven, |share| share > 0.0)
        };
        let supplied = level(LASER_SUPPLY, laser_driven > 0.0);
        let power = pins.signal(LASER_POWER).share().unwrap_or(laser_driven);
        Wires {
            pump: level(PUMP, commanded.control.is_on()),
            valve: level(VALVE, commanded.on.is_on()),
            laser: if supplied { power } else { 0.0 },
        }
    }

    /// Lets the tools follow their wires; what the world then feels of them.
    pub(crate) fn follow_wires(&mut self, now: ArmInstant, pins: &Pins) -> ToolState {
        let Wires { pump, valve, laser } = self.wires(pins);
        // The pump blows while the valve is closed: there is no vacuum then, and the gripper opens.
        let active = pump && valve;
        let (tool, _) = self.air;
        let has_air = |wanted| active && tool == wanted;
        (self.suction).command(has_air(AirTool::Suction), now, self.vacuum_delay);
        (self.gripper).command(has_air(AirTool::Gripper), now, self.gripper_delay);
        self.laser = laser;
        ToolState {
            sucking: self.suction(now).reached,
            closed: self.gripper(now).reached,
            laser,
        }
    }
}
