//! Parts of drawings, their pens and passes, and the pauses of a plan.

use magician::Set;
use magician_program::{
    Action, Color, Diagnostic, Format, Part, PartMode, PauseCause, Plan, Prepared, Setup,
    SetupDefaults, SetupOptions, read,
};
use serde_json::{Value, json};

const PAPER: f64 = -60.0;

fn svg(body: &str) -> String {
    format!(
        "<svg xmlns='http://www.w3.org/2000/svg' xmlns:inkscape='http://www.inkscape.org/namespaces/inkscape' \
         width='60mm' height='40mm' viewBox='0 0 60 40'>{body}</svg>"
    )
}

fn layer(name: &str, body: &str) -> String {
    format!("<g inkscape:groupmode='layer' inkscape:label='{name}'>{body}</g>")
}

fn line(y: u32, color: &str) -> String {
    format!("<path d='M5 {y}H25' stroke='{color}'/>")
}

fn options(fields: Value) -> SetupOptions {
    let mut fields = fields;
    fields["surface"] = json!(PAPER);
    SetupOptions::from_fields(fields.as_object().expect("an object")).expect("options")
}

fn prepared(format: Format, text: &str, fields: Value) -> Result<Prepared, Diagnostic> {
    let options = options(fields);
    let setup: Setup = options.setup(&SetupDefaults::default());
    let parsed = read(format, text.as_bytes(), &options.reading(&setup))?;
    setup.plan(format, parsed.content)
}

fn prepared_plan(
    format: Format,
    text: &str,
    fields: Value,
) -> Result<(Plan, Vec<Diagnostic>), Diagnostic> {
    let made = prepared(format, text, fields)?;
    Ok((made.plan, made.notes))
}

fn plan(text: &str, fields: Value) -> Plan {
    prepared_plan(Format::Svg, text, fields).expect("a plan").0
}

/// Parts and pauses, one per line.
fn step_texts(plan: &Plan) -> Vec<String> {
    let steps = plan.steps.iter().filter_map(|step| match &step.action {
        Action::Part(part) => Some(match part.pass {
            Some(pass) => format!("{part} pass {pass}"),
            None => part.to_string(),
        }),
        Action::Pause(pause) => Some(format!("{}: {}", pause.cause.name(), pause.text)),
        _ => None,
    });
    steps.collect()
}

/// End points of the drawn segments.
fn drawn(plan: &Plan) -> Vec<[f32; 3]> {
    let marks = plan.steps.iter().filter(|step| step.action.marks());
    marks.filter_map(|step| step.action.target()).collect()
}

fn three() -> String {
    svg(&[
        layer("outline", &(line(5, "red") + &line(10, "red"))),
        layer("fine", &line(15, "blue")),
        line(20, "green"),
        layer("outline", &line(25, "red")),
    ]
    .concat())
}

#[test]
fn drawing_has_no_parts_unless_requested() {
    let plain = plan(&three(), json!({}));
    assert!(step_texts(&plain).is_empty());
    assert!(
        plain
            .to_json()
            .starts_with("{\"format\":\"magician-plan\",\"version\":1,")
    );
}

#[test]
fn layers_are_parts_in_the_order_in_which_they_first_appear() {
    let layers = plan(&three(), json!({"parts": "layer"}));
    assert_eq!(
        step_texts(&layers),
        [
            "1, outline (#ff0000)",
            "part: mount the pen for part 2, fine (#0000ff)",
            "2, fine (#0000ff)",
            "part: mount the pen for part 3, #008000",
            "3, #008000",
        ]
    );
    assert_eq!(drawn(&layers).len(), 5);
    let colors = plan(&three(), json!({"parts": "color"}));
    assert_eq!(
        step_texts(&colors),
        [
            "1, #ff0000",
            "part: mount the pen for part 2, #0000ff",
            "2, #0000ff",
            "part: mount the pen for part 3, #008000",
            "3, #008000",
        ]
    );
}

/// The pen is up where a part begins and at a pause, and goes down only after it.
#[test]
fn pen_is_up_between_parts() {
    let layers = plan(&three(), json!({"parts": "layer"}));
    let mut z = None;
    for step in &layers.steps {
        if matches!(step.action, Action::Part(_) | Action::Pause(_)) {
            assert!(z.is_none_or(|z: f32| f64::from(z) > PAPER + 9.0), "{z:?}");
        }
        z = step.action.target().map(|[.., z]| z).or(z);
    }
}

