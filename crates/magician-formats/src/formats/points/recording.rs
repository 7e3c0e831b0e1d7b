//! Recordings of an arm as programs: the tool follows them at the speed at which they were made.
//!
//! A recording is rows of a time and a place. While the tool moves it follows a continuous path in real-time mode (document
//! 1.11.1, errata E31): a segment takes a period, so that rows come after even times. Where it stands it waits as long.
//!
//! The arm takes more than a period where its speed changes from one segment to the next. After a corner it is late, and
//! catches up by longer segments.

use magician_host::commands::CpParams;
use magician_motion::{ArmModel, KinematicLimits, Pose};
use magician_protocol::Flag;

use crate::recording::{HELD, LONGEST};
use crate::simplify::kept_where;
use crate::{Action, Diagnostic, DiagnosticCode, Origin, Parsed, Plan, Travel};

/// What stays within this stands, mm,
const STILL: f64 = 0.05;
/// if it does for so many periods.
const STANDS: usize = 3;
/// A shorter way takes an arm no time, mm.
const NO_WAY: f64 = 1e-3;
/// A segment of a path takes so long, s: a period of the arm, which takes the nearest whole number of them.
const PERIOD: f64 = ArmModel::MAGICIAN.law.period_us() as f64 / 1e6;
/// Steps in which the beginning of the arm's periods is looked for, s.
const PHASE_STEP: f64 = 0.001;
/// A share of a period that is rounding of times written to a microsecond.
const ROUNDING: f64 = 1e-4;
/// Times of periods are those of an arm if speeds change by less than this share of what they do at the times that were read.
const EVENER: f64 = 0.5;
/// Largest share by which a segment covers more than a period of the recording, to catch up: the arm is by as much faster than
/// it was when it was recorded.
const MOST_CATCH_UP: f64 = 0.5;
/// Share by which the arm is faster than it was before a turn of J4, so that it is in time when that is done.
const AHEAD: f64 = 0.25;
/// The arm is in time if it is late by no more than this, s: segments stay even then.
const IN_TIME: f64 = 1e-4;
/// Periods up to which a recording is cut, however few its rows are, and so many more for each row: a small file with a gap of
/// years takes no memory for it.
const MOST_PERIODS: f64 = 1e6;
const PERIODS_OF_A_ROW: f64 = 10.0;

/// Where the arm was at a time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// s.
    pub(super) t: f64,
    /// x, y, z, r; mm and deg.
    pub(super) pose: [f64; 4],
    /// The angle of J4 where it is known, deg.
    pub(super) j4: Option<f64>,
    pub(super) origin: Origin,
}

/// The program that repeats it: to where it begins, and along it. Rows that are nearer than `resample` to where the tool is at
/// their time without them are left out: between those that stay it goes straight, at an even speed.
pub(super) fn plan(rows: &[Sample], resample: Option<f64>) -> Result<Parsed<Plan>, Diagnostic> {
    let mut last = f64::NEG_INFINITY;
    for row in rows {
        if row.t < last {
            let message = format!("the time goes back from {last} to {} s", row.t);
            return Err(Diagnostic::new(row.origin, message));
        }
        last = row.t;
    }
    let [Some(first), Some(end)] = [rows.first(), rows.last()] else {
        return Err(Diagnostic::of_file("there are no rows in the recording"));
    };
    let (period, timed) = (PERIOD, timed(rows));
    let thinned = resample.map(|nearer| thinned(&timed, nearer));
    let (rows_left, between) = match &thinned {
        Some(thinned) => (thinned.as_slice(), Interpolation::Straight),
        None => (timed.as_slice(), Interpolation::Smooth),
    };
    let path = TimedPath::through(rows_left, between);
    let even = path.evenly(period)?;
    let mut replay = Replay::at(first, period);
    let mut at = 0;
    while at + 1 < even.len() {
        match standing(&even[at..]) {
            0 => {
                let moving = even[at..].iter().enumerate().skip(1);
                let stands = |(nth, _): &(usize, &Sample)| standing(&even[at + nth..]) > 0;
                let end = moving.take_while(|each| !stands(each)).count() + 1;
                let end = (at + end).min(even.len() - 1);
                replay.follow(&path, &even[at], &even[end]);
                at = end;
            }
            periods => at += periods,
        }
    }
    replay.wait_until(end.t, end.origin);
    let what = format!(
        "a recording: replayed at its own speed, {:.1} s from its first pose",
        end.t - first.t
    );
    let mut notes = vec![Diagnostic::of_file(what).coded(DiagnosticCode::Assumed)];
    if let (Some(nearer), Some(thinned)) = (resample, &thinned) {
        let (left_out, all) = (rows.len() - thinned.len(), rows.len());
        let what = format!(
            "{left_out} of {all} points are left out: they are closer than {nearer} mm to the line; \
                a step between the others still takes a period, so that the number of steps stays"
        );
        notes.push(Diagnostic::of_file(what).coded(DiagnosticCode::LeftOut));
    }
    if replay.turned > HELD {
        let what = format!(
            "J4 turns by up to {:.0} degrees during a motion; a continuous path cannot turn it, so it turns at the end of the motion",
            replay.turned
        );
        notes.push(Diagnostic::of_file(what).coded(DiagnosticCode::Assumed));
    }
    Ok(Parsed {
        content: replay.plan,
        notes,
    })
}

