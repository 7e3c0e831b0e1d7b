//! Measured figures and their output.

use std::time::Instant;

/// Measured number.
pub(crate) struct Figure {
    /// Short and stable name, for programs that parse the output.
    name: String,
    value: f64,
    unit: &'static str,
    /// Additional numbers.
    more: Vec<(&'static str, f64)>,
    goal: Option<Goal>,
}

/// Goal of a figure.
enum Goal {
    AtLeast(f64),
    AtMost(f64),
}

impl Figure {
    pub(crate) fn new(name: impl Into<String>, value: f64, unit: &'static str) -> Self {
        Self {
            name: name.into(),
            value,
            unit,
            more: Vec::new(),
            goal: None,
        }
    }

    pub(crate) fn with(mut self, name: &'static str, value: f64) -> Self {
        self.more.push((name, value));
        self
    }

    pub(crate) fn at_least(mut self, goal: f64) -> Self {
        self.goal = Some(Goal::AtLeast(goal));
        self
    }

    pub(crate) fn at_most(mut self, goal: f64) -> Self {
        self.goal = Some(Goal::AtMost(goal));
        self
    }

    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    pub(crate) fn is_missed(&self) -> bool {
        self.goal().is_some_and(|(_, _, met)| !met)
    }

    fn goal(&self) -> Option<(&'static str, f64, bool)> {
        match self.goal.as_ref()? {
            Goal::AtLeast(goal) => Some(("at least", *goal, self.value >= *goal)),
            Goal::AtMost(goal) => Some(("at most", *goal, self.value <= *goal)),
        }
    }

    fn line(&self) -> String {
        let mut line = format!(
            "  {:<34}{:>12} {}",
            self.name,
            format_number(self.value),
            self.unit
        );
        for (name, value) in &self.more {
            line += &format!(", {name} {}", format_number(*value));
        }
        if let Some((word, goal, met)) = self.goal() {
            let met = if met { "met" } else { "MISSED" };
            line += &format!(" (goal {word} {}: {met})", format_number(goal));
        }
        line
    }

    fn json(&self) -> String {
        let Self {
            name, value, unit, ..
        } = self;
        let mut text = format!("{{\"name\":\"{name}\",\"value\":{value},\"unit\":\"{unit}\"");
        for (name, value) in &self.more {
            text += &format!(",\"{name}\":{value}");
        }
        if let Some((word, goal, met)) = self.goal() {
            text += &format!(",\"goal\":\"{word} {goal}\",\"met\":{met}");
        }
        text + "}"
    }
}

/// Formats a number with its significant digits and a thousands separator.
fn format_number(value: f64) -> String {
    let decimals = match value.abs() {
        100.0.. => 0,
        10.0.. => 1,
        1.0.. => 2,
        _ => 4,
    };
    let text = format!("{value:.decimals$}");
    let (whole, part) = text.split_at(text.find('.').unwrap_or(text.len()));
    let (sign, digits) = whole.split_at(usize::from(whole.starts_with('-')));
    let mut apart = String::new();
    for (at, digit) in digits.chars().enumerate() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            apart.push(',');
        }
        apart.push(digit);
    }
    format!("{sign}{apart}{part}")
}

/// Output of figures.
pub(crate) struct Report {
    json: bool,
}

impl Report {
    pub(crate) fn new(json: bool) -> Self {
        Self { json }
    }

    pub(crate) fn title(&self, says: &str) {
        if !self.json {
            println!("{says}");
        }
    }

    pub(crate) fn print(&self, figure: &Figure) {
        println!(
            "{}",
            if self.json {
                figure.json()
            } else {
                figure.line()
            }
        );
    }
}

/// Measured rounds per rate. A round before them warms up the caches.
const ROUNDS: usize = 9;

/// Returns median and best of the rates of several rounds, per second. `work` returns the amount of
/// work done in a round.
pub(crate) fn rate(mut work: impl FnMut() -> f64) -> (f64, f64) {
    work();
    let mut rates: Vec<f64> = (0..ROUNDS)
        .map(|_| {
            let began = Instant::now();
            let done = work();
            done / began.elapsed().as_secs_f64()
        })
        .collect();
    rates.sort_by(f64::total_cmp);
    (rates[ROUNDS / 2], rates[ROUNDS - 1])
}
