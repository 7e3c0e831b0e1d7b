//! Programs for jobs: how they come, who reads them, and what is kept of jobs.

use std::fmt;
use std::io;
use std::pin::Pin;
use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use magician::message;
use magician::preflight::Preflight;
use magician::{Fence, Voice};
use magician_job::beside::BesideTurns;
use magician_job::presets::Presets;
use magician_job::report::{CheckReport, ConversionReport, Note};
use magician_job::{Journal, NoJournal};
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
use crate::files::{FilePreparation, FilePreparer, PrepareHere};
use crate::library::{self, LibraryError, NoPrograms, ProgramName, ProgramStore};
use crate::order::JobOrder;
use crate::presets;
use crate::reading::to_value;
use crate::surface::KnownSurface;

/// Points of a preview, at most.
const PREVIEWED: usize = 20_000;
/// Parts that a check tells of, and characters of the name of one, at most.
const PARTS: usize = 256;
const LONGEST_NAME: usize = 200;

/// A program as a client names it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum SourceBytes {
    /// Text.
    Text(String),
    /// Bytes in base64.
    Data(String),
    /// A program of the library, by its name.
    Program(String),
}

/// A program as a client sends it, and what it says of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Source {
    /// The file.
    #[serde(flatten)]
    pub bytes: SourceBytes,
    /// Its format, if it was said.
    pub format: Option<String>,
    /// How it is to be drawn or engraved; without it is run as it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub setup: Option<Box<SetupOptions>>,
    /// The preset that says what the options leave open.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preset: Option<String>,
}

impl Source {
    /// The bytes of the file; one of the library comes from there.
    ///
    /// # Errors
    /// An error of the parameter `data` for what is no base64, of `program` for a name of no program.
    pub fn bytes(&self, library: &dyn ProgramStore) -> Result<Vec<u8>, RpcError> {
        match &self.bytes {
            SourceBytes::Text(text) => Ok(text.clone().into_bytes()),
            SourceBytes::Data(data) => STANDARD
                .decode(data)
                .map_err(|_| RpcError::param("data", "`data` must be bytes in base64")),
            SourceBytes::Program(name) => {
                let name = ProgramName::new(name).ok_or_else(library::unknown_program)?;
                library::bytes_of(library, &name).map_err(|error| match error {
                    LibraryError::Unknown => library::unknown_program(),
                    other => library::wrong(other),
                })
            }
        }
    }
}

impl SourceBytes {
    /// Its name, if it has one.
    pub(crate) fn name(&self) -> &str {
        match self {
            Self::Program(name) => name,
            Self::Text(_) | Self::Data(_) => "",
        }
    }
}

/// How a program is drawn or engraved, and by which preset; what is wrong is an error of the parameter `setup.KEY`.
pub(crate) type SetupAndPreset = (Option<Box<SetupOptions>>, Option<String>);

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
            let why = "`setup`: preset must be the name of a preset";
            return Err(RpcError::param("setup.preset", why));
        }
    };
    let options = match preset {
        None => SetupOptions::from_fields(&fields),
        Some(_) => SetupOptions::from_fields_of_some(&fields),
    };
    let options = options.map_err(|error| {
        let message = format!("`setup`: {}", visible(&error.message));
        RpcError::param(&format!("setup.{}", visible(&error.key)), message).said(&error.message)
    })?;
    Ok((Some(Box::new(options)), preset))
}

/// The arm that a program is read for.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct ReadingArm {
    /// Whether it is a virtual one.
    pub is_virtual: bool,
    /// Its fence.
    pub fence: Option<Fence>,
    /// Where the program began when it was read before, mm.
    pub begun: Option<[f64; 3]>,
    /// The tool in force, where something is framed.
    pub tool: Option<Tool>,
    /// How the arm stands, where the program depends on that.
    pub stands: Option<Preflight>,
    /// Knowledge of the work surface under it.
    pub surface: KnownSurface,
}

/// What comes of what is done elsewhere.
pub type ToCome<T> = Pin<Box<dyn Future<Output = Result<T, RpcError>> + Send>>;

