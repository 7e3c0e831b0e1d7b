//! Areas filled with lines: hatched, or with rings from their edge inwards.
//!
//! ```
//! use magician_formats::fill::{Area, Fill, FillMode};
//!
//! let square = [[0.0, 0.0], [20.0, 0.0], [20.0, 20.0], [0.0, 20.0]];
//! let area = Area { rings: vec![square.to_vec()], ..Area::default() };
//! let fill = Fill { mode: FillMode::Hatch, spacing: 1.0, angle: 0.0, inset: 0.5 };
//! // Neighbouring lines are joined: the pen goes down once.
//! assert_eq!(fill.lines(&area).len(), 1);
//! ```

mod contour;
mod hatch;
mod join;
#[cfg(feature = "drawings")]
mod pattern;
mod region;
#[cfg(test)]
mod tests;

#[cfg(feature = "drawings")]
pub(crate) use pattern::LineFamily;
pub(crate) use region::Region;

use crate::words::words;

/// How an area is filled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum FillMode {
    /// It is not.
    #[default]
    None,
    /// Parallel lines.
    Hatch,
    /// Parallel lines, and others across them.
    Cross,
    /// Rings from the edge inwards.
    Contour,
}

words! {
    FillMode, "fill":
    None = "none",
    Hatch = "hatch",
    Cross = "cross",
    Contour = "contour",
}

/// How the shapes of a drawing are filled, as far as that was said. Lengths are mm on the surface, however the drawing is scaled.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Filling {
    /// With which lines.
    pub mode: FillMode,
    /// Distance of the lines; 0.8 with a pen and 0.2 with a laser unless given.
    pub spacing: Option<f64>,
    /// Direction of the lines, degrees counter-clockwise from x; 45 unless given.
    pub angle: Option<f64>,
    /// Distance from the edge; half the distance of the lines unless given.
    pub inset: Option<f64>,
}

impl Filling {
    /// The widths of a pen's line and of a laser's.
    const PEN: f64 = 0.8;
    const BEAM: f64 = 0.2;
    const ANGLE: f64 = 45.0;

    /// With what was not said as it is for a pen, or for a laser.
    #[must_use]
    pub fn fill(&self, burns: bool) -> Fill {
        let usual = if burns { Self::BEAM } else { Self::PEN };
        let spacing = self.spacing.unwrap_or(usual);
        Fill {
            mode: self.mode,
            spacing,
            angle: self.angle.unwrap_or(Self::ANGLE),
            inset: self.inset.unwrap_or(spacing / 2.0),
        }
    }
}

/// Which side of its rings is inside (SVG 2, section 13.4.2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum FillRule {
    /// What the rings go round in one direction more often than in the other.
    #[default]
    NonZero,
    /// What an odd number of rings is around.
    EvenOdd,
}

/// A filled shape. Lengths are mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Area {
    /// Its edges, each closed by a line from its last point to its first. They may cross themselves and each other.
    pub rings: Vec<Vec<[f64; 2]>>,
    /// Which side of them is inside.
    pub rule: FillRule,
}

impl Area {
    /// What of it is within a rectangle, from its least to its greatest corner.
    #[must_use]
    pub fn within(&self, [least, most]: [[f64; 2]; 2]) -> Self {
        let corners = [least, [most[0], least[1]], most, [least[0], most[1]]];
        let window = Self {
            rings: vec![corners.to_vec()],
            rule: FillRule::NonZero,
        };
        Region::of(self).common(&Region::of(&window)).area()
    }
}

/// How an area is filled. Lengths are mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fill {
    /// With which lines.
    pub mode: FillMode,
    /// Distance of neighbouring lines; the width of the pen or beam leaves no gap. They may be nearer to each other, so that
    /// the last line is as near to its edge as the first.
    pub spacing: f64,
    /// Direction of the lines, degrees counter-clockwise from x.
    pub angle: f64,
    /// Distance of the lines from the edge; half the spacing keeps the width of the pen inside.
    pub inset: f64,
}

