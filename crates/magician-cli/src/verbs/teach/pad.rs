//! Translates keys into actions while teaching. Carries out none of them.

use std::time::Duration;

use magician::commands::Pose;
use magician_job::teach::{ProgramModel, TeachEditor, TeachError};
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use super::file::DEFAULT_FILE_NAME;
use super::wording::{pause, refusal};
use crate::verbs::jog::{KeyEffect, Pad, Tone};

/// Time after a stop during which Space stops again instead of storing a point. A choice: about the
/// time for a nervous second press.
const REPEATED_STOP_TIME: Duration = Duration::from_secs(1);

/// Prompt that is being answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Prompt {
    /// Name of the row.
    Name(String),
    /// Pause at the position, s.
    Pause(String),
    /// File to save to.
    File(String),
    /// Confirmation to overwrite this file.
    Replace(String),
    /// Confirmation to leave with unsaved changes.
    Leave,
    /// Question whether to continue an unsaved lesson.
    Recover,
}

/// Effect of a key.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Turn {
    /// Handled by the jog pad.
    Pad(KeyEffect),
    /// Play from this row on.
    Play(usize),
    /// Save to the lesson's file.
    Save,
    /// Save to this file from now on.
    SaveAs(String),
    /// The same, even if the file exists.
    Replace(String),
    /// Save, and leave if that succeeds.
    SaveAndLeave,
    /// Leave without saving.
    Leave,
    /// Continue the unsaved lesson, or drop it.
    Recover(bool),
    /// Start or stop storing positions that a hand shows.
    Follow,
}

/// Lesson and prompt.
#[derive(Clone, Debug)]
pub(super) struct TeachPad {
    pub(super) editor: TeachEditor,
    pub(super) prompt: Option<Prompt>,
    /// True if the lesson has a file.
    pub(super) has_file: bool,
    /// Time of the last stop.
    stopped: Option<Duration>,
}

impl TeachPad {
    pub(super) fn new(lesson: ProgramModel, has_file: bool) -> Self {
        Self {
            editor: TeachEditor::new(lesson),
            prompt: None,
            has_file,
            stopped: None,
        }
    }

    /// Returns the effect of a key. `pose` is `None` if the position is unknown; `still` is true if
    /// the arm was seen to stand.
    pub(super) fn key(
        &mut self,
        key: KeyEvent,
        pad: &mut Pad,
        pose: Option<&Pose>,
        still: bool,
        now: Duration,
    ) -> Turn {
        let control = key.modifiers.contains(KeyModifiers::CONTROL);
        if key.kind == KeyEventKind::Release || pad.question.is_some() || pad.help.is_some() {
            return Turn::Pad(pad.key(key, now));
        }
        if control {
            return match key.code {
                KeyCode::Char('s') => self.save(),
                KeyCode::Char('r') => self.redo(pad),
                _ => Turn::Pad(pad.key(key, now)),
            };
        }
        let still = still && pad.pendant.activity.is_none();
        if key.code == KeyCode::Char(' ') && !still {
            self.stopped = Some(now);
            return Turn::Pad(pad.key(key, now));
        }
        if let Some(prompt) = self.prompt.take() {
            pad.message = None;
            return self.answer(prompt, key.code, pad);
        }
        if pad.direction(key.code).is_some() {
            return Turn::Pad(pad.key(key, now));
        }
        match key.code {
            KeyCode::Char(' ') if self.was_stopped(now) => Turn::Pad(pad.key(key, now)),
            KeyCode::Enter | KeyCode::Char(' ') if key.kind == KeyEventKind::Press => {
                self.store(pad, pose, still)
            }
            // A held key stores only once.
            KeyCode::Enter | KeyCode::Char(' ') => Turn::Pad(KeyEffect::Nothing),
            KeyCode::Char('q') if self.editor.program.is_saved() => Turn::Leave,
            KeyCode::Char('q') => self.ask(Prompt::Leave),
            _ => self.edit(key, pad, pose, still, now),
        }
    }

    /// Adds pasted text to the current prompt.
    pub(super) fn pasted(&mut self, text: &str) {
        let signs = text.chars().filter(|sign| !sign.is_control());
        self.prompt = (self.prompt.take())
            .map(|prompt| signs.fold(prompt, |prompt, sign| typed(prompt, KeyCode::Char(sign))));
    }

    /// Stores the position at which a hand has left the arm.
    pub(super) fn store_hand_position(&mut self, pad: &mut Pad, pose: &Pose) {
        if let Some(name) = self.editor.store_guided(pose) {
            pad.say(
                Tone::Plain,
                format!("{name} stored: the arm's key was released"),
            );
        }
    }

    fn was_stopped(&self, now: Duration) -> bool {
        self.stopped
            .is_some_and(|at| now.saturating_sub(at) < REPEATED_STOP_TIME)
    }

