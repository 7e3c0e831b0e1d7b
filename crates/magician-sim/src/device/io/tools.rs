//! Tools: one air line for suction cup and gripper, and the laser (model section 13).
//!
//! Pump, valve and the two wires of the laser are EIO pins. The firmware drives them for the
//! commands of the end effectors, unless a pin is multiplexed to an output: then the wire follows
//! that pin.

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

/// Tool that has the air line. Both share the pump, so only one of them works.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum AirTool {
    #[default]
    Suction,
    Gripper,
}

/// The two flags of a tool command.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ToolCommand {
    pub(crate) control: Flag,
    pub(crate) on: Flag,
}

impl ToolCommand {
    fn is_on(self) -> bool {
        self.control.is_on() && self.on.is_on()
    }
}

/// State of a tool that takes time to act.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct ToolOutput {
    /// Commanded state.
    pub commanded: bool,
    /// State that it has reached.
    pub reached: bool,
}

/// A tool that takes time to act.
#[derive(Clone, Copy, Debug, Default)]
struct Actuator {
    commanded: bool,
    /// State before the command, valid until `settled`.
    before: bool,
    settled: ArmInstant,
}

impl Actuator {
    fn at(&self, now: ArmInstant) -> ToolOutput {
        let commanded = self.commanded;
        let reached = if now < self.settled {
            self.before
        } else {
            commanded
        };
        ToolOutput { commanded, reached }
    }

    fn command(&mut self, commanded: bool, now: ArmInstant, delay: Micros) {
        let was = self.at(now);
        // Repeating a command does not restart its delay.
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
    laser_set: ToolCommand,
    suction_set: ToolCommand,
    gripper_set: ToolCommand,
    /// Tool of the last command, and that command: it has the pump.
    air: (AirTool, ToolCommand),
    /// Laser power along a continuous path, percent.
    path_power: f64,
    suction: Actuator,
    gripper: Actuator,
    /// Power that the laser really has, percent.
    laser: f64,
    vacuum_delay: Micros,
    gripper_delay: Micros,
}

/// Signals on the wires to the tools.
#[derive(Clone, Copy, Debug)]
struct Wires {
    pump: bool,
    valve: bool,
    /// Laser power, percent.
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

    /// Sets the command of a tool on the air line; that tool takes the pump.
    pub(crate) fn set_air(&mut self, tool: AirTool, commanded: ToolCommand) {
        match tool {
            AirTool::Suction => self.suction_set = commanded,
            AirTool::Gripper => self.gripper_set = commanded,
        }
        self.air = (tool, commanded);
    }

    /// Sets the command of the laser.
    pub(crate) fn set_laser(&mut self, commanded: ToolCommand) {
        self.laser_set = commanded;
    }

    /// Last command of a tool on the air line, whichever has the air.
    pub(crate) fn air_set(&self, tool: AirTool) -> ToolCommand {
        match tool {
            AirTool::Suction => self.suction_set,
            AirTool::Gripper => self.gripper_set,
        }
    }

    /// Last command of the laser.
    pub(crate) fn laser_set(&self) -> ToolCommand {
        self.laser_set
    }

    /// Sets the laser power along a continuous path, percent; 0 switches it off.
    pub(crate) fn burn(&mut self, power: f64) {
        // Also false for NaN: what is not a power must not burn.
        self.path_power = if power > 0.0 { power.min(100.0) } else { 0.0 };
    }

    /// Laser power that the firmware drives, percent.
    fn laser_driven(&self) -> f64 {
        // SetEndEffectorLaser knows on and off only.
        if self.laser_set.is_on() {
            100.0
        } else {
            self.path_power
        }
    }

    pub(crate) fn suction(&self, now: ArmInstant) -> ToolOutput {
        self.suction.at(now)
    }

    pub(crate) fn gripper(&self, now: ArmInstant) -> ToolOutput {
        self.gripper.at(now)
    }

    /// Laser power, percent; 0 is off.
    pub(crate) fn laser_power(&self) -> f64 {
        self.laser
    }

    /// Next instant at which a tool reaches its commanded state.
    pub(crate) fn next_event(&self, now: ArmInstant) -> Option<ArmInstant> {
        [self.suction.settled, self.gripper.settled]
            .into_iter()
            .filter(|at| *at > now)
            .min()
    }

    /// Signals on the wires: that of the pin if it is an output, else that of the firmware.
    fn wires(&self, pins: &Pins) -> Wires {
        let (_, commanded) = self.air;
        let laser_driven = self.laser_driven();
        let level = |address, driven: bool| {
            // A pin multiplexed to an output overrides the firmware, as users drive the tools by
            // pins.
            let share = pins.signal(address).share();
            share.map_or(driven, |share| share > 0.0)
        };
        // The laser needs both: supply on EIO 2 and PWM on EIO 4 (model section 13).
        let supplied = level(LASER_SUPPLY, laser_driven > 0.0);
        let power = pins.signal(LASER_POWER).share().unwrap_or(laser_driven);
        Wires {
            pump: level(PUMP, commanded.control.is_on()),
            valve: level(VALVE, commanded.on.is_on()),
            laser: if supplied { power } else { 0.0 },
        }
    }

    /// Updates the tools from their wires and returns the state that the world feels.
    pub(crate) fn follow_wires(&mut self, now: ArmInstant, pins: &Pins) -> ToolState {
        let Wires { pump, valve, laser } = self.wires(pins);
        // With the valve closed the pump blows: there is no vacuum, and the gripper opens.
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
