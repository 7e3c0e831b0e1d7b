//! How the pad looks.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};

use super::axis::Axis;
use super::hands::What;
use super::pad::{self, Pad, Tone, Tools, Way};
use crate::terminal::{Seen, Theme, fitted, help, lamp, mm, panel, wrapped};

/// What is shown.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    pub(crate) seen: Seen,
    pub(crate) pad: Pad,
}

/// Keys that move, whatever the program.
pub(crate) const MOVES: [(&str, &str); 6] = [
    ("arrows", "x and y; as joints J2 and J1"),
    ("w s PgUp/Dn", "z up and down; J3"),
    ("a d", "r left and right; J4"),
    ("[ ]", "the rail, if there is one"),
    ("space", "stop, whatever moves"),
    ("tab", "coordinates or joints"),
];
const KEYS: [(&str, &str); 17] = [
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
    ("q Ctrl-C", "leave; the arm stands, speeds are as they were"),
    ("Ctrl-L", "draw everything anew"),
    (
        "",
        "Hold, where the terminal tells no releases: a tap is a nudge, and the arm goes on once the key repeats, until it does not.",
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

/// Draws one frame.
pub(crate) fn draw(frame: &mut Frame<'_>, model: &Model, theme: Theme) {
    let Model { seen, pad } = model;
    let foot = foot(pad, &HINTS, frame.area().width, theme);
    let [header, middle, footer] = thirds(frame.area(), &foot);
    frame.render_widget(seen.header("jog", header.width, theme), header);
    let [top, pads, alarms, log] = Layout::vertical([
        Constraint::Length(7),
        Constraint::Length(7),
        Constraint::Length(if middle.height > 28 { 6 } else { 4 }),
        Constraint::Fill(1),
    ])
    .areas(middle);
    let [place, joints] =
        Layout::horizontal([Constraint::Length(30), Constraint::Fill(1)]).areas(top);
    pose(frame, place, seen, pad, theme);
    joint_bars(frame, joints, seen, theme);
    state(frame, pads, seen, pad, theme);
    alarm_panel(frame, alarms, seen, theme);
    log_panel(frame, log, seen, theme);
    frame.render_widget(Paragraph::new(foot), footer);
    if pad.help {
        help(frame, middle, &KEYS, theme);
    }
}

/// Where the tool is, and the keys that move it.
pub(crate) fn pose(frame: &mut Frame<'_>, area: Rect, seen: &Seen, pad: &Pad, theme: Theme) {
    let mut lines = Vec::new();
    let cartesian = pad.frame == pad::Frame::Cartesian;
    if let Some(status) = &seen.status {
        let p = &status.pose;
        let keys: [(Axis, f32, &str, &str); 4] = [
            (Axis::X, p.x, "up down", "left right"),
            (Axis::Y, p.y, "left right", "up down"),
            (Axis::Z, p.z, "w s", "w s"),
            (Axis::R, p.r, "a d", "a d"),
        ];
        for (axis, value, key, _) in keys {
            let key = if cartesian { key } else { "" };
            lines.push(row(axis, value, key, moves(pad, axis), theme));
        }
    }
    if let Some(rail) = seen.rail {
        lines.push(row(Axis::L, rail, "] [", moves(pad, Axis::L), theme));
    }
    let title = match cartesian {
        true => "tool: arrows move it",
        false => "tool",
    };
    frame.render_widget(Paragraph::new(lines).block(panel(title, theme)), area);
}

fn row(axis: Axis, value: f32, key: &str, moves: bool, theme: Theme) -> Line<'static> {
    let figure = format!("{:<2}{value:>9.2} {:<4}", axis.name(), axis.unit());
    let style = match moves {
        true => theme.good(),
        false => Style::new(),
    };
    Line::from(vec![
        Span::styled(figure, style),
        Span::styled(key.to_owned(), theme.key()),
    ])
}

fn moves(pad: &Pad, axis: Axis) -> bool {
    matches!(pad.doing, Some(What::Jog(heading) | What::Step(heading)) if heading.axis == axis)
}

/// The joints between their limits.
pub(crate) fn joint_bars(frame: &mut Frame<'_>, area: Rect, seen: &Seen, theme: Theme) {
    let block = panel("joints", theme);
    let lines = seen.joint_lines(block.inner(area).width, theme);
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

/// How much room there is for words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Placing {
    Narrow,
    Wide,
}

/// How keys move, what is done, what the tools do.
pub(crate) fn pad_panel(
    frame: &mut Frame<'_>,
    area: Rect,
    seen: &Seen,
    pad: &Pad,
    placing: Placing,
    theme: Theme,
) {
    let lines = pad_lines(seen, pad, placing, theme);
    frame.render_widget(Paragraph::new(lines).block(panel("pad", theme)), area);
}

fn state(frame: &mut Frame<'_>, area: Rect, seen: &Seen, pad: &Pad, theme: Theme) {
    let mut lines = pad_lines(seen, pad, Placing::Wide, theme);
    let refusal = match &pad.refusal {
        Some(why) => Line::from(vec![
            Span::styled("refused ", theme.note()),
            Span::raw(why.clone()),
        ]),
        None => Line::styled("nothing was refused", theme.dim()),
    };
    lines.push(refusal);
    let text = Paragraph::new(lines).wrap(Wrap { trim: false });
    frame.render_widget(text.block(panel("pad", theme)), area);
}

fn pad_lines(seen: &Seen, pad: &Pad, placing: Placing, theme: Theme) -> Vec<Line<'static>> {
    let (narrow, wide) = match pad.frame {
        pad::Frame::Cartesian => ("x y z r", "coordinates"),
        pad::Frame::Joints => ("joints", "joints J2 J1 J3 J4"),
    };
    let speed = format!("{} %", mm(f64::from(pad.speed)));
    let step = mm(f64::from(pad.step));
    let first = match placing {
        Placing::Narrow => {
            let way = match pad.way {
                Way::Step => format!("step {step}"),
                Way::Hold => "hold".to_owned(),
            };
            Line::styled(format!("{narrow}  {way}  {speed}"), theme.title())
        }
        Placing::Wide => {
            let way = match pad.way {
                Way::Step => format!("step {step} mm or deg"),
                Way::Hold if pad.hold.tells_releases() => "hold: moves until release".to_owned(),
                Way::Hold => "hold: moves while held".to_owned(),
            };
            Line::from(vec![
                Span::styled("moves ", theme.dim()),
                Span::styled(wide, theme.title()),
                Span::styled("  by ", theme.dim()),
                Span::styled(way, theme.title()),
                Span::styled("  speed ", theme.dim()),
                Span::styled(speed, theme.title()),
            ])
        }
    };
    let (doing, tools) = (doing(seen, pad), tool_spans(pad.tools, theme));
    let style = match pad.doing.is_none() && seen.stands() {
        true => theme.dim(),
        false => theme.good(),
    };
    let doing = [
        Span::styled(doing, style),
        Span::styled(format!("  {:.1} mm/s", seen.speed().tool), theme.dim()),
    ];
    let label = |text| match placing {
        Placing::Narrow => None,
        Placing::Wide => Some(Span::styled(text, theme.dim())),
    };
    vec![
        first,
        label("arm   ").into_iter().chain(doing).collect(),
        label("tools ").into_iter().chain(tools).collect(),
    ]
}

