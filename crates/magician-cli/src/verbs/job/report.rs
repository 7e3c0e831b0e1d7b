//! Results of a check, as text and as JSON.

use magician::report::ErrorFigures;
use magician::{ErrorKind, Given, Setting};
use magician_job::report::{
    Bounds, Estimate, FitOptions, PowerRange, format_duration, refused_places,
};
use magician_program::{
    Diagnostic, Format, RefusedStep, RemainingProgram, Report, WouldFit, foreign_coordinates,
};

use super::PreparedJob;
use crate::diagnostics::Severity;
use crate::failure::{Failure, Kind};

/// Summaries of a program for people.
pub(super) trait ForPeople {
    /// Returns the range of laser powers; `None` if nothing burns.
    fn power_line(&self) -> Option<String>;
    /// Returns time, steps and lengths.
    fn line(&self) -> String;
    /// Returns steps and lengths.
    fn work(&self) -> String;
    /// Returns the place on the table, if there is one.
    fn place(&self) -> Option<String>;
}

impl ForPeople for Estimate {
    fn power_line(&self) -> Option<String> {
        let PowerRange { most, least, .. } = self.power?;
        let [least, most] = [least, most].map(|percent| (percent * 10.0).round() / 10.0);
        Some(if least < most {
            format!("burns with {least} to {most} %")
        } else {
            format!("burns with {most} %")
        })
    }

    fn line(&self) -> String {
        let time = match self.seconds {
            Some(seconds) => {
                let time = std::time::Duration::from_secs_f64(seconds);
                format!("takes {} ({seconds:.1} s)", format_duration(time))
            }
            None => "time unknown (it homes, waits for an input, or begins at an unknown \
                position)"
                .to_owned(),
        };
        format!("{time}: {}", self.work())
    }

    fn work(&self) -> String {
        let steps = match self.steps {
            Some(1) => "1 step".to_owned(),
            Some(steps) => format!("{steps} steps"),
            None => "steps without end".to_owned(),
        };
        let (drawn, travelled) = (length(self.drawn_mm), length(self.travel_mm));
        format!("{steps}, {drawn} drawn, {travelled} travelled")
    }

    fn place(&self) -> Option<String> {
        let bounds = self.bounds.as_ref().or(self.travel_bounds.as_ref());
        let Bounds { x, y, z, .. } = bounds?;
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

impl PreparedJob {
    /// True if the file's coordinates are taken as the arm's and the first refused step is out of
    /// reach: the file could then be placed elsewhere.
    fn could_be_placed(&self, report: &Report) -> bool {
        let first = report.refused_steps.first();
        let is_beyond = first.is_some_and(|refused_step| refused_step.beyond().is_some());
        self.prepared.is_raw() && is_beyond
    }

    /// Returns the hint for the user; `None` if the note about a misfit has one already.
    fn told(&self, way_out: FitOptions) -> Option<String> {
        if self.prepared.misfit.is_some() {
            return None;
        }
        let at = (way_out.at).map(|[x, y]| format!("--at {x},{y} fits at this size"));
        let size = |would_fit: WouldFit| format!("--scale {} fits there", would_fit.scale);
        let straight = way_out.straight.map(size);
        let turned = way_out.turned.map(|turned| {
            let WouldFit { scale, rotate, .. } = turned;
            if scale < self.prepared.setup.placement.scale {
                format!("--rotate {rotate} --scale {scale} fits too")
            } else {
                format!("--rotate {rotate} fits at this size")
            }
        });
        let ways: Vec<String> = straight.into_iter().chain(turned).chain(at).collect();
        (!ways.is_empty()).then(|| format!("{}; --fit chooses place and size", ways.join("; ")))
    }
}

/// Converts a failed check into a failure: the misfit and the first complaints, drawn for people;
/// the first complaint for programs. Its kind is `CheckFailed` if `check` is set.
pub(super) fn failure(
    made: &PreparedJob,
    rest: &RemainingProgram,
    report: &Report,
    check: bool,
) -> Failure {
    let prepared = &made.prepared;
    // A G-code file with the origin of another machine is refused at many places. Its message
    // contains the remedy, so no other is given.
    let foreign = (prepared.format == Format::Gcode && prepared.is_raw())
        .then(|| foreign_coordinates(prepared.program.plan(), report))
        .flatten();
    let way_out = made
        .told(FitOptions::of(prepared, rest))
        .filter(|_| foreign.is_none());
    let source = &made.source;
    let problem = |refused_step: &RefusedStep| Diagnostic {
        message: sentence(made, report, refused_step).into(),
        ..Diagnostic::from(refused_step)
    };
    let is_foreign = foreign.is_some();
    let mut problems: Vec<Diagnostic> = (prepared.misfit.iter().cloned().chain(foreign))
        .chain(refused_places(report).into_iter().map(problem))
        .collect();
    if let Some(first) = problems.first_mut()
        && !is_foreign
        && made.could_be_placed(report)
    {
        *first = { first.clone() }
            .remedy(
                (Setting::Place, Given::On),
                "lays it where the arm reaches, if it is small enough",
            )
            .remedy((Setting::Fit, Given::On), "chooses its size as well");
    }
    let shown = if made.verbose { problems.len() } else { 1 };
    let drawn = problems.iter().take(shown);
    let mut drawn: Vec<String> = drawn
        .map(|problem| source.draw(problem, Severity::Error))
        .collect();
    let count = match report.refused {
        0 => "nothing was sent".to_owned(),
        1 => "1 step is refused; nothing was sent".to_owned(),
        all => format!("{all} steps are refused; nothing was sent"),
    };
    drawn.push(if shown < problems.len() {
        format!("{count} (-v shows the first of each line)")
    } else {
        count.clone()
    });
    let message = match problems.first() {
        Some(problem) => format!("{}: {problem}; {count}", source.name),
        None => count,
    };
    let first = report.refused_steps.first();
    let kind = first.map_or(ErrorKind::InvalidInput, |refused_step| {
        refused_step.error.kind()
    });
    let kind = if check {
        Kind::CheckFailed
    } else {
        Kind::Driver(kind)
    };
    let about = first.map(|refused_step| ErrorFigures::of(&refused_step.error));
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

/// Describes a refused step, in the terms of the file's format if possible.
fn sentence(made: &PreparedJob, report: &Report, refused_step: &RefusedStep) -> String {
    let error = &refused_step.error;
    let step = format!("step {}", report.number(refused_step.step));
    if let Some(beyond) = refused_step.beyond() {
        let words = match made.prepared.format {
            Format::Gcode | Format::Points => made.source.words(refused_step.origin.line),
            _ => None,
        };
        let what = words.unwrap_or(step);
        return format!("{what} is {beyond:.0} mm beyond the reach");
    }
    format!("{step}: {error}")
}
