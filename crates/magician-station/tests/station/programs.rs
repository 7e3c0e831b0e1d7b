//! Library of programs, and many checks at once.

use std::time::Duration;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use magician::admission::Origin;
use magician_protocol::HostInstant;
use magician_station::{ArmEntry, ArmOrder, Grant, Outgoing, Peer, Role, Station, StationConfig};
use serde_json::{Value, json};

use crate::bench::LocalStation;
use crate::jobs::{drawing, until};

#[tokio::test(start_paused = true)]
async fn programs_are_stored_listed_returned_and_removed() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let info = anna.ok("server.info", json!({})).await;
    assert_eq!(info["programs"], json!("/shelf"));
    let text = drawing();
    let put = json!({"name": "house 2.plan.json", "text": text});
    let kept = anna.ok("program.put", put.clone()).await;
    assert_eq!(
        kept,
        json!({"name": "house 2.plan.json", "bytes": text.len()})
    );
    let data = json!({"name": "raw", "data": "AAEC"});
    assert_eq!(anna.ok("program.put", data).await["bytes"], json!(3));
    anna.ok("program.put", put).await;
    let list = anna.ok("program.list", json!({})).await;
    let expected = json!([
        {"name": "house 2.plan.json", "bytes": text.len(), "modified": 1000.5, "format": "plan"},
        {"name": "raw", "bytes": 3, "modified": 1000.5, "format": null},
    ]);
    assert_eq!(list["programs"], expected);
    let given = anna.ok("program.get", json!({"name": "raw"})).await;
    let expected = json!({"name": "raw", "format": null, "data": "AAEC"});
    assert_eq!(given, expected);
    assert_eq!(
        anna.ok("program.delete", json!({"name": "raw"})).await,
        Value::Null
    );
    for method in ["program.get", "program.delete"] {
        let gone = anna.call(method, json!({"name": "raw"})).await.unwrap_err();
        assert_eq!(
            (&gone["code"], &gone["data"]["param"]),
            (&json!(-32602), &json!("name"))
        );
    }
    // Without room nothing is stored, and the old content stays.
    *bench.library.room.lock().unwrap() = 10;
    let more = json!({"name": "house 2.plan.json", "text": "more than ten bytes"});
    let full = anna.call("program.put", more).await.unwrap_err();
    assert_eq!(full["data"]["kind"], json!("unexpected"), "{full}");
    let there = json!({"name": "house 2.plan.json"});
    let there = anna.ok("program.get", there).await["data"].clone();
    assert_eq!(
        STANDARD.decode(there.as_str().unwrap()).unwrap(),
        text.as_bytes()
    );
}

#[tokio::test(start_paused = true)]
async fn program_too_large_for_an_answer_is_refused() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    for (size, given) in [(700 * 1024, true), (700 * 1024 + 1, false)] {
        let text = "x".repeat(size);
        anna.ok("program.put", json!({"name": "a", "text": text}))
            .await;
        let outcome = anna.call("program.get", json!({"name": "a"})).await;
        assert_eq!(outcome.is_ok(), given, "{size}");
        if let Err(error) = outcome {
            assert_eq!(error["data"]["kind"], json!("invalid-input"));
        }
    }
}

#[tokio::test(start_paused = true)]
async fn invalid_names_and_low_roles_are_refused() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let long = "x".repeat(81);
    for name in [
        "", ".", "..", ".hidden", "../a", "a/b", "a\\b", " a", "a ", "a\0", "a\n", "ä", "%2e%2e",
        &long,
    ] {
        let calls = [
            ("program.get", json!({"name": name})),
            ("program.put", json!({"name": name, "text": ""})),
            ("program.delete", json!({"name": name})),
            ("program.convert", json!({"name": name, "to": "a.csv"})),
        ];
        for (method, params) in calls {
            let refused = anna.call(method, params).await.unwrap_err();
            let found = (&refused["code"], &refused["data"]["param"]);
            assert_eq!(found, (&json!(-32602), &json!("name")), "{name:?}");
        }
        let refused = anna.call("job.check", json!({"program": name})).await;
        assert_eq!(refused.unwrap_err()["data"]["param"], json!("program"));
    }
    anna.ok("program.put", json!({"name": "x".repeat(80), "text": ""}))
        .await;
    let mut viewer = bench.join_as("Viewer", Role::Viewer).await;
    viewer.ok("program.list", json!({})).await;
    for (method, params) in [
        ("program.put", json!({"name": "a", "text": ""})),
        ("program.delete", json!({"name": "a"})),
        ("program.convert", json!({"name": "a", "to": "b.csv"})),
    ] {
        assert_eq!(viewer.code(method, params).await, -32001, "{method}");
    }
}

