//! Recordings of an arm as programs: the tool follows them at the speed at which they were made.
//!
//! A recording is rows of a time and a place. While the tool moves it follows a continuous path in real-time mode (document
//! 1.11.1, errata E31): a segment takes a period, so that rows come after even times. Where it stands it waits as long.

use magician_host::commands::CpParams;
use magician_motion::{ArmModel, Pose};
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
/// The period is shortened by no more than this share.
const MOST_LAG: f64 = 0.1;
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
    let even = match &thinned {
        Some(rows) => evenly(rows, period, Interpolation::Straight)?,
        None => evenly(&timed, period, Interpolation::Smooth)?,
    };
    let mut replay = Replay::at(first, period * (1.0 - lag(&even, period)));
    let mut at = 0;
    while at + 1 < even.len() {
        match standing(&even[at..]) {
            0 => {
                let moving = even[at..].iter().enumerate().skip(1);
                let stands = |(nth, _): &(usize, &Sample)| standing(&even[at + nth..]) > 0;
                let end = moving.take_while(|each| !stands(each)).count() + 1;
                let end = (at + end).min(even.len() - 1);
                replay.follow(&even[at..=end]);
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
            "{left_out} of {all} points are left out: they are closer than {nearer} mm to the line"
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

/// The rows after each period.
fn evenly(rows: &[Sample], period: f64, between: Interpolation) -> Result<Vec<Sample>, Diagnostic> {
    // Of two rows at the same time the first counts.
    let mut rows = rows.to_vec();
    rows.dedup_by(|later, earlier| later.t <= earlier.t);
    let [Some(first), Some(last)] = [rows.first(), rows.last()] else {
        return Ok(Vec::new());
    };
    let count = ((last.t - first.t) / period).ceil();
    if count > MOST_PERIODS + PERIODS_OF_A_ROW * rows.len() as f64 {
        let time = last.t - first.t;
        let message = format!("the recording takes {time:.0} s, which is too long");
        return Err(Diagnostic::new(last.origin, message));
    }
    let slopes = slopes(&rows);
    let mut at = 0;
    let even = (0..=count as u64).map(|nth| {
        let t = (first.t + nth as f64 * period).min(last.t);
        while rows.get(at + 1).is_some_and(|row| row.t < t) {
            at += 1;
        }
        let ends = [at, at + 1].map(|nth| rows.get(nth).zip(slopes.get(nth)));
        match ends {
            [Some((before, leaving)), Some((after, arriving))] => match between {
                Interpolation::Smooth => before.towards(after, [leaving, arriving], t),
                Interpolation::Straight => {
                    let straight = before.straight(after);
                    before.towards(after, [&straight, &straight], t)
                }
            },
            _ => Sample { t, ..*last },
        }
    });
    Ok(even.collect())
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
            match before * after > 0.0 {
                true => 2.0 * before * after / (before + after),
                false => 0.0,
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
        [0, 1, 2, 3].map(|axis| match step > 0.0 {
            true => (later.pose[axis] - self.pose[axis]) / step,
            false => 0.0,
        })
    }

    /// Between this row and a later one, with the speeds at both.
    fn towards(&self, later: &Self, [leaving, arriving]: [&[f64; 4]; 2], t: f64) -> Self {
        let step = later.t - self.t;
        // Rows at the same time have no way between them.
        let share = match step > 0.0 {
            true => ((t - self.t) / step).clamp(0.0, 1.0),
            false => 0.0,
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

/// The share of the time by which the arm lags: at each change of its speed by `change^2 / (2 acceleration speed)` (model
/// section 8). A period that is shorter by this makes up for it.
fn lag(rows: &[Sample], period: f64) -> f64 {
    let speeds = rows.windows(2).map(|pair| match pair {
        [from, to] => from.apart(to) / period,
        _ => 0.0,
    });
    let speeds: Vec<f64> = speeds.filter(|speed| speed * period > NO_WAY).collect();
    let late = speeds.windows(2).map(|pair| match pair {
        [before, after] => {
            let change = after - before;
            change * change
                / (2.0 * ArmModel::MAGICIAN.ceilings.linear_acceleration * before.max(*after))
        }
        _ => 0.0,
    });
    let late: f64 = late.sum();
    let time = speeds.len() as f64 * period;
    if time > 0.0 {
        (late / time).min(MOST_LAG)
    } else {
        0.0
    }
}

/// A program that is being made.
struct Replay {
    plan: Plan,
    /// Up to when it is made, s.
    t: f64,
    period: f64,
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
            period,
            has_period: false,
            j4: first.j4,
            turned: 0.0,
        }
    }

    fn wait_until(&mut self, t: f64, origin: Origin) {
        let milliseconds = ((t - self.t) * 1000.0).round().min(LONGEST);
        if milliseconds >= 1.0 {
            self.plan.push(Action::Wait(milliseconds as u32), origin);
            self.t += milliseconds / 1000.0;
        }
    }

    /// Along these rows, a period from each to the next.
    fn follow(&mut self, rows: &[Sample]) {
        let Some(last) = rows.last() else { return };
        self.set_period(last.origin);
        for pair in rows.windows(2) {
            let [from, to] = pair else { continue };
            if from.apart(to) < NO_WAY {
                continue;
            }
            self.wait_until(from.t, from.origin);
            let [x, y, z, _] = to.pose.map(|value| value as f32);
            self.plan.push(Action::Path { to: [x, y, z] }, to.origin);
            self.t = to.t;
        }
        let turned = self
            .j4
            .zip(last.j4)
            .map_or(0.0, |(from, to)| (to - from).abs());
        if turned > HELD {
            self.turned = self.turned.max(turned);
            let to = last.pose.map(|value| value as f32);
            let by = Travel::Line;
            self.plan.push(Action::Move { to, by }, last.origin);
            self.j4 = last.j4;
        }
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
