//! Terminal screens as text, for tests.

use std::sync::LazyLock;

use ratatui::backend::TestBackend;
use ratatui::{Frame, Terminal};

use super::{Help, Theme};

/// Draws one frame on a terminal of this size.
pub(crate) fn terminal(
    width: u16,
    height: u16,
    draw: impl FnOnce(&mut Frame<'_>),
) -> Terminal<TestBackend> {
    let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
    terminal.draw(draw).unwrap();
    terminal
}

/// Draws one frame and returns its lines of text.
pub(crate) fn screen(width: u16, height: u16, draw: impl FnOnce(&mut Frame<'_>)) -> Vec<String> {
    let terminal = terminal(width, height, draw);
    let cells = terminal.backend().buffer().content();
    let line = |cells: &[ratatui::buffer::Cell]| cells.iter().map(|cell| cell.symbol()).collect();
    cells.chunks(usize::from(width)).map(line).collect()
}

/// Asserts that each of these texts occurs in a line.
#[track_caller]
pub(crate) fn assert_shows(screen: &[String], wanted: &[&str]) {
    for text in wanted {
        let found = screen.iter().any(|line| line.contains(text));
        assert!(found, "no {text:?} in\n{}", screen.join("\n"));
    }
}

/// True if a sentence can be read, in one line or continued in the lines below.
pub(crate) fn contains_sentence(screen: &[String], sentence: &str) -> bool {
    let lines: Vec<Vec<char>> = screen.iter().map(|line| line.chars().collect()).collect();
    let words: Vec<&str> = sentence.split_whitespace().collect();
    let Some(first) = words.first() else {
        return true;
    };
    let begins = |row: usize, column: usize| {
        let text: String = lines[row][column..].iter().collect();
        text.starts_with(first) && is_readable_from(&lines[row..], column, &words)
    };
    (0..lines.len()).any(|row| (0..lines[row].len()).any(|column| begins(row, column)))
}

/// True if these words begin at a column and continue in the lines below, in the same column or at
/// the edge of the panel.
fn is_readable_from(lines: &[Vec<char>], column: usize, words: &[&str]) -> bool {
    let Some(line) = lines.first() else {
        return false;
    };
    let text: String = line.get(column..).unwrap_or_default().iter().collect();
    let (mut text, mut left) = (text.as_str(), words);
    while let Some(word) = left.first() {
        let rest = text.trim_start().strip_prefix(word);
        let begins = left.len() == words.len();
        let Some(rest) = rest.filter(|_| begins || text.starts_with(' ')) else {
            break;
        };
        (text, left) = (rest, &left[1..]);
    }
    let panel = line.iter().take(column).rposition(|sign| *sign == '│');
    let panel = panel.map_or(0, |border| border + 1);
    let continues = || {
        [column, panel]
            .iter()
            .any(|at| is_readable_from(&lines[1..], *at, left))
    };
    left.is_empty() || (left.len() < words.len() && continues())
}

/// Asserts that no panel is cut or covered by another.
#[track_caller]
pub(crate) fn assert_panels_whole(screen: &[String]) {
    let cells: Vec<Vec<char>> = screen.iter().map(|line| line.chars().collect()).collect();
    let mut ends = [0; 4];
    for (row, line) in cells.iter().enumerate() {
        for (column, sign) in line.iter().enumerate() {
            match sign {
                '╭' => ends[0] += 1,
                '╮' => ends[1] += 1,
                '╰' => ends[2] += 1,
                '╯' => ends[3] += 1,
                _ => continue,
            }
            if *sign != '╭' {
                continue;
            }
            let right = (column..line.len())
                .find(|at| line[*at] == '╮')
                .unwrap_or(column);
            let bottom = (row..cells.len()).find(|at| cells[*at][column] == '╰');
            let bottom = bottom.unwrap_or(row);
            let sides =
                (row + 1..bottom).all(|at| cells[at][column] == '│' && cells[at][right] == '│');
            let closed = cells[bottom][right] == '╯' && bottom > row + 1;
            assert!(
                sides && closed,
                "panel at {row},{column} in\n{}",
                screen.join("\n")
            );
        }
    }
    assert!(ends.iter().all(|count| *count == ends[0]), "{ends:?}");
}

/// Draws a state; with a [`Help`], also the key list, at its page.
type Draw = dyn Fn(&mut Frame<'_>, Option<Help>);

/// State of a full-screen program, for tests that run over all states.
pub(crate) struct Example {
    pub(crate) name: &'static str,
    /// Sentences that must be readable on any size of terminal.
    pub(crate) needs: Vec<String>,
    /// All its keys with their descriptions.
    pub(crate) keys: &'static [(&'static str, &'static str)],
    draw: Box<Draw>,
}

impl Example {
    /// `model` creates the state to draw; its argument is the key list if that is shown.
    pub(crate) fn new<M: 'static>(
        name: &'static str,
        needs: &[&str],
        keys: &'static [(&'static str, &'static str)],
        model: impl Fn(Option<Help>) -> M + 'static,
        draw: fn(&mut Frame<'_>, &M, Theme),
    ) -> Self {
        Self {
            name,
            needs: needs.iter().map(|text| (*text).to_owned()).collect(),
            keys,
            draw: Box::new(move |frame, help| draw(frame, &model(help), Theme::PLAIN)),
        }
    }

    pub(crate) fn screen(&self, width: u16, height: u16, help: Option<Help>) -> Vec<String> {
        screen(width, height, |frame| (self.draw)(frame, help))
    }
}

/// Returns the status of a virtual arm after it is switched on.
pub(crate) fn status() -> magician::Status {
    static STATUS: LazyLock<magician::Status> = LazyLock::new(|| {
        let runtime = tokio::runtime::Builder::new_current_thread();
        let runtime = { runtime }.enable_all().build().unwrap();
        runtime.block_on(async {
            let arm = magician::Arm::connect("sim").await.unwrap();
            arm.state(100.0).unwrap().changed().await.unwrap()
        })
    });
    STATUS.clone()
}
