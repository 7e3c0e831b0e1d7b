//! Jobs as clients see them: checked, run, paused, resumed and stopped, while leases change.

use std::time::Duration;

use magician::build;
use magician_program::{Action, Origin, Plan, Surface, Tool, Travel};
use magician_station::Role;
use serde_json::{Value, json};

use crate::bench::{LocalStation, Tester};

const PAPER: f64 = -60.0;

/// Returns a plan that draws lines slowly.
pub(crate) fn drawing() -> String {
    let mut plan = Plan::new("lines");
    plan.tool = Some(Tool::Pen);
    plan.surface = Some(Surface::level(PAPER));
    let paper = PAPER as f32;
    let mut push = |action: Action| plan.push(action, Origin::NONE);
    push(build::speed(20.0, 50.0).into());
    let line = |x, y, z| Action::Move {
        to: [x, y, z, 0.0],
        by: Travel::Line,
    };
    push(line(210.0, -40.0, paper + 15.0));
    push(line(210.0, -40.0, paper));
    for (x, y) in [(210.0, 40.0), (240.0, 40.0), (240.0, -40.0), (210.0, -40.0)] {
        push(line(x, y, paper));
    }
    push(line(210.0, -40.0, paper + 15.0));
    plan.to_json()
}

/// Returns a plan whose second step is out of reach.
fn too_far() -> String {
    let mut plan = Plan::new("far");
    for x in [220.0, 600.0] {
        let by = Travel::Line;
        let to = [x, 0.0, 50.0, 0.0];
        plan.push(Action::Move { to, by }, Origin::NONE);
    }
    plan.to_json()
}

async fn state_of(tester: &mut Tester, job: &Value) -> Value {
    tester.ok("job.get", json!({"job": job})).await
}

/// Waits until a job has this state.
pub(crate) async fn until(tester: &mut Tester, job: &Value, state: &str) -> Value {
    for _ in 0..2000 {
        let now = state_of(tester, job).await;
        if now["state"] == json!(state) {
            return now;
        }
        tester.listen(Duration::from_millis(100)).await;
    }
    panic!("never {state}: {}", state_of(tester, job).await);
}

async fn start(tester: &mut Tester, more: Value) -> Value {
    let mut params = json!({"text": drawing()});
    for (name, value) in more.as_object().unwrap() {
        params[name] = value.clone();
    }
    tester.ok("job.start", params).await["job"].clone()
}

/// True if the pen is above its paper.
fn pen_is_up(bench: &LocalStation) -> bool {
    bench.arms[0].state().pose.z > PAPER + 5.0
}

#[tokio::test(start_paused = true)]
async fn refused_program_carries_its_check_report() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let good = anna.ok("job.check", json!({"text": drawing()})).await;
    assert_eq!(
        (&good["ok"], &good["refused"], &good["steps"]),
        (&json!(true), &json!(0), &json!(8))
    );
    anna.lease().await;
    let before = bench.arms[0].state().pose;
    let refused = anna
        .call("job.start", json!({"text": too_far()}))
        .await
        .unwrap_err();
    assert_eq!(refused["code"], json!(-32004), "{refused}");
    let report = &refused["data"]["report"];
    assert_eq!(
        (&report["ok"], &report["complaints"][0]["step"]),
        (&json!(false), &json!(2))
    );
    let checked = anna.ok("job.check", json!({"text": too_far()})).await;
    assert_eq!(&checked, report);
    assert_eq!(bench.arms[0].state().pose, before);
    let soon = json!({"text": too_far(), "after_check": false});
    let job = anna.ok("job.start", soon).await["job"].clone();
    let failed = until(&mut anna, &job, "failed").await;
    assert_eq!(failed["error"]["report"]["ok"], json!(false));
    for (params, param) in [
        (json!({}), "text"),
        (json!({"text": "a", "data": "YQ=="}), "text"),
        (json!({"data": "?"}), "data"),
        (json!({"text": "{}", "format": "cobol"}), "format"),
    ] {
        let refused = anna.call("job.check", params.clone()).await.unwrap_err();
        assert_eq!(refused["data"]["param"], json!(param), "{params} {refused}");
    }
}

