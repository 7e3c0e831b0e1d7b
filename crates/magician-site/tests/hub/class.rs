//! A class on a site: the hub distributes it to all stations and names missing stations. Pupils
//! sign in at the stations.

use std::time::Duration;

use magician::admission::Origin;
use magician_site::StationId;
use magician_station::http::ApiServer;
use magician_station::{Client, Outgoing, Peer};
use serde_json::{Value, json};

use crate::bench::TestHub;

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

/// Starts stations with one arm each. Those with the given numbers have the class.
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

/// Pupil at the page of a station.
struct Pupil {
    client: Client,
    next: u64,
}

impl Pupil {
    async fn signs_in(
        bench: &TestHub,
        station: u64,
        name: &str,
        code: &str,
    ) -> Result<Self, Value> {
        let running = bench.site.station(station).running.clone();
        let tablet = Peer::elsewhere(None, "tablet".to_owned()).unwrap();
        let client = running.connect(tablet);
        let mut pupil = Self { client, next: 0 };
        let hello = json!({"client": {"name": "page"}, "pupil": {"name": name, "code": code}});
        let hello = pupil.call("session.hello", hello).await?;
        assert_eq!(hello["role"], "student");
        Ok(pupil)
    }

    async fn call(&mut self, method: &str, params: Value) -> Result<Value, Value> {
        self.next += 1;
        let text = json!({"jsonrpc": "2.0", "id": self.next, "method": method, "params": params});
        self.client.send(&text.to_string());
        loop {
            let Outgoing::Text(text) = self.client.receive().await else {
                return Err(Value::Null);
            };
            let mut answer: Value = serde_json::from_str(&text).unwrap();
            if answer["id"] == self.next {
                let error = answer["error"].take();
                return error
                    .is_null()
                    .then(|| answer["result"].take())
                    .ok_or(error);
            }
        }
    }
}

#[tokio::test(start_paused = true)]
async fn pupils_turns_and_new_codes_are_refused_with_the_machine_that_has_the_arm() {
    let bench = class(2, &[1, 2]).await;
    bench.site.report(2, "arm1").await;
    let mut lee = bench.join("Ms Lee").await;
    for (method, params) in [
        ("turn.list", json!({})),
        ("turn.join", json!({"arm": "arm1"})),
        ("turn.leave", json!({})),
        ("turn.end", json!({})),
        ("turn.next", json!({"arm": "arm1"})),
        ("class.codes", json!({})),
    ] {
        let error = lee.fails(method, params).await;
        assert_eq!(error["data"]["kind"], "unsupported", "{error}");
        let why = error["message"].as_str().unwrap();
        assert!(
            why.starts_with(method) && why.ends_with("that has the arm: test"),
            "{why}"
        );
    }
    // The machine of this arm is unknown, so the error cannot name it.
    let error = lee.fails("turn.end", json!({"arm": "arm0"})).await;
    assert!(
        error["message"]
            .as_str()
            .unwrap()
            .ends_with("that has the arm")
    );
    let mut page = bench.socket();
    let hello = json!({"client": {"name": "page"}, "pupil": {"name": "Ada", "code": "7K3M"}});
    let error = page.fails("session.hello", hello).await;
    assert_eq!(error["data"]["param"], "pupil");
    let why = "pupils sign in at the page of the computer that has the arm: test";
    assert_eq!(error["message"], why);
    assert_eq!(error["data"]["machines"], json!(["test"]));
    page.run_for(Duration::from_millis(50)).await;
    assert_eq!(page.closed.map(|code| code.0), Some(4401));
}

