#![no_main]
//! A plan file of any bytes: refused with a place in it, or written back so that it is read the same, and checked.

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
    // NaN equals nothing, so that the texts are compared.
    assert_eq!(again.to_json(), json);
    let report = check(&first, &Preflight::at(JointAngles::HOME, ToolBias::NONE));
    assert_eq!(report.steps, first.steps.len());
});
