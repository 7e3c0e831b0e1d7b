//! `magician serve` and `magician station` as other programs use them.
#![cfg(unix)]

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use magician_program::{Action, Origin, Plan, Travel};
use serde_json::{Value, json};

use crate::magician::drawing::{Fixture, PAPER, SVG};
use crate::magician::homed::mark_homed;
use crate::magician::served::Served;
use crate::magician::{command, run};

/// Station at a free port.
pub(crate) struct Station {
    pub(crate) served: Served,
    address: String,
}

impl Station {
    fn start(arguments: &[&str]) -> Self {
        Self::of(command(), arguments)
    }

    pub(crate) fn of(command: std::process::Command, arguments: &[&str]) -> Self {
        let listen = ["--listen", "127.0.0.1:0"];
        let served = Served::of(command, "serve", &[arguments, &listen].concat(), 1);
        let address = served
            .endpoint("http")
            .replace("http://", "http:")
            .replace("http:", "");
        let address = address.trim_matches('/').to_owned();
        Self { served, address }
    }

    /// Sends a request. Returns the status and the body of the answer.
    fn request(&self, method: &str, path: &str, headers: &str, body: &str) -> (u16, String) {
        let mut stream = TcpStream::connect(&self.address).expect("it listens");
        let length = body.len();
        write!(
            stream,
            "{method} {path} HTTP/1.1\r\nhost: {}\r\nconnection: close\r\ncontent-type: application/json\r\n\
             content-length: {length}\r\n{headers}\r\n{body}",
            self.address
        )
        .expect("it reads");
        let mut text = String::new();
        stream.read_to_string(&mut text).expect("an answer");
        let status = text
            .split(' ')
            .nth(1)
            .and_then(|status| status.parse().ok());
        let body = text.split_once("\r\n\r\n").map_or("", |(_, body)| body);
        (status.unwrap_or(0), body.to_owned())
    }

    pub(crate) fn call(&self, method: &str, params: &Value) -> Value {
        let body = json!({"jsonrpc": "2.0", "id": 1, "method": method, "params": params});
        let (status, text) = self.request("POST", "/api/v1/rpc", "", &body.to_string());
        assert_eq!(status, 200, "{text}");
        serde_json::from_str(&text).expect("JSON")
    }
}

/// Returns the state folder of this test.
fn state() -> PathBuf {
    let command = command();
    let mut variables = command.get_envs();
    let state = variables.find_map(|(name, value)| (name == "XDG_STATE_HOME").then_some(value));
    PathBuf::from(state.flatten().expect("it is set")).join("magician/station")
}

fn journal() -> Vec<Value> {
    let text = std::fs::read_to_string(state().join("journal.jsonl")).unwrap_or_default();
    text.lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect()
}

#[test]
fn address_in_use_names_its_station() {
    let state = tempfile::tempdir().expect("a directory");
    let with_state = || {
        let mut command = command();
        command.env("XDG_STATE_HOME", state.path());
        command
    };
    let station = Station::of(with_state(), &["--port", "sim"]);
    let url = format!("http://{}/", station.address);
    for verb in ["serve", "studio"] {
        let mut second = with_state();
        second.args([verb, "--port", "sim", "--listen", &station.address]);
        let refused = crate::magician::Run::of(&mut second, b"");
        assert_eq!(refused.status, 4, "{refused:?}");
        for told in ["a station of arm is running there", &url, "--listen"] {
            assert!(refused.err.contains(told), "{told}: {refused:?}");
        }
    }
    let other = std::net::TcpListener::bind("127.0.0.1:0").expect("an address");
    let address = other.local_addr().expect("known").to_string();
    let refused = run(&["serve", "--port", "sim", "--listen", &address]);
    assert_eq!(refused.status, 4, "{refused:?}");
    assert!(
        refused
            .err
            .contains("another program is using that address"),
        "{refused:?}"
    );
}

/// Verbs that open a port, each in its own way.
const OPENING: [&[&str]; 8] = [
    &["pose"],
    &["move", "220", "0", "40"],
    &["serve", "--listen", "127.0.0.1:0"],
    &["proxy", "--udp", "127.0.0.1:0"],
    &["conform", "--yes"],
    &["doctor"],
    &["bench", "--only", "h1", "--yes"],
    &["watch"],
];

