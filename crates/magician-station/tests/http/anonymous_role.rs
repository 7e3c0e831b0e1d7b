//! Anonymous clients of this machine at every route, with and without a class.

use magician_station::Role;
use magician_station::http::ROUTES;
use serde_json::{Value, json};

use crate::bench::{Answer, HttpStation};

const CLASS: &str = "[class]\npin = \"482913\"\n[[pupil]]\nname = \"Ada\"\ncode = \"AAAA\"\n";

/// Open routes, repeated here so that a new route fails the test.
const OPEN: [(&str, &str); 5] = [
    ("GET", "/"),
    ("GET", "/assets/{name}"),
    ("GET", "/manifest.webmanifest"),
    ("GET", "/healthz"),
    ("GET", "/api/v1/openrpc.json"),
];
/// Routes with tests of their own, decided by first message, method or code.
const OF_CONTENT: [(&str, &str); 3] = [
    ("GET", "/api/v1/ws"),
    ("POST", "/api/v1/rpc"),
    ("POST", "/api/v1/pair"),
];
const VIEWER: [(&str, &str); 3] = [
    ("GET", "/api/v1/recordings/{name}"),
    ("GET", "/api/v1/programs/{name}"),
    ("GET", "/api/v1/link"),
];
const STUDENT: [(&str, &str); 2] = [
    ("PUT", "/api/v1/programs/{name}"),
    ("DELETE", "/api/v1/programs/{name}"),
];
const TEACHER: [(&str, &str); 1] = [("GET", "/api/v1/class/results.html")];

async fn class(bench: &HttpStation) {
    let token = bench.token(Role::Teacher);
    let answer = rpc(bench, &bearer(&token), "class.set", json!({"text": CLASS})).await;
    assert!(answer.json()["result"].is_object(), "{}", answer.body);
}

fn bearer(token: &str) -> String {
    format!("authorization: Bearer {token}\n")
}

async fn rpc(bench: &HttpStation, headers: &str, method: &str, params: Value) -> Answer {
    let request = json!({"jsonrpc": "2.0", "id": 1, "method": method, "params": params});
    bench
        .post("/api/v1/rpc", headers, &request.to_string())
        .await
}

#[tokio::test]
async fn stranger_is_a_viewer_on_every_route_during_a_class() {
    let all = [&OPEN[..], &OF_CONTENT, &VIEWER, &STUDENT, &TEACHER].concat();
    for route in ROUTES {
        assert!(all.contains(&(route.method, route.path)), "{route:?}");
    }
    for with_class in [false, true] {
        let bench = HttpStation::new().await;
        if with_class {
            class(&bench).await;
        }
        let viewer = bearer(&bench.token(Role::Viewer));
        let student = bearer(&bench.token(Role::Student));
        let teacher = bearer(&bench.token(Role::Teacher));
        let pin = bearer("482913");
        let stranger = if with_class {
            Role::Viewer
        } else {
            Role::Teacher
        };
        let mut people = vec![
            ("", stranger),
            (&viewer, Role::Viewer),
            (&student, Role::Student),
            (&teacher, Role::Teacher),
        ];
        if with_class {
            people.push((&pin, Role::Teacher));
        }
        for (headers, role) in people {
            for (needs, routes) in [
                (Role::Viewer, &VIEWER[..]),
                (Role::Student, &STUDENT),
                (Role::Teacher, &TEACHER),
            ] {
                for (method, path) in routes {
                    let path = path.replace("{name}", "house.svg");
                    let answer = bench
                        .raw(&format!(
                            "{method} {path} HTTP/1.1\nhost: {{host}}\nconnection: close\ncontent-length: 0\n{headers}\n"
                        ))
                        .await;
                    let told = format!(
                        "{method} {path} as {role:?} {with_class}: {}",
                        answer.status
                    );
                    assert_eq!(answer.status == 403, role < needs, "{told}");
                    assert_ne!(answer.status, 401, "{told}");
                }
            }
        }
    }
}

#[tokio::test]
async fn post_without_token_needs_the_pin_for_codes_and_freezes() {
    let bench = HttpStation::new().await;
    assert!(rpc(&bench, "", "class.freeze", json!({})).await.json()["result"].is_object());
    class(&bench).await;
    let shown = rpc(&bench, "", "class.get", json!({})).await.json();
    assert!(shown["result"]["pupils"][0]["code"].is_null(), "{shown}");
    assert!(shown["result"]["pin"].is_null(), "{shown}");
    let frozen = rpc(&bench, "", "class.freeze", json!({})).await.json();
    assert_eq!(frozen["error"]["data"]["needs"], "teacher", "{frozen}");
    let stopped = rpc(&bench, "", "arm.stop", json!({})).await.json();
    assert!(stopped["result"].is_object(), "{stopped}");
    let pin = bearer("482913");
    let shown = rpc(&bench, &pin, "class.get", json!({})).await.json();
    assert_eq!(shown["result"]["pupils"][0]["code"], "AAAA", "{shown}");
    assert!(rpc(&bench, &pin, "class.freeze", json!({})).await.json()["result"].is_object());
    // On a socket the PIN belongs into the hello.
    assert_eq!(
        bench
            .socket(&[("authorization", "Bearer 482913")])
            .await
            .err(),
        Some(401)
    );
    let mut page = bench.socket(&[]).await.unwrap();
    let hello = json!({"client": {"name": "page"}, "pin": "482913"});
    assert_eq!(
        page.call("session.hello", hello).await.unwrap()["role"],
        "teacher"
    );
    for _ in 0..5 {
        let wrong = rpc(&bench, &bearer("000000"), "class.get", json!({})).await;
        assert_eq!(wrong.status, 401, "{}", wrong.body);
    }
    let wrong = rpc(&bench, &pin, "class.get", json!({})).await;
    assert_eq!(wrong.status, 429, "{}", wrong.body);
    assert!(wrong.body.contains("wait"), "{}", wrong.body);
}

#[tokio::test]
async fn own_user_token_is_valid_only_on_this_machine() {
    let folder = tempfile::TempDir::new().unwrap();
    let tokens = magician_station::http::TokenStore::at(folder.path().join("tokens.toml"));
    let (tokens, own) = tokens.with_own().unwrap();
    let bench = HttpStation::with_tokens(tokens).await;
    class(&bench).await;
    let shown = rpc(&bench, &bearer(&own), "class.get", json!({}))
        .await
        .json();
    assert_eq!(shown["result"]["pin"], "482913", "{shown}");
    let forwarded = format!("{}x-forwarded-for: 192.168.1.9\n", bearer(&own));
    assert_eq!(
        rpc(&bench, &forwarded, "class.get", json!({})).await.status,
        401
    );
}
