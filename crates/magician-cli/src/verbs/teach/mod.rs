//! `teach`: stores positions that a user shows the arm, and writes a file to play.

mod file;
mod pad;
mod view;
mod wording;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use magician::commands::{EndEffectorParams, Pose};
use magician::{Arm, ToolBias, build};
use magician_job::Polled;
use magician_job::jog::{Activity, PendantOrder};
use magician_job::teach::{ProgramModel, TeachStep, guided_points};
use magician_program::{Plan, Tool};
use serde::Serialize;

use crate::context::{Context, StopPolicy};
use crate::failure::Failure;
use crate::output::Output;
use crate::permission::homed;
use crate::saved::SavedSettings;
use crate::terminal::FullScreen;
use crate::verbs::jog::{
    Console, ConsoleEvent, End, KeyEffect, REAL_TIME_ARM, Tone, check_interactive, next_of,
};
use file::{DEFAULT_FILE_NAME, RescueFile};
use pad::{Prompt, TeachPad, Turn};
use view::Model;

#[cfg(test)]
pub(super) use view::tests::examples;

/// Teach points with keys or by hand; edit, play and save them
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician teach pick.playback     for DobotStudio and `magician play`; continues an existing file
  magician teach pick.plan.json    magician's own format, without loss

Keys move the arm as in `magician jog`. Or hold the unlock key on the forearm and guide the arm by \
hand: releasing the key stores the point. Enter stores the arm's position. Unsaved changes are kept \
in FILE~, so that nothing is lost if the cable, the terminal or the power fails. Points are \
positions of the tip of the tool that is set on the arm; --tool sets it.")]
pub(crate) struct Teach {
    /// Program to teach: NAME.playback or NAME.plan.json
    file: Option<PathBuf>,
    /// Mounted tool: none, suction, gripper, pen, laser, or its bias X,Y,Z in mm; it stays set on
    /// the arm
    #[arg(long, value_name = "NAME|X,Y,Z", allow_hyphen_values = true)]
    tool: Option<ToolBias>,
    /// Teach even if the arm is not known to be homed; the points may be wrong
    #[arg(long)]
    unhomed: bool,
}

#[derive(Serialize)]
struct TeachReport {
    file: Option<String>,
    rows: usize,
    saved: bool,
}

impl Teach {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let known = match &self.file {
            Some(path) => {
                file::format(path)?;
                file::read(path)?
            }
            None => None,
        };
        check_interactive("teach", "`magician run FILE` plays what was taught")?;
        let saved = context.saved.clone();
        let json = context.global.json;
        let answer = context.arm_or(REAL_TIME_ARM, StopPolicy::Pad, async |arm, out| {
            let arm = homed(arm, self.unhomed).await?;
            let mut session = Session::open(&arm, &saved, self.file, self.tool, known).await?;
            let outcome = session.run().await;
            session.leave(outcome, out, json).await
        })?;
        context.show(&answer, |out| {
            let rows = answer.rows;
            match &answer.file {
                Some(file) if answer.saved => out.line(format_args!("{file}: {rows} rows")),
                _ => out.line("nothing was saved"),
            }
        })
    }
}

struct Session {
    console: Console,
    teach: TeachPad,
    path: Option<PathBuf>,
    rescue: RescueFile,
    /// Unsaved lesson of an earlier session.
    unsaved: Option<Plan>,
    /// Steps in the rescue file.
    saved_steps: Arc<Vec<TeachStep>>,
    hand: Option<Polled<Pose>>,
    stage: FullScreen<Model>,
}

impl Session {
    async fn open(
        arm: &Arm,
        saved: &SavedSettings,
        path: Option<PathBuf>,
        tool: Option<ToolBias>,
        known: Option<Plan>,
    ) -> Result<Self, Failure> {
        let mut console = Console::open(arm, saved).await?;
        // The option takes precedence over the tool stored in the file.
        let wanted = tool.or(known.as_ref().and_then(|plan| plan.tool.map(Tool::bias)));
        if let Some(bias) = wanted {
            arm.set_any(&build::tool(bias)).await?;
        }
        let tool = Tool::from(&arm.get::<EndEffectorParams>().await?);
        let named = path.as_deref().unwrap_or(Path::new(DEFAULT_FILE_NAME));
        let mut lesson = match known {
            Some(plan) => ProgramModel::from_plan(&plan),
            None => ProgramModel::new("", None),
        };
        lesson.tool = Some(tool);
        lesson.title = title(named);
        let mut teach = TeachPad::new(lesson, path.is_some());
        let hand = guided_points(arm, saved).await?;
        teach.editor.hand_guiding = hand.as_ref().map(|_| true);
        let rescue = RescueFile::for_lesson(named);
        let left = rescue.find();
        if left.is_some() {
            teach.prompt = Some(Prompt::Recover);
        }
        console
            .observed
            .note(format!("points are for the tool: {tool}"));
        Ok(Self {
            saved_steps: Arc::clone(teach.editor.program.steps()),
            console,
            teach,
            path,
            rescue,
            unsaved: left,
            hand,
            stage: FullScreen::open(view::draw)?,
        })
    }

