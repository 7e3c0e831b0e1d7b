//! The tool at the end of the arm.

use magician_model::tool_to_wire;
use magician_motion::ToolBias;
use magician_protocol::commands::{
    SetEndEffectorGripper, SetEndEffectorLaser, SetEndEffectorSuctionCup,
};
use magician_protocol::{Flag, Set};

use crate::{Error, Result};

/// Tells the arm where the tool sits; poses count from there on.
#[must_use]
pub fn tool(bias: ToolBias) -> Set {
    tool_to_wire(bias).into()
}

/// As [`tool`], by name: `none`, `suction`, `gripper`, `pen`, `laser`.
///
/// # Errors
/// [`InvalidInput`](crate::ErrorKind::InvalidInput) for another name; it lists these.
pub fn tool_named(name: &str) -> Result<Set> {
    ToolBias::named(name).map(tool).ok_or_else(|| {
        let names: Vec<_> = ToolBias::NAMED.iter().map(|(name, _)| *name).collect();
        Error::invalid(format!(
            "unknown tool '{name}'; there are {}",
            names.join(", ")
        ))
    })
}

/// Sucks, or lets go; it takes about 0.3 s to hold (document 1.8.3, model section 15a). Suction cup and gripper share
/// one pump, so the later command has the air.
#[must_use]
pub fn suction(on: bool) -> Set {
    SetEndEffectorSuctionCup {
        enable_ctrl: Flag::ON,
        suck: on.into(),
    }
    .into()
}

/// Closes the gripper, in about 0.5 s (document 1.8.4, model section 15a).
#[must_use]
pub fn grip() -> Set {
    SetEndEffectorGripper {
        enable_ctrl: Flag::ON,
        grip: Flag::ON,
    }
    .into()
}

/// Opens the gripper.
#[must_use]
pub fn release() -> Set {
    SetEndEffectorGripper {
        enable_ctrl: Flag::ON,
        grip: Flag::OFF,
    }
    .into()
}

/// Switches the air pump off; suction cup and gripper go limp (model section 13).
#[must_use]
pub fn pump_off() -> Set {
    SetEndEffectorGripper {
        enable_ctrl: Flag::OFF,
        grip: Flag::OFF,
    }
    .into()
}

/// Switches the laser, full on or off (document 1.8.2). A program that leaves it on, or stands or travels with it, is
/// refused by the guard [`laser`](field@crate::preflight::Guards::laser). Off ends the power of a path, too.
#[must_use]
pub fn laser(on: bool) -> Set {
    SetEndEffectorLaser {
        enable_ctrl: on.into(),
        on: on.into(),
    }
    .into()
}
