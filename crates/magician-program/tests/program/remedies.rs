//! Remedies of problems and notes: each one of this crate, reached by a file and a setup.

use std::collections::BTreeSet;

use magician::{Act, Setting, SettingValue};
use magician_program::artwork::Sheet;
use magician_program::formats::playback::Playback;
use magician_program::raster::{Engrave, Size, Tone, Trace};
use magician_program::{
    Action, Diagnostic, Fit, Format, Frame, Origin, Parsed, Plan, Power, Reach, ReadOptions, Setup,
    Surface, Tool, Travel, White, Work, read,
};

const PAPER: Surface = Surface::level(-60.0);

/// All remedies for a file read and planned this way: name of the act, and its effect.
fn remedies(
    format: Format,
    bytes: &[u8],
    set: impl FnOnce(&mut ReadOptions, &mut Setup),
) -> BTreeSet<String> {
    let (mut options, mut setup) = (ReadOptions::default(), Setup::default());
    setup.surface = Some(PAPER);
    set(&mut options, &mut setup);
    setup.set_gcode_options(&mut options.gcode, None);
    let Parsed { content, mut notes } = match read(format, bytes, &options) {
        Ok(reading) => reading,
        Err(diagnostic) => return remedy_texts(&[diagnostic]),
    };
    match setup.plan(format, content) {
        Ok(prepared) => {
            notes.extend(prepared.notes);
            notes.extend(prepared.misfit);
        }
        Err(diagnostic) => notes.push(diagnostic),
    }
    remedy_texts(&notes)
}

fn remedy_texts(diagnostics: &[Diagnostic]) -> BTreeSet<String> {
    let remedies = diagnostics
        .iter()
        .flat_map(|diagnostic| &diagnostic.remedies);
    remedies
        .map(|remedy| {
            let said = format!("{} {}", remedy.act, remedy.effect);
            said.trim_end().to_owned()
        })
        .collect()
}

/// Remedies for G-code in arm coordinates.
fn of_gcode(text: &str, set: impl FnOnce(&mut ReadOptions, &mut Setup)) -> BTreeSet<String> {
    remedies(Format::Gcode, text.as_bytes(), |options, setup| {
        setup.surface = None;
        set(options, setup);
    })
}

fn svg(size: [f64; 2], inside: &str) -> Vec<u8> {
    let [width, height] = size;
    let text = format!(
        "<svg xmlns='http://www.w3.org/2000/svg' width='{width}mm' height='{height}mm' viewBox='0 0 {width} {height}'>{inside}</svg>"
    );
    text.into_bytes()
}

/// Rectangle as large as its page.
fn page(size: [f64; 2]) -> Vec<u8> {
    let [width, height] = size;
    let rectangle = format!("<rect width='{width}' height='{height}' fill='none' stroke='black'/>");
    svg(size, &rectangle)
}

#[track_caller]
fn assert_has(remedies: &BTreeSet<String>, wanted: &[&str]) {
    for wanted in wanted {
        assert!(
            remedies.iter().any(|said| said == wanted),
            "{wanted}: {remedies:?}"
        );
    }
}

fn sheet(size: [f64; 2]) -> Sheet {
    Sheet {
        corner: [200.0, -20.0],
        rotation: 0.0,
        surface: PAPER,
        size: Some(size),
    }
}

#[test]
fn remedies_of_drawings_are_options() {
    let two = "<path d='M1 1h5M40 40h5M8 1h5' stroke='black'/>";
    let ordered = remedies(Format::Svg, &svg([50.0, 50.0], two), |_, _| {});
    assert_has(&ordered, &["order off keeps the order of the file"]);
    let white = "<path d='M1 1h5' stroke='black'/><path d='M1 5h5' stroke='white'/>";
    let white = svg([20.0, 20.0], white);
    let left_out = remedies(Format::Svg, &white, |_, _| {});
    assert_has(&left_out, &["white draw keeps it"]);
    let kept = remedies(Format::Svg, &white, |options, _| {
        options.white = White::Draw;
    });
    assert!(!kept.contains("white draw keeps it"), "{kept:?}");
    let beyond = svg([20.0, 20.0], "<path d='M1 1h50' stroke='black'/>");
    assert_has(
        &remedies(Format::Svg, &beyond, |_, _| {}),
        &["clip_page cuts it off"],
    );
    let unitless =
        b"0\nSECTION\n2\nENTITIES\n0\nLINE\n10\n0\n20\n0\n11\n20\n21\n5\n0\nENDSEC\n0\nEOF\n";
    assert_has(
        &remedies(Format::Dxf, unitless, |_, _| {}),
        &["scale FACTOR corrects the size"],
    );
    let scaled = remedies(
        Format::Hpgl,
        b"IN;SC0,100,0,100;SP1;PU0,0;PD50,50;PU;",
        |_, _| {},
    );
    assert_has(
        &scaled,
        &["width MM sets its width", "scale FACTOR scales it"],
    );
}

