//! The arm in three dimensions: where its links are, what they look like, and what it drew.

use std::io::{self, Write};

use magician_motion::{ArmModel, JointAngles, Link, LinkJoint, Shape, ToolBias};

use super::file::{File, Topic};
use super::{Micros, SECOND};

mod message;
mod strokes;

use message::{Deletion, Entity, Placed, Rotation, SceneUpdate, Solid, Transform, Xyz};
pub(super) use strokes::Ink;
use strokes::Strokes;

/// Frames that moved are written with each so manieth sample: a viewer goes from one to the next.
pub(super) const EVERY: Micros = 10;
/// The whole scene is written again after so long, for those who begin to look in the middle ..
const AGAIN: Micros = 5 * SECOND;
/// .. or later: it takes no more than so many bytes for each sample, however much was drawn.
const SHARE: u64 = 24;
/// So many corners of strokes are written again; more than that are written once.
const MOST: usize = 100_000;

/// The frame of the arm's own coordinates, in which `/pose` is.
const BASE: &str = "base";
/// The beginning of the rail, which stands still.
const RAIL: &str = "rail";
/// The frame of the last link, whose origin is the tip.
const TIP: &str = "tip";

/// How the arm stands.
pub(super) struct Stance {
    pub(super) joints: JointAngles,
    pub(super) tool: ToolBias,
    /// Where on its rail, mm, if it has one.
    pub(super) rail: Option<f64>,
}

/// What of the scene was written, and what is to be.
pub(super) struct Scene {
    model: ArmModel,
    /// Between two samples.
    period: Micros,
    tool: ToolBias,
    rail: Option<f64>,
    /// The carriage on its rail, then the links.
    placed: [Option<Placed>; 8],
    strokes: Strokes,
    /// Entities of strokes beside the one of all.
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

    /// Adds a line that was drawn, its ends in mm in the frame in which the rail, or an arm without one, stands still.
    pub(super) fn draw(&mut self, ink: Ink, from: [f64; 3], to: [f64; 3]) {
        self.strokes.add(ink, from, to, MOST);
    }

    /// What was drawn is gone.
    #[cfg(feature = "sim")]
    pub(super) fn clear(&mut self) {
        self.strokes = Strokes::default();
        self.due = 0;
    }

    /// Writes the frames that are not where they were.
    pub(super) fn follow<W: Write>(
        &mut self,
        file: &mut File<W>,
        now: Micros,
        stance: &Stance,
    ) -> io::Result<()> {
        let on_rail = stance.rail.is_some();
        if (self.tool, self.rail.is_some()) != (stance.tool, on_rail) {
            // The links have other lengths.
            self.due = 0;
        }
        (self.tool, self.rail) = (stance.tool, stance.rail);
        let links = self.model.links(stance.tool, on_rail);
        for (at, link) in links.iter().enumerate() {
            let Some((parent, placed)) = frame_of(link, &links[0], stance) else {
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

    /// Writes what was drawn since, or all that is to be seen.
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
            self.due = now.saturating_add(AGAIN.max(bytes * self.period / SHARE));
        }
        Ok(())
    }
}

/// The frame of a link; the first has that of the arm's coordinates, and the last the tip.
fn name(link: &Link) -> &'static str {
    match (link.parent, link.name) {
        (None, _) => BASE,
        (_, "tool") => TIP,
        (_, name) => name,
    }
}

/// Where the frame of a link is, and in which; none for one that carries all others and stands still.
fn frame_of(link: &Link, first: &Link, stance: &Stance) -> Option<(&'static str, Placed)> {
    let Some(parent) = link.parent else {
        let along = link.axis.map(|axis| axis * stance.rail.unwrap_or(0.0));
        let placed = Placed::at(Xyz::millimetres(along), Rotation::NONE);
        return stance.rail.map(|_| (RAIL, placed));
    };
    // The first link's frame is that of the arm's coordinates here.
    let carried = parent == first.name;
    let at = [0, 1, 2].map(|axis| link.at[axis] + if carried { first.at[axis] } else { 0.0 });
    let angle = { link.joint }.map_or(0.0, |joint: LinkJoint| joint.angle(&stance.joints));
    let turned = Rotation::about(link.axis, angle);
    let parent = if carried { BASE } else { parent };
    Some((parent, Placed::at(Xyz::millimetres(at), turned)))
}

/// What a link looks like in its frame.
fn solid(link: &Link) -> (Shape, Solid) {
    let [x, y, z] = link.turn;
    let turned = Rotation::about([1.0, 0.0, 0.0], x)
        .then(Rotation::about([0.0, 1.0, 0.0], y))
        .then(Rotation::about([0.0, 0.0, 1.0], z));
    let middle = match link.shape {
        Shape::Sphere => [0.0; 3],
        Shape::Box | Shape::Cylinder => turned.turn([0.0, 0.0, link.size[2] / 2.0]),
    };
    // The frame of the first link is that of the arm's coordinates here.
    let from = if link.parent.is_none() {
        link.at
    } else {
        [0.0; 3]
    };
    let middle = [0, 1, 2].map(|axis| middle[axis] + from[axis]);
    let placed = Placed::at(Xyz::millimetres(middle), turned);
    (link.shape, Solid::new(placed, link.size, link.color))
}
