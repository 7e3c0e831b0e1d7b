//! Reader of points as JSON, made of the rows of a playback file.

use std::borrow::Cow;
use std::collections::BTreeSet;

use magician_host::message;

use super::row::{Row, plan};
use crate::formats::content::points::Field;
use crate::plan::json::Json;
use crate::{Diagnostic, DiagnosticCode, Parsed, Plan};

/// Largest number of rows. It bounds memory.
const MAX_ROWS: usize = 1_000_000;

pub(super) fn read(text: &str) -> Result<Parsed<Plan>, Diagnostic> {
    let json = Json::of(text);
    let whole = json.whole()?;
    let lines = json.lines();
    let mut rows = Vec::new();
    let mut notes = Vec::new();
    let mut within = None;
    json.members(whole, |key, value| {
        if key == "rows" {
            within = Some(value);
            return Ok(());
        }
        match number_of(&key) {
            Some(number) => rows.push((number, value)),
            None => {
                let note = message!("'{name}' is unknown: it is left out", name = key);
                notes.push(json.diagnostic(value, note).coded(DiagnosticCode::LeftOut));
            }
        }
        Ok(())
    })?;
    if let Some(within) = within {
        json.members(within, |key, value| {
            let number = number_of(&key).ok_or_else(|| {
                let message =
                    message!("the rows are called row0, row1 and so on, not '{key}'", key);
                json.diagnostic(value, message)
            })?;
            rows.push((number, value));
            Ok(())
        })?;
    }
    if rows.len() > MAX_ROWS {
        return Err(Diagnostic::of_file(message!(
            "too many rows: more than {most}",
            most = MAX_ROWS
        )));
    }
    // Members of an object may be in any order.
    rows.sort_by_key(|(number, _)| *number);
    if let Some([_, (number, value)]) = (rows.windows(2)).find_map(|pair| {
        let pair: [(u64, &str); 2] = pair.try_into().ok()?;
        (pair[0].0 == pair[1].0).then_some(pair)
    }) {
        return Err(json.diagnostic(value, message!("row{number} appears twice", number)));
    }
    let mut fields = BTreeSet::new();
    let mut strangers = BTreeSet::new();
    let mut points = Vec::new();
    for (_, value) in rows {
        let mut row = Row::at(json.place(&lines, value));
        for member in json.object(value)? {
            let Some(field) = Field::named(&member.key) else {
                if strangers.insert(member.key.to_string()) {
                    let note = message!("'{name}' is unknown: it is left out", name = member.key);
                    notes.push(
                        json.diagnostic(member.value, note)
                            .coded(DiagnosticCode::LeftOut),
                    );
                }
                continue;
            };
            fields.insert(field);
            let text = plain(&json, member.value)?;
            row.take(field, &text, json.place(&lines, member.value))?;
        }
        points.push(row);
    }
    plan(points, &fields, notes)
}

/// Returns a number or a string as text; null is empty.
fn plain<'t>(json: &Json<'t>, value: &'t str) -> Result<Cow<'t, str>, Diagnostic> {
    match value.chars().next() {
        Some('"') => json.string(value),
        Some('{' | '[') => Err(json.diagnostic(value, message!("expected a number or a string"))),
        _ if value == "null" => Ok("".into()),
        _ => Ok(value.into()),
    }
}

/// Returns the number in a name such as `row12`.
fn number_of(key: &str) -> Option<u64> {
    let digits = key.strip_prefix("row")?;
    let is_number = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
    is_number.then(|| digits.parse().ok()).flatten()
}
