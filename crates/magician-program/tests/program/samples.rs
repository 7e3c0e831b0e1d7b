//! Every sample as it is: read, placed, checked, drawn on the virtual arm, and the result compared
//! with its source.

use std::path::Path;
use std::time::Duration;

use magician::blocking::Arm;
use magician::preflight::Preflight;
use magician::sim::world::StrokeKind;
use magician::{Options, Set};
use magician_picture::compare::{Match, Tones, compare, lines_of};
use magician_picture::{Preview, PreviewOptions};
use magician_program::artwork::{Layout, Marking};
use magician_program::raster::{Engrave, Grid, Size};
use magician_program::rehearse::{Rehearsal, RehearseOptions, rehearse, stage};
use magician_program::{
    Action, Artwork, Content, Format, Plan, Raster, ReadOptions, Report, Surface, check, read,
};

/// Readers that share only the SVG parser with those under test.
#[path = "../../../../xtask/src/workshop/source.rs"]
mod source;

use source::Line;

/// Height of paper and wood, mm.
const TABLE: f64 = -60.0;
/// Largest distance of a line from its curve, mm: the default for reading.
const TOLERANCE: f64 = 0.05;
/// Largest distance of the drawing from its source, mm: tolerance of curves, accuracy of a drawing
/// (0.02), and a pixel's diagonal.
const DRAWING_TOLERANCE: f64 = TOLERANCE + 0.02 + 0.071;
/// Width of an image, mm.
const WIDTH: f64 = 16.0;
/// Distance of its engraved lines, mm.
const SPACING: f64 = 0.25;
/// Largest mean error of its tones, as a share of black.
const TONE_TOLERANCE: f64 = 0.02;

fn bytes_of(name: &str) -> Vec<u8> {
    let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples");
    std::fs::read(samples.join(name)).unwrap()
}

fn content(name: &str) -> (Format, Vec<u8>, Content) {
    let bytes = bytes_of(name);
    let format = Format::of(name, &bytes).expect("a format");
    let mut options = ReadOptions::default();
    options.title = name.to_owned();
    options.tolerance = TOLERANCE;
    let reading = read(format, &bytes, &options);
    let reading = reading.unwrap_or_else(|diagnostic| panic!("{name}: {diagnostic}"));
    (format, bytes, reading.content)
}

/// Start pose as reported by the virtual arm.
fn start(plan: &Plan) -> Preflight {
    let arm = stage(plan, &RehearseOptions::default()).unwrap();
    let arm = Arm::simulated(arm, Options::default()).unwrap();
    let commands: Vec<Set> = plan.commands().collect();
    arm.preflight_for(&commands).unwrap()
}

/// Checks a plan, runs it on the virtual arm, and again from its plan file: it passes, takes as
/// long as the check says, and leaves the same marks.
fn rehearsed(name: &str, plan: &Plan) -> (Rehearsal, Report) {
    let options = RehearseOptions::default();
    let report = check(plan, &start(plan));
    assert!(report.is_good(), "{name}: {:?}", report.refused_steps);
    let done = rehearse(plan, &options).unwrap();
    assert!(done.is_good(), "{name}: {:?} {:?}", done.alarms, done.log);
    assert_eq!(done.steps, plan.steps.len(), "{name}");
    // The duration of homing is unknown in advance.
    let homes = plan.steps.iter().any(|step| step.action == Action::Home);
    let time = Some(done.time).filter(|_| !homes);
    assert_eq!(report.time, time, "{name}");
    let json = plan.to_json();
    let again = read(Format::Plan, json.as_bytes(), &ReadOptions::default()).unwrap();
    let Content::Plan(again) = again.content else {
        panic!("a plan file is a plan")
    };
    assert_eq!(&again, plan, "{name}");
    let redone = rehearse(&again, &options).unwrap();
    assert_eq!(redone.drawing, done.drawing, "{name}");
    assert_eq!((redone.time, redone.pose), (done.time, done.pose), "{name}");
    (done, report)
}

