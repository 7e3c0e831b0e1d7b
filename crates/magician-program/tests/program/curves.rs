//! Curves at every size of a drawing: the drawn lines stay within tolerance, merging and thinning
//! of the curve, and vice versa.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use magician_program::fill::FillMode;
use magician_program::{
    Action, Content, FontChoice, Format, Plan, Preparation, PrepareRequest, ReadOptions, Setup,
    SetupOptions, Surface, WorkOption, read,
};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

type Point = [f64; 2];
type Line = Vec<Point>;

/// Side of the square around each drawing at its drawn size, mm.
const SIDE: f64 = 60.0;
/// Largest distance between a curve and its drawn lines, mm: tolerance 0.05 and thinning 0.02. No
/// curve here has merged ends.
const CURVE_TOLERANCE: f64 = 0.07;
/// Coordinates have 32 bits, and these tests approximate the curves in small steps too, mm.
const ROUNDING_ERROR: f64 = 0.002;
/// Distance of sampled positions, mm.
const SAMPLE_STEP: f64 = 0.4;
const SURFACE: f64 = -60.0;

/// Curve at its drawn size, mm.
#[derive(Clone, Copy, Debug)]
enum Curve {
    Circle(Point, f64),
    /// Centre, radius, first angle and sweep in degrees.
    Arc(Point, f64, [f64; 2]),
    /// Centre and half axes.
    Ellipse(Point, Point),
    Bezier([Point; 4]),
    /// Lower left and upper right corner, and radius of the corners.
    Rounded([Point; 2], f64),
}

const CURVES: [Curve; 5] = [
    Curve::Circle([22.0, 30.0], 20.0),
    Curve::Arc([30.0, 20.0], 25.0, [20.0, 100.0]),
    Curve::Ellipse([40.0, 35.0], [18.0, 6.0]),
    Curve::Bezier([[5.0, 5.0], [15.0, 70.0], [45.0, -20.0], [55.0, 50.0]]),
    Curve::Rounded([[3.0, 4.0], [57.0, 56.0]], 8.0),
];

fn on_circle([x, y]: Point, [across, up]: Point, degrees: f64) -> Point {
    let (sin, cos) = degrees.to_radians().sin_cos();
    [x + across * cos, y + up * sin]
}

impl Curve {
    /// Positions on it, dense enough that lines between them are the curve.
    fn exact(&self) -> Line {
        let pieces = |count: u32, at: &dyn Fn(f64) -> Point| -> Line {
            let shares = (0..=count).map(|nth| f64::from(nth) / f64::from(count));
            shares.map(at).collect()
        };
        match *self {
            Self::Circle(centre, radius) => {
                pieces(500, &|share| on_circle(centre, [radius; 2], share * 360.0))
            }
            Self::Arc(centre, radius, [from, sweep]) => pieces(300, &|share| {
                on_circle(centre, [radius; 2], from + share * sweep)
            }),
            Self::Ellipse(centre, halves) => {
                pieces(500, &|share| on_circle(centre, halves, share * 360.0))
            }
            Self::Bezier(points) => pieces(500, &|t| {
                let s = 1.0 - t;
                let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
                let sum = |axis: usize| {
                    { points.iter().zip(weights) }
                        .map(|(point, weight)| point[axis] * weight)
                        .sum()
                };
                [sum(0), sum(1)]
            }),
            Self::Rounded([[left, low], [right, high]], radius) => {
                let corners = [
                    ([right - radius, low + radius], 270.0),
                    ([right - radius, high - radius], 0.0),
                    ([left + radius, high - radius], 90.0),
                    ([left + radius, low + radius], 180.0),
                ];
                let mut line: Line = corners
                    .into_iter()
                    .flat_map(|(centre, from)| {
                        pieces(50, &|share| {
                            on_circle(centre, [radius; 2], from + share * 90.0)
                        })
                    })
                    .collect();
                line.push(line[0]);
                line
            }
        }
    }
}

fn frame() -> Line {
    let [low, high] = [0.0, SIDE];
    vec![
        [low, low],
        [high, low],
        [high, high],
        [low, high],
        [low, low],
    ]
}

