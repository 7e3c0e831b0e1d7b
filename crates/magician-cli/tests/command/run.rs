//! `run`, `draw`, `engrave`, `play` and `convert` on virtual arms in the process, and without an
//! arm.

use crate::magician::{Run, command, run, run_with, sample};
use serde_json::{Value, json};

/// Returns the value that a message names behind a flag.
fn said_after<T: std::str::FromStr>(flag: &str, text: &str) -> T {
    let rest = text.split_once(flag);
    let (_, rest) = rest.unwrap_or_else(|| panic!("{flag}: {text}"));
    let said = rest.split_whitespace().next().unwrap_or_default();
    let said = said.trim_end_matches([',', ';', '.']).parse();
    said.unwrap_or_else(|_| panic!("{flag}: {text}"))
}

/// Directory for output.
struct Fixture(tempfile::TempDir);

impl Fixture {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("directory"))
    }

    fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_str().expect("UTF-8").to_owned()
    }

    fn write(&self, name: &str, text: &str) -> String {
        std::fs::write(self.path(name), text).expect("written");
        self.path(name)
    }

    fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|_| panic!("no {name}"))
    }

    fn text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).expect("UTF-8")
    }
}

const SAMPLES: [&str; 11] = [
    "arc_movl_v1412.playback",
    "curves.svg",
    "engrave_gradient.png",
    "example_loop.blockly",
    "gripper_pick_v194.playback",
    "house.svg",
    "jump_suction_named_v170.playback",
    "laser_checker.gcode",
    "pen_outline.gcode",
    "star.plt",
    "suction_points_v194.playback",
];

/// Program whose later lines are far out of reach.
const FAR: &str = "G21 G90\nG0 X220 Y0 Z10\nG1 X230 F1200\nG1 X400\nG1 X230 Y10\n";

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

#[test]
fn every_sample_passes_the_check_without_an_arm_and_runs() {
    for name in SAMPLES {
        let file = sample(name);
        let check = run(&["run", &file, "--check", "--json"]);
        assert_eq!((check.status, check.err.as_str()), (0, ""), "{name}");
        let check = check.object();
        assert_eq!(
            (&check["ok"], &check["refused"]),
            (&json!(true), &json!(0)),
            "{name}"
        );
        let done = run(&["--port", "sim", "run", &file, "--json"]);
        assert_eq!(done.status, 0, "{name}: {done:?}");
        let done = done.objects().pop().expect("a report");
        assert_eq!(done["steps"], check["steps"], "{name}");
        assert_eq!(done["drawn_mm"], check["drawn_mm"], "{name}");
    }
}

#[test]
fn an_estimate_has_time_steps_lengths_and_bounds() {
    let estimate = run(&[
        "run",
        &sample("suction_points_v194.playback"),
        "--estimate",
        "--json",
    ]);
    let object = estimate.object();
    let keys: Vec<_> = object.as_object().expect("an object").keys().collect();
    assert_eq!(
        keys,
        ["seconds", "steps", "drawn_mm", "travel_mm", "travel_bounds"]
    );
    assert_eq!(object["steps"], 6);
    assert!(number(&object["seconds"]) > 5.0);
    assert_eq!(
        object["travel_bounds"]["x"].as_array().map(Vec::len),
        Some(2)
    );
    let text = run(&["run", &sample("suction_points_v194.playback"), "--estimate"]).out;
    assert!(
        text.contains("6 steps") && text.contains("travelled"),
        "{text}"
    );
    let thrice = run(&[
        "play",
        &sample("suction_points_v194.playback"),
        "--loops",
        "3",
        "--estimate",
        "--json",
    ]);
    assert_eq!(thrice.object()["steps"], 18);
    assert!(number(&thrice.object()["seconds"]) > 2.0 * number(&object["seconds"]));
    let ever = run(&[
        "play",
        &sample("suction_points_v194.playback"),
        "--loops",
        "0",
        "--estimate",
        "--json",
    ]);
    assert_eq!(
        (&ever.object()["steps"], &ever.object()["seconds"]),
        (&Value::Null, &Value::Null)
    );
}

#[test]
fn a_drawing_that_does_not_fit_fails_its_check() {
    let large = ["draw", &sample("house.svg"), "--scale", "20"];
    let check = run(&[&large[..], &["--check"]].concat());
    assert_eq!(check.status, 10, "{}", check.err);
    assert!(check.err.contains("--fit"), "{}", check.err);
    assert_eq!(run(&[&large[..], &["--estimate"]].concat()).status, 3);
}

#[test]
fn complaints_have_their_place_in_the_file() {
    let fixture = Fixture::new();
    let file = fixture.write("far.gcode", FAR);
    let check = run(&["run", &file, "--check"]);
    assert_eq!(check.status, 10);
    for part in [
        "far.gcode:4:1",
        "G1 X400",
        "^^^",
        "G1 X400 is 71 mm beyond the reach",
        "1 step is refused",
        "--scale",
    ] {
        assert!(check.err.contains(part), "{part}: {}", check.err);
    }
    let check = run(&["run", &file, "--check", "--json"]);
    assert_eq!(
        (check.status, &check.error()["kind"]),
        (10, &json!("check-failed"))
    );
    let object = check.object();
    assert_eq!(
        (&object["ok"], &object["refused"]),
        (&json!(false), &json!(1))
    );
    let complaint = &object["complaints"][0];
    assert_eq!(
        (&complaint["line"], &complaint["column"], &complaint["kind"]),
        (&json!(4), &json!(1), &json!("unreachable"))
    );
    assert!(number(&complaint["value"]) > number(&complaint["limit"]));
    assert_eq!(complaint["beyond"], 71.0);
    let scale = number(&object["would_fit"]["scale"]);
    let turn = number(&object["would_fit"]["rotate"]);
    let scaled = |turn: f64, scale: f64| {
        let (turn, scale) = (turn.to_string(), format!("{scale:.3}"));
        run(&[
            "run", &file, "--check", "--rotate", &turn, "--scale", &scale,
        ])
        .status
    };
    assert_eq!((turn, scaled(turn, scale)), (90.0, 0), "{object}");
    // In its orientation the hint names the largest scale.
    let straight: f64 = said_after("--scale ", &run(&["run", &file, "--check"]).err);
    assert!(straight < scale, "{straight} {scale}");
    let scaled = [straight, straight + 0.002].map(|scale| scaled(0.0, scale));
    assert_eq!(scaled, [0, 10], "{straight}");
    let refused = run(&["--port", "sim", "run", &file, "--json"]);
    assert_eq!((refused.status, refused.out.as_str()), (3, ""));
    assert_eq!(refused.error()["kind"], "unreachable");
    assert_eq!(refused.error()["limit"], 282.0);
}

