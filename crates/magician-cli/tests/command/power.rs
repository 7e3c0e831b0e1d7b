//! Power of a burn: the S of full power, `--power` with its default, and the reports on it.

use std::process::Command;

use crate::magician::{command, sample};
use serde_json::{Value, json};

const LIGHTBURN: &str = "; LightBurn 1.4.00\n; GRBL device profile, absolute coords\nG00 G17 G40 G21 G54\nG90\nM3\n; Cut @ 600 mm/min, 20% power\n\
                         M8\nG0 X220 Y0\n; Layer C00\nG1 X240S200F600\nM9\nG1 S0\nM5\nM2\n";

/// Directory with a settings file.
struct Fixture(tempfile::TempDir);

impl Fixture {
    fn new(settings: &str) -> Self {
        let fixture = Self(tempfile::tempdir().expect("directory"));
        fixture.write("config.toml", settings);
        fixture
    }

    fn write(&self, name: &str, text: &str) -> String {
        let path = self.0.path().join(name);
        std::fs::write(&path, text).expect("written");
        path.to_str().expect("UTF-8").to_owned()
    }

    /// Runs the command. Returns its status, the last line of stdout (else stderr) as JSON, and
    /// stderr.
    fn run(&self, arguments: &[&str]) -> (i32, Value, String) {
        let mut command: Command = command();
        let config = self.0.path().join("config.toml");
        let output = command
            .env("MAGICIAN_CONFIG", config)
            .args(arguments)
            .output();
        let output = output.expect("it runs");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let (out, err) = (text(&output.stdout), text(&output.stderr));
        let last = out.lines().chain(err.lines()).last().unwrap_or_default();
        let value = serde_json::from_str(last).unwrap_or(Value::Null);
        (output.status.code().expect("not killed"), value, err)
    }

    fn power(&self, arguments: &[&str]) -> Value {
        let (status, answer, err) = self.run(&[arguments, &["--json"]].concat());
        assert_eq!(status, 0, "{arguments:?}: {answer} {err}");
        answer["power"].clone()
    }
}

fn of(least: f64, most: f64) -> Value {
    json!({"most": most, "least": least})
}

#[test]
fn lightburn_job_at_20_percent_burns_at_20_percent() {
    let fixture = Fixture::new("");
    let file = fixture.write("job.gcode", LIGHTBURN);
    for look in [&["--check"][..], &["--estimate"], &["--port", "sim"]] {
        assert_eq!(
            fixture.power(&[&["run", &file], look].concat()),
            of(20.0, 20.0),
            "{look:?}"
        );
    }
    assert_eq!(
        fixture.power(&["run", &file, "--check", "--s-max", "400"]),
        of(50.0, 50.0)
    );
    let (_, answer, _) = fixture.run(&["run", &file, "--check", "--json"]);
    let notes = answer["notes"].as_array().expect("notes");
    let power = notes.iter().find(|note| note["code"] == "power");
    let (line, text) = power.map_or((0, ""), |note| {
        let (line, text) = (note["line"].as_u64(), note["text"].as_str());
        (line.unwrap_or_default(), text.unwrap_or_default())
    });
    assert_eq!(line, 6);
    assert!(
        text.starts_with("full power is S1000, by LightBurn's comments"),
        "{text}"
    );
    assert!(text.contains("--s-max"), "{text}");
    let (_, _, err) = fixture.run(&["run", &file, "--check"]);
    assert!(err.contains("full power is S1000"), "{err}");
    let beyond = fixture.write("beyond.gcode", "G0 X220 Y0\nM3 S2000\nG1 X240 F600\nM5\n");
    let (status, answer, _) = fixture.run(&["run", &beyond, "--check", "--json"]);
    assert_eq!(status, 3);
    assert!(answer.to_string().contains("S2000"), "{answer}");
    assert_eq!(answer["error"]["remedies"][0]["option"], "s_max");
    let (_, _, err) = fixture.run(&["run", &beyond, "--check"]);
    assert!(err.contains("--s-max"), "{err}");
    // A drawing does not burn, so no power is reported.
    assert_eq!(
        fixture.power(&["run", &sample("house.svg"), "--check"]),
        Value::Null
    );
    let (_, answer, _) = fixture.run(&[
        "run",
        &sample("house.svg"),
        "--check",
        "--power",
        "50",
        "--json",
    ]);
    assert!(
        answer["notes"].to_string().contains("nothing burns here"),
        "{answer}"
    );
}

