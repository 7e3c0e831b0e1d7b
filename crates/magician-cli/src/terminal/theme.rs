//! Styles of terminal pictures, with and without colours.

use magician::Alarm;
use magician_motion::Range;
use ratatui::style::{Color, Modifier, Style};

use crate::paint::Paint;

/// Distance to a joint limit below which the angle is highlighted, deg.
const NEAR_LIMIT: f64 = 5.0;

/// Set of styles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Theme {
    colored: bool,
}

impl Theme {
    pub(crate) fn for_stderr() -> Self {
        let colored = Paint::for_stderr().is_on();
        Self { colored }
    }

    #[cfg(test)]
    pub(crate) const PLAIN: Self = Self { colored: false };
    #[cfg(test)]
    pub(crate) const COLORED: Self = Self { colored: true };

    /// Returns a colour for drawing on a canvas.
    pub(crate) fn ink(self, color: Color) -> Color {
        if self.colored { color } else { Color::Reset }
    }

    fn style(self, color: Color, without: Modifier) -> Style {
        if self.colored {
            Style::new().fg(color)
        } else {
            Style::new().add_modifier(without)
        }
    }

    /// Style of entries in order and of lit indicators.
    pub(crate) fn good(self) -> Style {
        self.style(Color::Green, Modifier::BOLD)
    }

    /// Style of entries that need attention.
    pub(crate) fn note(self) -> Style {
        self.style(Color::Yellow, Modifier::BOLD)
    }

    /// Style of errors.
    pub(crate) fn bad(self) -> Style {
        self.style(Color::Red, Modifier::REVERSED)
    }

    /// Style of an alarm, by whether it blocks the queue.
    pub(crate) fn alarm(self, code: u8) -> Style {
        if Alarm::blocks(code) {
            self.bad()
        } else {
            self.note()
        }
    }

    /// Style of a joint angle: inside its range, near an end, or outside.
    pub(crate) fn near(self, value: f64, range: Range) -> Style {
        match (range.max - value).min(value - range.min) {
            room if room < 0.0 => self.bad(),
            room if room < NEAR_LIMIT => self.note(),
            _ => Style::new(),
        }
    }

    /// Style of secondary text.
    pub(crate) fn dim(self) -> Style {
        self.style(Color::DarkGray, Modifier::DIM)
    }

    /// Style of keys and of the selection.
    pub(crate) fn key(self) -> Style {
        self.style(Color::Cyan, Modifier::BOLD)
            .add_modifier(Modifier::BOLD)
    }

    /// Style of a panel's title.
    pub(crate) fn title(self) -> Style {
        Style::new().add_modifier(Modifier::BOLD)
    }

    /// Style of the lines at top and bottom.
    pub(crate) fn bar(self) -> Style {
        Style::new().add_modifier(Modifier::REVERSED)
    }
}