#[tokio::test(start_paused = true)]
async fn completed_job_is_counted_and_notified() {
    let bench = LocalStation::new(1).await;
    let (mut anna, mut ben) = (bench.join("Anna").await, bench.join("Ben").await);
    assert_eq!(
        anna.code("job.start", json!({"text": drawing()})).await,
        -32002
    );
    anna.lease().await;
    ben.ok("arm.subscribe", json!({"rate": 10})).await;
    let job = start(&mut anna, json!({"loops": 2})).await;
    let running = state_of(&mut anna, &job).await;
    assert_eq!(
        (&running["state"], &running["title"], &running["steps"]),
        (&json!("running"), &json!("lines"), &json!(8))
    );
    ben.listen(Duration::from_millis(300)).await;
    let list = ben.ok("arm.list", json!({})).await;
    assert_eq!(list["arms"][0]["job"], job);
    assert_eq!(anna.code("arm.home", json!({})).await, -32003);
    let busy = anna
        .call("job.start", json!({"text": drawing()}))
        .await
        .unwrap_err();
    assert_eq!(
        (&busy["code"], &busy["data"]["job"]),
        (&json!(-32003), &job)
    );
    let done = until(&mut anna, &job, "done").await;
    assert_eq!(
        (&done["step"], &done["loop"], &done["loops"]),
        (&json!(8), &json!(2), &json!(2))
    );
    assert!(done["drawn_mm"].as_f64().unwrap() > 400.0, "{done}");
    assert!(done["ended"].as_f64() > done["started"].as_f64());
    ben.listen(Duration::from_millis(200)).await;
    let told = ben.noticed("job.changed");
    let states: Vec<_> = told
        .iter()
        .map(|told| told["job"]["state"].as_str().unwrap())
        .collect();
    assert_eq!((states[0], states[states.len() - 1]), ("checking", "done"));
    let mut last = (0, 0);
    for told in told {
        let job = &told["job"];
        let at = (job["loop"].as_u64().unwrap(), job["step"].as_u64().unwrap());
        assert!(at >= last, "{at:?} after {last:?}");
        last = at;
    }
    let events: Vec<_> = { ben.noticed("arm.event").into_iter() }
        .filter(|event| event["event"] == "job")
        .map(|event| event["state"].clone())
        .collect();
    assert_eq!(events, ["checking", "running", "done"]);
    let states: Vec<_> = { ben.noticed("arm.state").into_iter() }
        .filter_map(|told| told["state"].get("job").cloned())
        .collect();
    assert!(states.contains(&job) && states.last() == Some(&json!(null)));
    anna.ok("arm.move", json!({"to": [220, 0, 50, 0]})).await;
    let list = ben.ok("job.list", json!({})).await;
    assert_eq!(list["jobs"].as_array().unwrap().len(), 1);
}

#[tokio::test(start_paused = true)]
async fn arm_may_move_during_a_pause_and_job_resumes() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    let job = start(&mut anna, json!({})).await;
    anna.listen(Duration::from_secs(4)).await;
    let paused = anna.ok("job.pause", json!({"job": job})).await;
    assert_eq!(
        (&paused["state"], &paused["reason"]),
        (&json!("paused"), &json!("person"))
    );
    assert!(pen_is_up(&bench) && !bench.arms[0].state().moving);
    assert_eq!(
        anna.code("job.start", json!({"text": drawing()})).await,
        -32003
    );
    // Without an approach it resumes from where it was left, but not from elsewhere.
    anna.ok("arm.move", json!({"to": [220, 0, 50, 0]})).await;
    let refused = anna
        .call("job.resume", json!({"job": job, "approach": false}))
        .await
        .unwrap_err();
    assert_eq!(refused["data"]["kind"], json!("unexpected"), "{refused}");
    assert!(refused["data"]["expected"]["x"].is_number());
    let running = anna.ok("job.resume", json!({"job": job})).await;
    assert_eq!(running["state"], json!("running"));
    let done = until(&mut anna, &job, "done").await;
    assert_eq!(done["step"], json!(8));
    let over = anna
        .call("job.pause", json!({"job": job}))
        .await
        .unwrap_err();
    assert_eq!(over["data"]["kind"], json!("invalid-input"));
}

