//! Virtual arms in the page.

use arm::table;
use magician::build;
use magician_program::{Action, Origin, Plan, Surface, Tool, Travel};
use serde_json::{Value, json};

use crate::bench::{Page, refusal};

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

#[test]
fn a_session_takes_the_arm_and_moves_it() {
    let mut page = Page::ready();
    let hello = page.join(1);
    assert_eq!(
        (&hello["role"], &hello["arms"], &hello["api"]),
        (&json!("teacher"), &json!(["arm"]), &json!(1))
    );
    let arms = page.ok(1, "arm.list", &json!({}));
    assert_eq!(arms["arms"][0]["virtual"], json!(true));
    let to = json!({"to": [220, 40, 30, 0]});
    let refused = page.call(1, "arm.move", &to).unwrap_err();
    assert_eq!(refused["code"], json!(-32002));
    page.ok(1, "lease.acquire", &json!({}));
    let began = page.now;
    let state = page.ok(1, "arm.move", &to);
    assert!((number(&state["y"]) - 40.0).abs() < 1e-3, "{state}");
    // The motion takes as long as on a real arm, and `t` is in the page's calendar.
    let took = (page.now - began) / 1e6;
    assert!(took > 0.3 && took < 5.0, "{took}");
    let t = number(&state["t"]);
    assert!((t - (1_000_000.0 + page.now / 1e6)).abs() < 0.1, "{t}");
}

#[test]
fn subscribers_get_the_requested_fields_as_text_or_frames() {
    let mut page = Page::ready();
    page.join(1);
    page.join(2);
    page.ok(1, "arm.subscribe", &json!({"rate": 20}));
    let binary = json!({"rate": 50, "frame": "binary"});
    let id = page.ok(2, "arm.subscribe", &binary)["subscription"].clone();
    page.ok(1, "lease.acquire", &json!({}));
    let going = page.send(
        1,
        "arm.move",
        &json!({"to": [180, 120, 60, 0], "by": "linear"}),
    );
    page.texts.clear();
    page.frames.clear();
    let began = page.now;
    page.answer(1, going).expect("within reach");
    let took = (page.now - began) / 1e6;
    let deltas = page.notifications(1, "arm.state").len() as f64 / took;
    assert!((17.0..=23.0).contains(&deltas), "{deltas} a second");
    let frames = page.frames.len() as f64 / took;
    assert!((45.0..=55.0).contains(&frames), "{frames} a second");
    for (session, frame) in &page.frames {
        assert_eq!((*session, frame.len(), frame[0]), (2, 112, 0x4D));
        let of = u16::from_le_bytes([frame[2], frame[3]]);
        assert_eq!(json!(of), id);
    }
}

/// Returns the laser state that the page was notified of last.
fn last_laser_state(page: &Page) -> Value {
    let states = page.notifications(1, "arm.state");
    let mut tools = states.iter().filter_map(|told| told["state"].get("tool"));
    tools
        .next_back()
        .map_or(Value::Null, |tool| tool["laser"].clone())
}

#[test]
fn laser_is_reported_off_after_a_stop() {
    let burns = r#"{"format":"magician-plan","version":1,"steps":[{"move":[220,0,30,0],"by":"line"},
        {"burn":[220,60,30],"power":60},{"burn":[220,0,30],"power":60},{"laser":false}]}"#;
    for by_job in [false, true] {
        let mut page = Page::ready();
        page.join(1);
        page.ok(1, "arm.subscribe", &json!({"rate": 20}));
        page.ok(1, "lease.acquire", &json!({}));
        if by_job {
            page.ok(1, "job.start", &json!({"text": burns}));
        } else {
            page.ok(1, "arm.tool", &json!({"laser": {"on": true}}));
        }
        page.wait(2.0);
        assert_eq!(last_laser_state(&page), json!(true), "job: {by_job}");
        page.ok(1, "arm.stop", &json!({}));
        let state = page.ok(1, "arm.state", &json!({}));
        assert_eq!(state["tool"]["laser"], json!(false), "job: {by_job}");
        page.wait(0.2);
        assert_eq!(last_laser_state(&page), json!(false), "job: {by_job}");
    }
}

#[test]
fn jog_continues_with_keep_alives_and_ends_without() {
    let mut page = Page::ready();
    page.join(1);
    page.ok(1, "lease.acquire", &json!({}));
    let jog = page.ok(1, "jog.start", &json!({"axis": "y+"}))["jog"].clone();
    for _ in 0..20 {
        page.notify(1, "jog.keep", &json!({"jog": jog}));
        page.wait(0.06);
    }
    assert!(page.notifications(1, "jog.ended").is_empty());
    let moved = number(&page.ok(1, "arm.state", &json!({}))["y"]);
    assert!(moved > 5.0, "{moved}");
    // The jog ends once no keep-alive arrives.
    page.wait(0.3);
    let ended = page.notifications(1, "jog.ended");
    assert_eq!(
        (&ended[0]["why"], &ended[0]["jog"]),
        (&json!("not-kept"), &jog)
    );
    page.wait(0.5);
    let state = page.ok(1, "arm.state", &json!({}));
    assert_eq!(state["moving"], json!(false));
}

