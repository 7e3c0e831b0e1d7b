//! `completions`: prints a completion script for a shell.

use std::io::Write;

use clap::Args;
use clap_complete::Shell;

use crate::context::Context;
use crate::failure::Failure;
use crate::output::Text;

/// Print a completion script for a shell
#[derive(Args, Debug)]
#[command(
    after_help = "For bash: magician completions bash > ~/.local/share/bash-completion/completions/magician"
)]
pub(crate) struct Completions {
    /// Shell to print the script for
    shell: Shell,
}

impl Completions {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let mut script = Vec::new();
        let mut description = (context.command_line.description)();
        clap_complete::generate(self.shell, &mut description, "magician", &mut script);
        let script = String::from_utf8_lossy(&script).into_owned();
        context.show(&Text::from(script.clone()), |out| {
            Ok(out.write_all(script.as_bytes())?)
        })
    }
}
