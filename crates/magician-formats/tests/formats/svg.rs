//! SVG drawings as strokes: lengths, positions, sizes, notes and refusals.

use magician_formats::{
    Artwork, Content, Diagnostic, Fills, Format, Lines, Parsed, ReadOptions, Stroke, White, read,
};

const HOUSE: &[u8] = include_bytes!("../../../magician-program/samples/house.svg");
const CURVES: &[u8] = include_bytes!("../../../magician-program/samples/curves.svg");

fn reading_with(
    text: impl AsRef<[u8]>,
    options: &ReadOptions,
) -> Result<(Artwork, Vec<Diagnostic>), Diagnostic> {
    let Parsed { content, notes } = read(Format::Svg, text.as_ref(), options)?;
    match content {
        Content::Artwork(artwork) => Ok((artwork, notes)),
        other => panic!("{other:?}"),
    }
}

fn reading(text: impl AsRef<[u8]>) -> (Artwork, Vec<Diagnostic>) {
    reading_with(text, &ReadOptions::default()).unwrap()
}

fn diagnostic(text: impl AsRef<[u8]>) -> Diagnostic {
    reading_with(text, &ReadOptions::default()).unwrap_err()
}

/// Returns a page of 100 by 100 mm whose unit is 1 mm.
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

/// Perimeter of an ellipse by Ramanujan's second formula, whose error is far below the tolerances
/// here.
fn ellipse(a: f64, b: f64) -> f64 {
    let h = ((a - b) / (a + b)).powi(2);
    std::f64::consts::PI * (a + b) * (1.0 + 3.0 * h / (10.0 + (4.0 - 3.0 * h).sqrt()))
}

/// Length of a Bezier curve, as the sum of 100,000 short chords.
fn bezier(at: impl Fn(f64) -> [f64; 2]) -> f64 {
    let count = 100_000;
    let points = (0..=count).map(|nth| at(f64::from(nth) / f64::from(count)));
    let mut points = points.peekable();
    let mut length = 0.0;
    while let (Some(from), Some(to)) = (points.next(), points.peek()) {
        length += (to[0] - from[0]).hypot(to[1] - from[1]);
    }
    length
}

fn cubic(p: [[f64; 2]; 4]) -> impl Fn(f64) -> [f64; 2] {
    move |t| {
        let u = 1.0 - t;
        let w = [u * u * u, 3.0 * u * u * t, 3.0 * u * t * t, t * t * t];
        [0, 1].map(|axis| (0..4).map(|nth| w[nth] * p[nth][axis]).sum())
    }
}

fn quadratic(p: [[f64; 2]; 3]) -> impl Fn(f64) -> [f64; 2] {
    move |t| {
        let u = 1.0 - t;
        let w = [u * u, 2.0 * u * t, t * t];
        [0, 1].map(|axis| (0..3).map(|nth| w[nth] * p[nth][axis]).sum())
    }
}

fn fine_options() -> ReadOptions {
    let mut options = ReadOptions::default();
    options.tolerance = 0.001;
    options
}

#[test]
fn house_sample_has_its_lines() {
    let (house, notes) = reading_with(HOUSE, &fine_options()).unwrap();
    assert_eq!(notes, []);
    let page = house.page.unwrap();
    near(page[0], 80.0, 1e-4);
    near(page[1], 60.0, 1e-4);
    let lengths: Vec<f64> = house.strokes.iter().map(Stroke::length).collect();
    let roof = 2.0 * 25_f64.hypot(20.0);
    let flag = 4.0 + 6.0 + 5.0 + 3.0;
    let expected = [
        140.0,
        roof,
        17.0,
        ellipse(5.0, 5.0),
        ellipse(6.0, 4.0),
        flag,
    ];
    assert_eq!(lengths.len(), expected.len());
    for (length, expected) in lengths.iter().zip(expected) {
        near(*length, expected, 0.01);
    }
    let closed: Vec<bool> = house.strokes.iter().map(Stroke::is_closed).collect();
    assert_eq!(closed, [true, false, false, true, true, true]);
    // The Y axis points up: the top of the roof is below the upper edge of the page.
    assert_points(
        &house.strokes[1],
        &[[15.0, 35.0], [40.0, 55.0], [65.0, 35.0]],
    );
    assert_points(&house.strokes[2], &[[40.0, 5.0], [40.0, 22.0]]);
    let [least, most] = house.bounds().unwrap();
    for (value, expected) in least.into_iter().chain(most).zip([15.0, 5.0, 65.0, 55.0]) {
        near(value, expected, 1e-4);
    }
}

