//! Routing of requests to stations, and renaming of ids.

use std::time::Duration;

use magician_station::http::{ApiClient, ApiServer};
use magician_station::{Grant, Peer, Role};
use serde_json::{Value, json};

use crate::bench::TestHub;

/// Plan with this number of moves.
fn plan(moves: usize) -> Value {
    let steps: Vec<_> = (0..moves)
        .map(|at| json!({"move": [220, at % 20, 20, 0]}))
        .collect();
    json!({"format": "magician-plan", "version": 1, "steps": steps})
}

#[tokio::test(start_paused = true)]
async fn the_arms_of_all_stations_are_those_of_one() {
    let bench = TestHub::new(3, 3).await;
    let mut anna = bench.socket();
    let hello = anna
        .ok("session.hello", json!({"client": {"name": "Anna"}}))
        .await;
    let names: Vec<_> = (0..9).map(|at| json!(format!("arm{at}"))).collect();
    assert_eq!(
        (&hello["arms"], &hello["hub"]),
        (&json!(names), &json!(true))
    );
    // No line is opened before a station is needed.
    assert_eq!(bench.site.opened(), 0);
    let list = anna.ok("arm.list", json!({})).await;
    let row = json!({"name": "arm4", "port": "sim", "virtual": true, "link": "up", "holder": null, "waiting": [], "job": null});
    assert_eq!(list["arms"][4], row);
    assert_eq!(list["arms"].as_array().unwrap().len(), 9);
    assert_eq!(bench.site.opened(), 3);
    let info = anna.ok("server.info", json!({})).await;
    assert_eq!(info["arms"], json!(names));
    // The machine stays listed after the arm has left.
    bench.site.news(2, "arm4").await;
    anna.live(Duration::from_millis(50)).await;
    assert_eq!(anna.row("arm4").await["machine"], "test");
    bench.site.cut(2);
    anna.live(Duration::from_millis(50)).await;
    let row = anna.row("arm4").await;
    assert_eq!(
        (&row["machine"], &row["link"]),
        (&json!("test"), &json!("lost"))
    );
}

#[tokio::test(start_paused = true)]
async fn a_request_goes_to_the_station_of_its_arm() {
    let bench = TestHub::new(3, 3).await;
    let mut anna = bench.join("Anna").await;
    anna.take_arm("arm7").await;
    let state = anna
        .ok("arm.move", json!({"arm": "arm7", "to": [220, 40, 20, 0]}))
        .await;
    assert_eq!(state["arm"], "arm7");
    assert_eq!(bench.site.opened(), 1);
    let others = ["arm0", "arm4", "arm6", "arm8"];
    for other in others {
        let state = anna.ok("arm.state", json!({"arm": other})).await;
        assert!(state["y"].as_f64().unwrap().abs() < 1.0, "{other}");
    }
    let error = anna.fails("arm.state", json!({"arm": "nobody"})).await;
    assert_eq!(
        (&error["code"], &error["data"]["param"]),
        (&json!(-32602), &json!("arm"))
    );
    let error = anna.fails("arm.state", json!({})).await;
    assert_eq!(error["data"]["param"], "arm");
}

#[tokio::test(start_paused = true)]
async fn the_same_ids_of_two_stations_are_two() {
    let bench = TestHub::new(3, 3).await;
    let mut anna = bench.join("Anna").await;
    let leases = [anna.take_arm("arm0").await, anna.take_arm("arm3").await];
    assert_ne!(leases[0], leases[1]);
    let mut jobs = Vec::new();
    for arm in ["arm0", "arm3"] {
        let text = plan(200).to_string();
        jobs.push(
            anna.ok("job.start", json!({"arm": arm, "text": text}))
                .await["job"]
                .clone(),
        );
    }
    assert_ne!(jobs[0], jobs[1]);
    // At their own stations both jobs have the same id.
    let bare = |id: &Value| id.as_str().unwrap().split_once('.').unwrap().1.to_owned();
    assert_eq!(bare(&jobs[0]), bare(&jobs[1]));
    for (job, arm) in jobs.iter().zip(["arm0", "arm3"]) {
        assert_eq!(anna.ok("job.get", json!({"job": job})).await["arm"], arm);
        assert_eq!(anna.row(arm).await["job"], *job);
    }
    let stopped = anna.ok("job.stop", json!({"job": jobs[0]})).await;
    assert_eq!(
        (&stopped["state"], &stopped["job"]),
        (&json!("stopped"), &jobs[0])
    );
    let other = anna.ok("job.get", json!({"job": jobs[1]})).await;
    assert_ne!(other["state"], "stopped");
    let busy = anna.fails("arm.home", json!({"arm": "arm3"})).await;
    assert_eq!(
        (&busy["code"], &busy["data"]["job"]),
        (&json!(-32003), &jobs[1])
    );
    anna.ok("lease.renew", json!({"lease": leases[1]})).await;
    anna.ok("lease.release", json!({"lease": leases[0]})).await;
    assert_eq!(anna.row("arm0").await["holder"], Value::Null);
    assert_ne!(anna.row("arm3").await["holder"], Value::Null);
    let changed = anna.noticed("job.changed");
    assert!(changed.iter().any(|params| params["job"]["job"] == jobs[1]));
}

