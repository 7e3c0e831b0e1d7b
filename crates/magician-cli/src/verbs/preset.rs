//! `preset`: named sets of drawing options.

use clap::{Args, Subcommand};
use magician_job::presets::{Preset, PresetError, PresetList, PresetReport, Presets};
use serde::Serialize;

use super::job::options::{Makes, OptionFlags, PresetName};
use crate::columns::Columns;
use crate::context::Context;
use crate::diagnostics::{self, Severity};
use crate::failure::Failure;

/// Show or change presets: named sets of flags for a pen, laser or material
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician preset list
  magician preset show wood-engrave
  magician preset save birch --power 5..65 --speed 18 --note \"3 mm birch plywood\"
  magician engrave photo.png --width 60 --preset birch --yes
  magician preset remove birch

Flags override the preset; the preset overrides the settings of `magician config`. A preset is a \
file NAME.toml in the folder presets next to the settings file (`magician config path`); its keys \
are the names of flags: `travel_speed = 90`, `order = false` for --no-order. A file overrides a \
built-in preset of the same name.

The built-in presets have not been tried on a real arm: start with a `magician testgrid` on a piece of the material.")]
pub(crate) struct Verb {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// List all presets
    List,
    /// Print the flags of a preset
    Show {
        /// Name of the preset
        #[arg(value_parser = PresetName, hide_possible_values = true)]
        name: String,
    },
    /// Save these flags as a preset, replacing one of the same name
    Save(Box<Save>),
    /// Remove the file of a preset
    Remove {
        /// Name of the preset
        #[arg(value_parser = PresetName, hide_possible_values = true)]
        name: String,
    },
}

/// Save these flags as a preset, replacing one of the same name
#[derive(Args, Debug)]
pub(crate) struct Save {
    /// Name of the preset: letters, digits, - and _
    name: String,
    /// Note for users of the preset
    #[arg(long, value_name = "TEXT")]
    note: Option<String>,
    #[command(flatten)]
    options: OptionFlags<Makes>,
}

#[derive(Serialize)]
struct Removed {
    removed: String,
    path: Option<String>,
}

impl Verb {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        match self.action {
            Action::List => list(context),
            Action::Show { name } => {
                let preset = load(&name)?;
                let text = preset.text.clone();
                context.show(&PresetReport::from(&preset), |out| {
                    out.line(text.trim_end())
                })
            }
            Action::Save(save) => {
                let options = save.options.options(false)?;
                let presets = Presets::of_user();
                let saved = presets.save(&save.name, save.note.as_deref(), &options);
                let saved = saved.map_err(|error| match error {
                    PresetError::Inexpressible(why) => Failure::usage(why),
                    error => failure(error),
                })?;
                context.show(&PresetReport::from(&saved), |out| match &saved.path {
                    Some(path) => out.line(format_args!("{}: {}", saved.name, path.display())),
                    None => Ok(()),
                })
            }
            Action::Remove { name } => {
                let path = Presets::of_user().remove(&name).map_err(failure)?;
                let removed = Removed {
                    removed: name,
                    path: path.map(|path| path.display().to_string()),
                };
                context.show(&removed, |out| {
                    let what = removed.path.as_ref().unwrap_or(&removed.removed);
                    out.line(format_args!("removed: {what}"))
                })
            }
        }
    }
}

/// Loads the preset of a name.
pub(super) fn load(name: &str) -> Result<Preset, Failure> {
    Presets::of_user().load(name).map_err(failure)
}

fn failure(error: PresetError) -> Failure {
    let hint = match &error {
        PresetError::NoDirectory => Some("set MAGICIAN_CONFIG to the path of the file of settings"),
        PresetError::Unknown(..) => Some("`magician preset list` lists them"),
        PresetError::Shipped(_) => Some("`magician preset save` with the same name overrides it"),
        _ => None,
    };
    let drawn = match &error {
        PresetError::Broken {
            path,
            text,
            problem,
        } => {
            let file = path.display().to_string();
            Some(diagnostics::draw(
                problem,
                Severity::Error,
                &file,
                Some(text),
            ))
        }
        _ => None,
    };
    let failure = Failure::invalid(error.to_string());
    let failure = match drawn {
        Some(drawn) => failure.drawn(drawn),
        None => failure,
    };
    hint.into_iter().fold(failure, Failure::hint)
}

fn list(context: &mut Context) -> Result<(), Failure> {
    let list = PresetList::of(&Presets::of_user());
    context.show(&list, |out| {
        let mut columns = Columns::default();
        for preset in &list.presets {
            let origin = if preset.shipped { "shipped" } else { "file" };
            let note = preset.problem.as_deref().or(preset.note.as_deref());
            columns.row([preset.name.as_str(), origin, note.unwrap_or_default()]);
        }
        columns.write(out)
    })
}