#[test]
fn every_stroke_has_its_origin() {
    let (house, _) = reading(HOUSE);
    let text = std::str::from_utf8(HOUSE).unwrap();
    let lines = Lines::new(text);
    let tags: Vec<&str> = house
        .strokes
        .iter()
        .map(|stroke| &text[lines.range(&stroke.origin).unwrap()])
        .collect();
    assert_eq!(tags[0], r#"<rect x="20" y="25" width="40" height="30"/>"#);
    assert_eq!(tags[3], r#"<circle cx="50" cy="36" r="5"/>"#);
    let name = |stroke: &Stroke| house.names[stroke.origin.name_index().unwrap()].as_str();
    assert_eq!(name(&house.strokes[3]), "circle");
}

#[test]
fn names_are_ids_and_used_elements_point_to_the_use() {
    let text = page(
        "\n<defs><path id='arrow' d='M0 0 L 5 0'/></defs>\n<!-- größer -->  <use href='#arrow' x='10' y='10'/>\n<g id='both'>\n <line id='low' x2='9' stroke='red'/>\n<line x2='8' stroke='red'/></g>",
    )
    .replace("<path id", "<path stroke='black' id");
    let (artwork, _) = reading(&text);
    let told: Vec<(u32, u32, &str)> = artwork
        .strokes
        .iter()
        .map(|stroke| {
            let name = &artwork.names[stroke.origin.name_index().unwrap()];
            (stroke.origin.line, stroke.origin.column, name.as_str())
        })
        .collect();
    assert_eq!(told, [(3, 18, "use"), (5, 2, "low"), (6, 1, "line")]);
    assert_points(&artwork.strokes[0], &[[10.0, 90.0], [15.0, 90.0]]);
}

#[test]
fn ids_of_the_file_do_not_collide_with_generated_ids() {
    let ids = ["element-0-3", "element-0-4", "element-1-4", "element-2x"];
    let lines: String = ids
        .iter()
        .map(|id| format!("\n<line x2='9' stroke='red'/><line id='{id}' x2='8' stroke='red'/>"))
        .collect();
    let (artwork, _) = reading(page(&lines));
    let name = |stroke: &Stroke| artwork.names[stroke.origin.name_index().unwrap()].clone();
    let names: Vec<String> = artwork.strokes.iter().map(name).collect();
    let expected: Vec<&str> = ids.iter().flat_map(|id| ["line", *id]).collect();
    assert_eq!(names, expected);
}

#[test]
fn curve_lengths_are_exact() {
    let (curves, notes) = reading_with(CURVES, &fine_options()).unwrap();
    assert_eq!(notes, []);
    let lengths: Vec<f64> = curves.strokes.iter().map(Stroke::length).collect();
    // The unit is 1/100 mm, enlarged by 1.5.
    let unit = 0.015;
    let wave = bezier(cubic([
        [0.0, 0.0],
        [1000.0, -1500.0],
        [3000.0, -1500.0],
        [4000.0, 0.0],
    ]));
    let bow = bezier(quadratic([
        [0.0, 3000.0],
        [2000.0, 1000.0],
        [4000.0, 3000.0],
    ]));
    // The second half of each curve mirrors the first.
    near(lengths[0], 2.0 * wave * unit, 0.01);
    near(lengths[1], 2.0 * bow * unit, 0.01);
    // Two arcs have their ends 3000 apart: radii of 1500 and 1000, turned by 20 degrees, are too
    // small for that and are scaled up together.
    let turn = 20_f64.to_radians();
    let grown = (1500.0 * turn.cos() / 1500.0).hypot(1500.0 * turn.sin() / 1000.0);
    near(
        lengths[2],
        ellipse(1500.0 * grown, 1000.0 * grown) * unit,
        0.01,
    );
    near(lengths[3], 4.0 * 1500.0 * unit, 1e-3);
    near(lengths[4], 4.0 * 1100.0 * unit, 1e-3);
    assert_eq!(curves.strokes.len(), 5);
    let [least, most] = curves.bounds().unwrap();
    near(least[0], 30.0, 1e-3);
    near(most[0], 30.0 + 8000.0 * unit, 1e-3);
    let page = curves.page.unwrap();
    near(page[0], 210.0, 1e-4);
    near(page[1], 297.0, 1e-4);
}

/// Distance from a point to a polyline.
fn distance_to_line(line: &[[f64; 2]], [x, y]: [f64; 2]) -> f64 {
    let to = |pair: &[[f64; 2]]| {
        let [a, b] = [pair[0], pair[1]];
        let way = [b[0] - a[0], b[1] - a[1]];
        let square = way[0] * way[0] + way[1] * way[1];
        let share = ((x - a[0]) * way[0] + (y - a[1]) * way[1]) / square.max(1e-300);
        let share = share.clamp(0.0, 1.0);
        (a[0] + share * way[0] - x).hypot(a[1] + share * way[1] - y)
    };
    line.windows(2).map(to).fold(f64::INFINITY, f64::min)
}

#[test]
fn vertices_are_within_tolerance_of_the_curve() {
    let shape = [[5.0, 90.0], [80.0, 5.0], [-20.0, 0.0], [90.0, 60.0]];
    let text = page(r#"<path stroke="black" fill="none" d="M5,90 C80,5 -20,0 90,60"/>"#);
    let curve = cubic(shape);
    for tolerance in [0.5, 0.1, 0.05, 0.01] {
        let mut options = ReadOptions::default();
        options.tolerance = tolerance;
        let (artwork, _) = reading_with(&text, &options).unwrap();
        let line = &artwork.strokes[0].points;
        let strays = (0..=5000).map(|nth| {
            let [x, y] = curve(f64::from(nth) / 5000.0);
            distance_to_line(line, [x, 100.0 - y])
        });
        let worst = strays.fold(0.0, f64::max);
        assert!(worst <= tolerance, "{worst} of {tolerance}");
        // An error far below the tolerance would be a waste of corners.
        assert!(worst >= tolerance / 10.0, "{worst} of {tolerance}");
    }
    for (tolerance, radius) in [(0.05, 40.0), (0.2, 10.0)] {
        let mut options = ReadOptions::default();
        options.tolerance = tolerance;
        let text = page(&format!(
            r#"<circle cx="50" cy="50" r="{radius}" stroke="black"/>"#
        ));
        let (artwork, _) = reading_with(&text, &options).unwrap();
        let line = &artwork.strokes[0].points;
        let angles = (0..3600).map(|nth| f64::from(nth) / 3600.0 * std::f64::consts::TAU);
        let strays = angles.map(|angle| {
            distance_to_line(
                line,
                [50.0 + radius * angle.cos(), 50.0 + radius * angle.sin()],
            )
        });
        let worst = strays.fold(0.0, f64::max);
        assert!(worst <= tolerance + 3e-4 * radius, "{worst} of {tolerance}");
    }
}

#[test]
fn sizes_units_and_view_boxes_are_right() {
    // Attributes of the root element, and the position of (10, 10) in its units: mm from the left
    // edge, mm below the upper one.
    let table = [
        (
            r#"width="100mm" height="50mm" viewBox="0 0 100 50""#,
            [100.0, 50.0],
            [10.0, 10.0],
        ),
        (
            r#"width="10cm" height="5cm" viewBox="0 0 100 50""#,
            [100.0, 50.0],
            [10.0, 10.0],
        ),
        (
            r#"width="4in" height="2in" viewBox="0 0 400 200""#,
            [101.6, 50.8],
            [2.54, 2.54],
        ),
        (
            r#"width="72pt" height="36pt" viewBox="0 0 72 36""#,
            [25.4, 12.7],
            [25.4 / 7.2, 25.4 / 7.2],
        ),
        (
            r#"width="6pc" height="6pc""#,
            [25.4, 25.4],
            [25.4 / 9.6, 25.4 / 9.6],
        ),
        (
            r#"width="96" height="96""#,
            [25.4, 25.4],
            [25.4 / 9.6, 25.4 / 9.6],
        ),
        (
            r#"width="96px" height="48px" viewBox="0 0 192 96""#,
            [25.4, 12.7],
            [25.4 / 19.2, 25.4 / 19.2],
        ),
        // The view box does not start at 0.
        (
            r#"width="100mm" height="100mm" viewBox="-10 -20 100 100""#,
            [100.0, 100.0],
            [20.0, 30.0],
        ),
        // Pages wider than the box: the drawing is centred, aligned left, stretched, or sliced.
        (
            r#"width="200mm" height="100mm" viewBox="0 0 100 100""#,
            [200.0, 100.0],
            [60.0, 10.0],
        ),
        (
            r#"width="200mm" height="100mm" viewBox="0 0 100 100" preserveAspectRatio="xMinYMin meet""#,
            [200.0, 100.0],
            [10.0, 10.0],
        ),
        (
            r#"width="200mm" height="100mm" viewBox="0 0 100 100" preserveAspectRatio="none""#,
            [200.0, 100.0],
            [20.0, 10.0],
        ),
        (
            r#"width="200mm" height="100mm" viewBox="0 0 100 100" preserveAspectRatio="xMidYMin slice""#,
            [200.0, 100.0],
            [20.0, 20.0],
        ),
        // The missing side follows from the other.
        (
            r#"width="100mm" viewBox="0 0 100 50""#,
            [100.0, 50.0],
            [10.0, 10.0],
        ),
        // Without a size the unit is a pixel.
        (
            r#"viewBox="0 0 96 96""#,
            [25.4, 25.4],
            [25.4 / 9.6, 25.4 / 9.6],
        ),
        (
            r#"width="100%" height="100%" viewBox="0 0 96 96""#,
            [25.4, 25.4],
            [25.4 / 9.6, 25.4 / 9.6],
        ),
    ];
    for (root, size, at) in table {
        let text = format!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" {root}><path d="M10 10 h1" stroke="black"/></svg>"#
        );
        let (artwork, notes) = reading(&text);
        let page = artwork.page.unwrap();
        for axis in 0..2 {
            near(page[axis], size[axis], 1e-3);
        }
        let point = artwork.strokes[0].points[0];
        assert!((point[0] - at[0]).abs() < 1e-3, "{root}: {point:?}");
        assert!(
            (size[1] - point[1] - at[1]).abs() < 1e-3,
            "{root}: {point:?}"
        );
        let only_box = root.starts_with("viewBox") || root.contains('%');
        assert_eq!(notes.len(), usize::from(only_box), "{root}: {notes:?}");
    }
    let (artwork, _) = reading(
        r#"<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0H96V96" stroke="red"/></svg>"#,
    );
    assert_eq!(artwork.page, None);
    near(artwork.strokes[0].length(), 2.0 * 25.4, 1e-3);
}

#[test]
fn percent_em_and_other_units_are_followed() {
    let text = page(
        r#"<g font-size="4" stroke="black"><line x1="10%" y1="20%" x2="50%" y2="20%"/><line x1="1em" y1="0" x2="2em" y2="0"/><line x1="0" y1="30" x2="96" y2="30"/></g>"#,
    );
    let (artwork, _) = reading(text);
    assert_points(&artwork.strokes[0], &[[10.0, 80.0], [50.0, 80.0]]);
    assert_points(&artwork.strokes[1], &[[4.0, 100.0], [8.0, 100.0]]);
    assert_points(&artwork.strokes[2], &[[0.0, 70.0], [96.0, 70.0]]);
}

#[test]
fn transforms_symbols_and_nested_drawings_are_followed() {
    let table = [
        (
            r#"<g transform="translate(10,20)"><g transform="scale(2)"><path d="M1 2h3"/></g></g>"#,
            [12.0, 24.0],
        ),
        (
            r#"<g transform="rotate(90)"><g transform="translate(5,-7)"><path d="M1 2h3"/></g></g>"#,
            [5.0, 6.0],
        ),
        (
            r#"<path transform="matrix(0 1 1 0 3 4)" d="M1 2h3"/>"#,
            [5.0, 5.0],
        ),
        (
            r#"<path transform="rotate(180 10 10)" d="M1 2h3"/>"#,
            [19.0, 18.0],
        ),
        (r#"<path transform="skewX(45)" d="M1 2h3"/>"#, [3.0, 2.0]),
        (
            r#"<svg x="10" y="10" width="40" height="40" viewBox="0 0 10 10"><path d="M1 2h3"/></svg>"#,
            [14.0, 18.0],
        ),
        (
            r##"<symbol id="s" viewBox="0 0 10 10"><path d="M1 2h3"/></symbol><use xlink:href="#s" x="10" y="10" width="40" height="40"/>"##,
            [14.0, 18.0],
        ),
        (
            r##"<defs><g id="a"><path d="M1 2h3"/></g><g id="b"><use href="#a" x="1"/></g></defs><use href="#b" y="1" transform="scale(3)"/>"##,
            [6.0, 9.0],
        ),
        (
            r#"<switch><path systemLanguage="de" d="M7 7h1"/><path d="M1 2h3"/></switch>"#,
            [1.0, 2.0],
        ),
    ];
    for (inside, [x, y]) in table {
        let (artwork, _) = reading(page(&format!(r#"<g stroke="black">{inside}</g>"#)));
        assert_eq!(artwork.strokes.len(), 1, "{inside}");
        let [px, py] = artwork.strokes[0].points[0];
        assert!(
            (px - x).abs() < 1e-3 && (100.0 - py - y).abs() < 1e-3,
            "{inside}: {px} {py}"
        );
    }
}

#[test]
fn invisible_elements_are_not_drawn() {
    let line = r#"<path d="M0 0h9" "#;
    let unseen = [
        r#"fill="none"/>"#,
        r#"stroke="black" display="none"/>"#,
        r#"stroke="black" visibility="hidden"/>"#,
        r#"stroke="black" opacity="0"/>"#,
        r#"stroke="black" fill="none" stroke-opacity="0"/>"#,
        r#"style="stroke:black;display:none"/>"#,
    ];
    for end in unseen {
        let (artwork, _) = reading(page(&format!("{line}{end}")));
        assert_eq!(artwork.strokes, [], "{end}");
    }
    let groups = [
        r#"opacity="0""#,
        r#"style="display:none""#,
        r#"visibility="hidden""#,
    ];
    for group in groups {
        let (artwork, _) = reading(page(&format!(r#"<g {group}>{line} stroke="black"/></g>"#)));
        assert_eq!(artwork.strokes, [], "{group}");
    }
}

#[test]
fn filled_shapes_are_outlined_or_left_out() {
    let text =
        page(r#"<path d="M10 10h10v10"/><rect x="50" y="50" width="9" height="9" fill="white"/>"#);
    let (artwork, notes) = reading(&text);
    assert_points(
        &artwork.strokes[0],
        &[[10.0, 90.0], [20.0, 90.0], [20.0, 80.0], [10.0, 90.0]],
    );
    assert_eq!(artwork.strokes.len(), 1);
    let told: Vec<&str> = notes.iter().map(|note| note.message.as_str()).collect();
    assert_eq!(
        told,
        [
            "filled shapes without a line are drawn as outlines",
            "white on white is left out: it is invisible"
        ]
    );
    let mut options = ReadOptions::default();
    options.fills = Fills::Ignore;
    let (artwork, notes) = reading_with(&text, &options).unwrap();
    assert_eq!(artwork.strokes, []);
    assert_eq!(
        notes[0].message,
        "filled shapes without a line are left out (2 times)"
    );
    // A shape with both is drawn once, and the fill does not close its line.
    let (artwork, notes) = reading(page(r#"<path d="M10 10h10v10" stroke="red" fill="blue"/>"#));
    assert_eq!(artwork.strokes[0].points.len(), 3);
    assert_eq!(notes, []);
}

#[test]
fn elements_without_stroke_and_area_are_not_drawn() {
    for unseen in [
        r#"<line x1="10" y1="10" x2="90" y2="10"/>"#,
        r#"<line x1="10" y1="10" x2="90" y2="50" fill="red" transform="rotate(17)"/>"#,
        r#"<polyline points="10,10 50,10 90,10"/>"#,
        r#"<polyline points="10,10 50,10 50,40 50,10" stroke="none"/>"#,
        r#"<path d="M10 10L30 30L20 20Z"/>"#,
        r#"<path d="M10 10L30 30" stroke="black" stroke-opacity="0"/>"#,
        r#"<path d="M10 10Z"/>"#,
        r#"<path d="M10 10C20 10 30 10 40 10"/>"#,
    ] {
        let (artwork, notes) = reading(page(unseen));
        assert_eq!(artwork.strokes, [], "{unseen}");
        if !unseen.contains("M10 10Z") {
            let told: Vec<&str> = notes.iter().map(|note| note.message.as_str()).collect();
            assert_eq!(
                told,
                ["lines without a stroke that enclose no area are left out: they are invisible"],
                "{unseen}"
            );
        }
        // With a stroke the shape is drawn once.
        let seen = unseen
            .replace("stroke-opacity", "data-none")
            .replace("stroke=\"none\"", "");
        let seen = if seen.contains("stroke=") {
            seen
        } else {
            seen.replace("/>", " stroke=\"black\"/>")
        };
        let (artwork, _) = reading(page(&seen));
        let drawn = artwork
            .strokes
            .iter()
            .filter(|stroke| stroke.points.len() > 1);
        assert_eq!(
            drawn.count(),
            usize::from(!unseen.contains("M10 10Z")),
            "{seen}"
        );
    }
    // Of a filled shape only parts with an area are drawn, and their points do not change.
    let (artwork, notes) = reading(page(r#"<path d="M10 10H40M50 50h9v9z"/>"#));
    assert_eq!((artwork.strokes.len(), notes.len()), (1, 2));
    let (artwork, _) = reading(page(r#"<polyline points="10,10 50,10 50,40"/>"#));
    assert_eq!(artwork.strokes[0].points.len(), 4);
}

#[test]
fn dashes_are_separate_strokes() {
    let (artwork, _) = reading(page(
        r#"<g transform="scale(2)"><line x1="5" y1="5" x2="15" y2="5" stroke="black" stroke-dasharray="3 1" stroke-dashoffset="1"/></g>"#,
    ));
    let spans: Vec<[f64; 2]> = artwork
        .strokes
        .iter()
        .map(|stroke| [stroke.points[0][0], stroke.points.last().unwrap()[0]])
        .collect();
    let expected = [[10.0, 14.0], [16.0, 22.0], [24.0, 30.0]];
    assert_eq!(spans.len(), expected.len());
    for (span, expected) in spans.iter().zip(expected) {
        near(span[0], expected[0], 1e-4);
        near(span[1], expected[1], 1e-4);
    }
    let (artwork, notes) = reading(page(
        r#"<line x2="90" stroke="black" stroke-dasharray="1e-6"/>"#,
    ));
    assert_eq!(artwork.strokes.len(), 1);
    assert!(notes[0].message.contains("too fine"), "{notes:?}");
}

#[test]
fn line_beside_the_page_is_noted() {
    let line = |x: u32| format!(r##"<path id="far" d="M10 10H{x}" stroke="black"/>"##);
    assert!(reading(page(&line(100))).1.is_empty());
    let (artwork, notes) = reading(page(&line(150)));
    assert_eq!(artwork.strokes.len(), 1);
    let [note] = &notes[..] else {
        panic!("{notes:?}");
    };
    assert!(note.message.contains("leaves the page"), "{note}");
    assert!(note.origin.line > 0, "{note:?}");
}

#[test]
fn a_line_on_the_edge_of_a_nested_drawing_is_drawn() {
    let (artwork, _) = reading(page(
        r##"<svg x="20" y="30" width="40" height="40" viewBox="0 0 10 10"><rect width="10" height="10" fill="none" stroke="black"/></svg>"##,
    ));
    let [stroke] = &artwork.strokes[..] else {
        panic!("{artwork:?}");
    };
    near(stroke.length(), 160.0, 0.01);
}

#[test]
fn clip_paths_cut_lines_off() {
    let (artwork, _) = reading(page(
        r##"<clipPath id="c"><circle cx="50" cy="50" r="20"/></clipPath><g clip-path="url(#c)" stroke="black"><line x1="0" y1="50" x2="100" y2="50"/><line x1="0" y1="5" x2="100" y2="5"/><rect x="45" y="45" width="10" height="10"/></g>"##,
    ));
    assert_eq!(artwork.strokes.len(), 2);
    let [from, to] = [artwork.strokes[0].points[0], artwork.strokes[0].points[1]];
    near(from[0], 30.0, 0.06);
    near(to[0], 70.0, 0.06);
    assert!(artwork.strokes[1].is_closed());
    // A region with a hole, and a region clipped by another.
    let (artwork, _) = reading(page(
        r##"<clipPath id="o" clip-path="url(#h)"><path clip-rule="evenodd" d="M10 10H90V90H10ZM40 40H60V60H40Z"/></clipPath><clipPath id="h"><rect width="55" height="100"/></clipPath><line y1="50" x2="100" y2="50" stroke="black" clip-path="url(#o)"/>"##,
    ));
    assert_eq!(artwork.strokes.len(), 1);
    assert_points(&artwork.strokes[0], &[[10.0, 50.0], [40.0, 50.0]]);
    // A nested drawing is clipped at the edge of its viewport.
    let (artwork, _) = reading(page(
        r#"<svg x="10" y="10" width="20" height="20" stroke="black"><line x1="-5" y1="5" x2="50" y2="5"/></svg>"#,
    ));
    assert_points(&artwork.strokes[0], &[[10.0, 85.0], [30.0, 85.0]]);
}

#[test]
fn masks_clip_hidden_lines() {
    let masked = |mask: &str| {
        reading(page(&format!(
            r##"<mask id="m" maskUnits="userSpaceOnUse" x="0" y="0" width="80" height="100" {mask}</mask><line x1="0" y1="50" x2="100" y2="50" stroke="black" mask="url(#m)"/>"##
        )))
    };
    let spans = |mask: &str| -> Vec<[f64; 2]> {
        let (artwork, notes) = masked(mask);
        // If everything is hidden, a note reports it.
        assert_eq!(
            notes.is_empty(),
            !artwork.strokes.is_empty(),
            "{mask}: {notes:?}"
        );
        let ends = |stroke: &Stroke| [stroke.points[0][0], stroke.points.last().unwrap()[0]];
        let rounded = |stroke: &Stroke| ends(stroke).map(|x| (x * 1000.0).round() / 1000.0);
        artwork.strokes.iter().map(rounded).collect()
    };
    let white = r#"<rect width="100" height="100" fill="white"/>"#;
    let hole = r#"<rect x="40" y="40" width="20" height="20"/>"#;
    assert_eq!(spans(&format!(">{white}")), [[0.0, 80.0]]);
    assert_eq!(
        spans(&format!(">{white}{hole}")),
        [[0.0, 40.0], [60.0, 80.0]]
    );
    assert_eq!(spans(&format!(">{hole}")), [[0.0; 2]; 0]);
    // In an alpha mask black is opaque too; even faint colours show.
    assert_eq!(
        spans(&format!(r#"mask-type="alpha">{hole}"#)),
        [[40.0, 60.0]]
    );
    assert_eq!(
        spans(r#"><g opacity="0.5"><rect x="10" width="20" height="99" fill="gray"/></g>"#),
        [[10.0, 30.0]]
    );
    // Later elements of a mask cover black ones, transparent black does not hide, and strokes have
    // their width.
    let island = r#"<rect x="45" y="40" width="10" height="20" fill="red"/>"#;
    assert_eq!(
        spans(&format!(">{white}{hole}{island}")),
        [[0.0, 40.0], [45.0, 55.0], [60.0, 80.0]]
    );
    assert_eq!(
        spans(&format!(r#">{white}<g opacity="0.9">{hole}</g>"#)),
        [[0.0, 80.0]]
    );
    assert_eq!(
        spans(r#"><line x1="50" y1="0" x2="50" y2="100" stroke="white" stroke-width="10"/>"#),
        [[45.0, 55.0]]
    );
    // A gradient that is opaque throughout counts as white; a gradient from white to black hides
    // gradually.
    let gradient = |to: &str| {
        format!(
            r##"><linearGradient id="g"><stop stop-color="white"/><stop offset="1" stop-color="{to}"/></linearGradient><rect width="50" height="100" fill="url(#g)"/>"##
        )
    };
    assert_eq!(spans(&gradient("gray")), [[0.0, 50.0]]);
    let (artwork, notes) = masked(&gradient("black"));
    assert_eq!(artwork.strokes.len(), 1);
    assert!(notes[0].message.contains("is ignored"), "{notes:?}");
    assert_eq!(notes[0].name.as_deref(), Some("line"));
}

#[test]
fn white_is_drawn_where_visible() {
    let count = |inside: &str| {
        let (artwork, notes) = reading(page(inside));
        let told = notes.iter().filter(|note| note.message.contains("white"));
        (artwork.strokes.len(), told.count())
    };
    let dark = r#"<rect x="10" y="10" width="50" height="50" fill="blue"/>"#;
    let line = r#"<path d="M20 20h20" stroke="white"/>"#;
    let bent = r#"<path d="M20 20h20v9" fill="none" stroke="white"/>"#;
    let shape = r##"<rect x="20" y="20" width="9" height="9" fill="#fff"/>"##;
    let text = r#"<text x="15" y="30" font-size="9" fill="white">l</text>"#;
    let black = r#"<path d="M5 5h5" stroke="black"/>"#;
    for white in [line, bent, shape, text] {
        // White over white, and below dark shapes, is left out.
        assert_eq!(count(&format!("{black}{white}")), (1, 1), "{white}");
        assert_eq!(count(&format!("{white}{dark}")), (1, 1), "{white}");
        // White over a dark shape is drawn, unless white lies between.
        assert_eq!(count(&format!("{dark}{white}")), (2, 0), "{white}");
        let between = r#"<rect x="15" y="15" width="40" height="40" fill="white"/>"#;
        assert_eq!(count(&format!("{dark}{between}{white}")), (2, 1), "{white}");
        // A drawing with nothing but white is drawn, with a note.
        assert_eq!(count(white), (1, 1), "{white}");
        let mut options = ReadOptions::default();
        options.white = White::Draw;
        let both = page(&format!("{black}{white}"));
        let (artwork, _) = reading_with(both, &options).unwrap();
        assert_eq!(artwork.strokes.len(), 2, "{white}");
    }
    // A shape is drawn if only its fill or only its stroke is white.
    assert_eq!(
        count(r#"<rect width="9" height="9" fill="white" stroke="red"/>"#),
        (1, 0)
    );
    assert_eq!(
        count(r#"<rect width="9" height="9" fill="red" stroke="white"/>"#),
        (1, 0)
    );
    // Half of the white line lies over the dark shape.
    assert_eq!(
        count(&format!(
            r#"{dark}<path d="M50 20h5v5h20" fill="none" stroke="white"/>"#
        )),
        (2, 0)
    );
}

#[test]
fn lines_beyond_the_page_are_clipped_on_request() {
    let mut options = ReadOptions::default();
    options.clip_page = true;
    let text = page(
        r#"<path d="M90 10h20" stroke="black"/><rect width="100" height="100" fill="none" stroke="black"/><path d="M-9 -9h5" stroke="black"/>"#,
    );
    let (artwork, notes) = reading_with(&text, &options).unwrap();
    assert_eq!(artwork.strokes.len(), 2);
    near(artwork.strokes[0].points[1][0], 100.0, 2e-3);
    assert!(artwork.strokes[1].is_closed());
    let told: Vec<&str> = notes.iter().map(|note| note.message.as_str()).collect();
    assert_eq!(
        told,
        ["lines beyond the page (100.0 by 100.0 mm) are cut off: 2 lines"]
    );
    let (_, notes) = reading(&text);
    assert_eq!(notes[0].remedies[0].act.to_string(), "clip_page");
    let pageless =
        r#"<svg xmlns="http://www.w3.org/2000/svg"><path d="M1 1h5" stroke="black"/></svg>"#;
    let (_, notes) = reading_with(pageless, &options).unwrap();
    assert!(notes[0].message.contains("nothing is cut off"), "{notes:?}");
}

#[test]
fn compressed_drawings_are_unpacked_up_to_a_limit() {
    let packed = |bytes: &[u8]| {
        let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        std::io::Write::write_all(&mut packer, bytes).unwrap();
        packer.finish().unwrap()
    };
    let text = page(r#"<path d="M1 1h5" stroke="black"/>"#);
    let (artwork, _) = reading(packed(text.as_bytes()));
    assert_eq!(artwork.strokes, reading(&text).0.strokes);
    assert_eq!(Format::of("a", &packed(text.as_bytes())), Some(Format::Svg));
    let bomb = packed(&vec![b' '; (64 << 20) + 1]);
    assert!(
        diagnostic(bomb)
            .message
            .contains("uncompressed it has more than")
    );
    let damaged = &packed(text.as_bytes())[..40];
    assert!(diagnostic(damaged).message.contains("damaged"));
}

#[test]
fn styles_and_markers_are_followed() {
    let (artwork, _) = reading(page(
        r#"<style><![CDATA[ .cut { fill: none; stroke: red } #gone { display: none } ]]></style><path class="cut" d="M1 1h5"/><path id="gone" class="cut" d="M1 3h5"/>"#,
    ));
    assert_eq!(artwork.strokes.len(), 1);
    let (artwork, _) = reading(page(
        r##"<marker id="m" markerWidth="4" markerHeight="4" markerUnits="userSpaceOnUse" refX="2" refY="2"><path d="M0 0L4 2L0 4" fill="none" stroke="black"/></marker><path d="M10 50H60" stroke="black" marker-end="url(#m)"/>"##,
    ));
    assert_eq!(artwork.strokes.len(), 2);
    let [_, most] = Artwork {
        strokes: vec![artwork.strokes[1].clone()],
        ..artwork
    }
    .bounds()
    .unwrap();
    near(most[0], 62.0, 1e-3);
}

#[test]
fn texts_are_outlines_in_one_font() {
    let text = page(
        r#"<text id="hello" x="10" y="50" font-size="20" font-family="Arial" font-weight="bold">lo</text>"#,
    );
    let (artwork, notes) = reading(&text);
    // The l is one outline, the o two.
    assert_eq!(artwork.strokes.len(), 3);
    assert!(artwork.strokes.iter().all(Stroke::is_closed));
    assert_eq!(artwork.names, ["hello"]);
    let [least, most] = artwork.bounds().unwrap();
    // In Roboto the l is 1536 of 2048 units tall from the baseline, and the o extends 20 units
    // below it.
    near(most[1], 50.0 + 20.0 * 1536.0 / 2048.0, 0.01);
    near(least[1], 50.0 - 20.0 * 20.0 / 2048.0, 0.01);
    let told: Vec<&str> = notes.iter().map(|note| note.message.as_str()).collect();
    assert_eq!(
        told,
        [
            "text is written in Roboto Regular instead of Arial",
            "text is written in Roboto Regular instead of bold"
        ]
    );
}

#[test]
fn characters_that_the_font_lacks_are_left_out_and_named() {
    let (artwork, notes) = reading(page("\n  <text id='label' y='20'>Hi 日本 日</text>"));
    // The H is one outline, the i two; missing characters leave no outline.
    assert_eq!(artwork.strokes.len(), 3);
    let told: Vec<String> = notes.iter().map(ToString::to_string).collect();
    assert_eq!(
        told,
        [
            "line 2, column 3 (label): U+65E5 '日' is left out: the font Roboto does not have it",
            "line 2, column 3 (label): U+672C '本' is left out: the font Roboto does not have it",
        ]
    );
    // Hidden text is not reported.
    let hidden = "<text y='20' visibility='hidden'>日</text><text y='20' display='none'>日</text>";
    let (_, notes) = reading(page(&format!("<line x2='5' stroke='red'/>{hidden}")));
    assert_eq!(notes, []);
    // A text without any known character is reported as well.
    let (artwork, notes) = reading(page("<text y='20'>日本</text>"));
    assert_eq!((artwork.strokes.len(), notes.len()), (0, 2));
}

#[test]
fn omissions_are_noted() {
    let (artwork, notes) = reading(page(
        r##"<image href="/etc/passwd" width="9" height="9"/><image href="data:image/png;base64,AAAA" width="9" height="9"/><foreignObject/><filter id="f"/><line x2="5" stroke="red" style="filter:url(#f)"/>"##,
    ));
    assert_eq!(artwork.strokes.len(), 1);
    let told: Vec<&str> = notes.iter().map(|note| note.message.as_str()).collect();
    assert_eq!(
        told,
        [
            "images in the drawing are left out (2 times)",
            "elements that are not SVG are left out",
            "filters are left out",
        ]
    );
    assert_eq!(notes[0].name.as_deref(), Some("image"));
}

#[test]
fn non_drawing_is_refused_with_its_origin() {
    let broken = diagnostic("<svg xmlns='http://www.w3.org/2000/svg'>\n  <g><rect></g></svg>");
    assert_eq!(broken.origin.line, 2, "{broken}");
    assert!(
        broken.message.starts_with("the XML cannot be read"),
        "{broken}"
    );
    assert!(diagnostic("<html/>").message.contains("<html>, not <svg>"));
    assert!(diagnostic([0xff, 0xfe, 0x3c]).message.contains("UTF-16"));
    assert!(
        diagnostic([0x1f, 0x8b, 0x08])
            .message
            .contains("compressed")
    );
    assert!(
        diagnostic(" ")
            .message
            .starts_with("the XML cannot be read")
    );
    assert!(
        diagnostic("<svg xmlns='http://www.w3.org/2000/svg' width='0' height='9'/>")
            .message
            .contains("has no size")
    );
    let far = diagnostic(page("<path id='far' d='M0 0L1e8 1e8' stroke='red'/>"));
    assert_eq!(far.name.as_deref(), Some("far"));
    assert!(far.message.contains("limit 100000 mm"), "{far}");
    let beyond = diagnostic(page(
        "\n<path id='arc' d='M0 0A4e38 4e38 0 0 1 9 9' stroke='red'/>",
    ));
    assert_eq!(
        beyond.to_string(),
        "line 2, column 1 (arc): a number is out of range: 4e38"
    );
}

#[test]
fn expansion_bombs_are_refused() {
    // Each level uses the one below ten times.
    let mut bomb = String::from("<defs><path id='l0' d='M0 0h1' stroke='red'/>");
    for level in 1..12 {
        let used = format!("<use href='#l{}'/>", level - 1).repeat(10);
        bomb += &format!("<g id='l{level}'>{used}</g>");
    }
    let diagnostic_of = |text: String| diagnostic(text).message;
    assert!(
        diagnostic_of(page(&(bomb + "</defs><use href='#l11'/>")))
            .contains("all references expanded")
    );
    let deep = "<g>".repeat(5000) + &"</g>".repeat(5000);
    assert!(diagnostic_of(page(&deep)).contains("nested more than"));
    let chain: String = (0..1000)
        .map(|nth| format!("<g id='c{nth}'><use href='#c{}'/></g>", nth + 1))
        .collect();
    assert!(diagnostic_of(page(&chain)).contains("nested more than"));
    // Cycles of references are broken or refused.
    for circle in [
        "<g id='a'><use href='#a'/></g>",
        "<g id='a'><use href='#b'/></g><g id='b'><use href='#a'/></g>",
        "<use id='a' href='#b'/><use id='b' href='#c'/><use id='c' href='#a'/>",
        "<clipPath id='a' clip-path='url(#b)'><rect width='9' height='9'/></clipPath><clipPath id='b' clip-path='url(#a)'><rect width='9' height='9'/></clipPath><rect clip-path='url(#a)' width='9' height='9'/>",
        "<pattern id='p' width='9' height='9'><rect width='9' height='9' fill='url(#p)'/></pattern><rect width='9' height='9' fill='url(#p)'/>",
        "<mask id='a' mask='url(#a)'><rect width='9' height='9' mask='url(#a)'/></mask><rect mask='url(#a)' width='9' height='9'/>",
        "<clipPath id='a' clip-path='url(#b)'><rect width='9' height='9'/></clipPath><clipPath id='b' clip-path='url(#c)'><rect width='9' height='9'/></clipPath><clipPath id='c' clip-path='url(#a)'><rect width='9' height='9'/></clipPath><rect clip-path='url(#a)' width='9' height='9'/>",
        "<mask id='a' mask='url(#b)'><rect width='9' height='9'/></mask><mask id='b' mask='url(#c)'><rect width='9' height='9'/></mask><mask id='c'><use href='#u'/></mask><rect id='u' mask='url(#a)' width='9' height='9'/>",
        "<style>.x{mask:url(#a)} .y{mask:url(#b)} #z{mask:url(#c)}</style><mask id='a'><rect class='y' width='9' height='9'/></mask><mask id='b'><rect id='z' width='9' height='9'/></mask><mask id='c'><rect class='x' width='9' height='9'/></mask><rect mask='url(#a)' width='9' height='9'/>",
        "<mask id='a'><rect clip-path='url(#c)' width='9' height='9'/></mask><clipPath id='c'><rect mask='url(#a)' width='9' height='9'/></clipPath><rect mask='url(#a)' width='9' height='9'/>",
        "<marker id='m'><path d='M0 0h1v1' marker-mid='url(#m)' stroke='red'/></marker><path d='M0 0h1v1' marker-mid='url(#m)'/>",
    ] {
        let _ = reading_with(page(circle), &ReadOptions::default());
    }
    // Classes with the same style do not form a cycle, however many there are.
    let clips: String = (0..5)
        .map(|n| format!("<style>.c{n}{{clip-path:url(#p{n})}}</style><clipPath id='p{n}'><rect class='d' width='90' height='90'/></clipPath><path class='c{n}' d='M1 1h{n}v1z'/>"))
        .collect();
    assert_eq!(reading(page(&clips)).0.strokes.len(), 4);
    let corners = "l1 1".repeat(100_000);
    let marked = format!(
        "<marker id='m'>{}</marker><path d='M0 0{corners}' stroke='red' marker-mid='url(#m)'/>",
        "<path d='M0 0h1'/>".repeat(100)
    );
    assert!(diagnostic_of(page(&marked)).contains("all references expanded"));
    let entities = "<!DOCTYPE svg [<!ENTITY a 'aaaaaaaaaa'>".to_owned()
        + &(0..9)
            .map(|n| {
                let (new, old) = ((b'b' + n) as char, (b'a' + n) as char);
                format!("<!ENTITY {new} '{}'>", format!("&{old};").repeat(10))
            })
            .collect::<String>()
        + "]><svg xmlns='http://www.w3.org/2000/svg'><text>&j;</text></svg>";
    assert!(diagnostic_of(entities).contains("XML cannot be read"));
}

#[test]
fn entities_keep_origins_correct() {
    let text = "<!DOCTYPE svg [<!ENTITY line \"<line x2='9' stroke='red'/>\"><!ENTITY ns 'http://www.w3.org/2000/svg'>]>\n<svg xmlns='&ns;' width='10mm' height='10mm' viewBox='0 0 10 10'>&line;\n<path d='M1 1h3' stroke='red'/></svg>";
    let (artwork, _) = reading(text);
    assert_eq!(artwork.strokes.len(), 2);
    assert_eq!(
        (
            artwork.strokes[1].origin.line,
            artwork.strokes[1].origin.column
        ),
        (3, 1)
    );
}

/// usvg places letters along a path in an enlarged drawing, which is scaled back afterwards.
#[test]
fn text_along_a_path_keeps_the_size_of_the_drawing() {
    let sizes = [
        r#"width="200mm" height="100mm" viewBox="0 0 400 200""#,
        r#"width="400" height="200""#,
        r#"width="400" viewBox="0 0 400 200""#,
        r#"width="100%" height="100%" viewBox="0 0 400 200""#,
        r#"width="50%" viewBox="0 0 400 200""#,
        r#"viewBox="0 0 400 200""#,
        r#"viewBox="-100 -50 400 200""#,
        "",
    ];
    for size in sizes {
        let drawing = |text: &str| {
            let file = format!(
                r##"<svg xmlns="http://www.w3.org/2000/svg" {size}>
                <path id="p" d="M20 150C20 20 180 20 180 150" fill="none" stroke="black"/>
                <path d="M5 5H195V195H5Z" fill="none" stroke="black"/>{text}</svg>"##
            );
            let (artwork, _) = reading(file);
            let frame = artwork
                .strokes
                .iter()
                .find(|stroke| stroke.points.len() == 5);
            (artwork.page, frame.expect("the frame").points.clone())
        };
        let plain = drawing("");
        let along =
            drawing(r##"<text font-size="20"><textPath href="#p">magician</textPath></text>"##);
        assert_eq!(plain.0, along.0, "{size}");
        for (one, other) in plain.1.iter().zip(&along.1) {
            near(one[0], other[0], 1e-3);
            near(one[1], other[1], 1e-3);
        }
    }
}
