//! What to do about an error or a note, in the words of the command: verbs and flags.

use magician::{Action, Given, Setting, Voice};

/// The command's voice.
pub(crate) struct Command;

impl Voice for Command {
    fn action(&self, action: Action) -> String {
        let verb = match action {
            Action::ClearAlarms => "alarms --clear",
            Action::ListAlarms => "alarms",
            Action::StartQueue => "queue start",
            Action::Stop | Action::StopJog => "stop",
            Action::Jog => "jog",
            Action::Home => "home",
            Action::LaserOff => "laser off",
            Action::ListPorts => "ports",
            Action::ListCommands => "commands",
            Action::CalibrateSurface => "calibrate surface",
            other => return other.name().to_owned(),
        };
        format!("`magician {verb}`")
    }

    fn give(&self, setting: Setting, given: &Given) -> String {
        match given {
            Given::On => self.setting(setting),
            Given::Off => self.setting(setting).replacen("--", "--no-", 1),
            given => format!("{} {given}", self.setting(setting)),
        }
    }

    fn setting(&self, setting: Setting) -> String {
        match setting {
            Setting::AllowLaser => "--yes".to_owned(),
            setting => format!("--{}", setting.name().replace('_', "-")),
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;
    use crate::args::Cli;

    /// Whether a verb, or the command itself, takes this flag.
    fn is_taken(verb: &clap::Command, flag: &str) -> bool {
        let own = verb.get_arguments().any(|arg| arg.get_long() == Some(flag));
        own || verb.get_subcommands().any(|verb| is_taken(verb, flag))
    }

    #[test]
    fn every_option_is_a_flag() {
        let command = Cli::command();
        for setting in Setting::ALL {
            let flag = Command.setting(*setting);
            let name = flag.trim_start_matches("--");
            let off = Command.give(*setting, &Given::Off);
            let off = off.trim_start_matches("--");
            assert!(
                is_taken(&command, name) || is_taken(&command, off),
                "{flag}"
            );
        }
    }

    #[test]
    fn every_action_is_a_command_line() {
        for action in Action::ALL {
            let line = Command.action(*action);
            let words = line.trim_matches('`').split(' ');
            let parsed = Cli::command().try_get_matches_from(words);
            assert!(parsed.is_ok(), "{line}: {}", parsed.unwrap_err());
        }
    }
}
