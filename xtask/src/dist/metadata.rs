//! Cargo's metadata of this workspace.

use std::error::Error;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// Cargo's metadata of this workspace.
pub(crate) struct Metadata {
    pub(crate) target_directory: PathBuf,
    /// Target triple of this machine.
    pub(crate) host: String,
    /// Version of `magician-cli`; the next three fields are also its.
    pub(crate) version: String,
    pub(super) repository: String,
    pub(super) description: String,
    pub(super) licence: String,
}

impl Metadata {
    pub(crate) fn read(cargo: &OsStr, root: &Path) -> Result<Self, Box<dyn Error>> {
        let printed = super::output(Command::new("rustc").arg("-vV"))?;
        let printed = String::from_utf8(printed)?;
        let host = printed.lines().find_map(|line| line.strip_prefix("host: "));
        let metadata = super::output(Command::new(cargo).current_dir(root).args([
            "metadata",
            "--format-version=1",
            "--locked",
            "--no-deps",
        ]))?;
        let metadata: Value = serde_json::from_slice(&metadata)?;
        let folder = metadata["target_directory"].as_str();
        let command = (metadata["packages"].as_array().into_iter().flatten())
            .find(|package| package["name"] == "magician-cli")
            .ok_or("there is no magician-cli")?;
        let word = |key: &str| match command[key].as_str() {
            Some(word) => Ok(word.to_owned()),
            None => Err(format!("magician-cli has no {key}")),
        };
        Ok(Self {
            target_directory: folder.ok_or("cargo tells no target directory")?.into(),
            host: host.ok_or("rustc does not tell its host")?.to_owned(),
            version: word("version")?,
            repository: word("repository")?,
            description: word("description")?,
            licence: word("license")?,
        })
    }

    /// True if the repository's address is still a placeholder in the reserved domain `.invalid`.
    pub(crate) fn unpublished(&self) -> bool {
        self.repository.contains(".invalid/")
    }
}
