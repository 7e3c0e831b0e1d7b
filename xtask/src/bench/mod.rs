//! What the virtual arm costs: figures that print themselves, for people or as JSON.
//!
//! Rates are of one core. Each is taken several times; the figure is the median, with the best beside it, which is
//! nearer to what an idle machine would give.

mod figure;
mod program;
mod speed;

use std::error::Error;
use std::path::Path;

use figure::{Figure, Report};

/// What can be measured, what it is, and how.
const PARTS: [(&str, &str, Measure); 3] = [
    (
        "ptp",
        "S1: arm-seconds a second, point to point",
        speed::ptp,
    ),
    ("cp", "S1: arm-seconds a second, continuous path", speed::cp),
    (
        "traced",
        "S2: arm-seconds a second, pose at 1 kHz",
        speed::traced,
    ),
];

type Measure = fn() -> Result<Vec<Figure>, Box<dyn Error>>;

/// Lines of help.
pub(crate) fn help() -> String {
    let parts = PARTS.map(|(name, says, _)| format!("    {name:<9}{says}\n"));
    parts.concat()
}

/// Measures what `words` name, everything without a name; `--json` prints one object a line.
pub(crate) fn run(words: &[String], _docs: &Path) -> Result<(), Box<dyn Error>> {
    let json = words.iter().any(|word| word == "--json");
    let wanted: Vec<&String> = words.iter().filter(|word| *word != "--json").collect();
    if let Some(unknown) =
        (wanted.iter()).find(|word| !PARTS.iter().any(|(name, ..)| name == **word))
    {
        return Err(format!("`{unknown}` cannot be measured; there is\n{}", help()).into());
    }
    let report = Report::new(json);
    for (name, says, measure) in PARTS {
        if wanted.is_empty() || wanted.iter().any(|word| *word == name) {
            report.title(says);
            for figure in measure()? {
                report.print(&figure);
            }
        }
    }
    Ok(())
}
