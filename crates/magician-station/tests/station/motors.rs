//! Motor outputs: they have no end of their own, so they end with the lease and with a stop.

use std::time::Duration;

use serde_json::json;
use tokio::time::sleep;

use crate::bench::{LocalStation, Tester};

fn motor(speed: i32) -> serde_json::Value {
    let enabled = u8::from(speed != 0);
    json!({"command": "EMotor", "fields": {"index": 0, "is_enabled": enabled, "speed": speed}})
}

fn turns(bench: &LocalStation) -> bool {
    let steppers = bench.arms[0].with(|arm| arm.steppers());
    steppers
        .iter()
        .any(|stepper| stepper.pulses_per_second != 0.0)
}

async fn turning(bench: &LocalStation) -> (Tester, serde_json::Value) {
    let mut anna = bench.join("Anna").await;
    let lease = anna.lease().await;
    anna.ok("arm.set", motor(1000)).await;
    assert!(turns(bench));
    (anna, lease)
}

#[tokio::test(start_paused = true)]
async fn stop_switches_a_motor_off() {
    let bench = LocalStation::new(1).await;
    let (_anna, _) = turning(&bench).await;
    // Any session may stop.
    let mut ben = bench.join("Ben").await;
    ben.ok("arm.stop", json!({})).await;
    assert!(!turns(&bench));
}

#[tokio::test(start_paused = true)]
async fn motor_ends_with_the_lease_that_is_released_taken_or_left() {
    for end in 0..3 {
        let bench = LocalStation::new(1).await;
        let (mut anna, lease) = turning(&bench).await;
        let mut teacher = bench.join_as("T", magician_station::Role::Teacher).await;
        match end {
            0 => drop(anna.ok("lease.release", json!({"lease": lease})).await),
            1 => drop(teacher.ok("lease.take", json!({})).await),
            _ => {
                drop(anna);
                teacher.listen(Duration::from_secs(6)).await;
            }
        }
        sleep(Duration::from_millis(100)).await;
        assert!(!turns(&bench), "end {end}");
    }
}

#[tokio::test(start_paused = true)]
async fn motor_that_waits_in_the_queue_does_not_begin_after_the_lease() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let lease = anna.lease().await;
    let wait = json!({"command": "WAITCmd", "fields": {"timeout": 2000}});
    anna.ok("arm.enqueue", wait).await;
    anna.ok("arm.enqueue", motor(1000)).await;
    anna.ok("arm.set", json!({"command": "QueuedCmdStartExec"}))
        .await;
    anna.ok("lease.release", json!({"lease": lease})).await;
    sleep(Duration::from_secs(5)).await;
    assert!(!turns(&bench));
}

#[tokio::test(start_paused = true)]
async fn motor_is_not_started_by_post() {
    let bench = LocalStation::new(1).await;
    for method in ["arm.set", "arm.enqueue"] {
        let answer = bench.once(method, motor(1000)).await;
        assert_eq!(answer["error"]["code"], json!(-32600), "{answer}");
    }
    sleep(Duration::from_millis(100)).await;
    assert!(!turns(&bench));
    // Switching off is permitted to all.
    let answer = bench.once("arm.set", motor(0)).await;
    assert!(answer.get("error").is_none(), "{answer}");
}

/// Returns a plan that leaves a belt running.
fn belt_plan() -> String {
    let belt = json!({"command": "EMotor", "values": {"index": 0, "is_enabled": 1, "speed": 1000}});
    let wait = json!({"command": "WAITCmd", "values": {"timeout": 500}});
    json!({"format": "magician-plan", "version": 1, "steps": [belt, wait]}).to_string()
}

#[tokio::test(start_paused = true)]
async fn belt_of_a_job_that_nobody_holds_ends_with_the_job() {
    let bench = LocalStation::new(1).await;
    let job = json!({"text": belt_plan(), "format": "plan", "unhomed": true, "yes": true});
    let answer = bench.once("job.start", job).await;
    assert!(answer.get("result").is_some(), "{answer}");
    sleep(Duration::from_secs(5)).await;
    assert!(!turns(&bench));
}

#[tokio::test(start_paused = true)]
async fn job_that_leaves_belt_and_pump_on_says_so_in_notes() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    let suction =
        json!({"command": "SetEndEffectorSuctionCup", "values": {"enable_ctrl": 1, "suck": 1}});
    let belt = json!({"command": "EMotor", "values": {"index": 0, "is_enabled": 1, "speed": 1000}});
    let plan = json!({"format": "magician-plan", "version": 1, "steps": [suction, belt]});
    let job = json!({"text": plan.to_string(), "format": "plan", "unhomed": true, "yes": true});
    let id = anna.ok("job.start", job).await["job"].clone();
    sleep(Duration::from_secs(5)).await;
    let job = anna.ok("job.get", json!({"job": id})).await;
    assert_eq!(job["state"], json!("done"), "{job}");
    assert!(turns(&bench), "its session holds the arm");
    let notes: Vec<_> = { job["notes"].as_array().unwrap().iter() }
        .map(|note| {
            (
                note["code"].clone(),
                note["text"].as_str().unwrap().to_owned(),
            )
        })
        .collect();
    assert_eq!(notes.len(), 2, "{job}");
    assert!(notes.iter().all(|(code, _)| code == "left-on"), "{job}");
    assert!(notes[0].1.starts_with("motor 1 runs on"), "{job}");
    assert!(
        notes[1].1.starts_with("the suction cup is still on"),
        "{job}"
    );
}