#[tokio::test(start_paused = true)]
async fn a_person_is_one_session_at_all_stations() {
    let bench = TestHub::new(3, 3).await;
    let mut anna = bench.socket();
    let hello = anna
        .ok("session.hello", json!({"client": {"name": "Anna"}}))
        .await;
    let mut ben = bench.join("Ben").await;
    anna.take_arm("arm0").await;
    anna.take_arm("arm8").await;
    for arm in ["arm0", "arm8"] {
        assert_eq!(anna.row(arm).await["holder"]["session"], hello["session"]);
        assert_eq!(ben.row(arm).await["holder"]["session"], hello["session"]);
        let state = ben.ok("arm.state", json!({"arm": arm})).await;
        assert_eq!(state["holder"]["session"], hello["session"]);
    }
    // A user who connected to one of the stations directly.
    let station = bench.site.station(2).running.clone();
    let grant = Some(Grant {
        role: Role::Student,
        token: None,
    });
    let carl = station.connect(Peer::elsewhere(grant, "here".to_owned()).unwrap());
    carl.send(
        r#"{"jsonrpc":"2.0","id":1,"method":"session.hello","params":{"client":{"name":"Carl"}}}"#,
    );
    let list = ben.ok("session.list", json!({})).await;
    let mut all: Vec<_> = { list["sessions"].as_array().unwrap().iter() }
        .map(|one| {
            (
                one["name"].as_str().unwrap().to_owned(),
                one["leases"].clone(),
            )
        })
        .collect();
    all.sort_by(|one, other| one.0.cmp(&other.0));
    let expected = [
        ("Anna", json!(["arm0", "arm8"])),
        ("Ben", json!([])),
        ("Carl", json!([])),
    ];
    assert_eq!(
        all,
        expected.map(|(name, leases)| (name.to_owned(), leases))
    );
    // Five lists a second at most, from stations and hub alike.
    ben.live(Duration::from_millis(500)).await;
    assert!(!ben.noticed("session.changed").is_empty());
}

#[tokio::test(start_paused = true)]
async fn a_raised_hand_reaches_the_holder_and_the_answer_comes_back() {
    let bench = TestHub::new(3, 3).await;
    let (mut anna, mut ben) = (bench.join("Anna").await, bench.join("Ben").await);
    anna.take_arm("arm5").await;
    let asks = ben.send("lease.ask", json!({"arm": "arm5", "message": "please"}));
    anna.live(Duration::from_millis(50)).await;
    let asked = anna.noticed("lease.asked").pop().expect("a hand").clone();
    assert_eq!(
        (&asked["arm"], &asked["name"]),
        (&json!("arm5"), &json!("Ben"))
    );
    let row = anna.row("arm5").await;
    assert_eq!(row["waiting"][0]["session"], asked["session"]);
    let wrong = anna
        .fails(
            "lease.answer",
            json!({"arm": "arm1", "session": asked["session"], "grant": true}),
        )
        .await;
    assert_eq!(wrong["data"]["param"], "session");
    anna.ok(
        "lease.answer",
        json!({"arm": "arm5", "session": asked["session"], "grant": true}),
    )
    .await;
    let granted = ben.answer(asks).await.unwrap();
    assert_eq!(granted["granted"], true);
    ben.ok("lease.renew", json!({"lease": granted["lease"]}))
        .await;
    // She may not renew another client's lease, as at a station.
    let error = anna
        .fails("lease.renew", json!({"lease": granted["lease"]}))
        .await;
    assert_eq!(error["code"], -32002);
}

#[tokio::test(start_paused = true)]
async fn what_needs_no_arm_the_hub_answers_itself() {
    let bench = TestHub::new(2, 1).await;
    let mut anna = bench.join("Anna").await;
    let pose = anna
        .ok("motion.forward", json!({"joints": [0, 45, 45, 0]}))
        .await;
    assert!(pose["x"].is_number());
    anna.ok(
        "program.put",
        json!({"name": "a.plan.json", "text": plan(3).to_string()}),
    )
    .await;
    let list = anna.ok("program.list", json!({})).await;
    assert_eq!(list["programs"][0]["name"], "a.plan.json");
    assert_eq!(bench.site.opened(), 0);
}

