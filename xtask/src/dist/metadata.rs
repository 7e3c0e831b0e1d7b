//! Cargo's metadata of this workspace.

use std::error::Error;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// Values from Cargo and rustc that a release needs.
pub(crate) struct Metadata {
    pub(crate) target_directory: PathBuf,
    /// Target triple of this machine.
    pub(crate) host: String,
    /// Version of `magician-cli`. The next three fields are also from its manifest.
    pub(crate) version: String,
    pub(super) repository: String,
    pub(super) description: String,
    pub(super) licence: String,
}

impl Metadata {
    pub(crate) fn read(cargo: &OsStr, root: &Path) -> Result<Self, Box<dyn Error>> {
        let rustc_version = super::output(Command::new("rustc").arg("-vV"))?;
        let rustc_version = String::from_utf8(rustc_version)?;
        let host = rustc_version
            .lines()
            .find_map(|line| line.strip_prefix("host: "));
        let metadata = super::output(Command::new(cargo).current_dir(root).args([
            "metadata",
            "--format-version=1",
            "--locked",
            "--no-deps",
        ]))?;
        let metadata: Value = serde_json::from_slice(&metadata)?;
        let target_directory = metadata["target_directory"].as_str();
        let package = (metadata["packages"].as_array().into_iter().flatten())
            .find(|package| package["name"] == "magician-cli")
            .ok_or("there is no magician-cli")?;
        let manifest_value = |key: &str| match package[key].as_str() {
            Some(value) => Ok(value.to_owned()),
            None => Err(format!("magician-cli has no {key}")),
        };
        Ok(Self {
            target_directory: target_directory
                .ok_or("cargo tells no target directory")?
                .into(),
            host: host.ok_or("rustc does not tell its host")?.to_owned(),
            version: manifest_value("version")?,
            repository: manifest_value("repository")?,
            description: manifest_value("description")?,
            licence: manifest_value("license")?,
        })
    }

    /// True if the repository's address is still a placeholder in the reserved domain `.invalid`.
    pub(crate) fn unpublished(&self) -> bool {
        self.repository.contains(".invalid/")
    }
}
