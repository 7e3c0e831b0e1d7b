//! The surroundings of the arm, validated.

use magician_motion::ToolBias;
use magician_protocol::Port;
use serde::Deserialize;

use super::Color;
use crate::world::{Footprint, ObjectPose, rotate};

/// Largest distance of anything from the base, mm. A choice: several times the reach of the arm.
pub(super) const MAX_DISTANCE: f64 = 2000.0;

/// State of the arm at power-up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct Arm {
    /// True angle of the base minus the angle that the controller assumes, deg (model section 11:
    /// the base has no absolute sensor).
    pub base_angle: f64,
    /// True if it is homed: the base then stands where the controller assumes.
    pub homed: bool,
}

/// The kind of tool on the arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum ToolKind {
    /// No tool: the wrist touches.
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

/// The mounted tool.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Tool {
    /// Kind of the tool, which gives its bias.
    pub kind: ToolKind,
    /// Distance by which the tool gives way before J2 and J3 stall, mm.
    pub give: f64,
    /// Opening of the gripper, mm.
    pub opening: f64,
}

impl Default for Tool {
    /// The suction cup, as at power-up.
    fn default() -> Self {
        Self::new(ToolKind::Suction)
    }
}

impl Tool {
    /// Opening of the gripper, mm (27.5 in the vendor's catalogue).
    pub const OPENING: f64 = 27.5;

    /// Returns a tool with the dimensions of the real one.
    #[must_use]
    pub const fn new(kind: ToolKind) -> Self {
        Self {
            kind,
            give: kind.give(),
            opening: Self::OPENING,
        }
    }

    /// Offset of its tip from the wrist.
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
    /// Distance that a tool gives way before the motors stall, mm. Guesses (G): the cup has bellows
    /// and the pen sits in a spring; the others are stiff, and what gives way is the arm.
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
    /// Height, mm; a pen writes at this height.
    pub height: f64,
    /// Extent in x, mm.
    #[serde(default = "Table::everywhere")]
    pub x: [f64; 2],
    /// Extent in y, mm.
    #[serde(default = "Table::everywhere")]
    pub y: [f64; 2],
}

impl Table {
    const fn everywhere() -> [f64; 2] {
        [-MAX_DISTANCE, MAX_DISTANCE]
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

/// A conveyor driven by a stepper output of the arm.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Conveyor {
    /// Middle of the edge where the belt starts, mm.
    pub start: [f64; 2],
    /// Heading of the belt for positive pulses, deg.
    pub direction: f64,
    /// Length, mm.
    pub length: f64,
    /// Width, mm.
    pub width: f64,
    /// Height of the belt, mm.
    pub height: f64,
    /// Stepper output that drives it, 0 or 1.
    pub stepper: u8,
    /// Diameter of the roller, mm.
    #[serde(default = "Conveyor::roller_diameter")]
    pub roller_diameter: f64,
    /// Pulses per turn of the roller.
    #[serde(default = "Conveyor::pulses_per_turn")]
    pub pulses_per_turn: f64,
}

impl Conveyor {
    // 34 mm and 16,000 pulses: found by two third parties. The vendor's demonstration has other
    // values, which do not fit the belt (model section 13).
    const fn roller_diameter() -> f64 {
        34.0
    }

    const fn pulses_per_turn() -> f64 {
        16_000.0
    }

    /// Travel of the belt per pulse, mm.
    #[must_use]
    pub fn mm_per_pulse(&self) -> f64 {
        std::f64::consts::PI * self.roller_diameter / self.pulses_per_turn
    }

    /// Frame of the belt at displacement 0: X along the belt, from its start.
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

/// Support of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum On {
    /// The table.
    Table,
    /// The conveyor's belt.
    Belt,
    /// Another object, by its index in the scenario.
    Object(u16),
    /// A support that the scenario does not contain: a shelf.
    Shelf,
}

/// A box that can be picked.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Object {
    /// Name of the object.
    pub name: String,
    /// Length, width and height, mm.
    pub size: [f64; 3],
    /// Colour of the object.
    pub color: Color,
    /// Position and yaw of the middle of its underside.
    pub place: ObjectPose,
    /// Support.
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

/// Kind of a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum SensorKind {
    /// Colour of the object in front of it.
    Color,
    /// Presence of an object.
    Infrared,
}

/// A sensor at a connector.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Sensor {
    /// Kind of the sensor.
    pub kind: SensorKind,
    /// Connector.
    pub port: Port,
    /// Line of sight: the sensor sees the first thing on it.
    pub beam: Beam,
}

/// Straight line of sight of a sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Position of the sensor, mm.
    pub from: [f64; 3],
    /// End of its range, mm.
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
