//! Classes: signing in, turns, freezing, the schedule, queued jobs, results.

use std::sync::atomic::Ordering;
use std::time::Duration;

use magician_station::{Grant, LIST_INTERVAL, Role};
use serde_json::{Value, json};

use crate::bench::{LocalStation, Tester};

const CLASS: &str = r#"
[class]
turn_s = 120
grace_s = 20
[[pupil]]
name = "Ada"
group = "red"
code = "7K3M"
[[pupil]]
name = "Ben"
code = "9QWE"
"#;

async fn class(arms: usize) -> (LocalStation, Tester) {
    class_of(LocalStation::new(arms).await).await
}

async fn class_of(bench: LocalStation) -> (LocalStation, Tester) {
    let mut teacher = bench.join_as("Ms Lee", Role::Teacher).await;
    teacher.ok("class.set", json!({"text": CLASS})).await;
    (bench, teacher)
}

/// Signs a pupil in at a page without any rights.
async fn sign_in(bench: &LocalStation, name: &str, code: &str) -> Result<Tester, Value> {
    sign_in_from(bench, "127.0.0.1:1", name, code).await
}

async fn sign_in_from(
    bench: &LocalStation,
    address: &str,
    name: &str,
    code: &str,
) -> Result<Tester, Value> {
    let mut page = bench.socket_of(None, address);
    let hello = json!({"client": {"name": "page"}, "pupil": {"name": name, "code": code}});
    page.call("session.hello", hello).await.map(|_| page)
}

async fn pupil(bench: &LocalStation, name: &str) -> Tester {
    let code = if name == "Ada" { "7K3M" } else { "9QWE" };
    sign_in(bench, name, code).await.unwrap()
}

/// Keeps sessions alive for this time.
async fn pass(seconds: u64, testers: &mut [&mut Tester]) {
    for _ in 0..seconds {
        for tester in testers.iter_mut() {
            tester.client.pong();
            tester.listen(Duration::ZERO).await;
        }
        tokio::time::sleep(Duration::from_secs(1)).await;
    }
    for tester in testers.iter_mut() {
        tester.listen(Duration::from_millis(1)).await;
    }
}

fn plan(moves: usize) -> String {
    let steps: Vec<_> = (0..moves)
        .map(|at| json!({"move": [220, at, 20, 0]}))
        .collect();
    json!({"format": "magician-plan", "version": 1, "title": "strokes", "steps": steps}).to_string()
}

#[tokio::test(start_paused = true)]
async fn pupil_signs_in_and_wrong_codes_are_rate_limited() {
    let (bench, mut teacher) = class(1).await;
    let mut ada = sign_in(&bench, "ada", "7k3m").await.unwrap();
    let sessions = ada.ok("session.list", json!({})).await["sessions"].clone();
    let own = sessions
        .as_array()
        .unwrap()
        .iter()
        .find(|one| one["name"] == "Ada")
        .unwrap();
    assert_eq!(own["role"], "student");
    assert_eq!(
        ada.ok("class.get", json!({})).await["pupils"][0]["code"],
        Value::Null
    );
    for _ in 0..5 {
        let error = sign_in(&bench, "Ben", "0000").await.err().unwrap();
        assert_eq!(error["code"], -32001, "{error}");
    }
    let error = sign_in(&bench, "Ben", "9QWE").await.err().unwrap();
    assert_eq!(error["data"]["kind"], "too-many", "{error}");
    assert!(
        sign_in(&bench, "Ada", "7K3M").await.is_ok(),
        "another name is another count"
    );
    tokio::time::sleep(Duration::from_secs(61)).await;
    assert!(sign_in(&bench, "Ben", "9QWE").await.is_ok());
    // A new code ends sessions that signed in with the old one.
    let codes = teacher.ok("class.codes", json!({"pupils": ["Ada"]})).await;
    let code = codes["pupils"][0]["code"].as_str().unwrap().to_owned();
    assert!(code.len() == 6 && code != "7K3M");
    ada.listen(Duration::from_millis(1)).await;
    assert!(ada.closed.is_some());
    bench.station.flush().await;
    let lines = bench.lines.lock().unwrap();
    let told = lines
        .iter()
        .map(|line| format!("{line:?}"))
        .collect::<String>();
    assert!(!told.contains("7k3m") && !told.contains("9QWE") && told.contains("Ben"));
}

