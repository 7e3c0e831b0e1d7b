//! Tests of the pages: each shell block runs and prints what stands below it, and each link leads
//! to a file.
//!
//! * A block marked `sh` runs line by line in a new directory with the samples, scenarios, workshop
//!   files and fonts. A line that ends with `# exit N` must exit with that status, every other line
//!   with 0. A line that ends with `&` starts a virtual arm that is served until the end of the
//!   block.
//! * A block marked `text` right below it is the expected output: each of its lines must be
//!   printed, in this order. `…` stands for any text, for example a duration of wall time, and a
//!   space for any spaces. With `MAGICIAN_WRITE_PAGES=1` in the environment, the tests write the
//!   printed numbers into the pages.
//! * Blocks for a real arm, a terminal or a toolchain are marked `console` and not run. Blocks
//!   marked `bash` need Python or a C compiler; `interop/book.py` runs them.
#![cfg(unix)]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use regex_lite::Regex;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Fenced block of a page.
#[derive(Debug)]
struct Block {
    /// Line number in the page.
    line: usize,
    language: String,
    text: Vec<String>,
    /// True if only empty lines separate it from the block before.
    follows: bool,
}

fn blocks(page: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut open: Option<Block> = None;
    let mut follows = false;
    for (number, line) in (1..).zip(page.lines()) {
        match (&mut open, line.strip_prefix("```")) {
            (None, Some(language)) => {
                open = Some(Block {
                    line: number,
                    language: language.to_owned(),
                    text: Vec::new(),
                    follows,
                });
            }
            (Some(_), Some(_)) => {
                blocks.extend(open.take());
                follows = true;
            }
            (Some(block), None) => block.text.push(line.to_owned()),
            (None, None) => follows &= line.trim().is_empty(),
        }
    }
    assert!(open.is_none(), "a fence is not closed");
    blocks
}

/// Returns a line of a block as a shell command, or `None` if it needs a toolchain. The shell stops
/// at the first line that fails.
fn script_line(line: &str) -> Option<String> {
    let (command, comment) = line.split_once(" #").unwrap_or((line, ""));
    let command = match command.trim().strip_prefix("cargo run -- ") {
        Some(arguments) => format!("magician {arguments}"),
        None => command.trim().to_owned(),
    };
    if command.is_empty() || command.starts_with("cargo ") {
        return None;
    }
    if let Some(served) = command.strip_suffix('&') {
        // The server prints `ready` as its only line; the next command waits for it.
        return Some(format!(
            "mkfifo .ready; {served} >.ready & pids=\"$pids $!\"; read -r _ <.ready"
        ));
    }
    Some(match comment.trim().strip_prefix("exit ") {
        Some(status) => format!("status=0; {command} || status=$?; test $status = {status}"),
        None => command,
    })
}

fn script(block: &Block) -> String {
    let lines = block.text.iter().filter_map(|line| script_line(line));
    let mut script = vec![
        "set -e".to_owned(),
        "pids=".to_owned(),
        "trap 'test -z \"$pids\" || kill $pids; wait' EXIT".to_owned(),
    ];
    script.extend(lines);
    script.join("\n") + "\n"
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a directory");
    for entry in fs::read_dir(from).expect("a directory") {
        let entry = entry.expect("an entry");
        if entry.path().is_file() {
            fs::copy(entry.path(), to.join(entry.file_name())).expect("copied");
        }
    }
}

/// Runs a block in a new directory and returns its output, or the reason why it failed.
fn run(block: &Block) -> Result<String, String> {
    let place = tempfile::tempdir().expect("a directory");
    for directory in [
        "crates/magician-program/samples",
        "crates/magician-sim/scenarios",
    ] {
        copy(&root().join(directory), place.path());
        copy(&root().join(directory), &place.path().join(directory));
    }
    for directory in [
        "docs/evidence/workshop/files",
        "crates/magician-formats/fonts",
    ] {
        copy(&root().join(directory), place.path());
    }
    let binary = Path::new(env!("CARGO_BIN_EXE_magician"));
    let directories = std::env::var("PATH").unwrap_or_default();
    let path = format!(
        "{}:{directories}",
        binary.parent().expect("its directory").display()
    );
    let mut command = Command::new("/bin/sh");
    for variable in [
        "MAGICIAN_PORT",
        "MAGICIAN_TOOL",
        "MAGICIAN_WINDOW",
        "MAGICIAN_CONFIG",
    ] {
        command.env_remove(variable);
    }
    for variable in [
        "HOME",
        "XDG_CONFIG_HOME",
        "XDG_STATE_HOME",
        "XDG_DATA_HOME",
        "XDG_CACHE_HOME",
    ] {
        command.env(variable, place.path().join(".home"));
    }
    let output = command
        .arg("-c")
        // Error messages of shell and command in their order.
        .arg(format!("exec 2>&1\n{}", script(block)))
        .env("PATH", path)
        .env("NO_COLOR", "1")
        .current_dir(place.path())
        .stdin(Stdio::null())
        .output()
        .expect("the shell starts");
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    if output.status.success() {
        Ok(printed)
    } else {
        Err(format!("{}:\n{printed}", output.status))
    }
}

