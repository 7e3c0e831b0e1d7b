//! Edits of a settings file that keep the rest of it, comments included, as its owner wrote it.
//!
//! `toml_edit` was tried: it inserts before a comment at the end of the file, and takes along the
//! comment above a value that it changes or removes. Correcting that takes as many lines as this
//! module.

use std::ops::Range;

use toml::de::{DeTable, DeValue};

/// Text with this value for a name. `None` if the place cannot be edited.
pub(super) fn with(text: &str, name: &str, value: &str) -> Option<String> {
    if let Some((_, old)) = find(text, name)? {
        return Some(format!(
            "{}{value}{}",
            text.get(..old.start)?,
            text.get(old.end..)?
        ));
    }
    let (section, key) = name
        .rsplit_once('.')
        .map_or((None, name), |(a, b)| (Some(a), b));
    let line = format!("{key} = {value}\n");
    let Some(section) = section else {
        return Some(inserted(text, first_header(text), &line));
    };
    match header(text, section) {
        Some(end) => Some(inserted(text, end, &line)),
        None => {
            let gap = if text.trim().is_empty() { "" } else { "\n" };
            Some(inserted(
                text,
                text.len(),
                &format!("{gap}[{section}]\n{line}"),
            ))
        }
    }
}

/// Text with this table at its end, in place of an earlier one.
pub(super) fn with_table(text: &str, name: &str, table: &toml::Table) -> Option<String> {
    let mut text = without(text, name)?;
    text.truncate(text.trim_end().len());
    if !text.is_empty() {
        text.push_str("\n\n");
    }
    text.push_str(&format!("[{name}]\n"));
    for (key, value) in table {
        text.push_str(&format!("{key} = {value}\n"));
    }
    Some(text)
}

/// Text without this name and the rest of its lines.
pub(super) fn without(text: &str, name: &str) -> Option<String> {
    let Some((key, value)) = find(text, name)? else {
        return Some(text.to_owned());
    };
    let is_table = text.get(key.clone())?.starts_with('[') || text.get(..key.start)?.ends_with('[');
    let start = text.get(..key.start)?.rfind('\n').map_or(0, |at| at + 1);
    let end = if is_table {
        // A table with its own header extends to the next header.
        value.end.max(next_header(text, key.end))
    } else {
        value.end
    };
    let rest = text.get(end..)?;
    let after = if is_table {
        end
    } else {
        rest.find('\n').map_or(text.len(), |at| end + at + 1)
    };
    Some(format!("{}{}", text.get(..start)?, text.get(after..)?))
}

/// Spans of a name and its value. `None` if the text is not TOML.
pub(super) fn find(text: &str, name: &str) -> Option<Option<(Range<usize>, Range<usize>)>> {
    let file = DeTable::parse(text).ok()?;
    let mut table = file.get_ref();
    let mut steps = name.split('.').peekable();
    while let Some(step) = steps.next() {
        let Some((key, value)) = table.iter().find(|(key, _)| key.get_ref() == step) else {
            return Some(None);
        };
        match value.get_ref() {
            _ if steps.peek().is_none() => return Some(Some((key.span(), value.span()))),
            DeValue::Table(inner) => table = inner,
            _ => return None,
        }
    }
    None
}

/// Offset of the first line that begins a table.
fn first_header(text: &str) -> usize {
    next_header(text, 0)
}

/// Offset of the next line from `from` on that begins a table; the end of the text if there is
/// none.
fn next_header(text: &str, from: usize) -> usize {
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        if at >= from && line.trim_start().starts_with('[') {
            return at;
        }
        at += line.len();
    }
    text.len()
}

/// Offset of the line after the header of a table.
fn header(text: &str, section: &str) -> Option<usize> {
    let mut end = 0;
    for line in text.split_inclusive('\n') {
        end += line.len();
        let line = line.split('#').next().unwrap_or_default().trim();
        let name = line
            .strip_prefix('[')
            .and_then(|line| line.strip_suffix(']'));
        if name.is_some_and(|name| name.trim() == section) {
            return Some(end);
        }
    }
    None
}

/// Text with a line inserted at an offset where a line begins.
fn inserted(text: &str, at: usize, line: &str) -> String {
    let (before, after) = text.split_at_checked(at).unwrap_or((text, ""));
    let feed = if before.is_empty() || before.ends_with('\n') {
        ""
    } else {
        "\n"
    };
    format!("{before}{feed}{line}{after}")
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "# mine\nport = \"COM3\" # the white one\n\n[draw] # pens\nspeed = 60\n\n[sheet]\nrotation = 3\nsurface = { height = -60 }\n";

    #[test]
    fn edit_changes_only_the_named_value() {
        let text = with(FILE, "port", "\"COM4\"").expect("it can");
        assert_eq!(text, FILE.replace("COM3", "COM4"));
        let text = with(FILE, "draw.speed", "70").expect("it can");
        assert_eq!(text, FILE.replace("60\n\n", "70\n\n"));
    }

    #[test]
    fn new_value_is_inserted_in_its_table() {
        let text = with(FILE, "surface", "-61").expect("it can");
        assert!(text.contains("surface = -61\n[draw]"), "{text}");
        let text = with(FILE, "draw.lift", "5").expect("it can");
        assert!(text.contains("[draw] # pens\nlift = 5\nspeed"), "{text}");
        let text = with(FILE, "engrave.speed", "5").expect("it can");
        assert!(text.ends_with("\n\n[engrave]\nspeed = 5\n"), "{text}");
        assert_eq!(
            with("", "draw.lift", "5"),
            Some("[draw]\nlift = 5\n".to_owned())
        );
        assert_eq!(with("a = 1", "b", "2"), Some("a = 1\nb = 2\n".to_owned()));
    }

    #[test]
    fn table_replaces_the_earlier_one() {
        let table: toml::Table = toml::from_str("a = [1.5, -2]\nb = { c = 3 }").expect("a table");
        let text = with_table(FILE, "sheet", &table).expect("it can");
        let end = "speed = 60\n\n[sheet]\na = [1.5, -2]\nb = { c = 3 }\n";
        assert!(text.ends_with(end), "{text}");
        assert_eq!(with_table(&text, "sheet", &table), Some(text));
        let text = with_table("sheet = { a = 1 }\nport = \"COM3\"\n", "sheet", &table);
        assert!(
            text.expect("it can")
                .starts_with("port = \"COM3\"\n\n[sheet]\n")
        );
    }

    #[test]
    fn removed_name_takes_all_its_lines() {
        let text = without(FILE, "port").expect("it can");
        assert!(text.starts_with("# mine\n\n[draw]"), "{text}");
        let text = without(FILE, "sheet").expect("it can");
        assert!(text.ends_with("speed = 60\n\n"), "{text}");
        let text = without(FILE, "draw.speed").expect("it can");
        assert!(text.contains("[draw] # pens\n\n[sheet]"), "{text}");
        assert_eq!(without("a = 1", "a"), Some(String::new()));
    }
}
