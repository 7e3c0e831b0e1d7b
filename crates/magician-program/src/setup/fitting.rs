//! Fitting: makes a drawing as large as possible, turned if that helps, so that it passes the
//! check.
//!
//! Lines alone give an upper bound for the size. The full check also covers travel between lines,
//! arcs and turns of the tool, which may leave the reach; then the plan is reduced in steps of
//! [`SHRINK_FACTOR`] until it passes, or fitting gives up.

use std::fmt;

use magician_host::message;
use magician_host::preflight::{Guards, Preflight};
use magician_host::{JointAngles, Setting, SettingValue};
use magician_motion::Fence;
use serde::Serialize;

use super::{Frame, LaidPage, POWER_UP_TOOL, Placement, Setup, extent_of_marks, middle};
use crate::artwork::{FitFailure, WouldFit};
use crate::check::check;
use crate::{Content, Diagnostic, DiagnosticCode, Format, Plan, Report};

/// Factor by which a plan that fails the check is reduced each time.
const SHRINK_FACTOR: f64 = 0.98;
/// Smallest share of the size given by the lines alone; below it fitting gives up.
const MIN_SHRUNK_SHARE: f64 = 0.5;
/// Smallest gain in size for which a drawing is turned.
const MIN_TURN_GAIN: f64 = 1.001;
/// Smallest gain in size for which a place beside the arm is preferred to one in front.
const MIN_SIDE_GAIN: f64 = 1.01;
/// Largest distance from the line straight ahead of the arm at which a drawing counts as in front,
/// mm.
const FRONT_TOLERANCE: f64 = 0.1;
/// Share from which on a scale counts as 1.
const FULL_SCALE: f64 = 1.0 - 1e-6;
/// Scale below which a drawing is probably not what the user wants.
const TINY_SCALE: f64 = 0.1;

/// Plan for this arm made from a file.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Prepared {
    /// The plan.
    pub plan: Plan,
    /// Notes on omissions and assumptions.
    pub notes: Vec<Diagnostic>,
    /// Applied placement. `None` if the plan was not placed.
    pub placed: Option<AppliedPlacement>,
    /// Reason why the check will refuse the plan at its place, if known before the check.
    pub misfit: Option<Diagnostic>,
    /// Size and rotation in which the plan would fit at its place. `None` if the plan fits already,
    /// or fits in no size.
    pub would_fit: Option<WouldFit>,
}

/// Placement that was applied.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct AppliedPlacement {
    /// Scale; 1 is the true size.
    pub scale: f64,
    /// Rotation, degrees counter-clockwise.
    pub turn: f64,
    /// Middle of the drawn or burnt part, in the arm's x and y, mm.
    pub at: [f64; 2],
    /// Corners of the page, if one was requested, in the arm's x and y, mm: counter-clockwise from
    /// the lower left.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub page: Option<[[f64; 2]; 4]>,
    /// Side of the arm on which the drawing lies, if fitting chose the place and the drawing does
    /// not fit in front of the arm. A note reports this.
    #[serde(skip)]
    pub beside: Option<Side>,
}

/// Side of the arm, looking along its x axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Side {
    /// The side of positive y.
    Left,
    /// The side of negative y.
    Right,
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Left => "left",
            Self::Right => "right",
        })
    }
}

impl Prepared {
    /// Returns the plan if it fits at its place.
    ///
    /// # Errors
    /// The reason why the plan does not fit.
    pub fn fitting(self) -> Result<Self, Diagnostic> {
        match self.misfit {
            Some(misfit) => Err(misfit),
            None => Ok(self),
        }
    }
}

impl AppliedPlacement {
    /// True if the drawing was reduced to a size at which the user should be asked.
    ///
    /// ```
    /// # use magician_program::{Content, Format, Plan, Setup};
    /// let prepared = Setup::default().plan(Format::Plan, Content::Plan(Plan::new("empty")))?;
    /// assert!(!prepared.placed.is_some_and(|position| position.is_tiny()));
    /// # Ok::<(), magician_program::Diagnostic>(())
    /// ```
    #[must_use]
    pub fn is_tiny(&self) -> bool {
        self.scale < TINY_SCALE
    }
}

/// Plan at one size and rotation.
pub(super) struct PlacedPlan {
    pub(super) plan: Plan,
    pub(super) notes: Vec<Diagnostic>,
    /// Scale; 1 is the true size.
    pub(super) scale: f64,
    pub(super) misfit: Option<FitFailure>,
    /// Fence that the plan keeps to.
    pub(super) fence: Option<Fence>,
}

/// Largest plan that passes the check, or the first plan tried if none passes.
struct ShrinkResult {
    made: PlacedPlan,
    passes: bool,
}

impl PlacedPlan {
    fn report(&self) -> Report {
        report(&self.plan, self.fence)
    }

