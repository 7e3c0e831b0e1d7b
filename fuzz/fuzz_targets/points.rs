#![no_main]
//! List of points of arbitrary bytes: refused with a place in the file, or steps of finite numbers
//! with their origin.

use libfuzzer_sys::fuzz_target;
use magician_formats::{Content, Format, ReadOptions, read};

fuzz_target!(|bytes: &[u8]| {
    let lines = bytes.iter().filter(|byte| **byte == b'\n').count() + 1;
    match read(Format::Points, bytes, &ReadOptions::default()) {
        Ok(reading) => {
            let Content::Plan(plan) = reading.content else {
                panic!("points are a plan");
            };
            assert!(!plan.steps.is_empty());
            for step in &plan.steps {
                assert!(step.origin.is_known() && step.origin.line as usize <= lines);
                assert!(step.action.target().into_iter().flatten().all(f32::is_finite));
            }
        }
        Err(problem) => {
            assert!(!problem.message.is_empty());
            assert!(problem.origin.line as usize <= lines);
        }
    }
});
