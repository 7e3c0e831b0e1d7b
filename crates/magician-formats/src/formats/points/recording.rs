//! Replay of recordings: the tool follows them at the recorded speed.
//!
//! A recording is rows of time and position. While the tool moves, the plan uses a continuous path
//! in real-time mode (document 1.11.1, errata E31): each segment takes one period, so rows are
//! resampled at even times. Where the tool stands, the plan waits.
//!
//! The arm needs more than a period for a segment in which its speed must change, so it falls
//! behind after a corner. [`Replay`] tracks the arm's time with the arm's own motion law and
//! catches up with longer segments.

use magician_host::commands::CpParams;
use magician_host::message;
use magician_motion::{ArmModel, KinematicLimits, Pose};
use magician_protocol::Flag;

use crate::recording::{J4_TOLERANCE, MAX_REST_MS};
use crate::simplify::kept_points_by;
use crate::{Action, Diagnostic, DiagnosticCode, Origin, Parsed, Plan, Travel};

/// Distance within which the tool stands still, mm. A choice: large enough for noise, too small to
/// swallow slow motion.
const STANDSTILL_TOLERANCE: f64 = 0.05;
/// Number of periods after which a standstill counts as a rest. A choice: ending the path for a
/// rest costs a ramp down and up.
const REST_PERIODS: usize = 3;
/// Length below which a segment takes the arm no time, mm.
const MIN_LENGTH: f64 = 1e-3;
/// Duration of a segment, s: one period of the arm, which rounds to whole periods.
const PERIOD: f64 = ArmModel::MAGICIAN.law.period_us() as f64 / 1e6;
/// Step of the search for the phase of the arm's periods, s. A choice between precision and time.
const PHASE_STEP: f64 = 0.001;
/// Share of a period that covers the rounding of times to microseconds.
const PERIOD_ROUNDING: f64 = 1e-4;
/// Ratio of unevenness below which times of periods are accepted instead of the times as read. A
/// choice: only a clear gain justifies changing the times.
const MAX_UNEVENNESS_RATIO: f64 = 0.5;
/// Largest share by which a segment is longer than a period of the recording in order to catch up.
///
/// The arm is then faster than recorded by this share. A choice between catching up soon and
/// keeping the recorded speed.
const MAX_CATCH_UP: f64 = 0.5;
/// Share by which the arm hurries before a turn of J4, so that it is in time afterwards. A choice
/// that keeps the motion close to the recorded one.
const HURRY_SHARE: f64 = 0.25;
/// Delay within which the arm is in time, s. Segments then stay even.
const MAX_DELAY: f64 = 1e-4;
/// Largest number of periods of a recording, besides [`PERIODS_PER_ROW`]: a small file with a gap
/// of years must not use up memory.
const MAX_PERIODS: f64 = 1e6;
/// Additional number of periods per row, so that long recordings are not refused.
const PERIODS_PER_ROW: f64 = 10.0;

/// Position of the arm at a time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// Time, s.
    pub(super) t: f64,
    /// Pose x, y, z, r, mm and deg.
    pub(super) pose: [f64; 4],
    /// Angle of J4 if known, deg.
    pub(super) j4: Option<f64>,
    pub(super) origin: Origin,
}

