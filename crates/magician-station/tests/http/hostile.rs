//! Hostile clients: others do not notice them.

use std::time::Duration;

use serde_json::json;
use tokio::io::AsyncWriteExt;
use tokio::net::TcpStream;
use tokio::time::{Instant, timeout};

use crate::bench::HttpStation;

const STOP: &str = r#"{"jsonrpc":"2.0","id":1,"method":"arm.stop"}"#;
/// Limit for a stop, on the test's clock, which advances only while everything waits: a stop must
/// not wait for a timeout of others.
const MAX_STOP_TIME: Duration = Duration::from_secs(1);

async fn stops_at_once(bench: &HttpStation) {
    let began = Instant::now();
    let stop = bench.post("/api/v1/rpc", "", STOP);
    let answer = timeout(Duration::from_secs(60), stop)
        .await
        .expect("an answer");
    assert_eq!(answer.status, 200, "{}", answer.body);
    assert!(began.elapsed() < MAX_STOP_TIME, "{:?}", began.elapsed());
}

#[tokio::test(start_paused = true)]
async fn stop_and_login_are_prompt_despite_400_silent_connections() {
    let bench = HttpStation::new().await;
    let mut silent = Vec::new();
    for at in 0..400 {
        let mut stream = TcpStream::connect(bench.address).await.unwrap();
        // Half of them send the start of a head.
        if at % 2 == 0 {
            stream
                .write_all(b"POST /api/v1/rpc HTTP/1.1\r\nhos")
                .await
                .unwrap();
        }
        silent.push(stream);
    }
    stops_at_once(&bench).await;
    let mut teacher = bench.join("Teacher").await;
    teacher.call("arm.stop", json!({})).await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn slow_bodies_do_not_block_a_stop() {
    let bench = HttpStation::new().await;
    let mut slow = Vec::new();
    for _ in 0..300 {
        let mut stream = TcpStream::connect(bench.address).await.unwrap();
        let head = format!(
            "POST /api/v1/rpc HTTP/1.1\r\nhost: {}\r\ncontent-type: application/json\r\n\
             content-length: 100\r\n\r\n{{",
            bench.address
        );
        stream.write_all(head.as_bytes()).await.unwrap();
        slow.push(stream);
    }
    stops_at_once(&bench).await;
}

#[tokio::test]
async fn silent_or_invalid_connections_block_no_client() {
    let bench = HttpStation::new().await;
    let mut anna = bench.join("Anna").await;
    let mut silent = Vec::new();
    for at in 0..200 {
        let mut stream = TcpStream::connect(bench.address).await.unwrap();
        if at % 2 == 0 {
            let _ = stream.write_all(&[0xFF, 0x00, 0x16, 0x03]).await;
        }
        silent.push(stream);
    }
    anna.call("lease.acquire", json!({})).await.unwrap();
    anna.call("arm.move", json!({"to": [220, 10, 50, 0]}))
        .await
        .unwrap();
    assert_eq!(bench.get("/healthz", "").await.status, 200);
}

#[tokio::test]
async fn endless_request_heads_are_closed() {
    let bench = HttpStation::new().await;
    let mut head = "GET / HTTP/1.1\nhost: {host}\n".to_owned();
    for at in 0..5000 {
        head.push_str(&format!("x-{at}: {}\n", "y".repeat(100)));
    }
    let answer = bench.raw(&head).await;
    assert!([0, 400, 431].contains(&answer.status), "{}", answer.status);
    assert_eq!(bench.get("/healthz", "").await.status, 200);
}
