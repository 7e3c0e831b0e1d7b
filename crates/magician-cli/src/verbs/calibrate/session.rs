//! Session at the terminal in which the user touches points with the jog pad.

use magician::Arm;
use magician_program::{Diagnostic, Tool};
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use super::subject::{CalibrationResult, Subject, Touch};
use super::view;
use crate::failure::Failure;
use crate::output::Output;
use crate::saved::SavedSettings;
use crate::terminal::{FullScreen, ObservedArm};
use crate::verbs::jog::{Console, ConsoleEvent, End, Pad, Tone};

/// Distance below which two points count as the same, touched twice by mistake; mm and deg.
const SAME_POINT_DISTANCE: f64 = 2.0;

/// Result of the session and the decision about saving.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Outcome {
    pub(super) found: CalibrationResult,
    pub(super) saves: bool,
}

/// Contents of a frame of the session.
#[derive(Clone, Debug)]
pub(super) struct Model {
    pub(super) observed: ObservedArm,
    pub(super) pad: Pad,
    pub(super) touched: Touched,
}

/// Points touched so far.
#[derive(Clone, Debug)]
pub(super) struct Touched {
    pub(super) subject: Subject,
    pub(super) tool: Tool,
    pub(super) touches: Vec<Touch>,
    /// Result, once all points have been touched.
    pub(super) result: Option<Result<CalibrationResult, Diagnostic>>,
}

/// Use of a key in this session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum KeyUse {
    Take,
    TakeBack,
    /// Passed on to the jog pad.
    Move,
}

impl Touched {
    pub(super) fn new(subject: Subject, tool: Tool) -> Self {
        Self {
            subject,
            tool,
            touches: Vec::new(),
            result: None,
        }
    }

    pub(super) fn add(&mut self, touch: Touch) {
        self.touches.push(touch);
        if self.touches.len() == self.subject.points().len() {
            self.result = Some(self.subject.evaluate(&self.touches, self.tool));
        }
    }

    /// Returns the index of an earlier point at the same place. A tool is calibrated at one point
    /// from two angles of the wrist, which are different poses.
    fn existing_point(&self, touch: &Touch) -> Option<usize> {
        let near = |other: &Touch| {
            let apart = other.pose.iter().zip(touch.pose);
            let far = apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            far < SAME_POINT_DISTANCE
        };
        self.touches.iter().position(near)
    }

    fn undo(&mut self) {
        self.touches.pop();
        self.result = None;
    }

    /// Returns the result if it may be saved.
    fn savable_result(&self) -> Option<&CalibrationResult> {
        self.result.as_ref()?.as_ref().ok()
    }
}

/// Runs the session until all points are touched. Returns `None` if the user leaves earlier.
pub(super) async fn run(
    arm: &Arm,
    saved: &SavedSettings,
    subject: Subject,
    tool: Tool,
    asks: bool,
    (out, json): (&mut Output, bool),
) -> Result<Option<Outcome>, Failure> {
    let mut console = Console::open(arm, saved).await?;
    console
        .observed
        .note(format!("the arm's poses are for the tool {tool}"));
    let mut touched = Touched::new(subject, tool);
    let mut stage = FullScreen::open(view::draw)?;
    let mut saves = false;
    let end = loop {
        stage.show(Model {
            observed: console.observed.clone(),
            pad: console.pad.clone(),
            touched: touched.clone(),
        });
        let end = match console.next(&mut stage).await? {
            ConsoleEvent::Key(key) => match key_use(key, &console.pad) {
                KeyUse::Take if touched.savable_result().is_some() => {
                    saves = true;
                    Some(End::Quit)
                }
                KeyUse::Take => {
                    take(&mut console, &mut touched);
                    (touched.savable_result().is_some() && !asks).then(|| {
                        saves = true;
                        End::Quit
                    })
                }
                KeyUse::TakeBack => {
                    touched.undo();
                    None
                }
                KeyUse::Move => {
                    let reply = console.pad.key(key, console.now());
                    console.carry_out(reply)
                }
            },
            other => console.handle_background(&other),
        };
        if let Some(end) = end {
            break end;
        }
    };
    stage.close()?;
    console.leave(end, out, json).await?;
    let found = touched.savable_result().cloned();
    Ok(found.map(|found| Outcome { found, saves }))
}

/// Takes the arm's position as the next point.
fn take(console: &mut Console, touched: &mut Touched) {
    if touched.result.is_some() {
        console
            .pad
            .say(Tone::Bad, "Backspace undoes the last point");
        return;
    }
    let Some(status) = console.observed.arm.status.as_ref() else {
        return;
    };
    if console.pad.pendant.activity.is_some() || !console.observed.arm.is_at_rest() {
        console.pad.say(
            Tone::Bad,
            "the arm is moving: take the point after it has stopped",
        );
        return;
    }
    let pose = &status.pose;
    let touch = Touch {
        pose: [pose.x, pose.y, pose.z, pose.r].map(f64::from),
    };
    if let Some(nth) = touched.existing_point(&touch) {
        let text = format!(
            "point {} was taken here: move the tool to the next one",
            nth + 1
        );
        console.pad.say(Tone::Bad, text);
        return;
    }
    touched.add(touch);
    let nth = touched.touches.len();
    console.observed.note(format!("point {nth} taken"));
}

/// Returns the use of a key: Enter and Backspace are the session's, unless the pad asks a question
/// or shows its help.
fn key_use(key: KeyEvent, pad: &Pad) -> KeyUse {
    let pressed = key.kind == KeyEventKind::Press && key.modifiers == KeyModifiers::NONE;
    if !pressed || pad.help.is_some() || pad.question.is_some() {
        return KeyUse::Move;
    }
    match key.code {
        KeyCode::Enter => KeyUse::Take,
        KeyCode::Backspace => KeyUse::TakeBack,
        _ => KeyUse::Move,
    }
}
