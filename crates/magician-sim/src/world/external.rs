//! Events that happen to the arm from outside its protocol.

use std::time::Duration;

use magician_motion::JointAngles;

/// A body that the tool can touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Body {
    /// The table.
    Table,
    /// The conveyor's belt.
    Belt,
    /// An object, by its index in the scenario, from 0.
    Object(u16),
}

/// Kind of press of the base key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Press {
    /// Runs or stops the stored program.
    Short,
    /// Homes the arm.
    Long,
}

/// An event that happens to the arm: scripted by a scenario, or injected.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ExternalEvent {
    /// An input or a sensor may have changed.
    Input,
    /// The tool touches a body. If it presses deeper than it gives way, J2 and J3 stall and lose
    /// steps.
    Touch {
        /// The touched body.
        body: Body,
        /// True if J2 and J3 stall.
        stalls: bool,
    },
    /// A joint slips: its true angle changes, the commanded one does not.
    Slip {
        /// Joint, 1 to 4 for J1 to J4.
        joint: u8,
        /// Angle of the slip, deg.
        degrees: f64,
    },
    /// An alarm is raised, by code.
    Alarm(u8),
    /// The controller is reset.
    Reset,
    /// The cable is pulled or plugged in again.
    Cable {
        /// True if it is plugged in.
        plugged: bool,
    },
    /// The additional delay of answers becomes this long, on the host's clock; 0 ends it.
    Delay(Duration),
    /// The base key is pressed.
    Key(Press),
    /// The unlock key on the forearm is pressed (true) or released.
    Unlock(bool),
    /// A hand moves the arm to these true joints, deg, while the unlock key is held.
    Guide(JointAngles),
}
