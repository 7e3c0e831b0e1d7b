//! Layout of the jog pad.

use magician_job::jog::{Activity, Axis, JogDirection, JogFrame, JogMode, ToolState};
use magician_program::Grip;
use ratatui::Frame;
use ratatui::crossterm::event::KeyCode;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::pad::{Pad, Tone};
use super::side_panel::{COMPACT_ROWS, TITLE, compact_panel};
use crate::terminal::{
    ObservedArm, Theme, fitted, header_body_footer, lamp, message_lines, mm, panel, wrapped,
};

/// Contents of a frame of the jog pad.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    pub(crate) observed: ObservedArm,
    pub(crate) pad: Pad,
}

/// Keys that move the arm, common to all programs with a pad.
pub(crate) const MOVES: [(&str, &str); 6] = [
    (
        "arrows  V",
        "x and y; as joints J2 and J1; V turns the view, arrows with it",
    ),
    ("w s PgUp/Dn", "z up and down; J3"),
    ("a d", "r left and right; J4"),
    ("[ ]", "the rail, if there is one"),
    ("space", "stop all motion"),
    ("tab", "coordinates or joints"),
];
pub(super) const KEYS: [(&str, &str); 17] = [
    MOVES[0],
    MOVES[1],
    MOVES[2],
    MOVES[3],
    MOVES[4],
    MOVES[5],
    (
        "m",
        "step: a press is a checked move; hold: it moves while held",
    ),
    (
        "+ -",
        "longer or shorter steps: 0.1, 1, 5, 10, 50 mm or deg",
    ),
    (". ,", "faster or slower"),
    ("p", "suction on or off"),
    ("g", "gripper: closes, opens, pump off"),
    ("l", "laser on (asks first) or off"),
    ("h", "home (asks first)"),
    ("c", "clear the alarms"),
    ("q Ctrl-C", "quit; the arm stops, speeds are restored"),
    ("Ctrl-L", "redraw the screen"),
    (
        "",
        "Hold, where the terminal reports no releases: a tap moves the arm briefly, a held key as \
            long as it repeats.",
    ),
];
const HINTS: [(&str, &str); 7] = [
    ("q", "quit"),
    ("space", "STOP"),
    ("tab", "frame"),
    ("m", "hold/step"),
    ("+ -", "step"),
    (". ,", "speed"),
    ("?", "all keys"),
];

/// Smallest height, in rows, for joints with bars.
const MIN_BARS_HEIGHT: u16 = 24;

/// Draws one frame.
pub(crate) fn draw(frame: &mut Frame<'_>, model: &Model, theme: Theme) {
    let Model { observed, pad } = model;
    let foot = foot(pad, &HINTS, frame.area().width, theme);
    let [header, middle, footer] = header_body_footer(frame.area(), &foot);
    frame.render_widget(observed.header("jog", header.width, theme), header);
    if frame.area().height < MIN_BARS_HEIGHT {
        small(frame, middle, observed, pad, theme);
    } else {
        large(frame, middle, observed, pad, theme);
    }
    frame.render_widget(Paragraph::new(foot), footer);
    if let Some(help) = pad.help {
        help.draw(frame, middle, &KEYS, theme);
    }
}

fn large(frame: &mut Frame<'_>, area: Rect, observed: &ObservedArm, pad: &Pad, theme: Theme) {
    let mut lines = pad_lines(observed, pad, area.width.saturating_sub(2), theme);
    lines.extend(refusal(pad, area.width.saturating_sub(2), theme));
    let [top, pads, alarms, log] = Layout::vertical([
        Constraint::Length(7),
        Constraint::Length(u16::try_from(lines.len() + 2).unwrap_or(7)),
        Constraint::Length(if area.height > 28 { 6 } else { 4 }),
        Constraint::Fill(1),
    ])
    .areas(area);
    let [place, joints] =
        Layout::horizontal([Constraint::Length(30), Constraint::Fill(1)]).areas(top);
    pose(frame, place, observed, pad, theme);
    joint_bars(frame, joints, observed, theme);
    frame.render_widget(Paragraph::new(lines).block(panel("pad", theme)), pads);
    alarm_panel(frame, alarms, observed, theme);
    log_panel(frame, log, observed, theme);
}

