//! A framed drawing area with a grid in mm.

use magician_picture::svg::palette::{FAINT, INK};
use magician_picture::svg::{Svg, segments};

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
    pub(super) fn at(&self, across: f64, up: f64) -> [f64; 2] {
        [
            self.left + (across - self.across.0) * self.per_mm,
            self.top + (self.up.1 - up) * self.per_mm,
        ]
    }

    /// Its upper left and lower right corner.
    fn corners(&self) -> [[f64; 2]; 2] {
        [
            self.at(self.across.0, self.up.1),
            self.at(self.across.1, self.up.0),
        ]
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
        let corners = scale.corners();
        let [[left, top], [right, bottom]] = corners;
        let heading = [("font-size", "17"), ("font-weight", "bold"), ("fill", INK)];
        svg.label([left, top - 10.0], title, &heading);
        let label = [("font-size", "13"), ("fill", FAINT), ("text-anchor", "end")];
        svg.label([right, bottom + 36.0], across, &label);
        svg.label([right, top - 10.0], format_args!("upwards: {up}"), &label);
        svg.group("clipPath", &[("id", id)]);
        svg.rectangle(corners, &[]);
        svg.end();
        let panel = Self { scale };
        panel.ticks(svg);
        svg.rectangle(corners, &[("fill", "#fbfcfd"), ("stroke", "#cbd2d9")]);
        svg.group("g", &[("clip-path", &format!("url(#{id})"))]);
        panel
    }

    /// The lines of the grid.
    pub(super) fn grid(&self, svg: &mut Svg) {
        let Scale { across, up, .. } = self.scale;
        let upright = lines(across).map(|value| [up.0, up.1].map(|up| self.scale.at(value, up)));
        let level = lines(up).map(|value| [across.0, across.1].map(|at| self.scale.at(at, value)));
        let look = [("stroke", INK), ("stroke-opacity", "0.09")];
        svg.path(&segments(upright.chain(level)), &look);
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
            let [x, y] = self.scale.at(value, up.0);
            svg.label([x, y + 17.0], value, &label("middle"));
        }
        for value in lines(up) {
            let [_, y] = self.scale.at(across.0, value);
            svg.label([left - 7.0, y + 4.0], value, &label("end"));
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