#[test]
fn busy_port_names_its_station_at_every_verb_and_in_every_spelling() {
    let state = tempfile::tempdir().expect("a directory");
    let fixture = tempfile::tempdir().expect("a directory");
    let arm = fixture.path().join("arm");
    let _arm = Served::start(&["--pty", arm.to_str().expect("text"), "--speed", "max"], 1);
    let with_state = || {
        let mut command = command();
        command.env("XDG_STATE_HOME", state.path());
        command.current_dir(fixture.path());
        command
    };
    let station = Station::of(with_state(), &["--port", "./arm"]);
    let url = format!("http://{}/", station.address);
    std::os::unix::fs::symlink("arm", fixture.path().join("other")).expect("linked");
    let terminal = std::fs::canonicalize(&arm).expect("it is there");
    assert!(terminal.starts_with("/dev/"), "{terminal:?}");
    let remedy = json!({
        "system": format!("magician --station {url} VERB"),
        "effect": "uses the arm through the station that has its port",
    });
    let refused = |port: &str, words: &[&str]| {
        let mut second = with_state();
        second.args(["--port", port]).args(words);
        let refused = crate::magician::Run::of(&mut second, b"");
        assert_eq!(refused.status, 4, "{port} {words:?}: {refused:?}");
        refused
    };
    let json = |port: &str, verb: &[&str]| {
        let refused = refused(port, &[&["--json"], verb].concat());
        let told: Value = serde_json::from_str(&refused.err).expect("JSON");
        let error = &told["error"];
        assert_eq!(error["station"], json!(url), "{port} {verb:?}: {error}");
        assert_eq!(error["remedies"], json!([remedy]), "{verb:?}: {error}");
    };
    let arm = arm.to_str().expect("text");
    for verb in OPENING {
        json(arm, verb);
        // The findings of `doctor` are on stdout.
        let said = refused(arm, verb);
        let said = said.out + &said.err;
        let hint = format!("`magician --station {url} VERB`");
        assert!(said.contains(&hint), "{verb:?}: {said}");
    }
    for port in [terminal.to_str().expect("text"), "./arm", "./other"] {
        json(port, &["pose"]);
    }
}

#[test]
fn warnings_of_a_station_are_printed_with_json() {
    let job = json!({
        "job": "j1-1", "arm": "arm", "title": null, "state": "done", "step": 0, "steps": null,
        "first_step": null, "loops": 1, "loop": 1, "seconds_left": null, "drawn_mm": null,
        "travel_mm": null, "started": 1.0, "ended": 2.0, "holder": null, "part": null,
        "reason": null, "text": null, "error": null, "kept": {"owner": 5},
    });
    let file = json!({"version": 2, "jobs": [job]}).to_string();
    for json in [&[][..], &["--json"]] {
        let state = tempfile::tempdir().expect("a directory");
        let jobs = state.path().join("magician/station/jobs");
        std::fs::create_dir_all(&jobs).expect("made");
        std::fs::write(jobs.join("virtual-arm.json"), &file).expect("written");
        let mut command = command();
        command.env("XDG_STATE_HOME", state.path());
        command.args(["serve", "--port", "sim", "--listen", "127.0.0.1:0"]);
        command.args(json).stdin(Stdio::null());
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        let mut station = command.spawn().expect("the command starts");
        let lines = BufReader::new(station.stderr.take().expect("stderr")).lines();
        let lines = lines.map(|line| line.expect("UTF-8"));
        let said: Vec<_> = lines.take_while(|line| !line.contains("serving")).collect();
        station.kill().expect("it runs");
        station.wait().expect("it ends");
        let is_it = |line: &String| {
            let of_file = line.contains("warning:") && line.contains("virtual-arm.json");
            of_file && line.contains("job j1-1 has lost whose it is")
        };
        assert_eq!(
            said.iter().filter(|line| is_it(line)).count(),
            1,
            "{json:?}: {said:?}"
        );
    }
}

