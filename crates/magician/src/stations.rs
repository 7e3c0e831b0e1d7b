//! Stations of this machine: address, ports and arms, from a file that each `serve` writes.

use std::path::{Path, PathBuf};
use std::{fmt, fs};

use serde::{Deserialize, Serialize};

use crate::files::replace_private;
use crate::{Error, ErrorKind, Port, SimSpeed, Target, dirs, ports};

/// Returns the folder for the files of a station; `None` if the system names no place.
#[must_use]
pub fn folder() -> Option<PathBuf> {
    dirs::state().map(|state| state.join("station"))
}

/// File of a running station; removed on drop.
#[derive(Debug)]
pub struct Holder(Option<PathBuf>);

/// Entry of a station, for programs of the same user.
#[derive(Clone, Deserialize, Serialize)]
pub struct LocalStation {
    pid: u32,
    /// Address of the station.
    pub url: String,
    /// Ports as they were spelled, one per arm.
    ports: Vec<String>,
    /// Devices that these ports meant when they were opened: real paths, to which other spellings
    /// lead as well.
    #[serde(default)]
    devices: Vec<String>,
    /// Names of its arms.
    #[serde(default)]
    pub arms: Vec<String>,
    /// Teacher token for commands of this user on this machine; only the owner may read the file.
    #[serde(default)]
    pub token: String,
}

/// Omits the token, which must not appear in a log.
impl fmt::Debug for LocalStation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LocalStation")
            .field("url", &self.url)
            .field("ports", &self.ports)
            .field("arms", &self.arms)
            .finish_non_exhaustive()
    }
}

impl LocalStation {
    /// Returns the address of the arm at this device, if this station has it.
    fn url_of(&self, wanted: &str) -> Option<String> {
        let is_it = |(at, served): (usize, &String)| {
            // An adapter may have moved since the start. A relative path only has a meaning in the
            // folder of its process.
            let now = || device(served) == wanted;
            let is_relative = served.contains('/') && !served.starts_with('/');
            let then = self.devices.get(at).is_some_and(|then| then == wanted);
            (then || served == wanted || !is_relative && now()).then_some(at)
        };
        let at = self.ports.iter().enumerate().find_map(is_it)?;
        let name = self.arms.get(at).filter(|_| self.arms.len() > 1);
        let name = name.map_or("", String::as_str);
        Some(format!("{}/{name}", self.url.trim_end_matches('/')))
    }
}

/// Returns the device that a port means, however it is spelled: the real path of a serial port,
/// also for `usb:..`; the canonical spelling of any other target.
fn device(port: &str) -> String {
    let path = match Target::parse(port, SimSpeed::Max) {
        Ok(Target::Serial(path)) => path,
        Ok(Target::Usb {
            vendor,
            product,
            serial,
        }) => {
            let is_it = |port: &Port| {
                let usb = port.usb.as_ref();
                usb.is_some_and(|usb| {
                    let same = (usb.vendor, usb.product) == (vendor, product);
                    same && (serial.is_none() || usb.serial == serial)
                })
            };
            let found = ports().unwrap_or_default().into_iter().find(is_it);
            match found {
                Some(found) => found.path,
                None => return port.to_owned(),
            }
        }
        Ok(target) => return target.to_string(),
        // Not a target at all; compared as it is spelled.
        Err(_) => return port.to_owned(),
    };
    fs::canonicalize(&path).map_or(path, |real| real.display().to_string())
}

