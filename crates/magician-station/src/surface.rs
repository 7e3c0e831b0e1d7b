//! Measured heights of the work surface under each arm, and where they are stored.
//!
//! A surface is measured by touching it with the tool: one touch gives a height, several give a
//! plane, three corners give a sheet with its position. The result is stored per arm and replaces
//! the height in the settings, so that a pen is never sent below the measured surface. Touches of
//! one measurement are kept in memory only: after a restart a further touch starts a new
//! measurement.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use magician::{Arm, Error, ErrorCode, Result};
use magician_job::{Touch, WorkSurface, sheet_stored_message, touch_off};
use magician_program::artwork::Sheet;
use magician_program::{
    Diagnostic, FittedSurface, SetupDefaults, SheetCorner, Tool, TouchedCorners,
};
use serde_json::{Value, json};

use crate::ArmEntry;
use crate::api::RpcError;
use crate::engine::run_blocking;

/// Knowledge of the work surface under an arm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum KnownSurface {
    /// Not measured: the settings of the [`Reader`](crate::Reader) apply.
    #[default]
    BySettings,
    /// Unknown height.
    Unknown,
    /// Measured by touches, or by corners of a sheet.
    Measured(WorkSurface),
}

impl KnownSurface {
    /// Replaces the surface in the defaults by this one.
    pub(crate) fn apply_to(self, defaults: &mut SetupDefaults, is_virtual: bool) {
        match self {
            Self::BySettings => {}
            Self::Unknown => {
                defaults.surface = None;
                // The default dates from the start of the station. The sheet under a real arm may
                // be gone since.
                defaults.sheet = defaults.sheet.filter(|_| is_virtual);
            }
            Self::Measured(WorkSurface::Plane(surface)) => {
                (defaults.surface, defaults.sheet) = (Some(surface), None);
            }
            Self::Measured(WorkSurface::Sheet(sheet)) => defaults.sheet = Some(sheet),
            #[cfg(not(magician_workspace))]
            Self::Measured(_) => unreachable!(),
        }
    }
}

/// Store of measured surfaces. Calls may block: they are made off the arm's task.
pub trait SurfaceStore: Send + Sync {
    /// Returns what is known of the surface under an arm.
    ///
    /// # Errors
    /// The store cannot be read.
    fn surface(&self, arm: &ArmEntry) -> Result<KnownSurface>;

    /// Stores the surface under an arm. `None` forgets it.
    ///
    /// # Errors
    /// The surface cannot be stored; then nothing has changed.
    fn store(&self, arm: &ArmEntry, surface: Option<WorkSurface>) -> Result<()>;
}

/// Store in memory, for the lifetime of the station.
#[derive(Debug, Default)]
pub struct MemorySurfaces(Mutex<BTreeMap<String, WorkSurface>>);

impl SurfaceStore for MemorySurfaces {
    fn surface(&self, arm: &ArmEntry) -> Result<KnownSurface> {
        let surfaces = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let surface = surfaces.get(&arm.name).copied();
        Ok(surface.map_or(KnownSurface::BySettings, KnownSurface::Measured))
    }

    fn store(&self, arm: &ArmEntry, surface: Option<WorkSurface>) -> Result<()> {
        let mut surfaces = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match surface {
            Some(surface) => surfaces.insert(arm.name.clone(), surface.rounded()),
            None => surfaces.remove(&arm.name),
        };
        Ok(())
    }
}

/// Measurement in progress, to which further touches are added. Kept for the lifetime of the
/// station.
#[derive(Default)]
struct Measuring {
    /// Touches that the stored plane was fitted to.
    touches: Vec<[f64; 3]>,
    /// The plane that they gave. If another plane is stored, it was measured elsewhere, and these
    /// touches do not belong to it.
    plane: Option<WorkSurface>,
    /// Largest distance of a touch from the plane, mm.
    residual: f64,
    /// Corners touched so far, while the sheet is incomplete.
    corners: TouchedCorners,
}

/// Called with the answer to `surface.get` whenever that has changed.
type Listener = Arc<dyn Fn(Value) + Send + Sync>;

