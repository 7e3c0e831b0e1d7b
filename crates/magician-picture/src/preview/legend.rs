//! What the lines and signs mean, and what is wrong.

use magician_motion::Fence;
use magician_program::toolpath::{
    MOST_REFUSED, MarkerKind, PlanPurpose, SHADES, StrokeKind, Toolpath,
};
use magician_program::{Diagnostic, Report};

use super::PreviewOptions;
use super::above::{has, kinds};
use crate::layers::look;
use crate::svg::palette::{FAINT, INK, REACH, REACH_EDGE, WRONG};
use crate::svg::{Anchor, Number, Svg, TextStyle, path, signed};
use crate::symbols;

/// From one row to the next, mm.
const ROW: f64 = 5.5;
/// Size of its letters, mm, and how wide one is at most on the average.
const LETTER: f64 = 3.0;
const WIDE: f64 = 0.54;
/// Room between a sign and its label, and between two entries, mm.
const GAP: f64 = 1.8;
const APART: f64 = 6.5;

/// Colours of lines that are shown.
const MOST_INKS: usize = 8;
/// As many lines has one complaint.
const MOST_LINES: usize = 3;
/// How a line that goes on begins.
const INDENT: &str = "\u{a0}\u{a0}\u{a0}";

/// What an entry shows.
enum Sign {
    Line(StrokeKind),
    Shades,
    Area,
    Page,
    Fence,
    KeepOut,
    Begin,
    End,
    Marker(MarkerKind),
}

/// The legend, laid out.
pub(super) struct Legend {
    entries: Vec<([f64; 2], Sign, String)>,
    refused_steps: Vec<String>,
    rows: usize,
}

impl Legend {
    /// Lays it out for a width.
    pub(super) fn new(
        toolpath: &Toolpath,
        report: &Report,
        options: &PreviewOptions,
        width: f64,
    ) -> Self {
        let mut at = [0.0, 0.0];
        let mut entries = Vec::new();
        for (sign, label) in entries_of(toolpath)
            .into_iter()
            .chain(options.page.iter().map(|_| (Sign::Page, "page".to_owned())))
            .chain(entries_of_fence(options.fence.as_ref()))
        {
            let room = sign.width() + GAP + text_width(&label);
            if at[0] > 0.0 && at[0] + room > width {
                at = [0.0, at[1] + ROW];
            }
            entries.push((at, sign, label));
            at[0] += room + APART;
        }
        let refused_steps = refused_steps(report, width);
        let rows = (at[1] / ROW) as usize + 1;
        Self {
            entries,
            refused_steps,
            rows,
        }
    }

    /// How high it is, mm.
    pub(super) fn height(&self) -> f64 {
        let rows = self.rows + self.refused_steps.len();
        rows as f64 * ROW
    }

    /// Draws it with its upper left corner at a place.
    pub(super) fn draw(&self, svg: &mut Svg, [left, top]: [f64; 2]) {
        let text = TextStyle {
            size: LETTER,
            colour: INK,
            anchor: Anchor::Start,
            rim: false,
        };
        for ([x, y], sign, label) in &self.entries {
            let at = [left + x, top + y + ROW / 2.0];
            sign.draw(svg, at);
            svg.text([at[0] + sign.width() + GAP, at[1] + 1.1], label, &text);
        }
        let wrong = TextStyle {
            colour: WRONG,
            ..text
        };
        for (nth, line) in self.refused_steps.iter().enumerate() {
            let y = top + (self.rows + nth) as f64 * ROW + ROW / 2.0 + 1.1;
            svg.text([left, y], line, &wrong);
        }
    }
}

