//! Reader of test grids: options as JSON, laid out as cells and labels.

use super::{Content, Parsed, ReadOptions};
use crate::encoding::{Fallback, decode};
use crate::lettering::lay_out;
use crate::testgrid::{TestGrid, TestGridOptions};
use crate::{BundledFont, Diagnostic, FontChoice, Origin, TextOptions};
use magician_host::message;

/// Height of a label, in sides of a cell.
const LABEL_HEIGHT: f64 = 0.25;
/// Gap between labels and cells, in sides of a cell.
const LABEL_GAP: f64 = 0.2;
/// Largest width of a label, in sides of a cell. Wider labels are scaled down; at 1.1 neighbours
/// still have a gap because cells are 1.25 sides apart ([`TestGrid::PITCH`]).
const MAX_LABEL_WIDTH: f64 = 1.1;
/// Flattening tolerance of the labels, mm.
const LABEL_TOLERANCE: f64 = 0.02;

pub(super) fn read(bytes: &[u8], options: &ReadOptions) -> Result<Parsed, Diagnostic> {
    let text = decode(bytes, Fallback::Refused)?.text;
    let wanted: TestGridOptions = serde_json::from_str(&text).map_err(|error| {
        let number = |value: usize| u32::try_from(value).unwrap_or(u32::MAX);
        let origin = Origin {
            line: number(error.line()),
            column: number(error.column()),
            ..Origin::NONE
        };
        Diagnostic::new(
            origin,
            message!("this is no test grid: {error}", error = error_text(&error)),
        )
    })?;
    wanted
        .check()
        .map_err(|(_, message)| Diagnostic::of_file(message))?;
    let title = match options.title.as_str() {
        "" => "test grid",
        title => title,
    };
    Ok(Parsed {
        content: Content::TestGrid(laid_out(title, wanted)?),
        notes: Vec::new(),
    })
}

/// Message of a serde error without the place, which the diagnostic carries itself.
fn error_text(error: &serde_json::Error) -> String {
    let text = error.to_string();
    text.split(" at line ").next().unwrap_or(&text).to_owned()
}

fn laid_out(title: &str, options: TestGridOptions) -> Result<TestGrid, Diagnostic> {
    let cell = options.cell;
    let pitch = TestGrid::PITCH * cell;
    let (powers, speeds) = (options.power.numbers(), options.speed.numbers());
    let across = |count: usize| count.saturating_sub(1) as f64 * pitch + cell;
    let mut grid = TestGrid {
        title: title.to_owned(),
        size: [across(powers.len()), across(speeds.len())],
        corner: [0.0; 2],
        labels: Vec::new(),
        options,
    };
    if !grid.options.labels {
        return Ok(grid);
    }
    let power = powers
        .iter()
        .map(|power| Label::new(&format!("{power}%"), cell));
    let speed = speeds
        .iter()
        .map(|speed| Label::new(&speed.to_string(), cell));
    let (power, speed) = (
        power.collect::<Result<Vec<_>, _>>()?,
        speed.collect::<Result<Vec<_>, _>>()?,
    );
    let unit = Label::new("mm/s", cell)?;
    let widest = speed
        .iter()
        .chain([&unit])
        .map(|label| label.size[0])
        .fold(0.0, f64::max);
    let highest = power
        .iter()
        .chain([&unit])
        .map(|label| label.size[1])
        .fold(0.0, f64::max);
    let [left, top] = [widest, highest].map(|side| side + LABEL_GAP * cell);
    grid.corner = [left, top];
    // The label of the last column may be wider than its cell and stick out to the right.
    let last = power
        .last()
        .map_or(0.0, |label| (label.size[0] - cell).max(0.0) / 2.0);
    grid.size = [grid.size[0] + left + last, grid.size[1] + top];
    let middle = |nth: usize| nth as f64 * pitch + cell / 2.0;
    for (nth, label) in power.iter().enumerate() {
        label.put(
            &mut grid.labels,
            [
                left + middle(nth) - label.size[0] / 2.0,
                highest - label.size[1],
            ],
        );
    }
    for (nth, label) in speed.iter().enumerate() {
        label.put(
            &mut grid.labels,
            [
                widest - label.size[0],
                top + middle(nth) - label.size[1] / 2.0,
            ],
        );
    }
    unit.put(
        &mut grid.labels,
        [widest - unit.size[0], highest - unit.size[1]],
    );
    Ok(grid)
}

/// Polylines of a label, y down from its upper left corner.
struct Label {
    lines: Vec<Vec<[f64; 2]>>,
    size: [f64; 2],
}

impl Label {
    fn new(text: &str, cell: f64) -> Result<Self, Diagnostic> {
        let font = FontChoice::Bundled(BundledFont::Sans).load()?;
        let options = TextOptions {
            size: LABEL_HEIGHT * cell,
            ..TextOptions::default()
        };
        let lines = lay_out(text, &font, &options, LABEL_TOLERANCE)?.lines;
        let mut lines: Vec<_> = lines.into_iter().map(|line| line.points).collect();
        let points = || lines.iter().flatten();
        let bound = |axis: usize, pick: fn(f64, f64) -> f64| {
            points()
                .map(|point| point[axis])
                .reduce(pick)
                .unwrap_or_default()
        };
        let ([left, low], [right, high]) = (
            [0, 1].map(|axis| bound(axis, f64::min)),
            [0, 1].map(|axis| bound(axis, f64::max)),
        );
        let scale = (MAX_LABEL_WIDTH * cell / (right - left)).min(1.0);
        for [x, y] in lines.iter_mut().flatten() {
            (*x, *y) = ((*x - left) * scale, (high - *y) * scale);
        }
        Ok(Self {
            lines,
            size: [(right - left) * scale, (high - low) * scale],
        })
    }

    fn put(&self, all: &mut Vec<Vec<[f64; 2]>>, [right, down]: [f64; 2]) {
        let moved =
            |line: &Vec<[f64; 2]>| line.iter().map(|[x, y]| [x + right, y + down]).collect();
        all.extend(self.lines.iter().map(moved));
    }
}
