//! The arm in three dimensions: coordinate frames and shapes of its links, and its strokes.

use std::io::{self, Write};

use magician_motion::{ArmModel, JointAngles, Link, LinkJoint, Shape, ToolBias};

use super::file::{File, Topic};
use super::{Micros, SECOND};

mod message;
mod strokes;

use message::{Deletion, Entity, Placed, Rotation, SceneUpdate, Solid, Transform, Xyz};
pub(super) use strokes::Ink;
use strokes::Strokes;

/// Samples between two writes of moved frames. A viewer interpolates.
pub(super) const SAMPLES_PER_TRANSFORM: Micros = 10;
/// Shortest interval at which the whole scene is written again, for viewers that start in the
/// middle.
const SCENE_INTERVAL: Micros = 5 * SECOND;
/// Bytes per sample that writing the whole scene again may take. A large drawing is written less
/// often than every [`SCENE_INTERVAL`].
const SCENE_BYTES_PER_SAMPLE: u64 = 24;
/// Most points of strokes that are written again; larger drawings are written once.
const MAX_REPEATED_POINTS: usize = 100_000;

/// Frame of the arm's coordinates, in which `/pose` is.
const BASE: &str = "base";
/// Start of the rail, which does not move.
const RAIL: &str = "rail";
/// Frame of the last link, with its origin at the tip.
const TIP: &str = "tip";

/// State of the arm, as the scene needs it.
pub(super) struct ArmConfiguration {
    pub(super) joints: JointAngles,
    pub(super) tool: ToolBias,
    /// Position on the rail, mm; `None` without a rail.
    pub(super) rail: Option<f64>,
}

/// The scene: what was written, and what is pending.
pub(super) struct Scene {
    model: ArmModel,
    /// Sample interval.
    period: Micros,
    tool: ToolBias,
    rail: Option<f64>,
    /// The carriage on its rail, then the links, as last written.
    placed: [Option<Placed>; 8],
    strokes: Strokes,
    /// Number of entities `strokes N` written since the entity `strokes` with all strokes.
    pieces: u32,
    due: Micros,
}

impl Scene {
    pub(super) fn of(model: ArmModel, period: Micros) -> Self {
        Self {
            model,
            period,
            tool: ToolBias::default(),
            rail: None,
            placed: [None; 8],
            strokes: Strokes::default(),
            pieces: 0,
            due: 0,
        }
    }

    /// Adds a drawn line. Its ends are in mm in the frame of the rail, or of the base without a
    /// rail.
    pub(super) fn draw(&mut self, ink: Ink, from: [f64; 3], to: [f64; 3]) {
        self.strokes.add(ink, from, to, MAX_REPEATED_POINTS);
    }

    /// Removes all strokes.
    #[cfg(feature = "sim")]
    pub(super) fn clear(&mut self) {
        self.strokes = Strokes::default();
        self.due = 0;
    }

    /// Writes the frames that have moved.
    pub(super) fn follow<W: Write>(
        &mut self,
        file: &mut File<W>,
        now: Micros,
        configuration: &ArmConfiguration,
    ) -> io::Result<()> {
        let on_rail = configuration.rail.is_some();
        if (self.tool, self.rail.is_some()) != (configuration.tool, on_rail) {
            // The links have other lengths, so their shapes must be written again.
            self.due = 0;
        }
        (self.tool, self.rail) = (configuration.tool, configuration.rail);
        let links = self.model.links(configuration.tool, on_rail);
        for (at, link) in links.iter().enumerate() {
            let Some((parent, placed)) = frame_of(link, &links[0], configuration) else {
                continue;
            };
            if self.placed[at] != Some(placed) {
                self.placed[at] = Some(placed);
                file.write(Topic::Transforms, now, |timestamp| Transform {
                    timestamp,
                    parent_frame_id: parent,
                    child_frame_id: name(link),
                    translation: placed.position,
                    rotation: placed.orientation,
                })?;
            }
        }
        Ok(())
    }

