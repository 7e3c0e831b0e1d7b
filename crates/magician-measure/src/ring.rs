use std::f64::consts::TAU;

use magician::preflight::Preflight;
use magician::{Arm, Result};
use magician_protocol::commands::{CpCmd, CpParams, Pose};
use magician_protocol::{CpMode, Flag, Set};

/// Radius of the ring, mm.
const RADIUS: f64 = 10.0;
/// Acceleration, mm/s^2: as much as the arm gives. It brakes to a stand at the end of what its queue holds, so this
/// bounds the speed in short segments.
const ACCELERATION: f32 = 1000.0;

/// A level ring of 20 mm that passes through where the arm stands and lies towards its base: an endless path of short
/// segments, all absolute.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    centre: [f64; 2],
    z: f32,
    begin: f64,
    step: f64,
    speed: f32,
}

/// The angle of a segment: so many of them are a whole ring.
fn step(length: f64) -> f64 {
    TAU / (TAU * RADIUS / length.clamp(0.01, RADIUS)).ceil()
}

impl Ring {
    /// Through a pose, with segments of `length` mm at up to `speed` mm/s.
    #[must_use]
    pub fn through(pose: &Pose, length: f64, speed: f32) -> Self {
        let (x, y) = (f64::from(pose.x), f64::from(pose.y));
        let begin = y.atan2(x);
        Self {
            centre: [x - RADIUS * begin.cos(), y - RADIUS * begin.sin()],
            z: pose.z,
            begin,
            step: step(length),
            speed,
        }
    }

    /// Through where the arm stands now, after the whole ring was checked.
    ///
    /// # Errors
    /// [`ErrorKind::Unreachable`](magician::ErrorKind::Unreachable) when part of it is out of reach, else as [`Arm::get`].
    pub async fn here(arm: &Arm, length: f64, speed: f32) -> Result<Self> {
        let pose = arm.get::<Pose>().await?;
        let ring = Self::through(&pose, length, speed);
        let mut check: Preflight = arm.preflight().await?;
        for command in ring.segments().take((TAU / ring.step) as usize) {
            check.check(&command)?;
        }
        Ok(ring)
    }

    /// The same ring in other segments.
    #[must_use]
    pub fn cut(self, length: f64, speed: f32) -> Self {
        let step = step(length);
        Self {
            step,
            speed,
            ..self
        }
    }

    /// The segment to where the ring begins and ends.
    #[must_use]
    pub fn back(self) -> Set {
        self.point(0)
    }

    /// The segments, for ever.
    pub fn segments(self) -> impl Iterator<Item = Set> {
        (1_u32..).map(move |count| self.point(count))
    }

    /// The end of a segment.
    fn point(self, count: u32) -> Set {
        let angle = self.begin + (f64::from(count) * self.step) % TAU;
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

    /// The speeds it is drawn with.
    #[must_use]
    pub fn speeds(self) -> CpParams {
        CpParams {
            plan_acc: ACCELERATION,
            junction_vel: self.speed,
            acc_or_period: ACCELERATION,
            real_time_track: Flag::OFF,
        }
    }

    /// Segments a second at full speed.
    #[must_use]
    pub fn segments_per_second(self) -> f64 {
        f64::from(self.speed) / (2.0 * RADIUS * (self.step / 2.0).sin())
    }
}

#[cfg(test)]
mod tests {
    use magician_protocol::Layout;

    use super::*;

    #[test]
    fn a_ring_closes_and_its_segments_have_the_length_asked_for() {
        let mut pose = Pose::decode(&[0; 32]).unwrap();
        (pose.y, pose.z) = (200.0, 30.0);
        let ring = Ring::through(&pose, 0.2, 90.0);
        assert!((ring.segments_per_second() - 450.0).abs() < 2.0);
        let count = (TAU / ring.step).round() as usize;
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
