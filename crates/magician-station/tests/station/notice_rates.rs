//! Rates of notifications about values that change often.

use std::collections::BTreeMap;
use std::time::Duration;

use magician::admission::Origin;
use magician_job::JobState;
use magician_station::{ArmOrder, ArmReport, JobUpdate, LIST_INTERVAL, Peer, SocketId};
use serde_json::{Value, json};

use crate::bare::BareStation;

/// Completes everything for disk and arm at once.
fn carry_out(bare: &mut BareStation) {
    loop {
        if let Some(jobs) = bare.station.poll_jobs() {
            let (arm, revision) = (jobs.arm(), jobs.revision());
            bare.station.jobs_written(bare.now, arm, revision, Ok(()));
        } else if let Some((_, order)) = bare.station.poll_order() {
            if let ArmOrder::StartJob(start) = order {
                let update = JobUpdate::State(JobState::Running, None);
                bare.report(ArmReport::Job {
                    job: start.job,
                    update,
                });
            }
        } else {
            break;
        }
    }
    for (name, file) in bare.station.poll_files() {
        bare.station
            .file_written(bare.now, name, file.revision, Ok(()));
    }
}

fn ask(bare: &mut BareStation, socket: SocketId, method: &str, params: &Value) {
    bare.ask(socket, method, params);
    carry_out(bare);
}

fn pass(bare: &mut BareStation, time: Duration) {
    bare.now += time;
    bare.station.handle_timeout(bare.now);
    carry_out(bare);
}

/// Returns the notifications with this name, and all answers.
fn received(bare: &mut BareStation, notice: &str) -> (Vec<Value>, Vec<Value>) {
    let received = bare.received().into_iter();
    let (notices, answers): (Vec<_>, Vec<_>) = received.partition(|it| it.get("method").is_some());
    for answer in &answers {
        assert!(answer.get("error").is_none(), "{answer}");
    }
    let of = notices.into_iter().filter(|it| it["method"] == notice);
    (of.map(|it| it["params"].clone()).collect(), answers)
}

#[test]
fn queue_positions_are_rate_limited_and_end_current() {
    const JOBS: usize = 20;
    const REORDERS: u32 = 190;
    let mut bare = BareStation::new();
    let socket = bare.socket;
    ask(&mut bare, socket, "lease.acquire", &json!({}));
    let text = json!({"format": "magician-plan", "version": 1, "title": "", "steps": []});
    for _ in 0..=JOBS {
        let start = json!({"text": text.to_string(), "queue": true, "after_check": false});
        ask(&mut bare, socket, "job.start", &start);
    }
    let (_, answers) = received(&mut bare, "job.changed");
    let ids: Vec<_> = answers[2..]
        .iter()
        .map(|it| it["result"]["job"].clone())
        .collect();
    assert_eq!(ids.len(), JOBS, "{answers:?}");
    pass(&mut bare, Duration::from_secs(1));
    received(&mut bare, "job.changed");
    let mut told: BTreeMap<String, Vec<Value>> = BTreeMap::new();
    let mut list = Vec::new();
    for at in 0..=REORDERS {
        if at < REORDERS {
            // The last job goes to the front, so that all positions change.
            let job = &ids[JOBS - 1 - at as usize % JOBS];
            ask(
                &mut bare,
                socket,
                "job.reorder",
                &json!({"job": job, "position": 1}),
            );
            bare.station.pong(bare.now, socket);
            pass(&mut bare, Duration::from_secs(1) / REORDERS);
        } else {
            pass(&mut bare, LIST_INTERVAL);
            ask(&mut bare, socket, "job.list", &json!({}));
        }
        let (notices, answers) = received(&mut bare, "job.changed");
        for notice in notices {
            let job = notice["job"]["job"].as_str().unwrap().to_owned();
            told.entry(job)
                .or_default()
                .push(notice["job"]["place"].clone());
        }
        list = answers.last().unwrap()["result"]["jobs"]
            .as_array()
            .cloned()
            .unwrap_or_default();
    }
    assert_eq!(told.len(), JOBS);
    for job in list.iter().filter(|job| job["state"] == "queued") {
        let places = &told[job["job"].as_str().unwrap()];
        // At once, then five times in the second, and the last one after it.
        assert!((2..=7).contains(&places.len()), "{places:?}");
        assert_eq!(places.last(), Some(&job["place"]));
    }
}

#[test]
fn each_job_state_is_notified_immediately() {
    let mut bare = BareStation::new();
    let socket = bare.socket;
    ask(&mut bare, socket, "lease.acquire", &json!({}));
    let text = json!({"format": "magician-plan", "version": 1, "title": "", "steps": []});
    let start = json!({"text": text.to_string(), "queue": true, "after_check": false});
    for _ in 0..2 {
        ask(&mut bare, socket, "job.start", &start);
    }
    let (notices, answers) = received(&mut bare, "job.changed");
    let job = answers[2]["result"]["job"].clone();
    ask(&mut bare, socket, "job.stop", &json!({"job": job}));
    let (stopped, _) = received(&mut bare, "job.changed");
    let states: Vec<_> = { notices.iter().chain(&stopped) }
        .map(|notice| notice["job"]["state"].clone())
        .collect();
    assert_eq!(states, ["checking", "running", "queued", "stopped"]);
}

#[test]
fn each_turn_change_is_notified_once() {
    const CLASS: &str = "[class]\nturn_s = 120\n\
        [[pupil]]\nname = \"Ada\"\ncode = \"7K3M\"\n\
        [[pupil]]\nname = \"Ben\"\ncode = \"9QWE\"\n";
    let mut bare = BareStation::new();
    let teacher = bare.socket;
    let pupil = |bare: &mut BareStation, name: &str, code: &str| {
        let peer = Peer {
            grant: None,
            origin: Origin::Elsewhere,
            address: String::new(),
            secret: format!("secret of {name}"),
        };
        let socket = bare.station.open(bare.now, peer);
        let pupil = json!({"name": name, "code": code});
        let hello = json!({"client": {"name": "page"}, "pupil": pupil});
        ask(bare, socket, "session.hello", &hello);
        socket
    };
    ask(&mut bare, teacher, "class.set", &json!({"text": CLASS}));
    let mut counts = vec![(
        "a class is set",
        received(&mut bare, "turn.changed").0.len(),
    )];
    let ada = pupil(&mut bare, "Ada", "7K3M");
    let ben = pupil(&mut bare, "Ben", "9QWE");
    let steps = [
        ("she gets the free arm", ada, "turn.join"),
        ("he waits", ben, "turn.join"),
        ("he follows her", ada, "turn.leave"),
        ("it is frozen", teacher, "class.freeze"),
        ("it is freed", teacher, "class.free"),
        ("he leaves", ben, "turn.leave"),
    ];
    assert!(received(&mut bare, "turn.changed").0.is_empty());
    for (what, socket, method) in steps {
        ask(&mut bare, socket, method, &json!({}));
        counts.push((what, received(&mut bare, "turn.changed").0.len()));
    }
    for (what, count) in &counts {
        assert_eq!(*count, 1, "{what}: {counts:?}");
    }
}
