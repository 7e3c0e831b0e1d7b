//! Speed of the external steppers, which hosts write as an integer or as a float (errata E41).

use crate::commands::{EMotor, EMotorS};

/// Largest speed read as an integer, pulses/s.
// A choice far above any stepper, below all usual floats.
const MAX_INTEGER_SPEED: u32 = 1 << 24;

/// Speed of a host that wrote it as a float (errata E41). `None` if `speed` is a plausible integer,
/// or its bits are NaN or infinite.
pub(crate) fn float_bits(speed: i32) -> Option<f32> {
    let float = f32::from_bits(speed as u32);
    (speed.unsigned_abs() > MAX_INTEGER_SPEED && float.is_finite()).then_some(float)
}

fn pulses_per_second(speed: i32) -> f64 {
    float_bits(speed).map_or(f64::from(speed), f64::from)
}

impl EMotor {
    /// Speed meant by the sender, pulses/s.
    ///
    /// The field is an integer, but hosts that follow the document write a float: beyond 2^24 in
    /// either direction the bits are read as one (errata E41).
    #[must_use]
    pub fn pulses_per_second(&self) -> f64 {
        pulses_per_second(self.speed)
    }
}

impl EMotorS {
    /// Speed meant by the sender, pulses/s; as [`EMotor::pulses_per_second`].
    #[must_use]
    pub fn pulses_per_second(&self) -> f64 {
        pulses_per_second(self.speed)
    }
}
