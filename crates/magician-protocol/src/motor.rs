use crate::commands::{EMotor, EMotorS};

/// Fastest speed that is read as a whole number, pulses/s; no stepper comes near it.
const FASTEST: u32 = 1 << 24;

/// What a speed means to a host that wrote it as a float (errata E41); `None` when it is a
/// plausible whole number, or the float would be none.
pub(crate) fn float_bits(speed: i32) -> Option<f32> {
    let float = f32::from_bits(speed as u32);
    (speed.unsigned_abs() > FASTEST && float.is_finite()).then_some(float)
}

fn pulses_per_second(speed: i32) -> f64 {
    float_bits(speed).map_or(f64::from(speed), f64::from)
}

impl EMotor {
    /// The speed that the sender meant, pulses/s. The field is a whole number, but hosts that
    /// follow the document write a float: beyond 2^24 either way the bits are read as one
    /// (errata E41).
    #[must_use]
    pub fn pulses_per_second(&self) -> f64 {
        pulses_per_second(self.speed)
    }
}

impl EMotorS {
    /// The speed that the sender meant, pulses/s; as [`EMotor::pulses_per_second`].
    #[must_use]
    pub fn pulses_per_second(&self) -> f64 {
        pulses_per_second(self.speed)
    }
}