#[test]
fn groups_with_an_id_are_layers_where_inkscape_has_made_none() {
    let groups = format!(
        "<g id='a'>{}<g id='inner'>{}</g></g><g>{}</g><g id='b'>{}</g>",
        line(5, "red"),
        line(10, "red"),
        line(15, "red"),
        line(20, "red")
    );
    let parts = step_texts(&plan(
        &svg(&groups),
        json!({"parts": "layer", "no_pause": true}),
    ));
    assert_eq!(parts, ["1, a (#ff0000)", "2, #ff0000", "3, b (#ff0000)"]);
}

#[test]
fn used_elements_belong_to_the_layer_of_the_use() {
    let body = format!(
        "<defs><g id='mark'>{}</g></defs>{}{}",
        line(5, "red"),
        layer("one", "<use href='#mark'/>"),
        layer("two", "<use href='#mark' y='10'/>")
    );
    let parts = step_texts(&plan(
        &svg(&body),
        json!({"parts": "layer", "no_pause": true}),
    ));
    assert_eq!(parts, ["1, one (#ff0000)", "2, two (#ff0000)"]);
}

#[test]
fn layer_names_can_skip_and_pause() {
    let named = svg(&[
        layer("%guides", &line(5, "grey")),
        layer("cut", &line(10, "red")),
        layer("!fold", &line(15, "red")),
        layer("%!both", &line(20, "red")),
    ]
    .concat());
    // Layers with commands are parts without being requested.
    let (pen, notes) = prepared_plan(Format::Svg, &named, json!({})).expect("a plan");
    assert_eq!(
        step_texts(&pen),
        [
            "2, cut (#ff0000)",
            "part: mount the pen for part 3, !fold (#ff0000)",
            "3, !fold (#ff0000)",
        ]
    );
    let notes: Vec<String> = notes.iter().map(ToString::to_string).collect();
    assert!(
        notes.contains(&"left out: part 1, %guides (#808080)".to_owned()),
        "{notes:?}"
    );
    // A burn pauses only at !.
    let three = named.replace("%guides", "guides");
    let burnt = plan(&three, json!({"work": "engrave"}));
    assert_eq!(
        step_texts(&burnt),
        [
            "1, guides (#808080)",
            "2, cut (#ff0000)",
            "part: part 3, !fold (#ff0000) is next",
            "3, !fold (#ff0000)",
        ]
    );
    // The laser is off at the pause.
    let pause = burnt.pauses().next().expect("one").0;
    assert_eq!(burnt.steps[pause - 1].action, Action::Laser(false));
    // `!` also pauses before the first part.
    let first = plan(&svg(&layer("!one", &line(5, "red"))), json!({}));
    let (at, pause) = first.pauses().next().expect("one");
    assert_eq!(pause.cause, PauseCause::Part);
    let mut before = first.steps[..at].iter();
    assert!(before.all(|step| matches!(step.action, Action::Command(_))));
    // A layer requested by name is drawn.
    let only = plan(&named, json!({"only": ["%guides"]}));
    assert_eq!(step_texts(&only), ["1, %guides (#808080)"]);
    let none = plan(&named, json!({"parts": "none"}));
    assert!(step_texts(&none).is_empty());
}

#[test]
fn parts_are_chosen_by_name_then_colour_then_number() {
    let named = svg(&[
        layer("2", &line(5, "red")),
        layer("red", &line(10, "blue")),
        layer("c", &line(15, "red")),
    ]
    .concat());
    let chosen = |only: Value| step_texts(&plan(&named, json!({"only": only, "no_pause": true})));
    assert_eq!(chosen(json!(["red"])), ["2, red (#0000ff)"]);
    assert_eq!(chosen(json!(["2"])), ["1, 2 (#ff0000)"]);
    assert_eq!(
        chosen(json!(["#f00"])),
        ["1, 2 (#ff0000)", "3, c (#ff0000)"]
    );
    assert_eq!(
        chosen(json!(["3", "blue"])),
        ["2, red (#0000ff)", "3, c (#ff0000)"]
    );
    let refused = prepared_plan(Format::Svg, &named, json!({"only": ["Red"]}));
    assert!(refused.is_ok(), "a colour's name has no case");
    let refused =
        prepared_plan(Format::Svg, &named, json!({"only": ["pencil"]})).expect_err("there is none");
    assert_eq!(
        refused.message,
        "no part has the name, colour or number 'pencil'; the parts are 1, 2 (#ff0000); 2, red (#0000ff); 3, c (#ff0000)"
    );
}

