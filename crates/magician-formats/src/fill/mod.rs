//! Filling of areas: hatching, or rings from the edge inwards.
//!
//! An area is split into layers: the part farther from the edge than the inset, then narrower parts
//! with smaller insets, and finally stubs that get a single line. This way hairlines and serifs are
//! marked although no line of the pen's width fits into them.
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

use crate::keywords::keywords;

/// Fill pattern of an area.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum FillMode {
    /// No filling.
    #[default]
    None,
    /// Parallel lines.
    Hatch,
    /// Two sets of parallel lines at right angles.
    Cross,
    /// Rings from the edge inwards.
    Contour,
}

keywords! {
    FillMode, "fill":
    None = "none",
    Hatch = "hatch",
    Cross = "cross",
    Contour = "contour",
}

/// Fill options of a drawing, as far as the user gave them. Lengths are mm on the surface,
/// regardless of the drawing's scale.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Filling {
    /// Pattern.
    pub mode: FillMode,
    /// Distance between lines; default 0.8 for a pen and 0.2 for a laser.
    pub spacing: Option<f64>,
    /// Direction of the lines, degrees counter-clockwise from x; default 45.
    pub angle: Option<f64>,
    /// Distance from the edge; default half the spacing.
    pub inset: Option<f64>,
}

impl Filling {
    /// Width of a pen's line, mm.
    const PEN_WIDTH: f64 = 0.8;
    /// Width of a laser's beam, mm.
    const BEAM_WIDTH: f64 = 0.2;
    /// Default direction of the lines, degrees: it avoids being parallel to the usual edges.
    const DEFAULT_ANGLE: f64 = 45.0;

    /// Returns the complete options, with defaults for a laser if `burns`, else for a pen.
    #[must_use]
    pub fn fill(&self, burns: bool) -> Fill {
        let usual = if burns {
            Self::BEAM_WIDTH
        } else {
            Self::PEN_WIDTH
        };
        let spacing = self.spacing.unwrap_or(usual);
        Fill {
            mode: self.mode,
            spacing,
            angle: self.angle.unwrap_or(Self::DEFAULT_ANGLE),
            inset: self.inset.unwrap_or(spacing / 2.0),
        }
    }
}

/// Rule that decides what is inside the rings of an area (SVG 2, section 13.4.2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum FillRule {
    /// Inside if the winding number is not zero.
    #[default]
    NonZero,
    /// Inside if an odd number of rings surrounds it.
    EvenOdd,
}

/// A filled shape. Lengths are in mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Area {
    /// Rings, each closed from its last point to its first. They may intersect themselves and each
    /// other.
    pub rings: Vec<Vec<[f64; 2]>>,
    /// Fill rule.
    pub rule: FillRule,
}

impl Area {
    /// Returns the part within a rectangle, given by its smallest and largest corner.
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

/// Options for filling an area. Lengths are in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fill {
    /// Pattern.
    pub mode: FillMode,
    /// Distance between lines. The width of the pen or beam leaves no gap. Lines are placed
    /// slightly closer where needed, so that the last one is as near to its edge as the first.
    pub spacing: f64,
    /// Direction of the lines, degrees counter-clockwise from x.
    pub angle: f64,
    /// Distance of the lines from the edge. Half the spacing keeps the pen's width inside.
    pub inset: f64,
}

/// Smallest spacing, mm. The arm has no finer pen.
pub const MIN_SPACING: f64 = 0.02;
/// Largest number of lines across an area. A choice that bounds memory and time.
const MAX_LINES: f64 = 20_000.0;

impl Fill {
    /// Returns the lines that fill an area, each drawn without lifting the pen.
    ///
    /// Parts narrower than twice the inset get lines nearer to their edge, down to an eighth of the
    /// spacing. Anything narrower, or not larger than the spacing, gets one line. Empty if the
    /// spacing is below [`MIN_SPACING`] or a number is not finite.
    #[must_use]
    pub fn lines(&self, area: &Area) -> Vec<Vec<[f64; 2]>> {
        let numbers = [self.spacing, self.angle, self.inset];
        let finite = numbers.iter().all(|number| number.is_finite());
        if !finite || self.spacing < MIN_SPACING || self.inset < 0.0 {
            return Vec::new();
        }
        let region = Region::of(area);
        let size = region.size();
        if !(size > 0.0 && size / self.spacing <= MAX_LINES) {
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

    /// Splits a region into the part farther from the edge than the inset, narrower parts with
    /// decreasing insets, and the rest.
    fn layers(&self, region: &Region) -> Layers {
        let mut layers = Layers::default();
        let mut rest = region.clone();
        let mut inset = self.inset;
        loop {
            let parts = rest.offset(-inset);
            // Area covered by the pen, plus 2 %, because rounding leaves slivers along the edge.
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
        // Smaller remainders are corners that no round pen can reach.
        layers.stubs.retain(|stub| {
            stub.size() > self.spacing / 2.0 && stub.size_of() > self.spacing.powi(2) / 16.0
        });
        // Parts that got no line yet, such as the dot of an i or a hairline, are drawn however
        // small they are.
        let served = layers.parts.iter().chain(&layers.stubs);
        let mut middles: Vec<_> = served.filter_map(Region::inner_point).collect();
        middles.sort_unstable_by(|one, other| one[0].total_cmp(&other[0]));
        let bare = region.parts().filter(|part| !part.has_any_of(&middles));
        layers.stubs.extend(bare);
        layers
    }
}

/// An area split for filling.
#[derive(Default)]
struct Layers {
    /// Parts to fill. Their edge is inset already.
    parts: Vec<Region>,
    /// Remainders too small or narrow for a pattern, which get one line each.
    stubs: Vec<Region>,
}

impl Layers {
    fn filled(&self, fill: impl Fn(&Region) -> Vec<Vec<[f64; 2]>>) -> Vec<Vec<[f64; 2]>> {
        self.parts.iter().flat_map(fill).collect()
    }
}
