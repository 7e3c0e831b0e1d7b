//! Findings of the check of a program, as an object of JSON: the same for the command (`--check --json`) and for a station.
//!
//! Names and shapes are contracts: fields are added, none is renamed. Lengths are mm.

use std::time::Duration;

use magician::message;
use magician::preflight::doubt_in_words;
use magician::report::{ErrorFigures, FenceReport, SentenceReport, remedies};
use magician::{Action, ArmOutputs, GripperState, Remedy, Voice};
use magician_program::{
    AppliedPlacement, Diagnostic, DiagnosticCode, Format, PartSummary, PreparedProgram,
    RefusedStep, RemainingProgram, Report, WouldFit, would_do_at, would_fit, would_fit_turned,
};
use serde::Serialize;

/// Number of refused steps that are told, at most.
pub const SHOWN: usize = 10;
/// A job that takes longer than this is probably a mistake.
const LONG: Duration = Duration::from_secs(2 * 3600);

/// Findings of a check.
#[derive(Debug, Serialize)]
#[non_exhaustive]
pub struct CheckReport {
    /// True if the arm can do all of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ok: Option<bool>,
    /// Figures of what it does.
    #[serde(flatten)]
    pub estimate: Estimate,
    /// Number of refused steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refused: Option<usize>,
    /// Size in which a refused program would fit; `None` within if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub would_fit: Option<Option<WouldFit>>,
    /// The first refused steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub complaints: Option<Vec<Refusal>>,
    /// The fence of the arm, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fence: Option<FenceReport>,
    /// The file of its picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preview: Option<String>,
    /// Placement, if it was placed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub placed: Option<AppliedPlacement>,
    /// Parts, where they were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parts: Option<Vec<PartSummary>>,
    /// Notes on what was taken in a certain way.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<Note>,
}

/// The first refused step of each place in the file, no more than are told: what one line, row or element of a file becomes
/// is refused for the same reason.
#[must_use]
pub fn refused_places(report: &Report) -> Vec<&RefusedStep> {
    let mut places: Vec<&RefusedStep> = Vec::new();
    for refused_step in &report.refused_steps {
        let is_of = |other: &&RefusedStep| {
            let is_known = refused_step.origin.line > 0;
            is_known && (other.origin, &other.name) == (refused_step.origin, &refused_step.name)
        };
        if places.len() < SHOWN && !places.iter().any(is_of) {
            places.push(refused_step);
        }
    }
    places
}

impl CheckReport {
    /// Creates the report of a program with so many steps left (`None` without an end). `ok` is true if the arm can do all of
    /// it, or else holds what would do instead.
    #[must_use]
    fn new(report: &Report, steps: Option<u64>, ok: Result<bool, WayOut>) -> Self {
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

    /// Creates the report of what a check has found in the rest of a prepared program, with its notes and warnings.
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
            Err(WayOut::of(prepared, rest))
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

    /// Returns the estimate alone, without what is refused.
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
    /// Duration by the arm's clock, s. `None` if its end is not known.
    pub seconds: Option<f64>,
    /// Number of steps. `None` if it has no end.
    pub steps: Option<u64>,
    /// Length that is drawn or burnt, mm.
    pub drawn_mm: f64,
    /// Length of travel besides, mm.
    pub travel_mm: f64,
    /// Bounds of what draws or burns.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bounds: Option<Bounds>,
    /// Bounds of all motion.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub travel_bounds: Option<Bounds>,
    /// Power of what it burns.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub power: Option<PowerRange>,
}

/// Range of laser power, percent.
#[derive(Clone, Copy, Debug, Serialize)]
#[non_exhaustive]
pub struct PowerRange {
    /// At most.
    pub most: f64,
    /// At least.
    pub least: f64,
}

/// The least and the greatest coordinates of something, mm.
#[derive(Debug, Serialize)]
#[non_exhaustive]
pub struct Bounds {
    /// Away from the base.
    pub x: [f64; 2],
    /// To the left.
    pub y: [f64; 2],
    /// Up.
    pub z: [f64; 2],
}

/// A step that is refused.
#[derive(Debug, Serialize)]
#[non_exhaustive]
pub struct Refusal {
    /// Which, from 1.
    pub step: u64,
    /// Its line in the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<u32>,
    /// Its column in the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<u32>,
    /// Its element in the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The kind of the error.
    pub kind: &'static str,
    /// What is wrong.
    pub message: String,
    /// The same without the command before it, as data.
    #[serde(flatten)]
    pub sentence: SentenceReport,
    /// How far the place is beyond the reach, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beyond: Option<f64>,
    /// What it is about.
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
    /// Of a report, with the steps that are left.
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
    /// Of a step of a report.
    #[must_use]
    pub fn of(report: &Report, refused_step: &RefusedStep) -> Self {
        let place = refused_step.origin;
        let known = |value: u32| Some(value).filter(|value| *value > 0);
        let error = &refused_step.error;
        let mut figures = ErrorFigures::of(error);
        // The complaint has its own.
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

/// What a person can do about a program that is out of reach where it lies.
#[derive(Clone, Copy, Debug, Default)]
#[non_exhaustive]
pub struct WayOut {
    /// In which size it would fit there,
    pub straight: Option<WouldFit>,
    /// and turned, if it may be larger then.
    pub turned: Option<WouldFit>,
    /// Where it would fit in its size and turn.
    pub at: Option<[f64; 2]>,
}

impl WayOut {
    /// What would do for the rest of a prepared program that is refused.
    #[must_use]
    pub fn of(prepared: &PreparedProgram, rest: &RemainingProgram) -> Self {
        let placement = &prepared.setup.placement;
        if prepared.misfit.is_some() || placement.fit {
            // No other place or turn: the misfit says it itself, and what is made to fit has been tried at all of them.
            return Self {
                straight: prepared.would_fit,
                ..Self::default()
            };
        }
        let (plan, start) = (rest.first(), rest.start());
        // G-code in the arm's coordinates would be laid on a surface as well, with its Z.
        let moves = prepared.format != Format::Gcode || prepared.setup.places();
        let lies = (placement.scale, placement.rotate);
        let straight = would_fit(plan, start, lies.0, lies.1);
        Self {
            straight,
            turned: would_fit_turned(plan, start, lies, straight),
            at: moves.then(|| would_do_at(plan, start)).flatten(),
        }
    }

    /// In which size and turn it would fit there: the largest there is.
    #[must_use]
    pub fn would_fit(&self) -> Option<WouldFit> {
        self.turned.or(self.straight)
    }
}

/// Something that was read or done in a certain way.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Note {
    /// Which.
    pub code: &'static str,
    /// What, with what to do about it in the words of a program.
    pub text: String,
    /// What, without what to do about it, as data.
    #[serde(flatten)]
    pub sentence: SentenceReport,
    /// Advice that is no remedy, as data.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub help: Option<SentenceReport>,
    /// Its line in the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<u32>,
    /// Its element in the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub element: Option<String>,
    /// What to do about it.
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "remedies")]
    pub remedies: Vec<Remedy>,
}