fn doing(seen: &Seen, pad: &Pad) -> String {
    match pad.doing {
        Some(What::Jog(heading)) => format!("jogs {heading}"),
        Some(What::Step(heading)) => format!("steps {heading}"),
        Some(What::Stop) => "stops".to_owned(),
        Some(What::Home) => "homes".to_owned(),
        Some(What::Run) => "plays".to_owned(),
        _ if seen.stands() => "stands".to_owned(),
        _ if !seen.answers() => "does not answer".to_owned(),
        _ => "moves".to_owned(),
    }
}

/// What the tools do.
pub(crate) fn tool_spans(tools: Tools, theme: Theme) -> [Span<'static>; 3] {
    let gripper = match tools.grips {
        None => "gripper",
        Some(true) => "closed",
        Some(false) => "open",
    };
    let lit = |on: bool| if on { theme.good() } else { theme.dim() };
    let laser = if tools.laser {
        theme.bad()
    } else {
        theme.dim()
    };
    let grips = tools.grips.is_some();
    [
        Span::styled(
            format!("{} suction ", lamp(tools.suction)),
            lit(tools.suction),
        ),
        Span::styled(format!("{} {gripper} ", lamp(grips)), lit(grips)),
        Span::styled(
            match tools.laser {
                true => format!("{} laser  ON", lamp(true)),
                false => format!("{} laser", lamp(false)),
            },
            laser,
        ),
    ]
}

