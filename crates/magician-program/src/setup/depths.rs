//! Depths of a cutting program, flattened so that a pen draws every line on the surface.
//!
//! A milling program cuts in several passes, each deeper than the last. A pen must draw each line
//! once, on the surface, and never go below it. The survey finds the Z below which feed moves cut,
//! `walk` splits the motion there, `covered` recognises lines that are cut again, and `flat` writes
//! the result.

mod covered;
mod flat;
mod walk;

use std::collections::BTreeMap;

use magician_host::message;
use magician_host::{Setting, SettingValue};

use super::work_lines::{Segment, TOUCH_HEIGHT};
use crate::artwork::distance;
use crate::{Diagnostic, DiagnosticCode, Plan};
use flat::Flattener;
use magician_formats::keywords::keywords;
use walk::{Event, walk};

/// Largest height difference that counts as equal, mm: programs have three or four decimals.
const HEIGHT_TOLERANCE: f64 = 1e-3;
/// Largest number of depths listed in a note; more are grouped into this many ranges.
const MAX_LISTED_DEPTHS: usize = 6;
/// Smallest share of level (horizontal) feed moves. A program with less is a relief: its depth
/// changes continuously.
const MIN_LEVEL_SHARE: f64 = 0.1;
/// Share of feed moves above the surface. A program with more is nearly all travel.
const TRAVEL_SHARE: f64 = 0.9;

/// Smallest length of repeated cuts (drawn once) that a note reports, mm.
const MIN_REPORTED_LENGTH: f64 = 1.0;

/// Treatment of depths below the first one at which a program draws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Depths {
    /// A pen draws all of them on the surface and never goes below it.
    #[default]
    Flatten,
    /// The tool follows them below the surface.
    Keep,
}

keywords! {
    Depths, "depths":
    Flatten = "flatten",
    Keep = "keep",
}

/// Survey of the feed moves of a program: which of them draw.
#[derive(Clone, Copy, Debug)]
pub(super) struct DepthSurvey {
    /// Z at or below which feed moves draw, mm.
    threshold: f64,
    /// Highest Z at which the program draws, or the given one; it is placed on the surface.
    pub(super) first: f64,
    /// Lowest Z at which the program draws.
    pub(super) deepest: f64,
    /// True if a single Z does not cover the drawing, or nearly all feed moves are travel.
    needs_flattening: bool,
}

impl DepthSurvey {
    /// Surveys a program. `None` if nothing is drawn.
    ///
    /// If a program moves above 0 and cuts below it, its zero is the surface of the work, and every
    /// feed move below 0 cuts. Otherwise 0 may be the bed or a machine position: then the highest
    /// level that the tool reaches from above is the first depth. Feed moves at travel height,
    /// which the tool reaches from below, draw nothing.
    pub(super) fn of(plan: &Plan, pen_z: Option<f64>) -> Option<Self> {
        let levels = Levels::of(plan);
        let lowest = levels.lowest?;
        let threshold = match pen_z {
            Some(z) => z + TOUCH_HEIGHT,
            None => levels.threshold(lowest),
        };
        let (mut first, mut deepest) = (f64::NEG_INFINITY, f64::INFINITY);
        let (mut drawn, mut air) = (0.0, 0.0);
        walk(plan, threshold, |event| match event {
            Event::Line { low, from, to, .. } => {
                (first, deepest) = (first.max(low), deepest.min(low));
                drawn += distance(from, to);
            }
            Event::Arc { low, .. } | Event::Dot { low, .. } => {
                (first, deepest) = (first.max(low), deepest.min(low));
            }
            Event::Air(length) => air += length,
            Event::Travel { .. } | Event::Other(_) => {}
        });
        if !first.is_finite() {
            return None;
        }
        let needs_flattening = match pen_z {
            Some(z) => deepest < z - HEIGHT_TOLERANCE,
            None => first > lowest + TOUCH_HEIGHT,
        };
        Some(Self {
            threshold,
            first: pen_z.unwrap_or(first),
            deepest,
            needs_flattening: needs_flattening || air > TRAVEL_SHARE * (air + drawn),
        })
    }
}

