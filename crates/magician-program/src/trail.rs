//! A motion that somebody led the arm through, as a program that repeats it.

use magician_host::words;

use crate::simplify::kept;
use crate::{Action, Origin, Plan, Tool, Travel};

/// What moves less than this stands, mm and deg.
const STILL: f64 = 0.2;
/// Who stands for longer rests, s.
const REST: f64 = 1.0;
/// J4 is held by its motor: what is less than this was read, not meant, deg.
pub(crate) const HELD: f64 = 0.5;
/// So many marks are thinned at once.
const CHUNK: usize = 2048;
/// Speeds of a program, mm/s: what is slower is not worth waiting for, and the arm goes no faster (model section 6).
const SPEEDS: [f64; 2] = [1.0, 300.0];
/// Accelerations of a program, mm/s2.
const ACCELERATIONS: [f64; 2] = [50.0, 400.0];
/// The longest rest that one step can keep, ms.
pub(crate) const LONGEST: f64 = 86_400_000.0;

/// Where the arm was seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// When, s.
    pub t: f64,
    /// x, y, z, r of the tool, mm and deg.
    pub pose: [f64; 4],
    /// The angle of J4, deg.
    pub j4: f64,
}

/// What a program follows a trail with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Follow {
    /// A continuous path, without a stop between two rests.
    #[default]
    Path,
    /// Straight lines from point to point, with a stop at each: all that a playback file can say.
    Lines,
}

/// Marks of a motion, thinned as they come: no mark is farther than the tolerance from the lines that remain.
///
/// A program of it goes to the first mark, and follows the motion at its own average speed from rest to rest. Rests between
/// motions are kept; nobody means those before the first and after the last. Where J4 was turned (by its motor: hands cannot) it follows on straight lines, as a continuous path does not drive J4 (model
/// section 8).
///
/// ```
/// use magician_program::{Follow, Mark, Trail};
///
/// let mut trail = Trail::new(0.5);
/// for nth in 0..100 {
///     let t = f64::from(nth) * 0.05;
///     trail.push(Mark { t, pose: [200.0 + 10.0 * t, 0.0, 50.0, 0.0], j4: 0.0 });
/// }
/// let plan = trail.plan("led", None, Follow::Path);
/// assert_eq!(plan.steps.len(), 3); // there, how fast, along
/// ```
#[derive(Clone, Debug)]
pub struct Trail {
    tolerance: f64,
    /// From rest to rest.
    stretches: Vec<Stretch>,
    /// The last mark that was no rest, and when the arm was seen last.
    last: Option<(Mark, f64)>,
}

/// From one rest to the next.
#[derive(Clone, Debug)]
struct Stretch {
    /// How long the arm had rested, s.
    rest: f64,
    begun: f64,
    ended: f64,
    length: f64,
    /// J4, from and to.
    j4: [f64; 2],
    /// Marks that stay, and behind them those that are to be thinned yet.
    marks: Vec<Mark>,
    thinned: usize,
}

impl Trail {
    /// An empty one; the tolerance is in mm, and in degrees of J4.
    #[must_use]
    pub fn new(tolerance: f64) -> Self {
        Self {
            tolerance,
            stretches: Vec::new(),
            last: None,
        }
    }

    /// Takes the next mark. One that is no number, or is not after the one before, is none.
    pub fn push(&mut self, mark: Mark) {
        let numbers = mark.pose.iter().chain([&mark.t, &mark.j4]);
        if !{ numbers }.all(|number| number.is_finite()) {
            return;
        }
        let Some((at, seen)) = self.last else {
            self.last = Some((mark, mark.t));
            return;
        };
        if mark.t <= seen {
            return;
        }
        if apart(&at, &mark) < STILL && (mark.pose[3] - at.pose[3]).abs() < STILL {
            self.last = Some((at, mark.t));
            // The end of a motion is where the arm came to rest.
            let stretch = self.stretches.last_mut();
            if let Some(end) = stretch.and_then(|stretch| stretch.marks.last_mut()) {
                end.pose = mark.pose;
            }
            return;
        }
        let rest = seen - at.t;
        if rest > REST || self.stretches.is_empty() {
            let end = self.stretches.last().and_then(|last| last.marks.last());
            let start = Mark {
                t: seen,
                ..end.copied().unwrap_or(at)
            };
            self.stretches.push(Stretch::from(start, rest));
        }
        if let Some(stretch) = self.stretches.last_mut() {
            stretch.push(mark, self.tolerance);
        }
        self.last = Some((mark, mark.t));
    }