/// Draws the joints as numbers, for small terminals. The last refusal is in the log there.
fn small(frame: &mut Frame<'_>, area: Rect, observed: &ObservedArm, pad: &Pad, theme: Theme) {
    let [top, alarms, log] = Layout::vertical([
        Constraint::Length(COMPACT_ROWS),
        Constraint::Length(4),
        Constraint::Fill(1),
    ])
    .areas(area);
    let [place, pads] =
        Layout::horizontal([Constraint::Length(30), Constraint::Fill(1)]).areas(top);
    compact_panel(frame, place, TITLE, observed, Some(pad), theme);
    pad_panel(frame, pads, observed, pad, theme);
    alarm_panel(frame, alarms, observed, theme);
    log_panel(frame, log, observed, theme);
}

/// Draws the tool's position with the keys that move it.
pub(crate) fn pose(
    frame: &mut Frame<'_>,
    area: Rect,
    observed: &ObservedArm,
    pad: &Pad,
    theme: Theme,
) {
    let mut lines = Vec::new();
    let cartesian = pad.pendant.frame == JogFrame::Cartesian;
    if let Some(status) = &observed.arm.status {
        let p = &status.pose;
        for (axis, value) in [
            (Axis::X, p.x),
            (Axis::Y, p.y),
            (Axis::Z, p.z),
            (Axis::R, p.r),
        ] {
            lines.push(row(
                axis,
                value,
                &keys(pad, axis),
                pad.pendant.moves(axis),
                theme,
            ));
        }
    }
    if let Some(rail) = observed.arm.rail {
        let moves = pad.pendant.moves(Axis::L);
        lines.push(row(Axis::L, rail, &keys(pad, Axis::L), moves, theme));
    }
    let title = if cartesian {
        "tool: arrows move it"
    } else {
        "tool"
    };
    frame.render_widget(Paragraph::new(lines).block(panel(title, theme)), area);
}

fn row(axis: Axis, value: f32, key: &str, moves: bool, theme: Theme) -> Line<'static> {
    let figure = format!("{:<2}{value:>9.2} {:<4}", axis.name(), axis.unit());
    let style = if moves { theme.good() } else { Style::new() };
    Line::from(vec![
        Span::styled(figure, style),
        Span::styled(key.to_owned(), theme.key()),
    ])
}

/// Returns the keys that move an axis, in the current frame.
fn keys(pad: &Pad, axis: Axis) -> String {
    let names: Vec<_> = key_names(pad, axis).map(|(name, _)| name).collect();
    names.join(" ")
}

/// Returns the keys that move an axis forward and back, with a name and a one-column symbol each;
/// empty for an axis without keys.
pub(super) fn key_names(
    pad: &Pad,
    axis: Axis,
) -> impl Iterator<Item = (&'static str, &'static str)> {
    const KEYS: [(KeyCode, &str, &str); 10] = [
        (KeyCode::Up, "up", "↑"),
        (KeyCode::Down, "down", "↓"),
        (KeyCode::Left, "left", "←"),
        (KeyCode::Right, "right", "→"),
        (KeyCode::Char('w'), "w", "w"),
        (KeyCode::Char('s'), "s", "s"),
        (KeyCode::Char('a'), "a", "a"),
        (KeyCode::Char('d'), "d", "d"),
        (KeyCode::Char(']'), "]", "]"),
        (KeyCode::Char('['), "[", "["),
    ];
    [true, false].into_iter().filter_map(move |forward| {
        let wanted = Some(JogDirection { axis, forward });
        let mut keys = KEYS.into_iter();
        let found = keys.find(|(code, ..)| pad.direction(*code) == wanted);
        found.map(|(_, name, sign)| (name, sign))
    })
}

