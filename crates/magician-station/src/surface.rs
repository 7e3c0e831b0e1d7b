//! Heights of the work surfaces under the arms of a station, and where they are kept.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use magician::{Arm, Result};
use magician_job::touch_off;
use magician_program::{Surface, Tool};
use serde_json::{Value, json};

use crate::ArmEntry;
use crate::api::RpcError;
use crate::engine::beside;

/// Knowledge of the work surface under an arm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum KnownSurface {
    /// No touch: the settings of the [`Reader`](crate::Reader) count.
    #[default]
    BySettings,
    /// Unknown height.
    Unknown,
    /// Level surface at this height, mm.
    Level(f64),
}

impl KnownSurface {
    /// The surface that a program is laid on, where the settings of a reader say this one.
    pub(crate) fn or(self, settings: Option<Surface>) -> Option<Surface> {
        match self {
            Self::BySettings => settings,
            Self::Unknown => None,
            Self::Level(height) => Some(Surface::level(height)),
        }
    }
}

/// Keeps the heights of work surfaces that were touched. It may take its time: it is asked beside
/// what the arm does.
pub trait SurfaceStore: Send + Sync {
    /// Returns the knowledge of the surface under an arm.
    ///
    /// # Errors
    /// What keeps it from being read.
    fn surface(&self, arm: &ArmEntry) -> Result<KnownSurface>;

    /// Keeps the height of the surface under an arm, mm; `None` forgets it.
    ///
    /// # Errors
    /// What keeps it from being kept: nothing has changed then.
    fn keep(&self, arm: &ArmEntry, height: Option<f64>) -> Result<()>;
}

/// Keeps them in memory, as long as the station runs.
#[derive(Debug, Default)]
pub struct MemorySurfaces(Mutex<BTreeMap<String, f64>>);

impl SurfaceStore for MemorySurfaces {
    fn surface(&self, arm: &ArmEntry) -> Result<KnownSurface> {
        let heights = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let height = heights.get(&arm.name).copied();
        Ok(height.map_or(KnownSurface::BySettings, KnownSurface::Level))
    }

    fn keep(&self, arm: &ArmEntry, height: Option<f64>) -> Result<()> {
        let mut heights = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match height {
            Some(height) => heights.insert(arm.name.clone(), height),
            None => heights.remove(&arm.name),
        };
        Ok(())
    }
}

/// The work surface under one arm.
#[derive(Clone)]
pub struct ArmSurface {
    entry: ArmEntry,
    store: Arc<dyn SurfaceStore>,
}

impl fmt::Debug for ArmSurface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ArmSurface")
            .field("entry", &self.entry)
            .finish_non_exhaustive()
    }
}

impl ArmSurface {
    /// The surface under this arm, which this store keeps.
    #[must_use]
    pub fn new(entry: ArmEntry, store: Arc<dyn SurfaceStore>) -> Self {
        Self { entry, store }
    }

    /// Reads the knowledge of it from the store.
    pub(crate) async fn known(&self) -> std::result::Result<KnownSurface, RpcError> {
        let this = self.clone();
        Ok(beside(move || this.store.surface(&this.entry)).await??)
    }

    /// Returns the answer of `surface.get`.
    pub(crate) async fn shown(&self) -> std::result::Result<Value, RpcError> {
        Ok(match self.known().await? {
            KnownSurface::Level(height) => level([0.0, 0.0], height),
            _ => json!({"touches": 0, "plane": null, "residual": null}),
        })
    }

    /// Takes its height from where the tool of the arm touches it, and keeps it.
    pub(crate) async fn touch(self, arm: Arm, draws: Tool) -> std::result::Result<Value, RpcError> {
        let touch = touch_off(&arm, draws).await?;
        self.keep(Some(touch.height)).await?;
        Ok(level(touch.at, touch.height))
    }

    /// Forgets its height.
    pub(crate) async fn forget(self) -> std::result::Result<Value, RpcError> {
        self.keep(None).await?;
        self.shown().await
    }

    async fn keep(&self, height: Option<f64>) -> std::result::Result<(), RpcError> {
        let this = self.clone();
        Ok(beside(move || this.store.keep(&this.entry, height)).await??)
    }
}

/// The answer of one touch: a level plane.
fn level(at: [f64; 2], z: f64) -> Value {
    let plane = json!({"at": at, "z": z, "slope_x": 0.0, "slope_y": 0.0});
    json!({"touches": 1, "plane": plane, "residual": 0.0})
}
