//! Look-up of commands by name or id, with suggestions for misspelt names.

use std::ffi::OsStr;

use clap::builder::{PossibleValue, StringValueParser, TypedValueParser};
use magician_protocol::{Row, TABLE};

use crate::failure::Failure;

/// Lowest similarity of a suggested name: 0 is unrelated, 1 equal. A choice: low enough for `Poze`,
/// high enough that random letters suggest nothing (tested below).
const MIN_SIMILARITY: f64 = 0.5;
/// Deduction from the edit-distance similarity. Names that share letter pairs (Sørensen-Dice) are
/// likelier meant than names with the same letters replaced.
const EDIT_DISTANCE_DEDUCTION: f64 = 0.2;
const MAX_SUGGESTIONS: usize = 3;

/// Value parser that accepts any text as a command and offers the names to completions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Names;

impl TypedValueParser for Names {
    type Value = String;

    fn parse_ref(
        &self,
        command: &clap::Command,
        argument: Option<&clap::Arg>,
        value: &OsStr,
    ) -> Result<String, clap::Error> {
        StringValueParser::new().parse_ref(command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(
            TABLE.iter().map(|row| PossibleValue::new(row.name)),
        ))
    }
}

/// Finds the command of a name or id.
pub(crate) fn find(name: &str) -> Result<&'static Row, Failure> {
    Row::find(name).map_err(|_| unknown(name))
}

/// Returns a name in lower case without `-` and `_`, which do not count in comparisons.
pub(crate) fn normalised_name(name: &str) -> String {
    let kept = name.chars().filter(|letter| !matches!(letter, '-' | '_'));
    kept.flat_map(char::to_lowercase).collect()
}

/// Returns a name in the command line's notation: `LostStep` becomes `lost-step`.
pub(crate) fn kebab(name: &str) -> String {
    let mut words = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !words.is_empty() {
            words.push('-');
        }
        words.extend(letter.to_lowercase());
    }
    words
}

fn unknown(name: &str) -> Failure {
    let failure = Failure::usage(format!("unknown command `{name}`"));
    match nearest(name).as_slice() {
        [] => failure.hint("`magician commands` lists them"),
        names => failure.hint(format!("did you mean {}?", names.join(" or "))),
    }
}

/// Returns the names most similar to this one, best first.
fn nearest(name: &str) -> Vec<&'static str> {
    let typed = normalised_name(name);
    let bare = ["get", "set"]
        .iter()
        .find_map(|prefix| typed.strip_prefix(prefix));
    let typed = bare.unwrap_or(&typed);
    let score = |row: &Row| {
        let candidate = normalised_name(row.name);
        let part = typed.len() >= 3 && candidate.contains(typed);
        strsim::sorensen_dice(&candidate, typed).max(
            strsim::normalized_damerau_levenshtein(&candidate, typed) - EDIT_DISTANCE_DEDUCTION,
        ) + if part { 1.0 } else { 0.0 }
    };
    let mut scored: Vec<_> = TABLE.iter().map(|row| (score(row), row.name)).collect();
    scored.retain(|(score, _)| *score >= MIN_SIMILARITY);
    scored.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    scored
        .into_iter()
        .take(MAX_SUGGESTIONS)
        .map(|(_, name)| name)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn misspelt_name_finds_the_command() {
        assert_eq!(nearest("GetPos").first(), Some(&"Pose"));
        assert_eq!(nearest("ptpjointparam").first(), Some(&"PTPJointParams"));
        assert_eq!(nearest("jumparams").first(), Some(&"PTPJumpParams"));
        assert_eq!(nearest("Poze"), ["Pose"]);
        assert_eq!(nearest("qqqq"), [""; 0]);
    }
}
