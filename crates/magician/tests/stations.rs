//! The error of a busy port names the station that has it, for every way to open it. A station is
//! found by its file in the folder that the environment names, so this program restarts itself with
//! another folder and opens the ports of the first process.
#![cfg(unix)]

use std::net::{TcpListener, UdpSocket};
use std::process::Command;
use std::time::Duration;

use magician::serve::Server;
use magician::sim::{Controller, Profile, Speed};
use magician::{Act, Arm, Error, Options, RawLine, Target, blocking};
use tokio::sync::oneshot;

const URL: &str = "http://127.0.0.1:8910/";
/// Environment variable that makes this program open these targets, one per line.
const TARGETS: &str = "MAGICIAN_TEST_TARGETS";

/// Creates the file of a station with these ports, run by this process.
fn station(ports: &[String]) -> tempfile::TempDir {
    let state = tempfile::tempdir().expect("a directory");
    let folder = state.path().join("magician/station");
    std::fs::create_dir_all(&folder).expect("made");
    let pid = std::process::id();
    let list = |texts: &[String]| format!("{texts:?}");
    let names: Vec<_> = (1..=ports.len()).map(|at| format!("arm{at}")).collect();
    let text = format!(
        "{{\"pid\": {pid}, \"url\": \"{URL}\", \"ports\": {}, \"arms\": {}}}",
        list(ports),
        list(&names)
    );
    std::fs::write(folder.join(format!("serve-{pid}.json")), text).expect("written");
    state
}

/// Returns the errors of all ways to open a target.
async fn doors(target: &Target) -> Vec<(&'static str, Error)> {
    let options = || Options::default().timeout(Duration::from_millis(50));
    let mut errors = Vec::new();
    let arm = Arm::connect_with(target, options()).await;
    errors.extend(arm.err().map(|error| ("Arm", error)));
    let again = target.clone();
    let opened = move || blocking::Arm::connect_with(again, options());
    // The blocking handle refuses a thread of a runtime.
    let arm = std::thread::spawn(opened).join().expect("no panic");
    errors.extend(arm.err().map(|error| ("blocking::Arm", error)));
    let line = RawLine::open(target).await;
    errors.extend(line.err().map(|error| ("RawLine", error)));
    errors
}

#[tokio::test]
#[ignore = "the other test starts it"]
async fn opens_what_another_program_has() {
    let targets = std::env::var(TARGETS).expect("the targets");
    for (at, target) in (1..).zip(targets.lines()) {
        let url = format!("{URL}arm{at}");
        let target = target.parse::<Target>().expect("a target");
        let errors = doors(&target).await;
        // A datagram line opens without an arm.
        let at_least = if matches!(target, Target::Udp { .. }) {
            2
        } else {
            3
        };
        assert!(errors.len() >= at_least, "{target}: {errors:?}");
        for (door, error) in errors {
            assert_eq!(error.station(), Some(url.as_str()), "{door}: {error:?}");
            let ways = error.remedies().iter().map(|remedy| &remedy.act);
            let ways: Vec<_> = ways.collect();
            let expected = Act::UseStation(url.clone().into());
            assert!(ways.contains(&&expected), "{door}: {error:?}");
        }
    }
    let missing = Arm::connect("/dev/tty-of-no-arm")
        .await
        .expect_err("missing");
    assert_eq!(missing.station(), None);
}

#[tokio::test]
async fn every_way_to_open_a_port_of_a_station_names_it() {
    let folder = tempfile::tempdir().expect("a directory");
    let path = folder.path().join("arm");
    let (ready, is_ready) = oneshot::channel();
    let server = Server::new(Controller::new(Profile::default()))
        .speed(Speed::Max)
        .pty(&path)
        .on_ready(move |_| ready.send(()).expect("it is heard"));
    let silent = UdpSocket::bind("127.0.0.1:0").expect("an address");
    let closed = TcpListener::bind("127.0.0.1:0").expect("an address");
    let path = path.to_str().expect("text").to_owned();
    let targets = [
        path.clone(),
        format!("udp:{}", silent.local_addr().expect("known")),
        format!("tcp:{}", closed.local_addr().expect("known")),
    ];
    drop(closed);
    let work = async {
        is_ready.await.expect("it is served");
        let _held = Arm::connect(path.as_str()).await.expect("it is free");
        let state = station(&targets);
        let mut opener = Command::new(std::env::current_exe().expect("known"));
        opener.args(["--exact", "--ignored", "opens_what_another_program_has"]);
        opener.env("XDG_STATE_HOME", state.path());
        opener.env(TARGETS, targets.join("\n"));
        let opened = move || opener.output().expect("it runs");
        let opened = tokio::task::spawn_blocking(opened).await.expect("no panic");
        let said = String::from_utf8_lossy(&opened.stdout);
        assert!(
            opened.status.success() && said.contains("1 passed"),
            "{said}"
        );
    };
    tokio::select! {
        ended = server.serve_until(std::future::pending()) => panic!("{ended:?}"),
        () = work => {}
    }
}
