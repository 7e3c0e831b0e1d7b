#![no_main]
//! Plan file of arbitrary bytes: refused with a place in the file, or written, read again with the
//! same result, and checked.

use libfuzzer_sys::fuzz_target;
use magician::preflight::Preflight;
use magician::{JointAngles, ToolBias};
use magician_program::{Content, Format, Plan, ReadOptions, check, read};

fn plan(bytes: &[u8]) -> Option<Plan> {
    match read(Format::Plan, bytes, &ReadOptions::default()).ok()?.content {
        Content::Plan(plan) => Some(plan),
        _ => panic!("a plan is a plan"),
    }
}

fuzz_target!(|bytes: &[u8]| {
    let Some(first) = plan(bytes) else { return };
    let json = first.to_json();
    let again = plan(json.as_bytes()).expect("what we have written");
    // Compared as text, since NaN does not equal itself.
    assert_eq!(again.to_json(), json);
    let report = check(&first, &Preflight::at(JointAngles::HOME, ToolBias::NONE));
    assert_eq!(report.steps, first.steps.len());
});