#[test]
fn power_applies_to_every_source_and_default() {
    let fixture = Fixture::new("");
    let habit = Fixture::new("[engrave]\npower = 50\n");
    let range = Fixture::new("[engrave]\npower = \"10..50\"\n");
    let gcode = fixture.write("job.gcode", LIGHTBURN);
    let plan = fixture.write(
        "job.plan.json",
        r#"{"format":"magician-plan","version":1,"title":"a","steps":[{"move":[220,0,0,0],"by":"line"},{"burn":[230,0,0],"power":20},{"laser":false}]}"#,
    );
    let (image, drawing) = (sample("engrave_gradient.png"), sample("house.svg"));
    for verb in ["run", "engrave"] {
        for file in [&gcode, &plan] {
            assert_eq!(
                fixture.power(&[verb, file, "--check"]),
                of(20.0, 20.0),
                "{verb} {file}"
            );
            assert_eq!(
                fixture.power(&[verb, file, "--check", "--power", "50"]),
                of(10.0, 10.0),
                "{verb} {file}"
            );
            assert_eq!(
                fixture.power(&[verb, file, "--check", "--power", "10..50"]),
                of(18.0, 18.0)
            );
            assert_eq!(habit.power(&[verb, file, "--check"]), of(10.0, 10.0));
            assert_eq!(range.power(&[verb, file, "--check"]), of(18.0, 18.0));
            assert_eq!(
                habit.power(&[verb, file, "--check", "--power", "100"]),
                of(20.0, 20.0)
            );
        }
        for (given, more) in [(&fixture, &["--power", "10..50"][..]), (&range, &[])] {
            let power = given.power(&[&[verb, &image, "--check"], more].concat());
            assert!(
                power["least"].as_f64() >= Some(10.0) && power["most"].as_f64() <= Some(50.0),
                "{power}"
            );
        }
        let power = habit.power(&[verb, &image, "--check"]);
        assert!(
            power["most"].as_f64() > Some(35.0) && power["most"].as_f64() <= Some(50.0),
            "{power}"
        );
    }
    assert_eq!(
        fixture.power(&["engrave", &drawing, "--check"]),
        of(100.0, 100.0)
    );
    assert_eq!(
        fixture.power(&["engrave", &drawing, "--check", "--power", "10..50"]),
        of(50.0, 50.0)
    );
    assert_eq!(
        habit.power(&["engrave", &drawing, "--check"]),
        of(50.0, 50.0)
    );
    for wrong in ["0", "120", "50..10"] {
        assert_eq!(
            fixture.run(&["run", &gcode, "--power", wrong]).0,
            2,
            "{wrong}"
        );
    }
    // A converted file has its own power: the default is applied once, when it is run.
    let made = fixture.0.path().join("made.plan.json");
    let made = made.to_str().expect("UTF-8");
    assert_eq!(habit.run(&["convert", &gcode, made]).0, 0);
    assert_eq!(habit.power(&["run", made, "--check"]), of(10.0, 10.0));
}

#[test]
fn default_laser_speed_applies_to_files_without_speed() {
    let fixture = Fixture::new("[engrave]\nspeed = 5\n");
    let seconds = |fixture: &Fixture, file: &str| {
        let (status, answer, err) = fixture.run(&["run", file, "--estimate", "--json"]);
        assert_eq!(status, 0, "{err}");
        answer["seconds"].as_f64().expect("a number")
    };
    let usual = Fixture::new("");
    let silent = fixture.write("silent.gcode", "G0 X220 Y0\nM3 S500\nG1 X240\nM5\n");
    assert!(seconds(&fixture, &silent) > seconds(&usual, &silent) + 2.0);
    let image = sample("engrave_gradient.png");
    assert!(seconds(&fixture, &image) > 1.5 * seconds(&usual, &image));
    let said = fixture.write("said.gcode", "G0 X220 Y0\nM3 S500\nG1 X240 F600\nM5\n");
    assert!((seconds(&fixture, &said) - seconds(&usual, &said)).abs() < 1e-9);
}

#[test]
fn m4_burns_in_proportion_to_speed() {
    let fixture = Fixture::new("");
    let m4 = fixture.write("m4.gcode", "G0 X220 Y0\nM4 S500\nG1 X240 F1200\nM5\n");
    let power = fixture.power(&["run", &m4, "--check"]);
    let [least, most] = ["least", "most"].map(|name| power[name].as_f64().expect("a number"));
    assert!(least < 7.0 && most > 49.0 && most <= 50.0, "{power}");
    let (_, _, err) = fixture.run(&["run", &m4, "--check"]);
    assert!(!err.contains("never"), "{err}");
    // While the speed F is not reached, the power stays lower.
    let (_, answer, err) = fixture.run(&["run", &m4, "--check", "--json", "--speed", "10"]);
    assert!(
        answer["power"]["most"].as_f64() <= Some(25.0),
        "{answer} {err}"
    );
    assert!(
        answer["notes"].to_string().contains("never reaches F1200"),
        "{answer}"
    );
    // A range applies to everything that burns.
    assert_eq!(
        fixture.power(&["run", &m4, "--check", "--power", "40..40"]),
        of(40.0, 40.0)
    );
}
