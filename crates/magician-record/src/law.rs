//! Residue of a log against the law of motion: distance of the logged positions from those that the
//! law gives (model section 7).
//!
//! Two kinds of logs can be measured:
//!
//! * **A session** ([`LawReport::of_session`]) contains the commands. It is
//!   [replayed](crate::replay) on a virtual arm of each built-in profile with a distinct motion,
//!   with the best phase of the periods, and the poses are compared.
//! * **Readings** ([`LawReport::of_samples`]) contain poses only. Motions from rest to rest along
//!   one line are compared with a velocity profile over the same distance, whose start, speed and
//!   acceleration are fitted.
//!
//! Times are measured by the host, so they jitter. A pose may belong to an instant up to 5 ms
//! before or after its time; its residue is the smallest deviation over these instants. Near the
//! boundary of a period, the pose of the neighbouring period therefore adds no residue. In
//! continuous time, no position that the arm passed within these 10 ms adds residue. A command may
//! have arrived up to half a period before or after its time; it is moved to the neighbouring
//! period if the poses after it fit better there.
//!
//! Whatever a log does not reveal is listed ([`LawReport::untold`]), not guessed.

mod gap;
mod log;
mod ramp;
mod settings;

use magician_motion::ArmModel;
use magician_sim::{Controller, Profile};
use serde::Serialize;

pub use gap::LawGap;
pub use log::{LogError, Sample, Samples};
use ramp::{Along, Motions};

use crate::replay::{Replay, Residue, Tolerances};

/// Largest residue that still agrees with the law, mm or deg. A recording of a real arm has 0.001
/// mm.
pub const LIMIT: f64 = 0.015;
/// Residue above which no profile is accepted, mm or deg. It leaves room for noise.
const MAX_RESIDUE: f64 = 0.05;
/// Longest median interval between poses at which ramps are visible, s.
const MAX_SAMPLE_INTERVAL: f64 = 0.125;
/// Factor by which the residue of the best profile must be smaller than that of another.
const DISTINCTION_FACTOR: f64 = 2.0;

/// Method by which a log was judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Basis {
    /// Replay of its commands.
    Commands,
    /// Poses alone.
    Readings,
}

/// Kind of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Kind {
    /// A jog of x, y or z.
    JogSpace,
    /// A jog of r.
    JogRotation,
    /// A jog of a joint.
    JogJoint,
    /// A straight move.
    Line,
    /// A move of all joints together.
    Joints,
    /// A continuous path.
    Path,
    /// An arc.
    Arc,
    /// A motion along a straight line, from readings.
    StraightWay,
    /// A motion of the joints, from readings.
    JointWay,
}

impl Kind {
    /// Name in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::JogSpace => "jog in space",
            Self::JogRotation => "jog of r",
            Self::JogJoint => "jog of a joint",
            Self::Line => "straight move",
            Self::Joints => "joint move",
            Self::Path => "continuous path",
            Self::Arc => "arc",
            Self::StraightWay => "along a line",
            Self::JointWay => "in the joints",
        }
    }

    /// Unit of its length.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::JogRotation | Self::JogJoint | Self::Joints | Self::JointWay => "deg",
            _ => "mm",
        }
    }
}

/// Speed and acceleration of motions of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Speeds {
    /// Kind of the motions.
    #[serde(rename = "motion")]
    pub kind: Kind,
    /// Acceleration in force, mm/s2 or deg/s2.
    pub acceleration: f64,
    /// Speed in force, mm/s or deg/s; `None` if no motion was long enough to reach it.
    pub speed: Option<f64>,
    /// Ratio of the speed, percent. From commands: the one in force. From readings: the ratio at
    /// which the power-up settings would yield this motion; `None` if no ratio does.
    pub ratio: Option<f64>,
}

/// Distance of a profile from the log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProfileResidue {
    /// Name of the profile.
    pub profile: String,
    /// Other profiles with the same motion.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub same: Vec<&'static str>,
    /// Period, ms; 0 for continuous time.
    pub period_ms: f64,
    /// Largest deviation of x, y or z, mm; from readings, of the position on a line.
    pub mm: f64,
    /// Largest deviation of r or a joint, deg.
    pub deg: f64,
}

impl ProfileResidue {
    fn worst(&self) -> f64 {
        self.mm.max(self.deg)
    }
}