#[test]
fn one_complaint_is_shown_or_ten_with_v_and_all_are_counted() {
    let fixture = Fixture::new();
    let far: String = (0..25).map(|y| format!("G1 X400 Y{y}\n")).collect();
    let file = fixture.write(
        "far.gcode",
        &format!("G21 G90 F1200\nG0 X220 Y0 Z10\n{far}"),
    );
    let check = run(&["run", &file, "--check"]);
    assert_eq!(check.err.matches("far.gcode:").count(), 1, "{}", check.err);
    assert!(check.err.contains("25 steps are refused"), "{}", check.err);
    assert!(check.err.contains("--place"), "{}", check.err);
    // A refused program has no duration.
    assert_eq!(check.out, "");
    let check = run(&["run", &file, "--check", "-v"]);
    assert_eq!(check.err.matches("far.gcode:").count(), 10, "{}", check.err);
}

#[test]
fn unknown_formats_are_refused() {
    let fixture = Fixture::new();
    let garbage = fixture.write("notes.txt", "Good morning\n");
    let unknown = run(&["run", &garbage, "--json"]);
    assert_eq!(
        (unknown.status, &unknown.error()["kind"]),
        (3, &json!("invalid-input"))
    );
    let missing = run(&["run", &fixture.path("nothing.svg"), "--json"]);
    assert_eq!(missing.status, 3);
    let svg = fixture.write(
        "broken.svg",
        "<svg xmlns='http://www.w3.org/2000/svg'>\n<path d='M0 0'\n</svg>\n",
    );
    let broken = run(&["run", &svg, "--check"]);
    assert_eq!(broken.status, 3);
    assert!(broken.err.contains("broken.svg:"), "{}", broken.err);
    let said = run(&["run", &garbage, "--format", "playback", "--json"]);
    assert_eq!(said.status, 3);
    assert_eq!(run(&["run", &garbage, "--format", "song"]).status, 2);
    let empty = fixture.write("empty.gcode", "; nothing\n");
    assert_eq!(run(&["run", &empty, "--check"]).status, 3);
    // The file is checked before an arm is searched.
    assert!(
        unknown.error()["message"]
            .as_str()
            .expect("text")
            .contains("notes.txt")
    );
}

#[test]
fn program_is_read_from_stdin() {
    let bytes = std::fs::read(sample("pen_outline.gcode")).expect("a sample");
    for arguments in [
        &["run", "-", "--estimate", "--json"][..],
        &["run", "-", "--format", "gcode", "--estimate", "--json"],
    ] {
        let piped = run_with(arguments, &bytes);
        assert_eq!(piped.status, 0, "{piped:?}");
        assert_eq!(piped.object()["steps"], 16);
    }
}

#[test]
fn check_writes_a_preview_and_run_writes_a_picture() {
    let fixture = Fixture::new();
    let file = sample("house.svg");
    let svg = run(&[
        "draw",
        &file,
        "--preview",
        &fixture.path("look.svg"),
        "--json",
    ]);
    assert_eq!(svg.object()["preview"], fixture.path("look.svg"));
    assert!(fixture.text("look.svg").starts_with("<svg"));
    assert_eq!(
        run(&[
            "draw",
            &file,
            "--preview",
            &fixture.path("look.png"),
            "--check"
        ])
        .status,
        0
    );
    assert!(fixture.read("look.png").starts_with(b"\x89PNG"));
    assert_eq!(
        run(&["draw", &file, "--preview", &fixture.path("look.bmp")]).status,
        2
    );
    for name in ["left.svg", "left.png"] {
        let done = run(&[
            "--port",
            "sim",
            "draw",
            &file,
            "--picture",
            &fixture.path(name),
        ]);
        assert_eq!(done.status, 0, "{done:?}");
        assert!(
            done.out
                .contains(&format!("picture: {}", fixture.path(name))),
            "{}",
            done.out
        );
    }
    assert!(fixture.text("left.svg").contains("<path"));
    // A preview of a refused program shows why, also for a drawing that does not fit.
    let far = fixture.write("far.gcode", FAR);
    for large in [
        &["run", far.as_str()][..],
        &["draw", file.as_str(), "--scale", "20"],
        &["draw", file.as_str(), "--at", "0,0"],
    ] {
        let preview = fixture.path("far.svg");
        let refused = run(&[large, &["--preview", &preview]].concat());
        assert_eq!(refused.status, 10, "{large:?} {}", refused.err);
        let picture = fixture.text("far.svg");
        assert!(picture.contains("class=\"unreachable\""), "{large:?}");
        assert!(picture.contains("out of reach"), "{large:?}");
        std::fs::remove_file(&preview).expect("it is there");
    }
}

#[test]
fn oversized_drawing_names_the_largest_fitting_scale() {
    let large = ["draw", &sample("house.svg"), "--scale", "9", "--check"];
    let refused = run(&[&large[..], &["--json"]].concat());
    assert_eq!(refused.status, 10);
    let object = refused.object();
    let would = &object["would_fit"];
    let (scale, rotate) = (number(&would["scale"]), number(&would["rotate"]));
    let at = |scale: f64| {
        let [scale, rotate] = [scale, rotate].map(|value| value.to_string());
        let asked = ["--scale", &scale, "--rotate", &rotate];
        run(&[&["draw", &sample("house.svg"), "--check"][..], &asked].concat()).status
    };
    assert_eq!(at(scale), 0, "{would}");
    assert_eq!(at(scale * 1.02), 10, "{would}");
    let complaints = object["complaints"].as_array().expect("a list");
    assert!(complaints.len() <= 10 && !complaints.is_empty());
    // Behind the base no size fits.
    let nowhere = run(&[
        "draw",
        &sample("house.svg"),
        "--at",
        "0,0",
        "--check",
        "--json",
    ]);
    assert_eq!(nowhere.object()["would_fit"], Value::Null);
}

#[test]
fn fitting_rotates_a_drawing_if_that_makes_it_larger() {
    let fixture = Fixture::new();
    let long = "<svg xmlns='http://www.w3.org/2000/svg' width='600mm' height='40mm' viewBox='0 0 600 40'><path d='M0 0H600V40H0Z' \
                stroke='#000' fill='none'/></svg>";
    let file = fixture.write("long.svg", long);
    let fit = |more: &[&str]| {
        let all = [&["draw", &file, "--fit", "--check", "--json"][..], more].concat();
        let done = run(&all);
        assert_eq!(done.status, 0, "{}", done.err);
        done.object()["placed"].clone()
    };
    let (turned, straight) = (fit(&[]), fit(&["--no-turn"]));
    assert_eq!(
        (&turned["turn"], &straight["turn"]),
        (&json!(90.0), &json!(0.0))
    );
    assert!(
        number(&turned["scale"]) > 1.02 * number(&straight["scale"]),
        "{turned} {straight}"
    );
    assert_eq!(turned["at"].as_array().map(Vec::len), Some(2));
    // The message contains flags that reproduce the placement.
    let said = ["--scale", "--rotate", "--at"].map(str::to_owned);
    let [scale, rotate, at] = said;
    let again = run(&[
        "draw",
        &file,
        "--check",
        &scale,
        &turned["scale"].to_string(),
        &rotate,
        "90",
        &at,
        &format!("{},{}", turned["at"][0], turned["at"][1]),
    ]);
    assert_eq!(again.status, 0, "{}", again.err);
}

