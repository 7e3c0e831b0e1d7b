//! The `magician` command: find, look, move and simulate a Dobot Magician arm.
//!
//! The command holds no robot knowledge: a verb reads its arguments, asks the crates below, and
//! shows what they say. Each verb is one file in `verbs`.
#![forbid(unsafe_code)]

mod args;
mod catalogue;
mod columns;
mod config;
mod context;
mod diagnostics;
mod failure;
mod fence;
mod interrupt;
mod log;
mod mounted;
mod output;
mod permission;
mod progress;
mod recording;
mod saved;
mod serving;
mod source;
mod terminal;
mod throttle;
mod usage;
mod values;
mod verbs;
mod voice;

use std::ffi::OsString;
use std::panic::{self, AssertUnwindSafe};
use std::process::ExitCode;

use clap::error::ErrorKind;

use crate::args::Cli;
use crate::context::Context;
use crate::failure::{Failure, Kind};
use crate::output::{Output, Text};

fn main() -> ExitCode {
    let arguments: Vec<OsString> = std::env::args_os().collect();
    let json = asks_for_json(&arguments);
    let outcome = guarded(|| run(&arguments));
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            failure.report(json);
            ExitCode::from(failure.kind.status())
        }
    }
}

fn run(arguments: &[OsString]) -> Result<(), Failure> {
    let mut output = Output::stdout();
    let cli = match Cli::read(arguments) {
        Ok(cli) => cli,
        Err(error) => {
            let done = usage(&error, asks_for_json(arguments), &mut output);
            return done.and(output.flush());
        }
    };
    log::begin(&cli.global);
    Context::new(cli.global.clone(), output).run(cli)
}

/// Shows what clap has to say: help on stdout, a mistake as a failure.
pub(crate) fn usage(error: &clap::Error, json: bool, output: &mut Output) -> Result<(), Failure> {
    match error.kind() {
        ErrorKind::DisplayHelp if json => output.json(&Text::from(&error.render())),
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => output.styled(&error.render()),
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand if json => {
            Err(Failure::usage("a verb is missing").hint("`--help` lists them"))
        }
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            let _ = error.print();
            Err(Failure::told(Kind::Usage))
        }
        _ => Err(Failure::from(error)),
    }
}

/// Whether the arguments ask for JSON, also when they cannot be understood otherwise.
pub(crate) fn asks_for_json(arguments: &[OsString]) -> bool {
    let options = arguments.iter().take_while(|argument| *argument != "--");
    options.into_iter().any(|argument| argument == "--json")
}

/// Runs the command; a panic becomes a failure of kind bug.
fn guarded(work: impl FnOnce() -> Result<(), Failure>) -> Result<(), Failure> {
    let place = std::sync::Arc::new(std::sync::Mutex::new(String::new()));
    let seen = place.clone();
    panic::set_hook(Box::new(move |info| {
        if let Ok(mut text) = seen.lock() {
            *text = info.to_string();
        }
    }));
    panic::catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| {
        let what = place.lock().map(|text| text.clone()).unwrap_or_default();
        let version = env!("CARGO_PKG_VERSION");
        Err(Failure::new(
            Kind::Bug,
            format!(
                "this is a bug in magician {version}: {what}\n\
                 please report it with the command you gave, at the place where you got this \
                 program from (its issue tracker)"
            ),
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_a_bug_with_its_place_and_where_to_report() {
        let failure = guarded(|| panic!("the ceiling fell")).unwrap_err();
        assert_eq!(failure.kind.status(), 1);
        assert!(
            failure.message.contains("the ceiling fell"),
            "{}",
            failure.message
        );
        assert!(failure.message.contains("main.rs"), "{}", failure.message);
        assert!(failure.message.contains("report"), "{}", failure.message);
    }

    #[test]
    fn json_is_asked_for_before_the_double_dash_only() {
        let arguments = |words: &[&str]| words.iter().map(OsString::from).collect::<Vec<_>>();
        assert!(asks_for_json(&arguments(&[
            "magician", "nonsense", "--json"
        ])));
        assert!(!asks_for_json(&arguments(&[
            "magician", "decode", "--", "--json"
        ])));
    }
}