#[tokio::test(start_paused = true)]
async fn job_stop_lifts_the_pen_and_arm_stop_does_not() {
    for (method, up) in [("job.stop", true), ("arm.stop", false)] {
        let bench = LocalStation::new(1).await;
        let mut viewer = bench.join_as("Viewer", Role::Viewer).await;
        let mut anna = bench.join("Anna").await;
        anna.lease().await;
        let job = start(&mut anna, json!({})).await;
        // Half way along a line.
        while pen_is_up(&bench) {
            anna.listen(Duration::from_millis(50)).await;
        }
        let params = if up { json!({"job": job}) } else { json!({}) };
        viewer.ok(method, params).await;
        let stopped = until(&mut viewer, &job, "stopped").await;
        assert_eq!(stopped["error"], json!(null));
        assert_eq!(pen_is_up(&bench), up, "{method}");
        assert!(!bench.arms[0].state().moving);
        // The lease is kept, and the job resumes where it was stopped.
        let running = anna.ok("job.resume", json!({"job": job})).await;
        assert_eq!(
            (&running["state"], &running["job"]),
            (&json!("running"), &job)
        );
        until(&mut anna, &job, "done").await;
    }
}

#[tokio::test(start_paused = true)]
async fn job_follows_its_on_lost_policy() {
    for (on_lost, state) in [
        (json!({}), "paused"),
        (json!({"on_lost": "stop"}), "stopped"),
        (json!({"on_lost": "continue"}), "done"),
    ] {
        let bench = LocalStation::new(1).await;
        let mut anna = bench.join("Anna").await;
        let mut teacher = bench.join_as("Teacher", Role::Teacher).await;
        anna.lease().await;
        let job = start(&mut anna, on_lost).await;
        anna.listen(Duration::from_secs(4)).await;
        teacher.ok("lease.take", json!({})).await;
        until(&mut teacher, &job, state).await;
        if state == "paused" {
            assert_eq!(anna.code("job.resume", json!({"job": job})).await, -32002);
            // The next holder moves the arm and loses its lease on the way. The job stays paused.
            let mut other = bench.join_as("Other", Role::Teacher).await;
            let moving = teacher.send("arm.move", json!({"to": [200, 150, 80, 0]}));
            teacher.listen(Duration::from_millis(300)).await;
            other.ok("lease.take", json!({})).await;
            let ended = teacher.answer(moving).await.unwrap_err();
            assert_eq!(ended["code"], json!(-32002));
            other.listen(Duration::from_secs(1)).await;
            assert!(!bench.arms[0].state().moving);
            let left = state_of(&mut other, &job).await;
            assert_eq!(left["state"], json!("paused"));
            other.ok("job.resume", json!({"job": job})).await;
            until(&mut other, &job, "done").await;
        }
    }
}

#[tokio::test(start_paused = true)]
async fn job_of_a_single_request_continues_without_lease() {
    let bench = LocalStation::new(1).await;
    let mut viewer = bench.join_as("Viewer", Role::Viewer).await;
    let job = bench.once("job.start", json!({"text": drawing()})).await["result"]["job"].clone();
    let list = viewer.ok("arm.list", json!({})).await;
    assert_eq!(
        (&list["arms"][0]["job"], &list["arms"][0]["holder"]),
        (&job, &json!(null))
    );
    viewer.listen(Duration::from_secs(2)).await;
    let running = state_of(&mut viewer, &job).await;
    assert_eq!(running["state"], json!("running"));
    let paused = bench.once("job.pause", json!({"job": job})).await;
    assert_eq!(paused["result"]["state"], json!("paused"), "{paused}");
    let running = bench.once("job.resume", json!({"job": job})).await;
    assert_eq!(running["result"]["state"], json!("running"), "{running}");
    until(&mut viewer, &job, "done").await;
}

