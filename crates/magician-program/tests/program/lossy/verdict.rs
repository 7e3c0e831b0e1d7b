//! Requirements on a drawing that came over a bad line.

use magician::ErrorKind;
use magician::sim::world::Drawing;
use magician::stream::LINE_TOLERANCE;
use magician_picture::compare::{compare, lines_of};
use magician_program::Plan;
use magician_program::rehearse::{RehearseOptions, rehearse};

use super::ink::{CORNER_ACCURACY, Ink};
use super::rig::{FaultSetup, Outcome};

/// Largest distance of matching lines in two pictures, mm: accuracy of drawings, and a pixel's
/// diagonal.
const MATCH_TOLERANCE: f64 = CORNER_ACCURACY + 0.071;

/// Largest deviation of a drawing, mm: above window 1 a line may skip a lost vertex on it.
fn tolerance_at(window: usize) -> f64 {
    match window {
        1 => CORNER_ACCURACY,
        _ => CORNER_ACCURACY + LINE_TOLERANCE,
    }
}

/// Result of a plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// Identical strokes.
    Same,
    /// Same lines, within the accuracy of a drawing.
    Equal,
    /// Stopped with a known place; complete after resuming there.
    Completed,
    /// Stopped with a range of steps: more than one may be done or not.
    Stopped,
}

/// Drawing of a plan on a good line: all of it, or its first steps.
pub(crate) fn drawn(plan: &Plan, steps: Option<u64>) -> Drawing {
    let mut plan = plan.clone();
    if let Some(steps) = steps {
        plan.steps
            .truncate(usize::try_from(steps).unwrap_or(usize::MAX));
    }
    let mut options = RehearseOptions::default();
    // Table and tool are those of the whole plan.
    options.tool = plan.tool;
    rehearse(&plan, &options)
        .map(|done| done.drawing)
        .unwrap_or_default()
}

/// Judges a drawing; the error says what is wrong.
pub(crate) fn judge(
    plan: &Plan,
    whole: &Drawing,
    trouble: FaultSetup,
    outcome: &Outcome,
) -> Result<Verdict, String> {
    let all = Ink::of(whole);
    let ink = Ink::of(&outcome.drawing);
    for part in &outcome.between {
        is_begun(&all, part, trouble).map_err(|why| format!("when interrupted: {why}"))?;
    }
    let Err(error) = &outcome.end else {
        return judge_success(&all, &ink, whole, outcome, trouble);
    };
    is_begun(&all, &outcome.drawing, trouble)?;
    let steps = outcome.steps.ok_or("nobody knows where it stopped")?;
    // A command corrupted by the line and refused by the arm counts as finished.
    let refused = error.kind() == ErrorKind::Alarm;
    let certain = steps.least.saturating_sub(refused.into());
    if trouble.window == 1 {
        let [least, most] =
            [certain, steps.most].map(|steps| Ink::of(&drawn(plan, Some(steps))).length());
        let found = ink.length();
        if found < least - CORNER_ACCURACY || found > most + CORNER_ACCURACY {
            return Err(format!(
                "{steps:?} leave {least:.3} to {most:.3} mm, and there are {found:.3} ({error})"
            ));
        }
    }
    let Some((step, rest)) = &outcome.rest else {
        return Ok(Verdict::Stopped);
    };
    let more = Ink::of(rest).length() - all.length();
    // The started part of the step may be drawn twice.
    let twice = step_length(plan, *step) + 2.0 * CORNER_ACCURACY;
    if more > twice || more < -CORNER_ACCURACY {
        return Err(format!(
            "gone on with from step {step}, {more:.3} mm are too much; of it {twice:.3} may be"
        ));
    }
    match compare(&lines_of(whole), &lines_of(rest), MATCH_TOLERANCE).matched {
        matched if matched.is_good() => Ok(Verdict::Completed),
        matched => Err(format!(
            "gone on with from step {step} it is another one: {matched:?}"
        )),
    }
}

/// Judges a run that reported success.
fn judge_success(
    all: &Ink,
    ink: &Ink,
    whole: &Drawing,
    outcome: &Outcome,
    trouble: FaultSetup,
) -> Result<Verdict, String> {
    if ink.equals(all) {
        return Ok(Verdict::Same);
    }
    let matched = compare(
        &lines_of(whole),
        &lines_of(&outcome.drawing),
        MATCH_TOLERANCE,
    )
    .matched;
    let more = ink.length() - all.length();
    let most = tolerance_at(trouble.window);
    let off = ink.distance_from_beginning_of(all).unwrap_or(f64::INFINITY);
    if matched.is_good() && more.abs() <= most && off <= most {
        Ok(Verdict::Equal)
    } else {
        Err(format!(
            "another drawing: {more:.3} mm more, {off:.3} mm off, {matched:?}"
        ))
    }
}

/// Checks that an unfinished drawing is the beginning of the whole.
fn is_begun(all: &Ink, part: &Drawing, trouble: FaultSetup) -> Result<(), String> {
    if part.is_empty() {
        return Ok(());
    }
    let ink = Ink::of(part);
    match ink.distance_from_beginning_of(all) {
        Some(off) if off <= tolerance_at(trouble.window) => Ok(()),
        off => Err(format!(
            "{:.3} mm are not how it begins: {off:?}",
            ink.length()
        )),
    }
}

/// Upper bound of the ink of a step, mm.
fn step_length(plan: &Plan, step: usize) -> f64 {
    let targets = plan.steps.iter().map(|step| step.action.target());
    let before = targets.clone().take(step).flatten().last();
    let arc = |step: &magician_program::Step| match step.action {
        magician_program::Action::Arc { via, .. } => Some([via[0], via[1], via[2]]),
        _ => None,
    };
    let [from, to] = [before, targets.clone().nth(step).flatten()];
    let (Some(from), Some(to)) = (from, to) else {
        return 0.0;
    };
    let apart = |a: [f32; 3], b: [f32; 3]| f64::from((a[0] - b[0]).hypot(a[1] - b[1]));
    match plan.steps.get(step).and_then(arc) {
        // An arc is shorter than the square around its circle.
        Some(via) => 4.0 * (apart(from, via) + apart(via, to)),
        None => apart(from, to),
    }
}
