//! The station's methods as types of the page: `studio/src/api.ts`, made of the OpenRPC document.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use serde_json::Value;

const HEAD: &str = "\
// The methods of a station. Written by `cargo xtask studio-api` from the table that the station itself works by.

export interface Holder {
  session: string;
  name: string;
}

";

/// Members that are null in every example, and what they are otherwise.
const NULL_IN_EXAMPLES: [(&str, &str); 13] = [
    ("box", "Record<string, [number, number]> | null"),
    ("drawn_mm", "number | null"),
    ("ended", "number | null"),
    ("error", "{ message: string } | null"),
    ("holder", "Holder | null"),
    ("job", "string | null"),
    ("jog", "string | null"),
    ("l", "[number, number] | null"),
    ("part", "string | null"),
    ("power", "number | null"),
    ("rail", "number | null"),
    ("reason", "string | null"),
    ("speed", "number | null"),
];
/// The same, of numbers that are null in some.
const UNKNOWN_NUMBERS: [&str; 2] = ["seconds_left", "travel_mm"];
/// Members that are null in no example, and may be.
const ALSO_NULL: [&str; 2] = ["fence", "floor"];

/// Writes `studio/src/api.ts`; with `--check` only compares it.
pub(crate) fn write(words: &[String], root: &Path) -> Result<(), Box<dyn Error>> {
    let path = root.join("studio/src/api.ts");
    let text = text()?;
    match words {
        [] => fs::write(path, text)?,
        [check] if check == "--check" => {
            if fs::read_to_string(path)? != text {
                return Err("studio/src/api.ts is stale: cargo xtask studio-api".into());
            }
        }
        _ => return Err("studio-api takes --check or nothing".into()),
    }
    Ok(())
}

fn text() -> Result<String, Box<dyn Error>> {
    let document = magician_station::api::openrpc();
    let mut text = HEAD.to_owned();
    for name in ["State", "Job"] {
        let schema = &document["components"]["schemas"][name];
        writeln!(text, "export type {name} = {};\n", type_of(schema, "", 0)?)?;
    }
    text += "export interface Methods {\n";
    let methods = document["methods"].as_array().into_iter().flatten();
    for method in methods {
        let name = method["name"].as_str().unwrap_or_default();
        let about = method["summary"].as_str().unwrap_or_default();
        writeln!(text, "  /** {about} */\n  {name:?}: {{\n    params: {{")?;
        for param in method["params"].as_array().into_iter().flatten() {
            let mark = if param["required"] == true { "" } else { "?" };
            let name = param["name"].as_str().unwrap_or_default();
            let kind = type_of(&param["schema"], name, 6)?;
            writeln!(text, "      {name}{mark}: {kind};")?;
        }
        let result = type_of(&method["result"]["schema"], "", 4)?;
        writeln!(text, "    }};\n    result: {result};\n  }};")?;
    }
    text += "}\n";
    Ok(text)
}

/// A JSON schema as a type, for a member of this name.
fn type_of(schema: &Value, name: &str, indent: usize) -> Result<String, Box<dyn Error>> {
    if let Some(reference) = schema["$ref"].as_str() {
        return Ok(reference.rsplit('/').next().unwrap_or_default().to_owned());
    }
    if name == "holder" {
        return Ok("Holder | null".to_owned());
    }
    if let Some(choices) = schema["enum"].as_array() {
        let choices = choices.iter().map(Value::to_string);
        return Ok(choices.collect::<Vec<_>>().join(" | "));
    }
    for key in ["oneOf", "anyOf"] {
        if let Some(kinds) = schema[key].as_array() {
            let kinds = kinds.iter().map(|kind| type_of(kind, "", indent));
            return Ok(kinds.collect::<Result<Vec<_>, _>>()?.join(" | "));
        }
    }
    let kinds: Vec<_> = match &schema["type"] {
        Value::String(kind) => vec![kind.as_str()],
        Value::Array(kinds) => kinds.iter().filter_map(Value::as_str).collect(),
        _ => {
            if UNKNOWN_NUMBERS.contains(&name) {
                return Ok("number | null".to_owned());
            }
            let known = NULL_IN_EXAMPLES.iter().find(|(known, _)| *known == name);
            return match (known, name) {
                (Some((_, kind)), _) => Ok((*kind).to_owned()),
                (None, "") => Ok("unknown".to_owned()),
                (None, _) => Ok("null".to_owned()),
            };
        }
    };
    let mut parts = Vec::new();
    for kind in kinds {
        parts.push(match kind {
            "integer" | "number" => "number".to_owned(),
            "array" => {
                let items = &schema["items"];
                let item = match items {
                    Value::Null => "unknown".to_owned(),
                    items => type_of(items, "", indent)?,
                };
                if item.contains(' ') {
                    format!("Array<{item}>")
                } else {
                    format!("{item}[]")
                }
            }
            "object" => object(schema, indent)?,
            plain => plain.to_owned(),
        });
    }
    Ok(parts.join(" | "))
}

fn object(schema: &Value, indent: usize) -> Result<String, Box<dyn Error>> {
    let Some(members) = schema["properties"].as_object() else {
        return Ok("Record<string, unknown>".to_owned());
    };
    let mut text = "{\n".to_owned();
    let pad = " ".repeat(indent + 2);
    for (name, member) in members {
        let mut kind = type_of(member, name, indent + 2)?;
        if ALSO_NULL.contains(&name.as_str()) {
            kind += " | null";
        } else if name == "name" && !members.contains_key("bias") {
            // Of all that has a name only a tool may have none.
            "string".clone_into(&mut kind);
        }
        writeln!(text, "{pad}{name}: {kind};")?;
    }
    write!(text, "{}}}", " ".repeat(indent))?;
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_types_are_those_of_the_stations_table() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../studio/src/api.ts");
        let written = fs::read_to_string(path).unwrap_or_default();
        let text = text().unwrap();
        assert!(written == text, "cargo xtask studio-api writes it anew");
    }
}
