//! Panels of what is around the arm and what has happened.

use magician_sim::world::Rest;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::View;
use super::arm::nearest;
use crate::verbs::sim::tui::look::Item;

impl View<'_> {
    /// The objects, in the order of the scenario.
    pub(super) fn items(self, frame: &mut Frame<'_>, area: Rect) {
        let title = match self.app.subject().conveyor {
            Some(_) => format!("objects, belt at {:.0} mm", self.look.belt_travel),
            None => "objects".to_owned(),
        };
        let block = self.panel(title);
        let room = usize::from(block.inner(area).height);
        let items = &self.look.items;
        let mut lines: Vec<_> = items
            .iter()
            .take(room)
            .map(|item| self.item(item))
            .collect();
        if items.len() > room
            && let Some(last) = lines.last_mut()
        {
            let more = items.len() - room + 1;
            *last = Line::styled(format!("and {more} more"), self.theme.dim());
        }
        frame.render_widget(Paragraph::new(lines).block(block), area);
    }

    fn item(self, item: &Item) -> Line<'static> {
        let rest = match item.rest {
            Rest::Table => "on the table".to_owned(),
            Rest::Belt => "on the belt".to_owned(),
            Rest::Shelf => "on a shelf".to_owned(),
            Rest::Tool => "held".to_owned(),
            Rest::Floor => "on the floor".to_owned(),
            Rest::Object(below) => {
                let below = self.look.items.get(usize::from(below));
                below.map_or_else(String::new, |below| format!("on {}", below.name))
            }
            _ => String::new(),
        };
        let style = match item.rest {
            Rest::Tool => self.theme.good(),
            Rest::Floor => self.theme.dim(),
            _ => Style::new(),
        };
        let color = Style::new().fg(self.theme.ink(nearest(item.color)));
        let place = item.place;
        Line::from(vec![
            Span::styled("■ ", color),
            Span::styled(
                format!(
                    "{:<10} {:>6.1} {:>6.1} {:>6.1}  {rest}",
                    item.name, place.x, place.y, place.z
                ),
                style,
            ),
        ])
    }

    pub(super) fn log(self, frame: &mut Frame<'_>, area: Rect) {
        let block = self.panel("log");
        let room = usize::from(block.inner(area).height);
        let lines: Vec<_> = self.log_lines(room);
        frame.render_widget(Paragraph::new(lines).block(block), area);
    }

    /// The latest lines, the newest last.
    pub(super) fn log_lines(self, room: usize) -> Vec<Line<'static>> {
        let lines = &self.app.told.lines;
        let first = lines.len().saturating_sub(room);
        lines
            .iter()
            .skip(first)
            .map(|line| {
                Line::from(vec![
                    Span::styled(format!("{:>8.2}  ", line.at), self.theme.dim()),
                    Span::raw(line.text.clone()),
                ])
            })
            .collect()
    }
}
