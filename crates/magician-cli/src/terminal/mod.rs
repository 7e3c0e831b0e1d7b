//! Parts of full-screen terminal programs: taking and restoring the screen, keys, colours, and
//! widgets.
//!
//! They draw on stderr, so that stdout stays free for results. The picture has its own thread
//! ([`PictureThread`]), so that neither a slow terminal nor a key delays the connection to the arm.

mod alarms;
mod full_screen;
mod help;
mod keyboard;
mod observed_arm;
mod panel;
mod picture_thread;
mod screen;
#[cfg(test)]
pub(crate) mod test;
mod theme;

use std::time::Duration;

pub(crate) use alarms::alarm_lines;
pub(crate) use full_screen::{FullScreen, TerminalEvent};
pub(crate) use help::Help;
pub(crate) use keyboard::{Keyboard, WaitResult};
pub(crate) use observed_arm::{ObservedArm, sparkline};
pub(crate) use panel::{
    arrow, fitted, header_body_footer, lamp, log_lines, message_lines, mm, panel, wrapped,
};
pub(crate) use picture_thread::{PictureThread, SuspendRequests, wait_for_hangup};
pub(crate) use screen::{EventKinds, LogWriter, Screen, check, take_log};
pub(crate) use theme::Theme;

/// Shortest time between two frames. A choice: 20 frames a second look smooth, and more would load
/// a terminal over SSH.
pub(crate) const FRAME_INTERVAL: Duration = Duration::from_millis(50);
