//! Counts symptoms of prose that needs a second reading, per crate, and fails above a limit.
//!
//! The code once read like a word-for-word translation: summaries that were clauses ("What it is at
//! most", "Whether it is one"), pronouns without a noun, nobody named who acts. The patterns here
//! are symptoms of that, per 1,000 comment lines; code of projects known for their documentation
//! scores 0 to 4. A low count does not make a text good, but a rising one shows where somebody
//! should read it again. Comments that give reasons are counted too, per 100 lines of code, in the
//! crates whose code is hard to follow without them.

use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::LazyLock;

use regex_lite::Regex;

/// A symptom: its name, its pattern, whether only the first line of a comment counts, and the limit
/// per 1,000 comment lines.
struct Symptom {
    name: &'static str,
    pattern: &'static str,
    first_line: bool,
    limit: f64,
}

const SYMPTOMS: [Symptom; 6] = [
    Symptom {
        name: "What..",
        pattern: r"^(What|Whatever|Whoever|Whether|Where|Who)\b",
        first_line: true,
        limit: 15.0,
    },
    Symptom {
        name: "so many",
        pattern: r"\b[Ss]o (many|much|long|often|far|few) ",
        first_line: false,
        limit: 1.0,
    },
    Symptom {
        name: "told",
        pattern: r"\b(told|tells?|telling) ",
        first_line: false,
        limit: 1.0,
    },
    Symptom {
        name: "none",
        pattern: r"\b(is|are|be) none\b|\bthat (there )?(is|are) not\b|\bwhich there (is|are)\b",
        first_line: false,
        limit: 1.0,
    },
    Symptom {
        name: "one that",
        pattern: r"\b([Oo]nes?|[Tt]hose|[Tt]hat) (that|who|which|of whom|of which)\b|\bof its own\b|\bof his\b",
        first_line: false,
        limit: 2.0,
    },
    Symptom {
        name: "It, That..",
        pattern: r"^(It|Its|That|Those|These|One|Nothing|Nobody|Everybody|Somebody|All that|As|So|How)\b",
        first_line: true,
        limit: 10.0,
    },
];

/// First words of a doc comment that make its summary a clause or leave its noun out.
const CLAUSE: &str = r"^(What|Whatever|Whoever|Whether|Where|Who|How|So|Those|That|These|One|It|Its|As|All that|Nothing|Nobody|Everybody|Somebody|Of|Than|There)\b";
/// Largest share of doc comments that begin so, percent.
const MAX_CLAUSES: f64 = 6.0;

/// Crates of which at least [`MIN_COMMENTS`] in 100 lines of code outside of tests are comments.
const COMMENTED_CRATES: [&str; 4] = [
    "crates/magician",
    "crates/magician-host",
    "crates/magician-sim",
    "crates/magician-station",
];
const MIN_COMMENTS: f64 = 3.0;

/// A smaller area than this is not judged by rates: one hit would be above the limit.
const MIN_LINES: usize = 300;

/// Folders of other people's code, and of what is generated.
const EXCLUDED_FOLDERS: [&str; 2] = ["/corpus/", "/include/"];

static PATTERNS: LazyLock<Vec<Regex>> = LazyLock::new(|| {
    let patterns = SYMPTOMS.iter().map(|symptom| symptom.pattern);
    let patterns = patterns.map(|pattern| Regex::new(pattern).expect("a pattern"));
    patterns.collect()
});
static CLAUSES: LazyLock<Regex> = LazyLock::new(|| Regex::new(CLAUSE).expect("a pattern"));

/// Counts of an area: a crate, or a folder at the top.
#[derive(Debug, Default)]
struct Counts {
    lines: usize,
    hits: [usize; SYMPTOMS.len()],
    /// Doc comments, and doc comments that begin with a clause.
    docs: usize,
    clauses: usize,
    /// Lines of code outside of tests, and of comments among them.
    code: usize,
    comments_in_code: usize,
    /// The lines that were counted: `file:line: symptom: text`.
    found: Vec<String>,
}

/// A line of a comment.
struct Line<'a> {
    number: usize,
    text: &'a str,
    is_doc: bool,
    is_first: bool,
}