#[tokio::test(start_paused = true)]
async fn missing_program_is_reported_before_the_lease() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let name = json!({"program": "lines.plan.json"});
    let unknown = anna.call("job.start", name.clone()).await.unwrap_err();
    assert_eq!(unknown["data"]["param"], json!("program"), "{unknown}");
    let put = json!({"name": "lines.plan.json", "text": drawing()});
    anna.ok("program.put", put).await;
    assert_eq!(anna.code("job.start", name).await, -32002);
    assert_eq!(anna.ok("job.list", json!({})).await, json!({"jobs": []}));
}

#[test]
fn stop_precedes_a_job_still_looking_up_its_program() {
    let now = HostInstant::ZERO;
    let arms = vec![ArmEntry::simulated("arm")];
    let mut station = Station::new(StationConfig::new(arms, "0"));
    let peer = |name: &str| Peer {
        grant: Some(Grant {
            role: Role::Student,
            token: None,
        }),
        origin: Origin::Loopback,
        address: name.to_owned(),
        secret: format!("{name:032}"),
    };
    let (anna, ben) = (station.open(now, peer("a")), station.open(now, peer("b")));
    let hello =
        r#"{"jsonrpc":"2.0","id":1,"method":"session.hello","params":{"client":{"name":"x"}}}"#;
    let mut say = |socket, text: &str| station.receive(now, socket, text);
    say(anna, hello);
    say(ben, hello);
    say(anna, r#"{"jsonrpc":"2.0","id":2,"method":"lease.acquire"}"#);
    say(
        anna,
        r#"{"jsonrpc":"2.0","id":3,"method":"job.start","params":{"program":"a.plan.json"}}"#,
    );
    let found = station.poll_library().expect("it is looked for");
    station.receive(now, ben, r#"{"jsonrpc":"2.0","id":4,"method":"arm.stop"}"#);
    station.library_done(now, found.request, Ok(Value::Null));
    while let Some((_, order)) = station.poll_order() {
        assert!(!matches!(order, ArmOrder::StartJob(_)), "{order:?}");
    }
    let mut stopped = false;
    while let Some(Outgoing::Text(text)) = station.poll_send(anna) {
        stopped |= text.contains("\"id\":3") && text.contains("-32007");
    }
    assert!(stopped);
}

#[tokio::test(start_paused = true)]
async fn program_runs_by_name_and_is_converted() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    let name = "lines.plan.json";
    let unknown = anna.call("job.start", json!({"program": name})).await;
    let unknown = unknown.unwrap_err();
    assert_eq!(
        (&unknown["code"], &unknown["data"]["param"]),
        (&json!(-32602), &json!("program"))
    );
    anna.ok("program.put", json!({"name": name, "text": drawing()}))
        .await;
    let by_name = anna.ok("job.check", json!({"program": name})).await;
    let by_text = anna.ok("job.check", json!({"text": drawing()})).await;
    assert_eq!(by_name, by_text);
    let started = anna.ok("job.start", json!({"program": name})).await;
    until(&mut anna, &started["job"], "done").await;
    // The same report as `magician convert --json`.
    let convert = json!({"name": name, "to": "lines.csv"});
    let made = anna.ok("program.convert", convert).await;
    assert_eq!(
        (&made["from"], &made["to"], &made["steps"]),
        (&json!(name), &json!("lines.csv"), &json!(8))
    );
    let lost = "a list of points has no speeds, tool or settings";
    assert_eq!(made["lost"], json!([lost]));
    let points = bench.library.bytes("lines.csv");
    let points = String::from_utf8(points).unwrap();
    assert!(
        points.starts_with("step,action,x,y,z,r,line,name\n"),
        "{points}"
    );
    for (params, param) in [
        (json!({"name": name, "to": "lines.dxf"}), "to"),
        (json!({"name": name, "to": "../lines.csv"}), "to"),
        (json!({"name": "none.svg", "to": "a.csv"}), "name"),
        (
            json!({"name": name, "to": "a.csv", "setup": {"scale": 0}}),
            "setup.scale",
        ),
    ] {
        let refused = anna.call("program.convert", params).await.unwrap_err();
        assert_eq!(refused["data"]["param"], json!(param), "{refused}");
    }
}

#[tokio::test(start_paused = true)]
async fn job_with_a_digest_runs_only_the_checked_program() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let mut ben = bench.join("Ben").await;
    anna.lease().await;
    let name = "lines.plan.json";
    let put = |text: String| json!({"name": name, "text": text});
    anna.ok("program.put", put(drawing())).await;
    let checked = anna.ok("job.check", json!({"program": name})).await["digest"].clone();
    let start = json!({"program": name, "digest": checked});
    // The same content under another name, or as text, is the same program.
    let text = json!({"text": drawing()});
    assert_eq!(anna.ok("job.check", text).await["digest"], checked);
    // Another session replaces it.
    let other = drawing().replace("240", "235");
    assert_ne!(other, drawing());
    ben.ok("program.put", put(other)).await;
    let before = bench.arms[0].state().pose;
    for (after_check, key) in [(true, "one"), (false, "two")] {
        let mut start = start.clone();
        start["after_check"] = json!(after_check);
        start["key"] = json!(key);
        let error = match anna.call("job.start", start).await {
            Ok(job) => until(&mut anna, &job["job"], "failed").await["error"].clone(),
            Err(error) => {
                assert_eq!(error["code"], json!(-32009), "{error}");
                error["data"].clone()
            }
        };
        assert_eq!(error["kind"], json!("changed"), "{error}");
        assert_ne!(error["digest"], checked);
    }
    assert_eq!(bench.arms[0].state().pose, before);
    anna.ok("program.put", put(drawing())).await;
    let job = anna.ok("job.start", start).await["job"].clone();
    let done = until(&mut anna, &job, "done").await;
    assert_eq!(done["digest"], checked);
}

