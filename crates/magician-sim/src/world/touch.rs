//! How deep the tool is in bodies, and what it can take.

use super::scene::{Frames, Scene};
use super::solid::Solid;
use super::{Body, Footprint, ObjectPose, ToolState};
use crate::scenario::{Scenario, Tool, ToolKind};

/// Less than this is a rounding error and no touch, mm.
const TOUCH: f64 = 1e-3;
/// A tool that is deeper than this at the instant at which it comes to a body has come from the
/// side, mm.
const FROM_THE_SIDE: f64 = 0.1;
/// A tool that stalled stalls again when it is deeper by this, mm.
const DEEPER: f64 = 0.01;
/// How far below its palm the gripper's fingers reach, mm (G).
pub(super) const FINGERS: f64 = 20.0;
/// The least that the fingers have to reach down beside an object to hold it, mm (G).
const BITE: f64 = 2.0;
/// How far above an object the suction cup may end and still take it, mm (G).
const SUCK: f64 = 1.0;

/// How the tool is at a body; nothing is said of a body that it is clear of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Contact {
    /// It touches it, no deeper than it gives way.
    Touch,
    /// It came from the side against an object, which gives way.
    Knock,
    /// It presses harder than it gives way.
    Stall,
}

/// The tool in the world, at an instant.
pub(super) struct Reach<'a> {
    pub(super) scenario: &'a Scenario,
    pub(super) scene: &'a Scene,
    pub(super) tool: ToolState,
    pub(super) frames: Frames,
}

impl Reach<'_> {
    fn tool(&self) -> Tool {
        self.scenario.tool()
    }

    /// The points of the tool that touch bodies, in the base frame.
    fn points(&self) -> [Option<ObjectPose>; 3] {
        let tip = &self.frames.tool;
        let at = |y: f64, z: f64| {
            Some(tip.then(&ObjectPose {
                y,
                z,
                ..ObjectPose::default()
            }))
        };
        match self.tool().kind {
            ToolKind::Gripper if !self.tool.closed => {
                let half = self.tool().opening / 2.0;
                [at(half, 0.0), at(-half, 0.0), at(0.0, FINGERS)]
            }
            _ => [at(0.0, 0.0), None, None],
        }
    }

    /// The upper side of a body that can be touched.
    pub(super) fn top(&self, body: Body) -> Option<Footprint> {
        match body {
            Body::Table => Some(self.scenario.table()?.footprint()),
            Body::Belt => Some(self.scenario.conveyor()?.footprint()),
            Body::Object(object) if self.scene.is_carried(object) => None,
            Body::Object(object) => Some(self.solid(object).top()),
        }
    }

    /// How far tool or held object are below the upper side of a body that they are over, mm.
    pub(super) fn depth(&self, body: Body) -> Option<f64> {
        let top = self.top(body)?;
        let of_points = self.points().into_iter().flatten().filter_map(|point| {
            let depth = top.place.z - point.z;
            (depth > TOUCH && top.contains(point.xy())).then_some(depth)
        });
        let of_held = self.scene.held().and_then(|object| {
            let held = self.solid(object);
            let depth = top.place.z - held.place.z;
            (depth > TOUCH && top.overlaps(&held.footprint())).then_some(depth)
        });
        of_points.chain(of_held).reduce(f64::max)
    }

    /// The lowest that anything of the tool or the held object is, mm.
    pub(super) fn lowest(&self) -> f64 {
        let held = self.scene.held().map(|object| self.solid(object).place.z);
        held.map_or(self.frames.tool.z, |z| z.min(self.frames.tool.z))
    }

    fn solid(&self, object: u16) -> Solid {
        self.scene.solid(object, self.scenario, &self.frames)
    }

    /// How far the tool gives way, mm.
    pub(super) fn give(&self) -> f64 {
        self.tool().give
    }

    /// How the tool is at a body, when it was so the instant before; deeper than `limit` it stalls.
    pub(super) fn contact(
        &self,
        body: Body,
        before: Option<Contact>,
        limit: f64,
    ) -> Option<Contact> {
        let depth = self.depth(body)?;
        let yields = matches!(body, Body::Object(_));
        Some(match before {
            Some(Contact::Knock) => Contact::Knock,
            None if depth > FROM_THE_SIDE && yields => Contact::Knock,
            // The side of the table or of the belt does not give way.
            None if depth > FROM_THE_SIDE => Contact::Stall,
            _ if depth > limit => Contact::Stall,
            _ => Contact::Touch,
        })
    }

    /// How the tool is at a body when a path begins, and how deep it may go there without a stall.
    /// One that is pressed in already, because it stalled there, stalls again only if it goes
    /// deeper.
    pub(super) fn at_start(&self, body: Body, before: Option<Contact>) -> (Option<Contact>, f64) {
        let give = self.give();
        let depth = self.depth(body);
        let contact = depth.map(|depth| match before {
            Some(Contact::Knock) => Contact::Knock,
            None if depth > give => Contact::Stall,
            _ => Contact::Touch,
        });
        let pressed = depth.filter(|depth| *depth > give);
        (contact, pressed.map_or(give, |depth| depth + DEEPER))
    }

    /// The object that the tool takes if it closes or sucks now: of several, the highest.
    pub(super) fn within_grasp(&self) -> Option<u16> {
        let objects = self
            .scene
            .ids()
            .filter(|object| !self.scene.is_carried(*object));
        objects
            .map(|object| (object, self.solid(object)))
            .filter(|(_, solid)| self.can_take(solid))
            .max_by(|(_, one), (_, other)| one.height().total_cmp(&other.height()))
            .map(|(object, _)| object)
    }

    fn can_take(&self, solid: &Solid) -> bool {
        let (tip, footprint) = (&self.frames.tool, solid.footprint());
        let above = tip.z - solid.height();
        if !footprint.contains(tip.xy()) {
            return false;
        }
        match self.tool().kind {
            ToolKind::Suction => (-self.tool().give - TOUCH..=SUCK).contains(&above),
            ToolKind::Gripper => {
                // The fingers close along the tool's Y.
                let [_, across] = tip.local(solid.place.xy());
                let reach = footprint.reach(tip.yaw + 90.0);
                let fits = across.abs() + reach <= self.tool().opening / 2.0;
                fits && (-FINGERS - self.tool().give..=-BITE).contains(&above)
            }
            ToolKind::None | ToolKind::Pen | ToolKind::Laser => false,
        }
    }
}
