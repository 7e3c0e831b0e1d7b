//! The licences of everything that is linked into the command, or into a library.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::error::Error;
use std::ffi::OsStr;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// What cargo knows of this workspace.
pub(crate) struct Metadata {
    pub(crate) target_directory: PathBuf,
    /// The triple of this machine.
    pub(crate) host: String,
    value: Value,
}

impl Metadata {
    /// What it knows for a target, this machine's if none is named.
    pub(crate) fn read(
        cargo: &OsStr,
        root: &Path,
        target: Option<&str>,
    ) -> Result<Self, Box<dyn Error>> {
        let told = super::output(Command::new("rustc").arg("-vV"))?;
        let told = String::from_utf8(told)?;
        let host = told.lines().find_map(|line| line.strip_prefix("host: "));
        let host = host.ok_or("rustc does not tell its host")?.to_owned();
        let metadata = super::output(Command::new(cargo).current_dir(root).args([
            "metadata",
            "--format-version=1",
            "--locked",
            "--filter-platform",
            target.unwrap_or(&host),
        ]))?;
        let value: Value = serde_json::from_slice(&metadata)?;
        let target = value["target_directory"].as_str();
        Ok(Self {
            target_directory: target.ok_or("cargo tells no target directory")?.into(),
            host,
            value,
        })
    }

    pub(crate) fn version(&self) -> Result<&str, Box<dyn Error>> {
        let command = self
            .packages()
            .find(|package| package["name"] == "magician-cli");
        let version = command.and_then(|package| package["version"].as_str());
        Ok(version.ok_or("there is no magician-cli")?)
    }

    fn packages(&self) -> impl Iterator<Item = &Value> {
        self.value["packages"].as_array().into_iter().flatten()
    }

    /// Everything that ends up in a package: what it depends on, but for tests and for building.
    fn linked(&self, name: &str) -> Vec<&Value> {
        let packages: BTreeMap<&str, &Value> = (self.packages())
            .filter_map(|package| Some((package["id"].as_str()?, package)))
            .collect();
        let nodes: BTreeMap<&str, &Value> = (self.value["resolve"]["nodes"].as_array())
            .into_iter()
            .flatten()
            .filter_map(|node| Some((node["id"].as_str()?, node)))
            .collect();
        let root = packages.iter().find(|(_, package)| package["name"] == name);
        let mut seen: BTreeSet<&str> = root.map(|(id, _)| *id).into_iter().collect();
        let mut queue: VecDeque<&str> = seen.iter().copied().collect();
        while let Some(id) = queue.pop_front() {
            let deps = nodes.get(id).and_then(|node| node["deps"].as_array());
            for dep in deps.into_iter().flatten().filter(|dep| is_normal(dep)) {
                if let Some(id) = dep["pkg"].as_str().filter(|id| seen.insert(id)) {
                    queue.push_back(id);
                }
            }
        }
        let mut linked: Vec<_> = seen
            .iter()
            .filter_map(|id| packages.get(id).copied())
            .collect();
        linked.retain(|package| !package["source"].is_null());
        linked.sort_by_key(|package| text(package, "name").to_owned());
        linked
    }
}

fn is_normal(dep: &Value) -> bool {
    let kinds = dep["dep_kinds"].as_array();
    kinds.is_some_and(|kinds| kinds.iter().any(|kind| kind["kind"].is_null()))
}

fn text<'v>(package: &'v Value, key: &str) -> &'v str {
    package[key].as_str().unwrap_or_default()
}

/// The page of a package: who is in it, and each licence text once.
pub(crate) fn page(metadata: &Metadata, package: &str) -> Result<String, Box<dyn Error>> {
    let linked = metadata.linked(package);
    if linked.is_empty() {
        return Err(
            format!("nothing is linked into {package}: cargo's answer was not understood").into(),
        );
    }
    let mut page = String::from("What is linked into magician, and its licences.\n\n");
    let mut texts: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for package in linked {
        let (name, version) = (text(package, "name"), text(package, "version"));
        let (licence, home) = (text(package, "license"), text(package, "repository"));
        writeln!(page, "{name} {version}: {licence} {home}")?;
        for licence in licence_texts(Path::new(text(package, "manifest_path")))? {
            texts.entry(licence).or_default().push(name.to_owned());
        }
    }
    for (licence, of) in texts {
        write!(
            page,
            "\n{}\nOf {}:\n\n{}\n",
            "-".repeat(80),
            of.join(", "),
            licence.trim_end()
        )?;
    }
    Ok(page)
}

fn licence_texts(manifest: &Path) -> Result<Vec<String>, Box<dyn Error>> {
    let Some(folder) = manifest.parent() else {
        return Ok(Vec::new());
    };
    let mut files: Vec<_> = fs::read_dir(folder)?
        .filter_map(|entry| entry.ok().map(|entry| entry.path()))
        .filter(|path| path.is_file() && is_licence(path))
        .collect();
    files.sort();
    let texts = files.iter().map(fs::read).collect::<Result<Vec<_>, _>>()?;
    Ok(texts
        .iter()
        .map(|bytes| String::from_utf8_lossy(bytes).replace("\r\n", "\n"))
        .collect())
}

fn is_licence(path: &Path) -> bool {
    let name = path
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .to_uppercase();
    ["LICENSE", "LICENCE", "COPYING", "NOTICE", "UNLICENSE"]
        .iter()
        .any(|head| name.starts_with(head))
}
