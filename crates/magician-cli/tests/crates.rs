//! Keeps the directions between the crates that ARCHITECTURE.md draws.

use std::collections::BTreeMap;
use std::process::Command;

/// What each crate may depend on among ours, in any section but dev-dependencies.
const ALLOWED: [(&str, &[&str]); 12] = [
    ("magician-protocol", &[]),
    ("magician-motion", &[]),
    ("magician-sim", &["magician-protocol", "magician-motion"]),
    (
        "magician",
        &["magician-protocol", "magician-motion", "magician-sim"],
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
            "magician-sim",
            "magician",
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
        ],
    ),
    ("magician-capi", &["magician"]),
    ("magician-capi-v1", &["magician-capi"]),
    ("magician-capi-v2", &["magician-capi"]),
    ("magician-capi-v3", &["magician-capi"]),
    (
        "xtask",
        &["magician-protocol", "magician-motion", "magician-sim"],
    ),
];

fn dependencies_of_members() -> BTreeMap<String, Vec<String>> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version=1", "--no-deps", "--offline"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo runs");
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let text = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    let packages = metadata["packages"].as_array().expect("packages");
    packages
        .iter()
        .map(|package| {
            let dependencies = package["dependencies"].as_array().expect("dependencies");
            let ours = dependencies
                .iter()
                .filter(|dependency| dependency["kind"].as_str() != Some("dev"))
                .map(|dependency| text(&dependency["name"]))
                .filter(|name| name.starts_with("magician"))
                .collect();
            (text(&package["name"]), ours)
        })
        .collect()
}

#[test]
fn crates_depend_only_downwards() {
    let members = dependencies_of_members();
    assert!(
        members.len() >= ALLOWED.len(),
        "only {} members",
        members.len()
    );
    // Chores may use anything.
    for (name, ours) in members.into_iter().filter(|(name, _)| name != "xtask") {
        let Some((_, allowed)) = ALLOWED.iter().find(|(allowed, _)| *allowed == name) else {
            panic!("{name} has no place in ARCHITECTURE.md");
        };
        for dependency in ours {
            assert!(
                allowed.contains(&dependency.as_str()),
                "{name} must not depend on {dependency}"
            );
        }
    }
}
