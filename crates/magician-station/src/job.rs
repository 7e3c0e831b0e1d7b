//! Reading of programs for jobs, previews and checks.
//!
//! A client sends a program as text, as base64 or as a name in the library ([`Source`]). A
//! [`Reader`] turns it into a [`PreparedProgram`] for a particular arm ([`ReadingArm`]). Reading
//! takes time and may happen elsewhere ([`PendingResult`]), so the station never reads: engines do,
//! beside the driver. A program that depends on where the arm stands is read twice
//! ([`ProgramReading::NeedsStart`]).

use std::fmt;
use std::pin::Pin;
use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use magician::message;
use magician::preflight::Preflight;
use magician::{Fence, Message, Voice};
use magician_job::background::BackgroundTurns;
use magician_job::presets::Presets;
use magician_job::report::{CheckReport, ConversionReport, Note};
use magician_picture::{Conversion, ConversionError};
use magician_program::toolpath::Outline;
use magician_program::wire::FileAnswer;
use magician_program::{
    Diagnostic, Format, PartSummary, Preparation, PrepareRequest, PreparedProgram,
    RemainingProgram, Report, SetupDefaults, SetupOptions, StartPosition, Tool,
    foreign_coordinates, tip,
};
use magician_protocol::visible;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use crate::api::RpcError;
use crate::digest::digest;
use crate::files::{FilePreparation, FilePreparer, LocalPreparer};
use crate::library::{self, LibraryError, NoPrograms, ProgramName, ProgramStore};
use crate::presets;
use crate::reading::to_value;
use crate::surface::KnownSurface;

/// Most points of strokes, and of travels, in a preview. Longer lines are thinned out, so that a
/// message stays small.
const MAX_PREVIEW_POINTS: usize = 20_000;
/// Most parts listed in a check, and most characters of a part's name: both come from the client's
/// file, which does not bound them.
const MAX_PARTS: usize = 256;
const MAX_PART_NAME: usize = 200;

/// Content of a program as named by a client.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum SourceBytes {
    /// Text.
    Text(String),
    /// Base64 of the file.
    Data(String),
    /// Name of a program in the library.
    Program(String),
}

/// Program sent by a client, with format and options.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Source {
    /// Bytes or name of the file.
    #[serde(flatten)]
    pub bytes: SourceBytes,
    /// Format. `None` if the station shall recognise it.
    pub format: Option<String>,
    /// Options of drawing or engraving. `None` runs the program as it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub setup: Option<Box<SetupOptions>>,
    /// Name of the preset that fills in omitted options.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preset: Option<String>,
}

impl Source {
    /// Returns the bytes of the file, read from the library if it is named.
    ///
    /// # Errors
    /// An error of the parameter `data` if it is not base64, or of `program` if the library has no
    /// such program.
    pub fn bytes(&self, library: &dyn ProgramStore) -> Result<Vec<u8>, RpcError> {
        match &self.bytes {
            SourceBytes::Text(text) => Ok(text.clone().into_bytes()),
            SourceBytes::Data(data) => STANDARD
                .decode(data)
                .map_err(|_| RpcError::param("data", message!("`data` must be bytes in base64"))),
            SourceBytes::Program(name) => {
                let name = ProgramName::new(name).ok_or_else(library::unknown_program)?;
                library::bytes_of(library, &name).map_err(|error| match error {
                    LibraryError::Unknown => library::unknown_program(),
                    other => library::library_error(other),
                })
            }
        }
    }
}

impl SourceBytes {
    /// Returns the name in the library, or an empty string.
    pub(crate) fn name(&self) -> &str {
        match self {
            Self::Program(name) => name,
            Self::Text(_) | Self::Data(_) => "",
        }
    }
}

/// Options, and name of the preset that completes them.
pub(crate) type SetupAndPreset = (Option<Box<SetupOptions>>, Option<String>);

