//! The library of programs and presets: what is kept under a name, and what clients do with it. Files are touched beside the station.

use std::fmt;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use magician::ErrorKind;
use magician_job::presets::Presets;
use magician_program::{Format, SetupOptions};
use serde_json::{Value, json};

use crate::api::{Role, RpcError};
use crate::control::RequestId;
use crate::engine::beside;
use crate::job::{Converting, Reader, Source, SourceBytes};
use crate::presets::{self, PresetAct};

/// Bytes of a program, at most.
pub const LARGEST_PROGRAM: u64 = 64 * 1024 * 1024;
/// Bytes of a program that are sent in an answer, at most.
const IN_AN_ANSWER: u64 = 700 * 1024;

/// The name of a program: 1 to 80 of `A-Z a-z 0-9 . _ -` and blanks, with no point first and no blank first or last.
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
    /// This one, if it is one.
    #[must_use]
    pub fn new(name: &str) -> Option<Self> {
        let sign = |sign: u8| sign.is_ascii_alphanumeric() || b"._- ".contains(&sign);
        let good = (1..=80).contains(&name.len())
            && name.bytes().all(sign)
            && !name.starts_with(['.', ' '])
            && !name.ends_with(' ')
            && !(cfg!(windows) && is_of_windows(name));
        good.then(|| Self(name.to_owned()))
    }

    /// As text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

/// Whether Windows has something else under this name.
fn is_of_windows(name: &str) -> bool {
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

/// A program of a library.
#[derive(Clone, Debug, PartialEq)]
pub struct ProgramEntry {
    /// Its name.
    pub name: ProgramName,
    /// Its size.
    pub bytes: u64,
    /// When it was changed last, Unix seconds.
    pub modified: f64,
    /// What it is, where that is recognised.
    pub format: Option<Format>,
}

/// Why a library does not do something.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LibraryError {
    /// There is no such program.
    Unknown,
    /// The program is larger than [`LARGEST_PROGRAM`].
    TooLarge,
    /// The library would be fuller than the role of the request may fill it.
    Quota(OverQuota),
    /// There is no room for it on the disk.
    Full,
    /// Anything else, in a sentence.
    Other(String),
}

impl fmt::Display for LibraryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown => f.write_str("there is no such program"),
            Self::TooLarge => write!(f, "a program is {} MiB at most", LARGEST_PROGRAM >> 20),
            Self::Quota(met) => met.fmt(f),
            Self::Full => f.write_str("no room for the program"),
            Self::Other(why) => f.write_str(why),
        }
    }
}

impl std::error::Error for LibraryError {}

/// Programs and bytes: those in a library, or those for which there is room.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(clippy::exhaustive_structs, reason = "two numbers")]
pub struct LibraryUse {
    /// Number of programs.
    pub programs: usize,
    /// Bytes of all of them.
    pub bytes: u64,
}

impl LibraryUse {
    /// With one more of so many bytes.
    #[must_use]
    pub const fn with(self, bytes: u64) -> Self {
        Self {
            programs: self.programs + 1,
            bytes: self.bytes.saturating_add(bytes),
        }
    }
}

/// How far each role may fill a library. Files do not tell who put them, so a quota is a level: what students put ends
/// below that of teachers, who always have the rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(clippy::exhaustive_structs, reason = "a level for each role that puts")]
pub struct LibraryQuotas {
    /// The level up to which students may fill it.
    pub students: LibraryUse,
    /// The level of the library.
    pub all: LibraryUse,
}

impl Default for LibraryQuotas {
    /// 1000 programs and 1 GiB: no disk is full because of it. Students have three quarters of both.
    fn default() -> Self {
        const ALL: LibraryUse = LibraryUse {
            programs: 1000,
            bytes: 1024 * 1024 * 1024,
        };
        Self {
            students: LibraryUse {
                programs: ALL.programs / 4 * 3,
                bytes: ALL.bytes / 4 * 3,
            },
            all: ALL,
        }
    }
}

impl LibraryQuotas {
    /// The level up to which a role may fill the library.
    #[must_use]
    pub fn of(&self, role: Role) -> LibraryUse {
        match role {
            Role::Teacher => self.all,
            Role::Student | Role::Viewer => self.students,
        }
    }

    /// Whether a role may put a program of so many bytes beside these others. `before` is the size of the one that it
    /// replaces: what does not grow is always taken.
    ///
    /// # Errors
    /// [`OverQuota`].
    pub fn check(
        &self,
        role: Role,
        others: LibraryUse,
        before: Option<u64>,
        bytes: u64,
    ) -> Result<(), OverQuota> {
        let quota = self.of(role);
        let after = others.with(bytes);
        let fits = match before {
            Some(before) => bytes <= before || after.bytes <= quota.bytes,
            None => after.programs <= quota.programs && after.bytes <= quota.bytes,
        };
        if fits {
            return Ok(());
        }
        let used = before.map_or(others, |before| others.with(before));
        let all = self.all;
        Err(OverQuota {
            role,
            quota,
            all,
            used,
        })
    }