/// Returns the comment lines of a source. Blocks (`/** .. */`) count as doc comments; `python` has
/// lines with `#` instead.
fn comments(source: &str, python: bool) -> Vec<Line<'_>> {
    let markers: &[&str] = if python {
        &["#"]
    } else {
        &["///", "//!", "//"]
    };
    // Marker of the comment that a line belongs to, and the number of its lines with text so far.
    let (mut comment, mut count) = ("", 0);
    let mut in_block = false;
    let mut lines = Vec::new();
    for (at, line) in source.lines().enumerate() {
        let line = line.trim();
        let begins_block = !python && !in_block && line.starts_with("/*");
        let own = markers.iter().find(|marker| line.starts_with(**marker));
        let own = own.filter(|_| !(python && line.starts_with("#!")));
        let (marker, text) = if begins_block || in_block {
            in_block = !line.ends_with("*/");
            let text = line.trim_end_matches("*/").trim_start_matches(['/', '*']);
            ("/**", text)
        } else {
            own.map_or(("", ""), |marker| (*marker, &line[marker.len()..]))
        };
        if begins_block || marker != comment {
            (comment, count) = (marker, 0);
        }
        let text = text.trim();
        if !text.is_empty() && !text.starts_with("```") {
            count += 1;
            lines.push(Line {
                number: at + 1,
                text,
                is_doc: marker.len() == 3,
                is_first: count == 1,
            });
        }
    }
    lines
}

impl Counts {
    fn add(&mut self, file: &str, source: &str) {
        for line in comments(source, file.ends_with(".py")) {
            self.lines += 1;
            for (at, symptom) in SYMPTOMS.iter().enumerate() {
                if (line.is_first || !symptom.first_line) && PATTERNS[at].is_match(line.text) {
                    self.hits[at] += 1;
                    self.note(file, &line, symptom.name);
                }
            }
            if line.is_doc && line.is_first {
                self.docs += 1;
                if CLAUSES.is_match(line.text) {
                    self.clauses += 1;
                    self.note(file, &line, "clause");
                }
            }
        }
        let is_test = file.contains("/tests/") || file.ends_with("/tests.rs");
        if file.ends_with(".rs") && file.contains("/src/") && !is_test {
            let own = source.split("#[cfg(test)]\nmod tests {").next();
            for line in own.unwrap_or_default().lines().map(str::trim) {
                let is_comment = line.starts_with("//");
                let is_doc = line.starts_with("///") || line.starts_with("//!");
                self.code += usize::from(!line.is_empty() && !is_comment);
                self.comments_in_code += usize::from(is_comment && !is_doc);
            }
        }
    }

    fn note(&mut self, file: &str, line: &Line<'_>, symptom: &str) {
        let (number, text) = (line.number, line.text);
        self.found
            .push(format!("{file}:{number}: {symptom}: {text}"));
    }

    fn rate(&self, symptom: usize) -> f64 {
        1000.0 * self.hits[symptom] as f64 / self.lines.max(1) as f64
    }

    fn clauses(&self) -> f64 {
        100.0 * self.clauses as f64 / self.docs.max(1) as f64
    }

    fn comments_in_code(&self) -> f64 {
        100.0 * self.comments_in_code as f64 / self.code.max(1) as f64
    }

    /// Names of the limits that are broken.
    fn exceeded_limits(&self, area: &str) -> Vec<String> {
        let mut exceeded_limits = Vec::new();
        if self.lines >= MIN_LINES {
            for (at, symptom) in SYMPTOMS.iter().enumerate() {
                let (rate, limit) = (self.rate(at), symptom.limit);
                if rate > limit {
                    exceeded_limits
                        .push(format!("{area}: {} {rate:.1}, limit {limit}", symptom.name));
                }
            }
            if self.clauses() > MAX_CLAUSES {
                let share = self.clauses();
                exceeded_limits.push(format!(
                    "{area}: clauses {share:.1} %, limit {MAX_CLAUSES} %"
                ));
            }
        }
        if COMMENTED_CRATES.contains(&area) && self.comments_in_code() < MIN_COMMENTS {
            let rate = self.comments_in_code();
            exceeded_limits.push(format!(
                "{area}: reasons {rate:.1}, at least {MIN_COMMENTS}"
            ));
        }
        exceeded_limits
    }
}

/// Sources of Rust, TypeScript and Python that git keeps: a checkout also has generated ones.
fn sources(root: &Path) -> Result<Vec<String>, Box<dyn Error>> {
    let git = Command::new("git")
        .arg("-C")
        .arg(root)
        .arg("ls-files")
        .output()?;
    if !git.status.success() {
        return Err("git does not list the files of this folder".into());
    }
    let files = String::from_utf8(git.stdout)?;
    let is_source = |file: &&str| {
        let name = file.rsplit('/').next().unwrap_or_default();
        [".rs", ".ts", ".tsx", ".py"]
            .iter()
            .any(|end| name.ends_with(end))
            && !(name == "api.ts" || name.ends_with("_blocking.py"))
            && !EXCLUDED_FOLDERS.iter().any(|folder| file.contains(folder))
    };
    Ok(files.lines().filter(is_source).map(str::to_owned).collect())
}

