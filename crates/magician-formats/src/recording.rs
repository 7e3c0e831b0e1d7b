//! Recordings of a motion that a person led by hand, and the plan that repeats it.
//!
//! Poses arrive many times a second and are thinned while they arrive (Ramer, Douglas and Peucker),
//! so that a recording of an hour stays small. Standstills of more than [`MIN_REST`] split the
//! recording into stretches. [`Recording::plan`] repeats each stretch at its own average speed,
//! with a wait between two of them, either as a continuous path or as straight lines.

use magician_host::build;

use crate::simplify::kept_points;
use crate::{Action, Origin, Plan, Tool, Travel};

/// Motion below which the arm counts as standing still, mm and deg. A choice above the noise of the
/// encoders and of a hand that only holds the arm.
const STANDSTILL_TOLERANCE: f64 = 0.2;
/// Shortest standstill that counts as a rest, s. Shorter pauses belong to the motion.
const MIN_REST: f64 = 1.0;
/// Rotation of J4 below which it counts as not turned, deg. Its motor holds J4, so a smaller change
/// is noise of the reading.
pub(crate) const J4_TOLERANCE: f64 = 0.5;
/// Number of readings to collect before thinning them. A choice: it bounds memory and keeps the
/// cost linear in the length of the recording.
const CHUNK_READINGS: usize = 2048;
/// Range of speeds in a plan, mm/s. The lower bound is a choice that keeps the run short; the upper
/// one is the arm's (model section 6).
const SPEED_RANGE: [f64; 2] = [1.0, 300.0];
/// Range of accelerations in a plan, mm/s2.
const ACCELERATION_RANGE: [f64; 2] = [50.0, 400.0];
/// Longest rest that fits one step, ms: one day.
pub(crate) const MAX_REST_MS: f64 = 86_400_000.0;

/// Pose of the arm at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseReading {
    /// Time, s.
    pub t: f64,
    /// Pose of the tool x, y, z, r, mm and deg.
    pub pose: [f64; 4],
    /// Angle of J4, deg.
    pub j4: f64,
}

/// Kind of motion that repeats a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum CaptureMode {
    /// A continuous path without stops between two rests.
    #[default]
    Path,
    /// Straight lines with a stop at each point, the only kind that a playback file can express.
    Lines,
}

/// A recorded motion, thinned as it arrives: no reading is farther than the tolerance from the
/// lines that remain.
///
/// Its plan moves to the first reading, then follows each stretch between two rests at the
/// stretch's own average speed. Rests are kept, except before the first motion and after the last.
/// Where J4 was turned (by its motor: hands cannot) the plan uses straight lines, because a
/// continuous path does not drive J4 (model section 8).
///
/// ```
/// use magician_formats::{CaptureMode, PoseReading, Recording};
///
/// let mut recording = Recording::new(0.5);
/// for nth in 0..100 {
///     let t = f64::from(nth) * 0.05;
///     recording.push(PoseReading { t, pose: [200.0 + 10.0 * t, 0.0, 50.0, 0.0], j4: 0.0 });
/// }
/// let plan = recording.plan("led", None, CaptureMode::Path);
/// assert_eq!(plan.steps.len(), 3); // move to the start, speed, path
/// ```
#[derive(Clone, Debug)]
pub struct Recording {
    tolerance: f64,
    /// Motions between two rests.
    stretches: Vec<Stretch>,
    /// Last reading at which the arm moved, and the time of the latest reading.
    last: Option<(PoseReading, f64)>,
}

/// A motion from one rest to the next.
#[derive(Clone, Debug)]
struct Stretch {
    /// Duration of the rest before it, s.
    rest: f64,
    begun: f64,
    ended: f64,
    length: f64,
    /// Smallest and largest angle of J4, deg.
    j4: [f64; 2],
    /// Readings: those before the index `thinned` are thinned already, the others are not.
    readings: Vec<PoseReading>,
    thinned: usize,
}

impl Recording {
    /// Creates an empty recording. The tolerance is in mm, and in degrees of J4.
    #[must_use]
    pub fn new(tolerance: f64) -> Self {
        Self {
            tolerance,
            stretches: Vec::new(),
            last: None,
        }
    }

