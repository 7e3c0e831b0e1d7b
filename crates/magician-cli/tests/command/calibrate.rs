//! `magician calibrate`: results, how they are saved, and that drawings use them.

use std::path::PathBuf;
use std::process::Command;

use crate::magician::command;
use serde_json::Value;

/// Page with one line along its left and lower edges, from corner to corner.
const PAGE: &str = r#"<svg xmlns="http://www.w3.org/2000/svg" width="80mm" height="60mm" viewBox="0 0 80 60">
<path d="M0 0 L0 60 L80 60" fill="none" stroke="black"/></svg>"#;

/// Settings and files of one user.
struct Fixture {
    dir: tempfile::TempDir,
}

/// Result of a run.
#[derive(Debug)]
struct Outcome {
    status: i32,
    out: String,
    err: String,
}

impl Outcome {
    fn object(&self) -> Value {
        serde_json::from_str(&self.out).unwrap_or_else(|_| panic!("{}{}", self.out, self.err))
    }
}

impl Fixture {
    fn new() -> Self {
        let dir = tempfile::tempdir().expect("directory");
        Self { dir }
    }

    fn file(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.file(name)).unwrap_or_default()
    }

    fn command(&self) -> Command {
        let mut command = command();
        command
            .env("MAGICIAN_CONFIG", self.file("config.toml"))
            .env("XDG_STATE_HOME", self.dir.path())
            .current_dir(self.dir.path());
        command
    }

    fn run(&self, arguments: &[&str]) -> Outcome {
        let output = self.command().args(arguments).output().expect("it runs");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        Outcome {
            status: output.status.code().expect("not killed"),
            out: text(&output.stdout),
            err: text(&output.stderr),
        }
    }
}

