//! Motions recognised in readings alone: from rest to rest along a line, with one ramp up and one
//! down.
//!
//! Readings contain no commands. A jog of one axis, a straight move and a joint move all have the
//! same profile with three parameters: start, speed and acceleration. They are fitted so that the
//! readings are as close to the profile as possible.
//!
//! Times are the host's, and jitter. A reading is compared with the profile at its own time and
//! [`JITTER`] before and after; the smallest deviation is the residue. With periods, a reading
//! within the jitter of a boundary is thereby compared with the pose of the neighbouring period as
//! well. In continuous time it is compared with all positions within the jitter.
//!
//! The search has two steps: a coarse grid of guesses around the times of start and end, then
//! pattern search from the best few. Periods make many local minima, so one start would not do.

use magician_motion::{KinematicLimits, MotionLaw};

use super::log::Sample;
use crate::replay::JITTER;

/// Largest difference at which two values count as the same position, mm or deg. It is above the
/// noise of readings, and below the distance of the first period of a power-up jog.
const REST_TOLERANCE: f64 = 0.02;
/// Shortest time at one position that counts as rest, s: two periods.
pub(super) const REST: f64 = 0.04;
/// Largest distance of a reading from a straight line, mm or deg.
const LINE_TOLERANCE: f64 = 0.03;
/// Shortest motion that is fitted, mm or deg.
const MIN_MOTION: f64 = 0.5;
/// Fewest readings of a motion. Fewer do not determine three parameters.
const MIN_READINGS: usize = 6;
/// Number of readings at rest, before and after a motion, that are compared with its profile.
const REST_SAMPLES: usize = 3;
/// Most motions that are fitted. Each fit takes some ten milliseconds.
const MAX_FITTED_MOTIONS: usize = 20;

/// Space in which a motion is straight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Along {
    /// An axis of space, by index: 0 for x.
    Axis(usize),
    /// A line in space.
    Line,
    /// All joints together; index of the joint that turns furthest.
    Joint(usize),
}

/// A motion from rest to rest.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    pub(super) along: Along,
    /// Length, mm or deg.
    length: f64,
    /// Time and position of its readings.
    places: Vec<(f64, f64)>,
    /// Start: times of the last reading at rest and the first in motion. End: times of the last
    /// reading in motion and the first at rest.
    ends: [(f64, f64); 2],
}

/// Motions found in readings.
#[derive(Clone, Debug, Default)]
pub(super) struct Motions {
    pub(super) fitted: Vec<Motion>,
    /// Number of motions with too few readings.
    pub(super) sparse: usize,
    /// Number of motions that are straight neither in space nor in the joints, or that reverse.
    pub(super) bent: usize,
    /// Number of motions that are too short.
    pub(super) short: usize,
    /// Number of motions cut by the start or the end of the log.
    pub(super) open: usize,
    /// Number of motions not fitted because of [`MAX_FITTED_MOTIONS`].
    pub(super) skipped: usize,
    /// True if no two readings differ.
    pub(super) at_rest: bool,
    /// Number of readings during motions.
    pub(super) moving: usize,
}

/// The best profile of a motion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ramp {
    /// Speed, mm/s or deg/s; `None` if the motion is too short to reach it.
    pub(super) speed: Option<f64>,
    /// Acceleration, mm/s2 or deg/s2.
    pub(super) acceleration: f64,
    /// Largest distance of a reading from the profile, mm or deg.
    pub(super) worst: f64,
}

fn near(one: &Sample, other: &Sample) -> bool {
    let pairs = one.values.iter().zip(other.values);
    pairs
        .into_iter()
        .all(|(a, b)| (a - b).abs() <= REST_TOLERANCE)
}

/// Finds the stretches at rest, as indices of their first and last readings.
fn rests(samples: &[Sample]) -> Vec<(usize, usize)> {
    let mut rests = Vec::new();
    let mut at = 0;
    while at < samples.len() {
        let same = samples[at + 1..].iter();
        let end = at + same.take_while(|other| near(&samples[at], other)).count();
        if samples[end].t - samples[at].t >= REST {
            rests.push((at, end));
            at = end + 1;
        } else {
            at += 1;
        }
    }
    rests
}

/// Place of a stretch at rest: the median of each value, which ignores outliers.
fn place(samples: &[Sample]) -> [f64; 8] {
    std::array::from_fn(|nth| {
        let mut values: Vec<f64> = samples.iter().map(|sample| sample.values[nth]).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or_default()
    })
}

