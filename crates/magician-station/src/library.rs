//! The library: programs stored under names, and the operations of clients on them.
//!
//! [`ProgramStore`] is the interface to the disk; [`LibraryQuotas`] bounds what each role may
//! store. Files are read and written off the station's thread.

mod quotas;

use std::fmt;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use magician::{ErrorKind, Message, message};
use magician_job::presets::Presets;
use magician_program::{Format, SetupOptions};
use serde_json::{Value, json};

use crate::api::{Role, RpcError};
use crate::control::RequestId;
use crate::engine::run_blocking;
use crate::job::{ConversionResult, Reader, Source, SourceBytes};
use crate::presets::{self, PresetAct};
use crate::station::TeachAct;

pub use quotas::{LibraryQuotas, LibraryUse, OverQuota};

/// Largest program, bytes.
pub const MAX_PROGRAM_SIZE: u64 = 64 * 1024 * 1024;
/// Largest program in an answer to `program.get`, bytes. As base64 it stays below the largest
/// message of a socket; larger ones are downloaded by HTTP.
const MAX_ANSWER_PROGRAM: u64 = 700 * 1024;

/// Name of a program: 1 to 80 characters of `A-Z a-z 0-9 . _ -` and space. Does not start with a
/// dot; does not start or end with a space.
///
/// ```
/// use magician_station::ProgramName;
///
/// assert!(ProgramName::new("house 2.svg").is_some());
/// for wrong in ["", ".hidden", "..", "a/b", " a", "a ", "ä.svg", "a\0"] {
///     assert!(ProgramName::new(wrong).is_none(), "{wrong}");
/// }
/// ```
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ProgramName(String);

impl ProgramName {
    /// Returns the name. `None` if the text is not a valid one.
    #[must_use]
    pub fn new(name: &str) -> Option<Self> {
        let sign = |sign: u8| sign.is_ascii_alphanumeric() || b"._- ".contains(&sign);
        let good = (1..=80).contains(&name.len())
            && name.bytes().all(sign)
            && !name.starts_with(['.', ' '])
            && !name.ends_with(' ')
            // On other systems these names are ordinary, and existing files keep them.
            && !(cfg!(windows) && is_reserved_on_windows(name));
        good.then(|| Self(name.to_owned()))
    }

    /// Returns the name as text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

/// True if Windows reserves the name for a device, or strips its final dot.
fn is_reserved_on_windows(name: &str) -> bool {
    // `con.svg` is the console as well: Windows looks at the part before the first dot.
    let stem = name.split('.').next().unwrap_or_default().trim_end();
    let stem = stem.to_ascii_lowercase();
    let numbered = |kind| {
        let number = stem.strip_prefix(kind);
        number.is_some_and(|number| number.len() == 1 && number.as_bytes()[0].is_ascii_digit())
    };
    let device = ["con", "prn", "aux", "nul"].contains(&stem.as_str());
    device || numbered("com") || numbered("lpt") || name.ends_with('.')
}

impl fmt::Display for ProgramName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Program in a library.
#[derive(Clone, Debug, PartialEq)]
pub struct ProgramEntry {
    /// Name.
    pub name: ProgramName,
    /// Size, bytes.
    pub bytes: u64,
    /// Last change, Unix seconds.
    pub modified: f64,
    /// Format. `None` if it is not recognised.
    pub format: Option<Format>,
}

/// Reason why an operation on a library failed.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LibraryError {
    /// The library has no such program.
    Unknown,
    /// The program is larger than [`MAX_PROGRAM_SIZE`].
    TooLarge,
    /// The quota of the request's role is exhausted.
    Quota(OverQuota),
    /// The disk is full.
    Full,
    /// Any other cause, as a sentence.
    Other(Message),
}

