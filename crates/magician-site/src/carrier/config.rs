//! Zenoh's own settings: those of a file, and what this program needs where the file says nothing.

use std::path::{Path, PathBuf};

use serde_json::Value;
use zenoh::Config;

use super::CarrierError;
use crate::certificates::Identity;
use crate::message::LARGEST;

/// What is set where a file does not set it. Presence is lost within three seconds of a cut cable: Zenoh takes a link for dead one lease
/// after its last packet, and the rest is for machines that are busy. Two signs of life to a lease are half of Zenoh's four: each
/// station sends them to each other one, and with fifty of them that is most of what they cost. And nobody sends what fills the memory.
const OURS: [(&str, &str); 3] = [
    ("transport/link/tx/lease", "2000"),
    ("transport/link/tx/keep_alive", "2"),
    ("transport/link/rx/max_message_size", LARGEST_TEXT),
];
const LARGEST_TEXT: &str = "2097152";
const _: () = assert!(LARGEST == 2_097_152);
/// What stations and hubs of a site with certificates may say to each other, and nothing else.
const ACCESS: &str = r#"{
    enabled: true,
    default_permission: "deny",
    rules: [{
        id: "tells",
        messages: ["put", "reply", "liveliness_token", "declare_queryable",
            "declare_subscriber", "query", "liveliness_query", "declare_liveliness_subscriber"],
        flows: ["ingress", "egress"],
        permission: "allow",
        key_exprs: ["magician/*/*/state/*", "magician/*/*/alive/*/*", "magician/*/*/roster", "magician/*/*/revoked"],
    }],
    subjects: [{ id: "everybody" }],
    policies: [{ rules: ["tells"], subjects: ["everybody"] }],
}"#;

/// The settings of a file, or the usual ones; with certificates connections are encrypted, and made
/// with machines of the same authority alone.
pub(super) fn read(
    file: Option<&Path>,
    identity: Option<&Identity>,
) -> Result<Config, CarrierError> {
    let (mut config, said) = match file {
        Some(file) => from_file(file)?,
        None => (Config::default(), Value::Null),
    };
    let mut ours: Vec<_> = OURS.map(|(key, value)| (key, value.to_owned())).to_vec();
    if let Some(identity) = identity {
        let text = |path: PathBuf| Value::from(path.to_string_lossy()).to_string();
        let (key, certificate) = (text(identity.key_file()), text(identity.certificate_file()));
        let encrypted = [
            ("listen/endpoints", r#"["tls/0.0.0.0:0"]"#.to_owned()),
            ("transport/link/protocols", r#"["tls"]"#.to_owned()),
            (
                "transport/link/tls/root_ca_certificate",
                text(identity.authority_file()),
            ),
            ("transport/link/tls/enable_mtls", "true".to_owned()),
            ("transport/link/tls/listen_private_key", key.clone()),
            ("transport/link/tls/listen_certificate", certificate.clone()),
            ("transport/link/tls/connect_private_key", key),
            ("transport/link/tls/connect_certificate", certificate),
            // Machines find each other by address, which is in no certificate. Who has signed it counts.
            (
                "transport/link/tls/verify_name_on_connect",
                "false".to_owned(),
            ),
            ("access_control", ACCESS.to_owned()),
        ];
        ours.extend(encrypted);
    }
    for (key, value) in ours {
        if said.pointer(&format!("/{key}")).is_none() {
            config
                .insert_json5(key, &value)
                .map_err(|error| CarrierError::Config(error.to_string()))?;
        }
    }
    Ok(config)
}

/// The settings of a file, and what it says.
fn from_file(file: &Path) -> Result<(Config, Value), CarrierError> {
    let wrong = |why: String| CarrierError::Config(format!("{}: {why}", file.display()));
    let text = std::fs::read_to_string(file).map_err(|error| wrong(error.to_string()))?;
    let said: Value = json5::from_str(&text).map_err(|error| wrong(error.to_string()))?;
    if !said.is_object() {
        return Err(wrong("it is no object".to_owned()));
    }
    let config = Config::from_file(file).map_err(|error| wrong(error.to_string()))?;
    Ok((config, said))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_says_what_counts_and_the_rest_is_ours() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("site.json5");
        let lease = |config: &Config| config.get_json("transport/link/tx/lease").unwrap();
        assert_eq!(lease(&read(None, None).unwrap()), "2000");
        let text = "// Zenoh's own.\n{ scouting: { multicast: { enabled: false } } }";
        std::fs::write(&file, text).unwrap();
        let config = read(Some(&file), None).unwrap();
        assert_eq!(lease(&config), "2000");
        let scouts = config.get_json("scouting/multicast/enabled").unwrap();
        assert_eq!(scouts, "false");
        std::fs::write(&file, "{ transport: { link: { tx: { lease: 10000 } } } }").unwrap();
        assert_eq!(lease(&read(Some(&file), None).unwrap()), "10000");
        for wrong in ["{", "{ lease: 1 }", "[]"] {
            std::fs::write(&file, wrong).unwrap();
            let error = read(Some(&file), None).unwrap_err().to_string();
            assert!(error.contains("site.json5"), "{wrong}: {error}");
        }
        assert!(read(Some(&folder.path().join("none.json5")), None).is_err());
    }
}
