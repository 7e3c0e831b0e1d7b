//! What the laser of a virtual arm leaves of an image.

use magician::JointAngles;
use magician::words::Preflight;
use magician_protocol::commands::{ClearAllAlarmsState, QueuedCmdStartExec};
use magician_protocol::{Ctrl, FrameBuf, Set};
use magician_sim::world::{Stroke, StrokeKind};
use magician_sim::{Controller, LinkId, Profile, Scenario, State, World};

use crate::raster::*;
use crate::{Action, Content, Format, Plan, ReadOptions, Surface, Tool, Travel, check, read};

const GRADIENT: &[u8] = include_bytes!("../../../samples/engrave_gradient.png");
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

/// A virtual arm with a laser, its queue full whenever there is something to do.
struct Bench(Controller);

impl Bench {
    fn new() -> Self {
        let scenario = "arm = { homed = true }\ntool = { kind = \"laser\" }";
        let world = World::from_scenario(&Scenario::from_toml(scenario).unwrap());
        let mut bench = Self(Controller::in_world(Profile::default(), world));
        bench.send(&ClearAllAlarmsState {}.into(), Ctrl::SET);
        bench.send(&QueuedCmdStartExec {}.into(), Ctrl::SET);
        bench
    }

    fn send(&mut self, command: &Set, ctrl: Ctrl) {
        let frame = FrameBuf::set(command, ctrl).unwrap();
        self.0.receive(LinkId(0), frame.bytes());
        while self.0.poll_transmit(LinkId(0)).is_some() {}
        while self.0.poll_event().is_some() {}
    }

    /// Does all of a plan that the checks let pass; `look` is called again and again while the arm is at it.
    fn perform(&mut self, plan: &Plan, mut look: impl FnMut(&State)) {
        let start = Preflight::at(JointAngles::HOME, Tool::None.bias());
        let report = check(plan, &start);
        assert!(report.is_good(), "{:?}", report.complaints);
        for command in plan.commands() {
            while self.0.state().queue.waiting > 30 {
                self.go_on(&mut look);
            }
            self.send(&command, Ctrl::QUEUED);
        }
        while self.0.busy() {
            self.go_on(&mut look);
        }
        assert!(self.0.state().alarms.is_empty());
    }

    fn go_on(&mut self, look: &mut impl FnMut(&State)) {
        let next = self.0.poll_timeout().unwrap();
        let soon = self.0.now() + LOOK;
        self.0.advance(next.min(soon));
        look(&self.0.state());
    }
}

/// The arm is looked at as often, us.
const LOOK: u64 = 5_000;

