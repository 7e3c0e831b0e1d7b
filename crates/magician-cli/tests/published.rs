//! Requirements of the registry for each published crate, and the compiler that everything needs.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Returns cargo's metadata of a workspace.
fn metadata(manifest: &str, options: &[&str]) -> Value {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version=1", "--offline"])
        .args(options)
        .arg("--manifest-path")
        .arg(root().join(manifest))
        .output()
        .expect("cargo runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// Returns the packages of a workspace.
fn packages(manifest: &str) -> Vec<Value> {
    let metadata = metadata(manifest, &["--no-deps"]);
    metadata["packages"].as_array().expect("packages").clone()
}

fn word<'a>(value: &'a Value, key: &str) -> &'a str {
    value[key].as_str().unwrap_or_default()
}

/// Unpublished crates: parts of the vendor's library (distributed built), programs that compare and
/// measure systems, and maintenance tasks.
const ASIDE: [&str; 8] = [
    "magician-capi",
    "magician-capi-v1",
    "magician-capi-v2",
    "magician-capi-v3",
    "magician-everywhere",
    "magician-sizes",
    "magician-wasm",
    "xtask",
];

/// Returns the published crates.
fn published() -> Vec<Value> {
    let (aside, published): (Vec<_>, Vec<_>) = packages("Cargo.toml")
        .into_iter()
        .partition(|package| package["publish"].is_array());
    let mut aside: Vec<_> = aside.iter().map(|package| word(package, "name")).collect();
    aside.sort_unstable();
    assert_eq!(aside, ASIDE);
    published
}

fn folder(package: &Value) -> PathBuf {
    let manifest = Path::new(word(package, "manifest_path"));
    manifest.parent().expect("its folder").to_owned()
}

/// Returns the requirements that a crate does not meet.
fn lacks(package: &Value) -> Vec<String> {
    let mut lacks = Vec::new();
    let mut want = |what: &str, there: bool| {
        if !there {
            lacks.push(format!("{}: {what}", word(package, "name")));
        }
    };
    let many = |key: &str| package[key].as_array().map_or(0, Vec::len);
    want("description", !word(package, "description").is_empty());
    want(
        "repository",
        word(package, "repository").starts_with("https://"),
    );
    want("license", word(package, "license") == "MIT OR Apache-2.0");
    want("categories", (1..=5).contains(&many("categories")));
    want("keywords", (1..=5).contains(&many("keywords")));
    for keyword in package["keywords"].as_array().into_iter().flatten() {
        let keyword = keyword.as_str().unwrap_or_default();
        let good = |c: char| c.is_ascii_alphanumeric() || "-_+".contains(c);
        let begins = keyword.starts_with(|c: char| c.is_ascii_alphanumeric());
        want(
            keyword,
            begins && keyword.len() <= 20 && keyword.chars().all(good),
        );
    }
    let readme = folder(package).join(word(package, "readme"));
    let readme = fs::read_to_string(readme).unwrap_or_default();
    let title = format!("# {}\n", word(package, "name"));
    want(
        "README.md",
        readme.starts_with(&title) && readme.contains("```"),
    );
    want(
        "a README.md of fewer than 60 lines",
        readme.lines().count() < 60,
    );
    for feature in package["features"].as_object().into_iter().flatten() {
        let (feature, _) = feature;
        let named = readme.contains(&format!("`{feature}`"));
        want(
            &format!("feature {feature} in README.md"),
            named || feature == "default",
        );
    }
    let targets = package["targets"].as_array().into_iter().flatten();
    let documented = |target: &Value| target["kind"][0] == "lib" && target["doc"] == true;
    if targets.into_iter().any(documented) {
        let docs = &package["metadata"]["docs"]["rs"];
        let shown = docs["all-features"] == true || docs["features"].is_array();
        want("features shown by docs.rs", shown);
        want("docs.rs' cfg", docs["rustdoc-args"][1] == "docsrs");
    }
    lacks
}

#[test]
fn each_crate_meets_the_requirements_of_the_registry() {
    let lacks: Vec<_> = published().iter().flat_map(lacks).collect();
    assert!(lacks.is_empty(), "{lacks:#?}");
}

/// Resolves `..` in a path without accessing the disk.
fn plain(path: &Path) -> PathBuf {
    path.components().fold(PathBuf::new(), |mut plain, part| {
        match part.as_os_str().to_str() {
            Some("..") => drop(plain.pop()),
            _ => plain.push(part),
        }
        plain
    })
}

