//! A real arm at the line: here the virtual one behind a serial line, at the far end of the page's bytes.

use serde_json::{Value, json};

use arm::table;

use crate::bench::{FarEnd, Page};

fn at_line() -> Page {
    let arms = json!([{"name": "arm", "line": true}]);
    let mut page = Page::of(&json!({"arms": arms}));
    page.far = Some(FarEnd::new());
    page
}

fn pose(page: &Page) -> [f64; 4] {
    let far = page.far.as_ref().expect("an arm");
    far.runner.controller().state().pose.to_array()
}

#[test]
fn an_arm_at_the_line_is_moved_and_jogged_by_its_bytes() {
    let mut page = at_line();
    page.becomes_ready();
    page.join(1);
    let arms = page.ok(1, "arm.list", &json!({}));
    assert_eq!(arms["arms"][0]["virtual"], json!(false));
    page.ok(1, "lease.acquire", &json!({}));
    page.ok(1, "arm.move", &json!({"to": [220, 40, 30, 0]}));
    let there = pose(&page);
    assert!((there[1] - 40.0).abs() < 1e-3, "{there:?}");
    let jog = page.ok(1, "jog.start", &json!({"axis": "z+"}))["jog"].clone();
    for _ in 0..10 {
        page.notify(1, "jog.keep", &json!({"jog": jog}));
        page.wait(0.06);
    }
    assert!(pose(&page)[2] > there[2] + 1.0);
    page.wait(0.3);
    assert_eq!(page.noticed(1, "jog.ended")[0]["why"], json!("not-kept"));
    page.wait(0.5);
    let stood = pose(&page);
    page.wait(0.5);
    assert_eq!(pose(&page), stood);
    // Nothing burns there that was not asked for.
    let laser = json!({"laser": {"on": true}});
    let refused = page.call(1, "arm.tool", &laser).unwrap_err();
    assert_eq!(refused["code"], json!(-32005), "{refused}");
    let refused = page.call(1, "world.look", &json!({})).unwrap_err();
    assert_eq!(refused["data"]["kind"], json!("unsupported"));
}

#[test]
fn a_line_that_is_lost_is_found_again() {
    let mut page = at_line();
    page.becomes_ready();
    page.join(1);
    page.ok(1, "arm.subscribe", &json!({"rate": 20}));
    page.ok(1, "lease.acquire", &json!({}));
    page.ok(1, "arm.move", &json!({"to": [220, 40, 30, 0]}));
    table::line_lost(page.handle);
    page.far.as_mut().unwrap().mute = true;
    page.texts.clear();
    page.wait(0.1);
    let lost = |state: &&Value| state["state"]["link"] == json!("lost");
    assert!(page.noticed(1, "arm.state").iter().any(lost));
    let refused = page.call(1, "arm.state", &json!({})).unwrap_err();
    assert_eq!(refused["data"]["kind"], json!("port"), "{refused}");
    // Bytes of a line that is lost do not belong to the next one.
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
    assert!(page.noticed(1, "arm.state").iter().any(up));
    page.ok(1, "lease.acquire", &json!({}));
    page.ok(1, "arm.move", &json!({"to": [220, -20, 30, 0]}));
    assert!((pose(&page)[1] + 20.0).abs() < 1e-3);
}

#[test]
fn where_no_arm_answers_the_station_says_so_and_is_over() {
    let mut page = at_line();
    page.far = None;
    let id = page.send(1, "session.hello", &json!({"client": {"name": "page"}}));
    let told = page.own();
    assert_eq!(told["error"]["kind"], json!("timeout"), "{told}");
    assert_eq!(table::station_turn(page.handle, page.now + 1e6), -1.0);
    assert!(!page.texts.contains_key(&1), "{id} has no answer");
}
