//! Configuration of a station, its arms, and the rights of a client.

use std::fmt;
use std::sync::Arc;

use magician_job::presets::Presets;

use crate::api::Role;
use crate::frames::FrameRing;
use crate::job::{FormatReader, Reader};
use crate::job_store::{JobStore, NoJobStore};
use crate::library::{NoPrograms, ProgramStore};
use crate::recording::{NoRecordings, RecordingStore};
use crate::surface::{MemorySurfaces, SurfaceStore};

/// Rights of a client, and their source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Grant {
    /// Role.
    pub role: Role,
    /// Name of the token. `None` for a client that needs no token.
    pub token: Option<String>,
}

/// Arm of a station.
#[derive(Clone, Debug, PartialEq)]
pub struct ArmEntry {
    /// Name: `[a-z0-9][a-z0-9_-]{0,31}`.
    pub name: String,
    /// Port, as given by the user.
    pub port: String,
    /// True for a virtual arm of this process. It burns nothing.
    pub is_virtual: bool,
    /// True if a laser may be mounted at the arm's pins.
    pub laser_pins: bool,
    /// Fence. [`RunningStation`](crate::RunningStation) sets it from the arm.
    pub fence: Option<magician::Fence>,
}

/// Configuration of a station.
pub struct StationConfig {
    /// Arms.
    pub arms: Vec<ArmEntry>,
    /// Prefix of all ids. Must differ for each start of a station, so that no id is used twice.
    pub epoch: String,
    /// Unix time at [`HostInstant::ZERO`](magician_protocol::HostInstant::ZERO), s.
    pub unix_zero: f64,
    /// Version of the program.
    pub version: String,
    /// True to limit every session to the role of a viewer.
    pub read_only: bool,
    /// True to let students burn with the laser of a real arm.
    pub student_laser: bool,
    /// Reader of programs.
    pub reader: Arc<dyn Reader>,
    /// Store of jobs.
    pub jobs: Arc<dyn JobStore>,
    /// Store of measured work surfaces.
    pub surfaces: Arc<dyn SurfaceStore>,
    /// Store of recordings.
    pub recordings: Arc<dyn RecordingStore>,
    /// Most readings per second for the history of the last ten minutes. With 0 only readings made
    /// for other purposes are kept.
    pub ring: u32,
    /// True to save the history to a file when an alarm is raised.
    pub save_on_alarm: bool,
    /// Traffic of the arms' lines, by index. Empty if no line is tapped.
    pub lines: Vec<Arc<FrameRing>>,
    /// Library of programs.
    pub programs: Arc<dyn ProgramStore>,
    /// Presets of drawing and engraving.
    pub presets: Presets,
    /// Text of the class file. `None` uses the stored one.
    #[cfg(feature = "class")]
    pub class: Option<String>,
    /// Text of the schedule file. `None` uses the stored one.
    #[cfg(feature = "class")]
    pub schedule: Option<String>,
    /// Source of unpredictable numbers, for codes.
    #[cfg(feature = "class")]
    pub random: fn() -> u64,
}

impl ArmEntry {
    /// Creates the entry of a virtual arm of this process.
    #[must_use]
    pub fn simulated(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            port: "sim".to_owned(),
            is_virtual: true,
            laser_pins: true,
            fence: None,
        }
    }
}

impl StationConfig {
    /// Creates a configuration with these arms and defaults: no tokens, built-in formats, nothing
    /// stored beyond the station's lifetime, a clock that starts in 1970.
    #[must_use]
    pub fn new(arms: Vec<ArmEntry>, epoch: impl Into<String>) -> Self {
        Self::reading_by(arms, epoch, Arc::new(FormatReader::default()))
    }

    /// Creates the same configuration with this reader of programs.
    #[must_use]
    pub fn reading_by(
        arms: Vec<ArmEntry>,
        epoch: impl Into<String>,
        reader: Arc<dyn Reader>,
    ) -> Self {
        Self {
            arms,
            epoch: epoch.into(),
            unix_zero: 0.0,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            read_only: false,
            student_laser: false,
            reader,
            jobs: Arc::new(NoJobStore),
            surfaces: Arc::new(MemorySurfaces::default()),
            recordings: Arc::new(NoRecordings),
            ring: 0,
            save_on_alarm: true,
            lines: Vec::new(),
            programs: Arc::new(NoPrograms),
            presets: Presets::default(),
            #[cfg(feature = "class")]
            class: None,
            #[cfg(feature = "class")]
            schedule: None,
            #[cfg(feature = "class")]
            random: crate::class::random,
        }
    }
}

impl fmt::Debug for StationConfig {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("StationConfig")
            .field("arms", &self.arms)
            .field("epoch", &self.epoch)
            .finish_non_exhaustive()
    }
}
