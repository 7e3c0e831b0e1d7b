//! Traces of pen and laser.

/// Distance up to which two points coincide, mm.
const SAME: f64 = 1e-6;

/// Kind of a trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StrokeKind {
    /// Ink of the pen.
    Ink,
    /// Burn of the laser.
    Burn,
}

/// A continuous line. A single point is a dot.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// Ink or burn.
    pub kind: StrokeKind,
    /// Laser power, above 0 to 100 percent; 100 for ink.
    pub power: f64,
    /// Vertices x, y in the frame of the arm's base, mm. The true line deviates from the polyline
    /// by at most 0.02 mm.
    pub points: Vec<[f64; 2]>,
}

/// All traces of pen and laser, in the order in which they were made.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    strokes: Vec<Stroke>,
    points: usize,
    dropped: u64,
}

/// A drawing restored from saved strokes.
impl From<Vec<Stroke>> for Drawing {
    fn from(strokes: Vec<Stroke>) -> Self {
        let points = strokes.iter().map(|stroke| stroke.points.len()).sum();
        Self {
            strokes,
            points,
            dropped: 0,
        }
    }
}

impl Drawing {
    /// Most points kept; further ones are only counted. A choice: 10 million points take 160 MB.
    pub const MOST_POINTS: usize = 10_000_000;

    /// Strokes, oldest first.
    #[must_use]
    pub fn strokes(&self) -> &[Stroke] {
        &self.strokes
    }

    /// True if there are no strokes.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.strokes.is_empty()
    }

    /// Number of points dropped above [`MOST_POINTS`](Self::MOST_POINTS).
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Lower and upper corner of the bounding box; `None` without points.
    #[must_use]
    pub fn bounds(&self) -> Option<[[f64; 2]; 2]> {
        let mut points = self.strokes.iter().flat_map(|stroke| &stroke.points);
        let first = *points.next()?;
        let grow = |[least, most]: [[f64; 2]; 2], point: &[f64; 2]| {
            let [x, y] = *point;
            [
                [least[0].min(x), least[1].min(y)],
                [most[0].max(x), most[1].max(y)],
            ]
        };
        Some(points.fold([first, first], grow))
    }

    pub(super) fn begin(&mut self, kind: StrokeKind, power: f64, point: [f64; 2]) {
        if self.has_room() {
            let points = vec![point];
            self.strokes.push(Stroke {
                kind,
                power,
                points,
            });
        }
    }

    /// Extends the last stroke to a point, if it differs from the last one.
    pub(super) fn line_to(&mut self, point: [f64; 2]) {
        let there = |last: [f64; 2]| {
            let [x, y] = [point[0] - last[0], point[1] - last[1]];
            x.abs().max(y.abs()) <= SAME
        };
        // A pen that stands still must not fill the drawing with equal points.
        if self.last().is_some_and(there) || !self.has_room() {
            return;
        }
        if let Some(stroke) = self.strokes.last_mut() {
            stroke.points.push(point);
        }
    }

    pub(super) fn last(&self) -> Option<[f64; 2]> {
        self.strokes.last()?.points.last().copied()
    }

    fn has_room(&mut self) -> bool {
        if self.points < Self::MOST_POINTS {
            self.points += 1;
            return true;
        }
        self.dropped = self.dropped.saturating_add(1);
        false
    }
}