impl LibraryError {
    /// Returns the reason as a sentence.
    #[must_use]
    pub fn sentence(&self) -> Message {
        match self {
            Self::Unknown => message!("there is no such program"),
            Self::TooLarge => message!(
                "a program is {most} MiB at most",
                most = MAX_PROGRAM_SIZE >> 20
            ),
            Self::Quota(met) => met.sentence(),
            Self::Full => message!("no room for the program"),
            Self::Other(why) => why.clone(),
        }
    }
}

impl fmt::Display for LibraryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.sentence())
    }
}

impl std::error::Error for LibraryError {}

/// Store of programs by name. Calls may block: they are made off the station's thread.
pub trait ProgramStore: Send + Sync {
    /// True if the store can keep programs.
    fn is_enabled(&self) -> bool {
        true
    }

    /// Returns the folder on disk. `None` if there is no folder.
    fn folder(&self) -> Option<&Path>;

    /// Returns all programs, sorted by name.
    ///
    /// # Errors
    /// The folder cannot be read.
    fn list(&self) -> Result<Vec<ProgramEntry>, LibraryError>;

    /// Opens a program for reading. Returns its size and content. The content stays the same while
    /// it is read, even if the program is replaced or deleted meanwhile.
    ///
    /// # Errors
    /// The program does not exist or cannot be read.
    fn open(&self, name: &ProgramName) -> Result<(u64, Box<dyn Read + Send>), LibraryError>;

    /// Starts an upload by a session of this role. The program appears under its name when the
    /// upload is [finished](Upload::finish), and not before. `length` is its size, if known.
    ///
    /// # Errors
    /// The upload cannot be started, or `length` exceeds the quota.
    fn upload(
        &self,
        name: &ProgramName,
        by: Role,
        length: Option<u64>,
    ) -> Result<Box<dyn Upload>, LibraryError>;

    /// Removes a program.
    ///
    /// # Errors
    /// The program does not exist or cannot be removed.
    fn delete(&self, name: &ProgramName) -> Result<(), LibraryError>;
}

/// Upload in progress. Dropping it leaves the library unchanged.
pub trait Upload: Send {
    /// Appends bytes.
    ///
    /// # Errors
    /// The program is too large, or the quota or the disk has no room.
    fn write(&mut self, bytes: &[u8]) -> Result<(), LibraryError>;

    /// Completes the upload and stores the program. Returns true if the name is new.
    ///
    /// # Errors
    /// The disk has no room, or the program cannot be stored.
    fn finish(self: Box<Self>) -> Result<bool, LibraryError>;
}

/// Empty library that refuses uploads.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoPrograms;

impl NoPrograms {
    fn refused() -> LibraryError {
        LibraryError::Other(message!("this station keeps no programs"))
    }
}

impl ProgramStore for NoPrograms {
    fn is_enabled(&self) -> bool {
        false
    }

    fn folder(&self) -> Option<&Path> {
        None
    }

    fn list(&self) -> Result<Vec<ProgramEntry>, LibraryError> {
        Ok(Vec::new())
    }

    fn open(&self, _: &ProgramName) -> Result<(u64, Box<dyn Read + Send>), LibraryError> {
        Err(LibraryError::Unknown)
    }

    fn upload(
        &self,
        _: &ProgramName,
        _: Role,
        _: Option<u64>,
    ) -> Result<Box<dyn Upload>, LibraryError> {
        Err(Self::refused())
    }

    fn delete(&self, _: &ProgramName) -> Result<(), LibraryError> {
        Err(LibraryError::Unknown)
    }
}

/// Reads a whole program.
pub(crate) fn bytes_of(
    store: &dyn ProgramStore,
    name: &ProgramName,
) -> Result<Vec<u8>, LibraryError> {
    let (_, mut from) = store.open(name)?;
    let mut bytes = Vec::new();
    let read = { from.by_ref() }
        // Reading one byte more than the limit shows that a program is too long without reading all
        // of it.
        .take(MAX_PROGRAM_SIZE + 1)
        .read_to_end(&mut bytes);
    match read {
        Err(error) => Err(LibraryError::Other(error.to_string().into())),
        Ok(count) if count as u64 > MAX_PROGRAM_SIZE => Err(LibraryError::TooLarge),
        Ok(_) => Ok(bytes),
    }
}

