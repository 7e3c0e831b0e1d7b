//! Plans as files of our own: JSON that people can read, with one step on a line, so that two of them can be compared.
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
//! Numbers are the shortest decimals that read back the same, NaN and infinities strings. `plan.schema.json` beside the
//! crate's manifest describes all of it; what is read back is the plan that was written.
//!
//! serde_json reads it, as raw values and not as derived types: an error of those names the place where the parser stood, here
//! it is that of the value that is wrong; and what a command takes is said by the protocol's table, which no type says.

mod read;
mod write;

use super::Plan;
use crate::Diagnostic;
use crate::formats::{Parsed, ReadOptions};

/// What the file says it is.
const FORMAT: &str = "magician-plan";
/// The version of plans that wait for nobody and have no parts.
const VERSION: u32 = 1;
/// The version of those with parts or pauses, which a reader of version 1 refuses.
const WITH_PARTS: u32 = 2;

/// The JSON Schema of plan files.
pub const PLAN_SCHEMA: &str = include_str!("../../plan.schema.json");

impl Plan {
    /// Reads what [`write_to`](Self::write_to) has written; or what a person has, in the same form.
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
