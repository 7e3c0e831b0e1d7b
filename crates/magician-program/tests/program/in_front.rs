//! Placement without a given position: in front of the arm, turned if that helps, else beside it
//! with a note.

use std::fmt::Write;

use magician_host::preflight::{Guards, Preflight};
use magician_host::{Act, Action, JointAngles, Setting};
use magician_motion::ToolBias;
use magician_program::{
    Diagnostic, DiagnosticCode, Format, Preparation, PrepareRequest, PreparedProgram, SetupOptions,
    Side, StartPosition, Surface, check, foreign_coordinates,
};
use serde_json::{Value, json};

fn prepare(format: Format, bytes: &[u8], options: &Value) -> Result<PreparedProgram, Diagnostic> {
    let mut file = PrepareRequest::new(format, bytes);
    file.options = SetupOptions::from_fields(options.as_object().unwrap()).unwrap();
    file.defaults.surface = Some(Surface::level(-50.0));
    file.start = StartPosition::Staged;
    match file.prepare()? {
        Preparation::Done(laid) => Ok(*laid),
        Preparation::NeedsStart => panic!("it needs a start"),
    }
}

fn svg([width, height]: [f64; 2]) -> Vec<u8> {
    let size = format!("width='{width}mm' height='{height}mm' viewBox='0 0 {width} {height}'");
    let shape = format!("<rect width='{width}' height='{height}' fill='none' stroke='black'/>");
    format!("<svg xmlns='http://www.w3.org/2000/svg' {size}>{shape}</svg>").into_bytes()
}

fn gcode([width, height]: [f64; 2]) -> Vec<u8> {
    let path = format!("G1 X{width}\nG1 Y{height}\nG1 X0\nG1 Y0\n");
    format!("G21 G90\nG0 Z5\nG0 X0 Y0\nG1 Z0 F600\n{path}G0 Z5\n").into_bytes()
}

fn points([width, height]: [f64; 2]) -> Vec<u8> {
    let mut text = "x,y,z\n".to_owned();
    for [x, y] in [
        [0.0, 0.0],
        [width, 0.0],
        [width, height],
        [0.0, height],
        [0.0, 0.0],
    ] {
        writeln!(text, "{},{},-50", 200.0 + x, y).unwrap();
    }
    text.into_bytes()
}

fn image([width, height]: [f64; 2]) -> Vec<u8> {
    let (width, height) = (width as u32, height as u32);
    let row = (3 * width).next_multiple_of(4);
    let mut bytes = b"BM".to_vec();
    for number in [54 + row * height, 0, 54, 40, width, height] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend([1, 0, 24, 0]);
    bytes.extend([0; 24]);
    bytes.extend(vec![90; (row * height) as usize]);
    bytes
}

/// Drawing of 240 by 20 mm in every format, with the options that place it.
fn wide_drawings() -> [(Format, Vec<u8>, Value); 5] {
    let size = [240.0, 20.0];
    [
        (Format::Svg, svg(size), json!({})),
        (Format::Svg, svg(size), json!({"work": "engrave"})),
        (Format::Gcode, gcode(size), json!({"place": true})),
        (Format::Points, points(size), json!({"place": true})),
        (
            Format::Image,
            image(size),
            json!({"work": "engrave", "width": 240, "spacing": 2, "overscan": 1}),
        ),
    ]
}

fn merged(options: &Value, more: Value) -> Value {
    let mut all = options.clone();
    for (key, value) in more.as_object().unwrap() {
        all[key] = value.clone();
    }
    all
}

fn bounds(laid: &PreparedProgram) -> [[f64; 3]; 2] {
    let start =
        Preflight::at(JointAngles::HOME, ToolBias::SUCTION).guards(Guards::NONE.reach(true));
    let report = check(laid.program.plan(), &start);
    assert!(report.is_good(), "{:?}", report.refused_steps.first());
    report
        .bounds
        .or(report.travel_bounds)
        .expect("something is drawn")
}

fn note_text(laid: &PreparedProgram) -> String {
    let notes: Vec<_> = laid
        .notes
        .iter()
        .map(|note| note.message.to_string())
        .collect();
    notes.join("; ")
}

#[test]
fn wide_drawing_of_every_format_is_turned_to_lie_in_front_of_the_arm() {
    for (format, bytes, options) in wide_drawings() {
        let laid = prepare(format, &bytes, &options).unwrap();
        let [least, most] = bounds(&laid);
        assert!(
            least[1] <= 0.1 && most[1] >= -0.1,
            "{format:?}: y {} {}",
            least[1],
            most[1]
        );
        let placed = laid.placed.unwrap();
        assert_eq!(
            (placed.turn, placed.beside, placed.scale),
            (90.0, None, 1.0),
            "{format:?}"
        );
        let said = note_text(&laid);
        assert!(
            said.contains("turned by 90 degrees to fit in front of the arm"),
            "{said}"
        );
    }
}

