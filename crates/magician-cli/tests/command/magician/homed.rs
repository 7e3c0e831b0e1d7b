//! An arm that was homed, without the half minute that it takes at real speed.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::SystemTime;

use serde_json::{Value, json};

/// Leaves the record that a homing leaves, for commands made by this one: `command` is given the port and nothing else.
pub(crate) fn as_if_homed(mut command: Command, port: &str) {
    let state = command
        .get_envs()
        .find(|(name, _)| *name == "XDG_STATE_HOME");
    let state = state
        .and_then(|(_, value)| value)
        .expect("a directory for state");
    let place = Path::new(state).join("magician/homed");
    let output = command.args(["--port", port, "info", "--json"]).output();
    let info: Value = serde_json::from_slice(&output.expect("it runs").stdout).expect("JSON");
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    let now = now.expect("a clock").as_secs_f64();
    let uptime = info["uptime_ms"].as_f64().expect("its clock") / 1000.0;
    let serial = info["device_sn"].as_str().expect("its serial number");
    let port = match fs::canonicalize(port) {
        Ok(path) => path.display().to_string(),
        Err(_) => port.to_owned(),
    };
    let record = json!({
        "version": 1,
        "serial": serial,
        "port": port,
        "powered_up": now - uptime,
        "seen": now,
        // At whatever speed it runs.
        "clock": "slower",
    });
    let name = format!("{serial}-{port}").replace(|sign: char| !sign.is_ascii_alphanumeric(), "_");
    fs::create_dir_all(&place).expect("a directory");
    fs::write(place.join(format!("{name}.json")), record.to_string()).expect("written");
}
