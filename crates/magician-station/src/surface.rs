//! Measured work surfaces under the arms of a station, and where they are kept.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use magician::{Arm, Error, ErrorCode, Result};
use magician_job::{Touch, WorkSurface, sheet_counts, touch_off};
use magician_program::artwork::Sheet;
use magician_program::{
    Diagnostic, FittedSurface, SetupDefaults, SheetCorner, Tool, TouchedCorners,
};
use serde_json::{Value, json};

use crate::ArmEntry;
use crate::api::RpcError;
use crate::engine::beside;

/// Knowledge of the work surface under an arm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum KnownSurface {
    /// Not measured: the settings of the [`Reader`](crate::Reader) count.
    #[default]
    BySettings,
    /// Unknown height.
    Unknown,
    /// Measured by touches, or by the corners of a sheet.
    Measured(WorkSurface),
}

impl KnownSurface {
    /// Puts the surface in the place of the one that the settings say.
    pub(crate) fn apply_to(self, defaults: &mut SetupDefaults, is_virtual: bool) {
        match self {
            Self::BySettings => {}
            Self::Unknown => {
                defaults.surface = None;
                // The settings were read when the station began: a real arm's sheet may be gone since.
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

/// Keeps measured work surfaces. It may take its time: it is asked beside what the arm does.
pub trait SurfaceStore: Send + Sync {
    /// Returns the knowledge of the surface under an arm.
    ///
    /// # Errors
    /// What keeps it from being read.
    fn surface(&self, arm: &ArmEntry) -> Result<KnownSurface>;

    /// Keeps the surface under an arm; `None` forgets it.
    ///
    /// # Errors
    /// What keeps it from being kept: nothing has changed then.
    fn keep(&self, arm: &ArmEntry, surface: Option<WorkSurface>) -> Result<()>;
}

/// Keeps them in memory, as long as the station runs.
#[derive(Debug, Default)]
pub struct MemorySurfaces(Mutex<BTreeMap<String, WorkSurface>>);

impl SurfaceStore for MemorySurfaces {
    fn surface(&self, arm: &ArmEntry) -> Result<KnownSurface> {
        let surfaces = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let surface = surfaces.get(&arm.name).copied();
        Ok(surface.map_or(KnownSurface::BySettings, KnownSurface::Measured))
    }

    fn keep(&self, arm: &ArmEntry, surface: Option<WorkSurface>) -> Result<()> {
        let mut surfaces = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match surface {
            Some(surface) => surfaces.insert(arm.name.clone(), surface.rounded()),
            None => surfaces.remove(&arm.name),
        };
        Ok(())
    }
}

/// A measurement that further touches add to, kept as long as the station runs.
#[derive(Default)]
struct Measuring {
    /// Touches that the kept plane was fitted to.
    touches: Vec<[f64; 3]>,
    /// The plane that they gave: another one was measured elsewhere, and they say nothing of it.
    plane: Option<WorkSurface>,
    /// Largest distance of a touch from the plane, mm.
    residual: f64,
    /// Corners of a sheet that is not complete.
    corners: TouchedCorners,
}

/// The work surface under one arm.
#[derive(Clone)]
pub struct ArmSurface {
    entry: ArmEntry,
    store: Arc<dyn SurfaceStore>,
    measuring: Arc<Mutex<Measuring>>,
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
        Self {
            entry,
            store,
            measuring: Arc::default(),
        }
    }

    /// Reads the knowledge of it from the store.
    pub(crate) async fn known(&self) -> std::result::Result<KnownSurface, RpcError> {
        let this = self.clone();
        Ok(beside(move || this.store.surface(&this.entry)).await??)
    }

    /// Returns the answer of `surface.get`.
    pub(crate) async fn shown(&self) -> std::result::Result<Value, RpcError> {
        let known = self.known().await?;
        Ok(self.told(known))
    }

    /// Takes a height from where the tool of the arm touches it, and keeps the plane: that of this
    /// touch alone, or of those before as well (`adds`).
    pub(crate) async fn touch(
        self,
        arm: Arm,
        draws: Tool,
        adds: bool,
    ) -> std::result::Result<Value, RpcError> {
        let known = self.known().await?;
        if let KnownSurface::Measured(WorkSurface::Sheet(_)) = known {
            return Err(Error::new(ErrorCode::InvalidSettings, sheet_counts()).into());
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
        self.keep(Some(plane)).await?;
        self.with_measuring(|measuring| {
            *measuring = Measuring {
                touches,
                plane: Some(plane),
                residual: fitted.residual,
                corners: measuring.corners,
            };
        });
        Ok(self.told(KnownSurface::Measured(plane)))
    }

    /// Takes a corner of a sheet from where the tool of the arm touches it. With the third one the
    /// sheet is kept, in the place of what was known.
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
        // A corner that makes no sheet with the others is not taken: it can be touched again.
        let sheet = corners.sheet().map_err(refused)?;
        let Some(sheet) = sheet else {
            self.with_measuring(|measuring| measuring.corners = corners);
            return self.shown().await;
        };
        let sheet = WorkSurface::Sheet(sheet.rounded());
        self.keep(Some(sheet)).await?;
        self.with_measuring(|measuring| *measuring = Measuring::default());
        Ok(self.told(KnownSurface::Measured(sheet)))
    }

    /// Forgets what was measured.
    pub(crate) async fn forget(self) -> std::result::Result<Value, RpcError> {
        self.keep(None).await?;
        self.with_measuring(|measuring| *measuring = Measuring::default());
        self.shown().await
    }

    async fn keep(&self, surface: Option<WorkSurface>) -> std::result::Result<(), RpcError> {
        let this = self.clone();
        Ok(beside(move || this.store.keep(&this.entry, surface)).await??)
    }

    fn with_measuring<T>(&self, change: impl FnOnce(&mut Measuring) -> T) -> T {
        let mut measuring = self
            .measuring
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        change(&mut measuring)
    }

    /// The touches that gave this plane; none if another station or the command measured it.
    fn touches_of(&self, plane: WorkSurface) -> Vec<[f64; 3]> {
        self.with_measuring(|measuring| match measuring.plane {
            Some(own) if own == plane => measuring.touches.clone(),
            _ => Vec::new(),
        })
    }

    /// The answer of all methods of the surface.
    fn told(&self, known: KnownSurface) -> Value {
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
        let z = magician_program::rounded_height(plane.at([x, y]));
        let [slope_x, slope_y] = plane.slope;
        json!({
            "touches": if sheet.is_some() { 3 } else { touches.len().max(1) },
            "plane": {"at": [x, y], "z": z, "slope_x": slope_x, "slope_y": slope_y},
            "residual": if touches.is_empty() { 0.0 } else { (residual * 1e3).round() / 1e3 },
            "corners": corners,
            "sheet": sheet.map(told_sheet),
        })
    }
}

/// A sheet with the four corners of its outline, from the lower left one against the clock.
fn told_sheet(sheet: Sheet) -> Value {
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
