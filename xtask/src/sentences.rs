//! Checks that texts below the front ends contain no flags, no verbs and no backticks: remedies are
//! data (`magician_host::Remedy`), which each front end words itself.

use std::fs;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// Crates below the front ends.
const CRATES: [&str; 13] = [
    "magician-protocol",
    "magician-motion",
    "magician-model",
    "magician-host",
    "magician-sim",
    "magician-record",
    "magician",
    "magician-formats",
    "magician-program",
    "magician-picture",
    "magician-job",
    "magician-conform",
    "magician-measure",
];

/// Beginnings of command lines for the system's shell, which are allowed: of `Act::System`, with
/// flags of other programs, and of `Act::UseStation`, which is the same in the JSON of every front
/// end.
const SHELL_COMMANDS: [&str; 3] = ["sudo ", "printf ", "magician --station {url} VERB"];

/// Attributes whose texts no user sees.
const FOR_PROGRAMMERS: [&str; 7] = [
    "doc",
    "cfg_attr",
    "allow",
    "expect",
    "warn",
    "deprecated",
    "must_use",
];

/// Strings of a source, and names of its test modules in other files.
#[derive(Default)]
struct Strings {
    /// Strings with their lines.
    found: Vec<(usize, String)>,
    tests: Vec<String>,
}

impl Strings {
    fn of(source: &str) -> Self {
        let tokens = TokenStream::from_str(source).expect("it is Rust");
        let mut strings = Self::default();
        strings.collect(tokens);
        strings
    }

    fn collect(&mut self, tokens: TokenStream) {
        let mut tokens = tokens.into_iter().peekable();
        while let Some(token) = tokens.next() {
            match token {
                TokenTree::Punct(sign) if sign.as_char() == '#' => {
                    tokens.next_if(|next| is_punct(next, '!'));
                    let attribute = tokens.next_if(|next| is_group(next, Delimiter::Bracket));
                    let Some(TokenTree::Group(attribute)) = attribute else {
                        continue;
                    };
                    let text = attribute.stream().to_string();
                    let name: String = text.chars().take_while(|c| is_word_char(*c)).collect();
                    if text.replace(' ', "") == "cfg(test)" {
                        self.skip_item(&mut tokens);
                    } else if !FOR_PROGRAMMERS.contains(&name.as_str()) {
                        self.collect(attribute.stream());
                    }
                }
                TokenTree::Group(group) => self.collect(group.stream()),
                TokenTree::Literal(literal) => {
                    let text = literal.to_string();
                    if text.starts_with(['"', 'r']) {
                        self.found.push((literal.span().start().line, text));
                    }
                }
                _ => {}
            }
        }
    }

    fn skip_item(&mut self, tokens: &mut impl Iterator<Item = TokenTree>) {
        let mut last = String::new();
        for token in tokens {
            if is_punct(&token, ';') {
                self.tests.push(last);
                return;
            }
            if is_group(&token, Delimiter::Brace) {
                return;
            }
            last = token.to_string();
        }
    }
}

pub(crate) fn is_punct(token: &TokenTree, wanted: char) -> bool {
    matches!(token, TokenTree::Punct(sign) if sign.as_char() == wanted)
}

pub(crate) fn is_group(token: &TokenTree, wanted: Delimiter) -> bool {
    matches!(token, TokenTree::Group(group) if group.delimiter() == wanted)
}

fn is_word_char(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

/// True if a string is worded for one front end.
fn is_front_end_text(text: &str) -> bool {
    let follows = |mark: &str| {
        text.match_indices(mark).any(|(at, _)| {
            let before = text[..at].chars().next_back();
            let after = text[at + mark.len()..].chars().next();
            !before.is_some_and(|c| is_word_char(c) || "-/".contains(c))
                && after.is_some_and(|c| c.is_ascii_lowercase())
        })
    };
    let words = text.trim_start_matches(['r', '#', '"']);
    let for_system = SHELL_COMMANDS.iter().any(|first| words.starts_with(first));
    text.contains('`') || !for_system && (follows("--") || follows("magician "))
}

/// Collects the sources of a crate, without those for tests only.
fn sources(directory: &Path, found: &mut Vec<PathBuf>) {
    let mut paths: Vec<PathBuf> = (fs::read_dir(directory).expect("a directory"))
        .map(|entry| entry.expect("an entry").path())
        .collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|end| end == "rs") {
            found.push(path);
        }
    }
}

