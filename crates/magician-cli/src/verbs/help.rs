use clap::Args;
use clap::builder::StyledStr;

use crate::args::Cli;
use crate::catalogue;
use crate::context::Context;
use crate::failure::Failure;
use crate::output::Text;

/// What the exit status says.
const EXIT_STATUS: &str = "\
Exit status, and the kind of the error object that --json writes to stderr:
    0  done
    1  bug            a mistake of this program
    2  usage          the command line makes no sense, or --yes is missing
    3  invalid-input  a value makes no sense
       unreachable    the arm cannot get there
    4  port           the port is not there, not allowed, in use, or gone
       closed         the connection was closed, or a stop came first
    5  timeout        no answer by the deadline
    6  unexpected     the peer answered what it should not
       unsupported    this build or this arm cannot do it
    7  queue-full     the arm's queue has no room
    8  alarm          an alarm holds the arm's queue
    9  uncertain      a command may or may not have been taken: look at the arm
   10  check-failed   what was checked is not right
  130  interrupted    Ctrl-C";

/// Explain a verb, a command of the protocol, or `exit-status`
#[derive(Args, Debug)]
pub(crate) struct Help {
    /// A verb, a command, a verb and a command (`get PTPJointParams`), or `exit-status`
    words: Vec<String>,
}

impl Help {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let mut description = Cli::description();
        let (first, second) = (self.words.first(), self.words.get(1));
        let Some(first) = first else {
            return show(&description.render_long_help(), context);
        };
        if first == "exit-status" {
            let text = Text::from(EXIT_STATUS.to_owned());
            return context.show(&text, |out| out.line(EXIT_STATUS));
        }
        let verb = description.find_subcommand_mut(first);
        match (verb, second) {
            (Some(_), Some(command)) => catalogue::explain(command, context),
            (Some(verb), None) => show(&verb.render_long_help(), context),
            (None, _) => catalogue::explain(first, context).map_err(|failure| {
                let verbs = description.get_subcommands().map(clap::Command::get_name);
                match verbs
                    .into_iter()
                    .find(|verb| strsim::damerau_levenshtein(verb, first) <= 2)
                {
                    Some(verb) => {
                        Failure::usage(format!("no verb and no command is called `{first}`"))
                            .hint(format!("did you mean {verb}?"))
                    }
                    None => failure,
                }
            }),
        }
    }
}

/// Shows help that clap has styled.
pub(crate) fn show(help: &StyledStr, context: &mut Context) -> Result<(), Failure> {
    context.show(&Text::from(help), |out| out.styled(help))
}
