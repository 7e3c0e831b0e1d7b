//! State of the picture between frames, and the effects of keys.

use std::collections::VecDeque;

use magician::serve::{Ended, Handle};
use magician_motion::{Limits, TopView};
use magician_protocol::Alarm;
use magician_sim::scenario::{Conveyor, Table};
use magician_sim::{ExternalEvent, Runner};

use super::arm_view::{ArmView, Cursor, Push, pushed};
use super::feed::{Feed, FeedState};
use super::keys::{self, Action, Axis, Mode, Nudge, Question};
use crate::terminal::Help;

/// Arm that can be shown.
#[derive(Clone, Debug)]
pub(in crate::verbs::sim) struct Subject {
    pub(in crate::verbs::sim) handle: Handle,
    pub(in crate::verbs::sim) feed: Feed,
    /// Kind of the arm.
    pub(in crate::verbs::sim) title: String,
    pub(in crate::verbs::sim) limits: Limits,
    pub(in crate::verbs::sim) table: Option<Table>,
    pub(in crate::verbs::sim) conveyor: Option<Conveyor>,
}

/// Reason why the picture ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::verbs::sim) enum End {
    /// The user quit.
    Quit,
    /// Ctrl-C.
    Interrupt,
    /// The terminal is gone.
    Gone,
    /// The arm is no longer served.
    Served,
}

/// Earlier position of the tool, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tip {
    /// x and y, as seen from above.
    pub(super) above: [f64; 2],
    /// r and z, as seen from the side.
    pub(super) beside: [f64; 2],
}

/// Largest number of earlier positions kept.
const MAX_TRAIL: usize = 600;
/// Distance from the last kept position at which another one is kept, mm.
const TRAIL_SPACING: f64 = 0.5;
/// Largest number of corners of the drawing kept.
const MAX_CORNERS: usize = 20_000;

/// Distance of one push by hand: along an axis in mm, and of a joint in deg.
const COARSE_PUSH: (f64, f64) = (5.0, 2.0);
const FINE_PUSH: (f64, f64) = (0.5, 0.2);

/// State of the picture.
pub(super) struct App {
    subjects: Vec<Subject>,
    shown: usize,
    pub(super) mode: Mode,
    /// Direction from which the arm is seen: arrow keys move where they point.
    pub(super) view: TopView,
    /// Result of the last key.
    pub(super) message: Option<String>,
    pub(super) joint: u8,
    pub(super) fine: bool,
    pub(super) feed_state: FeedState,
    pub(super) trail: VecDeque<Tip>,
    pub(super) ink: VecDeque<Vec<[f64; 2]>>,
    corners: usize,
    cursor: Cursor,
    /// Level to which each input was driven, by address less one.
    driven: [bool; 20],
    pub(super) look: Option<ArmView>,
}

impl App {
    /// Creates the state, showing the first arm. There is at least one.
    pub(super) fn new(subjects: Vec<Subject>) -> Self {
        Self {
            subjects,
            shown: 0,
            mode: Mode::Watch,
            view: TopView::BEHIND,
            message: None,
            joint: 1,
            fine: false,
            feed_state: FeedState::default(),
            trail: VecDeque::new(),
            ink: VecDeque::new(),
            corners: 0,
            cursor: Cursor::default(),
            driven: [false; 20],
            look: None,
        }
    }

    /// Returns the arm that is shown.
    pub(super) fn subject(&self) -> &Subject {
        &self.subjects[self.shown]
    }

    /// Returns the number of the arm shown, from 1, and the number of arms.
    pub(super) fn number(&self) -> (usize, usize) {
        (self.shown + 1, self.subjects.len())
    }

    /// True if the arm's unlock key is held.
    pub(super) fn is_unlocked(&self) -> bool {
        self.look.as_ref().is_some_and(|look| look.state.unlocked)
    }

    /// Reads the arm's state. Returns true if anything has changed.
    pub(super) fn refresh(&mut self) -> Result<bool, Ended> {
        let cursor = self.cursor;
        let take = move |runner: &mut Runner| ArmView::at(runner.controller(), cursor);
        let look = self.subject().handle.with(take).wait()?;
        let handle = &self.subjects[self.shown].feed;
        let told = handle.update_from(&mut self.feed_state);
        Ok(self.replace_view(look) | told)
    }

