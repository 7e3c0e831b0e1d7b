//! Positions of the objects. Each object rests on a support, and supports the objects on top of it.
//!
//! An object stores its position in the frame of its support, so a moving belt or tool moves a
//! whole stack without an update of its objects.

use super::solid::Solid;
use super::{Footprint, ObjectPose};
use crate::scenario::{Object, On, Scenario, footprint};

/// Height of the floor, mm: objects that fall off everything end up there.
pub(super) const FLOOR: f64 = -1000.0;

/// Depth below a surface up to which an object put there stands on it, mm.
const TOUCHES: f64 = 1.0;

/// Support of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Support {
    /// The table.
    Table,
    /// The conveyor's belt.
    Belt,
    /// A fixed position in the air, until it is picked.
    Shelf,
    /// Another object, by its index in the scenario.
    Object(u16),
    /// The tool, which holds it.
    Tool,
    /// The floor: it fell off everything.
    Floor,
}

impl From<On> for Support {
    fn from(on: On) -> Self {
        match on {
            On::Table => Self::Table,
            On::Belt => Self::Belt,
            On::Shelf => Self::Shelf,
            On::Object(below) => Self::Object(below),
        }
    }
}

/// Support of an object, and its position in the frame of the support.
#[derive(Clone, Copy, Debug)]
struct PlacedObject {
    rest: Support,
    inner: ObjectPose,
}

/// Moving frames of reference, at an instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frames {
    /// Frame of the belt.
    pub(super) belt: ObjectPose,
    /// Frame of the tool's tip. Default where it is not needed.
    pub(super) tool: ObjectPose,
}

/// The objects of the world.
#[derive(Clone, Debug, Default)]
pub(super) struct Scene {
    bodies: Vec<PlacedObject>,
    held: Option<u16>,
}

impl Scene {
    pub(super) fn new(scenario: &Scenario, belt: &ObjectPose) -> Self {
        let objects = scenario.objects();
        let body = |object: &Object| {
            let rest = Support::from(object.on);
            let inner = match object.on {
                On::Belt => belt.to(&object.place),
                On::Object(below) => objects
                    .get(usize::from(below))
                    .map_or(object.place, |below| below.place.to(&object.place)),
                On::Table | On::Shelf => object.place,
            };
            PlacedObject { rest, inner }
        };
        Self {
            bodies: objects.iter().map(body).collect(),
            held: None,
        }
    }

    pub(super) fn held(&self) -> Option<u16> {
        self.held
    }

    pub(super) fn ids(&self) -> impl Iterator<Item = u16> + use<> {
        // The scenario limits the number of objects.
        0..u16::try_from(self.bodies.len()).unwrap_or(u16::MAX)
    }

    pub(super) fn rest(&self, object: u16) -> Support {
        self.bodies
            .get(usize::from(object))
            .map_or(Support::Floor, |body| body.rest)
    }

    /// Support of the whole stack that contains the object.
    pub(super) fn root(&self, object: u16) -> Support {
        let mut rest = self.rest(object);
        // At most as many steps as objects: a cycle cannot hang the search.
        for _ in &self.bodies {
            let Support::Object(below) = rest else { break };
            rest = self.rest(below);
        }
        rest
    }

    pub(super) fn is_carried(&self, object: u16) -> bool {
        self.held.is_some() && self.root(object) == Support::Tool
    }

    pub(super) fn place(&self, object: u16, frames: &Frames) -> ObjectPose {
        let Some(body) = self.bodies.get(usize::from(object)) else {
            return ObjectPose::default();
        };
        let (mut place, mut rest) = (body.inner, body.rest);
        for _ in &self.bodies {
            match rest {
                Support::Object(below) => {
                    let Some(below) = self.bodies.get(usize::from(below)) else {
                        break;
                    };
                    (place, rest) = (below.inner.then(&place), below.rest);
                }
                Support::Belt => return frames.belt.then(&place),
                Support::Tool => return frames.tool.then(&place),
                Support::Table | Support::Shelf | Support::Floor => break,
            }
        }
        place
    }

    pub(super) fn solid(&self, object: u16, scenario: &Scenario, frames: &Frames) -> Solid {
        let objects = scenario.objects();
        let size = objects
            .get(usize::from(object))
            .map_or([0.0; 3], |object| object.size);
        let place = self.place(object, frames);
        Solid { place, size }
    }

