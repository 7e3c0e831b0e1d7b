//! A framed drawing area with a grid in mm.

use super::svg::{Svg, number, path};
use super::{FAINT, INK};

/// Distance of the grid's lines, mm.
const GRID: i32 = 50;

/// How mm become places in the picture. `across` and `up` are the values at the left and right,
/// and at the bottom and top edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) per_mm: f64,
    pub(super) across: (f64, f64),
    pub(super) up: (f64, f64),
}

impl Scale {
    /// Where a point lies.
    pub(super) fn at(&self, across: f64, up: f64) -> (f64, f64) {
        (
            self.left + (across - self.across.0) * self.per_mm,
            self.top + (self.up.1 - up) * self.per_mm,
        )
    }

    fn size(&self) -> (f64, f64) {
        let width = self.across.1 - self.across.0;
        (width * self.per_mm, (self.up.1 - self.up.0) * self.per_mm)
    }
}

/// A drawing area under way: what is drawn until its end is cut at its frame.
pub(super) struct Panel {
    scale: Scale,
}

impl Panel {
    /// Frames an area, titles it, and begins to cut.
    pub(super) fn begin(
        svg: &mut Svg,
        scale: Scale,
        id: &str,
        title: &str,
        across: &str,
        up: &str,
    ) -> Self {
        let (width, height) = scale.size();
        let (right, bottom) = (scale.left + width, scale.top + height);
        let heading = [("font-size", "17"), ("font-weight", "bold"), ("fill", INK)];
        svg.text((scale.left, scale.top - 10.0), title, &heading);
        let label = [("font-size", "13"), ("fill", FAINT), ("text-anchor", "end")];
        svg.text((right, bottom + 36.0), across, &label);
        svg.text(
            (right, scale.top - 10.0),
            format_args!("upwards: {up}"),
            &label,
        );
        let [left, top, width, height] = [scale.left, scale.top, width, height].map(number);
        let frame = [
            ("x", left.as_str()),
            ("y", &top),
            ("width", &width),
            ("height", &height),
        ];
        svg.group("clipPath", &[("id", id)]);
        svg.leaf("rect", &frame);
        svg.end();
        let panel = Self { scale };
        panel.ticks(svg);
        let mut border = frame.to_vec();
        border.extend([("fill", "#fbfcfd"), ("stroke", "#cbd2d9")]);
        svg.leaf("rect", &border);
        svg.group("g", &[("clip-path", &format!("url(#{id})"))]);
        panel
    }

    /// The lines of the grid.
    pub(super) fn grid(&self, svg: &mut Svg) {
        let Scale { across, up, .. } = self.scale;
        let mut data = String::new();
        for value in lines(across) {
            let ends = [up.0, up.1].map(|up| self.scale.at(value, up));
            data.push_str(&path(ends, false));
        }
        for value in lines(up) {
            let ends = [across.0, across.1].map(|across| self.scale.at(across, value));
            data.push_str(&path(ends, false));
        }
        let attributes = [
            ("d", data.as_str()),
            ("stroke", "#1f2933"),
            ("stroke-opacity", "0.09"),
        ];
        svg.leaf("path", &attributes);
    }

    /// The numbers at the lines of the grid.
    fn ticks(&self, svg: &mut Svg) {
        let Scale {
            across, up, left, ..
        } = self.scale;
        let label = |anchor| {
            [
                ("font-size", "12"),
                ("fill", FAINT),
                ("text-anchor", anchor),
            ]
        };
        for value in lines(across) {
            let (x, y) = self.scale.at(value, up.0);
            svg.text((x, y + 17.0), value, &label("middle"));
        }
        for value in lines(up) {
            let (_, y) = self.scale.at(across.0, value);
            svg.text((left - 7.0, y + 4.0), value, &label("end"));
        }
    }

    /// Ends the cutting.
    pub(super) fn end(self, svg: &mut Svg) {
        svg.end();
    }
}

fn lines(range: (f64, f64)) -> impl Iterator<Item = f64> {
    let first = (range.0 / f64::from(GRID)).ceil() as i32;
    let last = (range.1 / f64::from(GRID)).floor() as i32;
    (first..=last).map(|line| f64::from(line * GRID))
}
