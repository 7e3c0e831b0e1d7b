//! Journal: one line for each request that moves, sets or stops something or changes rights.

use serde_json::Value;

/// Line of the journal. Never contains tokens, codes, or programs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JournalLine {
    /// Time of the answer, Unix seconds.
    pub t: f64,
    /// Id of the session. `None` if there is no session.
    pub session: Option<String>,
    /// Name of the session.
    pub name: String,
    /// Role of the session.
    pub role: Option<&'static str>,
    /// Address of the client.
    pub peer: String,
    /// Name of the arm.
    pub arm: Option<String>,
    /// Method, or `session.end` for the end of a socket.
    pub method: String,
    /// Parameters without secrets.
    pub params: Value,
    /// `ok`, or the kind of the error.
    pub result: String,
    /// Duration from request to answer, ms.
    pub ms: f64,
}
