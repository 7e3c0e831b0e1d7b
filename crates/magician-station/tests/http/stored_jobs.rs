//! Folder of jobs: identity of arms, files of older stations, damaged files.

use std::fs;
use std::path::{Path, PathBuf};

use magician_job::{FileJournal, Journal, JournalKey};
use magician_program::resume::Checkpoint;
use magician_station::http::{JobFolder, JobStoreError};
use magician_station::{ArmEntry, JobOrder, JobStore};
use serde_json::{Value, json};

fn real(name: &str, port: &str) -> ArmEntry {
    ArmEntry {
        port: port.to_owned(),
        is_virtual: false,
        ..ArmEntry::simulated(name)
    }
}

fn open(folder: &Path, arms: &[(ArmEntry, &str)]) -> Result<JobFolder, JobStoreError> {
    let entries: Vec<_> = arms.iter().map(|(arm, _)| arm.clone()).collect();
    let serials: Vec<_> = arms
        .iter()
        .map(|(_, serial)| (*serial).to_owned())
        .collect();
    let opened = JobFolder::open(folder, &entries, &serials)?;
    Ok(opened.with_runs(folder.join("runs")))
}

fn job(id: &str, arm: &str, state: &str) -> Value {
    json!({"job": id, "arm": arm, "title": null, "state": state, "step": 0, "steps": null, "first_step": null,
        "loops": null, "loop": 1, "seconds_left": null, "drawn_mm": null, "travel_mm": null, "started": 1.0,
        "ended": null, "holder": null, "part": null, "reason": null, "text": null, "place": null, "error": null,
        "notes": null})
}

fn file(ids: &[&str]) -> Value {
    let jobs: Vec<_> = ids.iter().map(|id| job(id, "arm", "done")).collect();
    json!({"version": 2, "earlier": {}, "jobs": jobs})
}

fn ids(store: &JobFolder, arm: usize) -> Vec<String> {
    let content = store.load(arm);
    let jobs = content["jobs"].as_array().cloned().unwrap_or_default();
    { jobs.iter() }
        .map(|job| job["job"].as_str().unwrap().to_owned())
        .collect()
}

fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut all = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap().flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_none_or(|ending| ending != "lock") {
                let bytes = fs::read(&path).unwrap();
                all.push((path, bytes));
            }
        }
    }
    all.sort();
    all
}

#[test]
fn jobs_follow_the_serial_number_across_names_and_ports() {
    let place = tempfile::tempdir().unwrap();
    let one = open(place.path(), &[(real("arm", "/dev/a"), "DT1")]).unwrap();
    one.save(0, &file(&["j1"])).unwrap();
    drop(one);
    let other = open(place.path(), &[(real("arm", "/dev/a"), "DT2")]).unwrap();
    assert_eq!(
        other.load(0),
        Value::Null,
        "another arm of this name and port"
    );
    drop(other);
    let again = open(place.path(), &[(real("left", "/dev/b"), "DT1")]).unwrap();
    assert_eq!(ids(&again, 0), ["j1"]);
}

#[test]
fn arm_without_serial_number_is_identified_by_port() {
    let place = tempfile::tempdir().unwrap();
    let one = open(place.path(), &[(real("arm", "tcp:a:1"), "")]).unwrap();
    one.save(0, &file(&["j1"])).unwrap();
    drop(one);
    let other = open(place.path(), &[(real("arm", "tcp:a:2"), " ")]).unwrap();
    assert_eq!(other.load(0), Value::Null);
    drop(other);
    let again = open(place.path(), &[(real("x", "tcp:a:1"), "")]).unwrap();
    assert_eq!(ids(&again, 0), ["j1"]);
}

#[test]
fn shared_serial_number_is_combined_with_the_port() {
    let place = tempfile::tempdir().unwrap();
    let alone = open(place.path(), &[(real("arm", "tcp:a:1"), "DT1")]).unwrap();
    alone.save(0, &file(&["j1"])).unwrap();
    drop(alone);
    let arms = [
        (real("left", "tcp:a:2"), "DT1"),
        (real("right", "tcp:a:1"), "DT1"),
    ];
    let both = open(place.path(), &arms).unwrap();
    assert_eq!(
        (both.load(0), ids(&both, 1)),
        (Value::Null, vec!["j1".to_owned()])
    );
    both.save(0, &file(&["j2"])).unwrap();
    drop(both);
    for (port, expected) in [("tcp:a:1", "j1"), ("tcp:a:2", "j2")] {
        let one = open(place.path(), &[(real("arm", port), "DT1")]).unwrap();
        assert_eq!(ids(&one, 0), [expected]);
    }
}

