//! Clients that mean no good: others do not notice.

use serde_json::json;
use tokio::io::AsyncWriteExt;
use tokio::net::TcpStream;

use crate::bench::Bench;

#[tokio::test]
async fn connections_that_say_nothing_or_nonsense_keep_nobody_out() {
    let bench = Bench::new().await;
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
async fn heads_without_end_are_cut() {
    let bench = Bench::new().await;
    let mut head = "GET / HTTP/1.1\nhost: {host}\n".to_owned();
    for at in 0..5000 {
        head.push_str(&format!("x-{at}: {}\n", "y".repeat(100)));
    }
    let answer = bench.raw(&head).await;
    assert!([0, 400, 431].contains(&answer.status), "{}", answer.status);
    assert_eq!(bench.get("/healthz", "").await.status, 200);
}
