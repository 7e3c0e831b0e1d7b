//! What the laser of a virtual arm leaves of an image.

use magician::sim::Scenario;
use magician::words::Preflight;
use magician::{JointAngles, Options, VirtualArm, blocking::Arm};
use magician_sim::world::{Stroke, StrokeKind};

use super::*;
use crate::{Content, Format, Plan, ReadOptions, Surface, Tool, check, read};

const GRADIENT: &[u8] = include_bytes!("../../samples/engrave_gradient.png");
const SURFACE: Surface = Surface::level(-60.0);

fn gradient() -> Raster {
    let read = read(Format::Image, GRADIENT, &ReadOptions::default()).unwrap();
    match read.content {
        Content::Image(image) => image,
        other => panic!("{other:?}"),
    }
}

fn centred(image: &Raster, size: Size) -> Grid {
    Grid::centred(image.size(size).unwrap(), [250.0, 20.0], 0.0, false)
}

/// What the laser of a virtual arm has burnt when it has done all of it.
fn burnt(plan: &Plan) -> Vec<Stroke> {
    let start = Preflight::at(JointAngles::HOME, Tool::None.bias());
    let report = check(plan, &start);
    assert!(report.is_good(), "{:?}", report.complaints);

    let scenario = "arm = { homed = true }\ntool = { kind = \"laser\" }\ntable = { height = -60 }";
    let cell = VirtualArm::in_scenario(&Scenario::from_toml(scenario).unwrap());
    let arm = Arm::simulated(cell.clone(), Options::default()).unwrap();
    arm.clear_alarms().unwrap();
    let commands: Vec<_> = plan.commands().collect();
    arm.perform(&commands).unwrap();
    assert!(arm.alarms().unwrap().is_empty());
    let strokes = cell.with(|arm| arm.drawing().strokes().to_vec());
    assert!(strokes.iter().all(|stroke| stroke.kind == StrokeKind::Burn));
    strokes
}

/// Mean power in each cell of a picture so many cells wide and high, of lines that lie so far apart.
fn picture(strokes: &[Stroke], grid: &Grid, [columns, rows]: [usize; 2], lines: usize) -> Vec<f64> {
    let mut cells = vec![0.0; columns * rows];
    let [width, height] = grid.size();
    for stroke in strokes {
        for pair in stroke.points.windows(2) {
            let share = |[x, y]: [f64; 2]| {
                let off = [x - grid.origin[0], y - grid.origin[1]];
                let along = |side: [f64; 2], length: f64| {
                    (off[0] * side[0] + off[1] * side[1]) / (length * length)
                };
                [along(grid.across, width), along(grid.down, height)]
            };
            let [from, to] = [share(pair[0]), share(pair[1])];
            let row = (((from[1] + to[1]) / 2.0) * rows as f64) as usize;
            let (left, right) = (from[0].min(to[0]), from[0].max(to[0]));
            assert!(left > -1e-4 && right < 1.0 + 1e-4, "{left} to {right}");
            for column in 0..columns {
                let edges = [column, column + 1].map(|edge| edge as f64 / columns as f64);
                let way = (right.min(edges[1]) - left.max(edges[0])).max(0.0);
                cells[row * columns + column] += stroke.power * way * columns as f64;
            }
        }
    }
    let lines_in_a_cell = lines as f64 / rows as f64;
    cells.iter().map(|sum| sum / lines_in_a_cell).collect()
}

/// The greatest and the mean distance between two pictures, percent of power.
fn difference(one: &[f64], other: impl Iterator<Item = f64>) -> [f64; 2] {
    let off: Vec<f64> = one.iter().zip(other).map(|(a, b)| (a - b).abs()).collect();
    let sum: f64 = off.iter().sum();
    [
        off.iter().fold(0.0, |most, off| f64::max(most, *off)),
        sum / off.len() as f64,
    ]
}

fn wanted(image: &Raster) -> impl Iterator<Item = f64> {
    let grey = image.grey.iter();
    grey.map(|grey| f64::from(255 - grey) / 255.0 * 100.0)
}

#[test]
fn the_gradient_is_burnt_as_it_is() {
    let image = gradient();
    assert_eq!((image.width, image.height), (64, 48));
    for both_directions in [true, false] {
        let engrave = Engrave {
            both_directions,
            ..Engrave::default()
        };
        let grid = centred(&image, Size::Natural);
        let plan = image.plan(&grid, SURFACE, &engrave).unwrap();
        let strokes = burnt(&plan);
        let picture = picture(&strokes, &grid, [64, 48], 48);
        let [most, mean] = difference(&picture, wanted(&image));
        println!(
            "both directions {both_directions}: {} steps, power off by {most:.3} % at most, {mean:.3} % in the mean",
            plan.steps.len()
        );
        assert!(most < 0.55 && mean < 0.3);
    }
}
