//! DobotStudio's Teaching & Playback files (`.playback`, also renamed to `.xml`), read and written.
//!
//! A [`Playback`] is the document: its rows in their order, each with all its items. [`Playback::to_plan`] is what the arm does
//! for it, [`Playback::from_plan`] the other way. Loops and speed are no part of the file: the studio keeps them elsewhere, and
//! the caller gives them.
//!
//! What is known of the items comes from files of DobotStudio 1.4.12, 1.7.0 and 1.9.4:
//!
//! | item | what it says |
//! |---|---|
//! | 0 | motion style: 0 JUMP, 1 MOVJ, 2 MOVL, ARC is 3 in 1.7 to 1.9 and 4 in 1.4 |
//! | 1 | name of the point |
//! | 2 to 5 | x, y, z, r; of an arc the point on the way |
//! | 6 to 9 | where an arc ends; of other styles nothing, whatever it holds |
//! | 10 | pause at the point, s |
//! | 11 | gripper: 0 off, 1 open, 2 closed |
//! | 12 | suction cup: 0 off, 1 on |
//! | 36 | position on the sliding rail, mm; 0 throughout where no rail is in use |
//!
//! Those of DobotLab, which are JSON, are read as well (`lab`).

#[cfg(feature = "programs")]
mod lab;
mod play;
#[cfg(feature = "programs")]
mod read;
mod record;
mod row;
mod write;

#[cfg(feature = "programs")]
pub(super) use read::read;
pub use row::{Point, PointMotion, Row};

use crate::{Diagnostic, Grip, Tool};

/// A playback file.
///
/// Two are equal if they say the same in the same words; where it stands in their files does not matter.
#[derive(Clone, Debug, Default)]
pub struct Playback {
    /// The studio that wrote it, such as `Ver-194`.
    pub version: Option<String>,
    /// The arm that it was taught on; only newer studios say it.
    pub dobot_type: Option<String>,
    /// The taught points, in the order in which they are played.
    pub rows: Vec<Row>,
    /// Unknown elements, unchanged.
    others: Vec<String>,
    notes: Vec<Diagnostic>,
}

impl PartialEq for Playback {
    fn eq(&self, other: &Self) -> bool {
        self.version == other.version
            && self.dobot_type == other.dobot_type
            && self.rows == other.rows
            && self.others == other.others
    }
}

impl Playback {
    /// The tool that it was taught with, by the column that it has: items 11 are the gripper's, items 12 the suction
    /// cup's. `None` for a file without either, as those of DobotStudio 1.4, and for one that has both and uses neither:
    /// the caller then has to name it.
    #[must_use]
    pub fn tool(&self) -> Option<Tool> {
        let points = || self.rows.iter().map(Row::point);
        let grips = points().filter_map(|point| point.gripper);
        let sucks = points().filter_map(|point| point.suction);
        match (grips.clone().next(), sucks.clone().next()) {
            (Some(_), None) => Some(Tool::Gripper),
            (None, Some(_)) => Some(Tool::Suction),
            (None, None) => None,
            _ if grips.clone().any(|grip| grip != Grip::Off) => Some(Tool::Gripper),
            _ if sucks.clone().any(|on| on) => Some(Tool::Suction),
            _ => None,
        }
    }

    /// What was taken in a certain way or left out when it was made; nothing of it is an error.
    #[must_use]
    pub fn notes(&self) -> &[Diagnostic] {
        &self.notes
    }
}