/// Curves that a format has, and a file of them, larger than drawn by this factor.
fn file(format: Format, laser: bool, larger: f64) -> (Vec<Curve>, String) {
    let has = |curve: &Curve| match format {
        Format::Svg | Format::Dxf => true,
        Format::Hpgl => !matches!(curve, Curve::Ellipse(..)),
        _ => !matches!(curve, Curve::Ellipse(..) | Curve::Bezier(_)),
    };
    let curves: Vec<Curve> = CURVES.into_iter().filter(has).collect();
    let text = match format {
        Format::Svg => svg(&curves, larger),
        Format::Dxf => dxf(&curves, larger),
        Format::Hpgl => hpgl(&curves, larger),
        _ => gcode(&curves, larger, laser),
    };
    (curves, text)
}

/// An icon of 24 units.
fn svg(curves: &[Curve], larger: f64) -> String {
    let unit = 24.0 / SIDE;
    let at = |[x, y]: Point| format!("{:.7} {:.7}", x * unit, (SIDE - y) * unit);
    let mut text = format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" width="{0}mm" height="{0}mm" viewBox="0 0 24 24" fill="none" stroke="black"><path d="M0 0H24V24H0Z"/>"#,
        SIDE * larger
    );
    for curve in curves {
        let drawn = match *curve {
            Curve::Circle([x, y], radius) => format!(
                r#"<circle cx="{:.7}" cy="{:.7}" r="{:.7}"/>"#,
                x * unit,
                (SIDE - y) * unit,
                radius * unit
            ),
            Curve::Ellipse([x, y], [across, up]) => format!(
                r#"<ellipse cx="{:.7}" cy="{:.7}" rx="{:.7}" ry="{:.7}"/>"#,
                x * unit,
                (SIDE - y) * unit,
                across * unit,
                up * unit
            ),
            Curve::Arc(centre, radius, [from, sweep]) => format!(
                r#"<path d="M{} A{1:.7} {1:.7} 0 0 0 {2}"/>"#,
                at(on_circle(centre, [radius; 2], from)),
                radius * unit,
                at(on_circle(centre, [radius; 2], from + sweep))
            ),
            Curve::Bezier([a, b, c, d]) => {
                format!(r#"<path d="M{}C{},{},{}"/>"#, at(a), at(b), at(c), at(d))
            }
            Curve::Rounded([[left, low], [right, high]], radius) => format!(
                r#"<rect x="{:.7}" y="{:.7}" width="{:.7}" height="{:.7}" rx="{:.7}"/>"#,
                left * unit,
                (SIDE - high) * unit,
                (right - left) * unit,
                (high - low) * unit,
                radius * unit
            ),
        };
        text += &drawn;
    }
    text + "</svg>"
}

fn dxf(curves: &[Curve], larger: f64) -> String {
    let mut text =
        "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n"
            .to_owned();
    let mut entity = |kind: &str, pairs: &[(u32, f64)]| {
        let _ = write!(text, "0\n{kind}\n8\n0\n");
        for (code, value) in pairs {
            let whole = matches!(code, 70 | 71 | 72 | 73 | 74 | 90);
            let _ = if whole {
                write!(text, "{code}\n{value:.0}\n")
            } else {
                write!(text, "{code}\n{value:.9}\n")
            };
        }
    };
    let at = |[x, y]: Point, code: u32| [(code, x * larger), (code + 10, y * larger)];
    let polyline = |corners: &[(Point, f64)]| {
        let mut pairs = vec![(90, corners.len() as f64), (70, 1.0)];
        for (corner, bulge) in corners {
            pairs.extend(at(*corner, 10));
            pairs.push((42, *bulge));
        }
        pairs
    };
    let straight: Vec<(Point, f64)> = frame()[..4].iter().map(|corner| (*corner, 0.0)).collect();
    entity("LWPOLYLINE", &polyline(&straight));
    for curve in curves {
        match *curve {
            Curve::Circle(centre, radius) => {
                entity(
                    "CIRCLE",
                    &[&at(centre, 10)[..], &[(40, radius * larger)]].concat(),
                );
            }
            Curve::Arc(centre, radius, [from, sweep]) => {
                let rest = [(40, radius * larger), (50, from), (51, from + sweep)];
                entity("ARC", &[&at(centre, 10)[..], &rest].concat());
            }
            Curve::Ellipse(centre, [across, up]) => {
                let rest = [(40, up / across), (41, 0.0), (42, TAU)];
                let axis = at([across, 0.0], 11);
                entity("ELLIPSE", &[&at(centre, 10)[..], &axis, &rest].concat());
            }
            Curve::Bezier(points) => {
                let mut pairs = vec![(70, 8.0), (71, 3.0), (72, 8.0), (73, 4.0), (74, 0.0)];
                pairs.extend([0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0].map(|knot| (40, knot)));
                points.iter().for_each(|point| pairs.extend(at(*point, 10)));
                entity("SPLINE", &pairs);
            }
            Curve::Rounded([[left, low], [right, high]], radius) => {
                let bulge = (TAU / 16.0).tan();
                let corners = [
                    ([left + radius, low], 0.0),
                    ([right - radius, low], bulge),
                    ([right, low + radius], 0.0),
                    ([right, high - radius], bulge),
                    ([right - radius, high], 0.0),
                    ([left + radius, high], bulge),
                    ([left, high - radius], 0.0),
                    ([left, low + radius], bulge),
                ];
                entity("LWPOLYLINE", &polyline(&corners));
            }
        }
    }
    text + "0\nENDSEC\n0\nEOF\n"
}

