//! The parts of a file, to choose from.

use magician_host::JointAngles;
use magician_host::words::{Guards, Preflight};
use serde::Serialize;

use super::{PartMode, Setup, UNSAID};
use crate::{Action, Content, Diagnostic, Format, Part, Plan, Stroke, check};

/// A part of a file, and how much it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PartSummary {
    /// Its number, from 1, in the order of drawing.
    pub n: u64,
    /// Its layer, pen or tool, if that has a name.
    pub name: Option<String>,
    /// Its colour as `#rrggbb`, if it has one.
    pub color: Option<String>,
    /// How many lines it has in the file.
    pub strokes: usize,
    /// How long its lines are, mm.
    pub drawn_mm: f64,
    /// How long it takes once, if that is known.
    pub seconds: Option<f64>,
    /// Whether it is left out.
    pub skipped: bool,
}

impl Setup {
    /// The parts of a file: layers, unless it was said what they are.
    ///
    /// # Errors
    /// What is wrong with the file, or a part that was asked for and is not there.
    pub fn list_parts(
        &self,
        format: Format,
        content: &Content,
    ) -> Result<Vec<PartSummary>, Diagnostic> {
        let mode = self.parts.unwrap_or(PartMode::Layer);
        let once = Self {
            parts: Some(mode),
            passes: None,
            no_pause: true,
            ..self.clone()
        };
        let scale = self.placement.scale;
        let mut listed = Vec::new();
        if let Content::Artwork(artwork) = content {
            let (parts, _) = once.parts_of(artwork, mode)?;
            for (key, part) in (0..).zip(parts).filter(|(_, part)| part.passes > 0) {
                let strokes = artwork.strokes.iter().filter(|stroke| match mode {
                    PartMode::None => true,
                    PartMode::Layer => stroke.style.layer == key,
                    PartMode::Color => stroke.style.color == key,
                });
                listed.push(PartSummary {
                    strokes: strokes.clone().count(),
                    drawn_mm: scale * strokes.map(Stroke::length).sum::<f64>(),
                    skipped: part.skipped,
                    ..PartSummary::of(&part.part)
                });
            }
        }
        // Where it cannot be laid nobody knows how long it takes.
        let laid = once.plan(format, content.clone());
        if let Ok(laid) = laid
            && laid.misfit.is_none()
        {
            measure(
                &laid.plan,
                &mut listed,
                matches!(content, Content::Artwork(_)),
            );
        }
        Ok(listed)
    }
}

impl PartSummary {
    fn of(part: &Part) -> Self {
        Self {
            n: part.n,
            name: part.name.clone(),
            color: part.color.map(|color| color.to_string()),
            strokes: 0,
            drawn_mm: 0.0,
            seconds: None,
            skipped: false,
        }
    }
}

/// How long the parts of a plan are, and how long they take.
fn measure(plan: &Plan, listed: &mut Vec<PartSummary>, drawing: bool) {
    let begins = |(nth, step): (usize, &crate::Step)| match &step.action {
        Action::Part(part) => Some((nth, (**part).clone())),
        _ => None,
    };
    let parts: Vec<(usize, Part)> = plan.steps.iter().enumerate().filter_map(begins).collect();
    let start = Preflight::at(JointAngles::HOME, UNSAID).guards(Guards::NONE.reach(true));
    let up_to = |steps: usize| {
        let mut plan = plan.clone();
        plan.steps.truncate(steps);
        let report = check(&plan, &start);
        (report.drawn, report.time.map(|time| time.as_secs_f64()))
    };
    let ends = parts.iter().skip(1).map(|(nth, _)| *nth);
    let ends: Vec<usize> = ends.chain([plan.steps.len()]).collect();
    let mut before = parts.first().map_or((0.0, None), |(nth, _)| up_to(*nth));
    for ((begin, part), end) in parts.iter().zip(ends) {
        let after = up_to(end);
        if !listed.iter().any(|known| known.n == part.n) {
            listed.push(PartSummary::of(part));
        }
        let Some(known) = listed.iter_mut().find(|known| known.n == part.n) else {
            continue;
        };
        let seconds = after.1.zip(before.1).map(|(after, before)| after - before);
        known.seconds = match (known.seconds, seconds) {
            (Some(known), Some(more)) => Some(known + more),
            (known, more) => more.or(known),
        };
        if drawing {
            known.drawn_mm = after.0 - before.0;
        } else {
            known.drawn_mm += after.0 - before.0;
            let steps = plan.steps.get(*begin..end).unwrap_or_default();
            let lines = steps.chunk_by(|one, next| one.action.marks() == next.action.marks());
            let lines = lines.filter(|line| line.first().is_some_and(|step| step.action.marks()));
            known.strokes += lines.count();
        }
        known.drawn_mm = (known.drawn_mm * 1000.0).round() / 1000.0;
        before = after;
    }
}