#[tokio::test(start_paused = true)]
async fn a_program_of_the_hub_runs_on_an_arm_of_any_station() {
    let bench = TestHub::new(2, 2).await;
    let mut anna = bench.join("Anna").await;
    anna.ok(
        "program.put",
        json!({"name": "a.plan.json", "text": plan(3).to_string()}),
    )
    .await;
    anna.take_arm("arm3").await;
    let report = anna
        .ok(
            "job.check",
            json!({"arm": "arm3", "program": "a.plan.json"}),
        )
        .await;
    assert_eq!(report["steps"], 3);
    let job = anna
        .ok(
            "job.start",
            json!({"arm": "arm3", "program": "a.plan.json"}),
        )
        .await["job"]
        .clone();
    anna.live(Duration::from_secs(20)).await;
    assert_eq!(
        anna.ok("job.get", json!({"job": job})).await["state"],
        "done"
    );
    let error = anna
        .fails("job.start", json!({"arm": "arm3", "program": "b.svg"}))
        .await;
    assert_eq!(
        (&error["code"], &error["data"]["param"]),
        (&json!(-32602), &json!("program"))
    );
    let large = "a".repeat(800 * 1024);
    anna.ok("program.put", json!({"name": "c.svg", "text": large}))
        .await;
    let error = anna
        .fails("job.start", json!({"arm": "arm3", "program": "c.svg"}))
        .await;
    assert_eq!(error["data"]["kind"], "invalid-input");
    assert!(
        error["message"].as_str().unwrap().contains("700 KiB"),
        "{error}"
    );
}

#[tokio::test(start_paused = true)]
async fn a_single_request_reaches_any_arm_and_takes_its_lease_for_the_call() {
    let bench = TestHub::new(3, 1).await;
    let peer = || {
        let grant = Some(Grant {
            role: Role::Teacher,
            token: None,
        });
        Peer::elsewhere(grant, "here".to_owned()).unwrap()
    };
    let call = async |method: &str, params: Value| -> Value {
        let text =
            json!({"jsonrpc": "2.0", "id": 7, "method": method, "params": params}).to_string();
        let answer = ApiServer::call(&bench.hub, peer(), None, &text)
            .await
            .expect(method);
        let answer: Value = serde_json::from_str(&answer).unwrap();
        assert_eq!(answer["id"], 7);
        answer
    };
    let moved = call("arm.move", json!({"arm": "arm2", "to": [220, 40, 20, 0]})).await;
    assert_eq!(moved["result"]["arm"], "arm2");
    assert_eq!(
        moved["result"]["holder"]["session"]
            .as_str()
            .unwrap()
            .split_once('.')
            .unwrap()
            .0,
        "3"
    );
    assert_eq!(
        call("arm.list", json!({})).await["result"]["arms"]
            .as_array()
            .unwrap()
            .len(),
        3
    );
    assert_eq!(
        call("server.info", json!({})).await["result"]["arms"]
            .as_array()
            .unwrap()
            .len(),
        3
    );
    let stopped = call("arm.stop", json!({})).await;
    assert_eq!(stopped["result"]["arms"].as_array().unwrap().len(), 3);
    let refused = call("lease.acquire", json!({"arm": "arm1"})).await;
    assert_eq!(refused["error"]["code"], -32600);
    assert_eq!(bench.site.opened(), 0);
    assert_eq!(bench.hub.clients(), 0);
}

#[tokio::test(start_paused = true)]
async fn a_token_that_allows_more_elsewhere_does_not_here() {
    let bench = TestHub::over(crate::bench::TestSite::of(2, 1).await, true).await;
    let mut anna = bench.socket();
    let hello = anna
        .ok("session.hello", json!({"client": {"name": "Anna"}}))
        .await;
    assert_eq!(hello["role"], "viewer");
    let error = anna.fails("lease.take", json!({"arm": "arm0"})).await;
    assert_eq!(error["code"], -32001);
    // Viewers may read the fence. To change it she would have to be a teacher, which the station
    // decides.
    anna.ok("arm.fence", json!({"arm": "arm0"})).await;
    let error = anna
        .fails("arm.fence", json!({"arm": "arm0", "set": {"floor": 1}}))
        .await;
    assert_eq!(
        (&error["code"], &error["data"]["role"]),
        (&json!(-32001), &json!("viewer"))
    );
    // Nor in a single request.
    let text = json!({"jsonrpc": "2.0", "id": 7, "method": "arm.fence", "params": {"arm": "arm0", "set": {"floor": 1}}});
    let answer = ApiServer::call(&bench.hub, crate::bench::peer(), None, &text.to_string()).await;
    let answer: Value = serde_json::from_str(&answer.unwrap()).unwrap();
    assert_eq!(answer["error"]["data"]["role"], "viewer", "{answer}");
    anna.client.pong();
}
