//! Who serves which port, for other programs of this machine: a file for each `serve`.

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::folder;

/// The file of a `serve`, while it lasts.
#[derive(Debug)]
pub(crate) struct Holder(Option<PathBuf>);

#[derive(Debug, Deserialize, Serialize)]
struct Content {
    pid: u32,
    url: String,
    ports: Vec<String>,
}

impl Holder {
    /// Writes it. Without a place for it others just do not learn the address.
    pub(crate) fn write(url: &str, ports: &[String]) -> Self {
        let pid = std::process::id();
        let content = Content {
            pid,
            url: url.to_owned(),
            ports: ports.to_vec(),
        };
        let write = || {
            let folder = folder().ok()??;
            fs::create_dir_all(&folder).ok()?;
            let path = folder.join(format!("serve-{pid}.json"));
            let text = serde_json::to_string(&content).ok()?;
            fs::write(&path, text).ok()?;
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

/// The address at which a port is served, if a `serve` of this machine has it. The file of one that has ended is removed.
pub(crate) fn url_of(port: &str) -> Option<String> {
    let folder = folder().ok()??;
    let mut found = None;
    for entry in fs::read_dir(folder).ok()?.flatten() {
        let path = entry.path();
        let name = entry.file_name();
        let name = name.to_str().unwrap_or_default();
        if !(name.starts_with("serve-") && name.ends_with(".json")) {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap_or_default();
        let Ok(content) = serde_json::from_str::<Content>(&text) else {
            continue;
        };
        if !lives(content.pid) {
            let _ = fs::remove_file(&path);
            continue;
        }
        if content.ports.iter().any(|served| served == port) {
            found = Some(content.url);
        }
    }
    found
}

/// Whether a process is there; where the system does not say it counts as if it were.
fn lives(pid: u32) -> bool {
    let known = Path::new("/proc/self");
    !known.exists() || Path::new("/proc").join(pid.to_string()).exists()
}
