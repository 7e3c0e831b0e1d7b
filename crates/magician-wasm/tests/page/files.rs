//! Files that another module reads for the station.

use arm::table;
use magician_program::wire::answer;
use serde_json::{Value, json};

use crate::bench::Page;

const SQUARE: &str = "G21 G90\nG0 Z10\nG0 X200 Y0\nG1 Z0 F1200\nG1 X220\nG1 Y20\nG0 Z10\n";

fn ready() -> Page {
    let mut page = Page::ready();
    page.join(1);
    page.ok(1, "lease.acquire", &json!({}));
    page
}

fn gcode(text: &str) -> Value {
    json!({"text": text, "format": "gcode", "setup": {"place": true, "at": [240, 0], "width": 40}})
}

fn kind(error: &Value) -> &str {
    error["data"]["kind"].as_str().unwrap_or_default()
}

/// Runs turns until the page is asked for a file.
fn wait_for_file_request(page: &mut Page) -> (u32, Vec<u8>) {
    for _ in 0..1000 {
        if let Some(asked) = page.asked.pop() {
            return asked;
        }
        page.turn();
    }
    panic!("the page is asked for no file");
}

#[test]
fn file_is_checked_and_run_from_the_plan_read_by_the_page() {
    let mut page = ready();
    let report = page.ok(1, "job.check", &gcode(SQUARE));
    assert_eq!(report["ok"], json!(true), "{report}");
    assert_eq!(page.asked.len(), 1);
    let job = page.ok(1, "job.start", &gcode(SQUARE))["job"].clone();
    for _ in 0..500 {
        page.wait(0.1);
        let told = page.ok(1, "job.get", &json!({"job": job}));
        if told["state"] == json!("done") {
            assert!(told["drawn_mm"].as_f64().unwrap() > 30.0, "{told}");
            return;
        }
    }
    panic!("the job does not end");
}

#[test]
fn pose_dependent_file_is_read_again_from_the_current_pose() {
    let mut page = ready();
    let relative = json!({"text": "G91\nG1 X5 F600\nG1 Y5\n", "format": "gcode"});
    let report = page.ok(1, "job.check", &relative);
    assert_eq!(report["ok"], json!(true), "{report}");
    assert_eq!(page.asked.len(), 2);
}

#[test]
fn file_error_states_its_line() {
    let mut page = ready();
    let error = page
        .call(1, "job.check", &gcode("G90\nG1 X10 Y%\n"))
        .unwrap_err();
    assert_eq!(kind(&error), "invalid-input");
    assert!(
        error["message"].as_str().unwrap().contains("line 2"),
        "{error}"
    );
}

#[test]
fn crash_of_the_reader_fails_only_that_check() {
    let mut page = ready();
    page.skips_requests = true;
    let check = page.send(1, "job.check", &gcode(SQUARE));
    let (id, _) = wait_for_file_request(&mut page);
    table::file_in(page.handle, id, &[]);
    let error = page.answer(1, check).unwrap_err();
    assert_eq!(kind(&error), "unexpected", "{error}");
    page.skips_requests = false;
    page.ok(1, "job.check", &gcode(SQUARE));
}

#[test]
fn silent_reader_times_out() {
    let mut page = ready();
    page.skips_requests = true;
    let check = page.send(1, "job.check", &gcode(SQUARE));
    let (id, request) = wait_for_file_request(&mut page);
    let error = page.answer(1, check).unwrap_err();
    assert_eq!(kind(&error), "timeout", "{error}");
    // The page learns that the file is no longer wanted; a late answer is dropped.
    page.turn();
    assert_eq!(page.asked.pop(), Some((id, Vec::new())));
    table::file_in(page.handle, id, &answer(&request));
    page.turn();
}