#[test]
fn served_arm_is_moved_and_reported() {
    let station = Station::start(&["--port", "sim"]);
    let moved = station.call("arm.move", &json!({"to": [220, 30, 50, 0]}));
    assert_eq!(moved["result"]["y"], json!(30.0));
    let list = station.call("arm.list", &json!({}));
    assert_eq!(list["result"]["arms"][0]["port"], json!("sim"));
    let served: Vec<_> = std::fs::read_dir(state()).unwrap().flatten().collect();
    let holder =
        |entry: &std::fs::DirEntry| entry.file_name().to_string_lossy().starts_with("serve-");
    assert!(served.iter().any(holder));
    let (status, rest) = station.served.end("-TERM");
    assert_eq!((status.code(), rest.as_str()), (Some(0), ""));
    let served: Vec<_> = std::fs::read_dir(state()).unwrap().flatten().collect();
    assert!(!served.iter().any(holder));
    let lines = journal();
    assert_eq!(
        (&lines[0]["method"], &lines[0]["result"]),
        (&json!("arm.move"), &json!("ok"))
    );
    assert_eq!(lines[0]["params"]["to"], json!([220, 30, 50, 0]));
}

#[test]
fn the_page_is_served_unless_it_is_left_out() {
    let station = Station::start(&["--port", "sim"]);
    let (status, page) = station.request("GET", "/", "", "");
    assert_eq!(status, 200);
    assert!(page.starts_with("<!doctype html>"), "{page}");
    for name in page.split("./assets/").skip(1) {
        let name = name.split('"').next().unwrap_or_default();
        assert_eq!(
            station.request("GET", &format!("/assets/{name}"), "", "").0,
            200,
            "{name}"
        );
    }
    assert_eq!(station.request("GET", "/assets/nothing.js", "", "").0, 404);
    let station = Station::start(&["--port", "sim", "--no-studio"]);
    assert_eq!(station.request("GET", "/", "", "").0, 404);
}

/// Returns a command whose browsers, with these names, only write their arguments to a file, and
/// that file.
fn with_browser(folder: &Path, names: &[&str]) -> (Command, PathBuf) {
    let opened = folder.join("opened");
    let script = format!(
        "#!/bin/sh\necho \"$@\" >'{0}.part' && mv '{0}.part' '{0}'\n",
        opened.display()
    );
    for name in names {
        let browser = folder.join(name);
        std::fs::write(&browser, &script).expect("written");
        let runnable = std::os::unix::fs::PermissionsExt::from_mode(0o755);
        std::fs::set_permissions(&browser, runnable).expect("it can be run");
    }
    let mut magician = command();
    let path = std::env::var("PATH").unwrap_or_default();
    magician.env("PATH", format!("{}:{path}", folder.display()));
    (magician, opened)
}

fn shown(opened: &Path) -> String {
    while !opened.exists() {
        std::thread::yield_now();
    }
    std::fs::read_to_string(opened).expect("read")
}

#[test]
fn studio_opens_the_address_in_a_browser() {
    let folder = tempfile::tempdir().expect("a folder");
    let (magician, opened) = with_browser(folder.path(), &["open", "xdg-open"]);
    let words = ["--port", "sim", "--listen", "127.0.0.1:0"];
    let served = Served::of(magician, "studio", &words, 1);
    let url = served.endpoint("http");
    let opened = shown(&opened);
    assert!(
        url.contains(opened.trim().trim_end_matches('/')),
        "{opened} of {url}"
    );
    let refused = run(&["studio", "--port", "sim", "--no-studio"]);
    assert_eq!(refused.status, 2);
}

#[test]
#[cfg(target_os = "linux")]
fn studio_opens_a_window_of_its_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let (magician, opened) = with_browser(folder.path(), &["chromium"]);
    let words = ["--app", "--port", "sim", "--listen", "127.0.0.1:0"];
    let served = Served::of(magician, "studio", &words, 1);
    let url = served.endpoint("http");
    let opened = shown(&opened);
    let (app, rest) = opened.split_once(' ').expect("more than one word");
    let app = app.strip_prefix("--app=").expect("an application");
    assert!(url.contains(app.trim_end_matches('/')), "{app} of {url}");
    // A separate profile: the user's browser would open the page in its own window.
    assert!(rest.starts_with("--user-data-dir=/"), "{rest}");
    let refused = run(&["studio", "--app", "--no-open", "--port", "sim"]);
    assert_eq!(refused.status, 2);
}

