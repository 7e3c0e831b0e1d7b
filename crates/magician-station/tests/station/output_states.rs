//! States of tools and laser that subscribers receive while a job runs.

use std::time::Duration;

use magician_station::Role;
use serde_json::{Value, json};

use crate::bench::{LocalStation, Tester};

/// Interval of readings. A change of a tool is sent with the next one.
const READING: Duration = Duration::from_millis(50);

const GRIPPER: [&str; 3] = ["open", "closed", "off"];

/// Program that burns four lines.
const BURNS: &str =
    "G21\nG90\nM4 S1000\nG0 X0 Y0\nG1 X30 Y0 F1200\nG1 X30 Y30\nG1 X0 Y30\nG1 X0 Y0\nM5\n";

fn burning_job() -> Value {
    let setup = json!({"tool": "laser", "surface": 0, "s_max": 1000});
    json!({"text": BURNS, "format": "gcode", "setup": setup, "yes": true})
}

/// Subscriber that accumulates the changes it receives.
struct Subscriber {
    tester: Tester,
    binary: bool,
    state: Value,
}

impl Subscriber {
    async fn new(bench: &LocalStation, rate: u32, binary: bool) -> Self {
        let mut tester = bench.join("Viewer").await;
        let frame = if binary { "binary" } else { "json" };
        let params = json!({"rate": rate, "frame": frame});
        tester.ok("arm.subscribe", params).await;
        Self {
            tester,
            binary,
            state: json!({}),
        }
    }

    async fn listen(&mut self, time: Duration) {
        self.tester.listen(time).await;
        for (name, params) in self.tester.notices.drain(..) {
            if name == "arm.state" {
                let fields = params["state"].as_object().unwrap().clone();
                self.state.as_object_mut().unwrap().extend(fields);
            }
        }
    }

    fn laser(&self) -> Value {
        match (self.binary, self.tester.frames.last()) {
            (true, Some(frame)) => {
                let flags = f64::from_le_bytes(frame[104..112].try_into().unwrap());
                json!(flags as u32 & 8 != 0)
            }
            _ => self.state["tool"]["laser"].clone(),
        }
    }
}

#[tokio::test(start_paused = true)]
async fn burning_laser_is_reported_to_every_subscriber() {
    let bench = LocalStation::new(1).await;
    let mut text = Subscriber::new(&bench, 20, false).await;
    let mut bytes = Subscriber::new(&bench, 10, true).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    text.listen(Duration::from_secs(1)).await;
    bytes.listen(Duration::from_millis(1)).await;
    assert_eq!((text.laser(), bytes.laser()), (json!(false), json!(false)));
    let job = anna.ok("job.start", burning_job()).await["job"].clone();
    let (mut burnt, mut burning) = (0, 0);
    let mut state = json!("queued");
    while state != json!("done") {
        assert!(burnt < 2000 && state != json!("failed"), "{state}");
        text.listen(READING).await;
        bytes.listen(Duration::from_millis(1)).await;
        burning = if bench.arms[0].state().laser {
            burning + 1
        } else {
            0
        };
        burnt += u32::from(burning > 0);
        // Three readings: one in flight, and one of the slower subscriber.
        if burning > 2 {
            assert_eq!((text.laser(), bytes.laser()), (json!(true), json!(true)));
        }
        state = anna.ok("job.get", json!({"job": job})).await["state"].clone();
    }
    assert!(burnt > 50, "{burnt}");
    text.listen(Duration::from_millis(200)).await;
    bytes.listen(Duration::from_millis(1)).await;
    assert!(!bench.arms[0].state().laser);
    assert_eq!((text.laser(), bytes.laser()), (json!(false), json!(false)));
}

#[tokio::test(start_paused = true)]
async fn first_state_after_a_stop_reports_laser_off() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    let mut text = Subscriber::new(&bench, 20, false).await;
    anna.ok("arm.tool", json!({"laser": {"on": true}})).await;
    text.listen(Duration::from_millis(200)).await;
    assert_eq!(text.laser(), json!(true));
    anna.ok("arm.stop", json!({})).await;
    assert!(!bench.arms[0].state().laser);
    let state = anna.ok("arm.state", json!({})).await;
    assert_eq!(state["tool"]["laser"], json!(false));
    text.listen(Duration::from_millis(100)).await;
    assert_eq!(text.laser(), json!(false));
}

#[tokio::test(start_paused = true)]
async fn stopped_job_reports_laser_off() {
    for end in ["arm.stop", "job.stop", "job.pause"] {
        let bench = LocalStation::new(1).await;
        let mut text = Subscriber::new(&bench, 20, false).await;
        let mut anna = bench.join("Anna").await;
        anna.lease().await;
        let job = anna.ok("job.start", burning_job()).await["job"].clone();
        while !bench.arms[0].state().laser {
            anna.listen(READING).await;
        }
        text.listen(Duration::from_millis(500)).await;
        assert_eq!(text.laser(), json!(true), "{end}");
        let params = match end {
            "arm.stop" => json!({}),
            _ => json!({"job": job}),
        };
        anna.ok(end, params).await;
        text.listen(Duration::from_secs(2)).await;
        assert!(!bench.arms[0].state().laser, "{end}");
        assert_eq!(text.laser(), json!(false), "{end}");
    }
}