#[test]
fn tiny_or_hour_long_drawings_are_noted() {
    let fixture = Fixture::new();
    let huge = "<svg xmlns='http://www.w3.org/2000/svg' width='9000mm' height='9000mm' viewBox='0 0 9 9'><path d='M0 0H9V9' \
                stroke='#000' fill='none'/></svg>";
    let file = fixture.write("huge.svg", huge);
    let check = run(&["draw", &file, "--fit", "--check"]);
    assert_eq!(check.status, 0);
    assert!(check.err.contains("very small"), "{}", check.err);
    let slow = "<svg xmlns='http://www.w3.org/2000/svg' width='90mm' height='90mm' viewBox='0 0 9 9'><path d='M0 0H9V9' \
                stroke='#000' fill='none'/></svg>";
    let file = fixture.write("slow.svg", slow);
    let check = run(&["draw", &file, "--speed", "0.01", "--check", "--json"]);
    let notes = check.object()["notes"].clone();
    let codes = notes.as_array().expect("notes").iter();
    assert!(
        codes.map(|note| &note["code"]).any(|code| code == "long"),
        "{notes}"
    );
}

#[test]
fn pen_lifted_by_m3_is_no_laser_with_the_flag() {
    let fixture = Fixture::new();
    let file = fixture.write("servo.gcode", "G0 X220 Y0 Z0\nM3 S90\nG1 X240\nM5\n");
    let names = |arguments: &[&str]| {
        let mut all = vec!["run", file.as_str(), "--dry-run", "--json"];
        all.extend(arguments);
        run(&all).out
    };
    assert!(names(&[]).contains("SetCPLECmd"));
    let pen = names(&["--dialect", "pen"]);
    assert!(pen.contains("SetCPCmd") && !pen.contains("Laser"), "{pen}");
    let servo = names(&["--dialect", "servo", "--surface", "-50"]);
    assert!(
        servo.contains("SetCPCmd") && servo.contains("-50"),
        "{servo}"
    );
    assert_eq!(run(&["run", &file, "--dialect", "axe"]).status, 2);
}

#[test]
fn a_dry_run_sends_nothing_and_can_show_every_command() {
    let file = sample("suction_points_v194.playback");
    let silent = run(&["run", &file, "--dry-run"]);
    assert_eq!((silent.status, silent.out.lines().count()), (0, 2));
    let shown = run(&["run", &file, "--dry-run", "-v"]);
    assert!(shown.out.contains("SetPTPCmd ptp_mode="), "{}", shown.out);
    let objects = run(&["run", &file, "--dry-run", "--speed-ratio", "30", "--json"]).objects();
    assert_eq!(objects.len(), 9, "ratio, tool, six steps and the figures");
    assert_eq!(objects[0]["command"], "SetPTPCommonParams");
    assert_eq!(objects[0]["params"]["velocity_ratio"], 30.0);
    assert_eq!(
        (&objects[0]["step"], &objects[2]["step"]),
        (&Value::Null, &json!(1))
    );
    assert_eq!(objects[8]["steps"], 6);
}

#[test]
fn program_can_start_at_any_step() {
    let file = sample("suction_points_v194.playback");
    let whole = run(&["--port", "sim", "run", &file, "--json"])
        .objects()
        .pop()
        .expect("a report");
    let part = run(&["--port", "sim", "run", &file, "--from", "4", "--json"]);
    assert_eq!(part.status, 0, "{part:?}");
    let part = part.objects().pop().expect("a report");
    assert_eq!(
        (&part["first_step"], &part["steps"]),
        (&json!(4), &json!(3))
    );
    assert_eq!(
        (&whole["first_step"], &whole["steps"]),
        (&json!(1), &json!(6))
    );
    let beyond = i64::MAX.unsigned_abs() + 1;
    for (from, loops) in [("7", "1"), ("0", "1"), (&*beyond.to_string(), "0")] {
        let way = ["--from", from, "--loops", loops];
        let refused = run(&[&["--port", "sim", "run", &file][..], &way].concat());
        assert_eq!(refused.status, 2, "{way:?} {refused:?}");
    }
    let second = run(&[
        "--port", "sim", "play", &file, "--loops", "2", "--from", "9", "--json",
    ]);
    let second = second.objects().pop().expect("a report");
    assert_eq!(
        (&second["first_step"], &second["steps"]),
        (&json!(9), &json!(4))
    );
}

#[test]
fn settings_are_restored_and_the_tool_persists() {
    let fixture = Fixture::new();
    let plan = fixture.write(
        "fast.gcode",
        "G21 G90\nG0 X220 Y0 Z10\nG1 X240 F1800\nG1 Y10\n",
    );
    let lines = format!(
        "get CPParams\nget PTPCommonParams\nrun {plan} --tool pen --speed 30 --speed-ratio 90\nget CPParams\n\
         get PTPCommonParams\nget EndEffectorParams\n"
    );
    let script = run_with(&["--port", "sim", "--json", "shell"], lines.as_bytes());
    assert_eq!(script.status, 0, "{script:?}");
    let answers = script.objects();
    let last = answers.len();
    assert_eq!(answers[0], answers[last - 3]);
    assert_eq!(answers[1], answers[last - 2]);
    assert_eq!(
        answers[last - 1],
        json!({"x_bias": 61.0, "y_bias": 0.0, "z_bias": 0.0})
    );
}

/// Circle of 3 mm as an icon, a CAD file, a plot and a laser file.
const SMALL_CIRCLES: [(&str, &str); 4] = [
    (
        "icon.svg",
        "<svg xmlns='http://www.w3.org/2000/svg' width='24' height='24' viewBox='0 0 24 24'>\
            <circle cx='12' cy='12' r='11' fill='none' stroke='black'/></svg>",
    ),
    (
        "circle.dxf",
        "0\nSECTION\n2\nENTITIES\n0\nCIRCLE\n10\n0\n20\n0\n40\n3\n0\nENDSEC\n0\nEOF\n",
    ),
    ("circle.plt", "IN;SP1;PA400,400;CI120;PU;SP0;"),
    (
        "circle.gcode",
        "G21 G90\nM3 S1000\nG0 X3 Y0\nG2 X3 Y0 I-3 J0 F1200\nM5\n",
    ),
];

#[test]
fn small_circles_made_large_are_round_with_every_verb() {
    let fixture = Fixture::new();
    let round = 80.0 * std::f64::consts::PI;
    for (name, text) in SMALL_CIRCLES {
        let file = fixture.write(name, text);
        for verb in ["draw", "engrave", "run"] {
            for more in [&[][..], &["--tolerance", "0.01"]] {
                let look = [verb, &file, "--width", "80", "--estimate", "--json"];
                let look = run(&[&look[..], &["--place"], more].concat());
                assert_eq!(look.status, 0, "{verb} {name}: {look:?}");
                let drawn = number(&look.object()["drawn_mm"]);
                // A polygon of twenty chords would be 1 mm shorter.
                assert!((drawn - round).abs() < 0.2, "{verb} {name}: {drawn}");
            }
        }
        let points = fixture.path("points.csv");
        assert_eq!(run(&["convert", &file, &points, "--width", "80"]).status, 0);
        let rows = fixture.text("points.csv").lines().count();
        assert!(rows > 60, "{name}: {rows} rows");
    }
}

