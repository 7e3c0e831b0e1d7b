//! Observed state of an arm: position, speed, and if it is known to stand.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use magician::commands::Pose;
use magician::{RestDetector, Status};

/// Number of speeds kept in the history.
const SPEED_HISTORY_LENGTH: usize = 600;
/// Age from which a reading is stale. A choice: many periods at the usual rate of 20 Hz.
const STALE_AFTER: Duration = Duration::from_secs(1);
/// Number of missed readings from which a slower series of readings is stale.
const MAX_MISSED_READINGS: f64 = 3.0;

/// Speeds of tool and joints, without direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Speeds {
    /// Speed of the tool, mm/s.
    pub tool: f64,
    /// Speeds of J1 to J4, deg/s.
    pub joints: [f64; 4],
}

impl Speeds {
    /// Mean speeds between two poses that are `seconds` apart.
    fn between(before: &Pose, after: &Pose, seconds: f64) -> Self {
        let apart = |a: f32, b: f32| f64::from(a) - f64::from(b);
        let [x, y, z] = [
            apart(after.x, before.x),
            apart(after.y, before.y),
            apart(after.z, before.z),
        ];
        let mut joints = [0.0; 4];
        let angles = after.joint_angle.iter().zip(before.joint_angle);
        for (joint, (after, before)) in joints.iter_mut().zip(angles) {
            *joint = apart(*after, before).abs() / seconds;
        }
        Self {
            tool: (x * x + y * y + z * z).sqrt() / seconds,
            joints,
        }
    }
}

/// Evaluates an arm's readings ([`Arm::state`](magician::Arm::state)): speed, freshness, and if the
/// arm stands, so that a point can be taken.
///
/// ```
/// use std::time::Instant;
///
/// use magician::Arm;
/// use magician_job::ObservedState;
///
/// # #[tokio::main(flavor = "current_thread")]
/// # async fn main() -> magician::Result<()> {
/// let arm = Arm::connect("sim").await?;
/// let (mut state, mut observed) = (arm.state(50.0)?, ObservedState::default());
/// let pose = loop {
///     observed.observe(state.changed().await?);
///     observed.tick(Instant::now());
///     if let Some(pose) = observed.standing_pose() {
///         break *pose;
///     }
/// };
/// assert!((pose.x - 259.1).abs() < 0.1);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct ObservedState {
    /// Last reading.
    pub status: Option<Status>,
    /// Position on the rail, mm; `None` without a rail.
    pub rail: Option<f32>,
    /// Speeds between readings, latest last; at most 600.
    pub speeds: VecDeque<Speeds>,
    /// Smoothed rate of readings, Hz.
    pub rate: f64,
    /// Age of the last reading at the last [`tick`](Self::tick).
    age: Duration,
    /// Age from which a reading is stale.
    stale: Duration,
    /// Detector fed with the poses since the arm last moved. `None` once the arm came to rest, and
    /// before it was first seen to move.
    rest_detector: Option<RestDetector>,
    created: Instant,
}

impl Default for ObservedState {
    fn default() -> Self {
        Self {
            status: None,
            rail: None,
            speeds: VecDeque::new(),
            rate: 0.0,
            age: Duration::ZERO,
            stale: STALE_AFTER,
            rest_detector: None,
            created: Instant::now(),
        }
    }
}

impl ObservedState {
    /// Sets the expected rate, Hz. At low rates a reading is fresh for three periods instead of one
    /// second.
    #[must_use]
    pub fn with_rate(mut self, rate: f64) -> Self {
        let missed =
            Duration::try_from_secs_f64(MAX_MISSED_READINGS / rate).unwrap_or(Duration::MAX);
        self.stale = STALE_AFTER.max(missed);
        self
    }

    /// Age of the last reading at the last [`tick`](Self::tick); without a reading, time since
    /// creation.
    #[must_use]
    pub const fn age(&self) -> Duration {
        self.age
    }