/// What came of reading a program.
#[non_exhaustive]
pub enum ProgramReading {
    /// A program.
    Done(Box<PreparedProgram>),
    /// The program depends on where the arm stands: it has to be read again with that.
    NeedsStart,
    /// Error of a program without the height of its work surface. That is measured with a homed arm, so that an arm that is not
    /// homed is refused first.
    LacksSurface(RpcError),
    /// It is read elsewhere. Who drops it no longer wants it.
    ToCome(ToCome<ProgramReading>),
}

/// What came of making another file of a program.
#[non_exhaustive]
pub enum Converting {
    /// Its bytes, and what is answered.
    Done(Vec<u8>, Value),
    /// It is read elsewhere.
    ToCome(ToCome<Converting>),
}

/// Makes a program of what a client sends. It may take its time: it is asked beside what the arm does.
pub trait Reader: Send + Sync {
    /// Reads one for an arm.
    ///
    /// # Errors
    /// What is wrong with it, as it is answered.
    fn read(&self, source: &Source, arm: &ReadingArm) -> Result<ProgramReading, RpcError>;

    /// The tool that draws where nothing else is said.
    fn usual_tool(&self) -> Tool {
        Tool::Pen
    }

    /// Makes a file of this name of one: its bytes, and what is answered.
    ///
    /// # Errors
    /// What is wrong with it, and a name that says no format.
    fn convert(&self, source: &Source, to: &str) -> Result<Converting, RpcError> {
        let _ = (source, to);
        let why = message!("this station converts no programs");
        Err(RpcError::arm(magician::ErrorKind::Unsupported, why))
    }
}

/// Reads the formats that are built into `magician-program`: plans always.
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
    /// With these settings where a program brings none.
    #[must_use]
    pub fn new(defaults: SetupDefaults) -> Self {
        Self::by(defaults, Arc::new(PrepareHere))
    }

    /// The same, with files prepared elsewhere, whatever is built in.
    #[must_use]
    pub fn by(defaults: SetupDefaults, files: Arc<dyn FilePreparer>) -> Self {
        Self {
            defaults,
            library: Arc::new(NoPrograms),
            presets: Presets::default(),
            files,
        }
    }

    /// With the programs of this library.
    #[must_use]
    pub fn with_library(mut self, library: Arc<dyn ProgramStore>) -> Self {
        self.library = library;
        self
    }

    /// With these presets; without them those that come with this program.
    #[must_use]
    pub fn with_presets(mut self, presets: Presets) -> Self {
        self.presets = presets;
        self
    }

    /// What a program's preset says where its options say nothing; what it tells people.
    fn by_preset(
        &self,
        source: &Source,
        format: Format,
        options: &mut SetupOptions,
    ) -> Result<Option<Diagnostic>, RpcError> {
        let Some(name) = &source.preset else {
            return Ok(None);
        };
        let wrong = |error| presets::wrong(error, "setup.preset");
        let preset = self.presets.load(name).map_err(wrong)?;
        let completed = preset.complete(options, Some(format));
        let (completed, told) = completed.map_err(|error| {
            RpcError::param("setup.preset", visible(&error.message).to_string())
        })?;
        *options = completed;
        Ok(told)
    }

    /// The request to prepare a program for an arm.
    fn request(
        &self,
        source: &Source,
        arm: &ReadingArm,
        defaults: SetupDefaults,
    ) -> Result<PrepareRequest, RpcError> {
        let bytes = source.bytes(&*self.library)?;
        let format = match &source.format {
            Some(format) => format
                .parse()
                .map_err(|error: String| RpcError::param("format", error))?,
            None => Format::of(source.bytes.name(), &bytes).ok_or_else(|| {
                if let Some(foreign) = magician_program::foreign(source.bytes.name(), &bytes) {
                    return RpcError::param("format", foreign.to_string());
                }
                let why = message!("the type of the program is not recognised: name it");
                RpcError::param("format", why)
            })?,
        };
        let mut request = PrepareRequest::new(format, &bytes);
        if let Some(options) = &source.setup {
            request.options = (**options).clone();
        }
        request.preset_note = self.by_preset(source, format, &mut request.options)?;
        request.options.start = request.options.start.or(arm.begun);
        request.defaults = defaults;
        request.fence = arm.fence;
        request.tool = arm.tool;
        if !source.bytes.name().is_empty() {
            request.title = Format::title(source.bytes.name()).to_owned();
        } else if format == Format::Text {
            request.title = title_of_text(&bytes);
        }
        if let Some(stands) = &arm.stands {
            let tool = request.options.tool.or(request.defaults.tool);
            request.start = tip(stands, tool).map_or(StartPosition::Unknown, StartPosition::At);
        }
        Ok(request)
    }

    /// Prepares the program here or elsewhere, and makes of that what is wanted.
    fn prepare<T: 'static>(
        &self,
        request: PrepareRequest,
        done: impl FnOnce(FileAnswer) -> Result<T, RpcError> + Send + 'static,
        to_come: impl FnOnce(ToCome<T>) -> T,
    ) -> Result<T, RpcError> {
        match self.files.prepare(request) {
            FilePreparation::Here(answer) => done(answer),
            FilePreparation::ToCome(answer) => {
                Ok(to_come(Box::pin(async move { done(answer.await?) })))
            }
        }
    }
}

