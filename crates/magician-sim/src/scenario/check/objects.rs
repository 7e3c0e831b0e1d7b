//! Validation of the objects: each rests on something, and no two overlap.

use super::rules::{Checked, SectionPath};
use super::{MAX_DISTANCE, file};
use crate::scenario::{Color, Conveyor, Object, On, Table};
use crate::world::{Footprint, ObjectPose};

/// Longest side of an object, mm. A choice: larger than anything that the arm lifts.
const MAX_SIDE: f64 = 1000.0;
/// Most objects. The search for contacts looks at each of them for every motion.
const MAX_OBJECTS: usize = 1000;
/// Overlap up to which two objects count as touching, mm. It absorbs rounding.
const CLEARANCE: f64 = 1e-6;

pub(super) fn objects(
    objects: &[file::Object],
    table: Option<&Table>,
    belt: Option<&Conveyor>,
) -> Checked<Vec<Object>> {
    let mut checked: Vec<Object> = Vec::with_capacity(objects.len().min(MAX_OBJECTS));
    for (nth, object) in objects.iter().enumerate() {
        let at = SectionPath::entry("object", nth);
        if nth >= MAX_OBJECTS {
            return at.diagnostic("", format!("more than {MAX_OBJECTS} objects: remove some"));
        }
        let stage = Supports {
            table,
            belt,
            others: &checked,
        };
        let next = stage.object(&at, object)?;
        checked.push(next);
    }
    Ok(checked)
}

/// Supports for an object.
struct Supports<'a> {
    table: Option<&'a Table>,
    belt: Option<&'a Conveyor>,
    others: &'a [Object],
}

impl Supports<'_> {
    fn object(&self, at: &SectionPath, object: &file::Object) -> Checked<Object> {
        let name = self.name(at, &object.name)?;
        if let Some(side) = object
            .size
            .iter()
            .find(|side| !(**side > 0.0 && **side <= MAX_SIDE))
        {
            let message = format!(
                "a side of object '{name}' is {side}, it must be above 0 and at most {MAX_SIDE} mm"
            );
            return at.diagnostic("size", message);
        }
        at.numbers("at", &object.at, -MAX_DISTANCE..=MAX_DISTANCE, "mm")?;
        let yaw = at.number("yaw", object.yaw.unwrap_or(0.0), -360.0..=360.0, "deg")?;
        let on = self.on(at, object)?;
        let [x, y] = object.at;
        let checked = Object {
            name: name.to_owned(),
            size: object.size,
            color: object.color.unwrap_or(Color::GREY),
            place: ObjectPose {
                x,
                y,
                z: self.height(at, object, on)?,
                yaw,
            },
            on,
        };
        self.stands(at, &checked)?;
        Ok(checked)
    }

    fn name<'n>(&self, at: &SectionPath, name: &'n str) -> Checked<&'n str> {
        if name.trim().is_empty() {
            return at.diagnostic("name", "an object needs a name");
        }
        // Both words are supports in `on`.
        if name == "table" || name == "belt" {
            let message = format!("'{name}' is the {name}'s own name: choose another");
            return at.diagnostic("name", message);
        }
        if self.others.iter().any(|other| other.name == name) {
            let message = format!("another object is called '{name}': choose another name");
            return at.diagnostic("name", message);
        }
        Ok(name)
    }

    fn on(&self, at: &SectionPath, object: &file::Object) -> Checked<On> {
        if object.z.is_some() {
            at.absent("on", object.on.is_some(), "z gives its height")?;
            return Ok(On::Shelf);
        }
        match object.on.as_deref() {
            None | Some("table") => Ok(On::Table),
            Some("belt") => Ok(On::Belt),
            Some(name) => {
                let place = self.others.iter().position(|other| other.name == name);
                match place.and_then(|place| u16::try_from(place).ok()) {
                    Some(place) => Ok(On::Object(place)),
                    None => {
                        let message = format!(
                            "there is no earlier object '{name}': on must be \"table\", \"belt\" \
                                or the name of an earlier object"
                        );
                        at.diagnostic("on", message)
                    }
                }
            }
        }
    }

    /// Height of the support.
    fn height(&self, at: &SectionPath, object: &file::Object, on: On) -> Checked<f64> {
        match on {
            On::Shelf => at.number("z", object.z.unwrap_or_default(), -500.0..=500.0, "mm"),
            On::Table => match self.table {
                Some(table) => Ok(table.height),
                None => at.diagnostic("on", "there is no table: add [table], or give z"),
            },
            On::Belt => match self.belt {
                Some(belt) => Ok(belt.height),
                None => at.diagnostic("on", "there is no belt: add [conveyor]"),
            },
            On::Object(place) => Ok(self
                .others
                .get(usize::from(place))
                .map_or(0.0, |below| below.place.z + below.size[2])),
        }
    }

    /// Checks that the middle of the object is above its support, and that it overlaps no other
    /// object.
    fn stands(&self, at: &SectionPath, object: &Object) -> Checked<()> {
        let (name, [x, y]) = (&object.name, object.place.xy());
        let (ground, called): (Option<Footprint>, &str) = match object.on {
            On::Shelf => (None, ""),
            On::Table => (self.table.map(Table::footprint), "the table"),
            On::Belt => (self.belt.map(Conveyor::footprint), "the belt"),
            On::Object(place) => match self.others.get(usize::from(place)) {
                Some(below) => (Some(below.footprint()), below.name.as_str()),
                None => (None, ""),
            },
        };
        if ground.is_some_and(|ground| !ground.contains([x, y])) {
            let message = format!(
                "object '{name}' at [{x}, {y}] lies outside {called}: move it, or enlarge {called}"
            );
            return at.diagnostic("at", message);
        }
        match self.others.iter().find(|other| intersect(object, other)) {
            None => Ok(()),
            Some(other) => {
                let message = format!("object '{name}' overlaps '{}': move it", other.name);
                at.diagnostic("at", message)
            }
        }
    }
}

/// True if two objects overlap.
pub(in crate::scenario) fn intersect(one: &Object, other: &Object) -> bool {
    let above = |low: &Object, high: &Object| high.place.z >= low.place.z + low.size[2] - CLEARANCE;
    let shrunk = |object: &Object| {
        let mut footprint = object.footprint();
        footprint.half = footprint.half.map(|half| half - CLEARANCE);
        footprint
    };
    !above(one, other) && !above(other, one) && shrunk(one).overlaps(&shrunk(other))
}
