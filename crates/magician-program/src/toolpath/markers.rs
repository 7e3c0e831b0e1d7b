//! What happens at places: picking, placing, waiting.

/// Places nearer to one another than this are the same, mm.
const SAME: f64 = 1.0;

/// What happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum MarkerKind {
    /// The tool takes hold.
    Pick,
    /// It lets go.
    Place,
    /// It waits.
    Wait,
}

/// A place at which something happens.
#[derive(Clone, Debug, PartialEq)]
pub struct Marker {
    /// X, y and z, mm.
    pub at: [f64; 3],
    /// What happens there, each once.
    pub kinds: Vec<MarkerKind>,
    /// The name that the plan gives it.
    pub name: Option<String>,
}

impl Marker {
    /// Adds what happens at a place.
    pub(super) fn add(markers: &mut Vec<Self>, at: [f64; 3], kind: MarkerKind, name: Option<&str>) {
        let near = |mark: &&mut Self| (0..3).all(|axis| (mark.at[axis] - at[axis]).abs() < SAME);
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