#[tokio::test(start_paused = true)]
async fn existing_program_is_not_replaced_without_permission() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let put = |name: &str, text: &str| json!({"name": name, "text": text, "replace": false});
    anna.ok("program.put", put("lines.plan.json", &drawing()))
        .await;
    anna.ok("program.put", put("lines.csv", "mine")).await;
    let convert = json!({"name": "lines.plan.json", "to": "lines.csv"});
    let mut kept = convert.clone();
    kept["replace"] = json!(false);
    for (method, params, param) in [
        ("program.put", put("lines.csv", "yours"), "name"),
        ("program.convert", kept, "to"),
    ] {
        let refused = anna.call(method, params).await.unwrap_err();
        let found = (&refused["code"], &refused["data"]["param"]);
        assert_eq!(found, (&json!(-32602), &json!(param)), "{refused}");
        assert_eq!(bench.library.bytes("lines.csv"), b"mine");
    }
    anna.ok("program.convert", convert).await;
    assert_ne!(bench.library.bytes("lines.csv"), b"mine");
}

#[tokio::test(start_paused = true)]
async fn checks_are_queued_and_do_not_delay_a_stop() {
    let bench = LocalStation::new(1).await;
    let mut checkers = Vec::new();
    for name in ["Anna", "Ben", "Cleo"] {
        checkers.push(bench.join(name).await);
    }
    bench.gate.close(true);
    let mut ids = Vec::new();
    for checker in &mut checkers {
        let mut of_one = Vec::new();
        for _ in 0..30 {
            of_one.push(checker.send("job.check", json!({"text": drawing()})));
        }
        ids.push(of_one);
    }
    while bench.gate.now() < 2 {
        tokio::task::yield_now().await;
    }
    // Two run, 64 wait, and the last ones are refused.
    for id in &ids[2][6..] {
        let refused = checkers[2].answer(*id).await.unwrap_err();
        assert_eq!(
            (&refused["code"], &refused["data"]["limit"]),
            (&json!(-32006), &json!(64))
        );
    }
    let mut viewer = bench.join_as("Viewer", Role::Viewer).await;
    // Virtual time does not advance by itself while a thread computes.
    let passes = async {
        loop {
            tokio::time::advance(Duration::from_millis(1)).await;
        }
    };
    tokio::select! {
        _ = viewer.ok("arm.stop", json!({})) => {}
        () = passes => {}
    }
    // Requests of a closed socket are not carried out.
    drop(checkers.remove(1));
    bench.gate.close(false);
    for id in &ids[0] {
        // In the order of their requests.
        let answer = checkers[0].message().await.unwrap();
        assert_eq!(answer["id"], json!(id));
        assert_eq!(answer["result"]["ok"], json!(true));
    }
    for id in &ids[2][..6] {
        assert!(checkers[1].answer(*id).await.is_ok());
    }
    assert_eq!(bench.gate.most(), 2);
}
