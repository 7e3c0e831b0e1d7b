//! Drawings on a virtual arm in another process, which counts as a real one.

use std::process::{Command, Output};

use serde_json::Value;

use super::command;
use super::homed::mark_homed;
use super::served::Served;

/// Height of the paper, mm.
pub(crate) const PAPER: f64 = -50.0;
/// Drawing of two long lines.
pub(crate) const SVG: &str = "<svg xmlns='http://www.w3.org/2000/svg' width='80mm' height='20mm' viewBox='0 0 80 20'>\
                   <path d='M2 5 L78 5 L2 15' fill='none' stroke='black'/></svg>";

/// Arm, and a directory with a drawing.
pub(crate) struct Fixture {
    pub(crate) dir: tempfile::TempDir,
    served: Served,
}

impl Fixture {
    pub(crate) fn new(speed: &str) -> Self {
        let endpoints = ["--tcp", "127.0.0.1:0", "--speed", speed];
        let fixture = Self {
            dir: tempfile::tempdir().expect("directory"),
            served: Served::start(&endpoints, 1),
        };
        fixture.write("line.svg", SVG);
        fixture
    }

    /// Creates a place whose arm counts as homed.
    pub(crate) fn homed(speed: &str) -> Self {
        let fixture = Self::new(speed);
        assert!(fixture.run(&["alarms", "--clear"]).status.success());
        let mut command = command();
        command.env("XDG_STATE_HOME", fixture.dir.path().join("state"));
        mark_homed(command, &fixture.served.endpoint("tcp"));
        fixture
    }

    pub(crate) fn write(&self, name: &str, text: &str) {
        std::fs::write(self.dir.path().join(name), text).expect("written");
    }

    /// Returns the port of the arm.
    pub(crate) fn endpoint(&self) -> String {
        self.served.endpoint("tcp")
    }

    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        self.command_at(&["--port", &self.endpoint()], arguments)
    }

    /// Returns a command that reaches the arm by other flags.
    fn command_at(&self, at: &[&str], arguments: &[&str]) -> Command {
        let mut command = command();
        command.args(at);
        command.args(arguments).current_dir(self.dir.path());
        command.env("XDG_STATE_HOME", self.dir.path().join("state"));
        command
    }

    /// Returns the command that draws two long lines slowly.
    pub(crate) fn draw(&self, more: &[&str]) -> Command {
        self.draw_at(&["--port", &self.endpoint()], more)
    }

    /// Returns the same with other flags to reach the arm.
    pub(crate) fn draw_at(&self, at: &[&str], more: &[&str]) -> Command {
        let draw = ["draw", "line.svg", "--surface", "-50", "--speed", "10"];
        self.command_at(at, &[&draw, more].concat())
    }

    /// Waits until the pen is on the paper and has moved this far along it, mm.
    pub(crate) fn until_drawn(&self, mm: f64) {
        let mut began = None;
        for _ in 0..10_000 {
            let pose = last(&self.run(&["pose"]));
            let [x, y, z] = ["x", "y", "z"].map(|axis| pose[axis].as_f64().expect("a number"));
            let down = z < PAPER + 0.1;
            let went = |(from_x, from_y): (f64, f64)| (x - from_x).hypot(y - from_y);
            // Barely moved counts as resting at the start.
            if down && began.is_some_and(|began| went(began) > mm) {
                return;
            }
            began = down.then_some(began.unwrap_or((x, y)));
        }
        panic!("the pen is never down");
    }

    /// Runs a command to its end, with `--json`.
    pub(crate) fn run(&self, arguments: &[&str]) -> Output {
        let output = self.command(arguments).arg("--json").output();
        output.expect("it runs")
    }

    /// Returns settings of the arm that a drawing changes.
    pub(crate) fn settings(&self) -> Vec<Value> {
        let names = [
            "CPParams",
            "PTPCommonParams",
            "PTPCoordinateParams",
            "PTPJointParams",
        ];
        let get = |name| last(&self.run(&["get", name]));
        names.map(get).to_vec()
    }

    /// Returns the number of files with settings to restore.
    pub(crate) fn unrestored(&self) -> usize {
        let folder = self.dir.path().join("state/magician/debts");
        std::fs::read_dir(folder).map_or(0, Iterator::count)
    }

    /// Returns the number of runs that can be resumed.
    pub(crate) fn journals(&self) -> usize {
        let folder = self.dir.path().join("state/magician/runs");
        std::fs::read_dir(folder).map_or(0, Iterator::count)
    }

    pub(crate) fn number(&self, verb: &str, name: &str) -> f64 {
        last(&self.run(&[verb]))[name].as_f64().expect("a number")
    }
}

/// Returns the last JSON object of a command's output.
pub(crate) fn last(output: &Output) -> Value {
    let text = String::from_utf8_lossy(&output.stdout);
    let last = text.lines().last().unwrap_or_default();
    serde_json::from_str(last).unwrap_or_else(|_| panic!("{output:?}"))
}
