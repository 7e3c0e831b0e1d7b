//! Setup: makes a plan for this arm from the content of a file, with place, tool and speeds.
//!
//! Each stage depends on the earlier ones, which fixes their order. Depths are flattened first,
//! because the remaining lines determine the size. Then come the requested size, the page, tidying
//! and order of the lines, the place (with `fitting` if the size is free), the final offset, and
//! last the laser powers, which depend on the speeds. Programs in arm coordinates skip the
//! placement, but a pen is still held above its surface (`hold`).

use magician_host::build;
use magician_host::message;
use magician_host::preflight::Preflight;
use magician_host::{Action, Set, Setting, SettingValue};
use magician_motion::{ArmModel, Fence, ToolBias};

use crate::artwork::{FitFailure, Layout, Marking, Sheet, Tidy};
use crate::fill::Filling;
use crate::raster::{Adjust, Engrave, Size, Trace};
use crate::{
    Content, Diagnostic, DiagnosticCode, Fit, Format, Framing, Grid, Plan, Power, Reach,
    SheetTransform, Surface, Tool,
};

/// Tool of an arm if a plan does not set one: the default at power-up.
pub(crate) const POWER_UP_TOOL: ToolBias = ToolBias::SUCTION;

/// Options for making a plan from a file. Unset options come from the file or have a default.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Setup {
    /// Requested tool.
    pub tool: Option<Tool>,
    /// Default tool: used for files that name no tool, and for drawings and images if it can draw
    /// or burn them.
    pub default_tool: Option<Tool>,
    /// Requested surface.
    pub surface: Option<Surface>,
    /// Default surface of drawings and images.
    pub default_surface: Option<Surface>,
    /// Surface of drawings and images if none was given or measured: the table of a virtual arm. It
    /// does not limit programs in arm coordinates.
    pub assumed_surface: Option<Surface>,
    /// Sheet for drawings, if known.
    pub sheet: Option<Sheet>,
    /// Placement.
    pub placement: Placement,
    /// Marking with a pen.
    pub pen: Marking,
    /// Tidying of the lines of a drawing.
    pub tidy: Tidy,
    /// True to tidy the lines of programs as well: G-code, plans, playback, points.
    pub tidy_programs: bool,
    /// True if the lines of a drawing may be reordered to reduce travel.
    pub order: bool,
    /// Kind of work for drawings and images.
    pub work: Work,
    /// Engraving of images if the work is left to the file.
    pub engrave: Engrave,
    /// Size before scaling.
    pub size: Size,
    /// Adjustment of an image's grey levels, applied first.
    pub adjust: Adjust,
    /// Speed of the tool at work, mm/s; replaces that of the file or of the marking.
    pub speed: Option<f32>,
    /// Default speed of the laser on drawings and images, mm/s.
    pub laser_speed: Option<f64>,
    /// Filling of shapes.
    pub filling: Filling,
    /// Requested full power, for everything that burns.
    pub power: Option<Power>,
    /// Default full power.
    pub default_power: Option<Power>,
    /// Division of a drawing into parts, if requested.
    pub parts: Option<PartMode>,
    /// Parts to draw: names, colours or numbers; empty for all.
    pub only: Vec<String>,
    /// Number of passes over each part; 1 by default.
    pub passes: Option<u32>,
    /// Pens of the parts; the first that matches a part applies.
    pub pens: Vec<PartRule>,
    /// True to omit pauses for a person.
    pub no_pause: bool,
    /// Fence of the arm, which fitting respects.
    pub fence: Option<Fence>,
    /// Frame to trace instead of the marks.
    pub framing: Option<Framing>,
    /// Treatment of depths below the surface.
    pub depths: Depths,
}

mod depths;
mod drawing;
mod fitting;
mod hold;
mod image;
mod list;
mod page;
mod parts;
mod placed;
mod testgrid;
mod work_lines;

pub use depths::Depths;
use fitting::PlacedPlan;
pub(crate) use fitting::report;
pub use fitting::{AppliedPlacement, Prepared, Side};
pub(crate) use hold::hold_above;
use hold::{RaisedDepth, handles_objects};
pub use list::PartSummary;
use page::LaidPage;
pub use page::Page;
pub(crate) use parts::MAX_PASSES;
pub use parts::{PartMatch, PartMode, PartRule};
pub use placed::Frame;
pub(crate) use work_lines::WorkLines;

