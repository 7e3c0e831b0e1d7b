//! Entries of a preview's legend.

use magician_motion::Fence;
use magician_program::toolpath::{
    MAX_MARKED_REFUSALS, MarkerKind, PlanPurpose, StrokeKind, Toolpath,
};
use magician_program::{Diagnostic, Report};

use super::PreviewOptions;
use super::above::{has, kinds};
use crate::layers::PathStyle;
use crate::legend::{Legend, Sign};
use crate::svg::signed;

/// Largest number of line colours to list.
const MAX_COLORS: usize = 8;

/// Returns the legend of a preview for a width.
pub(super) fn legend(
    toolpath: &Toolpath,
    report: &Report,
    options: &PreviewOptions,
    width: f64,
) -> Legend {
    let mut entries = entries_of(toolpath);
    entries.extend(options.page.iter().map(|_| (Sign::Page, "page".to_owned())));
    entries.extend(entries_of_fence(options.fence.as_ref()));
    Legend::new(entries, &refused_steps(report), width)
}

fn entries_of(toolpath: &Toolpath) -> Vec<(Sign, String)> {
    let mut entries = vec![];
    let burns = has(toolpath, |mark| matches!(mark, StrokeKind::Burn(_)));
    let mut add_line = |mark, label: &str| {
        if has(toolpath, |other| other == mark) {
            entries.push((Sign::Line(mark, PathStyle::Plan), label.to_owned()));
        }
    };
    let inks = toolpath.layers.iter().map(|layer| layer.mark);
    let inks = inks.filter(|mark| matches!(mark, StrokeKind::Ink(_)));
    inks.take(MAX_COLORS).for_each(|ink| add_line(ink, "drawn"));
    add_line(StrokeKind::Carried, "with something held");
    let empty_label = match toolpath.purpose {
        PlanPurpose::Draws(_) => "pen up",
        PlanPurpose::Burns(_) => "laser dark",
        PlanPurpose::Carries(_) => "with nothing held",
    };
    add_line(StrokeKind::Nothing, empty_label);
    add_line(StrokeKind::Unreachable, "out of reach");
    if burns {
        entries.insert(0, (Sign::Shades, "burnt, 10 to 100 % power".to_owned()));
    }
    for kind in kinds(toolpath) {
        let label = match kind {
            MarkerKind::Pick => "grips",
            MarkerKind::Place => "releases",
            MarkerKind::Wait => "waits",
        };
        entries.push((Sign::Marker(kind), label.to_owned()));
    }
    if toolpath.ends.is_some() {
        entries.push((Sign::Begin, "start".to_owned()));
        entries.push((Sign::End, "end".to_owned()));
    }
    if let Some(surface) = toolpath.purpose.surface() {
        let height = signed(surface.height);
        entries.push((Sign::Area, format!("within reach at z = {height} mm")));
    }
    entries
}

/// Returns the entries of the fence. Its floor is not visible from above, so it is given as text.
fn entries_of_fence(fence: Option<&Fence>) -> Vec<(Sign, String)> {
    let mut entries = Vec::new();
    let Some(fence) = fence else {
        return entries;
    };
    let floor = fence
        .floor()
        .map(|floor| format!("floor at z = {} mm", signed(floor)));
    if fence.within().is_some() || floor.is_some() {
        let more = floor.map_or(String::new(), |floor| format!(", {floor}"));
        entries.push((Sign::Fence, format!("fence{more}")));
    }
    if !fence.keep_outs().is_empty() {
        entries.push((Sign::KeepOut, "keep-out".to_owned()));
    }
    entries
}

/// Returns a line for each refused step. If there are too many, the last line has the number of the
/// steps left out.
fn refused_steps(report: &Report) -> Vec<String> {
    let first = report.refused_steps.iter().take(MAX_MARKED_REFUSALS);
    let more = report.refused.saturating_sub(first.len());
    let lines = first.map(|refused_step| {
        let (step, diagnostic) = (
            report.number(refused_step.step),
            Diagnostic::from(refused_step),
        );
        format!("step {step}: {diagnostic}")
    });
    let more = (more > 0).then(|| format!("and {more} more"));
    lines.chain(more).collect()
}
