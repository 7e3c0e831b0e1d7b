//! The tool at the end of the arm.

use magician_model::tool_to_wire;
use magician_motion::ToolBias;
use magician_protocol::commands::{
    SetEndEffectorGripper, SetEndEffectorLaser, SetEndEffectorSuctionCup,
};
use magician_protocol::{Flag, Set};

use crate::{Error, Result, message};

/// Sets the position of the tool's tip relative to the flange. Poses refer to that tip from then
/// on.
#[must_use]
pub fn tool(bias: ToolBias) -> Set {
    tool_to_wire(bias).into()
}

/// Like [`tool`], by name: `none`, `suction`, `gripper`, `pen`, `laser`.
///
/// # Errors
/// [`InvalidInput`](crate::ErrorKind::InvalidInput) for another name; the message lists these.
pub fn tool_named(name: &str) -> Result<Set> {
    // Only the vendor's tools have names; any other tool is set by its bias.
    ToolBias::named(name).map(tool).ok_or_else(|| {
        let names: Vec<_> = ToolBias::NAMED.iter().map(|(name, _)| *name).collect();
        Error::invalid(message!(
            "unknown tool '{name}'; there are {names}",
            name,
            names = names.join(", ")
        ))
    })
}

/// Switches the suction cup on or off; it takes about 0.3 s to hold (document 1.8.3, model section
/// 15a). Suction cup and gripper share one pump, so the later command gets the air.
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

/// Switches the air pump off. Suction cup and gripper release (model section 13).
#[must_use]
pub fn pump_off() -> Set {
    SetEndEffectorGripper {
        enable_ctrl: Flag::OFF,
        grip: Flag::OFF,
    }
    .into()
}

/// Switches the laser fully on or off (document 1.8.2). Off also ends the power of a path. The
/// guard [`laser`](field@crate::preflight::Guards::laser) refuses a program that leaves it on, or
/// stands still or moves by joints with the laser on.
#[must_use]
pub fn laser(on: bool) -> Set {
    SetEndEffectorLaser {
        // Both flags, because either alone leaves the laser off.
        enable_ctrl: on.into(),
        on: on.into(),
    }
    .into()
}