fn print_figures(name: &str, how: &str, matched: &Match, done: &Rehearsal) {
    println!(
        "{name} {how}: missing {:.4} %, too much {:.4} %, worst {:.3} mm, mean {:.4} mm (pixels of {:.2} mm); {} steps, {:.3} s",
        100.0 * matched.missing_share,
        100.0 * matched.extra_share,
        matched.worst(),
        matched.mean,
        matched.pixel,
        done.steps,
        done.time.as_secs_f64()
    );
}

fn matches_source(name: &str, how: &str, source: &[Line], done: &Rehearsal) {
    assert!(!source.is_empty() && !done.drawing.is_empty(), "{name}");
    let matched = compare(source, &lines_of(&done.drawing), DRAWING_TOLERANCE).matched;
    print_figures(name, how, &matched, done);
    assert!(matched.is_good(), "{name} {how}: {matched:?}");
    assert!(
        matched.worst() <= DRAWING_TOLERANCE && matched.mean < 0.05,
        "{name} {how}: {matched:?}"
    );
}

/// Draws lines on a sheet with the pen, and burns them with the laser.
fn artwork(name: &str, artwork: &Artwork, source: &[Line]) {
    let [low, high] = artwork.bounds().expect("lines");
    for (how, marking, kind) in [
        ("drawn", Marking::pen(), StrokeKind::Ink),
        ("burnt", Marking::laser(80.0), StrokeKind::Burn),
    ] {
        let placed = artwork.placed(&Layout::on(Surface::level(TABLE)), &marking);
        let placed = placed.unwrap_or_else(|diagnostic| panic!("{name}: {diagnostic}"));
        assert_eq!(placed.scale, 1.0, "{name} is in true size");
        let to_arm = |point: &[f64; 2]| {
            [0, 1].map(|axis| placed.middle[axis] + point[axis] - (low[axis] + high[axis]) / 2.0)
        };
        let source: Vec<Line> = (source.iter())
            .map(|line| line.iter().map(to_arm).collect())
            .collect();
        let (done, report) = rehearsed(name, &placed.plan(&marking));
        assert!(
            done.drawing
                .strokes()
                .iter()
                .all(|stroke| stroke.kind == kind)
        );
        matches_source(name, how, &source, &done);
        takes_checked_time(name, &done, &report);
    }
}

fn takes_checked_time(name: &str, done: &Rehearsal, report: &Report) {
    let drawn: f64 = lines_of(&done.drawing)
        .iter()
        .map(|line| length(line))
        .sum();
    assert!(
        (drawn / report.drawn - 1.0).abs() < 1e-3,
        "{name}: {drawn} {}",
        report.drawn
    );
}

fn length(line: &[[f64; 2]]) -> f64 {
    let pairs = line.iter().zip(line.iter().skip(1));
    pairs.map(|(a, b)| (b[0] - a[0]).hypot(b[1] - a[1])).sum()
}

/// Checks for a program without marks that the preview shows the path of the virtual arm's tool.
fn check_path(name: &str, plan: &Plan) {
    let options = RehearseOptions::default();
    let start = start(plan);
    let (_, report) = rehearsed(name, plan);
    let preview = Preview::new(plan, &report, &start, &PreviewOptions::default());
    let watched = rehearse(plan, &options.watch(Duration::from_millis(2))).unwrap();
    let taken: Line = watched.way.iter().map(|[x, y, _]| [*x, *y]).collect();
    let shown: Vec<Line> = preview.paths().map(<[_]>::to_vec).collect();
    let matched = compare(&shown, &[taken], DRAWING_TOLERANCE).matched;
    print_figures(name, "way", &matched, &watched);
    // A preview does not show the search for the home position.
    let homes = plan.steps.iter().any(|step| step.action == Action::Home);
    assert_eq!(matched.missing_share, 0.0, "{name}: {matched:?}");
    assert!(homes || matched.is_good(), "{name}: {matched:?}");
    // Every point in the file is passed.
    for [x, y, z] in plan.steps.iter().filter_map(|step| step.action.target()) {
        let nearest = watched.way.iter().map(|at| {
            let off = [
                at[0] - f64::from(x),
                at[1] - f64::from(y),
                at[2] - f64::from(z),
            ];
            off.iter().map(|off| off * off).sum::<f64>().sqrt()
        });
        let nearest = nearest.fold(f64::INFINITY, f64::min);
        assert!(
            nearest < 0.6,
            "{name}: nowhere nearer than {nearest} mm to {x} {y} {z}"
        );
    }
}