/// Parses the parameter `setup`. Errors name the parameter `setup.KEY`.
pub(crate) fn setup_and_preset(
    fields: Option<&Map<String, Value>>,
) -> Result<SetupAndPreset, RpcError> {
    let Some(fields) = fields else {
        return Ok((None, None));
    };
    let mut fields = fields.clone();
    let preset = match fields.remove("preset") {
        None => None,
        Some(Value::String(name)) => Some(name),
        Some(_) => {
            let why = message!("`setup`: preset must be the name of a preset");
            return Err(RpcError::param("setup.preset", why));
        }
    };
    let options = match preset {
        // With a preset, contradictions are not checked yet: it completes the options later.
        None => SetupOptions::from_fields(&fields),
        Some(_) => SetupOptions::from_partial_fields(&fields),
    };
    let options = options.map_err(|error| {
        let message = format!("`setup`: {}", visible(&error.message));
        RpcError::param(&format!("setup.{}", visible(&error.key)), message)
            .with_sentence(&error.message)
    })?;
    Ok((Some(Box::new(options)), preset))
}

/// The arm for which a program is read.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct ReadingArm {
    /// True for a virtual arm.
    pub is_virtual: bool,
    /// Fence of the arm.
    pub fence: Option<Fence>,
    /// Position at which the program started when it was read before, mm.
    pub start: Option<[f64; 3]>,
    /// Tool in force. Set if a frame is traced and the options name neither work nor tool.
    pub tool: Option<Tool>,
    /// Pose, tool and speeds of the arm, if the program depends on them.
    pub start_state: Option<Preflight>,
    /// Known heights of the work surface under the arm.
    pub surface: KnownSurface,
}

/// Future that resolves to the result of work done elsewhere. Dropping it cancels the work.
pub type PendingResult<T> = Pin<Box<dyn Future<Output = Result<T, RpcError>> + Send>>;

/// Result of reading a program.
#[non_exhaustive]
pub enum ProgramReading {
    /// The program, and the digest of what it was made of: its bytes, and the preset if one is
    /// named.
    Done(Box<PreparedProgram>, String),
    /// The program depends on the arm's position: read it again with [`ReadingArm::start_state`].
    NeedsStart,
    /// The program needs the height of its work surface, which is unknown. Kept apart from other
    /// errors because measuring requires a homed arm: an arm not homed gets the error about homing
    /// first.
    LacksSurface(RpcError),
    /// The program is being read elsewhere. Dropping the future cancels it.
    Pending(PendingResult<ProgramReading>),
}

/// Result of converting a program to another file.
#[non_exhaustive]
pub enum ConversionResult {
    /// Bytes of the new file, and the answer to the client.
    Done(Vec<u8>, Value),
    /// The program is being read elsewhere.
    Pending(PendingResult<ConversionResult>),
}

/// Turns what a client sent into a program. May take long: engines call it off the station's
/// thread.
pub trait Reader: Send + Sync {
    /// Reads a program for an arm.
    ///
    /// # Errors
    /// What is wrong with the program, as sent to the client.
    fn read(&self, source: &Source, arm: &ReadingArm) -> Result<ProgramReading, RpcError>;

    /// Returns the tool used when neither the program nor its options name one.
    fn default_tool(&self) -> Tool {
        Tool::Pen
    }

    /// Converts a program to a file with the name `to`, whose extension selects the format. Returns
    /// the bytes and the answer to the client.
    ///
    /// # Errors
    /// What is wrong with the program, or an unknown extension.
    fn convert(&self, source: &Source, to: &str) -> Result<ConversionResult, RpcError> {
        let _ = (source, to);
        let why = message!("this station converts no programs");
        Err(RpcError::arm(magician::ErrorKind::Unsupported, why))
    }
}

/// Reader for the formats compiled into `magician-program`. Plans are always included.
#[derive(Clone)]
pub struct FormatReader {
    defaults: SetupDefaults,
    library: Arc<dyn ProgramStore>,
    presets: Presets,
    files: Arc<dyn FilePreparer>,
}

