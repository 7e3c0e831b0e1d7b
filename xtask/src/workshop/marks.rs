//! Compares preview, drawing of pen or laser, and content of the file.

use std::error::Error;

use magician::sim::world::{Drawing, Stroke, StrokeKind};
use magician_picture::compare::{Match, Tones, compare, lines_of, svg_lines};
use magician_program::raster::Size;
use magician_program::{Content, Format, Raster, ReadOptions, read};
use serde_json::Value;

use super::pieces::{Input, Piece};
use super::source::{self, Line};

/// Largest distance between a point of the result and its file, mm; and between it and the preview,
/// which leaves out corners of curves.
const TOLERANCE: f64 = 0.1;
const PREVIEW_TOLERANCE: f64 = 0.2;
/// Size of the cells in which tones are compared, mm, and their largest mean difference as a share
/// of black: half a step of an 8-bit grey is 0.002.
const CELL_SIZE: f64 = 1.0;
const TONE_TOLERANCE: f64 = 0.02;
/// Greys from this value on are burnt with no power.
const WHITE_LEVEL: u8 = 254;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Result of a comparison.
pub(super) struct Comparison {
    pub(super) text: String,
    pub(super) is_good: bool,
}

/// Compares the input of a piece with its preview and its drawing, both as SVG, and with the
/// estimate.
pub(super) fn compare_piece(
    piece: &Piece,
    input: &[u8],
    preview_svg: &str,
    result_svg: &str,
    estimate: &Value,
) -> Result<Comparison> {
    if !piece.makes_marks() {
        return Ok(Comparison {
            text: "It leaves no mark; the tests hold the path of the virtual arm's tool against the preview's.".to_owned(),
            is_good: true,
        });
    }
    let drawing = Drawing::from(strokes(result_svg)?);
    let result_lines = lines_of(&drawing);
    let bounds = drawing.bounds().ok_or("nothing was left")?;
    let off = max_offset(bounds, &estimate["bounds"]).ok_or("no bounds")?;
    // Dots appear as markers in a preview, and not as lines.
    let lines: Vec<Line> = { result_lines.iter() }
        .filter(|line| line.len() > 1)
        .cloned()
        .collect();
    let shown = fit_to(
        visible_lines(preview_svg)?,
        bounds_of(&lines).ok_or("no lines were left")?,
    )?;
    let matched = compare(&shown, &lines, PREVIEW_TOLERANCE).matched;
    let mut text = format!("Preview and result: {}", share(&matched));
    let mut is_good = matched.is_good() && off <= TOLERANCE;
    if off > TOLERANCE {
        text += &format!(" Its place is {off:.2} mm off.");
    }
    match &piece.input {
        Input::Lines(_, reader) if reader.is_independent() => {
            let source = reader.lines(input)?;
            let source: Vec<Line> = source.into_iter().map(|(_, line)| line).collect();
            let matched = compare(
                &move_to_estimate(source, estimate)?,
                &result_lines,
                TOLERANCE,
            )
            .matched;
            text += &format!(
                " File and result: {} At most {:.2} mm off, {:.3} mm in the mean, with pixels of {:.2} mm.",
                share(&matched),
                matched.worst(),
                matched.mean,
                matched.pixel
            );
            is_good &= matched.is_good();
        }
        Input::Tones(file, [width, spacing]) => {
            let content = read(Format::Image, input, &ReadOptions::default())?.content;
            let Content::Image(image) = content else {
                return Err(format!("{file} is no image").into());
            };
            let size = image.size(Size::Width(*width))?;
            // The middle of the marks is there; white margins do not count.
            let middle = middle_of(estimate)?;
            let off = middle_of_marks(&image);
            let corners = [0.0, 1.0]
                .map(|side| [0, 1].map(|axis| middle[axis] + (side - off[axis]) * size[axis]));
            let burnt = Tones::of_burns(&drawing, corners, CELL_SIZE, *spacing);
            let matched = burnt.difference(&Tones::of_image(&image, corners, CELL_SIZE));
            let matched = matched.ok_or("grids that differ")?;
            text += &format!(
                " The darkness of the result differs from the file's by {:.1} % of black in the mean, by {:.1} % at most.",
                100.0 * matched.mean,
                100.0 * matched.worst,
            );
            is_good &= matched.mean < TONE_TOLERANCE;
        }
        _ => {}
    }
    Ok(Comparison { text, is_good })
}

