//! Tests of filling: coverage of shapes, and number of pen lifts.

use proptest::collection::vec;
use proptest::prelude::*;

use super::hatch::{MAX_CONNECTION, graph};
use super::region::Region;
use super::{Area, Fill, FillMode, FillRule};
use crate::artwork::distance;

const SPACING: f64 = 0.8;

fn area(rings: &[&[[f64; 2]]], rule: FillRule) -> Area {
    Area {
        rings: rings.iter().map(|ring| ring.to_vec()).collect(),
        rule,
    }
}

fn polygon(corners: usize, radius: f64, step: usize) -> Vec<[f64; 2]> {
    let angle = |nth: usize| (nth * step) as f64 * std::f64::consts::TAU / corners as f64 + 0.3;
    let corner = |nth| {
        let (sin, cos) = libm::sincos(angle(nth));
        [radius * cos, radius * sin]
    };
    (0..corners).map(corner).collect()
}

fn shapes() -> Vec<(&'static str, Area)> {
    let square = [[0.0, 0.0], [40.0, 0.0], [40.0, 40.0], [0.0, 40.0]];
    let hole = [[10.0, 12.0], [10.0, 30.0], [25.0, 28.0], [28.0, 10.0]];
    let island = [[14.0, 16.0], [20.0, 16.0], [20.0, 22.0], [14.0, 22.0]];
    let letter = [
        [0.0, 0.0],
        [30.0, 0.0],
        [30.0, 8.0],
        [8.0, 8.0],
        [8.0, 16.0],
        [24.0, 16.0],
        [24.0, 24.0],
        [8.0, 24.0],
        [8.0, 32.0],
        [30.0, 32.0],
        [30.0, 40.0],
        [0.0, 40.0],
    ];
    let comb: Vec<[f64; 2]> = { 0..6 }
        .flat_map(|tooth| {
            let x = f64::from(tooth) * 16.0;
            [[x, 8.0], [x, 40.0], [x + 10.0, 40.0], [x + 10.0, 8.0]]
        })
        .chain([[90.0, 0.0], [0.0, 0.0]])
        .collect();
    let star = polygon(5, 50.0, 2);
    let bow = [[0.0, 0.0], [40.0, 30.0], [40.0, 0.0], [0.0, 30.0]];
    vec![
        ("square", area(&[&square], FillRule::NonZero)),
        ("circle", area(&[&polygon(90, 20.0, 1)], FillRule::NonZero)),
        ("hole", area(&[&square, &hole], FillRule::EvenOdd)),
        (
            "island",
            area(&[&square, &hole, &island], FillRule::EvenOdd),
        ),
        ("letter", area(&[&letter], FillRule::NonZero)),
        ("comb", area(&[&comb], FillRule::NonZero)),
        ("star", area(&[&star], FillRule::NonZero)),
        ("hollow star", area(&[&star], FillRule::EvenOdd)),
        ("bow", area(&[&bow], FillRule::NonZero)),
    ]
}

fn fill(mode: FillMode, angle: f64) -> Fill {
    Fill {
        mode,
        spacing: SPACING,
        angle,
        inset: SPACING / 2.0,
    }
}

/// Share of the shape that is bare, and share of the marks outside the shape, on a fine raster.
fn coverage(area: &Area, lines: &[Vec<[f64; 2]>], pen: f64) -> (f64, f64) {
    const CELL_SIDE: f64 = 0.16;
    let region = Region::of(area);
    let [x, y] = [0, 1].map(|side| region.extent(|point| point[side]));
    let (columns, rows) = (
        ((x.1 - x.0) / CELL_SIDE) as usize + 20,
        ((y.1 - y.0) / CELL_SIDE) as usize + 20,
    );
    let centre = |column: usize, row: usize| {
        [
            x.0 + (column as f64 - 9.5) * CELL_SIDE,
            y.0 + (row as f64 - 9.5) * CELL_SIDE,
        ]
    };
    let mut marked = vec![false; columns * rows];
    for line in lines {
        for pair in line.windows(2) {
            let steps = (distance(pair[0], pair[1]) / (CELL_SIDE / 2.0))
                .ceil()
                .max(1.0) as usize;
            for step in 0..=steps {
                let share = step as f64 / steps as f64;
                let at = [0, 1].map(|side| pair[0][side] + (pair[1][side] - pair[0][side]) * share);
                let index =
                    |from: f64, value: f64| ((value - from) / CELL_SIDE + 9.5).max(0.0) as usize;
                let (column, row) = (index(x.0, at[0]), index(y.0, at[1]));
                let reach = (pen / 2.0 / CELL_SIDE) as usize + 1;
                for row in row.saturating_sub(reach)..(row + reach + 1).min(rows) {
                    for column in column.saturating_sub(reach)..(column + reach + 1).min(columns) {
                        if distance(centre(column, row), at) <= pen / 2.0 {
                            marked[row * columns + column] = true;
                        }
                    }
                }
            }
        }
    }
    let (mut shape, mut bare, mut beside, mut all) = (0, 0, 0, 0);
    for row in 0..rows {
        for column in 0..columns {
            let inside = region.is_around(centre(column, row));
            let marked = marked[row * columns + column];
            shape += usize::from(inside);
            bare += usize::from(inside && !marked);
            beside += usize::from(marked && !inside);
            all += usize::from(marked);
        }
    }
    (
        bare as f64 / shape as f64,
        beside as f64 / all.max(1) as f64,
    )
}