impl Motions {
    pub(super) fn of(samples: &[Sample]) -> Self {
        let mut found = Self::default();
        let rests = rests(samples);
        let (Some(first), Some(last)) = (rests.first(), rests.last()) else {
            found.open = usize::from(samples.len() > 1);
            found.moving = samples.len();
            return found;
        };
        found.open = usize::from(first.0 > 0) + usize::from(last.1 + 1 < samples.len());
        found.moving = first.0 + samples.len() - last.1 - 1;
        for pair in rests.windows(2) {
            let [before, after] = [pair[0], pair[1]];
            found.moving += after.0 - before.1 - 1;
            found.add(samples, before, after);
        }
        found.at_rest = found.moving == 0 && rests.len() == 1;
        found
    }

    fn add(&mut self, samples: &[Sample], before: (usize, usize), after: (usize, usize)) {
        let from = place(&samples[before.0..=before.1]);
        let to = place(&samples[after.0..=after.1]);
        let on_way = after.0 - before.1 - 1;
        let head = before.1.saturating_sub(REST_SAMPLES).max(before.0);
        let tail = (after.0 + REST_SAMPLES).min(after.1);
        let way = &samples[head..=tail];
        let spaces = [in_space(&from, &to, way), in_joints(&from, &to, way)];
        let farthest = (0..8).map(|nth| (to[nth] - from[nth]).abs());
        let farthest = farthest.fold(0.0, f64::max);
        let straight = spaces.into_iter().flatten();
        let straight =
            straight.filter(|line| line.bend <= LINE_TOLERANCE && line.length >= MIN_MOTION);
        let straight = straight.min_by(|a, b| a.bend.total_cmp(&b.bend));
        match straight {
            // The order of these match arms decides which reason is reported for a motion with
            // several.
            _ if farthest < MIN_MOTION => self.short += 1,
            _ if on_way < MIN_READINGS => self.sparse += 1,
            None => self.bent += 1,
            Some(_) if self.fitted.len() >= MAX_FITTED_MOTIONS => self.skipped += 1,
            Some(line) => {
                let t = |at: usize| samples[at].t;
                self.fitted.push(Motion {
                    along: line.along,
                    length: line.length,
                    places: way.iter().map(|sample| sample.t).zip(line.places).collect(),
                    ends: [(t(before.1), t(before.1 + 1)), (t(after.0 - 1), t(after.0))],
                });
            }
        }
    }
}

/// A motion, projected onto a line in one of the two spaces.
struct Line {
    along: Along,
    length: f64,
    /// Largest deviation: beside the line, or backwards along it.
    bend: f64,
    places: Vec<f64>,
}

impl Line {
    /// Includes steps backwards in the deviation.
    fn in_order(mut self) -> Self {
        let mut last = 0.0_f64;
        for place in self.places.iter().copied().chain([self.length]) {
            self.bend = self.bend.max(last - place);
            last = last.max(place);
        }
        self
    }
}

fn in_space(from: &[f64; 8], to: &[f64; 8], way: &[Sample]) -> Option<Line> {
    let along: [f64; 3] = std::array::from_fn(|axis| to[axis] - from[axis]);
    let dot = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let length = libm::sqrt(dot(&along, &along));
    if length == 0.0 {
        return None;
    }
    let mut bend = 0.0_f64;
    let places = way.iter().map(|sample| {
        let off: [f64; 3] = std::array::from_fn(|axis| sample.values[axis] - from[axis]);
        let place = dot(&off, &along) / length;
        let beside = dot(&off, &off) - place * place;
        bend = bend.max(libm::sqrt(beside.max(0.0)));
        place
    });
    let places = places.collect();
    let alone = (0..3).find(|axis| along[*axis].abs() >= length - REST_TOLERANCE);
    Some(
        Line {
            along: alone.map_or(Along::Line, Along::Axis),
            length,
            bend,
            places,
        }
        .in_order(),
    )
}

fn in_joints(from: &[f64; 8], to: &[f64; 8], way: &[Sample]) -> Option<Line> {
    let turns: [f64; 4] = std::array::from_fn(|joint| to[4 + joint] - from[4 + joint]);
    let joint = (0..4).max_by(|a, b| turns[*a].abs().total_cmp(&turns[*b].abs()))?;
    let length = turns[joint].abs();
    if length == 0.0 {
        return None;
    }
    let mut bend = 0.0_f64;
    let places = way.iter().map(|sample| {
        let off = |nth: usize| sample.values[4 + nth] - from[4 + nth];
        let share = off(joint) / turns[joint];
        for (nth, turn) in turns.iter().enumerate() {
            bend = bend.max((off(nth) - share * turn).abs());
        }
        share * length
    });
    let places = places.collect();
    Some(
        Line {
            along: Along::Joint(joint),
            length,
            bend,
            places,
        }
        .in_order(),
    )
}

/// Parameters of the fit.
#[derive(Clone, Copy)]
struct Guess {
    /// Middle of the motion, s. It does not depend on the other two.
    middle: f64,
    /// Natural logarithms, so that steps are relative.
    speed: f64,
    acceleration: f64,
}

