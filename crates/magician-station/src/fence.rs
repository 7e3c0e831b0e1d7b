//! The fence of an arm in JSON: reading, changing and combining.
//!
//! A fence bounds where the tool tip may go, how fast it moves and how strong the laser burns.
//! [`Fence`] itself and its check are in `magician-host`; this module translates it for clients.

use magician::{Cuboid, Fence, Message, message};
use serde_json::{Map, Value, json};

use crate::api::RpcError;

const AXES: [&str; 3] = ["x", "y", "z"];

/// Returns the fence as JSON. Null without a fence, and null for each bound not set.
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

/// Returns the fence after a change: null removes the fence, a named member replaces the old bound,
/// other members stay.
pub(crate) fn changed(fence: Option<Fence>, change: &Value) -> Result<Option<Fence>, RpcError> {
    change_of(fence, change).map_err(|why| RpcError::param("set", why))
}

/// Like [`changed`], with a sentence as its error.
pub(crate) fn change_of(fence: Option<Fence>, change: &Value) -> Result<Option<Fence>, Message> {
    let Value::Object(change) = change else {
        return Ok(None);
    };
    // A misspelt bound must not be ignored: the client would rely on a missing fence.
    let known = ["floor", "box", "keep_out", "speed", "power"];
    if let Some(name) = change.keys().find(|name| !known.contains(&name.as_str())) {
        let name = magician_protocol::visible(name).to_string();
        return Err(message!(
            "a fence has floor, box, keep_out, speed and power, and no `{name}`",
            name
        ));
    }
    let before = fence.unwrap_or_default();
    // Built anew, because a `Fence` can only be extended: a bound could not be removed from it.
    let mut after = Fence::default();
    let number = |name: &str, was: Option<f64>| match change.get(name) {
        None => Ok(was),
        // Null removes the bound, unlike a member that is missing.
        Some(Value::Null) => Ok(None),
        Some(value) => match value.as_f64() {
            Some(number) => Ok(Some(number)),
            None => Err(message!("`{name}` must be a number or null", name)),
        },
    };
    if let Some(floor) = number("floor", before.floor())? {
        after = after.with_floor(floor)?;
    }
    if let Some(speed) = number("speed", before.top_speed())? {
        after = after.with_top_speed(speed)?;
    }
    if let Some(power) = number("power", before.strongest_laser())? {
        after = after.with_strongest_laser(power)?;
    }
    let within = match change.get("box") {
        None => before.within(),
        Some(Value::Null) => None,
        Some(value) => Some(cuboid("box", value)?),
    };
    if let Some(within) = within {
        after = after.with_box(within)?;
    }
    let keep_outs = match change.get("keep_out") {
        None => before.keep_outs().to_vec(),
        Some(Value::Null) => Vec::new(),
        Some(Value::Array(items)) => {
            let cuboids = items.iter().map(|item| cuboid("keep_out", item));
            cuboids.collect::<Result<_, _>>()?
        }
        Some(_) => return Err(message!("`keep_out` must be an array of boxes")),
    };
    for keep_out in keep_outs {
        after = after.with_keep_out(keep_out)?;
    }
    // A fence without any bound is no fence: `null` is what clients then see.
    Ok(Some(after).filter(|fence| !fence.is_empty()))
}

fn cuboid(name: &str, value: &Value) -> Result<Cuboid, Message> {
    let side = |axis: &str| {
        let pair = value.get(axis)?.as_array()?;
        match pair.as_slice() {
            [low, high] => Some([low.as_f64()?, high.as_f64()?]),
            // More or fewer numbers, or no array.
            _ => None,
        }
    };
    // Exactly three sides: a fourth member would be a misspelt axis.
    let whole = value.as_object().is_some_and(|sides| sides.len() == 3);
    match AXES.map(side) {
        [Some(x), Some(y), Some(z)] if whole => Ok(Cuboid {
            min: [x[0], y[0], z[0]],
            max: [x[1], y[1], z[1]],
        }),
        _ => Err(message!(
            "`{name}` is a box {shape}, mm",
            name,
            shape = "{x: [least, most], y: [..], z: [..]}"
        )),
    }
}

/// Returns the intersection of two fences: for each bound the stricter one.
#[cfg(feature = "class")]
pub(crate) fn stricter(one: Fence, other: &Fence) -> Fence {
    let both = |a: Option<f64>, b: Option<f64>, pick: fn(f64, f64) -> f64| match (a, b) {
        (Some(a), Some(b)) => Some(pick(a, b)),
        (a, b) => a.or(b),
    };
    let within = match (one.within(), other.within()) {
        (Some(a), Some(b)) => Some(Cuboid {
            min: std::array::from_fn(|axis| a.min[axis].max(b.min[axis])),
            max: std::array::from_fn(|axis| a.max[axis].min(b.max[axis])),
        }),
        (a, b) => a.or(b),
    };
    let mut out = Some(Fence::default());
    let mut add = |change: &dyn Fn(Fence) -> Result<Fence, magician::FenceError>| {
        out = out.and_then(|fence| change(fence).ok());
    };
    if let Some(floor) = both(one.floor(), other.floor(), f64::max) {
        add(&|fence| fence.with_floor(floor));
    }
    if let Some(speed) = both(one.top_speed(), other.top_speed(), f64::min) {
        add(&|fence| fence.with_top_speed(speed));
    }
    if let Some(power) = both(one.strongest_laser(), other.strongest_laser(), f64::min) {
        add(&|fence| fence.with_strongest_laser(power));
    }
    if let Some(within) = within {
        add(&|fence| fence.with_box(within));
    }
    for keep_out in one.keep_outs().iter().chain(other.keep_outs()) {
        add(&|fence| fence.with_keep_out(*keep_out));
    }
    // Two boxes that do not overlap have no intersection. A floor of 1 km then forbids every pose,
    // which is the safe choice.
    out.or_else(|| Fence::default().with_floor(1e6).ok())
        .unwrap_or(one)
}
