//! Results of the check of a program as a JSON object, shared by the command (`--check --json`) and
//! the station.
//!
//! Names and shapes are contracts: fields may be added, but not renamed. Lengths are in mm.

use std::time::Duration;

use magician::message;
use magician::preflight::doubt_in_words;
use magician::report::{ErrorFigures, FenceReport, SentenceReport, remedies};
use magician::{Action, ArmOutputs, GripperState, Remedy, Voice};
use magician_program::{
    AppliedPlacement, Diagnostic, DiagnosticCode, Format, PartSummary, PreparedProgram,
    RefusedStep, RemainingProgram, Report, WouldFit, would_fit, would_fit_at, would_fit_turned,
};
use serde::Serialize;

/// Largest number of refused steps in a report.
pub const MAX_LISTED_REFUSALS: usize = 10;
/// Duration above which a job is probably a mistake. A choice.
const LONG_JOB: Duration = Duration::from_secs(2 * 3600);

/// Result of a check.
#[derive(Debug, Serialize)]
#[non_exhaustive]
pub struct CheckReport {
    /// True if the arm can run the whole program.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ok: Option<bool>,
    /// Figures of the program.
    #[serde(flatten)]
    pub estimate: Estimate,
    /// Number of refused steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refused: Option<usize>,
    /// Size in which a refused program would fit. The inner value is `None` if there is no such
    /// size.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub would_fit: Option<Option<WouldFit>>,
    /// The first refused steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub complaints: Option<Vec<Refusal>>,
    /// The fence of the arm, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fence: Option<FenceReport>,
    /// Path of its preview.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preview: Option<String>,
    /// Placement that was applied, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub placed: Option<AppliedPlacement>,
    /// Parts, if requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parts: Option<Vec<PartSummary>>,
    /// Notes on assumptions and warnings.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<Note>,
}

/// First refused step of each place in the file, at most [`MAX_LISTED_REFUSALS`].
///
/// All steps made from one line, row or element of a file are refused for the same reason.
#[must_use]
pub fn refused_places(report: &Report) -> Vec<&RefusedStep> {
    let mut places: Vec<&RefusedStep> = Vec::new();
    for refused_step in &report.refused_steps {
        let is_of = |other: &&RefusedStep| {
            let is_known = refused_step.origin.line > 0;
            is_known && (other.origin, &other.name) == (refused_step.origin, &refused_step.name)
        };
        if places.len() < MAX_LISTED_REFUSALS && !places.iter().any(is_of) {
            places.push(refused_step);
        }
    }
    places
}

impl CheckReport {
    /// Creates the report of a program with `steps` left (`None` if endless). An `Err` in `ok`
    /// holds the changes that would make it fit.
    #[must_use]
    fn new(report: &Report, steps: Option<u64>, ok: Result<bool, FitOptions>) -> Self {
        let refusals = { refused_places(report).into_iter() }
            .map(|refused_step| Refusal::of(report, refused_step));
        Self {
            ok: Some(ok.unwrap_or(false)),
            estimate: Estimate::new(report, steps),
            refused: Some(report.refused),
            would_fit: ok.err().map(|way_out| way_out.would_fit()),
            complaints: Some(refusals.collect()),
            fence: None,
            preview: None,
            placed: None,
            parts: None,
            notes: Vec::new(),
        }
    }

    /// Creates the report of a check of the rest of a prepared program, with its notes and
    /// warnings.
    #[must_use]
    pub fn of(
        prepared: &PreparedProgram,
        rest: &RemainingProgram,
        report: &Report,
        voice: &impl Voice,
    ) -> Self {
        let ok = if report.is_good() && prepared.misfit.is_none() {
            Ok(true)
        } else {
            Err(FitOptions::of(prepared, rest))
        };
        let steps = prepared.program.steps();
        let steps = steps.map(|steps| steps.saturating_sub(rest.from()));
        let warnings = findings(report, prepared.placed);
        Self {
            fence: prepared.setup.fence.as_ref().map(FenceReport::from),
            placed: prepared.placed,
            notes: Note::all(voice, prepared.notes.iter().chain(&warnings)),
            ..Self::new(report, steps, ok)
        }
    }

    /// Drops the results of the check and keeps the estimate.
    #[must_use]
    pub fn without_check(self) -> Self {
        Self {
            ok: None,
            refused: None,
            would_fit: None,
            complaints: None,
            ..self
        }
    }
}

/// Figures of a program.
#[derive(Debug, Serialize)]
#[non_exhaustive]
pub struct Estimate {
    /// Duration by the arm's clock, s. `None` if endless or unknown.
    pub seconds: Option<f64>,
    /// Number of steps. `None` if endless.
    pub steps: Option<u64>,
    /// Length drawn or burnt, mm.
    pub drawn_mm: f64,
    /// Length of travel, mm.
    pub travel_mm: f64,
    /// Bounds of the drawn or burnt lines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bounds: Option<Bounds>,
    /// Bounds of all motion.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub travel_bounds: Option<Bounds>,
    /// Range of laser power.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub power: Option<PowerRange>,
}