    fn store(&mut self, pad: &mut Pad, pose: Option<&Pose>, still: bool) -> Turn {
        match self.editor.store(pose, still) {
            Ok(name) => pad.say(Tone::Plain, format!("{name} stored")),
            Err(error) => pad.say(Tone::Bad, refusal(error)),
        }
        Turn::Pad(KeyEffect::Nothing)
    }

    fn edit(
        &mut self,
        key: KeyEvent,
        pad: &mut Pad,
        pose: Option<&Pose>,
        still: bool,
        now: Duration,
    ) -> Turn {
        let lesson = &mut self.editor.program;
        let row = lesson.steps().get(lesson.selected());
        match key.code {
            KeyCode::Char('j') => lesson.select(true),
            KeyCode::Char('k') => lesson.select(false),
            KeyCode::Char('J') => lesson.shift(true),
            KeyCode::Char('K') => lesson.shift(false),
            KeyCode::Char('n') => {
                let name = row.map_or_else(String::new, |row| row.name.clone());
                return self.ask(Prompt::Name(name));
            }
            KeyCode::Char('P') => {
                let pause = row.map_or(0, |row| row.pause);
                let text = if pause == 0 {
                    String::new()
                } else {
                    (f64::from(pause) / 1000.0).to_string()
                };
                return self.ask(Prompt::Pause(text));
            }
            KeyCode::Char('x') | KeyCode::Delete => {
                return report_edit(pad, lesson.delete(), "deleted; u undoes it");
            }
            KeyCode::Char('t') => return report_edit(pad, lesson.next_travel(), ""),
            KeyCode::Char('G') => return report_edit(pad, lesson.next_gripper(), ""),
            KeyCode::Char('S') => return report_edit(pad, lesson.next_suction(), ""),
            KeyCode::Char('u') => {
                let undone = self.editor.program.undo();
                return report_if(pad, undone, "undone", "nothing to undo");
            }
            KeyCode::Char('U') => return self.redo(pad),
            KeyCode::Char('r') => {
                let taught = self.editor.reteach(pose, still);
                return report_edit(pad, taught, "point moved to the arm's position");
            }
            KeyCode::Char('v') => {
                let marked = self.editor.arc_through(pose, still);
                let text = "arc through this point: move to its end and press Enter";
                return report_edit(pad, marked, text);
            }
            KeyCode::Char('o' | 'O') if lesson.steps().is_empty() => {
                pad.say(Tone::Bad, "nothing to play")
            }
            KeyCode::Char('o') => return Turn::Play(lesson.selected()),
            KeyCode::Char('O') => return Turn::Play(0),
            KeyCode::Char('f') => return Turn::Follow,
            KeyCode::Esc => lesson.cancel_arc(),
            _ => return Turn::Pad(pad.key(key, now)),
        }
        Turn::Pad(KeyEffect::Nothing)
    }

    fn redo(&mut self, pad: &mut Pad) -> Turn {
        let redone = self.editor.program.redo();
        report_if(pad, redone, "redone", "nothing to redo")
    }

    fn ask(&mut self, prompt: Prompt) -> Turn {
        self.prompt = Some(prompt);
        Turn::Pad(KeyEffect::Nothing)
    }

    fn save(&mut self) -> Turn {
        if self.has_file {
            Turn::Save
        } else {
            self.ask(Prompt::File(DEFAULT_FILE_NAME.to_owned()))
        }
    }

    fn answer(&mut self, prompt: Prompt, code: KeyCode, pad: &mut Pad) -> Turn {
        match (prompt, code) {
            (Prompt::Leave, KeyCode::Char('y' | 'Y')) if self.has_file => Turn::SaveAndLeave,
            (Prompt::Leave, KeyCode::Char('y' | 'Y')) => self.save(),
            (Prompt::Leave, KeyCode::Char('n' | 'N')) => Turn::Leave,
            (Prompt::Replace(name), KeyCode::Char('y' | 'Y')) => Turn::Replace(name),
            (Prompt::Leave | Prompt::Replace(_), _) => Turn::Pad(KeyEffect::Nothing),
            (Prompt::Recover, KeyCode::Char('y' | 'Y')) => Turn::Recover(true),
            (Prompt::Recover, KeyCode::Char('n' | 'N')) => Turn::Recover(false),
            (Prompt::Recover, _) => self.ask(Prompt::Recover),
            (_, KeyCode::Esc) => Turn::Pad(KeyEffect::Nothing),
            (Prompt::Name(text), KeyCode::Enter) => {
                report_edit(pad, self.editor.program.rename(&text), "")
            }
            (Prompt::Pause(text), KeyCode::Enter) => match pause(&text) {
                Ok(pause) => report_edit(pad, self.editor.program.set_pause(pause), ""),
                Err(text) => {
                    pad.say(Tone::Bad, text);
                    Turn::Pad(KeyEffect::Nothing)
                }
            },
            (Prompt::File(text), KeyCode::Enter) => Turn::SaveAs(text),
            (prompt, code) => self.ask(typed(prompt, code)),
        }
    }
}

