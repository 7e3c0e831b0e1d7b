//! The picture of a run: where the tool really went, from above and from the side.

mod panel;
mod svg;
mod workspace;

use magician_motion::{JointAngles, Limits};

use super::scene::{ARM, CUBE, CUBES, TABLE, home};
use panel::{Panel, Scale};
use svg::{Svg, path};

/// The tool at an instant, as the arm reported it; mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) z: f64,
    /// Whether it carries a cube.
    pub(super) carrying: bool,
}

impl Sample {
    fn radius(&self) -> f64 {
        self.x.hypot(self.y)
    }
}

const WIDTH: f64 = 1340.0;
const HEIGHT: f64 = 760.0;
const INK: &str = "#1f2933";
const FAINT: &str = "#7b8794";
const EMPTY: &str = "#3b7dd8";
const CARRYING: &str = "#e8590c";
const CUBE_FILL: &str = "#ffd8a8";
const REACH_FILL: &str = "#e9f1fb";
const REACH_EDGE: &str = "#9db8d9";
const BODY: &str = "#ced4da";

/// From above: y to the left, x upwards.
const ABOVE: Scale = Scale {
    left: 60.0,
    top: 104.0,
    per_mm: 1.4,
    across: (240.0, -240.0),
    up: (-70.0, 340.0),
};
/// From the side: radius to the right, z upwards.
const SIDE: Scale = Scale {
    left: 790.0,
    top: 104.0,
    per_mm: 1.4,
    across: (0.0, 350.0),
    up: (-170.0, 240.0),
};

/// Draws a run.
pub(super) fn draw(samples: &[Sample], subtitle: &str) -> String {
    let mut svg = Svg::new(WIDTH, HEIGHT, "#ffffff");
    let title = [("font-size", "24"), ("font-weight", "bold"), ("fill", INK)];
    svg.text(
        (60.0, 44.0),
        "Six cubes, picked from a row and placed on a grid",
        &title,
    );
    svg.text(
        (60.0, 70.0),
        subtitle,
        &[("font-size", "15"), ("fill", FAINT)],
    );
    from_above(&mut svg, samples);
    from_the_side(&mut svg, samples);
    legend(&mut svg);
    svg.finish()
}

fn from_above(svg: &mut Svg, samples: &[Sample]) {
    let section = workspace::section(&ARM, &Limits::CONTROLLER);
    let panel = Panel::begin(svg, ABOVE, "above", "From above", "y / mm", "x / mm");
    let (near, far) = section
        .iter()
        .fold((f64::MAX, 0.0_f64), |(near, far), point| {
            (near.min(point.0), far.max(point.0))
        });
    reach_from_above(svg, near, far, REACH_FILL, "none");
    if let Some((near, far)) = workspace::radii_at(&section, super::scene::TOP) {
        reach_from_above(svg, near, far, "none", "5 4");
    }
    panel.grid(svg);
    base_from_above(svg);
    for (at, errand) in CUBES.iter().enumerate() {
        square_from_above(svg, errand.from, at + 1, false);
        square_from_above(svg, errand.to, at + 1, true);
    }
    tracks(svg, samples, |sample| ABOVE.at(sample.y, sample.x));
    let at_home = home();
    let spot = ABOVE.at(at_home.y, at_home.x);
    marker(svg, spot, "home", (10.0, -9.0));
    panel.end(svg);
}

/// A sector between two radii, as wide as J1 turns.
fn reach_from_above(svg: &mut Svg, near: f64, far: f64, fill: &str, dashes: &str) {
    let turn = Limits::CONTROLLER.j1;
    let steps = 90_u32;
    let angle = |step: u32| {
        (turn.min + (turn.max - turn.min) * f64::from(step) / f64::from(steps)).to_radians()
    };
    let on =
        |radius: f64, step| ABOVE.at(radius * f64::sin(angle(step)), radius * angle(step).cos());
    let outer = (0..=steps).map(|step| on(far, step));
    let inner = (0..=steps).rev().map(|step| on(near, step));
    let data = path(outer.chain(inner), true);
    let attributes = [
        ("d", data.as_str()),
        ("fill", fill),
        ("stroke", REACH_EDGE),
        ("stroke-width", "1.5"),
        ("stroke-dasharray", dashes),
    ];
    svg.leaf("path", &attributes);
}

/// The base's footprint, 158 mm square, and its axis.
fn base_from_above(svg: &mut Svg) {
    const HALF: f64 = 79.0;
    rectangle(
        svg,
        ABOVE.at(HALF, HALF),
        ABOVE.at(-HALF, -HALF),
        BODY,
        FAINT,
        "8",
    );
    let (x, y) = ABOVE.at(0.0, 0.0);
    let (x, y) = (svg::number(x), svg::number(y));
    svg.leaf(
        "circle",
        &[("cx", &x), ("cy", &y), ("r", "5"), ("fill", INK)],
    );
    let label = [
        ("font-size", "14"),
        ("fill", INK),
        ("text-anchor", "middle"),
    ];
    let (x, y) = ABOVE.at(0.0, -32.0);
    svg.text((x, y), "base", &label);
}