/// Range of laser power, percent.
#[derive(Clone, Copy, Debug, Serialize)]
#[non_exhaustive]
pub struct PowerRange {
    /// Largest power.
    pub most: f64,
    /// Smallest power.
    pub least: f64,
}

/// Bounding box, mm.
#[derive(Debug, Serialize)]
#[non_exhaustive]
pub struct Bounds {
    /// Range of x, away from the base.
    pub x: [f64; 2],
    /// Range of y, to the left.
    pub y: [f64; 2],
    /// Range of z, upwards.
    pub z: [f64; 2],
}

/// Refused step.
#[derive(Debug, Serialize)]
#[non_exhaustive]
pub struct Refusal {
    /// Number of the step, from 1.
    pub step: u64,
    /// Line in the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<u32>,
    /// Column in the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<u32>,
    /// Element in the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Kind of the error.
    pub kind: &'static str,
    /// Error as a sentence.
    pub message: String,
    /// The same sentence without the command, as data.
    #[serde(flatten)]
    pub sentence: SentenceReport,
    /// Distance beyond the reach, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beyond: Option<f64>,
    /// Figures of the error.
    #[serde(flatten)]
    pub figures: ErrorFigures,
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
    /// Figures of a report; `steps` are those left.
    #[must_use]
    pub fn new(report: &Report, steps: Option<u64>) -> Self {
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
}

impl Refusal {
    /// Creates the entry for a refused step of `report`.
    #[must_use]
    pub fn of(report: &Report, refused_step: &RefusedStep) -> Self {
        let place = refused_step.origin;
        let known = |value: u32| Some(value).filter(|value| *value > 0);
        let error = &refused_step.error;
        let mut figures = ErrorFigures::of(error);
        // This entry has its own number of the step.
        figures.step = None;
        Self {
            step: report.number(refused_step.step),
            line: known(place.line),
            column: known(place.column),
            name: refused_step.name.clone(),
            kind: error.kind().name(),
            message: error.to_string(),
            sentence: SentenceReport::of(error.sentence()),
            beyond: refused_step.beyond(),
            figures,
        }
    }
}

/// Changes that would bring a program within reach.
#[derive(Clone, Copy, Debug, Default)]
#[non_exhaustive]
pub struct FitOptions {
    /// Size in which it would fit at its place and angle.
    pub straight: Option<WouldFit>,
    /// Size in which it would fit after a turn, if larger.
    pub turned: Option<WouldFit>,
    /// Position at which it would fit unchanged.
    pub at: Option<[f64; 2]>,
}

impl FitOptions {
    /// Finds the changes for the rest of a refused program.
    #[must_use]
    pub fn of(prepared: &PreparedProgram, rest: &RemainingProgram) -> Self {
        let placement = &prepared.setup.placement;
        if prepared.misfit.is_some() || placement.fit {
            // No other place or turn: a misfit states its own remedy, and with `fit` all places
            // were tried already.
            return Self {
                straight: prepared.would_fit,
                ..Self::default()
            };
        }
        let (plan, start) = (rest.first(), rest.start());
        // On a surface, G-code in arm coordinates would be moved together with its Z: no other
        // position is proposed.
        let moves = prepared.format != Format::Gcode || prepared.setup.places();
        let lies = (placement.scale, placement.rotate);
        let straight = would_fit(plan, start, lies.0, lies.1);
        Self {
            straight,
            turned: would_fit_turned(plan, start, lies, straight),
            at: moves.then(|| would_fit_at(plan, start)).flatten(),
        }
    }

    /// Largest size in which the program would fit at its place.
    #[must_use]
    pub fn would_fit(&self) -> Option<WouldFit> {
        self.turned.or(self.straight)
    }
}

/// Note on an assumption, or a warning.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Note {
    /// Name of its code.
    pub code: &'static str,
    /// Text, with the remedy in the words of the front end.
    pub text: String,
    /// Text without the remedy, as data.
    #[serde(flatten)]
    pub sentence: SentenceReport,
    /// Advice other than a remedy, as data.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub help: Option<SentenceReport>,
    /// Line in the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<u32>,
    /// Element in the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub element: Option<String>,
    /// Remedies.
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "remedies")]
    pub remedies: Vec<Remedy>,
}

/// Result of converting a program to another format.
#[derive(Debug, Serialize)]
#[non_exhaustive]
pub struct ConversionReport {
    /// Name of the program.
    pub from: String,
    /// Name of the new file.
    pub to: String,
    /// Number of steps.
    pub steps: usize,
    /// Features that the new format cannot express.
    pub lost: Vec<String>,
    /// Notes on assumptions about the program, and on features that the new format cannot express.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<Note>,
}

impl ConversionReport {
    /// Creates the report of a conversion; `read` are the notes of reading, `lost` what the new
    /// format cannot express.
    #[must_use]
    pub fn new(
        voice: &impl Voice,
        [from, to]: [String; 2],
        steps: usize,
        read: &[Diagnostic],
        lost: &[Diagnostic],
    ) -> Self {
        Self {
            from,
            to,
            steps,
            lost: lost.iter().map(ToString::to_string).collect(),
            notes: Note::all(voice, read.iter().chain(lost)),
        }
    }
}

