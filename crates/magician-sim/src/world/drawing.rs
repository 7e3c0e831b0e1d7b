//! What pen and laser have left.

/// Points that are nearer to one another than this are the same, mm.
const SAME: f64 = 1e-6;

/// Ink or burnt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StrokeKind {
    /// The pen's ink.
    Ink,
    /// Burnt by the laser.
    Burn,
}

/// A line without a break; one of a single point is a dot.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// Ink or burnt.
    pub kind: StrokeKind,
    /// Power of the laser, above 0 to 100 percent; 100 for ink.
    pub power: f64,
    /// Its corners x, y in the frame of the arm's base, mm; the real line is never farther from it
    /// than 0.02 mm.
    pub points: Vec<[f64; 2]>,
}

/// Everything that pen and laser have left, in the order in which it came about.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    strokes: Vec<Stroke>,
    points: usize,
    dropped: u64,
}

/// A drawing of these strokes: what was kept of one, put together again.
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
    /// As many points are kept; more are counted.
    pub const MOST_POINTS: usize = 10_000_000;

    /// The strokes.
    #[must_use]
    pub fn strokes(&self) -> &[Stroke] {
        &self.strokes
    }

    /// Whether there is nothing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.strokes.is_empty()
    }

    /// How many points were not kept because there were too many.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// The least and the greatest corner of everything drawn.
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

    /// Goes on to a point, if that is another one.
    pub(super) fn line_to(&mut self, point: [f64; 2]) {
        let there = |last: [f64; 2]| {
            let [x, y] = [point[0] - last[0], point[1] - last[1]];
            x.abs().max(y.abs()) <= SAME
        };
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
