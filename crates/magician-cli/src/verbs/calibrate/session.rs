//! Session at the terminal in which the user touches points with the jog pad.

use magician::Arm;
use magician_program::{Diagnostic, Tool};
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use super::subject::{Found, Subject, Touch};
use super::view;
use crate::failure::Failure;
use crate::output::Output;
use crate::saved::SavedSettings;
use crate::terminal::{Seen, Stage};
use crate::verbs::jog::{Console, End, Happened, Pad, Tone};

/// Distance below which two points count as the same, touched twice by mistake; mm and deg.
const SAME: f64 = 2.0;

/// Result of the session and the decision about saving.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Outcome {
    pub(super) found: Found,
    pub(super) saves: bool,
}

/// Contents of a frame of the session.
#[derive(Clone, Debug)]
pub(super) struct Model {
    pub(super) seen: Seen,
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
    pub(super) result: Option<Result<Found, Diagnostic>>,
}

/// Use of a key in this session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wish {
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

    pub(super) fn take(&mut self, touch: Touch) {
        self.touches.push(touch);
        if self.touches.len() == self.subject.points().len() {
            self.result = Some(self.subject.found(&self.touches, self.tool));
        }
    }

    /// Returns the index of an earlier point at the same place. A tool is calibrated at one point
    /// from two angles of the wrist, which are different poses.
    fn is_there(&self, touch: &Touch) -> Option<usize> {
        let near = |other: &Touch| {
            let apart = other.pose.iter().zip(touch.pose);
            let far = apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            far < SAME
        };
        self.touches.iter().position(near)
    }

    fn take_back(&mut self) {
        self.touches.pop();
        self.result = None;
    }

    /// Returns the result if it may be saved.
    fn good(&self) -> Option<&Found> {
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
        .seen
        .note(format!("the arm's poses are for the tool {tool}"));
    let mut touched = Touched::new(subject, tool);
    let mut stage = Stage::open(view::draw)?;
    let mut saves = false;
    let end = loop {
        stage.show(Model {
            seen: console.seen.clone(),
            pad: console.pad.clone(),
            touched: touched.clone(),
        });
        let end = match console.next(&mut stage).await? {
            Happened::Key(key) => match wish(key, &console.pad) {
                Wish::Take if touched.good().is_some() => {
                    saves = true;
                    Some(End::Quit)
                }
                Wish::Take => {
                    take(&mut console, &mut touched);
                    (touched.good().is_some() && !asks).then(|| {
                        saves = true;
                        End::Quit
                    })
                }
                Wish::TakeBack => {
                    touched.take_back();
                    None
                }
                Wish::Move => {
                    let reply = console.pad.key(key, console.now());
                    console.obey(reply)
                }
            },
            other => console.attend(&other),
        };
        if let Some(end) = end {
            break end;
        }
    };
    stage.close()?;
    console.leave(end, out, json).await?;
    let found = touched.good().cloned();
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
    let Some(status) = console.seen.arm.status.as_ref() else {
        return;
    };
    if console.pad.pendant.activity.is_some() || !console.seen.arm.is_at_rest() {
        console.pad.say(
            Tone::Bad,
            "the arm is moving: take the point when it has stopped",
        );
        return;
    }
    let pose = &status.pose;
    let touch = Touch {
        pose: [pose.x, pose.y, pose.z, pose.r].map(f64::from),
    };
    if let Some(nth) = touched.is_there(&touch) {
        let text = format!(
            "point {} was taken here: move the tool to the next one",
            nth + 1
        );
        console.pad.say(Tone::Bad, text);
        return;
    }
    touched.take(touch);
    let nth = touched.touches.len();
    console.seen.note(format!("point {nth} taken"));
}

/// Returns the use of a key: Enter and Backspace are the session's, unless the pad asks a question
/// or shows its help.
fn wish(key: KeyEvent, pad: &Pad) -> Wish {
    let pressed = key.kind == KeyEventKind::Press && key.modifiers == KeyModifiers::NONE;
    if !pressed || pad.help.is_some() || pad.question.is_some() {
        return Wish::Move;
    }
    match key.code {
        KeyCode::Enter => Wish::Take,
        KeyCode::Backspace => Wish::TakeBack,
        _ => Wish::Move,
    }
}
