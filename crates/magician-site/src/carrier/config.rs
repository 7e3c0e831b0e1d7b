//! Zenoh's configuration: the user's file, with this program's defaults for settings that it omits.

use std::path::{Path, PathBuf};

use serde_json::Value;
use zenoh::Config;

use super::CarrierError;
use crate::certificates::Identity;
use crate::message::MAX_MESSAGE_SIZE;

/// Defaults for settings that the file omits.
///
/// * Lease 2 s: Zenoh declares a link dead one lease after its last packet. Together with delays of
///   busy machines, presence is lost within three seconds of a cut cable.
/// * Two keep-alives a lease instead of Zenoh's four: each station sends them to each other one,
///   and with fifty stations they are most of the idle traffic.
/// * Largest message: bounds the memory that a peer can make this program use.
const DEFAULTS: [(&str, &str); 3] = [
    ("transport/link/tx/lease", "2000"),
    ("transport/link/tx/keep_alive", "2"),
    ("transport/link/rx/max_message_size", MAX_MESSAGE_SIZE_TEXT),
];
const MAX_MESSAGE_SIZE_TEXT: &str = "2097152";
const _: () = assert!(MAX_MESSAGE_SIZE == 2_097_152);
/// Access list for a site with certificates: permits the messages of this program and denies all
/// others.
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

/// Reads the file, or starts from Zenoh's defaults without one. With an identity the links use TLS,
/// and only with machines whose certificate the same authority signed.
pub(super) fn read(
    file: Option<&Path>,
    identity: Option<&Identity>,
) -> Result<Config, CarrierError> {
    let (mut config, said) = match file {
        Some(file) => from_file(file)?,
        None => (Config::default(), Value::Null),
    };
    let mut ours: Vec<_> = DEFAULTS
        .map(|(key, value)| (key, value.to_owned()))
        .to_vec();
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
            // Peers find each other by address, and certificates contain no addresses. The
            // signature of the authority is the check.
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

/// Reads a configuration file. Returns the configuration and the plain JSON, which shows what the
/// file sets.
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
    fn file_settings_override_defaults() {
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
