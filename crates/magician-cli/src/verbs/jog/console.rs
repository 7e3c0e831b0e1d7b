//! Connection, observed state and jog pad, shared by programs with all three.

use std::time::Instant;

use magician::Arm;
use magician_job::Polled;
use magician_job::jog::{PendantEvent, PendantSession, device_name};
use magician_job::report::outputs_left_on;
use ratatui::crossterm::event::{Event, KeyEvent};
use tokio::time::{Duration, timeout};

use super::pad::{KeyEffect, Pad, Tone};
use super::wording;
use crate::context::{INTERRUPTED, STOP_CONFIRM_TIMEOUT, not_confirmed, stop};
use crate::failure::{Failure, Kind};
use crate::output::Output;
use crate::saved::SavedSettings;
use crate::terminal::{FullScreen, ObservedArm, TerminalEvent, take_log};

/// Event for a program with a jog pad.
#[derive(Debug)]
pub(crate) enum ConsoleEvent {
    Key(KeyEvent),
    /// Pasted text, which must not act as keys.
    Pasted(String),
    /// An order is complete; the pad has been informed.
    Done,
    /// New readings, or another change to show.
    Updated,
    Beat,
    /// The window has lost the focus.
    FocusLost,
    /// The terminal is gone.
    Gone,
}

/// Reason why the program ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    Quit,
    /// Ctrl-C, or loss of the terminal.
    Interrupt,
}

pub(crate) struct Console {
    arm: Arm,
    pub(crate) observed: ObservedArm,
    pub(crate) pad: Pad,
    pub(crate) session: PendantSession,
    saved: SavedSettings,
    begun: Instant,
}

impl Console {
    /// Connects a pad to the arm and reads its state.
    pub(crate) async fn open(arm: &Arm, saved: &SavedSettings) -> Result<Self, Failure> {
        let (session, pendant) = PendantSession::open(arm, saved).await?;
        let (_, places) = arm.stats().await?;
        Ok(Self {
            observed: ObservedArm::new(title(arm).await?, places),
            pad: Pad::new(pendant),
            session,
            saved: saved.clone(),
            arm: arm.clone(),
            begun: Instant::now(),
        })
    }

    /// Waits for the next event.
    pub(crate) async fn next<M: Send + 'static>(
        &mut self,
        stage: &mut FullScreen<M>,
    ) -> Result<ConsoleEvent, Failure> {
        let event = tokio::select! {
            biased;
            told = stage.next() => match told {
                TerminalEvent::Event(Event::Key(key)) => ConsoleEvent::Key(key),
                TerminalEvent::Event(Event::FocusLost) => ConsoleEvent::FocusLost,
                TerminalEvent::Event(Event::Paste(text)) => ConsoleEvent::Pasted(text),
                TerminalEvent::Event(_) => ConsoleEvent::Updated,
                TerminalEvent::Beat => ConsoleEvent::Beat,
                TerminalEvent::Gone => ConsoleEvent::Gone,
            },
            event = self.session.next() => self.take(event?),
        };
        for line in take_log() {
            self.observed.note(line);
        }
        self.note_motion();
        self.observed.arm.tick(Instant::now());
        Ok(event)
    }

    /// Handles an event of the pendant.
    fn take(&mut self, event: PendantEvent) -> ConsoleEvent {
        match event {
            PendantEvent::Done(done) => {
                self.pad.done(&done);
                if let Err(error) = &done.outcome {
                    self.observed.note(wording::failure(error).fact());
                }
                return ConsoleEvent::Done;
            }
            PendantEvent::Status(status) => self.observed.arm.observe(status),
            PendantEvent::Arm(event) => self.observed.note(event.to_string()),
            PendantEvent::Rail(rail) => self.observed.arm.rail = Some(rail),
            _ => {}
        }
        ConsoleEvent::Updated
    }

    /// Passes the cause of the arm's motion to the pad and the observed state.
    fn note_motion(&mut self) {
        self.pad.pendant.activity = self.session.activity();
        if self.pad.pendant.activity.is_some() {
            self.observed.arm.mark_moving();
        }
    }

    /// Returns the time since the beginning, the pad's clock.
    pub(crate) fn now(&self) -> Duration {
        self.begun.elapsed()
    }

    /// Carries out the reply to a key.
    pub(crate) fn carry_out(&mut self, reply: KeyEffect) -> Option<End> {
        match reply {
            KeyEffect::Order(order) => {
                if let Some(done) = self.session.order(order) {
                    self.pad.done(&done);
                }
                self.note_motion();
            }
            KeyEffect::Quit => return Some(End::Quit),
            KeyEffect::Interrupt => return Some(End::Interrupt),
            KeyEffect::Unknown => self.pad.say(Tone::Plain, "? lists the keys"),
            KeyEffect::Nothing => {}
        }
        None
    }

    /// Handles events that need no decision of the program: everything except keys.
    pub(crate) fn handle_background(&mut self, event: &ConsoleEvent) -> Option<End> {
        match event {
            ConsoleEvent::Beat => {
                let reply = self.pad.beat(self.now());
                self.carry_out(reply)
            }
            ConsoleEvent::FocusLost => {
                let reply = self.pad.focus_lost();
                self.carry_out(reply)
            }
            ConsoleEvent::Gone => Some(End::Interrupt),
            _ => None,
        }
    }

    /// Stops the arm, switches the laser off and restores its settings. Prints a note if suction or
    /// gripper stays on.
    pub(crate) async fn leave(self, end: End, out: &mut Output, json: bool) -> Result<(), Failure> {
        let ended = match end {
            End::Quit => self
                .session
                .close(&self.pad.pendant)
                .await
                .map_err(Failure::from),
            End::Interrupt => {
                drop(self.session);
                let stopped = timeout(
                    STOP_CONFIRM_TIMEOUT,
                    stop(&self.arm, &self.saved, INTERRUPTED),
                )
                .await;
                let message = match stopped {
                    Ok(Ok(message) | Err(message)) => message,
                    Err(_) => not_confirmed(INTERRUPTED, "it took too long"),
                };
                Err(Failure::new(Kind::Interrupted, message))
            }
        };
        for note in outputs_left_on(&self.arm.outputs()) {
            out.note(&note, json);
        }
        ended
    }
}

/// Waits for the next reading; `None` at once if nothing is polled.
pub(crate) async fn next_of<T: Clone + Send + Sync + 'static>(
    polled: &mut Option<Polled<T>>,
) -> Option<T> {
    match polled {
        Some(polled) => Some(polled.next().await),
        None => None,
    }
}

/// Returns the arm's name and place.
pub(crate) async fn title(arm: &Arm) -> Result<String, Failure> {
    let name = device_name(arm).await?;
    Ok(if name.is_empty() {
        arm.name().to_owned()
    } else {
        format!("{} | {name}", arm.name())
    })
}
