//! Functions that read, check, preview and rehearse a plan.

use std::cell::RefCell;

use magician_host::preflight::Preflight;
use magician_host::{JointAngles, ToolBias};
use magician_picture::{DrawingOptions, Preview, PreviewOptions, drawing_svg};
use magician_program::rehearse::{RehearseOptions, rehearse};
use magician_program::{Diagnostic, Format, Plan, Program, ReadOptions, Setup, check, read};

thread_local! {
    static PLAN: RefCell<Plan> = RefCell::new(Plan::new(""));
}

fn preflight_at_home() -> Preflight {
    Preflight::at(JointAngles::HOME, ToolBias::SUCTION)
}

/// Reads the given file. Returns 0, with the plan file as output; 1 if its format is unknown; or 2,
/// with the error as output.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn plan() -> u32 {
    let bytes = crate::take_input();
    let Some(format) = Format::of("", &bytes) else {
        return 1;
    };
    let read_plan = || -> Result<Plan, Diagnostic> {
        let reading = read(format, &bytes, &ReadOptions::default())?;
        Ok(Setup::default().plan(format, reading.content)?.plan)
    };
    match read_plan() {
        Ok(plan) => {
            crate::set_output(plan.to_json().as_bytes());
            PLAN.set(plan);
            0
        }
        Err(problem) => {
            crate::set_output(problem.to_string().as_bytes());
            2
        }
    }
}

/// Checks the plan and returns its estimated time, s; infinite if unknown.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn estimate() -> f64 {
    let time = PLAN.with_borrow(|plan| check(plan, &preflight_at_home()).time);
    time.map_or(f64::INFINITY, |time| time.as_secs_f64())
}

/// Returns the number of commands that resume the plan at a step; -1 if it cannot be resumed there.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn resume(step: u64) -> i64 {
    let program = PLAN.with_borrow(|plan| Program::new(plan.clone(), None));
    let rest = program.remaining(step, preflight_at_home());
    rest.map_or(-1, |rest| rest.commands().count() as i64)
}

/// Draws the plan as SVG.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn preview() {
    crate::set_output(plan_preview().to_svg().as_bytes());
}

fn plan_preview() -> Preview {
    PLAN.with_borrow(|plan| {
        let report = check(plan, &preflight_at_home());
        Preview::new(
            plan,
            &report,
            &preflight_at_home(),
            &PreviewOptions::default(),
        )
    })
}

/// Draws the plan as PNG.
#[cfg(feature = "picture")]
#[unsafe(no_mangle)]
pub(crate) extern "C" fn picture(pixels_per_mm: f64) {
    crate::set_output(&plan_preview().to_png(pixels_per_mm).unwrap_or_default());
}

/// Rehearses the plan on a virtual arm. Returns the number of completed steps, with the drawing as
/// SVG output; -1 if the rehearsal fails.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn rehearsal() -> i64 {
    let done = PLAN.with_borrow(|plan| rehearse(plan, &RehearseOptions::default()));
    done.map_or(-1, |done| {
        let svg = drawing_svg(&done.drawing, &DrawingOptions::default());
        crate::set_output(svg.as_bytes());
        done.steps as i64
    })
}
