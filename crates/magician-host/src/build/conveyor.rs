//! External motors, and the conveyor that one of them drives (document 1.15.6, errata E41).

use magician_protocol::commands::{EMotor, EMotorS};
use magician_protocol::{Flag, Set, Stepper};

use crate::{Error, Result, message};

/// Pulses per millimetre of the vendor's conveyor: 16,000 per turn of its roller, which has a
/// diameter of 34 mm (model section 13; the figure in the vendor's own demonstration makes it run
/// 1.9 times too far).
pub const CONVEYOR_PULSES_PER_MM: f64 = 16_000.0 / (34.0 * std::f64::consts::PI);

/// Highest speed of the kit's conveyor, mm/s (model section 13): above it the motor loses steps and
/// stalls. Front ends that take a speed from a user refuse a higher one.
pub const CONVEYOR_FASTEST: f64 = 120.0;

/// Longest distance of a single conveyor command, mm: about 28.7 km.
pub const CONVEYOR_FARTHEST: f64 = u32::MAX as f64 / CONVEYOR_PULSES_PER_MM;

/// Highest pulse rate, pulses/s: no motor follows faster ones, and the arm reads far larger numbers
/// as floats (errata E41).
const FASTEST: f64 = 1_000_000.0;

/// Runs an external motor at this pulse rate, pulses/s (up to about 1,000,000 in either direction);
/// 0 stops it. The sign is the direction. The queue continues at once.
#[must_use]
pub fn motor(index: Stepper, speed: i32) -> Set {
    EMotor {
        index,
        is_enabled: (speed != 0).into(),
        speed,
    }
    .into()
}

/// Runs an external motor for this number of pulses; the sign of the speed (pulses/s) is the
/// direction. In the queue the command finishes with the motor. Not in the vendor's document.
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

/// Runs the conveyor on this motor output at this speed, mm/s.
///
/// The sign is the direction; 0 and NaN stop it. The conveyor follows up to [`CONVEYOR_FASTEST`] in
/// either direction, which [`conveyor_speed`] checks. It runs until another command stops it, and
/// the queue continues at once.
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

/// Moves the conveyor on this motor output by this distance, mm, at this speed, mm/s (its sign is
/// ignored).
///
/// The sign of the distance is the direction. In the queue the command finishes when the conveyor
/// stands still. The arm counts whole pulses, so the distance is exact to 0.0034 mm. It is limited
/// to [`CONVEYOR_FARTHEST`].
#[must_use]
pub fn conveyor_by(index: Stepper, mm: f32, mm_per_s: f32) -> Set {
    let speed = pulse_rate(mm_per_s.abs().copysign(mm));
    // Casting a float saturates, and turns NaN into 0.
    let distance = (f64::from(mm).abs() * CONVEYOR_PULSES_PER_MM).round() as u32;
    motor_by(index, speed, distance)
}

/// Checks a speed of the conveyor, mm/s.
///
/// # Errors
/// [`InvalidInput`](crate::ErrorKind::InvalidInput) above [`CONVEYOR_FASTEST`] in either direction,
/// and for NaN.
pub fn conveyor_speed(mm_per_s: f32) -> Result<f32> {
    // The comparison is false for NaN, which is refused as well.
    if f64::from(mm_per_s).abs() <= CONVEYOR_FASTEST {
        Ok(mm_per_s)
    } else {
        Err(Error::invalid(message!(
            "{speed} mm/s: the belt reaches {fastest:.0} mm/s in either direction; above it its motor stalls",
            speed = mm_per_s,
            fastest = CONVEYOR_FASTEST
        )))
    }
}

fn pulse_rate(mm_per_s: f32) -> i32 {
    let rate = f64::from(mm_per_s) * CONVEYOR_PULSES_PER_MM;
    rate.round().clamp(-FASTEST, FASTEST) as i32
}
