//! Flags of `draw` and `engrave`, and keys of `setup`: the same options, with the same meaning.

use std::collections::BTreeSet;

use clap::{Args, Command, FromArgMatches};
use magician_program::SetupOptions;
use serde_json::{Value, json};

use crate::verbs::draw::Draw;
use crate::verbs::engrave::Verb as Engrave;
use crate::verbs::frame::Frame;
use crate::verbs::preset::Save;
use crate::verbs::write::Write;

/// Flags that change nothing of what is made: how it is looked at, and how the job goes.
const NOT_OF_A_SETUP: [&str; 21] = [
    "preset",
    "repeat",
    "format",
    "check",
    "estimate",
    "preview",
    "dry-run",
    "list-parts",
    "loops",
    "from",
    "resume",
    "overlap",
    "record",
    "rate",
    "units",
    "picture",
    "whole",
    "keep",
    "require-homed",
    "unhomed",
    "tui",
];

fn draw() -> Command {
    Draw::augment_args(Command::new("draw"))
}

fn engrave() -> Command {
    Engrave::augment_args(Command::new("engrave"))
}

#[test]
fn text_is_written_with_the_flags_of_draw() {
    const OF_A_FILE: [&str; 18] = [
        "format",
        "dialect",
        "s-max",
        "white",
        "resample",
        "text",
        // Of an image.
        "image",
        "threshold",
        "levels",
        "despeckle",
        "pen-width",
        "crop",
        "brightness",
        "contrast",
        "gamma",
        "invert",
        "spacing",
        "system-fonts",
    ];
    let write = flags(&Write::augment_args(Command::new("write")));
    let mut drawn = flags(&draw());
    drawn.retain(|flag| !OF_A_FILE.contains(&flag.as_str()));
    drawn.insert("fonts".to_owned());
    assert_eq!(write, drawn);
}

#[test]
fn a_frame_takes_the_flags_of_draw_and_engrave() {
    let mut of_frame = flags(&Frame::augment_args(Command::new("frame")));
    assert!(of_frame.remove("shape"));
    of_frame.insert("frame".to_owned());
    assert_eq!(of_frame, &flags(&draw()) | &flags(&engrave()));
}

#[test]
fn a_preset_is_saved_with_every_flag_that_changes_what_is_made() {
    let mut saved = flags(&Save::augment_args(Command::new("save")));
    assert!(saved.remove("note"));
    let mut made = &flags(&draw()) | &flags(&engrave());
    made.retain(|flag| !NOT_OF_A_SETUP.contains(&flag.as_str()) && !flag.starts_with("frame"));
    assert_eq!(saved, made);
}

fn flags(command: &Command) -> BTreeSet<String> {
    let flags = command.get_arguments().filter_map(clap::Arg::get_long);
    flags.map(str::to_owned).collect()
}

/// The key of a flag: `--no-X` is X, but for the one that is no switch of something.
fn key(flag: &str) -> String {
    if flag == "no-pause" {
        return "no_pause".to_owned();
    }
    flag.strip_prefix("no-").unwrap_or(flag).replace('-', "_")
}

