//! `--list-parts`: lists the parts of a file that can be selected.

use magician_job::report::format_duration;
use magician_program::PartSummary;
use magician_protocol::visible_lines;
use serde::Serialize;

use super::reading::ParsedFile;
use super::{Job, RunPlace, notes};
use crate::context::Context;
use crate::failure::Failure;

/// Parts as JSON.
#[derive(Serialize)]
struct Parts {
    parts: Vec<PartSummary>,
}

impl Job {
    /// Lists the parts of a file.
    pub(super) fn list_parts(&self, context: &mut Context) -> Result<(), Failure> {
        let ParsedFile { source, mut file } = self.parse_file(&RunPlace::NoArm, context)?;
        let listed = file.list_parts();
        let (parts, told) = listed.map_err(|error| self.refused(&source, error, context))?;
        notes(&source, &told, context);
        let answer = Parts { parts };
        context.show(&answer, |out| {
            if answer.parts.is_empty() {
                return out.line(format_args!("{}: no parts", source.name));
            }
            answer
                .parts
                .iter()
                .try_for_each(|part| out.line(line(part)))
        })
    }
}

/// Formats as `2  outline  #ff0000  14 lines, 320 mm, 0:41`.
fn line(part: &PartSummary) -> String {
    let name = part.name.as_deref().unwrap_or("-");
    let color = part.color.as_deref().unwrap_or("-");
    let lines = if part.strokes == 1 { "line" } else { "lines" };
    let time = part
        .seconds
        .and_then(|seconds| std::time::Duration::try_from_secs_f64(seconds).ok());
    let time = time
        .map(|time| format!(", {}", format_duration(time)))
        .unwrap_or_default();
    let skipped = if part.skipped { ", left out" } else { "" };
    format!(
        "{:>3}  {}  {color}  {} {lines}, {:.0} mm{time}{skipped}",
        part.n,
        visible_lines(name),
        part.strokes,
        part.drawn_mm,
    )
}