/// The alarms that stand.
pub(crate) fn alarm_panel(frame: &mut Frame<'_>, area: Rect, seen: &Seen, theme: Theme) {
    let block = panel("alarms", theme);
    let text = seen.alarms(block.inner(area), theme);
    frame.render_widget(text.block(block), area);
}

/// What has happened.
pub(crate) fn log_panel(frame: &mut Frame<'_>, area: Rect, seen: &Seen, theme: Theme) {
    let block = panel("log", theme);
    let lines = seen.log_lines(block.inner(area).height, theme);
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

/// What is asked, or was said last; else what the keys do.
pub(crate) fn foot(
    pad: &Pad,
    keys: &[(&str, &str)],
    width: u16,
    theme: Theme,
) -> Vec<Line<'static>> {
    match (&pad.question, &pad.message) {
        (Some(question), _) => said(question.text(), width, theme.note()),
        (_, Some((Tone::Bad, text))) => said(text, width, theme.bad()),
        (_, Some((Tone::Plain, text))) => said(text, width, theme.note()),
        _ => vec![fitted(keys, width, theme)],
    }
}

/// A message at the foot, on as many lines as it takes, up to three.
pub(crate) fn said(text: &str, width: u16, style: Style) -> Vec<Line<'static>> {
    const MOST: usize = 3;
    let room = usize::from(width).saturating_sub(1).max(1);
    let lines = wrapped(text, room).into_iter().take(MOST);
    lines
        .map(|text| Line::styled(format!(" {text}"), style))
        .collect()
}

/// From here on there is room beside something else for the pad as it is alone.
const WIDE: u16 = 120;

/// Draws the arm and its pad at the right, and gives what is left of the area to something else.
pub(crate) fn at_the_right(
    frame: &mut Frame<'_>,
    area: Rect,
    seen: &Seen,
    pad: &Pad,
    theme: Theme,
) -> Rect {
    let (placing, width) = match area.width >= WIDE {
        true => (Placing::Wide, Constraint::Percentage(45)),
        false => (Placing::Narrow, Constraint::Length(30)),
    };
    let [left, right] = Layout::horizontal([Constraint::Fill(1), width]).areas(area);
    let rail = u16::from(seen.rail.is_some());
    let [place, joints, pads, alarms, log] = Layout::vertical([
        Constraint::Length(6 + rail),
        Constraint::Length(7),
        Constraint::Length(5),
        Constraint::Length(if area.height > 30 { 6 } else { 4 }),
        Constraint::Fill(1),
    ])
    .areas(right);
    pose(frame, place, seen, pad, theme);
    joint_bars(frame, joints, seen, theme);
    pad_panel(frame, pads, seen, pad, placing, theme);
    alarm_panel(frame, alarms, seen, theme);
    if log.height > 2 {
        log_panel(frame, log, seen, theme);
    }
    left
}

/// Header, middle, and so many lines of foot.
pub(crate) fn thirds(area: Rect, foot: &[Line<'_>]) -> [Rect; 3] {
    let foot = u16::try_from(foot.len()).unwrap_or(1);
    Layout::vertical([
        Constraint::Length(1),
        Constraint::Fill(1),
        Constraint::Length(foot),
    ])
    .areas(area)
}
