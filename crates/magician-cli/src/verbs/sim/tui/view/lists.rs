//! Panels for the objects around the arm and for the log.

use magician_sim::world::Support;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::View;
use super::arm::nearest;
use crate::terminal;
use crate::verbs::sim::tui::arm_view::Item;

/// Precision of positions.
#[derive(Clone, Copy)]
enum Digits {
    /// x, y and z to a tenth of a millimetre.
    Tenths,
    /// x and y to a millimetre.
    Whole,
}

impl View<'_> {
    /// Draws the list of objects, in the order of the scenario.
    pub(super) fn items(self, frame: &mut Frame<'_>, area: Rect) {
        let title = match self.app.subject().conveyor {
            Some(_) => format!("objects, belt at {:.0} mm", self.look.belt_travel),
            None => "objects".to_owned(),
        };
        let block = self.panel(title);
        let inner = block.inner(area);
        let room = usize::from(inner.height);
        let items = &self.look.items;
        // The number of digits depends on the room; the place where the object rests is always
        // shown.
        let lines = |digits| -> Vec<Line<'static>> {
            let items = items.iter().take(room);
            items.map(|item| self.item(item, digits)).collect()
        };
        let fits = |lines: &Vec<Line<'_>>| {
            let width = usize::from(inner.width);
            lines.iter().all(|line| line.width() <= width)
        };
        let exact = Some(lines(Digits::Tenths)).filter(fits);
        let mut lines = exact.unwrap_or_else(|| lines(Digits::Whole));
        if items.len() > room
            && let Some(last) = lines.last_mut()
        {
            let more = items.len() - room + 1;
            *last = Line::styled(format!("and {more} more"), self.theme.dim());
        }
        frame.render_widget(Paragraph::new(lines).block(block), area);
    }

    fn item(self, item: &Item, digits: Digits) -> Line<'static> {
        let rest = match item.rest {
            Support::Table => "on the table".to_owned(),
            Support::Belt => "on the belt".to_owned(),
            Support::Shelf => "on a shelf".to_owned(),
            Support::Tool => "held".to_owned(),
            Support::Floor => "on the floor".to_owned(),
            Support::Object(below) => {
                let below = self.look.items.get(usize::from(below));
                below.map_or_else(String::new, |below| format!("on {}", below.name))
            }
            _ => String::new(),
        };
        let style = match item.rest {
            Support::Tool => self.theme.good(),
            Support::Floor => self.theme.dim(),
            _ => Style::new(),
        };
        let color = Style::new().fg(self.theme.ink(nearest(item.color)));
        let place = item.place;
        let text = match digits {
            Digits::Tenths => format!(
                "{:<10} {:>6.1} {:>6.1} {:>6.1}  {rest}",
                item.name, place.x, place.y, place.z
            ),
            Digits::Whole => {
                format!(
                    "{:<10} {:>4.0} {:>5.0}  {rest}",
                    item.name, place.x, place.y
                )
            }
        };
        Line::from(vec![Span::styled("■ ", color), Span::styled(text, style)])
    }

    pub(super) fn log(self, frame: &mut Frame<'_>, area: Rect) {
        let block = self.panel("log");
        let inner = block.inner(area);
        let lines = self.log_lines(inner.width, inner.height);
        frame.render_widget(Paragraph::new(lines).block(block), area);
    }

    /// Returns the latest lines of the log, newest last.
    pub(super) fn log_lines(self, width: u16, room: u16) -> Vec<Line<'static>> {
        let lines = self.app.feed_state.lines.iter().rev();
        let lines = lines.map(|line| (format!("{:>8.2}  ", line.at), line.text.as_str()));
        terminal::log_lines(lines, width, room, self.theme)
    }
}
