//! The complete profile as a file, with the source of each value.

use toml::{Table, Value};

use super::Profile;

/// Template of the file, without values.
///
/// A line is a comment, a `[section]`, `key # source`, or `key [` followed by one indented line for
/// each entry of the list.
const SOURCES: &str = include_str!("pattern.txt");

impl Profile {
    /// Returns the built-in profile as a file with the source of each value: the template for a
    /// custom one.
    #[must_use]
    pub fn pattern() -> String {
        // Cannot fail: a profile is numbers, text and lists. A test compares the result with the
        // default.
        let values = Table::try_from(Self::default()).unwrap_or_default();
        let mut section = &values;
        let mut entries: &[Value] = &[];
        let lines = SOURCES.lines().map(|line| {
            if let Some(header) = line.strip_prefix('[') {
                section = section_of(&values, header);
                return line.to_owned();
            }
            if line.is_empty() || line.starts_with('#') {
                return line.to_owned();
            }
            if let (Some(source), Some((entry, rest))) =
                (line.strip_prefix("    "), entries.split_first())
            {
                entries = rest;
                let end = if rest.is_empty() { "\n]" } else { "" };
                return format!("    {:<12} {source}{end}", format!("{entry},"));
            }
            if let Some(key) = line.strip_suffix(" [") {
                entries = (section.get(key).and_then(Value::as_array)).map_or(&[], Vec::as_slice);
                return format!("{key} = [");
            }
            let (key, source) = line.split_once(' ').unwrap_or((line, ""));
            let value = section.get(key).map(Value::to_string);
            let setting = format!("{key} = {}", value.unwrap_or_default());
            format!("{setting:<27} {source}").trim_end().to_owned()
        });
        let lines: Vec<String> = lines.collect();
        lines.join("\n") + "\n"
    }
}

/// Values of the section in a header line such as `limits.controller]  # ..`.
fn section_of<'t>(values: &'t Table, header: &str) -> &'t Table {
    let name = header.split(']').next().unwrap_or_default();
    let mut section = values;
    for part in name.split('.') {
        section = section
            .get(part)
            .and_then(Value::as_table)
            .unwrap_or(values);
    }
    section
}
