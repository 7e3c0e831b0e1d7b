//! Rows of taught points, and the plan made from them.

use std::collections::BTreeSet;

use magician_host::{Message, Setting, SettingValue, message};

use super::recording::Sample;
use crate::formats::content::points::{Field, number};
use crate::formats::rail::RailCourse;
use crate::{Action, Diagnostic, DiagnosticCode, Grip, Origin, Parsed, Plan, Tool, Travel};

/// Longest pause, s: about four weeks. A longer one is a mistake.
const MAX_PAUSE: f32 = 2_500_000.0;

/// Motion style.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Style {
    #[default]
    Joints,
    Line,
    Jump,
    Arc,
    /// Part of a continuous path.
    Path,
}

/// A parsed row.
#[derive(Clone, Debug, Default)]
pub(super) struct Row {
    place: [Option<f32>; 4],
    end: [Option<f32>; 4],
    /// Motion style as text, with its place. It is ignored in a row without a position.
    style: Option<(String, Origin)>,
    name: String,
    pause: u32,
    gripper: Option<Grip>,
    suction: Option<bool>,
    t: Option<f64>,
    j4: Option<f64>,
    /// Position of the rail's carriage, mm.
    rail: Option<f32>,
    /// Place of the whole row.
    origin: Origin,
}

impl Row {
    /// Creates an empty row.
    pub(super) fn at(origin: Origin) -> Self {
        Self {
            origin,
            ..Self::default()
        }
    }

    /// Adds the value of a column. Empty values are ignored.
    pub(super) fn take(
        &mut self,
        field: Field,
        text: &str,
        origin: Origin,
    ) -> Result<(), Diagnostic> {
        let text = text.trim();
        if text.is_empty() {
            return Ok(());
        }
        let number = |what: fn() -> Message| {
            number(text).ok_or_else(|| super::no_number(origin, what(), text))
        };
        match field {
            Field::Place(axis) => {
                let value = number(|| message!("a coordinate"))?;
                if let Some(place) = self.place.get_mut(axis) {
                    *place = Some(value);
                }
            }
            Field::End(axis) => {
                let value = number(|| message!("a coordinate"))?;
                if let Some(end) = self.end.get_mut(axis) {
                    *end = Some(value);
                }
            }
            Field::Style => self.style = Some((text.to_owned(), origin)),
            Field::Name => self.name = text.to_owned(),
            Field::Pause => {
                let seconds = number(|| message!("a pause"))?;
                if !(0.0..=MAX_PAUSE).contains(&seconds) {
                    let message = message!(
                        "a pause must be 0 to {most} s, and this is {seconds}",
                        most = MAX_PAUSE,
                        seconds
                    );
                    return Err(Diagnostic::new(origin, message));
                }
                self.pause = (f64::from(seconds) * 1000.0).round() as u32;
            }
            Field::Gripper => {
                self.gripper = Some(match text.to_ascii_lowercase().as_str() {
                    "0" | "0.0" | "off" => Grip::Off,
                    "1" | "1.0" | "open" => Grip::Open,
                    "2" | "2.0" | "close" | "closed" => Grip::Close,
                    _ => {
                        let help = message!("0 is off, 1 open, 2 closed");
                        return Err(Diagnostic::new(
                            origin,
                            message!("unknown gripper state '{state}'", state = short(text)),
                        )
                        .help(help));
                    }
                });
            }
            Field::Suction => {
                self.suction = Some(match text.to_ascii_lowercase().as_str() {
                    "0" | "0.0" | "off" | "false" => false,
                    "1" | "1.0" | "on" | "true" => true,
                    _ => {
                        let message =
                            message!("unknown suction cup state '{state}'", state = short(text));
                        let help = message!("0 is off, 1 on");
                        return Err(Diagnostic::new(origin, message).help(help));
                    }
                });
            }
            Field::Time | Field::J4 => {
                let value = crate::encoding::number(text);
                let value = value.ok_or_else(|| match field {
                    Field::Time => super::no_number(origin, message!("a time"), text),
                    _ => super::no_number(origin, message!("an angle"), text),
                })?;
                match field {
                    Field::Time => self.t = Some(value),
                    _ => self.j4 = Some(value),
                }
            }
            Field::Rail => self.rail = Some(number(|| message!("a position on the rail"))?),
            Field::Speed | Field::Idle => {}
        }
        Ok(())
    }

    /// Position of the rail's carriage, mm.
    pub(super) fn rail(&self) -> Option<f32> {
        self.rail
    }

    /// Returns the row as a sample of a recording; `None` if it is incomplete.
    pub(super) fn sample(&self) -> Option<Sample> {
        let [x, y, z, r] = self.place;
        Some(Sample {
            t: self.t?,
            pose: [x?, y?, z?, r.unwrap_or(0.0)].map(f64::from),
            j4: self.j4,
            origin: self.origin,
        })
    }

    /// Returns the pose, or `None` if it has no coordinates.
    fn pose(
        &self,
        place: [Option<f32>; 4],
        what: fn() -> Message,
    ) -> Result<Option<[f32; 4]>, Diagnostic> {
        match place {
            [None, None, None, _] => Ok(None),
            [Some(x), Some(y), Some(z), r] => Ok(Some([x, y, z, r.unwrap_or(0.0)])),
            [x, y, _, _] => {
                let missing = match (x, y) {
                    (None, _) => "x",
                    (_, None) => "y",
                    _ => "z",
                };
                Err(Diagnostic::new(
                    self.origin,
                    message!("{what} has no {missing}", what = what(), missing),
                ))
            }
        }
    }