#[test]
fn answers_of_another_build_or_damaged_are_refused() {
    let mut page = ready();
    page.skips_requests = true;
    for (spoil, wanted) in [
        ((|whole| whole[2] ^= 1) as fn(&mut Vec<u8>), "unsupported"),
        (|whole| whole.truncate(whole.len() - 3), "unexpected"),
        (|whole| *whole = vec![7; 5], "unexpected"),
        (|whole| whole.resize((64 << 20) + 1, 0), "unsupported"),
    ] {
        let check = page.send(1, "job.check", &gcode(SQUARE));
        let (id, request) = wait_for_file_request(&mut page);
        let mut whole = answer(&request);
        spoil(&mut whole);
        table::file_in(page.handle, id, &whole);
        let error = page.answer(1, check).unwrap_err();
        assert_eq!(kind(&error), wanted, "{error}");
    }
}

#[test]
fn stopped_job_cancels_its_file_request() {
    let mut page = ready();
    page.skips_requests = true;
    let start = page.send(1, "job.start", &{
        let mut source = gcode(SQUARE);
        source["after_check"] = json!(false);
        source
    });
    let job = page.answer(1, start).unwrap()["job"].clone();
    let (id, request) = wait_for_file_request(&mut page);
    let began = page.now;
    let stopped = page.ok(1, "job.stop", &json!({"job": job}));
    assert_eq!(stopped["state"], json!("stopped"), "{stopped}");
    assert!(page.now - began < 200e3, "{}", page.now - began);
    page.turn();
    assert_eq!(page.asked.pop(), Some((id, Vec::new())));
    // A late answer does not start the job.
    table::file_in(page.handle, id, &answer(&request));
    page.wait(1.0);
    let told = page.ok(1, "job.get", &json!({"job": job}));
    assert_eq!(told["state"], json!("stopped"));
    assert_eq!(page.ok(1, "arm.state", &json!({}))["moving"], json!(false));
}

#[test]
fn files_of_two_sessions_are_requested_one_at_a_time() {
    let mut page = ready();
    page.join(2);
    page.skips_requests = true;
    let one = page.send(1, "job.check", &gcode(SQUARE));
    let two = page.send(2, "job.check", &gcode("G90\nG1 X10 Y%\n"));
    let (id, request) = wait_for_file_request(&mut page);
    page.wait(1.0);
    assert!(page.asked.is_empty());
    // An answer with an unknown number is ignored.
    table::file_in(page.handle, id + 1, &answer(&request));
    table::file_in(page.handle, id, &answer(&request));
    page.skips_requests = false;
    let first = page.answer(1, one);
    let second = page.answer(2, two);
    assert_eq!(first.unwrap()["ok"], json!(true));
    assert_eq!(kind(&second.unwrap_err()), "invalid-input");
}

#[test]
fn large_program_is_transferred_without_messages() {
    let mut page = ready();
    let large = "G1 X200 Y0\n".repeat(200_000);
    let kept = |name: &str, bytes: &[u8]| {
        let why = table::program_in(page.handle, name.as_bytes(), bytes, <[u8]>::to_vec);
        why.map(|why| String::from_utf8(why).unwrap())
    };
    assert_eq!(kept("large.nc", large.as_bytes()), None);
    assert!(kept("../x", b"").is_some() && kept("", b"").is_some());
    assert!(kept("too large", &vec![0; 65 << 20]).is_some());
    let out = table::program_out(page.handle, b"large.nc", <[u8]>::to_vec);
    assert!(out.as_deref() == Some(large.as_bytes()));
    assert_eq!(table::program_out(page.handle, b"none", <[u8]>::len), None);
    let listed = page.ok(1, "program.list", &json!({}));
    assert_eq!(listed["programs"][0]["format"], json!("gcode"), "{listed}");
    assert_eq!(table::program_in(99, b"a", b"", <[u8]>::len), Some(24));
}