/// Reports the result of an edit; says nothing on success if `text` is empty.
fn report_edit(pad: &mut Pad, edit: Result<(), TeachError>, text: &str) -> Turn {
    match edit {
        Ok(()) if text.is_empty() => pad.message = None,
        Ok(()) => pad.say(Tone::Plain, text),
        Err(error) => pad.say(Tone::Bad, refusal(error)),
    }
    Turn::Pad(KeyEffect::Nothing)
}

/// Prints `text` if something was done, else `otherwise`.
fn report_if(pad: &mut Pad, done: bool, text: &str, otherwise: &str) -> Turn {
    if done {
        pad.say(Tone::Plain, text);
    } else {
        pad.say(Tone::Bad, otherwise);
    }
    Turn::Pad(KeyEffect::Nothing)
}

/// Returns a prompt after one more key.
fn typed(mut prompt: Prompt, code: KeyCode) -> Prompt {
    if let Prompt::Name(text) | Prompt::Pause(text) | Prompt::File(text) = &mut prompt {
        match code {
            KeyCode::Char(sign) if text.chars().count() < 200 => text.push(sign),
            KeyCode::Backspace => drop(text.pop()),
            _ => {}
        }
    }
    prompt
}

impl Prompt {
    /// Returns the question with the text typed so far.
    pub(super) fn text(&self) -> String {
        match self {
            Self::Name(text) => format!("name: {text}_"),
            Self::Pause(text) => format!("pause there, s: {text}_"),
            Self::File(text) => format!("save as NAME.playback or NAME.plan.json: {text}_"),
            Self::Replace(name) => format!("{name} already exists: overwrite it? y/n"),
            Self::Leave => {
                "not saved. Save it? y saves, n discards, any other key stays".to_owned()
            }
            Self::Recover => {
                "changes were left unsaved last time. Continue with them? y/n".to_owned()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use magician_job::jog::{Activity, Pendant, PendantOrder, ToolState};

    struct Console {
        teach: TeachPad,
        pad: Pad,
        pose: Pose,
        still: bool,
        now: Duration,
    }

    impl Console {
        fn new() -> Self {
            Self {
                teach: TeachPad::new(ProgramModel::new("lesson", None), true),
                pad: Pad::new(Pendant::new(50.0, ToolState::default(), false)),
                pose: Pose {
                    x: 200.0,
                    y: 0.0,
                    z: 0.0,
                    r: 0.0,
                    joint_angle: [0.0; 4],
                },
                still: true,
                now: Duration::ZERO,
            }
        }

        fn press(&mut self, code: KeyCode) -> Turn {
            self.pose.x += 1.0;
            let key = KeyEvent::new(code, KeyModifiers::NONE);
            let Self {
                teach, pad, pose, ..
            } = self;
            teach.key(key, pad, Some(pose), self.still, self.now)
        }

        fn types(&mut self, text: &str) {
            text.chars()
                .for_each(|sign| drop(self.press(KeyCode::Char(sign))));
        }

        fn rows(&self) -> usize {
            self.teach.editor.program.steps().len()
        }
    }

    #[test]
    fn enter_and_space_store_the_current_position() {
        let mut console = Console::new();
        console.press(KeyCode::Enter);
        console.press(KeyCode::Char(' '));
        assert_eq!(console.rows(), 2);
        console.still = false;
        console.press(KeyCode::Enter);
        assert_eq!(console.rows(), 2);
        // While the arm moves, and shortly after, Space stops it.
        let stop = Turn::Pad(KeyEffect::Order(PendantOrder::Stop));
        assert_eq!(console.press(KeyCode::Char(' ')), stop);
        console.still = true;
        assert_eq!(console.press(KeyCode::Char(' ')), stop);
        console.now = Duration::from_secs(3);
        console.press(KeyCode::Char(' '));
        assert_eq!(console.rows(), 3);
    }

    #[test]
    fn positions_of_a_moving_arm_are_not_stored() {
        let mut console = Console::new();
        console.press(KeyCode::Enter);
        let before = console.teach.editor.program.steps().clone();
        // A step was ordered, but no reading shows it yet.
        console.pad.pendant.activity = Some(Activity::Run);
        for key in [KeyCode::Enter, KeyCode::Char('r'), KeyCode::Char('v')] {
            console.press(key);
            let (_, said) = console.pad.message.clone().unwrap();
            assert!(said.contains("the arm is moving"), "{said}");
        }
        assert_eq!(*console.teach.editor.program.steps(), before);
        assert_eq!(console.teach.editor.program.via(), None);
        console.pad.pendant.activity = None;
        let key = KeyEvent::new(KeyCode::Enter, KeyModifiers::NONE);
        console
            .teach
            .key(key, &mut console.pad, None, false, console.now);
        let (_, said) = console.pad.message.clone().unwrap();
        assert!(said.contains("does not answer"), "{said}");
        assert_eq!(console.rows(), 1);
    }

    #[test]
    fn pasted_text_is_a_name_and_not_keys() {
        let mut console = Console::new();
        console.press(KeyCode::Enter);
        console.teach.pasted("hyo\n");
        assert_eq!(console.teach.prompt, None);
        console.types("n");
        console.teach.pasted(" by hand\n");
        console.press(KeyCode::Enter);
        assert_eq!(console.teach.editor.program.steps()[0].name, "P1 by hand");
    }

    #[test]
    fn space_stops_a_program_in_every_prompt() {
        let mut console = Console::new();
        console.press(KeyCode::Enter);
        console.types("n");
        console.pad.pendant.activity = Some(Activity::Run);
        let stop = Turn::Pad(KeyEffect::Order(PendantOrder::Stop));
        assert_eq!(console.press(KeyCode::Char(' ')), stop);
        console.pad.pendant.activity = None;
        console.now = Duration::from_secs(3);
        console.types(" a b");
        console.press(KeyCode::Enter);
        assert_eq!(console.teach.editor.program.steps()[0].name, "P1 a b");
    }

    #[test]
    fn arrows_move_the_arm_and_letters_edit() {
        let mut console = Console::new();
        assert!(matches!(
            console.press(KeyCode::Up),
            Turn::Pad(KeyEffect::Order(PendantOrder::Step { .. }))
        ));
        console.types("\u{20}");
        console.types("P");
        console.types("1.5");
        console.press(KeyCode::Enter);
        console.types("SGt");
        let row = &console.teach.editor.program.steps()[0];
        assert_eq!((row.pause, row.suction), (1500, Some(true)));
        assert!(row.gripper.is_some());
        console.types("x");
        assert_eq!(console.rows(), 0);
        console.types("u");
        assert_eq!(console.rows(), 1);
        assert_eq!(console.press(KeyCode::Char('o')), Turn::Play(0));
        assert_eq!(console.press(KeyCode::Char('f')), Turn::Follow);
    }

    #[test]
    fn unsaved_changes_ask_before_leaving() {
        let mut console = Console::new();
        for key in ['o', 'O'] {
            assert_eq!(
                console.press(KeyCode::Char(key)),
                Turn::Pad(KeyEffect::Nothing)
            );
        }
        assert_eq!(console.press(KeyCode::Char('q')), Turn::Leave);
        console.press(KeyCode::Enter);
        assert_eq!(
            console.press(KeyCode::Char('q')),
            Turn::Pad(KeyEffect::Nothing)
        );
        assert_eq!(console.teach.prompt, Some(Prompt::Leave));
        console.press(KeyCode::Esc);
        console.press(KeyCode::Char('q'));
        assert_eq!(console.press(KeyCode::Char('y')), Turn::SaveAndLeave);
        console.press(KeyCode::Char('q'));
        assert_eq!(console.press(KeyCode::Char('n')), Turn::Leave);
        console.teach.has_file = false;
        console.press(KeyCode::Char('q'));
        console.press(KeyCode::Char('y'));
        (0..DEFAULT_FILE_NAME.len()).for_each(|_| drop(console.press(KeyCode::Backspace)));
        console.types("a.playback");
        let save = Turn::SaveAs("a.playback".to_owned());
        assert_eq!(console.press(KeyCode::Enter), save);
    }

    #[test]
    fn arc_passes_through_the_marked_point() {
        let mut console = Console::new();
        console.types("\u{20}v");
        assert!(console.teach.editor.program.via().is_some());
        console.press(KeyCode::Enter);
        let plan = console.teach.editor.program.plan(0);
        assert!(matches!(
            plan.steps[1].action,
            magician_program::Action::Arc { .. }
        ));
        console.types("v");
        console.press(KeyCode::Esc);
        assert!(console.teach.editor.program.via().is_none());
    }

    #[test]
    fn hand_guiding_stores_a_position_once() {
        let mut console = Console::new();
        let pose = console.pose;
        console.teach.editor.hand_guiding = Some(true);
        console.teach.store_hand_position(&mut console.pad, &pose);
        console.teach.store_hand_position(&mut console.pad, &pose);
        assert_eq!(console.rows(), 1);
    }
}
