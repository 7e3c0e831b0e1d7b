//! Table of routes, and the headers of every response.

use magician_station::Role;
use magician_station::http::{Admission, PageFile, Pages, ROUTES, RouteNeeds};
use serde_json::json;

use crate::bench::{Answer, HttpStation};

#[tokio::test]
async fn every_route_exists_with_security_headers() {
    let bench = HttpStation::new().await;
    for route in ROUTES {
        let method = route.method;
        let path = &route.path.replace("{name}", "house.svg");
        let answer = bench
            .raw(&format!(
                "{method} {path} HTTP/1.1\nhost: {{host}}\nconnection: close\ncontent-length: 0\n\n"
            ))
            .await;
        let expected = match (route.path, method) {
            ("/api/v1/ws", _) => 426,
            (_, "POST") => 415,
            ("/" | "/assets/{name}" | "/manifest.webmanifest", _) => 404,
            ("/api/v1/recordings/{name}" | "/api/v1/link", _) => 404,
            (_, "PUT") => 201,
            (_, "DELETE") => 204,
            _ => 200,
        };
        assert_eq!(answer.status, expected, "{method} {path}");
        assert_eq!(
            answer.header("x-content-type-options"),
            Some("nosniff"),
            "{path}"
        );
        assert_eq!(answer.header("referrer-policy"), Some("no-referrer"));
        assert_eq!(
            answer.header("cross-origin-opener-policy"),
            Some("same-origin")
        );
        assert_eq!(
            answer.header("cross-origin-resource-policy"),
            Some("same-origin")
        );
        let policy = answer.header("content-security-policy").unwrap();
        assert!(
            policy.starts_with("default-src 'self'") && policy.ends_with("frame-ancestors 'none'")
        );
        assert_eq!(answer.header("access-control-allow-origin"), None);
        let wrong = bench
            .raw(&format!(
                "PATCH {path} HTTP/1.1\nhost: {{host}}\nconnection: close\n\n"
            ))
            .await;
        assert_eq!(wrong.status, 405, "{path}");
        assert!(wrong.header("allow").unwrap().contains(method));
        // A foreign host is refused before the route is looked up.
        let foreign = bench
            .raw(&format!("{method} {path} HTTP/1.1\nhost: evil.example\nconnection: close\ncontent-length: 0\n\n"))
            .await;
        assert_eq!(foreign.status, 403, "{path}");
        assert!(foreign.body.contains("--allow-host"), "{}", foreign.body);
        let page = format!(
            "{method} {path} HTTP/1.1\nhost: {{host}}\norigin: http://evil.example\nconnection: close\ncontent-length: 0\n\n"
        );
        let page = bench.raw(&page).await;
        assert_eq!(page.status, 403, "{path}");
        assert!(page.body.contains("--allow-origin"), "{}", page.body);
    }
    assert_eq!(bench.get("/nowhere", "").await.status, 404);
    assert_eq!(bench.get("/api/v1/../../etc/passwd", "").await.status, 404);
    assert_eq!(
        bench
            .raw("OPTIONS /healthz HTTP/1.1\nhost: {host}\nconnection: close\n\n")
            .await
            .status,
        405
    );
}