fn square_from_above(svg: &mut Svg, (x, y): (f64, f64), number: usize, placed: bool) {
    const HALF: f64 = CUBE / 2.0;
    let (fill, stroke) = if placed {
        (CUBE_FILL, CARRYING)
    } else {
        ("#ffffff", FAINT)
    };
    rectangle(
        svg,
        ABOVE.at(y + HALF, x + HALF),
        ABOVE.at(y - HALF, x - HALF),
        fill,
        stroke,
        "3",
    );
    let (px, py) = ABOVE.at(y, x);
    let label = [
        ("font-size", "13"),
        ("fill", INK),
        ("text-anchor", "middle"),
        ("font-weight", "bold"),
    ];
    svg.text((px - 10.0, py - 6.0), number, &label);
}

fn from_the_side(svg: &mut Svg, samples: &[Sample]) {
    let panel = Panel::begin(
        svg,
        SIDE,
        "side",
        "From the side",
        "distance from the base axis / mm",
        "z / mm",
    );
    let section = workspace::section(&ARM, &Limits::CONTROLLER);
    let data = path(
        section.into_iter().map(|(radius, z)| SIDE.at(radius, z)),
        true,
    );
    let attributes = [
        ("d", data.as_str()),
        ("fill", REACH_FILL),
        ("stroke", REACH_EDGE),
        ("stroke-width", "1.5"),
    ];
    svg.leaf("path", &attributes);
    panel.grid(svg);
    table(svg);
    for errand in CUBES {
        for ((x, y), placed) in [(errand.from, false), (errand.to, true)] {
            square_from_the_side(svg, x.hypot(y), placed);
        }
    }
    arm_from_the_side(svg);
    tracks(svg, samples, |sample| SIDE.at(sample.radius(), sample.z));
    let at_home = home();
    marker(svg, SIDE.at(at_home.x, at_home.z), "home", (10.0, -9.0));
    panel.end(svg);
}

fn table(svg: &mut Svg) {
    let (from, to) = (SIDE.at(0.0, TABLE), SIDE.at(SIDE.across.1, TABLE - 4.0));
    rectangle(svg, from, to, "#dee2e6", "none", "0");
    let label = [("font-size", "13"), ("fill", FAINT)];
    svg.text(
        (from.0 + 10.0, to.1 + 17.0),
        "table, where the cup touches it",
        &label,
    );
}

fn square_from_the_side(svg: &mut Svg, radius: f64, placed: bool) {
    let (from, to) = (
        SIDE.at(radius - CUBE / 2.0, TABLE + CUBE),
        SIDE.at(radius + CUBE / 2.0, TABLE),
    );
    let (fill, stroke) = if placed {
        (CUBE_FILL, CARRYING)
    } else {
        ("none", FAINT)
    };
    rectangle(svg, from, to, fill, stroke, "2");
}

/// The arm as it stands at home: rear arm, forearm, tool.
fn arm_from_the_side(svg: &mut Svg) {
    let joints = JointAngles::HOME;
    let (rear, fore) = (joints.j2.to_radians(), joints.j3.to_radians());
    let elbow = (ARM.rear_arm * rear.sin(), ARM.rear_arm * rear.cos());
    let wrist = (
        elbow.0 + ARM.forearm * fore.cos(),
        elbow.1 - ARM.forearm * fore.sin(),
    );
    let tool = (wrist.0 + ARM.tool.x, wrist.1);
    let points = [(0.0, 0.0), elbow, wrist, tool].map(|(radius, z)| SIDE.at(radius, z));
    let data = path(points, false);
    let attributes = [
        ("d", data.as_str()),
        ("fill", "none"),
        ("stroke", BODY),
        ("stroke-width", "12"),
        ("stroke-linejoin", "round"),
        ("stroke-linecap", "round"),
    ];
    svg.leaf("path", &attributes);
    for (x, y) in points.iter().take(3) {
        let (x, y) = (svg::number(*x), svg::number(*y));
        svg.leaf(
            "circle",
            &[("cx", &x), ("cy", &y), ("r", "5"), ("fill", FAINT)],
        );
    }
}