/// Heights at which a program feeds and travels.
#[derive(Default)]
struct Levels {
    /// Lowest Z of the horizontal feed moves; without any, of all feed moves.
    lowest: Option<f64>,
    /// Levels by height in thousandths of a millimetre.
    levels: BTreeMap<i64, Level>,
    /// Highest Z of all motion.
    highest: f64,
    /// Length of feed moves that change height, mm.
    slanted: f64,
}

/// Level motion at one height.
#[derive(Default)]
struct Level {
    /// Length of feed moves, mm.
    fed: f64,
    /// Length of rapid moves, mm.
    travelled: f64,
    /// Number of times that feed moves at this height began after a move straight down to it.
    from_above: u32,
    /// Number of times that feed moves at this height began after a move straight up to it.
    from_below: u32,
}

/// Direction from which the tool reached its height.
#[derive(Clone, Copy, PartialEq)]
enum Arrival {
    Down,
    Up,
    Unknown,
}

impl Levels {
    fn of(plan: &Plan) -> Self {
        let mut found = Self {
            highest: f64::NEG_INFINITY,
            ..Self::default()
        };
        let (mut lowest_horizontal, mut lowest_any) = (None::<f64>, None::<f64>);
        let least = |low: f64, known: Option<f64>| Some(known.map_or(low, |known| known.min(low)));
        let mut at: Option<[f64; 3]> = None;
        let mut arrival = Some(Arrival::Unknown);
        for step in &plan.steps {
            let Some(to) = step.action.target().map(|to| to.map(f64::from)) else {
                continue;
            };
            found.highest = found.highest.max(to[2]);
            let Some(from) = at.replace(to) else { continue };
            let segment = Segment::of(step, from, to);
            let fed = step.action.marks();
            let rise = to[2] - from[2];
            if !segment.moves_horizontally() {
                if fed {
                    lowest_any = least(segment.low(), lowest_any);
                }
                if rise != 0.0 {
                    // A level run that the tool reached from an unknown side is travel if the tool
                    // then descends.
                    if arrival == Some(Arrival::Unknown)
                        && rise < 0.0
                        && let Some(level) = found.levels.get_mut(&thousandths(from[2]))
                    {
                        level.from_below += u32::from(level.fed > 0.0);
                    }
                    let direction = if rise > 0.0 {
                        Arrival::Up
                    } else {
                        Arrival::Down
                    };
                    arrival = Some(direction);
                }
                continue;
            }
            if fed {
                lowest_horizontal = least(segment.low(), lowest_horizontal);
            }
            let length = distance([from[0], from[1]], [to[0], to[1]]);
            if rise.abs() > HEIGHT_TOLERANCE {
                found.slanted += if fed { length } else { 0.0 };
                arrival = None;
                continue;
            }
            let level = found.levels.entry(thousandths(to[2])).or_default();
            if !fed {
                level.travelled += length;
                continue;
            }
            level.fed += length;
            match arrival {
                Some(Arrival::Down) => level.from_above += 1,
                Some(Arrival::Up) => level.from_below += 1,
                _ => continue,
            }
            arrival = None;
        }
        found.lowest = lowest_horizontal.or(lowest_any);
        found
    }