/// Creates the plan that repeats a recording: a move to its start, then along it. With `resample`,
/// rows are dropped that stay within this distance of straight motion at constant speed between the
/// others.
pub(super) fn plan(rows: &[Sample], resample: Option<f64>) -> Result<Parsed<Plan>, Diagnostic> {
    let mut last = f64::NEG_INFINITY;
    for row in rows {
        if row.t < last {
            let message = message!("the time goes back from {last} to {t} s", last, t = row.t);
            return Err(Diagnostic::new(row.origin, message));
        }
        last = row.t;
    }
    let [Some(first), Some(end)] = [rows.first(), rows.last()] else {
        return Err(Diagnostic::of_file(message!(
            "there are no rows in the recording"
        )));
    };
    let (period, timed) = (PERIOD, timed(rows));
    let thinned = resample.map(|nearer| thinned(&timed, nearer));
    let (rows_left, between) = match &thinned {
        Some(thinned) => (thinned.as_slice(), Interpolation::Straight),
        None => (timed.as_slice(), Interpolation::Smooth),
    };
    let path = TimedPath::through(rows_left, between);
    let even = path.resampled(period)?;
    let mut replay = Replay::at(first, period);
    let mut at = 0;
    while at + 1 < even.len() {
        match initial_rest(&even[at..]) {
            0 => {
                let moving = even[at..].iter().enumerate().skip(1);
                let stands = |(nth, _): &(usize, &Sample)| initial_rest(&even[at + nth..]) > 0;
                let end = moving.take_while(|each| !stands(each)).count() + 1;
                let end = (at + end).min(even.len() - 1);
                replay.follow(&path, &even[at], &even[end]);
                at = end;
            }
            periods => at += periods,
        }
    }
    replay.wait_until(end.t, end.origin);
    let what = message!(
        "a recording: replayed at its own speed, {seconds:.1} s from its first pose",
        seconds = end.t - first.t
    );
    let mut notes = vec![Diagnostic::of_file(what).coded(DiagnosticCode::Assumed)];
    if let (Some(nearer), Some(thinned)) = (resample, &thinned) {
        let (left_out, all) = (rows.len() - thinned.len(), rows.len());
        let what = message!(
            "{left_out} of {all} points are left out: they are closer than {nearer} mm to the line; \
                a step between the others still takes a period, so that the number of steps stays",
            left_out,
            all,
            nearer
        );
        notes.push(Diagnostic::of_file(what).coded(DiagnosticCode::LeftOut));
    }
    if replay.turned > J4_TOLERANCE {
        let what = message!(
            "J4 turns by up to {degrees:.0} degrees during a motion; a continuous path cannot turn it, so it turns at the end of the motion",
            degrees = replay.turned
        );
        notes.push(Diagnostic::of_file(what).coded(DiagnosticCode::Assumed));
    }
    Ok(Parsed {
        content: replay.plan,
        notes,
    })
}

/// Interpolation between rows.
#[derive(Clone, Copy)]
enum Interpolation {
    /// Smooth without overshoot: monotone cubic of Fritsch and Carlson.
    Smooth,
    /// Straight, at constant speed.
    Straight,
}

/// Corrects the times of the rows.
///
/// A pose is read up to a period after the arm reached it, so constant speed looks uneven. The
/// phase of the arm's periods is not recorded; it is found as the one with the most even speeds. A
/// recording that does not fit any phase keeps its times.
fn timed(rows: &[Sample]) -> Vec<Sample> {
    let as_read = rows.to_vec();
    let steps = (PERIOD / PHASE_STEP).round() as u32;
    let phases = (0..steps).map(|nth| f64::from(nth) * PHASE_STEP);
    let candidates = phases.filter_map(|phase| at_periods(rows, phase));
    let least = |best: (f64, Vec<Sample>), rows: Vec<Sample>| match unevenness(&rows) {
        uneven if uneven < best.0 => (uneven, rows),
        _ => best,
    };
    let best = (MAX_UNEVENNESS_RATIO * unevenness(&as_read), as_read);
    candidates.fold(best, least).1
}

/// Moves rows to the ends of periods with this phase, one per period. `None` if two poses of one
/// period differ.
fn at_periods(rows: &[Sample], phase: f64) -> Option<Vec<Sample>> {
    let mut timed: Vec<Sample> = Vec::with_capacity(rows.len());
    for row in rows {
        let t = phase + PERIOD * ((row.t - phase) / PERIOD + PERIOD_ROUNDING).floor();
        match timed.last() {
            Some(last) if last.t >= t => {
                if last.pose_distance(row) > MIN_LENGTH {
                    return None;
                }
            }
            _ => timed.push(Sample { t, ..*row }),
        }
    }
    Some(timed)
}

