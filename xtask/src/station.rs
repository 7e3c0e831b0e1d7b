//! The page of a station's API, made of its tables of methods and routes.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use magician_station::api::{Example, METHODS, Method, Needs};
use magician_station::http::{ROUTES, RouteNeeds};
use serde_json::json;

use crate::options;

const INTRODUCTION: &str = "\
# The API of a station

What `magician serve` answers: [how to use it](STATION.md). `cargo xtask station` writes this page from the tables that the station itself works by;
`/api/v1/openrpc.json` of a running station has the same as an OpenRPC document.

Lengths are mm, angles deg, times s unless a name says otherwise. `arm` may be left out while a station has one arm. *lease*: the method needs the lease of the
arm. *socket*: it is for sessions of a WebSocket, not for single requests. A role may do what the roles before it may: viewer, student, teacher. `-->` is sent and
`<--` is answered, without `jsonrpc` and `id`; a test makes these calls.

## Routes

| method | path | needs | answers |
|---|---|---|---|
";

const ERRORS: &str = "
## Errors

JSON-RPC's own: -32700 no JSON, -32600 no request, -32601 unknown method, -32602 a parameter (`data.param` names it), -32603 a mistake of the station. Beside them:

| code | `data.kind` | meaning | further `data` |
|---|---|---|---|
| -32000 | a kind of the driver: `unreachable`, `alarm`, `port`, `timeout`, .. | the arm or its line | `code`, `step`, `command`, `value`, `limit`, `unit`, `fence`, `from`, `to` where they apply |
| -32001 | `forbidden` | the role does not allow it, or a job that waits is somebody else's | `role`, `needs`; `may`, who may: `owner`, `holder` (of the lease), `teacher` |
| -32002 | `lease` | it needs the lease of the arm, or the lease has ended | `holder`; `method`, which gets it; `free_in_s`, seconds until the lease of a holder without a socket ends |
| -32003 | `busy` | a job or a jog has the arm | `job` or `jog` |
| -32004 | `check-failed` | the arm cannot do all of a program; nothing was sent | `report`, as `run --check --json` |
| -32005 | `dangerous` | it is dangerous or may burn, and `\"yes\": true` was not given | `command`; `danger`: `laser` or `arm` |
| -32006 | `too-many` | more than a socket may send, subscribe to, or wait for, or than there are sessions; too many wrong codes | `limit`; `wait_s` of wrong codes |
| -32007 | `stopped` | a stop came first | `by` |
| -32008 | `frozen` | a teacher has frozen the arm | `arm` |

A socket is closed with 4400 (no good hello), 4401 (no or wrong token), 4403 (token revoked), 4408 (no hello within 5 s, from another machine
2 s, or a newer socket took the place of one that had said none), 4409 (its session has another socket), 4413 (it reads too slowly), 4429 (too many messages for five seconds), 1003 (a binary message), 1007 (no UTF-8), 1009 (more than 1 MiB), 1001 (the station ends), 1013 (tokens cannot be checked now).

Before a station ends it tells every session by the notification `server.ending` with `left_s`: the seconds that who holds an arm has to stop it (within 1 s, by `arm.stop`), to lift its
pen, to restore settings and to give the lease back. Nothing begins any more: -32007, \"the station ends\".

## Methods
";

const OPTIONS: &str = "
## Options of a program

The members of `setup`: `preset`, the name of a preset, and these, which are the flags of the command as well. What is refused has the same sentence there.

";

/// Writes `docs/STATION-API.md`.
pub(crate) fn write(docs: &Path) -> Result<(), Box<dyn Error>> {
    fs::write(docs.join("STATION-API.md"), page())?;
    Ok(())
}

fn page() -> String {
    let mut page = INTRODUCTION.to_owned();
    for route in ROUTES {
        let needs = match route.needs {
            RouteNeeds::Nothing => "nothing".to_owned(),
            RouteNeeds::Hello => "what `session.hello` says".to_owned(),
            RouteNeeds::Method => "what the method needs".to_owned(),
            RouteNeeds::Code => "a code".to_owned(),
            RouteNeeds::Role(role) => role.name().to_owned(),
        };
        let (method, path, about) = (route.method, route.path, route.about);
        let _ = writeln!(page, "| {method} | `{path}` | {needs} | {about} |");
    }
    page += ERRORS;
    for method in METHODS {
        page += &section(method);
    }
    page += OPTIONS;
    page += &options::table();
    page
}

fn section(method: &Method) -> String {
    let mut marks = vec![method.role.name()];
    if method.needs != Needs::Nothing {
        marks.push("lease");
    }
    if method.session {
        marks.push("socket");
    }
    if method.always {
        marks.push("obeyed in any number");
    }
    let (name, about) = (method.name, method.about);
    let mut text = format!("\n### {name}\n\n{about} *{}*\n\n", marks.join(", "));
    for param in method.params {
        let (name, about) = (param.name, param.about);
        let must = if param.required { ", required" } else { "" };
        let kind = param.kind.describe();
        let _ = writeln!(text, "* `{name}` ({kind}{must}): {about}");
    }
    let gap = if method.params.is_empty() { "" } else { "\n" };
    let _ = writeln!(text, "{gap}Answers: {}", method.result);
    if let Some(example) = Example::of(name) {
        text += &shown(name, &example);
    }
    text
}

/// An example as messages, without what all messages have.
fn shown(method: &str, example: &Example) -> String {
    let request = json!({"method": method, "params": example.params});
    let mut text = format!("\n```text\n--> {request}\n");
    if let Some(result) = &example.result {
        let _ = writeln!(text, "<-- {}", json!({"result": result}));
    }
    text += "```\n";
    if let Some(after) = &example.after {
        let _ = writeln!(text, "\nThe id is that of `{after}`.");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_is_what_the_tables_say() {
        let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
        let written = fs::read_to_string(docs.join("STATION-API.md")).unwrap_or_default();
        assert!(written == page(), "cargo xtask station writes it anew");
    }
}