/// Result of measuring a log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LawReport {
    /// Method by which the log was judged.
    pub basis: Basis,
    /// Number of poses.
    pub poses: usize,
    /// Number of poses read while the arm moved.
    pub moving: usize,
    /// Time from the first pose to the last, s.
    pub seconds: f64,
    /// Best profile; `None` if the log does not reveal it.
    pub profile: Option<String>,
    /// Period of the best profile, ms; 0 for continuous time; `None` if the log does not reveal it.
    pub period_ms: Option<f64>,
    /// All profiles, the best first.
    pub residues: Vec<ProfileResidue>,
    /// Speeds and accelerations of the motions.
    pub speeds: Vec<Speeds>,
    /// Facts that the log does not reveal.
    #[serde(rename = "not_told")]
    pub untold: Vec<LawGap>,
}

/// A profile to compare with a log. No other candidate has the same motion.
struct Candidate {
    name: String,
    same: Vec<&'static str>,
    profile: Profile,
}

impl Candidate {
    /// Built-in profiles with distinct motions, plus the named profile `more` if its motion differs
    /// from theirs.
    fn all(more: Option<(String, Profile)>) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        for (name, _) in Profile::NAMED {
            let Some(profile) = Profile::named(name) else {
                continue;
            };
            match all.iter_mut().find(|known| known.moves_as(&profile)) {
                Some(known) => known.same.push(name),
                None => all.push(Self {
                    name: name.to_owned(),
                    same: Vec::new(),
                    profile,
                }),
            }
        }
        let more = more.filter(|(_, profile)| !all.iter().any(|known| known.moves_as(profile)));
        all.extend(more.map(|(name, profile)| Self {
            name,
            same: Vec::new(),
            profile,
        }));
        all
    }

    /// True if both profiles move alike. The identity of the arm is left out, because it does not
    /// affect motion.
    fn moves_as(&self, profile: &Profile) -> bool {
        let identity = self.profile.identity.clone();
        self.profile
            == Profile {
                identity,
                ..profile.clone()
            }
    }

    fn residue(&self, mm: f64, deg: f64) -> ProfileResidue {
        let law = self.profile.arm_model().law;
        ProfileResidue {
            profile: self.name.clone(),
            same: self.same.clone(),
            period_ms: f64::from(law.period_us()) / 1000.0,
            mm,
            deg,
        }
    }
}