/// Position of the tip of `tool` for an arm in this state. `None` for `tool` means the tool in
/// force.
#[must_use]
pub fn tip(start: &Preflight, tool: Option<Tool>) -> Option<[f64; 3]> {
    let mut arm = start.clone();
    if let Some(tool) = tool {
        arm.check(&build::tool(tool.bias())).ok()?;
    }
    let pose = arm.arm()?.pose;
    Some([pose.x, pose.y, pose.z])
}

/// Kind of work for drawings and images.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Work {
    /// Draws drawings and engraves images.
    #[default]
    Default,
    /// Draws everything with a pen, images as lines.
    Draw(Trace),
    /// Burns everything, drawings along their lines at the largest power.
    Engrave(Engrave),
}

/// Placement of content.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Placement {
    /// Coordinate system of the file.
    pub frame: Frame,
    /// Z of placed G-code at which its pen touches, mm; by default the lowest at which it draws.
    pub pen_z: Option<f64>,
    /// Position of the middle of the content in x and y, mm.
    pub at: Option<[f64; 2]>,
    /// True to put the middle of the file's page there instead of the middle of the drawing.
    pub keeps_page: bool,
    /// Scale; 1 is the true size.
    pub scale: f64,
    /// Rotation to the left, degrees.
    pub rotate: f64,
    /// Page to place the content on: centred, or page on page if the file's page has the same size.
    pub page: Option<Page>,
    /// Grid of copies, applied last: the page holds all of them.
    pub grid: Option<Grid>,
    /// True to scale the content down until it is within reach and on the page.
    pub fit: bool,
    /// True if the content may be turned by 90 degrees: with `fit` to become larger, otherwise to
    /// lie in front of the arm.
    pub turn: bool,
    /// True to mirror the content left to right.
    pub mirror: bool,
    /// Final offset, mm.
    pub by: [f64; 3],
}

impl Default for Placement {
    fn default() -> Self {
        Self {
            frame: Frame::Default,
            pen_z: None,
            at: None,
            keeps_page: false,
            page: None,
            grid: None,
            scale: 1.0,
            rotate: 0.0,
            fit: false,
            turn: true,
            mirror: false,
            by: [0.0; 3],
        }
    }
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            tool: None,
            default_tool: None,
            surface: None,
            default_surface: None,
            assumed_surface: None,
            sheet: None,
            placement: Placement::default(),
            pen: Marking::pen(),
            tidy: Tidy::default(),
            tidy_programs: false,
            order: true,
            work: Work::Default,
            engrave: Engrave::default(),
            size: Size::Natural,
            adjust: Adjust::default(),
            speed: None,
            laser_speed: None,
            filling: Filling::default(),
            power: None,
            default_power: None,
            parts: None,
            only: Vec::new(),
            passes: None,
            pens: Vec::new(),
            no_pause: false,
            fence: None,
            framing: None,
            depths: Depths::default(),
        }
    }
}

impl Setup {
    /// Requested or measured surface, else the assumed one.
    #[must_use]
    pub fn known_surface(&self) -> Option<Surface> {
        self.measured_surface().or(self.assumed_surface)
    }

    /// Requested or measured surface.
    #[must_use]
    pub fn measured_surface(&self) -> Option<Surface> {
        let sheet = self.sheet.map(|sheet| sheet.surface);
        self.surface.or(sheet).or(self.default_surface)
    }