/// Returns the pattern of a line of a page: `…` stands for any text and a space for any spaces. If
/// `numbers` is set, a number stands for any number.
fn line_pattern(line: &str, numbers: bool) -> Regex {
    let literal = |text: &str| match text.trim() {
        "" if !text.is_empty() => r"\s+".to_owned(),
        "…" => "(.*)".to_owned(),
        _ => regex_lite::escape(text),
    };
    let mut pattern = String::new();
    let mut end = 0;
    let varying = Regex::new(r"…|\s+|-?[0-9]+(\.[0-9]+)?").expect("a pattern");
    let line = line.trim();
    for part in varying.find_iter(line) {
        pattern += &literal(&line[end..part.start()]);
        pattern += &match part.as_str() {
            number if numbers && number.ends_with(|c: char| c.is_ascii_digit()) => {
                r"-?[0-9]+(?:\.[0-9]+)?".to_owned()
            }
            text => literal(text),
        };
        end = part.end();
    }
    pattern += &literal(&line[end..]);
    Regex::new(&format!(r"^\s*{pattern}\s*$")).expect("a pattern")
}

/// Returns a page's output with the numbers that were printed, or the first line that was not
/// printed even with other numbers.
fn with_printed_numbers<'a>(printed: &str, expected: &'a [String]) -> Result<Vec<String>, &'a str> {
    let mut lines = printed.lines();
    let mut updated = Vec::new();
    for line in expected {
        if line.trim().is_empty() {
            updated.push(line.clone());
            continue;
        }
        let exact = line_pattern(line, false);
        let mut after = lines.clone();
        if after.any(|printed| exact.is_match(printed)) {
            lines = after;
            updated.push(line.clone());
            continue;
        }
        let like = line_pattern(line, true);
        let printed = lines.find(|printed| like.is_match(printed));
        let printed = printed.ok_or(line.as_str())?;
        // What `…` stands for stays out of the page.
        let mut line = String::new();
        let mut end = 0;
        let captures = like.captures(printed).expect("it matches");
        for hidden in captures.iter().skip(1).flatten() {
            line += &printed[end..hidden.start()];
            line.push('…');
            end = hidden.end();
        }
        line += &printed[end..];
        updated.push(line.trim_end().to_owned());
    }
    Ok(updated)
}

