//! Fitted plans pass the check and run without an alarm, over formats, tools, heights, sizes and
//! rotations. For more cases:
//! `FIT_CASES=5000 cargo test -p magician-program --test program --release fit::`.

use magician_program::rehearse::{RehearseOptions, rehearse, stage, start_of};
use magician_program::{Content, Format, ReadOptions, Setup, Surface, Tool, check, read};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestRunner};

/// Cases of the usual run: seconds.
const DEFAULT_CASES: u32 = 60;

/// Lines on a sheet; each point is a share of its width and height.
type Lines = Vec<Vec<[f64; 2]>>;

/// Content, and how it is placed.
#[derive(Clone, Debug)]
struct Case {
    format: Format,
    lines: Lines,
    /// Width and height, mm.
    size: [f64; 2],
    tool: Tool,
    surface: f64,
    scale: f64,
    rotate: f64,
    mirror: bool,
    turn: bool,
    at: Option<[f64; 2]>,
}

fn lines() -> impl Strategy<Value = Lines> {
    vec(vec([0.0..1.0_f64, 0.0..1.0_f64], 2..7), 1..6)
}

fn case() -> impl Strategy<Value = Case> {
    let formats = [
        Format::Svg,
        Format::Hpgl,
        Format::Dxf,
        Format::Gcode,
        Format::Points,
    ];
    let tools = [Tool::Pen, Tool::Laser, Tool::Suction, Tool::Gripper];
    let size = (0.5..3.3_f64, -1.0..1.0_f64).prop_map(|(size, aspect)| {
        let size = 10_f64.powf(size);
        [size, size * 10_f64.powf(aspect)]
    });
    let at = proptest::option::weighted(0.3, [180.0..280.0_f64, -80.0..80.0_f64]);
    (
        (proptest::sample::select(formats.to_vec()), lines(), size),
        (proptest::sample::select(tools.to_vec()), -90.0..40.0_f64),
        (
            0.3..3.0_f64,
            -180.0..180.0_f64,
            any::<bool>(),
            any::<bool>(),
        ),
        at,
    )
        .prop_map(
            |((format, lines, size), (tool, surface), (scale, rotate, mirror, turn), at)| Case {
                format,
                lines,
                size,
                tool,
                surface,
                scale,
                rotate,
                mirror,
                turn,
                at,
            },
        )
}