#[test]
fn drawing_that_may_not_be_turned_lies_beside_the_arm_with_a_note() {
    for (format, bytes, options) in wide_drawings() {
        // Points include rotations of the tool, which are limited to 180 degrees.
        let turned = json!({"rotate": 180});
        let turned = Some(turned).filter(|_| format != Format::Points);
        for more in turned.into_iter().chain([json!({"turn": false})]) {
            let laid = prepare(format, &bytes, &merged(&options, more)).unwrap();
            let [least, most] = bounds(&laid);
            let placed = laid.placed.unwrap();
            let side = placed
                .beside
                .unwrap_or_else(|| panic!("{format:?}: in front"));
            match side {
                Side::Left => assert!(least[1] > 0.0, "{format:?}"),
                _ => assert!(most[1] < 0.0, "{format:?}"),
            }
            let said = note_text(&laid);
            let told = format!("does not fit in front of the arm: lies at its {side}, x ");
            assert!(said.contains(&told), "{said}");
        }
    }
}

#[test]
fn given_place_is_kept_without_a_note() {
    let laid = prepare(Format::Svg, &svg([20.0, 20.0]), &json!({"at": [150, -180]})).unwrap();
    let placed = laid.placed.unwrap();
    assert_eq!(
        (placed.at, placed.turn, placed.beside),
        ([150.0, -180.0], 0.0, None)
    );
    assert!(
        !note_text(&laid).contains("in front"),
        "{}",
        note_text(&laid)
    );
}

/// `fit`, the size named by a refusal, and `would_fit` agree: that size passes, and no larger one
/// does anywhere.
#[test]
fn fitted_and_named_sizes_are_the_same_and_the_largest() {
    for size in [
        [500.0, 200.0],
        [600.0, 60.0],
        [300.0, 300.0],
        [100.0, 700.0],
    ] {
        for turn in [true, false] {
            let bytes = svg(size);
            let options = json!({"turn": turn});
            let of = |more: Value| prepare(Format::Svg, &bytes, &merged(&options, more)).unwrap();
            let fitted = of(json!({"fit": true})).placed.unwrap().scale;
            let refused = of(json!({}));
            let misfit = refused.misfit.expect("it is too large");
            let named = misfit.remedies.iter().find_map(|remedy| match &remedy.act {
                Act::Give(Setting::Scale, given) => given.to_string().parse::<f64>().ok(),
                _ => None,
            });
            let named = named.expect("a scale");
            let would_fit = refused.would_fit.expect("a size");
            assert!(
                (named - fitted).abs() < 0.01 * fitted,
                "{size:?} {turn}: {named} {fitted}"
            );
            if turn {
                assert_eq!(would_fit.scale, named, "{size:?}");
            }
            let passes = |scale: f64| of(json!({"scale": scale})).misfit.is_none();
            assert!(passes(named), "{size:?} {turn}: {named}");
            assert!(!passes(1.03 * fitted), "{size:?} {turn}: {fitted}");
        }
    }
}

#[test]
fn page_of_the_file_is_kept_on_paper_of_its_size() {
    let shape = "<rect x='20' y='30' width='40' height='20' fill='none' stroke='black'/>";
    let page = |width: u32, height: u32| {
        let size = format!("width='{width}mm' height='{height}mm' viewBox='0 0 {width} {height}'");
        format!("<svg xmlns='http://www.w3.org/2000/svg' {size}>{shape}</svg>").into_bytes()
    };
    // From the upper left corner of the page, which has the least x and the greatest y.
    let from_corner = |bytes: &[u8], options: Value| {
        let laid = prepare(Format::Svg, bytes, &options).unwrap();
        let placed = laid.placed.unwrap();
        let [lower_left, _, _, upper_left] = placed.page.unwrap();
        assert_eq!(lower_left[0], upper_left[0]);
        let [x, y] = placed.at;
        let scale = placed.scale;
        [x - upper_left[0], upper_left[1] - y].map(|way| (way / scale).round())
    };
    let a5 = page(148, 210);
    assert_eq!(
        from_corner(&a5, json!({"page": "a5", "at": [250, 0]})),
        [40.0, 40.0]
    );
    let fitted = from_corner(&page(210, 297), json!({"page": "a4", "fit": true}));
    assert!(fitted != [105.0, 149.0], "{fitted:?}");
    // On paper of another size it is centred.
    assert_eq!(from_corner(&a5, json!({"page": "a6"})), [53.0, 74.0]);
    // At twice the size the page is another one.
    let doubled = prepare(
        Format::Svg,
        &page(105, 148),
        &json!({"page": "a6", "scale": 0.5}),
    )
    .unwrap();
    let [[x, y], _, [right, top], _] = doubled.placed.unwrap().page.unwrap();
    let middle = [f64::midpoint(x, right), f64::midpoint(y, top)];
    let off = [0, 1].map(|axis| doubled.placed.unwrap().at[axis] - middle[axis]);
    assert!(off.iter().all(|off| off.abs() < 1e-3), "{off:?}");
}

