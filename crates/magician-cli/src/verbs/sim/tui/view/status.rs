//! Panels for the arm itself: pose, tools, queue and alarms.

use magician_protocol::Row;
use magician_sim::world::Support;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::View;
use crate::terminal::{self, lamp, mm};

/// Deviation of a joint below which it counts as rounding, deg.
const MIN_SLIP: f64 = 0.005;

impl View<'_> {
    pub(super) fn arm(self, frame: &mut Frame<'_>, area: Rect) {
        let mut lines = self.pose_lines();
        lines.extend(self.tool_lines());
        lines.push(self.line_line());
        lines.extend(self.client_lines(area));
        frame.render_widget(Paragraph::new(lines).block(self.panel("arm")), area);
    }

    /// Returns pose, joints and remarks on them.
    pub(super) fn pose_lines(self) -> Vec<Line<'static>> {
        let state = &self.look.state;
        let (pose, joints) = (state.pose, state.joints);
        vec![
            Line::from(format!("x  {:>7.1}   y  {:>7.1}", pose.x, pose.y)),
            Line::from(format!("z  {:>7.1}   r  {:>7.1}", pose.z, pose.r)),
            Line::from(format!("J1 {:>7.1}   J2 {:>7.1}", joints.j1, joints.j2)),
            Line::from(format!("J3 {:>7.1}   J4 {:>7.1}", joints.j3, joints.j4)),
            self.condition(),
            self.slip_line(),
        ]
    }

    fn condition(self) -> Line<'static> {
        let state = &self.look.state;
        let motion = match (state.unlocked, state.moving) {
            (true, _) => Span::styled("unlocked", self.theme.note()),
            (_, true) => Span::styled("moving", self.theme.good()),
            (_, false) => Span::raw("at rest"),
        };
        let homed = if state.homed {
            Span::raw(", homed")
        } else {
            Span::styled(", not homed", self.theme.dim())
        };
        let program = if state.program {
            Span::styled(", program", self.theme.good())
        } else {
            Span::raw("")
        };
        Line::from(vec![motion, homed, program])
    }

    /// Returns the deviation of the joints from the controller's belief, or the position of its
    /// tool.
    fn slip_line(self) -> Line<'static> {
        let slips = (1..).zip(self.look.slips());
        let slips: Vec<_> = slips
            .filter(|(_, degrees)| degrees.abs() > MIN_SLIP)
            .map(|(joint, degrees)| format!("J{joint} {degrees:+.1}"))
            .collect();
        if slips.is_empty() {
            let tool = self.look.state.tool;
            let text = format!("tool {} {} {}", mm(tool.x), mm(tool.y), mm(tool.z));
            return Line::styled(text, self.theme.dim());
        }
        Line::styled(format!("actual {}", slips.join(" ")), self.theme.note())
    }

    pub(super) fn tool_lines(self) -> Vec<Line<'static>> {
        let state = &self.look.state;
        let output = |name: &str, tool: magician_sim::ToolOutput| {
            let style = match (tool.commanded, tool.reached) {
                (true, true) => self.theme.good(),
                (false, false) => self.theme.dim(),
                // The tool is still switching.
                _ => self.theme.note(),
            };
            Span::styled(format!("{} {name}  ", lamp(tool.commanded)), style)
        };
        let tools = vec![
            output("suction", state.suction),
            output("gripper", state.gripper),
        ];
        let laser = if state.laser {
            Span::styled(
                format!("{} laser {:.0} %  ", lamp(true), state.laser_power),
                self.theme.bad(),
            )
        } else {
            Span::styled(format!("{} laser  ", lamp(false)), self.theme.dim())
        };
        let held = self
            .look
            .items
            .iter()
            .find(|item| item.rest == Support::Tool);
        let holding = match (state.holding, held) {
            (true, Some(item)) => format!("has {}", item.name),
            (true, None) => "holding".to_owned(),
            (false, _) => String::new(),
        };
        let holding = Span::styled(holding, self.theme.good());
        let mut second = vec![laser];
        if let Some(rail) = state.rail {
            second.push(Span::raw(format!("rail {} ", mm(rail))));
        }
        second.push(holding);
        vec![Line::from(tools), Line::from(second)]
    }

    /// Returns the state of the cable, and the clients at its other end.
    pub(super) fn line_line(self) -> Line<'static> {
        let line = self.look.state.line;
        let mut spans = vec![if line.plugged {
            Span::raw("cable in")
        } else {
            Span::styled("cable pulled", self.theme.bad())
        }];
        if !line.delay.is_zero() {
            let text = format!(", {:.0} ms late", line.delay.as_secs_f64() * 1000.0);
            spans.push(Span::styled(text, self.theme.note()));
        }
        if line.plugged {
            let text = match self.app.feed_state.clients.len() {
                1 => ", 1 client".to_owned(),
                count => format!(", {count} clients"),
            };
            spans.push(Span::styled(text, self.theme.dim()));
        }
        Line::from(spans)
    }

    fn client_lines(self, area: Rect) -> impl Iterator<Item = Line<'static>> {
        let clients = self.app.feed_state.clients.iter();
        let style = self.theme.dim();
        let lines = clients.map(move |client| Line::styled(format!("  {client}"), style));
        lines
            .take(usize::from(area.height))
            .collect::<Vec<_>>()
            .into_iter()
    }

    pub(super) fn queue(self, frame: &mut Frame<'_>, area: Rect) {
        let queue = self.look.state.queue;
        let block = self.panel("queue");
        let width = usize::from(block.inner(area).width);
        let taken = queue.waiting + usize::from(queue.running.is_some());
        let figures = format!(" {taken}/{}", queue.capacity);
        let bar = width.saturating_sub(figures.len());
        let full = (taken * bar).div_ceil(queue.capacity.max(1)).min(bar);
        let style = if taken >= queue.capacity {
            self.theme.note()
        } else {
            self.theme.good()
        };
        let lines = vec![
            Line::from(vec![
                Span::styled("█".repeat(full), style),
                Span::styled("░".repeat(bar - full), self.theme.dim()),
                Span::raw(figures),
            ]),
            self.queue_line(),
            self.queue_mode(),
        ];
        frame.render_widget(Paragraph::new(lines).block(block), area);
    }

    /// Returns the command that the queue is running.
    pub(super) fn queue_line(self) -> Line<'static> {
        let state = &self.look.state;
        let queue = state.queue;
        match (queue.running, queue.running_id) {
            (Some(index), Some(id)) => {
                let name = Row::with_id(id).map_or("?", |row| row.name);
                let waits = match state.awaits_input {
                    Some(address) => format!(" awaits {address}"),
                    None => String::new(),
                };
                Line::styled(format!("{index} {name}{waits}"), self.theme.good())
            }
            _ if queue.waiting > 0 => Line::from(format!("{} wait", queue.waiting)),
            _ => Line::styled("empty", self.theme.dim()),
        }
    }

    fn queue_mode(self) -> Line<'static> {
        let queue = self.look.state.queue;
        let mut spans = vec![match (queue.held, queue.started) {
            (true, _) => Span::styled("held by alarm", self.theme.bad()),
            (_, true) => Span::raw("started"),
            (_, false) => Span::styled("stopped", self.theme.note()),
        }];
        spans.push(Span::raw(format!(", done {}", queue.current_index)));
        if queue.overflows > 0 {
            let text = format!(", {} lost", queue.overflows);
            spans.push(Span::styled(text, self.theme.bad()));
        }
        Line::from(spans)
    }

    pub(super) fn alarms(self, frame: &mut Frame<'_>, area: Rect) {
        let count = self.look.state.alarms.codes().count();
        let title = match (count, self.look.state.queue.held) {
            (0, _) => "alarms".to_owned(),
            (_, false) => format!("alarms: {count}"),
            (_, true) => format!("alarms: {count}, the queue is held"),
        };
        let block = self.panel(title);
        let inner = block.inner(area);
        let alarms = &self.look.state.alarms;
        let lines = terminal::alarm_lines(alarms, inner.width, inner.height, self.theme);
        frame.render_widget(Paragraph::new(lines).block(block), area);
    }
}