#[test]
fn parts_drawn_separately_align_with_the_whole() {
    let long = "<path d='M0 0H600' stroke='blue' fill='none'/>";
    let short = "<path d='M290 5H310' stroke='red' fill='none'/>";
    let drawing = svg(&[layer("small", short), layer("long", long)].concat());
    let made = |more: Value| {
        let mut fields = json!({"fit": true, "no_pause": true, "parts": "layer"});
        let all = fields.as_object_mut().expect("an object");
        all.extend(more.as_object().expect("an object").clone());
        prepared(Format::Svg, &drawing, fields).expect("a plan")
    };
    let marks = |plan: &Plan| -> Vec<[f32; 2]> {
        let marks = plan.steps.iter().filter(|step| step.action.marks());
        let marks = marks.filter_map(|step| step.action.target());
        marks.map(|[x, y, _]| [x, y]).collect()
    };
    let together = made(json!({}));
    let (small, large) = (
        made(json!({"only": ["small"]})),
        made(json!({"only": ["long"]})),
    );
    let apart = [marks(&small.plan), marks(&large.plan)].concat();
    assert!(!apart.is_empty());
    assert_eq!(apart, marks(&together.plan));
    // At the place of the whole drawing, so that it can be repeated.
    assert_eq!([small.placed, large.placed], [together.placed; 2]);
    assert!(small.placed.is_some_and(|placed| placed.scale < 1.0));
    // A part may fit although the whole does not.
    let part = made(json!({"fit": false, "only": ["small"]}));
    assert!(part.misfit.is_none());
    assert!(made(json!({"fit": false})).misfit.is_some());
}

#[test]
fn each_pass_is_written_out_before_the_next_part() {
    let passes = plan(
        &three(),
        json!({"parts": "layer", "passes": 2, "only": ["1", "2"]}),
    );
    assert_eq!(
        step_texts(&passes),
        [
            "1, outline (#ff0000) pass 1",
            "1, outline (#ff0000) pass 2",
            "part: mount the pen for part 2, fine (#0000ff)",
            "2, fine (#0000ff) pass 1",
            "2, fine (#0000ff) pass 2",
        ]
    );
    let marks = drawn(&passes);
    assert_eq!(marks.len(), 2 * 4);
    let whole = plan(&three(), json!({"passes": 3}));
    assert_eq!(step_texts(&whole), ["1 pass 1", "1 pass 2", "1 pass 3"]);
    assert_eq!(drawn(&whole).len(), 3 * 5);
    let program = "G0 X220 Y0 Z20\nG0 Z0\nG1 X240 F600\nG0 Z20\n";
    let twice = prepared_plan(Format::Gcode, program, json!({"passes": 2}))
        .expect("a plan")
        .0;
    assert_eq!(step_texts(&twice), ["1 pass 1", "1 pass 2"]);
}

#[test]
fn part_uses_its_matching_pen() {
    let pens = json!({
        "parts": "layer",
        "speed": 40,
        "pens": [
            {"match": "blue", "surface_offset": 1.5, "lift": 4, "speed": 15, "passes": 2},
            {"match": "fine", "lift": 9},
            {"match": 3, "surface_offset": -1},
            {"match": "chalk"},
        ]
    });
    let (plan, notes) = prepared_plan(Format::Svg, &three(), pens).expect("a plan");
    let unused = notes
        .iter()
        .any(|note| note.message == "a pen is not used: no part has the name or colour 'chalk'");
    assert!(unused, "{notes:?}");
    let (mut part, mut speed, mut seen, mut up) = (0, 0.0, Vec::new(), Vec::new());
    for step in &plan.steps {
        match &step.action {
            Action::Part(next) => part = next.n,
            Action::Command(command) => {
                if let Set::CpParams(params) = **command {
                    speed = params.junction_vel;
                }
            }
            Action::Path { to: [.., z] } => seen.push((part, f64::from(*z) - PAPER, speed)),
            Action::Move {
                to: [_, _, z, _], ..
            } if part > 0 => up.push((part, f64::from(*z) - PAPER)),
            _ => {}
        }
    }
    let has = |part, z, speed| {
        seen.iter()
            .filter(|found| **found == (part, z, speed))
            .count()
    };
    assert_eq!(
        (
            has(1, 0.0, 40.0),
            has(2, 1.5, 15.0),
            has(3, -1.0, 40.0),
            seen.len()
        ),
        (3, 2, 1, 6)
    );
    // The pen is lifted by the part's lift from the part's drawing height.
    let fine = up.iter().filter(|(part, _)| *part == 2).map(|(_, z)| *z);
    assert!(
        fine.clone().any(|z| z == 5.5) && fine.clone().all(|z| z == 1.5 || z >= 5.5),
        "{up:?}"
    );
    // All of it counts as drawn, whatever the height of its pen.
    assert_eq!(
        plan.surface.map(|surface| surface.height),
        Some(PAPER + 1.5)
    );
    let burnt = json!({"work": "engrave", "power": 80, "parts": "layer", "pens": [{"match": "fine", "power": 30}]});
    let plan = prepared_plan(Format::Svg, &three(), burnt)
        .expect("a plan")
        .0;
    let powers: Vec<f32> = { plan.steps.iter() }
        .filter_map(|step| match step.action {
            Action::Burn { power, .. } => Some(power),
            _ => None,
        })
        .collect();
    assert_eq!(powers, [80.0, 80.0, 80.0, 30.0, 80.0]);
}

