//! Contact of the tool with bodies, and the objects within its grasp.
//!
//! Bodies are boxes, and the tool is a few points: one at the tip, three for an open gripper, plus
//! the underside of a held object. Depth is measured downwards from the upper side of a body. A
//! tool that appears deep inside a body must have come from its side.

use super::scene::{Frames, Scene};
use super::solid::Solid;
use super::{Body, Footprint, ObjectPose, ToolState};
use crate::scenario::{Scenario, Tool, ToolKind};

/// Smallest depth that counts as a touch, mm; it absorbs rounding.
const TOUCH: f64 = 1e-3;
/// Depth at first contact above which the tool must have come from the side, mm. In a motion from
/// above, bisection between two samples finds the contact at a depth far below this.
const FROM_THE_SIDE: f64 = 0.1;
/// Additional depth at which a stalled tool stalls again, mm.
const DEEPER: f64 = 0.01;
/// Length of the gripper's fingers below its palm, mm (G).
pub(super) const FINGERS: f64 = 20.0;
/// Least overlap of the fingers with an object to hold it, mm (G).
const MIN_FINGER_OVERLAP: f64 = 2.0;
/// Largest gap between suction cup and object at which the cup still takes the object, mm (G).
const MAX_SUCTION_GAP: f64 = 1.0;

/// Kind of contact of the tool with a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Contact {
    /// Touching; the depth is within the distance that the tool gives way.
    Touch,
    /// Ran into an object from the side; the object yields.
    Knock,
    /// Pressed in deeper than the tool gives way.
    Stall,
}

/// The tool in the world at an instant.
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

    /// Points of the tool that can touch, in the base frame.
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
            // All other tools are a single point.
            _ => [at(0.0, 0.0), None, None],
        }
    }

    /// Upper side of a body; `None` if it cannot be touched.
    pub(super) fn top(&self, body: Body) -> Option<Footprint> {
        match body {
            Body::Table => Some(self.scenario.table()?.footprint()),
            Body::Belt => Some(self.scenario.conveyor()?.footprint()),
            // A carried object moves with the tool.
            Body::Object(object) if self.scene.is_carried(object) => None,
            Body::Object(object) => Some(self.solid(object).top()),
        }
    }

    /// Greatest depth of tool or held object below the upper side of a body under it, mm. `None` if
    /// clear.
    pub(super) fn depth(&self, body: Body) -> Option<f64> {
        let top = self.top(body)?;
        let of_points = self.points().into_iter().flatten().filter_map(|point| {
            let depth = top.place.z - point.z;
            (depth > TOUCH && top.contains(point.xy())).then_some(depth)
        });
        let of_held = self.scene.held().and_then(|object| {
            let held = self.solid(object);
            // The underside of the held object is a face, not a point: any overlap counts.
            let depth = top.place.z - held.place.z;
            (depth > TOUCH && top.overlaps(&held.footprint())).then_some(depth)
        });
        of_points.chain(of_held).reduce(f64::max)
    }

    /// Lowest point of the tool or the held object, mm.
    pub(super) fn lowest(&self) -> f64 {
        let held = self.scene.held().map(|object| self.solid(object).place.z);
        held.map_or(self.frames.tool.z, |z| z.min(self.frames.tool.z))
    }

    fn solid(&self, object: u16) -> Solid {
        self.scene.solid(object, self.scenario, &self.frames)
    }

    /// Distance that the tool gives way, mm.
    pub(super) fn give(&self) -> f64 {
        self.tool().give
    }

    /// Contact with a body, given the contact an instant before. Deeper than `limit` the tool
    /// stalls.
    pub(super) fn contact(
        &self,
        body: Body,
        before: Option<Contact>,
        limit: f64,
    ) -> Option<Contact> {
        let depth = self.depth(body)?;
        let yields = matches!(body, Body::Object(_));
        Some(match before {
            // A knocked object yields until the tool is clear again.
            Some(Contact::Knock) => Contact::Knock,
            None if depth > FROM_THE_SIDE && yields => Contact::Knock,
            // The sides of table and belt do not yield.
            None if depth > FROM_THE_SIDE => Contact::Stall,
            _ if depth > limit => Contact::Stall,
            _ => Contact::Touch,
        })
    }

    /// Contact with a body at the start of a path, and the largest depth without a stall, mm.
    ///
    /// A tool still pressed in after a stall stalls again only if it goes deeper.
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

    /// Object that the tool takes if it closes or sucks now; of several, the highest.
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
            ToolKind::Suction => (-self.tool().give - TOUCH..=MAX_SUCTION_GAP).contains(&above),
            ToolKind::Gripper => {
                // The fingers close along Y of the tool.
                let [_, across] = tip.local(solid.place.xy());
                let reach = footprint.reach(tip.yaw + 90.0);
                let fits = across.abs() + reach <= self.tool().opening / 2.0;
                fits && (-FINGERS - self.tool().give..=-MIN_FINGER_OVERLAP).contains(&above)
            }
            ToolKind::None | ToolKind::Pen | ToolKind::Laser => false,
        }
    }
}
