//! The world around the arm: what it can touch, hold, see and mark, and what happens there by itself.
//!
//! Everything follows from the arm's time and what the world was told, so a run repeats itself bit for bit. The world
//! costs what happens in it, not what its milliseconds cost: it is told when a motion begins and ends, and it says when
//! something is due.

mod course;

use magician_protocol::Port;

use crate::Micros;
use crate::pins::place_of;
use crate::profile::PINS;

pub use course::{Course, Posture};

/// The world around one arm. Lengths are mm and angles deg in the frame of the arm's base; a height is the z that the
/// arm reports when its tool touches it (model section 1).
#[derive(Clone, Debug, Default)]
pub struct World {
    levels: [Option<bool>; PINS],
    values: [Option<u16>; PINS],
}

/// The tool as the world feels it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Grip {
    /// There is vacuum at the suction cup.
    pub sucking: bool,
    /// The gripper is closed.
    pub closed: bool,
    /// Power of the laser, 0 to 100 percent; 0 is off.
    pub laser: f64,
}

/// Something that the arm can touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Thing {
    /// The table.
    Table,
    /// The conveyor's belt.
    Belt,
    /// An object, by its place in the scenario, from 0.
    Object(u16),
}

/// How the base key was pressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Press {
    /// It runs the program in the flash.
    Short,
    /// It homes the arm.
    Long,
}

/// What happens to the arm by itself: from a scenario, or injected.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Happening {
    /// An input or a sensor may read something else from now on.
    Input,
    /// The tool touches something. If it presses harder than the tool gives way, J2 and J3 stall and lose steps.
    Touch {
        /// What.
        thing: Thing,
        /// Whether J2 and J3 stall there.
        stalls: bool,
    },
    /// A joint slips: it stands elsewhere than the controller believes.
    Slip {
        /// J1 to J4 as 1 to 4.
        joint: u8,
        /// By how much, deg.
        degrees: f64,
    },
    /// An alarm is raised.
    Alarm(u8),
    /// The controller resets.
    Reset,
    /// The cable is pulled, or plugged in again.
    Cable {
        /// Whether it is in.
        plugged: bool,
    },
    /// Answers take so much longer from now on.
    Delay(Micros),
    /// The base key is pressed.
    Key(Press),
    /// The unlock key on the forearm is pressed or released.
    Unlock(bool),
    /// A hand moves the arm there while the unlock key is held, deg.
    Guide(magician_motion::JointAngles),
}

impl World {
    /// Drives a digital input, address 1 to 20, from now on; `false` if there is no such address.
    pub fn set_input(&mut self, address: u8, level: bool) -> bool {
        let input = place_of(address).and_then(|at| self.levels.get_mut(at));
        input.map(|input| *input = Some(level)).is_some()
    }

    /// Puts a voltage on an analog input, address 1 to 20: 0 to 4095 for 0 to 3.3 V; `false` if there is no such
    /// address.
    pub fn set_analog(&mut self, address: u8, value: u16) -> bool {
        let input = place_of(address).and_then(|at| self.values.get_mut(at));
        input.map(|input| *input = Some(value.min(4095))).is_some()
    }
}

/// What the controller asks and tells.
impl World {
    /// Level that something puts on an input, address 1 to 20 (model section 13); `None` where nothing is connected.
    pub(crate) fn digital(&self, _now: Micros, address: u8) -> Option<bool> {
        *self.levels.get(place_of(address)?)?
    }

    /// Voltage that something puts on an input, 0 to 4095 for 0 to 3.3 V; `None` where nothing is connected.
    pub(crate) fn analog(&self, _now: Micros, address: u8) -> Option<u16> {
        *self.values.get(place_of(address)?)?
    }

    /// Red, green and blue under the colour sensor of a connector.
    pub(crate) fn color(&self, _now: Micros, _port: Port) -> [u8; 3] {
        [0; 3]
    }

    /// Whether something is in front of the infrared sensor of a connector.
    pub(crate) fn infrared(&self, _now: Micros, _port: Port) -> bool {
        false
    }

    /// Whether the tool holds an object.
    pub(crate) fn holding(&self) -> bool {
        false
    }

    /// The arm has begun a motion; unless it is told otherwise it follows the course to its end.
    pub(crate) fn begin(&mut self, _course: &Course<'_>) {}

    /// The arm has followed the course until the course's end, which may lie before the one told at its beginning.
    pub(crate) fn end(&mut self, _course: &Course<'_>) {}

    /// The tool has come to another state, at rest or on its way.
    pub(crate) fn grip(&mut self, _now: Micros, _grip: Grip, _at: &Posture) {}

    /// A stepper output (0 or 1) turns at so many pulses a second from now on, 0 for rest.
    pub(crate) fn stepper(&mut self, _now: Micros, _index: usize, _pulses_per_second: f64) {}

    /// A queued command comes to its turn.
    pub(crate) fn index_started(&mut self, _now: Micros, _index: u64) {}

    /// When something next happens.
    pub(crate) fn next_event(&self) -> Option<Micros> {
        None
    }

    /// What happens at the present instant: call again until there is nothing.
    pub(crate) fn happen(&mut self, _now: Micros) -> Option<Happening> {
        None
    }
}