#[test]
fn shapes_are_filled_only_in_parts_with_a_fill() {
    let square = |x: u32, color: &str| {
        format!("<rect x='{x}' y='5' width='10' height='10' fill='{color}'/>")
    };
    let two = svg(&[
        layer("a", &square(5, "red")),
        layer("b", &square(30, "blue")),
    ]
    .concat());
    let pens =
        json!({"parts": "layer", "no_pause": true, "pens": [{"match": "b", "fill": "hatch"}]});
    let plan = plan(&two, pens);
    let parts: Vec<usize> = { plan.steps.iter().enumerate() }
        .filter(|(_, step)| matches!(step.action, Action::Part(_)))
        .map(|(nth, _)| nth)
        .collect();
    let marks =
        |steps: &[magician_program::Step]| steps.iter().filter(|step| step.action.marks()).count();
    assert_eq!(marks(&plan.steps[parts[0]..parts[1]]), 4, "its edge");
    assert!(marks(&plan.steps[parts[1]..]) > 12, "hatched");
}

#[test]
fn pens_of_plots_and_layers_of_dxf_are_parts() {
    let plot = "IN;SP1;PU0,0;PD400,0;SP2;PU0,400;PD400,400;SP1;PU0,800;PD400,800;";
    let (alike, notes) = prepared_plan(Format::Hpgl, plot, json!({})).expect("a plan");
    assert!(step_texts(&alike).is_empty());
    assert!(
        notes
            .iter()
            .any(|note| note.message.starts_with("pens 1, 2 draw alike"))
    );
    let pens = prepared_plan(Format::Hpgl, plot, json!({"parts": "layer"}))
        .expect("a plan")
        .0;
    assert_eq!(
        step_texts(&pens),
        [
            "1, pen 1",
            "part: mount the pen for part 2, pen 2",
            "2, pen 2"
        ]
    );
    let dxf = "0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLAYER\n0\nLAYER\n2\ncut\n70\n0\n62\n1\n0\nENDTAB\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n\
        0\nLINE\n8\ncut\n10\n0\n20\n0\n11\n20\n21\n0\n0\nLINE\n8\nmark\n62\n5\n10\n0\n20\n9\n11\n20\n21\n9\n0\nENDSEC\n0\nEOF\n";
    let layers = prepared_plan(
        Format::Dxf,
        dxf,
        json!({"parts": "layer", "no_pause": true}),
    )
    .expect("a plan")
    .0;
    assert_eq!(
        step_texts(&layers),
        ["1, cut (#ff0000)", "2, mark (#0000ff)"]
    );
}

const TOOLS: &str = "T1\nG0 X220 Y0 Z20 F3000\nG0 Z0\nG1 X240 F600\nM0 (turn the paper)\nG1 Y10\nG0 Z20\n\
    T2 M6\nG0 X220 Y20\nG0 Z0\nG1 X240\nG0 Z20\nT2\nT1\nG0 X230\nM1\nM6\nM0 P5 Press the button\nM2\n";

/// Plan in its own coordinates, which are the arm's.
fn run(options: &SetupOptions) -> Result<Plan, Diagnostic> {
    let setup = options.setup(&SetupDefaults::default());
    let parsed = read(Format::Gcode, TOOLS.as_bytes(), &options.reading(&setup))?;
    Ok(setup.plan(Format::Gcode, parsed.content)?.plan)
}