/// The title of a text that no file has named: its own words, as many as a list of jobs has room for.
fn title_of_text(bytes: &[u8]) -> String {
    const MOST_LETTERS: usize = 40;
    let text = String::from_utf8_lossy(bytes);
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    match words.char_indices().nth(MOST_LETTERS) {
        Some((end, _)) => format!("{}…", words[..end].trim_end()),
        None => words,
    }
}

/// Translates the outcome of preparing a program.
fn reading(answer: FileAnswer) -> Result<ProgramReading, RpcError> {
    match answer {
        Ok(Preparation::Done(program)) => Ok(ProgramReading::Done(program)),
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
        arm.surface.apply_to(&mut defaults, arm.is_virtual);
        if arm.is_virtual {
            defaults = defaults.on_virtual_arm();
        }
        let request = self.request(source, arm, defaults)?;
        self.prepare(request, reading, ProgramReading::ToCome)
    }

    fn usual_tool(&self) -> Tool {
        self.defaults.tool.unwrap_or(Tool::Pen)
    }

    fn convert(&self, source: &Source, to: &str) -> Result<Converting, RpcError> {
        let conversion = Conversion::of(to).ok_or_else(|| {
            let why = "`to` must end with .plan.json, .playback, .svg, .png or .csv";
            RpcError::param("to", why)
        })?;
        let defaults = self.defaults.clone().for_conversion();
        let mut request = self.request(source, &ReadingArm::default(), defaults)?;
        request.start = StartPosition::Staged;
        let names = [source.bytes.name().to_owned(), to.to_owned()];
        let done =
            move |answer: FileAnswer| match answer.map_err(|error| refusal(*error.problem))? {
                Preparation::Done(program) => converted(conversion, names, *program),
                Preparation::NeedsStart => Err(invalid("it is not known where the program begins")),
            };
        self.prepare(request, done, Converting::ToCome)
    }
}

fn converted(
    conversion: Conversion,
    names: [String; 2],
    program: PreparedProgram,
) -> Result<Converting, RpcError> {
    let program = program.fitting().map_err(|error| refusal(*error.problem))?;
    let plan = program.program.plan();
    let (bytes, lost) = conversion.file(plan).map_err(|error| match error {
        ConversionError::Refused(problem) => refusal(problem),
        ConversionError::Rehearsal(error) => RpcError::from(error),
        ConversionError::OutOfReach => invalid("none of its lines is within reach"),
        _ => invalid("it draws and burns nothing"),
    })?;
    let steps = plan.steps.len();
    let report = ConversionReport::new(&Words, names, steps, &program.notes, &lost);
    Ok(Converting::Done(bytes, to_value(&report)?))
}

fn invalid(why: &str) -> RpcError {
    RpcError::arm(magician::ErrorKind::InvalidInput, why)
}

