//! Conversion of plans to playback files.

use magician_host::{Message, Set, Setting, SettingValue, message};
use magician_protocol::PtpMode;

use super::row::{numbered, setting};
use super::write::is_xml_character;
use super::{Playback, Point, PointMotion, Row};
use crate::{Action, Diagnostic, DiagnosticCode, Grip, Plan, Step, Tool, Travel};

impl Playback {
    /// Converts a plan to a file of DobotStudio 1.9, as far as such a file can express it.
    ///
    /// Supported are moves to poses (joints, lines, jumps), with or without rail, arcs, the suction
    /// cup or the gripper, and pauses. Speeds and jump heights are left out with a note
    /// ([`notes`](Self::notes)), because the studio stores them elsewhere.
    ///
    /// Every row contains the state of the tool, so it is off from the first row on unless the plan
    /// says otherwise. A tool action after a pause and before the next move gets a separate row at
    /// the same position.
    ///
    /// # Errors
    /// A [`Diagnostic`] with the number of the first step that such a file cannot express.
    pub fn from_plan(plan: &Plan) -> Result<Self, Diagnostic> {
        let mut recorder = Recorder::new(plan)?;
        for (nth, step) in plan.steps.iter().enumerate() {
            recorder.step(nth, step)?;
        }
        recorder.finish()
    }
}

/// Returns path shape, target and rail position of a move with the rail.
fn on_rail(command: &Set) -> Option<(Travel, [f32; 4], f32)> {
    let Set::PtpWithLCmd(ptp) = command else {
        return None;
    };
    let by = match ptp.ptp_mode {
        PtpMode::JumpXyz => Travel::Jump,
        PtpMode::MovjXyz => Travel::Joints,
        PtpMode::MovlXyz => Travel::Line,
        _ => return None,
    };
    Some((by, [ptp.x, ptp.y, ptp.z, ptp.r], ptp.l))
}

struct Recorder<'p> {
    plan: &'p Plan,
    points: Vec<Point>,
    /// True if the tool's state of the last point is settled.
    tool_recorded: bool,
    gripper: Option<Grip>,
    suction: Option<bool>,
    /// Rail position after the last move, mm.
    rail: Option<f32>,
    left_out: Vec<Message>,
    notes: Vec<Diagnostic>,
}

impl<'p> Recorder<'p> {
    fn new(plan: &'p Plan) -> Result<Self, Diagnostic> {
        let mut recorder = Self {
            plan,
            points: Vec::new(),
            tool_recorded: false,
            gripper: None,
            suction: None,
            rail: None,
            left_out: Vec::new(),
            notes: Vec::new(),
        };
        // Every row has the tool's column, so find out which tool is used before writing any row.
        for (nth, step) in plan.steps.iter().enumerate() {
            match step.action {
                Action::Gripper(_) => recorder.gripper = Some(Grip::Off),
                Action::Suction(_) => recorder.suction = Some(false),
                _ => continue,
            }
            if recorder.gripper.is_some() && recorder.suction.is_some() {
                let what = if matches!(step.action, Action::Gripper(_)) {
                    message!("uses the gripper, an earlier one the suction cup")
                } else {
                    message!("uses the suction cup, an earlier one the gripper")
                };
                return Err(recorder.cannot(nth, step, what));
            }
        }
        recorder.settle_tool();
        Ok(recorder)
    }

    /// Chooses the tool column of the file, which is all that it says about the tool.
    fn settle_tool(&mut self) {
        let used_tool = match (self.gripper, self.suction) {
            (None, None) => None,
            (Some(_), _) => Some(Tool::Gripper),
            _ => Some(Tool::Suction),
        };
        match (used_tool, self.plan.tool) {
            (None, Some(Tool::Gripper)) => self.gripper = Some(Grip::Off),
            (None, Some(Tool::Suction)) => self.suction = Some(false),
            (_, None) => {}
            (used_tool, tool) if used_tool == tool => {}
            (_, Some(tool)) => {
                let note = message!(
                    "the file cannot store that its points are for the tool '{tool}'",
                    tool
                );
                let tool = (Setting::Tool, SettingValue::Any("NAME"));
                self.notes.push(Diagnostic::of_file(note).remedy(
                    tool,
                    "sets it when the file is \
                        played",
                ));
            }
        }
    }

    fn cannot(&self, nth: usize, step: &Step, what: Message) -> Diagnostic {
        let diagnostic = Diagnostic::new(
            step.origin,
            message!(
                "step {step} {what}, which a playback file cannot store",
                step = nth + 1,
                what
            ),
        );
        match self.plan.name_of(&step.origin) {
            Some(name) => diagnostic.named(name),
            None => diagnostic,
        }
    }