    /// Z at or below which feed moves draw.
    fn threshold(&self, lowest: f64) -> f64 {
        let near = lowest + TOUCH_HEIGHT;
        let all = self.levels.iter();
        let all = all.map(|(thousandths, level)| (*thousandths as f64 / 1000.0, level));
        let travel_height = { all.clone() }
            .filter(|(z, level)| *z > near && level.travelled > 0.0)
            .max_by(|(_, one), (_, other)| one.travelled.total_cmp(&other.travelled))
            .map(|(z, _)| z);
        let has_surface_at_0 = lowest < -HEIGHT_TOLERANCE && self.highest > HEIGHT_TOLERANCE;
        // The level with the longest rapid moves is the travel height, unless 0 already separates
        // cutting from travel.
        let below_travel = match travel_height {
            Some(z) if !has_surface_at_0 => z,
            _ => f64::INFINITY,
        };
        let mut ceiling = if has_surface_at_0 { 0.0 } else { below_travel };
        let top = ceiling;
        let is_candidate = |(z, _): &(f64, &Level)| {
            *z < below_travel - HEIGHT_TOLERANCE && *z <= top + HEIGHT_TOLERANCE && *z > near
        };
        let mut first = None;
        let fed = all.clone().rev().filter(|(_, level)| level.fed > 0.0);
        for (z, level) in fed.filter(is_candidate) {
            let cuts = if has_surface_at_0 && z < -HEIGHT_TOLERANCE {
                level.from_above >= level.from_below
            } else {
                level.from_above > level.from_below
            };
            if cuts {
                first = Some(z);
                break;
            }
            ceiling = ceiling.min(z);
        }
        let below = |level: f64| (level - 2.0 * HEIGHT_TOLERANCE).max(near);
        if has_surface_at_0 {
            let at_0 = first.filter(|z| *z >= -HEIGHT_TOLERANCE);
            return at_0.map_or(below(ceiling), |_| near.max(HEIGHT_TOLERANCE));
        }
        let level_length: f64 = { all.filter(|(z, _)| *z < ceiling) }
            .map(|(_, level)| level.fed)
            .sum();
        // A relief has almost no level feed moves, so none of its levels is the first depth.
        let is_relief = travel_height.is_some()
            && level_length < MIN_LEVEL_SHARE * (level_length + self.slanted);
        match first {
            _ if is_relief => below(ceiling),
            Some(first) => first + HEIGHT_TOLERANCE,
            None => near,
        }
    }
}

fn thousandths(z: f64) -> i64 {
    (z * 1000.0).round() as i64
}

/// Length drawn at each depth, mm at the scale of the file.
#[derive(Clone, Debug, Default)]
pub(super) struct DepthTally {
    /// Length of lines and arcs by depth in hundredths of a millimetre.
    lengths: BTreeMap<i64, f64>,
    dots: usize,
    /// Length of cuts repeated at a greater depth, drawn once.
    repeated: f64,
    /// Length of feed moves that draw nothing.
    air: f64,
    threshold: f64,
}

/// Flattened program.
pub(super) struct FlatProgram {
    pub(super) plan: Plan,
    /// Z of the whole drawing.
    pub(super) touch: f64,
    pub(super) tally: DepthTally,
}

impl FlatProgram {
    /// Flattens a program to its first depth, to be drawn at this scale. `None` if it has a single
    /// depth, which is placed on the surface unchanged.
    pub(super) fn of(plan: &Plan, pen_z: Option<f64>, lift: f64, scale: f64) -> Option<Self> {
        let survey = DepthSurvey::of(plan, pen_z).filter(|survey| survey.needs_flattening)?;
        let mut flattener = Flattener::new(plan, survey.first, lift, survey.threshold, scale);
        walk(plan, survey.threshold, |event| {
            flattener.handle_event(event)
        });
        let (plan, tally) = flattener.finish();
        Some(Self {
            plan,
            touch: survey.first,
            tally,
        })
    }
}

impl DepthTally {
    fn drawn(&self) -> f64 {
        self.lengths.values().sum()
    }

