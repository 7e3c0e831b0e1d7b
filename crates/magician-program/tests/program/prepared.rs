//! From a file to a program by one request.

use std::sync::Arc;

use magician_program::{
    DiagnosticCode, Format, FrameShape, OpenedFile, Preparation, PrepareRequest, PrepareStage,
    PreparedProgram, SetupOptions, StartPosition, Tool, WorkOption,
};
use serde_json::{Value, json};

const SQUARE: &str = "<svg xmlns='http://www.w3.org/2000/svg' width='20mm' height='20mm' \
    viewBox='0 0 20 20'><path d='M2 2h16v16h-16z' stroke='black' fill='none'/></svg>";

fn request(format: Format, text: &str, options: Value) -> PrepareRequest {
    let mut request = PrepareRequest::new(format, text.as_bytes());
    request.options = SetupOptions::from_fields(options.as_object().unwrap()).unwrap();
    request.defaults = request.defaults.on_virtual_arm();
    request
}

fn expect_done(preparation: Preparation) -> PreparedProgram {
    match preparation {
        Preparation::Done(program) => *program,
        Preparation::NeedsStart => panic!("it needs a start"),
    }
}

/// Removes the file's content, so that reading it again fails.
fn without_file(mut opened: OpenedFile) -> OpenedFile {
    opened.request.bytes = Arc::default();
    opened
}

#[test]
fn opened_file_is_not_read_again() {
    let gcode = "G90\nG1 X220 Y0 Z20 F600\nG1 X240\n";
    for (format, text) in [(Format::Svg, SQUARE), (Format::Gcode, gcode)] {
        let request = request(format, text, json!({}));
        let mut opened = without_file(request.open().unwrap());
        assert!(
            !expect_done(opened.prepare().unwrap())
                .program
                .plan()
                .steps
                .is_empty()
        );
    }
}

#[test]
fn gcode_is_read_again_if_another_tool_makes_it_burn() {
    let text = "G90\nM4 S0\nG0 X0 Y0\nG1 X20 S500 F600\nG1 Y20\nM5\n";
    let mut framed = request(Format::Gcode, text, json!({"frame": "box"}));
    framed.defaults.tool = Some(Tool::Pen);
    let mut opened = framed.open().unwrap();
    opened.request.tool = Some(Tool::Laser);
    let program = expect_done(opened.prepare().unwrap());
    assert!(matches!(
        program.setup.work,
        magician_program::Work::Engrave(_)
    ));
    let first = &program.notes[0].message;
    assert!(
        first.contains("what would be engraved: the arm has the laser"),
        "{first}"
    );
}

#[test]
fn frame_depends_on_the_tool_in_force_unless_work_or_tool_is_given() {
    let mut options = SetupOptions::default();
    assert!(!options.needs_tool_in_force());
    options.frame = Some(FrameShape::Box);
    assert!(options.needs_tool_in_force());
    options.tool = Some(Tool::Laser);
    assert!(!options.needs_tool_in_force());
    (options.tool, options.work) = (None, Some(WorkOption::Draw));
    assert!(!options.needs_tool_in_force());
}

#[test]
fn missing_start_is_requested_once_with_its_option() {
    let text = "G91\nG1 X5 Y5 F600\nG1 X5\n";
    let mut opened = PrepareRequest::new(Format::Gcode, text.as_bytes())
        .open()
        .unwrap();
    assert_eq!(opened.prepare(), Ok(Preparation::NeedsStart));
    opened.request.start = StartPosition::At([200.000_04, 0.0, 20.0]);
    let program = expect_done(opened.prepare().unwrap());
    assert_eq!(program.start, Some([200.0, 0.0, 20.0]));
    let note = &program.notes[0];
    assert_eq!(note.code, DiagnosticCode::Assumed);
    assert_eq!(
        note.message,
        "it begins at the tool's position, 200.000,0.000,20.000"
    );
    let remedy = &note.remedies[0];
    assert_eq!(
        format!("{:?}", remedy.act),
        "Give(Start, Position([200.0, 0.0, 20.0]))"
    );
    // All of it depends on the start: it can neither be resumed nor begun in its middle.
    assert!(program.has_lost_start(1, false) && program.has_lost_start(0, true));
    assert!(!program.has_lost_start(0, false));
    // A start given by the options is not reported, and may be used again.
    opened.request.options.start = Some([200.0, 0.0, 20.0]);
    let given = expect_done(opened.prepare().unwrap());
    assert_eq!(
        (given.start, given.notes.len()),
        (None, program.notes.len() - 1)
    );
    assert_eq!(given.program.plan(), program.program.plan());
    assert!(!given.has_lost_start(1, true));
}