#[test]
fn hatch_covers_shapes_only() {
    for (name, area) in shapes() {
        for angle in [0.0, 45.0, 110.0] {
            let lines = fill(FillMode::Hatch, angle).lines(&area);
            let (bare, beside) = coverage(&area, &lines, SPACING);
            assert!(
                bare < 0.03 && beside < 0.005,
                "{name} at {angle}: {bare} {beside}"
            );
        }
    }
}

#[test]
fn rings_cover_shapes_only() {
    for (name, area) in shapes() {
        let lines = fill(FillMode::Contour, 0.0).lines(&area);
        let (bare, beside) = coverage(&area, &lines, SPACING);
        assert!(bare < 0.03 && beside < 0.01, "{name}: {bare} {beside}");
    }
}

/// Covers different widths between the last two rings.
#[test]
fn middle_of_a_band_is_drawn_once() {
    for inner in [15.0, 15.3, 15.6, 15.9, 16.2, 16.5] {
        let rings = [polygon(180, 30.0, 1), polygon(180, inner, 1)];
        let band = area(&[&rings[0], &rings[1]], FillRule::EvenOdd);
        let lines = fill(FillMode::Contour, 0.0).lines(&band);
        let (bare, _) = coverage(&band, &lines, SPACING);
        let drawn: f64 = (lines.iter().flat_map(|line| line.windows(2)))
            .map(|pair| distance(pair[0], pair[1]))
            .sum();
        let needed = Region::of(&band).size_of() / SPACING;
        assert!(
            bare < 0.03 && drawn < 1.04 * needed,
            "{inner}: {bare} bare, {drawn} mm of {needed} mm"
        );
    }
}

#[test]
fn pen_lifts_exceed_the_minimum_by_at_most_a_third() {
    let (mut lifts, mut least) = (0, 0);
    for (name, area) in shapes() {
        for angle in [0.0, 45.0, 110.0] {
            for part in Region::of(&area).offset(-2.0).parts() {
                let graph = graph(&part, 6.0, angle);
                let Some(fewest) = graph.fewest(MAX_CONNECTION * 6.0) else {
                    continue;
                };
                let found = graph.paths(MAX_CONNECTION * 6.0, f64::INFINITY).len();
                assert!(found >= fewest, "{name}: {found} {fewest}");
                lifts += found;
                least += fewest;
            }
        }
    }
    assert!(lifts as f64 <= 1.3 * least as f64, "{lifts} of {least}");
    println!("{lifts} of {least}");
}

#[test]
fn a_simple_shape_is_hatched_without_lifting_the_pen() {
    for (name, area) in shapes() {
        if ["square", "circle"].contains(&name) {
            for angle in [0.0, 20.0, 45.0, 90.0] {
                let lines = fill(FillMode::Hatch, angle).lines(&area);
                assert_eq!(lines.len(), 1, "{name} at {angle}");
            }
            assert_eq!(fill(FillMode::Contour, 0.0).lines(&area).len(), 1, "{name}");
            assert_eq!(fill(FillMode::Cross, 0.0).lines(&area).len(), 2, "{name}");
        }
    }
}

#[test]
fn part_narrower_than_the_pen_gets_a_line() {
    let strip = [[0.0, 0.0], [30.0, 0.0], [30.0, 0.5], [0.0, 0.5]];
    let strip = area(&[&strip], FillRule::NonZero);
    for (mode, angle) in [
        (FillMode::Hatch, 0.0),
        (FillMode::Hatch, 45.0),
        (FillMode::Contour, 0.0),
    ] {
        let lines = fill(mode, angle).lines(&strip);
        let (bare, _) = coverage(&strip, &lines, SPACING);
        assert!(bare < 0.03, "{mode:?} at {angle}: {bare}");
    }
}

