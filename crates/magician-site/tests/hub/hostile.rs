//! Stations and clients that misbehave.

use std::sync::Arc;
use std::time::Duration;

use magician_site::{FromStation, StationEnd, ToStation};
use magician_station::CloseCode;
use magician_station::http::ApiClient;
use serde_json::{Value, json};

use crate::bench::{Fault, TestHub};

/// Returns a fault: the station answers the hello correctly, and every other request with
/// `messages`.
fn replying_with(messages: impl Fn(&Value) -> Vec<String> + Send + Sync + 'static) -> Fault {
    let messages = Arc::new(messages);
    Arc::new(move |mut end: StationEnd| {
        let messages = Arc::clone(&messages);
        tokio::spawn(async move {
            while let Some(message) = end.from_client.recv().await {
                let ToStation::Text(text) = message else {
                    continue;
                };
                let message: Value = serde_json::from_str(&text).unwrap();
                let replies = if message["method"] == "session.hello" {
                    let result = json!({"session": "same-1", "resume": "r"});
                    vec![
                        json!({"jsonrpc": "2.0", "id": message["id"], "result": result})
                            .to_string(),
                    ]
                } else {
                    messages(&message)
                };
                for text in replies {
                    if end.to_client.send(FromStation::Text(text)).await.is_err() {
                        return;
                    }
                }
            }
        });
    })
}

#[tokio::test(start_paused = true)]
async fn garbage_closes_only_the_line_of_its_station() {
    for garbage in [
        "",
        "garbage",
        "[]",
        "17",
        "{\"jsonrpc\"",
        &"x".repeat(9 << 20),
        &"[".repeat(5000),
    ] {
        let bench = TestHub::new(2, 1).await;
        let garbage = garbage.to_owned();
        bench
            .site
            .fault(1, Some(replying_with(move |_| vec![garbage.clone()])));
        let mut anna = bench.join("Anna").await;
        let error = anna.fails("arm.info", json!({"arm": "arm0"})).await;
        assert_eq!(error["data"]["kind"], "unexpected");
        anna.ok("arm.info", json!({"arm": "arm1"})).await;
    }
}

#[tokio::test(start_paused = true)]
async fn reports_about_arms_of_other_stations_are_ignored() {
    let bench = TestHub::new(2, 1).await;
    let mut anna = bench.join("Anna").await;
    anna.ok("arm.info", json!({"arm": "arm1"})).await;
    bench.site.fault(1, Some(replying_with(|message| {
        let id = message["id"].as_u64().unwrap();
        let mut replies: Vec<_> = (id - 40..id + 40).filter(|other| *other != id).map(|other| {
            json!({"jsonrpc": "2.0", "id": other, "result": {"forged": true}}).to_string()
        }).collect();
        for (method, params) in [
            ("lease.changed", json!({"arm": "arm1", "holder": {"session": "forged", "name": "forged"}})),
            ("job.changed", json!({"job": {"arm": "arm1", "job": "forged"}})),
            ("arm.event", json!({"arm": "arm1", "event": "stop"})),
            ("jog.ended", json!({"arm": "arm1", "jog": "forged"})),
            ("lease.asked", json!({"session": "forged"})),
            ("arm.state", json!({"subscription": 1, "state": {"x": "forged"}})),
            ("unknown", json!({"forged": true})),
        ] {
            replies.push(json!({"jsonrpc": "2.0", "method": method, "params": params}).to_string());
        }
        replies.push(json!({"jsonrpc": "2.0", "id": id, "result": {"arms": [{"name": "arm1", "port": "forged"}, {"name": 7}, null]}}).to_string());
        replies
    })));
    anna.ok("arm.subscribe", json!({"arm": "arm1", "rate": 10}))
        .await;
    let request = anna.send("arm.move", json!({"arm": "arm1", "to": [220, 0, 20, 0]}));
    assert_eq!(anna.row("arm1").await["port"], "sim");
    anna.run_for(Duration::from_secs(1)).await;
    let error = anna.call("arm.info", json!({"arm": "arm1"})).await.unwrap();
    assert_ne!(error["forged"], true);
    assert!(!format!("{:?}", anna.notices).contains("forged"));
    let _ = request;
}