    /// Replaces the state shown. Returns true if it has changed.
    pub(super) fn replace_view(&mut self, mut look: ArmView) -> bool {
        let ink = std::mem::take(&mut look.ink);
        let drawn = !ink.strokes.is_empty();
        if drawn {
            self.cursor = ink.until;
            self.draw(ink.strokes);
        }
        let figure = look.figure();
        self.follow(Tip {
            above: figure.tip_above(),
            beside: figure.tip,
        });
        let new = self.look.as_ref() != Some(&look);
        self.look = Some(look);
        new || drawn
    }

    fn draw(&mut self, strokes: Vec<Vec<[f64; 2]>>) {
        for stroke in strokes {
            self.corners += stroke.len();
            self.ink.push_back(stroke);
        }
        while self.corners > MAX_CORNERS
            && let Some(stroke) = self.ink.pop_front()
        {
            self.corners -= stroke.len();
        }
    }

    fn follow(&mut self, tip: Tip) {
        let apart = |[a, b]: [f64; 2], [c, d]: [f64; 2]| (a - c).hypot(b - d) > TRAIL_SPACING;
        let moved = self
            .trail
            .back()
            .is_none_or(|last| apart(last.above, tip.above) || apart(last.beside, tip.beside));
        if moved {
            if self.trail.len() == MAX_TRAIL {
                self.trail.pop_front();
            }
            self.trail.push_back(tip);
        }
    }

    /// Carries out the action of a key. Returns the reason if it ends the picture.
    pub(super) fn act(&mut self, action: Action) -> Result<Option<End>, Ended> {
        if action != Action::Nothing {
            self.message = None;
        }
        match action {
            Action::Quit => return Ok(Some(End::Quit)),
            Action::Interrupt => return Ok(Some(End::Interrupt)),
            Action::Press(press) => self.inject(ExternalEvent::Key(press))?,
            Action::Reset => self.inject(ExternalEvent::Reset)?,
            Action::Unlock => self.inject(ExternalEvent::Unlock(!self.is_unlocked()))?,
            Action::Nudge(nudge) => self.nudge(nudge)?,
            Action::Cable => self.pull_or_plug()?,
            Action::Toggle => self.toggle()?,
            Action::Answer => self.answer()?,
            Action::Turn(by) => self.turn(by),
            other => self.follow_key(other),
        }
        Ok(None)
    }

    /// Carries out an action that only changes the picture.
    fn follow_key(&mut self, action: Action) {
        match (action, &mut self.mode) {
            (Action::Help, mode) => *mode = Mode::Help(Help::default()),
            (Action::Page(code), mode) => {
                let Mode::Help(help) = *mode else { return };
                *mode = help.after(code).map_or(Mode::Watch, Mode::Help);
            }
            (Action::View, _) => self.view = self.view.turned(),
            (Action::Leave, mode) => *mode = Mode::Watch,
            (Action::Inputs, mode) => {
                let (address, typed) = (1, false);
                *mode = Mode::Inputs { address, typed };
            }
            (Action::Ask(question), mode) => {
                let text = question.suggestion().to_owned();
                *mode = Mode::Ask { question, text };
            }
            (Action::Type(typed), Mode::Ask { text, .. }) if text.len() < 40 => text.push(typed),
            (Action::Erase, Mode::Ask { text, .. }) => drop(text.pop()),
            (Action::Step(by), Mode::Inputs { address, typed }) => {
                (*address, *typed) = (keys::stepped(*address, by), false);
            }
            (Action::Digit(digit), Mode::Inputs { address, typed }) => {
                (*address, *typed) = (keys::with_digit(*address, *typed, digit), true);
            }
            (Action::Fine, _) => self.fine = !self.fine,
            (Action::Joint(joint), _) => self.joint = joint,
            _ => {}
        }
    }

    /// Shows another arm.
    fn turn(&mut self, by: isize) {
        let (count, shown, view) = (self.subjects.len(), self.shown, self.view);
        let subjects = std::mem::take(&mut self.subjects);
        *self = Self::new(subjects);
        self.view = view;
        self.shown = shown.wrapping_add_signed(by).wrapping_add(count) % count.max(1);
    }