#[test]
fn too_many_points_suggest_a_wider_tolerance() {
    // No circle has more than 100,000 points; one of a kilometre has that many at the finest
    // tolerance.
    let circles = "0\nCIRCLE\n10\n0\n20\n0\n40\n1000000\n".repeat(21);
    let file = format!("0\nSECTION\n2\nENTITIES\n{circles}0\nENDSEC\n0\nEOF\n");
    let fine = remedies(Format::Dxf, file.as_bytes(), |options, _| {
        options.tolerance = 1e-9;
    });
    assert_has(&fine, &["tolerance MM needs fewer if it is larger"]);
}

#[test]
fn misplaced_drawing_gets_a_position_and_a_size() {
    let large = page([210.0, 297.0]);
    let anywhere = remedies(Format::Svg, &large, |_, _| {});
    assert_eq!(
        anywhere
            .iter()
            .filter(|said| said.contains("scale 0."))
            .count(),
        1,
        "{anywhere:?}"
    );
    assert_has(&anywhere, &["fit shrinks it"]);
    let wide = page([400.0, 80.0]);
    let there = remedies(Format::Svg, &wide, |_, setup| {
        setup.placement.at = Some([240.0, 0.0]);
    });
    assert_has(&there, &["rotate 90 leaves it more room"]);
    // A drawing without a given position is turned automatically.
    assert_has(
        &remedies(Format::Svg, &wide, |_, _| {}),
        &["turn off leaves it as it lies"],
    );
    let small = page([20.0, 20.0]);
    let far = remedies(Format::Svg, &small, |_, setup| {
        setup.placement.at = Some([330.0, 0.0]);
    });
    assert!(
        far.iter()
            .any(|said| said.starts_with("at ") && said.contains("fits there")),
        "{far:?}"
    );
    let edge = remedies(Format::Svg, &page([120.0, 120.0]), |_, setup| {
        setup.placement.at = Some([290.0, 0.0]);
    });
    assert!(
        edge.iter()
            .any(|said| said.starts_with("at ") && said.ends_with("fits at this size")),
        "{edge:?}"
    );
    let nowhere = remedies(Format::Svg, &large, |_, setup| {
        setup.placement.at = Some([900.0, 0.0]);
    });
    assert_has(&nowhere, &["at X,Y places it elsewhere"]);
    let turned = remedies(Format::Svg, &page([400.0, 80.0]), |_, setup| {
        setup.placement.fit = true;
    });
    assert_has(&turned, &["turn off leaves it as it lies"]);
    let corners = [[0.0, 0.0], [400.0, 0.0], [400.0, 400.0], [0.0, 400.0]];
    let reach = Reach::new(Tool::Pen.bias(), PAPER, 20.0);
    let refused = reach.best_place(&corners, Fit::TrueSize).unwrap_err();
    let Act::Give(Setting::Fit, SettingValue::On) = refused.remedies[0].act else {
        panic!("{refused:?}")
    };
    assert_has(
        &remedy_texts(&[refused]),
        &["rotate 90 may leave it larger"],
    );
}

