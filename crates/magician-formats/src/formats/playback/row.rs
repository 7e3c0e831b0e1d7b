//! Taught points and the rows that store them.

use magician_host::{Message, Set, message};

use crate::{Action, Grip, Origin, Travel};

/// Number of the item with the rail position.
pub(super) const RAIL_ITEM: u32 = 36;

/// Motion to a taught point.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PointMotion {
    /// Point-to-point move.
    Move(Travel),
    /// Arc through an intermediate point, whose r is ignored.
    Arc {
        /// Intermediate point: x, y, z, r.
        via: [f32; 4],
    },
}

/// Content of a row, in order of execution: motion, tool action, pause.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Name; may be empty.
    pub name: String,
    /// Motion.
    pub way: PointMotion,
    /// Target: x, y, z, r.
    pub to: [f32; 4],
    /// State of the gripper; `None` if the file has no column for it.
    pub gripper: Option<Grip>,
    /// State of the suction cup; `None` if the file has no column for it.
    pub suction: Option<bool>,
    /// Pause, ms.
    pub pause: u32,
    /// Position of the rail's carriage, mm; `None` if the file has no column for it. In files
    /// without a rail it is 0 at every point.
    pub rail: Option<f32>,
}

impl Point {
    /// Creates a point without name, tool action and pause.
    #[must_use]
    pub fn new(way: PointMotion, to: [f32; 4]) -> Self {
        Self {
            name: String::new(),
            way,
            to,
            gripper: None,
            suction: None,
            pause: 0,
            rail: None,
        }
    }

    /// Returns the motion to the point, without the rail.
    #[must_use]
    pub fn motion(&self) -> Action {
        match self.way {
            PointMotion::Move(by) => Action::Move { to: self.to, by },
            PointMotion::Arc { via } => Action::Arc { via, to: self.to },
        }
    }
}

/// Row of a playback file: its items as stored, and the point they describe.
///
/// Equality compares the items, not the places in the source.
#[derive(Clone, Debug)]
pub struct Row {
    pub(super) number: u32,
    pub(super) parts: Vec<Part>,
    pub(super) point: Point,
    pub(super) places: Places,
}

/// Child element of a row.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Part {
    /// `item_N` with its text.
    Item(u32, String),
    /// Any other element, as it stands. Only the reader creates it.
    #[cfg_attr(not(feature = "programs"), expect(dead_code))]
    Other(String),
}

/// Places in the file of the parts of a row.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Places {
    /// Coordinates.
    pub(super) motion: Origin,
    pub(super) gripper: Origin,
    pub(super) suction: Origin,
    pub(super) pause: Origin,
}

impl PartialEq for Row {
    fn eq(&self, other: &Self) -> bool {
        self.number == other.number && self.parts == other.parts
    }
}

impl Row {
    /// Number in its name `row<N>`.
    #[must_use]
    pub fn number(&self) -> u32 {
        self.number
    }

    /// Returns the point.
    #[must_use]
    pub fn point(&self) -> &Point {
        &self.point
    }

    /// Returns the text of `item_<N>`, as stored.
    #[must_use]
    pub fn item(&self, number: u32) -> Option<&str> {
        self.parts.iter().find_map(|part| match part {
            Part::Item(own, text) if *own == number => Some(text.as_str()),
            _ => None,
        })
    }

    /// Creates a row for a point, with the items that DobotStudio 1.9 writes. With `arcs` it
    /// includes those of the second point.
    pub(super) fn of(number: u32, point: Point, arcs: bool) -> Self {
        let (style, first, second) = match point.way {
            PointMotion::Move(Travel::Jump) => (0, point.to, None),
            PointMotion::Move(Travel::Joints) => (1, point.to, None),
            PointMotion::Move(Travel::Line) => (2, point.to, None),
            PointMotion::Arc { via } => (3, via, Some(point.to)),
        };
        let mut items = vec![(0, style.to_string()), (1, point.name.clone())];
        items.extend((2..).zip(first.map(|value| format!("{value:?}"))));
        if arcs {
            let second = second.map(|to| to.map(|value| format!("{value:?}")));
            items.extend((6..).zip(second.unwrap_or_default()));
        }
        items.extend(point.rail.map(|l| (RAIL_ITEM, format!("{l:?}"))));
        items.push((10, format!("{:?}", f64::from(point.pause) / 1000.0)));
        let gripper = point.gripper.map(|grip| match grip {
            Grip::Off => 0,
            Grip::Open => 1,
            Grip::Close => 2,
        });
        items.extend(gripper.map(|code| (11, code.to_string())));
        items.extend(point.suction.map(|on| (12, u8::from(on).to_string())));
        Self {
            number,
            parts: items
                .into_iter()
                .map(|(n, text)| Part::Item(n, text))
                .collect(),
            point,
            places: Places::default(),
        }
    }
}

/// Parses the number after the prefix of a name such as `row12`.
pub(super) fn numbered(name: &str, prefix: &str) -> Option<u32> {
    let digits = name.strip_prefix(prefix)?;
    let plain = digits == "0" || !digits.starts_with('0');
    (plain && digits.bytes().all(|byte| byte.is_ascii_digit()))
        .then(|| digits.parse().ok())
        .flatten()
}

/// Returns what kind of setting a command is, in words, if a playback file cannot store it. `None`
/// for other commands.
pub(super) fn setting(command: &Set) -> Option<Message> {
    Some(match command {
        Set::PtpJointParams(_)
        | Set::PtpCoordinateParams(_)
        | Set::PtpLParams(_)
        | Set::PtpCommonParams(_)
        | Set::CpParams(_)
        | Set::ArcParams(_)
        | Set::ArcCommonParams(_) => message!("speeds"),
        Set::SetDeviceWithL(_) => message!("settings of the rail"),
        Set::PtpJumpParams(_) | Set::PtpJump2Params(_) => message!("heights of jumps"),
        _ => return None,
    })
}