/// Draws the joints between their limits.
pub(crate) fn joint_bars(frame: &mut Frame<'_>, area: Rect, observed: &ObservedArm, theme: Theme) {
    let block = panel("joints", theme);
    let lines = observed.joint_lines(block.inner(area).width, theme);
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

/// Draws the panel with mode, activity and tools.
pub(super) fn pad_panel(
    frame: &mut Frame<'_>,
    area: Rect,
    observed: &ObservedArm,
    pad: &Pad,
    theme: Theme,
) {
    let lines = pad_lines(observed, pad, area.width.saturating_sub(2), theme);
    frame.render_widget(Paragraph::new(lines).block(panel("pad", theme)), area);
}

/// Formats the last refusal.
fn refusal(pad: &Pad, width: u16, theme: Theme) -> Vec<Line<'static>> {
    const REFUSED: &str = "refused ";
    let Some(why) = &pad.refusal else {
        return vec![Line::styled("nothing was refused", theme.dim())];
    };
    let lines = wrapped(&format!("{REFUSED}{why}"), width.into());
    let line = |text: String| match text.strip_prefix(REFUSED) {
        Some(rest) => Line::from(vec![
            Span::styled(REFUSED, theme.note()),
            Span::raw(rest.to_owned()),
        ]),
        None => Line::raw(text),
    };
    lines.into_iter().map(line).collect()
}

/// Returns the lines of that panel for a width.
pub(super) fn pad_lines(
    observed: &ObservedArm,
    pad: &Pad,
    width: u16,
    theme: Theme,
) -> Vec<Line<'static>> {
    let roomy = long_mode_line(pad, theme);
    let is_roomy = roomy.width() <= usize::from(width);
    let label = |text| is_roomy.then(|| Span::styled(text, theme.dim()));
    let style = if pad.pendant.activity.is_none() && observed.arm.is_at_rest() {
        theme.dim()
    } else {
        theme.good()
    };
    let doing = [
        Span::styled(activity_text(observed, pad), style),
        Span::styled(
            format!("  {:.1} mm/s", observed.arm.speed().tool),
            theme.dim(),
        ),
    ];
    let tools = tool_lines(pad.pendant.tools, width.saturating_sub(6), theme);
    let mut lines = vec![if is_roomy {
        roomy
    } else {
        mode_line(pad, theme)
    }];
    lines.push(label("arm   ").into_iter().chain(doing).collect());
    if is_roomy {
        lines.extend((tools.into_iter().enumerate()).map(|(nth, tools)| {
            let label = label(if nth == 0 { "tools " } else { "      " });
            label.into_iter().chain(tools).collect()
        }));
    } else {
        lines.extend(tool_lines(pad.pendant.tools, width, theme));
    }
    lines
}

/// Describes in a few words how keys move the arm.
pub(super) fn mode_line(pad: &Pad, theme: Theme) -> Line<'static> {
    let frame = match pad.pendant.frame {
        JogFrame::Cartesian => "x y z r",
        JogFrame::Joints => "joints",
    };
    let way = match pad.pendant.mode {
        JogMode::Step => format!("step {}", mm(f64::from(pad.pendant.step))),
        JogMode::Hold => "hold".to_owned(),
    };
    Line::styled(
        format!("{frame}  {way}  {} %", mm(f64::from(pad.pendant.speed))),
        theme.title(),
    )
}