#[test]
fn studio_exports_its_files_to_a_new_folder_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let site = folder.path().join("site");
    let words = ["studio", "--export", site.to_str().expect("a name")];
    if !magician_studio::works_without_server() {
        let refused = run(&words);
        assert_eq!(refused.status, 2);
        let said = "cargo xtask generate modules";
        assert!(refused.err.contains(said), "{}", refused.err);
        assert!(!site.exists());
        return;
    }
    assert_eq!(run(&words).status, 0);
    let page = std::fs::read_to_string(site.join("index.html")).expect("the page");
    assert!(page.starts_with("<!doctype html>"), "{page}");
    let module = std::fs::read(site.join("assets/arm.wasm")).expect("the virtual arm");
    assert!(module.starts_with(b"\0asm"));
    // A file of the user would be lost.
    std::fs::write(site.join("index.html"), "mine").expect("written");
    let refused = run(&words);
    assert_eq!(refused.status, 2);
    assert!(refused.err.contains("is not empty"), "{}", refused.err);
    let kept = std::fs::read_to_string(site.join("index.html")).expect("read");
    assert_eq!(kept, "mine");
}

#[test]
fn command_without_arguments_in_a_script_is_a_usage_error() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut magician, opened) = with_browser(folder.path(), &["chromium", "xdg-open", "open"]);
    // There is a screen, but a script reads the output.
    let ended = magician.env("DISPLAY", ":0").output().expect("it runs");
    assert_eq!(ended.status.code(), Some(2));
    assert!(!opened.exists());
}

#[test]
fn moving_arm_is_stopped_at_the_end() {
    let folder = tempfile::tempdir().unwrap();
    let port = folder.path().join("arm").to_str().unwrap().to_owned();
    let _arm = Served::start(&["--pty", &port], 1);
    let station = Station::start(&["--port", &port]);
    let slow = json!({"command": "PTPCommonParams", "fields": {"velocity_ratio": 1, "acceleration_ratio": 1}});
    station.call("arm.set", &slow);
    station.call("arm.move", &json!({"to": [200, 150, 50, 0], "wait": false}));
    let (status, _) = station.served.end("-INT");
    assert_eq!(status.code(), Some(0));
    let before = run(&["--port", &port, "pose", "--json"]).object();
    assert!(before["y"].as_f64().unwrap() < 149.0, "{before}");
    let queue = run(&["--port", &port, "queue", "status", "--json"]).object();
    assert_eq!(
        run(&["--port", &port, "pose", "--json"]).object(),
        before,
        "{queue}"
    );
}

#[test]
fn a_station_that_ends_lifts_the_pen_of_its_job_and_restores_settings() {
    let fixture = Fixture::homed("5");
    let before = fixture.settings();
    for signals in [&["-TERM"][..], &["-HUP", "-HUP"], &["-INT", "-INT"]] {
        let mut serve = command();
        serve.env("XDG_STATE_HOME", fixture.dir.path().join("state"));
        let mut station = Station::of(serve, &["--port", &fixture.endpoint()]);
        let setup = json!({"surface": PAPER, "speed": 10});
        let job = json!({"text": SVG, "format": "svg", "setup": setup});
        let started = station.call("job.start", &job);
        assert!(started["result"]["job"].is_string(), "{started}");
        fixture.until_drawn(2.0);
        for signal in signals {
            let id = station.served.child.id().to_string();
            let kill = Command::new("kill").args([*signal, &id]).status();
            assert!(kill.expect("kill runs").success());
        }
        let status = station.served.child.wait().expect("it ends");
        assert_eq!(status.code(), Some(0), "{signals:?}");
        let up = fixture.number("pose", "z") - PAPER;
        assert!((up - 10.0).abs() < 0.5, "{signals:?}: {up} mm");
        assert_eq!(fixture.settings(), before, "{signals:?}");
        assert_eq!(fixture.unrestored(), 0, "{signals:?}");
    }
}

#[test]
fn a_station_restores_settings_of_a_job_whose_line_was_lost_and_found() {
    let fixture = Fixture::homed("5");
    let before = fixture.settings();
    let line = fixture.dir.path().join("line").display().to_string();
    let proxy = || Served::verb("proxy", &["--port", &fixture.endpoint(), "--pty", &line], 2);
    let mut lost = proxy();
    let mut serve = command();
    serve.env("XDG_STATE_HOME", fixture.dir.path().join("state"));
    let station = Station::of(serve, &["--port", &line]);
    let setup = json!({"surface": PAPER, "speed": 10});
    let job = json!({"text": SVG, "format": "svg", "setup": setup, "unhomed": true});
    let started = station.call("job.start", &job);
    assert!(started["result"]["job"].is_string(), "{started}");
    fixture.until_drawn(2.0);
    lost.child.kill().expect("killed");
    lost.child.wait().expect("it ends");
    let _found = proxy();
    let restored = (0..1_000).any(|_| fixture.settings() == before);
    assert!(restored, "{:?}", fixture.settings());
}