/// No lines are nearer to each other than this, mm: a pen that fine is not on this arm.
pub const LEAST_SPACING: f64 = 0.02;
/// An area has no more lines than this across it.
const MOST_LINES: f64 = 20_000.0;

impl Fill {
    /// The lines that fill an area, each drawn without lifting the pen. Parts that are narrower than twice the inset get lines
    /// nearer to their edge, down to an eighth of the spacing; what is narrower still, or no larger than the
    /// spacing, gets one line. None where the spacing is below [`LEAST_SPACING`] or no number.
    #[must_use]
    pub fn lines(&self, area: &Area) -> Vec<Vec<[f64; 2]>> {
        let numbers = [self.spacing, self.angle, self.inset];
        let finite = numbers.iter().all(|number| number.is_finite());
        if !finite || self.spacing < LEAST_SPACING || self.inset < 0.0 {
            return Vec::new();
        }
        let region = Region::of(area);
        let size = region.size();
        if !(size > 0.0 && size / self.spacing <= MOST_LINES) {
            return Vec::new();
        }
        let layers = self.layers(&region);
        let hatched = |angle| layers.filled(|part| hatch::lines(part, self.spacing, angle));
        let mut lines = match self.mode {
            FillMode::None => return Vec::new(),
            FillMode::Hatch => hatched(self.angle),
            FillMode::Cross => [self.angle, self.angle + 90.0].map(hatched).concat(),
            FillMode::Contour => layers.filled(|part| contour::lines(part, self.spacing)),
        };
        lines.extend(layers.stubs.iter().map(|stub| stub.one_line(self.spacing)));
        lines.retain(|line| line.len() > 1);
        lines
    }

    /// Returns what is farther from the edge than the inset; then what is narrower, with ever smaller
    /// insets; and what is left of all that.
    fn layers(&self, region: &Region) -> Layers {
        let mut layers = Layers::default();
        let mut rest = region.clone();
        let mut inset = self.inset;
        loop {
            let parts = rest.offset(-inset);
            // What the pen has passed, and a little more: rounding leaves slivers along the edge.
            let passed = parts.offset(inset.max(self.spacing * 0.5) * 1.02);
            layers.parts.extend(parts.parts());
            let left = rest.except(&passed);
            let (worth, stubs): (Vec<_>, Vec<_>) =
                { left.parts() }.partition(|part| part.is_worth_a_line(self.spacing));
            layers.stubs.extend(stubs);
            let next = (inset * 0.7).min(self.spacing * 0.5);
            if worth.is_empty() || next < self.spacing / 8.0 || inset == 0.0 {
                layers.stubs.extend(worth);
                break;
            }
            rest = worth.into_iter().collect();
            inset = next;
        }
        // Smaller ones are the corners that no round pen reaches.
        layers.stubs.retain(|stub| {
            stub.size() > self.spacing / 2.0 && stub.size_of() > self.spacing.powi(2) / 16.0
        });
        // The dot of an i and a hairline are drawn, however small they are.
        let served = layers.parts.iter().chain(&layers.stubs);
        let mut middles: Vec<_> = served.filter_map(Region::inner_point).collect();
        middles.sort_unstable_by(|one, other| one[0].total_cmp(&other[0]));
        let bare = region.parts().filter(|part| !part.has_any_of(&middles));
        layers.stubs.extend(bare);
        layers
    }
}

/// An area as it is filled.
#[derive(Default)]
struct Layers {
    /// Parts whose edge lies as far inside as the pen has to stay.
    parts: Vec<Region>,
    /// What is too small or too narrow for that: one line is enough.
    stubs: Vec<Region>,
}

impl Layers {
    fn filled(&self, fill: impl Fn(&Region) -> Vec<Vec<[f64; 2]>>) -> Vec<Vec<[f64; 2]>> {
        self.parts.iter().flat_map(fill).collect()
    }
}