fn hpgl(curves: &[Curve], larger: f64) -> String {
    let unit = 40.0 * larger;
    let at = |[x, y]: Point| format!("{:.6},{:.6}", x * unit, y * unit);
    let mut text = "IN;SP1;".to_owned();
    let _ = write!(text, "PU{};", at(frame()[0]));
    for corner in &frame()[1..] {
        let _ = write!(text, "PD{};", at(*corner));
    }
    for curve in curves {
        let _ = match *curve {
            Curve::Circle(centre, radius) => {
                write!(text, "PU{};CI{:.6};", at(centre), radius * unit)
            }
            Curve::Arc(centre, radius, [from, sweep]) => {
                let begin = at(on_circle(centre, [radius; 2], from));
                write!(text, "PU{begin};PD;AA{},{sweep};", at(centre))
            }
            Curve::Bezier([a, b, c, d]) => {
                write!(text, "PU{};PD;BZ{},{},{};", at(a), at(b), at(c), at(d))
            }
            Curve::Rounded([[left, low], [right, high]], radius) => {
                let _ = write!(text, "PU{};", at([left + radius, low]));
                let sides = [
                    ([right - radius, low], [right - radius, low + radius]),
                    ([right, high - radius], [right - radius, high - radius]),
                    ([left + radius, high], [left + radius, high - radius]),
                    ([left, low + radius], [left + radius, low + radius]),
                ];
                for (end, centre) in sides {
                    let _ = write!(text, "PD{};AA{},90;", at(end), at(centre));
                }
                Ok(())
            }
            Curve::Ellipse(..) => unreachable!(),
        };
    }
    text + "PU;SP0;"
}

