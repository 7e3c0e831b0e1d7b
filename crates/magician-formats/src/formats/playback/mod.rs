//! DobotStudio's Teaching & Playback files (`.playback`, sometimes renamed to `.xml`), read and
//! written.
//!
//! A [`Playback`] is the document: its rows in order, each with all items, known or not.
//! [`Playback::to_plan`] converts it to a plan, [`Playback::from_plan`] back. Loops and speed are
//! not part of the file, because the studio stores them elsewhere; the caller supplies them.
//!
//! The meaning of the items is known from files of DobotStudio 1.4.12, 1.7.0 and 1.9.4:
//!
//! | item | meaning |
//! |---|---|
//! | 0 | motion style: 0 JUMP, 1 MOVJ, 2 MOVL; ARC is 3 in 1.7 to 1.9 and 4 in 1.4 |
//! | 1 | name of the point |
//! | 2 to 5 | x, y, z, r; for an arc the intermediate point |
//! | 6 to 9 | end of an arc; ignored for other styles |
//! | 10 | pause at the point, s |
//! | 11 | gripper: 0 off, 1 open, 2 closed |
//! | 12 | suction cup: 0 off, 1 on |
//! | 36 | position on the sliding rail, mm; 0 in all rows if no rail is used |
//!
//! The JSON files of DobotLab are read too (`lab`).

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
/// Equality compares the content, not the places in the source.
#[derive(Clone, Debug, Default)]
pub struct Playback {
    /// Version of the studio that wrote it, such as `Ver-194`.
    pub version: Option<String>,
    /// Arm that it was taught on. Only newer studios store it.
    pub dobot_type: Option<String>,
    /// Taught points in playing order.
    pub rows: Vec<Row>,
    /// Unknown elements, kept unchanged.
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
    /// Tool that the points were taught with: the gripper if items 11 exist, the suction cup if
    /// items 12 do.
    ///
    /// `None` if the file has neither, as those of DobotStudio 1.4, or has both and uses neither.
    /// The caller must then name the tool.
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

    /// Notes about assumptions and parts left out. They are not errors.
    #[must_use]
    pub fn notes(&self) -> &[Diagnostic] {
        &self.notes
    }
}