/// How the tool goes from one row to the next.
#[derive(Clone, Copy)]
enum Interpolation {
    /// Every coordinate goes on smoothly, and not beyond the rows: by the cubic of Fritsch and Carlson.
    Smooth,
    /// Straight, at an even speed.
    Straight,
}

/// The rows, each at the time at which the arm was there.
///
/// A pose is read up to a period after the arm came to it, so that an even speed looks uneven. When the arm's periods begin is not
/// written down: it is the time at which speeds change least. Rows that are of no such arm keep their times.
fn timed(rows: &[Sample]) -> Vec<Sample> {
    let as_read = rows.to_vec();
    let steps = (PERIOD / PHASE_STEP).round() as u32;
    let phases = (0..steps).map(|nth| f64::from(nth) * PHASE_STEP);
    let candidates = phases.filter_map(|phase| at_periods(rows, phase));
    let least = |best: (f64, Vec<Sample>), rows: Vec<Sample>| match unevenness(&rows) {
        uneven if uneven < best.0 => (uneven, rows),
        _ => best,
    };
    let best = (EVENER * unevenness(&as_read), as_read);
    candidates.fold(best, least).1
}

/// The rows at the ends of periods that begin at this phase, one of each period; `None` if two poses of one period differ.
fn at_periods(rows: &[Sample], phase: f64) -> Option<Vec<Sample>> {
    let mut timed: Vec<Sample> = Vec::with_capacity(rows.len());
    for row in rows {
        let t = phase + PERIOD * ((row.t - phase) / PERIOD + ROUNDING).floor();
        match timed.last() {
            Some(last) if last.t >= t => {
                if last.apart(row) > NO_WAY {
                    return None;
                }
            }
            _ => timed.push(Sample { t, ..*row }),
        }
    }
    Some(timed)
}

/// How much the speed changes from row to row, (mm/s)2.
fn unevenness(rows: &[Sample]) -> f64 {
    let speeds = rows.windows(2).filter_map(|pair| match pair {
        [from, to] if to.t > from.t => Some(from.apart(to) / (to.t - from.t)),
        _ => None,
    });
    let (mut before, mut sum) = (0.0, 0.0);
    for speed in speeds {
        sum += (speed - before) * (speed - before);
        before = speed;
    }
    sum
}

/// The rows without which the tool is nowhere farther than this from where it was seen at the time. By the line alone a rest on it
/// would be lost.
fn thinned(rows: &[Sample], nearer: f64) -> Vec<Sample> {
    let off = |row: Sample, from: Sample, to: Sample| {
        let straight = from.straight(&to);
        let there = from.towards(&to, [&straight, &straight], row.t);
        let turned = (there.pose[3] - row.pose[3]).abs();
        there.apart(&row).max(turned)
    };
    let stays = kept_where(rows, nearer, off);
    let kept = rows.iter().zip(stays).filter(|(_, stays)| *stays);
    kept.map(|(row, _)| *row).collect()
}

/// The way through rows of rising times.
struct TimedPath {
    rows: Vec<Sample>,
    slopes: Vec<[f64; 4]>,
    between: Interpolation,
}

impl TimedPath {
    /// Through these. Of two rows at the same time the first counts.
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

    /// The rows after each period.
    fn evenly(&self, period: f64) -> Result<Vec<Sample>, Diagnostic> {
        let [Some(first), Some(last)] = [self.rows.first(), self.rows.last()] else {
            return Ok(Vec::new());
        };
        let count = ((last.t - first.t) / period).ceil();
        if count > MOST_PERIODS + PERIODS_OF_A_ROW * self.rows.len() as f64 {
            let time = last.t - first.t;
            let message = format!("the recording takes {time:.0} s, which is too long");
            return Err(Diagnostic::new(last.origin, message));
        }
        let times = (0..=count as u64).map(|nth| first.t + nth as f64 * period);
        Ok(times.filter_map(|t| self.at(t)).collect())
    }

