//! Joining of lines that meet. Drawing programs store an outline as many lines and arcs, and a pen
//! would be lifted after each.

use std::collections::HashMap;

use crate::Stroke;
use crate::artwork::Style;

/// Grid of end points, mm: ends in the same cell meet. It absorbs the rounding of coordinates in
/// the file.
const END_GRID: f64 = 1e-4;

/// End of a line: twice its index, plus 1 for its last point.
type End = usize;

/// Joins lines of the same layer and colour where exactly two ends meet.
///
/// At a junction of three the file does not say which lines belong together. A joined line takes
/// the position and origin of its first part.
pub(super) fn joined(strokes: Vec<Stroke>) -> Vec<Stroke> {
    let partners = partners(&strokes);
    let mut slots: Vec<Option<Stroke>> = strokes.into_iter().map(Some).collect();
    let mut joined = Vec::with_capacity(slots.len());
    for nth in 0..slots.len() {
        let Some(first) = slots.get(nth).and_then(Option::as_ref) else {
            continue;
        };
        let (origin, style) = (first.origin, first.style);
        let mut points = Vec::new();
        let mut next = Some(first_end(&partners, nth));
        while let Some(end) = next {
            let Some(mut stroke) = slots.get_mut(end / 2).and_then(Option::take) else {
                break;
            };
            if end % 2 == 1 {
                stroke.points.reverse();
            }
            points.extend(
                stroke
                    .points
                    .into_iter()
                    .skip(usize::from(!points.is_empty())),
            );
            next = partner(&partners, end ^ 1);
        }
        // A chain that returns to its start is closed, whatever gap remains.
        if let (Some(_), [first, .., last]) = (next, points.as_mut_slice()) {
            *last = *first;
        }
        joined.push(Stroke {
            points,
            origin,
            style,
        });
    }
    joined
}

/// Returns the end at which the chain of a line begins; for a closed chain the line's own
/// beginning.
fn first_end(partners: &[Option<End>], nth: usize) -> End {
    let mut end = 2 * nth;
    while let Some(before) = partner(partners, end) {
        end = before ^ 1;
        if end / 2 == nth {
            return 2 * nth;
        }
    }
    end
}

fn partner(partners: &[Option<End>], end: End) -> Option<End> {
    partners.get(end).copied().flatten()
}

/// Returns for each end the end that it meets.
fn partners(strokes: &[Stroke]) -> Vec<Option<End>> {
    let mut meetings: HashMap<(Style, [i64; 2]), Vec<End>> = HashMap::new();
    for (nth, stroke) in strokes.iter().enumerate() {
        let ([first, .., last], false) = (stroke.points.as_slice(), stroke.is_closed()) else {
            continue;
        };
        for (end, point) in [(2 * nth, first), (2 * nth + 1, last)] {
            let cell = point.map(|value| (value / END_GRID).round() as i64);
            let ends = meetings.entry((stroke.style, cell)).or_default();
            ends.push(end);
        }
    }
    let mut partners = vec![None; 2 * strokes.len()];
    for ends in meetings.into_values() {
        if let [one, other] = ends.as_slice()
            && one / 2 != other / 2
        {
            partners[*one] = Some(*other);
            partners[*other] = Some(*one);
        }
    }
    partners
}
