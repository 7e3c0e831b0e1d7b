//! The function table is complete and consistent.

use std::collections::{BTreeMap, BTreeSet};

use magician::protocol::Row;
use magician_capi::{FUNCTIONS, Family, Function, Ids, Kind};

const FAMILIES: [Family; 3] = [Family::V1, Family::V2, Family::V3];
/// Functions added by this library, and those that wrappers name although no library has them.
const OURS: [&str; 3] = ["MagicianAllow", "MagicianLastError", "PeriodicTask"];
/// Functions of the first family that the second one lacks: 141 against 130.
const NOT_IN_V2: [&str; 11] = [
    "GetARCCommonParams",
    "GetCPCommonParams",
    "GetCPRHoldEnable",
    "GetUART4PeripheralsEnable",
    "GetUART4PeripheralsType",
    "SendPluse",
    "SendPluseEx",
    "SetARCCommonParams",
    "SetCPCommonParams",
    "SetCPRHoldEnable",
    "SetUART4PeripheralsEnable",
];

/// Lines of a facts file.
fn facts(text: &'static str) -> impl Iterator<Item = (&'static str, &'static str)> {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines.filter_map(|line| line.split_once(": "))
}

/// Names of the functions with this mark.
fn marked(mark: &str) -> BTreeSet<&'static str> {
    facts(include_str!("table/names.txt"))
        .filter(|(_, marks)| marks.split(' ').any(|found| found == mark))
        .map(|(name, _)| name)
        .collect()
}

/// Frames sent by functions: function, variant, and id with Ctrl.
fn frames() -> Vec<(&'static str, &'static str, [u8; 2])> {
    facts(include_str!("line/golden.txt"))
        .map(|(name, frame)| {
            let families = ["v1 ", "v2 ", "v3 "];
            let family = families.iter().find_map(|family| name.strip_prefix(family));
            let name = family.unwrap_or(name);
            let (function, variant) = name.split_once(' ').unwrap_or((name, ""));
            let bytes = frame.split(' ').skip(3).take(2);
            let bytes: Vec<u8> = bytes
                .map(|b| u8::from_str_radix(b, 16).expect("hexadecimal"))
                .collect();
            (function, variant, [bytes[0], bytes[1]])
        })
        .collect()
}

fn functions_of(family: Family) -> impl Iterator<Item = &'static Function> {
    FUNCTIONS
        .iter()
        .filter(move |function| function.families.contains(&family))
}

fn names(family: Family) -> BTreeSet<&'static str> {
    functions_of(family).map(|function| function.name).collect()
}

#[test]
fn names_are_unique_in_a_family() {
    for family in FAMILIES {
        assert_eq!(
            functions_of(family).count(),
            names(family).len(),
            "{family:?}"
        );
    }
}

#[test]
fn each_family_has_the_vendors_functions() {
    let mut first = marked("linux-1");
    assert_eq!(first.len(), 141);
    let mut second: BTreeSet<&str> = &first - &NOT_IN_V2.into();
    assert_eq!(second.len(), 130);
    assert!(marked("python-2").is_subset(&second));
    let mut third = marked("windows-3");
    assert_eq!(third.len(), 169);
    third.extend(marked("python-3"));

    first.extend(marked("header-0"));
    first.extend(marked("header-1"));
    second.extend(marked("header-2"));
    for (family, mut expected) in FAMILIES.into_iter().zip([first, second, third]) {
        expected.extend(OURS);
        assert_eq!(names(family), expected, "{family:?}");
    }
}

#[test]
fn functions_are_grouped_by_chapter() {
    let mut last = None;
    let mut seen = BTreeSet::new();
    let ids: BTreeMap<&str, u8> = frames()
        .into_iter()
        .map(|(name, _, [id, _])| (name, id))
        .collect();
    for id in FUNCTIONS
        .iter()
        .filter_map(|function| ids.get(function.name))
    {
        // Ids of one chapter of the protocol differ only in their last decimal digit.
        let chapter = id / 10;
        assert!(
            last == Some(chapter) || seen.insert(chapter),
            "{id} is apart from its chapter"
        );
        last = Some(chapter);
    }
}

#[test]
fn guarded_functions_are_the_dangerous_commands() {
    for (name, _, [id, ctrl]) in frames() {
        let row = Row::with_id(id).expect("a row");
        // A command without a value has an effect even if Ctrl says read.
        let writes = ctrl & 1 == 1 || row.value.is_none();
        let guarded = FUNCTIONS.iter().filter(|function| function.name == name);
        for function in guarded {
            assert_eq!(
                function.kind == Kind::Guarded,
                row.dangerous && writes,
                "{name}"
            );
        }
    }
}

#[test]
fn functions_queue_as_in_the_vendors_library() {
    let forced = marked("queued");
    let mut variants: BTreeMap<&str, BTreeSet<(&str, u8)>> = BTreeMap::new();
    for (name, variant, [_, ctrl]) in frames() {
        variants.entry(name).or_default().insert((variant, ctrl));
    }
    for function in FUNCTIONS
        .iter()
        .filter(|function| function.kind == Kind::Command)
    {
        let has_queued_argument = function.arguments.iter().any(|(name, _)| *name == "queued");
        let variants = &variants[function.name];
        match function.name {
            name if forced.contains(name) => {
                assert!(variants.iter().all(|(_, ctrl)| *ctrl == 3), "{name}")
            }
            // Ignores its argument `queued`, because older headers lack that argument.
            "SetLostStepParams" => {}
            name if has_queued_argument => assert!(
                variants.is_superset(&BTreeSet::from([("at once", 1), ("queued", 3)])),
                "{name}"
            ),
            name => assert!(variants.iter().any(|(_, ctrl)| *ctrl < 2), "{name}"),
        }
    }
}

#[test]
fn functions_with_is_queued_have_an_index_pointer() {
    for Function {
        name, arguments, ..
    } in FUNCTIONS
    {
        if arguments.contains(&("queued", "Bool")) {
            let (last, kind) = arguments.last().expect("arguments");
            assert_eq!(
                (*last, &*kind.replace(' ', "")),
                ("index", "Out<u64>"),
                "{name}"
            );
        }
    }
}

#[test]
fn only_functions_without_an_arm_have_no_ids() {
    for Function {
        name, kind, ids, ..
    } in FUNCTIONS
    {
        assert!(*ids != Ids::None || *kind == Kind::Host, "{name}");
    }
}

/// The log names the function that did nothing.
#[test]
fn neutral_functions_log_their_own_names() {
    let source = include_str!("../src/functions.rs");
    let rows = source.split("    Neutral Arm ").skip(1);
    let mut count = 0;
    for row in rows {
        let (name, rest) = row.split_once('(').expect("arguments");
        let (body, _) = rest.split_once(';').expect("an end");
        assert!(body.contains(&format!("neutral(\"{name}\"")), "{name}");
        count += 1;
    }
    let neutral = FUNCTIONS
        .iter()
        .filter(|function| function.kind == Kind::Neutral);
    assert_eq!(count, neutral.count());
}