    /// Adds a reading. A reading is ignored if a number is not finite or its time is not later than
    /// the one before.
    pub fn push(&mut self, reading: PoseReading) {
        let numbers = reading.pose.iter().chain([&reading.t, &reading.j4]);
        if !{ numbers }.all(|number| number.is_finite()) {
            return;
        }
        let Some((at, seen)) = self.last else {
            self.last = Some((reading, reading.t));
            return;
        };
        if reading.t <= seen {
            return;
        }
        if pose_distance(&at, &reading) < STANDSTILL_TOLERANCE
            && (reading.pose[3] - at.pose[3]).abs() < STANDSTILL_TOLERANCE
        {
            self.last = Some((at, reading.t));
            // Slow drift below the threshold still counts: the motion ends where the arm came to
            // rest.
            let stretch = self.stretches.last_mut();
            if let Some(end) = stretch.and_then(|stretch| stretch.readings.last_mut()) {
                end.pose = reading.pose;
            }
            return;
        }
        let rest = seen - at.t;
        if rest > MIN_REST || self.stretches.is_empty() {
            let end = self.stretches.last().and_then(|last| last.readings.last());
            let start = PoseReading {
                t: seen,
                ..end.copied().unwrap_or(at)
            };
            self.stretches.push(Stretch::from(start, rest));
        }
        if let Some(stretch) = self.stretches.last_mut() {
            stretch.push(reading, self.tolerance);
        }
        self.last = Some((reading, reading.t));
    }

    /// Length of the tool's path, mm.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.stretches.iter().map(|stretch| stretch.length).sum()
    }

    /// Returns the plan that repeats the recording with the tool that was led. Empty if there are
    /// no readings.
    #[must_use]
    pub fn plan(&self, title: &str, tool: Option<Tool>, follow: CaptureMode) -> Plan {
        let mut plan = Plan {
            tool,
            ..Plan::new(title)
        };
        let Some((last, _)) = self.last else {
            return plan;
        };
        let first = self
            .stretches
            .first()
            .and_then(|first| first.readings.first());
        let to = first.unwrap_or(&last).pose.map(|number| number as f32);
        let by = Travel::Joints;
        plan.push(Action::Move { to, by }, Origin::NONE);
        let mut speed = None;
        for (nth, stretch) in self.stretches.iter().enumerate() {
            if nth > 0 {
                rest(&mut plan, stretch.rest);
            }
            stretch.follow(&mut plan, self.tolerance, follow, &mut speed);
        }
        plan
    }
}

impl Stretch {
    fn from(start: PoseReading, rest: f64) -> Self {
        Self {
            rest,
            begun: start.t,
            ended: start.t,
            length: 0.0,
            j4: [start.j4; 2],
            readings: vec![start],
            thinned: 0,
        }
    }

    fn push(&mut self, reading: PoseReading, tolerance: f64) {
        if let Some(last) = self.readings.last() {
            self.length += path_distance(last, &reading);
        }
        self.ended = reading.t;
        self.j4 = [self.j4[0].min(reading.j4), self.j4[1].max(reading.j4)];
        self.readings.push(reading);
        if self.readings.len() - self.thinned > CHUNK_READINGS {
            let tail = thinned_readings(&self.readings[self.thinned..], tolerance);
            self.readings.truncate(self.thinned);
            self.readings.extend(tail);
            // The last reading kept is the start of the next chunk, so that chords join across
            // chunks.
            self.thinned = self.readings.len() - 1;
        }
    }

    fn rotates_j4(&self) -> bool {
        self.j4[1] - self.j4[0] > J4_TOLERANCE
    }

