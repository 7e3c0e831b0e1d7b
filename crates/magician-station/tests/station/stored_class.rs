//! Files of a class at the next start: ended, damaged, missing.

use magician_station::Role;
use serde_json::{Value, json};

use crate::bench::LocalStation;

/// Starts a station with one of the stored files of an earlier one changed.
async fn after(name: &'static str, change: impl FnOnce(&str) -> String) -> LocalStation {
    let bench = LocalStation::new(1).await;
    let mut teacher = bench.join_as("Ms Lee", Role::Teacher).await;
    let names = json!({"names": ["Ada"]});
    teacher.ok("class.set", names).await;
    let kept = bench.kept.copy();
    {
        let mut files = kept.files.lock().unwrap();
        let text = files.get(name).cloned().unwrap_or_default();
        files.insert(name.to_owned(), change(&text));
    }
    LocalStation::after(kept).await
}

async fn class(bench: &LocalStation) -> Value {
    let mut teacher = bench.join_as("Ms Lee", Role::Teacher).await;
    teacher.ok("class.get", json!({})).await
}

async fn role_of_a_stranger(bench: &LocalStation) -> Value {
    let mut page = bench.stranger();
    let hello = json!({"client": {"name": "page"}});
    page.call("session.hello", hello).await.unwrap()["role"].clone()
}

#[tokio::test(start_paused = true)]
async fn ended_class_stays_ended_after_restart() {
    let bench = after("class.toml", |_| String::new()).await;
    assert_eq!(class(&bench).await["class"], Value::Null);
    assert_eq!(role_of_a_stranger(&bench).await, "teacher");
}

#[tokio::test(start_paused = true)]
async fn unreadable_class_grants_no_teacher_role() {
    let bench = after("class.toml", |text| text.replace("[class]", "[class")).await;
    assert_eq!(role_of_a_stranger(&bench).await, "viewer");
    let shown = class(&bench).await;
    assert_eq!(shown["pupils"], json!([]), "{shown}");
    assert!(shown["pin"].is_string());
}

#[tokio::test(start_paused = true)]
async fn unreadable_results_are_moved_aside() {
    let bench = after("results.json", |_| "[{".to_owned()).await;
    let mut teacher = bench.join_as("Ms Lee", Role::Teacher).await;
    let shown = teacher.ok("class.results", json!({})).await;
    assert_eq!(shown["results"], json!([]));
    bench.station.flush().await;
    let files = bench.kept.files.lock().unwrap().clone();
    assert_eq!(files["results-damaged.json"], "[{");
}

#[tokio::test(start_paused = true)]
async fn unreadable_schedule_reserves_arms_for_teachers() {
    let bench = after("schedule.toml", |_| "[[slot".to_owned()).await;
    let shown = class(&bench).await;
    let code = shown["pupils"][0]["code"].clone();
    let hello = json!({"client": {"name": "page"}, "pupil": {"name": "Ada", "code": code}});
    let mut ada = bench.stranger();
    ada.call("session.hello", hello).await.unwrap();
    let says = |text: &Value, part: &str| text.as_str().is_some_and(|text| text.contains(part));
    for method in ["turn.join", "lease.acquire"] {
        let refused = ada.call(method, json!({})).await.unwrap_err();
        let why = &refused["message"];
        assert!(says(why, "cannot be read"), "{method}: {refused}");
        assert!(says(why, "schedule.set"), "{method}: {refused}");
    }
    let mut teacher = bench.join_as("Ms Lee", Role::Teacher).await;
    let shown = teacher.ok("schedule.get", json!({})).await;
    assert!(says(&shown["error"], "schedule.set"), "{shown}");
    let lease = teacher.ok("lease.acquire", json!({})).await["lease"].clone();
    teacher.ok("lease.release", json!({"lease": lease})).await;
    ada.ok("arm.stop", json!({})).await;
    assert_eq!(
        bench.kept.files.lock().unwrap()["schedule.toml"],
        "[[slot",
        "the file stays for its owner to look at"
    );
    let set = teacher.ok("schedule.set", json!({"text": ""})).await;
    assert_eq!(set["error"], Value::Null);
    ada.ok("turn.join", json!({})).await;
    ada.ok("lease.acquire", json!({})).await;
}
