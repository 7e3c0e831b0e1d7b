//! Unattended station: encrypted, configured by settings alone, found and checked by other
//! machines.
#![cfg(unix)]

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::magician::served::Served;
use crate::magician::{command, run};

/// Creates a self-signed certificate and its key.
fn pair(folder: &Path, name: &str) -> [PathBuf; 2] {
    let made = rcgen::generate_simple_self_signed(vec!["127.0.0.1".to_owned()]).unwrap();
    let files = ["cert", "key"].map(|what| folder.join(format!("{name}.{what}.pem")));
    std::fs::write(&files[0], made.cert.pem()).unwrap();
    std::fs::write(&files[1], made.signing_key.serialize_pem()).unwrap();
    files
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

const SIM: [&str; 4] = ["--port", "sim", "--listen", "127.0.0.1:0"];

/// Returns the address that a station prints.
fn url(served: &Served, scheme: &str) -> String {
    served.endpoint(scheme).trim_end_matches('/').to_owned()
}

#[test]
fn verbs_work_through_an_encrypted_station_that_is_trusted() {
    let folder = tempfile::tempdir().unwrap();
    let [certificate, key] = pair(folder.path(), "own");
    let [other, _] = pair(folder.path(), "other");
    let tls = ["--tls-cert", text(&certificate), "--tls-key", text(&key)];
    let served = Served::verb("serve", &[&SIM[..], &tls].concat(), 1);
    let url = url(&served, "https");
    let at = |trusted: &Path, how: &[&str]| {
        let trusting = ["--station", &url, "--station-ca", text(trusted), "pose"];
        run(&[&trusting, how].concat())
    };
    let pose = at(&certificate, &["--json"]);
    assert_eq!(pose.status, 0, "{pose:?}");
    assert!(pose.object()["x"].is_f64());
    for refused in [at(&other, &[]), at(&folder.path().join("nowhere"), &[])] {
        assert_eq!(refused.status, 4, "{refused:?}");
        assert!(refused.err.contains("--station-ca"), "{refused:?}");
    }
    let clear = run(&["--station", &url.replace("https", "http"), "pose"]);
    assert_eq!(clear.status, 4, "{clear:?}");
}

#[test]
fn unusable_certificates_state_the_exit_status() {
    let folder = tempfile::tempdir().unwrap();
    let [certificate, key] = pair(folder.path(), "own");
    let [_, other] = pair(folder.path(), "other");
    let nowhere = folder.path().join("nowhere.pem");
    for (certificate, key, status, said) in [
        (Some(&certificate), None, 2, "--tls-key"),
        (None, Some(&key), 2, "--tls-cert"),
        (Some(&certificate), Some(&nowhere), 3, "nowhere.pem"),
        (Some(&key), Some(&key), 3, "no certificate"),
        (Some(&certificate), Some(&other), 3, "is not that of"),
    ] {
        let mut words = [&["serve"][..], &SIM].concat();
        for (flag, file) in [("--tls-cert", certificate), ("--tls-key", key)] {
            words.extend(file.iter().flat_map(|file| [flag, text(file)]));
        }
        let refused = run(&words);
        assert_eq!(refused.status, status, "{words:?} {refused:?}");
        assert!(refused.err.contains(said), "{words:?} {refused:?}");
        assert_eq!(refused.out, "");
    }
}

#[test]
fn settings_apply_if_no_flag_is_given() {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("config.toml");
    let settings = "[serve]\nlisten = '127.0.0.1:0'\nallow_host = ['lab.local']\n\
         [arms.left]\nport = 'sim'\n[arms.right]\nport = 'sim:2'\n";
    std::fs::write(&config, settings).unwrap();
    let with = |arguments: &[&str]| {
        let mut command = command();
        command.env("MAGICIAN_CONFIG", &config);
        Served::of(command, "serve", arguments, 1)
    };
    let served = with(&[]);
    let url = url(&served, "http");
    let list = run(&["--station", &format!("{url}/left"), "doctor", "--json"]).object();
    assert_eq!(list["checks"][0]["ok"], json!(true), "{list}");
    let local = run(&["ports", "--local", "--json"]).object();
    let found = local["stations"].as_array().unwrap();
    let found = found.iter().find(|found| found["url"] == json!(url));
    assert_eq!(found.unwrap()["arms"], json!(["left", "right"]), "{local}");
    assert_eq!(admitted(&url, "lab.local"), 200);
    assert_eq!(admitted(&url, "evil.example"), 403);
    // A flag overrides a setting.
    let named = with(&["--allow-host", "other.local", "--arm", "one=sim"]);
    let url = self::url(&named, "http");
    assert_eq!(admitted(&url, "lab.local"), 403);
    assert_eq!(admitted(&url, "other.local"), 200);
}

#[test]
fn link_flags_are_accepted_with_the_link_enabled_by_settings() {
    let refused = run(&[&["serve", "--link-laser"][..], &SIM].concat());
    assert_eq!(refused.status, 2, "{refused:?}");
    assert!(refused.err.contains("--link-laser"), "{refused:?}");
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("config.toml");
    std::fs::write(&config, "[serve]\nlink = true\n").unwrap();
    let mut command = command();
    command.env("MAGICIAN_CONFIG", &config);
    let nowhere = folder.path().join("tokens");
    command.args(["serve", "--link-laser", "--token-file"]);
    let refused = command.args([&nowhere]).args(SIM).output().unwrap();
    // Only the missing file is wrong.
    assert_eq!(refused.status.code(), Some(3), "{refused:?}");
}

/// Returns the status of a request with this host name.
fn admitted(url: &str, host: &str) -> u16 {
    use std::io::{Read, Write};
    let address = url.strip_prefix("http://").unwrap();
    let mut stream = std::net::TcpStream::connect(address).unwrap();
    write!(
        stream,
        "GET /healthz HTTP/1.1\r\nhost: {host}\r\nconnection: close\r\n\r\n"
    )
    .unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer.split(' ').nth(1).unwrap().parse().unwrap()
}

/// Returns the findings about a station, by check.
fn look(words: &[&str], token: Option<&str>) -> (i32, Vec<(String, Value)>) {
    let mut command = command();
    command.args(words).args(["doctor", "--json"]);
    if let Some(token) = token {
        command.env("MAGICIAN_TOKEN", token);
    }
    let output = command.output().unwrap();
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let checks = report["checks"].as_array().unwrap().iter();
    let checks = checks.map(|check| {
        let name = check["check"].as_str().unwrap();
        (name.to_owned(), check["ok"].clone())
    });
    (output.status.code().unwrap(), checks.collect())
}

#[test]
fn doctor_reports_faults_of_a_station() {
    let served = Served::verb("serve", &SIM, 1);
    let url = url(&served, "http");
    let (status, checks) = look(&["--station", &url], None);
    assert_eq!(status, 0, "{checks:?}");
    let names: Vec<_> = checks.iter().map(|(name, _)| name.as_str()).collect();
    let wanted = [
        "station",
        "encryption",
        "version",
        "role",
        "answers",
        "arm",
        "lease",
        "alarms",
        "homed",
        "clock",
    ];
    assert_eq!(names, wanted);
    let (status, checks) = look(&["--station", &format!("{url}/nobody")], None);
    assert_eq!(
        (status, checks.last()),
        (10, Some(&("arm".to_owned(), json!(false))))
    );
    let (status, checks) = look(&["--station", &url], Some("nonsense"));
    assert_eq!(
        (status, &checks[..]),
        (4, &[("token".to_owned(), json!(false))][..])
    );
    let (status, checks) = look(&["--station", "http://127.0.0.1:1"], None);
    assert_eq!(
        (status, &checks[..]),
        (4, &[("station".to_owned(), json!(false))][..])
    );
}