    async fn run(&mut self) -> Result<End, Failure> {
        loop {
            self.follow_program();
            self.stage.show(Model {
                observed: self.console.observed.clone(),
                pad: self.console.pad.clone(),
                teach: self.teach.clone(),
            });
            let end = tokio::select! {
                biased;
                event = self.console.next(&mut self.stage) => match event? {
                    ConsoleEvent::Key(key) => {
                        let observed = &self.console.observed;
                        let status = observed.arm.status.as_ref().filter(|_| observed.arm.is_answering());
                        let (pose, still) = (status.map(|status| status.pose), observed.arm.is_at_rest());
                        let now = self.console.now();
                        let turn = self.teach.key(key, &mut self.console.pad, pose.as_ref(), still, now);
                        self.take(turn)
                    }
                    ConsoleEvent::Pasted(text) => {
                        self.teach.pasted(&text);
                        None
                    }
                    other => self.console.handle_background(&other),
                },
                Some(pose) = next_of(&mut self.hand) => {
                    self.teach.store_hand_position(&mut self.console.pad, &pose);
                    None
                }
            };
            self.save_rescue();
            if let Some(end) = end {
                return Ok(end);
            }
        }
    }

    fn take(&mut self, turn: Turn) -> Option<End> {
        match turn {
            Turn::Pad(reply) => return self.console.carry_out(reply),
            Turn::Play(from) => self.play(from),
            Turn::Save => drop(self.save()),
            Turn::SaveAs(name) if Path::new(&name).exists() => {
                self.teach.prompt = Some(Prompt::Replace(name));
            }
            Turn::SaveAs(name) | Turn::Replace(name) => {
                let before = self.path.replace(name.into());
                if !self.save() {
                    self.path = before;
                }
            }
            Turn::SaveAndLeave if self.save() => return Some(End::Quit),
            Turn::SaveAndLeave => {}
            Turn::Leave => {
                self.rescue.forget();
                return Some(End::Quit);
            }
            Turn::Recover(wanted) => self.recover(wanted),
            Turn::Follow => self.toggle_hand_guiding(),
        }
        None
    }

    fn play(&mut self, from: usize) {
        let (order, playing) = self.teach.editor.play(from);
        let before = self.console.pad.pendant.activity;
        self.console.carry_out(KeyEffect::Order(order));
        // If a program plays already, it continues and the new one was refused.
        if before.is_none() && self.console.pad.pendant.activity == Some(Activity::Run) {
            self.teach.editor.start_playing(playing);
            self.console.pad.say(Tone::Plain, "playing; space stops it");
        }
    }

    /// Marks the row that is being played.
    fn follow_program(&mut self) {
        let session = &self.console.session;
        self.teach.editor.follow(session.activity(), session.step());
    }

    fn toggle_hand_guiding(&mut self) {
        let text = match self.teach.editor.toggle_hand_guiding() {
            Some(true) => "points are stored when the arm's unlock key is released",
            Some(false) => "the arm's unlock key stores no points",
            None => "this arm does not report its unlock key",
        };
        self.console.pad.say(Tone::Plain, text);
    }

    fn recover(&mut self, wanted: bool) {
        let Some(left) = self.unsaved.take().filter(|_| wanted) else {
            self.rescue.forget();
            return;
        };
        if let Some(tip) = self.teach.editor.recover(&left) {
            self.console
                .carry_out(KeyEffect::Order(PendantOrder::Tool(tip)));
        }
        self.saved_steps = Arc::clone(self.teach.editor.program.steps());
    }

    /// Saves the lesson. Returns true on success.
    fn save(&mut self) -> bool {
        let Some(path) = self.path.clone() else {
            self.teach.prompt = Some(Prompt::File(DEFAULT_FILE_NAME.to_owned()));
            return false;
        };
        match file::write(&path, &self.teach.editor.program.plan(0)) {
            Ok(note) => {
                self.rescue.forget();
                self.rescue = RescueFile::for_lesson(&path);
                self.teach.editor.program.title = title(&path);
                self.teach.editor.program.mark_saved();
                self.teach.has_file = true;
                self.saved_steps = Arc::clone(self.teach.editor.program.steps());
                let note = note.map_or_else(String::new, |note| format!("; {note}"));
                let text = format!("saved to {}{note}", path.display());
                self.console.pad.say(Tone::Plain, text);
                true
            }
            Err(failure) => {
                self.console
                    .pad
                    .say(Tone::Bad, format!("not saved: {}", failure.message));
                false
            }
        }
    }

    /// Writes unsaved changes to the rescue file, if there are new ones.
    fn save_rescue(&mut self) {
        // The earlier rescue file stays until the user has decided about it.
        if self.unsaved.is_some() {
            return;
        }
        if Arc::ptr_eq(&self.saved_steps, self.teach.editor.program.steps()) {
            return;
        }
        self.saved_steps = Arc::clone(self.teach.editor.program.steps());
        if let Err(error) = self.rescue.keep(&self.teach.editor.program.plan(0)) {
            let text = format!(
                "{} cannot be written: {error}",
                self.rescue.path().display()
            );
            self.console.pad.say(Tone::Bad, text);
        }
    }

    async fn leave(
        self,
        outcome: Result<End, Failure>,
        out: &mut Output,
        json: bool,
    ) -> Result<TeachReport, Failure> {
        let lesson = self.teach.editor.program;
        let rescue = self.rescue.path().display().to_string();
        let lost = !lesson.is_saved() && self.rescue.find().is_some();
        let told = |failure: Failure| {
            if lost {
                failure.hint(format!(
                    "unsaved changes are in {rescue}: `magician teach` offers them next time"
                ))
            } else {
                failure
            }
        };
        let closed = self.stage.close();
        let end = outcome.map_err(told)?;
        closed.map_err(told)?;
        self.console.leave(end, out, json).await.map_err(told)?;
        Ok(TeachReport {
            file: self.path.map(|path| path.display().to_string()),
            rows: lesson.steps().len(),
            saved: lesson.is_saved() && !lesson.steps().is_empty(),
        })
    }
}

/// Returns the name of a file without its folder.
fn title(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}
