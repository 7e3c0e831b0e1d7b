//! Lines that a program in its own coordinates draws or burns.

use magician_host::message;
use magician_host::{Setting, SettingValue};

use crate::artwork::{circle_through, distance};
use crate::{Action, Artwork, Diagnostic, Plan, Stroke};

/// Height above the touching Z up to which a pen draws, mm.
pub(super) const TOUCH_HEIGHT: f64 = 0.5;
/// Largest horizontal distance that counts as no motion, mm.
const MOTION_TOLERANCE: f64 = 1e-4;
/// Turn of the pieces of an approximated arc, deg.
const ARC_PIECE_ANGLE: f64 = 3.0;

/// Drawn lines of a program, and their Z.
pub(crate) struct WorkLines {
    /// Lines, as on a sheet.
    pub(crate) artwork: Artwork,
    /// Z at which the tool touches.
    pub(crate) touch: f64,
}

impl WorkLines {
    pub(crate) fn of(plan: &Plan, pen_z: Option<f64>) -> Result<Self, Diagnostic> {
        let laser = plan.steps.iter().any(|step| step.action.is_of_a_laser());
        // Computed again for each use instead of stored: a drawing may have a million segments,
        // which take much more memory than its points.
        let working = || segments(plan).filter(|segment| !laser || segment.lit);
        let lowest = |across: bool| {
            let found = working().filter(|segment| !across || segment.moves_horizontally());
            found.map(|segment| segment.low()).reduce(f64::min)
        };
        let Some(lowest) = lowest(true).or(lowest(false)) else {
            let message = message!(
                "it draws and burns nothing: it has no size and no centre to be placed by"
            );
            return Err(Diagnostic::of_file(message)
                .remedy((Setting::Raw, SettingValue::On), "runs it as it stands"));
        };
        let touch = pen_z.unwrap_or(lowest);
        // If lines touch that Z only while descending, as in reliefs and arcs through Z, all of
        // them are the drawing.
        let slants = !laser && !working().any(|segment| segment.touches(touch));
        let mut strokes: Vec<Stroke> = Vec::new();
        let mut last = None;
        for segment in working() {
            let ends = [segment.from, segment.to];
            let touches = segment.touches(touch) || slants && segment.low() <= touch + TOUCH_HEIGHT;
            if !laser && !touches {
                continue;
            }
            let points = segment.points();
            match strokes.last_mut() {
                Some(stroke) if last == Some(ends[0]) => {
                    stroke.points.extend(points.into_iter().skip(1));
                }
                _ => strokes.push(Stroke::new(points, segment.origin)),
            }
            last = Some(ends[1]);
        }
        if strokes.is_empty() {
            let message = message!(
                "nothing is drawn at or below Z {touch}: the lowest drawn Z is {lowest}",
                touch,
                lowest
            );
            return Err(Diagnostic::of_file(message).remedy(
                (Setting::PenZ, SettingValue::Any("Z")),
                "sets the Z at which its pen touches",
            ));
        }
        let artwork = Artwork {
            title: plan.title.clone(),
            strokes,
            ..Artwork::default()
        };
        Ok(Self { artwork, touch })
    }
}

/// Motion of the tool at work.
pub(super) struct Segment {
    pub(super) from: [f64; 3],
    pub(super) via: Option<[f64; 3]>,
    pub(super) to: [f64; 3],
    lit: bool,
    origin: crate::Origin,
}

impl Segment {
    /// Motion of a step between two positions.
    pub(super) fn of(step: &crate::Step, from: [f64; 3], to: [f64; 3]) -> Self {
        let (via, lit) = match &step.action {
            Action::Arc {
                via: [x, y, z, _], ..
            } => (Some([*x, *y, *z].map(f64::from)), false),
            Action::Burn { power, .. } => (None, *power > 0.0),
            _ => (None, false),
        };
        Self {
            from,
            via,
            to,
            lit,
            origin: step.origin,
        }
    }

    pub(super) fn moves_horizontally(&self) -> bool {
        let [a, b] = [self.from, self.to].map(|[x, y, _]| [x, y]);
        self.via.is_some() || distance(a, b) > MOTION_TOLERANCE
    }

    pub(super) fn low(&self) -> f64 {
        self.from[2].min(self.to[2])
    }

    /// True if both ends of a line touch the surface, or the end of a vertical move does.
    fn touches(&self, touch: f64) -> bool {
        let touches = |z: f64| z <= touch + TOUCH_HEIGHT;
        touches(self.to[2]) && (touches(self.from[2]) || !self.moves_horizontally())
    }

    pub(super) fn points(&self) -> Vec<[f64; 2]> {
        let [from, to] = [self.from, self.to].map(|[x, y, _]| [x, y]);
        let Some([x, y, _]) = self.via else {
            return if self.moves_horizontally() {
                vec![from, to]
            } else {
                vec![to]
            };
        };
        arc_points(from, [x, y], to).unwrap_or_else(|| vec![from, [x, y], to])
    }
}

/// Points of the arc from `a` through `b` to `c`; `None` if they are on a line.
fn arc_points(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> Option<Vec<[f64; 2]>> {
    let (centre, sweep) = circle_through(a, b, c)?;
    let (start, radius) = (
        libm::atan2(a[1] - centre[1], a[0] - centre[0]),
        distance(a, centre),
    );
    let count = (sweep.abs() / ARC_PIECE_ANGLE).ceil().max(1.0);
    let point = |nth: u32| {
        let (sin, cos) = libm::sincos(start + sweep.to_radians() * f64::from(nth) / count);
        [centre[0] + radius * cos, centre[1] + radius * sin]
    };
    let between = (1..count as u32).map(point);
    Some([a].into_iter().chain(between).chain([c]).collect())
}

/// All motion of the tool at work, in order.
fn segments(plan: &Plan) -> impl Iterator<Item = Segment> + '_ {
    let mut at: Option<[f64; 3]> = None;
    plan.steps.iter().filter_map(move |step| {
        let to = step.action.target()?.map(f64::from);
        let from = at.replace(to).filter(|_| step.action.marks())?;
        Some(Segment::of(step, from, to))
    })
}
