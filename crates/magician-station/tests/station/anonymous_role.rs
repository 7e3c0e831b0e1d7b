//! Anonymous clients of this machine: teachers without a class, viewers with one, until they give
//! the teacher's PIN.

use std::time::Duration;

use magician_station::api::{Example, METHODS};
use magician_station::{Grant, Role};
use serde_json::{Value, json};

use crate::bench::{LocalStation, Tester};
use crate::rights::{CLASS, ClassBench, Row, table};

const FORBIDDEN: i64 = -32001;
const TOO_MANY: i64 = -32006;
const PIN: &str = "482913";
/// Columns of the documented table.
const VIEWER: usize = 0;
const TEACHER: usize = 3;

async fn hello(mut tester: Tester, more: &str, value: Value) -> Result<Tester, Value> {
    let params = json!({"client": {"name": "page"}, more: value});
    tester.call("session.hello", params).await.map(|_| tester)
}

/// Opens a page on this machine that does not identify itself.
async fn stranger(bench: &LocalStation) -> Tester {
    hello(bench.stranger(), "role", json!("teacher"))
        .await
        .unwrap()
}

async fn by_pin(bench: &LocalStation, pin: &str) -> Result<Tester, Value> {
    hello(bench.stranger(), "pin", json!(pin)).await
}

fn token() -> Grant {
    Grant {
        role: Role::Teacher,
        token: Some("desk".to_owned()),
    }
}

/// True if the role was too low: only that error names the required role.
fn is_refused(error: Option<&Value>) -> bool {
    error.is_some_and(|error| error["code"] == FORBIDDEN && error["data"]["needs"].is_string())
}

async fn role(bench: &LocalStation, name: &str) -> Value {
    let mut looks = bench.join_as("looks", Role::Viewer).await;
    let list = looks.ok("session.list", json!({})).await["sessions"].clone();
    let mut list = list.as_array().unwrap().iter();
    list.find(|one| one["name"] == name).unwrap()["role"].clone()
}

/// Returns all methods with their rows in the documented table.
fn cells() -> Vec<(Row, String)> {
    let rows = table().into_iter().flat_map(|row| {
        let methods = row.methods.clone();
        methods.into_iter().map(move |method| {
            let row = Row {
                what: row.what.clone(),
                methods: Vec::new(),
                cells: row.cells.clone(),
            };
            (row, method)
        })
    });
    let cells: Vec<_> = rows
        .filter(|(_, method)| method != "session.hello")
        .collect();
    let named = |name: &str| cells.iter().any(|(_, method)| method == name);
    let missing: Vec<_> = { METHODS.iter() }
        .map(|method| method.name)
        .filter(|name| *name != "session.hello" && !named(name))
        .collect();
    assert!(missing.is_empty(), "without a row: {missing:?}");
    cells
}