    /// True if the arm can carry out the whole plan.
    fn passes(&self) -> bool {
        self.misfit.is_none() && self.report().is_good()
    }

    /// Adds the reason why the arm cannot carry out the plan at any size.
    fn with_misfit(self) -> Self {
        let report = self.report();
        let why = report.refused_steps.first().map(|refused_step| FitFailure {
            diagnostic: Diagnostic::from(refused_step),
            would_fit: None,
        });
        Self {
            misfit: self.misfit.or(why),
            ..self
        }
    }
}

/// Report of the check of a plan from the home pose, with the guards of reach and fence alone.
pub(crate) fn report(plan: &Plan, fence: Option<Fence>) -> Report {
    let start = Preflight::at(JointAngles::HOME, POWER_UP_TOOL)
        .on_rail(0.0)
        .guards(Guards::NONE.reach(true));
    // The speed does not depend on the size, so the fence's speed limit is ignored here.
    let fence = fence.map(|fence| fence.in_space()).unwrap_or_default();
    check(plan, &start.fence(fence))
}

impl Setup {
    /// Makes a plan from the content of a file of this format.
    ///
    /// A fitted plan passes the check if it does so at any size: it is reduced as long as travel
    /// between lines, arcs or turns of the tool leave the reach. A plan that cannot be moved stays
    /// at its place.
    ///
    /// # Errors
    /// [`Diagnostic`] if the content is empty, no place is within reach, or the needed surface is
    /// unknown. A drawing that does not fit is not an error: [`misfit`](Prepared::misfit) holds the
    /// reason, so that the plan can still be previewed.
    pub fn plan(&self, format: Format, content: Content) -> Result<Prepared, Diagnostic> {
        let mut content = self.with_adequate_curves(format, content)?;
        let file = content.take_curves();
        let prepared = self.prepared(format, content)?;
        // After a large reduction the arm would see an arc as a point.
        let scale = prepared.placed.map_or(1.0, |placed| placed.scale);
        match file.filter(|file| scale > 0.0 && file.is_unfit_for(scale)) {
            Some(file) if self.placement.fit => self.prepared(format, file.read(scale)?),
            // Otherwise the size is the requested one, for which the curves were read.
            _ => Ok(prepared),
        }
    }

    /// Makes the plan. The curves of the content are already approximated closely enough.
    fn prepared(&self, format: Format, content: Content) -> Result<Prepared, Diagnostic> {
        let mut depth_notes = Vec::new();
        // Depths first: the remaining lines determine size and place.
        let (setup, content, depths) = self.flatten(format, content, &mut depth_notes);
        let sized = setup.with_size_as_scale(&content)?;
        // A requested width or height is a scale too; the option `scale` multiplies it.
        let size = sized.placement.scale / setup.placement.scale;
        let (setup, page) = sized.on_page(format, &content)?;
        let (content, reordered) = setup.prepare_lines(content)?;
        // A selection of parts is placed as it would be together with all parts.
        let whole = with_all_parts(&content);
        let (mut made, turned) = {
            let content = whole.as_ref().unwrap_or(&content);
            if setup.placement.fit {
                setup.make_fitting(format, content)?
            } else {
                setup.make_in_front(format, content)?
            }
        };
        let placed = setup.places() || !matches!(content, Content::Plan(_));
        let at = placed.then(|| middle(&made.plan));
        let lies = setup
            .chooses_place(&content)
            .then(|| setup.location(&made.plan));
        let beside = lies.flatten().filter(|lies| lies.side.is_some());
        let beside = beside.filter(|_| made.misfit.is_none());
        if whole.is_some() {
            let mut there = setup.turned(turned);
            there.placement.scale = made.scale;
            there.placement.fit = false;
            made = there.make_plan(format, &content)?;
            if made.report().is_good() {
                made.misfit = None;
            }
        }
        // Freed before the copies below, to limit the memory for large drawings.
        drop(whole);
        let PlacedPlan {
            plan,
            notes: laid,
            scale,
            misfit,
            ..
        } = made;
        let mut notes: Vec<_> = reordered.into_iter().collect();
        let fitted = self.placement.fit.then_some(scale / setup.placement.scale);
        notes.extend(turned_note(format, fitted, turned));
        notes.extend(beside.map(|beside| beside.note(format)));
        notes.extend(laid);
        notes.extend(depth_notes);
        notes.extend(depths.iter().flat_map(|depths| depths.notes(scale)));
        if let Some(page) = &page {
            notes.extend(page.notes(&plan, self.placement.grid, self.placement.fit));
        }
        // Freed here, because a large drawing is in memory twice by now.
        drop(content);
        let placed = at.map(|[x, y, _]| {
            let rounded = |value: f64| (value * 1e4).round() / 1e4;
            AppliedPlacement {
                // Rounded down so that the value can be given again and still fits; the small
                // addition keeps a true size at 1.
                scale: ((scale + 1e-9) * 1e4).floor() / 1e4,
                turn: self.placement.rotate + turned,
                at: [x, y].map(rounded),
                page: page.as_ref().map(LaidPage::corners),
                beside: beside.and_then(|beside| beside.side),
            }
        });
        let misfit = misfit.map(|misfit| misfit.scaled(1.0 / size));
        let would_fit = misfit.as_ref().and_then(|misfit| misfit.would_fit);
        let plan = match self.framing {
            Some(framing) => {
                let (frame, round) = framing.plan(plan, &self.pen, self.fence)?;
                // The order of the marks does not matter for a frame.
                notes.retain(|note| note.code != DiagnosticCode::Reordered);
                notes.extend(round);
                frame
            }
            None => plan,
        };
        Ok(Prepared {
            plan,
            notes,
            placed,
            misfit: misfit.map(|misfit| misfit.diagnostic),
            would_fit,
        })
    }

