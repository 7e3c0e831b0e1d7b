//! Which crates and which data a build has in it. Cargo's tree is asked, which knows what the features of this very
//! build ask for; its metadata mixes those of the whole workspace.

use std::collections::BTreeSet;
use std::error::Error;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

use serde_json::Value;

use crate::dist;

/// What is built, as cargo is told.
pub(crate) struct Build {
    /// What it is called.
    pub(crate) title: &'static str,
    /// The manifest of its workspace.
    pub(crate) manifest: PathBuf,
    pub(crate) packages: Vec<String>,
    /// As `package/feature`.
    pub(crate) features: Vec<String>,
    /// Its triple; none for every platform.
    pub(crate) target: Option<String>,
}

/// What is in a build.
pub(super) struct Linked {
    /// Whose code is in it, by name.
    pub(super) crates: Vec<Package>,
    /// Macros, and what they are made with: what they wrote is in it.
    pub(super) macros: Vec<Package>,
    /// Data of others that our crates bring along.
    pub(super) embedded: Vec<Embedded>,
}

/// A third-party crate.
#[derive(Debug)]
pub(super) struct Package {
    pub(super) name: String,
    pub(super) version: String,
    pub(super) licence: String,
    pub(super) authors: Vec<String>,
    pub(super) home: String,
    /// Where its sources lie.
    pub(super) folder: PathBuf,
}

/// Third-party data in one of our crates, as listed in its manifest under `package.metadata.third-party`.
#[derive(Debug)]
pub(super) struct Embedded {
    pub(super) name: String,
    #[cfg_attr(not(test), expect(dead_code, reason = "only the tests look for it"))]
    pub(super) file: PathBuf,
    pub(super) licence: String,
    pub(super) copyright: String,
    pub(super) source: String,
    /// The text of its licence.
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
        let key = (word(package, "name"), word(package, "version"));
        if !all.contains(&key) {
            continue;
        }
        known += 1;
        let is_code = code.contains(&key);
        if package["source"].is_null() {
            if is_code {
                embedded.extend(data_of(package)?);
            }
        } else if is_code {
            crates.push(other(package));
        } else {
            macros.push(other(package));
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

/// Names and versions of what a build depends on over edges of some kinds, itself included.
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
    let told = String::from_utf8(dist::output(&mut command)?)?;
    let lines = told.lines().filter(|line| !line.trim().is_empty());
    lines
        .map(|line| named(line).ok_or_else(|| format!("not understood: {line}").into()))
        .collect()
}

/// `name v1.2.3 (anything else)`.
fn named(line: &str) -> Option<(String, String)> {
    let mut words = line.split_whitespace();
    let (name, version) = (words.next()?, words.next()?.strip_prefix('v')?);
    Some((name.to_owned(), version.to_owned()))
}

fn word(package: &Value, key: &str) -> String {
    package[key].as_str().unwrap_or_default().to_owned()
}

fn folder(package: &Value) -> PathBuf {
    let mut path = PathBuf::from(word(package, "manifest_path"));
    path.pop();
    path
}

fn other(package: &Value) -> Package {
    let authors = package["authors"].as_array().into_iter().flatten();
    let homes = ["repository", "homepage"].map(|key| word(package, key));
    let registry = format!("https://crates.io/crates/{}", word(package, "name"));
    Package {
        name: word(package, "name"),
        version: word(package, "version"),
        licence: word(package, "license"),
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

fn data_of(package: &Value) -> Result<Vec<Embedded>, Box<dyn Error>> {
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
