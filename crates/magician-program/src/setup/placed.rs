//! Placement of a program in its own coordinates. Its drawn lines determine its size, middle and
//! height.
//!
//! Coordinates of such a program count from the program's own zero, often the corner of a machine.
//! Placing transforms its work steps as a drawing (scale, mirror, rotation, middle) and replaces
//! travel by moves that the arm can reach (`guide`).

mod guide;

use magician_host::message;
use magician_host::{Remedy, Setting, SettingValue};

use super::depths::{DepthSurvey, DepthTally, FlatProgram, kept_depths_note};
use super::work_lines::WorkLines;
use super::{Depths, LaidPlan, Setup, middle, moved_within_reach};
use crate::artwork::{Layout, Marking, Sheet, rotated};
use crate::formats::GcodeOptions;
use crate::raster::Size;
use crate::{Artwork, Content, Diagnostic, DiagnosticCode, Fit, Format, Plan, Surface, Tool, Work};
use guide::Guide;

/// Largest excess over a sheet that is ignored, mm.
pub(super) const SHEET_TOLERANCE: f64 = 1.0;

/// Coordinate system of G-code, plans, playback files and points. Drawings and images are always
/// placed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Frame {
    /// The program's own frame if the program is drawn or engraved, or if any placement option (a
    /// middle, a page, a surface, fitting) is set; otherwise the arm's frame.
    #[default]
    Default,
    /// The program's own frame: the program is placed.
    Own,
    /// The arm's frame: the program is not moved.
    Arm,
}

impl Setup {
    /// True if a file with coordinates is placed instead of using arm coordinates.
    #[must_use]
    pub fn places(&self) -> bool {
        match self.placement.frame {
            Frame::Own => true,
            Frame::Arm => false,
            Frame::Default => self.work != Work::Default || self.has_placement_option(),
        }
    }

    fn has_placement_option(&self) -> bool {
        let placement = &self.placement;
        placement.at.is_some()
            || placement.fit
            || placement.page.is_some()
            || self.surface.is_some()
    }

    /// Sets the options for reading G-code. `surface` is the surface under an unplaced program.
    pub fn set_gcode_options(&self, gcode: &mut GcodeOptions, surface: Option<Surface>) {
        gcode.lift = self.pen.lift;
        gcode.placed = self.places();
        gcode.surface = if gcode.placed {
            Some(Surface::level(0.0))
        } else {
            surface
        };
    }

    /// Refuses options about coordinates that this file does not have.
    pub(super) fn check_frame(&self, gcode: bool, drawing: bool) -> Result<(), Diagnostic> {
        let placement = &self.placement;
        let raw = Remedy::without(Setting::Raw);
        if placement.frame == Frame::Arm && drawing {
            let what = message!("a drawing or an image has no arm coordinates to keep");
            let diagnostic = Diagnostic::of_file(what).with(raw);
            let at = (Setting::At, SettingValue::Any("X,Y"));
            return Err(diagnostic.remedy(at, "sets the position of its centre"));
        }
        if placement.frame == Frame::Arm && self.has_placement_option() {
            let what =
                message!("the file's coordinates are the arm's: they cannot be placed as well");
            return Err(Diagnostic::of_file(what).with(raw));
        }
        if placement.pen_z.is_some() && !(gcode && self.places()) {
            let what = message!("a Z of the touching pen applies to placed G-code only");
            let mut diagnostic = Diagnostic::of_file(what);
            if gcode {
                diagnostic = diagnostic.remedy((Setting::Place, SettingValue::On), "places G-code");
            }
            return Err(diagnostic.with(Remedy::without(Setting::PenZ)));
        }
        Ok(())
    }

    /// Flattens placed G-code for a pen to its first depth. Returns the setup, the content, and the
    /// depth figures to report once its size is known.
    pub(super) fn flatten(
        &self,
        format: Format,
        content: Content,
        notes: &mut Vec<Diagnostic>,
    ) -> (Self, Content, Option<DepthTally>) {
        let plan = match content {
            Content::Plan(plan) => plan,
            content => return (self.clone(), content, None),
        };
        let (setup, flat) = self.flatten_program(format, &plan, notes);
        let Some(mut flat) = flat else {
            return (setup, Content::Plan(plan), None);
        };
        // Which lines count as equal depends on the size, and the size on the lines drawn: flatten
        // again at the size found.
        let sized = setup.with_size_as_scale(&Content::Plan(flat.plan.clone()));
        let scale = sized.map_or(1.0, |sized| sized.placement.scale);
        if scale != 1.0
            && let Some(there) = FlatProgram::of(&plan, self.placement.pen_z, self.pen.lift, scale)
        {
            flat = there;
        }
        (setup, Content::Plan(flat.plan), Some(flat.tally))
    }