fn gcode(curves: &[Curve], larger: f64, laser: bool) -> String {
    let [down, up] = if laser {
        ["M3 S1000", "M5"]
    } else {
        ["G1 Z0", "G0 Z5"]
    };
    let at = |[x, y]: Point| format!("X{:.6} Y{:.6}", x * larger, y * larger);
    let way = |[x, y]: Point, [to_x, to_y]: Point| {
        format!("I{:.6} J{:.6}", (to_x - x) * larger, (to_y - y) * larger)
    };
    let mut text = format!("G21 G90 G17 F1200\n{up}\nG0 {}\n{down}\n", at(frame()[0]));
    for corner in &frame()[1..] {
        let _ = writeln!(text, "G1 {}", at(*corner));
    }
    for curve in curves {
        let mut begin = |from: Point| {
            let _ = writeln!(text, "{up}\nG0 {}\n{down}", at(from));
        };
        let _ = match *curve {
            Curve::Circle(centre, radius) => {
                let from = on_circle(centre, [radius; 2], 0.0);
                begin(from);
                writeln!(text, "G2 {} {}", at(from), way(from, centre))
            }
            Curve::Arc(centre, radius, [first, sweep]) => {
                let [from, to] =
                    [first, first + sweep].map(|angle| on_circle(centre, [radius; 2], angle));
                begin(from);
                writeln!(text, "G3 {} {}", at(to), way(from, centre))
            }
            Curve::Rounded([[left, low], [right, high]], radius) => {
                begin([left + radius, low]);
                let corners = [
                    (
                        [right - radius, low],
                        [right, low + radius],
                        [right - radius, low + radius],
                    ),
                    (
                        [right, high - radius],
                        [right - radius, high],
                        [right - radius, high - radius],
                    ),
                    (
                        [left + radius, high],
                        [left, high - radius],
                        [left + radius, high - radius],
                    ),
                    (
                        [left, low + radius],
                        [left + radius, low],
                        [left + radius, low + radius],
                    ),
                ];
                for (from, to, centre) in corners {
                    let arc = way(from, centre);
                    let _ = writeln!(text, "G1 {}\nG3 {} {arc}", at(from), at(to));
                }
                Ok(())
            }
            Curve::Ellipse(..) | Curve::Bezier(_) => unreachable!(),
        };
    }
    text + up + "\n"
}

/// Option that sets the size of a drawing.
#[derive(Clone, Copy, Debug)]
enum RequestedSize {
    Scale,
    Width,
    Height,
    Fit,
    FitPage,
}

/// Plan of a file that is larger than drawn by this factor.
fn enlarged_plan(
    format: Format,
    text: &str,
    laser: bool,
    said: RequestedSize,
    larger: f64,
) -> Plan {
    let mut options = SetupOptions::default();
    options.work = Some(if laser {
        WorkOption::Engrave
    } else {
        WorkOption::Draw
    });
    match said {
        RequestedSize::Scale => options.scale = Some(1.0 / larger),
        RequestedSize::Width => options.width = Some(SIDE),
        RequestedSize::Height => options.height = Some(SIDE),
        RequestedSize::Fit | RequestedSize::FitPage => {
            (options.fit, options.turn) = (true, Some(false));
            options.page = matches!(said, RequestedSize::FitPage).then(|| "80x80".parse().unwrap());
        }
    }
    plan_of(format, text, options)
}

fn plan_of(format: Format, text: &str, options: SetupOptions) -> Plan {
    let mut file = PrepareRequest::new(format, text.as_bytes());
    file.options = options;
    file.defaults.assumed_surface = Some(Surface::level(SURFACE));
    match file.prepare() {
        Ok(Preparation::Done(laid)) => {
            assert_eq!(laid.misfit, None);
            laid.program.plan().clone()
        }
        other => panic!("{other:?}"),
    }
}

/// Lines that a plan leaves on the surface.
fn lines(plan: &Plan) -> Vec<Line> {
    let mut found: Vec<Line> = Vec::new();
    let mut at: Option<[f64; 3]> = None;
    let mut goes_on = false;
    for step in &plan.steps {
        let to = match &step.action {
            Action::Move {
                to: [x, y, z, _], ..
            }
            | Action::Arc {
                to: [x, y, z, _], ..
            } => [x, y, z],
            Action::Path { to: [x, y, z] } | Action::Burn { to: [x, y, z], .. } => [x, y, z],
            _ => continue,
        };
        let to = to.map(|value| f64::from(*value));
        let from = at.replace(to);
        let on = |[_, _, z]: [f64; 3]| (z - SURFACE).abs() < 0.01;
        let marks = match step.action {
            Action::Burn { power, .. } => power > 0.0,
            _ => step.action.marks() && on(to),
        };
        let Some(from) = from.filter(|from| marks && on(*from)) else {
            goes_on = false;
            continue;
        };
        let flat = |[x, y, _]: [f64; 3]| [x, y];
        let points = match step.action {
            Action::Arc {
                via: [x, y, _, _], ..
            } => round(flat(from), [x, y].map(f64::from), flat(to)),
            _ => vec![flat(from), flat(to)],
        };
        match found.last_mut().filter(|_| goes_on) {
            Some(line) => line.extend(&points[1..]),
            None => found.push(points),
        }
        goes_on = true;
    }
    found
}