#[test]
fn a_page_is_drawn_on_the_sheet_that_was_touched() {
    let fixture = Fixture::new();
    std::fs::write(fixture.file("page.svg"), PAGE).expect("written");
    let (corner, degrees) = ([200.0, -40.0], 12.0_f64);
    let (sin, cos) = degrees.to_radians().sin_cos();
    let surface = |x: f64, y: f64| -60.0 + 0.02 * (x - 200.0) - 0.01 * y;
    let at = |u: f64, v: f64| {
        let (x, y) = (corner[0] + u * cos - v * sin, corner[1] + u * sin + v * cos);
        [x, y, surface(x, y)]
    };
    let points = [at(0.0, 0.0), at(90.0, 0.0), at(0.0, 70.0)];
    let points = points.map(|[x, y, z]| format!("{x:.4},{y:.4},{z:.4}"));
    let [a, b, c] = &points;
    let ran = fixture.run(&["--json", "calibrate", "sheet", "--points", a, b, c, "--yes"]);
    let found = ran.object();
    let number = |value: &Value| value.as_f64().expect("a number");
    assert!(
        (number(&found["sheet"]["rotation"]) - degrees).abs() < 0.01,
        "{found}"
    );
    assert!((number(&found["tilt"]) - 1.28).abs() < 0.01, "{found}");
    assert_eq!(found["saved"], true);

    let drawn = ["draw", "page.svg", "--port", "sim", "--no-order"];
    let ran = fixture.run(&[&drawn[..], &["--picture", "left.svg"]].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    // Positions that the pen has drawn; y points down in a picture.
    let corners = [at(0.0, 60.0), at(0.0, 0.0), at(80.0, 0.0)];
    let wanted = corners.map(|[x, y, _]| [x, -y]);
    let left = ink(&fixture.text("left.svg"));
    assert_eq!(left.len(), 3, "{left:?}");
    for (left, wanted) in left.iter().zip(wanted) {
        let off = (left[0] - wanted[0]).hypot(left[1] - wanted[1]);
        assert!(off < 0.05, "{left:?} {wanted:?}");
    }
    // The picture contains the sheet; the arm's base only with `--whole`.
    let ran = fixture.run(&[&drawn[..], &["--picture", "whole.svg", "--whole"]].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    for (name, base) in [("left.svg", false), ("whole.svg", true)] {
        let picture = fixture.text(name);
        assert!(picture.contains("class=\"sheet\""), "{picture}");
        assert_eq!(picture.contains("<circle"), base, "{picture}");
    }
    let ran = fixture.run(&["draw", "page.svg", "--port", "sim", "--whole"]);
    assert_eq!(ran.status, 2, "{}", ran.err);

    // The tip follows the slope of the surface.
    let ran = fixture.run(&["convert", "page.svg", "page.plan.json", "--no-order"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let plan: Value = serde_json::from_str(&fixture.text("page.plan.json")).expect("JSON");
    let steps = plan["steps"].as_array().expect("steps");
    let ends = steps.iter().filter_map(|step| step["path"].as_array());
    let mut count = 0;
    for end in ends {
        let [x, y, z] = [0, 1, 2].map(|axis| number(&end[axis]));
        assert!((z - surface(x, y)).abs() < 0.01, "{end:?}");
        count += 1;
    }
    assert_eq!(count, 2);

    // A drawing larger than the sheet is refused.
    std::fs::write(fixture.file("wide.svg"), PAGE.replace("80mm", "99mm")).expect("written");
    let ran = fixture.run(&["draw", "wide.svg", "--port", "sim"]);
    assert_eq!(ran.status, 3);
    assert!(ran.err.contains("fits the sheet"), "{}", ran.err);
}

/// Returns the corners of the only line in a picture.
fn ink(picture: &str) -> Vec<[f64; 2]> {
    let mut lines = picture.lines().filter(|line| line.contains("#1a1a1a"));
    let line = lines.next_back().expect("a line");
    let path = line.split('"').nth(1).expect("its points");
    let mut points = Vec::new();
    for point in path.trim_start_matches('M').split('L') {
        let numbers: Vec<f64> = { point.split_whitespace() }
            .map(|number| number.parse().expect("a number"))
            .collect();
        points.push([numbers[0], numbers[1]]);
    }
    // A pen that is lowered leaves a dot first.
    points.dedup();
    points
}

#[test]
fn settings_keep_the_rest_of_the_file_as_it_was() {
    let fixture = Fixture::new();
    let mine = "# mine\n[draw]\nspeed = 50 # slow\n";
    std::fs::write(fixture.file("config.toml"), mine).expect("written");
    let points = [
        "--points",
        "150,-105,-61",
        "360.5,-101,-60",
        "146,191.6,-62",
    ];
    let sheet = [&["calibrate", "sheet"][..], &points].concat();

    // Without a terminal there is no question, and nothing is saved.
    let ran = fixture.run(&sheet);
    assert_eq!(ran.status, 0, "{}", ran.err);
    assert!(ran.out.contains("looks like A4, 0.5 mm off"), "{}", ran.out);
    assert!(ran.out.contains("not saved; --yes"), "{}", ran.out);
    assert_eq!(fixture.text("config.toml"), mine);

    // Saving again replaces the table under its header.
    for _ in 0..2 {
        let ran = fixture.run(&[&sheet[..], &["--yes"]].concat());
        assert_eq!(ran.status, 0, "{}", ran.err);
        let text = fixture.text("config.toml");
        assert!(text.starts_with(mine), "{text}");
        assert_eq!(text.matches("[sheet]").count(), 1, "{text}");
    }
    let beside = fixture.run(&["calibrate", "surface", "--height", "-60.5", "--yes"]);
    assert!(!beside.out.contains("use it as the height"), "{beside:?}");
    assert!(
        beside
            .out
            .contains("but the sheet's height takes precedence")
            && beside.out.contains("`magician calibrate forget sheet`"),
        "{beside:?}"
    );
    let known = fixture.run(&["--json", "calibrate", "show"]).object();
    assert_eq!(known["sheet"]["corner"], serde_json::json!([150.0, -105.0]));
    assert_eq!(known["surface"], -60.5);
    assert_eq!(known["tool"], Value::Null);

    assert!(
        fixture
            .run(&["calibrate", "forget", "sheet"])
            .out
            .contains("deleted: sheet")
    );
    let alone = fixture.run(&["calibrate", "surface", "--height", "-60.5", "--yes"]);
    assert!(alone.out.contains("use it as the height"), "{alone:?}");
    let ran = fixture.run(&["calibrate", "forget"]);
    assert_eq!(ran.out, "deleted: surface\n");
    assert_eq!(fixture.text("config.toml").trim_end(), mine.trim_end());
    assert_eq!(
        fixture.run(&["calibrate", "forget"]).out,
        "nothing was calibrated\n"
    );
}

#[test]
fn tool_is_computed_from_two_touches_and_set_on_the_arm() {
    let fixture = Fixture::new();
    let poses = ["--poses", "230,40,0", "236,40,180"];
    let tool = [&["--json", "calibrate", "tool"][..], &poses].concat();
    // The bias in force comes from the arm.
    let found = fixture
        .run(&[&tool[..], &["--port", "sim"]].concat())
        .object();
    assert_eq!(found["tool"], "62.7,0,0");
    assert_eq!(
        (&found["saved"], &found["told"]),
        (&Value::Bool(false), &Value::Bool(false))
    );
    // Or from `--tool`.
    let more = ["--tool", "pen", "--tell", "--port", "sim", "--yes"];
    let found = fixture.run(&[&tool[..], &more].concat()).object();
    assert_eq!(found["tool"], "64,0,0");
    assert_eq!(found["offset"], serde_json::json!([3.0, 0.0]));
    assert_eq!(
        (&found["saved"], &found["told"]),
        (&Value::Bool(true), &Value::Bool(true))
    );
    assert!(fixture.text("config.toml").contains("tool = \"64,0,0\""));
    assert_eq!(found["stale"], Value::Null);
    // Earlier calibrations used the other bias.
    fixture.run(&["calibrate", "surface", "--height", "-60.5", "--yes"]);
    let found = fixture.run(&[&tool[..], &more].concat()).object();
    assert_eq!(found["stale"], serde_json::json!(["surface"]));
}

#[test]
fn contradictory_points_are_refused_with_advice() {
    let fixture = Fixture::new();
    for (arguments, status, part) in [
        (
            &[
                "calibrate",
                "sheet",
                "--points",
                "200,0,-60",
                "200,80,-60",
                "280,0,-60",
            ][..],
            3,
            "lower left, lower right and upper left",
        ),
        (
            &["calibrate", "sheet", "--points", "1,2,3", "4,5,6"],
            2,
            "3 values",
        ),
        (
            &["calibrate", "sheet", "--points", "1,2", "4,5,6", "1,1,1"],
            2,
            "3 comma-separated numbers",
        ),
        (&["calibrate", "surface", "--height", "nan"], 3, ""),
        (
            &[
                "calibrate",
                "tool",
                "--poses",
                "1,2,3",
                "1,2,9",
                "--tool",
                "pen",
            ],
            3,
            "half a turn",
        ),
        (&["calibrate", "sheet"], 2, "--points"),
        (&["calibrate", "surface"], 2, "--height"),
        (&["calibrate", "forget", "everything"], 2, "sheet"),
    ] {
        let ran = fixture.run(arguments);
        assert_eq!(ran.status, status, "{arguments:?}: {}", ran.err);
        assert!(ran.err.contains(part), "{arguments:?}: {}", ran.err);
        assert_eq!(fixture.text("config.toml"), "");
    }
}

#[cfg(target_os = "linux")]
mod at_a_terminal {
    use super::*;
    use crate::magician::homed::mark_homed;
    use crate::magician::run;
    use crate::magician::served::Served;
    use crate::magician::terminal::Terminal;

    const UP: &str = "\x1b[A";
    const LEFT: &str = "\x1b[D";
    const BACKSPACE: &str = "\x7f";

    /// Runs the command at a homed arm.
    fn at(fixture: &Fixture, served: &Served, arguments: &[&str]) -> Terminal {
        mark_homed(fixture.command(), &served.endpoint("tcp"));
        let mut command = fixture.command();
        command
            .args(["--port", &served.endpoint("tcp")])
            .args(arguments);
        Terminal::running(command)
    }

    fn served() -> Served {
        let served = Served::start(&["--tcp", "127.0.0.1:0", "--speed", "1"], 1);
        let cleared = run(&["--port", &served.endpoint("tcp"), "alarms", "--clear"]);
        assert_eq!(cleared.status, 0, "{}", cleared.err);
        served
    }

    /// Types keys until a text is drawn completely; changing parts are drawn piecemeal.
    fn types(terminal: &mut Terminal, keys: &str, text: &str) {
        terminal.types(keys);
        terminal.until_drawn(text);
    }

    #[test]
    fn corners_are_touched_with_the_keys_of_the_pad() {
        let (fixture, served) = (Fixture::new(), served());
        let mut terminal = at(&fixture, &served, &["calibrate", "sheet"]);
        // Paper for the pen must not be touched with another tool.
        terminal.until("--tool pen sets it on the arm");
        assert_eq!(terminal.child.wait().expect("it ends").code(), Some(3));

        let mut terminal = at(&fixture, &served, &["calibrate", "sheet", "--tool", "pen"]);
        terminal.until_drawn("x 260.40");
        types(&mut terminal, "++", "step 50");
        types(&mut terminal, "\r", "1 lower left x 260.40");
        types(&mut terminal, "\r", "point 1 was taken here");
        types(&mut terminal, UP, "x 310.40");
        terminal.until_drawn("stands");
        types(&mut terminal, "\r", "2 lower right x 310.40");
        types(&mut terminal, BACKSPACE, "2 lower right next");
        types(&mut terminal, "\r", "2 lower right x 310.40");
        terminal.types("\x1b[B");
        terminal.until_drawn("x 260.40");
        terminal.until_drawn("stands");
        types(&mut terminal, LEFT, "y 50.00");
        terminal.until_drawn("stands");
        types(&mut terminal, "\r", "50.0 by 50.0 mm");
        terminal.types("\r");
        terminal.until("\x1b[?1049l");
        terminal.until("saved in");
        assert_eq!(terminal.child.wait().expect("it ends").code(), Some(0));
        let text = fixture.text("config.toml");
        assert!(
            text.contains("[sheet]\n") && text.contains("size = [50.0, 50.0]"),
            "{text}"
        );
    }

    #[test]
    fn leaving_saves_nothing() {
        let (fixture, served) = (Fixture::new(), served());
        let mut terminal = at(
            &fixture,
            &served,
            &["calibrate", "surface", "--tool", "pen"],
        );
        terminal.until_drawn("x 260.40");
        types(&mut terminal, "\r", "Enter save it");
        terminal.types("q");
        terminal.until("not saved");
        assert_eq!(terminal.child.wait().expect("it ends").code(), Some(0));
        assert_eq!(fixture.text("config.toml"), "");
    }

    #[test]
    fn points_from_flags_ask_before_saving() {
        let fixture = Fixture::new();
        let mut command = fixture.command();
        command.args(["calibrate", "surface", "--height", "-61"]);
        let mut terminal = Terminal::running(command);
        terminal.until("save it? y/n ");
        terminal.types("y\r");
        terminal.until("saved in");
        assert!(fixture.text("config.toml").contains("surface = -61"));
    }
}
