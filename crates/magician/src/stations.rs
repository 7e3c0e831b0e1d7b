//! The stations of this machine: where each is, which ports and arms it has; a file for each `serve`.

use std::path::{Path, PathBuf};
use std::{fmt, fs};

use serde::{Deserialize, Serialize};

use crate::files::replace_private;
use crate::{Error, ErrorKind, Port, SimSpeed, Target, dirs, ports};

/// Returns the folder where a station keeps its files; `None` where the system names no place.
#[must_use]
pub fn folder() -> Option<PathBuf> {
    dirs::state().map(|state| state.join("station"))
}

/// The file of a station, while it lasts.
#[derive(Debug)]
pub struct Holder(Option<PathBuf>);

/// What a station says of itself to programs of the same user.
#[derive(Clone, Deserialize, Serialize)]
pub struct LocalStation {
    pid: u32,
    /// Its address.
    pub url: String,
    /// The ports as they were spelled, one for each arm.
    ports: Vec<String>,
    /// The devices that these meant when they were opened: real paths, which other spellings lead to as well.
    #[serde(default)]
    devices: Vec<String>,
    /// The names of its arms.
    #[serde(default)]
    pub arms: Vec<String>,
    /// A teacher's token for commands of this user on this machine: the file is for its owner alone.
    #[serde(default)]
    pub token: String,
}

/// Without the token, which belongs into no log.
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
    /// Address of the arm at this device, if it is one of this station.
    fn url_of(&self, wanted: &str) -> Option<String> {
        let is_it = |(at, served): (usize, &String)| {
            // An adapter may have another path by now than at the start; a relative path is for the folder of that process.
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

/// Device that a port means, however it is spelled: the real path of a serial port, also of one that `usb:..` names; of other
/// ports the usual spelling.
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
        Err(_) => return port.to_owned(),
    };
    fs::canonicalize(&path).map_or(path, |real| real.display().to_string())
}

impl Holder {
    /// Writes it. Without a place for it others just do not learn the address.
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

/// Names the station of this machine that has a target, in the error of a line that could not be opened or does not answer. A
/// station is no reason for any other error, and the one of this program none at all.
pub(crate) fn named(error: Error, target: &Target) -> Error {
    const EFFECT: &str = "uses the arm through the station that has its port";
    let of_line = matches!(
        error.kind(),
        ErrorKind::Port | ErrorKind::Timeout | ErrorKind::Unexpected
    );
    // Every station has virtual arms of its own.
    if !of_line || error.station().is_some() || matches!(target, Target::Sim(_)) {
        return error;
    }
    match url_of(&target.to_string()) {
        Some(url) => error.at_station(url, EFFECT),
        None => error,
    }
}

/// The address at which a port is served, however it is spelled, if another program of this machine serves it.
pub(crate) fn url_of(port: &str) -> Option<String> {
    let wanted = device(port);
    let own = std::process::id();
    let mut others = stations().into_iter().filter(|station| station.pid != own);
    others.find_map(|station| station.url_of(&wanted))
}

/// The stations of this machine. The file of one that has ended is removed.
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
        // A link that leads elsewhere by now still names what was opened.
        fs::remove_file(path("arm")).expect("removed");
        assert_eq!(one.url_of(&real), here);
        // A relative path of another process is not looked at from here.
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