    /// Where the tool is at a time: at the last row after it.
    fn at(&self, t: f64) -> Option<Sample> {
        let last = self.rows.last()?;
        let t = t.min(last.t);
        let next = self.rows.partition_point(|row| row.t < t).max(1);
        let ends = [next - 1, next].map(|nth| self.rows.get(nth).zip(self.slopes.get(nth)));
        Some(match ends {
            [Some((before, leaving)), Some((after, arriving))] => match self.between {
                Interpolation::Smooth => before.towards(after, [leaving, arriving], t),
                Interpolation::Straight => {
                    let straight = before.straight(after);
                    before.towards(after, [&straight, &straight], t)
                }
            },
            _ => Sample { t, ..*last },
        })
    }
}

/// How fast each coordinate changes at each row: not at all where it turns round.
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

/// For how many periods the tool stands at the first of these rows; none if that is too short to be a rest.
fn standing(rows: &[Sample]) -> usize {
    let Some(first) = rows.first() else { return 0 };
    let same = rows
        .iter()
        .skip(1)
        .take_while(|row| first.apart(row) <= STILL);
    let periods = same.count();
    let ends = periods + 1 == rows.len();
    if periods >= STANDS || ends {
        periods
    } else {
        0
    }
}

impl Sample {
    /// How far it is to another place, mm.
    fn apart(&self, other: &Self) -> f64 {
        Pose::from(self.pose).distance_to(&Pose::from(other.pose))
    }

    /// How fast each coordinate changes on the straight way to a later row.
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

    /// Between this row and a later one, with the speeds at both.
    fn towards(&self, later: &Self, [leaving, arriving]: [&[f64; 4]; 2], t: f64) -> Self {
        let step = later.t - self.t;
        // Rows at the same time have no way between them.
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

/// Time in which J4 turns by an angle at the speeds of power-up, s.
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

/// A segment of a path whose duration is known when the next one is.
#[derive(Clone, Copy)]
struct Pending {
    length: f64,
    /// Speed at its beginning, mm/s.
    entry: f64,
}

/// A program that is being made.
struct Replay {
    plan: Plan,
    /// Time of the recording up to which it is made, s.
    t: f64,
    /// Time by which the arm is there, s: later than `t` where it has lost time.
    arm: f64,
    period: f64,
    /// The last segment of the path under way.
    pending: Option<Pending>,
    /// Whether a step sets it.
    has_period: bool,
    j4: Option<f64>,
    /// How far J4 turned on a way, at most, deg.
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

    /// Waits for a time, if the arm is there before it.
    fn wait_until(&mut self, t: f64, origin: Origin) {
        self.rest();
        let milliseconds = ((t - self.arm) * 1000.0).round().min(LONGEST);
        if milliseconds >= 1.0 {
            self.plan.push(Action::Wait(milliseconds as u32), origin);
            self.arm += milliseconds / 1000.0;
        }
        self.t = self.t.max(t);
    }

    /// Along a way, a period from each place to the next.
    fn follow(&mut self, path: &TimedPath, from: &Sample, last: &Sample) {
        self.set_period(last.origin);
        let turned = self
            .j4
            .zip(last.j4)
            .map_or(0.0, |(from, to)| (to - from).abs());
        let turned = if turned > HELD { turned } else { 0.0 };
        let turns_for = turn_duration(turned);
        let mut here = *from;
        while here.t < last.t {
            let pending = self.pending.map_or(0.0, |_| self.period);
            let early = (turns_for - AHEAD * (last.t - here.t)).max(0.0);
            let late = self.arm + pending + early - here.t;
            let late = if late > IN_TIME { late } else { 0.0 };
            let mut t = here.t + self.period + late.min(MOST_CATCH_UP * self.period);
            // No rest of a period, which would be a segment of its own.
            if last.t - t < IN_TIME {
                t = last.t;
            }
            let Some(to) = path.at(t) else { break };
            let length = here.apart(&to);
            if length >= NO_WAY {
                if here.t > self.t + IN_TIME {
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

    /// A segment follows: the one before it ends with the speed that both allow.
    fn go_on(&mut self, length: f64) {
        let entry = match self.pending {
            Some(pending) => self.end(pending, pending.length.min(length) / self.period),
            None => 0.0,
        };
        self.pending = Some(Pending { length, entry });
    }

    /// The path ends at rest.
    fn rest(&mut self) {
        if let Some(pending) = self.pending.take() {
            self.end(pending, 0.0);
        }
    }

    /// Counts the time of a segment that is to end with a speed; returns the speed that it ends with (model section 8).
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

    /// Sets, once, how long a segment takes.
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