    /// Makes the plan with this scale and rotation.
    fn make_plan(&self, format: Format, content: &Content) -> Result<PlacedPlan, Diagnostic> {
        let mut notes = Vec::new();
        let drawing = !matches!(content, Content::Plan(_));
        self.check_frame(format == Format::Gcode, drawing)?;
        let LaidPlan {
            plan,
            scale,
            misfit,
        } = match content {
            Content::Plan(plan) if format == Format::Gcode && self.places() => {
                self.place_program(plan.clone(), &mut notes)?
            }
            Content::Plan(plan) => self.taught_plan(format, plan.clone(), &mut notes)?,
            Content::Artwork(artwork) => self.draw_lines(artwork, &mut notes)?,
            Content::Image(image) => match &self.work {
                Work::Engrave(engrave) => self.engrave_image(image, engrave.clone(), &mut notes)?,
                Work::Draw(trace) => self.draw_shaded(image, trace, &mut notes)?,
                Work::Default => self.engrave_image(image, self.engrave.clone(), &mut notes)?,
            },
            Content::TestGrid(grid) => self.test_grid(grid)?,
            #[cfg(not(magician_workspace))]
            _ => unreachable!(),
        };
        let mut plan = match content {
            Content::Artwork(_) => plan,
            _ => self.with_passes(plan, format == Format::Gcode)?,
        };
        if self.no_pause {
            plan.without_pauses();
        }
        let burns = plan.burns();
        if !burns && format == Format::Gcode && self.framing.is_none() {
            self.check_burns()?;
        }
        if !burns && plan.tool == Some(Tool::Laser) && matches!(self.work, Work::Draw(_)) {
            let what = message!("the laser stays dark: a drawing is done with a pen");
            let note = Diagnostic::of_file(what).coded(DiagnosticCode::Power);
            notes.push(note.remedy(Action::Engrave, "burns it"));
        }
        let other = plan
            .tool
            .filter(|tool| matches!(tool, Tool::Pen | Tool::Suction | Tool::Gripper));
        if let (true, Work::Engrave(_), Some(tool)) = (burns, &self.work, other) {
            let what = message!("the laser is lit, and the tool is said to be {tool}", tool);
            notes.push(Diagnostic::of_file(what).coded(DiagnosticCode::Power));
        }
        if self.power.is_some() && !burns {
            let what = message!("nothing burns here: the given power has no effect");
            notes.push(Diagnostic::of_file(what).coded(DiagnosticCode::Power));
        }
        notes.extend(above_ceiling(&plan));
        Ok(PlacedPlan {
            plan,
            notes,
            scale,
            misfit,
            fence: self.fence,
        })
    }

    /// Refuses a program that should burn and does not.
    fn check_burns(&self) -> Result<(), Diagnostic> {
        if !matches!(self.work, Work::Engrave(_)) {
            return Ok(());
        }
        Err(Diagnostic::of_file(message!("nothing would burn"))
            .remedy(
                (Setting::Dialect, SettingValue::Word("laser")),
                "takes it for a laser's program",
            )
            .remedy(
                (Setting::SMax, SettingValue::Any("N")),
                "does so too, with the S of full power",
            ))
    }

    /// Makes the plan of a program in arm coordinates.
    fn taught_plan(
        &self,
        format: Format,
        mut plan: Plan,
        notes: &mut Vec<Diagnostic>,
    ) -> Result<LaidPlan, Diagnostic> {
        if let Some(tool) = self.tool {
            plan.tool = Some(tool);
        } else if plan.tool.is_none() {
            plan.tool = self.default_tool;
            if format == Format::Playback && plan.tool.is_none() {
                plan.tool = Some(Tool::Suction);
                let what = message!("the file does not name its tool: the suction cup is assumed");
                let note = Diagnostic::of_file(what).coded(DiagnosticCode::Assumed);
                notes.push(note.remedy((Setting::Tool, SettingValue::Any("NAME")), "sets it"));
            }
        }
        if plan.surface.is_none() {
            plan.surface = self.surface;
        }
        if let Some(speed) = self.speed {
            plan.path_at(speed);
        }
        if format == Format::Gcode {
            placed::add_entry(&mut plan, self.pen.lift);
        }
        let (mut plan, scale) = self.transformed(plan)?;
        if let Some(surface) = self.lower_bound(format, &plan) {
            notes.extend(hold_above(&mut plan, surface)?.map(RaisedDepth::note));
            // Moving a plan down also moves the surface it names, but not the real surface.
            let first = plan.steps.iter().find_map(|step| step.action.target());
            if let (Some(named), Some([x, y, _])) = (&mut plan.surface, first) {
                let at = [x, y].map(f64::from);
                if named.at(at) < surface.at(at) {
                    *named = surface;
                }
            }
        }
        Ok(LaidPlan {
            plan: self.with_powers(self.tidied_program(plan, notes), notes)?,
            scale,
            misfit: None,
        })
    }

    /// Surface that a plan in arm coordinates must not go below, because it draws with a pen.
    pub(crate) fn lower_bound(&self, format: Format, plan: &Plan) -> Option<Surface> {
        let drawing = format.is_drawing() || self.work != Work::Default;
        let is_held =
            self.depths == Depths::Flatten && plan.draws(drawing) && !handles_objects(plan);
        self.measured_surface().filter(|_| is_held)
    }