impl Case {
    fn lines(&self) -> impl Iterator<Item = Vec<[f64; 2]>> + '_ {
        let [width, height] = self.size;
        let placed = move |[x, y]: &[f64; 2]| [x * width, y * height];
        self.lines
            .iter()
            .map(move |line| line.iter().map(placed).collect())
    }

    /// Content of the file.
    fn text(&self) -> String {
        let [width, height] = self.size;
        let points = |line: Vec<[f64; 2]>| {
            let points = line.into_iter().map(|[x, y]| format!("{x:.4},{y:.4}"));
            points.collect::<Vec<_>>()
        };
        match self.format {
            Format::Svg => {
                let lines = self
                    .lines()
                    .map(|line| format!("<polyline points=\"{}\"/>", points(line).join(" ")));
                format!(
                    "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}mm\" height=\"{height}mm\" \
                     viewBox=\"0 0 {width} {height}\"><g fill=\"none\" stroke=\"black\">{}</g></svg>",
                    lines.collect::<String>()
                )
            }
            Format::Hpgl => {
                let units = |line: Vec<[f64; 2]>| {
                    let at = |[x, y]: [f64; 2]| format!("{:.0},{:.0}", 40.0 * x, 40.0 * y);
                    let points: Vec<String> = line.into_iter().map(at).collect();
                    let first = points.first().cloned().unwrap_or_default();
                    format!("PU{first};PD{};", points.join(","))
                };
                format!("IN;SP1;{}PU;", self.lines().map(units).collect::<String>())
            }
            Format::Dxf => {
                let line = |line: Vec<[f64; 2]>| {
                    let vertices = line
                        .iter()
                        .map(|[x, y]| format!("10\n{x:.4}\n20\n{y:.4}\n"));
                    let count = line.len();
                    format!(
                        "0\nLWPOLYLINE\n8\n0\n90\n{count}\n70\n0\n{}",
                        vertices.collect::<String>()
                    )
                };
                let lines: String = self.lines().map(line).collect();
                format!("0\nSECTION\n2\nENTITIES\n{lines}0\nENDSEC\n0\nEOF\n")
            }
            Format::Gcode => {
                let line = |line: Vec<[f64; 2]>| {
                    let mut text = String::new();
                    for (nth, [x, y]) in line.into_iter().enumerate() {
                        text += &match nth {
                            0 => format!("G0 Z5\nG0 X{x:.4} Y{y:.4}\nG1 Z0 F1200\n"),
                            _ => format!("G1 X{x:.4} Y{y:.4}\n"),
                        };
                    }
                    text
                };
                format!(
                    "G21 G90\n{}G0 Z5\nM2\n",
                    self.lines().map(line).collect::<String>()
                )
            }
            _ => {
                let rows = self
                    .lines()
                    .flat_map(points)
                    .map(|point| format!("{point},0\n"));
                format!("x,y,z\n{}", rows.collect::<String>())
            }
        }
    }

    fn passes_and_runs(&self) -> Result<bool, TestCaseError> {
        let text = self.text();
        let mut setup = Setup::default();
        setup.tool = Some(self.tool);
        setup.surface = Some(Surface::level(self.surface));
        setup.placement.fit = true;
        setup.placement.turn = self.turn;
        setup.placement.scale = self.scale;
        setup.placement.rotate = self.rotate;
        setup.placement.mirror = self.mirror;
        setup.placement.at = self.at;
        let mut options = ReadOptions::default();
        setup.set_gcode_options(&mut options.gcode, setup.surface);
        let content = match read(self.format, text.as_bytes(), &options) {
            Ok(reading) => reading.content,
            Err(diagnostic) => return Err(TestCaseError::fail(format!("{diagnostic}"))),
        };
        prop_assert!(!matches!(content, Content::Image(_)));
        let Ok(made) = setup.plan(self.format, content) else {
            return Ok(false);
        };
        if made.misfit.is_some() {
            return Ok(false);
        }
        let placed = made.placed.expect("what is made to fit is placed");
        prop_assert!(placed.scale <= self.scale * 1.001, "{placed:?}");
        let turned = placed.turn - self.rotate;
        prop_assert!(
            turned == 0.0 || self.turn && (turned - 90.0).abs() < 1e-9,
            "{placed:?}"
        );
        let rehearsal = RehearseOptions::default();
        let arm = stage(&made.plan, &rehearsal).expect("a virtual arm takes it");
        let report = check(&made.plan, &start_of(&arm));
        let refused = report.refused_steps.first();
        prop_assert!(
            report.is_good(),
            "{placed:?} {:?}",
            refused.map(|one| one.error.to_string())
        );
        let done = rehearse(&made.plan, &rehearsal).expect("commands fit into frames");
        prop_assert!(
            done.is_good(),
            "{placed:?} {:?} {:?}",
            done.alarms,
            done.log
        );
        Ok(true)
    }
}

#[test]
fn fitted_program_passes_the_check_and_runs() {
    let cases = std::env::var("FIT_CASES").ok();
    let cases = cases.map_or(DEFAULT_CASES, |cases| {
        cases.parse().expect("a number of cases")
    });
    let mut runner = TestRunner::new(ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(15),
        failure_persistence: None,
        max_shrink_iters: 200,
        ..ProptestConfig::default()
    });
    let fitted = std::cell::Cell::new(0_u32);
    let outcome = runner.run(&case(), |case| {
        fitted.set(fitted.get() + u32::from(case.passes_and_runs()?));
        Ok(())
    });
    if let Err(error) = outcome {
        panic!("{error}");
    }
    println!("{} of {cases} fit", fitted.get());
    assert!(fitted.get() > cases / 2, "{} of {cases}", fitted.get());
}
