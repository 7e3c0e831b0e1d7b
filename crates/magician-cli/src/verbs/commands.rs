//! `commands`: lists the commands of the protocol, or explains one.

use clap::Args;
use magician_protocol::{Row, TABLE};
use serde::Serialize;

use crate::catalogue::{self, Entry, Names, chapter_name, normalised_name};
use crate::columns::{Columns, note};
use crate::context::Context;
use crate::failure::Failure;
use crate::output::Output;

/// List or explain the commands of the protocol
#[derive(Args, Debug)]
pub(crate) struct Commands {
    /// Command to explain: its name (as in the vendor's document or in Rust) or its id
    #[arg(conflicts_with_all = ["chapter", "word"], value_parser = Names, hide_possible_values = true)]
    name: Option<String>,
    /// List only the commands of one chapter: info, pose, alarm, home, teach, tool, jog, ptp, cp,
    /// arc, wait, trigger, io, calibration, wifi, lost-step, queue
    #[arg(long)]
    chapter: Option<String>,
    /// List only commands with this word in their name or description
    #[arg(long)]
    word: Option<String>,
}

#[derive(Serialize)]
struct List {
    commands: Vec<Entry>,
}

impl Commands {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        if let Some(name) = &self.name {
            return catalogue::explain(name, context);
        }
        self.check_chapter()?;
        let rows: Vec<_> = TABLE.iter().filter(|row| self.matches(row)).collect();
        let commands = rows.iter().map(|row| Entry::brief(row)).collect();
        context.show(&List { commands }, |out| list(&rows, out))
    }

    fn check_chapter(&self) -> Result<(), Failure> {
        let Some(wanted) = &self.chapter else {
            return Ok(());
        };
        let mut names: Vec<_> = TABLE.iter().map(chapter_name).collect();
        names.dedup();
        if names
            .iter()
            .any(|name| normalised_name(name) == normalised_name(wanted))
        {
            return Ok(());
        }
        names.sort();
        names.dedup();
        let message = format!("unknown chapter `{wanted}`");
        Err(Failure::usage(message).hint(format!("chapters: {}", names.join(", "))))
    }

    fn matches(&self, row: &Row) -> bool {
        let chapter = self.chapter.as_ref();
        let word = self.word.as_ref().map(|word| word.to_lowercase());
        chapter
            .is_none_or(|chapter| normalised_name(chapter) == normalised_name(&chapter_name(row)))
            && word.is_none_or(|word| {
                normalised_name(row.name).contains(&normalised_name(&word))
                    || row.doc.to_lowercase().contains(&word)
            })
    }
}

fn list(rows: &[&'static Row], out: &mut Output) -> Result<(), Failure> {
    let count = match rows.len() {
        0 => return out.line("no command matches; `magician commands` lists them all"),
        1 => "1 command".to_owned(),
        count => format!("{count} commands"),
    };
    let mut columns = Columns::default();
    for row in rows {
        columns.row([
            row.name,
            &row.id.to_string(),
            &forms(row),
            &chapter_name(row),
            row.doc,
        ]);
    }
    columns.write(out)?;
    let legend = "g get, s set, q queue, ! a set needs --yes";
    let summary = format!("{count}; {legend}; `magician commands NAME` explains one");
    note(&summary, out)
}

/// Returns the forms of a command as four characters, such as `gsq!`; `-` stands for an absent one.
fn forms(row: &Row) -> String {
    let letter = |there, letter| if there { letter } else { '-' };
    String::from_iter([
        letter(row.value.is_some(), 'g'),
        letter(row.set.is_some(), 's'),
        letter(row.set.is_some() && row.queueable, 'q'),
        letter(row.dangerous, '!'),
    ])
}
