//! From an SVG to the marks that pen or laser of a virtual arm really leave.

use magician::blocking::Arm;
use magician::preflight::Preflight;
use magician::sim::Scenario;
use magician::{JointAngles, Options, ToolBias, VirtualArm};
use magician_program::artwork::{Layout, Marking, Order};
use magician_program::{Artwork, Content, Format, Plan, ReadOptions, Surface, check, read};
use proptest::prelude::*;

const PAPER: Surface = Surface::level(-60.0);
const HOUSE: &[u8] = include_bytes!("../../samples/house.svg");
const CURVES: &[u8] = include_bytes!("../../samples/curves.svg");

fn artwork(text: &[u8]) -> Artwork {
    match read(Format::Svg, text, &ReadOptions::default())
        .unwrap()
        .content
    {
        Content::Artwork(artwork) => artwork,
        other => panic!("{other:?}"),
    }
}

/// Runs a plan on an arm with this tool over a table, and returns the lines left there.
fn drawn(plan: &Plan, tool: &str) -> Vec<Vec<[f64; 2]>> {
    let scenario = format!("tool = {{ kind = \"{tool}\" }}\ntable = {{ height = -60 }}");
    let cell = VirtualArm::in_scenario(&Scenario::from_toml(&scenario).unwrap());
    let arm = Arm::simulated(cell.clone(), Options::default()).unwrap();
    let commands: Vec<_> = plan.commands().collect();
    arm.run(&commands).unwrap();
    cell.with(|arm| {
        let drawing = arm.drawing();
        drawing
            .strokes()
            .iter()
            .map(|stroke| stroke.points.clone())
            .collect()
    })
}

/// Largest distance of points along lines, mm.
const SAMPLE_STEP: f64 = 0.1;

fn along(lines: &[Vec<[f64; 2]>]) -> Vec<[f64; 2]> {
    let mut points = Vec::new();
    for line in lines {
        points.extend(line.first());
        for pair in line.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            let way = (to[0] - from[0]).hypot(to[1] - from[1]);
            let count = (way / SAMPLE_STEP).ceil().max(1.0);
            points.extend((1..=count as u32).map(|nth| {
                let share = f64::from(nth) / count;
                [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
            }));
        }
    }
    points
}

/// Distance of a point from the nearest line.
fn distance_to_lines(lines: &[Vec<[f64; 2]>], [x, y]: [f64; 2]) -> f64 {
    let mut nearest = f64::INFINITY;
    for line in lines {
        if let [dot] = line.as_slice() {
            nearest = nearest.min((dot[0] - x).hypot(dot[1] - y));
        }
        for pair in line.windows(2) {
            let [a, b] = [pair[0], pair[1]];
            let way = [b[0] - a[0], b[1] - a[1]];
            let square = (way[0] * way[0] + way[1] * way[1]).max(1e-300);
            let share = ((x - a[0]) * way[0] + (y - a[1]) * way[1]) / square;
            let share = share.clamp(0.0, 1.0);
            nearest = nearest.min((a[0] + share * way[0] - x).hypot(a[1] + share * way[1] - y));
        }
    }
    nearest
}

/// Largest distance of a point of one drawing from the other.
fn farthest(from: &[Vec<[f64; 2]>], to: &[Vec<[f64; 2]>]) -> f64 {
    along(from)
        .into_iter()
        .map(|point| distance_to_lines(to, point))
        .fold(0.0, f64::max)
}

#[track_caller]
fn assert_drawn(text: &[u8], layout: &Layout, marking: &Marking, tool: &str) {
    let mut artwork = artwork(text);
    let saving = artwork.put_in_order(&Order::default());
    assert!(saving.after_mm <= saving.before_mm);
    let placed = artwork.placed(layout, marking).unwrap();
    let plan = placed.plan(marking);
    let homed = Preflight::at(JointAngles::HOME, ToolBias::NONE);
    let report = check(&plan, &homed);
    assert!(report.is_good(), "{:?}", report.refused_steps.first());
    assert!(report.time.is_some());
    let left = drawn(&plan, tool);
    let wanted: Vec<_> = placed
        .artwork
        .strokes
        .iter()
        .map(|stroke| stroke.points.clone())
        .collect();
    let lost = farthest(&wanted, &left);
    let surplus = farthest(&left, &wanted);
    // The arm follows the corners; the curves are flattened to 0.02 mm.
    let most = 0.05;
    assert!(
        lost <= most && surplus <= most,
        "{lost} mm lost, {surplus} mm too much"
    );
}

#[test]
fn a_pen_draws_a_house() {
    assert_drawn(HOUSE, &Layout::on(PAPER), &Marking::pen(), "pen");
}

#[test]
fn a_pen_draws_curves_that_fit() {
    let layout = Layout {
        fit: true,
        rotate: 30.0,
        ..Layout::on(PAPER)
    };
    assert_drawn(CURVES, &layout, &Marking::pen(), "pen");
}

#[test]
fn a_laser_burns_a_house() {
    let layout = Layout {
        mirror: true,
        scale: 0.5,
        ..Layout::on(PAPER)
    };
    assert_drawn(HOUSE, &layout, &Marking::laser(35.0), "laser");
}

#[test]
fn dots_are_left_by_pen_and_laser() {
    let dots = br#"<svg xmlns="http://www.w3.org/2000/svg" width="50mm" height="50mm" viewBox="0 0 50 50"><g stroke="black" stroke-linecap="round" stroke-dasharray="0 10"><line x1="5" y1="5" x2="36" y2="5"/></g></svg>"#;
    let artwork = artwork(dots);
    for (marking, tool) in [(Marking::pen(), "pen"), (Marking::laser(50.0), "laser")] {
        let placed = artwork.placed(&Layout::on(PAPER), &marking).unwrap();
        let left = drawn(&placed.plan(&marking), tool);
        assert_eq!(left.len(), 4, "{tool}: {left:?}");
        for stroke in &placed.artwork.strokes {
            assert!(distance_to_lines(&left, stroke.points[0]) < 0.01);
        }
    }
}

