//! Traces of pen and laser: the pen draws where its tip is at the paper, the laser burns wherever
//! it is on.
//!
//! Paths are flattened to polylines by bisection: a stretch is halved until it deviates from its
//! chord by no more than `FLATNESS`. Power changes of the laser arrive while a path is under way
//! and are applied when the path is drawn.

use std::time::Duration;

use super::drawing::{Drawing, StrokeKind};
use super::samples::{SampleTimes, first};
use super::{ObjectPose, TimedPath};
use crate::scenario::{Scenario, ToolKind};
use crate::{ArmInstant, Micros};

/// Largest deviation of the polyline from the path, mm. Well below the width of a pen stroke.
const FLATNESS: f64 = 0.02;
/// Height above the paper at which the pen draws, mm. Nib and paper yield, and an arm that brakes
/// joint by joint rises above its line by less than this.
const AT_PAPER: f64 = 0.02;
/// Distance up to which a new stretch continues the previous stroke, mm.
const JOINED: f64 = 1e-3;
/// Points at which a stretch is compared with its chord, as shares of its time. Their ratios are
/// not simple, so a tool that circles is not sampled at the same position each time.
const CHECKS: [f64; 5] = [0.2137, 0.3791, 0.5, 0.6173, 0.7919];
/// Most halvings of one stretch: down to a millionth of its time.
const HALVINGS: u32 = 20;

/// State of pen and laser.
#[derive(Clone, Debug, Default)]
pub(super) struct Ink {
    drawing: Drawing,
    /// Instant up to which the drawing is complete.
    until: ArmInstant,
    /// Laser power at `until`, percent.
    power: f64,
    /// Changes of power during the running path, applied when the path is drawn.
    powers: Vec<(ArmInstant, f64)>,
    /// Kind and power with which the last stroke may continue.
    open: Option<(StrokeKind, f64)>,
}

impl Ink {
    pub(super) fn drawing(&self) -> &Drawing {
        &self.drawing
    }

    pub(super) fn into_drawing(self) -> Drawing {
        self.drawing
    }

    /// Drops the drawing; a line in progress starts anew.
    pub(super) fn clear(&mut self) {
        self.drawing = Drawing::default();
        self.open = None;
    }

    /// Sets the laser power from now on. `resting` is the position of an arm that does not move.
    pub(super) fn power(&mut self, now: ArmInstant, power: f64, resting: Option<[f64; 2]>) {
        // False for NaN: no power, no burn.
        let power = if power > 0.0 { power.min(100.0) } else { 0.0 };
        let Some(at) = resting else {
            self.powers.push((now, power));
            return;
        };
        // A laser that was on at rest has burnt a dot.
        if self.power > 0.0 && now > self.until {
            self.start(StrokeKind::Burn, self.power, at);
        }
        self.power = power;
        self.until = self.until.max(now);
    }

    /// Draws the remaining part of a path.
    pub(super) fn follow(
        &mut self,
        scenario: &Scenario,
        path: &TimedPath<'_>,
        tip: impl Fn(ArmInstant) -> ObjectPose,
    ) {
        // A replanned path may begin before the end of what is drawn.
        let from = path.from.max(self.until);
        if from > path.to {
            return;
        }
        match scenario.tool().kind {
            ToolKind::Pen => self.write(scenario, from, path.to, &tip),
            ToolKind::Laser => self.burn(from, path.to, &tip),
            ToolKind::None | ToolKind::Suction | ToolKind::Gripper => return,
        }
        self.until = path.to;
    }

