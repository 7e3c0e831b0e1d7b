//! Arm and jog pad as a side panel of other pictures.

use magician::commands::Pose;
use magician_motion::ArmModel;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::pad::Pad;
use super::view::{
    activity_text, alarm_panel, joint_bars, key_names, log_panel, mode_line, pad_lines, pad_panel,
    pose, tool_lines,
};
use crate::terminal::{ObservedArm, Theme, panel};
use magician_job::jog::Axis;

/// Smallest width, in columns, for the full pad beside something else.
const MIN_FULL_PAD_WIDTH: u16 = 120;
/// Below this width, in columns, the pad goes below instead of beside.
const MIN_SIDE_WIDTH: u16 = 80;
/// Smallest height, in rows, for joints with bars.
const MIN_BARS_HEIGHT: u16 = 28;
/// Rows of the panel with coordinates and joints.
pub(crate) const COMPACT_ROWS: u16 = 7;

/// Title of that panel.
pub(super) const TITLE: &str = "tool: mm, joints: deg";

/// Draws arm and pad at the right, or below on a narrow terminal, and returns the rest of the area.
pub(crate) fn side_panel(
    frame: &mut Frame<'_>,
    area: Rect,
    observed: &ObservedArm,
    pad: &Pad,
    theme: Theme,
) -> Rect {
    if area.width < MIN_SIDE_WIDTH {
        return bottom_panel(frame, area, observed, pad, theme);
    }
    let width = if area.width >= MIN_FULL_PAD_WIDTH {
        Constraint::Percentage(45)
    } else {
        Constraint::Length(30)
    };
    let [left, mut right] = Layout::horizontal([Constraint::Fill(1), width]).areas(area);
    if area.height >= MIN_BARS_HEIGHT {
        let rail = u16::from(observed.arm.rail.is_some());
        let [place, joints, rest] = Layout::vertical([
            Constraint::Length(6 + rail),
            Constraint::Length(7),
            Constraint::Fill(1),
        ])
        .areas(right);
        pose(frame, place, observed, pad, theme);
        joint_bars(frame, joints, observed, theme);
        right = rest;
    } else {
        let [place, rest] =
            Layout::vertical([Constraint::Length(COMPACT_ROWS), Constraint::Fill(1)]).areas(right);
        compact_panel(frame, place, TITLE, observed, Some(pad), theme);
        right = rest;
    }
    let lines = pad_lines(observed, pad, right.width.saturating_sub(2), theme);
    let lines = u16::try_from(lines.len()).unwrap_or(u16::MAX);
    let [pads, rest] = Layout::vertical([
        Constraint::Length(lines.saturating_add(2)),
        Constraint::Fill(1),
    ])
    .areas(right);
    pad_panel(frame, pads, observed, pad, theme);
    // A frame takes two rows; with less than eight rows left there is no room for a log.
    let alarms = match rest.height {
        0..8 => rest.height,
        8..14 => 4,
        _ => 6,
    };
    let [alarms, log] =
        Layout::vertical([Constraint::Length(alarms), Constraint::Fill(1)]).areas(rest);
    alarm_panel(frame, alarms, observed, theme);
    if log.height > 2 {
        log_panel(frame, log, observed, theme);
    }
    left
}

/// Draws them below: coordinates and joints at the left, pad and alarms in one panel at the right.
fn bottom_panel(
    frame: &mut Frame<'_>,
    area: Rect,
    observed: &ObservedArm,
    pad: &Pad,
    theme: Theme,
) -> Rect {
    let [top, bottom] =
        Layout::vertical([Constraint::Fill(1), Constraint::Length(COMPACT_ROWS)]).areas(area);
    let [place, pads] =
        Layout::horizontal([Constraint::Length(30), Constraint::Fill(1)]).areas(bottom);
    compact_panel(frame, place, TITLE, observed, Some(pad), theme);
    let block = panel(format!("pad: {}", activity_text(observed, pad)), theme);
    let inner = block.inner(pads);
    let mut lines = vec![mode_line(pad, theme)];
    lines.extend(tool_lines(pad.pendant.tools, inner.width, theme));
    let used = u16::try_from(lines.len()).unwrap_or(u16::MAX);
    let room = inner.height.saturating_sub(used);
    lines.extend(observed.alarm_lines(inner.width, room, theme));
    frame.render_widget(Paragraph::new(lines).block(block), pads);
    top
}

/// Draws coordinates and joints as numbers, with the keys of the pad.
pub(crate) fn compact_panel(
    frame: &mut Frame<'_>,
    area: Rect,
    title: &'static str,
    observed: &ObservedArm,
    pad: Option<&Pad>,
    theme: Theme,
) {
    let block = panel(title, theme);
    let lines = match &observed.arm.status {
        Some(status) => rows(&status.pose, observed.arm.rail, pad, theme),
        None => Vec::new(),
    };
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

fn rows(pose: &Pose, rail: Option<f32>, pad: Option<&Pad>, theme: Theme) -> Vec<Line<'static>> {
    let limits = ArmModel::MAGICIAN.limits;
    let [j1, j2, j3, j4] = pose.joint_angle.map(f64::from);
    let coordinates = [
        Some((Axis::X, pose.x)),
        Some((Axis::Y, pose.y)),
        Some((Axis::Z, pose.z)),
        Some((Axis::R, pose.r)),
        rail.map(|rail| (Axis::L, rail)),
    ];
    let joints = [
        ("J1", j1, limits.j1, Some(Axis::J1)),
        ("J2", j2, limits.j2, Some(Axis::J2)),
        ("J3", j3, limits.j3, Some(Axis::J3)),
        ("J4", j4, limits.j4, Some(Axis::J4)),
        ("2-3", j2 - j3, limits.j2_minus_j3, None),
    ];
    let row = |(coordinate, (name, angle, range, axis)): (Option<(Axis, f32)>, _)| {
        let mut spans = match coordinate {
            Some((axis, value)) => number_with_keys(
                format!("{:<2}{value:>8.2} ", axis.name()),
                Some(axis),
                pad,
                theme,
                Style::new(),
            ),
            None => vec![Span::raw(" ".repeat(13))],
        };
        spans.push(Span::raw(" "));
        let near = theme.near(angle, range);
        let text = format!("{name:<3}{angle:>7.1} ");
        spans.extend(number_with_keys(text, axis, pad, theme, near));
        Line::from(spans)
    };
    coordinates.into_iter().zip(joints).map(row).collect()
}

/// Formats a number with the two keys that change it.
fn number_with_keys(
    text: String,
    axis: Option<Axis>,
    pad: Option<&Pad>,
    theme: Theme,
    style: Style,
) -> Vec<Span<'static>> {
    let moved = pad.zip(axis);
    let keys = moved.map_or_else(String::new, |(pad, axis)| {
        key_names(pad, axis).map(|(_, sign)| sign).collect()
    });
    let style = match moved {
        Some((pad, axis)) if pad.pendant.moves(axis) => theme.good(),
        _ => style,
    };
    vec![
        Span::styled(text, style),
        Span::styled(format!("{keys:<2}"), theme.key()),
    ]
}
