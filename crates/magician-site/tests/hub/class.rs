//! A class on a site: pupils sign in once, and have one turn or one place wherever it is.

use std::time::Duration;

use magician::admission::Origin;
use magician_site::StationId;
use magician_site::message::EXPECT;
use magician_station::Peer;
use serde_json::{Value, json};

use crate::bench::{TestHub, Tester};

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
async fn class(stations: usize, with: &[u64]) -> TestHub {
    class_of(TestHub::new(stations, 1).await, with).await
}

async fn class_of(bench: TestHub, with: &[u64]) -> TestHub {
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

async fn pupil(bench: &TestHub, name: &str) -> Tester {
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
    let error = ada.fails("lease.acquire", json!({"arm": "arm1"})).await;
    assert_eq!(error["code"], -32001);
    ada.ok("turn.join", json!({"arm": "arm2"})).await;
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

fn code_of<'a>(class: &'a Value, name: &str) -> &'a str {
    let mut pupils = class["pupils"].as_array().unwrap().iter();
    let pupil = pupils.find(|pupil| pupil["name"] == name);
    pupil.unwrap()["code"].as_str().unwrap()
}

/// The classes of the stations of these numbers.
async fn classes(bench: &TestHub, of: &[u64]) -> Vec<Value> {
    let mut out = Vec::new();
    let request = r#"{"jsonrpc": "2.0", "id": 1, "method": "class.get"}"#;
    for id in of {
        let running = bench.site.station(*id).running.clone();
        let answer = running.call(crate::bench::peer(), request).await;
        let answer: Value = serde_json::from_str(&answer.unwrap()).unwrap();
        out.push(answer["result"].clone());
    }
    out
}

/// Whoever sits at the hub's computer, without a name.
fn at_the_hub() -> Peer {
    let mut peer = Peer::elsewhere(None, "127.0.0.1:1".to_owned()).unwrap();
    peer.origin = Origin::Loopback;
    peer
}

#[tokio::test(start_paused = true)]
async fn while_a_station_has_a_class_the_hubs_computer_looks_on_until_it_has_the_pin() {
    let bench = class_of(TestHub::with_token(2, 1).await, &[2]).await;
    tokio::time::sleep(Duration::from_secs(3)).await;
    let mut page = bench.socket_of(at_the_hub());
    let hello = json!({"client": {"name": "page"}});
    let shown = page.call("session.hello", hello).await.unwrap();
    assert_eq!(shown["role"], "viewer");
    page.live(Duration::from_millis(50)).await;
    let shown = page.ok("class.get", json!({})).await;
    assert_eq!(shown["pin"], Value::Null, "{shown}");
    assert_eq!(shown["pupils"][0]["code"], Value::Null);
    for (method, params) in [
        ("class.freeze", json!({})),
        ("class.codes", json!({})),
        ("turn.end", json!({})),
        ("lease.take", json!({"arm": "arm0"})),
        ("arm.move", json!({"arm": "arm0", "to": [220, 0, 40, 0]})),
    ] {
        let error = page.fails(method, params).await;
        assert!(
            [-32001, -32002].contains(&error["code"].as_i64().unwrap()),
            "{method}: {error}"
        );
    }
    let stopped = page.ok("arm.stop", json!({"arm": "arm0"})).await;
    assert_eq!(stopped["arms"][0]["stood"], json!(true), "{stopped}");
    let known = classes(&bench, &[2]).await;
    let pin = known[0]["pin"].as_str().unwrap();
    let mut teacher = bench.socket_of(at_the_hub());
    let hello = json!({"client": {"name": "page"}, "pin": pin});
    let shown = teacher.call("session.hello", hello).await.unwrap();
    assert_eq!(shown["role"], "teacher");
}

