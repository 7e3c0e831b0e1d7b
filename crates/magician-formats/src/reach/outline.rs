//! Outline of the reach, for pictures.
//!
//! The outline is traced in polar coordinates: for each heading the reachable distances are found
//! by sampling and bisection, and spans of neighbouring headings are connected to rings. Where
//! their number changes, the heading of the change is found by bisection too.

use super::Reach;

/// Step of distances before bisection, mm. Smaller gaps could be missed.
const DISTANCE_STEP: f64 = 2.0;
/// Upper bound of the reach of any tool, mm.
const MAX_REACH: f64 = 600.0;
/// Step of headings, degrees. A choice between a smooth outline and time.
const HEADING_STEP: i32 = 2;
/// Precision of the edge, mm or deg. Far finer than any picture shows.
const EDGE_PRECISION: f64 = 1e-6;

impl Reach {
    /// Returns the outline of the reach on the surface and at the lift above it: closed polygons in
    /// the arm's x and y. Empty if there is no reach.
    #[must_use]
    pub fn outline(&self) -> Vec<Vec<[f64; 2]>> {
        let mut rings: Vec<Ring> = Vec::new();
        let mut open: Vec<Ring> = Vec::new();
        let mut before: Option<(f64, Vec<[f64; 2]>)> = None;
        for heading in (-180..=180).step_by(HEADING_STEP as usize).map(f64::from) {
            let spans = self.spans(heading);
            if let Some((from, old)) = &before
                && old.len() != spans.len()
            {
                let (last, first) = self.change(*from, heading, old.len());
                let ending = self.spans(last);
                (open.iter_mut().zip(ending)).for_each(|(ring, span)| ring.add(last, span));
                rings.append(&mut open);
                let beginning = self.spans(first).into_iter();
                open = beginning.map(|span| Ring::begun(first, span)).collect();
            }
            if open.len() != spans.len() {
                rings.append(&mut open);
                open = vec![Ring::default(); spans.len()];
            }
            for (ring, span) in open.iter_mut().zip(&spans) {
                ring.add(heading, *span);
            }
            before = Some((heading, spans));
        }
        rings.append(&mut open);
        let closed = rings.into_iter().map(Ring::closed);
        closed.filter(|ring| ring.len() > 3).collect()
    }

    /// Returns the spans of reachable distances in a direction, mm.
    fn spans(&self, heading: f64) -> Vec<[f64; 2]> {
        let (sin, cos) = libm::sincos(heading.to_radians());
        let inside = |distance: f64| self.has([distance * cos, distance * sin]);
        let mut spans = Vec::new();
        let (mut at, mut was, mut begun) = (0.0, inside(0.0), 0.0);
        while at < MAX_REACH {
            let next = at + DISTANCE_STEP;
            let is = inside(next);
            match (was, is) {
                (false, true) => begun = edge(next, at, inside),
                (true, false) => spans.push([begun, edge(at, next, inside)]),
                _ => {}
            }
            (at, was) = (next, is);
        }
        spans
    }

    /// Bisects between two headings where the number of spans changes. Returns the last heading
    /// with `count` spans and the first without.
    fn change(&self, mut from: f64, mut to: f64, count: usize) -> (f64, f64) {
        while to - from > 1e-3 {
            let middle = 0.5 * (from + to);
            if self.spans(middle).len() == count {
                from = middle;
            } else {
                to = middle;
            }
        }
        (from, to)
    }

    /// Returns the widest span of reachable distances straight ahead, mm.
    pub(crate) fn ahead(&self) -> Option<[f64; 2]> {
        let spans = self.spans(0.0).into_iter();
        spans.max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))
    }
}

/// Bisects the edge between a reachable and an unreachable distance. The result is reachable.
fn edge(mut inner: f64, mut outer: f64, inside: impl Fn(f64) -> bool) -> f64 {
    while (outer - inner).abs() > EDGE_PRECISION {
        let middle = 0.5 * (inner + outer);
        if inside(middle) {
            inner = middle;
        } else {
            outer = middle;
        }
    }
    inner
}

/// An area between two distances per heading.
#[derive(Clone, Debug, Default)]
struct Ring {
    near: Vec<[f64; 2]>,
    far: Vec<[f64; 2]>,
}

impl Ring {
    fn begun(heading: f64, span: [f64; 2]) -> Self {
        let mut ring = Self::default();
        ring.add(heading, span);
        ring
    }

    fn add(&mut self, heading: f64, [near, far]: [f64; 2]) {
        let (sin, cos) = libm::sincos(heading.to_radians());
        self.near.push([near * cos, near * sin]);
        self.far.push([far * cos, far * sin]);
    }

    /// Closes the ring: out along the far edge, back along the near one.
    fn closed(self) -> Vec<[f64; 2]> {
        let mut points = self.far;
        points.extend(self.near.into_iter().rev());
        points.extend(points.first().copied());
        points
    }
}