    /// Most bytes of a program that a role puts beside these others.
    #[must_use]
    pub fn room(&self, role: Role, others: LibraryUse, before: Option<u64>) -> u64 {
        let room = self.of(role).bytes.saturating_sub(others.bytes);
        room.max(before.unwrap_or(0))
    }
}

/// A program for which a quota has no room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(clippy::exhaustive_structs, reason = "what a refusal says")]
pub struct OverQuota {
    /// The role that put it.
    pub role: Role,
    /// The level up to which that role may fill the library.
    pub quota: LibraryUse,
    /// The level of the library.
    pub all: LibraryUse,
    /// What is in it.
    pub used: LibraryUse,
}

impl fmt::Display for OverQuota {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
        let (quota, all, used) = (self.quota, self.all, self.used);
        let (programs, whole) = (all.programs, mib(all.bytes));
        if quota == all {
            write!(f, "the library takes {programs} programs and {whole} MiB")?;
        } else {
            let (own, part) = (quota.programs, mib(quota.bytes));
            write!(
                f,
                "students may fill {own} of the {programs} programs and {part} of the {whole} MiB of the library"
            )?;
        }
        let (count, size) = (used.programs, mib(used.bytes));
        write!(f, ", and {count} with {size:.1} MiB are used: remove some")
    }
}

/// Keeps programs under their names. It may take its time: it is asked beside the station.
pub trait ProgramStore: Send + Sync {
    /// Whether it keeps any.
    fn keeps(&self) -> bool {
        true
    }

    /// Where they are.
    fn folder(&self) -> Option<&Path>;

    /// All of them, by name.
    ///
    /// # Errors
    /// They cannot be looked at.
    fn list(&self) -> Result<Vec<ProgramEntry>, LibraryError>;

    /// One to be read, and its size. It stays the same while it is read, whatever becomes of its name.
    ///
    /// # Errors
    /// It is not there, or cannot be read.
    fn open(&self, name: &ProgramName) -> Result<(u64, Box<dyn Read + Send>), LibraryError>;

    /// One that is to be kept, by a session of this role: under its name when it is [finished](Upload::finish), and not at
    /// all before. `length` is its size, if that is known already.
    ///
    /// # Errors
    /// It cannot be begun, or there is no room for so many bytes.
    fn upload(
        &self,
        name: &ProgramName,
        by: Role,
        length: Option<u64>,
    ) -> Result<Box<dyn Upload>, LibraryError>;

    /// Removes one.
    ///
    /// # Errors
    /// It is not there, or cannot be removed.
    fn delete(&self, name: &ProgramName) -> Result<(), LibraryError>;
}

/// A program on its way into a library. Dropping it leaves the library as it is.
pub trait Upload: Send {
    /// More of it.
    ///
    /// # Errors
    /// It is too large, or there is no room.
    fn write(&mut self, bytes: &[u8]) -> Result<(), LibraryError>;

    /// That was all: it is kept. Whether its name is a new one.
    ///
    /// # Errors
    /// There is no room, or it cannot be kept.
    fn finish(self: Box<Self>) -> Result<bool, LibraryError>;
}

/// A library that holds nothing, and takes nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoPrograms;

impl NoPrograms {
    fn refused() -> LibraryError {
        LibraryError::Other("this station keeps no programs".to_owned())
    }
}

