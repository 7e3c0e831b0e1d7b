//! WebSockets: limits, admission, closing.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use futures_util::SinkExt;
use magician_station::{MAX_SOCKETS, Role};
use serde_json::json;
use tokio::sync::watch;
use tokio::task::JoinSet;
use tokio::time::Instant;
use tokio_tungstenite::tungstenite::Message;

use crate::bench::HttpStation;

#[tokio::test]
async fn other_session_may_stop_the_arm() {
    let bench = HttpStation::new().await;
    let (mut anna, mut ben) = (bench.join("Anna").await, bench.join("Ben").await);
    anna.call("lease.acquire", json!({})).await.unwrap();
    let state = anna
        .call("arm.move", json!({"to": [220, 40, 50, 0]}))
        .await
        .unwrap();
    assert_eq!(state["y"], json!(40.0));
    let slow = json!({"command": "PTPCommonParams", "fields": {"velocity_ratio": 1, "acceleration_ratio": 1}});
    anna.call("arm.set", slow).await.unwrap();
    let moving = anna
        .send("arm.move", json!({"to": [200, -150, 50, 0]}))
        .await;
    ben.until("moving", json!(true)).await;
    ben.call("arm.stop", json!({})).await.unwrap();
    assert_eq!(
        anna.answer(moving).await.unwrap_err()["code"],
        json!(-32007)
    );
    assert!(!bench.arm.state().moving);
}

#[tokio::test]
async fn binary_or_oversized_message_closes_the_socket() {
    let bench = HttpStation::new().await;
    let mut anna = bench.join("Anna").await;
    anna.socket
        .send(Message::binary(vec![1, 2, 3]))
        .await
        .unwrap();
    assert_eq!(anna.closed().await, Some(1003));
    let mut ben = bench.join("Ben").await;
    ben.socket
        .send(Message::text("x".repeat(1_100_000)))
        .await
        .unwrap();
    assert_eq!(ben.closed().await, Some(1009));
}

#[tokio::test]
async fn socket_upgrade_checks_host_origin_and_token() {
    let bench = HttpStation::new().await;
    assert_eq!(
        bench
            .socket(&[("origin", "http://evil.example")])
            .await
            .err(),
        Some(403)
    );
    assert_eq!(bench.socket(&[("origin", "null")]).await.err(), Some(403));
    assert_eq!(
        bench.socket(&[("host", "evil.example")]).await.err(),
        Some(403)
    );
    assert_eq!(
        bench
            .socket(&[("authorization", "Bearer nonsense")])
            .await
            .err(),
        Some(401)
    );
    let own = format!("http://{}", bench.address);
    assert!(bench.socket(&[("origin", &own)]).await.is_ok());
    let mut foreign = bench
        .socket(&[("x-forwarded-for", "1.2.3.4")])
        .await
        .unwrap();
    let hello = foreign
        .call("session.hello", json!({"client": {"name": "x"}}))
        .await;
    assert_eq!(hello.unwrap_err()["code"], json!(-32001));
    assert_eq!(foreign.closed().await, Some(4401));
    let token = bench.token(Role::Viewer);
    let mut viewer = bench.socket(&[]).await.unwrap();
    let hello = json!({"client": {"name": "x"}, "token": token});
    assert_eq!(
        viewer.call("session.hello", hello).await.unwrap()["role"],
        json!("viewer")
    );
}

/// Client of another machine, as reported by a proxy on this one.
const ELSEWHERE: &[(&str, &str)] = &[("x-forwarded-for", "192.0.2.7")];