#[test]
fn suspended_page_loses_jog_and_lease() {
    let mut page = Page::ready();
    page.join(1);
    let lease = page.ok(1, "lease.acquire", &json!({}))["lease"].clone();
    let jog = page.ok(1, "jog.start", &json!({"axis": "y+"}))["jog"].clone();
    page.notify(1, "jog.keep", &json!({"jog": jog}));
    page.wait(0.1);
    // Messages of a page that wakes up are judged by the current time.
    page.notify(1, "jog.keep", &json!({"jog": jog}));
    let renewed = page.send(1, "lease.renew", &json!({"lease": lease}));
    page.turn_at(page.now + 10e6);
    assert_eq!(
        page.notifications(1, "jog.ended")[0]["why"],
        json!("not-kept")
    );
    let refused = page.answer(1, renewed).unwrap_err();
    assert_eq!(refused["code"], json!(-32002));
}

#[test]
fn silent_session_keeps_its_lease_until_it_ends() {
    let mut page = Page::ready();
    page.join(1);
    page.join(2);
    page.ok(1, "lease.acquire", &json!({}));
    let jog = page.ok(1, "jog.start", &json!({"axis": "x+", "keep_ms": 1000}))["jog"].clone();
    page.notify(1, "jog.keep", &json!({"jog": jog}));
    table::station_rpc(page.handle, 1, b"");
    page.turn();
    assert_eq!(
        page.notifications(2, "jog.ended")[0]["why"],
        json!("released")
    );
    // A session has five seconds to come back.
    page.wait(6.0);
    let arms = page.ok(2, "arm.list", &json!({}));
    assert_eq!(arms["arms"][0]["holder"], Value::Null);
    // The other session stays connected throughout.
    page.ok(2, "lease.acquire", &json!({}));
    page.wait(20.0);
    let arms = page.ok(2, "arm.list", &json!({}));
    assert_eq!(arms["arms"][0]["holder"]["name"], json!("page"));
    // The number of the ended session can be used again.
    page.join(1);
}

#[test]
fn cable_can_be_unplugged_and_plugged_in_again() {
    let mut page = Page::ready();
    page.join(1);
    page.ok(1, "lease.acquire", &json!({}));
    page.ok(1, "world.unplug", &json!({"plugged": false}));
    let refused = page.call(1, "arm.info", &json!({})).unwrap_err();
    assert_eq!(refused["data"]["kind"], json!("port"), "{refused}");
    page.ok(1, "world.unplug", &json!({"plugged": true}));
    page.wait(2.0);
    let state = page.ok(1, "arm.move", &json!({"to": [220, 0, 20, 0]}));
    assert!((number(&state["x"]) - 220.0).abs() < 1e-3, "{state}");
}

/// Returns a plan that draws lines slowly with a pen.
fn drawing() -> String {
    let mut plan = Plan::new("lines");
    plan.tool = Some(Tool::Pen);
    plan.surface = Some(Surface::level(-60.0));
    let mut push = |action: Action| plan.push(action, Origin::NONE);
    push(build::speed(20.0, 50.0).into());
    let line = |x, y, z| Action::Move {
        to: [x, y, z, 0.0],
        by: Travel::Line,
    };
    push(line(210.0, -40.0, -45.0));
    for (x, y) in [(210.0, -40.0), (210.0, 40.0), (240.0, 40.0), (240.0, -40.0)] {
        push(line(x, y, -60.0));
    }
    push(line(240.0, -40.0, -45.0));
    plan.to_json()
}

fn until(page: &mut Page, job: &Value, state: &str) -> Value {
    for _ in 0..1000 {
        let now = page.ok(1, "job.get", &json!({"job": job}));
        if now["state"] == json!(state) {
            return now;
        }
        page.wait(0.1);
    }
    panic!("never {state}");
}

#[test]
fn a_plan_of_the_library_is_checked_run_stopped_and_resumed() {
    let mut page = Page::ready();
    page.join(1);
    page.ok(1, "lease.acquire", &json!({}));
    let name = "lines.plan.json";
    let kept = page.ok(1, "program.put", &json!({"name": name, "text": drawing()}));
    assert_eq!(kept["bytes"], json!(drawing().len()));
    let listed = page.ok(1, "program.list", &json!({}))["programs"][0].clone();
    assert_eq!(listed["format"], json!("plan"));
    assert!(number(&listed["modified"]) > 1_000_000.0, "{listed}");
    let found = page.ok(1, "job.check", &json!({"program": name, "preview": true}));
    assert_eq!(found["ok"], json!(true));
    assert!(!found["preview"]["strokes"].as_array().unwrap().is_empty());
    page.ok(1, "arm.home", &json!({}));
    let job = page.ok(1, "job.start", &json!({"program": name}))["job"].clone();
    until(&mut page, &job, "running");
    page.wait(4.0);
    let stopped = page.ok(1, "job.stop", &json!({"job": job}));
    assert_eq!(stopped["state"], json!("stopped"));
    // The job resumes from its journal.
    let resumed = page.ok(1, "job.resume", &json!({"job": job}));
    let done = until(&mut page, &resumed["job"], "done");
    assert_eq!(done["step"], done["steps"], "{done}");
    let look = page.ok(1, "world.look", &json!({}));
    assert!(look["drawing"].as_str().unwrap().starts_with("<svg"));
    page.ok(1, "program.delete", &json!({"name": name}));
    assert_eq!(
        page.ok(1, "program.list", &json!({}))["programs"],
        json!([])
    );
}

