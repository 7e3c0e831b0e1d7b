//! Path for measurements: a ring of short segments.

use std::f64::consts::TAU;

use magician::preflight::Preflight;
use magician::{Arm, Result};
use magician_protocol::commands::{CpCmd, CpParams, Pose};
use magician_protocol::{CpMode, Flag, Set};

/// Radius of the ring, mm.
const RADIUS: f64 = 10.0;
/// Acceleration, mm/s^2: the highest the arm allows. The arm always plans to stop at the end of its
/// queue, so the acceleration limits the speed of short segments.
const ACCELERATION: f32 = 1000.0;

/// Horizontal circle of 20 mm diameter, as an endless path of short absolute segments. It begins at
/// the current position; its centre is on the side of the base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    centre: [f64; 2],
    z: f32,
    start_angle: f64,
    segment_angle: f64,
    speed: f32,
}

/// Returns the angle of a segment, such that a whole number of them makes a ring.
fn segment_angle(length: f64) -> f64 {
    // Clamped, so that a mistyped length neither loops forever nor leaves the ring.
    TAU / (TAU * RADIUS / length.clamp(0.01, RADIUS)).ceil()
}

impl Ring {
    /// Creates a ring through a pose, with segments of `length` mm at up to `speed` mm/s.
    #[must_use]
    pub fn through(pose: &Pose, length: f64, speed: f32) -> Self {
        let (x, y) = (f64::from(pose.x), f64::from(pose.y));
        let start_angle = y.atan2(x);
        Self {
            // Towards the base, because the arm may stand at the edge of its reach.
            centre: [
                x - RADIUS * start_angle.cos(),
                y - RADIUS * start_angle.sin(),
            ],
            z: pose.z,
            start_angle,
            segment_angle: segment_angle(length),
            speed,
        }
    }

    /// Creates a ring through the current position, after checking all of it.
    ///
    /// # Errors
    /// [`ErrorKind::Unreachable`](magician::ErrorKind::Unreachable) if part of it is out of reach,
    /// else as [`Arm::get`].
    pub async fn here(arm: &Arm, length: f64, speed: f32) -> Result<Self> {
        let pose = arm.get::<Pose>().await?;
        let ring = Self::through(&pose, length, speed);
        let mut check: Preflight = arm.preflight().await?;
        for command in ring.segments().take((TAU / ring.segment_angle) as usize) {
            check.check(&command)?;
        }
        Ok(ring)
    }

    /// Returns the same ring with segments of another length and speed.
    #[must_use]
    pub fn cut(self, length: f64, speed: f32) -> Self {
        let segment_angle = segment_angle(length);
        Self {
            segment_angle,
            speed,
            ..self
        }
    }

    /// Returns the segment to the start and end of the ring.
    #[must_use]
    pub fn back(self) -> Set {
        self.point(0)
    }

    /// Returns the segments, round after round without end.
    pub fn segments(self) -> impl Iterator<Item = Set> {
        (1_u32..).map(move |count| self.point(count))
    }

    /// Returns the end of a segment.
    fn point(self, count: u32) -> Set {
        let angle = self.start_angle + (f64::from(count) * self.segment_angle) % TAU;
        let [x, y] = self.centre;
        CpCmd {
            cp_mode: CpMode::Absolute,
            x: (x + RADIUS * angle.cos()) as f32,
            y: (y + RADIUS * angle.sin()) as f32,
            z: self.z,
            velocity_or_power: 0.0,
        }
        .into()
    }

    /// Returns the path speeds for the ring.
    #[must_use]
    pub fn speeds(self) -> CpParams {
        CpParams {
            plan_acc: ACCELERATION,
            junction_vel: self.speed,
            acc_or_period: ACCELERATION,
            real_time_track: Flag::OFF,
        }
    }

    /// Returns the segments per second at full speed.
    #[must_use]
    pub fn segments_per_second(self) -> f64 {
        f64::from(self.speed) / (2.0 * RADIUS * (self.segment_angle / 2.0).sin())
    }
}

#[cfg(test)]
mod tests {
    use magician_protocol::Layout;

    use super::*;

    #[test]
    fn ring_closes_and_segments_have_the_requested_length() {
        let mut pose = Pose::decode(&[0; 32]).unwrap();
        (pose.y, pose.z) = (200.0, 30.0);
        let ring = Ring::through(&pose, 0.2, 90.0);
        assert!((ring.segments_per_second() - 450.0).abs() < 2.0);
        let count = (TAU / ring.segment_angle).round() as usize;
        let points: Vec<_> = ring.segments().take(count).collect();
        let Some(Set::CpCmd(last)) = points.last() else {
            panic!("{points:?}");
        };
        assert!((last.x - pose.x).hypot(last.y - pose.y) < 1e-3, "{last:?}");
        for point in &points {
            let Set::CpCmd(point) = point else {
                panic!("{point:?}")
            };
            assert!((f64::from(point.x).hypot(f64::from(point.y) - 190.0) - 10.0).abs() < 1e-4);
        }
    }
}
