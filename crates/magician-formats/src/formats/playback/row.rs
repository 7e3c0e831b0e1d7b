//! One taught point, and the row that says it.

use magician_host::Set;

use crate::{Action, Grip, Origin, Travel};

/// The item with the position on the rail.
pub(super) const RAIL: u32 = 36;

/// How a taught point is reached.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PointMotion {
    /// As a point-to-point move.
    Move(Travel),
    /// On an arc through a point, whose r does not count.
    Arc {
        /// The point on the way: x, y, z, r.
        via: [f32; 4],
    },
}

/// What a row of a playback file says, in this order: where the arm goes, what its tool does there, how long it stays.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// What it is called; empty if it has no name.
    pub name: String,
    /// How it is reached.
    pub way: PointMotion,
    /// Where it is: x, y, z, r.
    pub to: [f32; 4],
    /// What the gripper does there, where the file has a column for it.
    pub gripper: Option<Grip>,
    /// What the suction cup does there, where the file has a column for it.
    pub suction: Option<bool>,
    /// How long the arm stays, ms.
    pub pause: u32,
    /// Where the carriage of the sliding rail is, mm, where the file has a column for it. In files without a rail it is 0
    /// at every point.
    pub rail: Option<f32>,
}

impl Point {
    /// One without a name, a tool or a pause.
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

    /// The move that leads to it, without the rail.
    #[must_use]
    pub fn motion(&self) -> Action {
        match self.way {
            PointMotion::Move(by) => Action::Move { to: self.to, by },
            PointMotion::Arc { via } => Action::Arc { via, to: self.to },
        }
    }
}

/// A row of a playback file: its items as they stand there, and what they say.
///
/// Two rows are equal if their items are, wherever they stand in their files.
#[derive(Clone, Debug)]
pub struct Row {
    pub(super) number: u32,
    pub(super) parts: Vec<Part>,
    pub(super) point: Point,
    pub(super) places: Places,
}

/// What stands in a row.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Part {
    /// `item_N`, with its text.
    Item(u32, String),
    /// Anything else, as it stands; only a reader meets it.
    #[cfg_attr(not(feature = "programs"), expect(dead_code))]
    Other(String),
}

/// Where in its file a row says what.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Places {
    /// The coordinates.
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
    /// The number in its name, `row<N>`.
    #[must_use]
    pub fn number(&self) -> u32 {
        self.number
    }

    /// What it says.
    #[must_use]
    pub fn point(&self) -> &Point {
        &self.point
    }

    /// The text of `item_<N>`, as the file has it.
    #[must_use]
    pub fn item(&self, number: u32) -> Option<&str> {
        self.parts.iter().find_map(|part| match part {
            Part::Item(own, text) if *own == number => Some(text.as_str()),
            _ => None,
        })
    }

    /// A row for a point, with the items that DobotStudio 1.9 writes, and those of a second point if `arcs`.
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
        items.extend(point.rail.map(|l| (RAIL, format!("{l:?}"))));
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

/// The number in a name such as `row12`, after its `row`.
pub(super) fn numbered(name: &str, prefix: &str) -> Option<u32> {
    let digits = name.strip_prefix(prefix)?;
    let plain = digits == "0" || !digits.starts_with('0');
    (plain && digits.bytes().all(|byte| byte.is_ascii_digit()))
        .then(|| digits.parse().ok())
        .flatten()
}

/// What speeds, heights and the like are called that a playback file has no place for.
pub(super) fn setting(command: &Set) -> Option<&'static str> {
    Some(match command {
        Set::PtpJointParams(_)
        | Set::PtpCoordinateParams(_)
        | Set::PtpLParams(_)
        | Set::PtpCommonParams(_)
        | Set::CpParams(_)
        | Set::ArcParams(_)
        | Set::ArcCommonParams(_) => "speeds",
        Set::SetDeviceWithL(_) => "settings of the rail",
        Set::PtpJumpParams(_) | Set::PtpJump2Params(_) => "heights of jumps",
        _ => return None,
    })
}
