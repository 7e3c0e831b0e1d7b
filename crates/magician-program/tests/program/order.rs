//! Order of lines with short travel: the drawing is unchanged, and the travel never grows.

use magician_program::artwork::{Order, Tidy};
use magician_program::raster::{Engrave, Trace};
use magician_program::{Artwork, Format, Origin, ReadOptions, Setup, Stroke, Surface, Work, read};
use proptest::prelude::*;

fn artwork(lines: Vec<Vec<[f64; 2]>>) -> Artwork {
    let strokes = lines
        .into_iter()
        .map(|points| Stroke::new(points, Origin::NONE));
    Artwork {
        strokes: strokes.collect(),
        ..Artwork::default()
    }
}

/// Every straight piece regardless of direction, and every dot.
fn pieces(artwork: &Artwork) -> Vec<[[u64; 2]; 2]> {
    let bits = |point: &[f64; 2]| point.map(f64::to_bits);
    let mut pieces = Vec::new();
    for stroke in &artwork.strokes {
        let points = &stroke.points;
        if let [dot] = points.as_slice() {
            pieces.push([bits(dot), bits(dot)]);
        }
        for (from, to) in points.iter().zip(points.iter().skip(1)) {
            let (from, to) = (bits(from), bits(to));
            pieces.push([from.min(to), from.max(to)]);
        }
    }
    pieces.sort_unstable();
    pieces
}

/// Deterministic random numbers.
struct RandomSource(u64);

