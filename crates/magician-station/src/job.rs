//! Programs for jobs: how they come, who reads them, and what is kept of jobs.

use std::fmt;
use std::pin::Pin;
use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use magician::report::FenceReport;
use magician::words::Preflight;
use magician::{Fence, Voice};
use magician_job::beside::BesideTurns;
use magician_job::presets::Presets;
use magician_job::report::{CheckReport, ConversionReport, Note, WayOut, doubts, warnings};
use magician_job::{Journal, NoJournal};
use magician_program::preview::Outline;
use magician_program::{
    AppliedPlacement, Begins, Conversion, ConversionError, Diagnostic, DiagnosticCode, Ending,
    FileToLay, Format, LaidProgram, Laying, Origin, PartSummary, Program, RemainingProgram, Report,
    Setup, SetupDefaults, SetupOptions, Surface, Tool, WouldFit, foreign_coordinates, tip,
};
use magician_protocol::visible;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use crate::api::RpcError;
use crate::files::{FileLayer, LaidFile, LayHere};
use crate::library::{self, LibraryError, NoPrograms, ProgramName, ProgramStore};
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
    fn name(&self) -> &str {
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
        RpcError::param(&format!("setup.{}", visible(&error.key)), message)
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
    /// It was read.
    Done(Box<ReadProgram>),
    /// It depends on where the arm stands: it is to be read again with that.
    NeedsStart,
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

/// A program that has been read and laid before an arm.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ReadProgram {
    /// What it does, once.
    pub program: Program,
    /// What it was read as.
    pub format: Format,
    /// How it was laid.
    pub setup: Setup,
    /// What becomes of the pen.
    pub ending: Ending,
    /// Where the tool was, if the program depends on it and it was not given, mm.
    pub start: Option<[f64; 3]>,
    /// What of it was taken in a certain way.
    pub notes: Vec<Diagnostic>,
    /// How it lies, if it was placed.
    pub placed: Option<AppliedPlacement>,
    /// Why it does not fit there.
    pub misfit: Option<Diagnostic>,
    /// In which size it would.
    pub would_fit: Option<WouldFit>,
    /// Its parts, without how long they take.
    pub parts: Vec<PartSummary>,
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
        let why = "this station converts no programs";
        Err(RpcError::arm(magician::ErrorKind::Unsupported, why))
    }
}

/// Reads the formats that are built into `magician-program`: plans always.
#[derive(Clone)]
pub struct FormatReader {
    defaults: SetupDefaults,
    library: Arc<dyn ProgramStore>,
    presets: Presets,
    files: Arc<dyn FileLayer>,
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
        Self::by(defaults, Arc::new(LayHere))
    }

    /// The same, with someone else who reads and lays files, whatever is built in.
    #[must_use]
    pub fn by(defaults: SetupDefaults, files: Arc<dyn FileLayer>) -> Self {
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
        *options = options.or(&preset.options_for(Some(format)));
        options.check().map_err(|error| {
            let why = format!("with the preset {name}: {}", visible(&error.message));
            RpcError::param("setup.preset", why)
        })?;
        Ok(preset.told())
    }

    /// The file of a program, to be laid before an arm, and what people are told first: what is framed, and what its preset says; for one that is not there it begins where a virtual one stands.
    fn file(
        &self,
        source: &Source,
        arm: &ReadingArm,
        defaults: SetupDefaults,
        nowhere: bool,
    ) -> Result<(FileToLay, Vec<Diagnostic>), RpcError> {
        let bytes = source.bytes(&*self.library)?;
        let format = match &source.format {
            Some(format) => format
                .parse()
                .map_err(|error: String| RpcError::param("format", error))?,
            None => Format::of(source.bytes.name(), &bytes).ok_or_else(|| {
                if let Some(foreign) = magician_program::foreign(source.bytes.name(), &bytes) {
                    return RpcError::param("format", foreign.to_string());
                }
                let why = "the type of the program is not recognised: name it";
                RpcError::param("format", why)
            })?,
        };
        let mut file = FileToLay::new(format, &bytes);
        if let Some(options) = &source.setup {
            file.options = (**options).clone();
        }
        let told = self.by_preset(source, format, &mut file.options)?;
        file.options.start = file.options.start.or(arm.begun);
        file.defaults = defaults;
        let framed = file.options.frame_for(&file.defaults, arm.tool);
        let told = framed.into_iter().chain(told).collect();
        file.fence = arm.fence;
        if !source.bytes.name().is_empty() {
            file.title = Format::title(source.bytes.name()).to_owned();
        }
        if nowhere {
            file.begins = Begins::OnStage;
        } else if let Some(stands) = &arm.stands {
            let setup = file.setup();
            let at = tip(stands, setup.tool.or(setup.default_tool));
            file.begins = at.map_or(Begins::Unknown, Begins::At);
        }
        Ok((file, told))
    }

    /// Lays it here or elsewhere, and makes of that what is wanted.
    fn lay<T: 'static>(
        &self,
        file: FileToLay,
        done: impl FnOnce(FileToLay, Laying) -> Result<T, RpcError> + Send + 'static,
        to_come: impl FnOnce(ToCome<T>) -> T,
    ) -> Result<T, RpcError> {
        let wrong = |problem: Diagnostic| RpcError::from(magician::Error::from(problem));
        match self.files.lay(file.clone()) {
            LaidFile::Here(laying) => done(file, laying.map_err(wrong)?),
            LaidFile::ToCome(answer) => Ok(to_come(Box::pin(async move {
                let laying = answer.await?.map_err(wrong)?;
                done(file, laying)
            }))),
        }
    }
}