    /// Requested scale; 1 is the true size.
    pub(super) fn scale_of(&self, format: Format, content: &Content) -> Result<f64, Diagnostic> {
        let Content::Plan(plan) = content else {
            return Ok(self.with_size_as_scale(content)?.placement.scale);
        };
        if matches!(self.size, Size::Natural | Size::Pixel(_)) {
            return Ok(self.placement.scale);
        }
        let (setup, flat) = self.flatten_program(format, plan, &mut Vec::new());
        let flat = flat.map(|flat| Content::Plan(flat.plan));
        Ok(setup
            .with_size_as_scale(flat.as_ref().unwrap_or(content))?
            .placement
            .scale)
    }

    /// Setup for a program. Also returns the program flattened at its own size, if it is placed and
    /// drawn with a pen.
    fn flatten_program(
        &self,
        format: Format,
        plan: &Plan,
        notes: &mut Vec<Diagnostic>,
    ) -> (Self, Option<FlatProgram>) {
        let mut setup = self.clone();
        let laser = || plan.steps.iter().any(|step| step.action.is_of_a_laser());
        // Only milling programs have depths: a laser burns at one height.
        if format != Format::Gcode || !self.places() || laser() {
            return (setup, None);
        }
        let pen_z = self.placement.pen_z;
        if self.depths == Depths::Keep {
            // With kept depths, the first depth is on the surface and the others are below it.
            if let Some(survey) = DepthSurvey::of(plan, pen_z) {
                setup.placement.pen_z = Some(survey.first);
                notes.extend(kept_depths_note(&survey));
            }
            return (setup, None);
        }
        let flat = FlatProgram::of(plan, pen_z, self.pen.lift, 1.0);
        if let Some(flat) = &flat {
            setup.placement.pen_z = Some(flat.touch);
        }
        (setup, flat)
    }

    /// Places G-code in its own coordinates: the lowest Z at which it draws, or the given Z, is
    /// placed on the surface.
    pub(super) fn place_program(
        &self,
        plan: Plan,
        notes: &mut Vec<Diagnostic>,
    ) -> Result<LaidPlan, Diagnostic> {
        let laser = plan.steps.iter().any(|step| step.action.is_of_a_laser());
        let tool = self.tool_for(if laser { Tool::Laser } else { Tool::Pen });
        let surface = self.needed_surface()?;
        let marks = WorkLines::of(&plan, self.placement.pen_z)?;
        let (layout, marks_size) = self.layout_for(&marks.artwork, surface)?;
        self.check_sheet(&layout, marks_size)?;
        let marking = Marking { tool, ..self.pen };
        let (placed, misfit) = marks.artwork.placed_with_misfit(&layout, &marking)?;
        let [x, y] = placed.middle;
        let what = message!(
            "it is placed: its centre at x = {x:.1}, y = {y:.1}, its Z {touch:.3} on the surface at z \
                = {middle:.1}",
            x,
            y,
            touch = marks.touch,
            middle = surface.at(placed.middle)
        );
        let note = Diagnostic::of_file(what)
            .coded(DiagnosticCode::Placed)
            .remedy(
                (Setting::Raw, SettingValue::On),
                "takes its coordinates as the arm's",
            )
            .remedy(
                (Setting::PenZ, SettingValue::Any("Z")),
                "sets another Z for the touching pen",
            );
        notes.push(note);
        let course = ProgramTransform {
            mirror: layout.mirror,
            rotate: layout.rotate,
            middle: middle_of(&marks.artwork, &layout),
            sheet: layout.sheet.map_or(0.0, |sheet| sheet.rotation),
            scale: placed.scale,
            at: placed.middle,
            touch: marks.touch,
            deepest: match self.depths {
                Depths::Flatten => 0.0,
                // Kept depths have no lower limit here; the check covers the reach.
                Depths::Keep => f64::NEG_INFINITY,
            },
        };
        let mut plan = Guide::new(plan, &course, surface, &marking).build();
        (plan.tool, plan.surface) = (Some(tool), Some(surface));
        if let Some(speed) = self.speed {
            plan.path_at(speed);
        }
        let plan = self.tidied_program(self.with_offset(plan, notes)?, notes);
        Ok(LaidPlan {
            plan: self.with_powers(plan, notes)?,
            scale: placed.scale,
            misfit,
        })
    }

