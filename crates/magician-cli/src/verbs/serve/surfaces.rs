//! Store for measured work surfaces: the surface of the only real arm is kept in the settings, as
//! `calibrate` does.

use magician_job::{WorkSurface, store_surface, stored_surface};
use magician_station::{ArmEntry, KnownSurface, MemorySurfaces, SurfaceStore};

/// Keeps the surface of the only real arm in the settings, where every verb reads it. Other
/// surfaces last as long as the station: the settings have room for one, several real arms have a
/// table each, and a virtual arm's table says nothing about a real one.
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
        // Read anew, since another program may have changed the settings.
        let kept = stored_surface()?;
        Ok(kept.map_or(KnownSurface::Unknown, KnownSurface::Measured))
    }

    fn store(&self, arm: &ArmEntry, surface: Option<WorkSurface>) -> magician::Result<()> {
        if self.is_in_settings(arm) {
            store_surface(surface)
        } else {
            self.touched.store(arm, surface)
        }
    }
}