/// Runs all blocks of a page and reports all failures together.
///
/// Writes the printed numbers into the page instead if the variable `MAGICIAN_WRITE_PAGES` is set.
fn try_page(name: &str) {
    let path = root().join(name);
    let page = fs::read_to_string(&path).expect("the page");
    let write = std::env::var_os("MAGICIAN_WRITE_PAGES").is_some();
    let mut updated: Vec<String> = page.lines().map(str::to_owned).collect();
    let blocks = blocks(&page);
    let mut wrong = Vec::new();
    let mut tried = 0;
    for (nth, block) in blocks.iter().enumerate() {
        if block.language != "sh" {
            continue;
        }
        tried += 1;
        let place = format!("{name}:{}", block.line);
        let printed = match run(block) {
            Err(why) => {
                wrong.push(format!("{place} ends with {why}"));
                continue;
            }
            Ok(printed) => printed,
        };
        let expected = blocks
            .get(nth + 1)
            .filter(|next| next.follows && next.language == "text");
        let Some(expected) = expected else { continue };
        match with_printed_numbers(&printed, &expected.text) {
            Ok(lines) if write => {
                updated.splice(expected.line..expected.line + lines.len(), lines);
            }
            Ok(lines) => {
                let pairs = expected.text.iter().zip(&lines);
                for (old, new) in pairs.filter(|(old, new)| old != new) {
                    wrong.push(format!("{place} says\n{old}\nbut prints\n{new}"));
                }
            }
            Err(line) => wrong.push(format!("{place} does not print\n{line}\nbut\n{printed}")),
        }
    }
    if write {
        fs::write(&path, updated.join("\n") + "\n").expect("the page is written");
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
    let compiled = blocks.iter().any(|block| block.language == "rust");
    assert!(tried > 0 || compiled, "{name} has nothing that is tried");
}

macro_rules! pages {
    ($($name:ident: $path:literal,)*) => {
        const PAGES: &[&str] = &[$($path),*];
        $(#[test]
        fn $name() {
            try_page($path);
        })*
    };
}

pages! {
    the_readme: "README.md",
    readme_of_the_command: "crates/magician-cli/README.md",
    start: "docs/guide/START.md",
    troubleshooting: "docs/guide/TROUBLESHOOTING.md",
    workshop: "docs/evidence/WORKSHOP.md",
    draw: "docs/recipes/draw.md",
    pens: "docs/recipes/pens.md",
    photo: "docs/recipes/photo.md",
    logo: "docs/recipes/logo.md",
    write: "docs/recipes/write.md",
    poster: "docs/recipes/poster.md",
    fence: "docs/recipes/fence.md",
    engrave: "docs/recipes/engrave.md",
    testgrid: "docs/recipes/testgrid.md",
    cut_and_engrave_a_box: "docs/recipes/box.md",
    files_as_they_are: "docs/recipes/as-they-are.md",
    gcode: "docs/recipes/gcode.md",
    playback: "docs/recipes/playback.md",
    teach: "docs/recipes/teach.md",
    calibrate: "docs/recipes/calibrate.md",
    jog: "docs/recipes/jog.md",
    resume: "docs/recipes/resume.md",
    beside: "docs/recipes/beside.md",
    rust: "docs/recipes/rust.md",
    vendor_programs: "docs/recipes/vendor-programs.md",
}

#[test]
fn every_recipe_is_tried_and_every_page_is_in_the_book() {
    let summary = fs::read_to_string(root().join("docs/SUMMARY.md")).expect("the summary");
    for directory in ["guide", "recipes", "reference", "evidence"] {
        for entry in fs::read_dir(root().join("docs").join(directory)).expect("a directory") {
            let name = entry
                .expect("an entry")
                .file_name()
                .into_string()
                .expect("UTF-8");
            if !name.ends_with(".md") {
                continue;
            }
            let within = format!("{directory}/{name}");
            let path = format!("docs/{within}");
            assert!(
                summary.contains(&format!("]({within})")),
                "{path} is not in the book"
            );
            let text = fs::read_to_string(root().join(&path)).expect("a page");
            // Pages in Python are tested by `crates/magician-py/tests/test_pages.py`.
            let in_python = text.contains("\n```python\n") && !text.contains("\n```sh\n");
            assert!(
                directory != "recipes" || in_python || PAGES.contains(&path.as_str()),
                "{path} is not tried"
            );
        }
    }
}

/// Collects the tests of the Rust files below a directory, as `file::name`.
fn collect_tests(directory: &Path, found: &mut BTreeSet<String>) {
    for entry in fs::read_dir(directory).expect("a directory") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            collect_tests(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let file = path.file_stem().and_then(|stem| stem.to_str());
            let source = fs::read_to_string(&path).expect("a source");
            let names = source.split("fn ").skip(1);
            let names = names.filter_map(|rest| rest.split_once('(').map(|(name, _)| name));
            found.extend(names.map(|name| format!("{}::{name}", file.expect("a name"))));
        }
    }
}

/// `interop/workshop/run` looks these tests up too, but not in every run of the checks.
#[test]
fn every_test_that_a_promise_names_exists() {
    let promises = root().join("interop/workshop/promises.toml");
    let promises = fs::read_to_string(promises).expect("the promises");
    let named = promises.lines().filter_map(|line| {
        let test = line.strip_prefix("test = \"")?.strip_suffix('"')?;
        test.split_once(' ')
    });
    let mut tests_of = BTreeMap::new();
    let mut missing = Vec::new();
    let mut count = 0;
    for (package, test) in named {
        let tests = tests_of.entry(package).or_insert_with(|| {
            let mut tests = BTreeSet::new();
            collect_tests(&root().join("crates").join(package), &mut tests);
            tests
        });
        count += 1;
        if !tests.contains(test) {
            missing.push(format!("{package} {test}"));
        }
    }
    assert!(count > 30, "{count}");
    assert!(missing.is_empty(), "{missing:#?}");
}

/// The picture in the README is the output of its first command.
#[test]
fn readme_picture_is_the_output_of_its_command() {
    let page = fs::read_to_string(root().join("README.md")).expect("the page");
    let place = tempfile::tempdir().expect("a directory");
    let command = page
        .lines()
        .find_map(|line| line.strip_prefix("cargo run -- "))
        .and_then(|line| line.split(" #").next())
        .expect("its first command");
    let picture = place.path().join("drawn.svg");
    let arguments = command.split_whitespace().map(|word| match word {
        "drawn.svg" => picture.to_str().expect("UTF-8"),
        word => word,
    });
    let output = Command::new(env!("CARGO_BIN_EXE_magician"))
        .args(arguments)
        .current_dir(root())
        .env("MAGICIAN_CONFIG", "/dev/null")
        .env("XDG_STATE_HOME", place.path())
        .output()
        .expect("the command starts");
    assert!(output.status.success(), "{output:?}");
    let drawn = fs::read_to_string(&picture).expect("a picture");
    let shown = fs::read_to_string(root().join("docs/pictures/rabbit.svg"))
        .expect("docs/pictures/rabbit.svg");
    assert!(
        drawn == shown,
        "docs/pictures/rabbit.svg is not what `magician {command}` leaves: run that and put it there"
    );
}

