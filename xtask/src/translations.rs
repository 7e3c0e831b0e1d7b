//! Checks translations of the core's messages: each message of `message!` has a translation with
//! the same placeholders, and no translation is left without a source.
//!
//!
//! A message is identified by its English template. Translated are messages of `message!` and
//! effects of remedies; crates and files that still create plain texts are not in [`MESSAGE_ONLY_PATHS`].

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::str::FromStr;

use proc_macro2::{Delimiter, TokenStream, TokenTree};

use crate::sentences::{is_group, is_punct, production_sources};

/// Crates whose messages reach the page.
const CRATES: [&str; 6] = [
    "magician-host",
    "magician",
    "magician-formats",
    "magician-program",
    "magician-job",
    "magician-station",
];

/// Files and directories in which every diagnostic is a message: a plain text there would have no
/// translation.
const MESSAGE_ONLY_PATHS: [&str; 12] = [
    "magician-formats/src",
    "magician-host/src/build",
    "magician-host/src/error",
    "magician-host/src/preflight",
    "magician-host/src/stream",
    "magician-job/src",
    "magician-program/src",
    "magician-station/src",
    "magician/src/arm",
    "magician/src/ports",
    "magician/src/target.rs",
    "magician/src/transport",
];

/// Calls whose text is shown to people.
const TEXT_CALLS: [&str; 5] = ["of_file", "help", "invalid", "in_place", "burning"];

/// Texts in a source file.
#[derive(Default)]
struct SourceTexts {
    /// Templates of messages and effects of remedies, with their lines.
    sentences: Vec<(usize, String)>,
    /// Lines with plain texts in place of messages.
    texts: Vec<usize>,
    /// All strings, since words inside messages are among them.
    strings: Vec<String>,
}

impl SourceTexts {
    fn of(source: &str) -> Self {
        let mut sources = Self::default();
        sources.collect(TokenStream::from_str(source).expect("it is Rust"));
        sources
    }

    fn collect(&mut self, tokens: TokenStream) {
        let tokens = without_tests(tokens);
        for (at, token) in tokens.iter().enumerate() {
            match token {
                TokenTree::Group(group) => {
                    let before = |back: usize| at.checked_sub(back).and_then(|at| tokens.get(at));
                    // Examples in documentation do not count.
                    if before(1).is_some_and(|sign| is_punct(sign, '#')) {
                        continue;
                    }
                    let arguments = arguments(group.stream());
                    let is_macro = before(1).is_some_and(|sign| is_punct(sign, '!'));
                    let name = before(if is_macro { 2 } else { 1 });
                    let name = name.map(ToString::to_string).unwrap_or_default();
                    match (name.as_str(), is_macro) {
                        ("message", true) => self.add_sentence(arguments.first()),
                        ("remedy", false) => self.add_sentence(arguments.get(1)),
                        ("new", false) if is_remedy_call(&tokens, at) => {
                            self.add_sentence(arguments.get(1));
                        }
                        (name, false) if TEXT_CALLS.contains(&name) => {
                            self.texts
                                .extend(arguments.iter().filter_map(|it| text_line(it)));
                        }
                        _ => {}
                    }
                    self.collect(group.stream());
                }
                TokenTree::Literal(literal) => {
                    self.strings.extend(string_value(&literal.to_string()))
                }
                _ => {}
            }
        }
    }

    fn add_sentence(&mut self, argument: Option<&Vec<TokenTree>>) {
        if let Some([TokenTree::Literal(literal)]) = argument.map(Vec::as_slice)
            && let Some(template) = string_value(&literal.to_string())
            && !template.is_empty()
        {
            let line = literal.span().start().line;
            self.sentences.push((line, without_formats(&template)));
        }
    }
}

/// Returns the tokens without test code.
fn without_tests(tokens: TokenStream) -> Vec<TokenTree> {
    let mut all = Vec::new();
    let mut tokens = tokens.into_iter().peekable();
    while let Some(token) = tokens.next() {
        let is_test = is_punct(&token, '#')
            && (tokens.peek())
                .is_some_and(|group| group.to_string().replace(' ', "") == "[cfg(test)]");
        if is_test {
            let item = tokens.by_ref();
            item.find(|token| is_punct(token, ';') || is_group(token, Delimiter::Brace));
        } else {
            all.push(token);
        }
    }
    all
}

/// True if the group at this place holds the arguments of `Remedy::new`.
fn is_remedy_call(tokens: &[TokenTree], at: usize) -> bool {
    let name = at.checked_sub(4).and_then(|at| tokens.get(at));
    name.is_some_and(|name| name.to_string() == "Remedy")
}

/// Splits the arguments of a call.
fn arguments(tokens: TokenStream) -> Vec<Vec<TokenTree>> {
    let mut all = vec![Vec::new()];
    for token in tokens {
        if is_punct(&token, ',') {
            all.push(Vec::new());
        } else if let Some(last) = all.last_mut() {
            last.push(token);
        }
    }
    all
}

/// Returns the line of an argument that is a text: a string, or a result of `format!`.
fn text_line(argument: &[TokenTree]) -> Option<usize> {
    let first = argument.first()?;
    let is_text = match first {
        TokenTree::Literal(literal) => string_value(&literal.to_string()).is_some(),
        TokenTree::Ident(name) => {
            name == "format" && argument.get(1).is_some_and(|sign| is_punct(sign, '!'))
        }
        _ => false,
    };
    is_text.then(|| first.span().start().line)
}