    fn inject(&self, happening: ExternalEvent) -> Result<(), Ended> {
        let inject = move |runner: &mut Runner| runner.controller_mut().inject(happening);
        self.subject().handle.with(inject).wait()
    }

    fn pull_or_plug(&self) -> Result<(), Ended> {
        let handle = &self.subject().handle;
        let plugged = self
            .look
            .as_ref()
            .is_none_or(|look| look.state.line.plugged);
        if plugged {
            handle.unplug().wait()
        } else {
            handle.plug().wait()
        }
    }

    fn nudge(&mut self, nudge: Nudge) -> Result<(), Ended> {
        let (mm, degrees) = if self.fine { FINE_PUSH } else { COARSE_PUSH };
        let sign = if nudge.forward { 1.0 } else { -1.0 };
        let flat = |way: [f64; 2]| {
            let [x, y] = self.view.unproject(way.map(|part| part * sign * mm));
            Push::Tool([x, y, 0.0])
        };
        let push = match nudge.axis {
            Axis::Right => flat([1.0, 0.0]),
            Axis::Ahead => flat([0.0, 1.0]),
            Axis::Z => Push::Tool([0.0, 0.0, sign * mm]),
            Axis::Joint => Push::Joint(self.joint, sign * degrees),
        };
        let limits = self.subject().limits;
        let guide = move |runner: &mut Runner| {
            let controller = runner.controller_mut();
            let joints = pushed(&controller.state(), &limits, push)?;
            controller.guide(joints);
            Ok(())
        };
        let outcome: Result<(), String> = self.subject().handle.with(guide).wait()?;
        self.message = outcome.err().map(|why| format!("limit reached: {why}"));
        Ok(())
    }

    /// Drives the selected input to the other level.
    fn toggle(&mut self) -> Result<(), Ended> {
        let Mode::Inputs { address, .. } = self.mode else {
            return Ok(());
        };
        let driven = self.driven.get_mut(usize::from(address).saturating_sub(1));
        let Some(driven) = driven else {
            return Ok(());
        };
        *driven = !*driven;
        let level = *driven;
        let drive = move |runner: &mut Runner| runner.controller_mut().set_input(address, level);
        self.subject().handle.with(drive).wait()?;
        let level = if level { "high" } else { "low" };
        self.message = Some(format!("input {address} is driven {level}"));
        Ok(())
    }

    /// Carries out the typed answer if it is valid.
    fn answer(&mut self) -> Result<(), Ended> {
        let Mode::Ask { question, text } = &self.mode else {
            return Ok(());
        };
        let happening = match question {
            Question::Alarm => keys::alarm(text).map(ExternalEvent::Alarm),
            Question::Slip => {
                keys::slip(text).map(|(joint, degrees)| ExternalEvent::Slip { joint, degrees })
            }
        };
        match happening {
            Some(happening) => {
                self.inject(happening)?;
                self.mode = Mode::Watch;
            }
            None => self.message = Some(question.example().to_owned()),
        }
        Ok(())
    }
}

impl Question {
    /// Returns the initial text of the answer.
    fn suggestion(self) -> &'static str {
        match self {
            Self::Alarm => "",
            Self::Slip => "2 8",
        }
    }

    pub(super) fn prompt(self) -> &'static str {
        match self {
            Self::Alarm => "raise alarm 0x",
            Self::Slip => "slip, joint and deg: ",
        }
    }

    fn example(self) -> &'static str {
        match self {
            Self::Alarm => "enter two hexadecimal digits, such as 12",
            Self::Slip => "enter a joint, 1 to 4, and degrees, such as 2 8 or 3 -1.5",
        }
    }

    /// Describes the meaning of the text typed so far.
    pub(super) fn meaning(self, text: &str) -> String {
        match self {
            Self::Alarm => {
                let alarm = keys::alarm(text).map(Alarm::with_code);
                match alarm {
                    Some(Some(alarm)) => format!("{}: {}", alarm.name, alarm.cause),
                    Some(None) => "unknown alarm".to_owned(),
                    None => String::new(),
                }
            }
            Self::Slip => match keys::slip(text) {
                Some((joint, degrees)) => format!("J{joint} by {degrees} deg"),
                None => String::new(),
            },
        }
    }
}