/// What was laid as it is run; `before` is what people are told first.
fn reading(
    file: &FileToLay,
    laying: Laying,
    before: Vec<Diagnostic>,
) -> Result<ProgramReading, RpcError> {
    let laid = match laying {
        Laying::Done(laid) => *laid,
        Laying::NeedsStart => return Ok(ProgramReading::NeedsStart),
    };
    let LaidProgram {
        program,
        start,
        notes: mut told,
        placed,
        misfit,
        would_fit,
        parts,
    } = laid;
    if program.plan().steps.is_empty() {
        let why = "nothing to do in this program";
        return Err(RpcError::arm(magician::ErrorKind::InvalidInput, why));
    }
    let begins = start.map(begins_at);
    let mut notes: Vec<_> = before.into_iter().chain(begins).collect();
    notes.append(&mut told);
    let setup = file.setup();
    Ok(ProgramReading::Done(Box::new(ReadProgram {
        program,
        format: file.format,
        ending: file.ending(&setup),
        setup,
        start,
        notes,
        placed,
        misfit,
        would_fit,
        parts,
    })))
}

impl Reader for FormatReader {
    fn read(&self, source: &Source, arm: &ReadingArm) -> Result<ProgramReading, RpcError> {
        let mut defaults = self.defaults.clone();
        defaults.surface = arm.surface.or(defaults.surface);
        if arm.is_virtual {
            defaults.assumed_surface = Some(Surface::VIRTUAL);
        }
        let (file, told) = self.file(source, arm, defaults, false)?;
        let done = |file: FileToLay, laying| reading(&file, laying, told);
        self.lay(file, done, ProgramReading::ToCome)
    }

    fn usual_tool(&self) -> Tool {
        self.defaults.tool.unwrap_or(Tool::Pen)
    }

    fn convert(&self, source: &Source, to: &str) -> Result<Converting, RpcError> {
        let conversion = Conversion::of(to).ok_or_else(|| {
            let why = "`to` must end with .plan.json, .playback, .svg, .png or .csv";
            RpcError::param("to", why)
        })?;
        let mut defaults = self.defaults.clone();
        defaults.assumed_surface = Some(Surface::VIRTUAL);
        // What is converted is not burnt yet: a run of it has this then.
        defaults.engrave_power = None;
        let (file, told) = self.file(source, &ReadingArm::default(), defaults, true)?;
        let names = [source.bytes.name().to_owned(), to.to_owned()];
        let done = move |file: FileToLay, laying| match reading(&file, laying, told)? {
            ProgramReading::Done(read) => converted(conversion, names, *read),
            _ => Err(invalid("it is not known where the program begins")),
        };
        self.lay(file, done, Converting::ToCome)
    }
}

fn converted(
    conversion: Conversion,
    names: [String; 2],
    read: ReadProgram,
) -> Result<Converting, RpcError> {
    if let Some(misfit) = read.misfit {
        return Err(RpcError::from(magician::Error::from(misfit)));
    }
    let plan = read.program.plan();
    let (bytes, lost) = conversion.file(plan).map_err(|error| match error {
        ConversionError::Refused(problem) => RpcError::from(magician::Error::from(problem)),
        ConversionError::Rehearsal(error) => RpcError::from(error),
        ConversionError::OutOfReach => invalid("none of its lines is within reach"),
        _ => invalid("it draws and burns nothing"),
    })?;
    let steps = plan.steps.len();
    let report = ConversionReport::new(&Words, names, steps, &read.notes, &lost);
    Ok(Converting::Done(bytes, to_value(&report)?))
}

fn invalid(why: &str) -> RpcError {
    RpcError::arm(magician::ErrorKind::InvalidInput, why)
}

/// That a program begins where the arm stands.
fn begins_at([x, y, z]: [f64; 3]) -> Diagnostic {
    let what = format!("it begins at the tool's position, {x:.3},{y:.3},{z:.3}");
    Diagnostic::new(Origin::NONE, what)
        .coded(DiagnosticCode::Assumed)
        .help(format!(
            "start: [{x:.3}, {y:.3}, {z:.3}] begins there again from any position"
        ))
}

impl ReadProgram {
    /// The program, repeated so often; without end if `None`.
    #[must_use]
    pub fn program(&self, loops: Option<u64>) -> Program {
        self.program.clone().repeated(loops)
    }

    /// What it leaves when an arm stands there before it, and the ways between: lines of no more than 20,000 points each.
    pub async fn preview(&self, start: &Preflight) -> Value {
        let plan = self.program.plan();
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

    /// Checks it from where an arm stands: the object of a check.
    ///
    /// # Errors
    /// What makes it no program from there.
    pub async fn check(&self, start: Preflight) -> Result<CheckReport, RpcError> {
        let rest = self.program(Some(1)).remaining(0, start);
        let rest = rest.map_err(|problem| RpcError::from(magician::Error::from(problem)))?;
        let report = rest.check_in_turns(&BesideTurns).await;
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
        let steps = self.program.plan().steps.len() as u64;
        let mut found = CheckReport::new(report, Some(steps), ok);
        found.fence = self.setup.fence.as_ref().map(FenceReport::from);
        found.placed = self.placed;
        let mut parts = self.parts.clone();
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
        let mut warnings = warnings(report, self.placed);
        warnings.extend(doubts(report));
        let raw = self.format == Format::Gcode && self.placed.is_none() && self.misfit.is_none();
        let foreign = raw
            .then(|| foreign_coordinates(rest.first(), report))
            .flatten();
        let notes = self.notes.iter().chain(&warnings).chain(&foreign);
        found.notes = Note::all(&Words, notes);
        found
    }
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

    /// What was kept under a name: of a class and its schedule.
    fn kept(&self, name: &str) -> Option<String> {
        let _ = name;
        None
    }

    /// Keeps this under a name, for its owner alone.
    fn keep(&self, name: &str, text: &str) {
        let _ = (name, text);
    }
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