#[test]
fn missing_surface_suggests_options() {
    let unknown = remedies(Format::Svg, &page([20.0, 20.0]), |_, setup| {
        setup.surface = None;
    });
    let says = "surface Z sets it: the z of the pose when the tool touches it";
    assert_has(&unknown, &["calibrate-surface measures it", says]);
    let left = remedies(Format::Svg, &page([20.0, 20.0]), |_, setup| {
        setup.placement.frame = Frame::Arm;
    });
    assert_has(
        &left,
        &["without raw", "at X,Y sets the position of its centre"],
    );
    let gcode = "G0 X200 Y0 Z5\nG1 Z0 F600\nG1 X260\nG0 Z5\n";
    let both = of_gcode(gcode, |_, setup| {
        setup.placement.frame = Frame::Arm;
        setup.placement.at = Some([220.0, 0.0]);
    });
    assert_eq!(Vec::from_iter(both), ["without raw"]);
    let raw = of_gcode(gcode, |_, setup| setup.placement.pen_z = Some(0.0));
    assert_eq!(
        Vec::from_iter(raw),
        ["place places G-code", "without pen_z"]
    );
    let drawn = remedies(Format::Svg, &page([20.0, 20.0]), |_, setup| {
        setup.placement.pen_z = Some(0.0);
    });
    assert_has(&drawn, &["without pen_z"]);
    let placed = of_gcode(gcode, |_, setup| setup.surface = Some(PAPER));
    let raw = "raw takes its coordinates as the arm's";
    assert_has(
        &placed,
        &[raw, "pen_z Z sets another Z for the touching pen"],
    );
    let above = of_gcode(gcode, |_, setup| {
        setup.surface = Some(PAPER);
        setup.placement.pen_z = Some(-5.0);
    });
    assert_has(&above, &["pen_z Z sets the Z at which its pen touches"]);
    let nothing = of_gcode("G0 X200 Y0 Z5\n", |_, setup| setup.surface = Some(PAPER));
    assert_has(&nothing, &["raw runs it as it stands"]);
    let small = of_gcode(gcode, |_, setup| setup.sheet = Some(sheet([30.0, 30.0])));
    assert!(small.is_empty(), "it is not placed: {small:?}");
    let small = of_gcode(gcode, |_, setup| {
        setup.sheet = Some(sheet([30.0, 30.0]));
        setup.placement.frame = Frame::Own;
    });
    let moves = "at X,Y places it without one";
    assert_has(&small, &["fit shrinks it to the sheet", moves]);
    let image = include_bytes!("../../samples/engrave_gradient.png");
    let image = remedies(Format::Image, image, |_, setup| {
        setup.sheet = Some(sheet([30.0, 30.0]));
        setup.size = Size::Width(60.0);
    });
    let smaller = "width MM makes it smaller";
    assert_has(&image, &[smaller, "fit makes it as small as need be"]);
}

#[test]
fn remedies_of_images_are_options() {
    let image = include_bytes!("../../samples/engrave_gradient.png");
    let of = |work: Work, fit: bool| {
        remedies(Format::Image, image, |_, setup| {
            setup.size = Size::Width(60.0);
            setup.placement.fit = fit;
            setup.work = work;
        })
    };
    let mut trace = Trace::default();
    trace.level = 0;
    assert_has(
        &of(Work::Draw(trace), false),
        &["threshold N traces more if it is higher"],
    );
    let engraved = |set: fn(&mut Engrave), fit| {
        let mut engrave = Engrave::default();
        set(&mut engrave);
        of(Work::Engrave(engrave), fit)
    };
    let white = engraved(|engrave| engrave.tone = Tone::Threshold(0), false);
    assert_has(
        &white,
        &[
            "invert burns the white parts",
            "threshold N sets what counts as dark",
        ],
    );
    let fine = engraved(|engrave| engrave.spacing = 0.005, false);
    let wider = "spacing MM increases the distance between its lines";
    assert_has(&fine, &["width MM makes it smaller", wider]);
    let long = engraved(|engrave| engrave.overscan = Some(400.0), true);
    let less = "overscan MM sets the run-up";
    assert_has(&long, &["speed MM/S engraves it slower", less]);
}