    /// Notes that list the drawn depths, at this scale.
    pub(super) fn notes(&self, scale: f64) -> Vec<Diagnostic> {
        let mut notes = Vec::new();
        let ends = self
            .lengths
            .keys()
            .next()
            .zip(self.lengths.keys().next_back());
        let range = ends.map_or(0.0, |(deepest, first)| (first - deepest) as f64 / 100.0);
        let repeated = self.repeated * scale;
        if range > TOUCH_HEIGHT || self.dots > 0 || repeated >= MIN_REPORTED_LENGTH {
            let mut what = format!(
                "the pen draws all depths on the surface: {}",
                self.listed(scale)
            );
            if repeated >= MIN_REPORTED_LENGTH {
                let repeated = length(repeated);
                what += &format!("; {repeated} that is cut again deeper is drawn once");
            }
            let note = Diagnostic::of_file(what).coded(DiagnosticCode::Assumed);
            let keep = (Setting::Depths, SettingValue::Word("keep"));
            notes.push(note.remedy(keep, "takes the pen below the surface"));
        }
        let fed = self.air + self.drawn();
        if self.air > TRAVEL_SHARE * fed {
            let [air, fed] = [self.air, fed].map(|mm| length(mm * scale));
            let what = message!(
                "nearly all of it is travel: {air} of {fed} that it feeds lie above Z{threshold}, where \
                 the pen draws nothing",
                air,
                fed,
                threshold = rounded(self.threshold)
            );
            let note = Diagnostic::of_file(what).coded(DiagnosticCode::Assumed);
            let pen_z = (Setting::PenZ, SettingValue::Any("Z"));
            notes.push(note.remedy(pen_z, "sets another Z for the touching pen"));
        }
        notes
    }

    /// Depths from the first on, with the length drawn at each.
    fn listed(&self, scale: f64) -> String {
        let at = |hundredths: i64| rounded(hundredths as f64 / 100.0);
        let mut listed: Vec<String> = Vec::new();
        let ends = self
            .lengths
            .keys()
            .next()
            .zip(self.lengths.keys().next_back());
        match ends {
            Some((deepest, first)) if self.lengths.len() > MAX_LISTED_DEPTHS => {
                let size = (first - deepest) / MAX_LISTED_DEPTHS as i64 + 1;
                let mut from = *first;
                while from >= *deepest {
                    let range = self.lengths.range(from - size + 1..=from);
                    let (least, sum) = range.fold((None, 0.0), |(least, sum), (z, mm)| {
                        (least.or(Some(*z)), sum + mm)
                    });
                    if let Some(least) = least {
                        let most = self.lengths.range(..=from).next_back();
                        let most = most.map_or(from, |(z, _)| *z);
                        let length_text = length(sum * scale);
                        listed.push(if least == most {
                            format!("{length_text} at Z{}", at(most))
                        } else {
                            format!("{length_text} at Z{} to Z{}", at(most), at(least))
                        });
                    }
                    from -= size;
                }
            }
            _ => {
                let all = self.lengths.iter().rev();
                listed.extend(all.map(|(z, mm)| format!("{} at Z{}", length(mm * scale), at(*z))));
            }
        }
        match self.dots {
            0 => {}
            1 => listed.push("1 dot".to_owned()),
            dots => listed.push(format!("{dots} dots")),
        }
        listed.join(", ")
    }
}

/// Returns the note that the tool goes below the surface on request. `None` for a single depth.
pub(super) fn kept_depths_note(survey: &DepthSurvey) -> Option<Diagnostic> {
    let deep = survey.first - survey.deepest;
    (deep > HEIGHT_TOLERANCE).then(|| {
        let what = message!(
            "the pen goes up to {deep:.1} mm below the surface, as was asked",
            deep
        );
        Diagnostic::of_file(what).coded(DiagnosticCode::Assumed)
    })
}

/// Length with its unit as shown in notes: `140 mm`, `2.81 m`.
fn length(mm: f64) -> String {
    match mm {
        mm if mm >= 1000.0 => format!("{:.2} m", mm / 1000.0),
        mm if mm >= 10.0 => format!("{mm:.0} mm"),
        mm => format!("{mm:.1} mm"),
    }
}

fn rounded(z: f64) -> f64 {
    (z * 100.0).round() / 100.0
}
