//! Checks `methods.toml` against the protocol's table.

use std::collections::BTreeSet;

use magician_link::{Access, AnswerTime, Method, methods};
use magician_protocol::{LayoutInfo, Row};

fn row(method: &Method) -> Option<&'static Row> {
    let name = method.command.as_deref()?;
    Some(Row::find(name).unwrap_or_else(|_| panic!("{}: no row {name}", method.name)))
}

fn has(layout: Option<&'static LayoutInfo>, field: &str) -> bool {
    layout.is_some_and(|layout| layout.fields.iter().any(|known| known.name == field))
}

#[test]
fn table_has_149_calls_and_118_with_rows() {
    let names: BTreeSet<_> = methods().iter().map(|method| &method.name).collect();
    assert_eq!((methods().len(), names.len()), (149, 149));
    let rows = methods().iter().filter(|method| method.command.is_some());
    assert_eq!(rows.count(), 118);
}

#[test]
fn each_call_has_the_row_of_its_id_or_an_encoding() {
    for method in methods() {
        let name = &method.name;
        match row(method) {
            // DobotLink both reads and clears the alarms with id 20. The row of its call that
            // clears them has id 21.
            Some(row) => assert!(
                row.id == method.id || (row.id, method.id) == (21, 20),
                "{name}"
            ),
            None => {
                let laid_out = { method.params.iter() }.all(|param| param.wire.is_some());
                assert!(laid_out || method.refused.is_some(), "{name}");
            }
        }
        let queued = method.class != AnswerTime::Plain;
        assert!(!queued || method.access == Access::Write, "{name}");
        if let Some(row) = row(method) {
            assert!(!queued || row.queueable, "{name} cannot be queued");
        }
    }
}

#[test]
fn parameters_are_fields_and_cover_all_required_fields() {
    for method in methods() {
        let Some(row) = row(method) else { continue };
        let layout = match method.access {
            Access::Read => row.query,
            Access::Write => row.set,
        };
        for param in &method.params {
            let Some(field) = &param.field else { continue };
            assert!(has(layout, field), "{}: no field {field}", method.name);
        }
        for field in layout.into_iter().flat_map(|layout| layout.fields) {
            let given =
                { method.params.iter() }.any(|param| param.field.as_deref() == Some(field.name));
            assert!(
                given || field.optional || field.name == "reserved",
                "{}: {}",
                method.name,
                field.name
            );
        }
    }
}

#[test]
fn results_are_fields_and_cover_all_fields_of_a_read() {
    for method in methods() {
        let Some(row) = row(method) else { continue };
        if method.access == Access::Write {
            assert!(method.results.is_empty(), "{}", method.name);
            continue;
        }
        for result in &method.results {
            let field = result.field.as_deref().unwrap_or_default();
            assert!(has(row.value, field), "{}: no field {field}", method.name);
        }
        for field in row.value.into_iter().flat_map(|layout| layout.fields) {
            let told =
                { method.results.iter() }.any(|result| result.field.as_deref() == Some(field.name));
            assert!(told, "{}: {} is not answered", method.name, field.name);
        }
    }
}
