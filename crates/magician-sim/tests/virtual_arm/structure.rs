//! Structure of the sources: parts do not know the device, and the controller's interface is in one
//! file.

use std::fs;
use std::path::{Path, PathBuf};

/// Source files below a folder, with their text without comments.
fn sources(folder: &str) -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut folders = vec![root.join(folder)];
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "rs") {
                let text = fs::read_to_string(&path).unwrap();
                let code = |line: &&str| !line.trim_start().starts_with("//");
                let text: Vec<_> = text.lines().filter(code).collect();
                found.push((
                    path.strip_prefix(&root).unwrap().to_owned(),
                    text.join("\n"),
                ));
            }
        }
    }
    assert!(!found.is_empty());
    found
}

fn has_word(text: &str, word: &str) -> bool {
    let part = |char: char| char.is_alphanumeric() || char == '_';
    text.split(|char| !part(char)).any(|found| found == word)
}

/// Only these files connect parts; handlers and parts are passed what they need.
#[test]
fn only_what_is_between_the_parts_knows_the_device() {
    const BETWEEN: [&str; 6] = ["mod", "apply", "external", "moving", "request", "schedule"];
    for (path, text) in sources("device") {
        let between = path.parent() == Some(Path::new("device"))
            && BETWEEN
                .iter()
                .any(|name| path.file_stem().unwrap() == *name);
        assert!(between || !has_word(&text, "Device"), "{}", path.display());
    }
}

#[test]
fn all_that_can_be_done_to_a_controller_is_in_one_file() {
    let with = |(path, text): (PathBuf, String)| {
        let mut lines = text.lines();
        lines
            .any(|line| line.starts_with("impl ") && line.ends_with("Controller {"))
            .then_some(path)
    };
    let files: Vec<_> = sources("").into_iter().filter_map(with).collect();
    assert_eq!(files, [PathBuf::from("controller.rs")]);
}