/// Positions on the arc through three points.
fn round(a: Point, b: Point, c: Point) -> Line {
    let [bx, by] = [b[0] - a[0], b[1] - a[1]];
    let [cx, cy] = [c[0] - a[0], c[1] - a[1]];
    let d = 2.0 * (bx * cy - by * cx);
    let [bb, cc] = [bx * bx + by * by, cx * cx + cy * cy];
    let centre = [
        a[0] + (cy * bb - by * cc) / d,
        a[1] + (bx * cc - cx * bb) / d,
    ];
    let angle = |[x, y]: Point| (y - centre[1]).atan2(x - centre[0]);
    let radius = (a[0] - centre[0]).hypot(a[1] - centre[1]);
    let sweep = (angle(c) - angle(a)).rem_euclid(TAU) - if d > 0.0 { 0.0 } else { TAU };
    (0..=200)
        .map(|nth| {
            let (sin, cos) = (angle(a) + sweep * f64::from(nth) / 200.0).sin_cos();
            [centre[0] + radius * cos, centre[1] + radius * sin]
        })
        .collect()
}

fn bounds(lines: &[Line]) -> [Point; 2] {
    let none = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    lines.iter().flatten().fold(none, |[least, most], at| {
        [
            [0, 1].map(|axis| f64::min(least[axis], at[axis])),
            [0, 1].map(|axis| f64::max(most[axis], at[axis])),
        ]
    })
}

/// Lines at the size of the plan. The drawing has a straight border, so its bounds are exact.
fn placed(exact: &[Line], drawn: &[Line]) -> Vec<Line> {
    let ([from, end], [to, until]) = (bounds(exact), bounds(drawn));
    let scale = (until[0] - to[0]) / (end[0] - from[0]);
    let put = |at: &Point| [0, 1].map(|axis| to[axis] + scale * (at[axis] - from[axis]));
    { exact.iter() }
        .map(|line| line.iter().map(put).collect())
        .collect()
}