/// Collects all pages of the repository, except built or downloaded ones.
fn all_pages(directory: &Path, pages: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(directory).expect("a directory") {
        let entry = entry.expect("an entry");
        let name = entry.file_name().into_string().expect("UTF-8");
        let kind = entry.file_type().expect("its kind");
        let passed_by =
            name.starts_with('.') || ["target", "node_modules", "corpus"].contains(&name.as_str());
        if kind.is_dir() && !passed_by {
            all_pages(&entry.path(), pages);
        } else if kind.is_file() && name.ends_with(".md") {
            pages.push(entry.path());
        }
    }
}

/// Returns the targets of a page's links and pictures, outside of code.
fn links(page: &str) -> Vec<String> {
    let mut fenced = false;
    let mut found = Vec::new();
    for line in page.lines() {
        if line.starts_with("```") {
            fenced = !fenced;
        }
        if fenced {
            continue;
        }
        // Text between backquotes is code.
        let text: String = line.split('`').step_by(2).collect::<Vec<_>>().join("`");
        for (start, end) in [("](", ')'), ("src=\"", '"'), ("href=\"", '"')] {
            let targets = text
                .split(start)
                .skip(1)
                .filter_map(|rest| rest.split(end).next());
            found.extend(targets.map(str::to_owned));
        }
    }
    found
}

/// Returns the anchors of a page: its headings as links name them, and explicit ones.
fn headings(page: &str) -> Vec<String> {
    let anchors = page.split("<a id=\"").skip(1);
    let anchors = anchors.filter_map(|rest| Some(rest.split_once('"')?.0.to_owned()));
    let titles = page.lines().filter(|line| line.starts_with('#'));
    let named = titles.map(|line| {
        let title = line.trim_start_matches('#').trim().to_lowercase();
        let kept = title
            .chars()
            .filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    });
    named.chain(anchors).collect()
}

#[test]
fn all_links_resolve() {
    let mut pages = Vec::new();
    all_pages(&root(), &mut pages);
    assert!(pages.len() > 20, "{pages:?}");
    let mut dead = Vec::new();
    for path in pages {
        let page = fs::read_to_string(&path).expect("a page");
        for link in links(&page) {
            if link.contains("://") || link.starts_with("mailto:") {
                continue;
            }
            let (file, heading) = link.split_once('#').unwrap_or((&link, ""));
            let target = match file {
                "" => path.clone(),
                file => path.parent().expect("its directory").join(file),
            };
            let there = target.exists()
                && (heading.is_empty()
                    || fs::read_to_string(&target)
                        .is_ok_and(|page| headings(&page).iter().any(|name| name == heading)));
            // The book is published alone, so it must not link to files outside of `docs`.
            let book = root().join("docs").canonicalize().expect("the book");
            let within = |file: &Path| file.canonicalize().is_ok_and(|at| at.starts_with(&book));
            if !there || within(&path) && !within(&target) {
                dead.push(format!("{}: {link}", path.display()));
            }
        }
    }
    assert!(dead.is_empty(), "dead links:\n{}", dead.join("\n"));
}

#[test]
fn numbers_of_a_page_are_compared_and_can_be_updated() {
    let update = |printed: &str, line: &str| {
        with_printed_numbers(printed, &[line.to_owned()])
            .ok()
            .map(|lines| lines.concat())
    };
    let done = update("done in 0:11: 11 steps", "done in …: 12 steps");
    assert_eq!(done.as_deref(), Some("done in …: 11 steps"));
    // Columns keep the spaces that were printed.
    let pose = update("x   -1.20 y", "x  33.75 y");
    assert_eq!(pose.as_deref(), Some("x   -1.20 y"));
    // A line that matches exactly is preferred to an earlier one with other numbers.
    let second = update("step 1\nstep 2", "step 2");
    assert_eq!(second.as_deref(), Some("step 2"));
    assert_eq!(update("done", "…").as_deref(), Some("…"));
    assert_eq!(update("x  1 y", "x 1 y").as_deref(), Some("x 1 y"));
    for (printed, line) in [
        ("done in 0:11: 12 laps", "done in …: 12 steps"),
        ("x 1 y", "x y"),
        ("done.", "done"),
        ("a 1 b 2 c", "a … b"),
    ] {
        assert_eq!(update(printed, line), None, "{line}");
    }
}
