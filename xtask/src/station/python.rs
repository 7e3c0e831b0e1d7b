//! Types of a station's messages for Python, generated from the OpenRPC document.

use std::collections::BTreeSet;
use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use serde_json::{Map, Value, json};

/// Module of the Python package.
const FILE: &str = "crates/magician-py/python/magician/station_types.py";

const HEAD: &str = r#""""Types of the messages of a station, for programs that talk JSON-RPC to it: `cargo xtask station` writes this
module from the tables that the station itself works by. docs/reference/STATION-API.md says what they mean.

`XxxYyyParams` and `XxxYyyResult` are of the method `xxx.yyy`, `XxxYyyNotification` are parameters of a notification.
"""

from __future__ import annotations

from typing import Literal, TypedDict, Union

"#;

/// Words that cannot be names of class members.
const KEYWORDS: [&str; 35] = [
    "False", "None", "True", "and", "as", "assert", "async", "await", "break", "class", "continue",
    "def", "del", "elif", "else", "except", "finally", "for", "from", "global", "if", "import",
    "in", "is", "lambda", "nonlocal", "not", "or", "pass", "raise", "return", "try", "while",
    "with", "yield",
];

/// Writes the module.
pub(super) fn write(root: &Path) -> Result<(), Box<dyn Error>> {
    fs::write(root.join(FILE), text())?;
    Ok(())
}

/// Module under construction: classes in the order of their first use, then the unions.
#[derive(Default)]
struct Module {
    classes: String,
    aliases: String,
    names: BTreeSet<String>,
}

fn text() -> String {
    let document = magician_station::api::openrpc();
    let mut module = Module::default();
    let none = Map::new();
    let components = document["components"]["schemas"].as_object();
    for (name, schema) in components.unwrap_or(&none) {
        module.add_named(name, schema);
    }
    for method in document["methods"].as_array().into_iter().flatten() {
        let name = camel(method["name"].as_str().unwrap_or_default());
        let params = method["params"].as_array().into_iter().flatten();
        let mut properties = Map::new();
        let mut required = Vec::new();
        for param in params {
            let param_name = param["name"].as_str().unwrap_or_default();
            let mut schema = param["schema"].clone();
            schema["description"] = param["description"].clone();
            properties.insert(param_name.to_owned(), schema);
            if param["required"] == true {
                required.push(param_name);
            }
        }
        let params = json!({"type": "object", "properties": properties, "required": required});
        module.add_named(&format!("{name}Params"), &params);
        if method["x-notification"] == false {
            module.add_named(&format!("{name}Result"), &method["result"]["schema"]);
        }
    }
    for row in document["x-notifications"].as_array().into_iter().flatten() {
        let name = camel(row["name"].as_str().unwrap_or_default());
        module.add_named(&format!("{name}Notification"), &row["params"]);
    }
    let mut all = String::from("__all__ = [\n");
    for name in module.names.iter().filter(|name| !name.starts_with('_')) {
        let _ = writeln!(all, "    \"{name}\",");
    }
    all += "]\n";
    format!("{HEAD}{all}{}\n\n{}", module.classes, module.aliases)
}

/// Converts `arm.clear_alarms` into `ArmClearAlarms`.
fn camel(name: &str) -> String {
    let words = name.split(['.', '_']).filter(|word| !word.is_empty());
    words
        .map(|word| word[..1].to_uppercase() + &word[1..])
        .collect()
}

/// Returns a text with a capital letter and a full stop.
fn sentence(text: &str) -> String {
    let text = text
        .trim_end_matches('.')
        .replace('\\', "\\\\")
        .replace('"', "'");
    let mut letters = text.chars();
    match letters.next() {
        Some(first) => format!("{}{}.", first.to_uppercase(), letters.as_str()),
        None => text,
    }
}

/// Returns the description of a class that has none in the document.
fn class_description(name: &str) -> &'static str {
    match name {
        name if name.ends_with("Params") => "Parameters of a method",
        name if name.ends_with("Result") => "Result of a method",
        name if name.ends_with("Notification") => "Parameters of a notification",
        _ => "Part of a message",
    }
}

impl Module {
    /// Adds a schema under a name.
    fn add_named(&mut self, name: &str, schema: &Value) {
        self.names.insert(name.to_owned());
        if schema["type"] == "object" && schema["properties"].is_object() {
            self.add_class(name, schema);
            return;
        }
        let kind = self.type_of(schema, &format!("{name}Item"));
        let _ = writeln!(self.aliases, "{name} = {kind}");
    }

    /// Adds an object as a class. Optional members go into a class that derives from one with the
    /// required members.
    fn add_class(&mut self, name: &str, schema: &Value) {
        let required: Vec<_> = { schema["required"].as_array().into_iter().flatten() }
            .filter_map(Value::as_str)
            .collect();
        let mut parts: [Vec<(String, String, String)>; 2] = Default::default();
        for (member, of) in schema["properties"].as_object().into_iter().flatten() {
            let kind = self.type_of(of, &format!("{name}{}", camel(member)));
            let about = sentence(of["description"].as_str().unwrap_or_default());
            let is_there = required.contains(&member.as_str());
            parts[usize::from(!is_there)].push((member.clone(), kind, about));
        }
        let [there, perhaps] = &parts;
        let about = schema["description"]
            .as_str()
            .unwrap_or_else(|| class_description(name));
        match (there.is_empty(), perhaps.is_empty()) {
            (_, true) => self.write_class(name, "TypedDict", there, about),
            (true, false) => self.write_class(name, "TypedDict, total=False", perhaps, about),
            (false, false) => {
                let base = format!("_{name}");
                self.write_class(&base, "TypedDict", there, "");
                self.write_class(name, &format!("{base}, total=False"), perhaps, about);
            }
        }
    }

    fn write_class(
        &mut self,
        name: &str,
        base: &str,
        members: &[(String, String, String)],
        about: &str,
    ) {
        let text = &mut self.classes;
        let odd: Vec<_> = { members.iter() }
            .filter(|(member, ..)| KEYWORDS.contains(&member.as_str()))
            .collect();
        // Members whose names are no identifiers need the functional form of `TypedDict`.
        let base = if odd.is_empty() {
            base.to_owned()
        } else {
            let total = if base.contains("total=False") {
                ", total=False"
            } else {
                ""
            };
            let under = format!("_{name}Words");
            let _ = write!(text, "\n\n{under} = TypedDict(\n    \"{under}\",\n    {{");
            for (member, kind, _) in &odd {
                let _ = write!(text, "\"{member}\": \"{kind}\", ");
            }
            let _ = write!(text, "}}{total},\n)");
            match base.strip_prefix("TypedDict") {
                Some(rest) => format!("{under}{rest}"),
                None => format!("{under}, {base}"),
            }
        };
        let _ = write!(text, "\n\nclass {name}({base}):\n");
        if !about.is_empty() {
            let _ = writeln!(text, "    \"\"\"{}\"\"\"\n", sentence(about));
        }
        let mut is_empty = about.is_empty();
        for (member, kind, about) in members {
            if KEYWORDS.contains(&member.as_str()) {
                continue;
            }
            is_empty = false;
            let _ = writeln!(text, "    {member}: {kind}");
            if !about.is_empty() {
                let _ = writeln!(text, "    \"\"\"{about}\"\"\"");
            }
        }
        if is_empty {
            text.push_str("    pass\n");
        }
        text.truncate(text.trim_end().len());
    }

    /// Returns a schema as a type; an object without a name gets this one.
    fn type_of(&mut self, schema: &Value, name: &str) -> String {
        if let Some(reference) = schema["$ref"].as_str() {
            return reference.rsplit('/').next().unwrap_or_default().to_owned();
        }
        if let Some(choices) = schema["enum"].as_array() {
            let choices: Vec<_> = choices.iter().map(Value::to_string).collect();
            return format!("Literal[{}]", choices.join(", "));
        }
        if let Some(constant) = schema.get("const") {
            let shown = match constant {
                Value::Bool(true) => "True".to_owned(),
                other => other.to_string(),
            };
            return format!("Literal[{shown}]");
        }
        for key in ["anyOf", "oneOf"] {
            if let Some(kinds) = schema[key].as_array() {
                let many = kinds
                    .iter()
                    .filter(|kind| kind["properties"].is_object())
                    .count()
                    > 1;
                let kinds = kinds.iter().enumerate().map(|(nth, kind)| {
                    let own = match kind["properties"]["event"]["enum"][0].as_str() {
                        Some(event) => format!("{}Event", camel(&event.replace('-', "_"))),
                        None if many => match kind["required"][0].as_str() {
                            Some(member) => {
                                format!("{}{}", name.trim_end_matches("Item"), camel(member))
                            }
                            None => format!("{name}{}", nth + 1),
                        },
                        None => name.to_owned(),
                    };
                    self.type_of(kind, &own)
                });
                let mut kinds: Vec<_> = kinds.collect();
                kinds.dedup();
                return format!("Union[{}]", kinds.join(", "));
            }
        }
        let kinds: Vec<_> = match &schema["type"] {
            Value::String(kind) => vec![kind.as_str()],
            Value::Array(kinds) => kinds.iter().filter_map(Value::as_str).collect(),
            _ => return "Any".to_owned(),
        };
        let kinds = kinds.into_iter().map(|kind| match kind {
            "null" => "None".to_owned(),
            "boolean" => "bool".to_owned(),
            "string" => "str".to_owned(),
            "integer" => "int".to_owned(),
            "number" => "float".to_owned(),
            "array" => {
                let items = match &schema["items"] {
                    Value::Array(items) => items.first().unwrap_or(&Value::Null),
                    one => one,
                };
                format!("list[{}]", self.type_of(items, &format!("{name}Item")))
            }
            _ if schema["properties"].is_object() => {
                self.names.insert(name.to_owned());
                self.add_class(name, schema);
                name.to_owned()
            }
            _ => {
                let of = self.type_of(&schema["additionalProperties"], &format!("{name}Value"));
                format!("dict[str, {of}]")
            }
        });
        let kinds: Vec<_> = kinds.collect();
        match kinds.as_slice() {
            [one] => one.clone(),
            several => format!("Union[{}]", several.join(", ")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn python_types_agree_with_the_tables() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(FILE);
        let written = fs::read_to_string(path).unwrap_or_default();
        assert!(written == text(), "cargo xtask station writes it anew");
    }
}
