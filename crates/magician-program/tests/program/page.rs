//! Drawings on a page of paper.

use magician_host::preflight::{Guards, Preflight};
use magician_host::{Act, JointAngles, Setting, SettingValue};
use magician_motion::ToolBias;
use magician_program::artwork::Sheet;
use magician_program::toolpath::DrawnLine;
use magician_program::{
    Diagnostic, Format, Preparation, PrepareRequest, PreparedProgram, SetupOptions, StartPosition,
    Surface, check,
};
use serde_json::{Value, json};

/// 60 mm wide, 20 mm high, on its own page, which does not count.
const SVG: &[u8] =
    b"<svg xmlns='http://www.w3.org/2000/svg' width='300mm' height='300mm' viewBox='0 0 300 300'>\
    <path d='M10 10 h60 v20 h-60 z' fill='none' stroke='black'/></svg>";
const GCODE: &[u8] = b"G21 G90\nG0 Z5\nG0 X0 Y0\nG1 Z0 F600\nG1 X60\nG1 Y20\nG1 X0\nG1 Y0\nG0 Z5\n";
const POINTS: &[u8] = b"x,y,z\n200,0,-50\n260,0,-50\n260,20,-50\n200,20,-50\n200,0,-50\n";

/// Grey image of 60 by 20 pixels as BMP.
fn bmp() -> Vec<u8> {
    let (width, height) = (60_u32, 20_u32);
    let mut bytes = b"BM".to_vec();
    let size = 54 + width * height * 3;
    for number in [size, 0, 54, 40, width, height] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend([1, 0, 24, 0]);
    bytes.extend([0; 24]);
    bytes.extend(vec![90; (width * height * 3) as usize]);
    bytes
}

fn prepare(
    format: Format,
    bytes: &[u8],
    options: &Value,
    sheet: Option<Sheet>,
) -> Result<PreparedProgram, Diagnostic> {
    let mut file = PrepareRequest::new(format, bytes);
    file.options = SetupOptions::from_fields(options.as_object().unwrap()).unwrap();
    file.defaults.surface = Some(Surface::level(-50.0));
    file.defaults.sheet = sheet;
    file.start = StartPosition::Staged;
    match file.prepare()? {
        Preparation::Done(laid) => Ok(*laid),
        Preparation::NeedsStart => panic!("it needs a start"),
    }
}

fn svg(options: &Value) -> PreparedProgram {
    prepare(Format::Svg, SVG, options, None).unwrap()
}

fn start() -> Preflight {
    Preflight::at(JointAngles::HOME, ToolBias::SUCTION).guards(Guards::NONE.reach(true))
}

fn corners(laid: &PreparedProgram) -> [[f64; 2]; 4] {
    laid.placed.and_then(|placed| placed.page).expect("a page")
}

/// Bounds of the drawing from the middle of its page, along its edges.
fn on_page(laid: &PreparedProgram) -> [[f64; 2]; 2] {
    let [from, right, end, _] = corners(laid);
    let along = [right[0] - from[0], right[1] - from[1]];
    let width = along[0].hypot(along[1]);
    let along = along.map(|part| part / width);
    let middle = [0, 1].map(|axis: usize| f64::midpoint(from[axis], end[axis]));
    let lines = DrawnLine::of(laid.program.plan(), &start());
    let mut points: Vec<_> = lines.iter().flat_map(|line| [line.from, line.to]).collect();
    if points.is_empty() {
        let targets = { laid.program.plan().steps.iter() }.filter_map(|step| step.action.target());
        points = targets.map(|[x, y, _]| [x.into(), y.into()]).collect();
    }
    assert!(!points.is_empty());
    let mut bounds = [[f64::MAX; 2], [f64::MIN; 2]];
    for [x, y] in points {
        let [x, y] = [x - middle[0], y - middle[1]];
        let own = [x * along[0] + y * along[1], y * along[0] - x * along[1]];
        for axis in [0, 1] {
            bounds[0][axis] = bounds[0][axis].min(own[axis]);
            bounds[1][axis] = bounds[1][axis].max(own[axis]);
        }
    }
    bounds
}

fn assert_near(found: &[[f64; 2]], expected: &[[f64; 2]]) {
    let near = |(a, b): (&f64, &f64)| (a - b).abs() < 0.06;
    let all = { found.as_flattened().iter() }.zip(expected.as_flattened());
    assert!(
        found.len() == expected.len() && all.into_iter().all(near),
        "{found:?}, not {expected:?}"
    );
}

fn note_texts(laid: &PreparedProgram) -> Vec<String> {
    laid.notes
        .iter()
        .map(|note| note.message.to_string())
        .collect()
}

