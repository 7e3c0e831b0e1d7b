//! Page of paper in front of the arm. A drawing is centred on it, or placed as in its file if the
//! file has a page of the same size.

use magician_host::preflight::Preflight;
use magician_host::{JointAngles, Setting, SettingValue};
use magician_host::{Message, message};

use super::placed::middle_of_sheet;
use super::{Frame, POWER_UP_TOOL, Setup, Work, WorkLines, moved_within_reach};
use crate::artwork::{Marking, rotated, rounded};
use crate::raster::Engrave;
use crate::toolpath::DrawnLine;
use crate::{
    Artwork, Content, Diagnostic, DiagnosticCode, Fit, Format, Grid, Paper, Plan, Reach, Surface,
    Tool,
};

/// Largest overhang at an edge that is ignored, mm.
const OVERHANG_TOLERANCE: f64 = 0.05;
/// Largest difference of sides at which two pages count as equal, mm: files round to their own
/// units.
const SIZE_TOLERANCE: f64 = 1.0;

/// Page and its margin.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Page {
    /// Paper size.
    pub paper: Paper,
    /// Distance from the edges that fitting keeps, mm.
    pub margin: f64,
}

impl Page {
    /// Default margin, mm.
    pub const DEFAULT_MARGIN: f64 = 10.0;

    /// Page with the default margin.
    #[must_use]
    pub fn of(paper: Paper) -> Self {
        Self {
            paper,
            margin: Self::DEFAULT_MARGIN,
        }
    }

    /// Width and height inside the margin, mm; not positive if the margin leaves nothing.
    #[must_use]
    pub fn room(&self) -> [f64; 2] {
        self.paper.size().map(|side| side - 2.0 * self.margin)
    }

    /// Error if the margin leaves nothing.
    pub(crate) fn problem(&self) -> Option<Message> {
        let [width, height] = self.paper.size();
        let nothing = self.room().iter().any(|side| *side <= 0.0);
        nothing.then(|| {
            let margin = self.margin;
            message!(
                "a margin of {margin} mm leaves nothing of a page of {width} x {height} mm",
                margin,
                width,
                height
            )
        })
    }
}

/// Page at its place.
#[derive(Clone, Copy, Debug)]
pub(super) struct LaidPage {
    page: Page,
    /// Middle of the page, in the arm's x and y, mm.
    at: [f64; 2],
    /// Direction of the lower edge, degrees from the arm's X towards its Y.
    rotation: f64,
}

