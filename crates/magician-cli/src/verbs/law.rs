//! Residue of a log against the law of motion, as text.

use magician_record::law::{Basis, LawReport, ProfileResidue, Speeds};

use crate::failure::Failure;
use crate::output::Output;

/// Prints a residue.
pub(super) fn show(report: &LawReport, out: &mut Output) -> Result<(), Failure> {
    for line in lines(report) {
        out.line(line)?;
    }
    Ok(())
}

fn lines(report: &LawReport) -> Vec<String> {
    let mut lines = Vec::new();
    let by = match report.basis {
        Basis::Commands => "based on the commands in the log",
        Basis::Readings => "based on poses only",
    };
    let (poses, moving) = (report.poses, report.moving);
    lines.push(format!("law: {poses} poses, {moving} in motion, {by}"));
    for (nth, residue) in report.residues.iter().enumerate() {
        let best = nth == 0 && report.profile.is_some();
        let verdict = if best {
            "best fit, deviation"
        } else {
            "deviation"
        };
        let ProfileResidue {
            profile, mm, deg, ..
        } = residue;
        let same = if residue.same.is_empty() {
            String::new()
        } else {
            format!(" ({} move identically)", residue.same.join(", "))
        };
        lines.push(format!(
            "  profile {profile}{same}: {verdict} {mm:.4} mm, {deg:.4} deg at most"
        ));
    }
    match report.period_ms {
        Some(0.0) => lines.push("  period none: the arm moves in continuous time".to_owned()),
        Some(period) => lines.push(format!("  period {period} ms")),
        None => {}
    }
    lines.extend(report.speeds.iter().map(format_group));
    let untold = report.untold.iter();
    lines.extend(untold.map(|what| format!("  not determined, {}: {what}", what.about())));
    lines
}

/// Formats as `jog in space: 60 mm/s2 to 30 mm/s, ratio 50 %`.
fn format_group(speeds: &Speeds) -> String {
    let (name, unit) = (speeds.kind.name(), speeds.kind.unit());
    let mut line = format!("  {name}: acceleration {} {unit}/s2", speeds.acceleration);
    if let Some(speed) = speeds.speed {
        line += &format!(", speed {speed} {unit}/s");
    }
    if let Some(ratio) = speeds.ratio {
        line += &format!(", ratio {ratio} %");
    }
    line
}