#[tokio::test]
async fn head_returns_the_headers_of_get() {
    static PAGE: &[u8] = b"\x1f\x8b\x08\x00\x00\x00\x00\x00\x02\xff\xb3\xc9\x28\xc9\xcd\xb1\x03\x00\x41\x0c\x43\xc7\x06\x00\x00\x00";
    let page = PageFile {
        path: "/",
        kind: "text/html",
        gzip: PAGE,
    };
    let bench = HttpStation::paged(Pages::new([page])).await;
    let name = "house.svg";
    let program = format!(
        "PUT /api/v1/programs/{name} HTTP/1.1\nhost: {{host}}\nconnection: close\ncontent-length: 6\n\n<svg/>"
    );
    assert_eq!(bench.raw(&program).await.status, 201);
    let recordings = bench.folder.path().join("recordings");
    std::fs::create_dir_all(&recordings).unwrap();
    std::fs::write(recordings.join("arm-1.mcap"), "a recording").unwrap();
    let mut lengths = 0;
    for route in ROUTES.iter().filter(|route| route.method == "GET") {
        for name in [name, "arm-1.mcap", "absent"] {
            for encoding in ["", "accept-encoding: gzip\n"] {
                let path = &route.path.replace("{name}", name);
                let get = bench.get(path, encoding).await;
                let head = bench
                    .raw(&format!(
                        "HEAD {path} HTTP/1.1\nhost: {{host}}\nconnection: close\n{encoding}\n"
                    ))
                    .await;
                assert_eq!(
                    (head.status, head.body.as_str()),
                    (get.status, ""),
                    "{path}"
                );
                let told = |answer: &Answer| {
                    let headers = answer.headers.iter().filter(|(name, _)| name != "date");
                    headers.cloned().collect::<Vec<_>>()
                };
                assert_eq!(told(&head), told(&get), "{path}");
                let length = get
                    .header("content-length")
                    .map(|length| length.parse::<usize>());
                let length = length
                    .unwrap_or_else(|| panic!("{path} tells no length"))
                    .unwrap();
                lengths += length;
            }
        }
    }
    assert!(lengths > 100_000, "{lengths}: the answers are not empty");
}

#[tokio::test]
async fn missing_token_gets_401() {
    let bench = HttpStation::new().await;
    let body = json!({"jsonrpc": "2.0", "id": 1, "method": "server.info"}).to_string();
    for route in ROUTES
        .iter()
        .filter(|route| route.needs != RouteNeeds::Nothing)
    {
        if route.method != "POST" {
            continue;
        }
        // A proxy in between means that the client is not on this machine.
        let answer = bench
            .post(route.path, "x-forwarded-for: 1.2.3.4\n", &body)
            .await;
        assert_eq!(answer.status, 401, "{}", route.path);
        assert_eq!(answer.header("www-authenticate"), Some("Bearer"));
    }
    let wrong = bench
        .post("/api/v1/rpc", "authorization: Bearer nonsense\n", &body)
        .await;
    assert_eq!(wrong.status, 401, "a token that is given counts everywhere");
    let token = bench.token(Role::Viewer);
    let headers = format!("x-forwarded-for: 1.2.3.4\nauthorization: Bearer {token}\n");
    let right = bench.post("/api/v1/rpc", &headers, &body).await;
    assert_eq!(
        (right.status, &right.json()["result"]["api"]),
        (200, &json!(1))
    );
    let in_address = bench.get(&format!("/healthz?token={token}"), "").await;
    assert_eq!(in_address.status, 400);
}

#[tokio::test]
async fn listed_origin_is_admitted_with_cors_headers() {
    let origin = "https://lessons.example";
    let admission = Admission {
        origins: vec![origin.to_owned()],
        ..Admission::default()
    };
    let bench = HttpStation::with(admission).await;
    let answer = bench.get("/healthz", &format!("origin: {origin}\n")).await;
    assert_eq!(answer.header("access-control-allow-origin"), Some(origin));
    assert_eq!(answer.header("vary"), Some("Origin"));
    let asked = bench
        .raw(&format!(
            "OPTIONS /api/v1/rpc HTTP/1.1\nhost: {{host}}\norigin: {origin}\nconnection: close\n\n"
        ))
        .await;
    assert_eq!(asked.status, 204);
    assert_eq!(
        asked.header("access-control-allow-headers"),
        Some("authorization, content-type")
    );
}

#[tokio::test]
async fn openrpc_document_is_served() {
    let bench = HttpStation::new().await;
    let document = bench.get("/api/v1/openrpc.json", "").await.json();
    let methods = document["methods"].as_array().unwrap();
    let moving = methods
        .iter()
        .find(|method| method["name"] == "arm.move")
        .unwrap();
    assert_eq!(
        (&moving["x-role"], &moving["x-lease"]),
        (&json!("student"), &json!(true))
    );
    assert_eq!(moving["params"][1]["schema"]["minItems"], json!(4));
}