impl Guess {
    const NONE: Self = Self {
        middle: 0.0,
        speed: 0.0,
        acceleration: 0.0,
    };
}

/// Factors tried on the speed that the readings show. The readings of a triangular velocity profile
/// do not show its peak speed.
const FASTER: [f64; 14] = [
    0.94, 0.96, 0.97, 0.975, 0.98, 0.985, 0.99, 0.995, 1.0, 1.005, 1.01, 1.03, 1.2, 1.5,
];
/// Step between tried ramp durations, s. It is below a period, so one of them is close to the true
/// duration.
const RAMP_STEP: f64 = 0.006;
/// Step between tried middles, s.
const MIDDLE_STEP: f64 = 0.003;

/// Values from one number to another, at most a thousand.
fn steps(from: f64, to: f64, step: f64) -> impl Iterator<Item = f64> {
    let all = (0..1000).map(move |nth| from + f64::from(nth) * step);
    all.take_while(move |value| *value <= to)
}

/// Directions of the pattern search: middle, speed and acceleration, each up, down or unchanged.
const STEPS: [[f64; 3]; 26] = {
    let mut steps = [[0.0; 3]; 26];
    let (mut nth, mut at) = (0, 0);
    while nth < 27 {
        // The 14th of 27 is no step at all.
        if nth != 13 {
            steps[at] = [
                (nth / 9) as f64 - 1.0,
                (nth / 3 % 3) as f64 - 1.0,
                (nth % 3) as f64 - 1.0,
            ];
            at += 1;
        }
        nth += 1;
    }
    steps
};

/// Weight of the squared distance at a reading's own time, against that at the best time within the
/// jitter. It breaks ties: of profiles that fit equally well within the jitter, the one closest to
/// the readings at their own times wins.
const OWN_TIME_WEIGHT: f64 = 0.01;

/// Number of guesses that are refined. Periods create many local minima.
const MAX_REFINED_GUESSES: usize = 6;

impl Motion {
    /// Fits the best profile under a law.
    pub(super) fn fit(&self, law: MotionLaw) -> Ramp {
        let mut best: Option<(f64, Guess)> = None;
        for (cost, guess) in self.guesses(law) {
            let least = best.map_or(f64::MAX, |(least, _)| least);
            let (cost, guess) = self.follow(law, cost, guess);
            if cost < least {
                best = Some((cost, guess));
            }
        }
        let (_, guess) = best.unwrap_or((f64::MAX, Guess::NONE));
        self.rounded(law, guess)
    }

    /// Refines a guess by pattern search: halves the steps when no direction improves it.
    fn follow(&self, law: MotionLaw, mut cost: f64, mut best: Guess) -> (f64, Guess) {
        let (mut time, mut share) = (0.003, 0.03);
        // Down to 1 us of time, far below the jitter.
        while time > 1e-6 {
            let mut found = None;
            for [middle, speed, acceleration] in STEPS {
                let guess = Guess {
                    middle: best.middle + middle * time,
                    speed: best.speed + speed * share,
                    acceleration: best.acceleration + acceleration * 2.0 * share,
                };
                let tried = self.cost(law, guess, cost);
                if tried < cost {
                    (cost, found) = (tried, Some(guess));
                }
            }
            match found {
                Some(guess) => best = guess,
                None => (time, share) = (time * 0.5, share * 0.5),
            }
        }
        (cost, best)
    }

    /// Returns the highest mean speed that the readings show over at least 0.3 of the duration.
    fn steady_speed(&self, duration: f64) -> f64 {
        let mean = self.length / duration;
        let least = 0.3 * duration;
        let speeds = self.places.iter().enumerate().filter_map(|(at, from)| {
            let later = self.places[at..].iter().find(|to| to.0 - from.0 >= least)?;
            Some((later.1 - from.1) / (later.0 - from.0))
        });
        speeds.fold(mean, f64::max)
    }

    /// Returns the best guesses around the times of start and end.
    fn guesses(&self, law: MotionLaw) -> Vec<(f64, Guess)> {
        let middle = |(a, b): (f64, f64)| 0.5 * (a + b);
        let [begin, end] = self.ends.map(middle);
        let duration = (end - begin).max(0.01);
        let gap = self.ends.iter().map(|(a, b)| b - a).fold(0.0, f64::max);
        let fastest = self.steady_speed(duration);
        let reach = 0.5 * gap + 0.01;
        let mut best: Vec<(f64, Guess)> = Vec::new();
        for faster in FASTER {
            let velocity = fastest * faster;
            let cruise = self.length / velocity;
            // The ramp takes what remains of the duration after the cruise. Readings at its slow
            // ends count as rest, and the longer the ramp, the more of them do.
            let ramp = (duration - cruise).max(0.0);
            let least = (ramp - gap - 0.01).max(0.01);
            let unseen = 2.0 * libm::sqrt(2.0 * REST_TOLERANCE * ramp.max(0.02) / velocity);
            let most = (ramp + gap + 0.01 + unseen).min(1.05 * cruise);
            for ramp in steps(least, most, RAMP_STEP) {
                let acceleration = libm::log(velocity / ramp);
                for off in steps(-reach, reach, MIDDLE_STEP) {
                    let guess = Guess {
                        middle: 0.5 * (begin + end) + off,
                        speed: libm::log(velocity),
                        acceleration,
                    };
                    let most = match best.get(MAX_REFINED_GUESSES - 1) {
                        Some((most, _)) => *most,
                        None => f64::MAX,
                    };
                    let cost = self.cost(law, guess, most);
                    if cost < most {
                        let at = best.partition_point(|(known, _)| *known <= cost);
                        best.insert(at, (cost, guess));
                        best.truncate(MAX_REFINED_GUESSES);
                    }
                }
            }
        }
        best
    }

