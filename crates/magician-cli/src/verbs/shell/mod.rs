//! `shell`: runs verbs line by line over one connection.

mod complete;
mod editor;
mod input;
mod words;

use std::ffi::OsString;
use std::io::{self, IsTerminal, Write};

use clap::Args;

use crate::context::Context;
use crate::failure::{Failure, Kind};
use crate::interrupt::Signal;
use crate::options::Global;
use crate::paint::Paint;
use input::{Input, LineReader};

/// Run verbs over one connection, from a terminal or a script
#[derive(Args, Debug)]
#[command(after_help = "\
A line is a verb with its arguments, as on the command line but without `magician`; # starts a \
comment, `exit` ends the shell. On a terminal Tab completes, the arrow keys recall earlier lines, \
Ctrl-C stops the running verb, and Ctrl-D ends the shell.

  magician --port ./arm shell < script
  echo 'pose' | magician shell

A script stops at the first line that fails, with that line's exit status.")]
pub(crate) struct Shell {
    /// Continue a script after a line that fails; the exit status is that of the first failure
    #[arg(long)]
    keep_going: bool,
}

impl Shell {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        context.enter_shell();
        let session = context.global.clone();
        if io::stdin().is_terminal() {
            run_interactive(&session, context)
        } else {
            self.run_script(&session, context)
        }
    }

    /// Runs the lines of a script.
    fn run_script(&self, session: &Global, context: &mut Context) -> Result<(), Failure> {
        let mut lines = LineReader::open(None);
        let mut first = None;
        for number in 1_u64.. {
            let line = match lines.next(context)? {
                Input::Line(line) if !is_exit(&line) => line,
                Input::Signal(signal) => return Err(context.interrupt(signal)?),
                _ => break,
            };
            let outcome = run_line(&line, session, context);
            if outcome.is_ok() && context.is_terminated() {
                return Err(context.interrupt(Signal::Terminate)?);
            }
            let Err(mut failure) = outcome else {
                continue;
            };
            failure.message = format!("line {number}: {}", failure.message);
            context.out.flush()?;
            // An interruption ends the shell even with `--keep-going`.
            if !self.keep_going || failure.kind == Kind::Interrupted {
                return Err(failure);
            }
            failure.report(session.json);
            first = first.or(Some(failure.kind));
        }
        first.map_or(Ok(()), |kind| Err(Failure::already_reported(kind)))
    }
}

/// Runs the lines that a user types.
fn run_interactive(session: &Global, context: &mut Context) -> Result<(), Failure> {
    let mut lines = LineReader::open(Some((context.command_line.description)()));
    if !session.json {
        let hint = "Tab completes, `help` lists the verbs, Ctrl-D ends";
        writeln!(io::stderr(), "{}", Paint::for_stderr().dim(hint))?;
    }
    loop {
        let line = match lines.next(context)? {
            Input::Line(line) if is_exit(&line) => return Ok(()),
            Input::Line(line) => line,
            // Like other shells, an interactive one survives Ctrl-C, but no other signal.
            Input::Abandoned | Input::Signal(Signal::Interrupt) => continue,
            Input::Signal(signal) => return Err(context.interrupt(signal)?),
            Input::End => return Ok(()),
        };
        let outcome = run_line(&line, session, context);
        context.out.flush()?;
        match outcome {
            Err(failure) if context.is_terminated() => return Err(failure),
            Err(failure) => failure.report(session.json),
            Ok(()) if context.is_terminated() => return Err(context.interrupt(Signal::Terminate)?),
            Ok(()) => (),
        }
    }
}

fn is_exit(line: &str) -> bool {
    matches!(line.trim(), "exit" | "quit")
}

/// Runs one line.
fn run_line(line: &str, session: &Global, context: &mut Context) -> Result<(), Failure> {
    let words = words::split(line)?;
    if words.is_empty() {
        return Ok(());
    }
    let arguments = ["magician".to_owned()].into_iter().chain(words);
    let arguments: Vec<OsString> = arguments.map(OsString::from).collect();
    (context.command_line.follow)(&arguments, session, context)
}
