//! The stations of this machine: where each is, which ports and arms it has; a file for each `serve`.

use std::fs;
use std::path::{Path, PathBuf};

use magician_job::dirs;
use magician_job::files::replace;
use serde::{Deserialize, Serialize};

/// Returns the folder where a station keeps its files; `None` where the system names no place.
pub(crate) fn folder() -> Option<PathBuf> {
    dirs::state().map(|state| state.join("station"))
}

/// The file of a `serve`, while it lasts.
#[derive(Debug)]
pub(crate) struct Holder(Option<PathBuf>);

#[derive(Debug, Deserialize, Serialize)]
struct Content {
    pid: u32,
    url: String,
    ports: Vec<String>,
    /// The names of its arms.
    #[serde(default)]
    arms: Vec<String>,
}

impl Holder {
    /// Writes it. Without a place for it others just do not learn the address.
    pub(crate) fn write(url: &str, ports: &[String], arms: &[String]) -> Self {
        let pid = std::process::id();
        let content = Content {
            pid,
            url: url.to_owned(),
            ports: ports.to_vec(),
            arms: arms.to_vec(),
        };
        let write = || {
            let folder = folder()?;
            let path = folder.join(format!("serve-{pid}.json"));
            let text = serde_json::to_string(&content).ok()?;
            replace(&path, &text).ok()?;
            Some(path)
        };
        Self(write())
    }
}

impl Drop for Holder {
    fn drop(&mut self) {
        if let Some(path) = &self.0 {
            let _ = fs::remove_file(path);
        }
    }
}

/// The address at which a port is served, if a `serve` of this machine has it.
pub(crate) fn url_of(port: &str) -> Option<String> {
    let mut all = all().into_iter();
    all.find_map(|content| {
        content
            .ports
            .iter()
            .any(|served| served == port)
            .then_some(content.url)
    })
}

/// The stations of this machine: where each is, and its arms.
pub(crate) fn stations() -> impl Iterator<Item = (String, Vec<String>)> {
    all().into_iter().map(|content| (content.url, content.arms))
}

/// What each `serve` of this machine says of itself. The file of one that has ended is removed.
fn all() -> Vec<Content> {
    let read = || fs::read_dir(folder()?).ok();
    let files = read().into_iter().flatten().flatten();
    let content = files.filter_map(|entry| {
        let path = entry.path();
        let name = entry.file_name();
        let name = name.to_str()?;
        if !(name.starts_with("serve-") && name.ends_with(".json")) {
            return None;
        }
        let content: Content = serde_json::from_str(&fs::read_to_string(&path).ok()?).ok()?;
        if !lives(content.pid) {
            let _ = fs::remove_file(&path);
            return None;
        }
        Some(content)
    });
    content.collect()
}

/// Whether a process is there; where the system does not say it counts as if it were.
fn lives(pid: u32) -> bool {
    let known = Path::new("/proc/self");
    !known.exists() || Path::new("/proc").join(pid.to_string()).exists()
}