    /// Applies the requested powers.
    fn with_powers(&self, plan: Plan, notes: &mut Vec<Diagnostic>) -> Result<Plan, Diagnostic> {
        // The arm is faster on longer lines, so powers that follow the speed are computed last.
        let plan = plan.powered_by_speed();
        notes.extend(plan.notes);
        match self.full_power() {
            Some(power) => plan.content.at_power(&power),
            None => Ok(plan.content),
        }
    }

    /// Full power, if given.
    fn full_power(&self) -> Option<Power> {
        self.power.or(self.default_power)
    }

    /// Speed of the laser, mm/s, if given.
    fn given_laser_speed(&self) -> Option<f64> {
        self.speed.map(f64::from).or(self.laser_speed)
    }

    /// Engraving with the given speed and power.
    fn with_given_speed(&self, mut engrave: Engrave) -> Engrave {
        engrave.speed = self.given_laser_speed().unwrap_or(engrave.speed);
        if let Some(power) = self.full_power() {
            engrave.power = power.range();
        }
        engrave
    }

    /// Mirrors, scales, turns about the middle, and moves to the position.
    fn transformed(&self, mut plan: Plan) -> Result<(Plan, f64), Diagnostic> {
        let Placement {
            at,
            page,
            scale,
            rotate,
            fit,
            mirror,
            by,
            ..
        } = self.placement;
        let [x, y, _] = middle(&plan);
        if mirror {
            plan = plan.mirrored(x)?;
        }
        let mut scale = scale;
        if scale != 1.0 {
            plan = plan.scaled_xy(scale, [x, y])?;
        }
        if rotate != 0.0 {
            let [x, y, _] = middle(&plan);
            plan = plan.rotated(rotate, [x, y])?;
        }
        if let Some([x, y]) = at {
            let [from_x, from_y, _] = middle(&plan);
            plan = plan.moved([x - from_x, y - from_y, 0.0])?;
        }
        if let (true, Some(page), Some(at)) = (fit, page, at) {
            let share = self.laid_page(page, at).fitting_scale(&plan)?;
            (plan, scale) = (plan.scaled_xy(share, at)?, scale * share);
        } else if fit {
            let (fitted, by) = moved_within_reach(plan, Fit::Shrink)?;
            (plan, scale) = (fitted, scale * by);
        } else if at.is_none() && self.places() {
            plan = self.centre_plan(plan)?;
        }
        if by != [0.0, 0.0, 0.0] {
            plan = plan.moved(by)?;
        }
        Ok((plan, scale))
    }

    /// Tool that draws or burns: the requested one, else the default tool if it can do the work,
    /// else the tool implied by the work. A measured bias counts as a pen.
    fn tool_for(&self, implied: Tool) -> Tool {
        let usual = self.default_tool.filter(|usual| match usual {
            Tool::Bias(_) => implied == Tool::Pen,
            named => *named == implied,
        });
        self.tool.or(usual).unwrap_or(implied)
    }

    fn marking(&self) -> Marking {
        let marking = match &self.work {
            Work::Engrave(engrave) => {
                let engrave = self.with_given_speed(engrave.clone());
                Marking {
                    tool: self.tool_for(Tool::Laser),
                    speed: engrave.speed as f32,
                    acceleration: engrave.acceleration as f32,
                    lift: engrave.lift,
                    travel: self.pen.travel,
                    ..Marking::laser(engrave.power[1] as f32)
                }
            }
            _ => Marking {
                tool: self.tool_for(self.pen.tool),
                ..self.pen
            },
        };
        Marking {
            speed: self.speed.unwrap_or(marking.speed),
            fence: self.fence,
            ..marking
        }
    }

    fn layout(&self) -> Result<Layout, Diagnostic> {
        let Placement {
            at,
            keeps_page,
            scale,
            rotate,
            page,
            fit,
            mirror,
            ..
        } = self.placement;
        let sheet = self.sheet;
        let surface = self.needed_surface()?;
        Ok(Layout {
            surface,
            scale,
            rotate,
            at,
            keeps_page,
            // If the file's layout is kept, its margins apply instead of the page's.
            room: page.filter(|_| !keeps_page).map(|page| page.room()),
            fit,
            turn: self.may_turn(),
            mirror,
            sheet: sheet.map(|sheet| Sheet { surface, ..sheet }),
        })
    }