#[test]
fn preset_is_stored_among_the_programs_of_the_page() {
    let mut page = ready();
    let birch = json!({"name": "birch", "setup": {"work": null}});
    assert!(page.call(1, "preset.save", &birch).is_err());
    let birch = json!({"name": "birch", "setup": {"speed": 12}, "note": "3 mm"});
    let saved = page.ok(1, "preset.save", &birch);
    let name = b"preset+birch.toml";
    let text = table::program_out(page.handle, name, <[u8]>::to_vec).unwrap();
    assert_eq!(saved["text"].as_str().unwrap().as_bytes(), text);
    // A preset is not listed as a program.
    let listed = page.ok(1, "program.list", &json!({}));
    assert_eq!(listed["programs"], json!([]));
    page.ok(1, "preset.remove", &json!({"name": "birch"}));
    assert_eq!(table::program_out(page.handle, name, <[u8]>::len), None);
    // A reloaded page restores the preset, and jobs can use it.
    let put = table::program_in(page.handle, name, &text, <[u8]>::to_vec);
    assert_eq!(put, None);
    let mut check = gcode(SQUARE);
    check["setup"]["preset"] = json!("birch");
    let report = page.ok(1, "job.check", &check);
    assert_eq!(
        report["notes"][0]["text"],
        json!("preset birch: 3 mm"),
        "{report}"
    );
}

#[test]
fn drawing_is_converted_to_another_file() {
    let mut page = ready();
    let svg = "<svg xmlns='http://www.w3.org/2000/svg' width='40mm' height='40mm' viewBox='0 0 40 40'>\
        <path d='M5 5 L35 35' stroke='black' fill='none'/></svg>";
    page.ok(1, "program.put", &json!({"name": "line.svg", "text": svg}));
    page.ok(
        1,
        "program.convert",
        &json!({"name": "line.svg", "to": "line.plan.json"}),
    );
    assert_eq!(page.asked.len(), 1);
    let plan = page.ok(1, "program.get", &json!({"name": "line.plan.json"}));
    assert_eq!(plan["format"], json!("plan"));
}

#[test]
fn stop_interrupts_a_long_check() {
    const SLICES: usize = 6;
    let mut page = ready();
    page.skips_requests = true;
    let lines: String = (0..50_000)
        .map(|nth| format!("G1 X{} Y{}\n", 200 + nth % 7, nth % 11))
        .collect();
    let check = json!({"text": format!("G90\nG0 X200 Y0 Z0\n{lines}"), "format": "gcode"});
    let check = page.send(1, "job.check", &check);
    let (id, request) = wait_for_file_request(&mut page);
    table::file_in(page.handle, id, &answer(&request));
    let mut turns = 0;
    let mut stop = None;
    while !page.has(1, check) {
        // On a slow machine a turn takes far longer than planned.
        page.turn_at(page.now + 300e3);
        turns += 1;
        if turns == SLICES {
            stop = Some((page.send(1, "arm.stop", &json!({})), page.now));
        }
        assert!(turns < 1000, "the check does not end");
    }
    // Both reading the answer and the check itself are spread over turns.
    assert!(turns >= 2 * SLICES, "{turns}");
    let (stop, sent) = stop.expect("the check took turns");
    assert!(page.has(1, stop), "the stop came behind the check");
    assert!(page.now > sent);
    assert_eq!(page.answer(1, check).unwrap()["steps"], json!(50_002));
}

#[test]
fn bad_option_is_refused_with_the_common_message_before_reading() {
    let table = include_str!("../../../magician-program/tests/data/bad_options.json");
    let table: Vec<Value> = serde_json::from_str(table).unwrap();
    let mut page = ready();
    for entry in &table {
        let mut params = gcode(SQUARE);
        params["setup"] = entry["options"].clone();
        let error = page.call(1, "job.check", &params).unwrap_err();
        let (key, message) = (
            entry["key"].as_str().unwrap(),
            entry["message"].as_str().unwrap(),
        );
        assert_eq!(error["code"], json!(-32602), "{error}");
        assert_eq!(
            error["data"]["param"],
            json!(format!("setup.{key}")),
            "{error}"
        );
        assert_eq!(error["message"], json!(format!("`setup`: {message}")));
        // The limit of requests per session would refuse more of them at once.
        page.wait(0.1);
    }
    assert!(page.asked.is_empty());
}
