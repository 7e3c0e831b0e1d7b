//! Checks the dependencies between crates against the description in `ARCHITECTURE.md`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

/// Direct dependencies of each crate on ours, outside of dev-dependencies. Must be complete.
const DEPENDENCIES: &[(&str, &[&str])] = &[
    ("magician-protocol", &[]),
    ("magician-motion", &[]),
    // Commands as motions, which needs both.
    ("magician-model", &["magician-protocol", "magician-motion"]),
    (
        "magician-sim",
        &["magician-protocol", "magician-motion", "magician-model"],
    ),
    // The simulator is for its feature `pair`.
    (
        "magician-host",
        &[
            "magician-protocol",
            "magician-motion",
            "magician-model",
            "magician-sim",
        ],
    ),
    (
        "magician-record",
        &[
            "magician-protocol",
            "magician-motion",
            "magician-model",
            "magician-sim",
        ],
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
        "magician-formats",
        &["magician-protocol", "magician-motion", "magician-host"],
    ),
    (
        "magician-program",
        &[
            "magician-protocol",
            "magician-motion",
            "magician-host",
            "magician-formats",
            "magician-sim",
        ],
    ),
    (
        "magician-picture",
        &[
            "magician-protocol",
            "magician-motion",
            "magician-host",
            "magician-sim",
            // Behind a feature.
            "magician-formats",
            "magician-program",
        ],
    ),
    (
        "magician-job",
        &[
            "magician-protocol",
            "magician",
            "magician-program",
            "magician-record",
        ],
    ),
    ("magician-measure", &["magician-protocol", "magician"]),
    ("magician-link", &["magician-protocol"]),
    (
        "magician-station",
        &[
            "magician-protocol",
            "magician-motion",
            "magician",
            "magician-program",
            "magician-picture",
            "magician-job",
            "magician-record",
            "magician-link",
        ],
    ),
    (
        "magician-site",
        &["magician-protocol", "magician", "magician-station"],
    ),
    // Files only.
    ("magician-studio", &[]),
    (
        "magician-cli",
        &[
            "magician-protocol",
            "magician-motion",
            "magician-sim",
            "magician",
            "magician-conform",
            "magician-measure",
            "magician-program",
            "magician-picture",
            "magician-job",
            "magician-record",
            "magician-station",
            "magician-studio",
            // Behind a feature.
            "magician-site",
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
            "magician-motion",
            "magician-sim",
            "magician",
            "magician-program",
            "magician-picture",
            "magician-job",
            "magician-record",
            "magician-station",
            "magician-conform",
            "magician-measure",
            // Includes the command through its one function.
            "magician-cli",
        ],
    ),
    (
        "magician-wasm",
        &[
            // Selects the readers.
            "magician-formats",
            "magician",
            "magician-program",
            "magician-job",
            "magician-station",
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
            "magician-picture",
        ],
    ),
    // Measures sizes.
    (
        "magician-sizes",
        &[
            "magician-protocol",
            "magician-host",
            "magician-sim",
            "magician",
            "magician-formats",
            "magician-program",
            "magician-picture",
        ],
    ),
    // Maintenance tasks may use anything, but their dependencies are listed too.
    (
        "xtask",
        &[
            "magician-protocol",
            "magician-motion",
            "magician-sim",
            "magician",
            "magician-conform",
            "magician-program",
            "magician-picture",
            "magician-capi",
            "magician-station",
        ],
    ),
];

/// Returns the dependencies on our crates of each crate in both workspaces, without those of tests.
fn members() -> BTreeMap<String, BTreeSet<String>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut members = BTreeMap::new();
    for manifest in ["Cargo.toml", "crates/magician-py/Cargo.toml"] {
        let output = Command::new(env!("CARGO"))
            .args(["metadata", "--format-version=1", "--no-deps", "--offline"])
            .arg("--manifest-path")
            .arg(root.join(manifest))
            .output()
            .expect("cargo runs");
        let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let text = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
        let list = |value: &serde_json::Value| value.as_array().expect("a list").clone();
        for package in list(&metadata["packages"]) {
            let mut ours = BTreeSet::new();
            for dependency in list(&package["dependencies"]) {
                let name = text(&dependency["name"]);
                let is_ours = name.starts_with("magician") || name == "xtask";
                if is_ours && dependency["kind"].as_str() != Some("dev") {
                    ours.insert(name);
                }
            }
            members.insert(text(&package["name"]), ours);
        }
    }
    members
}

