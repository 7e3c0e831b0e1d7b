//! G-code: what becomes of it, and what it leaves on the paper.

mod arcs;
mod begin;
mod cycles;
mod depths;
mod drawn;
mod full_power;
mod interpreter;
mod power;
mod refused;
mod samples;
mod servo;
mod words;

use magician_program::formats::GcodeOptions;
use magician_program::{
    Action, Content, Diagnostic, Format, Parsed, Plan, ReadOptions, Travel, read,
};

const PEN: &str = include_str!("../../samples/pen_outline.gcode");
const LASER: &str = include_str!("../../samples/laser_checker.gcode");

fn try_with(
    text: &str,
    set: impl FnOnce(&mut GcodeOptions),
) -> Result<(Plan, Vec<Diagnostic>), Diagnostic> {
    let mut options = ReadOptions::default();
    set(&mut options.gcode);
    let Parsed { content, notes, .. } = read(Format::Gcode, text.as_bytes(), &options)?;
    match content {
        Content::Plan(plan) => Ok((plan, notes)),
        other => panic!("{other:?}"),
    }
}

fn try_read(text: &str) -> Result<(Plan, Vec<Diagnostic>), Diagnostic> {
    try_with(text, |_| {})
}

/// The steps of a program that is all right.
fn actions(text: &str) -> Vec<Action> {
    actions_with(text, |_| {})
}

fn actions_with(text: &str, set: impl FnOnce(&mut GcodeOptions)) -> Vec<Action> {
    let (plan, _) = try_with(text, set).unwrap_or_else(|diagnostic| panic!("{text}: {diagnostic}"));
    plan.steps.into_iter().map(|step| step.action).collect()
}

/// The steps that are motions.
fn motions(text: &str) -> Vec<Action> {
    let all = actions(text).into_iter();
    all.filter(|action| action.target().is_some()).collect()
}

fn notes(text: &str) -> Vec<String> {
    let (_, notes) = try_read(text).unwrap_or_else(|diagnostic| panic!("{text}: {diagnostic}"));
    notes.iter().map(ToString::to_string).collect()
}

fn diagnostic(text: &str) -> String {
    match try_read(text) {
        Ok((plan, _)) => panic!("{text}: {plan:?}"),
        Err(diagnostic) => diagnostic.to_string(),
    }
}

fn travel(x: f32, y: f32, z: f32) -> Action {
    let (to, by) = ([x, y, z, 0.0], Travel::Line);
    Action::Move { to, by }
}

fn path(x: f32, y: f32, z: f32) -> Action {
    Action::Path { to: [x, y, z] }
}

fn burn(x: f32, y: f32, z: f32, power: f32) -> Action {
    let to = [x, y, z];
    Action::Burn { to, power }
}

fn arc(via: [f32; 3], to: [f32; 3]) -> Action {
    let pose = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
    let (via, to) = (pose(via), pose(to));
    Action::Arc { via, to }
}