impl LaidPage {
    /// Corners of the page, counter-clockwise from the lower left.
    pub(super) fn corners(&self) -> [[f64; 2]; 4] {
        let half = self.page.paper.size().map(|side| side / 2.0);
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|sides| {
            let [x, y] = rotated([0, 1].map(|axis| sides[axis] * half[axis]), self.rotation);
            let rounded = |value: f64| (value * 1e4).round() / 1e4 + 0.0;
            [self.at[0] + x, self.at[1] + y].map(rounded)
        })
    }

    /// Scale that brings a plan centred on the page inside the margin and within reach.
    pub(super) fn fitting_scale(&self, plan: &Plan) -> Result<f64, Diagnostic> {
        let (_, reached) = moved_within_reach(plan.clone(), Fit::Shrink)?;
        let size = self.bounds(plan).map_or([0.0; 2], |[least, most]| {
            [0, 1].map(|axis| most[axis] - least[axis])
        });
        let shares = size.into_iter().zip(self.page.room());
        Ok(shares.fold(reached, |share, (side, room)| {
            if share * side > room {
                room / side
            } else {
                share
            }
        }))
    }

    /// Bounds of the drawn or burnt part of a plan, measured from the middle of the page along its
    /// edges. A plan that draws nothing has the bounds of its targets.
    fn bounds(&self, plan: &Plan) -> Option<[[f64; 2]; 2]> {
        let start = Preflight::at(JointAngles::HOME, POWER_UP_TOOL);
        let lines = DrawnLine::of(plan, &start);
        let drawn = lines.iter().flat_map(|line| [line.from, line.to]);
        let marks = || {
            let marks = WorkLines::of(plan, None).ok()?;
            let strokes = marks.artwork.strokes.iter();
            self.bounds_along_page(strokes.flat_map(|stroke| stroke.points.iter().copied()))
        };
        let places = || {
            let targets = plan.steps.iter().filter_map(|step| step.action.target());
            self.bounds_along_page(targets.map(|[x, y, _]| [x.into(), y.into()]))
        };
        self.bounds_along_page(drawn).or_else(marks).or_else(places)
    }

    fn bounds_along_page(&self, points: impl Iterator<Item = [f64; 2]>) -> Option<[[f64; 2]; 2]> {
        let mut points =
            points.map(|[x, y]| rotated([x - self.at[0], y - self.at[1]], -self.rotation));
        let first = points.next()?;
        Some(points.fold([first; 2], |[least, most], point| {
            [
                [0, 1].map(|axis| f64::min(least[axis], point[axis])),
                [0, 1].map(|axis| f64::max(most[axis], point[axis])),
            ]
        }))
    }

    /// Notes on the position of the page, and on content that reaches beyond the page; `grid`
    /// repeats the content.
    pub(super) fn notes(&self, plan: &Plan, grid: Option<Grid>, fit: bool) -> Vec<Diagnostic> {
        let [[x, y], ..] = self.corners();
        let [width, height] = self.page.paper.size();
        let (x, y) = (rounded(x), rounded(y));
        let what = match self.rotation {
            0.0 => message!(
                "the page is {width} x {height} mm: its lower left corner at x = {x:.1}, y = {y:.1}",
                width,
                height,
                x,
                y
            ),
            rotation => message!(
                "the page is {width} x {height} mm: its lower left corner at x = {x:.1}, y = {y:.1}, turned by {turned} degrees",
                width,
                height,
                x,
                y,
                turned = rounded(rotation)
            ),
        };
        let lies = Diagnostic::of_file(what).coded(DiagnosticCode::Placed);
        [lies]
            .into_iter()
            .chain(self.overhang(plan, grid, fit))
            .collect()
    }

    fn overhang(&self, plan: &Plan, grid: Option<Grid>, fit: bool) -> Option<Diagnostic> {
        let [mut least, mut most] = self.bounds(plan)?;
        if let Some(grid) = grid {
            let last = [
                (grid.columns.saturating_sub(1)) as f64 * grid.pitch[0],
                (grid.rows.saturating_sub(1)) as f64 * grid.pitch[1],
            ];
            // The copies at the corners of the grid bound all others, for either sign of the pitch.
            let corners = [[0.0; 2], [last[0], 0.0], [0.0, last[1]], last];
            let shifts = corners.map(|shift| rotated(shift, -self.rotation));
            let [low, high] = [least, most];
            for shift in shifts {
                for axis in [0, 1] {
                    least[axis] = least[axis].min(low[axis] + shift[axis]);
                    most[axis] = most[axis].max(high[axis] + shift[axis]);
                }
            }
        }
        let size = self.page.paper.size();
        let beyond = |axis: usize| most[axis].max(-least[axis]) - size[axis] / 2.0;
        let beyond = beyond(0).max(beyond(1));
        let margin = self.page.margin;
        let message = if beyond > OVERHANG_TOLERANCE {
            message!(
                "it reaches {by} mm beyond the edge of the page",
                by = tenths_up(beyond)
            )
        } else if -beyond < margin - OVERHANG_TOLERANCE {
            let left = rounded((-beyond).max(0.0));
            message!(
                "it comes within {left} mm of the edge of the page; the margin is {margin} mm",
                left,
                margin
            )
        } else {
            return None;
        };
        let note = Diagnostic::of_file(message).coded(DiagnosticCode::Placed);
        // With `fit` the content is fitted already, so that remedy would not help.
        Some(if fit {
            note
        } else {
            note.remedy((Setting::Fit, SettingValue::On), "shrinks it to the page")
        })
    }
}

/// Length rounded up to a tenth.
fn tenths_up(length: f64) -> f64 {
    (length * 10.0 - 1e-6).ceil() / 10.0
}