#[test]
fn placing_moves_scales_turns_and_repeats() {
    let file = sample("pen_outline.gcode");
    let look = |more: &[&str]| {
        let answer = run(&[&["run", &file, "--estimate", "--json"], more].concat());
        assert_eq!(answer.status, 0, "{more:?}: {answer:?}");
        answer.object()
    };
    let plain = look(&[]);
    assert_eq!(look(&["--move", "0,0,5"])["drawn_mm"], plain["drawn_mm"]);
    let half = look(&["--scale", "0.5"]);
    let y = |answer: &Value| [0, 1].map(|end| number(&answer["bounds"]["y"][end]));
    let side = |answer: &Value| y(answer)[1] - y(answer)[0];
    assert!((side(&half) / side(&plain) - 0.5).abs() < 0.001, "{half}");
    assert_eq!(
        half["bounds"]["z"], plain["bounds"]["z"],
        "lifts and depths stay"
    );
    let mirrored = look(&["--mirror"]);
    assert_eq!(mirrored["drawn_mm"], plain["drawn_mm"]);
    assert_eq!(mirrored["bounds"]["y"], plain["bounds"]["y"]);
    let turned = look(&["--rotate", "90", "--at", "230,0"]);
    let straight = look(&["--at", "230,0"]);
    assert!((number(&turned["drawn_mm"]) - number(&straight["drawn_mm"])).abs() < 0.1);
    assert_eq!(look(&["--grid", "2x2:10x-10"])["steps"], 64);
    assert_eq!(look(&["--pallet", "1x2:10x0"])["steps"], 32);
    let far = run(&["run", &file, "--move", "200,0,0", "--check", "--json"]);
    assert_eq!(far.status, 10);
    for wrong in [
        &["--at", "1"][..],
        &["--move", "1,2"],
        &["--grid", "2x2"],
        &["--scale", "0"],
        &["--rotate", "x"],
        &["--loops", "-1"],
        &["--speed-ratio", "0"],
    ] {
        let all = [&["run", &file, "--check"], wrong].concat();
        assert_eq!(run(&all).status, 2, "{wrong:?}");
    }
}

#[test]
fn drawings_are_as_large_as_they_are_unless_they_are_made_to_fit() {
    let fixture = Fixture::new();
    let svg = "<svg xmlns='http://www.w3.org/2000/svg' width='400mm' height='400mm' viewBox='0 0 400 400'>\
               <rect id='frame' x='0' y='0' width='400' height='400' fill='none' stroke='black'/></svg>";
    let file = fixture.write("large.svg", svg);
    let large = run(&["draw", &file, "--check"]);
    assert_eq!(large.status, 10);
    assert!(large.err.contains("--fit"), "{}", large.err);
    let fitted = run(&["draw", &file, "--fit", "--check", "--json"]);
    assert_eq!(fitted.status, 0, "{fitted:?}");
    assert!(number(&fitted.object()["drawn_mm"]) < 1600.0);
    let quick = run(&[
        "draw",
        &sample("house.svg"),
        "--speed",
        "80",
        "--estimate",
        "--json",
    ])
    .object();
    let slow = run(&[
        "draw",
        &sample("house.svg"),
        "--speed",
        "10",
        "--estimate",
        "--json",
    ])
    .object();
    assert!(number(&quick["seconds"]) < number(&slow["seconds"]));
    let low = run(&[
        "draw",
        &sample("house.svg"),
        "--surface",
        "-40",
        "--lift",
        "5",
        "--estimate",
        "--json",
    ])
    .object();
    assert_eq!(low["bounds"]["z"][0], -40.0);
}

#[test]
fn images_are_engraved_or_outlined() {
    let file = sample("engrave_gradient.png");
    let wide = |more: &[&str]| {
        let answer = run(&[
            &["engrave", &file, "--width", "20", "--estimate", "--json"],
            more,
        ]
        .concat());
        assert_eq!(answer.status, 0, "{more:?}: {answer:?}");
        answer.object()
    };
    let usual = wide(&[]);
    assert!(number(&usual["drawn_mm"]) > 100.0);
    assert!(number(&wide(&["--spacing", "0.4"])["drawn_mm"]) < number(&usual["drawn_mm"]));
    assert!(number(&wide(&["--one-way"])["seconds"]) > number(&usual["seconds"]));
    assert!(number(&wide(&["--speed", "5"])["seconds"]) > number(&usual["seconds"]));
    for more in [
        &["--mode", "dither"][..],
        &["--mode", "threshold", "--threshold", "100"],
        &["--invert"],
        &["--power", "10..40"],
        &["--overscan", "3"],
        &["--gamma", "1.5"],
    ] {
        wide(more);
    }
    assert_eq!(run(&["engrave", &file, "--power", "120"]).status, 2);
    assert_eq!(
        run(&["engrave", &file, "--width", "5", "--height", "5"]).status,
        2
    );
    let outlines = run(&[
        "draw",
        &file,
        "--width",
        "40",
        "--threshold",
        "200",
        "--check",
        "--json",
    ]);
    assert_eq!(outlines.status, 0, "{outlines:?}");
    assert_eq!(
        run(&["engrave", &sample("house.svg"), "--power", "60", "--check"]).status,
        0
    );
}

#[test]
fn recordings_have_a_row_for_each_sample() {
    let fixture = Fixture::new();
    let file = sample("suction_points_v194.playback");
    for name in ["poses.csv", "poses.jsonl"] {
        let done = run(&[
            "--port",
            "sim",
            "run",
            &file,
            "--record",
            &fixture.path(name),
        ]);
        assert_eq!(done.status, 0, "{done:?}");
    }
    let csv = fixture.text("poses.csv");
    let mut rows = csv.lines();
    let head = "time,t,x,y,z,r,j1,j2,j3,j4,index,left_space,alarms,step";
    assert_eq!(rows.next(), Some(head));
    assert!(rows.clone().count() >= 2);
    assert!(rows.all(|row| row.split(',').count() == 14));
    // With units, and at twice the rate; both are programs of the same duration.
    let more = fixture.path("units.csv");
    let run_with_units = ["--port", "sim", "run", &file, "--record", &more];
    let done = run(&[&run_with_units[..], &["--rate", "40", "--units"]].concat());
    assert_eq!(done.status, 0, "{done:?}");
    let units = fixture.text("units.csv");
    assert_eq!(
        units.lines().nth(1),
        Some(",s,mm,mm,mm,deg,deg,deg,deg,deg,,,,")
    );
    let ratio = units.lines().count() as f64 / csv.lines().count() as f64;
    assert!((1.9..2.1).contains(&ratio), "{ratio}");
    let seconds = |name: &str| {
        let check = run(&["run", &fixture.path(name), "--check", "--json"]);
        assert_eq!(check.status, 0, "{check:?}");
        check.object()["seconds"].as_f64().expect("a number")
    };
    assert!((seconds("units.csv") - seconds("poses.csv")).abs() < 0.2);
    let last: Value =
        serde_json::from_str(fixture.text("poses.jsonl").lines().last().expect("a row"))
            .expect("JSON");
    assert_eq!(last["step"], 6);
    let wrong = run(&[
        "--port",
        "sim",
        "run",
        &file,
        "--record",
        &fixture.path("poses.txt"),
    ]);
    assert_eq!(wrong.status, 2);
}

