//! List of the cases: a table in Markdown, or one JSON object per line.

use magician_conform::Case;

use super::record::Record;
use crate::context::Context;
use crate::failure::Failure;
use crate::output::Output;

pub(super) fn show(cases: &[&Case], context: &mut Context) -> Result<(), Failure> {
    let out = &mut context.out;
    if context.global.json {
        return cases
            .iter()
            .try_for_each(|case| out.json(&Record::listed(case)));
    }
    match context.global.verbose {
        0 => table(cases, out),
        _ => cases.iter().try_for_each(|case| case_details(case, out)),
    }
}

fn table(cases: &[&Case], out: &mut Output) -> Result<(), Failure> {
    out.line("| case | what it shows | confidence | source | tags |")?;
    out.line("|---|---|---|---|---|")?;
    cases.iter().try_for_each(|case| {
        let Case {
            id,
            title,
            confidence,
            source,
            ..
        } = case;
        let tags = case.tags().join(", ");
        out.line(format_args!(
            "| {id} | {title} | {confidence} | {source} | {tags} |"
        ))
    })
}

fn case_details(case: &Case, out: &mut Output) -> Result<(), Failure> {
    let paint = out.paint;
    out.line(format_args!(
        "{}",
        paint.name(format_args!("## {}", case.id))
    ))?;
    out.line("")?;
    out.line(format_args!(
        "{} ({}: {})",
        case.title, case.confidence, case.source
    ))?;
    let reasons = [
        ("not on a real arm", &case.hurts),
        ("only inside this program", &case.sim_only),
    ];
    for (what, reason) in reasons {
        if let Some(reason) = reason {
            out.line(format_args!("{what}: {reason}"))?;
        }
    }
    out.line("")?;
    for step in case.steps() {
        out.line(format_args!("    {step}"))?;
    }
    out.line("")
}
