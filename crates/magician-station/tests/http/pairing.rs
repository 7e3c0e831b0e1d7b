//! Pairing codes and tokens.

use magician_station::Role;
use serde_json::json;

use crate::bench::HttpStation;

#[tokio::test]
async fn pairing_code_gives_one_token() {
    let bench = HttpStation::new().await;
    let code = bench.tokens.pair(Role::Student).unwrap();
    assert!(code.len() == 6 && code.bytes().all(|digit| digit.is_ascii_digit()));
    let body = json!({"code": code, "name": "tablet"}).to_string();
    let paired = bench.post("/api/v1/pair", "", &body).await.json();
    assert_eq!(paired["role"], json!("student"));
    assert_eq!(bench.post("/api/v1/pair", "", &body).await.status, 401);
    let token = paired["token"].as_str().unwrap();
    let mut socket = bench
        .socket(&[("x-forwarded-for", "1.2.3.4")])
        .await
        .unwrap();
    let hello = json!({"client": {"name": "Tablet"}, "token": token});
    assert_eq!(
        socket.call("session.hello", hello).await.unwrap()["role"],
        json!("student")
    );
    assert_eq!(
        bench.tokens.list().unwrap().keys().collect::<Vec<_>>(),
        ["tablet"]
    );
    let file = format!("{:?}", bench.tokens.list().unwrap());
    assert!(!file.contains(token), "the file has a digest, and no token");
}

#[tokio::test]
async fn sixth_pairing_try_within_a_minute_is_refused() {
    let bench = HttpStation::new().await;
    let body = json!({"code": "000000x", "name": "x"}).to_string();
    for _ in 0..5 {
        assert_eq!(bench.post("/api/v1/pair", "", &body).await.status, 401);
    }
    let code = bench.tokens.pair(Role::Student).unwrap();
    let body = json!({"code": code, "name": "x"}).to_string();
    let late = bench.post("/api/v1/pair", "", &body).await;
    assert_eq!(late.status, 429);
    assert!(late.header("retry-after").unwrap().parse::<u64>().unwrap() <= 61);
}

#[tokio::test]
async fn revoked_token_ends_its_sessions() {
    let bench = HttpStation::new().await;
    let (name, token) = bench.tokens.create(Some("guest"), Role::Student).unwrap();
    let bearer = format!("Bearer {token}");
    let mut guest = bench.socket(&[("authorization", &bearer)]).await.unwrap();
    let hello = guest
        .call("session.hello", json!({"client": {"name": "Guest"}}))
        .await
        .unwrap();
    assert_eq!(
        hello["role"],
        json!("student"),
        "a token counts everywhere, also where none is needed"
    );
    guest.call("lease.acquire", json!({})).await.unwrap();
    bench.tokens.revoke(&name).unwrap();
    assert_eq!(guest.closed().await, Some(4403));
    let mut anna = bench.join("Anna").await;
    anna.call("lease.acquire", json!({})).await.unwrap();
    assert_eq!(
        bench.socket(&[("authorization", &bearer)]).await.err(),
        Some(401)
    );
}