#[test]
fn a_port_that_is_served_names_its_station() {
    let folder = tempfile::tempdir().unwrap();
    let port = folder.path().join("arm").to_str().unwrap().to_owned();
    let _arm = Served::start(&["--pty", &port], 1);
    let station = Station::start(&["--port", &port]);
    for words in [vec!["pose"], vec!["serve", "--listen", "127.0.0.1:0"]] {
        let words = [&["--port", &port][..], &words].concat();
        let refused = run(&words);
        assert_eq!(refused.status, 4, "{refused:?}");
        assert!(refused.err.contains(&station.address), "{refused:?}");
    }
    let mut station = station;
    station.served.child.kill().unwrap();
    station.served.child.wait().unwrap();
    assert_eq!(run(&["--port", &port, "pose"]).status, 0);
}

#[test]
fn failure_to_serve_states_its_reason_and_exit_status() {
    for (words, status, said) in [
        (
            vec!["--port", "sim", "serve", "--arm", "a=sim"],
            2,
            "cannot be used with --port",
        ),
        (vec!["serve", "--arm", "A=sim"], 3, "a-z"),
        (
            vec!["serve", "--arm", "a=sim", "--arm", "a=sim"],
            3,
            "two arms",
        ),
        (
            vec!["--port", "sim", "serve", "--listen", "nowhere"],
            3,
            "HOST:PORT",
        ),
        (
            vec!["--port", "sim", "serve", "--token-file", "/nowhere"],
            3,
            "/nowhere",
        ),
        (
            vec!["--port", "/nowhere", "serve", "--listen", "127.0.0.1:0"],
            4,
            "/nowhere",
        ),
    ] {
        let refused = run(&words);
        assert_eq!(refused.status, status, "{words:?} {refused:?}");
        assert!(refused.err.contains(said), "{words:?} {refused:?}");
        assert_eq!(refused.out, "");
    }
    let station = Station::start(&["--port", "sim"]);
    let taken = run(&["--port", "sim", "serve", "--listen", &station.address]);
    assert_eq!(taken.status, 4, "{taken:?}");
}

#[test]
fn tokens_are_made_listed_used_and_revoked() {
    let made = run(&[
        "station", "token", "--new", "tablet", "--role", "viewer", "--json",
    ])
    .object();
    let token = made["token"].as_str().unwrap();
    let station = Station::start(&["--port", "sim"]);
    let headers = format!("authorization: Bearer {token}\r\n");
    let moving = json!({"jsonrpc": "2.0", "id": 1, "method": "arm.home"}).to_string();
    let (_, refused) = station.request("POST", "/api/v1/rpc", &headers, &moving);
    assert!(refused.contains("forbidden"), "{refused}");
    let list = run(&["station", "token", "--list", "--json"]).object();
    assert_eq!(
        (&list["tokens"][0]["name"], &list["tokens"][0]["role"]),
        (&json!("tablet"), &json!("viewer"))
    );
    assert!(list["tokens"][0]["used"].is_u64(), "{list}");
    assert!(!list.to_string().contains(token));
    assert_eq!(run(&["station", "token", "--revoke", "tablet"]).status, 0);
    let (status, _) = station.request("POST", "/api/v1/rpc", &headers, &moving);
    assert_eq!(status, 401);
    assert_eq!(run(&["station", "token", "--revoke", "tablet"]).status, 3);
    let told = station.served.log().join("\n");
    assert!(!told.contains(token), "{told}");
}

#[test]
fn pairing_code_is_printed_at_start() {
    let station = Served::verb(
        "serve",
        &["--port", "sim", "--listen", "127.0.0.1:0", "--pair"],
        2,
    );
    let code = station.endpoints[1].strip_prefix("code ").expect("a code");
    assert!(
        code.as_bytes()[..6].iter().all(u8::is_ascii_digit),
        "{code}"
    );
}