/// Sum of squared changes of speed from row to row, (mm/s)2.
fn unevenness(rows: &[Sample]) -> f64 {
    let speeds = rows.windows(2).filter_map(|pair| match pair {
        [from, to] if to.t > from.t => Some(from.pose_distance(to) / (to.t - from.t)),
        _ => None,
    });
    let (mut before, mut sum) = (0.0, 0.0);
    for speed in speeds {
        sum += (speed - before) * (speed - before);
        before = speed;
    }
    sum
}

/// Drops rows without which the position at every time stays within the tolerance. Comparing
/// positions alone would lose rests on the line.
fn thinned(rows: &[Sample], nearer: f64) -> Vec<Sample> {
    let off = |row: Sample, from: Sample, to: Sample| {
        let straight = from.straight(&to);
        let there = from.interpolated(&to, [&straight, &straight], row.t);
        let turned = (there.pose[3] - row.pose[3]).abs();
        there.pose_distance(&row).max(turned)
    };
    let stays = kept_points_by(rows, nearer, off);
    let kept = rows.iter().zip(stays).filter(|(_, stays)| *stays);
    kept.map(|(row, _)| *row).collect()
}

/// Position as a function of time, through rows with increasing times.
struct TimedPath {
    rows: Vec<Sample>,
    slopes: Vec<[f64; 4]>,
    between: Interpolation,
}

impl TimedPath {
    /// Creates the path. Of rows with equal times the first counts.
    fn through(rows: &[Sample], between: Interpolation) -> Self {
        let mut rows = rows.to_vec();
        rows.dedup_by(|later, earlier| later.t <= earlier.t);
        let slopes = slopes(&rows);
        Self {
            rows,
            slopes,
            between,
        }
    }

    /// Returns the position after each period.
    fn resampled(&self, period: f64) -> Result<Vec<Sample>, Diagnostic> {
        let [Some(first), Some(last)] = [self.rows.first(), self.rows.last()] else {
            return Ok(Vec::new());
        };
        let count = ((last.t - first.t) / period).ceil();
        if count > MAX_PERIODS + PERIODS_PER_ROW * self.rows.len() as f64 {
            let time = last.t - first.t;
            let message = message!("the recording takes {time:.0} s, which is too long", time);
            return Err(Diagnostic::new(last.origin, message));
        }
        let times = (0..=count as u64).map(|nth| first.t + nth as f64 * period);
        Ok(times.filter_map(|t| self.at(t)).collect())
    }

    /// Returns the position at a time. After the last row it stays there.
    fn at(&self, t: f64) -> Option<Sample> {
        let last = self.rows.last()?;
        let t = t.min(last.t);
        let next = self.rows.partition_point(|row| row.t < t).max(1);
        let ends = [next - 1, next].map(|nth| self.rows.get(nth).zip(self.slopes.get(nth)));
        Some(match ends {
            [Some((before, leaving)), Some((after, arriving))] => match self.between {
                Interpolation::Smooth => before.interpolated(after, [leaving, arriving], t),
                Interpolation::Straight => {
                    let straight = before.straight(after);
                    before.interpolated(after, [&straight, &straight], t)
                }
            },
            _ => Sample { t, ..*last },
        })
    }
}

/// Returns the slope of each coordinate at each row; 0 at an extremum.
fn slopes(rows: &[Sample]) -> Vec<[f64; 4]> {
    let speeds = rows.windows(2).map(|pair| match pair {
        [a, b] => [0, 1, 2, 3].map(|axis| (b.pose[axis] - a.pose[axis]) / (b.t - a.t)),
        _ => [0.0; 4],
    });
    let speeds: Vec<[f64; 4]> = speeds.collect();
    let between = |nth: usize| nth.checked_sub(1).and_then(|nth| speeds.get(nth));
    let slope = |nth: usize| match (between(nth), speeds.get(nth)) {
        (Some(before), Some(after)) => [0, 1, 2, 3].map(|axis| {
            let (before, after) = (before[axis], after[axis]);
            if before * after > 0.0 {
                2.0 * before * after / (before + after)
            } else {
                0.0
            }
        }),
        _ => [0.0; 4],
    };
    (0..rows.len()).map(slope).collect()
}