/// What the laser of a virtual arm has burnt when it has done all of it.
fn burnt(plan: &Plan) -> Vec<Stroke> {
    let mut bench = Bench::new();
    bench.perform(plan, |_| {});
    let strokes = bench.0.drawing().strokes().to_vec();
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

fn image(width: usize, rows: &[&str]) -> Raster {
    let pixels = rows.concat();
    let grey = pixels.bytes().map(|at| match at {
        b'#' => 0,
        b'+' => 128,
        _ => 255,
    });
    Raster {
        width,
        height: rows.len(),
        grey: grey.collect(),
        ..Raster::default()
    }
}

/// Powers and where their segments end in x, row by row, of a plan of a grid that is not turned.
fn segments(plan: &Plan) -> Vec<(u32, f32, f32)> {
    let steps = plan.steps.iter();
    let segments = steps.filter_map(|step| match step.action {
        Action::Burn { to, power } => Some((step.origin.line, to[0], power)),
        _ => None,
    });
    segments.collect()
}

#[test]
fn a_line_is_run_up_to_burnt_in_runs_and_run_out_of() {
    let image = image(6, &["##++ #", "      ", " #  ##"]);
    let grid = Grid::centred([6.0, 3.0], [203.0, 1.5], 0.0, false);
    let engrave = Engrave {
        spacing: 1.0,
        overscan: Some(2.0),
        ..Engrave::default()
    };
    let plan = image.plan(&grid, SURFACE, &engrave).unwrap();
    let there = [
        (1, 200.0, 0.0),
        (1, 202.0, 100.0),
        (1, 204.0, 50.0),
        (1, 205.0, 0.0),
        (1, 206.0, 100.0),
        (1, 208.0, 0.0),
    ];
    let back = [
        (3, 208.0, 0.0),
        (3, 206.0, 0.0),
        (3, 204.0, 100.0),
        (3, 202.0, 0.0),
        (3, 201.0, 100.0),
        (3, 199.0, 0.0),
    ];
    assert_eq!(segments(&plan), [there, back].concat());

    let [.., dark, up] = plan.steps.as_slice() else {
        panic!("{plan:?}")
    };
    assert_eq!(dark.action, Action::Laser(false));
    assert_eq!(
        up.action,
        Action::Move {
            to: [199.0, 0.5, -50.0, 0.0],
            by: Travel::Line
        }
    );
    assert_eq!(
        (plan.tool, plan.surface),
        (Some(Tool::Laser), Some(SURFACE))
    );

    let one_way = Engrave {
        both_directions: false,
        white_skip: false,
        ..engrave
    };
    let plan = image.plan(&grid, SURFACE, &one_way).unwrap();
    let blank = [(2, 208.0, 0.0)];
    let lit = segments(&plan)
        .into_iter()
        .filter(|(.., power)| *power > 0.0);
    let rising = lit.collect::<Vec<_>>();
    assert!(rising.is_sorted_by(|one, other| one.0 < other.0 || one.1 < other.1));
    assert!(segments(&plan).iter().any(|segment| *segment == blank[0]));
}

#[test]
fn the_tool_passes_the_image_at_one_speed() {
    let image = gradient();
    let engrave = Engrave {
        speed: 30.0,
        ..Engrave::default()
    };
    assert!(engrave.speed < engrave.steady_speed());
    let grid = centred(&image, Size::Natural);
    let columns = (0..image.width).map(|at| image.grey.iter().skip(at).step_by(image.width));
    let burnt = columns.map(|mut column| column.any(|grey| *grey < 250));
    let white = burnt.take_while(|burnt| !burnt).count();
    let [left, _] = grid.at([white as f64 / 64.0, 0.0]);
    let plan = image.plan(&grid, SURFACE, &engrave).unwrap();
    let (mut before, mut looks) = (None::<State>, 0);
    let mut farthest = left;
    let mut off = 0.0_f64;
    Bench::new().perform(&plan, |now| {
        if now.pose.z < SURFACE.height + 1e-3 {
            farthest = farthest.min(now.pose.x);
        }
        let Some(before) = before.replace(*now) else {
            return;
        };
        let time = (now.now - before.now) as f64 / 1e6;
        // At the edges the laser is not lit in both looks.
        if time >= 1e-3 && before.laser && now.laser {
            let speed = (now.pose.x - before.pose.x).abs() / time;
            off = off.max((speed - engrave.speed).abs() / engrave.speed);
            looks += 1;
        }
    });
    println!("{looks} looks, speed off by {:.4} % at most", 100.0 * off);
    assert!(looks > 1000 && off < 0.005);
    // As far as speed and acceleration need it, before what is burnt first.
    assert_eq!(engrave.run_up(), 30.0 * 30.0 / (2.0 * 100.0));
    assert!((farthest - (left - engrave.run_up())).abs() < 1e-3);
}

#[test]
fn a_threshold_burns_what_is_darker_and_inverted_the_rest() {
    let image = gradient();
    let grid = centred(&image, Size::Natural);
    let share = |invert| {
        let engrave = Engrave {
            tone: Tone::Threshold(100),
            power: [20.0, 60.0],
            invert,
            ..Engrave::default()
        };
        let plan = image.plan(&grid, SURFACE, &engrave).unwrap();
        let strokes = burnt(&plan);
        assert!(strokes.iter().all(|stroke| stroke.power == 60.0));
        let powers = picture(&strokes, &grid, [64, 48], 48);
        powers.iter().filter(|power| **power > 30.0).count() as f64 / powers.len() as f64
    };
    let darker = |level| {
        let darker = image.grey.iter().filter(|grey| **grey < level).count();
        darker as f64 / image.grey.len() as f64
    };
    assert_eq!(share(false), darker(100));
    // White counts as black then: what is lighter than 155.
    assert_eq!(share(true), 1.0 - darker(156));
}

#[test]
fn dither_keeps_the_mean() {
    let image = gradient();
    let grid = centred(&image, Size::Natural);
    let engrave = Engrave {
        tone: Tone::Dither,
        ..Engrave::default()
    };
    let strokes = burnt(&image.plan(&grid, SURFACE, &engrave).unwrap());
    assert!(strokes.iter().all(|stroke| stroke.power == 100.0));
    let picture = picture(&strokes, &grid, [4, 3], 48);
    let wanted: Vec<f64> = wanted(&image).collect();
    let block = |nth: usize| {
        let pixels = (0..256).map(|at| (nth / 4 * 16 + at / 16) * 64 + nth % 4 * 16 + at % 16);
        pixels.map(|at| wanted[at]).sum::<f64>() / 256.0
    };
    let [most, mean] = difference(&picture, (0..12).map(block));
    println!("blocks of 16 by 16: power off by {most:.3} % at most, {mean:.3} % in the mean");
    assert!(most < 2.0 && mean < 1.0);
}

#[test]
fn turned_mirrored_and_on_a_slope_it_lies_where_the_grid_says() {
    let image = gradient();
    let surface = Surface {
        height: -60.0,
        slope: [0.02, -0.01],
    };
    for mirror in [false, true] {
        let size = image.size(Size::Width(20.0)).unwrap();
        let grid = Grid::centred(size, [240.0, -30.0], 35.0, mirror);
        let plan = image.plan(&grid, surface, &Engrave::default()).unwrap();
        let strokes = burnt(&plan);
        let rows = (15.0_f64 / 0.2).round() as usize;
        let picture = picture(&strokes, &grid, [16, 3], rows);
        let wanted: Vec<f64> = wanted(&image).collect();
        let block = |nth: usize| {
            let pixels = (0..64).map(|at| (nth / 16 * 16 + at / 4) * 64 + nth % 16 * 4 + at % 4);
            pixels.map(|at| wanted[at]).sum::<f64>() / 64.0
        };
        let [most, _] = difference(&picture, (0..48).map(block));
        println!("mirror {mirror}: power off by {most:.3} % at most");
        assert!(most < 1.0);
        for step in &plan.steps {
            if let Action::Burn { to: [x, y, z], .. } = step.action {
                let height = surface.at([x, y].map(f64::from));
                assert!((f64::from(z) - height).abs() < 1e-4);
            }
        }
    }
}

#[test]
fn a_wide_gap_is_travelled_dark() {
    let bars = format!("##{}##", " ".repeat(196));
    let image = image(200, &[&bars, &bars]);
    let grid = Grid::centred([100.0, 1.0], [240.0, 0.0], 90.0, false);
    let engrave = Engrave {
        spacing: 0.5,
        ..Engrave::default()
    };
    let moves = |plan: &Plan| {
        let steps = plan.steps.iter();
        let moves = steps.filter(|step| matches!(step.action, Action::Move { .. }));
        moves.count()
    };
    let start = Preflight::at(JointAngles::HOME, Tool::None.bias());
    let skips = image.plan(&grid, SURFACE, &engrave).unwrap();
    let stays = Engrave {
        white_skip: false,
        ..engrave
    };
    let stays = image.plan(&grid, SURFACE, &stays).unwrap();
    assert_eq!((moves(&skips), moves(&stays)), (3 + 2, 3));
    let time = |plan| check(plan, &start).time.unwrap();
    assert!(time(&skips) < time(&stays));
    assert_eq!(burnt(&skips).len(), 4);
}

#[test]
fn cells_are_means_of_the_area_they_cover() {
    let ramp = Raster {
        width: 3,
        height: 2,
        grey: vec![0, 90, 180, 30, 120, 210],
        ..Raster::default()
    };
    assert_eq!(resample::resample(&ramp, 1, 1), [105]);
    assert_eq!(resample::resample(&ramp, 2, 1), [45, 165]);
    assert_eq!(resample::resample(&ramp, 3, 2), ramp.grey);
    assert_eq!(
        resample::resample(&ramp, 6, 2),
        [0, 0, 90, 90, 180, 180, 30, 30, 120, 120, 210, 210]
    );
    let photo = gradient();
    let mean = |grey: &[u8]| grey.iter().map(|at| f64::from(*at)).sum::<f64>() / grey.len() as f64;
    let small = resample::resample(&photo, 37, 31);
    assert!((mean(&small) - mean(&photo.grey)).abs() < 0.2);
}

#[test]
fn what_makes_no_sense_is_refused() {
    let dot = image(1, &["#"]);
    let grid = centred(&dot, Size::Natural);
    let refused = |raster: &Raster, grid: &Grid, engrave: Engrave| {
        raster
            .plan(grid, SURFACE, &engrave)
            .unwrap_err()
            .to_string()
    };
    let usual = Engrave::default;
    let refusals = [
        refused(&Raster::default(), &grid, usual()),
        refused(
            &Raster {
                width: 2,
                ..dot.clone()
            },
            &grid,
            usual(),
        ),
        refused(&image(1, &[" "]), &grid, usual()),
        refused(
            &dot,
            &Grid {
                across: [0.0; 2],
                ..grid
            },
            usual(),
        ),
        refused(
            &dot,
            &Grid {
                down: [f64::NAN; 2],
                ..grid
            },
            usual(),
        ),
        refused(
            &dot,
            &Grid {
                origin: [f64::INFINITY; 2],
                ..grid
            },
            usual(),
        ),
        refused(
            &dot,
            &Grid {
                across: [1e9, 0.0],
                ..grid
            },
            usual(),
        ),
        refused(
            &dot,
            &grid,
            Engrave {
                spacing: 0.0,
                ..usual()
            },
        ),
        refused(
            &dot,
            &grid,
            Engrave {
                speed: f64::NAN,
                ..usual()
            },
        ),
        refused(
            &dot,
            &grid,
            Engrave {
                acceleration: -1.0,
                ..usual()
            },
        ),
        refused(
            &dot,
            &grid,
            Engrave {
                gamma: 0.0,
                ..usual()
            },
        ),
        refused(
            &dot,
            &grid,
            Engrave {
                overscan: Some(-1.0),
                ..usual()
            },
        ),
        refused(
            &dot,
            &grid,
            Engrave {
                lift: f64::INFINITY,
                ..usual()
            },
        ),
        refused(
            &dot,
            &grid,
            Engrave {
                power: [50.0, 40.0],
                ..usual()
            },
        ),
        refused(
            &dot,
            &grid,
            Engrave {
                power: [0.0, 101.0],
                ..usual()
            },
        ),
        refused(
            &dot,
            &grid,
            Engrave {
                power: [0.0, 0.0],
                ..usual()
            },
        ),
    ];
    assert!(refusals[2].contains("white"), "{}", refusals[2]);
    assert!(refusals[6].contains("cells"), "{}", refusals[6]);
    for size in [Size::Width(0.0), Size::Height(f64::NAN), Size::Pixel(-1.0)] {
        dot.size(size).unwrap_err();
    }
}

#[test]
fn a_placed_frame_says_where_the_image_lies() {
    let size = [20.0, 10.0];
    let engrave = Engrave::default();
    let frame = engrave.frame(size);
    assert_eq!(frame.page, Some(size));
    let run_up = engrave.run_up();
    let all = [[-run_up, 0.0], [20.0 + run_up, 10.0]];
    assert_eq!(frame.bounds(), Some(all));
    let upright = Grid::of_frame(&frame).unwrap();
    assert_eq!(upright, Grid::centred(size, [10.0, 5.0], 0.0, false));
    assert_eq!(Grid::of_frame(&crate::Artwork::default()), None);
}