    /// Adds the steps of this stretch. The arm already stands at its first reading.
    fn follow(
        &self,
        plan: &mut Plan,
        tolerance: f64,
        follow: CaptureMode,
        commanded: &mut Option<CommandedSpeed>,
    ) {
        let lines = follow == CaptureMode::Lines || self.rotates_j4();
        let velocity =
            (self.length / (self.ended - self.begun)).clamp(SPEED_RANGE[0], SPEED_RANGE[1]);
        let velocity = (velocity * 10.0).round() / 10.0;
        // A choice: the ramp to full speed takes a quarter of a second.
        let acceleration = (4.0 * velocity).clamp(ACCELERATION_RANGE[0], ACCELERATION_RANGE[1]);
        let speed = CommandedSpeed { lines, velocity };
        if *commanded != Some(speed) {
            let word = if lines {
                build::line_speed
            } else {
                build::path_speed
            };
            let command = word(velocity as f32, acceleration as f32);
            plan.push(command, Origin::NONE);
            *commanded = Some(speed);
        }
        let (done, rest) = self.readings.split_at(self.thinned);
        let readings = done
            .iter()
            .copied()
            .chain(thinned_readings(rest, tolerance));
        for reading in readings.skip(1) {
            let [x, y, z, r] = reading.pose.map(|number| number as f32);
            let action = if lines {
                Action::Move {
                    to: [x, y, z, r],
                    by: Travel::Line,
                }
            } else {
                Action::Path { to: [x, y, z] }
            };
            plan.push(action, Origin::NONE);
        }
    }
}

/// Speed that the plan set last.
#[derive(Clone, Copy, PartialEq)]
struct CommandedSpeed {
    lines: bool,
    velocity: f64,
}

fn rest(plan: &mut Plan, seconds: f64) {
    if seconds > MIN_REST {
        let milliseconds = (seconds * 1000.0).round().min(MAX_REST_MS);
        plan.push(Action::Wait(milliseconds as u32), Origin::NONE);
    }
}

/// Distance between two readings, mm.
fn path_distance(from: &PoseReading, to: &PoseReading) -> f64 {
    let apart = from.pose.iter().zip(to.pose).take(3);
    apart.map(|(a, b)| (b - a) * (b - a)).sum::<f64>().sqrt()
}

/// Distance including J4, where a degree counts as a millimetre.
fn pose_distance(from: &PoseReading, to: &PoseReading) -> f64 {
    libm::hypot(path_distance(from, to), to.j4 - from.j4)
}

/// Returns the first reading, the last, and as few as keep all others within the tolerance.
fn thinned_readings(readings: &[PoseReading], tolerance: f64) -> Vec<PoseReading> {
    let points: Vec<[f64; 4]> = readings.iter().map(point).collect();
    let kept = readings.iter().zip(kept_points(&points, tolerance));
    let kept = kept.filter(|(_, stays)| *stays);
    kept.map(|(reading, _)| *reading).collect()
}