    /// Makes the drawing as large as possible; returns the plan and its rotation.
    fn make_fitting(
        &self,
        format: Format,
        content: &Content,
    ) -> Result<(PlacedPlan, f64), Diagnostic> {
        let straight = self.shrink_to_pass(format, content);
        let passing = straight.as_ref().ok().filter(|straight| straight.passes);
        let in_front = |made: &PlacedPlan| !self.chooses_place(content) || self.is_in_front(made);
        let scale = passing.map_or(0.0, |straight| straight.made.scale);
        let ahead = passing.is_some_and(|straight| in_front(&straight.made));
        if self.placement.turn
            && (scale < FULL_SCALE * self.placement.scale || !ahead)
            && let Ok(turned) = self.turned(90.0).shrink_to_pass(format, content)
            && turned.passes
        {
            let least = match (ahead, in_front(&turned.made)) {
                // A place in front is worth a slightly smaller drawing.
                (true, false) => MIN_SIDE_GAIN * scale,
                (false, true) => scale / MIN_SIDE_GAIN,
                _ => MIN_TURN_GAIN * scale,
            };
            if turned.made.scale > least {
                return Ok((turned.made, 90.0));
            }
        }
        let ShrinkResult { made, passes } = straight?;
        // Plans and points may be within reach in their own arm coordinates; G-code has its own
        // zero.
        let stays = matches!(content, Content::Plan(_)) && format != Format::Gcode;
        let made = if passes {
            made
        } else {
            let there = stays.then(|| self.at_own_place(format, content)).flatten();
            there.unwrap_or_else(|| made.with_misfit())
        };
        Ok((made, 0.0))
    }

    /// Places the drawing at its size, turned by 90 degrees if it lies in front of the arm only
    /// then; returns the plan and its rotation.
    fn make_in_front(
        &self,
        format: Format,
        content: &Content,
    ) -> Result<(PlacedPlan, f64), Diagnostic> {
        let straight = self.make_plan(format, content);
        let fits = |made: &Result<PlacedPlan, Diagnostic>| {
            made.as_ref().is_ok_and(|made| made.misfit.is_none())
        };
        let in_front = |made: &Result<PlacedPlan, Diagnostic>| {
            made.as_ref().is_ok_and(|made| self.is_in_front(made))
        };
        if !self.may_turn()
            || !self.chooses_place(content)
            || fits(&straight) && in_front(&straight)
        {
            return Ok((straight?, 0.0));
        }
        let turned = self.turned(90.0).make_plan(format, content);
        if fits(&turned) && (in_front(&turned) || !fits(&straight)) {
            Ok((turned?, 90.0))
        } else {
            Ok((straight?, 0.0))
        }
    }

    /// True if fitting chooses the place: no position, sheet or page was given.
    fn chooses_place(&self, content: &Content) -> bool {
        let is_placed = self.places() || !matches!(content, Content::Plan(_));
        is_placed && self.placement.at.is_none() && self.sheet.is_none()
    }

    /// True if the drawing may be turned without resizing. A given rotation is kept.
    pub(super) fn may_turn(&self) -> bool {
        self.placement.turn && self.placement.rotate == 0.0
    }

    fn is_in_front(&self, made: &PlacedPlan) -> bool {
        self.location(&made.plan)
            .is_none_or(|lies| lies.side.is_none())
    }

    /// Bounds and side of a plan, before the final offset.
    fn location(&self, plan: &Plan) -> Option<Location> {
        let [least, most] = extent_of_marks(plan).or_else(|| plan.extent())?;
        let [_, moved, _] = self.placement.by;
        let side = match (least[1] - moved, most[1] - moved) {
            (least, _) if least > FRONT_TOLERANCE => Some(Side::Left),
            (_, most) if most < -FRONT_TOLERANCE => Some(Side::Right),
            _ => None,
        };
        let [x, y] = [0, 1].map(|axis| [least[axis], most[axis]]);
        Some(Location { side, x, y })
    }

