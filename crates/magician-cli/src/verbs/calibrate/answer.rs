//! Results of a calibration, as text and as JSON.

use magician_program::artwork::Sheet;
use magician_program::{Tip, Tool};
use serde::Serialize;

use super::paper::Paper;
use super::subject::{CalibrationResult, Subject, bias};
use crate::columns::Columns;
use crate::failure::Failure;
use crate::output::Output;

/// Result as JSON. Fields that were not calibrated are absent.
#[derive(Debug, Serialize)]
pub(super) struct CalibrationReport {
    #[serde(skip_serializing_if = "Option::is_none")]
    sheet: Option<Sheet>,
    /// Slope of the sheet, deg.
    #[serde(skip_serializing_if = "Option::is_none")]
    tilt: Option<f64>,
    /// Paper size that the sheet resembles.
    #[serde(skip_serializing_if = "Option::is_none")]
    paper: Option<Paper>,
    /// Height of a level surface, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    surface: Option<f64>,
    /// Offset of the tip from its position according to the bias in force, mm: ahead and left.
    #[serde(skip_serializing_if = "Option::is_none")]
    offset: Option<[f64; 2]>,
    /// Tool that touched the points. After the calibration of a tool: its new bias.
    tool: String,
    pub(super) saved: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) file: Option<String>,
    /// True if the bias was set on the arm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) told: Option<bool>,
    /// Saved calibrations that were made with the old bias and must be repeated.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) stale: Vec<&'static str>,
    /// True if a saved height has no effect, because the saved sheet has its own.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub(super) sheet_counts: bool,
    #[serde(skip)]
    lines: Vec<[String; 2]>,
}

impl CalibrationReport {
    pub(super) fn new(found: &CalibrationResult, tool: Tool) -> Self {
        let mut report = Self {
            sheet: None,
            tilt: None,
            paper: None,
            surface: None,
            offset: None,
            tool: tool.to_string(),
            saved: false,
            file: None,
            told: None,
            stale: Vec::new(),
            sheet_counts: false,
            lines: lines(found, tool),
        };
        match found {
            CalibrationResult::Sheet(sheet) => {
                report.sheet = Some(*sheet);
                report.tilt = Some((tilt(sheet) * 100.0).round() / 100.0);
                report.paper = sheet.size.and_then(Paper::most_similar);
            }
            CalibrationResult::Surface(height) => report.surface = Some(*height),
            CalibrationResult::Tip(tip) => {
                report.offset = Some(tip.offset.map(|part| (part * 1000.0).round() / 1000.0));
                report.tool = bias(tip);
                report.told = Some(false);
            }
        }
        report
    }

    /// Writes the result.
    pub(super) fn write(&self, out: &mut Output) -> Result<(), Failure> {
        let mut columns = Columns::default();
        for [name, value] in &self.lines {
            columns.row([name, value]);
        }
        columns.write(out)
    }

    /// Writes what was done with the result.
    pub(super) fn write_end(&self, subject: Subject, out: &mut Output) -> Result<(), Failure> {
        if self.told == Some(true) {
            out.line("the bias is set on the arm")?;
        }
        for name in &self.stale {
            out.line(format_args!(
                "the {name} was measured with another bias: `magician calibrate {name}` measures \
                    it again"
            ))?;
        }
        match (&self.file, self.saved) {
            (Some(file), true) if self.sheet_counts => {
                out.line(format_args!(
                    "saved in {file}, but the sheet's height takes precedence"
                ))?;
                out.line(
                    "drawings are placed on the calibrated sheet: `magician calibrate sheet` \
                        measures it again, after `magician calibrate forget sheet` this height is \
                        used",
                )
            }
            (Some(file), true) => out.line(format_args!("saved in {file}: {}", subject.used_by())),
            (None, true) => out.line("saved"),
            _ => out.line("not saved; --yes saves it without asking"),
        }
    }
}

/// Returns the slope of a sheet's surface, deg.
fn tilt(sheet: &Sheet) -> f64 {
    let [x, y] = sheet.surface.slope;
    x.hypot(y).atan().to_degrees()
}

/// Label of the line that names the touching tool.
pub(super) const TOUCHED_BY: &str = "touched by";

/// Returns the result as labels and values.
pub(super) fn lines(found: &CalibrationResult, tool: Tool) -> Vec<[String; 2]> {
    let line = |name: &str, value: String| [name.to_owned(), value];
    match found {
        CalibrationResult::Sheet(sheet) => sheet_lines(sheet, Some(tool)),
        CalibrationResult::Surface(height) => vec![
            line("height", format!("z {height:.2} mm")),
            line(TOUCHED_BY, tool.to_string()),
        ],
        CalibrationResult::Tip(tip) => tip_lines(tip, tool),
    }
}

/// Returns a sheet as labels and values.
pub(super) fn sheet_lines(sheet: &Sheet, tool: Option<Tool>) -> Vec<[String; 2]> {
    let mut lines = Vec::new();
    let mut line = |name: &str, value: String| lines.push([name.to_owned(), value]);
    if let Some([width, height]) = sheet.size {
        line("size", format!("{width:.1} by {height:.1} mm"));
        if let Some(paper) = Paper::most_similar([width, height]) {
            line("paper", format!("looks like {paper}"));
        }
    }
    let [x, y] = sheet.corner;
    line("lower left", format!("x {x:.1} y {y:.1}"));
    let side = if sheet.rotation < 0.0 {
        "right"
    } else {
        "left"
    };
    line(
        "rotation",
        format!("{:.1} deg to the {side}", sheet.rotation.abs()),
    );
    line("tilt", format!("{:.2} deg", tilt(sheet)));
    let height = sheet.surface.at(sheet.corner);
    line("height", format!("z {height:.2} mm at the lower left"));
    if let Some(tool) = tool {
        line(TOUCHED_BY, tool.to_string());
    }
    lines
}

fn tip_lines(tip: &Tip, tool: Tool) -> Vec<[String; 2]> {
    // Adding 0.0 turns -0.0 into 0.0.
    let [ahead, left] = tip.offset.map(|part| (part * 100.0).round() / 100.0 + 0.0);
    let offset =
        format!("{ahead:.2} mm ahead and {left:.2} mm to the left of the tip of the tool {tool}");
    vec![
        ["tip".to_owned(), offset],
        ["bias".to_owned(), format!("{} mm", bias(tip))],
    ]
}