#[tokio::test(start_paused = true)]
async fn job_of_a_crashed_station_is_interrupted() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    let job = start(&mut anna, json!({})).await;
    bench.station.flush().await;
    let kept = bench.kept.copy();
    drop((anna, bench));
    let bench = LocalStation::after(kept).await;
    let mut ben = bench.join("Ben").await;
    let left = state_of(&mut ben, &job).await;
    assert_eq!(
        (&left["state"], &left["title"]),
        (&json!("interrupted"), &json!("lines"))
    );
    let list = ben.ok("arm.list", json!({})).await;
    assert_eq!(list["arms"][0]["job"], json!(null));
    ben.lease().await;
    // The progress of the job is unknown, so the station refuses, like `run --resume`.
    let refused = ben.call("job.resume", json!({"job": job})).await;
    let data = &refused.unwrap_err()["data"];
    assert_eq!(data["kind"], json!("invalid-input"));
    assert_eq!(data["code"], json!("nothing-to-resume"));
    let fresh = start(&mut ben, json!({})).await;
    assert_ne!(fresh, job);
    until(&mut ben, &fresh, "done").await;
    assert_eq!(ben.ok("job.list", json!({})).await["jobs"][0]["job"], job);
}

#[tokio::test(start_paused = true)]
async fn job_of_a_crashed_station_keeps_recent_progress() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    let job = start(&mut anna, json!({"loops": 0})).await;
    let done = |job: &Value| 8 * job["loop"].as_u64().unwrap() + job["step"].as_u64().unwrap();
    while done(&state_of(&mut anna, &job).await) < 3 * 8 {
        tokio::time::sleep(Duration::from_secs(1)).await;
    }
    tokio::time::sleep(Duration::from_secs(3)).await;
    let shown = done(&state_of(&mut anna, &job).await);
    bench.station.flush().await;
    let kept = bench.kept.copy();
    drop((anna, bench));
    let bench = LocalStation::after(kept).await;
    let mut ben = bench.join("Ben").await;
    let left = state_of(&mut ben, &job).await;
    assert_eq!(left["state"], json!("interrupted"));
    assert!((2 * 8..=shown).contains(&done(&left)), "{left} {shown}");
}

#[tokio::test(start_paused = true)]
async fn arm_speed_slows_the_running_job() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    let job = start(&mut anna, json!({})).await;
    anna.ok("arm.speed", json!({"percent": 50})).await;
    let refused = anna.call("arm.speed", json!({"percent": 5})).await;
    assert_eq!(refused.unwrap_err()["data"]["kind"], json!("invalid-input"));
    anna.ok("job.stop", json!({"job": job})).await;
    anna.ok("arm.speed", json!({"percent": 5})).await;
}

#[tokio::test(start_paused = true)]
async fn job_list_has_fifty_entries_and_history_more() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    for _ in 0..53 {
        let params = json!({"text": too_far()});
        anna.call("job.start", params).await.unwrap_err();
    }
    let jobs = anna.ok("job.list", json!({})).await["jobs"].clone();
    assert_eq!(jobs.as_array().unwrap().len(), 50);
    bench.station.flush().await;
    let kept = bench.kept.jobs.lock().unwrap().clone();
    assert_eq!(kept["jobs"].as_array().unwrap().len(), 53);
}

