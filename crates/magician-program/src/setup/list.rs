//! List of the parts of a file, for selection.

use std::collections::BTreeMap;

use magician_host::JointAngles;
use magician_host::preflight::{Guards, Preflight};
use serde::Serialize;

use super::{POWER_UP_TOOL, PartMode, PartRule, Setup};
use crate::{Action, Artwork, Content, Diagnostic, Format, Part, Plan, Report, check};

/// Part of a file, with its figures.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PartSummary {
    /// Number, from 1, in drawing order.
    pub n: u64,
    /// Name of its layer, pen or tool, if any.
    pub name: Option<String>,
    /// Colour as `#rrggbb`, if any.
    pub color: Option<String>,
    /// Number of lines in the file; for filled shapes, number of drawn lines.
    pub strokes: usize,
    /// Length of its lines, mm.
    pub drawn_mm: f64,
    /// Duration of all passes, s, or of one pass in a list for selection; `None` if unknown.
    pub seconds: Option<f64>,
    /// True if it is left out.
    pub skipped: bool,
}

impl Setup {
    /// Lists the parts of a file: layers, unless the setup says otherwise.
    ///
    /// # Errors
    /// [`Diagnostic`] with the mistake in the file, or a requested part that does not exist.
    pub fn list_parts(
        &self,
        format: Format,
        content: &Content,
    ) -> Result<Vec<PartSummary>, Diagnostic> {
        let content = &self.with_adequate_curves(format, content.clone())?;
        let mut listed = self.parts_in(content, self.placement.scale)?;
        let pens = self.pens.iter().map(|rule| PartRule {
            passes: None,
            ..rule.clone()
        });
        let once = Self {
            parts: Some(self.listed_mode()),
            passes: None,
            pens: pens.collect(),
            no_pause: true,
            ..self.clone()
        };
        // Fill lines depend on the drawn size.
        let fills = self.fills(content);
        // Without a place the duration is unknown.
        let laid = once.plan(format, content.clone());
        if let Ok(laid) = laid
            && laid.misfit.is_none()
        {
            let start = Preflight::at(JointAngles::HOME, POWER_UP_TOOL)
                .on_rail(0.0)
                .guards(Guards::NONE.reach(true));
            PartSummary::measure(&mut listed, &check(&laid.plan, &start));
            if fills {
                PartSummary::count(&mut listed, &laid.plan);
            }
        }
        Ok(listed)
    }

    /// Parts as in the file, drawn at this scale.
    pub(crate) fn parts_in(
        &self,
        content: &Content,
        scale: f64,
    ) -> Result<Vec<PartSummary>, Diagnostic> {
        match content {
            Content::Artwork(artwork) => {
                let mut listed = self.parts_of_artwork(artwork)?;
                { listed.iter_mut() }.for_each(|part| part.drawn_mm *= scale);
                Ok(listed)
            }
            Content::Plan(plan) => Ok(parts_of_plan(plan, scale)),
            _ => Ok(Vec::new()),
        }
    }

    /// True if placing adds lines to the file's content, to fill its shapes.
    pub(crate) fn fills(&self, content: &Content) -> bool {
        let areas = matches!(content, Content::Artwork(artwork) if !artwork.areas.is_empty());
        areas && self.framing.is_none()
    }

    fn listed_mode(&self) -> PartMode {
        self.parts.unwrap_or(PartMode::Layer)
    }

    fn parts_of_artwork(&self, artwork: &Artwork) -> Result<Vec<PartSummary>, Diagnostic> {
        let mode = self.listed_mode();
        let (parts, _) = self.parts_of(artwork, mode)?;
        let mut lines = vec![(0, 0.0); parts.len()];
        for stroke in &artwork.strokes {
            let key = match mode {
                PartMode::None => 0,
                PartMode::Layer => stroke.style.layer,
                PartMode::Color => stroke.style.color,
            };
            if let Some((count, length)) = lines.get_mut(key as usize) {
                *count += 1;
                *length += stroke.length();
            }
        }
        let there = parts.iter().zip(lines);
        let there = there.filter(|(part, _)| part.passes > 0);
        let listed = there.map(|(part, (strokes, drawn_mm))| PartSummary {
            strokes,
            drawn_mm,
            skipped: part.skipped || part.unasked,
            ..PartSummary::of(&part.part)
        });
        Ok(listed.collect())
    }
}

/// Parts of a plan; steps before the first part belong to none.
fn parts_of_plan(plan: &Plan, scale: f64) -> Vec<PartSummary> {
    let mut listed: Vec<PartSummary> = Vec::new();
    let (mut now, mut at, mut marked) = (None, None, false);
    for step in &plan.steps {
        if let Action::Part(part) = &step.action {
            let known = listed.iter().position(|known| known.n == part.n);
            now = Some(known.unwrap_or_else(|| {
                listed.push(PartSummary::of(part));
                listed.len() - 1
            }));
        }
        let marks = step.action.marks();
        let to = step.action.target().map(|to| to.map(f64::from));
        if let Some(part) = now.filter(|_| marks).and_then(|now| listed.get_mut(now)) {
            part.strokes += usize::from(!marked);
            if let (Some(from), Some(to)) = (at, to) {
                part.drawn_mm += scale * distance(from, to);
            }
        }
        (at, marked) = (to.or(at), marks);
    }
    listed
}

fn distance(from: [f64; 3], to: [f64; 3]) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|axis: usize| to[axis] - from[axis]);
    libm::hypot(libm::hypot(x, y), z)
}

/// Rounded to micrometres, as in the report of a check.
fn rounded(mm: f64) -> f64 {
    (mm * 1000.0).round() / 1000.0
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

    /// Counts the strokes of each part in a plan, in one pass; an undivided plan is one part.
    pub(crate) fn count(listed: &mut [Self], plan: &Plan) {
        let mut counts = BTreeMap::new();
        let (mut now, mut again, mut marked) = (None, false, false);
        for step in &plan.steps {
            if let Action::Part(part) = &step.action {
                now = Some(part.n);
                again = part.pass.is_some_and(|pass| pass > 1);
            }
            let marks = step.action.marks();
            if marks && !marked && !again {
                *counts.entry(now).or_insert(0) += 1;
            }
            marked = marks;
        }
        let divided = counts.keys().any(Option::is_some);
        for part in listed.iter_mut().filter(|part| !part.skipped) {
            let key = divided.then_some(part.n);
            part.strokes = counts.get(&key).copied().unwrap_or(0);
        }
    }

    /// Adds the lengths and durations from a check.
    pub fn measure(listed: &mut Vec<Self>, report: &Report) {
        for figures in &report.parts {
            let known = listed.iter().position(|known| known.n == figures.part.n);
            let nth = known.unwrap_or_else(|| {
                listed.push(Self::of(&figures.part));
                listed.len() - 1
            });
            if let Some(part) = listed.get_mut(nth) {
                part.drawn_mm = rounded(figures.drawn);
                part.seconds = figures.time.map(|time| time.as_secs_f64());
            }
        }
        // An undivided plan is one part.
        if let ([part], true) = (listed.as_mut_slice(), report.parts.is_empty())
            && !part.skipped
        {
            part.drawn_mm = rounded(report.drawn);
            part.seconds = report.time.map(|time| time.as_secs_f64());
        }
    }
}
