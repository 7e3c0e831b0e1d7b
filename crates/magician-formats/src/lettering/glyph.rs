//! The lines of one character.

/// The lines of a character in the units of its font: x to the right from where it begins, y up from the baseline.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Glyph {
    /// Where the next character begins.
    pub(crate) advance: f64,
    /// Its lines, in the order in which they are drawn.
    pub(crate) lines: Vec<Vec<[f64; 2]>>,
}

/// A box: its least and its greatest corner.
pub(crate) type Bounds = [[f64; 2]; 2];

impl Glyph {
    /// Of lines.
    pub(super) fn new(advance: f64, lines: &[&[[f64; 2]]]) -> Self {
        let lines = lines.iter().map(|line| line.to_vec()).collect();
        Self { advance, lines }
    }

    /// What encloses its lines; none if it has none.
    pub(crate) fn bounds(&self) -> Option<Bounds> {
        let mut points = self.lines.iter().flatten();
        let first = *points.next()?;
        Some(points.fold([first, first], |[least, most], [x, y]| {
            [
                [least[0].min(*x), least[1].min(*y)],
                [most[0].max(*x), most[1].max(*y)],
            ]
        }))
    }

    /// Each point somewhere else.
    pub(super) fn mapped(mut self, to: impl Fn([f64; 2]) -> [f64; 2]) -> Self {
        for point in self.lines.iter_mut().flatten() {
            *point = to(*point);
        }
        self
    }

    pub(super) fn moved(self, [dx, dy]: [f64; 2]) -> Self {
        self.mapped(|[x, y]| [x + dx, y + dy])
    }

    /// Scaled from where it begins on the baseline, its advance with it.
    pub(super) fn scaled(mut self, [sx, sy]: [f64; 2]) -> Self {
        self.advance *= sx;
        self.mapped(|[x, y]| [x * sx, y * sy])
    }

    /// With the lines of another one; it keeps its advance.
    pub(super) fn with(mut self, other: Self) -> Self {
        self.lines.extend(other.lines);
        self
    }

    /// With one more line.
    pub(super) fn line(mut self, line: &[[f64; 2]]) -> Self {
        self.lines.push(line.to_vec());
        self
    }

    /// Without the lines for which this holds.
    pub(super) fn without(mut self, is_dropped: impl Fn(&[[f64; 2]]) -> bool) -> Self {
        self.lines.retain(|line| !is_dropped(line));
        self
    }

    /// The other one after it, so much nearer than it would be.
    pub(super) fn then(self, next: Self, nearer: f64) -> Self {
        let at = self.advance - nearer;
        let advance = at + next.advance;
        Self {
            advance,
            ..self.with(next.moved([at, 0.0]))
        }
    }

    /// Where its lines cross a height, from the left.
    pub(super) fn crossings(&self, height: f64) -> Vec<f64> {
        let pieces = self.lines.iter().flat_map(|line| line.windows(2));
        let crossing = |piece: &[[f64; 2]]| match piece {
            [[x, y], [to_x, to_y]] if (y - height) * (to_y - height) <= 0.0 && y != to_y => {
                Some(x + (to_x - x) * (height - y) / (to_y - y))
            }
            _ => None,
        };
        let mut all: Vec<f64> = pieces.filter_map(crossing).collect();
        all.sort_by(f64::total_cmp);
        all
    }

    /// The middle of where its lines cross a height; of the whole where none does.
    pub(super) fn middle_at(&self, height: f64) -> f64 {
        let crossings = self.crossings(height);
        match (crossings.first(), crossings.last()) {
            (Some(first), Some(last)) => (first + last) / 2.0,
            _ => self.middle(),
        }
    }

    /// The middle from left to right.
    pub(super) fn middle(&self) -> f64 {
        self.bounds().map_or(self.advance / 2.0, |[least, most]| {
            (least[0] + most[0]) / 2.0
        })
    }
}