#[tokio::test(start_paused = true)]
async fn burning_job_needs_a_teacher_and_confirmation() {
    let mut burns = Plan::new("burns");
    burns.push(Action::from(build::laser(true)), Origin::NONE);
    burns.push(Action::from(build::laser(false)), Origin::NONE);
    let bench = LocalStation::real(1).await;
    let program = json!({"text": burns.to_json()});
    let mut pupil = bench.join("Pupil").await;
    let lease = pupil.lease().await;
    assert_eq!(pupil.code("job.start", program.clone()).await, -32001);
    pupil.ok("lease.release", json!({"lease": lease})).await;
    let mut teacher = bench.join_as("Teacher", Role::Teacher).await;
    teacher.lease().await;
    let refused = teacher.call("job.start", program.clone()).await;
    let refused = refused.unwrap_err();
    assert_eq!(
        (&refused["code"], &refused["data"]["danger"]),
        (&json!(-32005), &json!("laser"))
    );
    assert!(!bench.arms[0].state().laser);
    let list = teacher.ok("job.list", json!({})).await;
    assert_eq!(list["jobs"][1]["error"]["kind"], json!("dangerous"));
    let mut meant = program;
    meant["yes"] = json!(true);
    let job = teacher.ok("job.start", meant).await["job"].clone();
    until(&mut teacher, &job, "done").await;
    assert!(!bench.arms[0].state().laser);
}

/// A laser without a page may be unattended, so the job does not wait for the end of the lease.
#[tokio::test(start_paused = true)]
async fn burning_job_ends_when_its_holder_disconnects() {
    let mut burns = Plan::new("burns");
    let by = Travel::Line;
    let to = [200.0, 0.0, 0.0, 0.0];
    burns.push(Action::Move { to, by }, Origin::NONE);
    burns.push(Action::from(build::path_speed(5.0, 100.0)), Origin::NONE);
    let to = [200.0, 100.0, 0.0];
    burns.push(Action::Burn { to, power: 60.0 }, Origin::NONE);
    burns.push(Action::Laser(false), Origin::NONE);
    for (on_lost, state) in [
        ("pause", "paused"),
        ("stop", "stopped"),
        ("continue", "running"),
    ] {
        let bench = LocalStation::real(1).await;
        let mut watcher = bench.join("Watcher").await;
        let mut teacher = bench.socket(Some(Role::Teacher));
        let client = json!({"client": {"name": "Teacher"}});
        let hello = teacher.ok("session.hello", client).await;
        teacher.lease().await;
        let program = json!({"text": burns.to_json(), "yes": true, "on_lost": on_lost});
        let job = teacher.ok("job.start", program).await["job"].clone();
        teacher.listen(Duration::from_secs(5)).await;
        assert!(bench.arms[0].state().laser, "{on_lost}");
        drop(teacher);
        watcher.listen(Duration::from_millis(1500)).await;
        assert_eq!(
            bench.arms[0].state().laser,
            on_lost == "continue",
            "{on_lost}"
        );
        let left = state_of(&mut watcher, &job).await;
        assert_eq!(left["state"], json!(state));
        // The reloaded page has the lease, and the job resumes when a person says so.
        let mut back = bench.socket(Some(Role::Teacher));
        let client = json!({"client": {"name": "Teacher"}, "resume": hello["resume"]});
        assert_eq!(
            back.ok("session.hello", client).await["resumed"],
            json!(true)
        );
        back.listen(Duration::from_secs(4)).await;
        assert_eq!(
            bench.arms[0].state().laser,
            on_lost == "continue",
            "{on_lost}"
        );
        if on_lost == "pause" {
            back.ok("job.resume", json!({"job": job, "yes": true}))
                .await;
            back.listen(Duration::from_secs(2)).await;
            assert!(bench.arms[0].state().laser);
        }
    }
}

