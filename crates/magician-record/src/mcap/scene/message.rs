//! Messages in the form of Foxglove's schemas: in metres, with all fields present.

use libm::{cos, sin};
use magician_motion::Shape;
use serde::Serialize;

use crate::mcap::message::Time;

/// Rounds to six decimals, which keeps the JSON short. The error of a position is below a
/// micrometre, and so is the error at the tip of a rotated link.
fn round_to_millionths(value: f64) -> f64 {
    // Adding 0 removes the sign of a negative zero.
    (value * 1e6).round() / 1e6 + 0.0
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Xyz {
    x: f64,
    y: f64,
    z: f64,
}

impl Xyz {
    pub(super) fn millimetres(at: [f64; 3]) -> Self {
        let [x, y, z] = at.map(|axis| round_to_millionths(axis / 1000.0));
        Self { x, y, z }
    }
}

/// A unit quaternion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Rotation {
    x: f64,
    y: f64,
    z: f64,
    w: f64,
}

impl Rotation {
    pub(super) const NONE: Self = Self {
        x: 0.0,
        y: 0.0,
        z: 0.0,
        w: 1.0,
    };

    pub(super) fn about(axis: [f64; 3], degrees: f64) -> Self {
        let half = degrees.to_radians() / 2.0;
        let [x, y, z] = axis.map(|component| round_to_millionths(component * sin(half)));
        let w = round_to_millionths(cos(half));
        Self { x, y, z, w }
    }

    /// Applies this rotation, then another one about fixed axes.
    pub(super) fn then(self, next: Self) -> Self {
        let (a, b) = (next, self);
        Self {
            x: a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
            y: a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
            z: a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
            w: a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
        }
    }

    pub(super) fn rotate(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let point = Self { x, y, z, w: 0.0 };
        let back = Self {
            x: -self.x,
            y: -self.y,
            z: -self.z,
            w: self.w,
        };
        let turned = back.then(point).then(self);
        [turned.x, turned.y, turned.z]
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Placed {
    pub(super) position: Xyz,
    pub(super) orientation: Rotation,
}

impl Placed {
    pub(super) const fn at(position: Xyz, orientation: Rotation) -> Self {
        Self {
            position,
            orientation,
        }
    }
}

#[derive(Serialize)]
pub(super) struct Transform {
    pub(super) timestamp: Time,
    pub(super) parent_frame_id: &'static str,
    pub(super) child_frame_id: &'static str,
    pub(super) translation: Xyz,
    pub(super) rotation: Rotation,
}

#[derive(Serialize)]
pub(super) struct SceneUpdate {
    pub(super) deletions: Vec<Deletion>,
    pub(super) entities: Vec<Entity>,
}

#[derive(Serialize)]
pub(super) struct Deletion {
    timestamp: Time,
    r#type: u8,
    id: &'static str,
}

impl Deletion {
    /// Deletes all earlier entities.
    pub(super) const fn all(timestamp: Time) -> Self {
        Self {
            timestamp,
            r#type: 1,
            id: "",
        }
    }
}

/// A lifetime of 0 means that an entity stays.
#[derive(Default, Serialize)]
struct Duration {
    sec: u32,
    nsec: u32,
}

/// Element of a list that is always empty.
#[derive(Serialize)]
enum Never {}

#[derive(Serialize)]
pub(super) struct Entity {
    timestamp: Time,
    frame_id: &'static str,
    id: String,
    lifetime: Duration,
    frame_locked: bool,
    metadata: [Never; 0],
    arrows: [Never; 0],
    cubes: Vec<Solid>,
    spheres: Vec<Solid>,
    cylinders: Vec<Cylinder>,
    lines: Vec<Line>,
    triangles: [Never; 0],
    texts: [Never; 0],
    models: [Never; 0],
}

impl Entity {
    fn new(timestamp: Time, frame_id: &'static str, id: String) -> Self {
        Self {
            timestamp,
            frame_id,
            id,
            lifetime: Duration::default(),
            frame_locked: true,
            metadata: [],
            arrows: [],
            cubes: Vec::new(),
            spheres: Vec::new(),
            cylinders: Vec::new(),
            lines: Vec::new(),
            triangles: [],
            texts: [],
            models: [],
        }
    }

    /// Entity of a link in its frame.
    pub(super) fn solid(
        timestamp: Time,
        frame: &'static str,
        (shape, solid): (Shape, Solid),
    ) -> Self {
        let mut entity = Self::new(timestamp, frame, format!("arm/{frame}"));
        match shape {
            Shape::Box => entity.cubes.push(solid),
            Shape::Sphere => entity.spheres.push(solid),
            Shape::Cylinder => entity.cylinders.push(Cylinder {
                solid,
                bottom_scale: 1,
                top_scale: 1,
            }),
        }
        entity
    }

    pub(super) fn lines(
        timestamp: Time,
        frame: &'static str,
        id: String,
        lines: Vec<Line>,
    ) -> Self {
        Self {
            lines,
            ..Self::new(timestamp, frame, id)
        }
    }
}

#[derive(Serialize)]
pub(super) struct Solid {
    pose: Placed,
    size: Xyz,
    color: Color,
}

impl Solid {
    pub(super) fn new(pose: Placed, size: [f64; 3], color: &str) -> Self {
        Self {
            pose,
            size: Xyz::millimetres(size),
            color: Color::hex(color),
        }
    }
}

#[derive(Serialize)]
struct Cylinder {
    #[serde(flatten)]
    solid: Solid,
    bottom_scale: u8,
    top_scale: u8,
}

#[derive(Clone, Copy, Serialize)]
pub(super) struct Color {
    r: f64,
    g: f64,
    b: f64,
    a: f64,
}

impl Color {
    /// Parses `#rrggbb`; black if invalid.
    pub(super) fn hex(text: &str) -> Self {
        let number = u32::from_str_radix(text.trim_start_matches('#'), 16).unwrap_or(0);
        let [_, r, g, b] = number.to_be_bytes();
        let channel = |value: u8| (f64::from(value) / 2.55).round() / 100.0;
        Self {
            r: channel(r),
            g: channel(g),
            b: channel(b),
            a: 1.0,
        }
    }
}

#[derive(Serialize)]
pub(super) struct Line {
    r#type: u8,
    pose: Placed,
    thickness: f64,
    scale_invariant: bool,
    points: Vec<Xyz>,
    color: Color,
    colors: [Never; 0],
    indices: Vec<u32>,
}

impl Line {
    /// Creates a list of separate lines; each pair of indices gives the ends of a line.
    pub(super) fn list(color: Color, points: Vec<Xyz>, indices: Vec<u32>) -> Self {
        Self {
            r#type: 2,
            pose: Placed::at(Xyz::millimetres([0.0; 3]), Rotation::NONE),
            thickness: 2.0,
            scale_invariant: true,
            points,
            color,
            colors: [],
            indices,
        }
    }
}