#[test]
fn flags_that_make_no_sense_together() {
    let file = sample("house.svg");
    let fixture = Fixture::new();
    for arguments in [
        &["run", &file, "--check", "--resume"][..],
        &["run", &file, "--check", "--picture", "x.svg"],
        &["run", &file, "--estimate", "--record", "x.csv"],
        &["run", &file, "--from", "2", "--resume"],
        &[
            "--port",
            "tcp:127.0.0.1:1",
            "run",
            &file,
            "--surface",
            "-60",
            "--picture",
            "x.svg",
        ],
    ] {
        assert_eq!(run(arguments).status, 2, "{arguments:?}");
    }
    let _ = fixture;
}

#[test]
fn conversions_report_lost_content() {
    let fixture = Fixture::new();
    let convert = |from: &str, to: &str| run(&["convert", from, &fixture.path(to), "--json"]);
    let taught = sample("suction_points_v194.playback");
    for (to, lost) in [("a.plan.json", 0), ("a.playback", 0), ("a.csv", 1)] {
        let done = convert(&taught, to);
        assert_eq!(done.status, 0, "{to}: {done:?}");
        assert_eq!(done.object()["steps"], 6);
        assert_eq!(
            done.object()["lost"].as_array().map(Vec::len),
            Some(lost),
            "{to}"
        );
    }
    let figures = |file: &str| run(&["run", file, "--estimate", "--json"]).object();
    assert_eq!(figures(&fixture.path("a.plan.json")), figures(&taught));
    assert_eq!(figures(&fixture.path("a.playback")), figures(&taught));
    assert_eq!(fixture.text("a.csv").lines().count(), 7);
    assert_eq!(convert(&sample("house.svg"), "house.svg").status, 0);
    assert!(fixture.text("house.svg").contains("<path"));
    assert_eq!(convert(&sample("house.svg"), "house.png").status, 0);
    assert_eq!(convert(&taught, "a.svg").status, 3, "nothing is drawn");
    assert_eq!(
        convert(&sample("house.svg"), "house.playback").status,
        3,
        "it cannot say paths"
    );
    assert_eq!(convert(&taught, "a.doc").status, 2);
}

#[test]
fn the_tool_and_the_surface_come_from_the_settings() {
    let fixture = Fixture::new();
    let config = fixture.write(
        "config.toml",
        "tool = \"70,0,-10\"\nsurface = -30\n[draw]\nspeed = 10\nlift = 8\n",
    );
    let look = |more: &[&str]| {
        let mut command = command();
        command.env("MAGICIAN_CONFIG", &config);
        command
            .args(["draw", &sample("house.svg"), "--dry-run", "--json"])
            .args(more);
        let output = command.output().expect("it runs");
        assert!(output.status.success(), "{output:?}");
        let text = String::from_utf8(output.stdout).expect("UTF-8");
        let run = Run {
            status: 0,
            out: text,
            err: String::new(),
        };
        run.objects()
    };
    let objects = look(&[]);
    assert_eq!(
        objects[0]["params"],
        json!({"x_bias": 70.0, "y_bias": 0.0, "z_bias": -10.0})
    );
    assert_eq!(objects.last().expect("figures")["bounds"]["z"][0], -30.0);
    let speeds = |objects: &[Value]| {
        let cp = objects
            .iter()
            .find(|object| object["command"] == "SetCPParams");
        cp.expect("a speed")["params"]["junction_vel"].clone()
    };
    assert_eq!(speeds(&objects), 10.0);
    let objects = look(&["--tool", "pen", "--surface", "-50", "--speed", "25"]);
    assert_eq!(objects[0]["params"]["x_bias"], 61.0);
    assert_eq!(objects.last().expect("figures")["bounds"]["z"][0], -50.0);
    assert_eq!(speeds(&objects), 25.0);
}

/// Returns the commands of a dry run that have coordinates.
fn moves(arguments: &[&str]) -> Vec<Value> {
    let all = [arguments, &["--dry-run", "--json"]].concat();
    let mut objects = run(&all).objects();
    objects.retain(|object| object["params"]["x"].is_number());
    objects
}

#[test]
fn no_flag_takes_a_pen_below_the_calibrated_surface() {
    let fixture = Fixture::new();
    let two = "G0 Z5\nG0 X205 Y5\nG1 Z-0.2 F900\nX235\nG0 Z5\nG0 X200 Y0\nG1 Z-3\nX240\nG0 Z5\n";
    let two = fixture.write("two.nc", two);
    let raw = "G0 X220 Y0 Z-30\nG1 Z-62 F900\nX240\nG0 Z-30\n";
    let raw = fixture.write("raw.gcode", raw);
    let plan = fixture.write(
        "p.plan.json",
        "{\"format\":\"magician-plan\",\"version\":1,\"title\":\"p\",\"tool\":\"pen\",\"steps\":[\
            {\"move\":[220,0,-30,0],\"by\":\"line\"},{\"path\":[220,0,-70]},{\"path\":[240,0,-70]}]}",
    );
    let config = fixture.write("config.toml", "surface = -58\n");
    let lowest = |arguments: &[&str]| {
        let all = [&["--port", "sim"], arguments, &["--dry-run", "--json"]].concat();
        let answer = Run::of(command().env("MAGICIAN_CONFIG", &config).args(&all), b"");
        let heights = answer.objects().into_iter();
        let heights = heights.filter_map(|object| object["params"]["z"].as_f64());
        let lowest = heights.reduce(f64::min);
        lowest.unwrap_or_else(|| panic!("{arguments:?}: {answer:?}"))
    };
    let house = sample("house.svg");
    for arguments in [
        &["run", &two, "--place"][..],
        &["run", &two, "--pen-z", "-0.2", "--place"],
        &["draw", &two, "--pen-z", "2", "--move", "0,0,-9"],
        &["run", &raw],
        &["run", &raw, "--raw", "--move", "0,0,-9"],
        &["run", &plan],
        &["run", &plan, "--place", "--move", "0,0,-9"],
        &["play", &plan],
        &["draw", &house, "--move", "0,0,-9"],
        &["frame", &house, "--tool", "pen", "--move", "0,0,-99"],
    ] {
        let held = lowest(arguments);
        assert!(held >= -58.0001, "{arguments:?}: {held}");
    }
    for arguments in [
        &["run", &two, "--place", "--depths", "keep"][..],
        &["run", &raw, "--depths", "keep"],
        &["run", &plan, "--depths", "keep"],
        &["draw", &house, "--move", "0,0,-9", "--depths", "keep"],
    ] {
        assert!(lowest(arguments) < -60.0, "{arguments:?}");
    }
    let parked = ["--port", "sim", "draw", &house, "--park", "220,0,-80"];
    let refused = Run::of(command().env("MAGICIAN_CONFIG", &config).args(parked), b"");
    assert_eq!(refused.status, 3, "{refused:?}");
    assert!(
        refused.err.contains("22.0 mm below the surface"),
        "{refused:?}"
    );
}

