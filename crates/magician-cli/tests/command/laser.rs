//! Laser of a real arm, which is any arm outside of the command's process: permission, and
//! switching off.
#![cfg(target_os = "linux")]

use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use crate::magician::homed::mark_homed;
use crate::magician::served::Served;
use crate::magician::terminal::Terminal;
use crate::magician::{Run, command, run, run_with};
use serde_json::{Value, json};

/// Arm behind a pseudo-terminal, with a second endpoint for observation.
struct Fixture {
    dir: tempfile::TempDir,
    served: Served,
}

impl Fixture {
    fn new() -> Self {
        Self::at_speed("1")
    }

    fn at_speed(speed: &str) -> Self {
        let dir = tempfile::tempdir().expect("directory");
        let path = dir.path().join("arm");
        let path = path.to_str().expect("UTF-8");
        let endpoints = ["--pty", path, "--tcp", "127.0.0.1:0", "--speed", speed];
        let fixture = Self {
            served: Served::start(&endpoints, 2),
            dir,
        };
        assert_eq!(fixture.run(&["alarms", "--clear"]).status, 0);
        mark_homed(command(), &fixture.port());
        fixture
    }

    fn port(&self) -> String {
        self.file("arm")
    }

    fn file(&self, name: &str) -> String {
        let path = self.dir.path().join(name);
        path.to_str().expect("UTF-8").to_owned()
    }

    fn at<'a>(&self, port: &'a str, arguments: &[&'a str]) -> Vec<&'a str> {
        [&["--port", port], arguments].concat()
    }

    fn run(&self, arguments: &[&str]) -> Run {
        run(&self.at(&self.port(), arguments))
    }

    /// Starts the command without a terminal.
    fn start(&self, arguments: &[&str], stdin: Stdio) -> Child {
        let child = command()
            .args(self.at(&self.port(), arguments))
            .stdin(stdin)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn();
        child.expect("the command starts")
    }

    /// Starts the command at a terminal.
    fn person(&self, arguments: &[&str]) -> Terminal {
        let mut command = command();
        command.args(self.at(&self.port(), arguments));
        Terminal::running(command)
    }

    fn look(&self, arguments: &[&str]) -> Value {
        let endpoint = self.served.endpoint("tcp");
        run(&[&["--port", &endpoint, "--json"], arguments].concat()).object()
    }

    fn burns(&self) -> bool {
        self.look(&["info"])["laser"] == json!(true)
    }

    fn waits_until(&self, burns: bool) {
        let deadline = Instant::now() + Duration::from_secs(60);
        while self.burns() != burns {
            assert!(Instant::now() < deadline, "burns: {}", !burns);
        }
    }

    /// Runs the command with a trace. Returns its result and the frames by which it wrote.
    fn traced(&self, arguments: &[&str], stdin: &[u8]) -> (Run, Vec<String>) {
        let trace = self.file("trace.pcapng");
        let port = self.port();
        let done = run_with(
            &[&["--port", &port, "--trace", &trace], arguments].concat(),
            stdin,
        );
        let written = if Path::new(&trace).exists() {
            written(&trace)
        } else {
            Vec::new()
        };
        let _ = std::fs::remove_file(trace);
        (done, written)
    }
}

/// Returns the frames of a trace by which the host wrote.
pub(crate) fn written(trace: &str) -> Vec<String> {
    let all = run(&["decode", trace, "--json"]).objects();
    let writes = all.iter().filter(|one| one["direction"] == "request");
    let writes = writes.filter(|one| one["write"] == true || one["queued"] == true);
    writes.map(|one| one["command"].to_string()).collect()
}

fn signal(signal: &str, process: u32) {
    let mut kill = Command::new("kill");
    let sent = kill.args([signal, &process.to_string()]).status();
    assert!(sent.is_ok_and(|status| status.success()));
}

/// Relay that can break the line to the arm.
struct Relay {
    port: String,
    lines: Arc<Mutex<Vec<TcpStream>>>,
}

impl Relay {
    fn to(fixture: &Fixture) -> Self {
        let endpoint = fixture.served.endpoint("tcp");
        let arm = endpoint
            .strip_prefix("tcp:")
            .expect("a TCP port")
            .to_owned();
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let port = format!("tcp:{}", listener.local_addr().expect("an address"));
        let lines = Arc::new(Mutex::new(Vec::new()));
        let opened = Arc::clone(&lines);
        std::thread::spawn(move || {
            for host in listener.incoming() {
                let host = host.expect("a connection");
                let arm = TcpStream::connect(&arm).expect("the arm");
                for (mut from, mut to) in [(&host, &arm), (&arm, &host)].map(clones) {
                    std::thread::spawn(move || std::io::copy(&mut from, &mut to));
                }
                opened.lock().expect("lines").push(host);
            }
        });
        Self { port, lines }
    }