impl Default for FormatReader {
    fn default() -> Self {
        Self::new(SetupDefaults::default())
    }
}

impl fmt::Debug for FormatReader {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FormatReader")
            .field("defaults", &self.defaults)
            .finish_non_exhaustive()
    }
}

impl FormatReader {
    /// Creates a reader with these defaults for settings that a program does not bring.
    #[must_use]
    pub fn new(defaults: SetupDefaults) -> Self {
        Self::with_preparer(defaults, Arc::new(LocalPreparer))
    }

    /// Creates a reader that prepares files with `files` instead of the compiled-in readers.
    #[must_use]
    pub fn with_preparer(defaults: SetupDefaults, files: Arc<dyn FilePreparer>) -> Self {
        Self {
            defaults,
            library: Arc::new(NoPrograms),
            presets: Presets::default(),
            files,
        }
    }

    /// Sets the library.
    #[must_use]
    pub fn with_library(mut self, library: Arc<dyn ProgramStore>) -> Self {
        self.library = library;
        self
    }

    /// Sets the presets. Without this call only the built-in ones exist.
    #[must_use]
    pub fn with_presets(mut self, presets: Presets) -> Self {
        self.presets = presets;
        self
    }

    /// Completes the options with the source's preset. Returns the preset's note for the user, and
    /// its text.
    fn apply_preset(
        &self,
        source: &Source,
        format: Format,
        options: &mut SetupOptions,
    ) -> Result<(Option<Diagnostic>, String), RpcError> {
        let Some(name) = &source.preset else {
            return Ok((None, String::new()));
        };
        let wrong = |error| presets::preset_error(error, "setup.preset");
        let preset = self.presets.load(name).map_err(wrong)?;
        let completed = preset.complete(options, Some(format));
        let (completed, told) = completed.map_err(|error| {
            RpcError::param("setup.preset", visible(&error.message).to_string())
                .with_sentence(&error.message)
        })?;
        *options = completed;
        Ok((told, preset.text))
    }

    /// Returns the request to prepare a program for an arm, and the digest of the program's bytes
    /// and of its preset. The digest detects a change of a program or preset that `source` only
    /// names.
    fn request(
        &self,
        source: &Source,
        arm: &ReadingArm,
        defaults: SetupDefaults,
    ) -> Result<(PrepareRequest, String), RpcError> {
        let bytes = source.bytes(&*self.library)?;
        let format = match &source.format {
            Some(format) => format
                .parse()
                .map_err(|error: String| RpcError::param("format", error))?,
            None => Format::of(source.bytes.name(), &bytes).ok_or_else(|| {
                if let Some(foreign) = magician_program::foreign(source.bytes.name(), &bytes) {
                    return RpcError::param("format", foreign.sentence());
                }
                let why = message!("the type of the program is not recognised: name it");
                RpcError::param("format", why)
            })?,
        };
        let mut request = PrepareRequest::new(format, &bytes);
        if let Some(options) = &source.setup {
            request.options = (**options).clone();
        }
        let (note, preset) = self.apply_preset(source, format, &mut request.options)?;
        request.preset_note = note;
        let digest = digest(&bytes, &[preset.as_bytes()]);
        // A resumed program keeps its first start position, or its steps would differ.
        request.options.start = request.options.start.or(arm.start);
        request.defaults = defaults;
        request.fence = arm.fence;
        request.tool = arm.tool;
        if !source.bytes.name().is_empty() {
            request.title = Format::title(source.bytes.name()).to_owned();
        } else if format == Format::Text {
            request.title = title_of_text(&bytes);
        }
        if let Some(stands) = &arm.start_state {
            let tool = request.options.tool.or(request.defaults.tool);
            request.start = tip(stands, tool).map_or(StartPosition::Unknown, StartPosition::At);
        }
        Ok((request, digest))
    }

