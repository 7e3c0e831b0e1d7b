//! Plans as files: JSON for people, one step per line, so that two files can be compared.
//!
//! ```text
//! {"format":"magician-plan","version":1,"title":"house","tool":"pen","surface":{"height":-60,"slope":[0,0]},"steps":[
//! {"command":"CPParams","values":{"plan_acc":100,"junction_vel":40,"acc_or_period":100,"real_time_track":0}},
//! {"move":[220,0,-40,0],"by":"line","at":[3,5,20],"name":"outline"},
//! {"path":[230,0,-60],"at":[3,5,20],"name":"outline"},
//! {"wait":0.5}
//! ]}
//! ```
//!
//! A plan with a `part` or a `pause` has version 2.
//!
//! Reading a written file returns the same plan: numbers are the shortest decimals that read back
//! bit for bit, and NaN and infinities are strings. `plan.schema.json` beside the crate's manifest
//! describes the format.
//!
//! The reader uses `serde_json`'s raw values instead of derived types for two reasons. An error of
//! a derived type points to where the parser stopped, not to the value that is wrong. And the
//! fields of a command are defined by the protocol's table, which no Rust type lists.

mod read;
mod write;

use super::Plan;
use crate::Diagnostic;
use crate::formats::{Parsed, ReadOptions};

/// Value of `format`.
const FORMAT: &str = "magician-plan";
/// Version of plans without parts and pauses.
const VERSION: u32 = 1;
/// Version of plans with parts or pauses. A reader of version 1 must refuse them, because it would
/// run on where the plan waits for a person.
const VERSION_WITH_PARTS: u32 = 2;

/// JSON Schema of plan files.
pub const PLAN_SCHEMA: &str = include_str!("../../plan.schema.json");

impl Plan {
    /// Reads a plan that [`write_to`](Self::write_to) or a person has written.
    ///
    /// ```
    /// use magician_formats::Plan;
    ///
    /// let text = r#"{"format":"magician-plan","version":1,"steps":[
    /// {"move":[220,0,50,0],"by":"jump"},
    /// {"move":[220,0,50],"by":"line"}
    /// ]}"#;
    /// let diagnostic = Plan::from_json(text.as_bytes()).unwrap_err();
    /// assert_eq!(diagnostic.to_string(), "line 3, column 9: 'move' takes 4 numbers, x, y, z, r, and these are 3");
    /// ```
    ///
    /// # Errors
    /// The first [`Diagnostic`], with line and column, and what would be right.
    pub fn from_json(bytes: &[u8]) -> Result<Self, Diagnostic> {
        read::plan(bytes)
    }
}

pub(crate) fn read(bytes: &[u8], options: &ReadOptions) -> Result<Parsed<Plan>, Diagnostic> {
    let mut plan = Plan::from_json(bytes)?;
    if plan.title.is_empty() {
        plan.title.clone_from(&options.title);
    }
    Ok(Parsed {
        content: plan,
        notes: Vec::new(),
    })
}