    pub(super) fn turned(&self, degrees: f64) -> Self {
        let mut setup = self.clone();
        setup.placement.rotate += degrees;
        setup
    }

    fn shrink_to_pass(
        &self,
        format: Format,
        content: &Content,
    ) -> Result<ShrinkResult, Diagnostic> {
        let first = self.make_plan(format, content)?;
        let passing = |made| ShrinkResult { made, passes: true };
        if first.passes() {
            return Ok(passing(first));
        }
        let mut setup = self.clone();
        let mut scale = first.scale;
        // A linear search, because a smaller size may fail although a larger one passes.
        while scale > MIN_SHRUNK_SHARE * first.scale {
            scale *= SHRINK_FACTOR;
            setup.placement.scale = scale;
            let smaller = setup.make_plan(format, content)?;
            if smaller.passes() {
                return Ok(passing(smaller));
            }
        }
        Ok(ShrinkResult {
            made: first,
            passes: false,
        })
    }

    /// Plan in arm coordinates, not moved, if it passes the check.
    fn at_own_place(&self, format: Format, content: &Content) -> Option<PlacedPlan> {
        let mut setup = self.clone();
        setup.surface = None;
        setup.placement = Placement {
            fit: false,
            at: None,
            page: None,
            frame: Frame::Arm,
            ..self.placement
        };
        setup
            .make_plan(format, content)
            .ok()
            .filter(PlacedPlan::passes)
    }
}

/// Drawing including the parts that were not requested, if there are any.
fn with_all_parts(content: &Content) -> Option<Content> {
    let Content::Artwork(artwork) = content else {
        return None;
    };
    artwork.parts.iter().any(|part| part.unasked).then(|| {
        let mut whole = artwork.clone();
        for part in &mut whole.parts {
            part.unasked = false;
        }
        Content::Artwork(whole)
    })
}

/// Bounds of a drawing, mm, and the side of the arm on which it lies.
#[derive(Clone, Copy)]
struct Location {
    /// Side of the arm; `None` in front.
    side: Option<Side>,
    x: [f64; 2],
    y: [f64; 2],
}

impl Location {
    fn note(&self, format: Format) -> Diagnostic {
        let side = self.side.unwrap_or(Side::Left);
        let [x, y] =
            [self.x, self.y].map(|[least, most]| message!("{least:.0} to {most:.0}", least, most));
        let what = match side {
            Side::Left => message!(
                "does not fit in front of the arm: lies at its left, x {x}, y {y} mm",
                x,
                y
            ),
            Side::Right => message!(
                "does not fit in front of the arm: lies at its right, x {x}, y {y} mm",
                x,
                y
            ),
        };
        let note = Diagnostic::of_file(what).coded(DiagnosticCode::Placed);
        let note = match format {
            Format::Text => note.remedy((Setting::Wrap, SettingValue::Any("MM")), WRAP_EFFECT),
            _ => note,
        };
        note.remedy(
            (Setting::At, SettingValue::Any("X,Y")),
            "sets the position of its centre",
        )
    }
}

/// Effect of a width on lines of text, as a remedy.
const WRAP_EFFECT: &str = "breaks its lines";

/// Note about a chosen size or rotation; `fitted` is the resulting share of the requested size.
fn turned_note(format: Format, fitted: Option<f64>, turned: f64) -> Option<Diagnostic> {
    let share = fitted.unwrap_or(1.0);
    let percent = 100.0 * share;
    let is_smaller = share < FULL_SCALE;
    let smaller = is_smaller.then(|| match percent {
        percent if percent < 10.0 => {
            message!("made smaller to fit: {percent:.1} % of its size", percent)
        }
        percent => message!("made smaller to fit: {percent:.0} % of its size", percent),
    });
    let turns = turned != 0.0;
    let turned = turns.then(|| {
        if is_smaller {
            message!("turned by {turned} degrees to be larger", turned)
        } else {
            message!(
                "turned by {turned} degrees to fit in front of the arm",
                turned
            )
        }
    });
    let what = match (smaller, turned) {
        (Some(smaller), Some(turned)) => message!("{smaller}, {turned}", smaller, turned),
        (one, other) => one.or(other)?,
    };
    let note = Diagnostic::of_file(what).coded(DiagnosticCode::Placed);
    let note = if turns {
        note.remedy((Setting::Turn, SettingValue::Off), "leaves it as it lies")
    } else {
        note
    };
    let note = match format {
        Format::Text if turns => note.remedy((Setting::Wrap, SettingValue::Any("MM")), WRAP_EFFECT),
        _ => note,
    };
    Some(note)
}
