//! `config`: the settings that hold without a flag.

use clap::{Args, Subcommand};
use serde::Serialize;

use crate::columns::Columns;
use crate::config::{Config, KEYS, Key, Source, near};
use crate::context::Context;
use crate::failure::Failure;

/// Columns of a terminal on which the meanings have room, too.
const ROOMY: usize = 120;

/// Show or change the settings that hold where no flag says otherwise
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician config                      every setting, its value, and where that comes from
  magician config set port /dev/ttyUSB0
  magician config set tool pen
  magician config unset port

A flag goes before a variable of the environment (MAGICIAN_PORT, MAGICIAN_TOOL, MAGICIAN_WINDOW), and that before the \
file. MAGICIAN_CONFIG names another file.")]
pub(crate) struct Show {
    #[command(subcommand)]
    deed: Option<Deed>,
}

#[derive(Debug, Subcommand)]
enum Deed {
    /// Print one value; `magician config` lists the names
    Get {
        /// Name of the setting
        key: String,
    },
    /// Keep a value
    Set {
        /// Name of the setting
        key: String,
        /// What it is from now on
        #[arg(allow_hyphen_values = true)]
        value: String,
    },
    /// Forget a value
    Unset {
        /// Name of the setting
        key: String,
    },
    /// Print where the file is
    Path,
}

/// A setting as JSON has it.
#[derive(Serialize)]
struct Setting {
    key: &'static str,
    value: Option<String>,
    source: Source,
}

#[derive(Serialize)]
struct All {
    path: Option<String>,
    settings: Vec<Setting>,
}

#[derive(Serialize)]
struct Place {
    path: String,
}

impl Show {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        match self.deed {
            None => all(context),
            Some(Deed::Get { key }) => one(key_named(&key)?, context),
            Some(Deed::Set { key, value }) => {
                let key = key_named(&key)?;
                let text = key.write(&value);
                let text = text.map_err(|why| Failure::usage(format!("{}: {why}", key.name)))?;
                Config::load()?.set(key.name, &text)?;
                one(key, context)
            }
            Some(Deed::Unset { key }) => {
                let key = key_named(&key)?;
                Config::load()?.unset(key.name)?;
                one(key, context)
            }
            Some(Deed::Path) => {
                let path = path_of(&Config::load()?).ok_or_else(|| {
                    Failure::invalid("the system names no directory for settings")
                })?;
                context.show(&Place { path: path.clone() }, |out| out.line(&path))
            }
        }
    }
}

fn path_of(config: &Config) -> Option<String> {
    config.path().map(|path| path.display().to_string())
}

fn key_named(name: &str) -> Result<&'static Key, Failure> {
    Key::named(name)
        .ok_or_else(|| Failure::usage(format!("there is no setting `{name}`")).hint(near(name)))
}

fn setting(config: &Config, key: &Key) -> Setting {
    let (value, source) = config.value(key).unzip();
    Setting {
        key: key.name,
        value,
        source: source.unwrap_or(Source::Default),
    }
}

fn one(key: &'static Key, context: &mut Context) -> Result<(), Failure> {
    let setting = setting(&Config::load()?, key);
    context.show(&setting, |out| match &setting.value {
        Some(value) => out.line(value),
        None => out.line(format_args!("not set ({})", key.default)),
    })
}

fn all(context: &mut Context) -> Result<(), Failure> {
    let config = Config::load()?;
    let all = All {
        path: path_of(&config),
        settings: KEYS.iter().map(|key| setting(&config, key)).collect(),
    };
    context.show(&all, |out| {
        let mut columns = Columns::default();
        let roomy = out.width() >= ROOMY;
        for (key, setting) in KEYS.iter().zip(&all.settings) {
            let source = match (setting.source, key.variable) {
                (Source::Environment, Some(variable)) => variable,
                (Source::File, _) => "file",
                _ => "default",
            };
            let value = setting.value.as_deref().unwrap_or(key.default);
            match roomy {
                true => columns.row([key.name, value, source, key.about]),
                false => columns.row([key.name, value, source]),
            }
        }
        columns.write(out)?;
        match &all.path {
            Some(path) => out.line(format_args!("\nfile: {path}")),
            None => Ok(()),
        }
    })
}