/// What came of converting a program to another format.
#[derive(Debug, Serialize)]
#[non_exhaustive]
pub struct ConversionReport {
    /// The name of the program.
    pub from: String,
    /// The name of the new file.
    pub to: String,
    /// How many steps it has.
    pub steps: usize,
    /// What the new file cannot say.
    pub lost: Vec<String>,
    /// What of the program was taken in a certain way, and what the new file cannot say.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<Note>,
}

impl ConversionReport {
    /// Of a program of so many steps, with the notes of reading it and what the new file cannot say.
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
    /// All of them, each with what to do about it in these words.
    pub fn all<'p>(
        voice: &impl Voice,
        notes: impl IntoIterator<Item = &'p Diagnostic>,
    ) -> Vec<Self> {
        let told = |note: &Diagnostic| Self {
            code: note.code.name(),
            text: advised(voice, note.message.as_str().to_owned(), note),
            sentence: SentenceReport::of(&note.message),
            help: note.help.as_ref().map(SentenceReport::of),
            line: Some(note.origin.line).filter(|line| *line > 0),
            element: note.name.clone().filter(|name| !name.is_empty()),
            remedies: note.remedies.clone(),
        };
        notes.into_iter().map(told).collect()
    }
}

/// What is said of a problem or a note, with what to do about it in these words.
#[must_use]
pub fn advised(voice: &impl Voice, text: String, problem: &Diagnostic) -> String {
    match problem.advice(voice) {
        Some(advice) => format!("{text} ({advice})"),
        None => text,
    }
}

/// Note of a job whose progress cannot be kept ([`JobEvent::Unkept`](crate::JobEvent::Unkept)).
#[must_use]
pub fn unkept(cause: &str) -> Diagnostic {
    Diagnostic::of_file(message!(
        "the progress cannot be kept: {cause}: after a stop this job starts again from the beginning",
        cause
    ))
}

/// Outputs that a stop leaves switched on, each with what switches it off.
#[must_use]
pub fn left_on(outputs: &ArmOutputs) -> Vec<Diagnostic> {
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

/// What a check has found that is no refusal: [`warnings`] and [`doubts`].
#[must_use]
pub fn findings(report: &Report, placed: Option<AppliedPlacement>) -> Vec<Diagnostic> {
    let mut found = warnings(report, placed);
    found.extend(doubts(report));
    found
}

/// Of a job that is probably a mistake: scaled below a tenth, or more than two hours of work.
#[must_use]
pub fn warnings(report: &Report, placed: Option<AppliedPlacement>) -> Vec<Diagnostic> {
    let mut warnings = Vec::new();
    if let Some(placed) = placed.filter(AppliedPlacement::is_tiny) {
        let percent = 100.0 * placed.scale;
        let what = message!("it becomes very small: {percent:.1} % of its size", percent);
        warnings.push(Diagnostic::of_file(what).coded(DiagnosticCode::Placed));
    }
    if let Some(time) = report.time.filter(|time| *time > LONG) {
        let what = message!("it takes {time}", time = clock(time));
        warnings.push(Diagnostic::of_file(what).coded(DiagnosticCode::Long));
    }
    warnings
}

/// The steps of a program that this arm may be able to do, and another one may not.
#[must_use]
pub fn doubts(report: &Report) -> Vec<Diagnostic> {
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

/// A time as clocks show it: `0:07`, `2:05:09`.
#[must_use]
pub fn clock(time: Duration) -> String {
    let seconds = time.as_secs_f64().round() as u64;
    let (hours, minutes, seconds) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    match hours {
        0 => format!("{minutes}:{seconds:02}"),
        _ => format!("{hours}:{minutes:02}:{seconds:02}"),
    }
}
