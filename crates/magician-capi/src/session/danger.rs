//! Commands that can brick, unlearn or unlock something: sent only if they were named.

use std::collections::BTreeSet;
use std::ffi::c_int;
use std::sync::Mutex;

use magician::protocol::Row;

use super::registry::lock;
use super::{Registry, Surroundings};
use crate::code::{Code, Fault, Outcome};
use crate::notice;
use crate::pointer::Text;

/// The variable that allows dangerous commands.
const VARIABLE: &str = "MAGICIAN_ALLOW";

/// The dangerous commands that were allowed.
#[derive(Debug)]
pub(super) struct Allowed {
    surroundings: Surroundings,
    /// By `MagicianAllow`.
    named: Mutex<Names>,
}

/// Ids of commands, or all.
#[derive(Clone, Debug, Default)]
struct Names {
    all: bool,
    ids: BTreeSet<u8>,
}

impl Allowed {
    pub(super) fn new(surroundings: Surroundings) -> Self {
        Self {
            surroundings,
            named: Mutex::default(),
        }
    }

    /// Whether this may be sent.
    pub(super) fn check(&self, row: &Row) -> Outcome {
        let Some(danger) = row.danger().filter(|_| !lock(&self.named).have(row)) else {
            return Ok(());
        };
        let variable = (self.surroundings.variable)(VARIABLE).unwrap_or_default();
        // A name that is misspelt there allows nothing, and the refusal has the right one.
        if parse(&variable).0.have(row) {
            return Ok(());
        }
        let name = row.set_name;
        Err(Fault::invalid(format!(
            "it was not sent, because it {danger}; {VARIABLE}={name}, or MagicianAllow(\"{name}\") \
                before it, allows it"
        )))
    }
}

impl Names {
    fn have(&self, row: &Row) -> bool {
        self.all || self.ids.contains(&row.id)
    }
}

/// Names with commas or blanks between them, and those among them that name nothing.
fn parse(text: &str) -> (Names, Vec<&str>) {
    let mut names = Names::default();
    let mut wrong = Vec::new();
    let parts = text.split(|c: char| c == ',' || c.is_whitespace());
    for name in parts.filter(|name| !name.is_empty()) {
        match Row::find_writable(name).or_else(|_| function(name)) {
            _ if name.eq_ignore_ascii_case("all") => names.all = true,
            Ok(row) => drop(names.ids.insert(row.id)),
            Err(_) => wrong.push(name),
        }
    }
    (names, wrong)
}

/// A function whose command has another name.
fn function(name: &str) -> Result<&'static Row, magician::protocol::NameError> {
    if name.eq_ignore_ascii_case("UpdateFirmware") {
        Row::find_writable("FirmwareSwitch")
    } else {
        Err(magician::protocol::NameError)
    }
}

impl Registry {
    /// `MagicianAllow`: allows the named dangerous commands, or `all`, as long as the process lasts. 3 if one is no
    /// command; the others are allowed then too.
    pub fn allow(&self, names: Text) -> c_int {
        let bytes = names.bytes();
        let text = String::from_utf8_lossy(&bytes);
        let (allowed, wrong) = parse(&text);
        {
            let mut named = lock(&self.allowed().named);
            named.all |= allowed.all;
            named.ids.extend(allowed.ids);
        }
        if wrong.is_empty() {
            return Code::NoError as c_int;
        }
        let fault = Fault::invalid(format!("unknown command {}", wrong.join(", ")));
        notice::fault("MagicianAllow", &fault)
    }
}
