//! Hatching: layers of parallel lines at different angles, each where the image is darker than its
//! level.

use magician_host::message;
use std::f64::consts::PI;

use super::Trace;
use super::shade::{Shade, check_bounds, stretch};
use crate::artwork::distance;
use crate::{Diagnostic, Stroke};

/// Angles of the layers, degrees counter-clockwise from x. Further layers repeat them between the
/// earlier lines.
const LAYER_ANGLES: [f64; 6] = [45.0, 135.0, 0.0, 90.0, 22.5, 112.5];
/// Sampling distance along a line, in pen widths.
const SAMPLE_STEP: f64 = 0.5;

/// Layer of hatching.
struct Hatching {
    /// Darkness above which the layer is drawn, 0 to 1.
    darker_than: f64,
    angle: f64,
    /// Distance of the lines, mm.
    spacing: f64,
    /// Offset of the first line, in line distances.
    shift: f64,
}

/// Layers from the lightest on. Each layer adds the same share of ink to the paper. Lines of
/// different layers cross, so a share of each layer lies on existing ink and the spacing allows for
/// that.
fn hatchings(trace: &Trace) -> Vec<Hatching> {
    let levels = trace.hatch_levels();
    let first = (trace.pen_width / trace.spacing()).min(1.0);
    let inked = |nth: u8| match (nth, levels) {
        (0, _) => 0.0,
        (1, _) | (_, 1) => first,
        (nth, levels) => first + (1.0 - first) * f64::from(nth - 1) / f64::from(levels - 1),
    };
    let hatching = |nth: u8| {
        let (below, above) = (inked(nth - 1), inked(nth));
        let share = 1.0 - (1.0 - above) / (1.0 - below).max(1e-9);
        let order = usize::from(nth - 1);
        Hatching {
            darker_than: f64::midpoint(below, above),
            angle: LAYER_ANGLES[order % LAYER_ANGLES.len()],
            spacing: trace.pen_width / share.clamp(1e-3, 1.0),
            shift: [0.5, 0.0, 0.25, 0.75][order / LAYER_ANGLES.len() % 4],
        }
    };
    (1..=levels).map(hatching).collect()
}

/// Returns the lines of all layers.
pub(super) fn strokes(shade: &Shade, trace: &Trace) -> Result<Vec<Stroke>, Diagnostic> {
    let [width, height] = shade.page();
    let mut strokes = Vec::new();
    let mut length = 0.0;
    for hatching in hatchings(trace) {
        length += width * height / hatching.spacing;
        check_bounds(message!("lines"), 0.0, length)?;
        let (sin, cos) = libm::sincos(hatching.angle.to_radians());
        // Along the lines and across them, with y down.
        let (along, across) = ([cos, -sin], [sin, cos]);
        let offsets = [[0.0, 0.0], [width, 0.0], [0.0, height], [width, height]]
            .map(|[x, y]| x * across[0] + y * across[1]);
        let least = offsets.into_iter().fold(f64::INFINITY, f64::min);
        let most = offsets.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let mut offset = least + hatching.shift * hatching.spacing;
        let mut back = false;
        while offset < most {
            let on = [across[0] * offset, across[1] * offset];
            if let Some(line) = within(on, along, [width, height]) {
                let before = strokes.len();
                for ends in stretches(shade, line, hatching.darker_than, trace.pen_width) {
                    let mut ends = stretch(line, ends);
                    if back {
                        ends.reverse();
                    }
                    strokes.push(shade.stroke(&ends));
                }
                if back {
                    strokes[before..].reverse();
                }
                back = !back;
            }
            check_bounds(message!("lines"), strokes.len() as f64, length)?;
            offset += hatching.spacing;
        }
    }
    Ok(strokes)
}

/// Part of an infinite line within the page.
fn within(on: [f64; 2], along: [f64; 2], page: [f64; 2]) -> Option<[[f64; 2]; 2]> {
    let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in [0, 1] {
        if along[axis].abs() < 1e-12 {
            if !(0.0..=page[axis]).contains(&on[axis]) {
                return None;
            }
            continue;
        }
        let ends = [0.0, page[axis]].map(|edge| (edge - on[axis]) / along[axis]);
        from = from.max(ends[0].min(ends[1]));
        to = to.min(ends[0].max(ends[1]));
    }
    let at = |way: f64| [0, 1].map(|axis| on[axis] + along[axis] * way);
    (from < to && from.is_finite() && to.is_finite()).then(|| [at(from), at(to)])
}

/// Stretches of a line on which the image is darker than a level. They are shortened so that a
/// stretch with the pen's round caps inks as much as one with square ends at the edge.
fn stretches(shade: &Shade, line: [[f64; 2]; 2], level: f64, pen_width: f64) -> Vec<[f64; 2]> {
    let length = distance(line[0], line[1]);
    let count = (length / (SAMPLE_STEP * pen_width)).ceil().max(1.0) as usize;
    let step = length / count as f64;
    let darkness = |nth: usize| {
        let [at, _] = stretch(line, [nth as f64 * step; 2]);
        shade.around(at, [pen_width; 2])
    };
    let mut found: Vec<[f64; 2]> = Vec::new();
    let mut last = darkness(0);
    let mut begun = (last > level).then_some(0.0);
    for nth in 1..=count {
        let dark = darkness(nth);
        if (dark > level) != (last > level) {
            let share = (level - last) / (dark - last);
            let at = ((nth - 1) as f64 + share) * step;
            match begun.take() {
                Some(from) => found.push([from, at]),
                None => begun = Some(at),
            }
        }
        last = dark;
    }
    found.extend(begun.map(|from| [from, length]));
    let cap = PI / 8.0 * pen_width;
    found
        .into_iter()
        .filter_map(|[from, to]| match to - from {
            long if long > 2.0 * cap => Some([from + cap, to - cap]),
            // A dot inks as much as a stretch of two caps.
            short if short > cap => Some([f64::midpoint(from, to); 2]),
            _ => None,
        })
        .collect()
}
