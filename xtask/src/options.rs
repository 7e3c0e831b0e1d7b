//! Program options for other uses: keywords of the Python package, and a table of a page.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use magician_program::{DefaultValue, OptionKind, OptionSpec, SetupOptions};

/// Source of the Python package that contains the keywords.
const PYTHON: &str = "crates/magician-py/python/magician/programs.py";
const BEGIN: &str = "# `cargo xtask python` writes this class from the table of options.\n";
const END: &str = "# So far it is written.\n";
/// Options that a plan in Python has in another form: `Plan.on_grid`, `arm.speed` and `arm.run`.
const OPTIONS_OUTSIDE_OF_PLANS: [&str; 4] = ["grid", "speed_ratio", "stay", "park"];

/// Writes the keywords into the Python package.
pub(crate) fn write_python(root: &Path) -> Result<(), Box<dyn Error>> {
    let path = root.join(PYTHON);
    let text = fs::read_to_string(&path)?;
    fs::write(
        path,
        with_keywords(&text).ok_or("programs.py has no place for options")?,
    )?;
    Ok(())
}

/// Returns the source with the keywords of the table; `None` without markers.
fn with_keywords(text: &str) -> Option<String> {
    let (before, rest) = text.split_once(BEGIN)?;
    let (_, behind) = rest.split_once(END)?;
    Some(format!("{before}{BEGIN}{}{END}{behind}", keywords()))
}

fn keywords() -> String {
    let mut text = "class SetupOptions(TypedDict, total=False):\n    \
        \"\"\"Options for drawing or engraving a file: the keywords of :func:`load`, :func:`write` and :func:`frame`. Options\n    \
        left out take the value of the file, or their default. Lengths are mm, angles degrees, speeds mm/s.\"\"\"\n\n"
        .to_owned();
    let rows = SetupOptions::OPTIONS.iter();
    for row in rows.filter(|row| !OPTIONS_OUTSIDE_OF_PLANS.contains(&row.name)) {
        let _ = writeln!(text, "    {}: {}", row.name, python_type(row));
        let sentences = [option_sentence(row), sentence(row.detail)].join(" ");
        text += &docstring(sentences.trim());
    }
    let switches = SetupOptions::OPTIONS
        .iter()
        .filter(|row| row.kind == OptionKind::Switch);
    let names = switches.filter(|row| !OPTIONS_OUTSIDE_OF_PLANS.contains(&row.name));
    text += "\n\n_SWITCHES = (\n";
    for row in names {
        let _ = writeln!(text, "    \"{}\",", row.name);
    }
    text + ")\n"
}

/// Returns a docstring inside a class, wrapped.
fn docstring(text: &str) -> String {
    // Line length of the Python package without the indentation of a class.
    const WIDTH: usize = 120 - 4;
    let mut lines = vec![String::from("\"\"\"")];
    for word in text.split_whitespace() {
        let line = lines.last_mut().expect("a line");
        let gap = usize::from(!line.ends_with('"') && !line.is_empty());
        if line.chars().count() + gap + word.chars().count() + 3 > WIDTH {
            lines.push(word.to_owned());
        } else {
            if gap > 0 {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    let mut shown = String::new();
    for line in &lines {
        let _ = writeln!(shown, "    {line}");
    }
    shown.truncate(shown.len() - 1);
    shown + "\"\"\"\n"
}

fn python_type(row: &OptionSpec) -> String {
    let words = || {
        let words: Vec<_> = row
            .choices
            .iter()
            .map(|word| format!("\"{word}\""))
            .collect();
        format!("Literal[{}]", words.join(", "))
    };
    // Types that are more specific than their kind.
    let own = match row.name {
        "tool" => "Tool",
        "surface" => "float | Surface",
        "font" => "str | os.PathLike[str]",
        "page" => "str",
        "power" => "float | tuple[float, float]",
        "only" => "str | Iterable[str]",
        "pens" => "str | os.PathLike[str] | Iterable[Mapping[str, Any]]",
        _ => "",
    };
    let kind = match row.kind {
        _ if !own.is_empty() => own.to_owned(),
        OptionKind::Choice => words(),
        OptionKind::Number => "float".to_owned(),
        OptionKind::Integer => "int".to_owned(),
        OptionKind::Point => "tuple[float, float]".to_owned(),
        OptionKind::Place => "tuple[float, float, float]".to_owned(),
        OptionKind::Area => "tuple[int, int, int, int]".to_owned(),
        OptionKind::Switch => "bool".to_owned(),
        _ => "str".to_owned(),
    };
    format!("{kind} | None")
}

/// Returns the sentence of an option with its range and its default.
fn option_sentence(row: &OptionSpec) -> String {
    let mut text = row.about.to_owned();
    let takes = range_text(row);
    if !takes.is_empty() {
        let _ = write!(text, ": {takes}");
    }
    let default = default_text(row);
    if !default.is_empty() {
        let _ = write!(text, "; default: {default}");
    }
    text + "."
}

fn sentence(text: &str) -> String {
    match text {
        "" => String::new(),
        text => format!("{}.", text.trim_end_matches('.')),
    }
}

/// Returns the range of an option; empty if its type shows it.
fn range_text(row: &OptionSpec) -> String {
    match row.kind {
        OptionKind::Switch | OptionKind::List | OptionKind::Pens => String::new(),
        // The type lists the words.
        OptionKind::Choice if row.expects.is_empty() => String::new(),
        _ if !row.expects.is_empty() && row.about.contains(row.expects) => String::new(),
        OptionKind::Number if row.least.is_none() && row.above.is_none() => row.unit.to_owned(),
        _ => row.accepted(),
    }
}

/// Returns the default of an option as text.
fn default_text(row: &OptionSpec) -> String {
    match row.default {
        _ if !row.usually.is_empty() => row.usually.to_owned(),
        Some(DefaultValue::Number(number)) => number.to_string(),
        Some(DefaultValue::Word(word)) => word.to_owned(),
        Some(DefaultValue::Switch(true)) => "on".to_owned(),
        _ => String::new(),
    }
}

/// Returns the options as a table in Markdown.
pub(crate) fn table() -> String {
    let mut text =
        "| option | value | default | needs | purpose |\n|---|---|---|---|---|\n".to_owned();
    for row in SetupOptions::OPTIONS {
        let needs = row.needs.map(|need| need.to_string()).unwrap_or_default();
        let purpose = [sentence(row.about), sentence(row.detail)].join(" ");
        let (name, value, default) = (row.name, row.accepted(), default_text(row));
        let _ = writeln!(
            text,
            "| `{name}` | {value} | {default} | {needs} | {} |",
            purpose.trim()
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn python_keywords_agree_with_the_table() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let text = fs::read_to_string(root.join(PYTHON)).expect("the sources");
        let written = with_keywords(&text).expect("a place");
        assert!(text == written, "cargo xtask python writes it anew");
    }
}