#[test]
fn g_code_pauses_at_pause_commands() {
    let plan = run(&SetupOptions::by_file()).expect("a plan");
    assert_eq!(
        step_texts(&plan),
        [
            "program: turn the paper",
            "program: mount tool 2",
            "program: mount tool 1",
            "program: the program pauses (M1)",
            "program: mount tool 1",
            "program: Press the button",
        ]
    );
    // A pen line is between its pauses.
    let pauses: Vec<usize> = plan.pauses().map(|(nth, _)| nth).collect();
    assert!(
        plan.steps[..pauses[0]]
            .iter()
            .any(|step| step.action.marks())
    );
    assert!(
        plan.steps[pauses[0]..pauses[1]]
            .iter()
            .any(|step| step.action.marks())
    );
}

/// Lines before the first named tool were drawn with another one.
#[test]
fn first_tool_is_a_change_after_earlier_drawing() {
    const TEXT: &str =
        "G0 X220 Y0 Z20 F3000\nG0 Z0\nG1 X240 F600\nG0 Z20\nT2\nG0 Z0\nG1 Y10\nG0 Z20\nM2\n";
    let run = |options: &SetupOptions| {
        let setup = options.setup(&SetupDefaults::default());
        let parsed = read(Format::Gcode, TEXT.as_bytes(), &options.reading(&setup)).expect("read");
        setup
            .plan(Format::Gcode, parsed.content)
            .expect("a plan")
            .plan
    };
    let mut options = SetupOptions::by_file();
    assert_eq!(step_texts(&run(&options)), ["program: mount tool 2"]);
    options.parts = Some(PartMode::Layer);
    assert_eq!(
        step_texts(&run(&options)),
        ["1", "part: mount tool 2", "2, tool 2"]
    );
}

#[test]
fn tools_become_parts_on_request() {
    let mut options = SetupOptions::by_file();
    options.parts = Some(PartMode::Layer);
    let all = step_texts(&run(&options).expect("a plan"));
    assert_eq!(
        all[..6],
        [
            "1, tool 1",
            "program: turn the paper",
            "part: mount tool 2",
            "2, tool 2",
            "part: mount tool 1",
            "1, tool 1",
        ]
    );
    options.only = vec!["tool 1".to_owned()];
    let refused = run(&options).expect_err("it cannot");
    assert!(
        refused.message.starts_with("only the parts of a drawing"),
        "{refused}"
    );
}

#[test]
fn without_pauses_everything_else_is_equal() {
    let pauses = plan(&three(), json!({"parts": "layer"}));
    let never = plan(&three(), json!({"parts": "layer", "no_pause": true}));
    assert!(never.pauses().next().is_none());
    assert!(never.commands().eq(pauses.commands()));
    // The two are different programs for resuming.
    let key = |plan: &Plan| magician_program::Program::new(plan.clone(), Some(1)).key();
    assert_ne!(key(&pauses), key(&never));
}

#[test]
fn a_plan_with_parts_is_read_back_byte_for_byte() {
    let plan = plan(&three(), json!({"parts": "layer", "passes": 2}));
    let text = plan.to_json();
    assert!(
        text.starts_with("{\"format\":\"magician-plan\",\"version\":2,"),
        "{text}"
    );
    assert!(
        text.contains("\n{\"part\":{\"n\":2,\"name\":\"fine\",\"color\":\"#0000ff\",\"pass\":1}"),
        "{text}"
    );
    assert!(
        text.contains("\n{\"part\":{\"n\":3,\"name\":null,\"color\":\"#008000\",\"pass\":2}"),
        "{text}"
    );
    assert!(
        text.contains(
            "{\"pause\":\"mount the pen for part 2, fine (#0000ff)\",\"reason\":\"part\""
        ),
        "{text}"
    );
    let back = Plan::from_json(text.as_bytes()).expect("it is read");
    assert_eq!(back, plan);
    assert_eq!(back.to_json(), text);
    let problem = |text: &str| Plan::from_json(text.as_bytes()).expect_err("wrong").message;
    assert_eq!(
        problem(&text.replace("\"version\":2", "\"version\":1")),
        "a 'part' needs a plan of version 2"
    );
    assert_eq!(
        problem(&text.replace("\"version\":2", "\"version\":3")),
        "this is a plan of version 3; only versions 1 and 2 are known here"
    );
    for (wrong, says) in [
        ("{\"part\":{\"n\":0}}", "parts and passes count from 1"),
        (
            "{\"part\":{\"n\":1,\"color\":\"reddish\"}}",
            "'reddish' is not a colour",
        ),
        ("{\"part\":{\"n\":1,\"pen\":2}}", "unknown"),
        ("{\"part\":2}", ""),
        ("{\"pause\":\"wait\"}", "'pause' needs 'reason' beside it"),
        ("{\"pause\":\"wait\",\"reason\":\"lunch\"}", ""),
        ("{\"pause\":3,\"reason\":\"part\"}", ""),
    ] {
        let text = format!("{{\"format\":\"magician-plan\",\"version\":2,\"steps\":[{wrong}]}}");
        let found = problem(&text);
        assert!(found.starts_with(says), "{wrong}: {found}");
    }
}