    fn limits(guess: Guess) -> KinematicLimits {
        KinematicLimits {
            velocity: libm::exp(guess.speed),
            acceleration: libm::exp(guess.acceleration),
        }
    }

    /// Returns the sum of squares to minimise. Once the sum reaches `most`, returns a partial sum.
    fn cost(&self, law: MotionLaw, guess: Guess, most: f64) -> f64 {
        let mut sum = 0.0;
        self.distances(law, Self::limits(guess), guess.middle, |own, best| {
            sum += best * best + OWN_TIME_WEIGHT * own * own;
            sum < most
        });
        sum
    }

    /// Calls `visit` with the distance of each reading from a profile, at its own time and at the
    /// best time within the jitter, until it returns false.
    fn distances(
        &self,
        law: MotionLaw,
        limits: KinematicLimits,
        middle: f64,
        mut visit: impl FnMut(f64, f64) -> bool,
    ) {
        let profile = law.rest_to_rest(self.length, &limits);
        let begin = middle - 0.5 * limits.least_time(self.length);
        let period = f64::from(law.period_us()) / 1e6;
        let place = |t: f64| {
            if period > 0.0 {
                // A rounding error in the time must not cost a period.
                profile.position(libm::floor(t / period + 1e-6) * period)
            } else {
                profile.position(t)
            }
        };
        let jitter = JITTER as f64 / 1e6;
        for (t, seen) in &self.places {
            let t = t - begin;
            let [early, own, late] = [t - jitter, t, t + jitter].map(place);
            let off = (own - seen).abs();
            let best = if period > 0.0 {
                off.min((early - seen).abs()).min((late - seen).abs())
            } else {
                (seen - seen.clamp(early, late)).abs()
            };
            if !visit(off, best) {
                return;
            }
        }
    }

    /// Replaces the parameters by round numbers, if the readings are no further from those.
    fn rounded(&self, law: MotionLaw, guess: Guess) -> Ramp {
        let worst = |limits, middle| {
            let mut worst = 0.0_f64;
            self.distances(law, limits, middle, |_, best| {
                worst = worst.max(best);
                true
            });
            worst
        };
        // A triangular profile never reaches its speed: any higher speed gives the same readings.
        let reaches = |limits: &KinematicLimits| {
            limits.velocity * limits.velocity < 0.98 * limits.acceleration * self.length
        };
        let own = Self::limits(guess);
        let mut known = (worst(own, guess.middle), own);
        // Settings have few digits, and their product with a ratio hardly more.
        let digits = [0.1, 0.2, 1.0, 2.0, 10.0, 100.0];
        let tried = digits.into_iter().flat_map(|digits| {
            let round = |value: f64, digits: f64| (value * digits).round() / digits;
            let acceleration = round(own.acceleration, f64::max(digits, 1.0));
            // If the speed is barely reached, the readings may fit a higher speed just as well.
            let speeds = [round(own.velocity, digits), 10.0 * own.velocity];
            speeds.map(|velocity| KinematicLimits {
                velocity,
                acceleration,
            })
        });
        let tried = tried.filter(|limits| limits.velocity > 0.0 && limits.acceleration > 0.0);
        let tried = tried.map(|limits| {
            let middles = (-24..=24).map(|nth| guess.middle + f64::from(nth) * 5e-4);
            let off = middles.map(|middle| worst(limits, middle));
            (off.fold(f64::MAX, f64::min), limits)
        });
        let tried: Vec<_> = tried.collect();
        let least = tried.iter().map(|(off, _)| *off).fold(known.0, f64::min);
        if let Some(round) = tried.into_iter().find(|(off, _)| *off <= least + 1e-3) {
            known = round;
        }
        let (worst, limits) = known;
        Ramp {
            speed: reaches(&limits).then_some(limits.velocity),
            acceleration: limits.acceleration,
            worst,
        }
    }
}
