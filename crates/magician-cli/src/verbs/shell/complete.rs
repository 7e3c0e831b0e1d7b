//! Completion with Tab: verbs, options and their values, commands of the protocol and their fields.

use magician_protocol::{FieldType, LayoutInfo, Row, TABLE};
use rustyline::completion::{Completer, Pair};
use rustyline::highlight::Highlighter;
use rustyline::hint::Hinter;
use rustyline::validate::Validator;
use rustyline::{Context, Helper};

use crate::catalogue::normalised_name;

/// Words of the shell itself, then verbs and options that do not work in a shell.
const EXIT_WORDS: [&str; 2] = ["exit", "quit"];
const EXCLUDED_VERBS: [&str; 5] = ["shell", "sim", "demo", "completions", "man"];
const EXCLUDED_OPTIONS: [&str; 2] = ["port", "version"];

/// Completes the word before the cursor.
pub(super) struct CommandCompleter {
    description: clap::Command,
}

impl CommandCompleter {
    /// Creates a completer for this command line.
    pub(super) fn new(description: clap::Command) -> Self {
        Self { description }
    }

    /// Returns the possible completions of `word` after the words `before`.
    fn candidates(&self, before: &[&str], word: &str) -> Vec<String> {
        let Some((first, rest)) = before.split_first() else {
            return self.verbs();
        };
        let Some(mut verb) = self.description.find_subcommand(first) else {
            return Vec::new();
        };
        for word in rest {
            verb = verb.find_subcommand(word).unwrap_or(verb);
        }
        if word.starts_with('-') {
            return options(verb);
        }
        let names: Vec<_> = rest.iter().filter(|word| !word.starts_with('-')).collect();
        match (*first, names.as_slice()) {
            ("commands", []) => names_of(|_| true),
            ("help", []) => [self.verbs(), names_of(|_| true)].concat(),
            ("get", []) => names_of(|row| row.value.is_some()),
            ("set", []) => names_of(|row| row.set.is_some()),
            ("enqueue", []) => names_of(|row| row.set.is_some() && row.queueable),
            ("get", [name, ..]) => Row::find_readable(name)
                .ok()
                .and_then(|row| row.query)
                .map_or(Vec::new(), |layout| fields(layout, &names, word)),
            ("set" | "enqueue", [name, ..]) => Row::find_writable(name)
                .ok()
                .and_then(|row| row.set)
                .map_or(Vec::new(), |layout| fields(layout, &names, word)),
            _ => choices(verb),
        }
    }

    fn verbs(&self) -> Vec<String> {
        let verbs = self
            .description
            .get_subcommands()
            .map(clap::Command::get_name);
        let verbs = verbs.filter(|verb| !EXCLUDED_VERBS.contains(verb));
        verbs.chain(EXIT_WORDS).map(str::to_owned).collect()
    }
}

/// Returns the long options of a verb.
fn options(verb: &clap::Command) -> Vec<String> {
    let names = verb.get_arguments().filter_map(clap::Arg::get_long);
    let names = names.filter(|name| !EXCLUDED_OPTIONS.contains(name));
    names.map(|name| format!("--{name}")).collect()
}

/// Returns the subcommands and fixed values of a verb, such as `status` or `on`.
fn choices(verb: &clap::Command) -> Vec<String> {
    let actions = verb.get_subcommands().map(clap::Command::get_name);
    let values = verb
        .get_positionals()
        .flat_map(clap::Arg::get_possible_values);
    let values = values.map(|value| value.get_name().to_owned());
    actions.map(str::to_owned).chain(values).collect()
}

fn names_of(wanted: impl Fn(&Row) -> bool) -> Vec<String> {
    let rows = TABLE.iter().filter(|row| wanted(row));
    rows.map(|row| row.name.to_owned()).collect()
}

/// Returns `key=` for fields not given yet, or the names of an enum's values after `key=`.
fn fields(layout: &LayoutInfo, given: &[&&str], word: &str) -> Vec<String> {
    if let Some((key, _)) = word.split_once('=') {
        let field = layout.fields.iter().find(|field| field.name == key);
        return match field.map(|field| field.ty) {
            Some(FieldType::Enum(info)) => {
                let names = info.variants.iter().map(|variant| variant.name);
                names.map(|name| format!("{key}={name}")).collect()
            }
            _ => Vec::new(),
        };
    }
    let there = |name: &str| {
        let mut keys = given.iter().filter_map(|word| word.split_once('='));
        keys.any(|(key, _)| key == name)
    };
    let names = layout.fields.iter().map(|field| field.name);
    let names = names.filter(|name| !there(name));
    names.map(|name| format!("{name}=")).collect()
}

impl Completer for CommandCompleter {
    type Candidate = Pair;

    fn complete(
        &self,
        line: &str,
        position: usize,
        _: &Context<'_>,
    ) -> rustyline::Result<(usize, Vec<Pair>)> {
        let line = line.get(..position).unwrap_or(line);
        let start = line.rfind(char::is_whitespace).map_or(0, |at| at + 1);
        let (before, word) = line.split_at(start);
        let before: Vec<_> = before.split_whitespace().collect();
        let mut found = self.candidates(&before, word);
        found.retain(|candidate| normalised_name(candidate).starts_with(&normalised_name(word)));
        let pair = |candidate: String| Pair {
            replacement: if candidate.ends_with('=') {
                candidate.clone()
            } else {
                format!("{candidate} ")
            },
            display: candidate,
        };
        Ok((start, found.into_iter().map(pair).collect()))
    }
}

impl Hinter for CommandCompleter {
    type Hint = String;
}
impl Highlighter for CommandCompleter {}
impl Validator for CommandCompleter {}
impl Helper for CommandCompleter {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::Cli;
    use rustyline::history::MemHistory;

    fn offered(line: &str) -> Vec<String> {
        let history = MemHistory::new();
        let found = CommandCompleter::new(Cli::description()).complete(
            line,
            line.len(),
            &Context::new(&history),
        );
        let (_, pairs) = found.expect("it never fails");
        pairs.into_iter().map(|pair| pair.replacement).collect()
    }

    #[test]
    fn completes_verbs_and_their_values() {
        assert_eq!(offered("po"), ["ports ", "pose "]);
        assert_eq!(offered("queue st"), ["status ", "start ", "stop "]);
        assert_eq!(offered("suction "), ["on ", "off "]);
        assert_eq!(offered("move 1 2 3 --lin"), ["--linear "]);
        assert_eq!(offered("move --po"), [""; 0]);
        assert_eq!(offered("nonsense "), [""; 0]);
        assert!(offered("").contains(&"exit ".to_owned()));
    }

    #[test]
    fn commands_and_their_fields_without_regard_to_case() {
        assert_eq!(offered("get ptp-joint"), ["PTPJointParams "]);
        assert_eq!(offered("set pose"), [""; 0], "it cannot be set");
        assert_eq!(offered("set PTPCommonParams acc"), ["acceleration_ratio="]);
        let rest = offered("set PTPCommonParams velocity_ratio=5 ");
        assert_eq!(rest, ["acceleration_ratio="]);
        let modes = offered("enqueue PTPCmd --start ptp_mode=movl");
        assert!(modes.contains(&"ptp_mode=MovlXyz ".to_owned()), "{modes:?}");
        assert_eq!(offered("get IODO "), ["address="]);
    }
}
