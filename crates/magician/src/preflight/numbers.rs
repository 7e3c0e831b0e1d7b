//! Numbers that are none, and values that the protocol's table does not allow.

use magician_protocol::{CpMode, Ctrl, Field, FieldValue, FrameBuf, Set};

use crate::{Error, Result};

/// The rail's place, or the way there: what it may be depends on the mode.
const RAIL: &str = "l";

/// Every number of a command is one, and within the range that its row tells.
pub(super) fn check(command: &Set) -> Result<()> {
    match is_plainly_sound(command) {
        true => Ok(()),
        false => check_by_table(command),
    }
}

fn check_by_table(command: &Set) -> Result<()> {
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

/// Whether nothing can be wrong with it, told without the table: of the segments of which drawings have a million.
fn is_plainly_sound(command: &Set) -> bool {
    let known = |mode| matches!(mode, CpMode::Absolute | CpMode::Relative);
    let finite = |numbers: [f32; 4]| numbers.iter().all(|number| number.is_finite());
    match command {
        Set::CpCmd(cp) => known(cp.cp_mode) && finite([cp.x, cp.y, cp.z, cp.velocity_or_power]),
        Set::CpLeCmd(cp) => {
            let power = cp.velocity_or_power;
            known(cp.cp_mode) && finite([cp.x, cp.y, cp.z, power]) && (0.0..=100.0).contains(&power)
        }
        _ => false,
    }
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

#[cfg(test)]
mod tests {
    use magician_protocol::commands::{CpCmd, CpLeCmd};

    use super::*;

    #[test]
    fn what_is_sound_without_the_table_is_sound_by_it() {
        let numbers = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            100.0,
            100.01,
            1e30,
            f32::NAN,
            f32::INFINITY,
        ];
        let mut plain = 0;
        for cp_mode in [0, 1, 2].map(CpMode::from) {
            for x in numbers {
                for velocity_or_power in numbers {
                    let cp = CpCmd {
                        cp_mode,
                        x,
                        y: 0.0,
                        z: 0.0,
                        velocity_or_power,
                    };
                    let le = CpLeCmd {
                        cp_mode,
                        x,
                        y: 0.0,
                        z: 0.0,
                        velocity_or_power,
                    };
                    for command in [Set::from(cp), Set::from(le)] {
                        let by_table = check_by_table(&command).is_ok();
                        assert_eq!(is_plainly_sound(&command), by_table, "{command:?}");
                        plain += u32::from(by_table);
                    }
                }
            }
        }
        assert!(plain > 50);
    }
}
