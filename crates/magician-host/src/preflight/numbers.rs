//! Checks of values against the ranges of the command table.

use magician_protocol::{Field, Range, Set};

use crate::{Error, Result};

/// Refuses a command with a value that is out of range or not a finite number.
pub(crate) fn check(command: &Set) -> Result<()> {
    command.check().map_err(Error::from)
}

/// Refuses a command that may burn if its duty cycle or laser power is not a number from 0 to 100
/// %.
///
/// These are the only values that are checked in commands which are otherwise sent unchanged.
///
/// # Errors
/// [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) with value and range.
pub fn check_power(command: &Set) -> Result<()> {
    let row = command.row();
    // The caller asked for raw commands, so only the danger of fire is checked.
    if !row.may_burn {
        return Ok(());
    }
    let checked = command.check_fields(is_power);
    checked.map_err(|error| Error::from(error).with_command(row.set_name))
}

fn is_power(field: &Field) -> bool {
    // Ratios of speed are capped ranges, so `Within` in percent is a share of power.
    matches!(field.range, Range::Within(..)) && field.unit == "percent"
}

#[cfg(test)]
mod tests {
    use magician_protocol::CpMode;
    use magician_protocol::commands::{CpLeCmd, IoPwm, PtpCommonParams, TABLE};

    use super::*;

    #[test]
    fn value_is_told_as_it_was_given() {
        let error = check(&Set::from(PtpCommonParams {
            velocity_ratio: 0.001,
            acceleration_ratio: 50.0,
        }))
        .unwrap_err();
        assert_eq!((error.value(), error.limit()), (Some(0.001), Some(1.0)));
        assert_eq!(error.unit(), Some("percent"));
        assert_eq!(
            error.to_string(),
            "velocity_ratio 0.001 % is below the minimum of 1 %"
        );
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
            (-1.0, "-1 % is out of range: 0 to 100 %"),
            (100.01, "100.01 % is out of range: 0 to 100 %"),
            (-1e-45, "-0.000000000000000000000000000000000000000000001 %"),
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

    /// The rule follows the table: it covers every field with a share of power.
    #[test]
    fn shares_of_power_are_the_duty_and_the_power_of_a_segment() {
        let burning = TABLE.iter().filter(|row| row.may_burn);
        let fields = burning.flat_map(|row| row.set.into_iter().flat_map(|set| set.fields));
        let shares: Vec<_> = fields
            .filter(|field| is_power(field))
            .map(|field| field.name)
            .collect();
        assert_eq!(shares, ["velocity_or_power", "duty_cycle"]);
    }
}