/// LightBurn file without comments, with air assist.
const AIR_ASSIST_PROGRAM: &[u8] =
    b"G21\nG90\nM4\nM8\nG0 X10Y10\nG1 X60S200F1200\nG1 Y40\nG1 X10\nG1 Y10\nM9\nG1 S0\nM5\nM2\n";
/// Program of a mill.
const MILLING_PROGRAM: &[u8] =
    b"G21\nG90\nM3 S12000\nG0 X10Y10Z5\nG1 Z-1F100\nG1 X60F1200\nG1 Y40\nG0 Z5\nM5\nM2\n";

#[test]
fn file_that_is_engraved_burns_or_is_refused() {
    for options in [
        json!({"work": "engrave"}),
        json!({"place": true, "s_max": 1000}),
    ] {
        let laid = prepare(Format::Gcode, AIR_ASSIST_PROGRAM, &options).unwrap();
        assert!(laid.program.plan().burns(), "{options}");
    }
    let refused = prepare(Format::Gcode, MILLING_PROGRAM, &json!({"work": "engrave"})).unwrap_err();
    assert_eq!(refused.message, "nothing would burn");
    let settings = refused
        .remedies
        .iter()
        .filter_map(|remedy| match remedy.act {
            Act::Give(setting, _) => Some(setting),
            _ => None,
        });
    assert_eq!(
        settings.collect::<Vec<_>>(),
        [Setting::Dialect, Setting::SMax]
    );
    // If it is run unchanged, coolant indicates a mill, with a remedy.
    let laid = prepare(Format::Gcode, AIR_ASSIST_PROGRAM, &json!({"place": true})).unwrap();
    assert!(!laid.program.plan().burns());
    let engraves = |note: &Diagnostic| {
        let mut acts = note.remedies.iter().map(|remedy| &remedy.act);
        acts.any(|act| *act == Act::Do(Action::Engrave))
    };
    assert!(laid.notes.iter().any(engraves), "{}", note_text(&laid));
}

#[test]
fn drawing_with_the_laser_tool_notes_that_it_stays_off() {
    let options = json!({"work": "draw", "tool": "laser"});
    let laid = prepare(Format::Svg, &svg([20.0, 20.0]), &options).unwrap();
    let dark = laid
        .notes
        .iter()
        .find(|note| note.code == DiagnosticCode::Power);
    let dark = dark.unwrap_or_else(|| panic!("{}", note_text(&laid)));
    assert!(dark.message.starts_with("the laser stays dark"), "{dark}");
    assert_eq!(dark.remedies[0].act, Act::Do(Action::Engrave));
}

#[test]
fn coordinates_of_another_machine_are_recognised() {
    let start =
        || Preflight::at(JointAngles::HOME, ToolBias::SUCTION).guards(Guards::NONE.reach(true));
    let at = |x: f64, y: f64| {
        let path = format!(
            "G0 X{x} Y{y} Z20\nG1 Z10 F600\nG1 X{} F900\nG1 Y{}\n",
            x + 50.0,
            y + 30.0
        );
        let text = format!("G21 G90\n{path}G0 Z20\n");
        let laid = prepare(Format::Gcode, text.as_bytes(), &json!({"raw": true})).unwrap();
        let report = check(laid.program.plan(), &start());
        let foreign = foreign_coordinates(laid.program.plan(), &report);
        (report.is_good(), foreign)
    };
    assert!(matches!(at(220.0, 0.0), (true, None)));
    for (x, y) in [(10.0, 10.0), (900.0, 700.0)] {
        let (_, foreign) = at(x, y);
        let foreign = foreign.unwrap_or_else(|| panic!("{x} {y}"));
        assert!(
            foreign
                .message
                .starts_with("its coordinates look like those of another machine")
        );
        let place = |act: &Act| matches!(act, Act::Give(Setting::Place, _));
        assert!(place(&foreign.remedies[0].act), "{foreign}");
    }
    // A drawing for this arm may cross the edge of the reach.
    assert!(matches!(at(290.0, 0.0), (false, None)));
}
