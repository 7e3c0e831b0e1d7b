//! Programs for jobs: how they come, who reads them, and what is kept of jobs.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use magician::Voice;
use magician::report::FenceReport;
use magician::words::Preflight;
use magician_job::report::{CheckReport, Note, WayOut, warnings};
use magician_job::{Journal, NoJournal};
use magician_program::{
    AppliedPlacement, Diagnostic, Ending, Format, Missing, Plan, Program, ReadOptions,
    RemainingProgram, Report, Setup, Surface, WouldFit,
};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::api::RpcError;

/// A program as a client sends it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum SourceBytes {
    /// Text.
    Text(String),
    /// Bytes in base64.
    Data(String),
}

/// A program as a client sends it, and what it says of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Source {
    /// The file.
    #[serde(flatten)]
    pub bytes: SourceBytes,
    /// Its format, if it was said.
    pub format: Option<String>,
}

impl Source {
    /// The bytes of the file.
    ///
    /// # Errors
    /// An error of the parameter `data` for what is no base64.
    pub fn bytes(&self) -> Result<Vec<u8>, RpcError> {
        match &self.bytes {
            SourceBytes::Text(text) => Ok(text.clone().into_bytes()),
            SourceBytes::Data(data) => STANDARD
                .decode(data)
                .map_err(|_| RpcError::param("data", "`data` must be bytes in base64")),
        }
    }
}

/// A program that has been read and laid before an arm.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ReadProgram {
    /// What it does, once.
    pub plan: Plan,
    /// What it was read as.
    pub format: Format,
    /// How it was laid.
    pub setup: Setup,
    /// What becomes of the pen.
    pub ending: Ending,
    /// What of it was taken in a certain way.
    pub notes: Vec<Diagnostic>,
    /// How it lies, if it was placed.
    pub placed: Option<AppliedPlacement>,
    /// Why it does not fit there.
    pub misfit: Option<Diagnostic>,
    /// In which size it would.
    pub would_fit: Option<WouldFit>,
}

/// Makes a program of what a client sends. It may take its time: it is asked beside what the arm does.
pub trait Reader: Send + Sync {
    /// Reads one, for an arm that is a virtual one or not.
    ///
    /// # Errors
    /// What is wrong with it, as it is answered.
    fn read(&self, source: &Source, is_virtual: bool) -> Result<ReadProgram, RpcError>;
}

/// Reads the formats that are built into `magician-program`: plans always.
#[derive(Clone, Debug, Default)]
pub struct FormatReader {
    /// What is said of every program.
    pub setup: Setup,
    /// What becomes of pen and arm at the end of each.
    pub ending: Ending,
}

impl Reader for FormatReader {
    fn read(&self, source: &Source, is_virtual: bool) -> Result<ReadProgram, RpcError> {
        let bytes = source.bytes()?;
        let format = match &source.format {
            Some(format) => format
                .parse()
                .map_err(|error: String| RpcError::param("format", error))?,
            None => Format::of("", &bytes).ok_or_else(|| {
                let why = "the type of the program is not recognised: name it";
                RpcError::param("format", why)
            })?,
        };
        let mut setup = self.setup.clone();
        if is_virtual {
            setup.default_surface = setup.default_surface.or(Some(Surface::VIRTUAL));
        }
        let mut options = ReadOptions::default();
        setup.prepare(&mut options.gcode, setup.known_surface());
        let wrong = |problem: Diagnostic| RpcError::from(magician::Error::from(problem));
        let read = magician_program::read(format, &bytes, &options).map_err(wrong)?;
        let lacks_start = |note: &Diagnostic| note.missing == Some(Missing::Start);
        if read.notes.iter().any(lacks_start) {
            let why = "the program depends on where the tool is when it begins";
            return Err(RpcError::arm(magician::ErrorKind::InvalidInput, why));
        }
        let made = setup.plan(format, read.content).map_err(wrong)?;
        if made.plan.steps.is_empty() {
            let why = "nothing to do in this program";
            return Err(RpcError::arm(magician::ErrorKind::InvalidInput, why));
        }
        let ending = Ending {
            drawing: format.needs_homed_arm(),
            ..self.ending
        };
        Ok(ReadProgram {
            plan: made.plan,
            format,
            ending,
            notes: read.notes.into_iter().chain(made.notes).collect(),
            placed: made.placed,
            misfit: made.misfit,
            would_fit: made.would_fit,
            setup,
        })
    }
}

impl ReadProgram {
    /// The program, repeated so often; without end if `None`.
    #[must_use]
    pub fn program(&self, loops: Option<u64>) -> Program {
        Program::new(self.plan.clone(), loops)
    }

    /// Checks it from where an arm stands: the object of a check.
    ///
    /// # Errors
    /// What makes it no program from there.
    pub fn check(&self, start: Preflight) -> Result<CheckReport, RpcError> {
        let rest = self.program(Some(1)).remaining(0, start);
        let rest = rest.map_err(|problem| RpcError::from(magician::Error::from(problem)))?;
        let report = rest.check();
        Ok(self.report(&rest, &report))
    }

    /// What a check has found.
    #[must_use]
    pub fn report(&self, rest: &RemainingProgram, report: &Report) -> CheckReport {
        let ok = match (&self.misfit, report.is_good()) {
            (None, true) => Ok(true),
            (Some(_), _) => Err(WayOut::scaled(self.would_fit)),
            (None, false) => Err(WayOut::of(rest, &self.setup, self.format)),
        };
        let steps = self.plan.steps.len() as u64;
        let mut found = CheckReport::new(report, Some(steps), ok);
        found.fence = self.setup.fence.as_ref().map(FenceReport::from);
        found.placed = self.placed;
        let warnings = warnings(report, self.placed);
        found.notes = Note::all(&Words, self.notes.iter().chain(&warnings));
        found
    }
}

/// The words of the API: names of methods' parameters.
struct Words;

impl Voice for Words {
    fn action(&self, action: magician::Action) -> String {
        action.name().to_owned()
    }

    fn give(&self, setting: magician::Setting, given: &magician::Given) -> String {
        match given {
            magician::Given::On => format!("{}: true", setting.name()),
            magician::Given::Off => format!("{}: false", setting.name()),
            given => format!("{}: {given}", setting.name()),
        }
    }

    fn setting(&self, setting: magician::Setting) -> String {
        setting.name().to_owned()
    }
}

/// Keeps jobs beyond the life of a station.
pub trait JobStore: Send + Sync {
    /// What was kept last; null if nothing was, or it cannot be read.
    fn load(&self) -> Value;

    /// Keeps this instead. What goes wrong costs what is kept, and nothing else.
    fn save(&self, jobs: &Value);

    /// A journal for a job.
    fn journal(&self) -> Box<dyn Journal>;
}

/// Keeps nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoStore;

impl JobStore for NoStore {
    fn load(&self) -> Value {
        Value::Null
    }

    fn save(&self, _: &Value) {}

    fn journal(&self) -> Box<dyn Journal> {
        Box::new(NoJournal)
    }
}