#[tokio::test(start_paused = true)]
async fn silent_remote_sockets_are_evicted_for_a_teacher() {
    let bench = HttpStation::new().await;
    let mut silent = Vec::new();
    for _ in 0..80 {
        silent.push(bench.socket(ELSEWHERE).await.unwrap());
        if silent.len() % 20 == 0 {
            let mut teacher = bench.join("Teacher").await;
            teacher.call("arm.stop", json!({})).await.unwrap();
        }
    }
    // Oldest first: of eighty sockets twelve are left.
    for socket in &mut silent[..68] {
        assert_eq!(socket.closed().await, Some(4408));
    }
    let token = bench.token(Role::Viewer);
    let hello = json!({"client": {"name": "x"}, "token": token});
    let last = silent.last_mut().unwrap();
    last.call("session.hello", hello).await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn silent_local_sockets_are_evicted_for_new_ones() {
    let bench = HttpStation::new().await;
    let mut silent = Vec::new();
    for _ in 0..9 {
        silent.push(bench.socket(&[]).await.unwrap());
    }
    for socket in &mut silent[..5] {
        assert_eq!(socket.closed().await, Some(4408));
    }
    let mut anna = bench.join("Anna").await;
    anna.call("arm.stop", json!({})).await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn prompt_hello_succeeds_during_a_flood_of_silent_sockets() {
    for headers in [&[][..], ELSEWHERE] {
        let bench = Arc::new(HttpStation::new().await);
        let (opened, mut counts) = watch::channel(0);
        let (opened, mut strangers) = (Arc::new(opened), JoinSet::new());
        for _ in 0..4 {
            let (bench, opened) = (Arc::clone(&bench), Arc::clone(&opened));
            strangers.spawn(async move {
                let mut silent = VecDeque::new();
                loop {
                    silent.extend(bench.socket(headers).await);
                    opened.send_modify(|count| *count += 1);
                    if silent.len() > 40 {
                        silent.pop_front();
                    }
                }
            });
        }
        for _ in 0..10 {
            let token = bench.token(Role::Teacher);
            let mut teacher = bench.socket(headers).await.unwrap();
            // While the hello is on its way many other sockets may arrive.
            let before = *counts.borrow();
            let many = counts.wait_for(|count| *count >= before + 20);
            let sleep = tokio::time::sleep(Duration::from_millis(90));
            tokio::select! {
                _ = many => {}
                () = sleep => {}
            }
            let hello = json!({"client": {"name": "teacher"}, "token": token});
            let hello = teacher.call("session.hello", hello).await.unwrap();
            assert_eq!(hello["role"], json!("teacher"));
        }
    }
}

#[tokio::test(start_paused = true)]
async fn uncheckable_token_is_not_reported_as_invalid() {
    let bench = HttpStation::new().await;
    let token = bench.token(Role::Student);
    let file = bench.folder.path().join("station/tokens.toml");
    std::fs::remove_file(&file).unwrap();
    // A folder in place of the file cannot be read, even by root.
    std::fs::create_dir(&file).unwrap();
    let header = format!("authorization: Bearer {token}\n");
    let stop = r#"{"jsonrpc":"2.0","id":1,"method":"arm.stop"}"#;
    let answer = bench.post("/api/v1/rpc", &header, stop).await;
    assert_eq!(answer.status, 503);
    assert!(
        answer.body.contains("cannot check tokens"),
        "{}",
        answer.body
    );
    let mut socket = bench.socket(&[]).await.unwrap();
    let hello = json!({"client": {"name": "x"}, "token": token});
    socket.send("session.hello", hello).await;
    assert_eq!(socket.closed().await, Some(1013));
}

#[tokio::test(start_paused = true)]
async fn hello_timeout_is_2_s_remote_and_5_s_local() {
    let bench = HttpStation::new().await;
    for (headers, seconds) in [(ELSEWHERE, 2), (&[][..], 5)] {
        let mut silent = bench.socket(headers).await.unwrap();
        let began = Instant::now();
        assert_eq!(silent.closed().await, Some(4408));
        assert_eq!(began.elapsed().as_secs(), seconds);
    }
}

#[tokio::test]
async fn socket_without_a_place_is_closed_with_its_reason() {
    let bench = HttpStation::new().await;
    let mut sockets = Vec::new();
    for _ in 0..MAX_SOCKETS {
        sockets.push(bench.join("Anna").await);
    }
    let mut beyond = bench.socket(&[]).await.unwrap();
    assert_eq!(beyond.closed().await, Some(4503));
    let body = json!({"jsonrpc": "2.0", "id": 1, "method": "arm.stop"}).to_string();
    assert_eq!(
        bench.post("/api/v1/rpc", "", &body).await.status,
        200,
        "a stop is always taken"
    );
}

#[tokio::test]
async fn station_end_closes_sockets() {
    let bench = HttpStation::new().await;
    let mut anna = bench.join("Anna").await;
    bench.over.send(true).unwrap();
    let because = (1001, "the station ends".to_owned());
    assert_eq!(anna.closed_because().await, Some(because));
    assert!(tokio::net::TcpStream::connect(bench.address).await.is_err());
    let _ = &bench.station;
}
