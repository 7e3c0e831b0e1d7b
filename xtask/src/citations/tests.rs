use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use magician_sim::fidelity::{Assumption, Authority};

use super::*;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(path: &str) -> String {
    fs::read_to_string(root().join(path)).expect("a file of the repository")
}

/// Returns all parts of a text between `before` and `after`.
fn between<'a>(text: &'a str, before: &str, after: &str) -> Vec<&'a str> {
    let parts = text.split(before).skip(1);
    parts
        .filter_map(|part| Some(part.split_once(after)?.0))
        .collect()
}

/// Returns the anchors of a page. Asserts that they are unique.
fn anchors(page: &str) -> BTreeSet<String> {
    let text = read(page);
    let ids = between(&text, "<a id=\"", "\"></a>");
    let set: BTreeSet<String> = ids.iter().map(|id| (*id).to_owned()).collect();
    assert_eq!(set.len(), ids.len(), "{page} has an anchor twice");
    set
}

/// Returns all texts of the repository with their paths, except built or downloaded files and
/// samples.
fn texts() -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut open = vec![root()];
    while let Some(directory) = open.pop() {
        for entry in fs::read_dir(directory).expect("a directory") {
            let path = entry.expect("an entry").path();
            let name = path
                .file_name()
                .expect("a name")
                .to_string_lossy()
                .into_owned();
            let hidden = name.starts_with('.') && name != ".ci";
            if path.is_dir() && !path.is_symlink() && !hidden {
                let passed_by = ["target", "node_modules", "corpus", "samples", "__pycache__"];
                if !passed_by.contains(&name.as_str()) {
                    open.push(path);
                }
            } else if path.is_file() && !hidden && !name.ends_with(".svg") && name != "Cargo.lock" {
                let Ok(text) = fs::read_to_string(&path) else {
                    continue;
                };
                let target = path.strip_prefix(root()).expect("under the root");
                found.push((target.to_string_lossy().replace('\\', "/"), text));
            }
        }
    }
    assert!(found.len() > 1000, "{} files", found.len());
    found
}

fn line_of(text: &str, at: usize) -> usize {
    text[..at].matches('\n').count() + 1
}

/// Returns all citations of a file that have no target.
fn broken_citations(
    path: &str,
    text: &str,
    places: &BTreeMap<&str, BTreeSet<String>>,
) -> Vec<String> {
    let mut wrong = Vec::new();
    for Citation { range, target } in citations(text) {
        let (page, anchor) = target.page_and_anchor();
        if !places[page].contains(&anchor) {
            let (line, cited) = (line_of(text, range.start), &text[range]);
            wrong.push(format!("{path}:{line}: {cited} is not in docs/{page}"));
        }
    }
    wrong
}

fn anchors_by_page() -> BTreeMap<&'static str, BTreeSet<String>> {
    let pages = [
        ("ERRATA.md", "docs/reference/ERRATA.md"),
        ("MODEL.md", "docs/reference/MODEL.md"),
    ];
    pages.map(|(page, path)| (page, anchors(path))).into()
}