/// Returns the folder of a file's submodules.
fn module_folder(path: &Path) -> PathBuf {
    match path.file_name().and_then(|name| name.to_str()) {
        Some("mod.rs" | "lib.rs") => path.with_file_name(""),
        _ => path.with_extension(""),
    }
}

/// Returns the sources of a crate, without those for tests only, with paths from the root.
pub(crate) fn production_sources(name: &str) -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let directory = root.join("crates").join(name).join("src");
    let mut paths = Vec::new();
    sources(&directory, &mut paths);
    assert!(!paths.is_empty(), "{name} has sources");
    let read: Vec<(PathBuf, String)> = (paths.into_iter())
        .map(|path| {
            let source = fs::read_to_string(&path).expect("a source");
            (path, source)
        })
        .collect();
    let tests: Vec<PathBuf> = (read.iter())
        .flat_map(|(path, source)| {
            let tests = Strings::of(source).tests.into_iter();
            tests
                .map(|name| module_folder(path).join(name))
                .collect::<Vec<_>>()
        })
        .collect();
    let for_tests =
        |path: &Path| (tests.iter()).any(|test| path.with_extension("").starts_with(test));
    let read = read.into_iter().filter(|(path, _)| !for_tests(path));
    read.map(|(path, source)| {
        let place = path.strip_prefix(&root).expect("under the root");
        (place.display().to_string(), source)
    })
    .collect()
}

/// Returns the texts of a crate that are worded for one front end, as `file:line: text`.
fn front_end_texts(name: &str) -> Vec<String> {
    { production_sources(name).into_iter() }
        .flat_map(|(place, source)| {
            let texts = Strings::of(&source).found.into_iter();
            let texts = texts.filter(|(_, text)| is_front_end_text(text));
            texts
                .map(|(line, text)| format!("{place}:{line}: {text}"))
                .collect::<Vec<_>>()
        })
        .collect()
}

#[test]
fn no_text_below_the_front_ends_is_worded_for_one_of_them() {
    let texts: Vec<String> = CRATES.into_iter().flat_map(front_end_texts).collect();
    assert!(texts.is_empty(), "{}", texts.join("\n"));
}

#[test]
fn front_end_texts_are_found_where_users_read_them() {
    let source = r##"
        //! With `code`.
        /// `--flag` in a comment, in a `macro` too.
        #[doc = concat!("`", "x")]
        #[error("`{name}` is no name")]
        #[must_use = "`this`"]
        struct Wrong;
        fn say() {
            let quiet = ["-", "a -- b", "x--y", "magician_host", "the magician", "/magician pose", "'x'", "sudo x --now"];
            let sign = '`';
            let loud = format!("'`", "{x} \
                pass --s-max", "--fit shrinks it", r#"run magician home"#, "(--raw)");
        }
        #[cfg(test)]
        mod more;
        #[cfg(test)]
        mod tests { const LOUD: &str = "`magician stop`"; }
        named! { /// `x`
            A = "`a`", }
    "##;
    let Strings { found, tests } = Strings::of(source);
    let texts = found.iter().filter(|(_, text)| is_front_end_text(text));
    let texts: Vec<(usize, &str)> = texts.map(|(line, text)| (*line, text.as_str())).collect();
    let expected = [
        (5, "\"`{name}` is no name\""),
        (11, "\"'`\""),
        (11, "\"{x} \\\n                pass --s-max\""),
        (12, "\"--fit shrinks it\""),
        (12, "r#\"run magician home\"#"),
        (12, "\"(--raw)\""),
        (19, "\"`a`\""),
    ];
    assert_eq!(texts, expected);
    assert_eq!(tests, ["more"]);
}