    /// Prepares the program, here or elsewhere, and applies `done` to the outcome.
    fn prepare<T: 'static>(
        &self,
        request: PrepareRequest,
        done: impl FnOnce(FileAnswer) -> Result<T, RpcError> + Send + 'static,
        pending: impl FnOnce(PendingResult<T>) -> T,
    ) -> Result<T, RpcError> {
        match self.files.prepare(request) {
            FilePreparation::Ready(answer) => done(answer),
            FilePreparation::Pending(answer) => {
                Ok(pending(Box::pin(async move { done(answer.await?) })))
            }
        }
    }
}

/// Returns a title for text that has no file name: its first words, as many as fit into a list of
/// jobs.
fn title_of_text(bytes: &[u8]) -> String {
    // Fits one row of the page's list of jobs; a choice.
    const MAX_TITLE_LENGTH: usize = 40;
    let text = String::from_utf8_lossy(bytes);
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    match words.char_indices().nth(MAX_TITLE_LENGTH) {
        Some((end, _)) => format!("{}…", words[..end].trim_end()),
        None => words,
    }
}

/// Converts the outcome of a preparation.
fn reading(answer: FileAnswer, digest: String) -> Result<ProgramReading, RpcError> {
    match answer {
        Ok(Preparation::Done(program)) => Ok(ProgramReading::Done(program, digest)),
        Ok(Preparation::NeedsStart) => Ok(ProgramReading::NeedsStart),
        Err(error) if error.problem.lacks_surface() => {
            Ok(ProgramReading::LacksSurface(refusal(*error.problem)))
        }
        Err(error) => Err(refusal(*error.problem)),
    }
}

fn refusal(problem: Diagnostic) -> RpcError {
    RpcError::from(magician::Error::from(problem))
}

impl Reader for FormatReader {
    fn read(&self, source: &Source, arm: &ReadingArm) -> Result<ProgramReading, RpcError> {
        let mut defaults = self.defaults.clone();
        // The measured surface is newer than the settings.
        arm.surface.apply_to(&mut defaults, arm.is_virtual);
        // A virtual arm needs no measured surface: it has a known table.
        if arm.is_virtual {
            defaults = defaults.on_virtual_arm();
        }
        let (request, digest) = self.request(source, arm, defaults)?;
        let done = move |answer| reading(answer, digest);
        self.prepare(request, done, ProgramReading::Pending)
    }

    fn default_tool(&self) -> Tool {
        self.defaults.tool.unwrap_or(Tool::Pen)
    }

    fn convert(&self, source: &Source, to: &str) -> Result<ConversionResult, RpcError> {
        let conversion = Conversion::of(to).ok_or_else(|| {
            let why = message!("`to` must end with .plan.json, .playback, .svg, .png or .csv");
            RpcError::param("to", why)
        })?;
        let defaults = self.defaults.clone().for_conversion();
        let (mut request, _) = self.request(source, &ReadingArm::default(), defaults)?;
        // No arm takes part in a conversion, so every program starts at the same staged position.
        request.start = StartPosition::Staged;
        let names = [source.bytes.name().to_owned(), to.to_owned()];
        let done =
            move |answer: FileAnswer| match answer.map_err(|error| refusal(*error.problem))? {
                Preparation::Done(program) => converted(conversion, names, *program),
                Preparation::NeedsStart => Err(invalid(message!(
                    "it is not known where the program begins"
                ))),
            };
        self.prepare(request, done, ConversionResult::Pending)
    }
}

fn converted(
    conversion: Conversion,
    names: [String; 2],
    program: PreparedProgram,
) -> Result<ConversionResult, RpcError> {
    // Unlike a job, a conversion has no check that would report a misfit.
    let program = program.fitting().map_err(|error| refusal(*error.problem))?;
    let plan = program.program.plan();
    let (bytes, lost) = conversion.file(plan).map_err(|error| match error {
        ConversionError::Refused(problem) => refusal(problem),
        ConversionError::Rehearsal(error) => RpcError::from(error),
        ConversionError::OutOfReach => invalid(message!("none of its lines is within reach")),
        // The remaining error of a conversion: there is nothing to convert.
        _ => invalid(message!("it draws and burns nothing")),
    })?;
    let steps = plan.steps.len();
    let report = ConversionReport::new(&ApiVoice, names, steps, &program.notes, &lost);
    Ok(ConversionResult::Done(bytes, to_value(&report)?))
}