#[test]
fn every_cited_erratum_and_section_exists() {
    let places = anchors_by_page();
    let mut wrong = Vec::new();
    let mut count = 0;
    for (path, text) in texts() {
        count += citations(&text).len();
        wrong.extend(broken_citations(&path, &text, &places));
    }
    assert!(count > 1000, "{count} citations");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn citation_without_a_target_is_reported() {
    let places = anchors_by_page();
    let none = |text: &str| assert_eq!(broken_citations("a", text, &places), [""; 0], "{text}");
    none(&format!("errata {}07, model sections 6 and 15a", 'E'));
    for text in [
        format!("// ({}99)", 'E'),
        format!("errata {}07, {}60", 'E', 'E'),
        format!("see {} 77", "erratum"),
        format!("({} section 17)", "model"),
        format!("/// ({}\n    /// sections 6, 7\n    /// and 15b)", "model"),
    ] {
        assert_eq!(broken_citations("a", &text, &places).len(), 1, "{text}");
    }
}

#[test]
fn every_form_of_a_citation_is_recognized() {
    let cited = |text: &str| -> Vec<String> {
        let all = citations(text).into_iter();
        all.map(|citation| citation.target.page_and_anchor().1)
            .collect()
    };
    for (text, targets) in [
        ("model section 7", &["section-7"][..]),
        (
            "the arm's model (model sections 4, 6 and 7).",
            &["section-4", "section-6", "section-7"],
        ),
        (
            "source = \"model 11, 15a; errata E37\"",
            &["section-11", "section-15a", "e37"],
        ),
        (
            "//! goes on (model\n//! section 15, errata E45).",
            &["section-15", "e45"],
        ),
        ("Model section 15a outranks it", &["section-15a"]),
        ("errata E18 to E20", &["e18", "e20"]),
        (
            "[model section 7](MODEL.md#section-7), E07",
            &["section-7", "e07"],
        ),
        ("erratum 7", &["e07"]),
        (
            "0xE10, 1E10, E10.5, E741, -E12, SE10, model 2.5, model 800, the model, 7, models 7",
            &[],
        ),
    ] {
        assert_eq!(cited(text), targets, "{text}");
    }
}

#[test]
fn citations_become_links() {
    for (text, page) in [
        (
            "Alarms (errata E18 to E20).",
            "Alarms (errata [E18](ERRATA.md#e18) to [E20](ERRATA.md#e20)).",
        ),
        (
            "see model sections 6 and 15a",
            "see model sections [6](MODEL.md#section-6) and [15a](MODEL.md#section-15a)",
        ),
        ("none", "none"),
    ] {
        assert_eq!(with_links(text), page);
    }
}

/// Every assumption of the virtual arm cites a section or an erratum.
#[test]
fn every_basis_of_an_assumption_has_an_anchor() {
    let places = anchors_by_page();
    for assumption in Assumption::ALL {
        let authority = assumption.authority();
        if let Some(link) = authority.link() {
            let (page, anchor) = link.split_once('#').expect("an anchor");
            assert!(
                places[page].contains(anchor),
                "{}: {link}",
                assumption.name()
            );
        } else {
            assert_eq!(authority, Authority::NoSource, "{}", assumption.name());
        }
    }
}

/// In the firmware profile numbers follow their letter directly: `# V 15: shown by ..`, `# M S9, T
/// S11: ..`.
#[test]
fn every_number_of_the_firmware_profile_exists() {
    let profile = read("crates/magician-sim/src/profile/pattern.txt");
    let anchors = anchors("docs/reference/MODEL.md");
    let mut count = 0;
    for line in profile.lines() {
        let comment = line.split_once('#').map_or("", |(_, comment)| comment);
        let words: Vec<&str> = comment.split([' ', ',', ':', ';']).collect();
        for pair in words.windows(2) {
            let [letter, number] = [pair[0], pair[1]];
            if !["M", "V", "VL", "T", "G"].contains(&letter) {
                continue;
            }
            let anchor = match section_number_len(number) {
                Some(length) if length == number.len() => format!("section-{number}"),
                _ if find_numbered(number, &['S']).len() == 1 => {
                    format!("source-{}", number.to_lowercase())
                }
                _ => continue,
            };
            count += 1;
            assert!(anchors.contains(&anchor), "{line}: {anchor}");
        }
    }
    assert!(count > 50, "{count} numbers");
}

/// Every source that the model names is in its table of sources.
#[test]
fn every_source_of_the_model_exists() {
    let anchors = anchors("docs/reference/MODEL.md");
    let page = read("docs/reference/MODEL.md");
    for (source, _) in find_numbered(&page, &['S']) {
        let listed = anchors.contains(&format!("source-{}", source.to_lowercase()));
        assert!(
            listed || page.contains(&format!("There is no {source}.")),
            "{source}"
        );
    }
}

/// Conformance cases also cite recorded frames, streams, poses and habits of hosts.
#[test]
fn every_source_of_a_conformance_case_exists() {
    let vectors = read("crates/magician-protocol/tests/data/vectors.toml");
    let poses = read("crates/magician-motion/tests/data/poses.toml");
    let recorded: BTreeSet<&str> = between(&vectors, "id = \"", "\"").into_iter().collect();
    let posed: BTreeSet<&str> = between(&poses, "id = \"", "\"").into_iter().collect();
    let hosts = anchors("docs/reference/ERRATA.md");
    let mut counts = [0; 3];
    for (path, text) in texts() {
        if !path.starts_with("crates/magician-conform/cases/") {
            continue;
        }
        for source in between(&text, "source = \"", "\"") {
            let words: Vec<&str> = source.split([' ', ',', ';', '(', ')']).collect();
            for (at, word) in words.iter().enumerate() {
                let behind = words.get(at + 1).copied().unwrap_or_default();
                let digits = word.trim_start_matches(|c: char| c.is_ascii_uppercase());
                if word.starts_with('S')
                    && !digits.is_empty()
                    && digits.bytes().all(|c| c.is_ascii_digit())
                {
                    counts[0] += 1;
                    assert!(recorded.contains(word), "{path}: {source}: {word}");
                } else if *word == "pose" {
                    counts[1] += 1;
                    assert!(posed.contains(behind), "{path}: {source}: {behind}");
                } else if *word == "hosts" && behind.bytes().all(|c| c.is_ascii_digit()) {
                    counts[2] += 1;
                    assert!(
                        hosts.contains(&format!("hosts-{behind}")),
                        "{path}: {source}"
                    );
                }
            }
        }
    }
    assert!(counts.iter().all(|count| *count > 10), "{counts:?}");
}

/// Measurements and tests cite goals by number; `docs/evidence/MEASUREMENTS.md` defines them.
#[test]
fn every_cited_goal_exists() {
    let goals = anchors("docs/evidence/MEASUREMENTS.md");
    let measuring = [
        "docs/evidence/MEASUREMENTS.md",
        "docs/reference/GUARANTEES.md",
        "xtask/src/bench/",
        "xtask/src/soak/",
        "crates/magician-cli/src/verbs/bench/",
        "crates/magician-sim/benches/",
    ];
    let mut cited = BTreeSet::new();
    for (path, text) in texts() {
        if !measuring.iter().any(|folder| path.starts_with(folder)) {
            continue;
        }
        for (goal, range) in find_numbered(&text, &['H', 'R', 'S']) {
            let line = line_of(&text, range.start);
            assert!(
                goals.contains(&goal.to_lowercase()),
                "{path}:{line}: {goal}"
            );
            cited.insert(goal.to_owned());
        }
    }
    assert!(cited.len() > 10, "{cited:?}");
}

/// An anchor is directly above the heading with its number.
#[test]
fn anchors_are_directly_above_their_headings() {
    for page in ["docs/reference/ERRATA.md", "docs/reference/MODEL.md"] {
        let text = read(page);
        for part in text.split("\n<a id=\"").skip(1) {
            let (id, rest) = part
                .split_once("\"></a>\n\n")
                .expect("an empty line behind the anchor");
            let heading = rest.lines().next().unwrap_or_default().to_lowercase();
            let number = id.replace('-', " ");
            let title = heading.trim_start_matches(['#', ' ']);
            let follows = title
                .strip_prefix(&number)
                .is_some_and(|rest| rest.starts_with(['.', ':']));
            assert!(
                heading.starts_with('#') && follows,
                "{page}: {id}: {heading}"
            );
        }
    }
}
