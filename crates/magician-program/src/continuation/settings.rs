//! Settings that the steps of a plan leave in force.
//!
//! To start in the middle of a plan, the arm needs the settings of the earlier steps, but not their
//! motion or other effects. The last command of each kind is kept (of each pin and motor, where
//! there are several), in the order in which they were given.

use std::collections::BTreeMap;

use magician_host::{Set, build};
use magician_protocol::commands::EMotor;
use magician_protocol::{PoList, PtpMode, Row, Writable};

/// Key of a setting that has one value at a time: the id of the command, and the pin, motor or
/// connector (0 if the command has only one).
type Slot = (u8, u8);

/// Settings left by commands, each with its last value.
#[derive(Debug, Default)]
pub(super) struct Settings {
    /// Commands with their sequence numbers. They are sent again in that order: one may depend on
    /// another.
    last: BTreeMap<Slot, (usize, Set)>,
    count: usize,
    lit: bool,
    with_rail: bool,
    rail: Rail,
}

/// Last target of the carriage on the rail.
#[derive(Clone, Copy, Debug, Default)]
enum Rail {
    /// No target was sent.
    #[default]
    Unset,
    At(f32),
    /// Unknown, because a path from an unknown start has moved the carriage.
    Unknown,
}

impl Settings {
    pub(super) fn note(&mut self, command: &Set) {
        match command {
            // The laser is switched on again only after the arm has arrived where the plan resumes.
            Set::SetEndEffectorLaser(laser) => {
                self.lit = laser.enable_ctrl.is_on() && laser.on.is_on();
            }
            // A motor that runs for a number of steps stops by itself, so it leaves no setting.
            Set::EMotorS(motor) => drop(self.last.remove(&motor_slot(motor.index.into()))),
            Set::PtpPoCmd(ptp) => self.note_outputs(&ptp.po),
            Set::PtpPoWithLCmd(ptp) => {
                self.note_outputs(&ptp.po);
                self.note_rail(ptp.ptp_mode, ptp.l);
            }
            Set::PtpWithLCmd(ptp) => self.note_rail(ptp.ptp_mode, ptp.l),
            Set::HomeCmd(_) if self.with_rail => self.rail = Rail::At(0.0),
            Set::SetDeviceWithL(rail) => {
                self.with_rail = rail.with_l.is_on();
                self.store((command.row().id, 0), *command);
            }
            _ => {
                if let Some(slot) = slot(command) {
                    self.store(slot, *command);
                }
            }
        }
    }

    fn store(&mut self, slot: Slot, command: Set) {
        self.last.insert(slot, (self.count, command));
        self.count += 1;
    }

    /// Records the outputs that a move switches, in the order in which the arm reaches them.
    fn note_outputs(&mut self, list: &PoList) {
        let mut outputs = list.as_slice().to_vec();
        // If one output is switched twice, the later switch is the one left in force.
        outputs.sort_by_key(|output| output.ratio);
        for output in outputs {
            if let Ok(address) = u8::try_from(output.address) {
                let command = build::output(address, output.level != 0);
                self.store((command.row().id, address), command);
            }
        }
    }

    fn note_rail(&mut self, mode: PtpMode, l: f32) {
        if !self.with_rail {
            return;
        }
        self.rail = match (mode.is_relative(), self.rail) {
            (false, _) => Rail::At(l),
            (true, Rail::At(from)) => Rail::At(from + l),
            // A relative target from an unknown position is unknown too.
            (true, Rail::Unset | Rail::Unknown) => Rail::Unknown,
        };
    }

    /// Commands that restore all settings, except for the laser.
    pub(super) fn in_force(&self) -> Vec<Set> {
        let mut commands: Vec<_> = self.last.values().collect();
        commands.sort_by_key(|(number, _)| *number);
        commands.into_iter().map(|(_, command)| *command).collect()
    }

    /// True if the laser is on.
    pub(super) fn is_lit(&self) -> bool {
        self.lit
    }

    /// True if the target of the carriage is unknown.
    pub(super) fn is_rail_unknown(&self) -> bool {
        matches!(self.rail, Rail::Unknown)
    }

    /// Target of the carriage on the rail, mm; `None` if the plan never moved the carriage.
    pub(super) fn rail(&self) -> Option<f32> {
        match self.rail {
            Rail::At(l) if self.with_rail => Some(l),
            _ => None,
        }
    }
}

fn motor_slot(index: u8) -> Slot {
    (MOTOR_COMMAND_ID, index)
}

/// Command id under which the state of motors is stored.
const MOTOR_COMMAND_ID: u8 = EMotor::ROW.id;

/// Key of the setting that a command leaves in force; `None` for a command that acts only once.
/// `EMotor` leaves one, because the motor keeps running until another command stops it.
fn slot(command: &Set) -> Option<Slot> {
    let row: &Row = command.row();
    match command {
        Set::EMotor(motor) => Some(motor_slot(motor.index.into())),
        Set::IoMultiplexing(pin) => Some((row.id, pin.address)),
        Set::IoDo(pin) => Some((row.id, pin.address)),
        Set::IoPwm(pin) => Some((row.id, pin.address)),
        Set::SetColorSensor(sensor) => Some((row.id, sensor.port.into())),
        Set::SetIrSwitch(sensor) => Some((row.id, sensor.port.into())),
        // Idempotent commands are the settings; all others do something once.
        _ => row.is_idempotent().then_some((row.id, 0)),
    }
}
