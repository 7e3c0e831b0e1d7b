//! A real arm on the serial line, played by a virtual one at the far end of the page's bytes.

use magician::protocol::Direction;
use magician::sim::HostInstant;
use magician_record::trace::read_trace;
use serde_json::{Value, json};

use arm::table;

use crate::bench::{FarEndArm, Page};

fn at_line() -> Page {
    let arms = json!([{"name": "arm", "line": true}]);
    let mut page = Page::of(&json!({"arms": arms}));
    page.far = Some(FarEndArm::new());
    page
}

fn pose(page: &Page) -> [f64; 4] {
    let far = page.far.as_ref().expect("an arm");
    far.runner.controller().state().pose.to_array()
}

#[test]
fn an_arm_at_the_line_is_moved_and_jogged_by_its_bytes() {
    let mut page = at_line();
    page.wait_until_ready();
    page.join(1);
    let arms = page.ok(1, "arm.list", &json!({}));
    assert_eq!(arms["arms"][0]["virtual"], json!(false));
    page.ok(1, "lease.acquire", &json!({}));
    page.ok(1, "arm.move", &json!({"to": [220, 40, 30, 0]}));
    let there = pose(&page);
    assert!((there[1] - 40.0).abs() < 1e-3, "{there:?}");
    page.commands.clear();
    let jog = page.ok(1, "jog.start", &json!({"axis": "z+"}))["jog"].clone();
    for _ in 0..10 {
        page.notify(1, "jog.keep", &json!({"jog": jog}));
        page.wait(0.06);
    }
    assert!(pose(&page)[2] > there[2] + 1.0);
    page.wait(0.3);
    assert_eq!(
        page.notifications(1, "jog.ended")[0]["why"],
        json!("not-kept")
    );
    page.wait(0.5);
    let stood = pose(&page);
    page.wait(0.5);
    assert_eq!(pose(&page), stood);
    assert!(page.commands.contains(&91) && !page.commands.contains(&73));
    // The laser of a real arm is refused without the confirmation `yes`.
    let laser = json!({"laser": {"on": true}});
    let refused = page.call(1, "arm.tool", &laser).unwrap_err();
    assert_eq!(refused["code"], json!(-32005), "{refused}");
    let refused = page.call(1, "world.look", &json!({})).unwrap_err();
    assert_eq!(refused["data"]["kind"], json!("unsupported"));
}

#[test]
fn keep_alive_of_a_jog_counts_from_its_start() {
    // A client cannot keep a jog before its start was answered, so on a slow line the call's
    // deadline ends it.
    for (baud, begins, why) in [(19_200, true, "not-kept"), (1200, false, "link")] {
        let mut page = at_line();
        page.wait_until_ready();
        page.join(1);
        page.ok(1, "lease.acquire", &json!({}));
        page.far = Some(FarEndArm::at(baud));
        let asked = page.now;
        let begun = page.call(1, "jog.start", &json!({"axis": "z+", "keep_ms": 230}));
        let took = page.now - asked;
        if begins {
            assert!(took > 230e3, "{took} us");
            let jog = begun.unwrap()["jog"].clone();
            page.wait(0.15);
            page.notify(1, "jog.keep", &json!({"jog": jog}));
            page.wait(0.15);
            assert!(page.notifications(1, "jog.ended").is_empty());
            page.wait(0.1);
        } else {
            begun.unwrap_err();
            assert!(took < 3.1e6, "{took} us");
            page.wait(2.0);
            assert!(!page.commands.contains(&91));
        }
        assert_eq!(page.notifications(1, "jog.ended")[0]["why"], json!(why));
    }
}

#[test]
fn arm_stops_in_time_if_the_page_dies_during_a_jog() {
    for (axis, turns) in [("z-", 20), ("z-", 90), ("j1+", 45), ("r-", 70)] {
        let mut page = at_line();
        page.wait_until_ready();
        page.join(1);
        page.ok(1, "lease.acquire", &json!({}));
        let asked = json!({"axis": axis, "percent": 100});
        let jog = page.ok(1, "jog.start", &asked)["jog"].clone();
        let mut longest = 0.0_f64;
        for turn in 0..turns {
            if turn % 15 == 0 {
                page.notify(1, "jog.keep", &json!({"jog": jog}));
            }
            page.turn();
            let mut alone = page.far.as_ref().unwrap().runner.controller().clone();
            let begun = alone.now();
            while alone.busy() {
                alone.advance(alone.now() + std::time::Duration::from_millis(1));
            }
            longest = longest.max((alone.now() - begun).as_secs_f64());
        }
        assert!((0.1..=0.3).contains(&longest), "{axis} {turns}: {longest}");
        // Bytes still on the line reach the arm.
        let far = page.far.as_mut().unwrap();
        let died = page.now;
        let mut now = died;
        while far.runner.controller().busy() {
            now += 1000.0;
            far.runner
                .handle_timeout(HostInstant::from_micros(now as u64));
        }
        assert!(now - died <= 300e3, "{axis} {turns}: {} us", now - died);
    }
}

