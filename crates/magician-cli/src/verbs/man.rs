use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use crate::context::Context;
use crate::failure::Failure;
use crate::output::Text;

/// Print the manual page, or write one for each verb
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
            clap_mangen::Man::new(description).render(&mut page)?;
            let page = String::from_utf8_lossy(&page).into_owned();
            return context.show(&Text::from(page.clone()), |out| {
                Ok(out.write_all(page.as_bytes())?)
            });
        };
        std::fs::create_dir_all(&dir)
            .and_then(|()| clap_mangen::generate_to(description, &dir))
            .map_err(|error| {
                let dir = dir.display();
                Failure::invalid(format!("the pages cannot be written into {dir}: {error}"))
            })?;
        let told = format!("pages written into {}", dir.display());
        context.show(&Text::from(told.clone()), |out| out.line(&told))
    }
}