#[test]
fn program_lifts_first_at_the_current_position() {
    let fixture = Fixture::new();
    let program = "G21 G90\nG0 Z50\nG0 X230 Y40\nG1 Z20 F1500\nG1 X240\nM2\n";
    let file = fixture.write("z.gcode", program);
    let told = moves(&["--port", "sim", "run", &file]);
    let place_of = |nth: usize| ["x", "y", "z"].map(|axis| number(&told[nth]["params"][axis]));
    let [first, second] = [place_of(0), place_of(1)];
    assert_eq!((first[2], second), (50.0, [230.0, 40.0, 50.0]));
    assert!(
        (first[0] - 230.0).abs() > 1.0 && (first[1] - 40.0).abs() > 1.0,
        "{first:?}"
    );
    // The program can start at any step after its first move, from any pose.
    let later = run(&["--port", "sim", "run", &file, "--from", "5", "--json"]);
    assert_eq!(later.status, 0, "{later:?}");
    let early = run(&["--port", "sim", "run", &file, "--from", "2", "--json"]);
    assert_eq!(early.status, 2, "{early:?}");
}

#[test]
fn relative_program_uses_the_current_position() {
    let fixture = Fixture::new();
    let file = fixture.write("rel.gcode", "G91\nG1 X20 F1500\nG1 Y20\nG1 Z-5\nG1 X-5\n");
    let record = fixture.path("rel.jsonl");
    let ran = run(&["--port", "sim", "run", &file, "--record", &record]);
    assert_eq!(ran.status, 0, "{ran:?}");
    let told = ran
        .err
        .split("tool's position, ")
        .nth(1)
        .expect("it says where");
    let told = told.split_whitespace().next().expect("a place");
    let told: Vec<f64> = told
        .split(',')
        .map(|at| at.parse().expect("a number"))
        .collect();
    let first = fixture.text("rel.jsonl");
    let mut lines = first
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).expect("JSON"));
    let first = lines.find(|line| line["x"].is_number()).expect("a reading");
    for (axis, told) in ["x", "y", "z"].into_iter().zip(told) {
        assert!(
            (number(&first[axis]) - told).abs() < 0.05,
            "{axis}: {first} {told}"
        );
    }
}

#[test]
fn placed_gcode_lies_on_the_surface_and_begins_at_its_own_zero() {
    let fixture = Fixture::new();
    let square = "G21 G90\nG1 X0 Y0 F1500\nG1 X60\nG1 Y60\nG1 X0\nG1 Y0\nG0 Z5\nG0 X0 Y0\n";
    let file = fixture.write("square.gcode", square);
    let look = |arguments: &[&str]| {
        let answer = run(&[
            &[arguments[0], &file, "--estimate", "--json"],
            &arguments[1..],
        ]
        .concat());
        assert_eq!(answer.status, 0, "{arguments:?}: {answer:?}");
        answer.object()
    };
    let ways: [&[&str]; 5] = [
        &["run", "--place", "--surface", "-50"],
        &["run", "--surface", "-50"],
        &["run", "--surface", "-50", "--at", "230,10"],
        &["run", "--surface", "-50", "--fit"],
        &["draw", "--surface", "-50"],
    ];
    for way in ways {
        let answer = look(way);
        assert!(
            (number(&answer["drawn_mm"]) - 240.0).abs() < 0.1,
            "{way:?}: {answer}"
        );
        assert!(
            (number(&answer["bounds"]["z"][0]) + 50.0).abs() < 1e-3,
            "{way:?}: {answer}"
        );
    }
    // The Z of the surface is that of the first drawing line, or the given one; deeper lines are
    // drawn on the surface.
    let deep = fixture.write(
        "deep.gcode",
        "G0 Z5\nG0 X0 Y0\nG1 Z-1 F900\nG1 X40\nG0 Z5\nG0 X0 Y20\nG1 Z0\nG1 X40\nG0 Z5\n",
    );
    for (more, least) in [
        (&[][..], -50.0),
        (&["--pen-z", "0"], -50.0),
        (&["--move", "0,0,-5"], -50.0),
        (&["--depths", "keep"], -51.0),
        (&["--pen-z", "0", "--depths", "keep"], -51.0),
    ] {
        let way = [
            &["run", &deep, "--estimate", "--json", "--surface", "-50"][..],
            more,
        ]
        .concat();
        let least_z = number(&run(&way).object()["bounds"]["z"][0]);
        assert!((least_z - least).abs() < 1e-3, "{more:?}: {least_z}");
    }
    // Unchanged (`--raw`) nothing is shifted, and a height that is neither is refused.
    let raw = run(&[
        "run",
        &deep,
        "--raw",
        "--estimate",
        "--json",
        "--move",
        "200,0,0",
    ]);
    assert_eq!(number(&raw.object()["bounds"]["z"][0]), -1.0, "{raw:?}");
    for flags in [
        &["--raw", "--place"][..],
        &["--raw", "--at", "230,0"],
        &["--raw", "--surface", "-50"],
        &["--raw", "--fit"],
    ] {
        assert_eq!(
            run(&[&["run", &deep, "--check"][..], flags].concat()).status,
            2,
            "{flags:?}"
        );
    }
    let drawing = sample("house.svg");
    assert_eq!(run(&["run", &drawing, "--raw", "--estimate"]).status, 3);
    assert_eq!(
        run(&["run", &drawing, "--pen-z", "1", "--estimate"]).status,
        3
    );
    assert_eq!(run(&["run", &deep, "--pen-z", "1", "--estimate"]).status, 3);
}

#[test]
fn a_feed_move_at_the_beginning_draws_nothing_from_where_the_arm_stands() {
    let fixture = Fixture::new();
    let text = "G21 G90\nG1 X200 Y-60 Z-40 F1500\nG1 X260\nG1 Y0\nG1 X200\nG1 Y-60\n";
    let file = fixture.write("feed.gcode", text);
    let ran = run(&["--port", "sim", "run", &file, "--json"]);
    assert_eq!(ran.status, 0, "{ran:?}");
    let done = ran.objects().pop().expect("a report");
    assert!((number(&done["drawn_mm"]) - 240.0).abs() < 0.1, "{done}");
    let said = run(&["run", &file, "--estimate"]);
    assert!(said.err.contains("begins with a feed move"), "{said:?}");
}

#[test]
fn notes_are_objects_with_json() {
    let fixture = Fixture::new();
    let svg = "<svg xmlns='http://www.w3.org/2000/svg' width='60mm' height='30mm' viewBox='0 0 60 30'>\n\
               <text id='label' x='5' y='15' font-size='8'>A中</text></svg>";
    let file = fixture.write("label.svg", svg);
    let look = ["--surface", "-40", "--json"];
    let note = json!({
        "code": "left-out",
        "text": "U+4E2D '中' is left out: the font Roboto does not have it (turn the text into paths in the \
                 program that it was drawn with)",
        "template": "U+{code} '{character}' is left out: the font {font} does not have it",
        "values": [
            {"name": "code", "text": "4E2D"},
            {"name": "character", "text": "中"},
            {"name": "font", "text": "Roboto"},
        ],
        "help": {"template": "turn the text into paths in the program that it was drawn with"},
        "line": 2,
        "element": "label",
    });
    let [check, estimate, ran] = ["--check", "--estimate", "--port=sim"].map(|how| {
        let done = run(&[&["run", &file, how], &look[..]].concat());
        assert_eq!(done.status, 0, "{done:?}");
        let last = done.objects().pop().expect("an answer");
        last["notes"][0].clone()
    });
    let out = fixture.path("label.csv");
    let made = run(&[&["convert", &file, &out], &look[..]].concat()).object();
    assert_eq!(
        [check, estimate, ran, made["notes"][0].clone()],
        [(); 4].map(|()| note.clone())
    );
}

