#![no_main]
//! G-code: no panic, refusals with a place, and accepted commands of finite numbers.

use libfuzzer_sys::fuzz_target;
use magician_formats::{Content, Format, Lines, ReadOptions, read};

fuzz_target!(|bytes: &[u8]| {
    match read(Format::Gcode, bytes, &ReadOptions::default()) {
        Ok(reading) => {
            let Content::Plan(plan) = reading.content else {
                panic!("G-code is a plan");
            };
            for target in plan.steps.iter().filter_map(|step| step.action.target()) {
                assert!(target.iter().all(|number| number.is_finite()), "{target:?}");
            }
        }
        Err(problem) => {
            assert!(!problem.message.is_empty());
            if let Ok(text) = std::str::from_utf8(bytes) {
                let text = text.strip_prefix('\u{feff}').unwrap_or(text);
                let known = problem.origin.is_known();
                assert!(!known || Lines::new(text).range(&problem.origin).is_some());
            }
        }
    }
});
