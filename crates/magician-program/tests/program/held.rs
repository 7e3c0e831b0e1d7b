//! A pen never goes below its surface, whatever file and options say, except with kept depths.

use magician::Set;
use magician::preflight::Preflight;
use magician::{JointAngles, ToolBias};
use magician_program::artwork::Sheet;
use magician_program::{
    Depths, Ending, Format, Preparation, PrepareRequest, Program, SetupDefaults, SetupOptions,
    Surface, Tool,
};
use magician_protocol::PtpMode;
use proptest::collection::vec;
use proptest::prelude::*;
use serde_json::{Map, Value, json};

const TILTED: Surface = Surface {
    height: -57.0,
    slope: [0.012, -0.02],
};

/// Files of each kind, some of which go far down.
fn files() -> Vec<(Format, Vec<u8>)> {
    let text = |format, text: &str| (format, text.as_bytes().to_vec());
    let plan = json!({
        "format": "magician-plan", "version": 1, "title": "p", "tool": "pen",
        "steps": [
            {"move": [220, 0, -20, 0], "by": "line"},
            {"path": [220, 0, -61]},
            {"path": [240, 0, -75]},
            {"arc": [240, 10, -60, 0], "via": [245, 5, -70, 0]},
            {"shift": [0, 0, -30, 0], "by": "line"},
        ],
    });
    let svg = r#"<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="30mm" viewBox="0 0 40 30"
        fill="none" stroke="black"><path d="M0 0h40v30h-40z"/><circle cx="20" cy="15" r="5" stroke="red"/></svg>"#;
    let two = "G0 Z5\nG0 X205 Y5\nG1 Z-0.2 F900\nX235\nY25\nG0 Z5\nG0 X200 Y0\nG1 Z-3\nX240\nY30\nX200\nY0\nG0 Z5\n\
        G0 X220 Y10\nG1 Z-9\nG0 Z5\nG1 X222 Y12 Z2\nG1 X230 Z-4\nG2 X234 Y16 I4 J0\nG0 Z5\n";
    let deep = "G0 X220 Y0 Z-50\nG1 Z-62 F900\nX240\nG2 X240 Y20 J10\nG1 Z-90\nG0 Z-50\n";
    let playback = "<root><DobotType><item_0>Magician</item_0></DobotType><row_StudioVersion><item_0>Ver-194</item_0>\
        </row_StudioVersion><row0><item_0>2</item_0><item_1/><item_2>220</item_2><item_3>0</item_3><item_4>-70</item_4>\
        <item_5>0</item_5></row0></root>";
    vec![
        text(Format::Svg, svg),
        text(Format::Text, "ab"),
        text(Format::Gcode, two),
        text(Format::Gcode, deep),
        text(Format::Plan, &plan.to_string()),
        text(Format::Points, "x,y,z\n220,0,-40\n230,0,-66\n240,10,-66\n"),
        text(Format::Playback, playback),
    ]
}

/// Options by name, some of which lead down.
fn option() -> impl Strategy<Value = (&'static str, Value)> {
    let number = |from: i32, to: i32| (from..to).prop_map(|tenths| json!(f64::from(tenths) / 10.0));
    prop_oneof![
        number(-100, 100).prop_map(|z| ("pen_z", z)),
        number(-650, -500).prop_map(|z| ("surface", z)),
        (-200..200, -200..200, -300..100).prop_map(|(x, y, z)| {
            (
                "move",
                json!([x, y, z].map(|tenths| f64::from(tenths) / 10.0)),
            )
        }),
        number(2, 15).prop_map(|scale| ("scale", scale)),
        number(0, 3600).prop_map(|degrees| ("rotate", degrees)),
        number(5, 200).prop_map(|lift| ("lift", lift)),
        number(5, 100).prop_map(|hop| ("hop", hop)),
        Just(("at", json!([235, 5]))),
        Just(("fit", json!(true))),
        Just(("place", json!(true))),
        Just(("raw", json!(true))),
        Just(("mirror", json!(true))),
        Just(("dedupe", json!(true))),
        Just(("passes", json!(2))),
        Just(("grid", json!("2x2:9x-7"))),
        Just(("page", json!("a6"))),
        Just(("work", json!("draw"))),
        Just(("speed", json!(20))),
        Just(("frame", json!("box"))),
        Just(("depths", json!("flatten"))),
        Just((
            "pens",
            json!([{"match": 1, "surface_offset": 0.5, "lift": 2}])
        )),
        number(-900, 300).prop_map(|z| ("park", json!([230, 10, z]))),
    ]
}

struct Case {
    file: PrepareRequest,
    surface: Surface,
}

