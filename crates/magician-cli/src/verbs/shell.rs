//! `shell`: the verbs, line by line, over one connection.

use std::ffi::OsString;
use std::io::{self, BufRead, IsTerminal, Write};
use std::sync::mpsc;

use clap::Args;
use tokio::sync::mpsc as channel;

use crate::args::{Cli, Global, Verb};
use crate::context::Context;
use crate::failure::{Failure, Kind};
use crate::interrupt::Signals;

/// Do several things over one connection, line by line from a terminal or a script
#[derive(Args, Debug)]
#[command(after_help = "\
A line is a verb with its arguments, as on the command line but without `magician`; # begins a comment, `exit` ends.

  magician --port ./arm shell < script
  echo 'pose' | magician shell

A script stops at the first line that fails, with that line's exit status.")]
pub(crate) struct Shell {
    /// Go on with a script after a line that fails; the exit status is that of the first failure
    #[arg(long)]
    keep_going: bool,
}

/// What came from the input.
enum Input {
    Line(String),
    End,
    Interrupt,
}

impl Shell {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let terminal = io::stdin().is_terminal();
        let session = context.global.clone();
        let mut lines = Lines::open();
        let mut first = None;
        context.in_shell = true;
        loop {
            if terminal {
                write!(io::stderr(), "magician> ").and_then(|()| io::stderr().flush())?;
            }
            let line = match lines.next(context)? {
                Input::Line(line) => line,
                Input::Interrupt if terminal => {
                    writeln!(io::stderr())?;
                    continue;
                }
                Input::Interrupt => return Err(Failure::interrupted()),
                Input::End => break,
            };
            if matches!(line.trim(), "exit" | "quit") {
                break;
            }
            let Err(failure) = one(&line, &session, context) else {
                continue;
            };
            context.out.flush()?;
            if !terminal && !self.keep_going {
                return Err(failure);
            }
            failure.report(session.json);
            first = first.or(Some(failure.kind));
        }
        if terminal {
            return Ok(());
        }
        first.map_or(Ok(()), |kind| Err(Failure::told(kind)))
    }
}

/// Does one line.
fn one(line: &str, session: &Global, context: &mut Context) -> Result<(), Failure> {
    let words = split(line)?;
    if words.is_empty() {
        return Ok(());
    }
    let arguments = ["magician".to_owned()].into_iter().chain(words);
    let arguments: Vec<OsString> = arguments.map(OsString::from).collect();
    let mut cli = match Cli::read(&arguments) {
        Ok(cli) => cli,
        Err(error) => return crate::usage(&error, &mut context.out),
    };
    if matches!(
        cli.verb,
        Some(Verb::Shell(_) | Verb::Sim(_) | Verb::Demo(_))
    ) {
        return Err(Failure::usage("this verb does not work within a shell"));
    }
    let global = &mut cli.global;
    if arguments
        .iter()
        .any(|word| word == "--port" || word == "-p")
    {
        let hint = "give --port to the shell itself";
        return Err(Failure::usage("a shell has one connection").hint(hint));
    }
    global.port.clone_from(&session.port);
    global.json |= session.json;
    global.yes |= session.yes;
    global.timeout = global.timeout.or(session.timeout);
    context.line(cli)
}

/// The words of a line: separated by spaces, kept together by quotes, up to a `#`.
fn split(line: &str) -> Result<Vec<String>, Failure> {
    let mut words = Vec::new();
    let mut word: Option<String> = None;
    let mut quote = None;
    for letter in line.chars() {
        match (quote, letter) {
            (Some(mark), letter) if letter == mark => quote = None,
            (Some(_), letter) => word.get_or_insert_default().push(letter),
            (None, '"' | '\'') => {
                quote = Some(letter);
                word.get_or_insert_default();
            }
            (None, '#') if word.is_none() => break,
            (None, letter) if letter.is_whitespace() => words.extend(word.take()),
            (None, letter) => word.get_or_insert_default().push(letter),
        }
    }
    if let Some(mark) = quote {
        return Err(Failure::usage(format!("a {mark} is not closed")));
    }
    words.extend(word);
    Ok(words)
}

/// The lines of stdin, read on a thread of their own so that signals and the connection are served
/// meanwhile. A line is read when it is asked for, not before: a verb may want the terminal.
struct Lines {
    wanted: mpsc::Sender<()>,
    lines: channel::Receiver<io::Result<Option<String>>>,
    asked: bool,
}

impl Lines {
    fn open() -> Self {
        let (wanted, wishes) = mpsc::channel();
        let (sender, lines) = channel::channel(1);
        std::thread::spawn(move || {
            let mut stdin = io::stdin().lock();
            while wishes.recv().is_ok() {
                let mut line = String::new();
                let read = stdin.read_line(&mut line);
                let read = read.map(|count| (count > 0).then_some(line));
                if sender.blocking_send(read).is_err() {
                    break;
                }
            }
        });
        Self {
            wanted,
            lines,
            asked: false,
        }
    }

    fn next(&mut self, context: &mut Context) -> Result<Input, Failure> {
        let runtime = context.runtime()?;
        if !self.asked {
            self.asked = self.wanted.send(()).is_ok();
        }
        let read = runtime.block_on(async {
            let mut signals = Signals::listen()?;
            tokio::select! {
                read = self.lines.recv() => Ok(read),
                _ = signals.next() => Err(Failure::interrupted()),
            }
        });
        match read {
            Ok(Some(Ok(Some(line)))) => {
                self.asked = false;
                Ok(Input::Line(line))
            }
            Ok(Some(Err(error))) => Err(Failure::invalid(format!("stdin cannot be read: {error}"))),
            Ok(_) => Ok(Input::End),
            Err(failure) if failure.kind == Kind::Interrupted => Ok(Input::Interrupt),
            Err(failure) => Err(failure),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::split;

    #[test]
    fn words_quotes_and_comments() {
        let words = |line| split(line).map_err(|failure| failure.message);
        assert_eq!(
            words("move 1  -2 3 # up"),
            Ok(["move", "1", "-2", "3"].map(String::from).to_vec())
        );
        assert_eq!(
            words("set X device_name='my arm'"),
            Ok(["set", "X", "device_name=my arm"]
                .map(String::from)
                .to_vec())
        );
        assert_eq!(words("  # nothing"), Ok(Vec::new()));
        assert_eq!(words("''"), Ok(vec![String::new()]));
        assert!(words("set name=\"open").is_err());
    }
}
