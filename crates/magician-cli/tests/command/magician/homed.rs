//! Marks an arm as homed, without the half minute of homing at real speed.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::SystemTime;

use serde_json::{Value, json};

/// Writes the record of a homing for commands made from this one. `command` must have no arguments;
/// the port is passed separately.
pub(crate) fn mark_homed(mut command: Command, port: &str) {
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
        // Valid for an arm at any speed.
        "clock": "slower",
    });
    let name = format!("{serial}-{port}").replace(|sign: char| !sign.is_ascii_alphanumeric(), "_");
    fs::create_dir_all(&place).expect("a directory");
    fs::write(place.join(format!("{name}.json")), record.to_string()).expect("written");
}