#[test]
fn a_drawing_lies_with_its_middle_on_the_middle_of_the_page() {
    let laid = svg(&json!({"page": "a6", "at": [240, 10]}));
    assert_near(
        &corners(&laid),
        &[[187.5, -64.0], [292.5, -64.0], [292.5, 84.0], [187.5, 84.0]],
    );
    assert_near(&on_page(&laid), &[[-30.0, -10.0], [30.0, 10.0]]);
    assert_eq!(laid.placed.unwrap().at, [240.0, 10.0]);
    let said = note_texts(&laid);
    assert_eq!(
        said,
        ["the page is 105 x 148 mm: its lower left corner at x = 187.5, y = -64.0"]
    );
    // A landscape page with the given size.
    let lies = svg(&json!({"page": "a6-landscape", "at": [240, 10]}));
    assert_near(&corners(&lies)[..2], &[[166.0, -42.5], [314.0, -42.5]]);
    let own = svg(&json!({"page": "80x40.5", "at": [240, 10], "margin": 0}));
    assert_near(&corners(&own)[..2], &[[200.0, -10.3], [280.0, -10.3]]);
}

#[test]
fn page_without_a_position_maximises_the_reachable_part() {
    let laid = svg(&json!({"page": "a6"}));
    let [from, .., end] = corners(&laid);
    assert_near(&[[f64::midpoint(from[1], end[1]), 0.0]], &[[0.0, 0.0]]);
    // A drawing as large as its page is as large as possible: free placement finds no more room for
    // these proportions.
    let a3 = b"<svg xmlns='http://www.w3.org/2000/svg' width='297mm' height='420mm' viewBox='0 0 297 420'>\
        <path d='M0 0 h297 v420 h-297 z' fill='none' stroke='black'/></svg>";
    let scale = |options: Value| {
        let laid = prepare(Format::Svg, a3, &options, None).unwrap();
        laid.placed.unwrap().scale
    };
    let on_page = scale(json!({"page": "a3", "margin": 0, "fit": true, "turn": false}));
    let alone = scale(json!({"fit": true, "turn": false}));
    assert!((on_page / alone - 1.0).abs() < 0.03, "{on_page} {alone}");
}

#[test]
fn a_page_lies_on_the_calibrated_sheet() {
    let mut sheet = Sheet {
        corner: [180.0, -60.0],
        rotation: 0.0,
        surface: Surface::level(-45.0),
        size: Some([120.0, 100.0]),
    };
    let laid = |sheet, options: &Value| prepare(Format::Svg, SVG, options, Some(sheet)).unwrap();
    let page = json!({"page": "100x60"});
    assert_near(&corners(&laid(sheet, &page))[..1], &[[190.0, -40.0]]);
    assert_near(
        &on_page(&laid(sheet, &page)),
        &[[-30.0, -10.0], [30.0, 10.0]],
    );
    // With a given position it is there, turned like the sheet.
    sheet.rotation = 90.0;
    let there = laid(sheet, &json!({"page": "100x60", "at": [240, 0]}));
    assert_near(
        &corners(&there),
        &[[270.0, -50.0], [270.0, 50.0], [210.0, 50.0], [210.0, -50.0]],
    );
    assert_near(&on_page(&there), &[[-30.0, -10.0], [30.0, 10.0]]);
    assert!(
        note_texts(&there)[0].ends_with("turned by 90 degrees"),
        "{:?}",
        note_texts(&there)
    );
    // On a sheet with only a known corner, the corners coincide.
    (sheet.rotation, sheet.size) = (0.0, None);
    assert_near(&corners(&laid(sheet, &page))[..1], &[[180.0, -60.0]]);
}