#[test]
fn arm_has_the_configured_speed_and_world() {
    let cube = "tool = { kind = \"suction\" }\ntable = { height = -60 }\n\
        object = [{ name = \"cube\", size = [20, 20, 20], at = [220, 80] }]";
    let arms = json!([
        {"name": "slow", "sim": {"speed": 1}},
        {"name": "fast", "sim": {"speed": 10, "scenario": cube}},
    ]);
    let mut page = Page::of(&json!({"arms": arms, "role": "student"}));
    page.wait_until_ready();
    assert_eq!(page.join(1)["role"], json!("student"));
    let look = page.ok(1, "world.look", &json!({"arm": "fast"}));
    assert_eq!(look["objects"][0]["name"], json!("cube"));
    let times = ["slow", "fast"].map(|arm| {
        page.ok(1, "lease.acquire", &json!({"arm": arm}));
        let began = page.now;
        page.ok(1, "arm.move", &json!({"arm": arm, "to": [180, 120, 60, 0]}));
        page.now - began
    });
    assert!(times[0] > 5.0 * times[1], "{times:?}");
}

#[test]
fn invalid_configuration_is_refused_with_its_reason() {
    let arm = json!({"name": "arm", "sim": {}});
    for (config, word) in [
        (json!(7), "configuration"),
        (json!({}), "arms"),
        (json!({"arms": []}), "arms"),
        (json!({"arms": [{"name": "Arm", "sim": {}}]}), "name"),
        (json!({"arms": [arm, arm]}), "two arms"),
        (json!({"arms": [{"name": "arm"}]}), "either"),
        (
            json!({"arms": [{"name": "arm", "sim": {}, "line": true}]}),
            "either",
        ),
        (
            json!({"arms": [{"name": "a", "line": true}, {"name": "b", "line": true}]}),
            "one arm",
        ),
        (
            json!({"arms": [{"name": "arm", "sim": {"speed": 0}}]}),
            "speed",
        ),
        (
            json!({"arms": [{"name": "arm", "sim": {"speed": 101}}]}),
            "speed",
        ),
        (
            json!({"arms": [{"name": "arm", "sim": {"scenario": "[table]\nheigth = 1"}}]}),
            "line 2",
        ),
        (json!({"arms": [arm], "role": "king"}), "role"),
        (json!({"arms": [arm], "unix_zero": 1e300}), "unix_zero"),
        (json!({"arms": [arm], "clock": 1}), "clock"),
    ] {
        assert_eq!(
            table::station_open(config.to_string().as_bytes()),
            0,
            "{config}"
        );
        let why = refusal().expect("why");
        assert_eq!(why["error"]["kind"], json!("invalid-input"));
        let message = why["error"]["message"].as_str().unwrap();
        assert!(message.contains(word), "{config}: {message}");
    }
    assert_eq!(table::station_open(b"\xff{"), 0);
    assert!(refusal().is_some());
    assert!(refusal().is_none(), "it is said once");
}

#[test]
fn invalid_calls_have_no_effect() {
    for handle in [0, 1, u32::MAX] {
        table::station_rpc(handle, 1, b"{}");
        table::line_in(handle, b"x");
        table::line_lost(handle);
        table::line_found(handle);
        assert_eq!(table::station_turn(handle, 1e6), -1.0);
        assert!(table::station_out(handle, <[u8]>::to_vec).is_none());
    }
    let mut page = Page::ready();
    page.join(3);
    for now in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, 0.0] {
        let next = table::station_turn(page.handle, now);
        assert!(next > page.now && next < page.now + 1e5, "{now}: {next}");
    }
    // The station's own session, and a number beyond the last.
    table::station_rpc(page.handle, 0, b"{}");
    table::station_rpc(page.handle, 65536, b"{}");
    // Invalid UTF-8, and text other than JSON.
    table::station_rpc(page.handle, 1, b"\xff");
    table::station_rpc(page.handle, 2, b"nonsense");
    page.turn();
    assert_eq!(page.closed, [(1, 1007), (2, 4400)]);
    // Sessions without `session.hello` displace each other, but never a session that sent it.
    for session in 100..200 {
        table::station_rpc(
            page.handle,
            session,
            b"{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"server.info\"}",
        );
    }
    page.turn();
    let late = page.closed.iter().filter(|(session, _)| *session >= 100);
    let late: Vec<_> = late.map(|(_, code)| *code).collect();
    assert!(
        late.len() >= 84 && late.iter().all(|code| *code == 4408),
        "{late:?}"
    );
    page.ok(3, "arm.state", &json!({}));
    // The clock jumps by a year.
    page.turn_at(page.now + 3e13);
    page.turn();
    page.ok(3, "arm.state", &json!({}));
}