/// Cause of an answer about a surface.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Cause {
    /// A client asked.
    Reading,
    /// The surface was measured or forgotten.
    Change,
}

/// Work surface under one arm.
#[derive(Clone)]
pub struct ArmSurface {
    entry: ArmEntry,
    store: Arc<dyn SurfaceStore>,
    measuring: Arc<Mutex<Measuring>>,
    /// Last answer to a client. `None` before the first.
    last: Arc<Mutex<Option<Value>>>,
    listener: Option<Listener>,
}

impl fmt::Debug for ArmSurface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ArmSurface")
            .field("entry", &self.entry)
            .finish_non_exhaustive()
    }
}

impl ArmSurface {
    /// Creates the surface of this arm, stored in `store`.
    #[must_use]
    pub fn new(entry: ArmEntry, store: Arc<dyn SurfaceStore>) -> Self {
        Self {
            entry,
            store,
            measuring: Arc::default(),
            last: Arc::default(),
            listener: None,
        }
    }

    /// Calls `listener` with the answer to `surface.get` whenever that has changed: by a touch, or
    /// by another program, which shows at the next reading of the store.
    pub(crate) fn on_change(&mut self, listener: impl Fn(Value) + Send + Sync + 'static) {
        self.listener = Some(Arc::new(listener));
    }

    /// Reads the store.
    pub(crate) async fn known(&self) -> std::result::Result<KnownSurface, RpcError> {
        let this = self.clone();
        Ok(run_blocking(move || this.store.surface(&this.entry)).await??)
    }

    /// Returns the answer to `surface.get`.
    pub(crate) async fn shown(&self) -> std::result::Result<Value, RpcError> {
        let known = self.known().await?;
        Ok(self.publish(known, Cause::Reading))
    }

    /// Takes a height from where the tool of the arm touches the surface, and stores the resulting
    /// plane. `adds`: earlier touches count as well, otherwise this touch alone.
    pub(crate) async fn touch(
        self,
        arm: Arm,
        draws: Tool,
        adds: bool,
    ) -> std::result::Result<Value, RpcError> {
        let known = self.known().await?;
        // A sheet's height comes from its corners: a height beside it would contradict them.
        if let KnownSurface::Measured(WorkSurface::Sheet(_)) = known {
            return Err(Error::new(ErrorCode::InvalidSettings, sheet_stored_message()).into());
        }
        let touch = touch_off(&arm, draws).await?;
        let point = point(touch.at, touch);
        let mut touches = match known {
            KnownSurface::Measured(plane) if adds => self.touches_of(plane),
            _ => Vec::new(),
        };
        touches.push(point);
        let fitted = FittedSurface::touched(&touches).map_err(refused)?;
        let plane = WorkSurface::Plane(fitted.surface).rounded();
        // Stored first: if that fails, the touches in memory stay those of the stored plane.
        self.store(Some(plane)).await?;
        self.with_measuring(|measuring| {
            *measuring = Measuring {
                touches,
                plane: Some(plane),
                residual: fitted.residual,
                corners: measuring.corners,
            };
        });
        Ok(self.publish(KnownSurface::Measured(plane), Cause::Change))
    }

    /// Takes a corner of a sheet from where the tool of the arm touches it. With the third corner
    /// the sheet is stored and replaces what was known.
    pub(crate) async fn take_corner(
        self,
        arm: Arm,
        draws: Tool,
        corner: SheetCorner,
    ) -> std::result::Result<Value, RpcError> {
        let touch = touch_off(&arm, draws).await?;
        let point = point(touch.tip, touch);
        let before = self.with_measuring(|measuring| measuring.corners);
        let corners = before.with(corner, point).map_err(refused)?;
        // A corner that does not form a sheet with the others is not stored: it can be touched
        // again.
        let sheet = corners.sheet().map_err(refused)?;
        let Some(sheet) = sheet else {
            self.with_measuring(|measuring| measuring.corners = corners);
            let known = self.known().await?;
            return Ok(self.publish(known, Cause::Change));
        };
        let sheet = WorkSurface::Sheet(sheet.rounded());
        self.store(Some(sheet)).await?;
        self.with_measuring(|measuring| *measuring = Measuring::default());
        Ok(self.publish(KnownSurface::Measured(sheet), Cause::Change))
    }

