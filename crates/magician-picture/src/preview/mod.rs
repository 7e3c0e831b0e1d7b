//! Previews of plans: what will be drawn, burnt or carried, and where, in true size.
//!
//! The main view is from above, X to the right and Y up, on a grid in mm, with the reach of the
//! tool at the height of its surface. A small map shows where in front of the arm the view is. A
//! plan that picks and places is also shown from the side. However many steps a plan has, the
//! picture has one path per kind of line, simplified to visible detail.

mod above;
mod caption;
mod entries;
mod locator;
mod side;

use magician_host::Geometry;
use magician_host::preflight::Preflight;
use magician_motion::Fence;
use magician_program::toolpath::Toolpath;
use magician_program::{Plan, Reach, Report};

use crate::legend::Legend;
use crate::panel::{MARGIN, Panel, TICK_SPACE};
use crate::svg::Svg;

/// Space for title and caption, mm.
const HEAD_HEIGHT: f64 = 16.0;

/// Additional contents of a preview.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct PreviewOptions {
    /// Corners of the sheet in the arm's x and y, mm.
    pub sheet: Option<Vec<[f64; 2]>>,
    /// Corners of the page on the sheet in the arm's x and y, mm.
    pub page: Option<Vec<[f64; 2]>>,
    /// Fence of the arm.
    pub fence: Option<Fence>,
    /// True for a view from the side, false for none. `None` shows it for plans that pick and
    /// place.
    pub side: Option<bool>,
}

impl PreviewOptions {
    /// Sets [`sheet`](Self::sheet).
    #[must_use]
    pub fn sheet(mut self, corners: impl Into<Vec<[f64; 2]>>) -> Self {
        self.sheet = Some(corners.into());
        self
    }

    /// Sets [`page`](Self::page).
    #[must_use]
    pub fn page(mut self, corners: impl Into<Vec<[f64; 2]>>) -> Self {
        self.page = Some(corners.into());
        self
    }

    /// Sets [`fence`](Self::fence).
    #[must_use]
    pub fn fence(mut self, fence: impl Into<Option<Fence>>) -> Self {
        self.fence = fence.into();
        self
    }

    /// Sets [`side`](Self::side).
    #[must_use]
    pub fn side(mut self, side: bool) -> Self {
        self.side = Some(side);
        self
    }
}

/// Preview of a plan.
///
/// ```
/// use magician_host::{JointAngles, ToolBias, preflight::Preflight};
/// use magician_picture::{Preview, PreviewOptions};
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
    toolpath: Toolpath,
}

impl Preview {
    /// Creates the preview of a plan. `report` is the result of
    /// [`check`](fn@magician_program::check), and `start` the state that the check started from.
    #[must_use]
    pub fn new(plan: &Plan, report: &Report, start: &Preflight, options: &PreviewOptions) -> Self {
        let toolpath = Toolpath::trace(plan, report, start, options.side);
        let geometry = match plan.tool {
            Some(tool) => Geometry::magician(tool.bias()),
            None => start.geometry(),
        };
        let svg = draw(plan, report, &toolpath, &geometry, options);
        Self { svg, toolpath }
    }

    /// Iterates over the paths shown from above as polylines in the arm's x and y, mm.
    pub fn paths(&self) -> impl Iterator<Item = &[[f64; 2]]> {
        let layers = self.toolpath.layers.iter();
        layers.flat_map(|layer| layer.above.lines())
    }

    /// Returns the SVG. One unit is a millimetre, also in print.
    #[must_use]
    pub fn to_svg(&self) -> &str {
        &self.svg
    }
}

fn draw(
    plan: &Plan,
    report: &Report,
    toolpath: &Toolpath,
    arm: &Geometry,
    options: &PreviewOptions,
) -> String {
    let page = Page::of(toolpath, report, options);
    let [left, top] = page.above.corner;
    let mut svg = Svg::page(page.size, "mm", &plan.title);
    let width = page.size[0] - MARGIN - left;
    caption::draw(&mut svg, [left, MARGIN], width, plan, report, toolpath);
    let surface = toolpath.purpose.surface();
    let reach = surface.map(|surface| Reach::new(arm.tool, surface, 0.0).outline());
    let reach = reach.unwrap_or_default();
    above::draw(&mut svg, &page.above, toolpath, report, options, &reach);
    locator::draw(&mut svg, [page.locator, top], &page.above, toolpath, &reach);
    if let Some(side) = &page.side {
        side::draw(&mut svg, side, toolpath, arm);
    }
    page.legend.draw(&mut svg, [left, page.foot]);
    svg.finish()
}

/// Layout of the picture, mm.
struct Page {
    size: [f64; 2],
    above: Panel,
    side: Option<Panel>,
    /// Left edge of the locator.
    locator: f64,
    legend: Legend,
    /// Upper edge of the legend.
    foot: f64,
}

impl Page {
    fn of(toolpath: &Toolpath, report: &Report, options: &PreviewOptions) -> Self {
        let panel = |part, corner, id| Panel {
            part,
            corner,
            scale: 1.0,
            id,
        };
        let [left, top] = [MARGIN + TICK_SPACE[0], MARGIN + HEAD_HEIGHT];
        let mut above = panel(above::part(toolpath, options), [left, top], "above");
        let mut side = toolpath
            .has_side
            .then(|| panel(side::part(toolpath), [left, top], "side"));
        if let Some(side) = &mut side {
            let [width, height] = above.size();
            // Beside a tall view; below a wide one, where x is aligned with the distance from the
            // axis.
            if height > 0.9 * width {
                side.corner[0] += width + MARGIN + TICK_SPACE[0];
            } else {
                let least = above.part[0][0].min(side.part[0][0]);
                let most = above.part[1][0].max(side.part[1][0]);
                for panel in [&mut above, &mut *side] {
                    (panel.part[0][0], panel.part[1][0]) = (least, most);
                }
                side.corner[1] += height + TICK_SPACE[1] + MARGIN / 2.0;
            }
        }
        let views = [Some(above), side].into_iter().flatten();
        let ends = views.map(|view| [0, 1].map(|axis| view.corner[axis] + view.size()[axis]));
        let [right, bottom] = ends.fold(
            [left, top + locator::HEIGHT - TICK_SPACE[1]],
            |end, view| [end[0].max(view[0]), end[1].max(view[1])],
        );
        let locator = right + MARGIN;
        let right = locator + locator::width(&above);
        let legend = entries::legend(toolpath, report, options, right - left);
        let foot = bottom + TICK_SPACE[1] + 2.0;
        Self {
            size: [right + MARGIN, foot + legend.height() + MARGIN - 2.0],
            above,
            side,
            locator,
            legend,
            foot,
        }
    }
}