#[tokio::test(start_paused = true)]
async fn suction_and_gripper_states_follow_execution() {
    let bench = LocalStation::new(1).await;
    let mut text = Subscriber::new(&bench, 20, false).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    let steps = json!([
        {"move": [220, 0, 20, 0]}, {"suction": true}, {"wait": 1.5}, {"move": [220, 60, 20, 0]},
        {"gripper": "close"}, {"wait": 1.5}, {"move": [220, 0, 20, 0]}, {"gripper": "open"}, {"wait": 1.5},
        {"suction": true}, {"move": [220, 60, 20, 0]},
    ]);
    let plan = json!({"format": "magician-plan", "version": 1, "steps": steps});
    let program = json!({"text": plan.to_string()});
    let job = anna.ok("job.start", program).await["job"].clone();
    let (mut before, mut same, mut seen) = ((false, false), 0, Vec::new());
    for _ in 0..900 {
        text.listen(READING).await;
        // A silent session loses the lease.
        anna.ok("job.get", json!({"job": job})).await;
        let state = bench.arms[0].state();
        let is = (state.suction.commanded, state.gripper.commanded);
        same = if is == before { same + 1 } else { 0 };
        before = is;
        if same < 4 {
            continue;
        }
        let tool = &text.state["tool"];
        let told = (
            tool["suction"] == json!(true),
            tool["gripper"] == json!("closed"),
        );
        assert_eq!(told, is, "{tool}");
        if seen.last() != Some(&is) {
            seen.push(is);
        }
    }
    assert_eq!(
        anna.ok("job.get", json!({"job": job})).await["state"],
        json!("done")
    );
    assert_eq!(
        seen,
        [
            (false, false),
            (true, false),
            (false, true),
            (false, false),
            (true, false)
        ]
    );
}

/// Any sequence of tool commands by any method: the reported state is that of the arm.
#[tokio::test(start_paused = true)]
async fn reported_outputs_match_the_arm_for_any_call_sequence() {
    for seed in 0..20_u64 {
        let bench = LocalStation::new(1).await;
        let mut text = Subscriber::new(&bench, 20, false).await;
        let mut anna = bench.join_as("Anna", Role::Teacher).await;
        anna.lease().await;
        let mut dice = seed;
        let mut any = |end: u64| {
            dice = dice
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (dice >> 33) % end
        };
        let mut calls = Vec::new();
        for _ in 0..25 {
            let on = any(2);
            let flags = |on: u64, name: &str| json!({"enable_ctrl": 1, name: on});
            let (method, params) = match any(10) {
                0 => ("arm.tool", json!({"suction": on == 1})),
                1 => ("arm.tool", json!({"gripper": GRIPPER[any(3) as usize]})),
                2 => ("arm.tool", json!({"laser": {"on": on == 1}, "yes": true})),
                3 => (
                    "arm.set",
                    json!({"command": "SetEndEffectorSuctionCup", "fields": flags(on, "suck")}),
                ),
                4 => (
                    "arm.enqueue",
                    json!({"command": "SetEndEffectorSuctionCup", "fields": flags(on, "suck")}),
                ),
                5 => (
                    "arm.enqueue",
                    json!({"command": "SetEndEffectorGripper", "fields": flags(on, "grip")}),
                ),
                6 => (
                    "arm.enqueue",
                    json!({"command": "SetEndEffectorLaser", "fields": flags(on, "on"), "yes": true}),
                ),
                7 => ("arm.set", json!({"command": "SetQueuedCmdStartExec"})),
                8 => ("arm.stop", json!({})),
                _ => ("arm.speed", json!({"percent": 20 + any(60)})),
            };
            calls.push(format!("{method} {params}"));
            let _ = anna.call(method, params).await;
            text.listen(4 * READING).await;
            let state = bench.arms[0].state();
            let tool = &text.state["tool"];
            let told = (tool["suction"].clone(), tool["gripper"] == json!("closed"));
            let is = (json!(state.suction.commanded), state.gripper.commanded);
            assert_eq!(told, is, "{seed}: {tool} {calls:#?}");
            // A laser command that waits in a stopped queue counts as burning.
            assert!(
                !state.laser || tool["laser"] == json!(true),
                "{seed}: {tool} {calls:#?}"
            );
        }
        anna.ok("arm.stop", json!({})).await;
        text.listen(4 * READING).await;
        assert_eq!(text.laser(), json!(false), "{seed}: {calls:#?}");
    }
}

#[tokio::test(start_paused = true)]
async fn move_is_answered_with_the_state_at_rest() {
    let bench = LocalStation::new(1).await;
    let mut text = Subscriber::new(&bench, 20, false).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    for y in [40, -40, 0] {
        let state = anna.ok("arm.move", json!({"to": [220, y, 20, 0]})).await;
        assert_eq!(state["moving"], json!(false), "{state}");
        text.state["moving"] = json!(false);
        text.tester.notices.clear();
        text.listen(Duration::from_millis(300)).await;
        assert_eq!(text.state["moving"], json!(false));
    }
}