    /// How far the tool was led, mm.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.stretches.iter().map(|stretch| stretch.length).sum()
    }

    /// The program that repeats it, for the tool that it was led with. Empty if nothing was pushed.
    #[must_use]
    pub fn plan(&self, title: &str, tool: Option<Tool>, follow: Follow) -> Plan {
        let mut plan = Plan {
            tool,
            ..Plan::new(title)
        };
        let Some((last, _)) = self.last else {
            return plan;
        };
        let first = self.stretches.first().and_then(|first| first.marks.first());
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
    fn from(start: Mark, rest: f64) -> Self {
        Self {
            rest,
            begun: start.t,
            ended: start.t,
            length: 0.0,
            j4: [start.j4; 2],
            marks: vec![start],
            thinned: 0,
        }
    }

    fn push(&mut self, mark: Mark, tolerance: f64) {
        if let Some(last) = self.marks.last() {
            self.length += along(last, &mark);
        }
        self.ended = mark.t;
        self.j4 = [self.j4[0].min(mark.j4), self.j4[1].max(mark.j4)];
        self.marks.push(mark);
        if self.marks.len() - self.thinned > CHUNK {
            let tail = thin(&self.marks[self.thinned..], tolerance);
            self.marks.truncate(self.thinned);
            self.marks.extend(tail);
            self.thinned = self.marks.len() - 1;
        }
    }

    fn turns(&self) -> bool {
        self.j4[1] - self.j4[0] > HELD
    }

    /// Adds the steps that follow it; the arm stands at its first mark.
    fn follow(&self, plan: &mut Plan, tolerance: f64, follow: Follow, told: &mut Option<Told>) {
        let lines = follow == Follow::Lines || self.turns();
        let velocity = (self.length / (self.ended - self.begun)).clamp(SPEEDS[0], SPEEDS[1]);
        let velocity = (velocity * 10.0).round() / 10.0;
        let acceleration = (4.0 * velocity).clamp(ACCELERATIONS[0], ACCELERATIONS[1]);
        let speed = Told { lines, velocity };
        if *told != Some(speed) {
            let word = if lines {
                words::line_speed
            } else {
                words::path_speed
            };
            let command = word(velocity as f32, acceleration as f32);
            plan.push(command, Origin::NONE);
            *told = Some(speed);
        }
        let (done, rest) = self.marks.split_at(self.thinned);
        let marks = done.iter().copied().chain(thin(rest, tolerance));
        for mark in marks.skip(1) {
            let [x, y, z, r] = mark.pose.map(|number| number as f32);
            let action = match lines {
                true => Action::Move {
                    to: [x, y, z, r],
                    by: Travel::Line,
                },
                false => Action::Path { to: [x, y, z] },
            };
            plan.push(action, Origin::NONE);
        }
    }
}

/// The speed that the arm was told last.
#[derive(Clone, Copy, PartialEq)]
struct Told {
    lines: bool,
    velocity: f64,
}

fn rest(plan: &mut Plan, seconds: f64) {
    if seconds > REST {
        let milliseconds = (seconds * 1000.0).round().min(LONGEST);
        plan.push(Action::Wait(milliseconds as u32), Origin::NONE);
    }
}

/// How far the tool went, mm.
fn along(from: &Mark, to: &Mark) -> f64 {
    let apart = from.pose.iter().zip(to.pose).take(3);
    apart.map(|(a, b)| (b - a) * (b - a)).sum::<f64>().sqrt()
}

/// The same with J4: a degree counts as a millimetre.
fn apart(from: &Mark, to: &Mark) -> f64 {
    libm::hypot(along(from, to), to.j4 - from.j4)
}

/// First, last, and as few between as leave none farther away than the tolerance.
fn thin(marks: &[Mark], tolerance: f64) -> Vec<Mark> {
    let points: Vec<[f64; 4]> = marks.iter().map(point).collect();
    let kept = marks.iter().zip(kept(&points, tolerance));
    let kept = kept.filter(|(_, stays)| *stays);
    kept.map(|(mark, _)| *mark).collect()
}