impl RandomSource {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn scattered(count: usize, side: f64) -> Artwork {
    let mut dice = RandomSource(7);
    let mut point = || [side * dice.next(), side * dice.next()];
    let mut lines = Vec::new();
    for nth in 0..count {
        let [x, y] = point();
        let [a, b] = point().map(|value| value / side * 2.0);
        lines.push(match nth % 3 {
            0 => vec![[x, y], [x + a, y], [x + a, y + b], [x, y]],
            _ => vec![[x, y], [x + a, y + b]],
        });
    }
    artwork(lines)
}

#[test]
fn a_row_is_drawn_from_one_end_to_the_other() {
    let line = |x: f64| vec![[x, 0.0], [x, 10.0]];
    let mut row = artwork([3.0, 0.0, 4.0, 1.0, 2.0].into_iter().map(line).collect());
    let before = pieces(&row);
    let saving = row.put_in_order(&Order::default());
    assert_eq!(saving.after_mm, 4.0);
    assert!(saving.before_mm > 40.0);
    let starts: Vec<_> = row.strokes.iter().map(|stroke| stroke.points[0]).collect();
    assert_eq!(
        starts,
        [[0.0, 0.0], [1.0, 10.0], [2.0, 0.0], [3.0, 10.0], [4.0, 0.0]]
    );
    assert_eq!(pieces(&row), before);
}

#[test]
fn closed_lines_begin_at_their_nearest_vertex() {
    let square = |x: f64| vec![[x, 0.0], [x + 4.0, 0.0], [x + 4.0, 4.0], [x, 4.0], [x, 0.0]];
    let mut squares = artwork(vec![square(0.0), square(5.0), square(10.0)]);
    let saving = squares.put_in_order(&Order::default());
    assert_eq!(saving.before_mm, 10.0);
    // From the right edge of the first, over the second, which is left where it was entered, to the
    // third.
    assert_eq!(saving.after_mm, 6.0);
    assert!(squares.strokes.iter().all(Stroke::is_closed));
}

#[test]
fn meeting_lines_are_joined() {
    let lines = vec![
        vec![[0.0, 0.0], [10.0, 0.0]],
        vec![[10.0, 10.0], [0.0, 10.0]],
        vec![[10.0, 10.0], [10.0, 0.0]],
        vec![[0.0, 10.0], [0.0, 0.005]],
    ];
    let mut square = artwork(lines.clone());
    let saving = square.put_in_order(&Order::default());
    assert_eq!(
        (saving.joined, square.strokes.len(), saving.after_mm),
        (3, 1, 0.0)
    );
    assert!(square.strokes[0].is_closed());
    let mut apart = artwork(lines);
    let saving = apart.put_in_order(&Order {
        joining: -1.0,
        ..Order::default()
    });
    assert_eq!((saving.joined, apart.strokes.len()), (0, 4));
    assert_eq!(saving.after_mm, 0.005_f64.min(saving.after_mm));
}

#[test]
fn reordering_keeps_duplicates() {
    let lines = vec![
        vec![[0.0, 0.0], [10.0, 3.0]],
        vec![[10.0, 3.0], [0.0, 0.0]],
        vec![[0.0, 5.0], [10.0, 5.0]],
    ];
    let order = Order {
        joining: -1.0,
        ..Order::default()
    };
    let mut twice = artwork(lines);
    twice.put_in_order(&order);
    assert_eq!(twice.strokes.len(), 3);
}

#[test]
fn file_order_is_kept_on_request() {
    let scattered = scattered(200, 100.0);
    let mut kept = scattered.clone();
    let saving = kept.put_in_order(&Order::OF_FILE);
    assert_eq!(kept, scattered);
    assert_eq!(saving.before_mm, saving.after_mm);
}

#[test]
fn tour_of_many_lines_is_near_the_optimum() {
    let count = 3000;
    let mut many = scattered(count, 300.0);
    let before = pieces(&many);
    let saving = many.put_in_order(&Order {
        joining: -1.0,
        ..Order::default()
    });
    assert_eq!(pieces(&many), before);
    // A tour through random points has a length of about 0.7124 times the root of their number
    // times the area (Beardwood, Halton and Hammersley; constant from Johnson and McGeoch). Lines
    // with a choice of two ends need less.
    let tour = 0.7124 * (count as f64 * 300.0 * 300.0).sqrt();
    assert!(saving.after_mm < tour, "{} of {tour}", saving.after_mm);
    let mut again = scattered(count, 300.0);
    again.put_in_order(&Order {
        joining: -1.0,
        ..Order::default()
    });
    assert_eq!(again, many);
}

fn lines() -> impl Strategy<Value = Vec<Vec<[f64; 2]>>> {
    // On a coarse grid, so that ends meet and lines repeat.
    let point = (0..12_i32, 0..12_i32).prop_map(|(x, y)| [f64::from(x) * 2.5, f64::from(y) * 2.5]);
    let points = proptest::collection::vec(point, 1..6);
    let line = (points, any::<bool>()).prop_map(|(mut points, close)| {
        if close {
            points.push(points[0]);
        }
        points.dedup();
        points
    });
    proptest::collection::vec(line, 0..40)
}

proptest! {
    #[test]
    fn reordering_never_lengthens_travel_and_keeps_the_strokes(lines in lines(), joining in prop_oneof![Just(-1.0), Just(0.01)]) {
        let original = artwork(lines);
        let mut ordered = original.clone();
        let saving = ordered.put_in_order(&Order { joining, ..Order::default() });
        prop_assert!(saving.after_mm <= saving.before_mm + 1e-9);
        prop_assert!((saving.after_mm - ordered.travel()).abs() < 1e-9);
        prop_assert_eq!(pieces(&ordered), pieces(&original));
    }
}

fn tolerant() -> Tidy {
    let mut tidy = Tidy::default();
    tidy.merge = 0.1;
    tidy.simplify = 0.02;
    tidy
}

/// Points along lines, at most a twentieth apart.
fn along(strokes: &[Stroke]) -> Vec<[f64; 2]> {
    let mut points = Vec::new();
    for stroke in strokes {
        points.extend(stroke.points.first());
        for pair in stroke.points.windows(2) {
            let [[x, y], [to_x, to_y]] = [pair[0], pair[1]];
            let count = ((to_x - x).hypot(to_y - y) / 0.05).ceil();
            let nth = (1..=count as u32).map(|nth| f64::from(nth) / count);
            points.extend(nth.map(|share| [x + (to_x - x) * share, y + (to_y - y) * share]));
        }
    }
    points
}

/// Largest distance of the points from the lines.
fn farthest(points: &[[f64; 2]], from: &[Stroke]) -> f64 {
    let to_piece = |[x, y]: [f64; 2], [a, b]: [[f64; 2]; 2]| {
        let way = [b[0] - a[0], b[1] - a[1]];
        let square = way[0] * way[0] + way[1] * way[1];
        let share = ((x - a[0]) * way[0] + (y - a[1]) * way[1]) / square;
        let share = if square > 0.0 {
            share.clamp(0.0, 1.0)
        } else {
            0.0
        };
        (x - a[0] - share * way[0]).hypot(y - a[1] - share * way[1])
    };
    let nearest = |point: [f64; 2]| {
        let pieces = from.iter().flat_map(|stroke| {
            let dot = stroke.points.first().map(|at| [*at, *at]);
            let pairs = stroke.points.windows(2).map(|pair| [pair[0], pair[1]]);
            dot.into_iter().chain(pairs)
        });
        pieces
            .map(|piece| to_piece(point, piece))
            .fold(f64::INFINITY, f64::min)
    };
    points
        .iter()
        .map(|point| nearest(*point))
        .fold(0.0, f64::max)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    /// Lines on a small sheet, whose ends often meet, in steps that are thinned, some of them
    /// duplicated.
    #[test]
    fn tidied_lines_stay_within_merge_and_simplify(
        lines in proptest::collection::vec(
            (proptest::collection::vec([0.0..2.0f64, 0.0..2.0f64], 1..9), any::<bool>()), 1..9),
        wave in 0.0..0.03f64,
    ) {
        let mut all = Vec::new();
        for (points, twice) in lines {
            let mut line: Vec<[f64; 2]> = Vec::new();
            for pair in points.windows(2) {
                for nth in 0..10 {
                    let share = f64::from(nth) / 10.0;
                    let off = if nth % 2 == 0 { wave } else { 0.0 };
                    line.push([0, 1].map(|axis| pair[0][axis] + share * (pair[1][axis] - pair[0][axis]) + off));
                }
            }
            line.extend(points.last());
            if twice {
                all.push(line.iter().rev().copied().collect());
            }
            all.push(line);
        }
        let before = artwork(all);
        let mut after = before.clone();
        after.tidy(&tolerant());
        let most = 0.1 + 0.02 + 1e-9;
        prop_assert!(farthest(&along(&after.strokes), &before.strokes) <= most);
        prop_assert!(farthest(&along(&before.strokes), &after.strokes) <= most);
        prop_assert!(after.strokes.len() <= before.strokes.len());
    }
}

#[test]
fn duplicates_are_drawn_once_regardless_of_their_start() {
    let square = [[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 9.0]];
    let from = |at: usize, back: bool| {
        let mut corners: Vec<[f64; 2]> = square.into_iter().cycle().skip(at).take(5).collect();
        if back {
            corners.reverse();
        }
        corners
    };
    let open = square.to_vec();
    let turned = open.iter().rev().copied().collect();
    let mut drawing = artwork(vec![
        from(0, false),
        from(2, false),
        from(3, true),
        open,
        turned,
    ]);
    let mut tidy = Tidy::default();
    tidy.merge = 0.0;
    assert_eq!(drawing.clone().tidy(&tidy).repeated, 3);
    tidy.dedupe = false;
    assert_eq!(drawing.tidy(&tidy).repeated, 0);
    assert_eq!(drawing.strokes.len(), 5);
}

#[test]
fn ordered_strokes_are_not_joined() {
    let lines = vec![vec![[0.0, 0.0], [9.0, 0.0]], vec![[9.0, 0.0], [9.0, 9.0]]];
    let mut drawing = artwork(lines);
    drawing.in_order = true;
    let before = drawing.clone();
    drawing.tidy(&Tidy::default());
    assert_eq!(drawing, before);
}

/// Square around a point.
fn square([x, y]: [f64; 2], side: f64) -> Vec<[f64; 2]> {
    let far = side / 2.0;
    let corners = [
        [-far, -far],
        [far, -far],
        [far, far],
        [-far, far],
        [-far, -far],
    ];
    corners.map(|[dx, dy]| [x + dx, y + dy]).to_vec()
}

/// Sizes of the lines in order, by their boxes.
fn sides(artwork: &Artwork) -> Vec<f64> {
    let width = |stroke: &Stroke| {
        let xs = stroke.points.iter().map(|point| point[0]);
        xs.clone().fold(f64::MIN, f64::max) - xs.fold(f64::MAX, f64::min)
    };
    artwork.strokes.iter().map(width).collect()
}

const INSIDE_FIRST: Order = Order {
    rearrange: true,
    inside_first: true,
    joining: 0.01,
    effort: 1_000_000,
};

#[test]
fn plate_within_a_plate_is_cut_from_the_inside_out() {
    // An outline, a window in it, a mark in the window, and next to them a plate with a hole and a
    // slit.
    let mut art = artwork(vec![
        square([0.0, 0.0], 80.0),
        square([5.0, 5.0], 40.0),
        vec![[0.0, 5.0], [8.0, 5.0]],
        square([200.0, 0.0], 50.0),
        square([190.0, 0.0], 10.0),
        vec![[205.0, 0.0], [217.0, 0.0]],
    ]);
    let drawn = pieces(&art);
    art.put_in_order(&INSIDE_FIRST);
    assert_eq!(pieces(&art), drawn);
    let sides = sides(&art);
    let at = |side: f64| sides.iter().position(|other| (other - side).abs() < 1e-9);
    assert!(at(8.0) < at(40.0) && at(40.0) < at(80.0), "{sides:?}");
    assert!(at(10.0) < at(50.0) && at(12.0) < at(50.0), "{sides:?}");
    // Plates are cut one after the other.
    assert!(
        at(80.0) < at(10.0).min(at(12.0)) || at(50.0) < at(8.0),
        "{sides:?}"
    );
    art.put_in_order(&Order::default());
}

#[test]
fn file_that_cuts_the_inside_first_by_short_ways_is_left_alone() {
    let lines = vec![square([0.0, 0.0], 10.0), square([0.0, 0.0], 20.0)];
    let mut art = artwork(lines);
    let before = art.clone();
    art.put_in_order(&INSIDE_FIRST);
    assert_eq!(sides(&art), sides(&before));
}

proptest! {
    #[test]
    fn content_of_a_square_comes_before_it(
        squares in prop::collection::vec(((-50_i32..50), (-50_i32..50), (1_u32..60)), 1..40),
    ) {
        let lines = squares.iter().map(|(x, y, side)| square([f64::from(*x), f64::from(*y)], f64::from(*side)));
        let mut art = artwork(lines.collect());
        let drawn = pieces(&art);
        art.put_in_order(&INSIDE_FIRST);
        prop_assert_eq!(pieces(&art), drawn);
        let place = |stroke: &Stroke| {
            let side = |axis: usize| {
                let values = stroke.points.iter().map(move |point| point[axis]);
                [values.clone().fold(f64::MAX, f64::min), values.fold(f64::MIN, f64::max)]
            };
            [side(0), side(1)]
        };
        let places: Vec<_> = art.strokes.iter().map(place).collect();
        for (at, outer) in places.iter().enumerate() {
            for inner in &places[at + 1..] {
                let lies = |axis: usize| outer[axis][0] < inner[axis][0] && inner[axis][1] < outer[axis][1];
                prop_assert!(!(lies(0) && lies(1)), "{inner:?} comes after {outer:?}");
            }
        }
    }
}

#[test]
fn outline_of_twenty_thousand_lines_comes_last() {
    let mut art = scattered(20_000, 400.0);
    art.strokes
        .insert(0, Stroke::new(square([200.0, 200.0], 410.0), Origin::NONE));
    art.put_in_order(&INSIDE_FIRST);
    let last = art.strokes.last().expect("lines");
    assert_eq!(last.points.len(), 5);
}

/// Lines of a file that are marked, in order.
fn lines_marked(work: Work) -> Vec<u32> {
    let plate = b"<svg xmlns='http://www.w3.org/2000/svg' width='70mm' height='50mm' viewBox='0 0 70 50' \
        fill='none' stroke='black'>\n<rect width='70' height='50'/>\n<circle cx='18' cy='25' r='6'/>\n\
        <rect x='44' y='17' width='16' height='16'/>\n</svg>";
    let mut setup = Setup::default();
    (setup.surface, setup.work) = (Some(Surface::level(-60.0)), work);
    let parsed = read(Format::Svg, plate, &ReadOptions::default()).expect("it is read");
    let prepared = setup
        .plan(Format::Svg, parsed.content)
        .expect("it is planned");
    let mut lines: Vec<_> = prepared
        .plan
        .steps
        .iter()
        .map(|step| step.origin.line)
        .collect();
    lines.retain(|line| *line > 0);
    lines.dedup();
    lines
}

#[test]
fn laser_cuts_the_holes_of_a_plate_first_and_a_pen_goes_the_shortest_way() {
    assert_eq!(lines_marked(Work::Engrave(Engrave::default())), [3, 4, 2]);
    assert_eq!(lines_marked(Work::Draw(Trace::default())), [2, 3, 4]);
}