/// A value for each key, and what it needs beside it.
fn examples() -> Vec<(Value, Value)> {
    [
        (json!({"dialect": "servo"}), json!({})),
        (json!({"s_max": 255.0}), json!({})),
        (json!({"white": "draw"}), json!({})),
        (json!({"resample": 0.5}), json!({})),
        (json!({"power": 80.0}), json!({})),
        (json!({"power": "5..80"}), json!({})),
        (json!({"tool": "pen"}), json!({})),
        (json!({"tool": [10.0, 0.5, -5.5]}), json!({})),
        (json!({"surface": -58.5}), json!({})),
        (json!({"start": [200.0, 0.0, 50.0]}), json!({})),
        (json!({"place": true}), json!({})),
        (json!({"raw": true}), json!({})),
        (json!({"pen_z": -1.5}), json!({})),
        (json!({"depths": "keep"}), json!({})),
        (json!({"at": [230.0, -10.0]}), json!({})),
        (json!({"page": "a4-landscape"}), json!({})),
        (json!({"page": "200x150.5"}), json!({})),
        (json!({"margin": 5.0}), json!({"page": "a5"})),
        (json!({"scale": 0.5}), json!({})),
        (json!({"rotate": -30.0}), json!({})),
        (json!({"fit": true}), json!({})),
        (json!({"turn": false}), json!({})),
        (json!({"clip_page": true}), json!({})),
        (json!({"mirror": true}), json!({})),
        (json!({"move": [1.0, -2.0, 3.0]}), json!({})),
        (json!({"grid": "2x3:40x-30.5"}), json!({})),
        (json!({"speed": 20.0}), json!({})),
        (json!({"speed_ratio": 80.0}), json!({})),
        (json!({"stay": true}), json!({})),
        (json!({"park": [150.0, 0.0, 40.0]}), json!({})),
        (json!({"lift": 4.0}), json!({})),
        (json!({"hop": 1.5}), json!({})),
        (json!({"travel_speed": 90.0}), json!({})),
        (json!({"order": false}), json!({})),
        (json!({"tolerance": 0.2}), json!({})),
        (json!({"threshold": 100}), json!({})),
        (json!({"width": 60.0}), json!({})),
        (json!({"height": 40.0}), json!({})),
        (json!({"mode": "dither"}), json!({})),
        (json!({"invert": true}), json!({})),
        (json!({"image": "hatch"}), json!({})),
        (json!({"levels": 4}), json!({"image": "halftone"})),
        (json!({"despeckle": 0.5}), json!({})),
        (json!({"pen_width": 0.4}), json!({})),
        (json!({"crop": [10, 20, 300, 200]}), json!({})),
        (json!({"brightness": -20.5}), json!({})),
        (json!({"contrast": 30.0}), json!({})),
        (json!({"spacing": 0.25}), json!({})),
        (json!({"one_way": true}), json!({})),
        (json!({"overscan": 3.0}), json!({})),
        (json!({"gamma": 1.5}), json!({})),
        (json!({"merge": 0.5}), json!({})),
        (json!({"dedupe": false}), json!({})),
        (json!({"dedupe": true}), json!({})),
        (json!({"simplify": 0.0}), json!({})),
        (json!({"fill": "hatch"}), json!({})),
        (json!({"fill_spacing": 0.5}), json!({"fill": "hatch"})),
        (json!({"fill_angle": 30.0}), json!({"fill": "hatch"})),
        (json!({"fill_inset": 0.1}), json!({"fill": "hatch"})),
        (json!({"font": "script"}), json!({})),
        (json!({"size": 12.0}), json!({})),
        (json!({"wrap": 150.0}), json!({})),
        (json!({"align": "center"}), json!({})),
        (json!({"line_height": 2.0}), json!({})),
        (json!({"text": "stroke"}), json!({})),
        (json!({"system_fonts": "off"}), json!({})),
        (json!({"strict_text": true}), json!({})),
        (json!({"parts": "color"}), json!({})),
        (json!({"only": ["red", "2"]}), json!({})),
        (json!({"passes": 3}), json!({})),
        (json!({"no_pause": true}), json!({})),
        (json!({"pens": [{"match": "red", "lift": 4.0, "fill": "hatch"}, {"match": 2, "passes": 2}]}), json!({})),
        (json!({"frame": "hull"}), json!({})),
        (json!({"frame_power": 2.0}), json!({"frame": "box"})),
    ]
    .into()
}