#[test]
fn all_parts_are_listed_with_skipped_ones_marked() {
    let named = svg(&[
        layer("a", &line(5, "red")),
        layer("%b", &(line(10, "blue") + &line(20, "red"))),
    ]
    .concat());
    let options = options(json!({}));
    let setup: Setup = options.setup(&SetupDefaults::default());
    let content = read(Format::Svg, named.as_bytes(), &options.reading(&setup))
        .unwrap()
        .content;
    let parts = setup.list_parts(Format::Svg, &content).expect("a list");
    let shown = serde_json::to_value(&parts).unwrap();
    assert_eq!(shown[0]["name"], "a");
    assert_eq!(
        (&shown[0]["color"], &shown[0]["skipped"]),
        (&json!("#ff0000"), &json!(false))
    );
    assert_eq!(
        (&shown[1]["color"], &shown[1]["skipped"]),
        (&json!(null), &json!(true))
    );
    assert_eq!((parts[1].n, parts[1].strokes), (2, 2));
    assert!((parts[1].drawn_mm - 40.0).abs() < 1e-3);
    assert!(parts[1].seconds.is_none());
    assert!(
        parts[0]
            .seconds
            .is_some_and(|seconds| (1.0..5.0).contains(&seconds))
    );
    assert!((parts[0].drawn_mm - 20.0).abs() < 1e-3);
}

#[test]
fn strokes_of_filled_shapes_are_counted_as_they_are_drawn() {
    let square = |x: u32, colour: &str| {
        format!(
            "<path d='M{x} 5h8v20h-8z' fill='{colour}'/><path d='M{x} 30h8' stroke='{colour}'/>"
        )
    };
    let two = svg(&(square(5, "red") + &square(25, "blue")));
    let listed = |more: Value| {
        let options = options(more);
        let setup: Setup = options.setup(&SetupDefaults::default());
        let content = read(Format::Svg, two.as_bytes(), &options.reading(&setup))
            .unwrap()
            .content;
        let parts = setup.list_parts(Format::Svg, &content).expect("a list");
        parts.iter().map(|part| part.strokes).collect::<Vec<_>>()
    };
    // Each square has an edge without a fill; with a fill a zigzag, or two crossing ones, are
    // added.
    assert_eq!(listed(json!({"parts": "color"})), [2, 2]);
    let hatched = json!({"parts": "color", "fill": "hatch", "fill_spacing": 1});
    assert_eq!(listed(hatched.clone()), [2, 2]);
    let mut crossed = hatched;
    crossed["fill"] = json!("cross");
    crossed["passes"] = json!(3);
    assert_eq!(listed(crossed.clone()), [3, 3]);
    crossed["only"] = json!(["blue"]);
    assert_eq!(listed(crossed.clone())[1], 3);
    assert_eq!(
        listed(json!({"fill": "cross", "fill_spacing": 1, "parts": "none"})),
        [6]
    );
}

#[test]
fn colours_have_names_and_numbers() {
    for (text, color) in [
        ("red", "#ff0000"),
        ("#0a3", "#00aa33"),
        (" Navy ", "#000080"),
        ("#AbCdEf", "#abcdef"),
    ] {
        let parsed: Color = text.parse().expect(text);
        assert_eq!(parsed.to_string(), color);
    }
    for text in ["", "#", "#12", "2", "reddish", "#ggg", "rgb("] {
        assert!(text.parse::<Color>().is_err(), "{text}");
    }
    let part = Part {
        n: 2,
        color: Some(Color([1, 2, 3])),
        ..Part::default()
    };
    assert_eq!(part.to_string(), "2, #010203");
}
