//! Lines in an order with short ways between them: what is drawn stays, the ways never grow.

use magician_program::artwork::Order;
use magician_program::{Artwork, Origin, Stroke};
use proptest::prelude::*;

fn artwork(lines: Vec<Vec<[f64; 2]>>) -> Artwork {
    let strokes = lines.into_iter().map(|points| Stroke {
        points,
        origin: Origin::NONE,
    });
    Artwork {
        strokes: strokes.collect(),
        ..Artwork::default()
    }
}

/// Every straight piece, whichever way it is drawn, and every dot.
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

/// The same numbers every time.
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn scattered(count: usize, side: f64) -> Artwork {
    let mut dice = Dice(7);
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
fn closed_lines_begin_where_it_is_near() {
    let square = |x: f64| vec![[x, 0.0], [x + 4.0, 0.0], [x + 4.0, 4.0], [x, 4.0], [x, 0.0]];
    let mut squares = artwork(vec![square(0.0), square(5.0), square(10.0)]);
    let saving = squares.put_in_order(&Order::default());
    assert_eq!(saving.before_mm, 10.0);
    // From the first's right edge over the second, which is left where it is entered, to the third.
    assert_eq!(saving.after_mm, 6.0);
    assert!(squares.strokes.iter().all(Stroke::is_closed));
}

#[test]
fn lines_that_meet_become_one() {
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
fn what_is_there_twice_is_drawn_twice_unless_told() {
    let lines = vec![
        vec![[0.0, 0.0], [10.0, 3.0]],
        vec![[10.0, 3.0], [0.0, 0.0]],
        vec![[0.0, 5.0], [10.0, 5.0]],
    ];
    let order = Order {
        joining: -1.0,
        ..Order::default()
    };
    let mut twice = artwork(lines.clone());
    assert_eq!(twice.put_in_order(&order).repeated, 0);
    assert_eq!(twice.strokes.len(), 3);
    let mut once = artwork(lines);
    assert_eq!(
        once.put_in_order(&Order {
            once: true,
            ..order
        })
        .repeated,
        1
    );
    assert_eq!(once.strokes.len(), 2);
}

#[test]
fn the_order_of_the_file_is_kept_if_told() {
    let scattered = scattered(200, 100.0);
    let mut kept = scattered.clone();
    let saving = kept.put_in_order(&Order::OF_FILE);
    assert_eq!(kept, scattered);
    assert_eq!(saving.before_mm, saving.after_mm);
}

#[test]
fn many_lines_are_near_to_the_best_order() {
    let count = 3000;
    let mut many = scattered(count, 300.0);
    let before = pieces(&many);
    let saving = many.put_in_order(&Order {
        joining: -1.0,
        ..Order::default()
    });
    assert_eq!(pieces(&many), before);
    // A tour through points at random is about 0.7124 times the root of their number and the area (Beardwood, Halton and
    // Hammersley; the constant from Johnson and McGeoch); lines with two ends to choose from take less.
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
    fn the_ways_never_grow_and_what_is_drawn_stays(lines in lines(), joining in prop_oneof![Just(-1.0), Just(0.01)]) {
        let original = artwork(lines);
        let mut ordered = original.clone();
        let saving = ordered.put_in_order(&Order { joining, ..Order::default() });
        prop_assert!(saving.after_mm <= saving.before_mm + 1e-9);
        prop_assert!((saving.after_mm - ordered.travel()).abs() < 1e-9);
        prop_assert_eq!(pieces(&ordered), pieces(&original));
    }
}
