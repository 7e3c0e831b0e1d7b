//! Colours, or their lack.

use magician::Alarm;
use magician_motion::Range;
use ratatui::style::{Color, Modifier, Style};

use crate::paint::Paint;

/// So near to a limit a joint deserves a look, deg.
const NEAR: f64 = 5.0;

/// How a picture is painted.
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

    /// A colour on the canvas.
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

    /// What is as it should be, and lamps that are lit.
    pub(crate) fn good(self) -> Style {
        self.style(Color::Green, Modifier::BOLD)
    }

    /// What deserves a look.
    pub(crate) fn note(self) -> Style {
        self.style(Color::Yellow, Modifier::BOLD)
    }

    /// What is wrong.
    pub(crate) fn bad(self) -> Style {
        self.style(Color::Red, Modifier::REVERSED)
    }

    /// An alarm: whether it holds the queue.
    pub(crate) fn alarm(self, code: u8) -> Style {
        if Alarm::blocks(code) {
            self.bad()
        } else {
            self.note()
        }
    }

    /// A joint in its range: well within, near an end, or beyond it.
    pub(crate) fn near(self, value: f64, range: Range) -> Style {
        match (range.max - value).min(value - range.min) {
            room if room < 0.0 => self.bad(),
            room if room < NEAR => self.note(),
            _ => Style::new(),
        }
    }

    /// What only accompanies.
    pub(crate) fn dim(self) -> Style {
        self.style(Color::DarkGray, Modifier::DIM)
    }

    /// Keys to press, and what is chosen.
    pub(crate) fn key(self) -> Style {
        self.style(Color::Cyan, Modifier::BOLD)
            .add_modifier(Modifier::BOLD)
    }

    /// The name of a panel.
    pub(crate) fn title(self) -> Style {
        Style::new().add_modifier(Modifier::BOLD)
    }

    /// The lines at top and bottom.
    pub(crate) fn bar(self) -> Style {
        Style::new().add_modifier(Modifier::REVERSED)
    }
}