/// The way of the tool, a line for each stretch with or without a cube.
fn tracks(svg: &mut Svg, samples: &[Sample], at: impl Fn(&Sample) -> (f64, f64)) {
    for carrying in [false, true] {
        let mut data = String::new();
        let mut last: Option<&Sample> = None;
        for run in samples.chunk_by(|a, b| a.carrying == b.carrying) {
            // A stretch begins where the one before it ended.
            if run.first().is_some_and(|first| first.carrying == carrying) {
                data.push_str(&path(last.into_iter().chain(run).map(&at), false));
            }
            last = run.last();
        }
        let colour = if carrying { CARRYING } else { EMPTY };
        let attributes = [
            ("d", data.as_str()),
            ("fill", "none"),
            ("stroke", colour),
            ("stroke-width", "2"),
            ("stroke-opacity", "0.85"),
            ("stroke-linejoin", "round"),
            ("stroke-linecap", "round"),
        ];
        svg.leaf("path", &attributes);
    }
}

fn marker(svg: &mut Svg, (x, y): (f64, f64), label: &str, shift: (f64, f64)) {
    let (cx, cy) = (svg::number(x), svg::number(y));
    let attributes = [
        ("cx", cx.as_str()),
        ("cy", cy.as_str()),
        ("r", "5"),
        ("fill", "#ffffff"),
        ("stroke", INK),
        ("stroke-width", "2"),
    ];
    svg.leaf("circle", &attributes);
    let text = [("font-size", "14"), ("fill", INK), ("font-weight", "bold")];
    svg.text((x + shift.0, y + shift.1), label, &text);
}

fn rectangle(svg: &mut Svg, a: (f64, f64), b: (f64, f64), fill: &str, stroke: &str, round: &str) {
    let [x, y, width, height] = [
        a.0.min(b.0),
        a.1.min(b.1),
        (a.0 - b.0).abs(),
        (a.1 - b.1).abs(),
    ]
    .map(svg::number);
    let attributes = [
        ("x", x.as_str()),
        ("y", &y),
        ("width", &width),
        ("height", &height),
        ("rx", round),
        ("fill", fill),
        ("stroke", stroke),
        ("stroke-width", "1.5"),
    ];
    svg.leaf("rect", &attributes);
}

fn legend(svg: &mut Svg) {
    const Y: f64 = 736.0;
    let text = [("font-size", "14"), ("fill", INK)];
    let mut x = 60.0;
    for (colour, label, width) in [
        (EMPTY, "tool without a cube", 190.0),
        (CARRYING, "tool with a cube", 170.0),
    ] {
        let data = path([(x, Y - 5.0), (x + 28.0, Y - 5.0)], false);
        let line = [
            ("d", data.as_str()),
            ("stroke", colour),
            ("stroke-width", "3"),
        ];
        svg.leaf("path", &line);
        svg.text((x + 36.0, Y), label, &text);
        x += width + 20.0;
    }
    for (fill, stroke, dashes, label, width) in [
        ("#ffffff", FAINT, "none", "cube, before", 120.0),
        (CUBE_FILL, CARRYING, "none", "cube, after", 112.0),
        (
            REACH_FILL,
            REACH_EDGE,
            "none",
            "within reach at some height",
            215.0,
        ),
        (
            "none",
            REACH_EDGE,
            "5 4",
            "within reach at the height of the cubes",
            300.0,
        ),
    ] {
        let left = svg::number(x);
        let top = svg::number(Y - 13.0);
        let attributes = [
            ("x", left.as_str()),
            ("y", &top),
            ("width", "16"),
            ("height", "16"),
            ("rx", "2"),
            ("fill", fill),
            ("stroke", stroke),
            ("stroke-width", "1.5"),
            ("stroke-dasharray", dashes),
        ];
        svg.leaf("rect", &attributes);
        svg.text((x + 24.0, Y), label, &text);
        x += width + 20.0;
    }
}

#[cfg(test)]
mod tests {
    use super::super::scene::{LIFT, TOP};
    use super::*;

    /// The corners of a run, without what lies between.
    fn corners() -> Vec<Sample> {
        let mut samples = Vec::new();
        for errand in CUBES {
            for ((x, y), carrying) in [(errand.from, false), (errand.to, true)] {
                for z in [TOP + LIFT, TOP] {
                    samples.push(Sample { x, y, z, carrying });
                }
            }
            let (x, y) = errand.to;
            samples.push(Sample {
                x,
                y,
                z: TOP + LIFT,
                carrying: false,
            });
        }
        samples
    }

    #[test]
    fn a_run_is_drawn_with_both_tracks_and_all_labels() {
        let picture = draw(&corners(), "a subtitle");
        if let Some(p) = std::env::var_os("DUMP") {
            std::fs::write(p, &picture).unwrap();
        }
        for part in [
            EMPTY,
            CARRYING,
            "From above",
            "From the side",
            "a subtitle",
            "home",
            "base",
        ] {
            assert!(picture.contains(part), "{part}");
        }
        assert_eq!(
            picture.matches("<g ").count(),
            picture.matches("</g>").count()
        );
        assert!(!picture.contains("NaN"));
    }
}
