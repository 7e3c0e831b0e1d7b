//! The fence of an arm as the API has it.

use magician::{Cuboid, Fence, FenceError};
use serde_json::{Map, Value, json};

use crate::api::RpcError;

const AXES: [&str; 3] = ["x", "y", "z"];

/// As clients see it: null without one, and null for what it does not bound.
pub(crate) fn shown(fence: Option<&Fence>) -> Value {
    let Some(fence) = fence else {
        return Value::Null;
    };
    json!({
        "floor": fence.floor(),
        "box": fence.within().map(sides),
        "keep_out": fence.keep_outs().iter().copied().map(sides).collect::<Vec<_>>(),
        "speed": fence.top_speed(),
        "power": fence.strongest_laser(),
    })
}

fn sides(cuboid: Cuboid) -> Value {
    let sides = AXES.iter().enumerate();
    let sides = sides.map(|(at, axis)| (*axis, json!([cuboid.min[at], cuboid.max[at]])));
    Value::Object(
        sides
            .map(|(axis, side)| (axis.to_owned(), side))
            .collect::<Map<_, _>>(),
    )
}

/// The fence after a change: null removes it, and a member that is named takes the place of what was.
pub(crate) fn changed(fence: Option<Fence>, change: &Value) -> Result<Option<Fence>, RpcError> {
    let Value::Object(change) = change else {
        return Ok(None);
    };
    let known = ["floor", "box", "keep_out", "speed", "power"];
    if let Some(name) = change.keys().find(|name| !known.contains(&name.as_str())) {
        let name = magician_protocol::visible(name).to_string();
        return Err(wrong(&format!(
            "a fence has floor, box, keep_out, speed and power, and no `{name}`"
        )));
    }
    let before = fence.unwrap_or_default();
    let mut after = Fence::default();
    let number = |name: &str, was: Option<f64>| match change.get(name) {
        None => Ok(was),
        Some(Value::Null) => Ok(None),
        Some(value) => match value.as_f64() {
            Some(number) => Ok(Some(number)),
            None => Err(wrong(&format!("`{name}` must be a number or null"))),
        },
    };
    if let Some(floor) = number("floor", before.floor())? {
        after = after.with_floor(floor).map_err(flaw)?;
    }
    if let Some(speed) = number("speed", before.top_speed())? {
        after = after.with_top_speed(speed).map_err(flaw)?;
    }
    if let Some(power) = number("power", before.strongest_laser())? {
        after = after.with_strongest_laser(power).map_err(flaw)?;
    }
    let within = match change.get("box") {
        None => before.within(),
        Some(Value::Null) => None,
        Some(value) => Some(cuboid("box", value)?),
    };
    if let Some(within) = within {
        after = after.with_box(within).map_err(flaw)?;
    }
    let keep_outs = match change.get("keep_out") {
        None => before.keep_outs().to_vec(),
        Some(Value::Null) => Vec::new(),
        Some(Value::Array(items)) => {
            let cuboids = items.iter().map(|item| cuboid("keep_out", item));
            cuboids.collect::<Result<_, _>>()?
        }
        Some(_) => return Err(wrong("`keep_out` must be an array of boxes")),
    };
    for keep_out in keep_outs {
        after = after.with_keep_out(keep_out).map_err(flaw)?;
    }
    Ok(Some(after).filter(|fence| !fence.is_empty()))
}

fn cuboid(name: &str, value: &Value) -> Result<Cuboid, RpcError> {
    let side = |axis: &str| {
        let pair = value.get(axis)?.as_array()?;
        match pair.as_slice() {
            [low, high] => Some([low.as_f64()?, high.as_f64()?]),
            _ => None,
        }
    };
    let whole = value.as_object().is_some_and(|sides| sides.len() == 3);
    match AXES.map(side) {
        [Some(x), Some(y), Some(z)] if whole => Ok(Cuboid {
            min: [x[0], y[0], z[0]],
            max: [x[1], y[1], z[1]],
        }),
        _ => Err(wrong(&format!(
            "`{name}` is a box {{x: [least, most], y: [..], z: [..]}}, mm"
        ))),
    }
}

fn wrong(why: &str) -> RpcError {
    RpcError::param("set", why)
}

fn flaw(error: FenceError) -> RpcError {
    wrong(&error.to_string())
}
