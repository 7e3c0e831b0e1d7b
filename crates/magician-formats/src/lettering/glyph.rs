//! Glyphs: the polylines of one character.

/// Polylines of a character in units of its font: x to the right from its origin, y up from the
/// baseline.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Glyph {
    /// Distance to the origin of the next character.
    pub(crate) advance: f64,
    /// Polylines in drawing order.
    pub(crate) lines: Vec<Vec<[f64; 2]>>,
}

/// Bounding box: smallest and largest corner.
pub(crate) type Bounds = [[f64; 2]; 2];

impl Glyph {
    /// Creates a glyph from polylines.
    pub(super) fn new(advance: f64, lines: &[&[[f64; 2]]]) -> Self {
        let lines = lines.iter().map(|line| line.to_vec()).collect();
        Self { advance, lines }
    }

    /// Bounding box, or `None` if the glyph has no lines.
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

    /// Maps every point.
    pub(super) fn mapped(mut self, to: impl Fn([f64; 2]) -> [f64; 2]) -> Self {
        for point in self.lines.iter_mut().flatten() {
            *point = to(*point);
        }
        self
    }

    pub(super) fn moved(self, [dx, dy]: [f64; 2]) -> Self {
        self.mapped(|[x, y]| [x + dx, y + dy])
    }

    /// Scales about the origin, including the advance.
    pub(super) fn scaled(mut self, [sx, sy]: [f64; 2]) -> Self {
        self.advance *= sx;
        self.mapped(|[x, y]| [x * sx, y * sy])
    }

    /// Adds the lines of another glyph and keeps the advance.
    pub(super) fn with(mut self, other: Self) -> Self {
        self.lines.extend(other.lines);
        self
    }

    /// Adds a line.
    pub(super) fn line(mut self, line: &[[f64; 2]]) -> Self {
        self.lines.push(line.to_vec());
        self
    }

    /// Removes the lines for which `is_dropped` returns true.
    pub(super) fn without(mut self, is_dropped: impl Fn(&[[f64; 2]]) -> bool) -> Self {
        self.lines.retain(|line| !is_dropped(line));
        self
    }

    /// Appends another glyph, closer by `nearer` than its advance says.
    pub(super) fn then(self, next: Self, nearer: f64) -> Self {
        let at = self.advance - nearer;
        let advance = at + next.advance;
        Self {
            advance,
            ..self.with(next.moved([at, 0.0]))
        }
    }

    /// X at which lines cross a height, sorted from left to right.
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

    /// Middle of the outermost crossings at a height, or of the whole glyph without crossings.
    pub(super) fn middle_at(&self, height: f64) -> f64 {
        let crossings = self.crossings(height);
        match (crossings.first(), crossings.last()) {
            (Some(first), Some(last)) => (first + last) / 2.0,
            _ => self.middle(),
        }
    }

    /// Middle between left and right edge.
    pub(super) fn middle(&self) -> f64 {
        self.bounds().map_or(self.advance / 2.0, |[least, most]| {
            (least[0] + most[0]) / 2.0
        })
    }
}
