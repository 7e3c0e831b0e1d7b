//! A framed area of a picture in true size, with a grid and its numbers.

use super::svg::{Anchor, Svg, Type, path};
use super::{FAINT, INK};

/// The fine grid, and the one with numbers, mm.
const FINE: f64 = 10.0;
const COARSE: f64 = 50.0;
/// Room for the numbers on the left and below, mm.
pub(super) const TICKS: [f64; 2] = [9.0, 6.0];

/// A part of a plane and where it lies in the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Panel {
    /// The least and the greatest corner of the part, mm.
    pub(super) part: [[f64; 2]; 2],
    /// Where its upper left corner lies, mm.
    pub(super) corner: [f64; 2],
    /// What it is called in the picture's own references.
    pub(super) id: &'static str,
}

impl Panel {
    /// Where a point lies in the picture.
    pub(super) fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [[left, _], [_, top]] = self.part;
        [self.corner[0] + x - left, self.corner[1] + top - y]
    }

    /// Its width and height.
    pub(super) fn size(&self) -> [f64; 2] {
        let [low, high] = self.part;
        [high[0] - low[0], high[1] - low[1]]
    }

    /// Draws the ground and begins to cut at the frame.
    pub(super) fn begin(&self, svg: &mut Svg) {
        svg.group("clipPath", &[("id", self.id)]);
        svg.rectangle(self.corners(), &[]);
        svg.end();
        let cut = format!("url(#{})", self.id);
        svg.group("g", &[("clip-path", &cut)]);
        svg.rectangle(self.corners(), &[("fill", "#fcfcfd")]);
    }

    /// Draws the lines of the grid.
    pub(super) fn grid(&self, svg: &mut Svg) {
        for (step, opacity) in [(FINE, "0.06"), (COARSE, "0.14")] {
            let mut data = String::new();
            let [low, high] = self.part;
            for x in lines(low[0], high[0], step) {
                let ends = [low[1], high[1]].map(|y| self.at([x, y]));
                data.push_str(&path(ends, false).replacen('m', "M", 1));
            }
            for y in lines(low[1], high[1], step) {
                let ends = [low[0], high[0]].map(|x| self.at([x, y]));
                data.push_str(&path(ends, false).replacen('m', "M", 1));
            }
            let look = [
                ("stroke", "#000"),
                ("stroke-opacity", opacity),
                ("stroke-width", "0.15"),
            ];
            svg.path(&data, &look);
        }
    }

    /// Ends the cutting; draws the frame, the numbers of the grid and what they are.
    pub(super) fn end(&self, svg: &mut Svg, across: &str, up: &str) {
        svg.end();
        let look = [("fill", "none"), ("stroke", FAINT), ("stroke-width", "0.2")];
        svg.rectangle(self.corners(), &look);
        let number = |anchor| Type {
            size: 2.8,
            colour: FAINT,
            bold: false,
            anchor,
            rim: false,
        };
        let [low, high] = self.part;
        for x in lines(low[0], high[0], COARSE) {
            let [x_at, y_at] = self.at([x, low[1]]);
            svg.text([x_at, y_at + 3.8], x, &number(Anchor::Middle));
        }
        for y in lines(low[1], high[1], COARSE) {
            let [x_at, y_at] = self.at([low[0], y]);
            svg.text([x_at - 1.4, y_at + 1.0], y, &number(Anchor::End));
        }
        let name = Type {
            colour: INK,
            rim: true,
            ..number(Anchor::End)
        };
        let [right, bottom] = self.at([high[0], low[1]]);
        svg.text([right - 1.5, bottom - 1.6], across, &name);
        let [left, top] = self.at([low[0], high[1]]);
        let name = Type {
            anchor: Anchor::Start,
            ..name
        };
        svg.text([left + 1.5, top + 3.6], up, &name);
    }

    fn corners(&self) -> [[f64; 2]; 2] {
        self.part.map(|corner| self.at(corner))
    }
}

/// The multiples of a step within a range, but for those right at its ends.
fn lines(low: f64, high: f64, step: f64) -> impl Iterator<Item = f64> {
    let [first, last] = [
        (low / step).floor() as i64 + 1,
        (high / step).ceil() as i64 - 1,
    ];
    // Adding 0 turns -0 into 0.
    (first..=last).map(move |line| line as f64 * step + 0.0)
}
