//! Colours, or their lack.

use ratatui::style::{Color, Modifier, Style};

use crate::output::Paint;

/// How the picture is painted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Theme {
    colored: bool,
}

impl Theme {
    pub(super) fn for_stderr() -> Self {
        let colored = Paint::for_stderr().is_on();
        Self { colored }
    }

    #[cfg(test)]
    pub(super) const PLAIN: Self = Self { colored: false };
    #[cfg(test)]
    pub(super) const COLORED: Self = Self { colored: true };

    /// A colour on the canvas.
    pub(super) fn ink(self, color: Color) -> Color {
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
    pub(super) fn good(self) -> Style {
        self.style(Color::Green, Modifier::BOLD)
    }

    /// What deserves a look.
    pub(super) fn note(self) -> Style {
        self.style(Color::Yellow, Modifier::BOLD)
    }

    /// What is wrong.
    pub(super) fn bad(self) -> Style {
        self.style(Color::Red, Modifier::REVERSED)
    }

    /// What only accompanies.
    pub(super) fn dim(self) -> Style {
        self.style(Color::DarkGray, Modifier::DIM)
    }

    /// Keys to press, and what is chosen.
    pub(super) fn key(self) -> Style {
        self.style(Color::Cyan, Modifier::BOLD)
            .add_modifier(Modifier::BOLD)
    }

    /// The name of a panel.
    pub(super) fn title(self) -> Style {
        Style::new().add_modifier(Modifier::BOLD)
    }

    /// The lines at top and bottom.
    pub(super) fn bar(self) -> Style {
        Style::new().add_modifier(Modifier::REVERSED)
    }
}