impl Setup {
    /// Returns the setup with its position on the page, and the page. Without a page the setup is
    /// unchanged.
    pub(super) fn on_page(
        &self,
        format: Format,
        content: &Content,
    ) -> Result<(Self, Option<LaidPage>), Diagnostic> {
        let mut setup = self.clone();
        let Some(page) = self
            .placement
            .page
            .filter(|_| self.placement.frame != Frame::Arm)
        else {
            return Ok((setup, None));
        };
        if let Some(problem) = page.problem() {
            return Err(Diagnostic::of_file(problem));
        }
        let rotation = self.sheet_rotation();
        let half = page.paper.size().map(|side| side / 2.0);
        let on_sheet = self.sheet.map(|sheet| {
            // If only the corner of the sheet is known, the page is aligned with that corner.
            middle_of_sheet(sheet).unwrap_or_else(|| {
                let [x, y] = rotated(half, rotation);
                [sheet.corner[0] + x, sheet.corner[1] + y]
            })
        });
        let at = match self.placement.at.or(on_sheet) {
            Some(at) => at,
            None => {
                let [width, height] = half;
                let corners = [
                    [-width, -height],
                    [width, -height],
                    [width, height],
                    [-width, height],
                ];
                let reach = self.reach_for(format, content)?;
                // A page larger than the reach is centred as well as possible: the drawing may
                // still fit.
                reach.best_place(&corners, Fit::Shrink)?.offset.map(rounded)
            }
        };
        setup.placement.at = Some(at);
        if self.has_page(content, page.paper) {
            setup.placement.keeps_page = true;
            // A turned drawing would not lie on the page.
            setup.placement.turn = false;
        }
        Ok((setup, Some(self.laid_page(page, at))))
    }

    /// True if the file has a page of this size, at its scale and rotation.
    fn has_page(&self, content: &Content, paper: Paper) -> bool {
        let Content::Artwork(Artwork {
            page: Some(page), ..
        }) = content
        else {
            return false;
        };
        // Compare as placed: scale and rotation decide if the pages coincide.
        let (sin, cos) = libm::sincos(self.placement.rotate.to_radians());
        let [width, height] = page.map(|side| side * self.placement.scale);
        let turned = [[cos, sin], [sin, cos]];
        let turned = turned.map(|[x, y]| width * x.abs() + height * y.abs());
        let sides = turned.into_iter().zip(paper.size());
        sides
            .into_iter()
            .all(|(side, of_paper)| (side - of_paper).abs() <= SIZE_TOLERANCE)
    }

    /// Page with its middle at this position.
    pub(super) fn laid_page(&self, page: Page, at: [f64; 2]) -> LaidPage {
        let rotation = self.sheet_rotation();
        LaidPage { page, at, rotation }
    }

    fn sheet_rotation(&self) -> f64 {
        self.sheet.map_or(0.0, |sheet| sheet.rotation)
    }

    /// Reach of the tool used for this content.
    fn reach_for(&self, format: Format, content: &Content) -> Result<Reach, Diagnostic> {
        let burns = Marking {
            tool: self.tool_for(Tool::Laser),
            lift: Engrave::default().lift,
            ..Marking::laser(0.0)
        };
        let marking = match content {
            Content::Plan(plan) if format == Format::Gcode => Marking {
                tool: self.tool_for(
                    if plan.steps.iter().any(|step| step.action.is_of_a_laser()) {
                        Tool::Laser
                    } else {
                        Tool::Pen
                    },
                ),
                ..self.pen
            },
            Content::Plan(plan) => {
                let [least, most] = plan.extent().unwrap_or_default();
                let tool = self.tool.or(plan.tool).or(self.default_tool);
                let tool = tool.map_or(POWER_UP_TOOL, Tool::bias);
                return Ok(Reach::new(
                    tool,
                    Surface::level(least[2]),
                    most[2] - least[2],
                ));
            }
            Content::Artwork(_) => self.marking(),
            Content::Image(_) if matches!(self.work, Work::Draw(_)) => self.marking(),
            Content::Image(_) | Content::TestGrid(_) => burns,
            #[cfg(not(magician_workspace))]
            _ => unreachable!(),
        };
        Ok(marking.reach(self.needed_surface()?))
    }
}
