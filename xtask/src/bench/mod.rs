//! Benchmarks of the virtual arm, printed for people or as JSON.
//!
//!
//! Rates are for one core. Each is measured several times; the figure is the median. The best is
//! given too, since it is closer to an idle machine.

pub(crate) mod figure;
mod many_arms;
mod memory;
mod pacing;
mod program;
mod scaling;
mod speed;
mod stepped;
mod vendor_library;

use std::error::Error;
use std::path::Path;

use figure::{Figure, Report};

/// Parts that can be measured: name, description, function.
const PARTS: [(&str, &str, Measure); 9] = [
    // First, because memory freed by other parts would be reused without a request to the system.
    ("s4", "S4: memory of an idle arm", |_| memory::measure()),
    ("ptp", "S1: arm-seconds a second, point to point", |_| {
        speed::ptp()
    }),
    ("cp", "S1: arm-seconds a second, continuous path", |_| {
        speed::cp()
    }),
    ("traced", "S2: arm-seconds a second, pose at 1 kHz", |_| {
        speed::polled()
    }),
    ("stepped", "beside a simulation in steps", |_| {
        stepped::measure()
    }),
    ("s3", "S3: arms in real time", |_| many_arms::measure()),
    ("s6", "S6: pacing at 115200 baud", |_| pacing::measure()),
    (
        "door",
        "calls a second through the vendor's C interface",
        vendor_library::measure,
    ),
    (
        "scaling",
        "one arm to many; draws docs/pictures/scaling.svg",
        scaling::measure,
    ),
];

/// Function that measures a part. It may write a picture into the documentation.
type Measure = fn(&Path) -> Result<Vec<Figure>, Box<dyn Error>>;

/// Returns the lines of help.
pub(crate) fn help() -> String {
    let parts = PARTS.map(|(name, says, _)| format!("    {name:<9}{says}\n"));
    parts.concat()
}

/// Measures the named parts, or all without names. `--json` prints one object per line.
pub(crate) fn run(words: &[String], docs: &Path) -> Result<(), Box<dyn Error>> {
    let json = words.iter().any(|word| word == "--json");
    let wanted: Vec<&String> = words.iter().filter(|word| *word != "--json").collect();
    if let Some(unknown) =
        (wanted.iter()).find(|word| !PARTS.iter().any(|(name, ..)| name == **word))
    {
        return Err(format!("`{unknown}` cannot be measured; known are\n{}", help()).into());
    }
    let report = Report::new(json);
    for (name, says, measure) in PARTS {
        if wanted.is_empty() || wanted.iter().any(|word| *word == name) {
            report.title(says);
            for figure in measure(docs)? {
                report.print(&figure);
            }
        }
    }
    Ok(())
}