impl LawReport {
    /// Measures a recorded session. `more` is a profile to compare besides the built-in ones.
    ///
    /// If the session has no commands that move the arm, or the commands do not explain the poses,
    /// the poses alone are measured.
    ///
    /// ```
    /// use magician_record::law::{LawReport, LawGap};
    /// use magician_record::replay::Replay;
    ///
    /// # let mut file = Vec::new();
    /// # {
    /// #     use magician_protocol::Direction::Request;
    /// #     use magician_record::trace::TraceWriter;
    /// #     let mut trace = TraceWriter::new(&mut file)?;
    /// #     let link = trace.link("arm")?;
    /// #     trace.record(link, 1, Request, &[0xAA, 0xAA, 0x02, 0x0A, 0x00, 0xF6])?;
    /// # }
    /// let report = LawReport::of_session(&Replay::new(&file)?, None);
    /// assert_eq!(report.untold, [LawGap::NoPoses]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn of_session(session: &Replay<'_>, more: Option<(String, Profile)>) -> Self {
        let log = Samples::of_session(session);
        let candidates = Candidate::all(more);
        if log.samples.is_empty() || !session.moves() {
            return Self::from_poses(&log, &candidates);
        }
        let tolerances = Tolerances {
            measured: LIMIT as f32,
            ..Tolerances::default()
        };
        let session = session.clone().tolerances(tolerances);
        let residues = candidates.iter().map(|candidate| {
            let arm = Controller::new(session.beginning(candidate.profile.clone()));
            session.clone().fitted(&arm).residue(&arm)
        });
        let residues: Vec<Residue> = residues.collect();
        let mut report = Self::new(&log, Basis::Commands);
        report.moving = residues.first().map_or(0, |first| first.moved as usize);
        if report.moving == 0 {
            report.untold.push(LawGap::AtRest);
            return report;
        }
        let pairs = candidates.iter().zip(&residues);
        let pairs = pairs.map(|(candidate, residue)| candidate.residue(residue.mm, residue.deg));
        report.choose_profile(pairs.collect());
        let best = candidates
            .iter()
            .find(|own| Some(&own.name) == report.profile.as_ref());
        match best.or(candidates
            .first()
            .filter(|_| report.untold == [LawGap::Alike]))
        {
            Some(best) => report.speeds = settings::speeds(&session, &best.profile),
            None => {
                // The poses alone may reveal the law.
                let alone = Self::from_poses(&log, &candidates);
                if alone.profile.is_some() {
                    report = alone;
                    report.untold.insert(0, LawGap::SetBefore);
                } else {
                    report.untold.push(LawGap::SetBefore);
                }
            }
        }
        report
    }

    /// Measures readings. `more` is a profile to compare besides the built-in ones.
    ///
    /// ```
    /// use magician_record::law::{LawReport, Sample, Samples, LawGap};
    ///
    /// let still = |t| Sample { t, values: [200.0, 0.0, 50.0, 0.0, 0.0, 45.0, 45.0, 0.0] };
    /// let samples = (0..10).map(|nth| still(f64::from(nth) * 0.05)).collect();
    /// let report = LawReport::of_samples(&Samples { samples, cut: false }, None);
    /// assert_eq!(report.untold, [LawGap::AtRest]);
    /// ```
    #[must_use]
    pub fn of_samples(log: &Samples, more: Option<(String, Profile)>) -> Self {
        Self::from_poses(log, &Candidate::all(more))
    }

    fn new(log: &Samples, basis: Basis) -> Self {
        let span = match (log.samples.first(), log.samples.last()) {
            (Some(first), Some(last)) => last.t - first.t,
            _ => 0.0,
        };
        let cut = log.cut.then_some(LawGap::Cut);
        Self {
            basis,
            poses: log.samples.len(),
            moving: 0,
            seconds: thousandths(span),
            profile: None,
            period_ms: None,
            residues: Vec::new(),
            speeds: Vec::new(),
            untold: cut.into_iter().collect(),
        }
    }

    fn from_poses(log: &Samples, candidates: &[Candidate]) -> Self {
        let mut report = Self::new(log, Basis::Readings);
        let motions = Motions::of(&log.samples);
        report.moving = motions.moving;
        let untold = &mut report.untold;
        if log.samples.is_empty() {
            untold.push(LawGap::NoPoses);
            return report;
        }
        if report.seconds < ramp::REST {
            untold.push(LawGap::Brief);
            return report;
        }
        if motions.at_rest {
            untold.push(LawGap::AtRest);
            return report;
        }
        let mut gaps: Vec<f64> = log
            .samples
            .windows(2)
            .map(|two| two[1].t - two[0].t)
            .collect();
        gaps.sort_by(f64::total_cmp);
        // The median: a single gap, as of a pause, says nothing about the rate.
        let gap = gaps.get(gaps.len() / 2).copied().unwrap_or_default();
        if gap > MAX_SAMPLE_INTERVAL {
            let every_ms = (gap * 1000.0).round() as u64;
            untold.push(LawGap::Slow { every_ms });
        }
        let gap_counts = [
            (
                motions.sparse,
                LawGap::Sparse {
                    motions: motions.sparse,
                },
            ),
            (
                motions.bent,
                LawGap::Bent {
                    motions: motions.bent,
                },
            ),
            (
                motions.short,
                LawGap::Short {
                    motions: motions.short,
                },
            ),
            (
                motions.open,
                LawGap::Open {
                    motions: motions.open,
                },
            ),
            (
                motions.skipped,
                LawGap::Left {
                    motions: motions.skipped,
                },
            ),
        ];
        untold.extend(
            gap_counts
                .into_iter()
                .filter_map(|(count, what)| (count > 0).then_some(what)),
        );
        if motions.fitted.is_empty() {
            return report;
        }
        let mut residues = Vec::new();
        let mut ramps = Vec::new();
        for candidate in candidates {
            let law = candidate.profile.arm_model().law;
            let fits: Vec<_> = motions
                .fitted
                .iter()
                .map(|motion| motion.fit(law))
                .collect();
            let worst = |in_joints: bool| {
                let own = motions.fitted.iter().zip(&fits);
                let own =
                    own.filter(|(motion, _)| matches!(motion.along, Along::Joint(_)) == in_joints);
                own.map(|(_, fit)| fit.worst).fold(0.0, f64::max)
            };
            residues.push(candidate.residue(worst(false), worst(true)));
            ramps.push(fits);
        }
        report.choose_profile(residues);
        let best = candidates
            .iter()
            .position(|own| Some(&own.name) == report.profile.as_ref());
        // Speeds and accelerations hardly depend on the period, so any candidate will do.
        let best = best.or(report.untold.contains(&LawGap::Alike).then_some(0));
        let Some(ramps) = best.map(|best| &ramps[best]) else {
            return report;
        };
        for (motion, ramp) in motions.fitted.iter().zip(ramps) {
            let speeds = Speeds {
                kind: match motion.along {
                    Along::Joint(_) => Kind::JointWay,
                    Along::Axis(_) | Along::Line => Kind::StraightWay,
                },
                acceleration: thousandths(ramp.acceleration),
                speed: ramp.speed.map(thousandths),
                ratio: ratio(motion.along, ramp.speed, ramp.acceleration),
            };
            if !report.speeds.contains(&speeds) {
                report.speeds.push(speeds);
            }
        }
        if report.speeds.iter().all(|speeds| speeds.speed.is_none()) {
            report.untold.push(LawGap::Speed);
        } else if report.speeds.iter().all(|speeds| speeds.ratio.is_none()) {
            report.untold.push(LawGap::Ratio);
        }
        report
    }

    /// Chooses the best profile, unless another fits about as well.
    fn choose_profile(&mut self, mut residues: Vec<ProfileResidue>) {
        residues.sort_by(|a, b| a.worst().total_cmp(&b.worst()));
        for residue in &mut residues {
            (residue.mm, residue.deg) = (rounded(residue.mm), rounded(residue.deg));
        }
        let mut others = residues.iter();
        if let Some(best) = others.next() {
            let is_distinct = |other: &ProfileResidue| {
                other.worst() > LIMIT && other.worst() > DISTINCTION_FACTOR * best.worst()
                    || other.period_ms == best.period_ms
            };
            if best.worst() > MAX_RESIDUE {
                self.untold.push(LawGap::NoProfile);
            } else if !others.all(is_distinct) {
                self.untold.push(LawGap::Alike);
            } else {
                self.profile = Some(best.profile.clone());
                self.period_ms = Some(best.period_ms);
            }
        }
        self.residues = residues;
    }
}

