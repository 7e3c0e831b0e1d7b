//! `man`: writes manual pages.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::{Args, Command};
use clap_mangen::Man as Page;
use magician_job::files::write_whole;

use crate::context::Context;
use crate::failure::Failure;
use crate::output::Text;

/// Print the manual page, or write one page for each verb
#[derive(Args, Debug)]
#[command(after_help = "To view it: magician man | man -l -")]
pub(crate) struct Man {
    /// Directory for the pages; created if missing
    dir: Option<PathBuf>,
}

impl Man {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let description = (context.command_line.description)();
        let Some(dir) = self.dir else {
            let mut page = Vec::new();
            Page::new(description).render(&mut page)?;
            let page = String::from_utf8_lossy(&page).into_owned();
            return context.show(&Text::from(page.clone()), |out| {
                Ok(out.write_all(page.as_bytes())?)
            });
        };
        std::fs::create_dir_all(&dir)
            .and_then(|()| write_pages(description, &dir))
            .map_err(|error| {
                let dir = dir.display();
                Failure::invalid(format!("the pages cannot be written into {dir}: {error}"))
            })?;
        let told = format!("pages written into {}", dir.display());
        context.show(&Text::from(told.clone()), |out| out.line(&told))
    }
}

/// Writes the page of a command and of each of its subcommands.
fn write_pages(command: Command, dir: &Path) -> io::Result<()> {
    let mut command = command.disable_help_subcommand(true);
    command.build();
    let below = command.get_subcommands().filter(|verb| !verb.is_hide_set());
    below.cloned().try_for_each(|verb| write_pages(verb, dir))?;
    let page = Page::new(command);
    let mut text = Vec::new();
    page.render(&mut text)?;
    write_whole(&dir.join(page.get_filename()), &text)
}