#[test]
fn a_file_is_drawn_through_a_station() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("square.svg");
    std::fs::write(&file, r#"<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="20mm" viewBox="0 0 20 20"><path fill="none" stroke="black" d="M0 0H20V20H0Z"/></svg>"#).unwrap();
    let station = Station::start(&["--port", "sim:20"]);
    let url = format!("http://{}", station.address);
    let file = file.to_str().unwrap();
    let drawn = run(&["--station", &url, "draw", file, "--unhomed", "--json"]);
    assert_eq!(
        drawn.status, 0,
        "the table is that of a virtual arm: {drawn:?}"
    );
    let list = station.call("arm.list", &json!({}));
    assert_eq!(
        list["result"]["arms"][0]["holder"],
        Value::Null,
        "the lease was given back"
    );
}

#[test]
fn unsupported_verbs_at_a_station_say_so() {
    let station = Station::start(&["--port", "sim"]);
    let url = format!("http://{}", station.address);
    let traced = run(&["--station", &url, "--trace", "/tmp/t.pcapng", "pose"]);
    assert_eq!(traced.status, 2, "{traced:?}");
    let gone = run(&["--station", "http://127.0.0.1:1", "pose"]);
    assert_eq!(gone.status, 4, "{gone:?}");
    assert_eq!(run(&["--station", "https://x/a/b", "pose"]).status, 3);
    let nobody = run(&["--station", &format!("{url}/left"), "pose"]);
    assert_eq!(nobody.status, 3, "{nobody:?}");
}

/// Returns a plan of short moves to and fro.
fn plan(moves: usize) -> String {
    let mut plan = Plan::new("to and fro");
    for nth in 0..moves {
        let to = [220.0, 10.0 * (nth % 5) as f32, 50.0, 0.0];
        let by = Travel::Line;
        plan.push(Action::Move { to, by }, Origin::NONE);
    }
    plan.to_json()
}

impl Station {
    /// Polls a job until it is as wanted.
    fn until(&self, job: &Value, wanted: impl Fn(&Value) -> bool) -> Value {
        for _ in 0..10_000 {
            let now = self.call("job.get", &json!({"job": job}))["result"].clone();
            if wanted(&now) {
                return now;
            }
        }
        panic!("never");
    }
}

#[test]
fn a_job_outlives_its_request_and_is_known_to_the_next_server() {
    let station = Station::start(&["--port", "sim"]);
    let started = station.call("job.start", &json!({"text": plan(4), "loops": 0}));
    let job = started["result"]["job"].clone();
    station.until(&job, |job| job["step"].as_u64() >= Some(1));
    let mut station = station;
    station.served.child.kill().unwrap();
    station.served.child.wait().unwrap();
    let station = Station::start(&["--port", "sim"]);
    let list = station.call("job.list", &json!({}));
    let left = &list["result"]["jobs"][0];
    assert_eq!(
        (&left["job"], &left["state"], &left["title"]),
        (&job, &json!("interrupted"), &json!("to and fro"))
    );
}

#[test]
fn stations_with_virtual_arms_resume_each_its_own_job() {
    let stations = [(); 2].map(|()| Station::start(&["--port", "sim:4"]));
    let index = |station: &Station| {
        let asked = json!({"command": "QueuedCmdCurrentIndex"});
        let read = station.call("arm.get", &asked);
        let text = read["result"].to_string();
        let digits: String = text.chars().filter(char::is_ascii_digit).collect();
        digits.parse::<u64>().unwrap_or_else(|_| panic!("{read}"))
    };
    let stopped = [(&stations[0], 2), (&stations[1], 7)].map(|(station, steps)| {
        let started = station.call("job.start", &json!({"text": plan(12)}));
        let job = started["result"]["job"].clone();
        station.until(&job, |job| job["step"].as_u64() >= Some(steps));
        let stopped = station.call("job.stop", &json!({"job": job}));
        (job, stopped["result"]["step"].as_u64().expect("steps"))
    });
    assert!(stopped[1].1 > stopped[0].1 + 2, "{stopped:?}");
    for nth in [0, 1] {
        let (station, (job, done)) = (&stations[nth], &stopped[nth]);
        let before = index(station);
        let resumed = station.call("job.resume", &json!({"job": job}));
        assert!(resumed["result"].is_object(), "{resumed}");
        let over = station.until(job, |job| job["state"] != "running");
        assert_eq!(over["state"], json!("done"), "{over}");
        // A few more commands return the arm to where it was stopped.
        let (count, rest) = (index(station) - before, 12 - done);
        assert!((rest..rest + 6).contains(&count), "{count} of {rest}");
    }
}