#[tokio::test(start_paused = true)]
async fn wrong_codes_of_unknown_names_do_not_block_pupils() {
    let (bench, _teacher) = class(1).await;
    let mut refused = 0;
    for nobody in 0..60 {
        // Each try is a connection with another port.
        let address = format!("192.168.1.9:{}", 4000 + nobody);
        let name = format!("nobody {nobody}");
        let error = sign_in_from(&bench, &address, &name, "0000")
            .await
            .err()
            .unwrap();
        match error["code"].as_i64().unwrap() {
            -32001 => assert!(nobody < 30, "{error}"),
            code => {
                assert_eq!(
                    (code, &error["data"]["limit"]),
                    (-32006, &json!(30)),
                    "{error}"
                );
                assert!(
                    error["message"]
                        .as_str()
                        .unwrap()
                        .contains("from this address")
                );
                refused += 1;
            }
        }
    }
    assert_eq!(refused, 30);
    // Pupils behind the same address, and from elsewhere, still sign in.
    assert!(
        sign_in_from(&bench, "192.168.1.9:5", "Ada", "7K3M")
            .await
            .is_ok()
    );
    assert!(sign_in(&bench, "Ben", "9QWE").await.is_ok());
    // The limit of the name is checked before that of the address, and reports its own values.
    for _ in 0..5 {
        let guess = sign_in_from(&bench, "192.168.1.9:6", "Ben", "0000").await;
        assert_eq!(guess.err().unwrap()["data"]["limit"], json!(30));
    }
    tokio::time::sleep(Duration::from_secs(20)).await;
    let error = sign_in_from(&bench, "192.168.1.9:7", "Ben", "9QWE")
        .await
        .err()
        .unwrap();
    assert_eq!(error["data"]["limit"], json!(5), "{error}");
    assert_eq!(error["data"]["wait_s"], json!(40.0), "{error}");
    assert!(
        error["message"]
            .as_str()
            .unwrap()
            .ends_with("of this name: wait 40 s")
    );
    tokio::time::sleep(Duration::from_secs(40)).await;
    assert!(
        sign_in_from(&bench, "192.168.1.9:8", "Ben", "9QWE")
            .await
            .is_ok()
    );
}

#[tokio::test(start_paused = true)]
async fn turn_passes_on_time_and_reload_keeps_the_place() {
    let (bench, _teacher) = class(1).await;
    let (mut ada, mut ben) = (pupil(&bench, "Ada").await, pupil(&bench, "Ben").await);
    ada.ok("turn.join", json!({})).await;
    let turns = ben.ok("turn.join", json!({"arm": "arm"})).await;
    assert_eq!(turns["arms"][0]["person"], "Ada");
    assert_eq!(turns["queue"][0]["person"], "Ben");
    let denied = ben.call("lease.acquire", json!({})).await.unwrap_err();
    assert!(
        denied["message"]
            .as_str()
            .unwrap()
            .contains("not your turn"),
        "{denied}"
    );
    ada.listen(Duration::from_millis(1)).await;
    let granted = ada.noticed("turn.granted")[0].clone();
    ada.ok("lease.renew", json!({"lease": granted["lease"]}))
        .await;
    ada.ok("arm.move", json!({"to": [220, 0, 40, 0]})).await;
    // Ben's page is reloaded, by another session.
    drop(ben);
    pass(10, &mut [&mut ada]).await;
    let mut ben = pupil(&bench, "Ben").await;
    let turns = ben.ok("turn.list", json!({})).await;
    assert_eq!(turns["queue"][0]["person"], "Ben");
    pass(115, &mut [&mut ada, &mut ben]).await;
    let told: Vec<_> = ada
        .noticed("turn.ending")
        .iter()
        .map(|told| told["left_s"].as_f64().unwrap())
        .collect();
    assert_eq!(told.len(), 2, "{told:?}");
    assert!(
        told[0] <= 60.0 && told[0] > 55.0 && told[1] <= 10.0 && told[1] > 5.0,
        "{told:?}"
    );
    assert_eq!(ben.noticed("turn.granted").len(), 1);
    assert_eq!(
        ada.code("arm.move", json!({"to": [220, 0, 40, 0]})).await,
        -32002
    );
    ben.ok("arm.move", json!({"to": [220, 10, 40, 0]})).await;
}

#[tokio::test(start_paused = true)]
async fn freeze_pauses_the_job_and_blocks_pupils() {
    let (bench, mut teacher) = class(1).await;
    let mut ada = pupil(&bench, "Ada").await;
    ada.ok("lease.acquire", json!({})).await;
    let job = ada.begin_job().await;
    teacher.ok("class.freeze", json!({})).await;
    pass(5, &mut [&mut ada, &mut teacher]).await;
    assert_eq!(
        ada.ok("job.get", json!({"job": job})).await["state"],
        "paused"
    );
    let error = ada
        .call("arm.move", json!({"to": [220, 0, 40, 0]}))
        .await
        .unwrap_err();
    assert_eq!(error["data"]["kind"], "frozen", "{error}");
    assert_eq!(ada.code("job.resume", json!({"job": job})).await, -32008);
    let left = |turns: Value| turns["arms"][0]["left_s"].as_f64().unwrap();
    let before = left(ada.ok("turn.list", json!({})).await);
    pass(60, &mut [&mut ada, &mut teacher]).await;
    assert_eq!(left(ada.ok("turn.list", json!({})).await), before);
    teacher.ok("class.free", json!({"arms": ["arm"]})).await;
    ada.ok("job.resume", json!({"job": job})).await;
}

#[tokio::test(start_paused = true)]
async fn frozen_arm_is_at_rest_within_2_s() {
    let (bench, mut teacher) = class(1).await;
    let mut ada = pupil(&bench, "Ada").await;
    ada.ok("lease.acquire", json!({})).await;
    ada.ok("arm.speed", json!({"percent": 5})).await;
    let steps = json!([{"move": [220, -100, 20, 0]}, {"move": [220, 100, 20, 0]}]);
    let slow = json!({"format": "magician-plan", "version": 1, "title": "slow", "steps": steps});
    let job = ada.ok("job.start", json!({"text": slow.to_string()})).await["job"].clone();
    pass(6, &mut [&mut ada, &mut teacher]).await;
    teacher.ok("class.freeze", json!({})).await;
    pass(2, &mut [&mut ada, &mut teacher]).await;
    let y = async |ada: &mut Tester| ada.ok("arm.state", json!({})).await["y"].clone();
    let stands = y(&mut ada).await;
    pass(5, &mut [&mut ada, &mut teacher]).await;
    assert_eq!(y(&mut ada).await, stands);
    let ended = ada.ok("job.get", json!({"job": job})).await;
    assert_eq!(ended["state"], "stopped", "{ended}");
    teacher.ok("class.free", json!({})).await;
    ada.ok("job.resume", json!({"job": job})).await;
}

