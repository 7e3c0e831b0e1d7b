//! Keeps the directions between the crates that ARCHITECTURE.md draws.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

/// What each crate depends on among ours, in any section but dev-dependencies: all of it, and nothing else.
const DEPENDENCIES: [(&str, &[&str]); 16] = [
    ("magician-protocol", &[]),
    ("magician-motion", &[]),
    ("magician-sim", &["magician-protocol", "magician-motion"]),
    // The simulator is for its feature `pair`.
    (
        "magician-host",
        &["magician-protocol", "magician-motion", "magician-sim"],
    ),
    (
        "magician-record",
        &["magician-protocol", "magician-motion", "magician-sim"],
    ),
    (
        "magician",
        &[
            "magician-protocol",
            "magician-motion",
            "magician-host",
            "magician-sim",
            "magician-record",
        ],
    ),
    (
        "magician-conform",
        &["magician-protocol", "magician-sim", "magician"],
    ),
    (
        "magician-program",
        &[
            "magician-protocol",
            "magician-motion",
            "magician-host",
            "magician-sim",
        ],
    ),
    (
        "magician-cli",
        &[
            "magician-protocol",
            "magician-motion",
            "magician-sim",
            "magician",
            "magician-conform",
            "magician-program",
            "magician-record",
        ],
    ),
    ("magician-capi", &["magician"]),
    ("magician-capi-v1", &["magician-capi"]),
    ("magician-capi-v2", &["magician-capi"]),
    ("magician-capi-v3", &["magician-capi"]),
    (
        "magician-py",
        &[
            "magician-protocol",
            "magician-sim",
            "magician",
            "magician-program",
        ],
    ),
    // Compares systems with each other.
    (
        "magician-everywhere",
        &[
            "magician-protocol",
            "magician-motion",
            "magician-host",
            "magician-sim",
            "magician-record",
            "magician-program",
        ],
    ),
    // Chores may use anything; what they use is said all the same.
    (
        "xtask",
        &[
            "magician-protocol",
            "magician-motion",
            "magician-sim",
            "magician",
            "magician-program",
            "magician-capi",
        ],
    ),
];

/// The crates of a workspace, and what they depend on among ours.
fn members_of(manifest: &Path, members: &mut BTreeMap<String, BTreeSet<String>>) {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version=1", "--no-deps", "--offline"])
        .arg("--manifest-path")
        .arg(manifest)
        .output()
        .expect("cargo runs");
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let text = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    for package in metadata["packages"].as_array().expect("packages") {
        let dependencies = package["dependencies"].as_array().expect("dependencies");
        let ours = dependencies
            .iter()
            .filter(|dependency| dependency["kind"].as_str() != Some("dev"))
            .map(|dependency| text(&dependency["name"]))
            .filter(|name| name.starts_with("magician") || name == "xtask");
        members.insert(text(&package["name"]), ours.collect());
    }
}

#[test]
fn crates_depend_on_what_is_said_of_them_and_on_nothing_else() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut members = BTreeMap::new();
    members_of(&root.join("Cargo.toml"), &mut members);
    members_of(&root.join("crates/magician-py/Cargo.toml"), &mut members);
    let said = DEPENDENCIES.iter().map(|(name, ours)| {
        let ours = ours.iter().map(|name| (*name).to_owned());
        ((*name).to_owned(), ours.collect())
    });
    let said: BTreeMap<String, BTreeSet<String>> = said.collect();
    assert_eq!(members, said);
}
