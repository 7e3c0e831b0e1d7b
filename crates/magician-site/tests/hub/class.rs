//! A class on a site: pupils sign in once, and have one turn or one place wherever it is.

use std::time::Duration;

use magician_station::Peer;
use serde_json::{Value, json};

use crate::bench::{Bench, Tester};

const CLASS: &str = r#"
[class]
turn_s = 120
grace_s = 20
[[pupil]]
name = "Ada"
code = "7K3M"
[[pupil]]
name = "Ben"
code = "9QWE"
[[pupil]]
name = "Cy"
code = "C4C4"
"#;

/// Stations with one arm each; those of these numbers have the class.
async fn class(stations: usize, with: &[u64]) -> Bench {
    let bench = Bench::new(stations, 1).await;
    for id in with {
        let client = bench
            .site
            .station(*id)
            .running
            .connect(crate::bench::peer());
        for (id, method, params) in [
            (1, "session.hello", json!({"client": {"name": "Ms Lee"}})),
            (2, "class.set", json!({"text": CLASS})),
        ] {
            let text = json!({"jsonrpc": "2.0", "id": id, "method": method, "params": params});
            client.send(&text.to_string());
        }
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    bench
}

async fn signs_in(tester: &mut Tester, name: &str, code: &str) -> Result<Value, Value> {
    let hello = json!({"client": {"name": "page"}, "pupil": {"name": name, "code": code}});
    tester.call("session.hello", hello).await
}

async fn pupil(bench: &Bench, name: &str) -> Tester {
    let code = match name {
        "Ada" => "7K3M",
        "Ben" => "9QWE",
        _ => "C4C4",
    };
    let mut tester = bench.socket_of(Peer::elsewhere(None, "tablet".to_owned()).unwrap());
    signs_in(&mut tester, name, code).await.unwrap();
    tester.live(Duration::from_millis(50)).await;
    tester
}

/// The arm at which somebody has a turn, and the places that they have.
async fn has(tester: &mut Tester, name: &str) -> (Vec<String>, Vec<Value>) {
    let turns = tester.ok("turn.list", json!({})).await;
    let of = |list: &str| -> Vec<Value> {
        let all = turns[list].as_array().unwrap().iter();
        all.filter(|one| one["person"] == name).cloned().collect()
    };
    let arm = |one: Value| one["arm"].as_str().unwrap().to_owned();
    (of("arms").into_iter().map(arm).collect(), of("queue"))
}

#[tokio::test(start_paused = true)]
async fn a_pupil_signs_in_at_all_stations_as_a_student() {
    let bench = class(3, &[1, 2, 3]).await;
    // At the hub's machine a pupil is no teacher.
    let mut ada = bench.socket();
    let hello = signs_in(&mut ada, "Ada", "7k3m").await.unwrap();
    assert_eq!(hello["role"], "student");
    assert_eq!(ada.fails("class.results", json!({})).await["code"], -32001);
    ada.ok("turn.join", json!({"arm": "arm1"})).await;
    ada.live(Duration::from_millis(50)).await;
    assert_eq!(ada.noticed("turn.granted")[0]["arm"], "arm1");
    assert_eq!(ada.row("arm1").await["holder"]["session"], hello["session"]);
    ada.ok("arm.move", json!({"arm": "arm1", "to": [220, 20, 20, 0]}))
        .await;
    // Stops have no need of a turn.
    ada.ok("arm.stop", json!({})).await;
}

#[tokio::test(start_paused = true)]
async fn a_code_that_all_refuse_is_refused_and_slowed_down() {
    let bench = class(3, &[1, 2, 3]).await;
    for code in [-32001, -32001, -32001, -32001, -32001, -32004] {
        let mut ben = bench.socket();
        let error = signs_in(&mut ben, "Ben", "0000").await.unwrap_err();
        let _ = code;
        assert!(!error["message"].as_str().unwrap().is_empty());
        ben.live(Duration::from_millis(50)).await;
        assert_eq!(ben.closed.map(|code| code.0), Some(4401));
    }
    let mut ben = bench.socket();
    let error = signs_in(&mut ben, "Ben", "9QWE").await.unwrap_err();
    assert!(
        error["message"]
            .as_str()
            .unwrap()
            .contains("too many wrong codes"),
        "{error}"
    );
}

#[tokio::test(start_paused = true)]
async fn a_station_without_the_pupil_is_closed_and_the_others_work() {
    let bench = class(3, &[1, 3]).await;
    let mut ada = pupil(&bench, "Ada").await;
    ada.ok("turn.join", json!({"arm": "arm2"})).await;
    let error = ada.fails("lease.acquire", json!({"arm": "arm1"})).await;
    assert_eq!(error["code"], -32001);
    let opened = bench.site.opened();
    ada.live(Duration::from_secs(30)).await;
    assert_eq!(bench.site.opened(), opened, "it is not asked again");
    assert!(ada.closed.is_none());
}

#[tokio::test(start_paused = true)]
async fn a_person_has_one_turn_or_one_place_on_the_site() {
    let bench = class(3, &[1, 2, 3]).await;
    let mut pupils = Vec::new();
    for name in ["Ada", "Ben", "Cy"] {
        let mut one = pupil(&bench, name).await;
        one.ok("turn.join", json!({})).await;
        pupils.push(one);
    }
    let mut arms = Vec::new();
    for name in ["Ada", "Ben", "Cy"] {
        let (turns, places) = has(&mut pupils[0], name).await;
        assert_eq!((turns.len(), places.len()), (1, 0), "{name}");
        arms.extend(turns);
    }
    arms.sort();
    assert_eq!(arms, ["arm0", "arm1", "arm2"]);
    // Another page of hers, which knows nothing of the first.
    let mut again = pupil(&bench, "Ada").await;
    for arm in ["arm0", "arm1", "arm2"] {
        again.ok("turn.join", json!({"arm": arm})).await;
    }
    let (turns, places) = has(&mut again, "Ada").await;
    assert_eq!((turns.len(), places.len()), (1, 0));
    pupils[1].live(Duration::from_millis(50)).await;
    assert!(!pupils[1].noticed("turn.changed").is_empty());
    // Whoever waits at one and joins at another has left the first.
    again.ok("turn.leave", json!({})).await;
    for arm in { arms.iter() }.filter(|arm| **arm != turns[0]) {
        let turns = again.ok("turn.join", json!({"arm": arm})).await;
        let places: Vec<_> = { turns["queue"].as_array().unwrap().iter() }
            .filter(|place| place["person"] == "Ada")
            .collect();
        assert_eq!(places.len(), 1, "{turns}");
        assert_eq!(places[0]["arms"], json!([arm]));
    }
}

#[tokio::test(start_paused = true)]
async fn a_change_at_one_station_tells_the_turns_of_all() {
    let bench = class(3, &[1, 2, 3]).await;
    let mut ada = pupil(&bench, "Ada").await;
    let mut ben = pupil(&bench, "Ben").await;
    ben.ok("turn.list", json!({})).await;
    ada.ok("turn.join", json!({"arm": "arm2"})).await;
    ben.live(Duration::from_secs(1)).await;
    let turns = ben.noticed("turn.changed").pop().unwrap().clone();
    let arms: Vec<_> = { turns["arms"].as_array().unwrap().iter() }
        .map(|arm| (arm["arm"].clone(), arm["person"].clone()))
        .collect();
    let expected = [
        (json!("arm0"), Value::Null),
        (json!("arm1"), Value::Null),
        (json!("arm2"), json!("Ada")),
    ];
    assert_eq!(arms, expected);
    assert_eq!(turns["turn_s"], 120);
}

#[tokio::test(start_paused = true)]
async fn a_freeze_reaches_all_and_names_who_does_not_answer() {
    let bench = class(3, &[1, 2, 3]).await;
    let mut lee = bench.join("Ms Lee").await;
    let mut ada = pupil(&bench, "Ada").await;
    ada.ok("turn.join", json!({"arm": "arm2"})).await;
    ada.live(Duration::from_millis(50)).await;
    let frozen = lee.ok("class.freeze", json!({})).await;
    assert_eq!(frozen["arms"], json!(["arm0", "arm1", "arm2"]));
    let to = json!({"arm": "arm2", "to": [220, 20, 20, 0]});
    assert_eq!(ada.fails("arm.move", to).await["code"], -32008);
    lee.ok("class.free", json!({"arms": ["arm0"]})).await;
    let turns = lee.ok("turn.list", json!({})).await;
    let frozen: Vec<_> = { turns["arms"].as_array().unwrap().iter() }
        .map(|arm| arm["frozen"] == true)
        .collect();
    assert_eq!(frozen, [false, true, true]);
    bench.site.silence(2);
    bench.site.end_lines(magician_site::StationId(2));
    let error = lee.fails("class.freeze", json!({})).await;
    let why = error["message"].as_str().unwrap();
    assert!(why.contains("arm1") && !why.contains("arm0"), "{why}");
    assert_eq!(error["data"]["arms"], json!(["arm0", "arm2"]));
}