/// Counts by crate, and by folder at the top.
fn count(root: &Path) -> Result<BTreeMap<String, Counts>, Box<dyn Error>> {
    let mut areas: BTreeMap<String, Counts> = BTreeMap::new();
    for file in sources(root)? {
        // A file may be deleted and not committed yet.
        let Ok(source) = fs::read_to_string(root.join(&file)) else {
            continue;
        };
        let parts = if file.starts_with("crates/") { 2 } else { 1 };
        let area = file.split('/').take(parts).collect::<Vec<_>>().join("/");
        areas.entry(area).or_default().add(&file, &source);
    }
    Ok(areas)
}

/// Prints the counts, and fails if a limit is broken. Prints with `--list` the lines that were counted instead.
pub(crate) fn run(words: &[String], root: &Path) -> Result<(), Box<dyn Error>> {
    let areas = count(root)?;
    match words {
        [] => {}
        [list] if list == "--list" => {
            for counts in areas.values() {
                for line in &counts.found {
                    println!("{line}");
                }
            }
            return Ok(());
        }
        _ => return Err("cargo xtask voice [--list]".into()),
    }
    print!("{:26}{:>8}", "per 1,000 comment lines", "lines");
    for symptom in &SYMPTOMS {
        print!("{:>12}", symptom.name);
    }
    println!("{:>12}{:>12}", "clauses, %", "reasons, %");
    for (area, counts) in &areas {
        print!("{area:26}{:>8}", counts.lines);
        for at in 0..SYMPTOMS.len() {
            print!("{:>12.1}", counts.rate(at));
        }
        println!(
            "{:>12.1}{:>12.1}",
            counts.clauses(),
            counts.comments_in_code()
        );
    }
    let exceeded_limits = exceeded_limits(&areas);
    if exceeded_limits.is_empty() {
        Ok(())
    } else {
        Err(exceeded_limits.join("\n").into())
    }
}

/// Limits that an area breaks.
fn exceeded_limits(areas: &BTreeMap<String, Counts>) -> Vec<String> {
    let all = areas.iter();
    all.flat_map(|(area, counts)| counts.exceeded_limits(area))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_crate_is_within_the_limits() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        // Sources without git, such as an unpacked archive, are not judged.
        let Ok(areas) = count(&root) else { return };
        assert!(areas.len() > 20, "the crates have moved");
        let exceeded_limits = exceeded_limits(&areas);
        assert!(
            exceeded_limits.is_empty(),
            "`cargo xtask voice --list` names the lines:\n{}",
            exceeded_limits.join("\n")
        );
    }

    #[test]
    fn lines_of_blocks_are_comments() {
        let source =
            "/** What it is. */\nconst A = 1; /* no */\n/**\n * Size of it,\n * mm.\n */\n// why\n";
        let lines: Vec<_> = comments(source, false)
            .iter()
            .map(|line| (line.number, line.text, line.is_doc, line.is_first))
            .collect();
        assert_eq!(
            lines,
            [
                (1, "What it is.", true, true),
                (4, "Size of it,", true, true),
                (5, "mm.", true, false),
                (7, "why", false, true),
            ]
        );
    }

    #[test]
    fn symptoms_are_found_at_their_lines() {
        let source = "//! What it is.\n//! What it is not.\n\n/// So many are told of.\nfn f() {} // it\n// why\n";
        let mut counts = Counts::default();
        counts.add("crates/a/src/lib.rs", source);
        assert_eq!((counts.lines, counts.hits), (4, [1, 1, 1, 0, 0, 1]));
        assert_eq!((counts.docs, counts.clauses), (2, 2));
        assert_eq!((counts.code, counts.comments_in_code), (1, 1));
        let mut many = Counts {
            lines: 1000,
            docs: 10,
            clauses: 1,
            ..Counts::default()
        };
        many.hits[1] = 2;
        let exceeded_limits = many.exceeded_limits("crates/magician");
        let expected = [
            "so many 2.0, limit 1",
            "clauses 10.0 %, limit 6 %",
            "reasons 0.0, at least 3",
        ];
        let expected = expected.map(|text| format!("crates/magician: {text}"));
        assert_eq!(exceeded_limits, expected);
    }
}
