//! What all programs share that take a whole terminal: the screen and its giving back, keys, colours, and the parts that
//! their pictures are made of.
//!
//! They draw on stderr, so that stdout stays what it is elsewhere: for results. A picture has a thread of its own
//! ([`Shown`]), so that neither a slow terminal nor a key keeps the line to the arm waiting.

mod alarms;
mod help;
mod keyboard;
mod panel;
mod screen;
mod seen;
mod shown;
mod stage;
#[cfg(test)]
pub(crate) mod test;
mod theme;

use std::time::Duration;

pub(crate) use alarms::alarm_lines;
pub(crate) use help::Help;
pub(crate) use keyboard::{Keyboard, Waited};
pub(crate) use panel::{arrow, fitted, lamp, log_lines, mm, panel, said, thirds, wrapped};
pub(crate) use screen::{Listen, LogWriter, Screen, check, take_log};
pub(crate) use seen::{Seen, sparkline};
pub(crate) use shown::{Shown, Suspends, hung_up};
pub(crate) use stage::{Stage, Told};
pub(crate) use theme::Theme;

/// No two frames are nearer than this.
pub(crate) const FRAME: Duration = Duration::from_millis(50);