#[tokio::test(start_paused = true)]
async fn flooding_station_is_disconnected_and_its_client_continues() {
    let bench = TestHub::new(2, 1).await;
    let mut anna = bench.join("Anna").await;
    let flood: Fault = Arc::new(|end: StationEnd| {
        tokio::spawn(async move {
            let text = json!({"jsonrpc": "2.0", "method": "lease.changed", "params": {"arm": "nobody", "holder": null}}).to_string();
            loop {
                for _ in 0..300 {
                    if end
                        .to_client
                        .send(FromStation::Text(text.clone()))
                        .await
                        .is_err()
                    {
                        return;
                    }
                }
                tokio::time::sleep(Duration::from_millis(100)).await;
            }
        });
    });
    bench.site.fault(1, Some(flood));
    let request = anna.send("arm.info", json!({"arm": "arm0"}));
    for _ in 0..20 {
        anna.ok("arm.info", json!({"arm": "arm1"})).await;
        anna.run_for(Duration::from_millis(300)).await;
    }
    assert!(anna.answer(request).await.is_err());
    assert_eq!(anna.closed, None);
}

#[tokio::test(start_paused = true)]
async fn unknown_ids_are_refused_without_a_request_to_a_station() {
    let bench = TestHub::new(2, 1).await;
    let mut anna = bench.join("Anna").await;
    for id in [
        "jsame-1",
        "0.jsame-1",
        "3.jsame-1",
        "18446744073709551616.j",
        ".",
        "1",
        "01.jsame-1",
        "é.x",
    ] {
        for (method, param) in [
            ("job.get", "job"),
            ("job.stop", "job"),
            ("jog.stop", "jog"),
            ("lease.release", "lease"),
        ] {
            let error = anna.fails(method, json!({param: id})).await;
            assert_eq!(
                (&error["code"], &error["data"]["param"]),
                (&json!(-32602), &json!(param)),
                "{method} {id}"
            );
        }
    }
    assert_eq!(
        (bench.site.opened(), bench.site.calls.lock().unwrap().len()),
        (0, 0)
    );
    let error = anna.fails("job.get", json!({"job": "1.jsame-77"})).await;
    assert_eq!(error["data"]["param"], "job");
}

#[tokio::test(start_paused = true)]
async fn invalid_requests_get_the_answers_of_a_station() {
    let bench = TestHub::new(2, 1).await;
    let anna = bench.join("Anna").await;
    for (text, code) in [
        ("garbage", -32700),
        ("[]", -32600),
        (r#"{"jsonrpc":"2.0","id":1,"method":"nothing"}"#, -32601),
        (r#"{"jsonrpc":"2.0","method":"arm.move"}"#, -32600),
        (
            r#"{"jsonrpc":"2.0","id":1,"method":"arm.move","params":{"arm":"arm0"}}"#,
            -32602,
        ),
        (
            r#"{"jsonrpc":"2.0","id":1,"method":"session.hello","params":{"client":{"name":"x"}}}"#,
            -32600,
        ),
    ] {
        anna.client.send(text);
        let outgoing = loop {
            match anna.client.receive().await {
                magician_station::Outgoing::Text(text) if text.contains("\"method\"") => {}
                outgoing => break outgoing,
            }
        };
        let magician_station::Outgoing::Text(answer) = outgoing else {
            panic!("{outgoing:?}");
        };
        let answer: Value = serde_json::from_str(&answer).unwrap();
        assert_eq!(answer["error"]["code"], code, "{text}: {answer}");
    }
    let mut late = bench.socket();
    assert_eq!(late.fails("arm.list", json!({})).await["code"], -32001);
    late.run_for(Duration::from_secs(6)).await;
    assert_eq!(late.closed, Some(CloseCode::HELLO_TIMEOUT));
    let mut wrong = bench.socket();
    wrong.client.send("garbage");
    wrong.run_for(Duration::from_millis(10)).await;
    assert_eq!(wrong.closed, Some(CloseCode::BAD_HELLO));
}

#[tokio::test(start_paused = true)]
async fn clients_that_flood_or_do_not_read_are_closed() {
    let bench = TestHub::new(1, 1).await;
    let (mut anna, mut ben) = (bench.join("Anna").await, bench.join("Ben").await);
    for _ in 0..70 {
        for _ in 0..30 {
            anna.send("server.info", json!({}));
        }
        anna.run_for(Duration::from_millis(100)).await;
        if anna.closed.is_some() {
            break;
        }
    }
    assert_eq!(anna.closed, Some(CloseCode::TOO_MANY));
    // Carl does not read while others acquire and release leases.
    let mut carl = bench.join("Carl").await;
    carl.ok("arm.list", json!({})).await;
    for _ in 0..3000 {
        ben.take_arm("arm0").await;
        let lease = ben.ok("lease.acquire", json!({"arm": "arm0"})).await["lease"].clone();
        ben.ok("lease.release", json!({"lease": lease})).await;
        ben.run_for(Duration::from_millis(25)).await;
        carl.client.pong();
    }
    assert_eq!(ben.closed, None);
    carl.run_for(Duration::from_secs(1)).await;
    assert_eq!(carl.closed, Some(CloseCode::SLOW));
}
