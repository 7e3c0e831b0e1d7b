//! One program: read, planned, run on the virtual arm and compared with its input.

use std::error::Error;
use std::time::Duration;

use magician::sim::world::{Drawing, StrokeKind};
use magician_program::artwork::{Layout, Marking};
use magician_program::compare::{Match, Tones, compare, lines_of};
use magician_program::preview::{Preview, PreviewOptions};
use magician_program::raster::{Engrave, Grid, Size};
use magician_program::rehearse::{Rehearsal, RehearseOptions, rehearse, stands};
use magician_program::{Artwork, Content, Format, Plan, Raster, ReadOptions, Surface, check, read};
use magician_sim::svg::FONTS;
use magician_sim::svg::palette::{BURNT, DRAWN};

use super::Program;
use super::sheet::{Ink, around, draw};
use super::source::{self, Line};

/// The height of paper and wood, mm.
const TABLE: f64 = -60.0;
/// A place of one picture matches if the other has something so near, mm.
const TOLERANCE: f64 = 0.1;
/// Free space round a picture that has no page, mm.
const MARGIN: f64 = 5.0;
/// Width of the engraved image, from line to line, and of the cells in which it is compared, mm.
const WIDTH: f64 = 32.0;
const SPACING: f64 = 0.25;
const CELL: f64 = 1.0;
/// What cells may differ in the mean, as a share of black: half a step of an 8-bit grey is 0.002.
const TONE: f64 = 0.02;
/// Steps of darkness in a picture.
const SHADES: usize = 20;

/// What came of a program.
pub(crate) struct Trial {
    pub(crate) input: Vec<u8>,
    /// The ending of its name.
    pub(crate) input_is: &'static str,
    pub(crate) drawn: String,
    /// How well it matches, in words.
    pub(crate) figures: String,
    pub(crate) is_good: bool,
}

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Runs a program.
pub(crate) fn run(program: &Program, bytes: &[u8]) -> Result<Trial> {
    let mut options = ReadOptions::default();
    options.title = program.file.to_owned();
    match read(program.format, bytes, &options)?.content {
        Content::Artwork(artwork) => drawn(program, bytes, &artwork),
        Content::Image(image) => engraved(bytes, &image),
        Content::Plan(plan) if program.format == Format::Playback => played(&plan),
        Content::Plan(plan) => followed(bytes, &plan),
        _ => Err("nothing that the gallery knows".into()),
    }
}

/// A drawing on a sheet.
fn drawn(program: &Program, bytes: &[u8], artwork: &Artwork) -> Result<Trial> {
    let marking = Marking::pen();
    let placed = artwork.placed(&Layout::on(Surface::level(TABLE)), &marking)?;
    let plan = placed.plan(&marking);
    let [low, high] = artwork.bounds().ok_or("an empty drawing")?;
    let to_arm = |point: [f64; 2]| {
        [0, 1].map(|axis| {
            placed.middle[axis] + placed.scale * (point[axis] - (low[axis] + high[axis]) / 2.0)
        })
    };
    let mut source = match program.format {
        Format::Svg => source::svg(bytes)?,
        _ => source::hpgl(std::str::from_utf8(bytes)?),
    };
    for point in source.iter_mut().flatten() {
        *point = to_arm(*point);
    }
    let frame = match artwork.page {
        Some(page) => [[0.0, 0.0], page].map(to_arm),
        None => around(source.iter().map(Vec::as_slice), MARGIN),
    };
    let (input, input_is) = match program.format {
        Format::Svg => (bytes.to_vec(), "svg"),
        _ => (lines(frame, &source).into_bytes(), "svg"),
    };
    let done = done(&plan)?;
    let matched = compare(&source, &lines_of(&done.drawing), TOLERANCE).matched;
    Ok(Trial {
        input,
        input_is,
        drawn: picture(frame, &done.drawing),
        figures: format!("{} {}", told(&matched), took(&done)),
        is_good: matched.is_good() && done.is_good(),
    })
}

/// A program in the arm's own coordinates that draws or burns.
fn followed(bytes: &[u8], plan: &Plan) -> Result<Trial> {
    let source = source::gcode(std::str::from_utf8(bytes)?);
    let frame = around(source.iter().map(Vec::as_slice), MARGIN);
    let done = done(plan)?;
    let matched = compare(&source, &lines_of(&done.drawing), TOLERANCE).matched;
    Ok(Trial {
        input: lines(frame, &source).into_bytes(),
        input_is: "svg",
        drawn: picture(frame, &done.drawing),
        figures: format!("{} {}", told(&matched), took(&done)),
        is_good: matched.is_good() && done.is_good(),
    })
}

