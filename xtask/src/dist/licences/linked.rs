//! Crates and data that a build contains. `cargo tree` is used because it resolves the features of
//! this build alone, while `cargo metadata` merges those of the whole workspace.

use std::collections::BTreeSet;
use std::error::Error;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

use serde_json::Value;

use crate::dist;

/// Build to examine.
pub(crate) struct Build {
    /// Title of its page.
    pub(crate) title: &'static str,
    /// Manifest of its workspace.
    pub(crate) manifest: PathBuf,
    pub(crate) packages: Vec<String>,
    /// Features as `package/feature`.
    pub(crate) features: Vec<String>,
    /// Target triple; `None` for every platform.
    pub(crate) target: Option<String>,
}

/// Contents of a build.
pub(super) struct Linked {
    /// Crates whose code is linked, by name.
    pub(super) crates: Vec<Package>,
    /// Macros and their dependencies: the code they generate is included.
    pub(super) macros: Vec<Package>,
    /// Third-party data in our crates.
    pub(super) embedded: Vec<Embedded>,
}

/// Third-party crate.
#[derive(Debug)]
pub(super) struct Package {
    pub(super) name: String,
    pub(super) version: String,
    pub(super) licence: String,
    pub(super) authors: Vec<String>,
    pub(super) home: String,
    /// Folder of its sources.
    pub(super) folder: PathBuf,
}

/// Third-party data in one of our crates, as listed in its manifest under
/// `package.metadata.third-party`.
#[derive(Debug)]
pub(super) struct Embedded {
    pub(super) name: String,
    #[cfg_attr(not(test), expect(dead_code, reason = "only the tests look for it"))]
    pub(super) file: PathBuf,
    pub(super) licence: String,
    pub(super) copyright: String,
    pub(super) source: String,
    /// Text of its licence.
    pub(super) text: String,
}

pub(super) fn read(build: &Build) -> Result<Linked, Box<dyn Error>> {
    let metadata = metadata(build)?;
    let packages = metadata["packages"].as_array();
    let packages = packages.ok_or("cargo's answer was not understood")?;
    let code = tree(build, "normal,no-proc-macro")?;
    let all = tree(build, "normal")?;
    let (mut crates, mut macros, mut embedded) = (Vec::new(), Vec::new(), Vec::new());
    let mut known = 0;
    for package in packages {
        let key = (
            string_member(package, "name"),
            string_member(package, "version"),
        );
        if !all.contains(&key) {
            continue;
        }
        known += 1;
        let is_code = code.contains(&key);
        if package["source"].is_null() {
            if is_code {
                embedded.extend(embedded_data(package)?);
            }
        } else if is_code {
            crates.push(third_party_package(package));
        } else {
            macros.push(third_party_package(package));
        }
    }
    if crates.is_empty() || known != all.len() {
        return Err(format!("of {} crates {known} are known to cargo", all.len()).into());
    }
    for list in [&mut crates, &mut macros] {
        list.sort_by(|a, b| (&a.name, &a.version).cmp(&(&b.name, &b.version)));
    }
    Ok(Linked {
        crates,
        macros,
        embedded,
    })
}

fn metadata(build: &Build) -> Result<Value, Box<dyn Error>> {
    let mut command = Command::new(dist::cargo());
    command.args(["metadata", "--format-version=1", "--locked"]);
    command.arg("--manifest-path").arg(&build.manifest);
    command.args(
        build
            .features
            .iter()
            .flat_map(|feature| ["--features", feature]),
    );
    if let Some(target) = &build.target {
        command.args(["--filter-platform", target]);
    }
    Ok(serde_json::from_slice(&dist::output(&mut command)?)?)
}

/// Returns names and versions of all packages that a build depends on through these kinds of edges,
/// itself included.
fn tree(build: &Build, edges: &str) -> Result<BTreeSet<(String, String)>, Box<dyn Error>> {
    let mut command = Command::new(dist::cargo());
    command.args(["tree", "--locked", "--prefix", "none", "--format", "{p}"]);
    command.args(["--edges", edges]);
    command.arg("--manifest-path").arg(&build.manifest);
    command.args(build.packages.iter().flat_map(|name| ["--package", name]));
    command.args(
        build
            .features
            .iter()
            .flat_map(|feature| ["--features", feature]),
    );
    command.args(["--target", build.target.as_deref().unwrap_or("all")]);
    let printed = String::from_utf8(dist::output(&mut command)?)?;
    let lines = printed.lines().filter(|line| !line.trim().is_empty());
    lines
        .map(|line| parse_package(line).ok_or_else(|| format!("not understood: {line}").into()))
        .collect()
}

/// Parses `name v1.2.3 (anything else)`.
fn parse_package(line: &str) -> Option<(String, String)> {
    let mut words = line.split_whitespace();
    let (name, version) = (words.next()?, words.next()?.strip_prefix('v')?);
    Some((name.to_owned(), version.to_owned()))
}

fn string_member(package: &Value, key: &str) -> String {
    package[key].as_str().unwrap_or_default().to_owned()
}

fn folder(package: &Value) -> PathBuf {
    let mut path = PathBuf::from(string_member(package, "manifest_path"));
    path.pop();
    path
}

fn third_party_package(package: &Value) -> Package {
    let authors = package["authors"].as_array().into_iter().flatten();
    let homes = ["repository", "homepage"].map(|key| string_member(package, key));
    let registry = format!(
        "https://crates.io/crates/{}",
        string_member(package, "name")
    );
    Package {
        name: string_member(package, "name"),
        version: string_member(package, "version"),
        licence: string_member(package, "license"),
        authors: authors
            .filter_map(|author| author.as_str().map(str::to_owned))
            .collect(),
        home: homes
            .into_iter()
            .find(|home| !home.is_empty())
            .unwrap_or(registry),
        folder: folder(package),
    }
}

fn embedded_data(package: &Value) -> Result<Vec<Embedded>, Box<dyn Error>> {
    let folder = folder(package);
    let entries = package["metadata"]["third-party"].as_array();
    let mut all = Vec::new();
    for entry in entries.into_iter().flatten() {
        let wanted = |key: &str| match entry[key].as_str() {
            Some(word) => Ok(word.to_owned()),
            None => Err(format!("{}: third-party wants {key}", folder.display())),
        };
        let file = folder.join(wanted("file")?);
        fs::metadata(&file).map_err(|error| format!("{}: {error}", file.display()))?;
        all.push(Embedded {
            name: wanted("name")?,
            licence: wanted("license")?,
            copyright: wanted("copyright")?,
            source: wanted("source")?,
            text: fs::read_to_string(folder.join(wanted("license-file")?))?,
            file,
        });
    }
    Ok(all)
}