impl Holder {
    /// Writes the file. Without a place for it other programs do not find the address.
    #[must_use]
    pub fn write(url: &str, ports: &[String], arms: &[String], token: String) -> Self {
        let pid = std::process::id();
        let content = LocalStation {
            pid,
            url: url.to_owned(),
            ports: ports.to_vec(),
            devices: ports.iter().map(|port| device(port)).collect(),
            arms: arms.to_vec(),
            token,
        };
        let write = || {
            let folder = folder()?;
            let path = folder.join(format!("serve-{pid}.json"));
            let text = serde_json::to_string(&content).ok()?;
            replace_private(&path, &text).ok()?;
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

/// Adds the station of this machine that has the target to the error of a line that could not be
/// opened or does not answer. Other errors stay as they are, and a station of this process is never
/// named.
pub(crate) fn named(error: Error, target: &Target) -> Error {
    const EFFECT: &str = "uses the arm through the station that has its port";
    let of_line = matches!(
        error.kind(),
        ErrorKind::Port | ErrorKind::Timeout | ErrorKind::Unexpected
    );
    // Every station has its own virtual arms, so `sim` is never one of another.
    if !of_line || error.station().is_some() || matches!(target, Target::Sim(_)) {
        return error;
    }
    match url_of(&target.to_string()) {
        Some(url) => error.at_station(url, EFFECT),
        None => error,
    }
}

/// Returns the address at which another program of this machine serves a port, however it is
/// spelled.
pub(crate) fn url_of(port: &str) -> Option<String> {
    let wanted = device(port);
    let own = std::process::id();
    let mut others = stations().into_iter().filter(|station| station.pid != own);
    others.find_map(|station| station.url_of(&wanted))
}

/// Returns the stations of this machine. The file of a station that has ended is removed.
#[must_use]
pub fn stations() -> Vec<LocalStation> {
    let read = || fs::read_dir(folder()?).ok();
    let files = read().into_iter().flatten().flatten();
    let content = files.filter_map(|entry| {
        let path = entry.path();
        let name = entry.file_name();
        let name = name.to_str()?;
        if !(name.starts_with("serve-") && name.ends_with(".json")) {
            return None;
        }
        let content: LocalStation = serde_json::from_str(&fs::read_to_string(&path).ok()?).ok()?;
        if !lives(content.pid) {
            // The process ended without removing its file, so the token in it is of no use.
            let _ = fs::remove_file(&path);
            return None;
        }
        Some(content)
    });
    content.collect()
}

/// True if a process exists, or if the system does not tell.
fn lives(pid: u32) -> bool {
    let known = Path::new("/proc/self");
    !known.exists() || Path::new("/proc").join(pid.to_string()).exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn every_spelling_of_a_port_names_its_station_and_arm() {
        let place = tempfile::tempdir().expect("a directory");
        let path = |name: &str| place.path().join(name).display().to_string();
        fs::write(path("tty"), "").expect("written");
        for link in ["arm", "other"] {
            std::os::unix::fs::symlink(path("tty"), path(link)).expect("linked");
        }
        let real = device(&path("tty"));
        let served = |ports: &[String], devices: &[String]| LocalStation {
            pid: 1,
            url: "http://127.0.0.1:8910/".to_owned(),
            ports: ports.to_vec(),
            devices: devices.to_vec(),
            arms: ports
                .iter()
                .map(|port| format!("arm{}", port.len()))
                .collect(),
            token: String::new(),
        };
        let one = served(&[path("arm")], std::slice::from_ref(&real));
        let here = Some("http://127.0.0.1:8910/".to_owned());
        for spelling in [
            path("tty"),
            path("arm"),
            path("other"),
            path("../")
                + &place
                    .path()
                    .file_name()
                    .map_or(String::new(), |name| name.display().to_string())
                + "/tty",
        ] {
            assert_eq!(one.url_of(&device(&spelling)), here, "{spelling}");
        }
        assert_eq!(one.url_of(&device("/dev/null")), None);
        // A link that leads elsewhere by now still names the device that was opened.
        fs::remove_file(path("arm")).expect("removed");
        assert_eq!(one.url_of(&real), here);
        // A relative path of another process has no meaning here.
        let relative = served(&["./Cargo.toml".to_owned()], std::slice::from_ref(&real));
        assert_eq!(relative.url_of(&device("./Cargo.toml")), None);
        assert_eq!(relative.url_of(&real), here);
        let several = served(&["udp:10.0.0.9".to_owned(), path("other")], &[]);
        let second = format!("http://127.0.0.1:8910/arm{}", path("other").len());
        assert_eq!(several.url_of(&real), Some(second));
        assert_eq!(
            several.url_of(&device("udp:10.0.0.9:8899")).is_some(),
            device("udp:10.0.0.9") == device("udp:10.0.0.9:8899")
        );
    }
}