/// Collects files that sources include at compile time but that are missing from the package.
fn missed(folder: &Path, within: &Path, left_out: &[PathBuf], all: &mut Vec<String>) {
    for entry in fs::read_dir(within).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            missed(folder, &path, left_out, all);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            let source = fs::read_to_string(&path).expect("a source");
            for macro_name in ["include_str!(", "include_bytes!(", "include!("] {
                for part in source.split(macro_name).skip(1) {
                    let Some(file) = part.trim_start().strip_prefix('"') else {
                        continue;
                    };
                    let file = file.split('"').next().unwrap_or_default();
                    let file = plain(&within.join(file));
                    let inside = file.starts_with(folder);
                    if !inside || left_out.iter().any(|out| file.starts_with(out)) {
                        all.push(format!("{}: {}", path.display(), file.display()));
                    }
                }
            }
        }
    }
}

#[test]
fn included_files_are_part_of_their_package() {
    let mut all = Vec::new();
    for package in published() {
        let folder = folder(&package);
        let manifest = fs::read_to_string(folder.join("Cargo.toml")).expect("its manifest");
        let listed = |key: &str| -> Vec<PathBuf> {
            let line = manifest.lines().find(|line| line.starts_with(key));
            let parts = line.unwrap_or_default().split('"');
            let parts = parts.filter_map(|part| part.strip_prefix('/'));
            parts.map(|part| folder.join(part)).collect()
        };
        let included = listed("include = ");
        let mut left_out = listed("exclude = ");
        if !included.is_empty() {
            let entries = fs::read_dir(&folder).expect("its folder").flatten();
            let entries = entries.map(|entry| entry.path());
            left_out.extend(entries.filter(|path| !included.contains(path)));
        }
        assert!(
            !left_out.is_empty(),
            "{}: tests stay here",
            folder.display()
        );
        for part in ["src", "examples"] {
            let part = folder.join(part);
            if !left_out.contains(&part) {
                missed(&folder, &part, &left_out, &mut all);
            }
        }
    }
    assert!(all.is_empty(), "{all:#?}");
}

fn numbers(version: &str) -> Vec<u32> {
    let mut numbers: Vec<u32> = version.split('.').flat_map(str::parse).collect();
    numbers.resize(3, 0);
    numbers
}

/// Crates that may need a newer compiler than the libraries: the command, and the package that
/// includes it.
const COMMAND: [&str; 2] = ["magician-cli", "magician-py"];

#[test]
fn no_dependency_needs_a_newer_compiler_than_the_workspace() {
    let output = Command::new("rustc").arg("-vV").output().expect("rustc");
    let told = String::from_utf8(output.stdout).expect("text");
    let host = told.lines().find_map(|line| line.strip_prefix("host: "));
    let host = host.expect("its host");
    let all = metadata("Cargo.toml", &["--locked", "--filter-platform", host]);
    let all = all["packages"].as_array().expect("packages");
    let of = |name: &str| {
        let package = all.iter().find(|package| word(package, "name") == name);
        word(package.expect("ours"), "rust_version").to_owned()
    };
    // The command's line editor needs a newer compiler than it declares; the libraries do not use
    // it.
    let (said, command) = (of("magician-protocol"), of(COMMAND[0]));
    let wants = |package: &Value| match word(package, "name") {
        name if COMMAND.contains(&name) => command.clone(),
        _ => said.clone(),
    };
    let newer: Vec<_> = all
        .iter()
        .filter(|package| numbers(word(package, "rust_version")) > numbers(&wants(package)))
        .map(|package| {
            format!(
                "{} {}",
                word(package, "name"),
                word(package, "rust_version")
            )
        })
        .collect();
    assert!(newer.is_empty(), "{said}: {newer:?}");
    for manifest in [
        "Cargo.toml",
        "crates/magician-py/Cargo.toml",
        "fuzz/Cargo.toml",
    ] {
        for package in packages(manifest) {
            assert_eq!(
                word(&package, "rust_version"),
                wants(&package),
                "{}",
                word(&package, "name")
            );
        }
    }
    for (page, said) in [
        ("README.md", &command),
        ("crates/magician-py/README.md", &command),
        ("docs/guide/PYTHON.md", &command),
        ("docs/guide/START.md", &command),
    ] {
        let text = fs::read_to_string(root().join(page)).expect("the page");
        assert!(text.contains(&format!("{said} or newer")), "{page}");
    }
}