#[test]
fn crate_dependencies_match_the_list() {
    let said = DEPENDENCIES.iter().map(|(name, ours)| {
        let ours = ours.iter().map(|name| (*name).to_owned());
        ((*name).to_owned(), ours.collect())
    });
    let said: BTreeMap<String, BTreeSet<String>> = said.collect();
    assert_eq!(members(), said);
}

/// Returns all crates that a crate is built with, for these features alone, including indirect
/// dependencies.
fn built_with(package: &str, features: &str) -> BTreeSet<String> {
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--offline", "--no-default-features"])
        .args(["--edges", "normal,no-proc-macro", "--prefix", "none"])
        .args(["--format", "{p}"])
        .args(["--package", package, "--features", features])
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."))
        .output()
        .expect("cargo runs");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let tree = String::from_utf8(output.stdout).expect("text");
    let names = tree.lines().filter_map(|line| line.split(' ').next());
    names.map(str::to_owned).collect()
}

/// Crates that only features of `magician-formats` bring in, with these features.
const BROUGHT_IN: [(&str, &[&str]); 9] = [
    (
        "crc32fast",
        &["drawings", "font-files", "images", "programs"],
    ),
    ("encoding_rs", &["drawings", "programs"]),
    ("flate2", &["drawings", "font-files", "images"]),
    ("fontdb", &["drawings"]),
    ("image", &["images"]),
    ("png", &["images"]),
    ("roxmltree", &["drawings", "font-files", "programs"]),
    ("skrifa", &["drawings", "font-files"]),
    ("usvg", &["drawings"]),
];

/// Crates that a plan never needs: the driver and its lines, a network, a runtime.
const NEVER: [&str; 4] = ["magician", "serial2", "socket2", "tokio"];

#[test]
fn each_reader_adds_only_its_own_dependencies() {
    let features = [
        "",
        "drawings",
        "font-files",
        "images",
        "lettering",
        "programs",
    ];
    for feature in features {
        let built = built_with("magician-formats", feature);
        assert!(built.contains("magician-host"), "{built:?}");
        let found = BROUGHT_IN.iter().map(|(name, _)| *name);
        let found: BTreeSet<_> = found.filter(|name| built.contains(*name)).collect();
        let said = BROUGHT_IN.iter().filter(|(_, by)| by.contains(&feature));
        let said: BTreeSet<_> = said.map(|(name, _)| *name).collect();
        assert_eq!(found, said, "{feature}");
        for name in NEVER.into_iter().chain(["magician-sim"]) {
            assert!(!built.contains(name), "{feature}: {name}");
        }
    }
}

#[test]
fn plans_alone_need_no_reader_no_picture_and_no_line() {
    for feature in ["", "readers"] {
        let built = built_with("magician-program", feature);
        assert!(built.contains("magician-sim"), "{built:?}");
        for (name, _) in BROUGHT_IN {
            // Without features there is no reader.
            assert!(!feature.is_empty() || !built.contains(name), "{name}");
        }
        for name in NEVER.into_iter().chain(["magician-picture", "resvg"]) {
            assert!(!built.contains(name), "{feature}: {name}");
        }
    }
}

#[test]
fn pictures_as_text_need_no_pixels_and_no_font() {
    const PIXELS: [&str; 4] = ["png", "resvg", "skrifa", "usvg"];
    for (feature, there) in [("", false), ("png", true)] {
        let built = built_with("magician-picture", feature);
        for name in PIXELS {
            assert_eq!(built.contains(name), there, "{feature}: {name}");
        }
        assert!(!built.contains("magician"), "{feature}");
    }
}