/// A hairline is drawn once, not there and back.
#[test]
fn hairline_gets_one_line() {
    let strip = |width: f64| vec![[0.0, 0.0], [30.0, 0.0], [30.0, width], [0.0, width]];
    for mode in [FillMode::Hatch, FillMode::Cross, FillMode::Contour] {
        for width in [0.2, 0.1, 0.05, 0.01] {
            let hair = area(&[&strip(width)], FillRule::NonZero);
            let lines = fill(mode, 45.0).lines(&hair);
            let drawn: f64 = (lines.iter().flat_map(|line| line.windows(2)))
                .map(|pair| distance(pair[0], pair[1]))
                .sum();
            let ends = { lines.iter().flatten() }.map(|point| point[0]);
            let (first, last) = ends.fold((f64::MAX, f64::MIN), |(least, most), x| {
                (least.min(x), most.max(x))
            });
            assert!(first < 0.2 && last > 29.8, "{mode:?} {width}");
            assert!((29.0..32.0).contains(&drawn), "{mode:?} {width}: {drawn}");
        }
    }
}

/// The bar of a t or the leg of a k is narrower and shorter than the pen, beside a wider part.
#[test]
fn bars_beside_a_wider_part_are_drawn() {
    let stem = |length: f64, height: f64| {
        let (foot, top) = (6.0, 6.0 + height);
        let right = 1.0 + length;
        vec![
            [0.0, 0.0],
            [1.0, 0.0],
            [1.0, foot],
            [right, foot],
            [right, top],
            [1.0, top],
            [1.0, 10.0],
            [0.0, 10.0],
        ]
    };
    for mode in [FillMode::Hatch, FillMode::Cross, FillMode::Contour] {
        for length in [0.5, 0.7, 0.8, 1.2, 2.0] {
            for height in [0.12, 0.3, 0.5, 0.7] {
                let bar = area(&[&stem(length, height)], FillRule::NonZero);
                let lines = fill(mode, 45.0).lines(&bar);
                let end = [1.0 + length * 0.8, 6.0 + height / 2.0];
                let off = (lines.iter().flat_map(|line| line.windows(2)))
                    .map(|pair| crate::simplify::distance_to_chord(end, pair[0], pair[1]))
                    .fold(f64::INFINITY, f64::min);
                assert!(off <= SPACING / 2.0, "{mode:?} {length} x {height}: {off}");
            }
        }
    }
}

#[test]
fn invalid_numbers_fill_nothing() {
    let (_, square) = shapes().remove(0);
    for spacing in [0.0, -1.0, 1e-9, f64::NAN, f64::INFINITY] {
        let fill = Fill {
            spacing,
            ..fill(FillMode::Hatch, 0.0)
        };
        assert!(fill.lines(&square).is_empty(), "{spacing}");
    }
    let negative = Fill {
        inset: -1.0,
        ..fill(FillMode::Hatch, 0.0)
    };
    assert!(negative.lines(&square).is_empty());
    for rings in [
        vec![],
        vec![vec![]],
        vec![vec![[1.0, 1.0]]],
        vec![vec![[f64::NAN, 0.0], [1.0, 0.0], [0.0, 1.0]]],
    ] {
        let area = Area {
            rings,
            ..Area::default()
        };
        for mode in [FillMode::Hatch, FillMode::Contour] {
            assert!(fill(mode, 30.0).lines(&area).is_empty());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn lines_stay_within_any_tangle(
        rings in vec(vec([-40.0..40.0f64, -40.0..40.0], 0..12), 0..4),
        even_odd: bool,
        angle in -200.0..200.0f64,
        spacing in 0.3..9.0f64,
        mode in 0..3usize,
    ) {
        let rule = if even_odd { FillRule::EvenOdd } else { FillRule::NonZero };
        let area = Area { rings, rule };
        let mode = [FillMode::Hatch, FillMode::Cross, FillMode::Contour][mode];
        let fill = Fill { mode, spacing, angle, inset: spacing / 2.0 };
        let region = Region::of(&area).offset(0.01);
        for line in fill.lines(&area) {
            prop_assert!(line.len() > 1);
            for pair in line.windows(2) {
                let middle = [0, 1].map(|side| f64::midpoint(pair[0][side], pair[1][side]));
                for point in [pair[0], middle] {
                    prop_assert!(region.is_around(point), "{point:?}");
                }
            }
        }
    }
}

#[test]
fn shape_smaller_than_the_pen_gets_a_line_through_its_middle() {
    let square = |x: f64, side: f64| vec![[x, 0.0], [x + side, 0.0], [x + side, side], [x, side]];
    for mode in [FillMode::Hatch, FillMode::Cross, FillMode::Contour] {
        let area = Area {
            rings: vec![square(0.0, 8.0), square(20.0, 0.6)],
            ..Area::default()
        };
        let fill = Fill {
            mode,
            spacing: 0.8,
            angle: 45.0,
            inset: 0.4,
        };
        let lines = fill.lines(&area);
        let small: Vec<_> = lines.iter().filter(|line| line[0][0] > 19.0).collect();
        assert_eq!(small.len(), 1, "{mode:?}: {small:?}");
        assert!(small[0].iter().all(|[x, _]| (20.0..=20.6).contains(x)));
    }
}
