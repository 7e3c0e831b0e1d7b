//! Pins of the connectors as lamps.

use magician_protocol::IoFunction;
use magician_sim::{PinState, Signal};
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::View;
use crate::terminal::lamp;
use crate::verbs::sim::tui::keys::Mode;

/// Number of pins at the arm's connectors.
const PIN_COUNT: u16 = 20;
/// Rows of the panel with its borders: as a list in one column, in two, and as lamps alone.
const LIST_ROWS: u16 = PIN_COUNT + 2;
const COLUMNS: u16 = PIN_COUNT / 2 + 2;
const LAMP_ROWS: u16 = PIN_COUNT / 5 + 2;

/// Returns the rows for the pins beside the other panels, which take precedence.
pub(super) fn height(column: Rect) -> u16 {
    // Rows that the other panels of the column need.
    const OTHERS: u16 = 16;
    let fits = |rows: u16| column.height >= OTHERS + rows;
    let wide = column.width >= 40;
    if wide && fits(LIST_ROWS) {
        LIST_ROWS
    } else if wide && fits(COLUMNS) {
        COLUMNS
    } else {
        LAMP_ROWS
    }
}

impl View<'_> {
    pub(super) fn pins(self, frame: &mut Frame<'_>, area: Rect) {
        let cells: Vec<_> = self.look.pins.iter().collect();
        let lines: Vec<Line<'static>> = match area.height {
            LIST_ROWS => cells.iter().map(|pin| self.row(pin, 40)).collect(),
            COLUMNS => {
                let (first, second) = cells.split_at(cells.len() / 2);
                let rows = first.iter().zip(second);
                rows.map(|(left, right)| joined(self.row(left, 21), self.row(right, 20)))
                    .collect()
            }
            _ => cells.chunks(5).map(|pins| self.lamps(pins)).collect(),
        };
        let title = match area.height {
            LAMP_ROWS => "io: o w out, i a in",
            _ => "io",
        };
        frame.render_widget(Paragraph::new(lines).block(self.panel(title)), area);
    }

    /// Returns a pin as text.
    fn row(self, pin: &PinState, width: usize) -> Line<'static> {
        let (name, value) = (name(pin), value(pin, width > 30));
        let text = format!("{} {name:<9}{value}", lamp(lit(pin)));
        let text: String = text.chars().take(width.saturating_sub(3)).collect();
        let text = format!("{text:<fill$}", fill = width.saturating_sub(3));
        Line::from(vec![self.address(pin), Span::styled(text, self.shade(pin))])
    }

    /// Returns pins as numbers with letter and lamp.
    fn lamps(self, pins: &[&PinState]) -> Line<'static> {
        let mut line = Line::default();
        for pin in pins {
            line.push_span(self.address(pin).content.trim_end().to_owned());
            if let Some(last) = line.spans.last_mut() {
                last.style = self.address(pin).style;
            }
            let text = format!("{}{} ", letter(pin), lamp(lit(pin)));
            line.push_span(Span::styled(text, self.shade(pin)));
        }
        line
    }

    fn address(self, pin: &PinState) -> Span<'static> {
        let chosen =
            matches!(self.app.mode, Mode::Inputs { address, .. } if address == pin.address);
        let style = if chosen {
            self.theme.bar()
        } else {
            Style::new()
        };
        Span::styled(format!("{:>2} ", pin.address), style)
    }

    fn shade(self, pin: &PinState) -> Style {
        match (pin.function, pin.able) {
            (IoFunction::None, _) => self.theme.dim(),
            (_, false) => self.theme.bad(),
            _ if lit(pin) => self.theme.good(),
            _ => Style::new(),
        }
    }
}

fn joined(mut left: Line<'static>, right: Line<'static>) -> Line<'static> {
    left.extend(right.spans);
    left
}

/// True if the pin is high, at least part of the time.
fn lit(pin: &PinState) -> bool {
    pin.input || pin.analog > 0 || pin.signal.share().is_some_and(|share| share > 0.0)
}

fn name(pin: &PinState) -> &'static str {
    match pin.function {
        IoFunction::None => "-",
        IoFunction::DigitalOutput => "output",
        IoFunction::Pwm => "pwm",
        IoFunction::DigitalInput => "input",
        IoFunction::AnalogInput => "analog",
        IoFunction::DigitalInputPullUp => "pull-up",
        IoFunction::DigitalInputPullDown => "pull-down",
        IoFunction::Unknown(_) => "unknown",
    }
}

fn letter(pin: &PinState) -> char {
    match pin.function {
        IoFunction::None => ' ',
        IoFunction::DigitalOutput => 'o',
        IoFunction::Pwm => 'w',
        IoFunction::DigitalInput
        | IoFunction::DigitalInputPullUp
        | IoFunction::DigitalInputPullDown => 'i',
        IoFunction::AnalogInput => 'a',
        IoFunction::Unknown(_) => '?',
    }
}

/// Describes the value of a pin; longer where there is room.
fn value(pin: &PinState, long: bool) -> String {
    let level = |high| if high { "high" } else { "low" }.to_owned();
    match (pin.function, pin.signal) {
        (IoFunction::None, _) => String::new(),
        _ if !pin.able => if long { "not on this pin" } else { "cannot" }.to_owned(),
        (_, Signal::Level(high)) => level(high),
        (
            _,
            Signal::Pulses {
                frequency,
                duty_cycle,
            },
        ) => {
            if long {
                format!("{duty_cycle:.0} % of {frequency:.0} Hz")
            } else {
                format!("{duty_cycle:.0} %")
            }
        }
        (IoFunction::AnalogInput, Signal::Undriven) => pin.analog.to_string(),
        (_, Signal::Undriven) => level(pin.input),
    }
}
