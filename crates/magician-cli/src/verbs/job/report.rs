//! What a check has found, for people and for programs.

use magician::ErrorKind;
use magician_program::{
    Diagnostic, Format, RefusedStep, RemainingProgram, Report, WouldFit, would_do_at, would_fit,
    would_fit_turned,
};
use serde::Serialize;

use super::Made;
use super::tell::clock;
use crate::diagnostics::Severity;
use crate::failure::{Failure, Figures, Kind};

/// As many complaints are told.
pub(super) const SHOWN: usize = 10;

/// What a program does, in figures.
#[derive(Debug, Serialize)]
pub(super) struct Estimate {
    /// Of the arm's clock; none if it has no end that is known.
    seconds: Option<f64>,
    /// None if it goes on for ever.
    steps: Option<u64>,
    drawn_mm: f64,
    travel_mm: f64,
    /// Of what draws or burns.
    #[serde(skip_serializing_if = "Option::is_none")]
    bounds: Option<Bounds>,
    /// Of all.
    #[serde(skip_serializing_if = "Option::is_none")]
    travel_bounds: Option<Bounds>,
    #[serde(skip_serializing_if = "Option::is_none")]
    power: Option<PowerRange>,
}

/// What is burnt with, percent.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct PowerRange {
    most: f64,
    least: f64,
}

/// The least and the greatest coordinates of something.
#[derive(Debug, Serialize)]
struct Bounds {
    x: [f64; 2],
    y: [f64; 2],
    z: [f64; 2],
}

/// A step that is refused, as JSON has it.
#[derive(Debug, Serialize)]
pub(super) struct Refusal {
    step: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    line: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    column: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<String>,
    kind: &'static str,
    message: String,
    /// How far the place is beyond the reach, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    beyond: Option<f64>,
    #[serde(flatten)]
    figures: Figures,
}

fn rounded(value: f64) -> f64 {
    (value * 1000.0).round() / 1000.0
}

impl Bounds {
    fn new([least, most]: [[f64; 3]; 2]) -> Self {
        let range = |axis: usize| [least[axis], most[axis]].map(rounded);
        Self {
            x: range(0),
            y: range(1),
            z: range(2),
        }
    }
}

impl Estimate {
    pub(super) fn new(report: &Report, steps: Option<u64>) -> Self {
        Self {
            seconds: report.time.map(|time| time.as_secs_f64()),
            steps,
            drawn_mm: rounded(report.drawn),
            travel_mm: rounded(report.travelled),
            bounds: report.bounds.map(Bounds::new),
            travel_bounds: report.travel_bounds.map(Bounds::new),
            power: report.power.map(|power| {
                let [least, most] = power.map(rounded);
                PowerRange { most, least }
            }),
        }
    }

    pub(super) fn power_range(&self) -> Option<PowerRange> {
        self.power
    }

    /// With which powers it burns, for people.
    pub(super) fn power(&self) -> Option<String> {
        let PowerRange { most, least } = self.power?;
        let [least, most] = [least, most].map(|percent| (percent * 10.0).round() / 10.0);
        Some(match least < most {
            true => format!("burns with {least} to {most} %"),
            false => format!("burns with {most} %"),
        })
    }

    /// One line for people.
    pub(super) fn line(&self) -> String {
        let time = match self.seconds {
            Some(seconds) => {
                let time = std::time::Duration::from_secs_f64(seconds);
                format!("takes {} ({seconds:.1} s)", clock(time))
            }
            None => "time unknown (it homes, waits for an input, or begins at an unknown \
                position)"
                .to_owned(),
        };
        format!("{time}: {}", self.work())
    }

    /// Steps and lengths.
    pub(super) fn work(&self) -> String {
        let steps = match self.steps {
            Some(1) => "1 step".to_owned(),
            Some(steps) => format!("{steps} steps"),
            None => "steps without end".to_owned(),
        };
        let (drawn, travelled) = (length(self.drawn_mm), length(self.travel_mm));
        format!("{steps}, {drawn} drawn, {travelled} travelled")
    }

    /// Where it is, for people.
    pub(super) fn place(&self) -> Option<String> {
        let bounds = self.bounds.as_ref().or(self.travel_bounds.as_ref());
        let Bounds { x, y, z } = bounds?;
        let range = |name, [least, most]: [f64; 2]| format!("{name} {least:.1} to {most:.1}");
        Some(format!(
            "{}, {}, {} mm",
            range("x", *x),
            range("y", *y),
            range("z", *z)
        ))
    }
}

fn length(mm: f64) -> String {
    match mm {
        mm if mm >= 1000.0 => format!("{:.2} m", mm / 1000.0),
        mm => format!("{mm:.0} mm"),
    }
}

impl Refusal {
    pub(super) fn of(report: &Report, refused_step: &RefusedStep) -> Self {
        let place = refused_step.origin;
        let known = |value: u32| Some(value).filter(|value| *value > 0);
        let error = &refused_step.error;
        let mut figures = Figures::of(error);
        // The complaint has its own.
        figures.step = None;
        Self {
            step: report.number(refused_step.step),
            line: known(place.line),
            column: known(place.column),
            name: refused_step.name.clone(),
            kind: error.kind().name(),
            message: error.to_string(),
            beyond: refused_step.beyond(),
            figures,
        }
    }
}

