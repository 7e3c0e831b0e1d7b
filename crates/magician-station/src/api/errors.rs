//! Table of errors: codes, kinds, and the members of their `data`.

use magician::ErrorKind;
use serde_json::{Value, json};

use super::types::ERROR_DATA;
use super::{Method, Needs, Role, RpcError};

/// Error of the API.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ErrorRow {
    /// Code.
    pub code: i32,
    /// `data.kind`. Empty if the error has no kind.
    pub kind: &'static str,
    /// Meaning.
    pub about: &'static str,
    /// Further members of `data`, which may be missing.
    pub data: &'static [&'static str],
}

const fn error(
    code: i32,
    kind: &'static str,
    about: &'static str,
    data: &'static [&'static str],
) -> ErrorRow {
    ErrorRow {
        code,
        kind,
        about,
        data,
    }
}

/// Members of `data` that any error may have: template and values of its sentence.
const SENTENCE: [&str; 2] = ["template", "values"];

/// Members of `data` of errors from the driver, and further ones.
macro_rules! of_arms {
    ($($more:literal),*) => {
        &[
            "code", "step", "command", "value", "limit", "unit", "fence", "from", "to", "remedies",
            "arms" $(, $more)*
        ]
    };
}

const fn of_arm(kind: ErrorKind, about: &'static str) -> ErrorRow {
    error(RpcError::ARM, kind.name(), about, of_arms!())
}

/// All errors, in documentation order. Those with code -32000 differ by kind.
pub static ERRORS: &[ErrorRow] = &[
    error(RpcError::PARSE, "", "the message is not JSON", &[]),
    error(
        RpcError::REQUEST,
        "",
        "the message is not a request, or not allowed here",
        &["method", "command"],
    ),
    error(RpcError::METHOD, "", "unknown method", &[]),
    error(
        RpcError::PARAMS,
        "",
        "invalid parameter",
        &["param", "row", "method"],
    ),
    error(RpcError::INTERNAL, "", "internal error of the station", &[]),
    error(
        RpcError::ARM,
        ErrorKind::InvalidInput.name(),
        "invalid request, or the quota of the library is exhausted",
        of_arms!("quota", "used"),
    ),
    of_arm(
        ErrorKind::Unreachable,
        "out of reach, or forbidden by the fence",
    ),
    of_arm(ErrorKind::Port, "the line to the arm is lost"),
    of_arm(ErrorKind::Timeout, "the arm did not answer in time"),
    error(
        RpcError::ARM,
        ErrorKind::Unexpected.name(),
        "unexpected answer or position of the arm",
        &[
            "code", "step", "command", "from", "to", "remedies", "arms", "expected", "pose",
        ],
    ),
    of_arm(
        ErrorKind::Unsupported,
        "not supported by this station or this arm",
    ),
    of_arm(
        ErrorKind::QueueFull,
        "the arm's queue is full; nothing was done",
    ),
    of_arm(ErrorKind::Alarm, "an alarm holds the queue"),
    of_arm(
        ErrorKind::Uncertain,
        "a command may or may not have been executed; `from` to `to` are the queue indices in doubt",
    ),
    error(
        RpcError::ARM,
        ErrorKind::Closed.name(),
        "the connection was closed, a stop came first, or the disk could not store it",
        of_arms!("reason"),
    ),
    error(
        RpcError::FORBIDDEN,
        "forbidden",
        "not allowed for the role, or a queued job of another person; nothing is allowed before hello",
        &["role", "needs", "may", "arm", "until"],
    ),
    error(
        RpcError::LEASE,
        "lease",
        "the lease of the arm is required, or has ended; `method` acquires it, `free_in_s` is the time until the lease of a holder without a socket ends",
        &["holder", "method", "free_in_s"],
    ),
    error(
        RpcError::BUSY,
        "busy",
        "a job, a jog or a recording has the arm",
        &["job", "jog", "recording"],
    ),
    error(
        RpcError::CHECK_FAILED,
        "check-failed",
        "the arm cannot run the whole program; nothing was sent",
        &["report", "remedies", "step"],
    ),
    error(
        RpcError::CHANGED,
        "changed",
        "the program differs from that of `digest`; nothing was sent",
        &["digest"],
    ),
    error(
        RpcError::DANGEROUS,
        "dangerous",
        "dangerous, or may burn: requires `\"yes\": true`",
        &["command", "danger"],
    ),
    error(
        RpcError::TOO_MANY,
        "too-many",
        "too many messages, subscriptions, pending requests or sessions; too many wrong codes",
        &["limit", "wait_s"],
    ),
    error(
        RpcError::STOPPED,
        "stopped",
        "a stop came first, or the station ends",
        &["by"],
    ),
    error(
        RpcError::FROZEN,
        "frozen",
        "a teacher has frozen the arm",
        &["arm"],
    ),
];

