//! Panels: framed areas of a picture in true size, with a grid and its labels.

use crate::svg::palette::{FAINT, INK};
use crate::svg::{Anchor, Svg, TextStyle, segments, signed};

/// Spacing of the fine grid, mm.
const FINE_GRID: f64 = 10.0;
/// Spacing of the labelled grid, mm.
const LABELLED_GRID: f64 = 50.0;
/// Spacing of the labelled grid in a small view, mm.
const SMALL_VIEW_GRID: f64 = 20.0;
/// Largest size of a small view, mm.
const SMALL_VIEW: f64 = 160.0;
/// Margin around a picture and between its parts, mm.
pub(super) const MARGIN: f64 = 6.0;
/// Space for labels on the left and below, mm.
pub(super) const TICK_SPACE: [f64; 2] = [9.0, 6.0];

/// A part of a plane, and its position in the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Panel {
    /// Part of the plane: smallest and largest corner, mm.
    pub(super) part: [[f64; 2]; 2],
    /// Position of its upper left corner in the picture, mm.
    pub(super) corner: [f64; 2],
    /// Scale, 1 being true size.
    pub(super) scale: f64,
    /// Id for references within the picture.
    pub(super) id: &'static str,
}

impl Panel {
    /// Maps a point to the picture.
    pub(super) fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [[left, _], [_, top]] = self.part;
        let [right, down] = [x - left, top - y].map(|way| way * self.scale);
        [self.corner[0] + right, self.corner[1] + down]
    }

    /// Width and height in the picture.
    pub(super) fn size(&self) -> [f64; 2] {
        let [low, high] = self.part;
        [0, 1].map(|axis| (high[axis] - low[axis]) * self.scale)
    }

    /// Draws the background and starts clipping to the frame.
    pub(super) fn begin(&self, svg: &mut Svg) {
        svg.group("clipPath", &[("id", self.id)]);
        svg.rectangle(self.corners(), &[]);
        svg.end();
        let cut = format!("url(#{})", self.id);
        svg.group("g", &[("clip-path", &cut)]);
        svg.rectangle(self.corners(), &[("fill", "#fcfcfd")]);
    }

    /// Draws the grid.
    pub(super) fn grid(&self, svg: &mut Svg) {
        for (step, opacity) in [(FINE_GRID, "0.06"), (self.grid_spacing(), "0.14")] {
            let [low, high] = self.part;
            let upright = multiples(low[0], high[0], step).map(|x| [[x, low[1]], [x, high[1]]]);
            let level = multiples(low[1], high[1], step).map(|y| [[low[0], y], [high[0], y]]);
            let all = upright.chain(level);
            let data = segments(all.map(|ends| ends.map(|end| self.at(end))));
            let look = [
                ("stroke", "#000"),
                ("stroke-opacity", opacity),
                ("stroke-width", "0.15"),
            ];
            svg.path(&data, &look);
        }
    }

    /// Ends the clipping and draws the frame.
    pub(super) fn end(&self, svg: &mut Svg) {
        svg.end();
        let look = [("fill", "none"), ("stroke", FAINT), ("stroke-width", "0.2")];
        svg.rectangle(self.corners(), &look);
    }

    /// Draws the labels of the grid and of the axes.
    pub(super) fn draw_labels(&self, svg: &mut Svg, across: &str, up: &str) {
        let number = |anchor| TextStyle {
            size: 2.8,
            colour: FAINT,
            anchor,
            rim: false,
        };
        let [low, high] = self.part;
        for x in multiples(low[0], high[0], self.grid_spacing()) {
            let [x_at, y_at] = self.at([x, low[1]]);
            svg.text([x_at, y_at + 3.8], signed(x), &number(Anchor::Middle));
        }
        for y in multiples(low[1], high[1], self.grid_spacing()) {
            let [x_at, y_at] = self.at([low[0], y]);
            svg.text([x_at - 1.4, y_at + 1.0], signed(y), &number(Anchor::End));
        }
        let name = TextStyle {
            colour: INK,
            rim: true,
            ..number(Anchor::End)
        };
        let [right, bottom] = self.at([high[0], low[1]]);
        svg.text([right - 1.5, bottom - 1.6], across, &name);
        let [left, top] = self.at([low[0], high[1]]);
        let name = TextStyle {
            anchor: Anchor::Start,
            ..name
        };
        svg.text([left + 1.5, top + 3.6], up, &name);
    }

    fn grid_spacing(&self) -> f64 {
        let [low, high] = self.part;
        if (high[0] - low[0]).max(high[1] - low[1]) > SMALL_VIEW {
            LABELLED_GRID
        } else {
            SMALL_VIEW_GRID
        }
    }

    fn corners(&self) -> [[f64; 2]; 2] {
        self.part.map(|corner| self.at(corner))
    }
}

/// Extent of what a view must show.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Extent(Option<[[f64; 2]; 2]>);

impl Extent {
    /// Margin around it, mm.
    const MARGIN: f64 = 12.0;
    /// Smallest width and height of a view, mm.
    const MIN_SIZE: [f64; 2] = [90.0, 70.0];
    /// Largest distance from the base that a view covers, mm. It keeps the picture small if a step
    /// is far out of reach.
    const MAX_DISTANCE: f64 = 420.0;

    pub(super) fn show(&mut self, point: [f64; 2]) {
        let [low, high] = self.0.get_or_insert([point, point]);
        for axis in 0..2 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
    }

    /// Returns the part of the plane that shows it, rounded to the fine grid.
    pub(super) fn part(self) -> [[f64; 2]; 2] {
        let [mut low, mut high] = self.0.unwrap_or([[200.0, 0.0]; 2]);
        for axis in 0..2 {
            let missing = Self::MIN_SIZE[axis] - (high[axis] - low[axis] + 2.0 * Self::MARGIN);
            let room = Self::MARGIN + missing.max(0.0) / 2.0;
            let fit =
                |value: f64| (value * FINE_GRID).clamp(-Self::MAX_DISTANCE, Self::MAX_DISTANCE);
            low[axis] = fit(((low[axis] - room) / FINE_GRID).floor());
            high[axis] = fit(((high[axis] + room) / FINE_GRID).ceil()).max(low[axis] + FINE_GRID);
        }
        [low, high]
    }
}

/// Iterates over the multiples of a step strictly within a range.
fn multiples(low: f64, high: f64, step: f64) -> impl Iterator<Item = f64> {
    let [first, last] = [
        (low / step).floor() as i64 + 1,
        (high / step).ceil() as i64 - 1,
    ];
    // Adding 0 turns -0 into 0.
    (first..=last).map(move |line| line as f64 * step + 0.0)
}
