//! Who did what: a line for each request that counts.

use serde_json::Value;

/// A line of the journal. It never holds a token, a code, or bytes of a program.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JournalLine {
    /// When, Unix seconds.
    pub t: f64,
    /// The session, if there is one.
    pub session: Option<String>,
    /// Its name.
    pub name: String,
    /// Its role.
    pub role: Option<&'static str>,
    /// Its address.
    pub peer: String,
    /// The arm that is meant.
    pub arm: Option<String>,
    /// The method; `session.end` for the end of a socket.
    pub method: String,
    /// Its parameters, without secrets.
    pub params: Value,
    /// `ok`, or the kind of the error.
    pub result: String,
    /// How long it took, ms.
    pub ms: f64,
}