#[tokio::test(start_paused = true)]
async fn class_makes_strangers_viewers_on_every_method() {
    let mut wrong = Vec::new();
    for (row, method) in cells() {
        for who in ["stranger", "pin", "token"] {
            let lesson = ClassBench::new().await;
            let bench = &lesson.bench;
            let params = Value::Object(lesson.params(&row, &method));
            let mut tester = match who {
                "stranger" => stranger(bench).await,
                "pin" => by_pin(bench, PIN).await.unwrap(),
                _ => {
                    let socket = bench.socket_of(Some(token()), "127.0.0.1:1");
                    hello(socket, "role", json!("teacher")).await.unwrap()
                }
            };
            let column = if who == "stranger" { VIEWER } else { TEACHER };
            let expected = row.cells[column] == "no";
            let outcome = tester.call(&method, params).await;
            if is_refused(outcome.as_ref().err()) != expected {
                wrong.push(format!("{method} as {who}: {outcome:?}"));
            }
        }
        // The same by single requests. A PIN in those is tested over HTTP.
        for who in [None, Some(token())] {
            let lesson = ClassBench::new().await;
            let params = Value::Object(lesson.params(&row, &method));
            let column = if who.is_none() { VIEWER } else { TEACHER };
            let expected = row.cells[column] == "no";
            let answer = lesson.bench.once_as(who.clone(), &method, params).await;
            let error = answer.get("error");
            let needs_session = error.is_some_and(|error| {
                error["message"]
                    .as_str()
                    .unwrap()
                    .contains("needs a session")
            });
            if !needs_session && is_refused(error) != expected {
                wrong.push(format!("POST {method} as {who:?}: {answer}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[tokio::test(start_paused = true)]
async fn stranger_may_call_every_method_without_a_class() {
    for (_, method) in cells() {
        let bench = LocalStation::new(1).await;
        let ids = json!({"job": "j0-1", "lease": "l0-1"});
        let params = Example::of(&method).unwrap().params_after(&ids);
        let mut tester = stranger(&bench).await;
        let outcome = tester.call(&method, params.clone()).await;
        assert!(!is_refused(outcome.as_ref().err()), "{method}: {outcome:?}");
        let answer = LocalStation::new(1)
            .await
            .once_as(None, &method, params)
            .await;
        assert!(!is_refused(answer.get("error")), "POST {method}: {answer}");
    }
}

#[tokio::test(start_paused = true)]
async fn class_start_revokes_a_strangers_lease_and_its_end_restores_the_role() {
    let bench = LocalStation::new(1).await;
    let mut page = stranger(&bench).await;
    assert_eq!(role(&bench, "page").await, "teacher");
    page.lease().await;
    let far = json!({"kind": "joint", "to": [200, 100, 50, 0]});
    page.send("arm.move", far);
    tokio::time::sleep(Duration::from_millis(100)).await;
    let mut teacher = bench.join_as("Ms Lee", Role::Teacher).await;
    teacher.ok("class.set", json!({"text": CLASS})).await;
    assert_eq!(role(&bench, "page").await, "viewer");
    let arms = teacher.ok("arm.list", json!({})).await;
    assert_eq!(arms["arms"][0]["holder"], Value::Null);
    tokio::time::sleep(Duration::from_secs(1)).await;
    assert_eq!(teacher.ok("arm.state", json!({})).await["moving"], false);
    // The page can watch and stop on the same socket.
    assert!(page.ok("class.get", json!({})).await["pupils"][0]["code"].is_null());
    assert_eq!(page.ok("class.get", json!({})).await["pin"], Value::Null);
    assert_eq!(page.code("lease.acquire", json!({})).await, FORBIDDEN);
    page.ok("arm.stop", json!({})).await;
    teacher.ok("class.set", json!({"text": ""})).await;
    assert_eq!(role(&bench, "page").await, "teacher");
    page.lease().await;
}

#[tokio::test(start_paused = true)]
async fn wrong_pins_are_limited_to_five_a_minute() {
    let bench = LocalStation::new(1).await;
    let mut teacher = bench.join_as("Ms Lee", Role::Teacher).await;
    teacher.ok("class.set", json!({"text": CLASS})).await;
    // Clients from elsewhere use up no tries.
    for _ in 0..9 {
        let socket = bench.socket_of(None, "192.168.1.9:1");
        let error = hello(socket, "pin", json!("000000")).await.err().unwrap();
        assert_eq!(error["code"], FORBIDDEN);
    }
    for _ in 0..5 {
        let error = by_pin(&bench, "000000").await.err().unwrap();
        assert_eq!(error["code"], FORBIDDEN, "{error}");
    }
    let error = by_pin(&bench, PIN).await.err().unwrap();
    assert_eq!(error["code"], TOO_MANY, "{error}");
    assert_eq!(error["data"]["limit"], 5);
    let wait = error["data"]["wait_s"].as_f64().unwrap();
    stranger(&bench).await.ok("arm.stop", json!({})).await;
    tokio::time::sleep(Duration::from_secs_f64(wait)).await;
    let mut good = by_pin(&bench, PIN).await.unwrap();
    assert_eq!(good.ok("class.get", json!({})).await["pin"], PIN);
}

#[tokio::test(start_paused = true)]
async fn generated_pin_is_stored_and_a_new_one_ends_old_sessions() {
    let bench = LocalStation::new(1).await;
    let mut teacher = bench.join_as("Ms Lee", Role::Teacher).await;
    let made = "[class]\n[[pupil]]\nname = \"Ada\"\n";
    let shown = teacher.ok("class.set", json!({"text": made})).await;
    let pin = shown["pin"].as_str().unwrap().to_owned();
    assert_eq!(pin.len(), 6);
    let again = teacher.ok("class.set", json!({"text": made})).await;
    assert_eq!(again["pin"], json!(pin));
    let mut page = by_pin(&bench, &pin).await.unwrap();
    assert_eq!(page.ok("class.get", json!({})).await["pin"], json!(pin));
    let other = if pin == PIN { "111111" } else { PIN };
    let text = made.replace("[class]", &format!("[class]\npin = \"{other}\""));
    let kept = teacher.ok("class.set", json!({"text": text})).await;
    assert_eq!(
        kept["pin"],
        json!(pin),
        "an old file brings no old PIN back"
    );
    let set = json!({"text": text, "use_codes": true});
    teacher.ok("class.set", set).await;
    page.listen(Duration::from_secs(1)).await;
    assert_eq!(page.closed.map(|code| code.0), Some(4403));
    for wrong in ["12345", "1234567", "12345a"] {
        let text = format!("[class]\npin = \"{wrong}\"\n");
        teacher.code("class.set", json!({"text": text})).await;
    }
}

#[tokio::test(start_paused = true)]
async fn creator_of_a_class_stays_teacher_and_gets_the_pin() {
    let bench = LocalStation::new(1).await;
    let (mut maker, mut other) = (stranger(&bench).await, stranger(&bench).await);
    let made = maker.ok("class.set", json!({"text": CLASS})).await;
    assert_eq!(made["pin"], json!(PIN));
    maker.ok("class.freeze", json!({})).await;
    let refused = other.call("class.free", json!({})).await;
    assert!(is_refused(refused.as_ref().err()), "{refused:?}");
}
