//! Confirmations by the user: the laser of a real arm, and unusual jobs.
//!
//! The driver refuses whatever may burn without permission. The command obtains it before it
//! connects or sends: `--yes`, or a question on the terminal. A virtual arm needs none.

use std::io::{self, IsTerminal, Write};

use magician::{Arm, ErrorCode, Set, Target, burns};

use crate::context::{Context, StopPolicy};
use crate::failure::{Failure, GOGGLES_ADVICE};

/// Source of a confirmation that `--yes` does not give.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ConfirmationSource {
    AtTheTerminal,
    /// Never asks: standard input is the file to run.
    Never,
}

/// Returns the arm for work that depends on its position. Refused if the arm is not known to be
/// homed, unless `unhomed` is set.
pub(crate) async fn homed(arm: &Arm, unhomed: bool) -> Result<Arm, Failure> {
    let arm = if unhomed {
        arm.allowing_unhomed()
    } else {
        arm.clone()
    };
    arm.homing().check().await?;
    Ok(arm)
}

impl Context {
    /// True if the arm is virtual, in this process or at a station; anything else counts as real.
    pub(crate) fn is_virtual(&mut self) -> Result<bool, Failure> {
        match self.connected() {
            Some(arm) => Ok(arm.is_virtual()),
            None if self.global.station.is_some() => {
                self.arm(StopPolicy::Look, async |arm, _| Ok(arm.is_virtual()))
            }
            None => Ok(matches!(self.target(None)?, Target::Sim(_))),
        }
    }

    /// True if a laser may be wired to the arm's pins.
    pub(crate) fn laser_pins(&mut self) -> Result<bool, Failure> {
        let port = self.port()?;
        Ok(self.config()?.laser_is_mounted(port.as_deref()))
    }

    /// Asks the user before commands that may burn, and allows them for this verb. Nothing has been
    /// sent by then. Returns true if any of the commands may burn.
    pub(crate) fn permit<'a>(
        &mut self,
        commands: impl IntoIterator<Item = &'a Set>,
    ) -> Result<bool, Failure> {
        let pins = self.laser_pins()?;
        let burns = commands.into_iter().any(|command| burns(command, pins));
        if burns {
            self.permit_laser(ConfirmationSource::AtTheTerminal)?;
        }
        Ok(burns)
    }

    /// Asks the user and allows the laser for this verb.
    pub(crate) fn permit_laser(&mut self, source: ConfirmationSource) -> Result<(), Failure> {
        self.ask_for_laser(source, "this lights the laser of the arm")
    }

    /// Allows the queue to run during this verb. If it holds commands of another program the user
    /// must confirm: they may burn, and the protocol cannot read them back.
    pub(crate) fn permit_queue(&mut self) -> Result<(), Failure> {
        if self.laser_is_allowed() || self.is_virtual()? {
            return Ok(());
        }
        let refused = self.arm(StopPolicy::Look, async |arm, _| {
            match arm.permission().check_queue().await {
                Err(error) if error.code() == ErrorCode::LaserNotAllowed => Ok(true),
                other => Ok(other.map(|()| false)?),
            }
        })?;
        if refused {
            let what = "commands of another program wait in the queue and could light the laser of the arm";
            self.ask_for_laser(ConfirmationSource::AtTheTerminal, what)
        } else {
            Ok(())
        }
    }

    fn ask_for_laser(&mut self, source: ConfirmationSource, what: &str) -> Result<(), Failure> {
        if self.laser_is_allowed() || self.is_virtual()? {
            return Ok(());
        }
        let place = match self.port()? {
            Some(port) => format!("{what} at {port}"),
            None => what.to_owned(),
        };
        if self.may_ask(source) && ask_yes_no(&format!("{place}: {GOGGLES_ADVICE}"))? {
            self.allow_laser();
            return Ok(());
        }
        Err(Failure::burn_not_allowed(format!(
            "{place}; nothing was sent"
        )))
    }

    /// Asks the user to confirm something unusual; `--yes` confirms it in advance.
    pub(crate) fn confirm(
        &mut self,
        source: ConfirmationSource,
        what: &str,
    ) -> Result<(), Failure> {
        if self.global.yes || self.may_ask(source) && ask_yes_no(what)? {
            return Ok(());
        }
        Err(Failure::usage(format!("{what}; nothing was sent")).hint("--yes continues"))
    }

    /// True if a user is at the terminal to answer.
    fn may_ask(&self, source: ConfirmationSource) -> bool {
        let person = io::stdin().is_terminal() && io::stderr().is_terminal();
        source == ConfirmationSource::AtTheTerminal && person && !self.global.json
    }
}

/// Asks a question on stderr; true if the answer is yes.
fn ask_yes_no(what: &str) -> io::Result<bool> {
    let mut stderr = io::stderr();
    write!(stderr, "{what}. Continue? y/n ")?;
    stderr.flush()?;
    let mut line = String::new();
    io::stdin().read_line(&mut line)?;
    Ok(matches!(
        line.trim().to_ascii_lowercase().as_str(),
        "y" | "yes"
    ))
}
