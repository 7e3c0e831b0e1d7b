//! `help`: explains verbs, commands of the protocol, and topics.

mod groups;
mod topics;

use std::fmt::Write;

use clap::Args;

use crate::catalogue;
use crate::context::Context;
use crate::failure::Failure;
use crate::output::Text;
pub(crate) use groups::grouped;
use topics::{TOPICS, Topic};

/// Explain a verb, a command of the protocol, or a topic
#[derive(Args, Debug)]
pub(crate) struct Help {
    /// Name to explain: a verb, a protocol command, a verb and a command (`get PTPJointParams`), or
    /// a topic
    words: Vec<String>,
}

impl Help {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let mut description = (context.command_line.description)();
        let (first, second) = (self.words.first(), self.words.get(1));
        let Some(first) = first else {
            let mut help = grouped(description).render_help();
            // Writing to a `StyledStr` cannot fail.
            let _ = write!(help, "{}", listed());
            return context.show_styled(&help);
        };
        let topic = TOPICS.iter().find(|topic| topic.is(first));
        let verb = description.find_subcommand_mut(first);
        match (verb, second, topic) {
            (Some(_), Some(command), _) => catalogue::explain(command, context),
            (Some(verb), None, _) => {
                let mut help = verb.render_long_help();
                if let Some(topic) = topic {
                    let _ = write!(help, "\n{}\n", topic.text);
                }
                context.show_styled(&help)
            }
            (None, None, Some(topic)) => {
                let text = Text::from(topic.text.to_owned());
                context.show(&text, |out| out.line(topic.text))
            }
            (None, _, _) => catalogue::explain(first, context).map_err(|failure| {
                let verbs = description.get_subcommands().map(clap::Command::get_name);
                let topics = TOPICS.iter().map(|topic| topic.name);
                match nearest(first, verbs.chain(topics)) {
                    Some(name) => {
                        Failure::usage(format!("unknown verb, command or topic `{first}`"))
                            .hint(format!("did you mean {name}?"))
                    }
                    None => failure,
                }
            }),
        }
    }
}

/// Returns the most similar name; `None` if more than a third of its letters differ, because every
/// word of three letters is within two of some verb.
fn nearest<'a>(word: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let distance = |name: &str| strsim::damerau_levenshtein(name, word);
    let near = names.filter(|name| 3 * distance(name) <= name.chars().count());
    near.min_by_key(|name| distance(name))
}

/// Returns the list of topics, which follows the list of verbs.
fn listed() -> String {
    let line = |topic: &Topic| format!("  {:<12} {}\n", topic.name, topic.about);
    let lines: String = TOPICS.iter().map(line).collect();
    format!("\nTopics (`magician help TOPIC`):\n{lines}")
}
