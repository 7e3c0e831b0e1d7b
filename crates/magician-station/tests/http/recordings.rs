//! Recordings as files, and their download.

use magician_station::Role;
use serde_json::{Value, json};

use crate::bench::HttpStation;

async fn call(bench: &HttpStation, method: &str, params: Value) -> Value {
    let request = json!({"jsonrpc": "2.0", "id": 1, "method": method, "params": params});
    let answer = bench.post("/api/v1/rpc", "", &request.to_string()).await;
    let answer: Value = serde_json::from_str(&answer.body).unwrap();
    assert!(answer["error"].is_null(), "{method}: {answer}");
    answer["result"].clone()
}

#[tokio::test]
async fn viewer_downloads_a_recording() {
    let bench = HttpStation::new().await;
    let name = call(&bench, "record.start", json!({"rate": 50})).await["name"].clone();
    let name = name.as_str().unwrap().to_owned();
    // The part already written can be downloaded during the recording.
    let path = format!("/api/v1/recordings/{name}");
    assert_eq!(bench.get(&path, "").await.status, 200);
    for y in [40, -40, 40] {
        call(&bench, "arm.move", json!({"to": [220, y, 50, 0]})).await;
    }
    let over = call(&bench, "record.stop", json!({})).await;
    let answer = bench.get(&path, "").await;
    assert_eq!(answer.status, 200);
    assert_eq!(
        answer.header("content-length"),
        Some(over["bytes"].to_string().as_str())
    );
    assert!(answer.body.contains("MCAP0") && answer.body.trim_end().ends_with("MCAP0"));
    assert!(answer.body.contains("/pose") && answer.body.contains("/joints"));
    let saved = call(&bench, "record.save_last", json!({"seconds": 60})).await;
    assert_ne!(saved["name"], json!(name));
    let saved = format!("/api/v1/recordings/{}", saved["name"].as_str().unwrap());
    assert_eq!(bench.get(&saved, "").await.status, 200);
    let viewer = format!("authorization: Bearer {}\n", bench.token(Role::Viewer));
    assert_eq!(bench.get(&path, &viewer).await.status, 200);
    let wrong = "authorization: Bearer nonsense\n";
    assert_eq!(bench.get(&path, wrong).await.status, 401);
    // A client from elsewhere needs a token.
    let elsewhere = "x-forwarded-for: 10.0.0.1\n";
    assert_eq!(bench.get(&path, elsewhere).await.status, 401);
    let head = format!("HEAD {path} HTTP/1.1\nhost: {{host}}\nconnection: close\n\n");
    let head = bench.raw(&head).await;
    assert_eq!((head.status, head.body.as_str()), (200, ""));
    for none in [
        "nothing.mcap",
        "..%2Fstation%2Ftokens.toml",
        "../station/tokens.toml",
        "..",
        "",
        "a%00.mcap",
    ] {
        let path = format!("/api/v1/recordings/{none}");
        assert_eq!(bench.get(&path, "").await.status, 404, "{none}");
    }
}
