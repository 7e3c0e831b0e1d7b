//! What happens to the arm from outside its protocol.

use std::time::Duration;

use magician_motion::JointAngles;

/// Something that the arm can touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Body {
    /// The table.
    Table,
    /// The conveyor's belt.
    Belt,
    /// An object, by its place in the scenario, from 0.
    Object(u16),
}

/// How the base key was pressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Press {
    /// It runs the program in the flash.
    Short,
    /// It homes the arm.
    Long,
}

/// What happens to the arm by itself: from a scenario, or injected.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ExternalEvent {
    /// An input or a sensor may read something else from now on.
    Input,
    /// The tool touches something. If it presses harder than the tool gives way, J2 and J3 stall
    /// and lose steps.
    Touch {
        /// What.
        body: Body,
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
    /// Answers take so much longer from now on, by the host's clock.
    Delay(Duration),
    /// The base key is pressed.
    Key(Press),
    /// The unlock key on the forearm is pressed or released.
    Unlock(bool),
    /// A hand moves the arm while the unlock key is held: this is where the joints really come to,
    /// deg.
    Guide(JointAngles),
}