#[test]
fn staged_start_comes_with_the_joints_of_its_arm() {
    let mut request = PrepareRequest::new(Format::Gcode, b"G91\nG1 X5 F600\n");
    request.start = StartPosition::Staged;
    let program = expect_done(request.prepare().unwrap());
    assert!(program.start.is_some() && program.staged_joints.is_some());
}

#[test]
fn error_has_its_stage_and_the_earlier_notes() {
    let broken = PrepareRequest::new(Format::Gcode, b"G90\nG1 X10 Y%\n");
    assert_eq!(broken.open().unwrap_err().stage, PrepareStage::Read);
    let empty = PrepareRequest::new(Format::Plan, br#"{"plan":1,"title":"nothing","steps":[]}"#);
    let error = empty.prepare().unwrap_err();
    assert_eq!(error.stage, PrepareStage::Read, "{error}");
    let two = SQUARE.replace(
        "<path",
        "<path d='M1 1h2' stroke='white' fill='none'/><path",
    );
    let mut unplaced = request(Format::Svg, &two, json!({}));
    unplaced.defaults.assumed_surface = None;
    let error = unplaced.prepare().unwrap_err();
    assert!(error.problem.lacks_surface(), "{error}");
    assert_eq!(error.stage, PrepareStage::Place);
    assert!(!error.notes.is_empty(), "the white line was left out");
}

#[test]
fn misfit_is_a_finding_for_a_preview_and_an_error_for_a_run() {
    let program = expect_done(
        request(Format::Svg, SQUARE, json!({"scale": 40}))
            .prepare()
            .unwrap(),
    );
    assert!(program.misfit.is_some() && !program.is_raw());
    let error = program.fitting().unwrap_err();
    assert_eq!(error.stage, PrepareStage::Place);
}

#[test]
fn rest_follows_the_last_position_of_a_grid() {
    let mut request = request(Format::Svg, SQUARE, json!({"grid": "2x1:30x20"}));
    let without = expect_done(request.prepare().unwrap());
    request.rest = 250;
    let with = expect_done(request.prepare().unwrap());
    let [count, more] = [&without, &with].map(|program| program.program.plan().steps.len());
    assert_eq!(more, count + 1);
}

#[test]
fn suggested_scale_fits_together_with_a_width() {
    for side in ["width", "height"] {
        let program = expect_done(
            request(Format::Svg, SQUARE, json!({side: 500}))
                .prepare()
                .unwrap(),
        );
        assert!(program.misfit.is_some());
        let scale = program.would_fit.unwrap().scale;
        let again = json!({side: 500, "scale": scale});
        let program = expect_done(request(Format::Svg, SQUARE, again).prepare().unwrap());
        assert!(program.misfit.is_none(), "{side}, {scale}");
    }
}

#[test]
fn grid_of_a_million_places_is_refused() {
    let error = request(Format::Svg, SQUARE, json!({"grid": "1000x1000:1x1"}))
        .prepare()
        .unwrap_err();
    let told = error.problem.message;
    assert!(told.ends_with("are too many, limit 2000000"), "{told}");
}

#[test]
fn laser_that_is_lit_with_another_tool_is_noted() {
    for (tool, noted) in [("pen", true), ("laser", false)] {
        let options = json!({"work": "engrave", "tool": tool});
        let program = expect_done(request(Format::Svg, SQUARE, options).prepare().unwrap());
        let told = { program.notes.iter() }.any(|note| note.message.contains("the laser is lit"));
        assert_eq!(told, noted, "{tool}");
    }
}
