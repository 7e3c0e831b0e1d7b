//! What stands around the arm, checked.

use magician_motion::ToolBias;
use magician_protocol::Port;
use serde::Deserialize;

use super::Color;
use crate::world::{Footprint, ObjectPose, rotate};

/// Farther than this from the base nothing can be placed, mm.
pub(super) const FAR: f64 = 2000.0;

/// How the arm stands at power-up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct Arm {
    /// Where the base really stands beyond the angle that the controller takes it for, deg (model
    /// section 11: the base has no absolute sensor).
    pub base_angle: f64,
    /// Whether it has been homed: the base then stands where the controller believes.
    pub homed: bool,
}

/// The kind of tool on the arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum ToolKind {
    /// None: what touches is the wrist.
    None,
    /// The suction cup.
    Suction,
    /// The gripper.
    Gripper,
    /// The pen.
    Pen,
    /// The laser.
    Laser,
}

/// The tool that is really on the arm.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Tool {
    /// Its kind, which says where its tip is.
    pub kind: ToolKind,
    /// How far it gives way before J2 and J3 stall, mm.
    pub give: f64,
    /// How far the gripper opens, mm.
    pub opening: f64,
}

impl Default for Tool {
    /// The suction cup, as at power-up.
    fn default() -> Self {
        Self::new(ToolKind::Suction)
    }
}

impl Tool {
    /// How far the gripper opens, mm (T: 27.5 in the vendor's catalogue).
    pub const OPENING: f64 = 27.5;

    /// A tool with the measures of the real one.
    #[must_use]
    pub const fn new(kind: ToolKind) -> Self {
        Self {
            kind,
            give: kind.give(),
            opening: Self::OPENING,
        }
    }

    /// Where its tip is, seen from the wrist.
    #[must_use]
    pub const fn bias(&self) -> ToolBias {
        match self.kind {
            ToolKind::None => ToolBias::NONE,
            ToolKind::Suction => ToolBias::SUCTION,
            ToolKind::Gripper => ToolBias::GRIPPER,
            ToolKind::Pen => ToolBias::PEN,
            ToolKind::Laser => ToolBias::LASER,
        }
    }
}

impl ToolKind {
    /// How far a tool gives way before the motors stall, mm. All of them guesses (G): the cup has
    /// bellows, the pen sits in a spring, the others are stiff and what gives is the arm.
    const fn give(self) -> f64 {
        match self {
            Self::Suction => 5.0,
            Self::Pen => 3.0,
            Self::Gripper | Self::Laser | Self::None => 1.0,
        }
    }
}

/// A level table.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Table {
    /// Its height, mm; a pen writes here.
    pub height: f64,
    /// From where to where it reaches forward, mm.
    #[serde(default = "Table::everywhere")]
    pub x: [f64; 2],
    /// From where to where it reaches to the left, mm.
    #[serde(default = "Table::everywhere")]
    pub y: [f64; 2],
}

impl Table {
    const fn everywhere() -> [f64; 2] {
        [-FAR, FAR]
    }

    pub(crate) fn footprint(&self) -> Footprint {
        let ([x0, x1], [y0, y1]) = (self.x, self.y);
        Footprint {
            place: ObjectPose {
                x: f64::midpoint(x0, x1),
                y: f64::midpoint(y0, y1),
                z: self.height,
                yaw: 0.0,
            },
            half: [(x1 - x0) / 2.0, (y1 - y0) / 2.0],
        }
    }
}

/// A conveyor that a stepper output of the arm drives.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Conveyor {
    /// The middle of the edge where the belt starts, mm.
    pub start: [f64; 2],
    /// Where it runs for positive pulses, deg.
    pub direction: f64,
    /// Its length, mm.
    pub length: f64,
    /// Its width, mm.
    pub width: f64,
    /// The height of the belt, mm.
    pub height: f64,
    /// The stepper output that drives it, 0 or 1.
    pub stepper: u8,
    /// Of its roller, mm.
    #[serde(default = "Conveyor::roller_diameter")]
    pub roller_diameter: f64,
    /// Pulses for one turn of the roller.
    #[serde(default = "Conveyor::pulses_per_turn")]
    pub pulses_per_turn: f64,
}

impl Conveyor {
    const fn roller_diameter() -> f64 {
        34.0
    }

    const fn pulses_per_turn() -> f64 {
        16_000.0
    }

    /// Belt travel of one pulse, mm.
    #[must_use]
    pub fn mm_per_pulse(&self) -> f64 {
        std::f64::consts::PI * self.roller_diameter / self.pulses_per_turn
    }

    /// The frame of the belt at displacement 0: X along it, from its start.
    pub(crate) fn frame(&self) -> ObjectPose {
        let [x, y] = self.start;
        ObjectPose {
            x,
            y,
            z: self.height,
            yaw: self.direction,
        }
    }

    pub(crate) fn footprint(&self) -> Footprint {
        let half = [self.length / 2.0, self.width / 2.0];
        let middle = ObjectPose {
            x: half[0],
            ..ObjectPose::default()
        };
        Footprint {
            place: self.frame().then(&middle),
            half,
        }
    }
}

/// What an object rests on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum On {
    /// The table.
    Table,
    /// The conveyor's belt.
    Belt,
    /// Another object, by its place in the scenario.
    Object(u16),
    /// Something that the scenario does not have: a shelf.
    Shelf,
}

/// A box that can be picked.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Object {
    /// Its name.
    pub name: String,
    /// Length, width and height, mm.
    pub size: [f64; 3],
    /// Its colour.
    pub color: Color,
    /// Where it stands.
    pub place: ObjectPose,
    /// What it rests on.
    pub on: On,
}

impl Object {
    pub(crate) fn footprint(&self) -> Footprint {
        footprint(&self.size, self.place)
    }
}

pub(crate) fn footprint(size: &[f64; 3], place: ObjectPose) -> Footprint {
    let [length, width, _] = size;
    Footprint {
        place,
        half: [length / 2.0, width / 2.0],
    }
}

/// What a sensor tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum SensorKind {
    /// The colour of what is before it.
    Color,
    /// Whether object detected.
    Infrared,
}

/// A sensor at a connector.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Sensor {
    /// What it tells.
    pub kind: SensorKind,
    /// The connector.
    pub port: Port,
    /// Where it looks: it sees what this line meets.
    pub beam: Beam,
}

/// A straight line that a sensor looks along.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Where the sensor is, mm.
    pub from: [f64; 3],
    /// How far it sees, mm.
    pub to: [f64; 3],
}

impl Beam {
    pub(super) fn level(from: [f64; 3], heading: f64, range: f64) -> Self {
        let [x, y] = rotate([range, 0.0], heading);
        let [from_x, from_y, z] = from;
        Self {
            from,
            to: [from_x + x, from_y + y, z],
        }
    }

    pub(super) fn upright(from: [f64; 3], range: f64) -> Self {
        let [x, y, z] = from;
        Self {
            from,
            to: [x, y, z + range],
        }
    }
}