    /// Forgets all measurements.
    pub(crate) async fn forget(self) -> std::result::Result<Value, RpcError> {
        self.store(None).await?;
        self.with_measuring(|measuring| *measuring = Measuring::default());
        let known = self.known().await?;
        Ok(self.publish(known, Cause::Change))
    }

    async fn store(&self, surface: Option<WorkSurface>) -> std::result::Result<(), RpcError> {
        let this = self.clone();
        Ok(run_blocking(move || this.store.store(&this.entry, surface)).await??)
    }

    fn with_measuring<T>(&self, change: impl FnOnce(&mut Measuring) -> T) -> T {
        let mut measuring = self
            .measuring
            // A poisoned lock still holds whole values.
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        change(&mut measuring)
    }

    /// Returns the touches that gave this plane. Empty if another station or the command line
    /// measured it.
    fn touches_of(&self, plane: WorkSurface) -> Vec<[f64; 3]> {
        self.with_measuring(|measuring| match measuring.plane {
            Some(own) if own == plane => measuring.touches.clone(),
            _ => Vec::new(),
        })
    }

    /// Returns the answer of all methods of the surface. Passes it to the listener if it differs
    /// from the one before.
    fn publish(&self, known: KnownSurface, cause: Cause) -> Value {
        let answer = self.answer(known);
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let before = last.replace(answer.clone());
        let has_changed = match &before {
            Some(before) => *before != answer,
            // No session has seen an answer, so a first reading changes nothing for them.
            None => cause == Cause::Change,
        };
        // Under the lock, so that two changes are reported in order.
        if has_changed && let Some(listener) = &self.listener {
            listener(answer.clone());
        }
        answer
    }

    fn answer(&self, known: KnownSurface) -> Value {
        let corners = self.with_measuring(|measuring| measuring.corners);
        let corners: Vec<_> = SheetCorner::ALL
            .into_iter()
            .filter(|&corner| corners.at(corner).is_some())
            .map(SheetCorner::name)
            .collect();
        let KnownSurface::Measured(surface) = known else {
            return json!({
                "touches": 0, "plane": null, "residual": null, "corners": corners, "sheet": null,
            });
        };
        let touches = self.touches_of(surface);
        let residual = self.with_measuring(|measuring| measuring.residual);
        let plane = surface.plane();
        let (sheet, [x, y]) = match surface {
            WorkSurface::Sheet(sheet) => (Some(sheet), sheet.corner),
            _ => (
                None,
                touches.first().map_or([0.0, 0.0], |&[x, y, _]| [x, y]),
            ),
        };
        // Rounded like the stored value, so that both show the same digits.
        let z = magician_program::rounded_height(plane.at([x, y]));
        let [slope_x, slope_y] = plane.slope;
        // A plane from the store counts as one touch: it exists, but its touches are not kept.
        json!({
            "touches": if sheet.is_some() { 3 } else { touches.len().max(1) },
            "plane": {"at": [x, y], "z": z, "slope_x": slope_x, "slope_y": slope_y},
            "residual": if touches.is_empty() { 0.0 } else { (residual * 1e3).round() / 1e3 },
            "corners": corners,
            "sheet": sheet.map(sheet_value),
        })
    }
}

/// Returns a sheet as JSON, with the four corners of its outline counterclockwise from the lower
/// left.
fn sheet_value(sheet: Sheet) -> Value {
    let [width, height] = sheet.size.unwrap_or_default();
    let outline = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]].map(|at| {
        let [x, y] = magician_program::artwork::rotated(at, sheet.rotation);
        [sheet.corner[0] + x, sheet.corner[1] + y].map(magician_program::rounded_height)
    });
    json!({
        "corner": sheet.corner,
        "rotation": sheet.rotation,
        "size": sheet.size,
        "outline": outline,
    })
}

fn point([x, y]: [f64; 2], touch: Touch) -> [f64; 3] {
    [x, y, touch.height]
}

fn refused(problem: Diagnostic) -> RpcError {
    RpcError::from(Error::from(problem))
}
