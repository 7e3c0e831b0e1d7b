//! Where this program keeps what outlives it.

use std::ffi::OsString;
use std::path::PathBuf;

pub(crate) use magician_job::dirs::state;

/// The file of settings: `MAGICIAN_CONFIG`, or `config.toml` in the system's directory for settings.
pub(crate) fn config() -> Option<PathBuf> {
    config_of(|name| std::env::var_os(name))
}

fn config_of(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    let set = |name| variable(name).filter(|value| !value.is_empty());
    if let Some(path) = set("MAGICIAN_CONFIG") {
        return Some(path.into());
    }
    let config = set("XDG_CONFIG_HOME").map(PathBuf::from);
    let config = config.filter(|path| path.is_absolute());
    let local = || match (cfg!(windows), cfg!(target_os = "macos")) {
        (true, _) => set("APPDATA").map(PathBuf::from),
        (_, true) => {
            set("HOME").map(|home| PathBuf::from(home).join("Library/Application Support"))
        }
        _ => set("HOME").map(|home| PathBuf::from(home).join(".config")),
    };
    Some(config.or_else(local)?.join("magician").join("config.toml"))
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;

    #[test]
    fn settings_have_their_place_or_the_one_that_is_named() {
        let with = |name: &'static str, value: &'static str| {
            config_of(move |asked| (asked == name).then(|| value.into()))
        };
        assert_eq!(
            with("XDG_CONFIG_HOME", "/config"),
            Some("/config/magician/config.toml".into())
        );
        assert_eq!(with("MAGICIAN_CONFIG", "my.toml"), Some("my.toml".into()));
        assert_eq!(with("MAGICIAN_CONFIG", ""), None);
    }
}