    fn step(&mut self, nth: usize, step: &Step) -> Result<(), Diagnostic> {
        match &step.action {
            Action::Move { to, by } => self.go(nth, step, PointMotion::Move(*by), *to),
            Action::Arc { via, to } => self.go(nth, step, PointMotion::Arc { via: *via }, *to),
            Action::Gripper(grip) => {
                self.gripper = Some(*grip);
                self.record_output(nth, step)
            }
            Action::Suction(on) => {
                self.suction = Some(*on);
                self.record_output(nth, step)
            }
            Action::Wait(milliseconds) => self.wait(nth, step, *milliseconds),
            Action::Command(command) if on_rail(command).is_some() => {
                let (by, to, l) = on_rail(command).unwrap_or_default();
                if !l.is_finite() {
                    return Err(self.cannot(
                        nth,
                        step,
                        message!("leads to a place on the rail that is not a number"),
                    ));
                }
                self.rail = Some(l);
                self.go(nth, step, PointMotion::Move(by), to)
            }
            other => {
                let Some(command) = other.command() else {
                    let what = message!("parts and pauses for a person");
                    if !self.left_out.contains(&what) {
                        self.left_out.push(what);
                    }
                    return Ok(());
                };
                if let Some(what) = setting(&command) {
                    if !self.left_out.contains(&what) {
                        self.left_out.push(what);
                    }
                    return Ok(());
                }
                let name = command.row().set_name;
                let diagnostic = self.cannot(nth, step, message!("is a {name}", name));
                let help = message!(
                    "it can store moves to poses, arcs, pauses, and the suction cup or the gripper"
                );
                Err(diagnostic.help(help))
            }
        }
    }

    fn go(
        &mut self,
        nth: usize,
        step: &Step,
        way: PointMotion,
        to: [f32; 4],
    ) -> Result<(), Diagnostic> {
        let via = match way {
            PointMotion::Arc { via } => via,
            PointMotion::Move(_) => to,
        };
        if !to.iter().chain(&via).all(|value| value.is_finite()) {
            let what = message!("leads to a coordinate that is not a number");
            return Err(self.cannot(nth, step, what));
        }
        // The reader takes a second point of zeros for an absent one, so this arc would not come
        // back.
        if matches!(way, PointMotion::Arc { .. }) && to == [0.0; 4] {
            return Err(self.cannot(nth, step, message!("is an arc to 0, 0, 0, 0")));
        }
        let name = self.plan.name_of(&step.origin).unwrap_or_default();
        let name = name.trim();
        // The reader makes up names such as `row3` for unnamed points. They would be wrong in this
        // file.
        let name = if numbered(name, "row").is_some() {
            ""
        } else {
            name
        };
        self.points.push(Point {
            name: name.chars().filter(|c| is_xml_character(*c)).collect(),
            gripper: self.gripper,
            suction: self.suction,
            rail: self.rail,
            ..Point::new(way, to)
        });
        self.tool_recorded = false;
        Ok(())
    }

    /// Sets the tool's state of the last point. Adds a point at the same position if that already
    /// had an action or a pause.
    fn record_output(&mut self, nth: usize, step: &Step) -> Result<(), Diagnostic> {
        let (gripper, suction, tool_recorded) = (self.gripper, self.suction, self.tool_recorded);
        let Some(last) = self.points.last_mut() else {
            return Err(self.error_before_first_point(nth, step));
        };
        let same = last.gripper == gripper && last.suction == suction;
        if !same && (tool_recorded || last.pause > 0) {
            let again = Point {
                rail: last.rail,
                ..Point::new(PointMotion::Move(Travel::Joints), last.to)
            };
            self.points.push(again);
        }
        if let Some(last) = self.points.last_mut() {
            (last.gripper, last.suction) = (gripper, suction);
        }
        self.tool_recorded = true;
        Ok(())
    }

    fn wait(&mut self, nth: usize, step: &Step, milliseconds: u32) -> Result<(), Diagnostic> {
        let Some(last) = self.points.last_mut() else {
            return Err(self.error_before_first_point(nth, step));
        };
        match last.pause.checked_add(milliseconds) {
            Some(pause) => last.pause = pause,
            None => return Err(self.cannot(nth, step, message!("waits for more than 49 days"))),
        }
        Ok(())
    }

    fn error_before_first_point(&self, nth: usize, step: &Step) -> Diagnostic {
        let diagnostic = self.cannot(nth, step, message!("comes before the first move"));
        diagnostic.help(message!("put a move to a pose in front of it"))
    }

    fn finish(mut self) -> Result<Playback, Diagnostic> {
        if self.points.is_empty() {
            return Err(Diagnostic::of_file(message!(
                "there is no move to a pose to store"
            )));
        }
        for what in self.left_out {
            let note = message!(
                "the {what} are left out: a playback file does not have them",
                what
            );
            self.notes
                .push(Diagnostic::of_file(note).coded(DiagnosticCode::LeftOut));
        }
        let arcs = |point: &Point| matches!(point.way, PointMotion::Arc { .. });
        let arcs = self.points.iter().any(arcs);
        let rows = (0..).zip(self.points);
        Ok(Playback {
            // Values of DobotStudio 1.9, whose rows `Row::of` writes.
            version: Some("Ver-194".to_owned()),
            dobot_type: Some("Magician".to_owned()),
            rows: rows.map(|(n, point)| Row::of(n, point, arcs)).collect(),
            notes: self.notes,
            ..Playback::default()
        })
    }
}
