//! Errors of ranges as messages. `magician-protocol` has the same sentences without templates;
//! assertions keep both equal.

use magician_protocol::{Range, RangeError};

use crate::{Message, message};

/// Returns the message for a field whose value is out of range.
pub(super) fn of_range(error: &RangeError) -> Message {
    let mut field = error.field.to_owned();
    if let Some(item) = error.item {
        field += &format!("[{item}]");
    }
    if let Some(part) = error.part {
        field += &format!(".{part}");
    }
    let number = error.value.to_string();
    let value = with_unit(&number, error.unit);
    let message = match error.range {
        Range::Any => message!(
            "{field} is {value}, not a finite number",
            field,
            value = number
        ),
        Range::AtMost(most, of) => {
            let of = Message::word(of);
            message!(
                "{field} has {count} {of}, limit {most}",
                field,
                count = number,
                of,
                most
            )
        }
        Range::Above(limit) => message!(
            "{field} {value} must be above {limit}",
            field,
            value,
            limit = with_unit(&limit.to_string(), error.unit)
        ),
        Range::Capped(least, _) => message!(
            "{field} {value} is below the minimum of {least}",
            field,
            value,
            least = with_unit(&least.to_string(), error.unit)
        ),
        Range::Within(least, most) => message!(
            "{field} {value} is out of range: {range}",
            field,
            value,
            range = interval(least, most, &with_unit(&most.to_string(), error.unit))
        ),
        // The error names only the case in force.
        Range::By([case]) => {
            // Unlike the unit of a field, that of a case is never a description.
            let last = format!("{} {}", case.most, case.unit);
            message!(
                "{field} {value} is out of range: {range} in {mode}",
                field,
                value = number,
                range = interval(case.least, case.most, last.trim_end()),
                mode = Message::word(case.name)
            )
        }
        // A range that no check reports.
        _ => error.to_string().into(),
    };
    debug_assert_eq!(message, error.to_string());
    message
}

/// Returns both bounds; `last` is the upper one with its unit.
fn interval(least: i32, most: i32, last: &str) -> Message {
    match most.wrapping_sub(least) {
        0 => last.into(),
        1 => message!("{least} or {most}", least, most = last),
        _ => message!("{least} to {most}", least, most = last),
    }
}

/// Appends the unit to a number. Descriptions such as "flag" or "code" are no units.
fn with_unit(number: &str, unit: &'static str) -> String {
    match unit {
        "percent" => format!("{number} %"),
        "mm" | "deg" | "mm/s" | "deg/s" | "mm/s^2" | "deg/s^2" | "Hz" | "turns" => {
            format!("{number} {unit}")
        }
        _ => number.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use magician_protocol::commands::{PtpCommonParams, TrigCmd};
    use magician_protocol::{Layout, TriggerCondition, TriggerMode};

    use super::*;

    #[test]
    fn error_of_each_range_has_a_template() {
        let ratio = |velocity_ratio| PtpCommonParams {
            velocity_ratio,
            acceleration_ratio: 50.0,
        };
        let trigger = |address, mode, threshold| TrigCmd {
            address,
            mode,
            condition: TriggerCondition::from(0),
            threshold,
        };
        let (level, analog) = (TriggerMode::Level, TriggerMode::Analog);
        for (error, text) in [
            (
                ratio(0.001).check(),
                "velocity_ratio 0.001 % is below the minimum of 1 %",
            ),
            (
                ratio(f32::NAN).check(),
                "velocity_ratio is NaN, not a finite number",
            ),
            (
                trigger(21, level, 0).check(),
                "address 21 is out of range: 1 to 20",
            ),
            (
                trigger(1, level, 2).check(),
                "threshold 2 is out of range: 0 or 1 in level mode",
            ),
            (
                trigger(1, analog, 5000).check(),
                "threshold 5000 is out of range: 0 to 4095 counts in analog mode",
            ),
        ] {
            let message = of_range(&error.expect_err(text));
            assert_eq!(message, text);
            assert!(message.template().is_some(), "{text}");
        }
    }
}
