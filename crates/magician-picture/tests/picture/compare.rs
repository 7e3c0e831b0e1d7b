//! Comparison of drawings with the artwork or image that they should show.

use magician::sim::world::Drawing;
use magician_picture::compare::{Comparison, Picture, PixelGrid, Tones, compare, svg_lines};
use magician_program::Raster;
use magician_program::rehearse::{RehearseOptions, rehearse};
use magician_program::{Action, Origin, Plan, Tool, Travel};

type Lines = Vec<Vec<[f64; 2]>>;

/// Returns two concentric squares, 24 and 8 mm wide.
fn squares() -> Lines {
    let square = |low: f64, high: f64| {
        vec![
            [low, low],
            [high, low],
            [high, high],
            [low, high],
            [low, low],
        ]
    };
    vec![square(0.0, 24.0), square(8.0, 16.0)]
}

fn moved(lines: &Lines, [dx, dy]: [f64; 2]) -> Lines {
    let shift = |line: &Vec<[f64; 2]>| line.iter().map(|[x, y]| [x + dx, y + dy]).collect();
    lines.iter().map(shift).collect()
}

#[test]
fn equal_lines_match() {
    let matched = compare(&squares(), &squares(), 0.0).matched;
    assert!(matched.is_good());
    assert_eq!((matched.worst(), matched.mean), (0.0, 0.0));
    assert_eq!(matched.pixel, 0.05);
}

#[test]
fn offset_of_a_moved_drawing_is_measured() {
    for shift in [0.1, 0.3, 1.0] {
        let drawn = moved(&squares(), [shift, 0.0]);
        let matched = compare(&squares(), &drawn, shift + 0.06).matched;
        assert!(matched.is_good(), "{matched:?}");
        assert!(
            (matched.worst() - shift).abs() <= matched.pixel,
            "{matched:?}"
        );
        let strict = compare(&squares(), &drawn, shift - 0.06).matched;
        // Only the sides across the shift differ: half of the lines.
        for share in [strict.missing_share, strict.extra_share] {
            assert!((share - 0.5).abs() < 0.03, "{strict:?}");
        }
        assert!((strict.mean - shift / 2.0).abs() < 0.05, "{strict:?}");
    }
}

#[test]
fn a_missing_line_is_missing() {
    let matched = compare(&squares(), &squares()[..1], 0.2).matched;
    assert_eq!(matched.extra_share, 0.0);
    assert!(
        (matched.missing_share - 32.0 / 128.0).abs() < 0.01,
        "{matched:?}"
    );
    assert!((matched.worst_missing - 8.0).abs() < 0.1, "{matched:?}");
    let more = compare(&squares()[..1], &squares(), 0.2).matched;
    assert_eq!(
        (more.missing_share, more.extra_share),
        (0.0, matched.missing_share)
    );
    let nothing = compare(&squares(), &[], 0.2).matched;
    assert_eq!((nothing.missing_share, nothing.extra_share), (1.0, 0.0));
}

#[test]
fn nan_and_infinite_numbers_are_ignored() {
    let mut drawn = squares();
    drawn.push(vec![[f64::NAN, 0.0], [f64::INFINITY, 1.0], [1e300, -1e300]]);
    assert!(compare(&squares(), &drawn, 0.1).matched.is_good());
}

#[test]
fn large_drawings_have_coarser_pixels() {
    let frame = PixelGrid::around([[0.0, 0.0], [900.0, 700.0]], 2.0, 20.0);
    let [width, height] = frame.size();
    assert!(width * height <= 16_100_000, "{frame:?}");
    assert!(frame.pixels_per_mm() < 6.0 && frame.pixels_per_mm() > 4.0);
}

#[test]
fn difference_is_an_image() {
    let drawn = moved(&squares()[..1].to_vec(), [0.1, 0.0]);
    let png = compare(&squares(), &drawn, 0.3).to_png();
    let image = image::load_from_memory(&png).unwrap().to_rgb8();
    let count = |colour: [u8; 3]| image.pixels().filter(|pixel| pixel.0 == colour).count();
    let white = [255, 255, 255];
    // The inner square is missing and red; the outer one matches: black on grey.
    assert!(count([209, 26, 33]) > 1000 && count([26, 26, 26]) > 1000);
    assert!(count([190, 196, 203]) > 1000 && count([240, 140, 20]) == 0);
    assert!(count(white) > image.pixels().len() / 2);
}