#[test]
fn two_stations_share_the_folder_but_no_arm() {
    let place = tempfile::tempdir().unwrap();
    let one = open(place.path(), &[(real("arm", "tcp:a:1"), "DT1")]).unwrap();
    one.save(0, &file(&["j1"])).unwrap();
    let before = files(place.path());
    let taken = open(place.path(), &[(real("arm", "tcp:a:9"), "DT1")]).unwrap_err();
    assert!(matches!(taken, JobStoreError::Taken(..)), "{taken}");
    assert!(taken.to_string().contains("arm"), "{taken}");
    assert_eq!(files(place.path()), before);
    let other = open(place.path(), &[(real("arm", "tcp:a:2"), "DT2")]).unwrap();
    other.save(0, &file(&["j2"])).unwrap();
    one.save(0, &file(&["j1", "j3"])).unwrap();
    let twins = [
        open(place.path(), &[(ArmEntry::simulated("arm"), "0")]).unwrap(),
        open(place.path(), &[(ArmEntry::simulated("arm"), "0")]).unwrap(),
    ];
    for (twin, id) in twins.iter().zip(["v1", "v2"]) {
        twin.save(0, &file(&[id])).unwrap();
    }
    drop((one, other, twins));
    let one = open(place.path(), &[(real("arm", "tcp:a:1"), "DT1")]).unwrap();
    assert_eq!(ids(&one, 0), ["j1", "j3"]);
    let twin = open(place.path(), &[(ArmEntry::simulated("arm"), "0")]).unwrap();
    assert_eq!(ids(&twin, 0), ["v1"]);
}

#[test]
fn unreadable_job_file_is_reported_and_preserved() {
    let whole = file(&["j1", "j2"]).to_string();
    let newer = whole.replace("\"version\":2", "\"version\":3");
    let foreign = r#"{"version":2,"jobs":[{"job":7}]}"#;
    let unknown = whole.replacen("\"state\":\"done\"", "\"state\":\"flying\"", 1);
    let twice = file(&["j1", "j1"]).to_string();
    let frozen = whole.replace("\"version\":2", "\"version\":2,\"frozen\":\"yes\"");
    let sums = whole.replace("\"earlier\":{}", "\"earlier\":{\"jobs\":-1}");
    for (text, why) in [
        ("", "EOF"),
        (&whole[..whole.len() / 2], "EOF"),
        ("\0\0\0\0", "expected value"),
        ("7", "no list of jobs"),
        ("{}", "no version"),
        (foreign, "its job 1"),
        (&newer, "version 3"),
        (&unknown, "its job 1 has no state"),
        (&twice, "its job 2 has the id of another one"),
        (&frozen, "frozen"),
        (&sums, "sums of earlier jobs"),
    ] {
        let place = tempfile::tempdir().unwrap();
        fs::create_dir_all(place.path().join("jobs")).unwrap();
        fs::write(place.path().join("jobs/serial-DT1.json"), text).unwrap();
        let before = files(place.path());
        let error = open(place.path(), &[(real("arm", "tcp:a:1"), "DT1")]).unwrap_err();
        let told = error.to_string();
        assert!(
            told.contains("serial-DT1.json") && told.contains(why),
            "{told}"
        );
        assert_eq!(files(place.path()), before, "{text}");
        // The damaged file of one arm does not concern another arm.
        open(place.path(), &[(real("arm", "tcp:a:1"), "DT2")]).unwrap();
    }
    let place = tempfile::tempdir().unwrap();
    fs::create_dir_all(place.path().join("jobs/serial-DT1.json")).unwrap();
    let error = open(place.path(), &[(real("arm", "tcp:a:1"), "DT1")]).unwrap_err();
    assert!(matches!(error, JobStoreError::Io(..)), "{error}");
}

#[test]
fn old_job_file_is_migrated_once_by_arm_name() {
    let place = tempfile::tempdir().unwrap();
    let old = place.path().join("jobs.json");
    let jobs = json!([
        job("j1", "left", "done"),
        job("j2", "right", "running"),
        job("j3", "left", "queued"),
        job("j4", "gone", "failed"),
    ]);
    fs::write(&old, jobs.to_string()).unwrap();
    let arms = [
        (real("left", "tcp:a:1"), "DT1"),
        (real("right", "tcp:a:2"), "DT2"),
    ];
    let both = open(place.path(), &arms).unwrap();
    assert_eq!(ids(&both, 0), ["j1", "j3"]);
    assert_eq!(ids(&both, 1), ["j2"]);
    // The owner is unknown, so the job does not wait as someone else's.
    assert_eq!(both.load(0)["jobs"][1]["state"], json!("interrupted"));
    let rest: Value = serde_json::from_str(&fs::read_to_string(&old).unwrap()).unwrap();
    assert_eq!(rest, json!([job("j4", "gone", "failed")]));
    drop(both);
    // Again, as after a kill between the two files.
    fs::write(&old, jobs.to_string()).unwrap();
    let again = open(place.path(), &arms).unwrap();
    assert_eq!(ids(&again, 0), ["j1", "j3"]);
    drop(again);
    let last = open(place.path(), &[(real("gone", "tcp:a:3"), "DT3")]).unwrap();
    assert_eq!(ids(&last, 0), ["j4"]);
    assert!(!old.exists());
}

