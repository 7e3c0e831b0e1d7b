//! Counts of calls, unknown parameters and errors, by program.

use std::collections::BTreeMap;

use serde_json::{Value, json};

/// Most programs that are counted separately. Further ones share an entry, so that memory is
/// bounded.
const MAX_CLIENTS: usize = 64;
/// Most names per program that are counted separately.
const MAX_NAMES: usize = 400;

/// Call that was answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AnsweredCall {
    /// Name, such as `Magician.SetPTPCmd`.
    pub method: String,
    /// Parameters that the call does not have, or has under another name.
    pub unknown_params: Vec<String>,
    /// Error number. `None` for a success.
    pub error: Option<i32>,
}

#[derive(Clone, Debug, Default)]
struct Counts {
    calls: BTreeMap<String, u64>,
    unknown_params: BTreeMap<String, u64>,
    errors: BTreeMap<String, u64>,
}

/// Calls, unknown parameters and errors, counted by program. Contains no values that programs sent.
#[derive(Clone, Debug, Default)]
pub struct LinkReport {
    clients: BTreeMap<String, Counts>,
}

impl LinkReport {
    /// Counts a call of a program.
    pub fn count(&mut self, client: &str, answered: &AnsweredCall) {
        let known = self.clients.contains_key(client) || self.clients.len() < MAX_CLIENTS;
        // A program can choose any number of names.
        let client = if known { client } else { "others" };
        let counts = self.clients.entry(client.to_owned()).or_default();
        add(&mut counts.calls, answered.method.clone());
        for name in &answered.unknown_params {
            add(
                &mut counts.unknown_params,
                format!("{}.{name}", answered.method),
            );
        }
        if let Some(error) = answered.error {
            add(&mut counts.errors, format!("{} {error}", answered.method));
        }
    }

    /// Returns the report of `GET /api/v1/link`: `{clients: [{client, calls, unknown_params,
    /// errors}]}`.
    #[must_use]
    pub fn to_value(&self) -> Value {
        let client = |(name, counts): (&String, &Counts)| json!({"client": name, "calls": counts.calls, "unknown_params": counts.unknown_params, "errors": counts.errors});
        json!({"clients": self.clients.iter().map(client).collect::<Vec<_>>()})
    }
}

/// Increments a counter. Names come from programs, so their number is bounded.
fn add(counts: &mut BTreeMap<String, u64>, name: String) {
    let known = counts.contains_key(&name) || counts.len() < MAX_NAMES;
    let name = if known { name } else { "others".to_owned() };
    *counts.entry(name).or_default() += 1;
}