/// Returns the distance before the place of the stop at which a burn resumes, mm.
async fn burnt_again(overlap: Value) -> f64 {
    let mut burns = Plan::new("burns");
    let by = Travel::Line;
    let to = [200.0, 0.0, 0.0, 0.0];
    burns.push(Action::Move { to, by }, Origin::NONE);
    burns.push(Action::from(build::path_speed(20.0, 100.0)), Origin::NONE);
    let to = [200.0, 100.0, 0.0];
    burns.push(Action::Burn { to, power: 60.0 }, Origin::NONE);
    burns.push(Action::Laser(false), Origin::NONE);
    let bench = LocalStation::new(1).await;
    let mut teacher = bench.join_as("Teacher", Role::Teacher).await;
    teacher.lease().await;
    let program = json!({"text": burns.to_json(), "yes": true});
    let job = teacher.ok("job.start", program).await["job"].clone();
    while !bench.arms[0].state().laser {
        teacher.listen(Duration::from_millis(50)).await;
    }
    teacher.listen(Duration::from_secs(2)).await;
    teacher.ok("job.pause", json!({"job": job})).await;
    until(&mut teacher, &job, "paused").await;
    let mut resume = json!({"job": job, "yes": true});
    if !overlap.is_null() {
        let refused = json!({"job": job, "yes": true, "overlap": overlap});
        assert_eq!(
            teacher.code("job.resume", refused).await,
            -32602,
            "it is only paused"
        );
        resume["overlap"] = overlap;
    }
    teacher.ok("job.stop", json!({"job": job})).await;
    until(&mut teacher, &job, "stopped").await;
    let y = || bench.arms[0].state().pose.y;
    let stopped = y();
    teacher.ok("job.resume", resume).await;
    while !bench.arms[0].state().laser {
        teacher.listen(Duration::from_millis(10)).await;
    }
    let lit = y();
    until(&mut teacher, &job, "done").await;
    stopped - lit
}

#[tokio::test(start_paused = true)]
async fn resumed_burn_starts_before_its_end_by_the_overlap() {
    let again = [
        burnt_again(Value::Null).await,
        burnt_again(json!(6.5)).await,
    ];
    for (found, said) in again.into_iter().zip([0.0, 6.5]) {
        assert!((found - said).abs() < 0.5, "{found}, not {said}");
    }
}

/// The arm needs another pen: every client can read which.
#[tokio::test(start_paused = true)]
async fn job_paused_between_parts_reports_its_reason() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    let two = "<svg xmlns='http://www.w3.org/2000/svg' width='30mm' height='30mm' viewBox='0 0 30 30'>\
        <path d='M5 5H25' stroke='red'/><path d='M5 15H25' stroke='blue'/></svg>";
    let setup = json!({"surface": PAPER, "parts": "color", "pens": [{"match": "blue", "lift": 6}]});
    let params = json!({"text": two, "format": "svg", "setup": setup});
    let job = anna.ok("job.start", params).await["job"].clone();
    let paused = until(&mut anna, &job, "paused").await;
    assert_eq!(
        (&paused["reason"], &paused["part"], &paused["text"]),
        (
            &json!("part"),
            &json!(2),
            &json!("mount the pen for part 2, #0000ff")
        )
    );
    assert!(pen_is_up(&bench));
    anna.listen(Duration::from_secs(5)).await;
    assert!(!bench.arms[0].state().moving);
    assert_eq!(state_of(&mut anna, &job).await["state"], json!("paused"));
    anna.lease().await;
    let running = anna.ok("job.resume", json!({"job": job})).await;
    assert_eq!(
        (&running["state"], &running["text"]),
        (&json!("running"), &json!(null))
    );
    until(&mut anna, &job, "done").await;
    anna.lease().await;
    let wrong = json!({"surface": PAPER, "pens": [{"match": "blue", "width": 6}]});
    let params = json!({"text": two, "format": "svg", "setup": wrong});
    let refused = anna.call("job.start", params).await.unwrap_err();
    let message = refused["message"].as_str().unwrap_or_default();
    assert!(message.contains("unknown field `width`"), "{refused}");
}