fn long_mode_line(pad: &Pad, theme: Theme) -> Line<'static> {
    let frame = match pad.pendant.frame {
        JogFrame::Cartesian => "coordinates",
        JogFrame::Joints => "joints J2 J1 J3 J4",
    };
    let way = match pad.pendant.mode {
        JogMode::Step => format!("step {} mm or deg", mm(f64::from(pad.pendant.step))),
        JogMode::Hold if pad.pendant.hold.reports_releases() => {
            "hold: moves until release".to_owned()
        }
        JogMode::Hold => "hold: moves while held".to_owned(),
    };
    let speed = format!("{} %", mm(f64::from(pad.pendant.speed)));
    Line::from(vec![
        Span::styled("moves ", theme.dim()),
        Span::styled(frame, theme.title()),
        Span::styled("  by ", theme.dim()),
        Span::styled(way, theme.title()),
        Span::styled("  speed ", theme.dim()),
        Span::styled(speed, theme.title()),
    ])
}

/// Describes the arm's activity.
pub(super) fn activity_text(observed: &ObservedArm, pad: &Pad) -> String {
    match pad.pendant.activity {
        Some(Activity::Jog(direction)) => format!("jogs {direction}"),
        Some(Activity::Step(direction)) => format!("steps {direction}"),
        Some(Activity::Stop) => "stops".to_owned(),
        Some(Activity::Home) => "homes".to_owned(),
        Some(Activity::Run) => "plays".to_owned(),
        _ if observed.arm.is_at_rest() => "stands".to_owned(),
        _ if !observed.arm.is_answering() => "does not answer".to_owned(),
        _ => "moves".to_owned(),
    }
}

/// Returns the state of the tools on one line, or on two if it is narrow, so that a laser that is
/// on stays visible.
pub(crate) fn tool_lines(tools: ToolState, width: u16, theme: Theme) -> Vec<Line<'static>> {
    let [suction, gripper, laser] = tool_spans(tools, theme);
    let line = Line::from(vec![suction.clone(), gripper.clone(), laser.clone()]);
    if line.width() <= usize::from(width) {
        vec![line]
    } else {
        vec![Line::from(vec![suction, gripper]), Line::from(laser)]
    }
}

fn tool_spans(tools: ToolState, theme: Theme) -> [Span<'static>; 3] {
    let gripper = match tools.gripper {
        Grip::Off => "gripper",
        Grip::Close => "closed",
        Grip::Open => "open",
    };
    let lit = |on: bool| if on { theme.good() } else { theme.dim() };
    let laser = if tools.laser {
        theme.bad()
    } else {
        theme.dim()
    };
    let grips = tools.gripper != Grip::Off;
    [
        Span::styled(
            format!("{} suction ", lamp(tools.suction)),
            lit(tools.suction),
        ),
        Span::styled(format!("{} {gripper} ", lamp(grips)), lit(grips)),
        Span::styled(
            if tools.laser {
                format!("{} laser  ON", lamp(true))
            } else {
                format!("{} laser", lamp(false))
            },
            laser,
        ),
    ]
}

/// Draws the active alarms.
pub(crate) fn alarm_panel(frame: &mut Frame<'_>, area: Rect, observed: &ObservedArm, theme: Theme) {
    let block = panel("alarms", theme);
    let inner = block.inner(area);
    let lines = observed.alarm_lines(inner.width, inner.height, theme);
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

/// Draws the log.
pub(crate) fn log_panel(frame: &mut Frame<'_>, area: Rect, observed: &ObservedArm, theme: Theme) {
    let block = panel("log", theme);
    let inner = block.inner(area);
    let lines = observed.log_lines(inner.width, inner.height, theme);
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

/// Returns the footer: a question, the last message, or the keys.
pub(crate) fn foot(
    pad: &Pad,
    keys: &[(&str, &str)],
    width: u16,
    theme: Theme,
) -> Vec<Line<'static>> {
    match (&pad.question, &pad.message) {
        (Some(question), _) => message_lines(question.text(), width, theme.note()),
        (_, Some((Tone::Bad, text))) => message_lines(text, width, theme.bad()),
        (_, Some((Tone::Plain, text))) => message_lines(text, width, theme.note()),
        _ => vec![fitted(keys, width, theme)],
    }
}