    /// Layout: middle at the requested position, else on the middle of the sheet. Also returns the
    /// size of the drawing along the sheet.
    fn layout_for(
        &self,
        marks: &Artwork,
        surface: Surface,
    ) -> Result<(Layout, [f64; 2]), Diagnostic> {
        let layout = Layout {
            surface,
            at: self.placement.at.or(self.sheet.and_then(middle_of_sheet)),
            ..self.layout()?
        };
        let [least, most] = turned_bounds(marks, &layout);
        let size = [0, 1].map(|axis| most[axis] - least[axis]);
        // On a sheet the drawing must also fit its sides, not only the reach.
        let mut layout = layout;
        if layout.fit
            && let Some(room) = self.sheet_in_use().and_then(|sheet| sheet.size)
        {
            for (side, room) in size.into_iter().zip(room) {
                if side * layout.scale > room {
                    layout.scale = room / side;
                }
            }
        }
        Ok((layout, size))
    }

    /// Sheet under the drawing. `None` without a sheet, or if a position is given.
    fn sheet_in_use(&self) -> Option<Sheet> {
        self.sheet.filter(|_| self.placement.at.is_none())
    }

    fn check_sheet(&self, layout: &Layout, size: [f64; 2]) -> Result<(), Diagnostic> {
        let Some(room) = self.sheet_in_use().and_then(|sheet| sheet.size) else {
            return Ok(());
        };
        let size = size.map(|side| side * layout.scale);
        if size
            .iter()
            .zip(room)
            .all(|(side, room)| side - SHEET_TOLERANCE <= room)
        {
            return Ok(());
        }
        let shown = |[width, height]: [f64; 2]| format!("{width:.1} x {height:.1} mm");
        let message = message!(
            "it draws {size}, and the sheet is {room}",
            size = shown(size),
            room = shown(room)
        );
        Err(Diagnostic::of_file(message)
            .remedy((Setting::Fit, SettingValue::On), "shrinks it to the sheet")
            .remedy(
                (Setting::At, SettingValue::Any("X,Y")),
                "places it without one",
            ))
    }

    /// Centres a plan in arm coordinates on the sheet, or moves it within reach without one.
    pub(super) fn centre_plan(&self, plan: Plan) -> Result<Plan, Diagnostic> {
        match self.sheet.and_then(middle_of_sheet) {
            Some([x, y]) => {
                let [from_x, from_y, _] = middle(&plan);
                plan.moved([x - from_x, y - from_y, 0.0])
            }
            None => Ok(moved_within_reach(plan, Fit::TrueSize)?.0),
        }
    }
}

/// Middle of a sheet, if its size is known.
pub(super) fn middle_of_sheet(sheet: Sheet) -> Option<[f64; 2]> {
    let half = sheet.size?.map(|side| side / 2.0);
    let [x, y] = rotated(half, sheet.rotation);
    let [from_x, from_y] = sheet.corner;
    Some([from_x + x, from_y + y])
}

/// Transform from a program's coordinates to x, y and a height above the surface.
struct ProgramTransform {
    mirror: bool,
    rotate: f64,
    /// Middle of the drawn lines, mirrored and rotated.
    middle: [f64; 2],
    sheet: f64,
    scale: f64,
    at: [f64; 2],
    touch: f64,
    /// Lower limit for holes, relative to the surface.
    deepest: f64,
}

impl ProgramTransform {
    fn of(&self, [x, y, z]: [f64; 3]) -> ([f64; 2], f64) {
        let [x, y] = to_own_axes([x, y], self.mirror, self.rotate);
        let [mx, my] = self.middle;
        let way = rotated([x - mx, y - my], self.sheet);
        let at = [0, 1].map(|axis| self.at[axis] + self.scale * way[axis]);
        (at, z - self.touch)
    }
}

fn to_own_axes([x, y]: [f64; 2], mirror: bool, rotate: f64) -> [f64; 2] {
    rotated([if mirror { -x } else { x }, y], rotate)
}

/// Bounds of a drawing, mirrored and rotated.
fn turned_bounds(artwork: &Artwork, layout: &Layout) -> [[f64; 2]; 2] {
    let points = artwork.strokes.iter().flat_map(|stroke| &stroke.points);
    let points = points.map(|point| to_own_axes(*point, layout.mirror, layout.rotate));
    let none = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    points.fold(none, |[least, most], point| {
        [
            [0, 1].map(|axis| f64::min(least[axis], point[axis])),
            [0, 1].map(|axis| f64::max(most[axis], point[axis])),
        ]
    })
}

fn middle_of(artwork: &Artwork, layout: &Layout) -> [f64; 2] {
    let [least, most] = turned_bounds(artwork, layout);
    [0, 1].map(|axis| f64::midpoint(least[axis], most[axis]))
}

/// Adds an approach from above, if the first motion of a plan in arm coordinates starts at an
/// unknown position.
pub(super) fn add_entry(plan: &mut Plan, lift: f64) {
    guide::add_entry_from_above(plan, lift);
}
