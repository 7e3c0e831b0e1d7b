//! List of verbs in groups by purpose.

use std::fmt::Write;

use clap::Command;

/// Headings with their verbs, in the order of the list.
const GROUPS: [(&str, &[&str]); 7] = [
    (
        "Find and inspect",
        &[
            "ports", "info", "pose", "watch", "alarms", "doctor", "sensor", "record",
        ],
    ),
    (
        "Move",
        &[
            "home", "move", "jog", "stop", "suction", "gripper", "laser", "io", "rail", "conveyor",
        ],
    ),
    (
        "Draw, engrave and run",
        &[
            "draw",
            "write",
            "engrave",
            "frame",
            "testgrid",
            "run",
            "convert",
            "calibrate",
            "demo",
        ],
    ),
    ("Teach", &["teach", "play"]),
    (
        "Share and serve",
        &[
            "studio", "serve", "station", "fleet", "site", "sim", "proxy", "shell",
        ],
    ),
    (
        "Protocol",
        &[
            "get", "set", "enqueue", "queue", "commands", "decode", "replay", "conform", "bench",
            "forward", "inverse",
        ],
    ),
    (
        "Settings",
        &["config", "preset", "completions", "man", "help"],
    ),
];

/// Returns the command with its verbs listed in groups.
pub(crate) fn grouped(command: Command) -> Command {
    let template = format!(
        "{{before-help}}{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{}{{all-args}}{{after-help}}",
        listed(&command)
    );
    command
        .override_usage("magician [OPTIONS] [VERB]")
        .mut_subcommands(|verb| verb.hide(true))
        .help_template(template)
}

fn listed(command: &Command) -> String {
    let style = command.get_styles();
    let (header, literal) = (style.get_header(), style.get_literal());
    let mut text = String::new();
    for (heading, verbs) in GROUPS {
        // Writing to a `StyledStr` cannot fail.
        let _ = writeln!(text, "{header}{heading}:{header:#}");
        for name in verbs {
            let verb = command.find_subcommand(name);
            if verb.is_some_and(Command::is_hide_set) {
                continue;
            }
            let about = verb.and_then(Command::get_about).map(ToString::to_string);
            let about = about.unwrap_or_default();
            let _ = writeln!(text, "  {literal}{name:<11}{literal:#} {about}");
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::args::Cli;

    #[test]
    fn every_verb_stands_in_one_group_on_one_line() {
        let description = Cli::description();
        let known: Vec<&str> = description
            .get_subcommands()
            .map(Command::get_name)
            .collect();
        let shown: Vec<&str> = GROUPS
            .iter()
            .flat_map(|(_, verbs)| *verbs)
            .copied()
            .collect();
        let all = |names: &[&str]| {
            names
                .iter()
                .map(|&name| name.to_owned())
                .collect::<BTreeSet<_>>()
        };
        assert_eq!(all(&shown), all(&known));
        assert_eq!(shown.len(), known.len());
        let styles = clap::builder::Styles::plain();
        let text = listed(&description.styles(styles));
        for line in text.lines() {
            assert!(line.chars().count() <= 88, "{line}");
        }
    }
}