fn point(reading: &PoseReading) -> [f64; 4] {
    let [x, y, z, _] = reading.pose;
    [x, y, z, reading.j4]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Readings every 50 ms from a given time on.
    fn led(
        recording: &mut Recording,
        from: f64,
        seconds: f64,
        at: impl Fn(f64) -> ([f64; 4], f64),
    ) {
        let count = (seconds / 0.05).round() as u32;
        for nth in 0..=count {
            let t = f64::from(nth) * 0.05;
            let (pose, j4) = at(t);
            let t = from + t;
            recording.push(PoseReading { t, pose, j4 });
        }
    }

    fn circle(t: f64) -> ([f64; 4], f64) {
        let (sin, cos) = libm::sincos(t * std::f64::consts::TAU / 10.0);
        ([220.0 + 30.0 * cos, 30.0 * sin, -20.0, 0.0], 5.0)
    }

    fn path(plan: &Plan) -> Vec<[f32; 3]> {
        let steps = plan.steps.iter();
        steps.filter_map(|step| step.action.target()).collect()
    }

    #[test]
    fn circle_becomes_a_path_within_tolerance_at_its_speed() {
        let mut recording = Recording::new(0.5);
        led(&mut recording, 0.0, 10.0, circle);
        let plan = recording.plan("circle", Some(Tool::Pen), CaptureMode::Path);
        let points = path(&plan);
        assert!((8..40).contains(&points.len()), "{}", points.len());
        // The circle is farthest from a chord at the chord's middle.
        for pair in points.windows(2) {
            let [x, y] = [0, 1].map(|axis| f64::from(pair[0][axis] + pair[1][axis]) / 2.0);
            let off = 30.0 - libm::hypot(x - 220.0, y);
            assert!((-0.01..0.6).contains(&off), "{off}");
        }
        let circumference = 30.0 * std::f64::consts::TAU;
        assert!((recording.length() - circumference).abs() < 0.5);
        let speed = plan.steps[1].action.command();
        assert_eq!(speed, Some(build::path_speed(18.8, 75.2)));
    }

    #[test]
    fn rests_are_kept_and_motions_stay_in_one_piece() {
        let mut recording = Recording::new(0.5);
        let line = |t: f64| ([200.0 + 20.0 * t, 0.0, 0.0, 0.0], 0.0);
        led(&mut recording, 0.0, 2.0, |_| line(0.0));
        led(&mut recording, 2.05, 3.0, line);
        led(&mut recording, 5.1, 4.0, |_| line(3.0));
        led(&mut recording, 9.15, 2.0, |t| line(3.0 - t));
        let plan = recording.plan("to and fro", None, CaptureMode::Path);
        let actions: Vec<_> = plan.steps.iter().map(|step| step.action.clone()).collect();
        let [there, _, out, wait, back] = &actions[..] else {
            panic!("{actions:#?}");
        };
        assert!(matches!(there, Action::Move { to, .. } if to[0] == 200.0));
        assert_eq!(
            *out,
            Action::Path {
                to: [260.0, 0.0, 0.0]
            }
        );
        assert!(matches!(wait, Action::Wait(4000..4150)), "{wait:?}");
        assert_eq!(
            *back,
            Action::Path {
                to: [220.0, 0.0, 0.0]
            }
        );
    }

    #[test]
    fn rotation_of_j4_gives_lines_instead_of_a_path() {
        let mut recording = Recording::new(0.5);
        led(&mut recording, 0.0, 2.0, |t| {
            ([200.0, 10.0 * t, 0.0, 20.0 * t], 20.0 * t)
        });
        let plan = recording.plan("turned", None, CaptureMode::Path);
        let last = plan.steps.last().map(|step| step.action.clone());
        let (to, by) = ([200.0, 20.0, 0.0, 40.0], Travel::Line);
        assert_eq!(last, Some(Action::Move { to, by }));
        // The caller may also ask for lines.
        let mut recording = Recording::new(0.5);
        led(&mut recording, 0.0, 10.0, circle);
        let plan = recording.plan("circle", None, CaptureMode::Lines);
        let paths = plan
            .steps
            .iter()
            .filter(|step| matches!(step.action, Action::Path { .. }));
        assert_eq!(paths.count(), 0);
        assert!(crate::formats::playback::Playback::from_plan(&plan).is_ok());
    }

    #[test]
    fn long_motions_are_thinned_while_recording() {
        let mut recording = Recording::new(0.5);
        led(&mut recording, 0.0, 1000.0, circle);
        let readings: usize = recording
            .stretches
            .iter()
            .map(|stretch| stretch.readings.len())
            .sum();
        assert!(readings < CHUNK_READINGS + 3000, "{readings}");
        assert_eq!(recording.stretches.len(), 1);
    }

    #[test]
    fn readings_with_nan_or_earlier_times_are_dropped() {
        let mut recording = Recording::new(0.5);
        assert!(recording.plan("", None, CaptureMode::Path).steps.is_empty());
        let reading = PoseReading {
            t: 1.0,
            pose: [200.0, 0.0, 0.0, 0.0],
            j4: 0.0,
        };
        recording.push(PoseReading {
            j4: f64::NAN,
            ..reading
        });
        assert!(recording.plan("", None, CaptureMode::Path).steps.is_empty());
        recording.push(reading);
        recording.push(PoseReading {
            t: 0.5,
            pose: [100.0; 4],
            ..reading
        });
        assert_eq!(recording.plan("", None, CaptureMode::Path).steps.len(), 1);
        assert_eq!(recording.length(), 0.0);
    }
}
