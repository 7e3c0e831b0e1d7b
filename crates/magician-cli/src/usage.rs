//! Errors of the command line, reworded from clap's structured error.

use std::error::Error;

use clap::error::{ContextKind, ContextValue, ErrorKind};

use crate::failure::Failure;

impl From<&clap::Error> for Failure {
    fn from(error: &clap::Error) -> Self {
        let context = ErrorContext(error);
        let failure = Self::usage(context.message());
        match context.hints().join("; ") {
            hint if hint.is_empty() => failure,
            hint => failure.hint(hint),
        }
    }
}

struct ErrorContext<'e>(&'e clap::Error);

impl ErrorContext<'_> {
    /// Returns all texts of this kind; empty if clap gives none.
    fn all(&self, kind: ContextKind) -> Vec<String> {
        match self.0.get(kind) {
            Some(ContextValue::String(text)) => vec![text.clone()],
            Some(ContextValue::Strings(texts)) => texts.clone(),
            Some(ContextValue::StyledStr(text)) => vec![one_line(&text.to_string())],
            Some(ContextValue::StyledStrs(texts)) => texts
                .iter()
                .map(|text| one_line(&text.to_string()))
                .collect(),
            Some(ContextValue::Number(number)) => vec![number.to_string()],
            _ => Vec::new(),
        }
    }

    /// Returns the first text of this kind in backticks.
    fn quoted(&self, kind: ContextKind) -> String {
        self.all(kind)
            .first()
            .map_or_else(|| "an option".to_owned(), |text| format!("`{text}`"))
    }

    /// Returns the sentence that states the error.
    fn message(&self) -> String {
        let argument = || self.quoted(ContextKind::InvalidArg);
        let value = || self.quoted(ContextKind::InvalidValue);
        match self.0.kind() {
            ErrorKind::InvalidSubcommand => {
                format!(
                    "unknown command {}",
                    self.quoted(ContextKind::InvalidSubcommand)
                )
            }
            ErrorKind::UnknownArgument => format!("unexpected argument {}", argument()),
            ErrorKind::MissingRequiredArgument => {
                let missing = self.all(ContextKind::InvalidArg);
                format!("missing: {}", missing.join(" "))
            }
            ErrorKind::InvalidValue if self.all(ContextKind::InvalidValue).concat().is_empty() => {
                format!("{} needs a value", argument())
            }
            ErrorKind::InvalidValue => format!("invalid value {} for {}", value(), argument()),
            ErrorKind::ValueValidation => {
                let why = self
                    .0
                    .source()
                    .map_or_else(String::new, |why| format!(": {why}"));
                format!("invalid value {} for {}{why}", value(), argument())
            }
            ErrorKind::ArgumentConflict => match self.all(ContextKind::PriorArg) {
                others if others.is_empty() => format!("{} cannot be used here", argument()),
                others if others == self.all(ContextKind::InvalidArg) => {
                    format!("{} is given more than once", argument())
                }
                others => format!(
                    "{} cannot be used with `{}`",
                    argument(),
                    others.join("`, `")
                ),
            },
            ErrorKind::TooManyValues => format!("too many values: {} for {}", value(), argument()),
            ErrorKind::TooFewValues | ErrorKind::WrongNumberOfValues => {
                let counts = [ContextKind::MinValues, ContextKind::ExpectedNumValues];
                let wanted: Vec<String> =
                    counts.into_iter().flat_map(|kind| self.all(kind)).collect();
                let given = self.all(ContextKind::ActualNumValues).concat();
                format!(
                    "{} takes {} values, not {given}",
                    argument(),
                    wanted.concat()
                )
            }
            ErrorKind::MissingSubcommand => "a command is missing".to_owned(),
            ErrorKind::InvalidUtf8 => "an argument is not UTF-8".to_owned(),
            other => other.as_str().unwrap_or("invalid command line").to_owned(),
        }
    }

    /// Returns hints: suggestions of clap, and usage.
    fn hints(&self) -> Vec<String> {
        let suggested = [
            ContextKind::SuggestedSubcommand,
            ContextKind::SuggestedArg,
            ContextKind::SuggestedValue,
        ];
        let suggested: Vec<String> = suggested
            .into_iter()
            .flat_map(|kind| self.all(kind))
            .collect();
        let mut hints = Vec::new();
        let known = [ContextKind::ValidValue, ContextKind::ValidSubcommand];
        let known: Vec<String> = known.into_iter().flat_map(|kind| self.all(kind)).collect();
        if !suggested.is_empty() {
            hints.push(format!("did you mean `{}`?", suggested.join("` or `")));
        } else if self.0.kind() == ErrorKind::InvalidSubcommand {
            hints.push("`magician help` lists them".to_owned());
        }
        if suggested.is_empty() && !known.is_empty() {
            hints.push(format!("possible values: {}", known.join(", ")));
        }
        hints.extend(self.all(ContextKind::Suggested));
        if hints.is_empty() {
            hints.extend(self.all(ContextKind::Usage));
        }
        hints
    }
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use std::ffi::OsString;

    use super::*;
    use crate::args::Cli;

    fn first_line(line: &str) -> String {
        let words: Vec<OsString> = line.split(' ').map(OsString::from).collect();
        let error = Cli::parse(&words).map(drop).expect_err("a mistake");
        Failure::from(&error).to_string()
    }

    #[test]
    fn each_mistake_quotes_the_typed_text() {
        let cases = [
            ("magician drow x.svg", "unknown command `drow`"),
            ("magician home --fast", "unexpected argument `--fast`"),
            ("magician run", "missing: <FILE>"),
            ("magician --port", "`--port <PORT>` needs a value"),
            (
                "magician --window 0 pose",
                "invalid value `0` for `--window <N>`: expected 1 to 8",
            ),
            ("magician get", "missing: <NAME>"),
        ];
        for (line, wanted) in cases {
            assert!(
                first_line(line).starts_with(wanted),
                "{line}: {}",
                first_line(line)
            );
        }
    }

    #[test]
    fn flag_of_other_verbs_names_those_verbs() {
        let words = ["magician", "write", "Anna", "--despeckle", "2"].map(OsString::from);
        let error = Cli::parse(&words).map(drop).expect_err("a mistake");
        let hints = ErrorContext(&error).hints().join("; ");
        assert!(hints.contains("`magician draw`"), "{hints}");
        assert!(hints.ends_with(" accept it"), "{hints}");
    }
}
