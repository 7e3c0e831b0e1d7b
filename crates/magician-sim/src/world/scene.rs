//! Where the objects are: each is carried by something, and carries what stands on it.

use super::solid::Solid;
use super::{Footprint, ObjectPose};
use crate::scenario::{Object, On, Scenario, footprint};

/// Where objects end up that fall off everything: a floor far below, mm.
pub(super) const FLOOR: f64 = -1000.0;

/// An object that is put so little below a surface stands on it, mm.
const TOUCHES: f64 = 1.0;

/// What an object rests on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Rest {
    /// The table.
    Table,
    /// The conveyor's belt.
    Belt,
    /// A place of its own in the air, until it is picked.
    Shelf,
    /// Another object, by its place in the scenario.
    Object(u16),
    /// The tool holds it.
    Tool,
    /// It fell off everything.
    Floor,
}

impl From<On> for Rest {
    fn from(on: On) -> Self {
        match on {
            On::Table => Self::Table,
            On::Belt => Self::Belt,
            On::Shelf => Self::Shelf,
            On::Object(below) => Self::Object(below),
        }
    }
}

/// An object: what carries it, and where it stands in the carrier's frame.
#[derive(Clone, Copy, Debug)]
struct Body {
    rest: Rest,
    inner: ObjectPose,
}

/// The frames that move by themselves, at an instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frames {
    /// Moves with the belt.
    pub(super) belt: ObjectPose,
    /// The tool's tip, turned as the tool is; nothing is known of it where nothing depends on it.
    pub(super) tool: ObjectPose,
}

/// The objects.
#[derive(Clone, Debug, Default)]
pub(super) struct Scene {
    bodies: Vec<Body>,
    held: Option<u16>,
}

impl Scene {
    pub(super) fn new(scenario: &Scenario, belt: &ObjectPose) -> Self {
        let objects = scenario.objects();
        let body = |object: &Object| {
            let rest = Rest::from(object.on);
            let inner = match object.on {
                On::Belt => belt.to(&object.place),
                On::Object(below) => objects
                    .get(usize::from(below))
                    .map_or(object.place, |below| below.place.to(&object.place)),
                On::Table | On::Shelf => object.place,
            };
            Body { rest, inner }
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
        // There are never more: the scenario sees to it.
        0..u16::try_from(self.bodies.len()).unwrap_or(u16::MAX)
    }

    pub(super) fn rest(&self, object: u16) -> Rest {
        self.bodies
            .get(usize::from(object))
            .map_or(Rest::Floor, |body| body.rest)
    }

    /// What carries the whole stack that the object is part of.
    pub(super) fn root(&self, object: u16) -> Rest {
        let mut rest = self.rest(object);
        for _ in &self.bodies {
            let Rest::Object(below) = rest else { break };
            rest = self.rest(below);
        }
        rest
    }

    pub(super) fn is_carried(&self, object: u16) -> bool {
        self.held.is_some() && self.root(object) == Rest::Tool
    }

    pub(super) fn place(&self, object: u16, frames: &Frames) -> ObjectPose {
        let Some(body) = self.bodies.get(usize::from(object)) else {
            return ObjectPose::default();
        };
        let (mut place, mut rest) = (body.inner, body.rest);
        for _ in &self.bodies {
            match rest {
                Rest::Object(below) => {
                    let Some(below) = self.bodies.get(usize::from(below)) else {
                        break;
                    };
                    (place, rest) = (below.inner.then(&place), below.rest);
                }
                Rest::Belt => return frames.belt.then(&place),
                Rest::Tool => return frames.tool.then(&place),
                Rest::Table | Rest::Shelf | Rest::Floor => break,
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

    /// The tool takes an object, and what stands on it.
    pub(super) fn take(&mut self, object: u16, frames: &Frames) {
        let place = self.place(object, frames);
        let inner = frames.tool.to(&place);
        self.put(object, Rest::Tool, inner);
        self.held = Some(object);
    }

    /// The tool lets go of what it holds: it falls straight down, what stands on it with it. What
    /// the tool was pressed into by no more than `slack` is what it falls on.
    pub(super) fn drop_held(
        &mut self,
        scenario: &Scenario,
        frames: &Frames,
        slack: f64,
    ) -> Option<(u16, Rest)> {
        let object = self.held?;
        let place = self.place(object, frames);
        let rest = self.fall(object, place, slack, scenario, frames);
        self.held = None;
        Some((object, rest))
    }

    /// A hand puts an object somewhere, out of the tool if it is there, what stands on it with it:
    /// it falls onto what is below.
    pub(super) fn set_down(
        &mut self,
        object: u16,
        at: [f64; 3],
        scenario: &Scenario,
        frames: &Frames,
    ) -> Rest {
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

    /// An object falls straight down from a place, onto the highest body that is under its middle.
    pub(super) fn fall(
        &mut self,
        object: u16,
        from: ObjectPose,
        slack: f64,
        scenario: &Scenario,
        frames: &Frames,
    ) -> Rest {
        let highest = self
            .grounds(object, scenario, frames)
            .filter(|(_, ground)| ground.contains(from.xy()))
            .filter(|(_, ground)| ground.place.z <= from.z + slack)
            .max_by(|(_, one), (_, other)| one.place.z.total_cmp(&other.place.z));
        let (rest, z) = highest.map_or((Rest::Floor, FLOOR), |(rest, ground)| {
            (rest, ground.place.z)
        });
        let place = ObjectPose { z, ..from };
        let inner = match rest {
            Rest::Belt => frames.belt.to(&place),
            Rest::Object(below) => self.place(below, frames).to(&place),
            _ => place,
        };
        self.put(object, rest, inner);
        rest
    }

    /// What an object can fall on: each with its upper side.
    fn grounds<'a>(
        &'a self,
        object: u16,
        scenario: &'a Scenario,
        frames: &'a Frames,
    ) -> impl Iterator<Item = (Rest, Footprint)> + 'a {
        let table = scenario
            .table()
            .map(|table| (Rest::Table, table.footprint()));
        let belt = scenario
            .conveyor()
            .map(|belt| (Rest::Belt, belt.footprint()));
        let tops = self
            .ids()
            .filter(move |other| !self.stands_on(*other, object))
            .map(move |other| {
                (
                    Rest::Object(other),
                    self.solid(other, scenario, frames).top(),
                )
            });
        table.into_iter().chain(belt).chain(tops)
    }

    /// Whether one object is another, or stands on it, on whatever there is between them.
    fn stands_on(&self, object: u16, below: u16) -> bool {
        let mut next = object;
        for _ in &self.bodies {
            if next == below {
                return true;
            }
            match self.rest(next) {
                Rest::Object(under) => next = under,
                _ => return false,
            }
        }
        false
    }

    fn put(&mut self, object: u16, rest: Rest, inner: ObjectPose) {
        if let Some(body) = self.bodies.get_mut(usize::from(object)) {
            *body = Body { rest, inner };
        }
    }
}

impl Solid {
    pub(super) fn footprint(&self) -> Footprint {
        footprint(&self.size, self.place)
    }

    /// The height of its upper side.
    pub(super) fn height(&self) -> f64 {
        self.place.z + self.size[2]
    }

    /// Its upper side.
    pub(super) fn top(&self) -> Footprint {
        let place = ObjectPose {
            z: self.height(),
            ..self.place
        };
        footprint(&self.size, place)
    }
}