fn point(mark: &Mark) -> [f64; 4] {
    let [x, y, z, _] = mark.pose;
    [x, y, z, mark.j4]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mark each 50 ms, from a time on.
    fn led(trail: &mut Trail, from: f64, seconds: f64, at: impl Fn(f64) -> ([f64; 4], f64)) {
        let count = (seconds / 0.05).round() as u32;
        for nth in 0..=count {
            let t = f64::from(nth) * 0.05;
            let (pose, j4) = at(t);
            let t = from + t;
            trail.push(Mark { t, pose, j4 });
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
    fn a_circle_is_a_path_within_the_tolerance_at_its_speed() {
        let mut trail = Trail::new(0.5);
        led(&mut trail, 0.0, 10.0, circle);
        let plan = trail.plan("circle", Some(Tool::Pen), Follow::Path);
        let points = path(&plan);
        assert!((8..40).contains(&points.len()), "{}", points.len());
        // In the middle of a chord the circle is farthest from it.
        for pair in points.windows(2) {
            let [x, y] = [0, 1].map(|axis| f64::from(pair[0][axis] + pair[1][axis]) / 2.0);
            let off = 30.0 - libm::hypot(x - 220.0, y);
            assert!((-0.01..0.6).contains(&off), "{off}");
        }
        let circumference = 30.0 * std::f64::consts::TAU;
        assert!((trail.length() - circumference).abs() < 0.5);
        let speed = plan.steps[1].action.command();
        assert_eq!(speed, words::path_speed(18.8, 75.2));
    }

    #[test]
    fn rests_are_kept_and_parts_of_a_motion_are_not_torn_apart() {
        let mut trail = Trail::new(0.5);
        let line = |t: f64| ([200.0 + 20.0 * t, 0.0, 0.0, 0.0], 0.0);
        led(&mut trail, 0.0, 2.0, |_| line(0.0));
        led(&mut trail, 2.05, 3.0, line);
        led(&mut trail, 5.1, 4.0, |_| line(3.0));
        led(&mut trail, 9.15, 2.0, |t| line(3.0 - t));
        let plan = trail.plan("to and fro", None, Follow::Path);
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
    fn where_j4_turns_the_way_is_of_lines() {
        let mut trail = Trail::new(0.5);
        led(&mut trail, 0.0, 2.0, |t| {
            ([200.0, 10.0 * t, 0.0, 20.0 * t], 20.0 * t)
        });
        let plan = trail.plan("turned", None, Follow::Path);
        let last = plan.steps.last().map(|step| step.action.clone());
        let (to, by) = ([200.0, 20.0, 0.0, 40.0], Travel::Line);
        assert_eq!(last, Some(Action::Move { to, by }));
        // And so it is when nothing else can be said.
        let mut trail = Trail::new(0.5);
        led(&mut trail, 0.0, 10.0, circle);
        let plan = trail.plan("circle", None, Follow::Lines);
        let paths = plan
            .steps
            .iter()
            .filter(|step| matches!(step.action, Action::Path { .. }));
        assert_eq!(paths.count(), 0);
        assert!(crate::formats::playback::Playback::from_plan(&plan).is_ok());
    }

    #[test]
    fn long_motions_are_thinned_on_the_way() {
        let mut trail = Trail::new(0.5);
        led(&mut trail, 0.0, 1000.0, circle);
        let marks: usize = trail
            .stretches
            .iter()
            .map(|stretch| stretch.marks.len())
            .sum();
        assert!(marks < CHUNK + 3000, "{marks}");
        assert_eq!(trail.stretches.len(), 1);
    }

    #[test]
    fn what_is_no_mark_is_none() {
        let mut trail = Trail::new(0.5);
        assert!(trail.plan("", None, Follow::Path).steps.is_empty());
        let mark = Mark {
            t: 1.0,
            pose: [200.0, 0.0, 0.0, 0.0],
            j4: 0.0,
        };
        trail.push(Mark {
            j4: f64::NAN,
            ..mark
        });
        assert!(trail.plan("", None, Follow::Path).steps.is_empty());
        trail.push(mark);
        trail.push(Mark {
            t: 0.5,
            pose: [100.0; 4],
            ..mark
        });
        assert_eq!(trail.plan("", None, Follow::Path).steps.len(), 1);
        assert_eq!(trail.length(), 0.0);
    }
}
