//! Short help of a verb (`-h`): its most used options and examples, on one screen.
//!
//! The full help is cut by rule instead of written twice: other options are hidden, each help text
//! is reduced to its first sentence, and two examples are kept.

use std::collections::BTreeSet;

use clap::{Arg, Command};

/// Largest number of options shown for a verb. With positionals, examples and usage the help then
/// fits a screen of 30 lines (tested below).
const MAX_OPTIONS: usize = 12;
/// Options shown for verbs that run a file, most used first.
const COMMON_OPTIONS: [&str; 21] = [
    "shape", "repeat", "cell", "pause", "check", "preview", "surface", "at", "size", "font",
    "width", "scale", "fit", "tool", "fill", "image", "power", "speed", "preset", "resume",
    "loops",
];
/// Options of lettering: shown for `write`, hidden for verbs that draw files and happen to have
/// them.
const LETTERING_OPTIONS: [&str; 2] = ["size", "font"];
/// Argument id that only verbs drawing files have; marks such a verb.
const DRAWING_MARKER: &str = "clip_page";
/// Argument id that only verbs running a file have; marks such a verb.
const FILE_MARKER: &str = "speed_ratio";
/// Global option that is shown for every verb, with its help text here.
const PORT_OPTION: (&str, &str) = (
    "port",
    "Port or address of the arm, or sim for a virtual arm",
);
/// Longest placeholder of a value, in characters. A longer list of choices is replaced by `WORD`,
/// since it would leave no room for the help text.
const MAX_PLACEHOLDER_WIDTH: usize = 14;
/// Sentences from this length on, in characters, do not fit in one line of help and are cut at
/// their first comma or colon.
const MAX_SENTENCE_WIDTH: usize = 68;
/// Number of examples shown.
const MAX_EXAMPLES: usize = 2;

/// Returns the command with the short help of each verb in place of the full one.
pub(crate) fn brief(command: Command) -> Command {
    command.mut_subcommands(|verb| brief_verb(verb, "magician"))
}

fn brief_verb(command: Command, above: &str) -> Command {
    let name = format!("{above} {}", command.get_name());
    let shown = common_options(&command);
    let command = command.mut_args(|arg| {
        let id = arg.get_id().as_str();
        let is_shown = arg.is_positional() || id == "help" || shown.contains(id);
        let is_hidden = arg.is_hide_set() || !is_shown;
        let help = match id {
            _ if id == PORT_OPTION.0 => PORT_OPTION.1.to_owned(),
            _ => arg
                .get_help()
                .map(|help| sentence(&help.to_string()))
                .unwrap_or_default(),
        };
        let values = arg.get_value_names().unwrap_or_default().concat();
        let arg = match values.len() {
            MAX_PLACEHOLDER_WIDTH.. if values.contains('|') => arg.value_name("WORD"),
            _ => arg,
        };
        arg.hide(is_hidden)
            .help_heading(None)
            .hide_env(true)
            .help(help)
    });
    let examples = command.get_after_help().map(ToString::to_string);
    let mut after = examples.as_deref().map(first_examples).unwrap_or_default();
    after += &format!("`{name} --help` explains all options");
    let command = command.after_help(after);
    command.mut_subcommands(|below| brief_verb(below, &name))
}

/// Returns the argument ids that are shown: the first [`MAX_OPTIONS`] of [`COMMON_OPTIONS`] for
/// verbs that run a file, otherwise the verb's first own options.
fn common_options(command: &Command) -> BTreeSet<String> {
    let is_own = |arg: &&Arg| !arg.is_positional() && !arg.is_global_set() && !arg.is_hide_set();
    let own = command.get_arguments().filter(is_own);
    let own: Vec<_> = own.map(|arg| arg.get_id().as_str()).collect();
    let is_seldom = |id: &str| LETTERING_OPTIONS.contains(&id) && own.contains(&DRAWING_MARKER);
    let chosen: Vec<_> = if own.contains(&FILE_MARKER) {
        let usual = COMMON_OPTIONS.iter().copied();
        usual
            .filter(|id| own.contains(id) && !is_seldom(id))
            .take(MAX_OPTIONS)
            .collect()
    } else {
        own.into_iter().take(MAX_OPTIONS).collect()
    };
    chosen
        .into_iter()
        .chain([PORT_OPTION.0])
        .map(str::to_owned)
        .collect()
}

/// Returns the first sentence of a help text; of a long sentence only the part before its list.
fn sentence(help: &str) -> String {
    let until = |ends: &[&str], text: &str| {
        let end = ends.iter().filter_map(|end| text.find(end)).min();
        text[..end.unwrap_or(text.len())].to_owned()
    };
    let sentence = until(&[". ", "; ", " [default"], help);
    match sentence.len() {
        MAX_SENTENCE_WIDTH.. => until(&[": ", ", "], &sentence),
        _ => sentence,
    }
}

/// Returns the first examples from the text at the end of a help.
fn first_examples(text: &str) -> String {
    let mut lines = text.lines();
    match lines.next() {
        Some("Examples:") => {
            let examples = lines
                .take_while(|line| line.starts_with("  "))
                .take(MAX_EXAMPLES);
            let examples: String = examples.map(|line| format!("{line}\n")).collect();
            format!("Examples:\n{examples}\n")
        }
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use std::ffi::OsString;

    use super::*;
    use crate::args::Cli;

    #[test]
    fn short_help_of_every_verb_fits_on_a_screen() {
        /// Lines of a terminal without the prompt.
        const SCREEN: usize = 30;
        let mut description = brief(Cli::description());
        for verb in description.get_subcommands_mut() {
            let help = verb.render_help().to_string();
            let (verb, count) = (verb.get_name(), help.lines().count());
            assert!(
                (6..=SCREEN).contains(&count),
                "{verb} has {count} lines:\n{help}"
            );
            assert!(help.contains("--help"), "{help}");
        }
    }

    #[test]
    fn long_help_contains_the_options_hidden_in_the_short_help() {
        let words = ["magician", "draw", "--help"].map(OsString::from);
        let help = Cli::parse(&words)
            .map(drop)
            .expect_err("help")
            .render()
            .to_string();
        for flag in [
            "--fill-spacing",
            "--merge",
            "--station",
            "--tui",
            "Examples:",
        ] {
            assert!(help.contains(flag), "{flag}:\n{help}");
        }
    }
}