/// Number of periods for which the tool stands from the first row on; 0 if that is too short for a
/// rest.
fn initial_rest(rows: &[Sample]) -> usize {
    let Some(first) = rows.first() else { return 0 };
    let same = rows
        .iter()
        .skip(1)
        .take_while(|row| first.pose_distance(row) <= STANDSTILL_TOLERANCE);
    let periods = same.count();
    let ends = periods + 1 == rows.len();
    if periods >= REST_PERIODS || ends {
        periods
    } else {
        0
    }
}

impl Sample {
    /// Distance to another row, mm.
    fn pose_distance(&self, other: &Self) -> f64 {
        Pose::from(self.pose).distance_to(&Pose::from(other.pose))
    }

    /// Speed of each coordinate on the straight way to a later row.
    fn straight(&self, later: &Self) -> [f64; 4] {
        let step = later.t - self.t;
        [0, 1, 2, 3].map(|axis| {
            if step > 0.0 {
                (later.pose[axis] - self.pose[axis]) / step
            } else {
                0.0
            }
        })
    }

    /// Interpolates (cubic Hermite) between this row and a later one, with the speeds at both.
    fn interpolated(&self, later: &Self, [leaving, arriving]: [&[f64; 4]; 2], t: f64) -> Self {
        let step = later.t - self.t;
        // Rows with equal times have no distance to interpolate.
        let share = if step > 0.0 {
            ((t - self.t) / step).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let (square, cube) = (share * share, share * share * share);
        let pose = [0, 1, 2, 3].map(|axis| {
            let (from, to) = (self.pose[axis], later.pose[axis]);
            let ends = from + (3.0 * square - 2.0 * cube) * (to - from);
            let leaving = (cube - 2.0 * square + share) * step * leaving[axis];
            ends + leaving + (cube - square) * step * arriving[axis]
        });
        let j4 = self.j4.zip(later.j4);
        Self {
            t,
            pose,
            j4: j4.map(|(from, to)| from + share * (to - from)),
            origin: later.origin,
        }
    }
}

/// Duration of a turn of J4 at the speeds after power-up, s.
fn turn_duration(degrees: f64) -> f64 {
    let speeds = &ArmModel::MAGICIAN.power_up.speeds();
    let rates = KinematicLimits {
        velocity: speeds.rotation_velocity * speeds.velocity_ratio / 100.0,
        acceleration: speeds.rotation_acceleration * speeds.acceleration_ratio / 100.0,
    };
    if degrees > 0.0 {
        ArmModel::MAGICIAN
            .law
            .rest_to_rest(degrees, &rates)
            .duration()
    } else {
        0.0
    }
}

/// A segment whose duration depends on the next one.
#[derive(Clone, Copy)]
struct Pending {
    length: f64,
    /// Speed at its start, mm/s.
    entry: f64,
}

/// Plan being built, and the arm's progress.
struct Replay {
    plan: Plan,
    /// Recorded time up to which the plan is built, s.
    t: f64,
    /// Time at which the arm is there, s; later than `t` if it is behind.
    arm: f64,
    period: f64,
    /// Last segment of the current path.
    pending: Option<Pending>,
    /// True if the plan has set the period.
    has_period: bool,
    j4: Option<f64>,
    /// Largest turn of J4 during a motion, deg.
    turned: f64,
}

impl Replay {
    fn at(first: &Sample, period: f64) -> Self {
        let mut plan = Plan::default();
        let to = first.pose.map(|value| value as f32);
        let by = Travel::Joints;
        plan.push(Action::Move { to, by }, first.origin);
        Self {
            plan,
            t: first.t,
            arm: first.t,
            period,
            pending: None,
            has_period: false,
            j4: first.j4,
            turned: 0.0,
        }
    }