fn invalid(why: Message) -> RpcError {
    RpcError::arm(magician::ErrorKind::InvalidInput, why)
}

/// Returns the strokes of a program started from `start`, and the travels between them, at most
/// 20,000 points each.
pub(crate) async fn preview(program: &PreparedProgram, start: &Preflight) -> Value {
    let plan = program.program.plan();
    let outline = Outline::with_travels(plan, start, MAX_PREVIEW_POINTS, &BackgroundTurns);
    let (lines, travels) = outline.await;
    // Rounded to 0.01 mm: finer than the arm's repeatability, and half the size of full decimals.
    let rounded = |value: f64| (value * 100.0).round() / 100.0;
    let strokes = lines.into_iter().map(|line| {
        let points: Vec<_> = { line.points.iter() }
            .map(|point| point.map(rounded))
            .collect();
        json!({
            "points": points,
            "height": rounded(line.height),
            "part": line.part,
            "reachable": line.reachable,
            "power": line.power,
        })
    });
    let travels = travels.into_iter().map(|way| {
        let points = way.into_iter().map(|point| point.map(rounded));
        points.collect::<Vec<_>>()
    });
    json!({
        "strokes": strokes.collect::<Vec<_>>(),
        "travels": travels.collect::<Vec<_>>(),
    })
}

/// Checks one loop of a program from the arm's current state.
///
/// # Errors
/// Why the program is not valid from there.
pub(crate) async fn check(
    program: &PreparedProgram,
    start: Preflight,
) -> Result<CheckReport, RpcError> {
    let rest = program.program.remaining(0, start).map_err(refusal)?;
    let report = rest.check_yielding(&BackgroundTurns).await;
    Ok(check_report(program, &rest, &report))
}

/// Builds the report of a check, with the durations of parts.
pub(crate) fn check_report(
    program: &PreparedProgram,
    rest: &RemainingProgram,
    report: &Report,
) -> CheckReport {
    let mut found = CheckReport::of(program, rest, report, &ApiVoice);
    let mut parts = program.parts.clone();
    PartSummary::measure(&mut parts, report);
    // After `measure`, which needs all parts.
    parts.truncate(MAX_PARTS);
    for part in &mut parts {
        part.drawn_mm = (part.drawn_mm * 1000.0).round() / 1000.0;
        // Cut between characters: `truncate` panics inside of one.
        let end = { part.name.as_ref() }.and_then(|name| name.char_indices().nth(MAX_PART_NAME));
        if let (Some((end, _)), Some(name)) = (end, &mut part.name) {
            name.truncate(end);
        }
    }
    found.parts = Some(parts);
    // G-code without options keeps the coordinates of its file, which are often those of another
    // machine.
    let raw = program.format == Format::Gcode && program.is_raw();
    let foreign = raw
        .then(|| foreign_coordinates(rest.first(), report))
        .flatten();
    found.notes.extend(Note::all(&ApiVoice, &foreign));
    found
}

/// Wording of messages for API clients: names of method parameters.
pub(crate) struct ApiVoice;

impl Voice for ApiVoice {
    fn action(&self, action: magician::Action) -> String {
        action.name().to_owned()
    }

    fn give(&self, setting: magician::Setting, given: &magician::SettingValue) -> String {
        match given {
            magician::SettingValue::On => format!("{}: true", setting.name()),
            magician::SettingValue::Off => format!("{}: false", setting.name()),
            magician::SettingValue::Position([x, y, z]) => {
                format!("{}: [{x:.3}, {y:.3}, {z:.3}]", setting.name())
            }
            given => format!("{}: {given}", setting.name()),
        }
    }

    fn setting(&self, setting: magician::Setting) -> String {
        setting.name().to_owned()
    }
}
