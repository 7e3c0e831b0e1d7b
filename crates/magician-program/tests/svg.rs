//! SVG drawings as strokes: lengths, places, sizes, what is left out and what is refused.

use magician_program::{
    Artwork, Content, Fills, Format, Problem, ReadOptions, Reading, Stroke, read,
};

const HOUSE: &[u8] = include_bytes!("../samples/house.svg");
const CURVES: &[u8] = include_bytes!("../samples/curves.svg");

fn reading_with(
    text: impl AsRef<[u8]>,
    options: &ReadOptions,
) -> Result<(Artwork, Vec<Problem>), Problem> {
    let Reading { content, notes } = read(Format::Svg, text.as_ref(), options)?;
    match content {
        Content::Artwork(artwork) => Ok((artwork, notes)),
        other => panic!("{other:?}"),
    }
}

fn reading(text: impl AsRef<[u8]>) -> (Artwork, Vec<Problem>) {
    reading_with(text, &ReadOptions::default()).unwrap()
}

fn problem(text: impl AsRef<[u8]>) -> Problem {
    reading_with(text, &ReadOptions::default()).unwrap_err()
}

/// A page of 100 by 100 mm whose unit is 1 mm.
fn page(inside: &str) -> String {
    format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="100mm" height="100mm" viewBox="0 0 100 100">{inside}</svg>"#
    )
}

#[track_caller]
fn near(one: f64, other: f64, within: f64) {
    assert!(
        (one - other).abs() <= within,
        "{one} is not {other} within {within}"
    );
}

#[track_caller]
fn assert_points(stroke: &Stroke, expected: &[[f64; 2]]) {
    assert_eq!(stroke.points.len(), expected.len(), "{:?}", stroke.points);
    for (point, expected) in stroke.points.iter().zip(expected) {
        near(point[0], expected[0], 1e-4);
        near(point[1], expected[1], 1e-4);
    }
}

#[test]
fn dump() {
    let (house, notes) = reading(HOUSE);
    for s in &house.strokes {
        println!(
            "{:?} {} {:?} closed {} len {:.4}",
            s.origin,
            house.names[s.origin.name_index().unwrap()],
            s.points.len(),
            s.is_closed(),
            s.length()
        );
    }
    println!("{notes:?} {:?} {:?}", house.page, house.bounds());
    let (house, notes) = reading(CURVES);
    for s in &house.strokes {
        println!(
            "{:?} {} {:?} closed {} len {:.4}",
            s.origin,
            house.names[s.origin.name_index().unwrap()],
            s.points.len(),
            s.is_closed(),
            s.length()
        );
    }
    println!("{notes:?} {:?} {:?}", house.page, house.bounds());
    let (house, notes) = reading(page(
        r#"<text x="10" y="50" font-size="10" font-family="Arial" font-weight="bold">Hi, Welt ß</text>"#,
    ));
    for s in &house.strokes {
        println!(
            "{:?} {} {:?} closed {} len {:.4}",
            s.origin,
            house.names[s.origin.name_index().unwrap()],
            s.points.len(),
            s.is_closed(),
            s.length()
        );
    }
    println!("{notes:?} {:?} {:?}", house.page, house.bounds());
    println!(
        "{}",
        problem(page(
            r#"<text x="10" y="50" font-size="10" id="jp">Hi 日本</text>"#
        ))
    );
}