#[tokio::test(start_paused = true)]
async fn freeze_reaches_all_stations_and_names_silent_ones() {
    let bench = class(3, &[1, 2, 3]).await;
    let mut lee = bench.join("Ms Lee").await;
    let mut ada = Pupil::signs_in(&bench, 3, "Ada", "7K3M").await.unwrap();
    ada.call("turn.join", json!({"arm": "arm2"})).await.unwrap();
    let frozen = lee.ok("class.freeze", json!({})).await;
    assert_eq!(frozen["arms"], json!(["arm0", "arm1", "arm2"]));
    let to = json!({"arm": "arm2", "to": [220, 20, 20, 0]});
    assert_eq!(ada.call("arm.move", to).await.unwrap_err()["code"], -32008);
    lee.ok("class.free", json!({"arms": ["arm0"]})).await;
    assert_eq!(frozen_arms(&bench).await, [false, true, true]);
    let mut late = bench.join("Mr Poe").await;
    late.ok("arm.list", json!({})).await;
    for page in [&mut lee, &mut late] {
        page.run_for(Duration::from_millis(50)).await;
        let list = page.ok("arm.list", json!({})).await;
        let frozen: Vec<_> = { list["arms"].as_array().unwrap().iter() }
            .map(|row| row["frozen"] == true)
            .collect();
        assert_eq!(frozen, [false, true, true], "{list}");
    }
    bench.site.silence(2);
    bench.site.end_lines(magician_site::StationId(2));
    let error = lee.fails("class.freeze", json!({})).await;
    let why = error["message"].as_str().unwrap();
    assert!(why.contains("arm1") && !why.contains("arm0"), "{why}");
    assert_eq!(error["data"]["arms"], json!(["arm0", "arm2"]));
}

/// For each of three stations, true if its arm is frozen.
async fn frozen_arms(bench: &TestHub) -> Vec<bool> {
    let turns = bench.ask_all(&[1, 2, 3], "turn.list").await;
    turns
        .iter()
        .map(|turns| turns["arms"][0]["frozen"] == true)
        .collect()
}

fn code_of<'a>(class: &'a Value, name: &str) -> &'a str {
    let mut pupils = class["pupils"].as_array().unwrap().iter();
    let pupil = pupils.find(|pupil| pupil["name"] == name);
    pupil.unwrap()["code"].as_str().unwrap()
}

/// Classes of these stations.
async fn classes(bench: &TestHub, of: &[u64]) -> Vec<Value> {
    bench.ask_all(of, "class.get").await
}

/// A user at the hub's computer, without a name.
fn at_the_hub() -> Peer {
    let mut peer = Peer::elsewhere(None, "127.0.0.1:1".to_owned()).unwrap();
    peer.origin = Origin::Loopback;
    peer
}

