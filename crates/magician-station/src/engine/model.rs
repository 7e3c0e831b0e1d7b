//! Geometry of an arm, for pages that draw it.

use magician::commands::{DeviceWithL, EndEffectorParams};
use magician::{Arm, ToolBias};
use magician_motion::{Link, LinkJoint, Range};
use serde_json::{Value, json};

use crate::api::RpcError;
use crate::reading::short;

/// Returns links, limits and tool of the arm.
pub(super) async fn model(arm: &Arm) -> Result<Value, RpcError> {
    let bias = arm.get::<EndEffectorParams>().await?;
    let bias = [bias.x_bias, bias.y_bias, bias.z_bias];
    let on_rail = arm.get::<DeviceWithL>().await?.with_l.is_on();
    let [x, y, z] = bias.map(f64::from);
    let model = arm.model();
    let links = model.links(ToolBias::new(x, y, z), on_rail);
    let limits = &model.limits;
    let range = |range: Range| [range.min, range.max];
    Ok(json!({
        "frame": "shoulder",
        "links": links.iter().map(link).collect::<Vec<_>>(),
        "limits": {
            "j1": range(limits.j1),
            "j2": range(limits.j2),
            "j3": range(limits.j3),
            "j4": range(limits.j4),
            "j2_minus_j3": range(limits.j2_minus_j3),
            // The rail has no limits in the model, only a length.
            "l": on_rail.then_some([0.0, model.rail.length]),
        },
        "tool": {"name": super::reads::tool_name(bias), "bias": bias.map(short)},
    }))
}

fn link(link: &Link) -> Value {
    json!({
        "name": link.name,
        "parent": link.parent,
        "joint": link.joint.map(LinkJoint::name),
        "axis": link.axis,
        // Rounded to micrometres: the tool's offset comes in single precision. Adding 0.0 turns -0
        // into 0.
        "at": link.at.map(|at| (at * 1000.0).round() / 1000.0 + 0.0),
        "shape": link.shape.name(),
        "size": link.size.map(|size| (size * 1000.0).round() / 1000.0),
        "turn": link.turn,
        "color": link.color,
    })
}
