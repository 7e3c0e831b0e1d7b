use crate::{Error, Result};

/// What a [`Preflight`](super::Preflight) refuses, each by a name of its own. All are on but
/// [`require_homed`](Self::require_homed).
///
/// Numbers that are none, speeds that are none and values that the protocol does not have are
/// refused whatever is switched off here.
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
    /// Targets and ways out of reach or beyond a limit.
    pub reach: bool,
    /// Paths that cannot be checked, because their start is unknown: after homing to a point
    /// that is not known, or when the arm was moving as the check began. A move of all joints to an
    /// absolute target passes nevertheless: from there on the arm's place is known. Anything else
    /// (a line, a jump, an arc, a path, an increment) does not.
    pub unknown_start: bool,
    /// Jogs in a program: they go on until a limit ends them with an alarm, and a stop that is
    /// queued comes too late. Jog with `Arm::set` and
    /// `Arm::stop_jog`.
    pub jog: bool,
    /// A laser that burns while the arm waits, homes, or travels with its joints, and one that is
    /// left burning at the end. It may burn along lines, arcs and continuous paths.
    ///
    /// The power of a path counts until a segment without power or
    /// [`laser(false)`](crate::build::laser): that the arm darkens the laser by itself where it comes
    /// to rest is likely (model section 8) and not certain.
    pub laser: bool,
    /// An alarm that holds the queue when the program begins. Homing runs all the same.
    pub alarms: bool,
    /// An arm that has not been homed since it was switched on, as far as the alarm 0x00 tells. Off
    /// at first: then there is a warning.
    pub require_homed: bool,
}

impl Default for Guards {
    fn default() -> Self {
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

/// Refuses in the name of a guard, if it is on.
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
