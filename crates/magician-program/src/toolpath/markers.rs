//! Markers: places where the tool picks, places or waits.

/// Largest distance of places that share a marker, mm.
const MERGE_DISTANCE: f64 = 1.0;

/// Kind of event at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum MarkerKind {
    /// The tool picks something up.
    Pick,
    /// The tool lets go.
    Place,
    /// The arm waits.
    Wait,
}

/// Place with events.
#[derive(Clone, Debug, PartialEq)]
pub struct Marker {
    /// Position x, y, z, mm.
    pub at: [f64; 3],
    /// Kinds of events, each once.
    pub kinds: Vec<MarkerKind>,
    /// Name given by the plan.
    pub name: Option<String>,
}

impl Marker {
    /// Adds an event at a place.
    pub(super) fn add(markers: &mut Vec<Self>, at: [f64; 3], kind: MarkerKind, name: Option<&str>) {
        let near =
            |mark: &&mut Self| (0..3).all(|axis| (mark.at[axis] - at[axis]).abs() < MERGE_DISTANCE);
        let name = name.map(str::to_owned);
        match markers.iter_mut().find(near) {
            Some(mark) => {
                if !mark.kinds.contains(&kind) {
                    mark.kinds.push(kind);
                }
                mark.name = mark.name.take().or(name);
            }
            None => markers.push(Self {
                at,
                kinds: vec![kind],
                name,
            }),
        }
    }
}