/// Returns the mean position of all pixels other than white, as shares of the width and, from the
/// lower edge, of the height.
fn middle_of_marks(image: &Raster) -> [f64; 2] {
    let marked = image.grey.iter().enumerate();
    let marked = marked.filter(|(_, grey)| **grey < WHITE_LEVEL);
    let [mut low, mut high] = [[usize::MAX; 2], [0; 2]];
    for (at, _) in marked {
        let place = [at % image.width, image.height - 1 - at / image.width];
        for axis in [0, 1] {
            low[axis] = low[axis].min(place[axis]);
            high[axis] = high[axis].max(place[axis] + 1);
        }
    }
    let sides = [image.width, image.height];
    [0, 1].map(|axis| f64::midpoint(low[axis] as f64, high[axis] as f64) / sides[axis] as f64)
}

fn share(matched: &Match) -> String {
    format!(
        "{:.2} % of the first is there, {:.2} % of the second is too much.",
        100.0 * (1.0 - matched.missing_share),
        100.0 * matched.extra_share
    )
}

/// Returns the strokes of a picture as the command writes it: paths of straight segments, with y
/// downwards.
fn strokes(svg: &str) -> Result<Vec<Stroke>> {
    let mut strokes = Vec::new();
    for path in svg.split("<path ").skip(1) {
        let path = path.split("/>").next().unwrap_or_default();
        let data = attribute(path, "d").ok_or("a path without data")?;
        let power = match attribute(path, "stroke-opacity") {
            Some(share) => 100.0 * share.parse::<f64>()?,
            None => 100.0,
        };
        // A dot is a line of zero length.
        let data = data.trim_start_matches('M').trim_end_matches("h0");
        let points = data.split('L').map(|point| {
            let (x, y) = point.split_once(' ').ok_or("a point of one number")?;
            Ok([x.parse::<f64>()?, -y.parse::<f64>()?])
        });
        let burnt = path.contains("stroke-opacity");
        strokes.push(Stroke {
            kind: if burnt {
                StrokeKind::Burn
            } else {
                StrokeKind::Ink
            },
            power,
            points: points.collect::<Result<_>>()?,
        });
    }
    Ok(strokes)
}

fn attribute<'a>(element: &'a str, name: &str) -> Option<&'a str> {
    let rest = element.split(&format!("{name}=\"")).nth(1)?;
    rest.split('"').next()
}

/// Returns the lines of a preview that leave a mark.
fn visible_lines(preview: &str) -> Result<Vec<Line>> {
    let head = preview.split_inclusive('>').next().unwrap_or_default();
    let leaves = |line: &&str| {
        ["class=\"drawn\"", "class=\"burnt\""]
            .iter()
            .any(|class| line.contains(class))
    };
    let paths: String = preview.lines().filter(leaves).map(path_element).collect();
    Ok(svg_lines(format!("{head}{paths}</svg>").as_bytes())?)
}

/// Returns the path of a line of SVG that also opens and closes other elements.
fn path_element(line: &str) -> &str {
    let from = line.find("<path").unwrap_or(0);
    let to = line.rfind("/>").map_or(line.len(), |at| at + 2);
    line.get(from..to).unwrap_or_default()
}

