//! Pictures as text, for tests.

use ratatui::backend::TestBackend;
use ratatui::{Frame, Terminal};

/// A terminal of that size with one frame on it.
pub(crate) fn terminal(
    width: u16,
    height: u16,
    draw: impl FnOnce(&mut Frame<'_>),
) -> Terminal<TestBackend> {
    let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
    terminal.draw(draw).unwrap();
    terminal
}

/// A frame as lines of text.
pub(crate) fn screen(width: u16, height: u16, draw: impl FnOnce(&mut Frame<'_>)) -> Vec<String> {
    let terminal = terminal(width, height, draw);
    let cells = terminal.backend().buffer().content();
    let line = |cells: &[ratatui::buffer::Cell]| cells.iter().map(|cell| cell.symbol()).collect();
    cells.chunks(usize::from(width)).map(line).collect()
}

/// Makes sure that each of these texts is in a line.
#[track_caller]
pub(crate) fn shows(screen: &[String], wanted: &[&str]) {
    for text in wanted {
        let found = screen.iter().any(|line| line.contains(text));
        assert!(found, "no {text:?} in\n{}", screen.join("\n"));
    }
}

/// What a virtual arm tells after it was switched on.
pub(crate) fn status() -> magician::Status {
    let runtime = tokio::runtime::Builder::new_current_thread();
    let runtime = { runtime }.enable_all().build().unwrap();
    runtime.block_on(async {
        let target = "sim".parse().unwrap();
        let arm = magician::Arm::connect(&target).await.unwrap();
        arm.state(100.0).unwrap().changed().await.unwrap()
    })
}