/// Engraves a grey image.
fn image(name: &str, image: &Raster) {
    let mut engrave = Engrave::default();
    engrave.spacing = SPACING;
    let size = image.size(Size::Width(WIDTH)).unwrap();
    let surface = Surface::level(TABLE);
    let grid = Grid::centred(size, [240.0, 0.0], 0.0, false);
    let plan = engrave.plan(image, &grid, surface).unwrap();
    let (done, _) = rehearsed(name, &plan);
    let corners = [grid.at([0.0, 1.0]), grid.at([1.0, 0.0])];
    let burnt = Tones::of_burns(&done.drawing, corners, 1.0, SPACING);
    let matched = burnt
        .difference(&Tones::of_image(image, corners, 1.0))
        .unwrap();
    println!(
        "{name}: darkness differs by {:.2} % of black in the mean, {:.2} % at most; {} steps, {:.3} s",
        100.0 * matched.mean,
        100.0 * matched.worst,
        done.steps,
        done.time.as_secs_f64()
    );
    assert!(matched.mean < TONE_TOLERANCE, "{matched:?}");
}

fn sample(name: &str) {
    let (format, bytes, content) = content(name);
    let text = || std::str::from_utf8(&bytes).unwrap();
    match content {
        Content::Plan(plan) => match format {
            Format::Gcode => {
                let (done, report) = rehearsed(name, &plan);
                takes_checked_time(name, &done, &report);
                let source: Vec<Line> = source::gcode(text())
                    .into_iter()
                    .map(|(_, line)| line)
                    .collect();
                matches_source(name, "followed", &source, &done);
            }
            _ => check_path(name, &plan),
        },
        Content::Artwork(lines) => {
            let source = match format {
                Format::Svg => source::svg(&bytes).unwrap(),
                Format::Hpgl => source::hpgl(text()),
                // The reader has its own tests; this one is about its lines.
                _ => lines
                    .strokes
                    .iter()
                    .map(|stroke| stroke.points.clone())
                    .collect(),
            };
            artwork(name, &lines, &source);
        }
        Content::Image(grey) => image(name, &grey),
        other => panic!("{name}: {other:?}"),
    }
}

/// Defines a test per sample, so that they run in parallel and are counted.
macro_rules! samples {
    ($($test:ident $name:literal)*) => {
        const NAMES: &[&str] = &[$($name),*];
        $(#[test]
        fn $test() {
            sample($name);
        })*
    };
}

samples! {
    gripper_pick "gripper_pick_v194.playback"
    suction_points "suction_points_v194.playback"
    arcs_and_lines "arc_movl_v1412.playback"
    jumps "jump_suction_named_v170.playback"
    blocks "example_loop.blockly"
    house "house.svg"
    curves "curves.svg"
    rabbit "rabbit.svg"
    star "star.plt"
    pen "pen_outline.gcode"
    laser "laser_checker.gcode"
    plate "plate.dxf"
    logo "logo.svg"
    gradient "engrave_gradient.png"
    landscape "landscape.png"
}

#[test]
fn every_sample_is_covered() {
    let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples");
    let mut found: Vec<String> = std::fs::read_dir(samples)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| !name.ends_with(".md"))
        .collect();
    found.sort();
    let mut known = NAMES.to_vec();
    known.sort_unstable();
    assert_eq!(found, known);
}
