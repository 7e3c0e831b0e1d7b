//! Waits, triggers and pins. Model section 13 lists the pins and their functions.

use std::time::Duration;

use magician_protocol::commands::{
    IoDo, IoMultiplexing, IoPwm, PtpPoCmd, PtpPoWithLCmd, TrigCmd, WaitCmd,
};
use magician_protocol::{IoFunction, PoCmd, PoList, Set, TriggerCondition, TriggerMode};

use super::rail::{MAX_OUTPUTS, no_move};
use crate::{Error, Result, message};

/// Makes the queue wait, with millisecond resolution and for at most 49 days (document 1.13.1,
/// errata E34).
#[must_use]
pub fn wait(time: Duration) -> Set {
    // Saturates: a wait that does not fit the field is longer than any program anyway.
    let timeout = u32::try_from(time.as_millis()).unwrap_or(u32::MAX);
    WaitCmd { timeout }.into()
}

/// Makes the queue wait until a digital input (EIO address 1 to 20) has this level, without a time
/// limit (document 1.14.1, errata E35).
#[must_use]
pub fn wait_for_level(address: u8, level: bool) -> Set {
    TrigCmd {
        address,
        mode: TriggerMode::Level,
        condition: TriggerCondition::EqualOrBelow,
        threshold: level.into(),
    }
    .into()
}

/// Makes the queue wait until an analog input (EIO address 1 to 20) satisfies a condition, without
/// a time limit (document 1.14.1, errata E35).
///
/// The threshold is 0 to 4095 counts, 4095 at 3.3 V. For analog inputs
/// [`EqualOrBelow`](TriggerCondition::EqualOrBelow) means below, and
/// [`DifferentOrAtMost`](TriggerCondition::DifferentOrAtMost) at most; [`wait_below`],
/// [`wait_at_most`], [`wait_at_least`] and [`wait_above`] have clearer names.
#[must_use]
pub fn wait_for_analog(address: u8, condition: TriggerCondition, threshold: u16) -> Set {
    let mode = TriggerMode::Analog;
    TrigCmd {
        address,
        mode,
        condition,
        threshold,
    }
    .into()
}

/// Like [`wait_for_analog`], until the input is below the threshold.
#[must_use]
pub fn wait_below(address: u8, threshold: u16) -> Set {
    wait_for_analog(address, TriggerCondition::EqualOrBelow, threshold)
}

/// Like [`wait_for_analog`], until the input is at most the threshold.
#[must_use]
pub fn wait_at_most(address: u8, threshold: u16) -> Set {
    wait_for_analog(address, TriggerCondition::DifferentOrAtMost, threshold)
}

/// Like [`wait_for_analog`], until the input is at least the threshold.
#[must_use]
pub fn wait_at_least(address: u8, threshold: u16) -> Set {
    wait_for_analog(address, TriggerCondition::AtLeast, threshold)
}

/// Like [`wait_for_analog`], until the input is above the threshold.
#[must_use]
pub fn wait_above(address: u8, threshold: u16) -> Set {
    wait_for_analog(address, TriggerCondition::Above, threshold)
}

/// Sets the function of an EIO pin (1 to 20), which it needs before use (document 1.15.1, errata
/// E40).
#[must_use]
pub fn multiplex(address: u8, function: IoFunction) -> Set {
    IoMultiplexing {
        address,
        multiplex: function,
    }
    .into()
}

/// Sets the level of a digital output (EIO address 1 to 20; document 1.15.2).
#[must_use]
pub fn output(address: u8, high: bool) -> Set {
    IoDo {
        address,
        level: high.into(),
    }
    .into()
}

/// Sets a pulse-width output (EIO address 1 to 20): frequency 10 to 1000000 Hz, duty cycle in
/// percent (document 1.15.3).
#[must_use]
pub fn pwm(address: u8, frequency: f32, duty_cycle: f32) -> Set {
    IoPwm {
        address,
        frequency,
        duty_cycle,
    }
    .into()
}

/// Turns a hobby servo on a pulse-width pin (EIO 4, 6, 8, 11 or 14) by its pulse length, ms, at 50
/// pulses per second.
///
/// 1.5 ms is the middle of most servos; all accept 1 to 2 ms, many 0.5 to 2.5 ms. 0 switches the
/// servo off, and 20 ms is the maximum. Multiplex the pin to [`IoFunction::Pwm`] first (model
/// section 13: EIO 8, 6 and 4 have driven servos).
///
/// ```
/// use magician_host::protocol::IoFunction;
/// use magician_host::build;
///
/// let middle = [build::multiplex(8, IoFunction::Pwm), build::servo(8, 1.5)];
/// assert_eq!(middle[1], build::pwm(8, 50.0, 7.5));
/// ```
#[must_use]
pub fn servo(address: u8, pulse_ms: f32) -> Set {
    // A servo expects a pulse every 20 ms, which is 50 Hz.
    pwm(address, 50.0, 100.0 * pulse_ms / 20.0)
}

/// An output that a move switches on its way.
///
/// ```
/// use magician_host::build::{self, Output};
///
/// let at_the_top = Output { percent: 50, address: 17, high: true };
/// let jump = build::with_outputs(build::jump_to(220.0, 0.0, 20.0, 0.0), &[at_the_top])?;
/// # Ok::<(), magician_host::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Output {
    /// Share of the move after which it switches, 0 to 100 percent.
    pub percent: u8,
    /// EIO address, 1 to 20.
    pub address: u8,
    /// Level to set.
    pub high: bool,
}

/// Makes any point-to-point move switch outputs on its way, in any order: at most 57, with the rail
/// 56 (document 1.10.9 and 1.10.10, errata E29).
///
/// They replace the outputs that the move had.
///
/// # Errors
/// [`InvalidInput`](crate::ErrorKind::InvalidInput) for any other command than a point-to-point
/// move, and for too many outputs.
pub fn with_outputs(command: Set, outputs: &[Output]) -> Result<Set> {
    let list: Vec<PoCmd> = outputs
        .iter()
        .map(|output| PoCmd {
            ratio: output.percent,
            address: output.address.into(),
            level: output.high.into(),
        })
        .collect();
    // The rail position takes four bytes of the frame, the size of one output.
    let on_rail = matches!(command, Set::PtpWithLCmd(_) | Set::PtpPoWithLCmd(_));
    let most = if on_rail {
        MAX_OUTPUTS
    } else {
        PoList::CAPACITY
    };
    let list = PoList::new(&list).filter(|_| list.len() <= most);
    let po = list.ok_or_else(|| {
        let count = outputs.len();
        Error::invalid(message!(
            "{count} outputs on the way, limit {most}",
            count,
            most
        ))
    })?;
    macro_rules! switching {
        ($to:ident, $ptp:ident $(, $l:ident)?) => {
            $to {
                ptp_mode: $ptp.ptp_mode,
                x: $ptp.x,
                y: $ptp.y,
                z: $ptp.z,
                r: $ptp.r,
                $($l: $ptp.$l,)?
                po,
            }
            .into()
        };
    }
    Ok(match command {
        Set::PtpCmd(ptp) => switching!(PtpPoCmd, ptp),
        Set::PtpPoCmd(ptp) => switching!(PtpPoCmd, ptp),
        Set::PtpWithLCmd(ptp) => switching!(PtpPoWithLCmd, ptp, l),
        Set::PtpPoWithLCmd(ptp) => switching!(PtpPoWithLCmd, ptp, l),
        // Only point-to-point moves have a form with outputs.
        other => return Err(no_move(&other)),
    })
}