    /// Adds a reading.
    pub fn observe(&mut self, status: Status) {
        if let Some(before) = &self.status {
            let seconds = status.at.saturating_duration_since(before.at).as_secs_f64();
            // When the link comes or goes, the last reading is delivered a second time.
            if seconds > 0.0 {
                self.push_speeds(Speeds::between(&before.pose, &status.pose, seconds));
                let rate = seconds.recip();
                let known = if self.rate > 0.0 { self.rate } else { rate };
                self.rate = known + 0.1 * (rate - known);
            }
        }
        let at = status.at.saturating_duration_since(self.created);
        let at = u64::try_from(at.as_micros()).unwrap_or(u64::MAX);
        let before = self.status.as_ref().map(|before| before.pose);
        if before.is_some_and(|before| before != status.pose) {
            self.rest_detector.get_or_insert_default();
        }
        if let Some(rest) = &mut self.rest_detector
            && rest.see(at, status.pose)
        {
            self.rest_detector = None;
        }
        self.status = Some(status);
    }

    /// Updates the age of the last reading.
    pub fn tick(&mut self, now: Instant) {
        let last = self
            .status
            .as_ref()
            .map_or(self.created, |status| status.at);
        self.age = now.saturating_duration_since(last);
    }

    /// Marks the arm as moving: earlier readings no longer give its position.
    pub fn mark_moving(&mut self) {
        self.rest_detector = Some(RestDetector::default());
    }

    /// True if the arm has answered recently.
    #[must_use]
    pub fn is_answering(&self) -> bool {
        self.age < self.stale
    }

    /// Last measured speeds.
    #[must_use]
    pub fn speed(&self) -> Speeds {
        self.speeds.back().copied().unwrap_or_default()
    }

    /// True if the arm was recently seen to stand, and nothing has moved it since.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.is_answering() && self.rest_detector.is_none()
    }

    /// Pose at which the arm stands, if it is known to.
    #[must_use]
    pub fn standing_pose(&self) -> Option<&Pose> {
        let status = self.status.as_ref()?;
        self.is_at_rest().then_some(&status.pose)
    }

    fn push_speeds(&mut self, speeds: Speeds) {
        if self.speeds.len() == SPEED_HISTORY_LENGTH {
            self.speeds.pop_front();
        }
        self.speeds.push_back(speeds);
    }
}

#[cfg(test)]
mod tests {
    use magician::Arm;

    use super::*;

    const READING: Duration = Duration::from_millis(50);

    /// Feeds readings of an arm that stands, 50 ms apart.
    fn read(observed: &mut ObservedState, status: &Status, times: u32) {
        for _ in 0..times {
            let mut next = observed.status.clone().unwrap_or_else(|| status.clone());
            next.at += READING;
            observed.tick(next.at);
            observed.observe(next);
        }
    }

    async fn status() -> Status {
        let arm = Arm::connect("sim").await.unwrap();
        arm.state(20.0).unwrap().changed().await.unwrap()
    }

    #[tokio::test]
    async fn moved_arm_is_at_rest_after_three_equal_readings() {
        let (mut observed, status) = (ObservedState::default(), status().await);
        read(&mut observed, &status, 3);
        assert!(observed.is_at_rest());
        observed.mark_moving();
        assert!(!observed.is_at_rest());
        read(&mut observed, &status, 2);
        assert!(!observed.is_at_rest());
        read(&mut observed, &status, 1);
        assert!(observed.is_at_rest());
    }

    #[tokio::test]
    async fn old_reading_is_stale() {
        let (mut observed, status) = (ObservedState::default(), status().await);
        read(&mut observed, &status, 3);
        let last = observed.status.as_ref().unwrap().at;
        observed.tick(last + Duration::from_millis(900));
        assert!(observed.is_answering() && observed.is_at_rest());
        observed.tick(last + Duration::from_millis(2100));
        assert!(!observed.is_answering() && !observed.is_at_rest());
        assert_eq!(observed.age().as_secs(), 2);
        // At a low rate readings are fresh for longer.
        let mut observed = observed.with_rate(0.5);
        observed.tick(last + Duration::from_millis(2100));
        assert!(observed.is_answering());
    }
}
