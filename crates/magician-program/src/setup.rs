//! What was in a file becomes a plan for this arm: where it lies, with which tool, how fast.

use magician_host::build;
use magician_host::message;
use magician_host::preflight::Preflight;
use magician_host::{Action, Given, Set, Setting};
use magician_motion::{ArmModel, Fence, ToolBias};

use crate::artwork::{FitFailure, Layout, Marking, Sheet, Tidy};
use crate::fill::Filling;
use crate::raster::{Adjust, Engrave, Size, Trace};
use crate::{
    Content, Diagnostic, DiagnosticCode, Fit, Format, Framing, Grid, Plan, Power, Reach,
    SheetTransform, Surface, Tool,
};

/// The tool of an arm that a plan does not tell of one: what it has at power-up.
pub(crate) const UNSAID: ToolBias = ToolBias::SUCTION;

/// What a person says of how a file is to be done. What is left open is as the file says, or has a default.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Setup {
    /// The tool that was asked for.
    pub tool: Option<Tool>,
    /// The tool that is on the arm as a rule: for files that name none; for drawings and images if it can draw or burn them.
    pub default_tool: Option<Tool>,
    /// The surface that was asked for.
    pub surface: Option<Surface>,
    /// The surface that drawings and images lie on, by default.
    pub default_surface: Option<Surface>,
    /// The surface of drawings and images where none was said or measured: the table of a virtual arm. It bounds nothing
    /// that is in the arm's coordinates.
    pub assumed_surface: Option<Surface>,
    /// The sheet that drawings lie on, where it is known.
    pub sheet: Option<Sheet>,
    /// Where it goes.
    pub placement: Placement,
    /// How lines are drawn with a pen.
    pub pen: Marking,
    /// How the lines of a drawing are tidied.
    pub tidy: Tidy,
    /// Whether those of a program are as well: of G-code, a plan, playback, points.
    pub tidy_programs: bool,
    /// Whether the lines of a drawing may be taken in another order, to travel less.
    pub order: bool,
    /// What is made of drawings and images.
    pub work: Work,
    /// How images are engraved where the work is left to the file.
    pub engrave: Engrave,
    /// How large it becomes, before it is scaled.
    pub size: Size,
    /// How the greys of an image are changed first.
    pub adjust: Adjust,
    /// Speed of the tool at work, mm/s, instead of what the file or the way of working says.
    pub speed: Option<f32>,
    /// Speed of the laser on drawings and images by default, mm/s.
    pub laser_speed: Option<f64>,
    /// How filled shapes are filled.
    pub filling: Filling,
    /// The full power that was asked for, whatever burns.
    pub power: Option<Power>,
    /// Full power, by default.
    pub default_power: Option<Power>,
    /// What the parts of a drawing are, if that was said.
    pub parts: Option<PartMode>,
    /// The parts that are drawn: by name, colour or number; all of them if it is empty.
    pub only: Vec<String>,
    /// How often each part is drawn, once unless given.
    pub passes: Option<u32>,
    /// The pens of the parts; the first that is for a part counts.
    pub pens: Vec<PartRule>,
    /// Whether it never waits for a person.
    pub no_pause: bool,
    /// The fence of the arm: what is made to fit keeps to it.
    pub fence: Option<Fence>,
    /// Going round what would be marked, instead of marking it.
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
use hold::{Raised, handles};
pub use list::PartSummary;
use page::LaidPage;
pub use page::Page;
pub(crate) use parts::MOST_PASSES;
pub use parts::{PartMatch, PartMode, PartRule};
pub use placed::Frame;
pub(crate) use work_lines::WorkLines;

/// Where the tip of a tool is when an arm stands so; of the tool that the arm knows of, if none is named.
#[must_use]
pub fn tip(start: &Preflight, tool: Option<Tool>) -> Option<[f64; 3]> {
    let mut told = start.clone();
    if let Some(tool) = tool {
        told.check(&build::tool(tool.bias())).ok()?;
    }
    let pose = told.arm()?.pose;
    Some([pose.x, pose.y, pose.z])
}

/// What is made of drawings and images.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Work {
    /// Drawings are drawn, images engraved.
    #[default]
    Default,
    /// All is drawn with a pen, images as lines.
    Draw(Trace),
    /// All is burnt, drawings along their lines with the most power.
    Engrave(Engrave),
}

