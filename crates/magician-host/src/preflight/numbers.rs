//! Numbers that are none, and values that the protocol's table does not allow.

use magician_protocol::{Case, CpMode, Ctrl, Field, FieldValue, Fields, FrameBuf, Range, Set};

use crate::{Error, Result};

/// Every number of a command is one, and within the range that its row tells.
pub(crate) fn check(command: &Set) -> Result<()> {
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
    for (field, value) in values.clone() {
        let range = range(field, values.clone());
        check_value(field, value, range)?;
        value
            .items()
            .try_for_each(|item| check_value(field, item, range))?;
    }
    Ok(())
}

/// Refuses a command that may burn with a share of power that is none: a duty or a laser power that is
/// not a number or not 0 to 100 %. The only values that are checked of commands which are otherwise
/// sent as they are given.
///
/// # Errors
/// [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) with value and range.
pub fn check_power(command: &Set) -> Result<()> {
    let row = command.row();
    if !row.may_burn || is_plainly_sound(command) {
        return Ok(());
    }
    let Some(layout) = row.set else {
        return Ok(());
    };
    let frame = FrameBuf::set(command, Ctrl::SET)?;
    for (field, value) in layout.values(frame.frame().params())? {
        let range = field.range;
        if let (FieldValue::Float(_), Range::Within(..), "percent") = (value, range, field.unit) {
            let checked = check_value(field, value, range);
            checked.map_err(|error| error.with_command(row.set_name))?;
        }
    }
    Ok(())
}