/// Lines that a program leaves when it begins there, and the ways between, of no more than 20,000 points each.
pub(crate) async fn preview(program: &PreparedProgram, start: &Preflight) -> Value {
    let plan = program.program.plan();
    let outline = Outline::with_travels(plan, start, PREVIEWED, &BesideTurns);
    let (lines, travels) = outline.await;
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

/// Checks a program once from where an arm stands: the object of a check.
///
/// # Errors
/// What makes it no program from there.
pub(crate) async fn check(
    program: &PreparedProgram,
    start: Preflight,
) -> Result<CheckReport, RpcError> {
    let rest = program.program.remaining(0, start).map_err(refusal)?;
    let report = rest.check_in_turns(&BesideTurns).await;
    Ok(check_report(program, &rest, &report))
}

/// Report of a check, with the times of the parts.
pub(crate) fn check_report(
    program: &PreparedProgram,
    rest: &RemainingProgram,
    report: &Report,
) -> CheckReport {
    let mut found = CheckReport::of(program, rest, report, &Words);
    let mut parts = program.parts.clone();
    PartSummary::measure(&mut parts, report);
    parts.truncate(PARTS);
    for part in &mut parts {
        part.drawn_mm = (part.drawn_mm * 1000.0).round() / 1000.0;
        let end = { part.name.as_ref() }.and_then(|name| name.char_indices().nth(LONGEST_NAME));
        if let (Some((end, _)), Some(name)) = (end, &mut part.name) {
            name.truncate(end);
        }
    }
    found.parts = Some(parts);
    let raw = program.format == Format::Gcode && program.is_raw();
    let foreign = raw
        .then(|| foreign_coordinates(rest.first(), report))
        .flatten();
    found.notes.extend(Note::all(&Words, &foreign));
    found
}

/// The words of the API: names of methods' parameters.
pub(crate) struct Words;

impl Voice for Words {
    fn action(&self, action: magician::Action) -> String {
        action.name().to_owned()
    }

    fn give(&self, setting: magician::Setting, given: &magician::Given) -> String {
        match given {
            magician::Given::On => format!("{}: true", setting.name()),
            magician::Given::Off => format!("{}: false", setting.name()),
            magician::Given::Position([x, y, z]) => {
                format!("{}: [{x:.3}, {y:.3}, {z:.3}]", setting.name())
            }
            given => format!("{}: {given}", setting.name()),
        }
    }

    fn setting(&self, setting: magician::Setting) -> String {
        setting.name().to_owned()
    }
}

/// Keeps jobs beyond the life of a station. Arms are meant by their places among those of the station.
pub trait JobStore: Send + Sync {
    /// What was kept last of the jobs of an arm; null if nothing was.
    fn load(&self, arm: usize) -> Value;

    /// Keeps this instead. It is on the disk when this returns.
    ///
    /// # Errors
    /// The cause; then what was kept before is still kept.
    fn save(&self, arm: usize, jobs: &Value) -> io::Result<()>;

    /// A journal for a job.
    fn journal(&self) -> Box<dyn Journal>;

    /// Runs of the command line at an arm that were interrupted and can be resumed.
    fn runs(&self, arm: usize) -> Vec<KeptRun> {
        let _ = arm;
        Vec::new()
    }

    /// Returns the text that was kept under a name, of a class and its schedule. `None` if there is none.
    ///
    /// # Errors
    /// The cause, if there is one that cannot be read.
    fn kept(&self, name: &str) -> io::Result<Option<String>> {
        let _ = name;
        Ok(None)
    }

    /// Keeps this under a name, for its owner alone. It is on the disk when this returns.
    ///
    /// # Errors
    /// The cause; then what was kept before is still kept.
    fn keep(&self, name: &str, text: &str) -> io::Result<()> {
        let _ = (name, text);
        Ok(())
    }
}

/// A run of the command line that was interrupted.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct KeptRun {
    /// Name of its journal, which no other run has meanwhile.
    pub name: String,
    /// Title of its program.
    pub title: String,
    /// What it does.
    pub order: JobOrder,
    /// Steps of one loop, where that is known.
    pub steps: Option<u64>,
    /// Steps that are finished, over all loops.
    pub done: u64,
    /// When it began, Unix seconds.
    pub started: f64,
    /// When it was heard of last, Unix seconds.
    pub ended: f64,
}

/// Keeps nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoStore;

impl JobStore for NoStore {
    fn load(&self, _: usize) -> Value {
        Value::Null
    }

    fn save(&self, _: usize, _: &Value) -> io::Result<()> {
        Ok(())
    }

    fn journal(&self) -> Box<dyn Journal> {
        Box::new(NoJournal)
    }
}
