//! Types of the station's methods for the page (`studio/src/api.ts`), generated from the OpenRPC
//! document.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use serde_json::Value;

const HEAD: &str = "\
// The methods of a station. Written by `cargo xtask studio-api` from the table that the station itself works by.

";

/// Writes `studio/src/api.ts`; with `--check` only compares it.
pub(crate) fn write(words: &[String], root: &Path) -> Result<(), Box<dyn Error>> {
    let path = root.join("studio/src/api.ts");
    let text = typescript()?;
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

fn typescript() -> Result<String, Box<dyn Error>> {
    let document = magician_station::api::openrpc();
    let mut typescript = HEAD.to_owned();
    let components = document["components"]["schemas"].as_object();
    for (name, schema) in components.into_iter().flatten() {
        writeln!(
            typescript,
            "export type {name} = {};\n",
            type_of(schema, 0)?
        )?;
    }
    typescript += "export interface Methods {\n";
    let methods = document["methods"].as_array().into_iter().flatten();
    for method in methods {
        let name = method["name"].as_str().unwrap_or_default();
        let summary = method["summary"].as_str().unwrap_or_default();
        writeln!(
            typescript,
            "  /** {summary} */\n  {name:?}: {{\n    params: {{"
        )?;
        for param in method["params"].as_array().into_iter().flatten() {
            let optional_mark = if param["required"] == true { "" } else { "?" };
            let name = param["name"].as_str().unwrap_or_default();
            let kind = type_of(&param["schema"], 6)?;
            writeln!(typescript, "      {name}{optional_mark}: {kind};")?;
        }
        let result = type_of(&method["result"]["schema"], 4)?;
        writeln!(typescript, "    }};\n    result: {result};\n  }};")?;
    }
    typescript += "}\n\n/** What a station tells by itself: parameters by notification. */\nexport interface Notifications {\n";
    for row in document["x-notifications"].as_array().into_iter().flatten() {
        let (name, summary) = (&row["name"], row["summary"].as_str().unwrap_or_default());
        let kind = type_of(&row["params"], 2)?;
        writeln!(typescript, "  /** {summary} */\n  {name}: {kind};")?;
    }
    typescript += "}\n";
    Ok(typescript)
}

/// Returns a JSON schema as a TypeScript type.
fn type_of(schema: &Value, indent: usize) -> Result<String, Box<dyn Error>> {
    let join_types = |kinds: &[Value], between: &str| {
        let kinds = kinds.iter().map(|kind| type_of(kind, indent));
        Ok::<_, Box<dyn Error>>(kinds.collect::<Result<Vec<_>, _>>()?.join(between))
    };
    if let Some(reference) = schema["$ref"].as_str() {
        return Ok(reference.rsplit('/').next().unwrap_or_default().to_owned());
    }
    if let Some(choices) = schema["enum"].as_array() {
        let choices = choices.iter().map(Value::to_string);
        return Ok(choices.collect::<Vec<_>>().join(" | "));
    }
    if let Some(constant) = schema.get("const") {
        return Ok(constant.to_string());
    }
    for key in ["oneOf", "anyOf"] {
        if let Some(kinds) = schema[key].as_array() {
            return join_types(kinds, " | ");
        }
    }
    let kinds: Vec<_> = match &schema["type"] {
        Value::String(kind) => vec![kind.as_str()],
        Value::Array(kinds) => kinds.iter().filter_map(Value::as_str).collect(),
        _ => vec!["unknown"],
    };
    let mut parts = Vec::new();
    for kind in kinds {
        parts.push(match (kind, &schema["items"]) {
            ("integer" | "number", _) => "number".to_owned(),
            ("array", Value::Null) => "unknown[]".to_owned(),
            ("array", Value::Array(items)) => format!("[{}]", join_types(items, ", ")?),
            ("array", items) => match type_of(items, indent)? {
                item if item.contains(' ') => format!("Array<{item}>"),
                item => format!("{item}[]"),
            },
            ("object", _) => object_type(schema, indent)?,
            (plain, _) => plain.to_owned(),
        });
    }
    Ok(parts.join(" | "))
}

fn object_type(schema: &Value, indent: usize) -> Result<String, Box<dyn Error>> {
    let Some(members) = schema["properties"].as_object() else {
        let member_type = type_of(&schema["additionalProperties"], indent)?;
        return Ok(format!("Record<string, {member_type}>"));
    };
    let mut text = "{\n".to_owned();
    let pad = " ".repeat(indent + 2);
    let required = schema["required"].as_array().map_or(&[][..], Vec::as_slice);
    for (name, member) in members {
        let is_required = required.iter().any(|known| known == name);
        let optional_mark = if is_required { "" } else { "?" };
        writeln!(
            text,
            "{pad}{name}{optional_mark}: {};",
            type_of(member, indent + 2)?
        )?;
    }
    write!(text, "{}}}", " ".repeat(indent))?;
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_agree_with_the_station_table() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../studio/src/api.ts");
        let written = fs::read_to_string(path).unwrap_or_default();
        let text = typescript().unwrap();
        assert!(written == text, "cargo xtask studio-api writes it anew");
    }
}
