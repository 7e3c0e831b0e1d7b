//! What a person has to confirm: the laser of a real arm, and unusual jobs.

use std::io::{self, IsTerminal, Write};

use magician::{Arm, ErrorCode, Set, Target, burns};

use crate::context::{Context, StopPolicy};
use crate::failure::{Failure, GOGGLES};

/// Whether a person at the terminal may be asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Asks {
    AtTheTerminal,
    /// What is on stdin is a file.
    Never,
}

/// The arm for what needs to know where it is: one that is not known to be homed is refused, or taken with `--unhomed`.
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
    /// Whether the arm is a virtual one, in this process or of a station: everything else counts as real.
    pub(crate) fn is_virtual(&mut self) -> Result<bool, Failure> {
        match self.connected() {
            Some(arm) => Ok(arm.is_virtual()),
            None if self.global.station.is_some() => {
                self.arm(StopPolicy::Look, async |arm, _| Ok(arm.is_virtual()))
            }
            None => Ok(matches!(self.target(None)?, Target::Sim(_))),
        }
    }

    /// Whether a laser may be wired to the pins of the arm.
    pub(crate) fn laser_pins(&mut self) -> Result<bool, Failure> {
        let port = self.port()?;
        Ok(self.config()?.laser_is_mounted(port.as_deref()))
    }

    /// Lets what burns of these commands burn during this verb, once a person has said so; nothing has been sent by then.
    /// Whether any does.
    pub(crate) fn permit<'a>(
        &mut self,
        commands: impl IntoIterator<Item = &'a Set>,
    ) -> Result<bool, Failure> {
        let pins = self.laser_pins()?;
        let burns = commands.into_iter().any(|command| burns(command, pins));
        if burns {
            self.permit_laser(Asks::AtTheTerminal)?;
        }
        Ok(burns)
    }

    /// Lets the laser burn during this verb, once a person has said so.
    pub(crate) fn permit_laser(&mut self, asks: Asks) -> Result<(), Failure> {
        self.ask_for_laser(asks, "this lights the laser of the arm")
    }

    /// Lets the queue run during this verb. If commands of another program wait in it, a person has to confirm: they may
    /// burn, and cannot be read back.
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
            let what = "commands of another program wait in the queue and could light the \
                    laser of the arm";
            self.ask_for_laser(Asks::AtTheTerminal, what)
        } else {
            Ok(())
        }
    }

    fn ask_for_laser(&mut self, asks: Asks, what: &str) -> Result<(), Failure> {
        if self.laser_is_allowed() || self.is_virtual()? {
            return Ok(());
        }
        let place = match self.port()? {
            Some(port) => format!("{what} at {port}"),
            None => what.to_owned(),
        };
        if self.may_ask(asks) && says_yes(&format!("{place}: {GOGGLES}"))? {
            self.allow_laser();
            return Ok(());
        }
        Err(Failure::not_allowed_to_burn(format!(
            "{place}; nothing was sent"
        )))
    }

    /// Asks for confirmation of something unusual; `--yes` confirms it.
    pub(crate) fn confirm(&mut self, asks: Asks, what: &str) -> Result<(), Failure> {
        if self.global.yes || self.may_ask(asks) && says_yes(what)? {
            return Ok(());
        }
        Err(Failure::usage(format!("{what}; nothing was sent")).hint("give --yes to go on"))
    }

    /// Whether a person is there to be asked.
    fn may_ask(&self, asks: Asks) -> bool {
        let person = io::stdin().is_terminal() && io::stderr().is_terminal();
        asks == Asks::AtTheTerminal && person && !self.global.json
    }
}

/// Asks on stderr.
fn says_yes(what: &str) -> io::Result<bool> {
    let mut stderr = io::stderr();
    write!(stderr, "{what}. Go on? y/n ")?;
    stderr.flush()?;
    let mut line = String::new();
    io::stdin().read_line(&mut line)?;
    Ok(matches!(
        line.trim().to_ascii_lowercase().as_str(),
        "y" | "yes"
    ))
}
