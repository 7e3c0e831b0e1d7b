//! Parameters of `arm.tool` and `arm.speed`.

use std::collections::BTreeSet;

use magician::build;
use magician::commands::{
    ArcParams, CpParams, JogCommonParams, JogCoordinateParams, JogJointParams, JogLParams,
    PtpCommonParams, PtpCoordinateParams, PtpJointParams, PtpLParams,
};
use magician::{ErrorKind, ToolBias, message};
use magician_protocol::Writable;
use serde_json::{Map, Value};

use super::calls::named_command;
use super::dispatch::Call;
use crate::api::RpcError;
use crate::order::ArmAct;

/// Commands that set speeds. `arm.speed` accepts no others.
const SPEEDS: [u8; 10] = [
    PtpJointParams::ROW.id,
    PtpCoordinateParams::ROW.id,
    PtpLParams::ROW.id,
    PtpCommonParams::ROW.id,
    JogJointParams::ROW.id,
    JogCoordinateParams::ROW.id,
    JogLParams::ROW.id,
    JogCommonParams::ROW.id,
    CpParams::ROW.id,
    ArcParams::ROW.id,
];

/// Returns the action of `arm.tool`. Exactly one tool must be given.
pub(super) fn tool(call: &Call<'_>) -> Result<ArmAct, RpcError> {
    let params = call.params;
    let things = ["tool", "suction", "gripper", "laser"];
    let given: BTreeSet<_> = { things.iter() }
        .filter(|name| params.get(name).is_some())
        .collect();
    // With two, the first could succeed and the second fail; an answer cannot say that.
    if given.len() != 1 {
        let why = message!("one of `tool`, `suction`, `gripper`, `laser` has to be given");
        return Err(RpcError::param("tool", why));
    }
    if let Some(on) = params.switch("suction") {
        return Ok(ArmAct::Tool(build::suction(on)));
    }
    if let Some(gripper) = params.text("gripper") {
        return Ok(ArmAct::Tool(match gripper {
            "closed" => build::grip(),
            "open" => build::release(),
            _ => build::pump_off(),
        }));
    }
    if let Some(laser) = params.object("laser") {
        return laser_of(laser);
    }
    let bias = match (params.text("tool"), params.numbers("tool").as_deref()) {
        (Some(name), _) => ToolBias::named(name),
        (None, Some([x, y, z])) => Some(ToolBias::new(*x, *y, *z)),
        _ => None,
    };
    bias.map(ArmAct::Tip)
        .ok_or_else(|| RpcError::param("tool", message!("unknown tool")))
}

fn laser_of(laser: &Map<String, Value>) -> Result<ArmAct, RpcError> {
    let wrong = || {
        let why = message!(
            "`laser` is {shape}: true or false, and 0 to 100 percent",
            shape = "{on, power?}"
        );
        RpcError::param("laser", why)
    };
    if laser.keys().any(|name| name != "on" && name != "power") {
        return Err(wrong());
    }
    let on = laser.get("on").and_then(Value::as_bool).ok_or_else(wrong)?;
    let power = match laser.get("power") {
        None => None,
        Some(power) => {
            let percent = power
                .as_f64()
                .filter(|percent| (0.0..=100.0).contains(percent));
            Some(percent.ok_or_else(wrong)?)
        }
    };
    // The command that switches the laser knows on and off. Only a path carries a power.
    if on && power.is_some_and(|power| power < 100.0) {
        let why = message!(
            "a standing laser burns at full power or not at all: power below 100 is for paths (cple_cmd)"
        );
        return Err(RpcError::arm(ErrorKind::Unsupported, why));
    }
    Ok(ArmAct::Tool(build::laser(on)))
}

/// Returns the action of `arm.speed`: the ratio of all moves and jogs, or one setting of the
/// protocol.
pub(super) fn speed(call: &Call<'_>) -> Result<ArmAct, RpcError> {
    let params = call.params;
    match (params.number("percent"), params.text("row")) {
        (Some(percent), None) if params.get("fields").is_none() => {
            Ok(ArmAct::Speed(percent as f32))
        }
        (None, Some(name)) => {
            let set = named_command(call, "row", false)?;
            if !SPEEDS.contains(&set.row().id) {
                let name = magician_protocol::visible(name).to_string();
                let why = message!("{name} holds no speed: use `arm.set`", name);
                return Err(RpcError::param("row", why));
            }
            Ok(ArmAct::Set(set))
        }
        _ => {
            let why = message!("either `percent`, or `row` and its `fields`");
            Err(RpcError::param("percent", why))
        }
    }
}