#[tokio::test(start_paused = true)]
async fn one_class_is_given_to_all_stations_with_the_same_codes() {
    // One knows codes already.
    let bench = class(3, &[1]).await;
    let mut lee = bench.join("Ms Lee").await;
    let text = "
[groups]
red = [\"arm0\", \"arm2\"]
blue = [\"arm1\"]
[[pupil]]
name = \"Ada\"
group = \"red\"
[[pupil]]
name = \"Dan\"
group = \"blue\"
";
    let set = lee.ok("class.set", json!({ "text": text })).await;
    assert_eq!(code_of(&set, "Ada"), "7K3M", "she has it already");
    let all = classes(&bench, &[1, 2, 3]).await;
    let texts =
        |all: &[Value]| -> Vec<Value> { all.iter().map(|class| class["text"].clone()).collect() };
    assert_eq!(texts(&all), vec![set["text"].clone(); 3]);
    let mut dan = bench.socket_of(Peer::elsewhere(None, "tablet".to_owned()).unwrap());
    let code = code_of(&set, "Dan").to_owned();
    signs_in(&mut dan, "Dan", &code).await.unwrap();
    dan.live(Duration::from_millis(50)).await;
    dan.ok("turn.join", json!({})).await;
    assert_eq!(has(&mut dan, "Dan").await.0, ["arm1"]);
    // One pupil gets a new code, everywhere, and signs in again.
    let again = lee.ok("class.codes", json!({"pupils": ["Dan"]})).await;
    assert_ne!(code_of(&again, "Dan"), code);
    assert_eq!(code_of(&again, "Ada"), "7K3M");
    let all = classes(&bench, &[1, 2, 3]).await;
    assert_eq!(texts(&all), vec![again["text"].clone(); 3]);
    dan.live(Duration::from_millis(100)).await;
    assert_eq!(dan.closed.map(|code| code.0), Some(4403));
    // An old file brings no old code back, and that is said.
    let old = again["text"].as_str().unwrap().replace("7K3M", "OLD1");
    let kept = lee.ok("class.set", json!({"text": old})).await;
    assert_eq!(code_of(&kept, "Ada"), "7K3M");
    assert_eq!(kept["codes_kept"], json!(["Ada"]));
    // Empty text ends the class.
    lee.ok("class.set", json!({"text": ""})).await;
    let all = classes(&bench, &[1, 2, 3]).await;
    assert!(all.iter().all(|class| class["class"].is_null()));
}

#[tokio::test(start_paused = true)]
async fn a_class_or_schedule_with_an_arm_of_nobody_reaches_no_station() {
    let bench = class(2, &[]).await;
    let mut lee = bench.join("Ms Lee").await;
    for (method, text) in [
        ("class.set", "[groups]\nred = [\"arm0\", \"arm7\"]"),
        (
            "schedule.set",
            "[[slot]]\narms = [\"arm7\"]\nwho = [\"Ada\"]\nfrom = 2026-11-25T12:00:00Z\nuntil = 2026-11-25T13:00:00Z",
        ),
        ("class.set", "[class]\nturns = 5"),
    ] {
        let error = lee.fails(method, json!({ "text": text })).await;
        assert_eq!(error["data"]["param"], "text", "{error}");
    }
    assert!(classes(&bench, &[1, 2]).await[0]["class"].is_null());
    // The same file of arms that are there is every station's.
    let text = "[[slot]]\narms = [\"arm0\", \"arm1\"]\nwho = [\"Ada\"]\nfrom = 2026-11-25T12:00:00Z\nuntil = 2026-11-25T13:00:00Z";
    let set = lee.ok("schedule.set", json!({ "text": text })).await;
    assert_eq!(set["text"], text);
    // A station by itself refuses what is of another one.
    let request =
        json!({"jsonrpc": "2.0", "id": 1, "method": "schedule.set", "params": {"text": text}});
    let running = bench.site.station(1).running.clone();
    let answer = running
        .call(crate::bench::peer(), &request.to_string())
        .await;
    assert!(answer.unwrap().contains("arm1"));
}

#[tokio::test(start_paused = true)]
async fn a_station_that_has_not_taken_the_class_is_named() {
    let bench = class(3, &[1, 2, 3]).await;
    let mut lee = bench.join("Ms Lee").await;
    bench.site.silence(2);
    bench.site.end_lines(magician_site::StationId(2));
    for (method, params) in [
        ("class.set", json!({ "text": CLASS })),
        ("class.codes", json!({"pupils": ["Ben"]})),
        ("schedule.set", json!({"text": ""})),
    ] {
        let error = lee.fails(method, params).await;
        let why = error["message"].as_str().unwrap();
        assert!(why.starts_with(method), "{why}");
        assert!(why.contains("arm1") && !why.contains("arm0"), "{why}");
    }
    let after = classes(&bench, &[1, 3]).await;
    assert_ne!(code_of(&after[0], "Ben"), "9QWE");
    assert_eq!(after[0], after[1]);
}

#[tokio::test(start_paused = true)]
async fn codes_of_stations_with_different_classes_are_left_alone() {
    let bench = class(2, &[1, 2]).await;
    let request =
        json!({"jsonrpc": "2.0", "id": 1, "method": "class.codes", "params": {"pupils": ["Cy"]}});
    let running = bench.site.station(2).running.clone();
    let peer = crate::bench::peer();
    running.call(peer, &request.to_string()).await.unwrap();
    let before = classes(&bench, &[1, 2]).await;
    let mut lee = bench.join("Ms Lee").await;
    let error = lee.fails("class.codes", json!({"pupils": ["Ada"]})).await;
    let why = error["message"].as_str().unwrap();
    assert!(why.contains("different classes"), "{why}");
    assert_eq!(classes(&bench, &[1, 2]).await, before);
    // The file of all of them makes it one.
    lee.ok("class.set", json!({"text": before[0]["text"]}))
        .await;
    lee.ok("class.codes", json!({"pupils": ["Ada"]})).await;
}

#[tokio::test(start_paused = true)]
async fn a_pupil_gives_nobody_a_class() {
    let bench = class(2, &[1, 2]).await;
    let mut ada = pupil(&bench, "Ada").await;
    for (method, params) in [
        ("class.set", json!({"text": ""})),
        ("class.codes", json!({})),
        ("schedule.set", json!({"text": ""})),
    ] {
        assert_eq!(ada.fails(method, params).await["code"], -32001, "{method}");
    }
    let shown = ada.ok("class.get", json!({})).await;
    assert!(shown["text"].is_null());
}

#[tokio::test(start_paused = true)]
async fn an_arm_that_is_taken_without_the_queue_is_a_turn_on_the_site_too() {
    let bench = class(3, &[1, 2, 3]).await;
    let mut ada = pupil(&bench, "Ada").await;
    let mut ben = pupil(&bench, "Ben").await;
    ben.ok("turn.join", json!({"arm": "arm1"})).await;
    // She waits at one station, and takes a free arm of another one.
    ada.ok("turn.join", json!({"arm": "arm1"})).await;
    assert_eq!(has(&mut ada, "Ada").await.1.len(), 1);
    ada.ok("lease.acquire", json!({"arm": "arm0"})).await;
    ada.live(Duration::from_millis(50)).await;
    let (turns, places) = has(&mut ada, "Ada").await;
    assert_eq!((turns, places.len()), (vec!["arm0".to_owned()], 0));
    // A second arm is not hers, whichever page asks.
    let mut again = pupil(&bench, "Ada").await;
    let error = again.fails("lease.acquire", json!({"arm": "arm2"})).await;
    assert_eq!(error["code"], -32002, "{error}");
    assert!(error["message"].as_str().unwrap().contains("arm0"));
    assert_eq!(has(&mut ada, "Ada").await.0, ["arm0"]);
    // A teacher is bound by none of this.
    let mut lee = bench.join("Ms Lee").await;
    for arm in ["arm0", "arm2"] {
        lee.ok("lease.take", json!({"arm": arm})).await;
    }
}

#[tokio::test(start_paused = true)]
async fn two_pages_that_ask_in_one_moment_get_one_turn() {
    let bench = class(3, &[1, 2, 3]).await;
    let mut pages = [pupil(&bench, "Ada").await, pupil(&bench, "Ada").await];
    let asks = [
        ("turn.join", "turn.join"),
        ("turn.join", "lease.acquire"),
        ("lease.acquire", "turn.join"),
        ("lease.acquire", "lease.acquire"),
    ];
    for (one, other) in asks {
        let first = pages[0].send(one, json!({"arm": "arm0"}));
        let second = pages[1].send(other, json!({"arm": "arm2"}));
        assert!(pages[0].answer(first).await.is_ok());
        let refused = pages[1].answer(second).await.unwrap_err();
        assert_eq!(refused["code"], -32003, "{refused}");
        assert_eq!(has(&mut pages[1], "Ada").await.0, ["arm0"]);
        pages[0].ok("turn.leave", json!({})).await;
        assert!(has(&mut pages[1], "Ada").await.0.is_empty());
    }
}

#[tokio::test(start_paused = true)]
async fn arm_that_is_expected_and_never_came_is_named_until_it_comes() {
    let bench = class(2, &[1, 2]).await;
    { bench.site.roster.lock().unwrap() }.expect("arm9".to_owned(), "bench-9");
    bench.hub.read_roster().await;
    let mut teacher = bench.join("Ms Lee").await;
    // Longer than an arm that was there once is remembered.
    for wait in [0, 700] {
        teacher.live(Duration::from_secs(wait)).await;
        let frozen = teacher.fails("class.freeze", json!({})).await;
        assert_eq!(frozen["data"]["missing"], json!(["arm9"]), "{frozen}");
        assert_eq!(frozen["data"]["arms"], json!(["arm0", "arm1"]), "{frozen}");
        let stopped = teacher.fails("arm.stop", json!({})).await;
        assert_eq!(stopped["data"]["missing"], json!(["arm9"]), "{stopped}");
        assert_eq!(stopped["data"]["arms"].as_array().unwrap().len(), 2);
        let class = teacher.ok("class.get", json!({})).await;
        assert_eq!(class["missing"], json!(["arm9"]), "{class}");
        assert_eq!(class["pupils"].as_array().unwrap().len(), 3);
        assert_eq!(teacher.row("arm9").await["link"], "lost");
    }
    bench.site.start(StationId(9), &["arm9".to_owned()]).await;
    teacher.live(Duration::from_secs(1)).await;
    teacher.ok("class.freeze", json!({})).await;
    teacher.ok("arm.stop", json!({})).await;
    // And named again once it is gone, however long ago.
    bench.site.cut(9);
    teacher.live(Duration::from_secs(700)).await;
    let frozen = teacher.fails("class.freeze", json!({})).await;
    assert_eq!(frozen["data"]["missing"], json!(["arm9"]), "{frozen}");
}

#[tokio::test(start_paused = true)]
async fn stations_with_another_class_or_no_answer_are_named_beside_the_class_of_most() {
    let bench = class(4, &[]).await;
    let same = CLASS.replace("turn_s", "pin = \"123456\"\nturn_s");
    let other = same.replace("120", "130");
    for (id, class) in [(2, &same), (3, &other), (4, &same)] {
        let params = json!({"text": class});
        let text = json!({"jsonrpc": "2.0", "id": 1, "method": "class.set", "params": params});
        let (station, text) = (bench.site.station(id), text.to_string());
        let set = station.running.call(crate::bench::peer(), &text).await;
        assert!(set.unwrap().contains("result"));
    }
    let mut teacher = bench.join("Ms Lee").await;
    bench.site.news(1, "arm0").await;
    bench.site.start(StationId(5), &["arm4".to_owned()]).await;
    teacher.live(Duration::from_secs(1)).await;
    let class = teacher.ok("class.get", json!({})).await;
    assert_eq!(class["class"]["turn_s"], 120, "{class}");
    let differ = json!([
        {"arms": ["arm0"], "machine": "test", "none": true},
        {"arms": ["arm2"], "machine": null, "none": false},
        {"arms": ["arm4"], "machine": null, "none": true},
    ]);
    assert_eq!(class["differ"], differ, "{class}");
    assert!(class.get("missing").is_none(), "{class}");
    let schedule = teacher.ok("schedule.get", json!({})).await;
    assert!(schedule.get("differ").is_none(), "{schedule}");
}

#[tokio::test(start_paused = true)]
async fn class_that_all_stations_have_taken_expects_the_arms_that_are_there() {
    let bench = class(2, &[]).await;
    let mut teacher = bench.join("Ms Lee").await;
    let told = || {
        let calls = bench.site.calls.lock().unwrap();
        calls.iter().filter(|method| *method == EXPECT).count()
    };
    teacher.ok("class.set", json!({"text": CLASS})).await;
    assert_eq!(told(), 2);
    bench.site.cut(2);
    teacher.live(Duration::from_secs(700)).await;
    let frozen = teacher.fails("class.freeze", json!({})).await;
    assert_eq!(frozen["data"]["missing"], json!(["arm1"]), "{frozen}");
    teacher.fails("class.set", json!({"text": CLASS})).await;
    assert_eq!(told(), 2, "a class that is not everywhere changes nothing");
}
