//! The methods as an OpenRPC document.

use serde_json::{Value, json};

use super::{METHODS, Method, Needs};

/// The document: every method with its parameters, from the table.
#[must_use]
pub fn openrpc() -> Value {
    let methods: Vec<_> = METHODS.iter().map(method).collect();
    json!({
        "openrpc": "1.3.2",
        "info": {
            "title": "Station of Dobot Magician arms",
            "version": "1",
            "license": {"name": "MIT OR Apache-2.0"},
        },
        "methods": methods,
    })
}

fn method(method: &Method) -> Value {
    let params = method.params.iter().map(|param| {
        json!({
            "name": param.name,
            "description": param.about,
            "required": param.required,
            "schema": param.kind.schema(),
        })
    });
    json!({
        "name": method.name,
        "summary": method.about,
        "paramStructure": "by-name",
        "params": params.collect::<Vec<_>>(),
        "result": {"name": "result", "description": method.result, "schema": {}},
        "x-role": method.role.name(),
        "x-lease": method.needs != Needs::Nothing,
        "x-session": method.session,
    })
}
