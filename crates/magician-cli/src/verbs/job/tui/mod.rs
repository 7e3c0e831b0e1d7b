//! Full-screen picture of a job: the drawing as it progresses, time left, queue, connection and
//! keys.

mod sheet;
mod view;

use std::cell::RefCell;
use std::io;
use std::rc::Rc;
use std::sync::Arc;
use std::time::Instant;

use magician::{Arm, Events, StateWatch};
use magician_job::Polled;
use ratatui::crossterm::event::{Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use tokio::task::spawn_blocking;
use tokio::time::sleep;

use self::sheet::Sheet;
use super::input::UserOrder;
use super::job_run::JobRun;
use super::keys::{self, is_in_foreground};
use crate::failure::Failure;
use crate::interrupt::{Control, Signal};
use crate::terminal::{FRAME_INTERVAL, FullScreen, ObservedArm, TerminalEvent, take_log};
use crate::verbs::jog::title;
use crate::verbs::watch::{Around, around};
pub(super) use view::Model;
#[cfg(test)]
pub(in crate::verbs) use view::tests::examples;

/// Readings a second. A choice.
const STATE_RATE: f64 = 10.0;

/// Model that the job's loop and the picture share.
pub(super) type SharedModel = Rc<RefCell<Model>>;

/// Screen of a job.
pub(super) struct Screen {
    /// `None` while the terminal is released.
    stage: Option<FullScreen<Model>>,
    /// True if the terminal shall be taken once this process is in the foreground.
    wanted: bool,
    model: SharedModel,
    state: StateWatch,
    around: Polled<Around>,
    events: Events,
}

/// Input that the job must act on.
pub(super) enum ScreenInput {
    UserOrder(UserOrder),
    /// Key, or loss of the terminal, that stands for a signal.
    Stop(Signal),
    Control(Control),
}

impl Screen {
    pub(super) async fn open(arm: &Arm, drive: &JobRun<'_>) -> Result<Self, Failure> {
        let (_, places) = arm.stats().await?;
        let observed = ObservedArm::new(title(arm).await?, places).with_reading_rate(STATE_RATE);
        let made = drive.made;
        let program = &made.prepared.program;
        let start = arm.preflight_for(&program.kinds()).await?;
        let outline = made.paper();
        // Computed on another thread, since a large program takes long and the arm must be served
        // meanwhile.
        let (plan, outline) = (program.clone(), outline.unwrap_or_default());
        let sheet = spawn_blocking(move || Sheet::of(&plan, &start, &outline)).await;
        let sheet = sheet.map_err(io::Error::other)?;
        let model = Model {
            verb: drive.verb,
            observed,
            around: Around::default(),
            sheet: Arc::new(sheet),
            doing: "running",
            step: 0,
            steps: program.steps(),
            round: 1,
            rounds: program.iterations(),
            left: None,
            help: None,
        };
        Ok(Self {
            stage: Some(FullScreen::open(view::draw)?),
            wanted: true,
            model: Rc::new(RefCell::new(model)),
            state: arm.state(STATE_RATE)?,
            around: around(arm),
            events: arm.events(),
        })
    }

    pub(super) fn model(&self) -> SharedModel {
        Rc::clone(&self.model)
    }

    /// Restores the terminal until it is taken again.
    pub(super) fn release(&mut self) {
        self.stage = None;
        self.wanted = false;
    }

    /// Takes the terminal again once this process is in the foreground.
    pub(super) fn take(&mut self) {
        self.wanted = true;
    }

    /// Restores the terminal for good.
    pub(super) fn close(self) -> Result<(), Failure> {
        self.stage.map_or(Ok(()), FullScreen::close)
    }

    /// Updates the picture until there is input.
    pub(super) async fn next(&mut self) -> ScreenInput {
        loop {
            if self.stage.is_none() && self.wanted && is_in_foreground() {
                // If the terminal cannot be drawn on, the job continues without a picture.
                self.stage = FullScreen::open(view::draw).ok();
                self.wanted = self.stage.is_some();
            }
            {
                let mut model = self.model.borrow_mut();
                for line in take_log() {
                    model.observed.note(line);
                }
                model.observed.arm.tick(Instant::now());
                if let Some(stage) = &self.stage {
                    stage.show(model.clone());
                }
            }
            let told = async {
                match &mut self.stage {
                    Some(stage) => stage.next().await,
                    None => {
                        sleep(FRAME_INTERVAL).await;
                        TerminalEvent::Beat
                    }
                }
            };
            tokio::select! {
                biased;
                told = told => match told {
                    TerminalEvent::Event(Event::Key(key)) => {
                        if let Some(wants) = press(key, &mut self.model.borrow_mut()) {
                            return wants;
                        }
                    }
                    // Without a keyboard the user could not stop the job.
                    TerminalEvent::Gone => {
                        self.release();
                        return ScreenInput::Stop(Signal::HangUp);
                    }
                    TerminalEvent::Event(_) | TerminalEvent::Beat => {}
                },
                status = self.state.changed() => match status {
                    Ok(status) => self.model.borrow_mut().observed.arm.observe(status),
                    // The job sees the loss of the connection too; wait for its reaction.
                    Err(_) => sleep(FRAME_INTERVAL).await,
                },
                Some(event) = self.events.next() => {
                    self.model.borrow_mut().observed.note(event.to_string());
                }
                read = self.around.next() => self.model.borrow_mut().around = read,
            }
        }
    }
}

/// Returns the effect of a key; `None` if it only changes the picture.
fn press(key: KeyEvent, model: &mut Model) -> Option<ScreenInput> {
    if key.kind == KeyEventKind::Release {
        return None;
    }
    if key.modifiers.contains(KeyModifiers::CONTROL) {
        return match key.code {
            KeyCode::Char('c') => Some(ScreenInput::Stop(Signal::Interrupt)),
            KeyCode::Char('z') if cfg!(unix) => Some(ScreenInput::Control(Control::Suspend)),
            _ => None,
        };
    }
    // Space and `s` stop the job even while help is shown.
    let typed = keys::order_of(&Event::Key(key));
    if let Some(shown) = model.help {
        model.help = shown.after(key.code);
        return typed
            .filter(|typed| *typed == UserOrder::Stop)
            .map(ScreenInput::UserOrder);
    }
    if matches!(key.code, KeyCode::Char('?') | KeyCode::F(1)) {
        model.help = Some(crate::terminal::Help::default());
        return None;
    }
    typed.map(ScreenInput::UserOrder)
}
