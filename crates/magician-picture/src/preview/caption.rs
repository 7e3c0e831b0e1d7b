//! Title and key figures of a preview.

use magician_program::toolpath::{PlanPurpose, Toolpath};
use magician_program::{Plan, Report};
use std::time::Duration;

use crate::svg::palette::{FAINT, INK};
use crate::svg::{Anchor, Svg, TextStyle};

/// Mean width of a letter of the title, as a share of its size.
const LETTER_WIDTH_SHARE: f64 = 0.56;

/// Draws title and key figures with their upper left corner at a point.
pub(super) fn draw(
    svg: &mut Svg,
    [left, top]: [f64; 2],
    width: f64,
    plan: &Plan,
    report: &Report,
    toolpath: &Toolpath,
) {
    let title = TextStyle {
        size: 5.2,
        colour: INK,
        anchor: Anchor::Start,
        rim: false,
    };
    let name = if plan.title.is_empty() {
        "untitled"
    } else {
        plan.title.as_str()
    };
    let most = (width / (title.size * LETTER_WIDTH_SHARE)) as usize;
    let short: String = name.chars().take(most).collect();
    svg.text([left, top + 4.6], short, &title);
    let text = TextStyle {
        size: 3.4,
        colour: FAINT,
        ..title
    };
    let facts = facts(plan, report, toolpath);
    svg.text([left, top + 11.0], facts.join("  ·  "), &text);
}

fn facts(plan: &Plan, report: &Report, toolpath: &Toolpath) -> Vec<String> {
    let mut facts = Vec::new();
    if let Some([low, high]) = toolpath.bounds {
        let [x, y] = [high[0] - low[0], high[1] - low[1]];
        facts.push(format!("{x:.1} × {y:.1} mm"));
    }
    let (drawn_label, other_label) = match toolpath.purpose {
        PlanPurpose::Draws(_) => ("drawn", "pen up"),
        PlanPurpose::Burns(_) => ("burnt", "dark"),
        PlanPurpose::Carries(_) => ("drawn", "travelled"),
    };
    if toolpath.drawn > 0.0 {
        facts.push(format!("{} {drawn_label}", length(toolpath.drawn)));
    }
    if toolpath.other > 0.0 {
        facts.push(format!("{} {other_label}", length(toolpath.other)));
    }
    facts.extend(report.time.map(time));
    facts.push(match plan.steps.len() {
        1 => "1 step".to_owned(),
        steps => format!("{steps} steps"),
    });
    match report.refused {
        0 => {}
        refused => facts.push(format!("{refused} refused")),
    }
    facts
}

fn length(mm: f64) -> String {
    if mm < 9999.5 {
        format!("{mm:.0} mm")
    } else {
        format!("{:.1} m", mm / 1000.0)
    }
}

/// Formats a duration: `21.7 s`, `3 min 05 s`, `2 h 10 min`.
fn time(time: Duration) -> String {
    let seconds = time.as_secs_f64();
    let whole = seconds.round() as u64;
    match whole {
        0..60 => format!("{seconds:.1} s"),
        60..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole % 3600 / 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_lengths_are_short() {
        let formatted = |ms| time(Duration::from_millis(ms));
        assert_eq!(formatted(21_740), "21.7 s");
        assert_eq!(formatted(185_400), "3 min 05 s");
        assert_eq!(formatted(7_830_000), "2 h 10 min");
        assert_eq!([length(463.2), length(12_345.0)], ["463 mm", "12.3 m"]);
    }
}
