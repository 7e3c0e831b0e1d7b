//! Legend of a picture: the meaning of lines and signs in rows, followed by errors.

use magician_program::toolpath::{MarkerKind, POWER_SHADES, StrokeKind};

use crate::layers::{PathStyle, style_of};
use crate::svg::palette::{FAINT, INK, REACH, REACH_EDGE, WRONG};
use crate::svg::{Anchor, Number, Svg, TextStyle, path};
use crate::{fence, ground, symbols};

/// Height of a row, mm.
const ROW_HEIGHT: f64 = 5.5;
/// Size of letters, mm.
const LETTER_SIZE: f64 = 3.0;
/// Upper bound of the mean width of letters, as a share of their size.
const LETTER_WIDTH_SHARE: f64 = 0.54;
/// Gap between a sign and its label, mm.
const LABEL_GAP: f64 = 1.8;
/// Gap between entries, mm.
const ENTRY_GAP: f64 = 6.5;

/// Largest number of lines per error. Longer errors are cut off.
const MAX_LINES: usize = 3;
/// Indentation of continuation lines.
const INDENT: &str = "\u{a0}\u{a0}\u{a0}";

/// Sign of an entry.
pub(super) enum Sign {
    Line(StrokeKind, PathStyle),
    Shades,
    /// Reach of the tool.
    Area,
    /// Reach of the tool at a second height, as an outline.
    Outline,
    /// Object with a fill, and with colour and width of its edge.
    Object(&'static str, [&'static str; 2]),
    Page,
    Fence,
    KeepOut,
    Begin,
    End,
    Marker(MarkerKind),
}

/// A legend after layout.
pub(super) struct Legend {
    entries: Vec<([f64; 2], Sign, String)>,
    errors: Vec<String>,
    rows: usize,
}

impl Legend {
    /// Lays out entries, and below them errors, for a width.
    pub(super) fn new(entries: Vec<(Sign, String)>, errors: &[String], width: f64) -> Self {
        let mut at = [0.0, 0.0];
        let mut placed = Vec::new();
        for (sign, label) in entries {
            let room = sign.width() + LABEL_GAP + text_width(&label);
            if at[0] > 0.0 && at[0] + room > width {
                at = [0.0, at[1] + ROW_HEIGHT];
            }
            placed.push((at, sign, label));
            at[0] += room + ENTRY_GAP;
        }
        let errors = errors.iter().flat_map(|text| wrapped(text, width));
        let rows = (at[1] / ROW_HEIGHT) as usize + 1;
        Self {
            entries: placed,
            errors: errors.collect(),
            rows,
        }
    }

    /// Height, mm.
    pub(super) fn height(&self) -> f64 {
        let rows = self.rows + self.errors.len();
        rows as f64 * ROW_HEIGHT
    }

    /// Draws it with its upper left corner at a point.
    pub(super) fn draw(&self, svg: &mut Svg, [left, top]: [f64; 2]) {
        let text = TextStyle {
            size: LETTER_SIZE,
            colour: INK,
            anchor: Anchor::Start,
            rim: false,
        };
        for ([x, y], sign, label) in &self.entries {
            let at = [left + x, top + y + ROW_HEIGHT / 2.0];
            sign.draw(svg, at);
            svg.text(
                [at[0] + sign.width() + LABEL_GAP, at[1] + 1.1],
                label,
                &text,
            );
        }
        let errors = TextStyle {
            colour: WRONG,
            ..text
        };
        for (nth, line) in self.errors.iter().enumerate() {
            let y = top + (self.rows + nth) as f64 * ROW_HEIGHT + ROW_HEIGHT / 2.0 + 1.1;
            svg.text([left, y], line, &errors);
        }
    }
}

impl Sign {
    /// Width, mm.
    fn width(&self) -> f64 {
        match self {
            Self::Line(..) | Self::Shades => 7.0,
            Self::Area | Self::Outline | Self::Object(..) | Self::Page => 4.0,
            Self::Fence | Self::KeepOut => 4.0,
            Self::Begin => 2.2,
            Self::End => 4.6,
            Self::Marker(_) => 3.2,
        }
    }

    fn draw(&self, svg: &mut Svg, [x, y]: [f64; 2]) {
        match self {
            Self::Line(mark, path_style) => line(svg, [[x, y], [x + 7.0, y]], *mark, *path_style),
            Self::Shades => {
                for shade in 1..=POWER_SHADES {
                    let from = x + 7.0 * (shade - 1) as f64 / POWER_SHADES as f64;
                    let ends = [[from, y - 1.2], [from, y + 1.2]];
                    line(svg, ends, StrokeKind::Burn(shade), PathStyle::Plan);
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
            Self::Outline => {
                let corners = [[x, y - 1.6], [x + 4.0, y + 1.6]];
                svg.rectangle(corners, &ground::OUTLINE_ATTRIBUTES);
            }
            Self::Object(fill, [edge, width]) => {
                let look = [("fill", *fill), ("stroke", *edge), ("stroke-width", *width)];
                svg.rectangle([[x + 0.4, y - 1.6], [x + 3.6, y + 1.6]], &look);
            }
            Self::Fence => fence::draw_outline(svg, [[x, y - 1.6], [x + 4.0, y + 1.6]]),
            Self::KeepOut => fence::draw_keep_out(svg, [[x, y - 1.6], [x + 4.0, y + 1.6]]),
            Self::Begin => symbols::begin(svg, [x + 1.1, y]),
            Self::End => symbols::finish(svg, [x + 2.3, y]),
            Self::Marker(kind) => symbols::sign(svg, [x + 1.6, y], *kind),
        }
    }
}

fn line(svg: &mut Svg, ends: [[f64; 2]; 2], mark: StrokeKind, path_style: PathStyle) {
    let (colour, width, opacity, dashes) = style_of(mark, path_style);
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

/// Wraps a text to lines that fit, and indents all but the first.
fn wrapped(text: &str, width: f64) -> Vec<String> {
    let most = ((width / (LETTER_SIZE * LETTER_WIDTH_SHARE)) as usize).max(20);
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
    lines.truncate(MAX_LINES);
    lines
}

fn text_width(text: &str) -> f64 {
    text.chars().count() as f64 * LETTER_SIZE * LETTER_WIDTH_SHARE
}
