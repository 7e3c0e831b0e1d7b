//! Reader of strokes as text: x,y,z on each line.

use std::ops::Range;

use magician_host::message;

use crate::formats::content::points::numbers;
use crate::{Action, Diagnostic, Lines, Parsed, Plan, Travel};

/// Height above its ends from which a stroke is approached and left, mm. A choice that clears usual
/// work.
const STROKE_LIFT: f32 = 10.0;

/// A vertex of a stroke, with its range in the text.
type Corner = ([f32; 3], Range<usize>);

/// Reads strokes, each a run of lines: a joint move above its start, down, along it, up.
pub(super) fn read(text: &str) -> Result<Parsed<Plan>, Diagnostic> {
    let places = Lines::new(text);
    let mut plan = Plan::default();
    let mut stroke: Vec<Corner> = Vec::new();
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        let start = at + line.len() - line.trim_start().len();
        let range = start..start.max(at + line.trim_end().len());
        at += line.len();
        let line = line.trim();
        if line.is_empty() {
            put(&mut plan, &places, &stroke);
            stroke.clear();
            continue;
        }
        let Some(corner) = numbers(line) else {
            let found: String = line.chars().take(30).collect();
            let message = message!(
                "a line of strokes must be x,y,z in mm, and this is '{found}'",
                found
            );
            let diagnostic = Diagnostic::new(places.origin(range), message);
            return Err(diagnostic.help(message!("separate two strokes by an empty line")));
        };
        stroke.push((corner, range));
    }
    put(&mut plan, &places, &stroke);
    let what = message!(
        "the coordinates are read as the arm's; the pen is lifted by 10 mm between strokes"
    );
    Ok(Parsed {
        content: plan,
        notes: vec![Diagnostic::of_file(what)],
    })
}

fn put(plan: &mut Plan, places: &Lines<'_>, stroke: &[Corner]) {
    let (Some((first, begin)), Some((last, end))) = (stroke.first(), stroke.last()) else {
        return;
    };
    let above = |[x, y, z]: [f32; 3]| [x, y, z + STROKE_LIFT, 0.0];
    let [begin, end] = [begin, end].map(|range| places.origin(range.clone()));
    let [x, y, z] = *first;
    let go = |to, by| Action::Move { to, by };
    plan.push(go(above(*first), Travel::Joints), begin);
    plan.push(go([x, y, z, 0.0], Travel::Line), begin);
    for pair in stroke.windows(2) {
        let [(before, _), (to, range)] = pair else {
            continue;
        };
        if before != to {
            plan.push(Action::Path { to: *to }, places.origin(range.clone()));
        }
    }
    plan.push(go(above(*last), Travel::Line), end);
}
