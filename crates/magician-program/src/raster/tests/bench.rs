//! Virtual arm that engraves, and its result as a picture.

use std::time::Duration;

use magician_host::JointAngles;
use magician_host::preflight::Preflight;
use magician_protocol::commands::{ClearAllAlarmsState, QueuedCmdStartExec};
use magician_protocol::{Ctrl, FrameBuf, Set};
use magician_sim::world::{Stroke, StrokeKind};
use magician_sim::{Controller, ControllerState, LinkId, Profile, Scenario, World};

use crate::raster::{Grid, Raster, Size};
use crate::{Content, Format, Plan, ReadOptions, Surface, Tool, check, read};

pub(super) const GRADIENT: &[u8] = include_bytes!("../../../samples/engrave_gradient.png");
pub(super) const SURFACE: Surface = Surface::level(-60.0);

pub(super) fn gradient() -> Raster {
    let read = read(Format::Image, GRADIENT, &ReadOptions::default()).unwrap();
    match read.content {
        Content::Image(image) => image,
        other => panic!("{other:?}"),
    }
}

pub(super) fn centred(image: &Raster, size: Size) -> Grid {
    Grid::centred(image.size(size).unwrap(), [250.0, 20.0], 0.0, false)
}

pub(super) fn image(width: usize, rows: &[&str]) -> Raster {
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

/// Virtual arm with a laser whose queue is full whenever there is work.
pub(super) struct EngravingArm(pub(super) Controller);

impl EngravingArm {
    pub(super) fn new() -> Self {
        let scenario = "arm = { homed = true }\ntool = { kind = \"laser\" }";
        let world = World::from_scenario(&Scenario::from_toml(scenario).unwrap());
        let mut bench = Self(Controller::in_world(Profile::default(), world));
        bench.send(&ClearAllAlarmsState {}.into(), Ctrl::SET);
        bench.send(&QueuedCmdStartExec {}.into(), Ctrl::SET);
        bench
    }

    fn send(&mut self, command: &Set, ctrl: Ctrl) {
        let frame = FrameBuf::set(command, ctrl).unwrap();
        self.0.exchange(LinkId(0), frame.bytes());
        while self.0.poll_event().is_some() {}
    }

    /// Runs a plan that passes the check; calls `look` repeatedly on the way.
    pub(super) fn perform(&mut self, plan: &Plan, mut look: impl FnMut(&ControllerState)) {
        let start = Preflight::at(JointAngles::HOME, Tool::None.bias());
        let report = check(plan, &start);
        assert!(report.is_good(), "{:?}", report.refused_steps);
        for command in plan.commands() {
            while self.0.state().queue.waiting > 30 {
                self.advance(&mut look);
            }
            self.send(&command, Ctrl::QUEUED);
        }
        while self.0.busy() {
            self.advance(&mut look);
        }
        assert!(self.0.state().alarms.is_empty());
    }

    fn advance(&mut self, look: &mut impl FnMut(&ControllerState)) {
        let next = self.0.poll_timeout().unwrap();
        let soon = self.0.now() + SAMPLE_INTERVAL;
        self.0.advance(next.min(soon));
        look(&self.0.state());
    }
}

/// Interval between the looks.
pub(super) const SAMPLE_INTERVAL: Duration = Duration::from_millis(5);

/// Strokes burnt by a virtual arm for the whole plan.
pub(super) fn burnt(plan: &Plan) -> Vec<Stroke> {
    let mut bench = EngravingArm::new();
    bench.perform(plan, |_| {});
    let strokes = bench.0.drawing().strokes().to_vec();
    assert!(strokes.iter().all(|stroke| stroke.kind == StrokeKind::Burn));
    strokes
}

/// Mean power in each cell of a picture of this many columns and rows, from evenly spaced lines.
pub(super) fn picture(
    strokes: &[Stroke],
    grid: &Grid,
    [columns, rows]: [usize; 2],
    lines: usize,
) -> Vec<f64> {
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

/// Largest and mean difference of two pictures, percent of power.
pub(super) fn difference(one: &[f64], other: impl Iterator<Item = f64>) -> [f64; 2] {
    let off: Vec<f64> = one.iter().zip(other).map(|(a, b)| (a - b).abs()).collect();
    let sum: f64 = off.iter().sum();
    [
        off.iter().fold(0.0, |most, off| f64::max(most, *off)),
        sum / off.len() as f64,
    ]
}

pub(super) fn wanted(image: &Raster) -> impl Iterator<Item = f64> {
    let grey = image.grey.iter();
    grey.map(|grey| f64::from(255 - grey) / 255.0 * 100.0)
}