    fn needed_surface(&self) -> Result<Surface, Diagnostic> {
        self.known_surface().ok_or_else(Diagnostic::unknown_surface)
    }

    /// Applies the final offset over the surface. A pen is not moved below it.
    fn with_offset(&self, plan: Plan, notes: &mut Vec<Diagnostic>) -> Result<Plan, Diagnostic> {
        let [x, y, mut z] = self.placement.by;
        let slope = plan.surface.map_or([0.0; 2], |surface| surface.slope);
        let burns = plan.steps.iter().any(|step| step.action.is_of_a_laser());
        if z < 0.0 && !burns && self.depths == Depths::Flatten {
            notes.push(RaisedDepth::new(-z).note());
            z = 0.0;
        }
        match [x, y, z + slope[0] * x + slope[1] * y] {
            [0.0, 0.0, 0.0] => Ok(plan),
            by => plan.moved(by),
        }
    }
}

/// Plan at its place.
struct LaidPlan {
    plan: Plan,
    /// Scale; 1 is the true size.
    scale: f64,
    /// Reason why the plan does not fit there, if known.
    misfit: Option<FitFailure>,
}

/// Middle of the drawn or burnt part of a plan in x and y, and its lowest z. A plan that draws
/// nothing is measured by its targets.
pub(crate) fn middle(plan: &Plan) -> [f64; 3] {
    let drawn = extent_of_marks(plan).or_else(|| plan.extent());
    let [least, most] = drawn.unwrap_or_default();
    let middle = |axis: usize| f64::midpoint(least[axis], most[axis]);
    [middle(0), middle(1), least[2]]
}

/// Bounds of the drawn or burnt part of a plan, if any.
pub(crate) fn extent_of_marks(plan: &Plan) -> Option<[[f64; 3]; 2]> {
    let marks = WorkLines::of(plan, None).ok()?;
    let bounds = marks.artwork.bounds()?;
    Some(bounds.map(|[x, y]| [x, y, marks.touch]))
}

/// Moves a plan within reach, and scales it down if allowed and necessary; returns the scale.
fn moved_within_reach(plan: Plan, fit: Fit) -> Result<(Plan, f64), Diagnostic> {
    let Some(SheetTransform { scale, offset }) = best_place_for_plan(&plan, fit)? else {
        return Ok((plan, 1.0));
    };
    let [x, y] = offset;
    let scaled = match scale {
        1.0 => plan,
        scale => plan.scaled_xy(scale, [0.0, 0.0])?,
    };
    Ok((scaled.moved([x, y, 0.0])?, scale))
}

/// Offset that brings a plan within reach unchanged; `None` if no offset does.
pub(crate) fn offset_within_reach(plan: &Plan) -> Option<[f64; 2]> {
    let place = best_place_for_plan(plan, Fit::TrueSize).ok()??;
    Some(place.offset)
}

/// Best place for all targets of a plan; `None` if it has none.
fn best_place_for_plan(plan: &Plan, fit: Fit) -> Result<Option<SheetTransform>, Diagnostic> {
    let Some([least, most]) = plan.extent() else {
        return Ok(None);
    };
    let tool = plan.tool.map_or(POWER_UP_TOOL, Tool::bias);
    let reach = Reach::new(tool, Surface::level(least[2]), most[2] - least[2]);
    let points: Vec<[f64; 2]> = plan
        .steps
        .iter()
        .filter_map(|step| step.action.target())
        .map(|[x, y, _]| [f64::from(x), f64::from(y)])
        .collect();
    reach.best_place(&points, fit).map(Some)
}

/// Note for paths faster than the arm's ceiling.
fn above_ceiling(plan: &Plan) -> Option<Diagnostic> {
    let speeds = plan.settings().filter_map(|setting| match setting {
        Set::CpParams(speeds) => Some(f64::from(speeds.junction_vel)),
        _ => None,
    });
    let fastest = speeds.fold(0.0, f64::max);
    let ceiling = ArmModel::MAGICIAN.ceilings.linear_velocity;
    (fastest > ceiling).then(|| {
        let what = message!(
            "speed {fastest:.0} mm/s is above the arm's ceiling: it goes at {ceiling:.0} mm/s",
            fastest,
            ceiling
        );
        Diagnostic::of_file(what).coded(DiagnosticCode::Speed)
    })
}

#[cfg(test)]
mod tests;
