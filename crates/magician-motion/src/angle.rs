//! Trigonometry in degrees. Radians occur only in this file.
//!
//! All functions come from `libm`, so results are the same on every platform.

use core::f64::consts::PI;

/// Degrees in one radian.
pub(crate) const DEGREES_PER_RADIAN: f64 = 180.0 / PI;

/// Sine and cosine of an angle in degrees.
pub(crate) fn sin_cos(degrees: f64) -> (f64, f64) {
    let angle_rad = degrees * (PI / 180.0);
    libm::sincos(angle_rad)
}

/// Angle of the vector (`x`, `y`) in degrees, -180 to 180.
pub(crate) fn atan2(y: f64, x: f64) -> f64 {
    let angle_rad = libm::atan2(y, x);
    angle_rad * DEGREES_PER_RADIAN
}