impl Note {
    /// Converts notes, each with its remedy in the words of `voice`.
    pub fn all<'p>(
        voice: &impl Voice,
        notes: impl IntoIterator<Item = &'p Diagnostic>,
    ) -> Vec<Self> {
        let told = |note: &Diagnostic| Self {
            code: note.code.name(),
            text: with_advice(voice, note.message.as_str().to_owned(), note),
            sentence: SentenceReport::of(&note.message),
            help: note.help.as_ref().map(SentenceReport::of),
            line: Some(note.origin.line).filter(|line| *line > 0),
            element: note.name.clone().filter(|name| !name.is_empty()),
            remedies: note.remedies.clone(),
        };
        notes.into_iter().map(told).collect()
    }
}

/// Appends the advice of a problem or note, in the words of `voice`.
#[must_use]
pub fn with_advice(voice: &impl Voice, text: String, problem: &Diagnostic) -> String {
    match problem.advice(voice) {
        Some(advice) => format!("{text} ({advice})"),
        None => text,
    }
}

/// Note for a job whose progress cannot be stored
/// ([`JobEvent::NotStored`](crate::JobEvent::NotStored)).
#[must_use]
pub fn not_stored_note(cause: &str) -> Diagnostic {
    Diagnostic::of_file(message!(
        "the progress cannot be kept: {cause}: after a stop this job starts again from the beginning",
        cause
    ))
}

/// Notes for outputs that a stop leaves on, each with its remedy.
#[must_use]
pub fn outputs_left_on(outputs: &ArmOutputs) -> Vec<Diagnostic> {
    let mut left = Vec::new();
    if outputs.suction == Some(true) {
        let note = Diagnostic::of_file(message!("the suction cup is still on"));
        left.push(note.remedy(Action::SuctionOff, "switches it off"));
    }
    let gripper = match outputs.gripper {
        Some(GripperState::Closed) => {
            Some(message!("the gripper is still closed, and its pump runs"))
        }
        Some(GripperState::Open) => Some(message!("the gripper's pump still runs")),
        Some(GripperState::Off) | None => None,
    };
    if let Some(gripper) = gripper {
        let note = Diagnostic::of_file(gripper);
        left.push(note.remedy(Action::GripperOff, "switches its pump off"));
    }
    if outputs.pump_is_contested && left.is_empty() {
        let note = Diagnostic::of_file(message!("suction cup or gripper is still on"));
        let note = note.remedy(Action::SuctionOff, "switches the cup off");
        left.push(note.remedy(Action::GripperOff, "switches the pump off"));
    }
    let coded = |note: Diagnostic| note.coded(DiagnosticCode::LeftOn);
    left.into_iter().map(coded).collect()
}

/// Notes of a check besides refusals: [`warnings`] and [`arm_dependent_notes`].
#[must_use]
pub fn findings(report: &Report, placed: Option<AppliedPlacement>) -> Vec<Diagnostic> {
    let mut found = warnings(report, placed);
    found.extend(arm_dependent_notes(report));
    found
}

/// Warnings for a job that is probably a mistake: scaled below a tenth, or longer than two hours.
#[must_use]
pub fn warnings(report: &Report, placed: Option<AppliedPlacement>) -> Vec<Diagnostic> {
    let mut warnings = Vec::new();
    if let Some(placed) = placed.filter(AppliedPlacement::is_tiny) {
        let percent = 100.0 * placed.scale;
        let what = message!("it becomes very small: {percent:.1} % of its size", percent);
        warnings.push(Diagnostic::of_file(what).coded(DiagnosticCode::Placed));
    }
    if let Some(time) = report.time.filter(|time| *time > LONG_JOB) {
        let what = message!("it takes {time}", time = format_duration(time));
        warnings.push(Diagnostic::of_file(what).coded(DiagnosticCode::Long));
    }
    warnings
}

/// Notes for steps that some arms of this type can do and others cannot.
#[must_use]
pub fn arm_dependent_notes(report: &Report) -> Vec<Diagnostic> {
    let told = report.doubtful.iter().map(|doubtful| {
        let step = report.number(doubtful.step);
        let cause = doubt_in_words(&doubtful.cause);
        let what = match doubtful.count {
            0 | 1 => message!("step {step} leads where {cause}", step, cause),
            count => message!(
                "step {step} leads where {cause}; so do {more} more steps",
                step,
                cause,
                more = count - 1
            ),
        };
        let mut note = Diagnostic::of_file(what);
        note.origin = doubtful.origin;
        note.coded(DiagnosticCode::Doubtful)
    });
    told.collect()
}

/// Duration as `m:ss` or `h:mm:ss`: `0:07`, `2:05:09`.
#[must_use]
pub fn format_duration(time: Duration) -> String {
    let seconds = time.as_secs_f64().round() as u64;
    let (hours, minutes, seconds) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    match hours {
        0 => format!("{minutes}:{seconds:02}"),
        _ => format!("{hours}:{minutes:02}:{seconds:02}"),
    }
}