/// What a person can do about a file that is out of reach where it lies.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct WayOut {
    /// In which size it would fit there,
    straight: Option<WouldFit>,
    /// and turned, if it may be larger then.
    turned: Option<WouldFit>,
    /// Where it would fit in its size and turn.
    at: Option<[f64; 2]>,
}

impl WayOut {
    /// In which size and turn it would fit there: the largest there is.
    pub(super) fn would_fit(&self) -> Option<WouldFit> {
        self.turned.or(self.straight)
    }
}

impl Made {
    /// What would do for the rest of it, which is refused.
    pub(super) fn way_out(&self, rest: &RemainingProgram) -> WayOut {
        let placement = &self.setup.placement;
        if self.misfit.is_some() || placement.fit {
            // The misfit says it itself.
            return WayOut {
                straight: self.would_fit,
                ..WayOut::default()
            };
        }
        let (plan, start) = (rest.first(), rest.start());
        // G-code in the arm's coordinates would be laid on a surface as well, with its Z.
        let moves = self.format != Format::Gcode || self.setup.places();
        let lies = (placement.scale, placement.rotate);
        let straight = would_fit(plan, start, lies.0, lies.1);
        WayOut {
            straight,
            turned: would_fit_turned(plan, start, lies, straight),
            at: moves.then(|| would_do_at(plan, start)).flatten(),
        }
    }

    /// The hint for the user; a drawing that does not fit brings its own.
    fn told(&self, way_out: WayOut) -> Option<String> {
        if self.misfit.is_some() {
            return None;
        }
        let at = (way_out.at).map(|[x, y]| format!("--at {x},{y} fits at this size"));
        let size = |would_fit: WouldFit| format!("--scale {} fits there", would_fit.scale);
        let straight = way_out.straight.map(size);
        let turned = way_out.turned.map(|turned| {
            let WouldFit { scale, rotate, .. } = turned;
            match scale < self.setup.placement.scale {
                true => format!("--rotate {rotate} --scale {scale} fits too"),
                false => format!("--rotate {rotate} fits at this size"),
            }
        });
        let ways: Vec<String> = straight.into_iter().chain(turned).chain(at).collect();
        (!ways.is_empty()).then(|| format!("{}; --fit chooses place and size", ways.join("; ")))
    }
}

/// Why it is refused, as a failure: that it does not fit and the first complaints, drawn for people, the first of all for
/// programs. Of kind `check` if it was only looked at.
pub(super) fn failure(made: &Made, report: &Report, check: bool, way_out: WayOut) -> Failure {
    let way_out = made.told(way_out);
    let source = &made.source;
    let problem = |refused_step: &RefusedStep| Diagnostic {
        message: sentence(made, report, refused_step),
        ..Diagnostic::from(refused_step)
    };
    let problems: Vec<Diagnostic> = (made.misfit.iter().cloned())
        .chain(report.refused_steps.iter().take(SHOWN).map(problem))
        .collect();
    let drawn = problems.iter();
    let mut drawn: Vec<String> = drawn
        .map(|problem| source.draw(problem, Severity::Error))
        .collect();
    let (all, shown) = (report.refused, report.refused_steps.len().min(SHOWN));
    let count = match (all, shown < all) {
        (0, _) => "nothing was sent".to_owned(),
        (1, _) => "1 step is refused; nothing was sent".to_owned(),
        (all, false) => format!("{all} steps are refused; nothing was sent"),
        (all, true) => {
            format!("{all} steps are refused, the first {shown} are shown; nothing was sent")
        }
    };
    drawn.push(count.clone());
    let message = match problems.first() {
        Some(problem) => format!("{}: {problem}; {count}", source.name),
        None => count,
    };
    let first = report.refused_steps.first();
    let kind = first.map_or(ErrorKind::InvalidInput, |refused_step| {
        refused_step.error.kind()
    });
    let kind = match check {
        true => Kind::CheckFailed,
        false => Kind::Driver(kind),
    };
    let about = first.map(|refused_step| Figures::of(&refused_step.error));
    let mut about = about.unwrap_or_default();
    about.remedies = (problems.first()).map_or_else(Vec::new, |problem| problem.remedies.clone());
    let failure = Failure::new(kind, message)
        .about(about)
        .drawn(drawn.join("\n"));
    match way_out {
        Some(way_out) => failure.hint(way_out),
        None => failure,
    }
}

/// What is wrong, with the step and by how much, in the words of the file where it has words.
fn sentence(made: &Made, report: &Report, refused_step: &RefusedStep) -> String {
    let error = &refused_step.error;
    let step = format!("step {}", report.number(refused_step.step));
    if let Some(beyond) = refused_step.beyond() {
        let words = match made.format {
            Format::Gcode | Format::Points => made.source.words(refused_step.origin.line),
            _ => None,
        };
        let what = words.unwrap_or(step);
        return format!("{what} is {beyond:.0} mm beyond the reach: {error}");
    }
    let over = match (error.value(), error.limit(), error.unit()) {
        (Some(value), Some(limit), Some(unit)) => {
            let by = (value - limit).abs();
            format!(" ({by:.1} {unit} beyond)")
        }
        _ => String::new(),
    };
    format!("{step}: {error}{over}")
}
