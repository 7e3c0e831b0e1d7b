//! What programs have called, and what was odd about it.

use std::collections::BTreeMap;

use serde_json::{Value, json};

/// Programs that are told apart; later ones are counted together.
const CLIENTS: usize = 64;
/// Names that are told apart for each.
const NAMES: usize = 400;

/// A call that was answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Noted {
    /// `Magician.SetPTPCmd`.
    pub method: String,
    /// Parameters that the call does not have, or has under another name.
    pub odd: Vec<String>,
    /// The number of its error.
    pub error: Option<i32>,
}

#[derive(Clone, Debug, Default)]
struct Counts {
    calls: BTreeMap<String, u64>,
    odd: BTreeMap<String, u64>,
    errors: BTreeMap<String, u64>,
}

/// Calls, parameters that are not of the table, and errors, counted by client. It holds no values that programs sent.
#[derive(Clone, Debug, Default)]
pub struct LinkReport {
    clients: BTreeMap<String, Counts>,
}

impl LinkReport {
    /// Counts a call of a client.
    pub fn count(&mut self, client: &str, noted: &Noted) {
        let known = self.clients.contains_key(client) || self.clients.len() < CLIENTS;
        let client = if known { client } else { "others" };
        let counts = self.clients.entry(client.to_owned()).or_default();
        add(&mut counts.calls, noted.method.clone());
        for name in &noted.odd {
            add(&mut counts.odd, format!("{}.{name}", noted.method));
        }
        if let Some(error) = noted.error {
            add(&mut counts.errors, format!("{} {error}", noted.method));
        }
    }

    /// The report as `GET /api/v1/link` has it: `{clients: [{client, calls, unknown_params, errors}]}`.
    #[must_use]
    pub fn to_value(&self) -> Value {
        let client = |(name, counts): (&String, &Counts)| json!({"client": name, "calls": counts.calls, "unknown_params": counts.odd, "errors": counts.errors});
        json!({"clients": self.clients.iter().map(client).collect::<Vec<_>>()})
    }
}

/// Names come from outside: there may be no end of them.
fn add(counts: &mut BTreeMap<String, u64>, name: String) {
    let known = counts.contains_key(&name) || counts.len() < NAMES;
    let name = if known { name } else { "others".to_owned() };
    *counts.entry(name).or_default() += 1;
}
