//! Parts of full-screen terminal programs: taking and restoring the screen, keys, colours, and
//! widgets.
//!
//! They draw on stderr, so that stdout stays free for results. The picture has its own thread
//! ([`Shown`]), so that neither a slow terminal nor a key delays the connection to the arm.

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

/// Shortest time between two frames. A choice: 20 frames a second look smooth, and more would load
/// a terminal over SSH.
pub(crate) const FRAME: Duration = Duration::from_millis(50);