/// An image.
fn engraved(bytes: &[u8], image: &Raster) -> Result<Trial> {
    let mut engrave = Engrave::default();
    engrave.spacing = SPACING;
    let size = image.size(Size::Width(WIDTH))?;
    let surface = Surface::level(TABLE);
    let frame = engrave.frame(size);
    let placed = frame.placed(&Layout::on(surface), &Marking::laser(100.0))?;
    let grid = Grid::of_frame(&placed.artwork).ok_or("no frame")?;
    let plan = image.plan(&grid, surface, &engrave)?;
    let done = done(&plan)?;
    let corners = [grid.at([0.0, 1.0]), grid.at([1.0, 0.0])];
    let burnt = Tones::of_burns(&done.drawing, corners, CELL, SPACING);
    let matched = burnt.difference(&Tones::of_image(image, corners, CELL));
    let matched = matched.ok_or("grids that differ")?;
    let figures = format!(
        "Darkness differs by {:.1} % of black in the mean, by {:.1} % at most. {}",
        100.0 * matched.mean,
        100.0 * matched.worst,
        took(&done)
    );
    Ok(Trial {
        input: bytes.to_vec(),
        input_is: "png",
        drawn: picture(corners, &done.drawing),
        figures,
        is_good: matched.mean < TONE && done.is_good(),
    })
}

/// What leaves nothing but a way.
fn played(plan: &Plan) -> Result<Trial> {
    let options = RehearseOptions::default();
    let start = stands(plan, &options)?;
    let report = check(plan, &start);
    let preview = Preview::new(plan, &report, &start, &PreviewOptions::default());
    let watched = rehearse(plan, &options.watch(Duration::from_millis(2)))?;
    let way: Line = watched.way.iter().map(|[x, y, _]| [*x, *y]).collect();
    let shown: Vec<Line> = preview.ways().map(<[_]>::to_vec).collect();
    let matched = compare(&shown, &[way], TOLERANCE).matched;
    let figures = format!(
        "The path of the virtual arm's tool is within {:.2} mm of the one shown. {}",
        matched.worst(),
        took(&watched)
    );
    Ok(Trial {
        input: points(plan).into_bytes(),
        input_is: "svg",
        drawn: preview.to_svg().to_owned(),
        figures,
        is_good: matched.is_good() && watched.is_good(),
    })
}

fn done(plan: &Plan) -> Result<Rehearsal> {
    Ok(rehearse(plan, &RehearseOptions::default())?)
}

fn told(matched: &Match) -> String {
    format!(
        "{:.2} % of the input is drawn, {:.2} % of what is drawn is too much (within {TOLERANCE} mm); at most {:.2} mm off, \
         {:.3} mm in the mean, with pixels of {:.2} mm.",
        100.0 * (1.0 - matched.missing_share),
        100.0 * matched.extra_share,
        matched.worst(),
        matched.mean,
        matched.pixel
    )
}

fn took(done: &Rehearsal) -> String {
    format!("{} steps in {:.1} s.", done.steps, done.time.as_secs_f64())
}

/// Lines of a source.
fn lines(frame: [[f64; 2]; 2], lines: &[Line]) -> String {
    let ink = Ink {
        colour: DRAWN,
        width: 0.5,
        opacity: 1.0,
        round: true,
        lines: lines.iter().map(Vec::as_slice).collect(),
    };
    draw(frame, &[ink], |_| {})
}

/// What pen and laser have left.
fn picture(frame: [[f64; 2]; 2], drawing: &Drawing) -> String {
    let strokes = drawing.strokes();
    let of = |wanted: &dyn Fn(StrokeKind, f64) -> bool| {
        let wanted = strokes
            .iter()
            .filter(|stroke| wanted(stroke.kind, stroke.power));
        wanted.map(|stroke| stroke.points.as_slice()).collect()
    };
    let shade = |power: f64| (power / 100.0 * SHADES as f64).ceil() as usize;
    let mut inks = vec![Ink {
        colour: DRAWN,
        width: 0.5,
        opacity: 1.0,
        round: true,
        lines: of(&|kind, _| kind == StrokeKind::Ink),
    }];
    inks.extend((1..=SHADES).map(|nth| Ink {
        colour: BURNT,
        // No hairline of white between two lines.
        width: 1.08 * SPACING,
        round: false,
        opacity: nth as f64 / SHADES as f64,
        lines: of(&|kind, power| kind == StrokeKind::Burn && shade(power) == nth),
    }));
    draw(frame, &inks, |_| {})
}

/// The points of a plan, with their names.
fn points(plan: &Plan) -> String {
    let targets = plan.steps.iter().filter_map(|step| {
        let [x, y, _] = step.action.target()?;
        Some((
            [f64::from(x), f64::from(y)],
            plan.name_of(&step.origin).unwrap_or_default(),
        ))
    });
    let targets: Vec<_> = targets.collect();
    let places: Vec<_> = targets.iter().map(|(place, _)| *place).collect();
    let frame = around([places.as_slice()], 25.0);
    draw(frame, &[], |svg| {
        let mut named: Vec<[f64; 2]> = Vec::new();
        for ([x, y], name) in &targets {
            svg.circle([*x, -y], 1.4, &[("fill", DRAWN)]);
            if !name.is_empty() && !named.contains(&[*x, *y]) {
                let look = [("font-family", FONTS), ("font-size", "6"), ("fill", DRAWN)];
                svg.label([x + 3.0, 2.0 - y], name, &look);
                named.push([*x, *y]);
            }
        }
    })
}
