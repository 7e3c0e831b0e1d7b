//! `config`: shows and changes the settings that apply if no flag overrides them.

use clap::{Args, Subcommand};
use serde::Serialize;

use crate::columns::Columns;
use crate::config::{Config, KEYS, Key, Source, arms, suggestion};
use crate::context::Context;
use crate::failure::Failure;

/// Smallest terminal width, in columns, at which the list also shows what each setting means.
const WIDE_LIST_WIDTH: usize = 120;

/// Show or change settings: defaults of options, named arms
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician config                      every setting, its value and its source
  magician config set port /dev/ttyUSB0
  magician config set tool pen
  magician config unset port
  magician config set arms.white.port /dev/ttyUSB0
  magician config set arms.white.fence.floor -60

An option overrides its environment variable (MAGICIAN_PORT, MAGICIAN_TOOL, MAGICIAN_WINDOW), which \
overrides the settings file. MAGICIAN_CONFIG sets the path of that file.")]
pub(crate) struct Show {
    #[command(subcommand)]
    action: Option<Action>,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Print one value; `magician config` lists the names
    Get {
        /// Name of the setting
        key: String,
    },
    /// Save a value
    Set {
        /// Name of the setting
        key: String,
        /// New value
        #[arg(allow_hyphen_values = true)]
        value: String,
    },
    /// Remove a value
    Unset {
        /// Name of the setting
        key: String,
    },
    /// Print the path of the settings file
    Path,
}

/// Setting as JSON.
#[derive(Serialize)]
struct Setting {
    key: String,
    value: Option<String>,
    source: Source,
}

#[derive(Serialize)]
struct SettingList {
    path: Option<String>,
    settings: Vec<Setting>,
}

#[derive(Serialize)]
struct ConfigPath {
    path: String,
}

impl Show {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        match self.action {
            None => show_all(context),
            Some(Action::Get { key }) if arms::is_name(&key) => show_arm_setting(&key, context),
            Some(Action::Set { key, value }) if arms::is_name(&key) => {
                let text = arms::to_toml(&key, &value);
                let text = text.map_err(|why| Failure::usage(format!("{key}: {why}")))?;
                Config::load()?.set_arm_value(&key, Some(&text))?;
                show_arm_setting(&key, context)
            }
            Some(Action::Unset { key }) if arms::is_name(&key) => {
                Config::load()?.set_arm_value(&key, None)?;
                show_arm_setting(&key, context)
            }
            Some(Action::Get { key }) => show_setting(key_named(&key)?, context),
            Some(Action::Set { key, value }) => {
                let key = key_named(&key)?;
                let text = key.write(&value);
                let text = text.map_err(|why| Failure::usage(format!("{}: {why}", key.name)))?;
                Config::load()?.set(key.name, &text)?;
                show_setting(key, context)
            }
            Some(Action::Unset { key }) => {
                let key = key_named(&key)?;
                Config::load()?.unset(key.name)?;
                show_setting(key, context)
            }
            Some(Action::Path) => {
                let path = path_of(&Config::load()?)
                    .ok_or_else(|| Failure::invalid("this system has no directory for settings"))?;
                context.show(&ConfigPath { path: path.clone() }, |out| out.line(&path))
            }
        }
    }
}

fn path_of(config: &Config) -> Option<String> {
    config.path().map(|path| path.display().to_string())
}

fn key_named(name: &str) -> Result<&'static Key, Failure> {
    Key::named(name)
        .ok_or_else(|| Failure::usage(format!("unknown setting `{name}`")).hint(suggestion(name)))
}

fn setting(config: &Config, key: &Key) -> Setting {
    let (value, source) = config.value(key).unzip();
    Setting {
        key: key.name.to_owned(),
        value,
        source: source.unwrap_or(Source::Default),
    }
}

fn show_setting(key: &'static Key, context: &mut Context) -> Result<(), Failure> {
    let setting = setting(&Config::load()?, key);
    context.show(&setting, |out| match &setting.value {
        Some(value) => out.line(value),
        None => out.line(format_args!("not set ({})", key.default)),
    })
}

fn setting_of_arm(config: &Config, name: &str) -> Setting {
    let value = config.arm_value(name).map(str::to_owned);
    let source = match value {
        Some(_) => Source::File,
        None => Source::Default,
    };
    Setting {
        key: name.to_owned(),
        value,
        source,
    }
}

fn show_arm_setting(name: &str, context: &mut Context) -> Result<(), Failure> {
    let setting = setting_of_arm(&Config::load()?, name);
    context.show(&setting, |out| match &setting.value {
        Some(value) => out.line(value),
        None => out.line(format_args!("not set ({})", arms::default_of(name))),
    })
}

/// Returns the settings of all arms in the file.
fn arm_settings(config: &Config) -> Vec<Setting> {
    let names = config
        .arms()
        .iter()
        .flat_map(|arm| arms::names_of(&arm.name));
    let settings = names.map(|(name, _)| setting_of_arm(config, &name));
    settings.filter(|setting| setting.value.is_some()).collect()
}

fn show_all(context: &mut Context) -> Result<(), Failure> {
    let config = Config::load()?;
    let all = SettingList {
        path: path_of(&config),
        settings: (KEYS.iter().map(|key| setting(&config, key)))
            .chain(arm_settings(&config))
            .collect(),
    };
    context.show(&all, |out| {
        let mut columns = Columns::default();
        let is_wide = out.width() >= WIDE_LIST_WIDTH;
        for (key, setting) in KEYS.iter().zip(&all.settings) {
            let source = match (setting.source, key.variable) {
                (Source::Environment, Some(variable)) => variable,
                (Source::File, _) => "file",
                _ => "default",
            };
            let value = setting.value.as_deref().unwrap_or(key.default);
            if is_wide {
                columns.row([key.name, value, source, key.about])
            } else {
                columns.row([key.name, value, source])
            }
        }
        for setting in all.settings.iter().skip(KEYS.len()) {
            let value = setting.value.as_deref().unwrap_or_default();
            if is_wide {
                columns.row([setting.key.as_str(), value, "file", ""])
            } else {
                columns.row([setting.key.as_str(), value, "file"])
            }
        }
        columns.write(out)?;
        match &all.path {
            Some(path) => out.line(format_args!("\nfile: {path}")),
            None => Ok(()),
        }
    })
}