/// Stores a program. Returns true if the name is new.
pub(crate) fn store_program(
    store: &dyn ProgramStore,
    name: &ProgramName,
    by: Role,
    bytes: &[u8],
) -> Result<bool, LibraryError> {
    let mut upload = store.upload(name, by, Some(bytes.len() as u64))?;
    upload.write(bytes)?;
    upload.finish()
}

/// Operation on the library, on presets or on taught programs, carried out off the station's
/// thread.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum LibraryAct {
    /// List the programs.
    List,
    /// Return the bytes of a program.
    Get(ProgramName),
    /// Check that a program and a preset exist.
    Find {
        /// Program to look for.
        program: Option<ProgramName>,
        /// Preset to look for.
        preset: Option<String>,
    },
    /// Store a program.
    Put(ProgramName, Vec<u8>, OverwritePolicy),
    /// Remove a program.
    Delete(ProgramName),
    /// Convert a program to another file.
    Convert {
        /// Program to convert.
        from: ProgramName,
        /// Name of the new file.
        to: ProgramName,
        /// Options of drawing or engraving.
        setup: Option<Box<SetupOptions>>,
        /// Name of the preset.
        preset: Option<String>,
        /// Treatment of an existing program with this name.
        overwrite: OverwritePolicy,
    },
    /// Operation on presets.
    Presets(PresetAct),
    /// Conversion of a taught program.
    Teach(TeachAct),
}

/// Treatment of an existing program with the name of a new one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(clippy::exhaustive_enums, reason = "there is no third treatment")]
pub enum OverwritePolicy {
    /// Replaces the existing program.
    Replace,
    /// Keeps the existing program and refuses the new one.
    Refuse,
}

impl OverwritePolicy {
    /// Checks the name before a program is stored under it. `param` is the parameter of the name.
    fn check(
        self,
        store: &dyn ProgramStore,
        name: &ProgramName,
        param: &str,
    ) -> Result<(), RpcError> {
        if self == Self::Replace {
            return Ok(());
        }
        match store.open(name) {
            Err(LibraryError::Unknown) => Ok(()),
            Ok(_) => {
                let why = message!("there is a program {name} already", name = name.as_str());
                Err(RpcError::param(param, why))
            }
            Err(error) => Err(library_error(error)),
        }
    }
}

/// Operation on the library on behalf of a request.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LibraryOrder {
    /// Id of the request.
    pub request: RequestId,
    /// Role of its session.
    pub by: Role,
    /// Operation.
    pub act: LibraryAct,
}

impl LibraryAct {
    /// Carries out the operation off the station's thread. Returns the answer.
    pub(crate) async fn carry_out(
        self,
        by: Role,
        store: Arc<dyn ProgramStore>,
        presets: Presets,
        reader: Arc<dyn Reader>,
    ) -> Result<Value, RpcError> {
        let Self::Convert {
            from,
            to,
            setup,
            preset,
            overwrite,
        } = self
        else {
            return run_blocking(move || self.carry_out_on(by, &*store, &presets)).await?;
        };
        let source = Source {
            bytes: SourceBytes::Program(from.as_str().to_owned()),
            format: None,
            setup,
            preset,
        };
        // Both are needed again for storing the result.
        let (opened, name) = (Arc::clone(&store), to.clone());
        let converted = run_blocking(move || {
            // Opened here although the reader opens it again: the reader would report an unknown
            // name for the parameter `program`, which this method does not have.
            opened.open(&from).map_err(library_error)?;
            // Before the conversion, which may take long, and once more after it.
            overwrite.check(&*opened, &name, "to")?;
            reader.convert(&source, name.as_str())
        });
        let mut converted = converted.await??;
        loop {
            match converted {
                ConversionResult::Pending(to_come) => converted = to_come.await?,
                ConversionResult::Done(bytes, report) => {
                    let kept = run_blocking(move || {
                        overwrite.check(&*store, &to, "to")?;
                        store_program(&*store, &to, by, &bytes).map_err(library_error)
                    });
                    return kept.await?.map(|_| report);
                }
            }
        }
    }

