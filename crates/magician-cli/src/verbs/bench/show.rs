//! Figures of `bench` as a table.

use super::figures::{Figures, H1, H2, H3, H4, H5, RateComparison, Starvation};
use crate::columns::{Columns, note};
use crate::failure::Failure;
use crate::output::Output;

/// Text for a figure that was not measured.
const NOT_MEASURED: &str = "not measured";

pub(super) fn write(figures: &Figures, out: &mut Output) -> Result<(), Failure> {
    let mut head = Columns::default();
    head.row(["port", &figures.port]);
    head.row(["window", &figures.window.to_string()]);
    head.row(["line", &line(figures)]);
    head.write(out)?;
    out.line("")?;
    let mut table = Columns::default();
    match &figures.h1 {
        Some(h1) => rates(h1, &mut table),
        None => row(&mut table, "requests", None),
    }
    row(
        &mut table,
        "segments, line saturated",
        figures.h2.as_ref().map(full_line),
    );
    match &figures.h3 {
        Some(h3) => starvation(h3, &mut table),
        None => row(&mut table, "queue while drawing", None),
    }
    match &figures.h4 {
        Some(h4) => stop(h4, &mut table),
        None => row(&mut table, "stop", None),
    }
    row(&mut table, "processor", figures.h5.as_ref().map(processor));
    let added = figures.h7.as_ref().map(|added| {
        format!(
            "median {} us; 99 % below {} us",
            added.added_p50_us, added.added_p99_us
        )
    });
    row(&mut table, "added by the driver", added);
    table.write(out)?;
    if figures.drawn {
        Ok(())
    } else {
        note(
            "measurements with motion were left out; with --yes the arm draws rings of 20 mm \
                through its current position",
            out,
        )
    }
}

fn line(figures: &Figures) -> String {
    let Some(turnaround) = figures.turnaround_ms else {
        return NOT_MEASURED.to_owned();
    };
    let jitter = figures.jitter_ms.unwrap_or_default();
    match (figures.line_baud, figures.computed_for_ms) {
        (Some(baud), Some(known)) => {
            format!(
                "{baud} baud, turnaround {turnaround} ms, jitter {jitter} ms; computed for {known} ms"
            )
        }
        _ => format!(
            "bytes take no time, turnaround {turnaround} ms, jitter {jitter} ms; no rates can be \
                computed"
        ),
    }
}

fn row(table: &mut Columns, name: &str, measured: Option<String>) {
    table.row([name, measured.as_deref().unwrap_or(NOT_MEASURED)]);
}

fn rates(h1: &H1, table: &mut Columns) {
    let all = [
        ("reads of the pose", h1.get_pose),
        ("reads of the index", h1.current_index),
        ("segments", h1.enqueue),
        ("segments, with reads between", h1.enqueue_polled),
    ];
    for (name, compared) in all {
        row(table, name, compared.map(rate));
    }
}

fn rate(one: RateComparison) -> String {
    let measured = format!("{:.1} /s", one.per_s);
    match (one.computed_per_s, one.ratio) {
        (Some(computed), Some(ratio)) => format!(
            "{measured}, {:.1} % of the {computed:.1} /s that the line allows",
            100.0 * ratio
        ),
        _ => measured,
    }
}

fn full_line(h2: &H2) -> String {
    let gap = if h2.in_a_row {
        "without a gap"
    } else {
        "with gaps"
    };
    format!(
        "{:.1} /s of the {:.1} /s that the line allows, {gap}",
        h2.enqueue_polled_per_s, h2.bound_per_s
    )
}

fn starvation(h3: &H3, table: &mut Columns) {
    let measured = |one: &Starvation| {
        let (rate, dry, looks) = (one.segments_per_s, one.dry_looks, one.looks);
        let fewest = match one.fewest_queued {
            Some(fewest) => format!(", at least {fewest} queued"),
            None => String::new(),
        };
        format!("{rate:.0} segments/s, queue empty in {dry} of {looks} samples{fewest}")
    };
    row(table, "drawing in 0.2 mm", Some(measured(&h3.dense)));
    row(table, "drawing in 0.5 mm", Some(measured(&h3.fast)));
}

fn stop(h4: &H4, table: &mut Columns) {
    let times = |p50: Option<f64>, p99: Option<f64>| {
        let text = |time: Option<f64>| time.map_or("?".to_owned(), |time| format!("{time:.2}"));
        format!("median {} ms; 99 % below {} ms", text(p50), text(p99))
    };
    let sent = times(h4.on_the_line_p50_ms, h4.on_the_line_p99_ms);
    row(table, "stop, until sent", Some(sent));
    let answered = times(h4.answered_p50_ms, h4.answered_p99_ms);
    row(table, "stop, until answered", Some(answered));
}

fn processor(h5: &H5) -> String {
    let percent = h5
        .core_percent
        .map_or("?".to_owned(), |percent| percent.to_string());
    format!(
        "{percent} % of a core at {:.0} segments/s",
        h5.segments_per_s
    )
}
