//! Directories for data that outlives a program.

use std::ffi::OsString;
use std::path::PathBuf;

/// Returns the directory for state: job journals, saved settings, histories. `None` if the system
/// names no place.
#[must_use]
pub fn state() -> Option<PathBuf> {
    place_of("XDG_STATE_HOME", ".local/state", |name| {
        std::env::var_os(name)
    })
}

/// Returns the directory for user data: programs. `None` if the system names no place.
#[must_use]
pub fn data() -> Option<PathBuf> {
    place_of("XDG_DATA_HOME", ".local/share", |name| {
        std::env::var_os(name)
    })
}

fn place_of(
    named: &str,
    usual: &str,
    variable: impl Fn(&str) -> Option<OsString>,
) -> Option<PathBuf> {
    let set = |name| variable(name).filter(|value| !value.is_empty());
    let place = set(named).map(PathBuf::from);
    // The XDG specification says that relative paths are to be ignored.
    let place = place.filter(|path| path.is_absolute());
    let local = || {
        if cfg!(windows) {
            set("LOCALAPPDATA").map(PathBuf::from)
        } else {
            set("HOME").map(|home| PathBuf::from(home).join(usual))
        }
    };
    Some(place.or_else(local)?.join("magician"))
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;

    #[test]
    fn state_has_its_place_or_none() {
        let with = |name: &'static str, value: &'static str| {
            place_of("XDG_STATE_HOME", ".local/state", move |asked| {
                (asked == name).then(|| value.into())
            })
        };
        let home = Some("/home/me/.local/state/magician".into());
        assert_eq!(
            with("XDG_STATE_HOME", "/state"),
            Some("/state/magician".into())
        );
        assert_eq!(with("HOME", "/home/me"), home);
        assert_eq!(with("XDG_STATE_HOME", "relative"), None);
        assert_eq!(with("HOME", ""), None);
    }
}
