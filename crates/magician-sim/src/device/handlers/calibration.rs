//! Sensor calibration (document 1.16), and undocumented commands with neighbouring ids.

use magician_protocol::NoArgs;
use magician_protocol::commands::*;

use crate::device::context::Context;
use crate::device::handlers::{Report, kept, not_simulated, stored};
use crate::fidelity::Assumption;

kept! {
    AngleSensorStaticError in angle_error: StoredWithoutEffect;
    AngleSensorCoef in angle_coef: StoredWithoutEffect;
    BaseDecoderStaticError in base_error: StoredWithoutEffect;
}
stored! { PulseMode in pulse_mode: OutsideTheDocument; }
not_simulated! { ZdfCalibRequest: OutsideTheDocument; }

impl Report for ZdfCalibStatus {
    const ASSUMPTION: Assumption = Assumption::Zeros;

    fn report(_: &mut Context<'_>, _: &NoArgs) -> Self {
        Self { status: 0 }
    }
}
