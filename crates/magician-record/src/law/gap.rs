//! Quantities that a log does not reveal, each with the reason.

use std::fmt;

use serde::Serialize;

use super::MAX_RESIDUE;

/// Something that a log does not reveal, with the reason.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LawGap {
    /// The log has no poses.
    NoPoses,
    /// The poses cover less than two periods.
    Brief,
    /// The arm never moved.
    AtRest,
    /// Poses are too far apart.
    Slow {
        /// Interval between two poses, ms.
        every_ms: u64,
    },
    /// Motions with too few poses.
    Sparse {
        /// Number of motions.
        motions: usize,
    },
    /// Motions other than a single straight line.
    Bent {
        /// Number of motions.
        motions: usize,
    },
    /// Motions that are too short.
    Short {
        /// Number of motions.
        motions: usize,
    },
    /// Motions cut by the start or the end of the log.
    Open {
        /// Number of motions.
        motions: usize,
    },
    /// Motions beyond the number examined.
    Left {
        /// Number of motions.
        motions: usize,
    },
    /// Profiles with different periods fit equally well.
    Alike,
    /// No profile fits.
    NoProfile,
    /// Settings were made before the session began.
    SetBefore,
    /// The speed was never reached.
    Speed,
    /// The settings of power-up do not explain speed and acceleration.
    Ratio,
    /// The last line of the log is cut off.
    Cut,
}

impl LawGap {
    /// Subject of the report that remains unknown: the law, the period, and so on.
    #[must_use]
    pub const fn about(&self) -> &'static str {
        match self {
            Self::NoPoses | Self::Brief | Self::AtRest | Self::Slow { .. } => "law",
            Self::Alike => "period",
            Self::NoProfile => "profile",
            Self::SetBefore => "settings",
            Self::Speed => "speed",
            Self::Ratio => "ratio",
            Self::Cut => "end",
            _ => "motions",
        }
    }
}

impl fmt::Display for LawGap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = |f: &mut fmt::Formatter<'_>, motions: usize, what: &str| match motions {
            1 => write!(f, "1 motion {what}"),
            several => write!(f, "{several} motions {what}"),
        };
        match self {
            Self::NoPoses => f.write_str("no pose was read"),
            Self::Brief => f.write_str("its poses cover less than two periods of the arm, 40 ms"),
            Self::AtRest => f.write_str("the arm was at rest throughout"),
            Self::Slow { every_ms } => write!(
                f,
                "a pose came every {every_ms} ms only; 10 a second are needed, 23 a second are better"
            ),
            Self::Sparse { motions } => count(
                f,
                *motions,
                "had fewer than 6 poses on the way: read faster or move farther",
            ),
            Self::Bent { motions } => count(
                f,
                *motions,
                "went neither straight nor with all joints in proportion, or turned round: only a trace has the commands",
            ),
            Self::Short { motions } => count(f, *motions, "was shorter than 0.5 mm or deg"),
            Self::Open { motions } => count(
                f,
                *motions,
                "without a rest of two periods before and after it",
            ),
            Self::Left { motions } => count(f, *motions, "beyond the first 20"),
            Self::Alike => f.write_str(
                "profiles with different periods are equally near: poses came at whole periods, or hardly moved; 23 a second tell",
            ),
            Self::NoProfile => write!(f, "no profile is within {MAX_RESIDUE} mm and deg"),
            Self::SetBefore => f.write_str(
                "no profile makes these poses with the settings in the log: others were made before it began",
            ),
            Self::Speed => f.write_str("no motion was long enough to reach its speed"),
            Self::Ratio => {
                f.write_str("the settings of power-up do not explain speed and acceleration")
            }
            Self::Cut => f.write_str("the last line is cut off and left out"),
        }
    }
}

impl Serialize for LawGap {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Report<'a> {
            about: &'a str,
            why: String,
        }
        let (about, why) = (self.about(), self.to_string());
        Report { about, why }.serialize(serializer)
    }
}