/// Where something goes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Placement {
    /// Whose coordinates those of the file are.
    pub frame: Frame,
    /// The Z of placed G-code at which its pen touches, mm; the lowest at which it draws, if not said.
    pub pen_z: Option<f64>,
    /// Its middle goes to this x and y, mm.
    pub at: Option<[f64; 2]>,
    /// True if the middle of the file's page goes there, and not that of what it draws.
    pub keeps_page: bool,
    /// Its size, 1 being the true one.
    pub scale: f64,
    /// Turned to the left, degrees.
    pub rotate: f64,
    /// The page that it lies on: its middle on the middle of the page, or the file's page on it if both have the same size.
    pub page: Option<Page>,
    /// Where it is repeated afterwards: what is said of the page is said of all of it.
    pub grid: Option<Grid>,
    /// Made smaller until it can be reached, and lies on the page.
    pub fit: bool,
    /// True if it may be turned by 90 degrees: what is made to fit where that lets it be larger, anything else where that lets
    /// it lie in front of the arm.
    pub turn: bool,
    /// Mirrored, left to right.
    pub mirror: bool,
    /// Moved on from there, mm.
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
    /// The surface that was said or measured, else the assumed one.
    #[must_use]
    pub fn known_surface(&self) -> Option<Surface> {
        self.measured_surface().or(self.assumed_surface)
    }

    /// The surface that was said or measured.
    #[must_use]
    pub fn measured_surface(&self) -> Option<Surface> {
        let sheet = self.sheet.map(|sheet| sheet.surface);
        self.surface.or(sheet).or(self.default_surface)
    }

    /// As it is laid with this scale and turn.
    fn made(&self, format: Format, content: &Content) -> Result<PlacedPlan, Diagnostic> {
        let mut notes = Vec::new();
        let drawing = !matches!(content, Content::Plan(_));
        self.check_frame(format == Format::Gcode, drawing)?;
        let Laid {
            plan,
            scale,
            misfit,
        } = match content {
            Content::Plan(plan) if format == Format::Gcode && self.places() => {
                self.laid(plan.clone(), &mut notes)?
            }
            Content::Plan(plan) => self.taught(format, plan.clone(), &mut notes)?,
            Content::Artwork(artwork) => self.drawn(artwork, &mut notes)?,
            Content::Image(image) => match &self.work {
                Work::Engrave(engrave) => self.engraved(image, engrave.clone(), &mut notes)?,
                Work::Draw(trace) => self.shaded(image, trace, &mut notes)?,
                Work::Default => self.engraved(image, self.engrave.clone(), &mut notes)?,
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

    /// Refuses a program that was to burn and does not.
    fn check_burns(&self) -> Result<(), Diagnostic> {
        if !matches!(self.work, Work::Engrave(_)) {
            return Ok(());
        }
        Err(Diagnostic::of_file(message!("nothing would burn"))
            .remedy(
                (Setting::Dialect, Given::Word("laser")),
                "takes it for a laser's program",
            )
            .remedy(
                (Setting::SMax, Given::Any("N")),
                "does so too, with the S of full power",
            ))
    }

    /// A plan that is in the arm's coordinates already.
    fn taught(
        &self,
        format: Format,
        mut plan: Plan,
        notes: &mut Vec<Diagnostic>,
    ) -> Result<Laid, Diagnostic> {
        if let Some(tool) = self.tool {
            plan.tool = Some(tool);
        } else if plan.tool.is_none() {
            plan.tool = self.default_tool;
            if format == Format::Playback && plan.tool.is_none() {
                plan.tool = Some(Tool::Suction);
                let what = message!("the file does not name its tool: the suction cup is assumed");
                let note = Diagnostic::of_file(what).coded(DiagnosticCode::Assumed);
                notes.push(note.remedy((Setting::Tool, Given::Any("NAME")), "sets it"));
            }
        }
        if plan.surface.is_none() {
            plan.surface = self.surface;
        }
        if let Some(speed) = self.speed {
            plan.path_at(speed);
        }
        if format == Format::Gcode {
            placed::raised(&mut plan, self.pen.lift);
        }
        let (mut plan, scale) = self.placed(plan)?;
        if let Some(surface) = self.bound_of(format, &plan) {
            notes.extend(hold_above(&mut plan, surface)?.map(Raised::note));
            // Moved down, a plan takes the surface that it names along; the real one stays where it is.
            let first = plan.steps.iter().find_map(|step| step.action.target());
            if let (Some(named), Some([x, y, _])) = (&mut plan.surface, first) {
                let at = [x, y].map(f64::from);
                if named.at(at) < surface.at(at) {
                    *named = surface;
                }
            }
        }
        Ok(Laid {
            plan: self.powered(self.tidied_program(plan, notes), notes)?,
            scale,
            misfit: None,
        })
    }

    /// The surface that a plan in the arm's coordinates never goes below, because a pen draws it.
    pub(crate) fn bound_of(&self, format: Format, plan: &Plan) -> Option<Surface> {
        let drawing = format.is_drawing() || self.work != Work::Default;
        let is_held = self.depths == Depths::Flatten && plan.draws(drawing) && !handles(plan);
        self.measured_surface().filter(|_| is_held)
    }

    /// With the powers that are wanted.
    fn powered(&self, plan: Plan, notes: &mut Vec<Diagnostic>) -> Result<Plan, Diagnostic> {
        // The arm is faster on longer lines: the powers that follow the speed come last.
        let plan = plan.powered_by_speed();
        notes.extend(plan.notes);
        match self.full_power() {
            Some(power) => plan.content.at_power(&power),
            None => Ok(plan.content),
        }
    }

    /// Full power, as far as anybody has said it.
    fn full_power(&self) -> Option<Power> {
        self.power.or(self.default_power)
    }

    /// Speed of the laser, mm/s, if anybody has said it.
    fn said_laser_speed(&self) -> Option<f64> {
        self.speed.map(f64::from).or(self.laser_speed)
    }

    /// How an image is engraved, and how fast a drawing is burnt.
    fn engraving(&self, mut engrave: Engrave) -> Engrave {
        engrave.speed = self.said_laser_speed().unwrap_or(engrave.speed);
        if let Some(power) = self.full_power() {
            engrave.power = power.range();
        }
        engrave
    }

    /// Mirrored, scaled, turned about the middle, brought where it belongs.
    fn placed(&self, mut plan: Plan) -> Result<(Plan, f64), Diagnostic> {
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
            let share = self.laid_page(page, at).share_of(&plan)?;
            (plan, scale) = (plan.scaled_xy(share, at)?, scale * share);
        } else if fit {
            let (fitted, by) = fitted(plan, Fit::Shrink)?;
            (plan, scale) = (fitted, scale * by);
        } else if at.is_none() && self.places() {
            plan = self.centred(plan)?;
        }
        if by != [0.0, 0.0, 0.0] {
            plan = plan.moved(by)?;
        }
        Ok((plan, scale))
    }

    /// The tool that draws or burns: the one that was asked for, else the usual one if it can do that, else what the work
    /// implies. A bias that was measured is that of a pen.
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
                let engrave = self.engraving(engrave.clone());
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
            // The margins of a layout that is kept are the file's.
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

    /// Moved on over its surface, and above it; a pen never below.
    fn pushed(&self, plan: Plan, notes: &mut Vec<Diagnostic>) -> Result<Plan, Diagnostic> {
        let [x, y, mut z] = self.placement.by;
        let slope = plan.surface.map_or([0.0; 2], |surface| surface.slope);
        let burns = plan.steps.iter().any(|step| step.action.is_of_a_laser());
        if z < 0.0 && !burns && self.depths == Depths::Flatten {
            notes.push(Raised::new(-z).note());
            z = 0.0;
        }
        match [x, y, z + slope[0] * x + slope[1] * y] {
            [0.0, 0.0, 0.0] => Ok(plan),
            by => plan.moved(by),
        }
    }
}

/// A plan as it lies.
struct Laid {
    plan: Plan,
    /// Its size, 1 being the true one.
    scale: f64,
    /// Why it does not fit there, if that is known.
    misfit: Option<FitFailure>,
}

/// Where the middle of what a plan draws or burns is, and its lowest point; of all the places to which it leads, if it draws
/// nothing.
pub(crate) fn middle(plan: &Plan) -> [f64; 3] {
    let drawn = extent_of_marks(plan).or_else(|| plan.extent());
    let [least, most] = drawn.unwrap_or_default();
    let middle = |axis: usize| f64::midpoint(least[axis], most[axis]);
    [middle(0), middle(1), least[2]]
}

/// The least and the greatest x, y, z of what a plan draws or burns, if it does.
pub(crate) fn extent_of_marks(plan: &Plan) -> Option<[[f64; 3]; 2]> {
    let marks = WorkLines::of(plan, None).ok()?;
    let bounds = marks.artwork.bounds()?;
    Some(bounds.map(|[x, y]| [x, y, marks.touch]))
}

/// Brought where all of it is reached, and made smaller if that is wanted and need be: how much.
fn fitted(plan: Plan, fit: Fit) -> Result<(Plan, f64), Diagnostic> {
    let Some(SheetTransform { scale, offset }) = place_of(&plan, fit)? else {
        return Ok((plan, 1.0));
    };
    let [x, y] = offset;
    let scaled = match scale {
        1.0 => plan,
        scale => plan.scaled_xy(scale, [0.0, 0.0])?,
    };
    Ok((scaled.moved([x, y, 0.0])?, scale))
}

/// By how much a plan would have to be moved for all of it to be reached as it is.
pub(crate) fn offset_within_reach(plan: &Plan) -> Option<[f64; 2]> {
    let place = place_of(plan, Fit::TrueSize).ok()??;
    Some(place.offset)
}

/// The best place for all the places to which a plan leads; none if it leads nowhere.
fn place_of(plan: &Plan, fit: Fit) -> Result<Option<SheetTransform>, Diagnostic> {
    let Some([least, most]) = plan.extent() else {
        return Ok(None);
    };
    let tool = plan.tool.map_or(UNSAID, Tool::bias);
    let reach = Reach::new(tool, Surface::level(least[2]), most[2] - least[2]);
    let points: Vec<[f64; 2]> = plan
        .steps
        .iter()
        .filter_map(|step| step.action.target())
        .map(|[x, y, _]| [f64::from(x), f64::from(y)])
        .collect();
    reach.best_place(&points, fit).map(Some)
}

/// Paths that are to be drawn faster than the arm goes.
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