impl ErrorRow {
    /// Returns the row of an error. `None` if the table lacks it.
    #[must_use]
    pub fn of(error: &RpcError) -> Option<&'static Self> {
        let kind = error.data.get("kind").and_then(Value::as_str);
        let kind = kind.unwrap_or_default();
        { ERRORS.iter() }.find(|row| row.code == error.code && row.kind == kind)
    }

    /// Returns the name of the OpenRPC component.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match (self.kind, self.code) {
            ("", RpcError::PARSE) => "parse",
            ("", RpcError::REQUEST) => "request",
            ("", RpcError::METHOD) => "method",
            ("", RpcError::PARAMS) => "params",
            ("", _) => "internal",
            (kind, _) => kind,
        }
    }

    /// Returns the error in OpenRPC. `x-data` is the schema of `data`.
    pub(super) fn to_value(self) -> Value {
        let mut properties = serde_json::Map::new();
        let mut required = Vec::new();
        if !self.kind.is_empty() {
            properties.insert(
                "kind".to_owned(),
                json!({"type": "string", "enum": [self.kind]}),
            );
            required.push("kind");
        }
        for name in self.data.iter().chain(&SENTENCE) {
            let member = ERROR_DATA.iter().find(|member| member.name == *name);
            let schema = member.map_or_else(|| json!({}), |member| member.schema());
            properties.insert((*name).to_owned(), schema);
        }
        let data = json!({"type": "object", "properties": properties, "required": required});
        json!({"code": self.code, "message": self.about, "x-data": data})
    }

    /// True if the method may answer with this error, judged by the method's row.
    pub(super) fn is_of(&self, method: &Method) -> bool {
        let takes = |name: &str| method.params.iter().any(|param| param.name == name);
        let leased = method.needs != Needs::Nothing;
        // A job and a jog belong to an arm, so their methods meet its errors too.
        let of_arm = takes("arm") || takes("job") || takes("jog");
        match self.code {
            // A method of the table exists, and JSON is parsed before the method is known.
            RpcError::PARSE | RpcError::METHOD => false,
            RpcError::PARAMS => !method.params.is_empty(),
            RpcError::ARM => {
                of_arm || method.name.starts_with("program.") || method.name.starts_with("preset.")
            }
            RpcError::FORBIDDEN => {
                method.role != Role::Viewer || takes("set") || method.name == "session.hello"
            }
            RpcError::LEASE => leased || method.name.starts_with("lease."),
            RpcError::BUSY => leased || method.name.starts_with("record.") || takes("set"),
            RpcError::CHECK_FAILED => leased && (takes("setup") || takes("approach")),
            RpcError::CHANGED => takes("digest") || method.name == "job.resume",
            RpcError::DANGEROUS => takes("yes"),
            RpcError::STOPPED | RpcError::FROZEN => leased || method.name.starts_with("lease."),
            // Codes that any method may answer with.
            _ => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use magician::ErrorCode;

    use super::*;

    #[test]
    fn error_rows_cover_exactly_the_defined_codes() {
        for code in RpcError::CODES {
            let rows: Vec<_> = ERRORS.iter().filter(|row| row.code == code).collect();
            assert!(!rows.is_empty(), "{code}");
            if code != RpcError::ARM {
                let error = RpcError::new(code, "");
                assert_eq!(ErrorRow::of(&error), Some(rows[0]), "{code}");
            }
        }
        assert!(ERRORS.iter().all(|row| RpcError::CODES.contains(&row.code)));
        for code in ErrorCode::ALL {
            let kind = code.kind();
            assert!(ErrorRow::of(&RpcError::arm(kind, "")).is_some(), "{kind}");
        }
        for row in ERRORS {
            for name in row.data {
                assert!(
                    ERROR_DATA.iter().any(|member| member.name == *name),
                    "{name}"
                );
            }
        }
    }
}
