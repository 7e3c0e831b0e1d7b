//! `write`: writes text with the pen.

use std::path::PathBuf;

use clap::Args;
use magician_program::{BundledFont, FontKind, Format, WorkOption};
use serde::Serialize;

use super::job::Job;
use super::job::options::{File, OptionFlags, PreviewFlags, RunFlags, Writes};
use crate::columns::Columns;
use crate::context::Context;
use crate::failure::Failure;

/// Write text with the pen, in single-line letters
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician write Anna --preview out.svg                  preview the text and its position
  magician write Happy birthday --font script --size 15
  magician write \"$(date +%F)\" --size 5 --at 220,60
  magician write - --wrap 120 --align center < poem.txt
  magician write 東京 --font 中.json                      in stroke order
  magician write --fonts                                 list the built-in fonts

A font file is a TrueType or OpenType font, whose letters are drawn as outlines; an SVG font, whose \
lines are drawn as they are; or a stroke-order file for Chinese and Japanese from KanjiVG or \
hanzi-writer. `magician engrave - --format text` burns text.")]
pub(crate) struct Write {
    /// Text to write; several words are joined by spaces; `-` reads stdin
    #[arg(required_unless_present = "fonts")]
    text: Vec<String>,
    /// List the built-in fonts
    #[arg(long, conflicts_with = "text")]
    fonts: bool,
    #[command(flatten)]
    look: PreviewFlags,
    #[command(flatten)]
    options: OptionFlags<Writes>,
    #[command(flatten)]
    way: RunFlags,
}

/// Font in the list.
#[derive(Serialize)]
struct FontReport {
    name: &'static str,
    kind: &'static str,
    /// Path of its file; `None` for a built-in font.
    file: Option<PathBuf>,
    licence: Option<&'static str>,
}

#[derive(Serialize)]
struct FontList {
    fonts: Vec<FontReport>,
}

impl Write {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        if self.fonts {
            return list(context);
        }
        self.job()?.run(context)
    }

    /// Creates the job from the flags.
    pub(super) fn job(self) -> Result<Job, Failure> {
        let (file, text) = match self.text.as_slice() {
            [stdin] if stdin == "-" => (File::from_argument("-", Format::Text), None),
            words => (
                File::from_argument("text", Format::Text),
                Some(words.join(" ")),
            ),
        };
        let draw = WorkOption::Draw;
        let mut job = Job::new(draw, file, self.look, &self.options, self.way)?;
        job.text = text;
        Ok(job)
    }
}

fn list(context: &mut Context) -> Result<(), Failure> {
    let fonts = BundledFont::ALL.into_iter().map(|font| FontReport {
        name: font.name(),
        kind: FontKind::Stroke.name(),
        file: None,
        licence: Some(font.licence()),
    });
    let list = FontList {
        fonts: fonts.collect(),
    };
    context.show(&list, |out| {
        let mut columns = Columns::default();
        for font in &list.fonts {
            columns.row([font.name, font.kind, font.licence.unwrap_or_default()]);
        }
        columns.write(out)
    })
}