#[test]
fn station_of_a_virtual_arm_ignores_the_calibrated_surface() {
    let home = tempfile::tempdir().unwrap();
    let with_home = || {
        let mut command = command();
        command.env("XDG_CONFIG_HOME", home.path());
        command
    };
    let kept =
        crate::magician::Run::of(with_home().args(["config", "set", "surface", "-31.5"]), b"");
    assert_eq!(kept.status, 0, "{kept:?}");
    let station = Station::of(with_home(), &["--port", "sim"]);
    let known = station.call("surface.get", &json!({}));
    assert_eq!(known["result"]["plane"], Value::Null, "{known}");
    let job = json!({"text": SVG, "format": "svg", "preview": true, "setup": {"work": "draw"}});
    let checked = station.call("job.check", &job);
    let height = &checked["result"]["preview"]["strokes"][0]["height"];
    assert_eq!(height, &json!(-60.0), "{checked}");
}

#[test]
fn run_resumes_a_job_of_a_station() {
    let folder = tempfile::tempdir().unwrap();
    let port = folder.path().join("arm").to_str().unwrap().to_owned();
    let file = folder.path().join("moves.plan.json");
    std::fs::write(&file, plan(12)).unwrap();
    let file = file.to_str().unwrap();
    let _arm = Served::start(&["--pty", &port], 1);
    mark_homed(command(), &port);
    let station = Station::start(&["--port", &port]);
    let started = station.call("job.start", &json!({"text": plan(12)}));
    let job = started["result"]["job"].clone();
    assert!(job.is_string(), "{started}");
    station.until(&job, |job| job["step"].as_u64() >= Some(2));
    let stopped = station.call("job.stop", &json!({"job": job}));
    assert_eq!(stopped["result"]["state"], json!("stopped"), "{stopped}");
    let done = stopped["result"]["step"].as_u64().unwrap();
    station.served.end("-TERM");
    let resumed = run(&["--port", &port, "run", file, "--resume", "--json"]);
    assert_eq!(resumed.status, 0, "{resumed:?}");
    let last = resumed.out.lines().last().unwrap().to_owned();
    let last: Value = serde_json::from_str(&last).unwrap();
    assert!(last["first_step"].as_u64().unwrap() > done, "{last}");
}

#[test]
fn placement_settings_apply_to_jobs_of_real_arms_only() {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("config.toml");
    std::fs::write(&config, "surface = -40\n").unwrap();
    let drawing = "<svg xmlns='http://www.w3.org/2000/svg' width='10mm' height='10mm' viewBox='0 0 10 10'>\
        <path d='M1 1H9' stroke='black' fill='none'/></svg>";
    // An arm behind a line counts as real.
    let served = Served::start(&["--tcp", "127.0.0.1:0"], 1);
    for (port, height) in [(&*served.endpoint("tcp"), -40.0), ("sim", -60.0)] {
        let mut command = command();
        command.env("MAGICIAN_CONFIG", &config);
        let station = Station::of(command, &["--port", port]);
        let report = station.call("job.check", &json!({"text": drawing}));
        assert_eq!(
            report["result"]["bounds"]["z"],
            json!([height, height]),
            "{port}: {report}"
        );
    }
}