/// Returns the value of a string literal; `None` for other literals.
fn string_value(literal: &str) -> Option<String> {
    let text = literal.strip_prefix('"')?.strip_suffix('"')?;
    let mut out = String::new();
    let mut letters = text.chars().peekable();
    while let Some(letter) = letters.next() {
        match (letter, letters.peek()) {
            // A continued line, and the indentation of the next one.
            ('\\', Some('\n')) => while letters.next_if(|it| it.is_whitespace()).is_some() {},
            ('\\', Some('n')) => {
                letters.next();
                out.push('\n');
            }
            ('\\', Some(_)) => out.extend(letters.next()),
            _ => out.push(letter),
        }
    }
    Some(out)
}

/// Returns a template as `magician_host::Message::template` does.
fn without_formats(template: &str) -> String {
    let mut out = String::new();
    let mut rest = template;
    while let Some((before, place)) = rest.split_once('{') {
        let (place, after) = place.split_once('}').unwrap_or((place, ""));
        let name = place.split(':').next().unwrap_or_default();
        out += &format!("{before}{{{name}}}");
        rest = after;
    }
    out + rest
}

/// Returns the names in braces.
fn placeholders(sentence: &str) -> BTreeSet<&str> {
    let inner = sentence.split('{').skip(1);
    inner.filter_map(|place| place.split('}').next()).collect()
}

/// Returns the problems of a translation.
fn problems(language: &BTreeMap<String, String>, sources: &[(String, SourceTexts)]) -> Vec<String> {
    let mut problems = Vec::new();
    for (file, sources) in sources {
        for (line, template) in &sources.sentences {
            match language.get(template) {
                None => problems.push(format!("{file}:{line}: no translation of \"{template}\"")),
                Some(other) if placeholders(other) != placeholders(template) => {
                    problems.push(format!("\"{template}\" has other places in \"{other}\""));
                }
                Some(_) => {}
            }
        }
    }
    let all: BTreeSet<String> = { sources.iter() }
        .flat_map(|(_, sources)| sources.strings.iter().map(|text| without_formats(text)))
        .collect();
    let unsaid = language.keys().filter(|template| !all.contains(*template));
    problems.extend(unsaid.map(|template| format!("no source says \"{template}\"")));
    problems
}

/// Returns the texts of `CRATES`. Words that these quote are defined in the crates below.
fn collect_sources() -> Vec<(String, SourceTexts)> {
    let below = ["magician-protocol", "magician-motion"];
    let mut sources = Vec::new();
    for name in CRATES.into_iter().chain(below) {
        for (file, source) in production_sources(name) {
            sources.push((file, SourceTexts::of(&source)));
        }
    }
    sources
}

fn read_language(name: &str) -> BTreeMap<String, String> {
    let file = format!("../studio/src/said/{name}.json");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    let text = fs::read_to_string(&path).expect("the sentences of the language");
    serde_json::from_str(&text).expect("sentences by their templates")
}

#[test]
fn chinese_sentences_are_exactly_those_of_the_messages() {
    let problems = problems(&read_language("zh"), &collect_sources());
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

#[test]
fn translated_files_contain_messages_alone() {
    let mut texts = Vec::new();
    for (file, sources) in collect_sources() {
        let is_translated = (MESSAGE_ONLY_PATHS.iter())
            .any(|path| Path::new(&file).starts_with(Path::new("crates").join(path)));
        if is_translated {
            texts.extend(sources.texts.iter().map(|line| format!("{file}:{line}")));
        }
    }
    assert!(
        texts.is_empty(),
        "texts without a template: {}",
        texts.join(" ")
    );
}

#[test]
fn missing_differing_and_stale_translations_are_reported() {
    let source = r#"
        /// message!("in a comment")
        fn say(height: f64) {
            message!("a surface at {height:.1} \
                mm", height);
            Diagnostic::of_file(message!("nothing")).remedy(Action::Home, "homes it");
            Remedy::new((Setting::At, OptionValue::Any("X,Y")), "places it");
            Diagnostic::of_file(format!("text"));
            let word = "joint 1";
        }
        #[cfg(test)]
        mod tests { fn say() { message!("in a test"); } }
    "#;
    let sources = SourceTexts::of(source);
    let sentences: Vec<&str> = { sources.sentences.iter() }
        .map(|(_, text)| text.as_str())
        .collect();
    assert_eq!(
        sentences,
        [
            "a surface at {height} mm",
            "nothing",
            "homes it",
            "places it"
        ]
    );
    assert_eq!(sources.texts, [8]);
    let sources = [("file.rs".to_owned(), sources)];
    let language = |entries: &[(&str, &str)]| -> BTreeMap<String, String> {
        let own = |(one, other): &(&str, &str)| ((*one).to_owned(), (*other).to_owned());
        entries.iter().map(own).collect()
    };
    let whole = [
        ("a surface at {height} mm", "{height} 毫米"),
        ("nothing", "无"),
        ("homes it", "回零"),
        ("places it", "放置"),
        ("joint 1", "关节 1"),
    ];
    assert_eq!(problems(&language(&whole), &sources), Vec::<String>::new());
    let missing = problems(&language(&whole[1..]), &sources);
    assert_eq!(
        missing,
        ["file.rs:4: no translation of \"a surface at {height} mm\""]
    );
    let mut other = language(&whole);
    other.insert("nothing".to_owned(), "{what}".to_owned());
    other.insert("gone".to_owned(), "没有".to_owned());
    let found = problems(&other, &sources);
    assert_eq!(
        found,
        [
            "\"nothing\" has other places in \"{what}\"",
            "no source says \"gone\""
        ]
    );
}
