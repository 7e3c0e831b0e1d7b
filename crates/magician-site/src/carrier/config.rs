//! Zenoh's own settings: those of a file, and what this program needs where the file says nothing.

use std::path::Path;

use serde_json::Value;
use zenoh::Config;

use super::CarrierError;
use crate::message::LARGEST;

/// What is set where a file does not set it. Presence is lost within three seconds of a cut cable: Zenoh takes a link for dead one lease
/// after its last packet, and the rest is for machines that are busy. Two signs of life to a lease are half of Zenoh's four: each
/// station sends them to each other one, and with fifty of them that is most of what they cost. And nobody sends what fills the memory.
const OURS: [(&str, &str); 3] = [
    ("transport/link/tx/lease", "2000"),
    ("transport/link/tx/keep_alive", "2"),
    ("transport/link/rx/max_message_size", LARGEST_TEXT),
];
const LARGEST_TEXT: &str = "16777216";
const _: () = assert!(LARGEST == 16_777_216);

/// The settings of a file, or the usual ones.
pub(super) fn read(file: Option<&Path>) -> Result<Config, CarrierError> {
    let Some(file) = file else {
        return with_ours(Config::default(), &Value::Null);
    };
    let wrong = |why: String| CarrierError::Config(format!("{}: {why}", file.display()));
    let text = std::fs::read_to_string(file).map_err(|error| wrong(error.to_string()))?;
    let said: Value = json5::from_str(&text).map_err(|error| wrong(error.to_string()))?;
    if !said.is_object() {
        return Err(wrong("it is no object".to_owned()));
    }
    let config = Config::from_file(file).map_err(|error| wrong(error.to_string()))?;
    with_ours(config, &said)
}

fn with_ours(mut config: Config, said: &Value) -> Result<Config, CarrierError> {
    for (key, value) in OURS {
        if said.pointer(&format!("/{key}")).is_none() {
            config
                .insert_json5(key, value)
                .map_err(|error| CarrierError::Config(error.to_string()))?;
        }
    }
    Ok(config)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_says_what_counts_and_the_rest_is_ours() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("site.json5");
        let lease = |config: &Config| config.get_json("transport/link/tx/lease").unwrap();
        assert_eq!(lease(&read(None).unwrap()), "2000");
        let text = "// Zenoh's own.\n{ scouting: { multicast: { enabled: false } } }";
        std::fs::write(&file, text).unwrap();
        let config = read(Some(&file)).unwrap();
        assert_eq!(lease(&config), "2000");
        let scouts = config.get_json("scouting/multicast/enabled").unwrap();
        assert_eq!(scouts, "false");
        std::fs::write(&file, "{ transport: { link: { tx: { lease: 10000 } } } }").unwrap();
        assert_eq!(lease(&read(Some(&file)).unwrap()), "10000");
        for wrong in ["{", "{ lease: 1 }", "[]"] {
            std::fs::write(&file, wrong).unwrap();
            let error = read(Some(&file)).unwrap_err().to_string();
            assert!(error.contains("site.json5"), "{wrong}: {error}");
        }
        assert!(read(Some(&folder.path().join("none.json5"))).is_err());
    }
}