/// Elements of a drawing, most of them valid.
fn element() -> impl Strategy<Value = String> {
    let number = prop_oneof![
        80 => (-300..900_i32).prop_map(|tenth| f64::from(tenth) / 10.0),
        4 => Just(0.0),
        1 => prop_oneof![Just(1e5), Just(-1e-9), Just(4e38)],
    ];
    let numbers = proptest::collection::vec(number, 8);
    let style = proptest::sample::select(vec![
        "",
        "fill='none' stroke='black'",
        "stroke='red' stroke-dasharray='3 1 2'",
        "stroke='red' transform='rotate(33) scale(1 -2)'",
        "stroke='red' clip-path='url(#clip)'",
        "fill='url(#paint)' opacity='0.5'",
        "stroke='red' marker-mid='url(#mark)' marker-end='url(#mark)'",
        "style='stroke:blue;stroke-width:3%' transform='matrix(1 0 0 0 3 3)'",
    ]);
    let shape = proptest::sample::select(vec![
        "<path d='M{0} {1}L{2} {3} {4} {5}z' {S}/>",
        "<path d='M{0},{1}c{2} {3} {4} {5} {6} {7}s{1} {2} {3} {0}' {S}/>",
        "<path d='M{0} {1}a{2} {3} {4} 1 0 {5} {6}q{1} {2} {3} {4}t{5} {6}' {S}/>",
        "<rect x='{0}' y='{1}' width='{2}' height='{3}' rx='{4}' {S}/>",
        "<circle cx='{0}' cy='{1}' r='{2}' {S}/>",
        "<ellipse cx='{0}%' cy='{1}' rx='{2}' ry='{3}' {S}/>",
        "<line x1='{0}' y1='{1}mm' x2='{2}' y2='{3}' {S}/>",
        "<polyline points='{0},{1} {2},{3} {4},{5}' {S}/>",
        "<polygon points='{0},{1} {2},{3} {4}' {S}/>",
        "<text x='{0}' y='{1}' font-size='{2}' {S}>A{3}</text>",
        "<use href='#used' x='{0}' y='{1}' {S}/>",
        "<svg x='{0}' y='{1}' width='{2}' height='{3}' viewBox='0 0 {4} {5}'><circle r='4' {S}/></svg>",
    ]);
    (shape, style, numbers).prop_map(|(shape, style, numbers)| {
        let mut text = shape.replace("{S}", style);
        for (nth, number) in numbers.iter().enumerate() {
            text = text.replace(&format!("{{{nth}}}"), &number.to_string());
        }
        text
    })
}

fn document() -> impl Strategy<Value = String> {
    let root = proptest::sample::select(vec![
        "width='90mm' height='70mm' viewBox='0 0 90 70'",
        "width='5cm' height='5cm' viewBox='-30 0 120 90' preserveAspectRatio='xMinYMax slice'",
        "viewBox='0 0 90 90'",
        "",
    ]);
    let elements = proptest::collection::vec(element(), 1..8);
    (root, elements, any::<bool>()).prop_map(|(root, elements, grouped)| {
        let inside = elements.concat();
        let inside = if grouped {
            format!("<g transform='translate(3 4) rotate(15)' stroke='black'>{inside}</g>")
        } else {
            inside
        };
        format!(
            "<svg xmlns='http://www.w3.org/2000/svg' {root}><defs><path id='used' d='M0 0h5v5'/><clipPath id='clip'><circle cx='30' cy='30' r='20'/></clipPath><marker id='mark' overflow='visible'><path d='M0 0L2 1'/></marker><linearGradient id='paint'><stop/></linearGradient></defs>{inside}</svg>"
        )
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// Any drawing is either refused before anything moves, or drawn completely.
    #[test]
    fn drawing_is_refused_or_drawable(
        text in document(),
        fit in any::<bool>(),
        laser in any::<bool>(),
        rotate in prop_oneof![Just(0.0), -180.0..180.0],
    ) {
        let Ok(reading) = read(Format::Svg, text.as_bytes(), &ReadOptions::default()) else {
            return Ok(());
        };
        let Content::Artwork(mut artwork) = reading.content else {
            panic!("an SVG is lines");
        };
        artwork.put_in_order(&Order::default());
        let marking = if laser { Marking::laser(50.0) } else { Marking::pen() };
        let layout = Layout { fit, rotate, ..Layout::on(PAPER) };
        if let Ok(placed) = artwork.placed(&layout, &marking) {
            let homed = Preflight::at(JointAngles::HOME, ToolBias::NONE);
            let report = check(&placed.plan(&marking), &homed);
            prop_assert!(report.is_good(), "{:?}", report.refused_steps.first());
        }
    }

    #[test]
    fn reader_survives_any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let _ = read(Format::Svg, &bytes, &ReadOptions::default());
    }

    /// A drawing with pieces cut out, doubled and replaced.
    #[test]
    fn reader_survives_any_damaged_drawing(
        text in document(),
        cuts in proptest::collection::vec((any::<prop::sample::Index>(), 0..30_usize, ".{0,6}"), 1..6),
    ) {
        let mut broken: Vec<char> = text.chars().collect();
        for (at, length, with) in cuts {
            let start = at.index(broken.len());
            let end = (start + length).min(broken.len());
            broken.splice(start..end, with.chars());
            if broken.is_empty() {
                break;
            }
        }
        let broken: String = broken.into_iter().collect();
        let _ = read(Format::Svg, broken.as_bytes(), &ReadOptions::default());
    }
}
