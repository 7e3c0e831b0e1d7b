//! Helpers that read G-code, for tests of this crate and of `magician-program`.

use magician_formats::formats::GcodeOptions;
use magician_formats::{
    Action, Content, Diagnostic, Format, Parsed, Plan, ReadOptions, Travel, read,
};

pub(crate) const PEN_SAMPLE: &str =
    include_str!("../../../../magician-program/samples/pen_outline.gcode");
pub(crate) const LASER_SAMPLE: &str =
    include_str!("../../../../magician-program/samples/laser_checker.gcode");

pub(crate) fn try_with(
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

pub(crate) fn try_read(text: &str) -> Result<(Plan, Vec<Diagnostic>), Diagnostic> {
    try_with(text, |_| {})
}

/// Returns the actions of a program that is accepted.
pub(crate) fn actions(text: &str) -> Vec<Action> {
    actions_with(text, |_| {})
}

pub(crate) fn actions_with(text: &str, set: impl FnOnce(&mut GcodeOptions)) -> Vec<Action> {
    let (plan, _) = try_with(text, set).unwrap_or_else(|diagnostic| panic!("{text}: {diagnostic}"));
    plan.steps.into_iter().map(|step| step.action).collect()
}

/// Returns the actions that are motions.
pub(crate) fn motions(text: &str) -> Vec<Action> {
    let all = actions(text).into_iter();
    all.filter(|action| action.target().is_some()).collect()
}

pub(crate) fn notes(text: &str) -> Vec<String> {
    let (_, notes) = try_read(text).unwrap_or_else(|diagnostic| panic!("{text}: {diagnostic}"));
    notes.iter().map(ToString::to_string).collect()
}

pub(crate) fn diagnostic(text: &str) -> String {
    match try_read(text) {
        Ok((plan, _)) => panic!("{text}: {plan:?}"),
        Err(diagnostic) => diagnostic.to_string(),
    }
}

pub(crate) fn travel(x: f32, y: f32, z: f32) -> Action {
    let (to, by) = ([x, y, z, 0.0], Travel::Line);
    Action::Move { to, by }
}

pub(crate) fn path(x: f32, y: f32, z: f32) -> Action {
    Action::Path { to: [x, y, z] }
}
