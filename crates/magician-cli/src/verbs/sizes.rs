//! Tests of every full-screen program on small, usual and large terminals.

use ratatui::crossterm::event::KeyCode;

use crate::terminal::Help;
use crate::terminal::test::{Example, assert_panels_whole, contains_sentence};

const SIZES: [(u16, u16); 3] = [(60, 20), (80, 24), (120, 40)];

fn all() -> Vec<Example> {
    let parts = [
        super::jog::examples(),
        super::teach::examples(),
        super::watch::examples(),
        super::calibrate::examples(),
        super::sim::examples(),
        super::job::examples(),
    ];
    parts.into_iter().flatten().collect()
}

#[test]
fn essential_text_is_readable_at_every_size() {
    let mut missing = Vec::new();
    for example in all() {
        for (width, height) in SIZES {
            let screen = example.screen(width, height, None);
            let unread = example
                .needs
                .iter()
                .filter(|need| !contains_sentence(&screen, need));
            let unread: Vec<_> = unread.collect();
            if !unread.is_empty() {
                let (name, text) = (example.name, screen.join("\n"));
                missing.push(format!(
                    "{name} at {width}x{height}: no {unread:?} in\n{text}"
                ));
            }
            assert_panels_whole(&screen);
        }
    }
    assert!(missing.is_empty(), "{}", missing.join("\n\n"));
}

#[test]
fn the_list_of_keys_is_complete_at_every_size() {
    for example in all() {
        for (width, height) in SIZES {
            let mut pages = Vec::new();
            let mut help = Help::default();
            loop {
                let page = example.screen(width, height, Some(help));
                if pages.contains(&page) {
                    break;
                }
                pages.push(page);
                help = help.after(KeyCode::PageDown).unwrap();
            }
            for (key, what) in example.keys {
                let read = |page: &Vec<String>| {
                    let beside = page.iter().any(|line| {
                        line.contains(key.trim()) && line.contains(what.split(' ').next().unwrap())
                    });
                    beside && contains_sentence(page, what)
                };
                let name = example.name;
                let text = || pages.iter().map(|page| page.join("\n")).collect::<Vec<_>>();
                assert!(
                    pages.iter().any(read),
                    "{name} at {width}x{height}: {key:?} {what:?} in\n{}",
                    text().join("\n\n")
                );
            }
        }
    }
}