#[test]
fn svg_is_read_independently_of_the_reader() {
    let svg =
        br#"<svg xmlns="http://www.w3.org/2000/svg" width="80mm" height="60mm" viewBox="0 0 80 60">
        <g fill="none" stroke="black" transform="translate(10 0)"><circle cx="30" cy="20" r="10"/>
        <path d="M0 50h20"/></g></svg>"#;
    let lines = svg_lines(svg).unwrap();
    assert_eq!(lines.len(), 2);
    for [x, y] in &lines[0] {
        assert!(((x - 40.0).hypot(y - 40.0) - 10.0).abs() < 0.005, "{x} {y}");
    }
    let ring: Vec<_> = (0..=720)
        .map(|nth| f64::from(nth).to_radians() / 2.0)
        .map(|angle| [40.0 + 10.0 * angle.cos(), 40.0 + 10.0 * angle.sin()])
        .collect();
    let drawn = vec![ring, vec![[10.0, 10.0], [30.0, 10.0]]];
    let frame = PixelGrid::around(drawn.iter().flatten().copied(), 1.0, 20.0);
    let source = Picture::of_svg(frame, svg, |point| point).unwrap();
    let drawn = Picture::of_lines(frame, &drawn);
    let matched = Comparison::of(source, drawn, 0.1).unwrap().matched;
    assert!(matched.is_good() && matched.worst() <= 0.08, "{matched:?}");
    assert!(svg_lines(b"no drawing").is_err());
}

/// Returns burnt lines half a millimetre apart, each from white to black.
fn burnt() -> Drawing {
    let mut plan = Plan::new("grey");
    plan.tool = Some(Tool::Laser);
    for row in 0..20 {
        let y = row as f32 * 0.5 + 0.25;
        let (to, by) = ([220.0, y, 0.0, 0.0], Travel::Line);
        plan.push(Action::Move { to, by }, Origin::NONE);
        for column in 0..20u8 {
            let to = [221.0 + f32::from(column), y, 0.0];
            let power = f32::from(column) * 5.0;
            plan.push(Action::Burn { to, power }, Origin::NONE);
        }
        plan.push(
            Action::Burn {
                to: [241.0, y, 0.0],
                power: 0.0,
            },
            Origin::NONE,
        );
    }
    plan.push(Action::Laser(false), Origin::NONE);
    rehearse(&plan, &RehearseOptions::default())
        .unwrap()
        .drawing
}

#[test]
fn burns_are_as_dark_as_their_power() {
    let corners = [[220.0, 0.0], [240.0, 10.0]];
    let burnt = Tones::of_burns(&burnt(), corners, 2.0, 0.5);
    let grey = (0..20).map(|column| 255 - (f64::from(column) * 0.05 * 255.0).round() as u8);
    let image = |grey: Vec<u8>| Raster {
        width: grey.len(),
        height: 1,
        grey,
        ..Raster::default()
    };
    let source = image(grey.clone().collect());
    let matched = burnt
        .difference(&Tones::of_image(&source, corners, 2.0))
        .unwrap();
    assert!(matched.mean < 0.01 && matched.worst < 0.02, "{matched:?}");
    let mirrored = image(grey.rev().collect());
    let wrong = burnt
        .difference(&Tones::of_image(&mirrored, corners, 2.0))
        .unwrap();
    assert!(wrong.mean > 0.4, "{wrong:?}");
}

#[test]
fn an_image_is_the_right_way_up() {
    let image = Raster {
        width: 1,
        height: 2,
        grey: vec![0, 255],
        ..Raster::default()
    };
    let corners = [[0.0, 0.0], [1.0, 2.0]];
    let tones = Tones::of_image(&image, corners, 1.0);
    // The upper half of the image is black and nothing is burnt there; the white rest matches.
    let nothing = Tones::of_burns(&Drawing::default(), corners, 1.0, 1.0);
    let matched = tones.difference(&nothing).unwrap();
    assert_eq!((matched.mean, matched.worst), (0.5, 1.0));
    let upside_down = Raster {
        grey: vec![255, 0],
        ..image
    };
    assert_ne!(tones, Tones::of_image(&upside_down, corners, 1.0));
}