fn places(lines: &[Line]) -> Vec<Point> {
    let mut places = Vec::new();
    for pair in lines.iter().flat_map(|line| line.windows(2)) {
        let [from, to] = [pair[0], pair[1]];
        let way = (to[0] - from[0]).hypot(to[1] - from[1]);
        let count = (way / SAMPLE_STEP).ceil().max(1.0) as u32;
        places.extend((0..=count).map(|nth| {
            let share = f64::from(nth) / f64::from(count);
            [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
        }));
    }
    places
}

/// Largest distance of positions on some lines from other lines, mm; capped at 3 mm.
fn largest_distance(of: &[Line], from: &[Line]) -> f64 {
    const CELL_SIDE: f64 = 3.0;
    let cell = |value: f64| (value / CELL_SIDE).floor() as i64;
    let mut grid = std::collections::HashMap::<[i64; 2], Vec<[Point; 2]>>::new();
    for pair in from.iter().flat_map(|line| line.windows(2)) {
        let ends = [pair[0], pair[1]];
        let range = |axis: usize| {
            let [one, other] = ends.map(|end| end[axis]);
            cell(one.min(other)) - 1..=cell(one.max(other)) + 1
        };
        for x in range(0) {
            range(1).for_each(|y| grid.entry([x, y]).or_default().push(ends));
        }
    }
    let away = |at: Point| {
        let near = grid.get(&at.map(cell)).into_iter().flatten();
        near.map(|[from, to]| distance_to_segment(at, *from, *to))
            .fold(CELL_SIDE, f64::min)
    };
    places(of).into_iter().map(away).fold(0.0, f64::max)
}

fn distance_to_segment(at: Point, from: Point, to: Point) -> f64 {
    let [x, y] = [to[0] - from[0], to[1] - from[1]];
    let [px, py] = [at[0] - from[0], at[1] - from[1]];
    let length = x * x + y * y;
    let share = if length > 0.0 {
        ((px * x + py * y) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (px - share * x).hypot(py - share * y)
}

/// Largest distances of drawn lines from the exact ones, and vice versa, mm.
fn deviations(exact: &[Line], plan: &Plan) -> [f64; 2] {
    let drawn = lines(plan);
    let exact = placed(exact, &drawn);
    [
        largest_distance(&drawn, &exact),
        largest_distance(&exact, &drawn),
    ]
}

const FORMATS: [Format; 4] = [Format::Svg, Format::Dxf, Format::Hpgl, Format::Gcode];

fn assert_curves_within_tolerance(format: Format, laser: bool, said: RequestedSize, larger: f64) {
    let (curves, text) = file(format, laser, larger);
    let mut exact: Vec<Line> = curves.iter().map(Curve::exact).collect();
    exact.push(frame());
    let plan = enlarged_plan(format, &text, laser, said, larger);
    let strays = deviations(&exact, &plan);
    assert!(
        strays
            .iter()
            .all(|stray| *stray <= CURVE_TOLERANCE + ROUNDING_ERROR),
        "{format} {said:?} {larger} times as large, laser {laser}: {strays:.3?} mm off"
    );
    // Chords finer than the thinning would be wasted.
    assert!(
        plan.steps.len() < 1500,
        "{format} {larger}: {} steps",
        plan.steps.len()
    );
}

#[test]
fn curves_are_within_tolerance_at_every_scale_width_and_height_with_pen_and_laser() {
    for format in FORMATS {
        for laser in [false, true] {
            for nth in -4..=4 {
                let larger = 10.0_f64.powf(f64::from(nth) / 2.0);
                let all = [
                    RequestedSize::Scale,
                    RequestedSize::Width,
                    RequestedSize::Height,
                ];
                for said in if nth % 2 == 0 { &all[..] } else { &all[..1] } {
                    assert_curves_within_tolerance(format, laser, *said, larger);
                }
            }
        }
    }
}

#[test]
fn curves_are_within_tolerance_where_a_drawing_is_made_to_fit() {
    for format in FORMATS {
        for laser in [false, true] {
            for said in [RequestedSize::Fit, RequestedSize::FitPage] {
                for larger in [8.0, 90.0] {
                    assert_curves_within_tolerance(format, laser, said, larger);
                }
            }
        }
    }
}

/// An icon of 24 units with letters, a clip path, dashes and a filled shape.
fn lettered(side: f64) -> String {
    format!(
        r##"<svg xmlns="http://www.w3.org/2000/svg" width="{side}mm" height="{side}mm" viewBox="0 0 24 24" fill="none" stroke="black">
        <clipPath id="c"><circle cx="15" cy="9" r="6"/></clipPath>
        <path d="M0 0H24V24H0Z"/><path d="M2 20a10 8 0 0 1 20 0"/>
        <text x="2" y="9" font-size="9" fill="black" stroke="none">Rg</text>
        <circle cx="12" cy="9" r="7" clip-path="url(#c)"/>
        <circle cx="20" cy="4" r="2" stroke-dasharray="2 1"/>
        <path d="M14 14q4 -5 8 0t-8 6z" fill="black" stroke="none"/></svg>"##
    )
}

/// Lines of a drawing at true size and a very fine tolerance.
fn tolerant_lines(format: Format, text: &str, mut options: SetupOptions) -> Vec<Line> {
    options.tolerance = Some(0.002);
    (options.merge, options.simplify) = (Some(0.0), Some(0.0));
    lines(&plan_of(format, text, options))
}

fn assert_within_tolerance(exact: &[Line], plan: &Plan, what: &str) {
    let strays = deviations(exact, plan);
    assert!(
        strays
            .iter()
            .all(|stray| *stray <= CURVE_TOLERANCE + ROUNDING_ERROR),
        "{what}: {strays:.3?} mm off"
    );
}

#[test]
fn letters_clips_dashes_and_fills_are_within_tolerance_at_every_width() {
    let closely = tolerant_lines(Format::Svg, &lettered(SIDE), SetupOptions::default());
    for larger in [0.01, 0.1, 0.5, 20.0, 100.0] {
        for laser in [false, true] {
            let plan = enlarged_plan(
                Format::Svg,
                &lettered(SIDE * larger),
                laser,
                RequestedSize::Width,
                larger,
            );
            assert_within_tolerance(&closely, &plan, &format!("{larger} times as large"));
        }
    }
}

/// Drawing of this many units with letters along a curve.
fn along_a_path(side: f64, units: f64) -> String {
    let at = |share: f64| share * units;
    format!(
        r##"<svg xmlns="http://www.w3.org/2000/svg" width="{side}mm" height="{side}mm" viewBox="0 0 {units} {units}" fill="none" stroke="black" stroke-width="{0}">
        <path id="p" d="M{1} {2}C{1} {3} {4} {3} {4} {2}"/><path d="M0 0H{units}V{units}H0Z"/>
        <text font-size="{5}" fill="black" stroke="none"><textPath href="#p">Magician</textPath></text></svg>"##,
        at(0.01),
        at(0.1),
        at(0.8),
        at(0.15),
        at(0.9),
        at(0.18),
    )
}

#[test]
fn letters_along_a_path_are_within_tolerance_at_every_size() {
    let closely = tolerant_lines(
        Format::Svg,
        &along_a_path(SIDE, 24_000.0),
        SetupOptions::default(),
    );
    for larger in [0.01, 0.1, 0.5, 1.0, 20.0] {
        for laser in [false, true] {
            let small = along_a_path(SIDE * larger, 24.0);
            let plan = enlarged_plan(Format::Svg, &small, laser, RequestedSize::Width, larger);
            assert_within_tolerance(&closely, &plan, &format!("{larger} times as large"));
        }
    }
}

#[test]
fn hatch_is_as_dense_and_as_true_at_every_width() {
    let filled = |side: f64, width: Option<f64>| {
        let mut options = SetupOptions::default();
        (options.fill, options.width) = (Some(FillMode::Hatch), width);
        plan_of(Format::Svg, &lettered(side), options)
    };
    let length = |plan: &Plan| -> f64 {
        let lines = lines(plan);
        let pairs = lines.iter().flat_map(|line| line.windows(2));
        pairs
            .map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]))
            .sum()
    };
    let true_size = length(&filled(SIDE, None));
    for larger in [0.01, 0.1, 20.0] {
        let plan = filled(SIDE * larger, Some(SIDE));
        let share = length(&plan) / true_size;
        assert!((0.99..1.01).contains(&share), "{larger}: {share}");
    }
}

