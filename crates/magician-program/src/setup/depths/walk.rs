//! Motion of a program, as seen by a pen that draws at or below a threshold Z.

use super::HEIGHT_TOLERANCE;
use crate::artwork::distance;
use crate::setup::work_lines::Segment;
use crate::{Action, Origin, Plan, Step};

/// Motion of a program, or a part of one.
pub(super) enum Event<'a> {
    /// Step without motion.
    Other(&'a Step),
    /// Rapid move.
    Travel { step: &'a Step, to: [f64; 3] },
    /// Feed move above the threshold, with its length.
    Air(f64),
    /// Drawn line.
    Line {
        from: [f64; 2],
        to: [f64; 2],
        /// Lowest Z.
        low: f64,
        /// Highest Z.
        high: f64,
        origin: Origin,
    },
    /// Drawn arc.
    Arc {
        from: [f64; 2],
        via: [f64; 2],
        to: [f64; 2],
        low: f64,
        /// Length, mm.
        length: f64,
        step: &'a Step,
    },
    /// The tool leaves a hole from which it drew no line.
    Dot {
        at: [f64; 2],
        low: f64,
        origin: Origin,
    },
}

fn flat([x, y, _]: [f64; 3]) -> [f64; 2] {
    [x, y]
}

/// Follows a program and reports its motion. Feed moves at or below the threshold draw.
pub(super) fn walk<'a>(plan: &'a Plan, threshold: f64, mut report: impl FnMut(Event<'a>)) {
    let mut at: Option<[f64; 3]> = None;
    // Current hole: position, depth, and the step that began it.
    let mut hole: Option<([f64; 2], f64, Origin)> = None;
    // End of the last line, until the tool leaves that position.
    let mut inked: Option<[f64; 2]> = None;
    for step in &plan.steps {
        let Some(to) = step.action.target().map(|to| to.map(f64::from)) else {
            report(Event::Other(step));
            continue;
        };
        let from = at.replace(to);
        let mut left = |report: &mut dyn FnMut(Event<'a>)| {
            if let Some((at, low, origin)) = hole.take() {
                report(Event::Dot { at, low, origin });
            }
        };
        let (true, Some(from)) = (step.action.marks(), from) else {
            left(&mut report);
            inked = None;
            report(Event::Travel { step, to });
            continue;
        };
        let way = Segment::of(step, from, to);
        if !way.moves_horizontally() {
            if to[2] > threshold {
                left(&mut report);
                inked = None;
                report(Event::Air(0.0));
            } else if inked != Some(flat(to)) {
                let (low, origin) = match hole {
                    Some((_, low, origin)) => (low.min(way.low()), origin),
                    None => (way.low(), step.origin),
                };
                hole = Some((flat(to), low, origin));
            }
            continue;
        }
        let [above, below] = [from[2] > threshold, to[2] > threshold];
        if above && below {
            left(&mut report);
            inked = None;
            report(Event::Air(segment_length(&way)));
            continue;
        }
        if let Action::Arc { via, .. } = step.action {
            hole = None;
            let [x, y, _, _] = via.map(f64::from);
            report(Event::Arc {
                from: flat(from),
                via: [x, y],
                to: flat(to),
                low: way.low(),
                length: segment_length(&way),
                step,
            });
            inked = Some(flat(to));
            continue;
        }
        // A line begins or ends where it crosses the threshold.
        let crossing = (above != below).then(|| {
            let share = (threshold - from[2]) / (to[2] - from[2]);
            [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
        });
        let (begin, end) = match crossing {
            Some(crossing) if above => (crossing, flat(to)),
            Some(crossing) => (flat(from), crossing),
            None => (flat(from), flat(to)),
        };
        if above {
            left(&mut report);
            report(Event::Air(distance(flat(from), begin)));
        }
        hole = None;
        report(Event::Line {
            from: begin,
            to: end,
            low: way.low(),
            high: from[2].max(to[2]).min(threshold),
            origin: step.origin,
        });
        inked = Some(end);
        if below {
            inked = None;
            report(Event::Air(distance(end, flat(to))));
        }
    }
    if let Some((at, low, origin)) = hole {
        report(Event::Dot { at, low, origin });
    }
}

fn segment_length(way: &Segment) -> f64 {
    if way.via.is_none() {
        return distance(flat(way.from), flat(way.to));
    }
    let points = way.points();
    let pairs = points.windows(2);
    pairs.map(|pair| distance(pair[0], pair[1])).sum()
}

/// True if two positions are equal for a pen.
pub(super) fn coincides(one: [f64; 2], other: [f64; 2]) -> bool {
    distance(one, other) <= HEIGHT_TOLERANCE
}