fn case(nth: usize, fields: &Map<String, Value>, tilted: bool) -> Option<Case> {
    let (format, bytes) = files().swap_remove(nth);
    let mut options = SetupOptions::from_fields(fields).ok()?;
    options.tool = Some(Tool::Pen);
    let mut defaults = SetupDefaults::default();
    let measured = if tilted {
        TILTED
    } else {
        Surface::level(-60.0)
    };
    defaults.sheet = tilted.then_some(Sheet {
        corner: [190.0, -60.0],
        rotation: 3.0,
        surface: measured,
        size: Some([120.0, 120.0]),
    });
    defaults.surface = Some(measured);
    let surface = options.surface.map_or(measured, Surface::level);
    let mut file = PrepareRequest::new(format, &bytes);
    (file.options, file.defaults) = (options, defaults);
    file.start = magician_program::StartPosition::At([200.0, 0.0, 30.0]);
    Some(Case { file, surface })
}

/// Lowest height above the surface of a program's targets, mm.
fn lowest(program: &Program, surface: Surface) -> f64 {
    let mut at: Option<[f64; 3]> = None;
    let mut lowest = f64::INFINITY;
    for command in program.plan().commands() {
        let (through, to): (Option<[f32; 4]>, [f32; 4]) = match command {
            Set::PtpCmd(ptp) => {
                let to = [ptp.x, ptp.y, ptp.z, ptp.r];
                match (ptp.ptp_mode, at) {
                    (PtpMode::MovlXyzInc | PtpMode::MovjXyzInc, Some([x, y, z])) => {
                        let from = [x, y, z, 0.0].map(|value| value as f32);
                        (None, [0, 1, 2, 3].map(|axis| from[axis] + to[axis]))
                    }
                    (PtpMode::MovlXyzInc | PtpMode::MovjXyzInc, None) => continue,
                    _ => (None, to),
                }
            }
            Set::CpCmd(cp) => (None, [cp.x, cp.y, cp.z, 0.0]),
            Set::ArcCmd(arc) => (Some(arc.cir_point), arc.to_point),
            _ => continue,
        };
        for [x, y, z, _] in through.into_iter().chain([to]) {
            let [x, y, z] = [x, y, z].map(f64::from);
            lowest = lowest.min(z - surface.at([x, y]));
        }
        let [x, y, z, _] = to.map(f64::from);
        at = Some([x, y, z]);
    }
    lowest
}

fn prepared_program(case: &Case) -> Option<(Program, Ending)> {
    match case.file.prepare() {
        Ok(Preparation::Done(laid)) if laid.misfit.is_none() => Some((laid.program, laid.ending)),
        _ => None,
    }
}

fn checked(program: &Program, ending: &Ending) -> Result<(), magician::Error> {
    let start = Preflight::at(JointAngles::HOME, ToolBias::PEN);
    ending.check(&program.remaining(0, start).expect("it has steps"))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn pen_never_goes_below_the_surface_with_any_options(
        nth in 0..7_usize,
        options in vec(option(), 0..6),
        tilted: bool,
    ) {
        let fields = options.into_iter().map(|(key, value)| (key.to_owned(), value));
        let Some(case) = case(nth, &fields.collect(), tilted) else {
            return Ok(());
        };
        let Some((program, ending)) = prepared_program(&case) else {
            return Ok(());
        };
        let lowest = lowest(&program, case.surface);
        prop_assert!(lowest > -2e-3, "{lowest}: {:?}", program.plan().steps);
        if let Some([x, y, z]) = ending.park {
            let surface = program.plan().surface.filter(|_| ending.draws(program.plan()));
            let below = surface.is_some_and(|surface| z < surface.at([x, y]) - 0.02);
            prop_assert!(!below || checked(&program, &ending).is_err(), "parked at {z}");
        }
    }
}

#[test]
fn kept_depths_take_the_pen_below_the_surface() {
    for (nth, fields) in [
        (0, json!({"move": [0, 0, -5]})),
        (2, json!({"place": true})),
        (2, json!({"pen_z": -0.2, "place": true})),
        (3, json!({"raw": true})),
        (4, json!({"raw": true})),
        (4, json!({"place": true, "surface": -55})),
        (6, json!({"raw": true})),
    ] {
        let mut fields = fields.as_object().unwrap().clone();
        let case = |fields: &Map<String, Value>| {
            let case = case(nth, fields, false).unwrap();
            let (program, _) =
                prepared_program(&case).unwrap_or_else(|| panic!("{nth} {fields:?}"));
            lowest(&program, case.surface)
        };
        assert!(case(&fields) > -2e-3, "{nth} {fields:?}");
        fields.insert("depths".to_owned(), json!(Depths::Keep.name()));
        assert!(case(&fields) < -1.0, "{nth} {fields:?}: {}", case(&fields));
    }
}

#[test]
fn pen_is_not_parked_below_the_surface() {
    let fields = json!({"park": [230, 10, -75]});
    let case = |fields: &Value| case(0, fields.as_object().unwrap(), false).unwrap();
    let parked = |fields: &Value| {
        let (program, ending) = prepared_program(&case(fields)).unwrap();
        checked(&program, &ending)
    };
    let refused = parked(&fields).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "the tool cannot be parked at 230,10,-75: that is 15.0 mm below the surface"
    );
    assert!(parked(&json!({"park": [230, 10, -75], "depths": "keep"})).is_ok());
}
