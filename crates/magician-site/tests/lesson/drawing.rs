//! Drawings of pupils: one stroke for each letter of their name.

use magician::build;
use magician_program::{Action, Origin, Plan, Surface, Tool, Travel};

pub(crate) const PAPER: f64 = -60.0;

/// Polylines on the paper.
pub(crate) type Strokes = Vec<Vec<[f64; 2]>>;

/// Returns one stroke for each letter of a text. Bits of its Unicode code point determine the
/// corners.
pub(crate) fn strokes(text: &str) -> Strokes {
    let letters = text.chars().enumerate();
    letters
        .map(|(at, letter)| {
            let left = -60.0 + 15.0 * at as f64;
            let corner = |turn: u32| {
                let bits = u32::from(letter).rotate_right(3 * turn) % 8;
                [205.0 + 4.0 * f64::from(bits), left + 4.0 * f64::from(turn)]
            };
            (0..4).map(corner).collect()
        })
        .collect()
}

/// Plan that draws the strokes.
pub(crate) fn plan(title: &str, strokes: &Strokes) -> String {
    let mut plan = Plan::new(title);
    plan.tool = Some(Tool::Pen);
    plan.surface = Some(Surface::level(PAPER));
    let paper = PAPER as f32;
    let mut push = |action: Action| plan.push(action, Origin::NONE);
    push(build::speed(8.0, 30.0).into());
    let line = |[x, y]: [f64; 2], z| Action::Move {
        to: [x as f32, y as f32, z, 0.0],
        by: Travel::Line,
    };
    for stroke in strokes {
        push(line(stroke[0], paper + 10.0));
        stroke.iter().for_each(|point| push(line(*point, paper)));
        push(line(stroke[stroke.len() - 1], paper + 10.0));
    }
    plan.to_json()
}

/// Returns the number, from 1, of the step of the plan that follows the corner at which the pen
/// stopped.
pub(crate) fn step_after(strokes: &Strokes, pen: [f64; 2]) -> usize {
    // Step 1 sets the speed. Each stroke begins above its first corner.
    let mut step = 1;
    for stroke in strokes {
        step += 1;
        for corner in stroke {
            step += 1;
            if distance(*corner, pen) < 0.3 {
                return step + 1;
            }
        }
        step += 1;
    }
    panic!("the pen stands at {pen:?}, at no corner");
}

/// Checks that the paper has the strokes of the plans, each exactly once and in order. A pause
/// lifts the pen, so a stroke may consist of pieces that continue each other.
pub(crate) fn check_strokes(
    paper: &[Vec<[f64; 2]>],
    plans: &[(Strokes, bool)],
) -> Result<(), String> {
    let mut on_paper = paper.iter().peekable();
    for (plan, interrupted) in plans {
        for stroke in plan {
            let (from, to, length) = (stroke[0], stroke[stroke.len() - 1], length(stroke));
            let mut drawn = 0.0;
            let mut pen = from;
            loop {
                let Some(piece) = on_paper.next() else {
                    return Err(format!("no stroke from {from:?} to {to:?}"));
                };
                if distance(piece[0], pen) > 0.3 {
                    return Err(format!("a stroke at {:?}, not at {pen:?}", piece[0]));
                }
                drawn += self::length(piece);
                pen = piece[piece.len() - 1];
                if distance(pen, to) < 0.3 && drawn > length - 0.5 {
                    break;
                }
            }
            // A pause at the very end of a stroke leaves the rest of it as a separate piece: a dot.
            while let Some(piece) =
                on_paper.next_if(|piece| self::length(piece) < 0.5 && distance(piece[0], to) < 0.5)
            {
                drawn += self::length(piece);
            }
            let tolerance = if *interrupted { 3.0 } else { 0.5 };
            if drawn > length + tolerance {
                return Err(format!("{drawn:.1} mm of {length:.1} mm from {from:?}"));
            }
        }
    }
    match on_paper.next() {
        Some(piece) => Err(format!("a stroke at {:?} of no plan", piece[0])),
        None => Ok(()),
    }
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

fn length(stroke: &[[f64; 2]]) -> f64 {
    stroke.windows(2).map(|two| distance(two[0], two[1])).sum()
}