#[test]
fn programs_are_stored_in_a_folder_and_run_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let programs = folder.path().join("programs");
    let named = ["--port", "sim", "--programs", programs.to_str().unwrap()];
    let station = Station::start(&named);
    let info = station.call("server.info", &json!({}));
    assert_eq!(info["result"]["programs"], json!(programs));
    let square = "G21 G90\nG0 X200 Y0 Z20\nG1 Z0 F3000\nG1 X230\nG1 Y30\nG0 Z20\n";
    let at = "/api/v1/programs/square.gcode";
    assert_eq!(station.request("PUT", at, "", square).0, 201);
    assert_eq!(
        std::fs::read_to_string(programs.join("square.gcode")).unwrap(),
        square
    );
    let setup = json!({"at": [220, 0], "lift": 8});
    let checked = json!({"program": "square.gcode", "setup": setup});
    let checked = station.call("job.check", &checked);
    assert_eq!(checked["result"]["ok"], json!(true), "{checked}");
    // The command gives the same result for the same flags.
    let file = programs.join("square.gcode");
    let file = file.to_str().unwrap();
    let flags = ["--at", "220,0", "--lift", "8", "--check", "--json"];
    let said = run(&[&["draw", file][..], &flags].concat());
    let said = said.objects().pop().expect("a report");
    for member in ["bounds", "drawn_mm", "steps", "placed", "travel_mm"] {
        assert_eq!(checked["result"][member], said[member], "{member}");
    }
    let convert = json!({"name": "square.gcode", "to": "square.csv"});
    let made = station.call("program.convert", &convert)["result"].clone();
    let to = folder.path().join("square.csv");
    let said = run(&["convert", file, to.to_str().unwrap(), "--json"]);
    let said = said.objects().pop().expect("a report");
    assert_eq!(
        (&made["steps"], &made["lost"]),
        (&said["steps"], &said["lost"])
    );
    assert_eq!(
        std::fs::read(programs.join("square.csv")).unwrap(),
        std::fs::read(to).unwrap()
    );
    // A path that is no folder is reported before an arm is searched.
    let wrong = run(&["serve", "--port", "sim", "--programs", file]);
    assert_eq!(wrong.status, 3, "{wrong:?}");
}

#[cfg(target_os = "linux")]
#[test]
fn full_disk_keeps_the_stored_program() {
    let folder = tempfile::tempdir().unwrap();
    let programs = folder.path().join("programs");
    // No file of this process may exceed a few MiB: a write then fails as on a full disk.
    let ours = command();
    let mut limited = std::process::Command::new("sh");
    let script = "ulimit -f 4096; exec \"$0\" \"$@\"";
    limited.args(["-c", script]).arg(ours.get_program());
    for (name, value) in ours.get_envs() {
        if let Some(value) = value {
            limited.env(name, value);
        }
    }
    let named = ["--port", "sim", "--programs", programs.to_str().unwrap()];
    let station = Station::of(limited, &named);
    let at = "/api/v1/programs/a.gcode";
    assert_eq!(station.request("PUT", at, "", "G0 X1 Y1 Z1").0, 201);
    let large = "x".repeat(16 << 20);
    let (status, why) = station.request("PUT", at, "", &large);
    assert_eq!(status, 507, "{why}");
    assert_eq!(station.request("GET", at, "", "").1, "G0 X1 Y1 Z1");
    let files = std::fs::read_dir(&programs).unwrap().count();
    assert_eq!(files, 1, "nothing half-written");
    // The arm is not affected.
    let moved = station.call("arm.move", &json!({"to": [220, 30, 50, 0]}));
    assert_eq!(moved["result"]["y"], json!(30.0));
}

#[cfg(target_os = "linux")]
#[test]
fn too_few_descriptors_are_an_error_and_no_panic() {
    let ours = command();
    for descriptors in 5..16 {
        let mut limited = std::process::Command::new("sh");
        let script = format!("ulimit -n {descriptors}; exec \"$0\" \"$@\"");
        limited.args(["-c", &script]).arg(ours.get_program());
        limited.args(["pose", "--port", "sim"]);
        for (name, value) in ours.get_envs() {
            if let Some(value) = value {
                limited.env(name, value);
            }
        }
        let output = limited.output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(!said.contains("panicked"), "{descriptors}: {said}");
        if descriptors < 9 {
            assert_eq!(output.status.code(), Some(4), "{descriptors}: {said}");
            assert!(
                said.contains("Too many open files"),
                "{descriptors}: {said}"
            );
        }
    }
}

/// A build without sites names a build with them, before it opens anything.
#[cfg(not(feature = "site"))]
#[test]
fn sites_are_refused_in_builds_without_them() {
    for words in [
        &["serve", "--port", "sim", "--site", "lab"][..],
        &["fleet", "--site", "lab", "list"],
        &["fleet", "stop", "--all", "--site", "lab"],
        &["site", "init", "lab"],
        &["site", "join", "a:1/x"],
        &["site", "list"],
    ] {
        let refused = run(words);
        assert_eq!(refused.status, 6, "{words:?}");
        assert!(refused.err.contains("--features site"), "{words:?}");
    }
    // A wrong command line is still reported as such.
    assert_eq!(run(&["serve", "--port", "sim", "--site", "Lab"]).status, 2);
    assert_eq!(run(&["fleet", "stop"]).status, 2);
}
