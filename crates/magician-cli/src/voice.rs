//! Wording of remedies for errors and notes, in verbs and flags of the command.

use std::cell::RefCell;
use std::collections::BTreeSet;

use magician::{Act, Action, PinUse, Setting, SettingValue, Voice};

/// Voice of the command.
pub(crate) struct Command;

thread_local! {
    /// Flags of the verb that this thread runs; `None` before one is parsed.
    static FLAGS: RefCell<Option<BTreeSet<String>>> = const { RefCell::new(None) };
}

/// Sets the verb that is running: remedies name only flags that it has.
pub(crate) fn set_running_verb(verb: &clap::Command) {
    let flags = verb.get_arguments().filter_map(clap::Arg::get_long);
    let flags = flags.map(str::to_owned).collect();
    FLAGS.with_borrow_mut(|own| *own = Some(flags));
}

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
            Action::SuctionOff => "suction off",
            Action::GripperOff => "gripper off",
            Action::ListPorts => "ports",
            Action::ListCommands => "commands",
            Action::CalibrateSurface | Action::TouchOff => "calibrate surface",
            Action::UseRail => "rail on",
            Action::Engrave => "engrave FILE",
            other => return other.name().to_owned(),
        };
        format!("`magician {verb}`")
    }

    fn give(&self, setting: Setting, given: &SettingValue) -> String {
        match given {
            SettingValue::On => self.setting(setting),
            SettingValue::Off => self.setting(setting).replacen("--", "--no-", 1),
            given => format!("{} {given}", self.setting(setting)),
        }
    }

    fn can_follow(&self, act: &Act) -> bool {
        let flag = match act {
            Act::Give(setting, given) => self.give(*setting, given),
            Act::Omit(setting) => self.setting(*setting),
            _ => return true,
        };
        let name = flag.trim_start_matches("--");
        let name = name.split(' ').next().unwrap_or_default();
        FLAGS.with_borrow(|own| own.as_ref().is_none_or(|own| own.contains(name)))
    }

    fn set_pin(&self, pin: u8, function: PinUse) -> String {
        format!("`magician io mux {pin} {}`", function.name())
    }

    fn system(&self, line: &str) -> String {
        format!("`{line}`")
    }

    fn use_station(&self, url: &str) -> String {
        format!("`magician --station {url} VERB`")
    }

    fn setting(&self, setting: Setting) -> String {
        match setting {
            Setting::AllowLaser | Setting::TryQueue => "--yes".to_owned(),
            setting => format!("--{}", setting.name().replace('_', "-")),
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use magician::report::remedies as json;
    use magician::{Error, ErrorCode, Remedy};

    use super::*;
    use crate::args::Cli;
    use crate::failure::Failure;
    use crate::paint::Paint;

    /// True if a verb or one of its subcommands has this flag.
    fn has_flag(verb: &clap::Command, flag: &str) -> bool {
        let own = verb.get_arguments().any(|arg| arg.get_long() == Some(flag));
        own || verb.get_subcommands().any(|verb| has_flag(verb, flag))
    }

    #[test]
    fn every_option_is_a_flag() {
        let command = Cli::command();
        for setting in Setting::ALL {
            let flag = Command.setting(*setting);
            let name = flag.trim_start_matches("--");
            let off = Command.give(*setting, &SettingValue::Off);
            let off = off.trim_start_matches("--");
            assert!(
                has_flag(&command, name) || has_flag(&command, off),
                "{flag}"
            );
        }
    }

    /// Returns all verbs without subcommands, each with the global flags.
    fn verbs(command: &clap::Command) -> Vec<&clap::Command> {
        let own = command.get_subcommands().flat_map(verbs);
        let own: Vec<_> = own.collect();
        if own.is_empty() { vec![command] } else { own }
    }

    #[test]
    fn remedy_names_only_flags_of_the_verb() {
        let mut command = Cli::command();
        command.build();
        let all: Vec<Remedy> = { Setting::ALL.iter() }
            .flat_map(|setting| {
                let given = [
                    SettingValue::On,
                    SettingValue::Off,
                    SettingValue::Any("VALUE"),
                ];
                let gives = given.map(|given| Remedy::new((*setting, given), "is a way"));
                gives.into_iter().chain([Remedy::without(*setting)])
            })
            .collect();
        let named = |said: Option<String>| -> BTreeSet<String> {
            let said = said.unwrap_or_default();
            let words = said.split([' ', ';']);
            let flags = words.filter_map(|word| word.strip_prefix("--"));
            flags.map(str::to_owned).collect()
        };
        let whole = named(Command.remedies(&all));
        assert!(whole.contains("no-order") && whole.contains("fit"));
        let mut is_left_out = false;
        for verb in verbs(&command) {
            set_running_verb(verb);
            let said = named(Command.remedies(&all));
            let longs = verb.get_arguments().filter_map(clap::Arg::get_long);
            let taken: BTreeSet<String> = longs.map(str::to_owned).collect();
            assert!(said.is_subset(&taken), "{}", verb.get_name());
            let usable: BTreeSet<String> = whole.intersection(&taken).cloned().collect();
            assert_eq!(said, usable, "{}", verb.get_name());
            is_left_out |= verb.get_name() == "engrave" && !said.contains("no-order");
        }
        assert!(is_left_out);
        FLAGS.with_borrow_mut(|own| *own = None);
    }

    #[test]
    fn every_error_is_written_as_text_and_json() {
        for code in ErrorCode::ALL {
            let error = Error::new(*code, "it is so").with_command("SetPTPCmd");
            let error = Action::ALL
                .iter()
                .fold(error, |error, action| error.remedy(*action, "mends it"));
            let error = Setting::ALL.iter().fold(error, |error, setting| {
                error.remedy((*setting, SettingValue::Any("VALUE")), "is a way")
            });
            let failure = Failure::from(&error);
            let mut said = Vec::new();
            failure
                .write_text(&mut said, Paint::for_stderr())
                .expect("memory");
            let said = String::from_utf8(said).expect("UTF-8");
            let mut json = Vec::new();
            failure.write_json(&mut json).expect("memory");
            let json: serde_json::Value = serde_json::from_slice(&json).expect("JSON");
            let json = &json["error"];
            let message = json["message"].as_str().expect("text");
            assert!(said.contains(message), "{said}");
            assert!(
                !message.contains(['`', '\n']) && !message.contains("--"),
                "{message}"
            );
            if *code == ErrorCode::LaserNotAllowed {
                assert!(said.contains("goggles") && said.contains("--yes"), "{said}");
                continue;
            }
            assert_eq!(
                (&json["code"], &json["kind"]),
                (&code.name().into(), &code.kind().name().into())
            );
            let remedies = json["remedies"].as_array().expect("a list");
            assert_eq!(remedies.len(), error.remedies().len());
            for remedy in error.remedies() {
                assert!(said.contains(&Command.act(&remedy.act)), "{said}");
            }
        }
    }

    #[test]
    fn json_has_names_and_values() {
        let remedies = [
            Remedy::new(Action::Home, "homes it"),
            Remedy::new((Setting::Scale, SettingValue::Number(0.5)), "fits there"),
            Remedy::new(
                (Setting::At, SettingValue::Point(220.0, -5.5)),
                "fits there",
            ),
            Remedy::new(
                (Setting::Order, SettingValue::Off),
                "keeps the order of the file",
            ),
            Remedy::new((Setting::White, SettingValue::Word("draw")), "keeps it"),
            Remedy::new((Setting::Start, SettingValue::Any("X,Y,Z")), "says it"),
            Remedy::without(Setting::Raw),
            Remedy::new(Act::System("sudo rfkill".into()), ""),
            Remedy::new(Act::UseStation("http://h/".into()), "uses it"),
        ];
        let expected = serde_json::json!([
            {"action": "home", "effect": "homes it"},
            {"option": "scale", "value": 0.5, "effect": "fits there"},
            {"option": "at", "value": [220.0, -5.5], "effect": "fits there"},
            {"option": "order", "value": false, "effect": "keeps the order of the file"},
            {"option": "white", "value": "draw", "effect": "keeps it"},
            {"option": "start", "effect": "says it"},
            {"without": "raw"},
            {"system": "sudo rfkill"},
            {"system": "magician --station http://h/ VERB", "effect": "uses it"},
        ]);
        let json = json(&remedies, serde_json::value::Serializer).expect("it has a JSON form");
        assert_eq!(json, expected);
    }

    #[test]
    fn every_action_is_a_command_line() {
        for action in Action::ALL {
            let line = Command.action(*action);
            let words = line.trim_matches('`').split(' ');
            let parsed = Cli::command().try_get_matches_from(words);
            assert!(parsed.is_ok(), "{line}: {}", parsed.unwrap_err());
        }
        for function in [PinUse::DigitalOutput, PinUse::Pwm] {
            let line = Command.set_pin(6, function);
            let words = line.trim_matches('`').split(' ');
            assert!(Cli::command().try_get_matches_from(words).is_ok(), "{line}");
        }
    }
}
