//! `preset`: named sets of drawing options.

use clap::{Args, Subcommand};
use magician_job::presets::{Preset, PresetError, PresetList, PresetReport, Presets};
use serde::Serialize;

use super::job::options::{Makes, OptionFlags, PresetName};
use crate::columns::Columns;
use crate::context::Context;
use crate::diagnostics::{self, Severity};
use crate::failure::Failure;

/// Show or change presets: flags of a pen, a laser, a material, under a name
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician preset list
  magician preset show wood-engrave
  magician preset save birch --power 5..65 --speed 18 --note \"3 mm birch plywood\"
  magician engrave photo.png --width 60 --preset birch --yes
  magician preset remove birch

A flag overrides the preset, which overrides the settings of `magician config`. A preset is a file, NAME.toml in the folder presets beside the file of \
settings (`magician config path`), whose keys are the names of flags: `travel_speed = 90`, `order = false` for --no-order. A file of the same name as a \
preset that comes with this program goes before it.

The presets that come with this program were not tried on a real arm: begin with a `magician testgrid` on a piece of the material.")]
pub(crate) struct Verb {
    #[command(subcommand)]
    deed: Deed,
}

#[derive(Debug, Subcommand)]
enum Deed {
    /// List all presets
    List,
    /// Print what a preset says
    Show {
        /// Name of the preset
        #[arg(value_parser = PresetName, hide_possible_values = true)]
        name: String,
    },
    /// Save these flags under a name, in the place of what was saved under it
    Save(Box<Save>),
    /// Remove the file of a preset
    Remove {
        /// Name of the preset
        #[arg(value_parser = PresetName, hide_possible_values = true)]
        name: String,
    },
}

/// Save these flags under a name, in the place of what was saved under it
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
        match self.deed {
            Deed::List => list(context),
            Deed::Show { name } => {
                let preset = load(&name)?;
                let text = preset.text.clone();
                context.show(&PresetReport::from(&preset), |out| {
                    out.line(text.trim_end())
                })
            }
            Deed::Save(save) => {
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
            Deed::Remove { name } => {
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
        PresetError::Shipped(_) => Some("`magician preset save` with the same name goes before it"),
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