/// Fits lines into these bounds, because a preview has its own scale and position.
fn fit_to(mut lines: Vec<Line>, [low, high]: [[f64; 2]; 2]) -> Result<Vec<Line>> {
    let [from, to] = bounds_of(&lines).ok_or("a preview without lines")?;
    let width = |[low, high]: [[f64; 2]; 2], axis: usize| high[axis] - low[axis];
    let long = if width([low, high], 0) > width([low, high], 1) {
        0
    } else {
        1
    };
    let scale = width([low, high], long) / width([from, to], long).max(f64::MIN_POSITIVE);
    for point in lines.iter_mut().flatten() {
        *point = [0, 1].map(|axis| {
            f64::midpoint(low[axis], high[axis])
                + scale * (point[axis] - f64::midpoint(from[axis], to[axis]))
        });
    }
    Ok(lines)
}

/// Moves the lines of a file to the place in its estimate.
fn move_to_estimate(mut lines: Vec<Line>, estimate: &Value) -> Result<Vec<Line>> {
    if estimate["placed"].is_null() {
        return Ok(lines);
    }
    let number = |name: &str| estimate["placed"][name].as_f64().ok_or("no place");
    let (scale, turn, at) = (
        number("scale")?,
        number("turn")?.to_radians(),
        middle_of(estimate)?,
    );
    let [low, high] = bounds_of(&lines).ok_or("a file without lines")?;
    for point in lines.iter_mut().flatten() {
        let [x, y] =
            [0, 1].map(|axis| scale * (point[axis] - f64::midpoint(low[axis], high[axis])));
        *point = [
            at[0] + x * turn.cos() - y * turn.sin(),
            at[1] + x * turn.sin() + y * turn.cos(),
        ];
    }
    Ok(lines)
}

fn middle_of(estimate: &Value) -> Result<[f64; 2]> {
    let side = |axis: usize| estimate["placed"]["at"][axis].as_f64().ok_or("no middle");
    Ok([side(0)?, side(1)?])
}

fn bounds_of(lines: &[Line]) -> Option<[[f64; 2]; 2]> {
    let first = *lines.iter().flatten().next()?;
    let points = lines.iter().flatten();
    Some(points.fold([first, first], |[low, high], point| {
        [
            [low[0].min(point[0]), low[1].min(point[1])],
            [high[0].max(point[0]), high[1].max(point[1])],
        ]
    }))
}

/// Returns the largest deviation of the drawing's sides from the estimate, mm.
fn max_offset([low, high]: [[f64; 2]; 2], bounds: &Value) -> Option<f64> {
    let mut worst: f64 = 0.0;
    for (axis, name) in ["x", "y"].into_iter().enumerate() {
        for (side, actual) in [low[axis], high[axis]].into_iter().enumerate() {
            worst = worst.max((bounds[name][side].as_f64()? - actual).abs());
        }
    }
    Some(worst)
}

/// Independent reader of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reader {
    Svg,
    Hpgl,
    Gcode,
    /// Our own reader: there is no other one here, so nothing is compared.
    Dxf,
}

impl Reader {
    pub(super) fn is_independent(self) -> bool {
        self != Self::Dxf
    }

    /// Returns the lines of a file, each with its darkness up to 1.
    pub(super) fn lines(self, bytes: &[u8]) -> Result<Vec<(f64, Line)>> {
        let black = |lines: Vec<Line>| lines.into_iter().map(|line| (1.0, line)).collect();
        Ok(match self {
            Self::Svg => black(source::svg(bytes)?),
            Self::Hpgl => black(source::hpgl(std::str::from_utf8(bytes)?)),
            Self::Gcode => source::gcode(std::str::from_utf8(bytes)?),
            Self::Dxf => match read(Format::Dxf, bytes, &ReadOptions::default())?.content {
                Content::Artwork(artwork) => black(
                    artwork
                        .strokes
                        .into_iter()
                        .map(|stroke| stroke.points)
                        .collect(),
                ),
                _ => return Err("a DXF file without lines".into()),
            },
        })
    }
}
