//! What all programs share that take a whole terminal: the screen and its giving back, keys, colours, and the parts that
//! their pictures are made of.
//!
//! They draw on stderr, so that stdout stays what it is elsewhere: for results. A picture has a thread of its own
//! ([`Shown`]), so that neither a slow terminal nor a key keeps the line to the arm waiting.

mod keyboard;
mod panel;
mod screen;
mod shown;
#[cfg(test)]
pub(crate) mod test;
mod theme;

use std::time::Duration;

pub(crate) use keyboard::{Keyboard, Waited};
pub(crate) use panel::{help, hints, lamp, mm, panel};
pub(crate) use screen::{Screen, check};
pub(crate) use shown::{Shown, hung_up};
pub(crate) use theme::Theme;

/// No two frames are nearer than this.
pub(crate) const FRAME: Duration = Duration::from_millis(50);