/// Ratio at which the settings of power-up yield this motion, percent; `None` if no ratio does.
fn ratio(along: Along, speed: Option<f64>, acceleration: f64) -> Option<f64> {
    let power_up = &ArmModel::MAGICIAN.power_up;
    let (jog, ptp) = (&power_up.jog, &power_up.speeds());
    // 1 %: fitted speeds are less exact than poses.
    let is_near = |a: f64, b: f64| (a - b).abs() <= 0.01 * b;
    let percent = |share: f64| (share * 1000.0).round() / 10.0;
    let speed = speed?;
    let (jog, ptp) = match along {
        Along::Joint(joint) => (
            (
                jog.joint_velocity[joint].into(),
                jog.joint_acceleration[joint].into(),
            ),
            (ptp.joint_velocity[joint], ptp.joint_acceleration[joint]),
        ),
        Along::Axis(axis) => (
            (
                jog.coordinate_velocity[axis].into(),
                jog.coordinate_acceleration[axis].into(),
            ),
            (ptp.linear_velocity, ptp.linear_acceleration),
        ),
        // No jog moves several axes.
        Along::Line => ((0.0, 0.0), (ptp.linear_velocity, ptp.linear_acceleration)),
    };
    // The ratio of a jog scales the speed only, that of a move also the acceleration (model section
    // 6).
    if is_near(acceleration, jog.1) && speed <= jog.0 * 1.01 {
        return Some(percent(speed / jog.0));
    }
    let (speed_ratio, acceleration_ratio) = (speed / ptp.0, acceleration / ptp.1);
    (is_near(speed_ratio, acceleration_ratio) && speed_ratio <= 1.01).then(|| percent(speed_ratio))
}

/// Rounds to a tenth of a micrometre, below the accuracy of poses.
fn rounded(residue: f64) -> f64 {
    (residue * 1e4).round() / 1e4
}

fn thousandths(value: f64) -> f64 {
    (value * 1000.0).round() / 1000.0
}
