//! External events of an arm, and observations of it from outside.

use magician_sim::ExternalEvent;
use magician_sim::world::Press;

use crate::words;

/// Output of a virtual arm that can be observed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Observable {
    /// Power of the laser, percent.
    Laser,
    /// Suction cup, 1 if it currently sucks.
    Suction,
    /// Gripper, 1 if it is currently closed.
    Gripper,
    /// Object held by the tool, 1 if any.
    Holding,
    /// Pulses of a stepper output.
    Pulses(usize),
}

/// Observed output with its expected value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Observation {
    pub(crate) observable: Observable,
    pub(crate) wanted: f64,
    pub(crate) tolerance: f64,
}

/// Parses an external event.
pub(super) fn parse_event(words: &[String]) -> Result<ExternalEvent, String> {
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let number = |text: &str| {
        text.parse::<f64>()
            .map_err(|_| format!("'{text}' is not a number"))
    };
    Ok(match words.as_slice() {
        ["key", "short"] => ExternalEvent::Key(Press::Short),
        ["key", "long"] => ExternalEvent::Key(Press::Long),
        ["unlock", "press"] => ExternalEvent::Unlock(true),
        ["unlock", "release"] => ExternalEvent::Unlock(false),
        ["reset"] => ExternalEvent::Reset,
        ["alarm", code] => ExternalEvent::Alarm(words::code(code)?),
        ["slip", joint, degrees] => ExternalEvent::Slip {
            joint: words::code(joint)?,
            degrees: number(degrees)?,
        },
        ["guide", j1, j2, j3, j4] => {
            ExternalEvent::Guide([number(j1)?, number(j2)?, number(j3)?, number(j4)?].into())
        }
        _ => {
            return Err(
                "expected 'key short', 'key long', 'unlock press', 'unlock release', 'reset', \
                 'alarm CODE', 'slip JOINT DEGREES' or 'guide J1 J2 J3 J4'"
                    .to_owned(),
            );
        }
    })
}

/// Parses `laser=30` or `pulses1=8000+-10`.
pub(super) fn observation(word: &str) -> Result<Observation, String> {
    const OBSERVABLES: [(&str, Observable); 6] = [
        ("laser", Observable::Laser),
        ("suction", Observable::Suction),
        ("gripper", Observable::Gripper),
        ("holding", Observable::Holding),
        ("pulses0", Observable::Pulses(0)),
        ("pulses1", Observable::Pulses(1)),
    ];
    let (name, value) = word.split_once('=').ok_or("write sees laser=30")?;
    let observable = OBSERVABLES.iter().find(|(known, _)| *known == name);
    let (_, observable) = observable.ok_or_else(|| format!("unknown observation '{name}'"))?;
    // Without a tolerance the value has to be exact.
    let (wanted, tolerance) = value.split_once("+-").unwrap_or((value, "0"));
    let number = |text: &str| {
        (text.parse::<f64>()).map_err(|_| {
            format!(
                "'{text}' is not a \
        number"
            )
        })
    };
    Ok(Observation {
        observable: *observable,
        wanted: number(wanted)?,
        tolerance: number(tolerance)?,
    })
}
