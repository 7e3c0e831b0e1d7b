//! Reader of points and recordings as CSV with a header.

use std::borrow::Cow;
use std::collections::BTreeSet;

use magician_host::message;

use super::row::{Row, plan};
use super::{only_recordings, recording};
use crate::formats::content::points::{Field, cells, lines, separator};
use crate::{Diagnostic, DiagnosticCode, Lines, Parsed, Plan};

pub(super) fn read(text: &str, resample: Option<f64>) -> Result<Parsed<Plan>, Diagnostic> {
    let places = Lines::new(text);
    let mut lines = lines(text);
    let (start, header) = lines.next().unwrap_or_default();
    let between = separator(header);
    let mut notes = Vec::new();
    let mut columns: Vec<Option<Field>> = Vec::new();
    for (range, cell) in cells(header, start, between) {
        let field = Field::named(&cell);
        let origin = places.origin(range);
        if field.is_some_and(|field| {
            field != Field::Idle && field != Field::Speed && columns.contains(&Some(field))
        }) {
            return Err(Diagnostic::new(
                origin,
                message!("there is another column '{name}'", name = cell.trim()),
            ));
        }
        if field.is_none() {
            let note = message!(
                "unknown column '{name}': it is left out",
                name = cell.trim()
            );
            notes.push(Diagnostic::new(origin, note).coded(DiagnosticCode::LeftOut));
        }
        columns.push(field);
    }
    let fields: BTreeSet<Field> = columns.iter().flatten().copied().collect();
    for (axis, name) in ["X", "Y", "Z"].into_iter().enumerate() {
        if !fields.contains(&Field::Place(axis)) {
            let origin = places.origin(start..start + header.len());
            let diagnostic = Diagnostic::new(origin, message!("there is no column {name}", name));
            return Err(diagnostic.help(message!(
                "the first line names the columns, such as X,Y,Z,R; \
                without it each line is x,y,z"
            )));
        }
    }
    let mut rows = Vec::new();
    let mut lines = lines.peekable();
    lines.next_if(|(start, line)| {
        let mut units = cells(line, *start, between).map(|(_, cell)| cell);
        let are = |cell: Cow<'_, str>| ["", "s", "mm", "deg"].contains(&cell.trim());
        fields.contains(&Field::Time) && units.all(are)
    });
    for (start, line) in lines {
        let origin = places.origin(start..start + line.len());
        let mut row = Row::at(origin);
        let mut count = 0;
        for (range, cell) in cells(line, start, between) {
            let origin = places.origin(range);
            count += 1;
            let Some(column) = columns.get(count - 1) else {
                if cell.trim().is_empty() {
                    continue;
                }
                let message = message!(
                    "this line has more than the {count} columns of the first",
                    count = columns.len()
                );
                return Err(Diagnostic::new(origin, message));
            };
            let Some(field) = column else { continue };
            // With another separator a comma can only be a decimal comma.
            let number = between != ',' && !matches!(field, Field::Name | Field::Style);
            let cell = if number {
                Cow::Owned(cell.replace(',', "."))
            } else {
                cell
            };
            row.take(*field, &cell, origin)?;
        }
        rows.push(row);
    }
    if !fields.contains(&Field::Time) {
        only_recordings(resample)?;
        return plan(rows, &fields, notes);
    }
    if rows
        .iter()
        .any(|row| row.rail().is_some_and(|l| l != rows[0].rail().unwrap_or(l)))
    {
        let message = message!(
            "the rail moves in this recording, and a recording is followed by the arm alone"
        );
        let help = message!("teach its points on the rail instead");
        return Err(Diagnostic::of_file(message).help(help));
    }
    // The last row of an interrupted recording may be incomplete.
    let samples: Vec<_> = rows.iter().filter_map(Row::sample).collect();
    if samples.len() < rows.len() {
        let what = message!(
            "rows without a time or a position are left out: {count}",
            count = rows.len() - samples.len()
        );
        notes.push(Diagnostic::of_file(what).coded(DiagnosticCode::LeftOut));
    }
    let mut reading = recording::plan(&samples, resample)?;
    reading.notes.splice(0..0, notes);
    Ok(reading)
}
