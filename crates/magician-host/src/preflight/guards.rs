//! Guards: the checks of a program that a caller can switch off.

use crate::{Error, Result};

/// Checks of a [`Preflight`](super::Preflight) that can be switched off. All are on except
/// [`require_homed`](Self::require_homed).
///
/// Values that are NaN, infinite or out of range are always refused.
///
/// ```
/// use magician_host::preflight::Guards;
///
/// // A program that pierces: the laser burns while the arm waits.
/// let guards = Guards::default().laser(false);
/// assert!(guards.reach && !guards.laser && !guards.require_homed);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Guards {
    /// Refuses targets and paths that are out of reach or beyond a limit.
    pub reach: bool,
    /// Refuses paths that cannot be checked because their start is unknown: after homing to an
    /// unknown point, or if the arm was moving when the check began.
    ///
    /// A move of all joints to an absolute target passes nevertheless, and makes the position
    /// known. Lines, jumps, arcs, paths and increments do not pass.
    pub unknown_start: bool,
    /// Refuses jogs in a program: they continue until a limit ends them with an alarm, and a queued
    /// stop comes too late. Jog with `Arm::set` and `Arm::stop_jog`.
    pub jog: bool,
    /// Refuses a laser that burns while the arm waits, homes or moves by joints, and a laser that
    /// is left on at the end. It may burn along lines, arcs and continuous paths.
    ///
    /// The power of a path counts until a segment without power or
    /// [`laser(false)`](crate::build::laser). The firmware probably switches the laser off when the
    /// arm comes to rest (model section 8), but this is unconfirmed.
    pub laser: bool,
    /// Refuses to begin a program under an alarm that holds the queue. Homing runs nevertheless.
    pub alarms: bool,
    /// Refuses to move an arm that was not homed since power-up, according to alarm 0x00. Off by
    /// default, which gives a warning.
    pub require_homed: bool,
}

impl Default for Guards {
    fn default() -> Self {
        // Off, because alarm 0x00 also stands on a homed arm whose alarms were not cleared.
        Self::ALL.require_homed(false)
    }
}

/// Setters, one for each guard.
macro_rules! setters {
    ($($name:ident)+) => {
        impl Guards {
            /// Every guard on.
            pub const ALL: Self = Self { $($name: true),+ };
            /// Every guard off.
            pub const NONE: Self = Self { $($name: false),+ };

            $(
                #[doc = concat!("Sets [`", stringify!($name), "`](field@Self::", stringify!($name), ").")]
                #[must_use]
                pub fn $name(mut self, on: bool) -> Self {
                    self.$name = on;
                    self
                }
            )+
        }
    };
}

setters! { reach unknown_start jog laser alarms require_homed }

/// Returns an error that names the guard, if the guard is on.
///
/// # Errors
/// [`InvalidInput`](crate::ErrorKind::InvalidInput) with [`Error::guard`].
pub fn refuse(on: bool, name: &'static str, why: impl Into<crate::Message>) -> Result<()> {
    if on {
        Err(Error::guarded(name, why))
    } else {
        Ok(())
    }
}
