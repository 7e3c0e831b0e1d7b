//! What the steps of a plan leave set.

use std::collections::BTreeMap;

use magician_host::{Set, build};
use magician_protocol::commands::EMotor;
use magician_protocol::{PoList, PtpMode, Row, Writable};

/// What can be set to one value at a time: a command, of a pin, a motor or a connector if it has several.
type Slot = (u8, u8);

/// The settings that commands leave behind, each as the last of them has it.
#[derive(Debug, Default)]
pub(super) struct Settings {
    /// The commands, each with its number, to be told in their order: one may depend on another.
    last: BTreeMap<Slot, (usize, Set)>,
    count: usize,
    lit: bool,
    with_rail: bool,
    rail: Rail,
}

/// Where the carriage on the rail has been sent.
#[derive(Clone, Copy, Debug, Default)]
enum Rail {
    /// Nowhere.
    #[default]
    Unsent,
    At(f32),
    /// By a path from an unknown start.
    Lost,
}

impl Settings {
    pub(super) fn note(&mut self, command: &Set) {
        match command {
            // What it lights is lit again when the arm has come to where it goes on.
            Set::SetEndEffectorLaser(laser) => {
                self.lit = laser.enable_ctrl.is_on() && laser.on.is_on();
            }
            // It has turned as far as it was to.
            Set::EMotorS(motor) => drop(self.last.remove(&motor_slot(motor.index.into()))),
            Set::PtpPoCmd(ptp) => self.outputs(&ptp.po),
            Set::PtpPoWithLCmd(ptp) => {
                self.outputs(&ptp.po);
                self.carry(ptp.ptp_mode, ptp.l);
            }
            Set::PtpWithLCmd(ptp) => self.carry(ptp.ptp_mode, ptp.l),
            Set::HomeCmd(_) if self.with_rail => self.rail = Rail::At(0.0),
            Set::SetDeviceWithL(rail) => {
                self.with_rail = rail.with_l.is_on();
                self.keep((command.row().id, 0), *command);
            }
            _ => {
                if let Some(slot) = slot(command) {
                    self.keep(slot, *command);
                }
            }
        }
    }

    fn keep(&mut self, slot: Slot, command: Set) {
        self.last.insert(slot, (self.count, command));
        self.count += 1;
    }

    /// Outputs that a move has switched on its way, in the order of the way.
    fn outputs(&mut self, list: &PoList) {
        let mut outputs = list.as_slice().to_vec();
        outputs.sort_by_key(|output| output.ratio);
        for output in outputs {
            if let Ok(address) = u8::try_from(output.address) {
                let command = build::output(address, output.level != 0);
                self.keep((command.row().id, address), command);
            }
        }
    }

    fn carry(&mut self, mode: PtpMode, l: f32) {
        if !self.with_rail {
            return;
        }
        self.rail = match (mode.is_relative(), self.rail) {
            (false, _) => Rail::At(l),
            (true, Rail::At(from)) => Rail::At(from + l),
            (true, Rail::Unsent | Rail::Lost) => Rail::Lost,
        };
    }

    /// The commands that set it all again, the laser left out.
    pub(super) fn in_force(&self) -> Vec<Set> {
        let mut commands: Vec<_> = self.last.values().collect();
        commands.sort_by_key(|(number, _)| *number);
        commands.into_iter().map(|(_, command)| *command).collect()
    }

    /// Whether the laser is on.
    pub(super) fn is_lit(&self) -> bool {
        self.lit
    }

    /// Whether the target of the carriage on the rail is unknown.
    pub(super) fn has_lost_the_rail(&self) -> bool {
        matches!(self.rail, Rail::Lost)
    }

    /// Where the carriage on the rail is to be, mm, if it was sent anywhere.
    pub(super) fn rail(&self) -> Option<f32> {
        match self.rail {
            Rail::At(l) if self.with_rail => Some(l),
            _ => None,
        }
    }
}

fn motor_slot(index: u8) -> Slot {
    (EXTERNAL_MOTOR, index)
}

/// The id under which motors run until told otherwise.
const EXTERNAL_MOTOR: u8 = EMotor::ROW.id;

/// What a command sets and leaves set; nothing for one that does something. A motor runs on until it is told otherwise.
fn slot(command: &Set) -> Option<Slot> {
    let row: &Row = command.row();
    match command {
        Set::EMotor(motor) => Some(motor_slot(motor.index.into())),
        Set::IoMultiplexing(pin) => Some((row.id, pin.address)),
        Set::IoDo(pin) => Some((row.id, pin.address)),
        Set::IoPwm(pin) => Some((row.id, pin.address)),
        Set::SetColorSensor(sensor) => Some((row.id, sensor.port.into())),
        Set::SetIrSwitch(sensor) => Some((row.id, sensor.port.into())),
        _ => row.is_idempotent().then_some((row.id, 0)),
    }
}