    fn write(
        &mut self,
        scenario: &Scenario,
        from: ArmInstant,
        to: ArmInstant,
        tip: &impl Fn(ArmInstant) -> ObjectPose,
    ) {
        // Without a table there is no paper.
        let Some(paper) = scenario.table() else {
            return;
        };
        let sheet = paper.footprint();
        let writes = |at| {
            let tip = tip(at);
            tip.z <= paper.height + AT_PAPER && sheet.contains(tip.xy())
        };
        let samples = SampleTimes::along(from, to, tip);
        let mut since = writes(from).then_some(from);
        let mut last = from;
        for nth in 1..=samples.count {
            let next = samples.at(nth);
            match (since, writes(next)) {
                (None, true) => since = Some(first(last, next, writes)),
                (Some(start), false) => {
                    let lifts = first(last, next, |at| !writes(at));
                    self.stretch(
                        StrokeKind::Ink,
                        100.0,
                        start,
                        // The pen is on the paper until the microsecond before it lifts.
                        start.max(lifts - Duration::from_micros(1)),
                        tip,
                    );
                    (since, self.open) = (None, None);
                }
                _ => {}
            }
            last = next;
        }
        match since {
            Some(start) => self.stretch(StrokeKind::Ink, 100.0, start, to, tip),
            None => self.open = None,
        }
    }

    fn burn(&mut self, from: ArmInstant, to: ArmInstant, tip: &impl Fn(ArmInstant) -> ObjectPose) {
        let mut start = from;
        let mut later = std::mem::take(&mut self.powers);
        // Power changes after the end of this path belong to the next one.
        later.retain(|(at, power)| {
            if *at > to {
                return true;
            }
            let end = (*at).max(start);
            self.burn_stretch(start, end, tip);
            (self.power, start) = (*power, end);
            false
        });
        self.powers = later;
        self.burn_stretch(start, to, tip);
    }

    fn burn_stretch(
        &mut self,
        from: ArmInstant,
        to: ArmInstant,
        tip: &impl Fn(ArmInstant) -> ObjectPose,
    ) {
        if from >= to {
            return;
        }
        if self.power > 0.0 {
            self.stretch(StrokeKind::Burn, self.power, from, to, tip);
        } else {
            self.open = None;
        }
    }

    /// Draws a stroke along the path, or extends the last one.
    fn stretch(
        &mut self,
        kind: StrokeKind,
        power: f64,
        from: ArmInstant,
        to: ArmInstant,
        tip: &impl Fn(ArmInstant) -> ObjectPose,
    ) {
        let start = (from, tip(from).xy());
        self.start(kind, power, start.1);
        if from < to {
            self.flatten(start, (to, tip(to).xy()), tip, HALVINGS);
        }
    }

    fn start(&mut self, kind: StrokeKind, power: f64, at: [f64; 2]) {
        let goes_on = self.open == Some((kind, power))
            && self
                .drawing
                .last()
                .is_some_and(|last| distance(last, at) <= JOINED);
        if !goes_on {
            self.drawing.begin(kind, power, at);
        }
        self.open = Some((kind, power));
    }

    /// Flattens a stretch to a polyline.
    fn flatten(
        &mut self,
        from: (ArmInstant, [f64; 2]),
        to: (ArmInstant, [f64; 2]),
        tip: &impl Fn(ArmInstant) -> ObjectPose,
        halvings: u32,
    ) {
        let span = to.0.micros_since(from.0);
        let strays = |share: &f64| {
            let at = from.0.after_micros((span as f64 * share) as Micros);
            off_chord(tip(at).xy(), from.1, to.1) > FLATNESS
        };
        // Below two microseconds there is nothing left to halve.
        if halvings == 0 || span < 2 || !CHECKS.iter().any(strays) {
            self.drawing.line_to(to.1);
            return;
        }
        let middle = from.0.after_micros(span / 2);
        let middle = (middle, tip(middle).xy());
        self.flatten(from, middle, tip, halvings - 1);
        self.flatten(middle, to, tip, halvings - 1);
    }
}

fn distance(one: [f64; 2], other: [f64; 2]) -> f64 {
    let [x, y] = [other[0] - one[0], other[1] - one[1]];
    libm::sqrt(x * x + y * y)
}

/// Distance of a point from a line segment.
fn off_chord(point: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    let chord = [to[0] - from[0], to[1] - from[1]];
    let way = [point[0] - from[0], point[1] - from[1]];
    let square = chord[0] * chord[0] + chord[1] * chord[1];
    let along = way[0] * chord[0] + way[1] * chord[1];
    let share = if square > 0.0 {
        (along / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let nearest = [from[0] + chord[0] * share, from[1] + chord[1] * share];
    distance(point, nearest)
}
