//! Pictures of plans: what will be drawn, burnt or carried, and where, in true size.
//!
//! From above, X to the right and Y up, on a grid in mm, with the arm's base and what the tool can reach at the height of
//! its surface. A plan that picks and places is also shown from the side. However many steps a plan has, a picture has a
//! path for each sort of line, with as many corners as can be seen.

mod above;
mod caption;
mod layers;
mod legend;
mod marks;
mod panel;
mod png;
mod section;
mod side;
mod svg;
mod symbols;
mod track;
mod trip;
mod work;

use magician::Geometry;
use magician::words::Preflight;

use legend::Legend;
use panel::{Panel, TICKS};
pub use png::PictureError;
use svg::Svg;
use trip::Trip;

use crate::{Plan, Report};

const INK: &str = "#1f2933";
const FAINT: &str = "#66727f";
const DRAWN: &str = "#1a1a1a";
const BURNT: &str = "#4a2508";
const EMPTY: &str = "#3b7dd8";
const CARRIED: &str = "#d9530b";
const WRONG: &str = "#c4161c";
const REACH: &str = "#e9edf1";
const REACH_EDGE: &str = "#a9b5c1";
const BASE: &str = "#d5dae0";

/// Free space round the picture, and between its parts, mm.
const MARGIN: f64 = 6.0;
/// Room for title and caption, mm.
const HEAD: f64 = 16.0;
/// The narrowest picture, so that there is room for its words, mm.
const NARROWEST: f64 = 150.0;

/// What else a picture shows.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct PreviewOptions {
    /// The corners of the sheet, where it is known, in the arm's x and y, mm.
    pub sheet: Option<Vec<[f64; 2]>>,
    /// Whether there is a view from the side; if it does not say, there is one of plans that pick and place.
    pub side: Option<bool>,
}

impl PreviewOptions {
    /// Sets [`sheet`](Self::sheet).
    #[must_use]
    pub fn sheet(mut self, corners: impl Into<Vec<[f64; 2]>>) -> Self {
        self.sheet = Some(corners.into());
        self
    }

    /// Sets [`side`](Self::side).
    #[must_use]
    pub fn side(mut self, side: bool) -> Self {
        self.side = Some(side);
        self
    }
}

/// The picture of a plan.
///
/// ```
/// use magician::{JointAngles, ToolBias, words::Preflight};
/// use magician_program::preview::{Preview, PreviewOptions};
/// use magician_program::{Action, Origin, Plan, Surface, Tool, Travel, check};
///
/// let mut plan = Plan::new("a line");
/// plan.tool = Some(Tool::Pen);
/// plan.surface = Some(Surface::level(-60.0));
/// plan.push(Action::Move { to: [200.0, 0.0, -60.0, 0.0], by: Travel::Joints }, Origin::NONE);
/// plan.push(Action::Path { to: [240.0, 0.0, -60.0] }, Origin::NONE);
///
/// let start = Preflight::at(JointAngles::HOME, ToolBias::PEN);
/// let report = check(&plan, &start);
/// let preview = Preview::new(&plan, &report, &start, &PreviewOptions::default());
/// assert!(preview.to_svg().starts_with("<svg"));
/// ```
#[derive(Clone, Debug)]
pub struct Preview {
    svg: String,
}

impl Preview {
    /// The picture of a plan, of what [`check`](fn@crate::check) says of it, and of where it starts: what the check was
    /// given.
    #[must_use]
    pub fn new(plan: &Plan, report: &Report, start: &Preflight, options: &PreviewOptions) -> Self {
        let mut trip = Trip::through(plan, report, start, options.side);
        let geometry = match plan.tool {
            Some(tool) => Geometry::magician(tool.bias()),
            None => start.geometry(),
        };
        let svg = draw(plan, report, &mut trip, &geometry, options);
        Self { svg }
    }

    /// As SVG: one unit is a millimetre, and so it is printed.
    #[must_use]
    pub fn to_svg(&self) -> &str {
        &self.svg
    }

    /// As PNG, so many pixels to a millimetre: the SVG, drawn.
    ///
    /// # Errors
    /// [`PictureError`] if the scale makes no sense or the picture would be too large.
    pub fn to_png(&self, pixels_per_mm: f64) -> Result<Vec<u8>, PictureError> {
        png::drawn(&self.svg, pixels_per_mm)
    }
}

fn draw(
    plan: &Plan,
    report: &Report,
    trip: &mut Trip,
    arm: &Geometry,
    options: &PreviewOptions,
) -> String {
    let [left, top] = [MARGIN + TICKS[0], MARGIN + HEAD];
    let above = Panel {
        part: above::part(trip, options),
        corner: [left, top],
        id: "above",
    };
    let [width, height] = above.size();
    let side = trip.has_side.then(|| {
        let part = side::part(trip);
        // Beside a view that is high, below one that is wide.
        let beside = height > 0.9 * width;
        let corner = if beside {
            [left + width + MARGIN + TICKS[0], top]
        } else {
            [left, top + height + TICKS[1] + MARGIN]
        };
        Panel {
            part,
            corner,
            id: "side",
        }
    });
    let panels = [Some(above), side];
    let ends = panels.iter().flatten().map(|panel| {
        let [width, height] = panel.size();
        [panel.corner[0] + width, panel.corner[1] + height]
    });
    let [right, bottom] = ends.fold([NARROWEST, 0.0], |[right, bottom], [x, y]| {
        [right.max(x), bottom.max(y)]
    });
    let legend = Legend::new(trip, report, right - left);
    let foot = bottom + TICKS[1] + 2.0;
    let size = [right + MARGIN, foot + legend.height() + MARGIN - 2.0];

    let mut svg = Svg::new(size, &plan.title);
    caption::draw(&mut svg, [left, MARGIN], right - left, plan, report, trip);
    above::draw(&mut svg, &above, trip, options, arm);
    if let Some(side) = side {
        side::draw(&mut svg, &side, trip, arm);
    }
    legend.draw(&mut svg, [left, foot]);
    svg.finish()
}
