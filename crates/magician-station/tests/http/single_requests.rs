//! Single requests by POST.

use serde_json::{Value, json};

use crate::bench::HttpStation;

async fn call(bench: &HttpStation, method: &str, params: Value) -> Value {
    let body = json!({"jsonrpc": "2.0", "id": "a", "method": method, "params": params}).to_string();
    let answer = bench.post("/api/v1/rpc", "", &body).await;
    assert_eq!(answer.status, 200, "{}", answer.body);
    answer.json()
}

#[tokio::test]
async fn single_request_acquires_and_releases_a_free_lease() {
    let bench = HttpStation::new().await;
    let moved = call(&bench, "arm.move", json!({"to": [220, 30, 50, 0]})).await;
    assert_eq!(
        (&moved["id"], &moved["result"]["y"]),
        (&json!("a"), &json!(30.0))
    );
    let mut anna = bench.join("Anna").await;
    anna.call("lease.acquire", json!({})).await.unwrap();
    let refused = call(&bench, "arm.move", json!({"to": [220, 0, 50, 0]})).await;
    assert_eq!(
        (
            &refused["error"]["code"],
            &refused["error"]["data"]["holder"]["name"]
        ),
        (&json!(-32002), &json!("Anna"))
    );
    let stopped = call(&bench, "arm.stop", json!({})).await;
    assert_eq!(stopped["result"]["arms"][0]["stood"], json!(true));
    // Sessions of single requests are not listed.
    let sessions = anna.call("session.list", json!({})).await.unwrap();
    assert_eq!(sessions["sessions"].as_array().unwrap().len(), 1);
}

#[tokio::test]
async fn command_queued_by_a_single_request_continues() {
    let bench = HttpStation::new().await;
    let queued = call(
        &bench,
        "arm.move",
        json!({"to": [220, 60, 50, 0], "wait": false}),
    )
    .await;
    assert!(queued["result"]["index"].is_u64(), "{queued}");
    let mut anna = bench.join("Anna").await;
    anna.until("y", json!(60.0)).await;
}

#[tokio::test]
async fn session_method_refuses_a_single_request() {
    let bench = HttpStation::new().await;
    for (method, params) in [
        ("session.hello", json!({"client": {"name": "x"}})),
        ("lease.acquire", json!({})),
        ("jog.start", json!({"axis": "x+"})),
        ("arm.subscribe", json!({"rate": 1})),
    ] {
        let refused = call(&bench, method, params).await;
        assert_eq!(
            (
                &refused["error"]["code"],
                &refused["error"]["data"]["method"]
            ),
            (&json!(-32600), &json!(method))
        );
    }
    let answer = bench.post("/api/v1/rpc", "", "{").await;
    assert_eq!(
        (answer.status, &answer.json()["error"]["code"]),
        (200, &json!(-32700))
    );
    let large = " ".repeat(1_100_000);
    assert_eq!(bench.post("/api/v1/rpc", "", &large).await.status, 413);
    let stop = json!({"jsonrpc": "2.0", "method": "arm.stop"}).to_string();
    assert_eq!(bench.post("/api/v1/rpc", "", &stop).await.status, 204);
}

#[tokio::test]
async fn closed_request_stops_its_motion() {
    use tokio::io::AsyncWriteExt;
    let bench = HttpStation::new().await;
    let mut anna = bench.join("Anna").await;
    let slow = json!({"command": "PTPCommonParams", "fields": {"velocity_ratio": 1, "acceleration_ratio": 1}});
    call(&bench, "arm.set", slow).await;
    let body = json!({"jsonrpc": "2.0", "id": 1, "method": "arm.move", "params": {"to": [200, 200, 50, 0]}}).to_string();
    let mut stream = tokio::net::TcpStream::connect(bench.address).await.unwrap();
    let head = format!(
        "POST /api/v1/rpc HTTP/1.1\r\nhost: {}\r\ncontent-type: application/json\r\ncontent-length: {}\r\n\r\n{body}",
        bench.address,
        body.len()
    );
    stream.write_all(head.as_bytes()).await.unwrap();
    anna.until("moving", json!(true)).await;
    drop(stream);
    anna.until("moving", json!(false)).await;
    let state = anna.call("arm.state", json!({})).await.unwrap();
    assert!(state["y"].as_f64().unwrap() < 199.0, "{state}");
    assert_eq!(state["holder"], json!(null));
}