    /// Makes the tool hold an object and whatever stands on it.
    pub(super) fn take(&mut self, object: u16, frames: &Frames) {
        let place = self.place(object, frames);
        let inner = frames.tool.to(&place);
        self.put(object, Support::Tool, inner);
        self.held = Some(object);
    }

    /// Releases the held object, which falls straight down with whatever stands on it.
    ///
    /// A surface into which the object is pressed by at most `slack`, mm, counts as below it.
    pub(super) fn drop_held(
        &mut self,
        scenario: &Scenario,
        frames: &Frames,
        slack: f64,
    ) -> Option<(u16, Support)> {
        let object = self.held?;
        let place = self.place(object, frames);
        let rest = self.fall(object, place, slack, scenario, frames);
        self.held = None;
        Some((object, rest))
    }

    /// Moves an object by hand, with whatever stands on it; it then falls onto whatever is below.
    /// The tool lets go of the object if it holds it.
    pub(super) fn set_down(
        &mut self,
        object: u16,
        at: [f64; 3],
        scenario: &Scenario,
        frames: &Frames,
    ) -> Support {
        if self.held == Some(object) {
            self.held = None;
        }
        let [x, y, z] = at;
        let from = ObjectPose {
            x,
            y,
            z,
            ..self.place(object, frames)
        };
        self.fall(object, from, TOUCHES, scenario, frames)
    }

    /// Drops an object straight down, onto the highest surface under its middle.
    pub(super) fn fall(
        &mut self,
        object: u16,
        from: ObjectPose,
        slack: f64,
        scenario: &Scenario,
        frames: &Frames,
    ) -> Support {
        let highest = self
            .grounds(object, scenario, frames)
            .filter(|(_, ground)| ground.contains(from.xy()))
            // Surfaces above the object do not catch it.
            .filter(|(_, ground)| ground.place.z <= from.z + slack)
            .max_by(|(_, one), (_, other)| one.place.z.total_cmp(&other.place.z));
        let (rest, z) = highest.map_or((Support::Floor, FLOOR), |(rest, ground)| {
            (rest, ground.place.z)
        });
        let place = ObjectPose { z, ..from };
        let inner = match rest {
            Support::Belt => frames.belt.to(&place),
            Support::Object(below) => self.place(below, frames).to(&place),
            // Table and floor do not move, so their frame is that of the base.
            _ => place,
        };
        self.put(object, rest, inner);
        rest
    }

    /// Surfaces that an object can fall on.
    fn grounds<'a>(
        &'a self,
        object: u16,
        scenario: &'a Scenario,
        frames: &'a Frames,
    ) -> impl Iterator<Item = (Support, Footprint)> + 'a {
        let table = scenario
            .table()
            .map(|table| (Support::Table, table.footprint()));
        let belt = scenario
            .conveyor()
            .map(|belt| (Support::Belt, belt.footprint()));
        let tops = self
            .ids()
            // An object cannot fall onto its own load.
            .filter(move |other| !self.stands_on(*other, object))
            .map(move |other| {
                (
                    Support::Object(other),
                    self.solid(other, scenario, frames).top(),
                )
            });
        table.into_iter().chain(belt).chain(tops)
    }

    /// True if an object is `below`, or stands on it directly or indirectly.
    fn stands_on(&self, object: u16, below: u16) -> bool {
        let mut next = object;
        for _ in &self.bodies {
            if next == below {
                return true;
            }
            match self.rest(next) {
                Support::Object(under) => next = under,
                _ => return false,
            }
        }
        false
    }

    fn put(&mut self, object: u16, rest: Support, inner: ObjectPose) {
        if let Some(body) = self.bodies.get_mut(usize::from(object)) {
            *body = PlacedObject { rest, inner };
        }
    }
}

impl Solid {
    pub(super) fn footprint(&self) -> Footprint {
        footprint(&self.size, self.place)
    }

    /// Height of its upper side.
    pub(super) fn height(&self) -> f64 {
        self.place.z + self.size[2]
    }

    /// Upper side.
    pub(super) fn top(&self) -> Footprint {
        let place = ObjectPose {
            z: self.height(),
            ..self.place
        };
        footprint(&self.size, place)
    }
}
