//! The `magician` command: find, look, move and simulate a Dobot Magician arm.
//!
//! The command holds no knowledge of robots: a verb parses its arguments, calls the crates below,
//! and prints their results. Each verb is one file or directory in `verbs`.
//!
//! It is a library so that the Python package can include the command. Its only interface is
//! [`run`].
#![forbid(unsafe_code)]

mod args;
mod brief;
mod catalogue;
mod columns;
mod config;
mod context;
mod diagnostics;
mod failure;
mod fence;
mod interrupt;
mod json;
mod log;
mod mdns;
mod mounted;
mod named_files;
mod numbers;
mod options;
mod output;
mod paint;
mod permission;
mod progress;
mod saved;
mod serving;
mod source;
mod terminal;
mod throttle;
mod tokens;
mod usage;
mod values;
mod verbs;
mod voice;

use std::ffi::OsString;
use std::panic::{self, AssertUnwindSafe};

use crate::args::{COMMAND_LINE, Cli, has_json_flag, show_usage};
use crate::context::Context;
use crate::failure::{Failure, Kind};
use crate::output::Output;
use crate::verbs::serve::is_started_by_hand;

/// Runs the command and returns its exit status. The first argument is the program's name.
///
/// Meant for a separate process: it replaces the process's signal handlers, panic hook and log
/// subscriber.
#[must_use]
pub fn run(arguments: &[OsString]) -> u8 {
    match catch_panics(|| follow(arguments)) {
        Ok(()) => 0,
        Err(failure) => {
            failure.report(has_json_flag(arguments));
            failure.kind.status()
        }
    }
}

fn follow(arguments: &[OsString]) -> Result<(), Failure> {
    let mut output = Output::stdout();
    // Without arguments and a terminal, as after a double click, the program shows the studio.
    let by_hand = arguments.len() <= 1 && is_started_by_hand();
    let by_hand = by_hand.then(|| ["magician", "studio", "--app"].map(OsString::from));
    let arguments = by_hand.as_ref().map_or(arguments, |words| &words[..]);
    let cli = match Cli::parse(arguments) {
        Ok(cli) => cli,
        Err(error) => {
            let done = show_usage(&error, has_json_flag(arguments), &mut output);
            return done.and(output.flush());
        }
    };
    log::begin(&cli.global, cli.serves());
    if let Err(error) = interrupt::survive_file_limit() {
        tracing::warn!(%error, "reaching the file size limit will end this process");
    }
    let mut context = Context::new(cli.global.clone(), output, COMMAND_LINE);
    cli.run(&mut context)
}

/// Runs `work` and turns a panic into a failure of kind `Bug`.
fn catch_panics(work: impl FnOnce() -> Result<(), Failure>) -> Result<(), Failure> {
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
                 please report it, with the command you ran, in the issue tracker of this program"
            ),
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panic_is_reported_as_a_bug_with_its_location() {
        let failure = catch_panics(|| panic!("the ceiling fell")).unwrap_err();
        assert_eq!(failure.kind.status(), 1);
        assert!(
            failure.message.contains("the ceiling fell"),
            "{}",
            failure.message
        );
        assert!(failure.message.contains("lib.rs"), "{}", failure.message);
        assert!(failure.message.contains("report"), "{}", failure.message);
    }
}
