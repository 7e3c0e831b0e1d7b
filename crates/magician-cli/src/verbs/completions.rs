use clap::Args;
use clap_complete::Shell;

use crate::args::Cli;
use crate::context::Context;
use crate::failure::Failure;

/// Print a completion script for a shell
#[derive(Args, Debug)]
#[command(
    after_help = "For bash: magician completions bash > ~/.local/share/bash-completion/completions/magician"
)]
pub(crate) struct Completions {
    /// Shell
    shell: Shell,
}

impl Completions {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Cli::description(), "magician", &mut script);
        Ok(std::io::Write::write_all(&mut context.out, &script)?)
    }
}