    /// Returns the number of connections so far.
    fn count(&self) -> usize {
        self.lines.lock().expect("lines").len()
    }

    fn breaks(&self) {
        for line in &*self.lines.lock().expect("lines") {
            let _ = line.shutdown(Shutdown::Both);
        }
    }
}

fn clones((from, to): (&TcpStream, &TcpStream)) -> (TcpStream, TcpStream) {
    let clone = |line: &TcpStream| line.try_clone().expect("a clone");
    (clone(from), clone(to))
}

/// Writes a program that burns for a long time.
fn plan(dir: &Path, commands: &[&str]) -> PathBuf {
    let path = dir.join("job.gcode");
    let text = format!(
        "$30=1000\nG21 G90\nG0 X220 Y-30 Z0\n{}\nM5\nM2\n",
        commands.join("\n")
    );
    std::fs::write(&path, text).expect("written");
    path
}

const SLOW_LINE: [&str; 2] = ["M3 S200 F180", "G1 X220 Y30"];

/// Verbs that send single commands, with commands that burn.
const BURNING: [&[&str]; 12] = [
    &["laser", "on", "--for", "1"],
    &["laser", "on", "--keep-on"],
    &["set", "EndEffectorLaser", "enable_ctrl=1", "on=1"],
    &["enqueue", "EndEffectorLaser", "enable_ctrl=1", "on=1"],
    &[
        "enqueue",
        "CPLECmd",
        "cp_mode=1",
        "x=220",
        "y=0",
        "z=0",
        "velocity_or_power=5",
    ],
    &["set", "61", "enable_ctrl=1", "on=1"],
    &["set", "IODO", "address=4", "level=1"],
    &["enqueue", "IODO", "address=2", "level=1"],
    &[
        "set",
        "IOPWM",
        "address=4",
        "frequency=1000",
        "duty_cycle=10",
    ],
    &[
        "enqueue",
        "PTPPOCmd",
        "ptp_mode=1",
        "x=220",
        "y=0",
        "z=0",
        "r=0",
        "po=50:4:1",
    ],
    &["io", "set", "2", "on"],
    &["io", "pwm", "4", "1000", "20"],
];

#[test]
fn nothing_burns_on_a_real_arm_without_yes() {
    let fixture = Fixture::new();
    for arguments in BURNING {
        for json in [&[][..], &["--json"]] {
            let (done, written) = fixture.traced(&[arguments, json].concat(), b"y\n");
            assert_eq!(done.status, 2, "{arguments:?}: {done:?}");
            assert!(
                done.err.contains("laser of the arm"),
                "{arguments:?}: {done:?}"
            );
            assert_eq!(written, Vec::<String>::new(), "{arguments:?}");
        }
        // In a shell too.
        let line = arguments.join(" ");
        let (done, written) = fixture.traced(&["shell"], line.as_bytes());
        assert_eq!(
            (done.status, written.len()),
            (2, 0),
            "{arguments:?}: {done:?}"
        );
    }
    assert!(!fixture.burns());
    // Commands that cannot burn need no confirmation.
    for arguments in [
        &["laser", "off"][..],
        &["set", "EndEffectorLaser", "enable_ctrl=1", "on=0"],
        &["set", "IODO", "address=4", "level=0"],
        &["set", "IODO", "address=3", "level=1"],
        &[
            "set",
            "IOPWM",
            "address=6",
            "frequency=1000",
            "duty_cycle=10",
        ],
    ] {
        let done = fixture.run(arguments);
        assert_eq!(done.status, 0, "{arguments:?}: {done:?}");
    }
    // A virtual arm in the process needs none.
    for arguments in BURNING {
        let line = arguments.join(" ");
        // A pin is driven according to its function.
        let lines = format!("io mux 2 digital-output\nio mux 4 pwm\n{line}\n");
        let done = run_with(&["--port", "sim", "shell"], lines.as_bytes());
        assert_eq!(done.status, 0, "{arguments:?}: {done:?}");
    }
}

#[test]
fn burning_file_needs_yes_on_stdin_and_with_json() {
    let fixture = Fixture::new();
    let file = plan(fixture.dir.path(), &SLOW_LINE);
    let file = file.to_str().expect("UTF-8");
    let text = std::fs::read(file).expect("read");
    let (done, written) = fixture.traced(&["run", file], b"y\n");
    assert_eq!((done.status, written.len()), (2, 0), "{done:?}");
    let (done, written) = fixture.traced(&["run", "-", "--format", "gcode"], &text);
    assert_eq!((done.status, written.len()), (2, 0), "{done:?}");
    let mut terminal = fixture.person(&["run", file, "--json"]);
    terminal.until("\"usage\"");
    assert_eq!(terminal.child.wait().expect("it ends").code(), Some(2));
}

#[test]
fn arm_without_a_laser_drives_its_pins_freely() {
    let fixture = Fixture::new();
    let config = fixture.file("config.toml");
    let port = fixture.port();
    let text = format!("[arms.white]\nport = '{port}'\nlaser = false\n");
    std::fs::write(&config, text).expect("written");
    let with = |arguments: &[&str]| {
        let mut command = command();
        command
            .env("MAGICIAN_CONFIG", &config)
            .args(["--port", &port]);
        command
            .args(arguments)
            .stdin(Stdio::null())
            .output()
            .expect("it runs")
            .status
            .code()
    };
    assert_eq!(with(&["io", "mux", "4", "digital-output"]), Some(0));
    assert_eq!(with(&["io", "set", "4", "on"]), Some(0));
    assert_eq!(
        with(&["set", "EndEffectorLaser", "enable_ctrl=1", "on=1"]),
        Some(2)
    );
}

#[test]
fn user_at_the_terminal_is_asked_on_stderr() {
    let fixture = Fixture::new();
    for (answer, status) in [("n\n", 2), ("\n", 2), ("yes\n", 0), ("Y\n", 0)] {
        let mut terminal = fixture.person(&["laser", "on", "--for", "0.2"]);
        terminal.until("y/n ");
        assert!(!fixture.burns());
        terminal.types(answer);
        let ended = terminal.child.wait().expect("it ends");
        assert_eq!(ended.code(), Some(status), "{answer:?}");
        assert!(!fixture.burns());
    }
}

#[test]
fn laser_burns_until_ctrl_c_end_of_input_or_time_limit() {
    let fixture = Fixture::new();
    let needs = fixture.run(&["laser", "on", "--yes"]);
    assert_eq!(needs.status, 2, "{needs:?}");
    assert!(needs.err.contains("--keep-on"), "{needs:?}");
    // Ctrl-C and Ctrl-D at the terminal.
    for key in ["\x03", "\x04"] {
        let mut terminal = fixture.person(&["laser", "on", "--yes"]);
        terminal.until("laser: on");
        fixture.waits_until(true);
        if key == "\x03" {
            signal("-INT", terminal.child.id());
        } else {
            terminal.types(key);
        }
        assert_eq!(
            terminal.child.wait().expect("it ends").code(),
            Some(0),
            "{key:?}"
        );
        assert!(!fixture.burns(), "{key:?}");
    }
    // Signals.
    for name in ["-INT", "-TERM", "-HUP"] {
        let mut child = fixture.start(&["laser", "on", "--for", "600", "--yes"], Stdio::null());
        fixture.waits_until(true);
        signal(name, child.id());
        assert_eq!(child.wait().expect("it ends").code(), Some(0), "{name}");
        assert!(!fixture.burns(), "{name}");
    }
    // The time limit.
    let done = fixture.run(&["laser", "on", "--for", "0.1", "--yes", "--json"]);
    assert_eq!(done.status, 0, "{done:?}");
    assert_eq!(
        done.objects(),
        [json!({"state": "on"}), json!({"state": "off"})]
    );
    assert!(!fixture.burns());
    // And `--keep-on`, which leaves it on.
    assert_eq!(
        fixture.run(&["laser", "on", "--keep-on", "--yes"]).status,
        0
    );
    assert!(fixture.burns());
    assert_eq!(fixture.run(&["laser", "off"]).status, 0);
    assert!(!fixture.burns());
}

#[test]
fn laser_in_a_shell_burns_until_laser_off_or_the_end() {
    let fixture = Fixture::new();
    let script = b"laser on\nget EndEffectorLaser\nlaser off\nget EndEffectorLaser\nlaser on\n";
    let port = fixture.port();
    let done = run_with(&["--port", &port, "--yes", "--json", "shell"], script);
    assert_eq!(done.status, 0, "{done:?}");
    let seen: Vec<_> = done
        .objects()
        .iter()
        .filter_map(|one| one["is_on"].as_u64())
        .collect();
    assert_eq!(seen, [1, 0]);
    assert!(!fixture.burns());
    let lit = run_with(
        &["--port", &port, "--yes", "shell"],
        b"set EndEffectorLaser enable_ctrl=1 on=1\n",
    );
    assert_eq!(lit.status, 0, "{lit:?}");
    assert!(!fixture.burns());
}

#[test]
fn lit_laser_is_shown_and_blocks_motion_except_homing() {
    let fixture = Fixture::at_speed("max");
    let file = plan(fixture.dir.path(), &["G1 X230 F600"]);
    let file = file.to_str().expect("UTF-8");
    for pins in [false, true] {
        let lit = if pins {
            assert_eq!(fixture.run(&["io", "mux", "4", "digital-output"]).status, 0);
            fixture.run(&["io", "set", "4", "on", "--yes"])
        } else {
            fixture.run(&["laser", "on", "--keep-on", "--yes"])
        };
        assert_eq!(lit.status, 0, "{lit:?}");
        let info = fixture.run(&["info"]);
        assert!(
            info.out
                .lines()
                .any(|line| line.starts_with("laser") && line.ends_with("  ON")),
            "{info:?}"
        );
        for arguments in [
            &["move", "220", "10", "30"][..],
            &["move", "220", "10", "30", "--linear", "--yes"],
            &["jog", "x", "1"],
            &["run", file],
            &["run", file, "--yes"],
            &["set", "PTPCmd", "ptp_mode=1", "x=220", "y=0", "z=30", "r=0"],
            &[
                "enqueue",
                "PTPCmd",
                "ptp_mode=1",
                "x=220",
                "y=0",
                "z=30",
                "r=0",
                "--start",
            ],
            &["queue", "start"],
        ] {
            let (done, written) = fixture.traced(arguments, b"");
            assert_eq!(done.status, 3, "{arguments:?}: {done:?}");
            assert!(
                done.err.contains("magician laser off"),
                "{arguments:?}: {done:?}"
            );
            assert_eq!(written, Vec::<String>::new(), "{arguments:?}");
        }
        let (done, written) = fixture.traced(&["home"], b"");
        assert_eq!(done.status, 0, "{done:?}");
        let at = |name: &str| written.iter().position(|one| one.contains(name));
        assert!(
            at("EndEffectorLaser").is_some() && at("EndEffectorLaser") < at("HOMECmd"),
            "{written:?}"
        );
        assert!(!fixture.burns());
        assert_eq!(fixture.run(&["move", "220", "10", "30"]).status, 0);
    }
    let mut watch = fixture.start(&["watch", "--json"], Stdio::null());
    let mut line = String::new();
    let mut lines = std::io::BufReader::new(watch.stdout.take().expect("stdout"));
    std::io::BufRead::read_line(&mut lines, &mut line).expect("a line");
    let seen: Value = serde_json::from_str(&line).expect("an object");
    assert_eq!(
        (&seen["laser"], &seen["suction"], &seen["gripper"]),
        (&json!(false), &json!(false), &json!("off"))
    );
    signal("-INT", watch.id());
    let _ = watch.wait();
}

#[test]
fn queue_of_another_program_needs_yes() {
    let fixture = Fixture::at_speed("max");
    let wait = ["enqueue", "WAITCmd", "timeout=1"];
    for arguments in [
        &["queue", "start"][..],
        &["alarms", "--clear"],
        &["enqueue", "WAITCmd", "timeout=1", "--start"],
        &["set", "QueuedCmdStartExec"],
        &["set", "AlarmsState"],
        &["home", "--keep"],
        &["move", "220", "0", "30", "--keep"],
    ] {
        assert_eq!(fixture.run(&["queue", "stop"]).status, 0);
        assert_eq!(fixture.run(&wait).status, 0);
        let (done, written) = fixture.traced(arguments, b"y\n");
        assert_eq!(done.status, 2, "{arguments:?}: {done:?}");
        assert_eq!(written, Vec::<String>::new(), "{arguments:?}");
    }
    assert_eq!(fixture.run(&["queue", "start", "--yes"]).status, 0);
    // Without commands of other programs in the queue there is no question.
    assert_eq!(fixture.run(&["stop"]).status, 0);
    assert_eq!(fixture.run(&["queue", "start"]).status, 0);
    assert_eq!(fixture.run(&["alarms", "--clear"]).status, 0);
}

#[test]
fn every_signal_switches_the_laser_of_a_job_off() {
    for name in ["-INT", "-TERM", "-HUP"] {
        let fixture = Fixture::new();
        let file = plan(fixture.dir.path(), &SLOW_LINE);
        let file = file.to_str().expect("UTF-8");
        let trace = fixture.file("job.pcapng");
        let mut child = fixture.start(&["run", file, "--yes", "--trace", &trace], Stdio::null());
        // On the way to the line, and along it: 60 mm at 3 mm/s.
        for along in [-30.5..-29.5, -28.0..29.0] {
            let deadline = Instant::now() + Duration::from_secs(60);
            let y = || fixture.look(&["pose"])["y"].as_f64().expect("a number");
            while !along.contains(&y()) {
                let runs = child.try_wait().expect("a child").is_none();
                assert!(runs && Instant::now() < deadline, "{name}");
            }
        }
        signal(name, child.id());
        let ended = child.wait_with_output().expect("it ends");
        assert_eq!(ended.status.code(), Some(130), "{name}: {ended:?}");
        let sent = written(&trace);
        // Followed by the end of the queue and the motors.
        let last: Vec<_> = sent.iter().rev().take(6).collect();
        assert!(
            last.iter().any(|one| one.contains("EndEffectorLaser")),
            "{name}: {sent:?}"
        );
        // At most the current piece and the next one were ever in the arm.
        let pieces = sent.iter().filter(|one| one.contains("CPLECmd")).count();
        assert!((1..15).contains(&pieces), "{name}: {sent:?}");
        assert!(!fixture.burns(), "{name}");
        assert_eq!(fixture.look(&["queue"])["left_space"], 32, "{name}");
    }
}

#[test]
fn burning_job_reconnects_a_broken_line_after_an_initial_read() {
    let fixture = Fixture::new();
    let file = fixture.file("relative.gcode");
    let text = "$30=1000\nG21 G91\nM3 S200 F180\nG1 X0 Y60\nM5\nM2\n";
    std::fs::write(&file, text).expect("written");
    let relay = Relay::to(&fixture);
    let mut job = command()
        .args(["--port", &relay.port, "run", &file, "--yes", "--unhomed"])
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command starts");
    let deadline = Instant::now() + Duration::from_secs(60);
    while fixture.look(&["pose"])["y"].as_f64().expect("a number") < 2.0 {
        assert!(Instant::now() < deadline, "it does not begin");
    }
    let before = relay.count();
    relay.breaks();
    while relay.count() == before {
        assert!(
            job.try_wait().expect("a child").is_none(),
            "it gives the line up"
        );
    }
    signal("-INT", job.id());
    job.wait().expect("it ends");
    assert!(!fixture.burns());
}

#[test]
fn terminated_shell_runs_no_further_lines() {
    let fixture = Fixture::new();
    let mut shell = fixture.start(&["--yes", "shell"], Stdio::piped());
    let mut lines = shell.stdin.take().expect("stdin");
    let script = b"laser on --for 600\npose\n";
    lines.write_all(script).expect("written");
    drop(lines);
    fixture.waits_until(true);
    signal("-TERM", shell.id());
    assert_eq!(shell.wait().expect("it ends").code(), Some(130));
    let mut said = String::new();
    let mut out = shell.stdout.take().expect("stdout");
    out.read_to_string(&mut said).expect("text");
    assert_eq!(said, "laser: on\nlaser: off\n");
}
