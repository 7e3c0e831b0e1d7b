//! Sensor calibration (document 1.16) and what little is known of its neighbours.

use magician_protocol::NoArgs;
use magician_protocol::commands::*;

use crate::device::context::Context;
use crate::device::handlers::{Report, kept, not_simulated, stored};

kept!(
    AngleSensorStaticError in angle_error,
    AngleSensorCoef in angle_coef,
    BaseDecoderStaticError in base_error,
);
stored!(PulseMode in pulse_mode);
not_simulated!(ZdfCalibRequest);

impl Report for ZdfCalibStatus {
    fn report(_: &mut Context<'_>, _: &NoArgs) -> Self {
        Self { status: 0 }
    }
}