    /// Waits until a time, if the arm is early.
    fn wait_until(&mut self, t: f64, origin: Origin) {
        self.rest();
        let milliseconds = ((t - self.arm) * 1000.0).round().min(MAX_REST_MS);
        if milliseconds >= 1.0 {
            self.plan.push(Action::Wait(milliseconds as u32), origin);
            self.arm += milliseconds / 1000.0;
        }
        self.t = self.t.max(t);
    }

    /// Follows the path with one segment per period.
    fn follow(&mut self, path: &TimedPath, from: &Sample, last: &Sample) {
        self.set_period(last.origin);
        let turned = self
            .j4
            .zip(last.j4)
            .map_or(0.0, |(from, to)| (to - from).abs());
        let turned = if turned > J4_TOLERANCE { turned } else { 0.0 };
        let turns_for = turn_duration(turned);
        let mut here = *from;
        while here.t < last.t {
            let pending = self.pending.map_or(0.0, |_| self.period);
            let early = (turns_for - HURRY_SHARE * (last.t - here.t)).max(0.0);
            let late = self.arm + pending + early - here.t;
            let late = if late > MAX_DELAY { late } else { 0.0 };
            let mut t = here.t + self.period + late.min(MAX_CATCH_UP * self.period);
            // A remainder shorter than a period would become a separate segment.
            if last.t - t < MAX_DELAY {
                t = last.t;
            }
            let Some(to) = path.at(t) else { break };
            let length = here.pose_distance(&to);
            if length >= MIN_LENGTH {
                if here.t > self.t + MAX_DELAY {
                    self.wait_until(here.t, here.origin);
                }
                let [x, y, z, _] = to.pose.map(|value| value as f32);
                self.plan.push(Action::Path { to: [x, y, z] }, to.origin);
                self.go_on(length);
                self.t = t;
            }
            here = Sample { t, ..to };
        }
        if turned > 0.0 {
            self.rest();
            self.arm += turns_for;
            self.turned = self.turned.max(turned);
            let to = last.pose.map(|value| value as f32);
            let by = Travel::Line;
            self.plan.push(Action::Move { to, by }, last.origin);
            self.j4 = last.j4;
        }
    }

    /// Adds a segment. The previous one ends with the speed that both allow.
    fn go_on(&mut self, length: f64) {
        let entry = match self.pending {
            Some(pending) => self.end(pending, pending.length.min(length) / self.period),
            None => 0.0,
        };
        self.pending = Some(Pending { length, entry });
    }

    /// Ends the path at rest.
    fn rest(&mut self) {
        if let Some(pending) = self.pending.take() {
            self.end(pending, 0.0);
        }
    }

    /// Adds the duration of a segment with a wanted exit speed, and returns its actual exit speed
    /// (model section 8).
    fn end(&mut self, segment: Pending, exit: f64) -> f64 {
        let ceilings = ArmModel::MAGICIAN.ceilings;
        let rates = KinematicLimits {
            velocity: (segment.length / self.period).min(ceilings.linear_velocity),
            acceleration: ceilings.linear_acceleration,
        };
        let law = ArmModel::MAGICIAN.law;
        let profile = law.segment(segment.length, segment.entry, exit, &rates);
        self.arm += profile.duration();
        profile.exit()
    }

    /// Sets the period of segments, once per plan.
    fn set_period(&mut self, origin: Origin) {
        if std::mem::replace(&mut self.has_period, true) {
            return;
        }
        let params = CpParams {
            plan_acc: ArmModel::MAGICIAN.ceilings.linear_acceleration as f32,
            junction_vel: ArmModel::MAGICIAN.ceilings.linear_velocity as f32,
            acc_or_period: (self.period * 1000.0) as f32,
            real_time_track: Flag::ON,
        };
        self.plan
            .push(Action::Command(Box::new(params.into())), origin);
    }
}