#[tokio::test(start_paused = true)]
async fn freeze_stops_a_burning_job_immediately() {
    let (bench, mut teacher) = class(1).await;
    let mut ada = pupil(&bench, "Ada").await;
    ada.ok("lease.acquire", json!({})).await;
    ada.ok("arm.speed", json!({"percent": 5})).await;
    let svg = "<svg xmlns='http://www.w3.org/2000/svg' width='100mm' height='10mm' viewBox='0 0 100 10'><path \
               d='M0 5H100' stroke='black' fill='none'/></svg>";
    let setup = json!({"tool": "laser", "speed": 5, "surface": -60});
    let start = json!({"text": svg, "format": "svg", "setup": setup, "yes": true});
    let job = ada.ok("job.start", start).await["job"].clone();
    let lit =
        async |ada: &mut Tester| ada.ok("arm.state", json!({})).await["tool"]["laser"].clone();
    for _ in 0..50 {
        if lit(&mut ada).await == json!(true) {
            break;
        }
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    assert_eq!(lit(&mut ada).await, json!(true), "it burns");
    teacher.ok("class.freeze", json!({})).await;
    tokio::time::sleep(Duration::from_millis(300)).await;
    assert_eq!(lit(&mut ada).await, json!(false));
    pass(2, &mut [&mut ada, &mut teacher]).await;
    assert_eq!(
        ada.ok("job.get", json!({"job": job})).await["state"],
        "stopped"
    );
}

#[tokio::test(start_paused = true)]
async fn freeze_survives_a_restart_until_freed() {
    let (bench, mut teacher) = class(1).await;
    teacher.ok("class.freeze", json!({})).await;
    let kept = bench.kept.copy();
    drop((teacher, bench));

    let (bench, mut teacher) = class_of(LocalStation::after(kept).await).await;
    let turns = teacher.ok("turn.list", json!({})).await;
    assert_eq!(turns["arms"][0]["frozen"], json!(true));
    let mut ada = pupil(&bench, "Ada").await;
    ada.ok("lease.acquire", json!({})).await;
    let to = json!({"to": [220, 0, 40, 0]});
    assert_eq!(ada.code("arm.move", to.clone()).await, -32008);
    teacher.ok("class.free", json!({})).await;
    ada.ok("arm.move", to).await;
    let kept = bench.kept.copy();
    drop((ada, teacher, bench));

    let (_bench, mut teacher) = class_of(LocalStation::after(kept).await).await;
    let turns = teacher.ok("turn.list", json!({})).await;
    assert_eq!(turns["arms"][0]["frozen"], json!(false));
}

#[tokio::test(start_paused = true)]
async fn unsaved_freeze_applies_and_is_reported() {
    let (bench, mut teacher) = class(1).await;
    bench
        .kept
        .full
        .store(true, std::sync::atomic::Ordering::SeqCst);
    let error = teacher.call("class.freeze", json!({})).await.unwrap_err();
    assert_eq!(error["data"]["reason"], "unkept", "{error}");
    let turns = teacher.ok("turn.list", json!({})).await;
    assert_eq!(turns["arms"][0]["frozen"], json!(true));
}

#[tokio::test(start_paused = true)]
async fn schedule_follows_the_station_clock() {
    let (bench, mut teacher) = class(1).await;
    // The clock of the test starts at 1970-01-12T13:46:40Z.
    let text = "[[slot]]\narms = [\"arm\"]\nwho = [\"red\"]\nfrom = 1970-01-12T13:00:00Z\nuntil = \"1970-01-12T13:48:00Z\"\n";
    teacher.ok("schedule.set", json!({"text": text})).await;
    let (mut ada, mut ben) = (pupil(&bench, "Ada").await, pupil(&bench, "Ben").await);
    let kept = ben.call("turn.join", json!({})).await.unwrap_err();
    assert_eq!(
        (&kept["data"]["arm"], &kept["data"]["until"]),
        (&json!("arm"), &json!(1_000_080)),
        "no place that never comes: {kept}"
    );
    ada.ok("lease.acquire", json!({})).await;
    pass(85, &mut [&mut ada, &mut ben]).await;
    assert_eq!(
        ada.code("arm.move", json!({"to": [220, 0, 40, 0]})).await,
        -32002
    );
    assert_eq!(ada.code("lease.acquire", json!({})).await, -32002);
    teacher.ok("lease.acquire", json!({})).await;
    let bad = teacher
        .call(
            "schedule.set",
            json!({"text": text.replace("\"arm\"", "\"nose\"")}),
        )
        .await;
    assert!(
        bad.unwrap_err()["message"]
            .as_str()
            .unwrap()
            .contains("nose")
    );
}

#[tokio::test(start_paused = true)]
async fn place_reports_its_slot_start_and_arm_its_persons() {
    let (bench, mut teacher) = class(1).await;
    let slot = |who: &str, from: &str, until: &str| {
        format!(
            "[[slot]]\narms = [\"arm\"]\nwho = [\"{who}\"]\nfrom = 1970-01-12T{from}Z\nuntil = 1970-01-12T{until}Z\n"
        )
    };
    let text = slot("red", "13:00:00", "13:48:00") + &slot("Ben", "13:48:30", "13:50:00");
    teacher.ok("schedule.set", json!({"text": text})).await;
    let mut ben = pupil(&bench, "Ben").await;
    let turns = ben.ok("turn.join", json!({})).await;
    let place = &turns["queue"][0];
    assert_eq!(
        (&place["reason"], &place["from"]),
        (&json!("schedule"), &json!(1_000_110.0))
    );
    let arm = &turns["arms"][0];
    assert_eq!(arm["slot"], json!({"who": ["red"], "until": 1_000_080}));
    pass(90, &mut [&mut ben, &mut teacher]).await;
    let arm = ben.ok("turn.list", json!({})).await["arms"][0].clone();
    assert_eq!(
        (&arm["slot"], &arm["free_at"]),
        (&Value::Null, &json!(1_000_110))
    );
    assert!(
        ben.noticed("turn.changed")
            .iter()
            .any(|told| told["arms"][0]["slot"].is_null())
    );
    pass(30, &mut [&mut ben, &mut teacher]).await;
    assert_eq!(ben.noticed("turn.granted").len(), 1);
}

#[tokio::test(start_paused = true)]
async fn class_from_names_has_arms_and_keeps_codes() {
    let bench = LocalStation::new(2).await;
    let mut teacher = bench.join_as("Ms Lee", Role::Teacher).await;
    let names =
        json!({"names": ["Ada", "Ben"], "arms": ["arm2"], "turn_s": 60, "offset": "+01:00"});
    let made = teacher.ok("class.set", names).await;
    assert_eq!(
        (&made["class"]["turn_s"], &made["class"]["arms"]),
        (&json!(60), &json!(["arm2"]))
    );
    let code = |class: &Value| class["pupils"][0]["code"].as_str().unwrap().to_owned();
    let mut ada = sign_in(&bench, "Ada", &code(&made)).await.unwrap();
    let arm = teacher.ok("turn.list", json!({})).await["arms"][0]["arm"].clone();
    assert_eq!(ada.code("lease.acquire", json!({"arm": arm})).await, -32002);
    let error = ada
        .call("turn.join", json!({"arm": arm}))
        .await
        .unwrap_err();
    assert!(
        error["message"]
            .as_str()
            .unwrap()
            .contains("is for teacher"),
        "{error}"
    );
    let turns = ada.ok("turn.join", json!({})).await;
    assert_eq!(
        turns["arms"][1]["person"], "Ada",
        "any arm is one of the class"
    );
    // A renewed code wins over an older file.
    let old = made["text"].as_str().unwrap().to_owned();
    let renewed = teacher.ok("class.codes", json!({"pupils": ["Ada"]})).await;
    let again = teacher.ok("class.set", json!({"text": old})).await;
    assert_eq!(
        (code(&again), &again["codes_kept"]),
        (code(&renewed), &json!(["Ada"]))
    );
    let meant = json!({"text": old, "use_codes": true});
    let again = teacher.ok("class.set", meant).await;
    assert_eq!(
        (code(&again), &again["codes_kept"]),
        (code(&made), &json!([]))
    );
    // Names alone leave the other rules unchanged.
    let fewer = teacher.ok("class.set", json!({"names": ["Ada"]})).await;
    assert_eq!(
        (code(&fewer), &fewer["class"]["turn_s"]),
        (code(&made), &json!(60))
    );
    for fence in ["floor = nan", "top_speed = inf", "box = { x = [nan, 300] }"] {
        let text = format!("[class]\nfence = {{ {fence} }}\n[[pupil]]\nname = \"Ada\"\n");
        assert_eq!(
            teacher.code("class.set", json!({"text": text})).await,
            -32602,
            "{fence}"
        );
    }
    for wrong in [
        json!({"names": ["teacher"]}),
        json!({}),
        json!({"names": ["Ada"], "text": ""}),
        json!({"names": ["Ada", "ada"]}),
        json!({"names": [" "]}),
        json!({"names": ["Ada"], "offset": "1 h"}),
    ] {
        assert_eq!(
            teacher.code("class.set", wrong.clone()).await,
            -32602,
            "{wrong}"
        );
    }
}

#[tokio::test(start_paused = true)]
async fn teacher_ends_and_passes_turns_and_removes_places() {
    let (bench, mut teacher) = class(1).await;
    let (mut ada, mut ben) = (pupil(&bench, "Ada").await, pupil(&bench, "Ben").await);
    ada.ok("turn.join", json!({})).await;
    assert_eq!(
        teacher.code("turn.next", json!({"arm": "arm"})).await,
        -32602
    );
    ben.ok("turn.join", json!({})).await;
    let class = teacher.ok("class.get", json!({})).await["pupils"].clone();
    let of =
        |at: usize| [&class[at]["here"], &class[at]["place"], &class[at]["arm"]].map(Value::clone);
    assert_eq!(of(0), [json!(true), Value::Null, json!("arm")]);
    assert_eq!(of(1), [json!(true), json!(1), Value::Null]);
    assert_eq!(
        ada.ok("class.get", json!({})).await["pupils"][1]["here"],
        Value::Null
    );
    assert_eq!(ada.code("turn.next", json!({})).await, -32001);
    teacher.ok("turn.next", json!({"arm": "arm"})).await;
    let turns = teacher.ok("turn.list", json!({})).await;
    assert_eq!(
        (&turns["arms"][0]["person"], &turns["queue"][0]["person"]),
        (&json!("Ben"), &json!("Ada"))
    );
    ben.ok("arm.move", json!({"to": [220, 0, 40, 0]})).await;
    assert_eq!(
        ben.code("turn.leave", json!({"person": "Ada"})).await,
        -32001
    );
    teacher.ok("turn.leave", json!({"person": "Ada"})).await;
    let twice = json!({"arms": ["arm", "arm"]});
    assert_eq!(teacher.ok("turn.end", twice).await["arms"], json!(["arm"]));
    let turns = teacher.ok("turn.list", json!({})).await;
    assert_eq!(
        (&turns["arms"][0]["person"], &turns["queue"]),
        (&Value::Null, &json!([]))
    );
    assert_eq!(
        teacher.code("turn.leave", json!({"person": "Eve"})).await,
        -32602
    );
}

#[tokio::test(start_paused = true)]
async fn removed_pupil_loses_waiting_jobs_and_places() {
    let (bench, mut teacher) = class(1).await;
    let (mut ada, mut ben) = (pupil(&bench, "Ada").await, pupil(&bench, "Ben").await);
    ada.ok("turn.join", json!({})).await;
    let queued = json!({"text": plan(2), "queue": true});
    let job = ben.ok("job.start", queued).await["job"].clone();
    teacher.ok("class.set", json!({"names": ["Ada"]})).await;
    let job = teacher.ok("job.get", json!({"job": job})).await;
    assert_eq!(job["state"], "stopped", "{job}");
}

#[tokio::test(start_paused = true)]
async fn pupil_cannot_use_an_arm_of_another_group() {
    let (bench, mut teacher) = class(2).await;
    let arms = teacher.ok("turn.list", json!({})).await["arms"].clone();
    let (own, other) = (
        arms[0]["arm"].as_str().unwrap(),
        arms[1]["arm"].as_str().unwrap(),
    );
    let text = format!("{CLASS}[groups]\nred = [\"{own}\"]\nblue = [\"{other}\"]\n");
    teacher.ok("class.set", json!({"text": text})).await;
    let (mut ada, mut ben) = (pupil(&bench, "Ada").await, pupil(&bench, "Ben").await);
    for (method, params) in [
        ("turn.join", json!({"arm": other})),
        ("turn.join", json!({"group": "blue"})),
        ("lease.acquire", json!({"arm": other})),
        ("lease.acquire", json!({"arm": other, "wait_s": 60})),
        (
            "job.start",
            json!({"arm": other, "text": plan(2), "queue": true}),
        ),
    ] {
        let refused = ada.call(method, params.clone()).await.unwrap_err();
        let why = refused["message"].as_str().unwrap();
        assert!(why.contains("group red"), "{method} {params}: {refused}");
    }
    // Ben has no group and may use both.
    ben.ok("turn.join", json!({"arm": other})).await;
    ada.ok("turn.join", json!({"arm": own})).await;
    let passed = teacher.call("turn.next", json!({"arm": other})).await;
    assert!(passed.is_err(), "there is nobody to follow: {passed:?}");
    let turns = teacher.ok("turn.list", json!({})).await;
    assert_eq!(turns["arms"][1]["person"], "Ben", "{turns}");
    assert_eq!(turns["arms"][0]["person"], "Ada", "{turns}");
    // Moving her to another group ends the turn at the arm that it lacks.
    let text = text.replace(
        &format!("red = [\"{own}\"]"),
        &format!("red = [\"{other}\"]"),
    );
    teacher.ok("class.set", json!({"text": text})).await;
    let turns = teacher.ok("turn.list", json!({})).await;
    assert_eq!(turns["arms"][0]["person"], Value::Null, "{turns}");
}

/// Returns the state of a queued job of Ada's, running without a lease, after a teacher's call.
async fn job_from_queue_after(text: &str, word: (&str, Value)) -> Value {
    let (bench, mut teacher) = class(1).await;
    teacher.ok("class.set", json!({"text": text})).await;
    let mut ada = pupil(&bench, "Ada").await;
    let queued = json!({"text": plan(200), "queue": true});
    let job = ada.ok("job.start", queued).await["job"].clone();
    pass(1, &mut [&mut teacher]).await;
    let runs = teacher.ok("job.get", json!({"job": job})).await;
    assert_eq!(runs["state"], "running", "{runs}");
    teacher.ok(word.0, word.1).await;
    pass(3, &mut [&mut teacher]).await;
    teacher.ok("job.get", json!({"job": job})).await["state"].clone()
}

#[tokio::test(start_paused = true)]
async fn queued_job_ends_with_the_end_of_turns() {
    let finish = CLASS.replace("[class]", "[class]\nfinish_job = true");
    for (method, params) in [
        ("turn.end", json!({})),
        ("turn.end", json!({"arm": "arm"})),
        ("class.set", json!({"names": ["Ben"]})),
        ("class.codes", json!({"pupils": ["Ada"]})),
    ] {
        let word = (method, params.clone());
        let state = job_from_queue_after(CLASS, word.clone()).await;
        assert_eq!(state, "paused", "{method} {params}");
        let state = job_from_queue_after(&finish, word).await;
        assert_eq!(state, "running", "{method} {params}");
    }
    let others = ("class.codes", json!({"pupils": ["Ben"]}));
    assert_eq!(job_from_queue_after(CLASS, others).await, "running");
}

#[tokio::test(start_paused = true)]
async fn token_named_like_a_pupil_shares_the_pupils_turn() {
    let bench = LocalStation::new(2).await;
    let mut teacher = bench.join_as("Ms Lee", Role::Teacher).await;
    // The token exists before the class and its pupil.
    let token = Grant {
        role: Role::Student,
        token: Some("ada".to_owned()),
    };
    let mut desk = bench.socket_of(Some(token), "127.0.0.1:1");
    let hello = json!({"client": {"name": "desk"}});
    desk.call("session.hello", hello).await.unwrap();
    teacher.ok("class.set", json!({"names": ["Ben"]})).await;
    desk.ok("turn.join", json!({})).await;
    let persons = |turns: &Value| {
        let arms = turns["arms"].as_array().unwrap().iter();
        let persons: Vec<_> = arms.map(|arm| arm["person"].clone()).collect();
        persons
    };
    let turns = teacher.ok("turn.list", json!({})).await;
    assert_eq!(persons(&turns), [json!("ada"), Value::Null]);
    teacher.ok("class.set", json!({"text": CLASS})).await;
    let turns = teacher.ok("turn.list", json!({})).await;
    assert_eq!(
        persons(&turns),
        [Value::Null, Value::Null],
        "another person"
    );
    let mut ada = pupil(&bench, "Ada").await;
    ada.ok("turn.join", json!({})).await;
    let turns = desk.ok("turn.join", json!({})).await;
    assert_eq!(persons(&turns), [json!("Ada"), Value::Null], "{turns}");
    assert_eq!(turns["queue"], json!([]));
    let other = turns["arms"][1]["arm"].clone();
    let second = desk.call("lease.acquire", json!({"arm": other})).await;
    assert!(second.is_err(), "{second:?}");
}

#[tokio::test(start_paused = true)]
async fn holder_of_two_arms_gets_one_turn_when_a_class_begins() {
    let bench = LocalStation::new(2).await;
    let token = Grant {
        role: Role::Student,
        token: Some("desk".to_owned()),
    };
    let mut desk = bench.socket_of(Some(token), "127.0.0.1:1");
    let hello = json!({"client": {"name": "desk"}});
    desk.call("session.hello", hello).await.unwrap();
    let mut teacher = bench.join_as("Ms Lee", Role::Teacher).await;
    let arms = teacher.ok("turn.list", json!({})).await["arms"].clone();
    for arm in arms.as_array().unwrap() {
        desk.ok("lease.acquire", json!({"arm": arm["arm"]})).await;
    }
    teacher.ok("class.set", json!({"text": CLASS})).await;
    let turns = teacher.ok("turn.list", json!({})).await["arms"].clone();
    let persons: Vec<_> = turns
        .as_array()
        .unwrap()
        .iter()
        .map(|arm| arm["person"].clone())
        .collect();
    assert_eq!(persons, [json!("desk"), Value::Null]);
}

#[tokio::test(start_paused = true)]
async fn waiting_job_is_listed_with_its_reason() {
    let (bench, mut teacher) = class(1).await;
    let mut ada = pupil(&bench, "Ada").await;
    ada.ok("turn.join", json!({})).await;
    let put = json!({"name": "strokes.json", "text": plan(2)});
    teacher.ok("program.put", put).await;
    teacher
        .ok("class.send", json!({"program": "strokes.json"}))
        .await;
    let waits = |turns: &Value| turns["arms"][0]["jobs"][0].clone();
    let job = waits(&teacher.ok("turn.list", json!({})).await);
    assert_eq!(
        (&job["title"], &job["reason"]),
        (&json!("strokes"), &json!("turn")),
        "{job}"
    );
    teacher.ok("class.freeze", json!({})).await;
    teacher.listen(Duration::from_millis(1)).await;
    let told = teacher.noticed("turn.changed");
    assert_eq!(waits(told.last().unwrap())["reason"], "frozen");
}

#[tokio::test(start_paused = true)]
async fn queued_jobs_start_in_order() {
    let (bench, mut teacher) = class(1).await;
    let (mut ada, mut ben) = (pupil(&bench, "Ada").await, pupil(&bench, "Ben").await);
    ada.ok("lease.acquire", json!({})).await;
    let first = ada.begin_job().await;
    let queue = |text: String| json!({"text": text, "queue": true});
    let second = ben.ok("job.start", queue(plan(2))).await["job"].clone();
    let third = ben.ok("job.start", queue(plan(3))).await["job"].clone();
    let shown = ben.ok("job.get", json!({"job": third})).await;
    assert_eq!(
        (&shown["state"], &shown["place"]),
        (&json!("queued"), &json!(2))
    );
    let fourth = ben.ok("job.start", queue(plan(3))).await["job"].clone();
    assert_eq!(
        ben.ok("job.stop", json!({"job": fourth})).await["state"],
        "stopped"
    );
    bench.station.flush().await;
    let kept = bench.kept.copy();
    pass(60, &mut [&mut ada, &mut ben, &mut teacher]).await;
    assert_eq!(
        ben.ok("job.get", json!({"job": first})).await["state"],
        "done"
    );
    // During Ada's turn no job of Ben's starts.
    assert_eq!(
        ben.ok("job.get", json!({"job": second})).await["state"],
        "queued"
    );
    ada.ok("turn.leave", json!({})).await;
    pass(30, &mut [&mut ada, &mut ben, &mut teacher]).await;
    for job in [&second, &third] {
        assert_eq!(
            ben.ok("job.get", json!({"job": job})).await["state"],
            "done"
        );
    }
    let results = teacher.ok("class.results", json!({})).await["results"].clone();
    let names: Vec<_> = results
        .as_array()
        .unwrap()
        .iter()
        .map(|one| one["pupil"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["Ada", "Ben", "Ben"]);
    // A restart starts no job.
    let after = LocalStation::after(kept).await;
    let mut teacher = after.join_as("Ms Lee", Role::Teacher).await;
    let shown = teacher.ok("job.get", json!({"job": second})).await;
    assert_eq!(
        (&shown["state"], &shown["place"]),
        (&json!("queued"), &json!(1))
    );
    assert_eq!(shown["reason"], json!("restart"));
    pass(60, &mut [&mut teacher]).await;
    for job in [&second, &third] {
        assert_eq!(
            teacher.ok("job.get", json!({"job": job})).await["state"],
            "queued"
        );
        teacher.ok("job.resume", json!({"job": job})).await;
    }
    pass(60, &mut [&mut teacher]).await;
    for job in [&second, &third] {
        assert_eq!(
            teacher.ok("job.get", json!({"job": job})).await["state"],
            "done"
        );
    }
}

#[tokio::test(start_paused = true)]
async fn queue_position_change_is_notified_without_event() {
    let (bench, mut teacher) = class(1).await;
    let (mut ada, mut ben) = (pupil(&bench, "Ada").await, pupil(&bench, "Ben").await);
    ada.ok("turn.join", json!({})).await;
    let mut jobs = Vec::new();
    for _ in 0..3 {
        let queued = json!({"text": plan(2), "queue": true});
        jobs.push(ben.ok("job.start", queued).await["job"].clone());
    }
    teacher.listen(Duration::from_millis(1)).await;
    let before = teacher.ok("events.since", json!({"seq": 0})).await;
    let told_before = teacher.noticed("job.changed").len();
    for place in [1, 3, 1] {
        let to = json!({"job": jobs[2], "position": place});
        assert_eq!(ben.ok("job.reorder", to).await["place"], json!(place));
    }
    // Positions are sent no more often than lists.
    teacher.listen(LIST_INTERVAL).await;
    let told = &teacher.noticed("job.changed")[told_before..];
    let last = |job: &Value| {
        let of = told.iter().rev().find(|told| told["job"]["job"] == *job);
        of.unwrap()["job"]["place"].clone()
    };
    assert_eq!(
        [&jobs[0], &jobs[1], &jobs[2]].map(last),
        [json!(2), json!(3), json!(1)]
    );
    let after = teacher.ok("events.since", json!({"seq": 0})).await;
    assert_eq!(after["seq"], before["seq"]);
}

#[tokio::test(start_paused = true)]
async fn stop_holds_the_queue_until_resumed() {
    let (bench, mut teacher) = class(1).await;
    let mut ada = pupil(&bench, "Ada").await;
    let first = ada
        .ok(
            "job.start",
            json!({"text": plan(40), "queue": true, "after_check": false}),
        )
        .await["job"]
        .clone();
    let second = ada
        .ok("job.start", json!({"text": plan(2), "queue": true}))
        .await["job"]
        .clone();
    pass(1, &mut [&mut ada, &mut teacher]).await;
    teacher.ok("job.stop", json!({"job": first})).await;
    pass(10, &mut [&mut ada, &mut teacher]).await;
    let shown = ada.ok("job.get", json!({"job": second})).await;
    assert_eq!(
        (&shown["state"], &shown["reason"]),
        (&json!("queued"), &json!("stopped"))
    );
    ada.ok("job.resume", json!({"job": second})).await;
    pass(10, &mut [&mut ada, &mut teacher]).await;
    assert_eq!(
        ada.ok("job.get", json!({"job": second})).await["state"],
        "done"
    );
}

#[tokio::test(start_paused = true)]
async fn burning_queued_job_needs_a_teachers_confirmation() {
    let bench = LocalStation::real(1).await;
    let mut teacher = bench.join_as("Ms Lee", Role::Teacher).await;
    teacher.ok("class.set", json!({"text": CLASS})).await;
    let mut ada = pupil(&bench, "Ada").await;
    let burns = json!({"format": "magician-plan", "version": 1, "tool": "laser", "steps": [
        {"laser": true}, {"laser": false}]});
    teacher.ok("lease.acquire", json!({})).await;
    let queue = json!({"text": burns.to_string(), "queue": true, "yes": true});
    let job = ada.ok("job.start", queue).await["job"].clone();
    let lease = teacher.ok("lease.acquire", json!({})).await["lease"].clone();
    teacher.ok("lease.release", json!({"lease": lease})).await;
    pass(10, &mut [&mut ada, &mut teacher]).await;
    let shown = ada.ok("job.get", json!({"job": job})).await;
    assert_eq!(
        (&shown["state"], &shown["reason"]),
        (&json!("queued"), &json!("yes")),
        "{shown}"
    );
    assert_eq!(
        ada.code("job.resume", json!({"job": job, "yes": true}))
            .await,
        -32001
    );
    assert_eq!(
        teacher.code("job.resume", json!({"job": job})).await,
        -32005
    );
    teacher
        .ok("job.resume", json!({"job": job, "yes": true}))
        .await;
    pass(30, &mut [&mut ada, &mut teacher]).await;
    let shown = ada.ok("job.get", json!({"job": job})).await;
    assert_ne!(shown["state"], "queued", "{shown}");
    assert_ne!(shown["error"]["kind"], "dangerous", "{shown}");
}

#[tokio::test(start_paused = true)]
async fn class_fence_applies_to_pupils_only() {
    let (bench, mut teacher) = class(1).await;
    let text = CLASS.replace(
        "grace_s = 20",
        "grace_s = 20\nfence = { floor = 10 }\nspeed = 90",
    );
    teacher.ok("class.set", json!({"text": text})).await;
    let mut ada = pupil(&bench, "Ada").await;
    ada.ok("lease.acquire", json!({})).await;
    let low = json!({"to": [220, 0, -20, 0]});
    ada.ok("arm.move", json!({"to": [220, 0, 30, 0]})).await;
    let error = ada.call("arm.move", low.clone()).await.unwrap_err();
    assert_eq!(error["data"]["kind"], "unreachable", "{error}");
    ada.ok("arm.move", json!({"to": [220, 0, 20, 0]})).await;
    teacher.ok("lease.take", json!({})).await;
    teacher.ok("arm.move", low.clone()).await;
    assert_eq!(
        teacher.ok("arm.fence", json!({})).await["fence"],
        Value::Null
    );
    assert_eq!(
        ada.ok("turn.list", json!({})).await["arms"][0]["state"],
        "suspended"
    );
}

#[tokio::test(start_paused = true)]
async fn teacher_queues_a_program_at_all_arms() {
    let (bench, mut teacher) = class(2).await;
    let mut ada = pupil(&bench, "Ada").await;
    ada.ok("turn.join", json!({"arm": "arm2"})).await;
    let sent = teacher.ok("class.send", json!({"text": plan(2)})).await["jobs"].clone();
    assert_eq!(sent[0]["state"], "checking");
    assert_eq!(sent[1]["state"], "queued", "arm2 is Ada's: {sent}");
    ada.ok("turn.leave", json!({})).await;
    pass(20, &mut [&mut ada, &mut teacher]).await;
    for job in sent.as_array().unwrap() {
        let shown = teacher.ok("job.get", json!({"job": job["job"]})).await;
        assert_eq!(shown["state"], "done", "{shown}");
    }
}

#[tokio::test(start_paused = true)]
async fn unsaved_class_change_is_refused_without_effect() {
    const SCHEDULE: &str = "[[slot]]\narms = [\"arm\"]\nwho = [\"Ada\"]\nfrom = 1970-01-12T13:00:00Z\nuntil = 1970-01-12T13:48:00Z\n";
    let (bench, mut teacher) = class(1).await;
    let shown = async |teacher: &mut Tester| {
        let class = teacher.ok("class.get", json!({})).await;
        (
            class,
            teacher.ok("schedule.get", json!({})).await["text"].clone(),
        )
    };
    let files = || bench.kept.files.lock().unwrap().clone();
    let (before, on_disk) = (shown(&mut teacher).await, files());
    assert!(on_disk["class.toml"].contains("7K3M"));
    let changes = [
        ("class.set", json!({"text": ""})),
        ("class.set", json!({"text": "[[pupil]]\nname = \"Cem\"\n"})),
        ("class.codes", json!({"pupils": ["Ada"]})),
        ("schedule.set", json!({"text": SCHEDULE})),
    ];
    bench.kept.full.store(true, Ordering::SeqCst);
    for (method, params) in &changes {
        let refused = teacher.call(method, params.clone()).await;
        let refused = refused.expect_err(method);
        assert_eq!(refused["data"]["kind"], "closed", "{method}: {refused}");
        assert_eq!(refused["data"]["reason"], "unkept", "{method}: {refused}");
        assert_eq!(shown(&mut teacher).await, before, "{method}");
    }
    assert_eq!(files(), on_disk);
    sign_in(&bench, "Ada", "7K3M")
        .await
        .expect("her code is good");
    bench.kept.full.store(false, Ordering::SeqCst);
    for (method, params) in changes.into_iter().rev() {
        teacher.ok(method, params).await;
    }
    let on_disk = files();
    assert_eq!(on_disk["schedule.toml"], SCHEDULE);
    assert_eq!(on_disk["class.toml"], "");
}

#[tokio::test(start_paused = true)]
async fn class_is_returned_by_post() {
    let bench = LocalStation::new(1).await;
    let set = bench.once("class.set", json!({"text": CLASS})).await;
    assert_eq!(set["result"]["pupils"][0]["name"], "Ada", "{set}");
}