    fn carry_out_on(
        self,
        by: Role,
        store: &dyn ProgramStore,
        presets: &Presets,
    ) -> Result<Value, RpcError> {
        match self {
            Self::Presets(act) => act.carry_out(presets),
            Self::Teach(act) => act.carry_out(),
            Self::List => {
                let programs = store.list().map_err(library_error)?;
                let shown = programs.iter().map(|program| {
                    json!({
                        "name": program.name.as_str(),
                        "bytes": program.bytes,
                        "modified": program.modified,
                        "format": program.format.map(Format::name),
                    })
                });
                Ok(json!({"programs": shown.collect::<Vec<_>>()}))
            }
            Self::Get(name) => {
                // The size first: a large program is refused without reading it.
                let (size, _) = store.open(&name).map_err(library_error)?;
                if size > MAX_ANSWER_PROGRAM {
                    let why = message!(
                        "{name} has {size} bytes, and an answer has room for {most}: get it by \
                            HTTP from /api/v1/programs",
                        name = name.as_str(),
                        size,
                        most = MAX_ANSWER_PROGRAM
                    );
                    return Err(RpcError::arm(ErrorKind::InvalidInput, why));
                }
                let bytes = bytes_of(store, &name).map_err(library_error)?;
                let format = Format::of(name.as_str(), &bytes).map(Format::name);
                let data = STANDARD.encode(bytes);
                Ok(json!({"name": name.as_str(), "format": format, "data": data}))
            }
            Self::Find { program, preset } => {
                match program.map(|name| store.open(&name)).transpose() {
                    Ok(_) => {}
                    Err(LibraryError::Unknown) => return Err(unknown_program()),
                    Err(error) => return Err(library_error(error)),
                }
                let preset = preset.map(|name| presets.load(&name)).transpose();
                preset.map_err(|error| presets::preset_error(error, "setup.preset"))?;
                Ok(Value::Null)
            }
            Self::Put(name, bytes, overwrite) => {
                overwrite.check(store, &name, "name")?;
                store_program(store, &name, by, &bytes).map_err(library_error)?;
                Ok(json!({"name": name.as_str(), "bytes": bytes.len()}))
            }
            Self::Delete(name) => {
                store.delete(&name).map_err(library_error)?;
                Ok(Value::Null)
            }
            Self::Convert { .. } => Err(RpcError::internal("it is not done at once")),
        }
    }
}

/// Error for a job whose program is not in the library.
pub(crate) fn unknown_program() -> RpcError {
    RpcError::param("program", LibraryError::Unknown.sentence())
}

/// Converts an error of the library to an answer.
pub(crate) fn library_error(error: LibraryError) -> RpcError {
    match error {
        LibraryError::Unknown => RpcError::param("name", error.sentence()),
        LibraryError::TooLarge => RpcError::arm(ErrorKind::InvalidInput, error.sentence()),
        LibraryError::Quota(met) => {
            let shown = |of: LibraryUse| json!({"programs": of.programs, "bytes": of.bytes});
            RpcError::arm(ErrorKind::InvalidInput, met.sentence())
                .with("quota", shown(met.quota))
                .with("used", shown(met.used))
        }
        // Errors of the disk, which do not depend on a parameter.
        _ => RpcError::arm(ErrorKind::Unexpected, error.sentence()),
    }
}

/// Returns the folder of the library as JSON. Null without a folder.
pub(crate) fn folder_of(store: &dyn ProgramStore) -> Value {
    let folder: Option<PathBuf> = store.folder().map(Path::to_owned);
    folder.map_or(Value::Null, |folder| json!(folder.display().to_string()))
}
