//! Policies of every verb, and the effects of each policy.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use super::*;
use crate::args::COMMAND_LINE;

/// Each verb with its files below `verbs` and all policies that they choose. `run_with_own_line`
/// and `run_without_arm` mark verbs that do not use the context's arm, or not for everything.
const VERBS: &[(&str, &[&str], &[&str])] = &[
    ("ports", &["ports.rs"], &[]),
    ("info", &["info.rs"], &["StopPolicy::Look"]),
    ("pose", &["pose.rs"], &["StopPolicy::Look"]),
    ("home", &["home.rs"], &["StopPolicy::Move"]),
    (
        "move",
        &["travel.rs"],
        &["StopPolicy::HandOver", "StopPolicy::Move"],
    ),
    ("jog", &["jog"], &["StopPolicy::Move", "StopPolicy::Pad"]),
    ("record", &["record.rs"], &["SignalPolicy::Record"]),
    (
        "calibrate",
        &["calibrate"],
        &["StopPolicy::Look", "StopPolicy::Order", "StopPolicy::Pad"],
    ),
    ("teach", &["teach"], &["StopPolicy::Pad"]),
    ("run", &["run.rs", "job"], JOB),
    ("draw", &["draw.rs", "job"], JOB),
    ("write", &["write.rs", "job"], JOB),
    ("engrave", &["engrave.rs", "job"], JOB),
    ("frame", &["frame.rs", "job"], JOB),
    ("testgrid", &["testgrid.rs", "job"], JOB),
    ("play", &["play.rs", "job"], JOB),
    ("convert", &["convert.rs"], &[]),
    (
        "watch",
        &["watch"],
        &["StopPolicy::Watch", "SignalPolicy::Record"],
    ),
    (
        "stop",
        &["stop.rs"],
        &[
            "StopPolicy::Hold",
            "StopPolicy::Look",
            "StopPolicy::Stop",
            "run_without_arm",
        ],
    ),
    ("suction", &["tools.rs"], &["StopPolicy::Order"]),
    ("gripper", &["tools.rs"], &["StopPolicy::Order"]),
    (
        "laser",
        &["laser.rs"],
        &[
            "StopPolicy::Darken",
            "StopPolicy::Light",
            "SignalPolicy::Burn",
        ],
    ),
    (
        "io",
        &["io.rs"],
        &["StopPolicy::lights", "StopPolicy::order_if"],
    ),
    ("sensor", &["sensor.rs"], &["StopPolicy::Order"]),
    (
        "rail",
        &["rail.rs"],
        &["StopPolicy::Look", "StopPolicy::Move", "StopPolicy::Order"],
    ),
    (
        "conveyor",
        &["conveyor.rs"],
        &["StopPolicy::Move", "StopPolicy::Order"],
    ),
    ("alarms", &["alarms.rs"], &["StopPolicy::order_if"]),
    (
        "queue",
        &["queue.rs"],
        &[
            "StopPolicy::HandOver",
            "StopPolicy::Look",
            "StopPolicy::Order",
        ],
    ),
    ("get", &["get.rs"], &["StopPolicy::Look"]),
    (
        "set",
        &["set.rs"],
        &["StopPolicy::Order", "StopPolicy::lights"],
    ),
    ("enqueue", &["enqueue.rs"], &["StopPolicy::Order"]),
    ("shell", &["shell"], &["run_without_arm"]),
    ("demo", &["demo"], &["StopPolicy::Move"]),
    ("sim", &["sim"], &["run_without_arm"]),
    ("proxy", &["proxy"], &["run_without_arm"]),
    ("serve", &["serve"], &["run_without_arm"]),
    ("studio", &["serve/studio.rs"], &[]),
    ("station", &["station.rs", "class.rs"], &["run_without_arm"]),
    (
        "fleet",
        &["fleet", "class.rs"],
        &["run_without_arm", "run_with_own_line"],
    ),
    ("site", &["site"], &["run_without_arm", "run_with_own_line"]),
    (
        "conform",
        &["conform"],
        &["run_without_arm", "run_with_own_line"],
    ),
    (
        "doctor",
        &["doctor"],
        &["StopPolicy::Look", "run_without_arm", "run_with_own_line"],
    ),
    (
        "bench",
        &["bench"],
        &["StopPolicy::Move", "StopPolicy::Order", "run_with_own_line"],
    ),
    ("commands", &["commands.rs"], &[]),
    ("decode", &["decode"], &[]),
    ("replay", &["replay"], &["run_without_arm"]),
    ("forward", &["forward.rs"], &[]),
    ("inverse", &["inverse.rs"], &[]),
    ("config", &["config.rs"], &[]),
    ("preset", &["preset.rs"], &[]),
    ("completions", &["completions.rs"], &[]),
    ("man", &["man.rs"], &[]),
    ("help", &["help"], &[]),
];

const JOB: &[&str] = &["JobPolicy::Burning", "JobPolicy::Dark", "StopPolicy::Look"];