/// The range of a field, as it is beside the values of the others.
fn range(field: &Field, values: Fields<'_>) -> Range {
    match field.range {
        // Where the rail's carriage is sent is checked with the motion, which knows the mode.
        Range::Absolute(..) => Range::Any,
        Range::By(cases) => {
            let applies = |case: &&Case| {
                values.clone().any(|(field, value)| {
                    let byte = match value {
                        FieldValue::Enum(_, byte) | FieldValue::Flag(byte) => Some(byte),
                        _ => None,
                    };
                    field.name == case.field && byte == Some(case.is)
                })
            };
            let case = cases.iter().find(applies);
            case.map_or(Range::Any, |case| Range::Within(case.least, case.most))
        }
        range => range,
    }
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

fn check_value(field: &Field, value: FieldValue<'_>, range: Range) -> Result<()> {
    match value {
        FieldValue::Float(number) if !number.is_finite() => {
            let name = field.name;
            let message = format!("{name} is {number}, not a finite number");
            Err(Error::invalid(message))
        }
        FieldValue::Float(number) => check_number(field, number.into(), range),
        FieldValue::Unsigned(number) => check_number(field, number as f64, range),
        FieldValue::Signed(number) => check_number(field, number.into(), range),
        FieldValue::Enum(info, byte) if info.name_of(byte).is_none() => {
            let Field { name, range, .. } = field;
            let message = format!("{name} is {byte}, it must be {range}");
            Err(Error::invalid(message).with_value(byte.into(), name))
        }
        FieldValue::Enum(_, byte) => check_number(field, byte.into(), range),
        FieldValue::Text(text) => check_count(field, text.len(), range),
        FieldValue::Outputs(list) => {
            check_count(field, list.as_slice().len(), range)?;
            list.as_slice().iter().try_for_each(|output| {
                check_within("ratio", output.ratio.into(), 0.0, 100.0, "%")?;
                check_within("address", output.address.into(), 1.0, 20.0, "EIO address")?;
                check_within("level", output.level.into(), 0.0, 1.0, "level")
            })
        }
        _ => Ok(()),
    }
}

fn check_number(field: &Field, number: f64, range: Range) -> Result<()> {
    let Field { name, unit, .. } = *field;
    let broken = match range {
        Range::Above(limit) => Some(f64::from(limit)).filter(|limit| number <= *limit),
        // More than the most of a capped one is taken for the most, and does no harm.
        Range::Within(least, _) | Range::Capped(least, _) if number < f64::from(least) => {
            Some(least.into())
        }
        Range::Within(_, most) => Some(f64::from(most)).filter(|most| number > *most),
        _ => None,
    };
    broken.map_or(Ok(()), |limit| {
        let message = match range {
            Range::Above(limit) => {
                format!("{name} is {number} {unit}, it must be above {limit}")
            }
            Range::Within(..) if unit == "percent" => {
                // As short as it was given: the wire has 32 bits.
                format!(
                    "{name} is {} %, it must be {} %",
                    number as f32, field.range
                )
            }
            _ => format!("{name} is {number}, it must be {} ({unit})", field.range),
        };
        Err(Error::invalid(message).with_limit(number, limit, unit))
    })
}

fn check_count(field: &Field, count: usize, range: Range) -> Result<()> {
    match range {
        Range::AtMost(most, of) if count > usize::from(most) => {
            let message = format!("{} has {count} {of}, limit {most}", field.name);
            Err(Error::invalid(message).with_limit(count as f64, most.into(), of))
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
    use magician_protocol::commands::{
        CpCmd, CpLeCmd, DeviceSn, IoPwm, JogCommonParams, PtpCommonParams, TABLE, TrigCmd,
    };
    use magician_protocol::{Text, TriggerCondition, TriggerMode};

    use super::*;

    fn trigger(mode: u8, condition: u8, threshold: u16) -> Set {
        Set::TrigCmd(TrigCmd {
            address: 4,
            mode: TriggerMode::from(mode),
            condition: TriggerCondition::from(condition),
            threshold,
        })
    }

    #[test]
    fn an_input_is_waited_for_with_values_that_it_can_have() {
        for (mode, condition, threshold, sound) in [
            (0, 0, 0, true),
            (0, 1, 1, true),
            (0, 2, 1, false),
            (0, 3, 0, false),
            (0, 0, 2, false),
            (1, 3, 2, true),
            (1, 3, 4095, true),
            (1, 3, 4096, false),
            (1, 0, 60_000, false),
            (1, 4, 0, false),
            (2, 0, 0, false),
        ] {
            let checked = check(&trigger(mode, condition, threshold));
            assert_eq!(checked.is_ok(), sound, "{mode} {condition} {threshold}");
        }
        let error = check(&trigger(1, 0, 60_000)).unwrap_err();
        assert_eq!(
            (error.value(), error.limit()),
            (Some(60_000.0), Some(4095.0))
        );
        let said = "threshold is 60000, it must be 0 or 1 for levels, 0 to 4095 for analog values \
                    (level or counts)";
        assert_eq!(error.to_string(), said);
    }

    #[test]
    fn a_share_of_the_speed_is_one_percent_at_least_and_more_than_all_is_all() {
        for (ratio, sound) in [
            (0.001, false),
            (0.99, false),
            (1.0, true),
            (100.0, true),
            (500.0, true),
        ] {
            let [velocity_ratio, acceleration_ratio] = [ratio, 50.0];
            let moves = PtpCommonParams {
                velocity_ratio,
                acceleration_ratio,
            };
            let jogs = JogCommonParams {
                velocity_ratio: acceleration_ratio,
                acceleration_ratio: velocity_ratio,
            };
            assert_eq!(check(&Set::from(moves)).is_ok(), sound, "{ratio}");
            assert_eq!(check(&Set::from(jogs)).is_ok(), sound, "{ratio}");
        }
    }

    #[test]
    fn a_name_that_does_not_fit_is_refused() {
        for (length, sound) in [(23, true), (24, false)] {
            let device_sn = Text::new(&"A".repeat(length)).unwrap();
            let checked = check(&Set::from(DeviceSn { device_sn }));
            assert_eq!(checked.is_ok(), sound, "{length}");
        }
    }

    #[test]
    fn share_of_power_out_of_range_is_refused_with_value_and_range() {
        let duty = |address, duty_cycle| {
            Set::from(IoPwm {
                address,
                frequency: 5.0,
                duty_cycle,
            })
        };
        let power = |velocity_or_power| {
            Set::from(CpLeCmd {
                cp_mode: CpMode::from(7),
                x: f32::NAN,
                y: 0.0,
                z: 0.0,
                velocity_or_power,
            })
        };
        for share in [0.0, -0.0, f32::MIN_POSITIVE, 1e-45, 50.0, 100.0] {
            for command in [duty(4, share), duty(6, share), power(share)] {
                check_power(&command).unwrap_or_else(|error| panic!("{command:?}: {error}"));
            }
        }
        for (share, said) in [
            (-1.0, "is -1 %, it must be 0 to 100 %"),
            (100.01, "is 100.01 %, it must be 0 to 100 %"),
            (
                -1e-45,
                "is -0.000000000000000000000000000000000000000000001 %",
            ),
            (f32::NAN, "is NaN, not a finite number"),
            (f32::INFINITY, "is inf, not a finite number"),
            (f32::NEG_INFINITY, "is -inf, not a finite number"),
        ] {
            for (command, name) in [
                (duty(4, share), "IOPWM: duty_cycle"),
                (duty(200, share), "IOPWM: duty_cycle"),
                (power(share), "CPLECmd: velocity_or_power"),
            ] {
                let error = check_power(&command).unwrap_err().to_string();
                assert!(error.contains(&format!("{name} {said}")), "{error}");
            }
        }
    }

    /// The rule follows the table: what it holds is all that has a share of power.
    #[test]
    fn shares_of_power_are_the_duty_and_the_power_of_a_segment() {
        let burning = TABLE.iter().filter(|row| row.may_burn);
        let fields = burning.flat_map(|row| row.set.into_iter().flat_map(|set| set.fields));
        let shares = fields
            .filter(|field| matches!(field.range, Range::Within(..)) && field.unit == "percent");
        let shares: Vec<_> = shares.map(|field| field.name).collect();
        assert_eq!(shares, ["velocity_or_power", "duty_cycle"]);
    }

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
