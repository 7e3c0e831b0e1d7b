//! Page of the station's API, generated from its tables: routes, methods, notifications, types.

pub(crate) mod python;
mod wire;

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use magician_station::api::{Example, Kind, METHODS, Method, Needs};
use magician_station::http::{ROUTES, RouteNeeds};
use serde_json::json;

use crate::options;

const INTRODUCTION: &str = "\
# The API of a station

Methods, notifications and types of `magician serve` ([how to use it](STATION.md)), written by
`cargo xtask station` from the station's own tables. `/api/v1/openrpc.json` of a running station has
the same as an OpenRPC document, with notifications in `x-notifications`, events in `x-events` and
the frame in `x-frame`.

Lengths are mm, angles deg, times s unless a name says otherwise. `arm` may be left out while a
station has one arm. *lease*: the method needs the lease of the arm. *socket*: for sessions of a
WebSocket, not for single requests. A role may do what the roles before it may: viewer, student,
teacher. `-->` is sent and `<--` is answered, without `jsonrpc` and `id`; a test makes these calls.

## Routes

| method | path | needs | answers |
|---|---|---|---|
";

const OPTIONS: &str = "
## Options of a program

The members of `setup`: `preset`, the name of a preset, and these, which are the flags of the command as well. What is refused has the same sentence there.

";

/// Writes `docs/reference/STATION-API.md` and the types for Python.
pub(crate) fn write(root: &Path) -> Result<(), Box<dyn Error>> {
    fs::write(root.join("docs/reference/STATION-API.md"), page())?;
    python::write(root)
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
    page += &wire::errors();
    page += &wire::sections();
    page += "\n## Methods\n";
    for method in METHODS {
        page += &section(method);
    }
    page += OPTIONS;
    page += &options::table();
    page += &wire::types();
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
        let kind = match param.kind {
            Kind::Object(name) => format!("an object: {}", type_link(name)),
            Kind::Objects(name) => format!("an array of objects: {}", type_link(name)),
            kind => kind.describe(),
        };
        let _ = writeln!(text, "* `{name}` ({kind}{must}): {about}");
    }
    let gap = if method.params.is_empty() { "" } else { "\n" };
    let _ = writeln!(text, "{gap}Answers: {}", method.result);
    if let Some(example) = Example::of(name) {
        text += &example_text(name, &example);
    }
    text
}

/// Returns the name of a type as a link to its description.
fn type_link(name: &str) -> String {
    match name {
        "Setup" => "[Setup](#options-of-a-program)".to_owned(),
        "Plan" => "as in plan files".to_owned(),
        "Fields" => "fields by their names in [the protocol](PROTOCOL.md)".to_owned(),
        name => format!("[{name}](#{})", name.to_lowercase()),
    }
}

/// Returns an example as messages, without the members that all messages have.
fn example_text(method: &str, example: &Example) -> String {
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
    fn page_agrees_with_the_tables() {
        let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
        let written = fs::read_to_string(docs.join("reference/STATION-API.md")).unwrap_or_default();
        assert!(written == page(), "cargo xtask station writes it anew");
    }
}
