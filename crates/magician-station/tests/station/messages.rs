//! Valid and invalid messages.

use magician_station::{CloseCode, Role, api::METHODS};
use serde_json::{Value, json};

use crate::bench::{LocalStation, Tester};

async fn raw(tester: &mut Tester, text: &str) -> Value {
    tester.client.send(text);
    tester.message().await.unwrap()
}

#[tokio::test(start_paused = true)]
async fn invalid_requests_get_json_rpc_errors() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    for (text, id, code) in [
        ("", json!(null), -32700),
        ("{", json!(null), -32700),
        ("[]", json!(null), -32600),
        ("3", json!(null), -32600),
        (
            r#"{"jsonrpc":"2.0","id":null,"method":"arm.list"}"#,
            json!(null),
            -32600,
        ),
        (
            r#"{"jsonrpc":"2.0","id":1.5,"method":"arm.list"}"#,
            json!(null),
            -32600,
        ),
        (r#"{"id":7,"method":"arm.list"}"#, json!(7), -32600),
        (r#"{"jsonrpc":"2.0","id":"a"}"#, json!("a"), -32600),
        (
            r#"{"jsonrpc":"2.0","id":8,"method":"arm.list","params":[]}"#,
            json!(8),
            -32600,
        ),
        (
            r#"{"jsonrpc":"2.0","id":8,"method":"arm.list","more":1}"#,
            json!(8),
            -32600,
        ),
        (
            r#"{"jsonrpc":"2.0","id":9,"method":"arm.dance"}"#,
            json!(9),
            -32601,
        ),
        (
            r#"{"jsonrpc":"2.0","method":"arm.home"}"#,
            json!(null),
            -32600,
        ),
        (
            r#"{"jsonrpc":"2.0","id":9,"method":"session.hello","params":{"client":{"name":"x"}}}"#,
            json!(9),
            -32600,
        ),
    ] {
        let answer = raw(&mut anna, text).await;
        assert_eq!(
            (&answer["id"], &answer["error"]["code"]),
            (&id, &json!(code)),
            "{text}"
        );
    }
}

#[tokio::test(start_paused = true)]
async fn parameters_are_checked_by_name_kind_and_range() {
    let bench = LocalStation::new(2).await;
    let mut anna = bench.join("Anna").await;
    for (method, params, param) in [
        ("arm.state", json!({}), "arm"),
        ("arm.state", json!({"arm": "arm3"}), "arm"),
        ("arm.state", json!({"arm": 1}), "arm"),
        ("arm.state", json!({"arm": "arm1", "color": "red"}), "color"),
        ("arm.subscribe", json!({"arm": "arm1", "rate": 51}), "rate"),
        ("arm.subscribe", json!({"arm": "arm1", "rate": 2.5}), "rate"),
        ("arm.subscribe", json!({"arm": "arm1"}), "rate"),
        (
            "arm.unsubscribe",
            json!({"subscription": 9}),
            "subscription",
        ),
        ("arm.move", json!({"arm": "arm1", "to": [1, 2, 3]}), "to"),
        (
            "arm.move",
            json!({"arm": "arm1", "to": [1, 2, 3, "4"]}),
            "to",
        ),
        ("jog.start", json!({"arm": "arm1", "axis": "up"}), "axis"),
        (
            "jog.start",
            json!({"arm": "arm1", "axis": "x+", "keep_ms": 99}),
            "keep_ms",
        ),
        ("jog.stop", json!({"jog": "g0-1"}), "jog"),
        ("lease.release", json!({"lease": "nonsense"}), "lease"),
    ] {
        let error = anna.call(method, params.clone()).await.unwrap_err();
        assert_eq!(
            (&error["code"], &error["data"]["param"]),
            (&json!(-32602), &json!(param)),
            "{method} {params}"
        );
    }
}

#[tokio::test(start_paused = true)]
async fn message_before_hello_is_refused_and_bad_hello_closes() {
    let bench = LocalStation::new(1).await;
    let mut early = bench.socket(Some(Role::Student));
    assert_eq!(early.code("arm.state", json!({})).await, -32001);
    assert_eq!(
        early
            .code("session.hello", json!({"client": {"name": 3}}))
            .await,
        -32602
    );
    assert!(early.message().await.is_none());
    assert_eq!(early.closed, Some(CloseCode::BAD_HELLO));
    let mut foreign = bench.socket(None);
    assert_eq!(
        foreign
            .code("session.hello", json!({"client": {"name": "x"}}))
            .await,
        -32001
    );
    assert!(foreign.message().await.is_none());
    assert_eq!(foreign.closed, Some(CloseCode::BAD_TOKEN));
    let mut noise = bench.socket(Some(Role::Student));
    noise.client.send("GET / HTTP/1.1");
    assert_eq!(
        noise.message().await.unwrap()["error"]["code"],
        json!(-32700)
    );
    assert!(noise.message().await.is_none());
    let mut silent = bench.socket(Some(Role::Student));
    assert!(silent.message().await.is_none());
    assert_eq!(silent.closed, Some(CloseCode::HELLO_TIMEOUT));
}

/// Every method of the table must be implemented.
#[tokio::test(start_paused = true)]
async fn every_method_is_implemented() {
    let bench = LocalStation::recording(crate::recordings::Tapes::default()).await;
    for method in METHODS {
        if method.name == "session.hello" || method.name == "jog.keep" {
            continue;
        }
        let mut teacher = bench.join_as("Teacher", Role::Teacher).await;
        let lease = teacher.ok("lease.take", json!({})).await["lease"].clone();
        let mut job = json!(null);
        if method.params.iter().any(|param| param.name == "job") {
            let program = json!({"text": crate::jobs::drawing()});
            job = teacher.ok("job.start", program).await["job"].clone();
            if method.name == "job.resume" {
                teacher.ok("job.pause", json!({"job": job})).await;
            }
            if method.name == "job.delete" {
                teacher.ok("job.stop", json!({"job": job})).await;
            }
        }
        let mut params = json!({});
        for param in method.params.iter().filter(|param| param.required) {
            params[param.name] = match param.name {
                "command" if method.name == "arm.get" => json!("Pose"),
                "command" => json!("WAITCmd"),
                "to" if method.name == "program.convert" => json!("a.csv"),
                "to" => json!([220, 0, 50, 0]),
                "axis" if method.name == "jog.start" => json!("x+"),
                "axis" => json!("x"),
                "rate" | "seq" | "subscription" | "position" => json!(1),
                "percent" | "by" => json!(5),
                "lease" => lease.clone(),
                "format" => json!("svg"),
                "plan" => json!({"format": "magician-plan", "version": 1, "steps": []}),
                "rows" | "arms" => json!([]),
                "address" => json!(4),
                "corner" => json!("lower-left"),
                "grant" | "held" | "high" | "on" | "plugged" => json!(true),
                "at" => json!([200, 0, 0]),
                "text" => json!(""),
                "seconds" => json!(10),
                "joints" => json!([0, 45, 45, 0]),
                "pose" => json!([220, 0, 50, 0]),
                "z" => json!(0),
                "fault" => json!("reset"),
                "job" => job.clone(),
                _ => json!("nonsense"),
            };
        }
        if method.name == "world.input" {
            params["level"] = json!(true);
        }
        if ["arm.set", "arm.enqueue"].contains(&method.name) {
            params["fields"] = json!({"timeout": 10});
        }
        if ["job.check", "job.start", "program.put", "class.send"].contains(&method.name) {
            params["text"] = json!(crate::jobs::drawing());
        }
        match method.name {
            "arm.tool" => params["suction"] = json!(true),
            "arm.speed" => params["percent"] = json!(5),
            "class.codes" => {
                teacher.ok("class.set", json!({"text": "[class]"})).await;
            }
            "preset.save" => params["setup"] = json!({"speed": 5}),
            _ => {}
        }
        let outcome = teacher.call(method.name, params).await;
        if let Err(error) = outcome {
            // Methods that name something missing say so. No other error is expected.
            assert_eq!(error["code"], json!(-32602), "{}: {error}", method.name);
            let named = ["subscription", "session", "jog", "name", "text", "pupils"];
            assert!(
                named.contains(&error["data"]["param"].as_str().unwrap()),
                "{}: {error}",
                method.name
            );
        }
        let job = teacher.ok("arm.list", json!({})).await["arms"][0]["job"].clone();
        if !job.is_null() {
            teacher.ok("job.stop", json!({"job": job})).await;
        }
    }
}
