//! Members and rules of the class.

use std::fmt::Write as _;

/// Stations, each with its arms.
pub(crate) const STATIONS: [&[&str]; 4] = [
    &["a1", "a2", "a3"],
    &["a4", "a5", "a6"],
    &["a7", "a8"],
    &["a9", "a10"],
];

/// Groups with their two arms and their pupils. The pupils are assigned to the two arms
/// alternately.
const GROUPS: [(&str, [&str; 2], [&str; 6]); 5] = [
    (
        "red",
        ["a1", "a2"],
        ["Ada", "Aïcha", "Bảo", "Björn", "Chidi", "Chloé"],
    ),
    (
        "blue",
        ["a3", "a4"],
        ["Dmitri", "Ebru", "Eun-ji", "Fatima", "Finn", "Giulia"],
    ),
    (
        "green",
        ["a5", "a6"],
        ["Hanna", "Ion", "Jiří", "João", "Kaito", "Kwame"],
    ),
    (
        "yellow",
        ["a7", "a8"],
        ["Łukasz", "Mei", "Mihály", "Noa", "Ólafur", "Priya"],
    ),
    (
        "white",
        ["a9", "a10"],
        ["Rūta", "Sefa", "Søren", "Tariq", "Yusuf", "Zoë"],
    ),
];

#[derive(Clone)]
pub(crate) struct Pupil {
    pub(crate) name: &'static str,
    group: &'static str,
    pub(crate) code: String,
    pub(crate) arm: &'static str,
    pub(crate) station: u64,
}

pub(crate) fn pupils() -> Vec<Pupil> {
    let mut all = Vec::new();
    for (group, arms, names) in GROUPS {
        for (at, name) in names.into_iter().enumerate() {
            let code = format!("{}", 2000 + 97 * all.len());
            let arm = arms[at % 2];
            let station = station_of(arm);
            all.push(Pupil {
                name,
                group,
                code,
                arm,
                station,
            });
        }
    }
    all
}

pub(crate) fn station_of(arm: &str) -> u64 {
    let at = STATIONS.iter().position(|arms| arms.contains(&arm));
    at.unwrap() as u64 + 1
}

/// Class file, the same for all stations.
pub(crate) fn file() -> String {
    let mut text = "[class]\nturn_s = 240\ngrace_s = 30\nfinish_job = true\nspeed = 60\n\
                    fence = { floor = -62, box = { x = [150, 300], y = [-150, 150], z = [-62, 160] } }\n\n[groups]\n"
        .to_owned();
    for (group, [one, two], _) in GROUPS {
        writeln!(text, "{group} = [\"{one}\", \"{two}\"]").unwrap();
    }
    for Pupil {
        name, group, code, ..
    } in pupils()
    {
        writeln!(
            text,
            "\n[[pupil]]\nname = \"{name}\"\ngroup = \"{group}\"\ncode = \"{code}\""
        )
        .unwrap();
    }
    text
}

/// Start of the lesson, nine o'clock, Unix seconds. It ends at 9:45.
pub(crate) const LESSON_START: f64 = 1_795_597_200.0;

pub(crate) fn schedule() -> String {
    let names = |names: Vec<&str>| format!("[\"{}\"]", names.join("\", \""));
    let arms = names(STATIONS.concat());
    let who = names(GROUPS.iter().map(|(group, ..)| *group).collect());
    format!(
        "[[slot]]\narms = {arms}\nwho = {who}\nfrom = 2026-11-25T09:00:00Z\nuntil = 2026-11-25T09:45:00Z\n"
    )
}
