//! Permission for dangerous commands. They can brick the arm, lose its calibration or unlock
//! something, and are sent only if the user has named them.

use std::collections::BTreeSet;
use std::ffi::c_int;
use std::sync::Mutex;

use magician::protocol::Row;

use super::registry::lock;
use super::{Environment, Registry};
use crate::code::{Code, Fault, Outcome};
use crate::notice;
use crate::pointer::Text;

/// Variable with the allowed commands.
const VARIABLE: &str = "MAGICIAN_ALLOW";

/// Dangerous commands that are allowed.
#[derive(Debug)]
pub(super) struct Allowed {
    environment: Environment,
    /// Allowed by `MagicianAllow`.
    named: Mutex<AllowedIds>,
}

/// Ids of commands, or all of them.
#[derive(Clone, Debug, Default)]
struct AllowedIds {
    all: bool,
    ids: BTreeSet<u8>,
}

impl Allowed {
    pub(super) fn new(environment: Environment) -> Self {
        Self {
            environment,
            named: Mutex::default(),
        }
    }

    /// Fails if the command is dangerous and not allowed.
    pub(super) fn check(&self, row: &Row) -> Outcome {
        let Some(danger) = row.danger().filter(|_| !lock(&self.named).contains(row)) else {
            return Ok(());
        };
        let variable = (self.environment.variable)(VARIABLE).unwrap_or_default();
        // Unknown names in the variable are ignored; the refusal shows the correct one.
        if parse(&variable).0.contains(row) {
            return Ok(());
        }
        let name = row.set_name;
        Err(Fault::invalid(format!(
            "it was not sent, because it {danger}; {VARIABLE}={name}, or MagicianAllow(\"{name}\") \
                before it, allows it"
        )))
    }
}

impl AllowedIds {
    fn contains(&self, row: &Row) -> bool {
        self.all || self.ids.contains(&row.id)
    }
}

/// Parses names separated by commas or blanks. Also returns the unknown ones.
fn parse(text: &str) -> (AllowedIds, Vec<&str>) {
    let mut names = AllowedIds::default();
    let mut unknown = Vec::new();
    let parts = text.split(|c: char| c == ',' || c.is_whitespace());
    for name in parts.filter(|name| !name.is_empty()) {
        match Row::find_writable(name).or_else(|_| find_by_function_name(name)) {
            _ if name.eq_ignore_ascii_case("all") => names.all = true,
            Ok(row) => drop(names.ids.insert(row.id)),
            Err(_) => unknown.push(name),
        }
    }
    (names, unknown)
}

/// Finds the command of a vendor function whose name differs from that of the command.
fn find_by_function_name(name: &str) -> Result<&'static Row, magician::protocol::NameError> {
    if name.eq_ignore_ascii_case("UpdateFirmware") {
        Row::find_writable("FirmwareSwitch")
    } else {
        Err(magician::protocol::NameError)
    }
}

impl Registry {
    /// `MagicianAllow`: allows the named dangerous commands, or `all`, until the process ends.
    /// Returns 3 if a name is unknown; the other names are allowed nevertheless.
    pub fn allow(&self, names: Text) -> c_int {
        let bytes = names.bytes();
        let text = String::from_utf8_lossy(&bytes);
        let (allowed, unknown) = parse(&text);
        {
            let mut named = lock(&self.allowed().named);
            named.all |= allowed.all;
            named.ids.extend(allowed.ids);
        }
        if unknown.is_empty() {
            return Code::NoError as c_int;
        }
        let fault = Fault::invalid(format!("unknown command {}", unknown.join(", ")));
        notice::fault("MagicianAllow", &fault)
    }
}