impl ProgramStore for NoPrograms {
    fn keeps(&self) -> bool {
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

/// The bytes of a program.
pub(crate) fn bytes_of(
    store: &dyn ProgramStore,
    name: &ProgramName,
) -> Result<Vec<u8>, LibraryError> {
    let (_, mut from) = store.open(name)?;
    let mut bytes = Vec::new();
    let read = { from.by_ref() }
        .take(LARGEST_PROGRAM + 1)
        .read_to_end(&mut bytes);
    match read {
        Err(error) => Err(LibraryError::Other(error.to_string())),
        Ok(count) if count as u64 > LARGEST_PROGRAM => Err(LibraryError::TooLarge),
        Ok(_) => Ok(bytes),
    }
}

/// Keeps a program; whether its name is a new one.
pub(crate) fn keep(
    store: &dyn ProgramStore,
    name: &ProgramName,
    by: Role,
    bytes: &[u8],
) -> Result<bool, LibraryError> {
    let mut upload = store.upload(name, by, Some(bytes.len() as u64))?;
    upload.write(bytes)?;
    upload.finish()
}

/// Something to do with the library.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum LibraryAct {
    /// Lists the programs.
    List,
    /// Gives the bytes of one.
    Get(ProgramName),
    /// Says whether there is a program, and a preset.
    Find {
        /// The program, if one is meant.
        program: Option<ProgramName>,
        /// The preset, if one is meant.
        preset: Option<String>,
    },
    /// Keeps one.
    Put(ProgramName, Vec<u8>),
    /// Removes one.
    Delete(ProgramName),
    /// Makes another file of one.
    Convert {
        /// Of this.
        from: ProgramName,
        /// Under this name.
        to: ProgramName,
        /// How it is drawn or engraved.
        setup: Option<Box<SetupOptions>>,
        /// By which preset.
        preset: Option<String>,
    },
    /// Something with presets.
    Presets(PresetAct),
}

/// Something to do with the library, for a request.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LibraryOrder {
    /// The request.
    pub request: RequestId,
    /// The role of its session.
    pub by: Role,
    /// What.
    pub act: LibraryAct,
}

impl LibraryAct {
    /// Does it beside all else, and says what is answered.
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
        } = self
        else {
            return beside(move || self.carry_out_on(by, &*store, &presets)).await?;
        };
        let source = Source {
            bytes: SourceBytes::Program(from.as_str().to_owned()),
            format: None,
            setup,
            preset,
        };
        let (opened, name) = (Arc::clone(&store), to.clone());
        let converted = beside(move || {
            // One that is not there is named as this method names it.
            opened.open(&from).map_err(wrong)?;
            reader.convert(&source, name.as_str())
        });
        let mut converted = converted.await??;
        loop {
            match converted {
                Converting::ToCome(to_come) => converted = to_come.await?,
                Converting::Done(bytes, report) => {
                    let kept = beside(move || keep(&*store, &to, by, &bytes).map_err(wrong));
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
            Self::List => {
                let programs = store.list().map_err(wrong)?;
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
                let (size, _) = store.open(&name).map_err(wrong)?;
                if size > IN_AN_ANSWER {
                    let why = format!(
                        "{name} has {size} bytes, and an answer has room for {IN_AN_ANSWER}: get \
                            it by HTTP from /api/v1/programs"
                    );
                    return Err(RpcError::arm(ErrorKind::InvalidInput, why));
                }
                let bytes = bytes_of(store, &name).map_err(wrong)?;
                let format = Format::of(name.as_str(), &bytes).map(Format::name);
                let data = STANDARD.encode(bytes);
                Ok(json!({"name": name.as_str(), "format": format, "data": data}))
            }
            Self::Find { program, preset } => {
                match program.map(|name| store.open(&name)).transpose() {
                    Ok(_) => {}
                    Err(LibraryError::Unknown) => return Err(unknown_program()),
                    Err(error) => return Err(wrong(error)),
                }
                let preset = preset.map(|name| presets.load(&name)).transpose();
                preset.map_err(|error| presets::wrong(error, "setup.preset"))?;
                Ok(Value::Null)
            }
            Self::Put(name, bytes) => {
                keep(store, &name, by, &bytes).map_err(wrong)?;
                Ok(json!({"name": name.as_str(), "bytes": bytes.len()}))
            }
            Self::Delete(name) => {
                store.delete(&name).map_err(wrong)?;
                Ok(Value::Null)
            }
            Self::Convert { .. } => Err(RpcError::internal("it is not done at once")),
        }
    }
}

/// A job names a program that is not there.
pub(crate) fn unknown_program() -> RpcError {
    RpcError::param("program", LibraryError::Unknown.to_string())
}

/// What is wrong with a program, as an answer.
pub(crate) fn wrong(error: LibraryError) -> RpcError {
    match error {
        LibraryError::Unknown => RpcError::param("name", error.to_string()),
        LibraryError::TooLarge => RpcError::arm(ErrorKind::InvalidInput, error.to_string()),
        LibraryError::Quota(met) => {
            let shown = |of: LibraryUse| json!({"programs": of.programs, "bytes": of.bytes});
            RpcError::arm(ErrorKind::InvalidInput, met.to_string())
                .with("quota", shown(met.quota))
                .with("used", shown(met.used))
        }
        _ => RpcError::arm(ErrorKind::Unexpected, error.to_string()),
    }
}

/// Where they are, as an answer.
pub(crate) fn folder_of(store: &dyn ProgramStore) -> Value {
    let folder: Option<PathBuf> = store.folder().map(Path::to_owned);
    folder.map_or(Value::Null, |folder| json!(folder.display().to_string()))
}
