//! Motor outputs and a lit laser: they have no end of their own, so they end with the lease and
//! with a stop.

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
async fn stop_switches_motors_off() {
    let bench = LocalStation::new(1).await;
    let (_anna, _) = turning(&bench).await;
    // Any session may stop.
    let mut ben = bench.join("Ben").await;
    ben.ok("arm.stop", json!({})).await;
    assert!(!turns(&bench));
}

/// Requests that switch on what has no end of its own, by the method.
fn unattended() -> [(&'static str, Vec<(&'static str, serde_json::Value)>); 5] {
    let set = |command: &str, fields: serde_json::Value| {
        let params = json!({"command": command, "fields": fields, "yes": true});
        ("arm.set", params)
    };
    let function = |address, multiplex| {
        let fields = json!({"address": address, "multiplex": multiplex});
        set("IOMultiplexing", fields)
    };
    let lit = json!({"enable_ctrl": 1, "on": 1});
    [
        ("a motor", vec![("arm.set", motor(1000))]),
        (
            "the laser",
            vec![("arm.tool", json!({"laser": {"on": true}, "yes": true}))],
        ),
        (
            "the laser by its command",
            vec![set("SetEndEffectorLaser", lit)],
        ),
        (
            "a level on a pin",
            vec![
                function(2, 1),
                set("IODO", json!({"address": 2, "level": 1})),
            ],
        ),
        (
            "pulses on a pin",
            vec![
                function(4, 2),
                set(
                    "IOPWM",
                    json!({"address": 4, "frequency": 1000, "duty_cycle": 50}),
                ),
            ],
        ),
    ]
}

/// True if the arm itself has a motor, the laser or one of the laser's pins on.
fn is_on(bench: &LocalStation) -> bool {
    let pins = bench.arms[0].with(|arm| arm.pins());
    let high = [2, 4].map(|address: usize| &pins[address - 1]);
    let high = high.iter().any(|pin| pin.level || pin.duty_cycle > 0.0);
    turns(bench) || bench.arms[0].state().laser || high
}

#[tokio::test(start_paused = true)]
async fn motors_and_laser_go_off_with_every_lease_end() {
    let ends = ["released", "at once", "taken", "granted", "left", "silent"];
    let unattended = unattended();
    for ((what, requests), end) in unattended.iter().flat_map(|on| ends.map(|end| (on, end))) {
        let bench = LocalStation::new(1).await;
        let mut anna = bench.join_as("Anna", magician_station::Role::Teacher).await;
        let mut ben = bench.join_as("Ben", magician_station::Role::Teacher).await;
        let lease = anna.lease().await;
        // A release that follows at once must not overtake the requests.
        let at_once = end == "at once";
        for (method, params) in requests {
            if at_once {
                anna.send(method, params.clone());
            } else {
                anna.ok(method, params.clone()).await;
            }
        }
        assert!(at_once || is_on(&bench), "{what}");
        match end {
            "released" | "at once" => {
                anna.ok("lease.release", json!({"lease": lease})).await;
            }
            "taken" => drop(ben.ok("lease.take", json!({})).await),
            "granted" => {
                let asked = ben.send("lease.ask", json!({}));
                anna.listen(Duration::from_millis(10)).await;
                let session = anna.noticed("lease.asked")[0]["session"].clone();
                let grant = json!({"session": session, "grant": true});
                anna.ok("lease.answer", grant).await;
                ben.answer(asked).await.unwrap();
            }
            "left" => {
                drop(anna);
                ben.listen(Duration::from_secs(6)).await;
            }
            _ => ben.listen(Duration::from_secs(6)).await,
        }
        sleep(Duration::from_millis(200)).await;
        assert!(!is_on(&bench), "{what}, {end}");
    }
}

#[tokio::test(start_paused = true)]
async fn post_cannot_switch_motors_or_laser_on() {
    let bench = LocalStation::new(1).await;
    let path = json!({"command": "CPLECmd", "yes": true, "fields": {
        "cp_mode": 1, "x": 220, "y": 0, "z": 0, "velocity_or_power": 50}});
    let path = ("a path", vec![("arm.enqueue", path)]);
    for (what, requests) in unattended().into_iter().chain([path]) {
        let mut refused = false;
        for (method, params) in requests {
            let answer = bench.once(method, params).await;
            refused = answer["error"]["code"] == json!(-32600);
        }
        sleep(Duration::from_millis(200)).await;
        assert!(refused && !is_on(&bench), "{what}");
    }
    // Switching off is permitted to all.
    let off = json!({"laser": {"on": false}});
    let answer = bench.once("arm.tool", off).await;
    assert!(answer.get("error").is_none(), "{answer}");
}

#[tokio::test(start_paused = true)]
async fn queued_motor_command_is_dropped_with_the_lease() {
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
async fn post_cannot_start_a_motor() {
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
async fn belt_of_an_unheld_job_stops_with_the_job() {
    let bench = LocalStation::new(1).await;
    let job = json!({"text": belt_plan(), "format": "plan", "unhomed": true, "yes": true});
    let answer = bench.once("job.start", job).await;
    assert!(answer.get("result").is_some(), "{answer}");
    sleep(Duration::from_secs(5)).await;
    assert!(!turns(&bench));
}

#[tokio::test(start_paused = true)]
async fn job_leaving_belt_and_pump_on_has_notes() {
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
