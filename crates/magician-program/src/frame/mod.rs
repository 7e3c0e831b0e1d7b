//! Frames: outlines of a job, traced with the laser off or the pen up to show where the job will
//! lie.

mod outline;

use magician_host::message;
use magician_host::{Remedy, Setting};
use magician_motion::Fence;

use crate::artwork::{Marking, PlacedArtwork};
use crate::setup::{POWER_UP_TOOL, WorkLines, report};
use crate::{Artwork, Diagnostic, DiagnosticCode, Origin, Plan, Reach, Stroke, Surface, Tool};
use magician_formats::keywords::keywords;
use magician_formats::reach::hull;

/// Speed ratio of the arm at power-up (model section 6): travel moves run at half the set speed.
const POWER_UP_SPEED_RATIO: f32 = 0.5;
/// Largest speed of a frame, mm/s, so that a person can follow it.
const MAX_SPEED: f32 = 100.0;

/// Shape of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum FrameShape {
    /// Bounding box along the arm's X and Y.
    #[default]
    Box,
    /// Convex hull of all marks.
    Hull,
    /// Outer contours. Marks close to each other share one.
    Outline,
}

keywords! {
    FrameShape, "frame":
    Box = "box",
    Hull = "hull",
    Outline = "outline",
}

/// Options of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Framing {
    /// Shape to trace.
    pub shape: FrameShape,
    /// Laser power while tracing, percent, to see the spot: off by default, and at most
    /// [`MAX_POWER`](Self::MAX_POWER).
    pub power: Option<f64>,
}

impl Framing {
    /// Largest power of a frame, percent.
    pub const MAX_POWER: f64 = 5.0;

    /// Frame of this shape, with the laser off.
    #[must_use]
    pub fn of(shape: FrameShape) -> Self {
        Self { shape, power: None }
    }

    /// Creates the plan that traces the marks of another plan with the same tool: a laser at the
    /// height of the marks, any other tool `lift` above them. Where possible it avoids places that
    /// the check refuses.
    pub(crate) fn plan(
        &self,
        marked: Plan,
        pen: &Marking,
        fence: Option<Fence>,
    ) -> Result<(Plan, Vec<Diagnostic>), Diagnostic> {
        let laser = marked.tool == Some(Tool::Laser)
            || marked.steps.iter().any(|step| step.action.is_of_a_laser());
        if self.power.is_some() && !laser {
            let message = message!("only the laser lights a frame, and this is for another tool");
            let diagnostic = Diagnostic::of_file(message);
            return Err(diagnostic.with(Remedy::without(Setting::FramePower)));
        }
        let marks = WorkLines::of(&marked, None).map_err(|_| {
            Diagnostic::of_file(message!(
                "it draws and burns nothing: there is nothing to go round"
            ))
        })?;
        let surface = marked.surface.unwrap_or(Surface::level(marks.touch));
        let frame = Frame {
            marked: &marked,
            surface,
            above: if laser { 0.0 } else { pen.lift },
            marking: Marking {
                tool: marked.tool.unwrap_or(Tool::Bias(
                    [POWER_UP_TOOL.x, POWER_UP_TOOL.y, POWER_UP_TOOL.z].map(|side| side as f32),
                )),
                power: laser.then(|| self.power.unwrap_or(0.0) as f32),
                speed: (pen.travel * POWER_UP_SPEED_RATIO).min(MAX_SPEED),
                ..*pen
            },
        };
        let lines = marks.artwork;
        let points: Vec<[f64; 2]> = lines
            .strokes
            .iter()
            .flat_map(|stroke| stroke.points.iter().copied())
            .collect();
        let round = || vec![closed(hull(&points))];
        let (rings, message) = match self.shape {
            FrameShape::Box => (
                vec![closed(corners(&lines))],
                message!("the corners of its box are out of reach: the frame is the convex hull"),
            ),
            FrameShape::Outline => (
                outline::of(&lines),
                message!("its outline is out of reach: the frame is the convex hull"),
            ),
            FrameShape::Hull => return Ok((frame.plan(round()), Vec::new())),
        };
        let plan = frame.plan(rings);
        // The hull lies within the box, so it may be in reach when the box is not.
        if report(&plan, fence).is_good() {
            return Ok((plan, Vec::new()));
        }
        let note = Diagnostic::of_file(message).coded(DiagnosticCode::Placed);
        Ok((frame.plan(round()), vec![note]))
    }
}

/// Input of a frame.
struct Frame<'a> {
    marked: &'a Plan,
    surface: Surface,
    /// Height above the surface, mm.
    above: f64,
    marking: Marking,
}

impl Frame<'_> {
    fn plan(&self, rings: Vec<Vec<[f64; 2]>>) -> Plan {
        let at = Surface {
            height: self.surface.height + self.above,
            ..self.surface
        };
        let reach = Reach::new(self.marking.tool.bias(), at, self.marking.lift);
        let strokes = rings.into_iter().map(|ring| {
            let points = around_base(&ring, &reach);
            Stroke::new(points, Origin::NONE)
        });
        let mut artwork = Artwork {
            title: self.marked.title.clone(),
            strokes: strokes.collect(),
            ..Artwork::default()
        };
        artwork.put_in_order(&crate::artwork::Order::default());
        let placed = PlacedArtwork::at(artwork, at);
        Plan {
            tool: self.marked.tool,
            surface: Some(self.surface),
            ..placed.plan(&self.marking)
        }
    }
}

/// Corners of the bounding box, starting at the lower left.
fn corners(lines: &Artwork) -> Vec<[f64; 2]> {
    let [[left, low], [right, high]] = lines.bounds().unwrap_or_default();
    let mut corners = vec![[left, low], [right, low], [right, high], [left, high]];
    corners.dedup();
    corners
}

/// Closes a ring: appends its first point.
fn closed(mut corners: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    corners.extend(corners.first().copied().filter(|_| corners.len() > 1));
    corners
}

/// Same ring, with detours around the base where an edge passes too close to the base.
fn around_base(ring: &[[f64; 2]], reach: &Reach) -> Vec<[f64; 2]> {
    let mut round: Vec<[f64; 2]> = Vec::with_capacity(ring.len());
    for &to in ring {
        if let Some(&from) = round.last()
            && !reach.is_lifted_line_possible(from, to, 0.0)
        {
            round.extend(reach.corners_around_base(from, to, 0.0).unwrap_or_default());
        }
        round.push(to);
    }
    round
}