#[test]
fn remedies_of_gcode_are_options() {
    let of = |text: &str| of_gcode(text, |_, _| {});
    let start = "start X,Y,Z sets where the program begins";
    assert_has(&of("G91\nG1 X10 F600\n"), &[start]);
    assert_has(&of("G1 X220 F600\n"), &[start]);
    assert_has(&of("G2 X230 Y20 I-20\n"), &[start]);
    let s_max = "s_max N sets the S of full power";
    assert_has(&of("G0 X220 Y0 Z0\nM3 S2000\nG1 X221 F600\n"), &[s_max]);
    assert_has(&of("G0 X220 Y0 Z0\nM3 S200\nG1 X221 F600\n"), &[s_max]);
    assert_has(&of("$30=9\nG0 X220 Y0 Z0\nM3 S20\nG1 X221\n"), &[s_max]);
    let unsaid = of("G0 X220 Y0 Z0\nM3\nG1 X230\n");
    let speed = "speed MM/S sets another speed";
    assert_has(&unsaid, &["power PERCENT sets the full power", speed]);
    let mill = of("G0 X220 Y0 Z5\nM3 S10000\nG1 Z-2 F100\nG1 X230\nG0 Z5\nM5\n");
    assert_has(&mill, &["dialect laser burns with it"]);
    let servo = of("M280 P0 S40\nG0 X220 Y0\nM280 P0 S90\nG1 X240 F600\nM280 P0 S40\n");
    assert_has(&servo, &["surface Z gives it, as z of the arm"]);
    assert_has(
        &of("G28\nG0 X220 Y0 Z0\n"),
        &["home homes it before the program"],
    );
    assert_has(&of("G0 X220 Y0 Z0\nM99\n"), &["loops N repeats it"]);
    let machine = "G0 X200 Y0 Z5\nG1 Z0 F600\nG53 G1 X260\nG0 Z5\n";
    let machine = of_gcode(machine, |_, setup| setup.surface = Some(PAPER));
    assert_has(&machine, &["raw takes its coordinates as the arm's"]);
    let thinned = of_gcode("G0 X220 Y0 Z0\n", |options, _| {
        options.resample = Some(0.1);
    });
    assert_has(&thinned, &["without resample"]);
}

#[test]
fn remedies_of_other_files_are_options() {
    let row = "<row0><item_0>1</item_0><item_2>220</item_2><item_3>0</item_3><item_4>20</item_4><item_5>0</item_5></row0>";
    let playback = format!("<root>{row}</root>");
    let playback = remedies(Format::Playback, playback.as_bytes(), |_, setup| {
        setup.surface = None;
    });
    assert_has(&playback, &["tool NAME sets it"]);
    let points = b"X,Y,Z,R,Velocity\n220,0,20,0,30\n";
    let points = remedies(Format::Points, points, |_, setup| setup.surface = None);
    assert_has(&points, &["speed_ratio PERCENT says how fast"]);
    let endless = br#"<xml><block type="controls_whileUntil"><field name="MODE">WHILE</field><value name="BOOL"><block type="logic_boolean"><field name="BOOL">TRUE</field></block></value></block></xml>"#;
    let endless = remedies(Format::Blockly, endless, |_, _| {});
    assert_has(&endless, &["loops N repeats all of it"]);
    let foreign = br#"{"format":"magician-plan","version":1,"steps":[
{"command":"Waltz"}
]}"#;
    let foreign = remedies(Format::Plan, foreign, |_, _| {});
    assert_has(&foreign, &["list-commands lists them"]);
    let mut plan = Plan::new("drawn");
    plan.tool = Some(Tool::Pen);
    let (to, by) = ([220.0, 0.0, 20.0, 0.0], Travel::Line);
    plan.push(Action::Move { to, by }, Origin::NONE);
    let kept = Playback::from_plan(&plan).unwrap();
    assert_has(
        &remedy_texts(kept.notes()),
        &["tool NAME sets it when the file is played"],
    );
    let mut plan = Plan::new("lit");
    plan.push(Action::Laser(true), Origin::NONE);
    let power = Power::new(0.0, 50.0).unwrap();
    let refused = plan.at_power(&power).unwrap_err();
    assert_has(&remedy_texts(&[refused]), &["power 100 runs it as it is"]);
}

#[test]
fn front_end_voice_joins_advice_and_options() {
    struct UppercaseVoice;
    impl magician::Voice for UppercaseVoice {
        fn action(&self, action: magician::Action) -> String {
            action.name().to_uppercase()
        }
        fn give(&self, setting: Setting, given: &SettingValue) -> String {
            format!("{}={given}", self.setting(setting))
        }
        fn setting(&self, setting: Setting) -> String {
            setting.name().to_uppercase()
        }
    }
    let diagnostic = Diagnostic::of_file("nothing is known");
    assert_eq!(diagnostic.advice(&UppercaseVoice), None);
    let diagnostic = diagnostic
        .help("look it up")
        .remedy(magician::Action::Home, "homes it")
        .remedy((Setting::Fit, SettingValue::On), "shrinks it");
    let advice = "look it up; HOME homes it; FIT=on shrinks it";
    assert_eq!(diagnostic.advice(&UppercaseVoice).as_deref(), Some(advice));
}