/// Playback with rotations, drawings with arcs, and images: content that is made to fit can be run.
#[test]
fn fitted_content_passes_the_check() {
    // With another tool the pose after homing is unknown, so a Blockly program fails its check at
    // any place. All tools with all kinds of drawings: `tests/program/fit.rs` of magician-program.
    let fits = |name: &&str| !name.ends_with(".blockly");
    let tools = [
        ("pen", "-60", &[][..]),
        ("laser", "-60", &["--scale", "3"]),
        ("gripper", "0", &["--scale", "3", "--rotate", "30"]),
        ("suction", "-40", &["--scale", "3"]),
    ];
    let samples = SAMPLES.into_iter().filter(fits);
    for (name, (tool, surface, more)) in samples.zip(tools.into_iter().cycle()) {
        let file = sample(name);
        let fit = ["run", &file, "--fit", "--surface", surface, "--tool", tool];
        let checked = run(&[&fit[..], more, &["--check", "--json"]].concat());
        assert_eq!(checked.status, 0, "{name} {tool} {more:?}: {checked:?}");
    }
}

#[test]
fn recording_runs_with_its_original_duration() {
    let fixture = Fixture::new();
    let house = sample("house.svg");
    for name in ["way.csv", "way.mcap"] {
        let file = fixture.path(name);
        let drawn = run(&["--port", "sim", "draw", &house, "--record", &file, "--json"]);
        assert_eq!(drawn.status, 0, "{}", drawn.err);
        let objects = drawn.objects();
        let took = number(&objects.last().expect("a result")["seconds"]);
        let check = run(&["run", &file, "--check", "--json"]);
        assert_eq!(check.status, 0, "{}", check.err);
        let object = check.object();
        let takes = number(&object["seconds"]);
        assert!((takes - took).abs() < 0.02 * took, "{name}: {takes} {took}");
        let notes = object["notes"].as_array().expect("notes");
        assert_eq!(notes.len(), 1, "{notes:?}");
        let again = run(&["--port", "sim", "run", &file]);
        assert_eq!(again.status, 0, "{}", again.err);
    }
    // A truncated recording is run as far as it goes; an empty one is refused.
    let whole = std::fs::read(fixture.path("way.mcap")).expect("it is there");
    for share in [0.0, 0.01, 0.3, 0.9, 0.999] {
        let cut = fixture.path("cut.mcap");
        let end = (whole.len() as f64 * share) as usize;
        std::fs::write(&cut, &whole[..end]).expect("it is written");
        let check = run(&["run", &cut, "--check"]);
        assert!([0, 3].contains(&check.status), "{share} {}", check.err);
    }
}

/// The remedy in a refusal works.
#[test]
fn refusal_names_a_fitting_position_or_rotation() {
    let dir = tempfile::tempdir().expect("directory");
    let write = |name: &str, text: &str| {
        let path = dir.path().join(name);
        std::fs::write(&path, text).expect("written");
        path.to_str().expect("UTF-8").to_owned()
    };
    let svg = |width: u32, height: u32| {
        format!(
            "<svg xmlns='http://www.w3.org/2000/svg' width='{width}mm' height='{height}mm' viewBox='0 0 {width} {height}' \
             stroke='black' fill='none'><path d='M0 0H{width}V{height}H0Z'/></svg>"
        )
    };
    let small = write("small.svg", &svg(60, 40));
    let points = write(
        "points.csv",
        "x,y,z\n300,0,0\n360,0,0\n360,40,0\n300,40,0\n",
    );
    let steps = r#"{"format":"magician-plan","version":1,"title":"a","tool":"pen","steps":[
        {"move":[300,0,0,0],"by":"line"},{"path":[360,0,0]},{"path":[360,60,0]},{"path":[300,60,0]}]}"#;
    let plan = write("a.plan.json", steps);
    for base in [
        &["draw", &small, "--at", "330,0"][..],
        &["run", &points],
        &["run", &plan],
        &["run", &plan, "--at", "330,0"],
    ] {
        let refused = run(&[base, &["--check"]].concat());
        assert_eq!(refused.status, 10, "{base:?}: {refused:?}");
        let at = said_after::<String>("--at ", &refused.err);
        let asked = base
            .iter()
            .copied()
            .filter(|word| *word != "--at" && *word != "330,0");
        let passes: Vec<&str> = asked.chain(["--at", &at, "--check"]).collect();
        let passes = run(&passes);
        assert_eq!(passes.status, 0, "{base:?} {at}: {passes:?}");
    }
    // Wide, in a direction with room for a high drawing.
    let wide = write("wide.csv", "x,y,z\n130,0,0\n330,0,0\n");
    let refused = run(&["run", &wide, "--check"]);
    assert_eq!(refused.status, 10, "{refused:?}");
    let turn: String = said_after("--rotate ", &refused.err);
    let passes = run(&["run", &wide, "--rotate", &turn, "--check"]);
    assert_eq!(passes.status, 0, "{turn}: {passes:?}");
    let refused = run(&["run", &wide, "--check", "--json"]);
    let answer: Value =
        serde_json::from_str(refused.out.lines().next().unwrap_or_default()).expect("JSON");
    assert_eq!(answer["would_fit"]["rotate"], 90.0, "{answer}");
}

#[test]
fn remedies_name_flags_of_the_verb() {
    let dir = tempfile::tempdir().expect("a directory");
    let write = |name: &str, text: &str| {
        let path = dir.path().join(name);
        std::fs::write(&path, text).expect("written");
        path.to_str().expect("UTF-8").to_owned()
    };
    let far = write(
        "far.gcode",
        "G21 G90\nG0 X500 Y0 Z20\nG1 Z0 F3000\nG1 X530\n",
    );
    let refused = run(&["run", &far, "--port", "sim"]);
    assert_ne!(refused.status, 0, "{refused:?}");
    for flag in ["--place", "--fit"] {
        assert!(refused.err.contains(flag), "{refused:?}");
    }
    // Lines that are reordered.
    let lines: String = (0..6)
        .map(|nth| format!("<path d='M{} 1V9'/>", [1, 17, 3, 15, 5, 13][nth]))
        .collect();
    let apart = write(
        "apart.svg",
        &format!(
            "<svg xmlns='http://www.w3.org/2000/svg' width='20mm' height='20mm' \
                viewBox='0 0 20 20'><g fill='none' stroke='black'>{lines}</g></svg>"
        ),
    );
    for (words, takes) in [
        (&["draw", &apart][..], true),
        (&["engrave", &apart], false),
        (&["run", &apart, "--tool", "laser"], true),
    ] {
        let looked = run(&[words, &["--port", "sim", "--dry-run", "-v"]].concat());
        assert_eq!(looked.status, 0, "{looked:?}");
        assert!(looked.err.contains("drawn in another order"), "{looked:?}");
        assert_eq!(looked.err.contains("--no-order"), takes, "{looked:?}");
    }
}

