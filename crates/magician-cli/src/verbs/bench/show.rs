//! The figures as a table for people.

use super::figures::{Compared, Figures, H1, H2, H3, H4, H5, Starvation};
use crate::columns::{Columns, GAP, note};
use crate::failure::Failure;
use crate::output::Output;

/// What stands where nothing was measured.
const NONE: &str = "not measured";

pub(super) fn write(figures: &Figures, out: &mut Output) -> Result<(), Failure> {
    let mut head = Columns::default();
    head.row(["port", &figures.port]);
    head.row(["window", &figures.window.to_string()]);
    head.row(["line", &line(figures)]);
    head.write(out)?;
    out.line("")?;
    let mut table = Table::default();
    table.row(["", "measured", "goal", ""]);
    match &figures.h1 {
        Some(h1) => rates(h1, &mut table),
        None => table.row(["h1", NONE, "", ""]),
    }
    row(
        &mut table,
        "h2 full line",
        figures.h2.as_ref().map(full_line),
    );
    match &figures.h3 {
        Some(h3) => starvation(h3, &mut table),
        None => row(&mut table, "h3 starvation", None),
    }
    match &figures.h4 {
        Some(h4) => stop(h4, &mut table),
        None => row(&mut table, "h4 stop", None),
    }
    row(
        &mut table,
        "h5 processor",
        figures.h5.as_ref().map(processor),
    );
    let added = figures.h7.as_ref().map(|added| {
        let measured = format!(
            "+{} us p50, +{} us p99",
            added.added_p50_us, added.added_p99_us
        );
        let goal = format!("+{} us, +{} us", added.goal_p50, added.goal_p99);
        [measured, goal, met(Some(added.met))]
    });
    row(&mut table, "h7 added latency", added);
    table.write(out)?;
    match figures.drawn {
        true => Ok(()),
        false => note(
            "the arm did not draw; with --yes it does: rings of 20 mm through where it stands",
            out,
        ),
    }
}

/// Name, measured, goal, whether it is met; on a narrow terminal the goal stands below.
#[derive(Default)]
struct Table(Vec<[String; 4]>);

impl Table {
    fn row(&mut self, cells: [&str; 4]) {
        self.0.push(cells.map(str::to_owned));
    }

    fn write(&self, out: &mut Output) -> Result<(), Failure> {
        let widest = |column: usize| {
            let cells = self.0.iter().filter_map(|row| row.get(column));
            cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        let wide = (0..4).map(widest).sum::<usize>() + 3 * GAP <= out.width();
        let mut columns = Columns::default();
        for [name, measured, goal, met] in &self.0 {
            match wide {
                true => columns.row([name, measured, goal, met]),
                false if name.is_empty() => {}
                false => {
                    columns.row([name, measured]);
                    if !goal.is_empty() {
                        columns.row(["", format!("goal {goal}  {met}").trim_end()]);
                    }
                }
            }
        }
        columns.write(out)
    }
}

fn line(figures: &Figures) -> String {
    let Some(turnaround) = figures.turnaround_ms else {
        return NONE.to_owned();
    };
    let jitter = figures.jitter_ms.unwrap_or_default();
    match (figures.line_baud, figures.computed_for_ms) {
        (Some(baud), Some(known)) => {
            format!(
                "{baud} baud, turnaround {turnaround} ms, jitter {jitter} ms; computed for {known} ms"
            )
        }
        _ => format!(
            "bytes take no time, turnaround {turnaround} ms, jitter {jitter} ms; nothing to compute with"
        ),
    }
}

fn row(table: &mut Table, name: &str, cells: Option<[String; 3]>) {
    match cells {
        Some([measured, goal, met]) => table.row([name, &measured, &goal, &met]),
        None => table.row([name, NONE, "", ""]),
    }
}

fn met(met: Option<bool>) -> String {
    match met {
        Some(true) => "met",
        Some(false) => "not met",
        None => "",
    }
    .to_owned()
}

fn rates(h1: &H1, table: &mut Table) {
    let all = [
        ("h1 GetPose", h1.get_pose),
        ("   current index", h1.current_index),
        ("   segments", h1.enqueue),
        ("   segments, polled", h1.enqueue_polled),
    ];
    for (name, compared) in all {
        row(table, name, compared.map(|one| rate(one, h1.goal)));
    }
}

fn rate(one: Compared, goal: f64) -> [String; 3] {
    let measured = format!("{:.1} /s", one.per_s);
    match (one.computed_per_s, one.ratio) {
        (Some(computed), Some(ratio)) => [
            format!("{measured}, {:.1} % of {computed:.1}", 100.0 * ratio),
            format!("{} %", 100.0 * goal),
            met(Some(ratio >= goal)),
        ],
        _ => [measured, String::new(), String::new()],
    }
}

fn full_line(h2: &H2) -> [String; 3] {
    let gap = if h2.in_a_row { "no gap" } else { "with gaps" };
    let measured = format!(
        "{:.1} /s of {:.1}, {gap}",
        h2.enqueue_polled_per_s, h2.bound_per_s
    );
    [measured, format!("{} /s", h2.goal), met(Some(h2.met))]
}

fn starvation(h3: &H3, table: &mut Table) {
    let cells = |one: &Starvation, goal: &str, met| {
        let fewest = one
            .fewest_queued
            .map_or("?".to_owned(), |fewest| fewest.to_string());
        let (rate, dry, looks) = (one.segments_per_s, one.dry_looks, one.looks);
        let measured =
            format!("{rate:.0} /s, dry in {dry} of {looks} looks, least {fewest} queued");
        Some([measured, goal.to_owned(), met])
    };
    row(
        table,
        "h3 0.2 mm segments",
        cells(&h3.dense, "450 /s, never dry", met(h3.met)),
    );
    row(
        table,
        "   0.5 mm segments",
        cells(&h3.fast, "200 /s, never dry", String::new()),
    );
}

fn stop(h4: &H4, table: &mut Table) {
    let times = |p50: Option<f64>, p99: Option<f64>| {
        let text = |time: Option<f64>| time.map_or("?".to_owned(), |time| format!("{time:.2}"));
        format!("{} ms p50, {} ms p99", text(p50), text(p99))
    };
    let sent = times(h4.on_the_line_p50_ms, h4.on_the_line_p99_ms);
    row(
        table,
        "h4 stop on the line",
        Some([sent, format!("{:.2} ms p99", h4.goal), met(h4.met)]),
    );
    let answered = times(h4.answered_p50_ms, h4.answered_p99_ms);
    row(
        table,
        "   and answered",
        Some([answered, String::new(), String::new()]),
    );
}

fn processor(h5: &H5) -> [String; 3] {
    let percent = h5
        .core_percent
        .map_or("?".to_owned(), |percent| percent.to_string());
    let measured = format!(
        "{percent} % of a core at {:.0} segments/s",
        h5.segments_per_s
    );
    [measured, format!("{} %", h5.goal), met(h5.met)]
}