/// Members as flags.
fn arguments(members: &Value) -> Vec<String> {
    let members = members.as_object().unwrap();
    let flag = |(key, value): (&String, &Value)| {
        let flag = key.replace('_', "-");
        vec![match value {
            Value::Bool(true) => format!("--{flag}"),
            Value::Bool(false) => format!("--no-{flag}"),
            Value::String(text) => format!("--{flag}={text}"),
            Value::Array(_) if flag == "pens" => {
                let path = std::env::temp_dir().join(format!("pens-{}.toml", std::process::id()));
                let pens = toml::to_string(&json!({ "pen": value })).unwrap();
                std::fs::write(&path, pens).unwrap();
                format!("--pens={}", path.display())
            }
            Value::Array(items) if flag == "only" => {
                let items = items.iter().filter_map(Value::as_str);
                return items.map(|item| format!("--only={item}")).collect();
            }
            Value::Array(items) => {
                let items: Vec<_> = items.iter().map(ToString::to_string).collect();
                format!("--{flag}={}", items.join(","))
            }
            number => format!("--{flag}={number}"),
        }]
    };
    members.iter().flat_map(flag).collect()
}

fn said_to_draw(arguments: &[String]) -> SetupOptions {
    let line = ["draw", "file"].map(str::to_owned);
    let matches = draw().get_matches_from([&line, arguments].concat());
    Draw::from_arg_matches(&matches).unwrap().job().options
}

fn said_to_engrave(arguments: &[String]) -> SetupOptions {
    let line = ["engrave", "file"].map(str::to_owned);
    let matches = engrave().get_matches_from([&line, arguments].concat());
    Engrave::from_arg_matches(&matches).unwrap().job().options
}

#[test]
fn every_flag_that_changes_what_is_made_is_a_key_and_every_key_a_flag() {
    let flags = &flags(&draw()) | &flags(&engrave());
    for flag in NOT_OF_A_SETUP {
        assert!(flags.contains(flag), "--{flag} is no flag any more");
    }
    let of_flags = flags
        .iter()
        .filter(|flag| !NOT_OF_A_SETUP.contains(&flag.as_str()));
    let of_flags: BTreeSet<_> = of_flags.map(|flag| key(flag)).collect();
    let mut keys: BTreeSet<_> = SetupOptions::keys().into_iter().collect();
    // Which verb it is.
    assert!(keys.remove("work"));
    assert_eq!(of_flags, keys);
    let examples = examples();
    let tried = examples
        .iter()
        .filter_map(|(members, _)| members.as_object()?.keys().next().cloned());
    let tried: BTreeSet<_> = tried.collect();
    assert_eq!(tried, keys, "each is tried below");
}

#[test]
fn a_flag_and_a_key_say_the_same() {
    let (draws, engraves) = (flags(&draw()), flags(&engrave()));
    for (members, beside) in examples() {
        let mut members = members;
        for (name, value) in beside.as_object().unwrap() {
            members[name] = value.clone();
        }
        let arguments = arguments(&members);
        let has = |flags: &BTreeSet<String>| {
            let known = |argument: &String| {
                let flag = argument.trim_start_matches("--");
                flags.contains(flag.split('=').next().unwrap())
            };
            arguments.iter().all(known)
        };
        let mut tried = 0;
        for (known, said) in [
            (&draws, said_to_draw as fn(&[String]) -> SetupOptions),
            (&engraves, said_to_engrave),
        ] {
            if !has(known) {
                continue;
            }
            tried += 1;
            let mut expected = serde_json::to_value(said(&[])).unwrap();
            for (name, value) in members.as_object().unwrap() {
                expected[name] = value.clone();
            }
            let given = said(&arguments);
            assert_eq!(serde_json::to_value(&given).unwrap(), expected);
            let of_keys = SetupOptions::from_fields(members.as_object().unwrap()).unwrap();
            for name in members.as_object().unwrap().keys() {
                let (given, of_keys) =
                    (serde_json::to_value(&given), serde_json::to_value(&of_keys));
                assert_eq!(given.unwrap()[name], of_keys.unwrap()[name], "{name}");
            }
        }
        assert!(tried > 0, "{members}");
    }
}