    /// Writes the new strokes, or the whole scene if it is due.
    pub(super) fn show<W: Write>(&mut self, file: &mut File<W>, now: Micros) -> io::Result<()> {
        let frame = if self.rail.is_some() { RAIL } else { BASE };
        let whole = now >= self.due;
        let repeats = whole && self.strokes.are_kept();
        if repeats {
            self.pieces = 0;
        } else if !whole && !self.strokes.has_new() {
            return Ok(());
        }
        let (lines, id) = if repeats {
            (self.strokes.all(), "strokes".to_owned())
        } else {
            self.pieces += u32::from(self.strokes.has_new());
            (self.strokes.new_ones(), format!("strokes {}", self.pieces))
        };
        let links = self.model.links(self.tool, self.rail.is_some());
        file.write(Topic::Scene, now, |timestamp| {
            let mut entities = Vec::new();
            if whole {
                let solid = |link| Entity::solid(timestamp, name(link), solid(link));
                entities.extend(links.iter().map(solid));
            }
            if !lines.is_empty() {
                entities.push(Entity::lines(timestamp, frame, id, lines));
            }
            let deletions = repeats.then(|| Deletion::all(timestamp));
            SceneUpdate {
                deletions: deletions.into_iter().collect(),
                entities,
            }
        })?;
        self.strokes.shown();
        if whole {
            let bytes = file.bytes() as u64;
            self.due = now
                .saturating_add(SCENE_INTERVAL.max(bytes * self.period / SCENE_BYTES_PER_SAMPLE));
        }
        Ok(())
    }
}

/// Name of a link's frame: the base for the first link, the tip for the last one.
fn name(link: &Link) -> &'static str {
    match (link.parent, link.name) {
        (None, _) => BASE,
        (_, "tool") => TIP,
        (_, name) => name,
    }
}

/// Position of a link's frame, and its parent frame; `None` for the first link without a rail,
/// which does not move.
fn frame_of(
    link: &Link,
    first: &Link,
    configuration: &ArmConfiguration,
) -> Option<(&'static str, Placed)> {
    let Some(parent) = link.parent else {
        let along = link
            .axis
            .map(|axis| axis * configuration.rail.unwrap_or(0.0));
        let placed = Placed::at(Xyz::millimetres(along), Rotation::NONE);
        return configuration.rail.map(|_| (RAIL, placed));
    };
    // In a recording the first link's frame is the arm's own, so its offset is added to that of its
    // children.
    let carried = parent == first.name;
    let at = [0, 1, 2].map(|axis| link.at[axis] + if carried { first.at[axis] } else { 0.0 });
    let angle = { link.joint }.map_or(0.0, |joint: LinkJoint| joint.angle(&configuration.joints));
    let turned = Rotation::about(link.axis, angle);
    let parent = if carried { BASE } else { parent };
    Some((parent, Placed::at(Xyz::millimetres(at), turned)))
}

/// Shape of a link in its frame.
fn solid(link: &Link) -> (Shape, Solid) {
    let [x, y, z] = link.turn;
    let turned = Rotation::about([1.0, 0.0, 0.0], x)
        .then(Rotation::about([0.0, 1.0, 0.0], y))
        .then(Rotation::about([0.0, 0.0, 1.0], z));
    let middle = match link.shape {
        Shape::Sphere => [0.0; 3],
        Shape::Box | Shape::Cylinder => turned.rotate([0.0, 0.0, link.size[2] / 2.0]),
    };
    // In a recording the first link's frame is the arm's own, so the shape has the link's offset.
    let from = if link.parent.is_none() {
        link.at
    } else {
        [0.0; 3]
    };
    let middle = [0, 1, 2].map(|axis| middle[axis] + from[axis]);
    let placed = Placed::at(Xyz::millimetres(middle), turned);
    (link.shape, Solid::new(placed, link.size, link.color))
}