    fn motion(&self) -> Result<Option<Action>, Diagnostic> {
        let Some(to) = self.pose(self.place, || message!("the point"))? else {
            return Ok(None);
        };
        let style = match &self.style {
            Some((text, origin)) => style(text, *origin)?,
            None => Style::default(),
        };
        let by = match style {
            Style::Joints => Travel::Joints,
            Style::Line => Travel::Line,
            Style::Jump => Travel::Jump,
            Style::Path => {
                let [x, y, z, _] = to;
                return Ok(Some(Action::Path { to: [x, y, z] }));
            }
            Style::Arc => {
                let end = self.pose(self.end, || message!("the end of the arc"))?;
                let end = end.ok_or_else(|| {
                    let message = message!("the arc has no end");
                    Diagnostic::new(self.origin, message).help(message!(
                        "x, y, z, r is a point on the arc, _X, _Y, _Z, _R its end"
                    ))
                })?;
                return Ok(Some(Action::Arc { via: to, to: end }));
            }
        };
        Ok(Some(Action::Move { to, by }))
    }
}

fn short(text: &str) -> String {
    text.chars().take(30).collect()
}

/// Parses a motion style by its name, its number, or as written by `magician convert`.
fn style(text: &str, origin: Origin) -> Result<Style, Diagnostic> {
    let plain = text.to_ascii_lowercase();
    Ok(match plain.as_str() {
        "jump" | "0" => Style::Jump,
        "movj" | "joints" | "1" => Style::Joints,
        "movl" | "move" | "line" | "2" => Style::Line,
        "arc" | "3" | "4" => Style::Arc,
        "path" | "cp" => Style::Path,
        _ => {
            let message = message!("unknown motion style '{style}'", style = short(text));
            let help = message!("known are MOVJ, MOVL, JUMP and ARC");
            return Err(Diagnostic::new(origin, message).help(help));
        }
    })
}

/// Creates the plan: for each point the move, then the tool's action, then the pause.
pub(super) fn plan(
    rows: impl IntoIterator<Item = Row>,
    fields: &BTreeSet<Field>,
    mut notes: Vec<Diagnostic>,
) -> Result<Parsed<Plan>, Diagnostic> {
    let mut plan = Plan::default();
    let (mut gripper, mut suction) = (None, None);
    let (mut uses, mut skipped) = ([None; 2], None);
    let rows: Vec<Row> = rows.into_iter().collect();
    let mut rail = RailCourse::of(rows.iter().map(|row| row.rail));
    notes.extend(rail.note());
    for row in rows {
        let named = match row.name.as_str() {
            "" => row.origin,
            name => row.origin.named(plan.name(name)),
        };
        let Some(motion) = row.motion()? else {
            skipped = skipped.or(Some(row.origin));
            continue;
        };
        let motion = rail.with_rail(motion, row.rail);
        plan.push(motion.map_err(|why| Diagnostic::new(named, why))?, named);
        // Like playback files, the columns repeat the tool's state in each row; only changes are
        // actions.
        if let Some(grip) = row.gripper.filter(|grip| gripper != Some(*grip)) {
            uses[0] = uses[0].or(Some(named).filter(|_| grip != Grip::Off));
            plan.push(Action::Gripper(grip), named);
            gripper = Some(grip);
        }
        if let Some(on) = row.suction.filter(|on| suction != Some(*on)) {
            uses[1] = uses[1].or(Some(named).filter(|_| on));
            plan.push(Action::Suction(on), named);
            suction = Some(on);
        }
        if row.pause > 0 {
            plan.push(Action::Wait(row.pause), named);
        }
    }
    if plan.steps.is_empty() {
        return Err(Diagnostic::of_file(message!("the file has no points")));
    }
    if let [Some(_), Some(origin)] = uses {
        let message =
            message!("this uses the suction cup, another point the gripper; the arm has one tool");
        return Err(Diagnostic::new(origin, message));
    }
    // With both columns, the tool is the one ever switched on; the other column is `off`
    // throughout.
    plan.tool = match (
        fields.contains(&Field::Gripper),
        fields.contains(&Field::Suction),
    ) {
        (true, false) => Some(Tool::Gripper),
        (false, true) => Some(Tool::Suction),
        (true, true) if uses[0].is_some() => Some(Tool::Gripper),
        (true, true) if uses[1].is_some() => Some(Tool::Suction),
        _ => None,
    };
    let other = match plan.tool {
        Some(Tool::Gripper) => |action: &Action| matches!(action, Action::Suction(_)),
        Some(Tool::Suction) => |action: &Action| matches!(action, Action::Gripper(_)),
        _ => |action: &Action| matches!(action, Action::Suction(_) | Action::Gripper(_)),
    };
    plan.steps.retain(|step| !other(&step.action));
    if let Some(origin) = skipped {
        let note = Diagnostic::new(origin, message!("rows without a position are left out"));
        notes.push(note.coded(DiagnosticCode::LeftOut));
    }
    if fields.contains(&Field::Speed) {
        let what = message!(
            "velocity and acceleration are ignored: in known files they held the pauses of a playback"
        );
        let note = Diagnostic::of_file(what)
            .coded(DiagnosticCode::LeftOut)
            .help(message!(
                "a pause is taken from a column 'Pause', in seconds"
            ))
            .remedy(
                (Setting::SpeedRatio, SettingValue::Any("PERCENT")),
                "says how fast",
            );
        notes.push(note);
    }
    Ok(Parsed {
        content: plan,
        notes,
    })
}