fn entries_of(toolpath: &Toolpath) -> Vec<(Sign, String)> {
    let mut entries = vec![];
    let burns = has(toolpath, |leaves| matches!(leaves, StrokeKind::Burn(_)));
    let mut lines = |leaves, label: &str| {
        if has(toolpath, |other| other == leaves) {
            entries.push((Sign::Line(leaves), label.to_owned()));
        }
    };
    let inks = toolpath.layers.iter().map(|layer| layer.leaves);
    let inks = inks.filter(|leaves| matches!(leaves, StrokeKind::Ink(_)));
    inks.take(MOST_INKS).for_each(|ink| lines(ink, "drawn"));
    lines(StrokeKind::Carried, "with something held");
    let nothing = match toolpath.purpose {
        PlanPurpose::Draws(_) => "pen up",
        PlanPurpose::Burns(_) => "laser dark",
        PlanPurpose::Carries(_) => "with nothing held",
    };
    lines(StrokeKind::Nothing, nothing);
    lines(StrokeKind::Unreachable, "out of reach");
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

/// What is seen of a fence, and the floor, which is not.
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

impl Sign {
    /// mm.
    fn width(&self) -> f64 {
        match self {
            Self::Line(_) | Self::Shades => 7.0,
            Self::Area | Self::Page | Self::Fence | Self::KeepOut => 4.0,
            Self::Begin => 2.2,
            Self::End => 4.6,
            Self::Marker(_) => 3.2,
        }
    }

    fn draw(&self, svg: &mut Svg, [x, y]: [f64; 2]) {
        match self {
            Self::Line(leaves) => line(svg, [[x, y], [x + 7.0, y]], *leaves),
            Self::Shades => {
                for shade in 1..=SHADES {
                    let from = x + 7.0 * (shade - 1) as f64 / SHADES as f64;
                    let ends = [[from, y - 1.2], [from, y + 1.2]];
                    line(svg, ends, StrokeKind::Burn(shade));
                }
            }
            Self::Area => {
                let look = [
                    ("fill", REACH),
                    ("stroke", REACH_EDGE),
                    ("stroke-width", "0.3"),
                ];
                svg.rectangle([[x, y - 1.6], [x + 4.0, y + 1.6]], &look);
            }
            Self::Page => {
                let look = [("fill", "none"), ("stroke", FAINT), ("stroke-width", "0.4")];
                svg.rectangle([[x + 0.6, y - 1.6], [x + 2.9, y + 1.6]], &look);
            }
            Self::Fence => super::fence::outline(svg, [[x, y - 1.6], [x + 4.0, y + 1.6]]),
            Self::KeepOut => super::fence::hatched(svg, [[x, y - 1.6], [x + 4.0, y + 1.6]]),
            Self::Begin => symbols::begin(svg, [x + 1.1, y]),
            Self::End => symbols::finish(svg, [x + 2.3, y]),
            Self::Marker(kind) => symbols::sign(svg, [x + 1.6, y], *kind),
        }
    }
}

fn line(svg: &mut Svg, ends: [[f64; 2]; 2], leaves: StrokeKind) {
    let (colour, width, opacity, dashes) = look(leaves);
    let [width, opacity] = [width, opacity].map(|value| Number(value).to_string());
    let mut attributes = vec![
        ("stroke", &*colour),
        ("stroke-width", width.as_str()),
        ("stroke-opacity", &opacity),
        ("stroke-linecap", "round"),
    ];
    attributes.extend(dashes.map(|dashes| ("stroke-dasharray", dashes)));
    svg.path(&path(ends, false), &attributes);
}

/// What is wrong, in lines that fit, and how much more there is.
fn refused_steps(report: &Report, width: f64) -> Vec<String> {
    let first = report.refused_steps.iter().take(MOST_REFUSED);
    let more = report.refused.saturating_sub(first.len());
    let told = first.flat_map(|refused_step| {
        let (step, diagnostic) = (
            report.number(refused_step.step),
            Diagnostic::from(refused_step),
        );
        wrapped(&format!("step {step}: {diagnostic}"), width)
    });
    let more = (more > 0).then(|| format!("and {more} more"));
    told.chain(more).collect()
}

/// A text in lines that fit, the second and later ones moved in.
fn wrapped(text: &str, width: f64) -> Vec<String> {
    let most = ((width / (LETTER * WIDE)) as usize).max(20);
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let room = word.chars().count() + 1;
        let Some(line) = lines.last_mut() else {
            break;
        };
        if line.chars().count() + room > most && !line.is_empty() {
            lines.push(format!("{INDENT}{word}"));
        } else {
            line.push_str(if line.is_empty() { "" } else { " " });
            line.push_str(word);
        }
    }
    lines.truncate(MOST_LINES);
    lines
}

fn text_width(text: &str) -> f64 {
    text.chars().count() as f64 * LETTER * WIDE
}