/// Collects the policies that a file, or all files of a directory, choose.
fn chosen(path: &Path, found: &mut BTreeSet<String>) {
    if path.is_dir() {
        let files = fs::read_dir(path).unwrap();
        files.for_each(|file| chosen(&file.unwrap().path(), found));
        return;
    }
    let text = fs::read_to_string(path).unwrap();
    for policy in ["StopPolicy::", "SignalPolicy::", "JobPolicy::"] {
        for (at, _) in text.match_indices(policy) {
            let rest = &text[at + policy.len()..];
            let end = rest.find(|letter: char| !letter.is_alphanumeric() && letter != '_');
            found.insert(format!("{policy}{}", &rest[..end.unwrap_or(rest.len())]));
        }
    }
    for method in ["run_with_own_line", "run_without_arm"] {
        if text.contains(&format!("context.{method}(")) {
            found.insert(method.to_owned());
        }
    }
}

#[test]
fn each_verb_has_the_policies_of_the_list() {
    let verbs = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src/verbs");
    let listed: BTreeSet<_> = VERBS.iter().map(|(verb, ..)| *verb).collect();
    let all = (COMMAND_LINE.description)();
    let all: BTreeSet<_> = all.get_subcommands().map(clap::Command::get_name).collect();
    assert_eq!(listed, all);
    for (verb, files, policies) in VERBS {
        let mut found = BTreeSet::new();
        files
            .iter()
            .for_each(|file| chosen(&verbs.join(file), &mut found));
        let policies: BTreeSet<_> = policies.iter().map(ToString::to_string).collect();
        assert_eq!(found, policies, "{verb}");
    }
}

/// Returns the effects of rules: true if a signal stops an arm of which the driver knows nothing,
/// during the work and after its success; true if the driver reconnects; how long the laser burns
/// after success.
fn effects(rules: Rules) -> (bool, bool, bool, Option<BurnEnd>) {
    let mut untracked = Untracked::default();
    untracked.begin(&rules);
    let during = untracked.needs_stop();
    untracked.note_success(rules.end);
    (
        during,
        untracked.needs_stop(),
        rules.reconnects,
        untracked.laser,
    )
}

#[test]
fn each_policy_has_its_effects() {
    use StopPolicy::{Darken, HandOver, Hold, Light, Look, Move, Order, Pad, Stop, Watch};
    let connected = Some(BurnEnd::WhileConnected);
    for (rules, expected) in [
        (Look.rules(), (false, false, false, None)),
        (Watch.rules(), (false, false, true, None)),
        (Order.rules(), (false, false, false, None)),
        (HandOver.rules(), (true, true, false, None)),
        (Move.rules(), (true, false, false, None)),
        (Pad.rules(), (true, false, true, None)),
        (
            Light(BurnEnd::WhileConnected).rules(),
            (true, true, false, connected),
        ),
        (
            Light(BurnEnd::UntilSwitchedOff).rules(),
            (true, false, false, Some(BurnEnd::UntilSwitchedOff)),
        ),
        (Darken.rules(), (false, false, false, None)),
        (Stop.rules(), (false, false, false, None)),
        (Hold.rules(), (false, false, false, None)),
        (SignalPolicy::Record.rules(), (false, false, false, None)),
        (SignalPolicy::Burn.rules(), (true, false, true, None)),
        (JobPolicy::Dark.rules(), (true, false, false, None)),
        (JobPolicy::Burning.rules(), (true, false, true, None)),
    ] {
        assert_eq!(effects(rules), expected, "{rules:?}");
    }
}

#[test]
fn work_of_shell_lines_continues_until_a_line_ends_it() {
    let lit = StopPolicy::Light(BurnEnd::WhileConnected);
    for (lines, needs_stop, laser) in [
        (&[StopPolicy::HandOver, StopPolicy::Look][..], true, None),
        (&[StopPolicy::HandOver, StopPolicy::Hold], true, None),
        (&[StopPolicy::HandOver, StopPolicy::Stop], false, None),
        (&[StopPolicy::HandOver, StopPolicy::Move], false, None),
        (&[StopPolicy::HandOver, StopPolicy::Darken], true, None),
        (&[lit, StopPolicy::Darken], false, None),
        (&[lit, StopPolicy::Stop], false, None),
        (
            &[lit, StopPolicy::Move],
            true,
            Some(BurnEnd::WhileConnected),
        ),
        (
            &[StopPolicy::Light(BurnEnd::UntilSwitchedOff), lit],
            true,
            Some(BurnEnd::WhileConnected),
        ),
    ] {
        let mut untracked = Untracked::default();
        for line in lines {
            untracked.begin(&line.rules());
            untracked.note_success(line.rules().end);
        }
        assert_eq!(untracked.needs_stop(), needs_stop, "{lines:?}");
        assert_eq!(untracked.laser, laser, "{lines:?}");
    }
}
