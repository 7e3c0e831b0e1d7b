//! `[arms.NAME]` tables: settings of one arm, as `magician config` shows and edits them.
//!
//! All front ends read these tables through [`magician::arms`]; only the editing is here.

use magician::arms::KnownArm;
use magician_program::{Diagnostic, Lines};
use toml::Spanned;
use toml::de::DeValue;

pub(super) use magician::arms::TABLE;

/// Settings of an arm: name, text shown while it is not set, and type.
const SETTINGS: [(&str, &str, SettingType); 8] = [
    ("port", "", SettingType::Text),
    ("laser", "true", SettingType::Flag),
    (
        "lowest_j2",
        "-13.5, with a warning below -5",
        SettingType::Number,
    ),
    ("fence.floor", "no floor", SettingType::Number),
    ("fence.box", "no box", SettingType::Box),
    ("fence.keep_out", "no keep-outs", SettingType::Boxes),
    ("fence.top_speed", "no top speed", SettingType::Number),
    ("fence.strongest_laser", "100", SettingType::Number),
];

#[derive(Clone, Copy)]
enum SettingType {
    Text,
    Flag,
    Number,
    Box,
    Boxes,
}

/// Reads the arms of a file, or returns where the file is wrong.
pub(super) fn read(
    lines: &Lines<'_>,
    table: &Spanned<DeValue<'_>>,
) -> Result<Vec<KnownArm>, Diagnostic> {
    magician::arms::read(table).map_err(|flaw| {
        let problem = Diagnostic::new(lines.origin(flaw.place), flaw.message);
        match flaw.help {
            Some(help) => problem.help(help),
            None => problem,
        }
    })
}

/// True if this is the name of an arm's setting, such as `arms.NAME.fence.floor`.
pub(crate) fn is_name(name: &str) -> bool {
    setting(name).is_some()
}

/// Returns the full names of all settings of this arm, each with the text shown while it is not
/// set.
pub(crate) fn names_of(arm: &str) -> impl Iterator<Item = (String, &'static str)> {
    SETTINGS
        .iter()
        .map(move |(setting, default, _)| (format!("{TABLE}.{arm}.{setting}"), *default))
}

/// Returns the text shown while the setting is not set.
pub(crate) fn default_of(name: &str) -> &'static str {
    setting(name).map_or("", |(default, _)| default)
}

fn setting(name: &str) -> Option<(&'static str, SettingType)> {
    let (arm, setting) = name
        .strip_prefix(TABLE)?
        .strip_prefix('.')?
        .split_once('.')?;
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if arm.is_empty() || !arm.chars().all(bare) {
        return None;
    }
    let mut known = SETTINGS.iter();
    let (_, default, kind) = known.find(|(known, ..)| *known == setting)?;
    Some((default, *kind))
}

/// Converts a value as typed by the user into TOML.
pub(crate) fn to_toml(name: &str, value: &str) -> Result<String, String> {
    let value = value.trim();
    let (_, kind) = setting(name).ok_or("no such setting")?;
    match kind {
        SettingType::Text => Ok(toml::Value::from(value).to_string()),
        SettingType::Flag if ["true", "false"].contains(&value) => Ok(value.to_owned()),
        SettingType::Flag => Err("expected true or false".to_owned()),
        SettingType::Number => value
            .parse::<f64>()
            .map(|number| toml::Value::from(number).to_string())
            .map_err(|_| format!("`{value}` is not a number")),
        SettingType::Box | SettingType::Boxes if value.starts_with('[') => Ok(value.to_owned()),
        SettingType::Box => corners(value),
        SettingType::Boxes => {
            let boxes: Result<Vec<String>, String> = value.split(';').map(corners).collect();
            Ok(format!("[{}]", boxes?.join(", ")))
        }
    }
}

/// Converts six numbers into two corners.
fn corners(text: &str) -> Result<String, String> {
    let wrong = || format!("`{text}`: expected X,Y,Z,X,Y,Z, two corners in mm");
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match numbers.map_err(|_| wrong())?.as_slice() {
        [a, b, c, d, e, f] => Ok(format!("[[{a:?}, {b:?}, {c:?}], [{d:?}, {e:?}, {f:?}]]")),
        _ => Err(wrong()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn typed_value_is_valid_in_the_file() {
        for (name, typed, written) in [
            ("arms.white.fence.floor", "-60", Some("-60.0")),
            ("arms.white.port", "COM3", Some("\"COM3\"")),
            ("arms.white.laser", "false", Some("false")),
            (
                "arms.white.fence.box",
                "1,2,3,4,5,6",
                Some("[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]"),
            ),
            (
                "arms.w.fence.keep_out",
                "1,2,3,4,5,6;0,0,0,1,1,1",
                Some("[[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]]]"),
            ),
            ("arms.white.fence.floor", "low", None),
            ("arms.white.fence.box", "1,2,3", None),
        ] {
            assert_eq!(
                super::to_toml(name, typed).ok().as_deref(),
                written,
                "{name}"
            );
        }
        assert!(!is_name("arms.white.roof") && !is_name("arms..laser") && !is_name("port"));
    }
}