#[test]
fn size_or_speed_that_no_arm_has_is_refused() {
    let dir = tempfile::tempdir().expect("a directory");
    let svg = dir.path().join("a.svg");
    let text = "<svg xmlns='http://www.w3.org/2000/svg' width='20mm' height='20mm' \
        viewBox='0 0 20 20'><path d='M2 5H18' fill='none' stroke='black'/></svg>";
    std::fs::write(&svg, text).expect("written");
    let svg = svg.to_str().expect("UTF-8");
    for (flag, value, told) in [
        ("--speed", "1e-9", "from 0.01 to 10000 mm/s"),
        ("--width", "1e300", "at most 10000 mm"),
    ] {
        let refused = run(&["draw", svg, "--port", "sim", flag, value]);
        assert!([2, 3].contains(&refused.status), "{refused:?}");
        assert!(refused.err.contains(told), "{refused:?}");
    }
}

/// A laser file has many steps per line, all refused for one reason.
#[test]
fn file_with_a_foreign_origin_is_refused_with_one_remedy() {
    let fixture = Fixture::new();
    let burns = "G21 G90\nM4\nG0 X10Y10\nG1 X60S200F1200\nG1 Y40\nG1 X10\nG1 Y10\nM5\n";
    let file = fixture.write("burns.gc", burns);
    let check = run(&["run", &file, "--check"]);
    assert_eq!(
        (check.status, check.out.as_str()),
        (10, ""),
        "{}",
        check.err
    );
    assert_eq!(check.err.matches("error:").count(), 1, "{}", check.err);
    for part in [
        "--place lays it in front of the arm",
        "`magician engrave FILE`",
    ] {
        assert!(check.err.contains(part), "{part}: {}", check.err);
    }
    let check = run(&["run", &file, "--check", "--json"]).object();
    let lines: Vec<_> = { check["complaints"].as_array() }
        .expect("complaints")
        .iter()
        .map(|complaint| complaint["line"].clone())
        .collect();
    assert_eq!(lines, [3, 4, 5, 6, 7].map(|line| json!(line)));
    assert_eq!(run(&["run", &file, "--check", "--place"]).status, 0);
    assert_eq!(run(&["engrave", &file, "--check"]).status, 0);
}

#[test]
fn unreachable_move_is_reported_with_its_position() {
    for (to, said) in [
        (
            ["0", "0", "0"],
            "x 0, y 0, z 0 is too close to the base of the arm; the nearest",
        ),
        (
            ["400", "0", "0"],
            "x 400, y 0, z 0 is out of reach; the nearest place in reach is x ",
        ),
        (
            ["20", "40", "50"],
            "x 20, y 40, z 50 is too close to the base of the arm",
        ),
    ] {
        let refused = run(&["--port", "sim", "move", to[0], to[1], to[2]]);
        assert_eq!(refused.status, 3);
        assert!(refused.err.contains(said), "{}", refused.err);
        assert!(!refused.err.contains("joint") && !refused.err.contains("SetPTPCmd"));
        let refused = run(&["--port", "sim", "move", to[0], to[1], to[2], "-v"]);
        let joints = ["joint 2 would be at", "from the shoulder"];
        assert!(
            joints.iter().any(|said| refused.err.contains(said)),
            "{}",
            refused.err
        );
    }
}

#[test]
fn line_order_is_noted_only_with_v_and_notes_name_the_file() {
    let logo = sample("logo.svg");
    let check = run(&["draw", &logo, "--check"]);
    assert!(
        !check.err.contains("drawn in another order"),
        "{}",
        check.err
    );
    let check = run(&["draw", &logo, "--check", "--scale", "0.05"]);
    assert!(
        check.err.contains("note: logo.svg: it becomes very small"),
        "{}",
        check.err
    );
    let check = run(&["draw", &logo, "--check", "--json"]).object();
    let notes = check["notes"].as_array().expect("notes");
    assert!(
        notes.iter().any(|note| note["code"] == "reordered"),
        "{notes:?}"
    );
}

#[test]
fn drawing_beside_the_front_of_a_real_arm_asks_for_confirmation() {
    let fixture = Fixture::new();
    let wide = "<svg xmlns='http://www.w3.org/2000/svg' width='240mm' height='20mm' viewBox='0 0 240 20'>\
        <rect width='240' height='20' fill='none' stroke='black'/></svg>";
    let file = fixture.write("wide.svg", wide);
    let draw = ["draw", &file, "--no-turn", "--surface", "-40"];
    let check = run(&[&draw[..], &["--check"]].concat());
    let note = "note: wide.svg: does not fit in front of the arm: lies at its ";
    assert!(
        check.status == 0 && check.err.contains(note),
        "{}",
        check.err
    );
    // A virtual arm in this process asks no question.
    let drawn = run(&[&["--port", "sim:max"], &draw[..]].concat());
    assert_eq!(drawn.status, 0, "{}", drawn.err);
    let served =
        crate::magician::served::Served::start(&["--tcp", "127.0.0.1:0", "--speed", "max"], 1);
    let endpoint = served.endpoint("tcp");
    let real = |more: &[&str]| {
        run(&[
            &["--port", &endpoint, "--json"],
            &draw[..],
            &["--unhomed"],
            more,
        ]
        .concat())
    };
    let asked = real(&[]);
    assert_eq!(
        (asked.status, &asked.error()["kind"]),
        (2, &json!("usage")),
        "{}",
        asked.err
    );
    let said = asked.error()["message"]
        .as_str()
        .unwrap_or_default()
        .to_owned();
    assert!(
        said.contains("does not fit in front of the arm and is placed at its "),
        "{said}"
    );
}

#[test]
fn error_of_an_empty_drawing_includes_its_notes() {
    let fixture = Fixture::new();
    let font = "<svg xmlns='http://www.w3.org/2000/svg'><defs><font horiz-adv-x='500'>\
        <font-face units-per-em='1000'/><glyph unicode='a' d='M0 0L500 500'/></font></defs></svg>";
    let file = fixture.write("letters.svg", font);
    let refused = run(&["draw", &file, "--check", "--json"]);
    assert_eq!(refused.status, 10, "{refused:?}");
    let notes = refused.error()["notes"].clone();
    let text = notes[0]["text"].as_str().unwrap_or_default();
    assert!(
        text.contains("is a font") && text.contains("--font FILE writes text with it"),
        "{notes}"
    );
    let solid = "0\nSECTION\n2\nENTITIES\n0\n3DSOLID\n0\nENDSEC\n0\nEOF\n";
    let file = fixture.write("solid.dxf", solid);
    let refused = run(&["draw", &file, "--check", "--json"]);
    let notes = refused.error()["notes"].to_string();
    assert!(notes.contains("3DSOLID is left out"), "{notes}");
}
