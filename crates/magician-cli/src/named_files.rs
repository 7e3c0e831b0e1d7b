//! Files that a command line names, checked before any verb runs: no output may overwrite another
//! file of the same command line.
//!
//! Roles are looked up by the name of the argument, so a verb cannot forget the check. A test fails
//! for a path argument without a role.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::ArgMatches;
use magician_job::files::check_distinct;

use crate::failure::Failure;

/// Argument id of the global option for a trace.
const TRACE: &str = "trace";

/// Use of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    Reads,
    /// Written; also if the verb reads the same file first, as an editor does.
    Writes,
}

/// Returns the role of a verb's argument; `None` if it names no file.
fn role(verb: &str, argument: &str) -> Option<Role> {
    Some(match (verb, argument) {
        ("record" | "teach" | "new", "file") => Role::Writes,
        (
            _,
            TRACE | "flash" | "html" | "out" | "picture" | "preview" | "record" | "save" | "to",
        ) => Role::Writes,
        (_, "class" | "file" | "font" | "input" | "pens" | "profile" | "scenario" | "schedule") => {
            Role::Reads
        }
        (_, "session" | "site_config" | "station_ca" | "tls_cert" | "tls_key" | "token_file") => {
            Role::Reads
        }
        _ => return None,
    })
}

/// Files of a command line.
#[derive(Clone, Debug, Default)]
pub(crate) struct NamedFiles {
    inputs: Vec<PathBuf>,
    outputs: Vec<PathBuf>,
    has_trace: bool,
}

impl NamedFiles {
    /// Collects the files from the arguments of a verb and its subcommands.
    pub(crate) fn of(matches: &ArgMatches) -> Self {
        let mut arguments = BTreeMap::new();
        let mut level = Some(("", matches));
        while let Some((verb, matches)) = level {
            for id in matches.ids() {
                let role = role(verb, id.as_str());
                let values = matches.try_get_raw(id.as_str()).ok().flatten();
                if let (Some(role), Some(values)) = (role, values) {
                    // Global options appear at each level; the map keeps one copy.
                    let values: Vec<OsString> = values.map(OsString::from).collect();
                    arguments.insert(id.as_str(), (role, values));
                }
            }
            level = matches.subcommand();
        }
        let mut files = Self {
            has_trace: arguments.contains_key(TRACE),
            ..Self::default()
        };
        for (role, values) in arguments.into_values() {
            let paths = values.into_iter().map(PathBuf::from);
            // `-` is standard input or output.
            let paths = paths.filter(|path| path != Path::new("-"));
            match role {
                Role::Reads => files.inputs.extend(paths),
                Role::Writes => files.outputs.extend(paths),
            }
        }
        files
    }

    /// Returns an error if an output is the same file as another one. `trace` is a shell's trace,
    /// unless the line has its own.
    pub(crate) fn check(&self, trace: Option<&Path>) -> Result<(), Failure> {
        let trace = trace.filter(|_| !self.has_trace);
        let [inputs, outputs] =
            [&self.inputs, &self.outputs].map(|paths| paths.iter().map(PathBuf::as_path));
        check_distinct(inputs, outputs.chain(trace)).map_err(|same| {
            Failure::usage(same.to_string()).hint("give each output file a different name")
        })
    }
}

#[cfg(test)]
mod tests {
    use std::any::TypeId;

    use clap::{Arg, Command, ValueHint};

    use super::*;
    use crate::args::Cli;

    /// Path arguments that are no files: directories and the name of a pseudo-terminal.
    const NO_FILES: &[&str] = &["dir", "export", "programs", "pty"];

    fn names_a_path(argument: &Arg) -> bool {
        let is_path = argument.get_value_parser().type_id() == TypeId::of::<PathBuf>();
        let names = argument.get_value_names().unwrap_or_default();
        let is_hinted = argument.get_value_hint() == ValueHint::FilePath;
        is_path || is_hinted || names.iter().any(|name| name.contains("FILE"))
    }

    fn check_roles(command: &Command) {
        for argument in command.get_arguments().filter(|one| names_a_path(one)) {
            let (verb, name) = (command.get_name(), argument.get_id().as_str());
            let is_known = role(verb, name).is_some() != NO_FILES.contains(&name);
            assert!(is_known, "{verb} {name}: is it read or written?");
        }
        command.get_subcommands().for_each(check_roles);
    }

    #[test]
    fn every_argument_that_names_a_file_has_a_role() {
        check_roles(&Cli::description());
    }

    #[test]
    fn file_that_a_verb_reads_or_writes_twice_is_refused_by_name() {
        let place = tempfile::tempdir().unwrap();
        let check = |line: &str| {
            let at = |word: &str| match word.strip_prefix('@') {
                Some(name) => place.path().join(name).into_os_string(),
                None => OsString::from(word),
            };
            let words: Vec<OsString> = line.split(' ').map(at).collect();
            let cli = Cli::read(&words).unwrap();
            cli.check_files().map_err(|failure| failure.message)
        };
        for line in [
            "magician draw @h.svg --preview @h.svg",
            "magician convert @h.svg @h.svg",
            "magician run @o.plan.json --record @o.plan.json",
            "magician run @o.plan.json --picture @p.svg --trace @p.svg",
            "magician --trace @o.plan.json run @o.plan.json",
            "magician draw @h.svg --preview @p.svg --picture @p.svg",
            "magician testgrid @p.svg --preview @p.svg",
            "magician sim --scenario @x.svg --picture @x.svg",
            "magician sim --trace @x --record @x",
            "magician sim --flash @x --record @x",
            "magician sim --profile @x --trace @x",
            "magician proxy --pty @arm --trace @x --station-ca @x",
            "magician replay @x --save @x",
            "magician replay @x --scenario @y --save @y",
            "magician record @x.csv --trace @x.csv",
            "magician teach @x.playback --trace @x.playback",
            "magician station class new @x --html @x",
            "magician demo --picture @x.svg --trace @x.svg",
            "magician decode @x --trace @x",
        ] {
            assert!(check(line).is_err(), "{line}");
        }
        for line in [
            "magician convert @h.svg @p.svg --trace @t",
            "magician run - --preview @p.svg --picture @q.svg",
            "magician sim --trace @x",
            "magician --trace @x sim --tcp 127.0.0.1:0",
            "magician teach @x.playback",
            "magician run @h.svg --trace /dev/null --record /dev/null",
        ] {
            assert_eq!(check(line), Ok(()), "{line}");
        }
    }
}