#[test]
fn fitted_content_keeps_the_page_margin_in_every_format() {
    let bmp = bmp();
    let sheet = Sheet {
        corner: [200.0, -40.0],
        rotation: 20.0,
        surface: Surface::level(-50.0),
        size: Some([60.0, 60.0]),
    };
    for (format, bytes, more) in [
        (Format::Svg, SVG, json!({})),
        (Format::Svg, SVG, json!({"rotate": 90})),
        (Format::Gcode, GCODE, json!({})),
        (Format::Points, POINTS, json!({"tool": "pen"})),
        (Format::Image, &bmp, json!({"width": 60, "tool": "laser"})),
        (
            Format::Image,
            &bmp,
            json!({"width": 60, "tool": "pen", "image": "hatch"}),
        ),
        (
            Format::Image,
            &bmp,
            json!({"width": 60, "tool": "pen", "image": "outline"}),
        ),
        (Format::Text, b"WORDS IN A ROW", json!({})),
    ] {
        for sheet in [None, Some(sheet)] {
            let mut options = json!({"page": "50x40", "margin": 5, "fit": true, "turn": false});
            options
                .as_object_mut()
                .unwrap()
                .extend(more.as_object().unwrap().clone());
            let laid = prepare(format, bytes, &options, sheet).unwrap();
            let what = format!("{format} {options} {}", sheet.is_some());
            assert_eq!(laid.misfit, None, "{what}");
            let [least, most] = on_page(&laid);
            let turned_points = format == Format::Points && sheet.is_some();
            for (axis, half) in [(0, 20.0), (1, 15.0)] {
                assert!(
                    most[axis].max(-least[axis]) < half + 0.1,
                    "{what}: {least:?} {most:?}"
                );
            }
            // And it is as large as possible.
            let fills = (most[0] - least[0]) / 40.0;
            let fills = fills.max((most[1] - least[1]) / 30.0);
            assert!(fills > 0.97 || turned_points, "{what}: {fills}");
            assert!(check(laid.program.plan(), &start()).is_good(), "{what}");
            assert_eq!(
                laid.notes
                    .iter()
                    .filter(|note| note.message.contains("page"))
                    .count(),
                1,
                "{what}"
            );
        }
    }
}

#[test]
fn content_with_room_keeps_its_size_and_turns_for_more_room() {
    let page =
        |margin: f64| json!({"page": "80x100", "at": [240, 0], "margin": margin, "fit": true});
    let placed = |options: &Value| svg(options).placed.unwrap();
    let fits = placed(&page(10.0));
    assert_eq!((fits.scale, fits.turn), (1.0, 0.0));
    let turned = placed(&page(20.0));
    assert_eq!((turned.scale, turned.turn), (1.0, 90.0));
    let mut larger = page(10.0);
    larger["scale"] = json!(2);
    let larger = placed(&larger);
    assert_eq!((larger.scale, larger.turn), (1.3333, 90.0));
}

#[test]
fn overhang_is_noted_with_its_length_and_drawn() {
    let told = |options: Value| {
        let laid = svg(&options);
        assert_eq!(laid.misfit, None);
        let note = laid
            .notes
            .iter()
            .skip(1)
            .find(|note| note.message.contains("page"));
        note.map(|note| (note.message.clone(), note.remedies.clone()))
    };
    let at = json!([240, 0]);
    let (message, remedies) = told(json!({"page": "50x40", "at": at})).unwrap();
    assert_eq!(message, "it reaches 5 mm beyond the edge of the page");
    assert_eq!(remedies[0].act, Act::Give(Setting::Fit, SettingValue::On));
    let (message, _) = told(json!({"page": "70x100", "at": at})).unwrap();
    assert_eq!(
        message,
        "it comes within 5 mm of the edge of the page; the margin is 10 mm"
    );
    assert_eq!(told(json!({"page": "70x100", "at": at, "margin": 5})), None);
    let (message, _) = told(json!({"page": "80x40", "at": at, "move": [0, -21.25, 0]})).unwrap();
    assert_eq!(message, "it reaches 11.3 mm beyond the edge of the page");
    // The whole grid is checked against the page; a fitted drawing causes no warning.
    let (message, remedies) =
        told(json!({"page": "80x40", "at": at, "fit": true, "grid": "2x1:0x-30"})).unwrap();
    assert_eq!(message, "it reaches 20 mm beyond the edge of the page");
    assert_eq!(remedies, []);
}

#[test]
fn page_places_a_coordinate_file_and_contradicts_raw() {
    let placed = prepare(
        Format::Gcode,
        GCODE,
        &json!({"page": "a6", "at": [240, 0]}),
        None,
    )
    .unwrap();
    assert_near(&on_page(&placed), &[[-30.0, -10.0], [30.0, 10.0]]);
    let wrong = json!({"page": "a6", "raw": true});
    let error = SetupOptions::from_fields(wrong.as_object().unwrap()).unwrap_err();
    assert_eq!(error.message, "raw and page contradict each other");
}

#[test]
fn oversize_error_gives_the_size_that_fits_reach_and_page() {
    let laid = svg(&json!({"page": "50x40", "at": [240, 0], "scale": 6}));
    let misfit = laid.misfit.expect("it is out of reach").message;
    assert_eq!(
        misfit,
        "the drawing is 360 by 120 mm, at most 30 by 10 mm of that shape fits the page inside its margin and is reachable there"
    );
    assert_eq!(
        laid.would_fit.map(|fit| (fit.scale, fit.rotate)),
        Some((0.499, 0.0))
    );
}
