//! The measured work surfaces: that of the only real arm is the one of the settings, as `calibrate`
//! keeps it.

use magician_job::{WorkSurface, keep_surface, kept_surface};
use magician_station::{ArmEntry, KnownSurface, MemorySurfaces, SurfaceStore};

/// Keeps the surface of the only real arm in the settings, where every verb reads it. A virtual arm
/// and a real table say nothing about each other, and of several real arms each has a table of its
/// own, while the settings have one: those are kept as long as the station runs.
pub(super) struct Surfaces {
    touched: MemorySurfaces,
    is_only_real: bool,
}

impl Surfaces {
    /// Creates the store for these arms.
    pub(super) fn under(arms: &[ArmEntry]) -> Self {
        let real = arms.iter().filter(|arm| !arm.is_virtual).count();
        Self {
            touched: MemorySurfaces::default(),
            is_only_real: real == 1,
        }
    }

    fn is_in_settings(&self, arm: &ArmEntry) -> bool {
        self.is_only_real && !arm.is_virtual
    }
}

impl SurfaceStore for Surfaces {
    fn surface(&self, arm: &ArmEntry) -> magician::Result<KnownSurface> {
        if let known @ KnownSurface::Measured(_) = self.touched.surface(arm)? {
            return Ok(known);
        }
        if arm.is_virtual {
            return Ok(KnownSurface::Unknown);
        }
        // As they are now: another program may have changed them.
        let kept = kept_surface()?;
        Ok(kept.map_or(KnownSurface::Unknown, KnownSurface::Measured))
    }

    fn keep(&self, arm: &ArmEntry, surface: Option<WorkSurface>) -> magician::Result<()> {
        if self.is_in_settings(arm) {
            keep_surface(surface)
        } else {
            self.touched.keep(arm, surface)
        }
    }
}