#[tokio::test(start_paused = true)]
async fn users_at_the_hub_are_viewers_during_a_class_until_they_enter_the_pin() {
    let bench = class_of(TestHub::with_token(2, 1).await, &[2]).await;
    tokio::time::sleep(Duration::from_secs(3)).await;
    let mut page = bench.socket_of(at_the_hub());
    let hello = json!({"client": {"name": "page"}});
    let shown = page.call("session.hello", hello).await.unwrap();
    assert_eq!(shown["role"], "viewer");
    page.run_for(Duration::from_millis(50)).await;
    let shown = page.ok("class.get", json!({})).await;
    assert_eq!(shown["pin"], Value::Null, "{shown}");
    assert_eq!(shown["pupils"][0]["code"], Value::Null);
    for (method, params) in [
        ("class.freeze", json!({})),
        ("class.codes", json!({})),
        ("turn.end", json!({})),
        ("class.set", json!({"text": ""})),
        ("schedule.set", json!({"text": ""})),
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
    // One station already has codes: they are kept.
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
    let code = code_of(&set, "Dan");
    for station in [1, 2, 3] {
        let dan = Pupil::signs_in(&bench, station, "Dan", code).await;
        assert!(dan.is_ok(), "at station {station}");
    }
    // An old file does not bring old codes back; the reply names the pupils concerned.
    let old = set["text"].as_str().unwrap().replace("7K3M", "OLD1");
    let kept = lee.ok("class.set", json!({"text": old})).await;
    assert_eq!(code_of(&kept, "Ada"), "7K3M");
    assert_eq!(kept["codes_kept"], json!(["Ada"]));
    // Empty text ends the class.
    lee.ok("class.set", json!({"text": ""})).await;
    let all = classes(&bench, &[1, 2, 3]).await;
    assert!(all.iter().all(|class| class["class"].is_null()));
}

#[tokio::test(start_paused = true)]
async fn class_or_schedule_with_an_unknown_arm_reaches_no_station() {
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
    // Every station accepts the whole file, because the site has all of its arms.
    let text = "[[slot]]\narms = [\"arm0\", \"arm1\"]\nwho = [\"Ada\"]\nfrom = 2026-11-25T12:00:00Z\nuntil = 2026-11-25T13:00:00Z";
    let set = lee.ok("schedule.set", json!({ "text": text })).await;
    assert_eq!(set["text"], text);
    // On its own, a station refuses arms of another one.
    let request =
        json!({"jsonrpc": "2.0", "id": 1, "method": "schedule.set", "params": {"text": text}});
    let running = bench.site.station(1).running.clone();
    let answer = running
        .call(crate::bench::peer(), &request.to_string())
        .await;
    assert!(answer.unwrap().contains("arm1"));
}

#[tokio::test(start_paused = true)]
async fn station_that_refused_the_class_is_named() {
    let bench = class(3, &[1, 2, 3]).await;
    let mut lee = bench.join("Ms Lee").await;
    bench.site.silence(2);
    bench.site.end_lines(magician_site::StationId(2));
    for (method, params) in [
        ("class.set", json!({ "text": CLASS })),
        ("schedule.set", json!({"text": ""})),
    ] {
        let error = lee.fails(method, params).await;
        let why = error["message"].as_str().unwrap();
        assert!(why.starts_with(method), "{why}");
        assert!(why.contains("arm1") && !why.contains("arm0"), "{why}");
    }
    let after = classes(&bench, &[1, 3]).await;
    assert_eq!(code_of(&after[0], "Ben"), "9QWE");
    assert_eq!(after[0], after[1]);
}

#[tokio::test(start_paused = true)]
async fn expected_arm_is_reported_missing_until_it_appears() {
    let bench = class(2, &[1, 2]).await;
    { bench.site.roster.lock().unwrap() }.expect("arm9".to_owned(), "bench-9");
    bench.hub.read_roster().await;
    let mut teacher = bench.join("Ms Lee").await;
    // Expected arms are listed for longer than departed ones.
    for wait in [0, 700] {
        teacher.run_for(Duration::from_secs(wait)).await;
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
    teacher.run_for(Duration::from_secs(1)).await;
    teacher.ok("class.freeze", json!({})).await;
    teacher.ok("arm.stop", json!({})).await;
    // And after its departure it is missing again, however long ago that was.
    bench.site.cut(9);
    teacher.run_for(Duration::from_secs(700)).await;
    let frozen = teacher.fails("class.freeze", json!({})).await;
    assert_eq!(frozen["data"]["missing"], json!(["arm9"]), "{frozen}");
}

#[tokio::test(start_paused = true)]
async fn stations_with_another_class_or_no_answer_are_named_with_the_majority_class() {
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
    bench.site.report(1, "arm0").await;
    bench.site.start(StationId(5), &["arm4".to_owned()]).await;
    teacher.run_for(Duration::from_secs(1)).await;
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
async fn unresponsive_station_is_missing_in_class_schedule_and_results() {
    let bench = class(3, &[1, 2, 3]).await;
    let mut teacher = bench.join("Ms Lee").await;
    bench.site.silence(2);
    // Silent at first; later its line waits to be opened again.
    for wait in [0, 7] {
        teacher.run_for(Duration::from_secs(wait)).await;
        for method in ["class.get", "schedule.get", "class.results"] {
            let shown = teacher.ok(method, json!({})).await;
            assert_eq!(shown["missing"], json!(["arm1"]), "{method}: {shown}");
        }
        let one = json!({"arms": ["arm0"]});
        assert_eq!(teacher.ok("class.freeze", one.clone()).await, one);
    }
}

#[tokio::test(start_paused = true)]
async fn class_at_the_hub_omits_turns_of_single_stations() {
    let bench = class(2, &[1, 2]).await;
    let mut ada = Pupil::signs_in(&bench, 2, "Ada", "7K3M").await.unwrap();
    ada.call("turn.join", json!({})).await.unwrap();
    let mut teacher = bench.join("Ms Lee").await;
    let set = teacher.ok("class.set", json!({"text": CLASS})).await;
    for class in [set, teacher.ok("class.get", json!({})).await] {
        let ada = json!({"name": "Ada", "group": null, "code": "7K3M", "here": null, "place": null, "arm": null});
        assert_eq!(class["pupils"][0], ada);
    }
}

#[tokio::test(start_paused = true)]
async fn class_accepted_by_all_stations_expects_the_present_arms() {
    let bench = class(2, &[]).await;
    let mut teacher = bench.join("Ms Lee").await;
    teacher.ok("class.set", json!({"text": CLASS})).await;
    let roster = teacher.ok("site.roster", json!({})).await;
    let names: Vec<_> = { roster["arms"].as_array().unwrap().iter() }
        .map(|one| one["arm"].clone())
        .collect();
    assert_eq!(names, ["arm0", "arm1"]);
    bench.site.cut(2);
    teacher.run_for(Duration::from_secs(700)).await;
    let frozen = teacher.fails("class.freeze", json!({})).await;
    assert_eq!(frozen["data"]["missing"], json!(["arm1"]), "{frozen}");
    teacher.fails("class.set", json!({"text": CLASS})).await;
}

#[tokio::test(start_paused = true)]
async fn post_at_the_hub_without_the_pin_reads_no_code() {
    let bench = class_of(TestHub::with_token(2, 1).await, &[1, 2]).await;
    tokio::time::sleep(Duration::from_secs(3)).await;
    let request = r#"{"jsonrpc": "2.0", "id": 1, "method": "class.get"}"#;
    let answer = ApiServer::call(&bench.hub, at_the_hub(), None, request).await;
    let answer: Value = serde_json::from_str(&answer.unwrap()).unwrap();
    let class = &answer["result"];
    assert_eq!(class["class"]["turn_s"], 120, "{answer}");
    assert_eq!(class["pin"], Value::Null, "{answer}");
    assert_eq!(class["text"], Value::Null, "{answer}");
    assert!(!answer.to_string().contains("7K3M"), "{answer}");
}

#[tokio::test(start_paused = true)]
async fn roster_is_written_to_all_stations_and_read_from_any() {
    let bench = class(2, &[]).await;
    let mut teacher = bench.join("Ms Lee").await;
    assert_eq!(
        teacher.ok("site.roster", json!({})).await,
        json!({"arms": []})
    );
    let arms = json!({"arms": [{"arm": "arm0", "machine": "m"}, {"arm": "gone", "machine": ""}]});
    assert_eq!(teacher.ok("site.expect", arms.clone()).await, arms);
    let mut read = arms.clone();
    read["missing"] = json!(["gone"]);
    assert_eq!(teacher.ok("site.roster", json!({})).await, read);
    let refused = teacher.call("class.freeze", json!({})).await.unwrap_err();
    assert_eq!(refused["data"]["missing"], json!(["gone"]), "{refused}");
    // An arm that is no longer expected does not block the change.
    let arms = json!({"arms": [{"arm": "arm0", "machine": "m"}]});
    assert_eq!(teacher.ok("site.expect", arms.clone()).await, arms);
    teacher.ok("class.freeze", json!({})).await;
}