#[test]
fn words_in_an_outline_font_are_within_tolerance_at_every_scale() {
    let font = include_bytes!("../../../magician-formats/fonts/Roboto-Regular.ttf");
    let sized = |size: f64| {
        let mut options = SetupOptions::default();
        options.font = Some(FontChoice::file("Roboto-Regular.ttf", font.to_vec()));
        options.size = Some(size);
        options
    };
    let closely = tolerant_lines(Format::Text, "Hogs", sized(30.0));
    for larger in [0.01, 0.2, 50.0] {
        let mut options = sized(30.0 * larger);
        options.scale = Some(1.0 / larger);
        let plan = plan_of(Format::Text, "Hogs", options);
        assert_within_tolerance(&closely, &plan, &format!("{larger} times as large"));
    }
}

#[test]
fn lines_changed_after_reading_are_drawn_unchanged() {
    let text = lettered(SIDE / 10.0);
    let mut options = ReadOptions::default();
    options.title = "changed".to_owned();
    let mut content = read(Format::Svg, text.as_bytes(), &options)
        .unwrap()
        .content;
    let Content::Artwork(artwork) = &mut content else {
        panic!("no drawing");
    };
    artwork.strokes.truncate(1);
    let mut setup = Setup::default();
    setup.surface = Some(Surface::level(SURFACE));
    setup.placement.scale = 10.0;
    let made = setup.plan(Format::Svg, content).unwrap();
    assert_eq!(lines(&made.plan).len(), 1);
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 24,
        rng_seed: RngSeed::Fixed(43),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn curves_are_within_tolerance_at_any_scale(
        power in -2.0..2.0_f64,
        nth in 0..FORMATS.len(),
        laser: bool,
        said in prop_oneof![Just(RequestedSize::Scale), Just(RequestedSize::Width), Just(RequestedSize::Height)],
    ) {
        assert_curves_within_tolerance(FORMATS[nth], laser, said, 10.0_f64.powf(power));
    }
}
