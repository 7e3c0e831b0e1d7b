//! Outlines of dark areas.

use std::f64::consts::PI;

use crate::raster::{Raster, Size, Trace};

/// Image in which each pixel is as dark as the share of it within a shape.
fn image(side: usize, within: impl Fn(f64, f64) -> bool) -> Raster {
    let grey = (0..side * side).map(|at| {
        let inside = (0..64).filter(|nth| {
            let [x, y] = [at % side * 8 + nth % 8, at / side * 8 + nth / 8];
            within((x as f64 + 0.5) / 8.0, (y as f64 + 0.5) / 8.0)
        });
        255 - (inside.count() * 255 / 64) as u8
    });
    Raster {
        width: side,
        height: side,
        grey: grey.collect(),
        ..Raster::default()
    }
}

/// Signed area of a closed line; negative if clockwise.
fn area(points: &[[f64; 2]]) -> f64 {
    let pairs = points.windows(2);
    let twice: f64 = pairs
        .map(|pair| pair[0][0] * pair[1][1] - pair[1][0] * pair[0][1])
        .sum();
    twice / 2.0
}

#[test]
fn a_ring_has_two_round_outlines() {
    let ring = image(100, |x, y| {
        (20.0..40.0).contains(&libm::hypot(x - 50.0, y - 50.0))
    });
    let trace = Trace {
        size: Size::Width(50.0),
        ..Trace::default()
    };
    let artwork = trace.lines(&ring).unwrap().artwork;
    assert_eq!(artwork.page, Some([50.0, 50.0]));
    let [outer, inner] = artwork.strokes.as_slice() else {
        panic!("{} strokes", artwork.strokes.len())
    };
    for (stroke, radius, sense) in [(outer, 20.0, -1.0), (inner, 10.0, 1.0)] {
        assert!(stroke.is_closed());
        assert!(stroke.points.len() < 80, "{}", stroke.points.len());
        for [x, y] in &stroke.points {
            let off = libm::hypot(x - 25.0, y - 25.0) - radius;
            assert!(off.abs() < 0.1, "{off}");
        }
        let round = PI * radius * radius * sense;
        assert!((area(&stroke.points) / round - 1.0).abs() < 0.02);
    }
    assert_eq!(outer.origin.line, 11);
}

#[test]
fn touching_corners_are_joined_by_the_grey_between_them() {
    let checks = |grey: [u8; 4]| Raster {
        width: 2,
        height: 2,
        grey: grey.to_vec(),
        ..Raster::default()
    };
    let trace = Trace {
        size: Size::Pixel(10.0),
        tolerance: 0.0,
        ..Trace::default()
    };
    let outlines = |grey| trace.lines(&checks(grey)).unwrap().artwork.strokes.len();
    assert_eq!(outlines([0, 255, 255, 0]), 1);
    assert_eq!(outlines([10, 255, 255, 10]), 2);
    assert_eq!(outlines([255, 0, 0, 255]), 1);
    assert_eq!(outlines([255, 10, 10, 255]), 2);
}

#[test]
fn image_edge_closes_dark_areas() {
    let black = Raster {
        width: 30,
        height: 20,
        grey: vec![0; 600],
        ..Raster::default()
    };
    let trace = Trace {
        size: Size::Pixel(1.0),
        ..Trace::default()
    };
    let artwork = trace.lines(&black).unwrap().artwork;
    let [frame] = artwork.strokes.as_slice() else {
        panic!("{artwork:?}")
    };
    assert!((area(&frame.points) + 600.0).abs() < 2.0);
    assert_eq!(artwork.bounds(), Some([[0.0, 0.0], [30.0, 20.0]]));
}

#[test]
fn specks_are_dropped_and_an_empty_image_is_refused() {
    let speck = image(50, |x, y| (x as usize, y as usize) == (20, 20));
    let trace = Trace::default();
    let error = trace.lines(&speck).unwrap_err();
    assert!(error.message.contains("1 spots in the image"), "{error}");
    let all = Trace {
        despeckle: 0.0,
        ..trace
    };
    assert_eq!(all.lines(&speck).unwrap().artwork.strokes.len(), 1);
    let odd = Trace {
        tolerance: f64::NAN,
        ..all
    };
    odd.lines(&speck).unwrap_err();
}

#[test]
fn a_large_image_is_traced_as_a_smaller_one() {
    let side = 2500;
    let grey = (0..side * side).map(|at| if at % side >= side / 2 { 0 } else { 255 });
    let half = Raster {
        width: side,
        height: side,
        grey: grey.collect(),
        ..Raster::default()
    };
    let trace = Trace {
        size: Size::Width(82.0),
        ..Trace::default()
    };
    let artwork = trace.lines(&half).unwrap().artwork;
    let [stroke] = artwork.strokes.as_slice() else {
        panic!("{} strokes", artwork.strokes.len())
    };
    assert!((area(&stroke.points) + 41.0 * 82.0).abs() < 4.0);
}