#[test]
fn step_after_a_jog_uses_the_arms_own_speeds() {
    let mut page = at_line();
    page.wait_until_ready();
    page.join(1);
    page.ok(1, "lease.acquire", &json!({}));
    let speeds = json!({"command": "PTPCommonParams"});
    page.ok(1, "arm.speed", &json!({"percent": 20}));
    let before = page.ok(1, "arm.get", &speeds);
    page.ok(1, "arm.speed", &json!({"percent": 50}));
    let jog = page.ok(1, "jog.start", &json!({"axis": "j1+"}))["jog"].clone();
    assert_ne!(page.ok(1, "arm.get", &speeds), before);
    page.send(1, "jog.stop", &json!({"jog": jog}));
    // The speed is set after the jog restored the previous one.
    page.ok(1, "arm.speed", &json!({"percent": 20}));
    page.ok(1, "jog.step", &json!({"axis": "x", "by": -5}));
    assert_eq!(page.ok(1, "arm.get", &speeds), before);
    let jog = page.ok(1, "jog.start", &json!({"axis": "j1+"}))["jog"].clone();
    page.ok(1, "arm.stop", &json!({}));
    page.ok(1, "jog.step", &json!({"axis": "x", "by": 5}));
    assert_eq!(page.ok(1, "arm.get", &speeds), before);
    assert_eq!(page.notifications(1, "jog.ended")[1]["jog"], jog);
    // The line breaks during a jog.
    page.ok(1, "jog.start", &json!({"axis": "j1+"}));
    table::line_lost(page.handle);
    page.far.as_mut().unwrap().mute = true;
    page.wait(1.0);
    table::line_found(page.handle);
    page.far.as_mut().unwrap().mute = false;
    page.wait(2.0);
    assert_eq!(page.ok(1, "arm.get", &speeds), before);
}

#[test]
fn lost_line_is_reconnected() {
    let mut page = at_line();
    page.wait_until_ready();
    page.join(1);
    page.ok(1, "arm.subscribe", &json!({"rate": 20}));
    page.ok(1, "lease.acquire", &json!({}));
    page.ok(1, "arm.move", &json!({"to": [220, 40, 30, 0]}));
    table::line_lost(page.handle);
    page.far.as_mut().unwrap().mute = true;
    page.texts.clear();
    page.wait(0.1);
    let lost = |state: &&Value| state["state"]["link"] == json!("lost");
    assert!(page.notifications(1, "arm.state").iter().any(lost));
    let refused = page.call(1, "arm.state", &json!({})).unwrap_err();
    assert_eq!(refused["data"]["kind"], json!("port"), "{refused}");
    // Bytes of the lost line do not count for the next one.
    table::line_in(page.handle, &[0xAA; 100]);
    page.wait(3.0);
    let said = page.said;
    page.wait(1.0);
    assert_eq!(page.said, said, "nothing goes out");
    page.texts.clear();
    table::line_found(page.handle);
    page.far.as_mut().unwrap().mute = false;
    page.wait(2.0);
    let up = |state: &&Value| state["state"]["link"] == json!("up");
    assert!(page.notifications(1, "arm.state").iter().any(up));
    page.ok(1, "lease.acquire", &json!({}));
    page.ok(1, "arm.move", &json!({"to": [220, -20, 30, 0]}));
    assert!((pose(&page)[1] + 20.0).abs() < 1e-3);
}

#[test]
fn station_fails_with_a_message_if_no_arm_answers() {
    let mut page = at_line();
    page.far = None;
    let id = page.send(1, "session.hello", &json!({"client": {"name": "page"}}));
    let told = page.own();
    assert_eq!(told["error"]["kind"], json!("timeout"), "{told}");
    assert_eq!(table::station_turn(page.handle, page.now + 1e6), -1.0);
    assert!(!page.texts.contains_key(&1), "{id} has no answer");
}

#[test]
fn connecting_sends_nothing_but_reads() {
    let mut page = at_line();
    page.wait_until_ready();
    page.join(1);
    page.ok(1, "arm.subscribe", &json!({"rate": 20}));
    page.ok(1, "job.list", &json!({}));
    page.wait(3.0);
    let file = page.trace();
    let packets = read_trace(&file).map(Result::unwrap);
    let sent = packets.filter(|packet| packet.direction == Some(Direction::Request));
    // In the Ctrl byte bit 0 means write and bit 1 means queued.
    let ctrls: Vec<u8> = sent.map(|packet| packet.bytes[4]).collect();
    assert!(ctrls.len() > 20, "{}", ctrls.len());
    assert!(ctrls.iter().all(|ctrl| *ctrl == 0), "{ctrls:?}");
}

#[test]
fn trace_contains_the_latest_traffic() {
    let mut page = at_line();
    page.wait_until_ready();
    page.join(1);
    page.ok(1, "lease.acquire", &json!({}));
    page.ok(1, "arm.move", &json!({"to": [220, 40, 30, 0]}));
    let file = page.trace();
    let moves = read_trace(&file).map(Result::unwrap);
    let moves = moves.filter(|packet| packet.bytes.get(3) == Some(&84));
    let sides: Vec<_> = moves.map(|packet| packet.direction).collect();
    assert_eq!(sides, [Some(Direction::Request), Some(Direction::Reply)]);
    page.ok(1, "arm.subscribe", &json!({"rate": 50}));
    while page.trace().len() < arm::trace::CAPACITY {
        page.wait(20.0);
    }
    page.wait(20.0);
    let file = page.trace();
    assert!(file.len() < arm::trace::CAPACITY + 1000, "{}", file.len());
    let mut packets = read_trace(&file).map(Result::unwrap);
    assert!(packets.all(|packet| packet.bytes.get(3) != Some(&84)));
}