#[test]
fn failed_write_of_jobs_is_an_error() {
    let place = tempfile::tempdir().unwrap();
    let one = open(place.path(), &[(real("arm", "tcp:a:1"), "DT1")]).unwrap();
    one.save(0, &file(&["j1"])).unwrap();
    let folder = place.path().join("jobs");
    fs::rename(&folder, place.path().join("away")).unwrap();
    fs::write(&folder, "in the way").unwrap();
    let error = one.save(0, &file(&["j1", "j2"])).unwrap_err();
    assert!(error.to_string().contains("serial-DT1.json"), "{error}");
}

#[test]
fn interrupted_command_runs_are_listed_per_arm_unless_running() {
    let place = tempfile::tempdir().unwrap();
    let runs = place.path().join("runs");
    let checkpoint = |finished| Checkpoint {
        finished,
        ..Checkpoint::new("house", Some(10), false)
    };
    let run = |key: &str, serial: &str, started: f64| {
        let order = JobOrder::of_plan("{}".to_owned(), Some(1), None);
        let order = json!({"version": 1, "started": started, "port": "tcp:a:1", "steps": 10, "order": order});
        let Value::Object(order) = order else {
            panic!()
        };
        let mut journal = FileJournal::at(&runs).with_order(order);
        journal.open(&JournalKey::new(key, serial));
        journal
    };
    let mut under_way = run("aa", "DT1", 5.0);
    under_way.write(&checkpoint(4)).unwrap();
    let mut other = run("bb", "DT2", 6.0);
    other.write(&checkpoint(1)).unwrap();
    drop(other);
    let one = open(place.path(), &[(real("arm", "tcp:a:1"), "DT1")]).unwrap();
    assert_eq!(one.runs(0), [], "a process has it");
    drop(under_way);
    let found = one.runs(0);
    assert_eq!(found.len(), 1);
    assert_eq!(
        (
            found[0].title.as_str(),
            found[0].done,
            found[0].steps,
            found[0].started
        ),
        ("house", 4, Some(10), 5.0)
    );
    // A station resumes the run and finishes it.
    let mut journal = one.journal();
    journal.open(&JournalKey::new("aa", "DT1"));
    assert_eq!(journal.load().unwrap().finished, 4);
    journal.remove();
    assert_eq!(one.runs(0), []);
    // A run started by a station is not taken over, even if the command has resumed it.
    let mut station = one.journal();
    station.open(&JournalKey::new("cc", "DT1"));
    station.write(&checkpoint(2)).unwrap();
    drop(station);
    let mut goes_on = run("cc", "DT1", 7.0);
    goes_on.write(&checkpoint(3)).unwrap();
    drop(goes_on);
    assert_eq!(one.runs(0), []);
}

#[test]
fn failed_write_of_a_file_names_it() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("station");
    let store = open(&folder, &[(real("arm", "/dev/arm"), "DT1")]).unwrap();
    store.save_text("class.toml", "first").unwrap();
    assert_eq!(
        store.load_text("class.toml").unwrap().as_deref(),
        Some("first")
    );
    // Root ignores permissions, but even root cannot write into a file as if it were a folder.
    fs::remove_dir_all(&folder).unwrap();
    fs::write(&folder, "").unwrap();
    let refused = store.save_text("class.toml", "second").unwrap_err();
    assert!(refused.to_string().contains("class.toml"), "{refused}");
}

#[test]
fn damaged_part_of_a_job_is_reported_and_the_job_kept() {
    let mut damaged = file(&["good", "whose", "what", "both"]);
    let kept = json!({"ran": true, "owner": {"pupil": "Ada"}, "later": 1});
    damaged["jobs"][0]["kept"] = kept;
    damaged["jobs"][1]["kept"] = json!({"ran": true, "owner": {"pupil": 5}});
    damaged["jobs"][2]["order"] = json!({"source": 5});
    damaged["jobs"][3]["kept"] = json!("nothing");
    damaged["jobs"][3]["order"] = json!([]);
    assert_eq!(magician_station::check_jobs(&damaged), Ok(()));
    let said = magician_station::damaged_jobs(&damaged);
    let whose = "has lost whose it is, its key and its rules, so it is a teacher's";
    let what = "its program, so it cannot go on";
    let expected = [
        format!("job whose {whose}"),
        format!("job what has lost {what}"),
        format!("job both {whose}; and {what}"),
    ];
    assert_eq!(said, expected);
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("jobs/serial-DT1.json");
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(&path, damaged.to_string()).unwrap();
    let store = open(place.path(), &[(real("arm", "/dev/arm"), "DT1")]).unwrap();
    assert_eq!(ids(&store, 0), ["good", "whose", "what", "both"]);
}
