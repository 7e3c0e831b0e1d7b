//! Numbers that are none, and values that the protocol's table does not allow.

use magician_protocol::{Ctrl, Field, FieldValue, FrameBuf, Set};

use crate::{Error, Result};

/// The rail's place, or the way there: what it may be depends on the mode.
const RAIL: &str = "l";

/// Every number of a command is one, and within the range that its row tells.
pub(super) fn check(command: &Set) -> Result<()> {
    let frame = FrameBuf::set(command, Ctrl::SET)?;
    let Some(layout) = command.row().set else {
        return Ok(());
    };
    let values = layout.values(frame.frame().params())?;
    for (field, value) in values {
        check_value(field, value)?;
        value
            .items()
            .try_for_each(|item| check_value(field, item))?;
    }
    Ok(())
}

fn check_value(field: &Field, value: FieldValue<'_>) -> Result<()> {
    match value {
        FieldValue::Float(number) => check_float(field, number),
        FieldValue::Unsigned(number) => check_range(field, number as f64),
        FieldValue::Enum(info, byte) if info.name_of(byte).is_none() => {
            let Field { name, range, .. } = field;
            let message = format!("{name} is {byte}, which does not exist; there are {range}");
            Err(Error::invalid(message).with_value(byte.into(), name))
        }
        FieldValue::Outputs(list) => list.as_slice().iter().try_for_each(|output| {
            check_within("ratio", output.ratio.into(), 0.0, 100.0, "%")?;
            check_within("address", output.address.into(), 1.0, 20.0, "EIO address")?;
            check_within("level", output.level.into(), 0.0, 1.0, "level")
        }),
        _ => Ok(()),
    }
}

fn check_float(field: &Field, number: f32) -> Result<()> {
    let name = field.name;
    if !number.is_finite() {
        return Err(Error::invalid(format!(
            "{name} is {number}, which is no number"
        )));
    }
    let above_zero = field.range == "above 0" || field.range.ends_with("more counts as 100");
    if above_zero && number <= 0.0 {
        let message = format!("{name} is {number} {}, it must be above 0", field.unit);
        return Err(Error::invalid(message).with_limit(number.into(), 0.0, field.unit));
    }
    check_range(field, number.into())
}

/// The range of the table, if it is two numbers and nothing else.
fn check_range(field: &Field, number: f64) -> Result<()> {
    let Some((low, high)) = field.range.split_once(" to ") else {
        return Ok(());
    };
    match (low.parse::<f64>(), high.parse::<f64>()) {
        (Ok(low), Ok(high)) if field.name != RAIL => {
            check_within(field.name, number, low, high, field.unit)
        }
        _ => Ok(()),
    }
}

fn check_within(name: &str, number: f64, low: f64, high: f64, unit: &'static str) -> Result<()> {
    if (low..=high).contains(&number) {
        return Ok(());
    }
    let limit = if number < low { low } else { high };
    let message = format!("{name} is {number}, it must be {low} to {high} ({unit})");
    Err(Error::invalid(message).with_limit(number, limit, unit))
}
