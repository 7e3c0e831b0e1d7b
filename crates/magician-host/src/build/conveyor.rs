//! Motors beside the arm, and the conveyor belt that one of them drives (document 1.15.6, errata E41).

use magician_protocol::commands::{EMotor, EMotorS};
use magician_protocol::{Flag, Set, Stepper};

use crate::{Error, Result};

/// Pulses that move the vendor's belt by 1 mm: 16,000 for a turn of its roller, which is 34 mm across
/// (model section 13; the vendor's own demonstration has a figure that runs 1.9 times too far).
pub const CONVEYOR_PULSES_PER_MM: f64 = 16_000.0 / (34.0 * std::f64::consts::PI);

/// Highest speed of the kit's belt, mm/s (model section 13): above it the motor loses steps and stalls.
/// Commands that run a belt faster are refused by who takes the speed from a person or program.
pub const CONVEYOR_FASTEST: f64 = 120.0;

/// The longest way that a belt is told to move, mm: about 28 km.
pub const CONVEYOR_FARTHEST: f64 = u32::MAX as f64 / CONVEYOR_PULSES_PER_MM;

/// Faster pulses than any motor follows, pulses/s. Beyond, the arm reads the number as another one (errata E41).
const FASTEST: f64 = 1_000_000.0;

/// Runs an external motor at so many pulses a second (to about 1,000,000 either way); 0 stops it. The sign is the
/// direction. The queue goes on at once.
#[must_use]
pub fn motor(index: Stepper, speed: i32) -> Set {
    EMotor {
        index,
        is_enabled: (speed != 0).into(),
        speed,
    }
    .into()
}

/// Runs an external motor so many pulses far; the sign of the speed (pulses/s) is the direction. In the
/// queue it has finished when the motor has. Not in the vendor's document.
#[must_use]
pub fn motor_by(index: Stepper, speed: i32, distance: u32) -> Set {
    EMotorS {
        index,
        is_enabled: Flag::ON,
        speed,
        distance,
    }
    .into()
}

/// Runs the conveyor belt on this motor output at so many mm/s; the sign is the direction, 0 stops it, and so does what
/// is not a number. The belt keeps up with [`CONVEYOR_FASTEST`] either way, which [`conveyor_speed`] checks. It runs on
/// until it is told otherwise, and the queue goes on at once.
///
/// ```
/// use magician_host::protocol::Stepper;
/// use magician_host::build;
///
/// let feed = [
///     build::conveyor(Stepper::Stepper1, 50.0),
///     build::wait_for_level(19, true),
///     build::conveyor(Stepper::Stepper1, 0.0),
/// ];
/// # assert_eq!(feed.len(), 3);
/// ```
#[must_use]
pub fn conveyor(index: Stepper, mm_per_s: f32) -> Set {
    motor(index, pulse_rate(mm_per_s))
}

/// Moves the conveyor belt on this motor output by so many mm, at so many mm/s (of either sign). The
/// sign of the way is the direction. In the queue it has finished when the belt stands again.
///
/// The arm counts whole pulses: the way is exact to 0.0034 mm, and at most 28 km.
#[must_use]
pub fn conveyor_by(index: Stepper, mm: f32, mm_per_s: f32) -> Set {
    let speed = pulse_rate(mm_per_s.abs().copysign(mm));
    // A cast of a float saturates, and takes NaN to 0.
    let distance = (f64::from(mm).abs() * CONVEYOR_PULSES_PER_MM).round() as u32;
    motor_by(index, speed, distance)
}

/// Checks a speed of the belt, mm/s.
///
/// # Errors
/// [`InvalidInput`](crate::ErrorKind::InvalidInput) above [`CONVEYOR_FASTEST`] in either direction, and for what is not a
/// number.
pub fn conveyor_speed(mm_per_s: f32) -> Result<f32> {
    if f64::from(mm_per_s).abs() <= CONVEYOR_FASTEST {
        Ok(mm_per_s)
    } else {
        Err(Error::invalid(format!(
            "{mm_per_s} mm/s: the belt reaches {CONVEYOR_FASTEST:.0} mm/s in either direction; above it its motor stalls"
        )))
    }
}

fn pulse_rate(mm_per_s: f32) -> i32 {
    let rate = f64::from(mm_per_s) * CONVEYOR_PULSES_PER_MM;
    rate.round().clamp(-FASTEST, FASTEST) as i32
}
