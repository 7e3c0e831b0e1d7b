//! Instants of the two clocks, as types that cannot be confused.
//!
//! * [`HostInstant`] is the host's clock: timeouts, deadlines, bytes and silences on a line, the
//!   hold time of a jog. Applications read it from the wall clock and tests advance it by hand; its
//!   origin is theirs to choose. (`magician-host` uses plain microseconds internally, which are not
//!   arm time either.)
//! * [`ArmInstant`] is the arm's clock since power-up: motion, WAIT, DeviceTime and estimates. The
//!   clock of a virtual arm may run faster or slower than the host's, or stand still.
//! * A span of either clock is a [`Duration`]. Instant plus span is an instant of the same clock;
//!   the difference of two instants of one clock is a span; mixing clocks does not compile.
//! * Both count whole microseconds in integers, so results do not depend on how time is cut.
//!   Fractions of a microsecond in a span are dropped. Arithmetic saturates at the first and last
//!   instant.
//! * Conversions between the clocks exist only where a speed or a jump defines one: `ArmClock` and
//!   `Runner` of `magician-sim` (speed of a virtual arm), `Pair` of `magician-host` (both clocks
//!   are one) and its stream (`stream/clock.rs`: which clock leads).

use core::ops::{Add, AddAssign, Sub};
use core::time::Duration;

macro_rules! instant {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(u64);

        impl $name {
            /// Origin of the clock.
            pub const ZERO: Self = Self(0);
            /// Latest representable instant; as a deadline, never.
            pub const MAX: Self = Self(u64::MAX);

            /// Creates an instant `micros` microseconds after [`ZERO`](Self::ZERO).
            #[must_use]
            pub const fn from_micros(micros: u64) -> Self {
                Self(micros)
            }

            /// Microseconds since [`ZERO`](Self::ZERO).
            #[must_use]
            pub const fn as_micros(self) -> u64 {
                self.0
            }

            /// Returns the instant `micros` microseconds later, saturating.
            #[must_use]
            pub const fn after_micros(self, micros: u64) -> Self {
                Self(self.0.saturating_add(micros))
            }

            /// Microseconds since an earlier instant; 0 if that is later.
            #[must_use]
            pub const fn micros_since(self, earlier: Self) -> u64 {
                self.0.saturating_sub(earlier.0)
            }
        }

        impl Add<Duration> for $name {
            type Output = Self;

            fn add(self, span: Duration) -> Self {
                self.after_micros(whole_micros(span))
            }
        }

        impl AddAssign<Duration> for $name {
            fn add_assign(&mut self, span: Duration) {
                *self = *self + span;
            }
        }

        impl Sub<Duration> for $name {
            type Output = Self;

            fn sub(self, span: Duration) -> Self {
                Self(self.0.saturating_sub(whole_micros(span)))
            }
        }

        impl Sub for $name {
            type Output = Duration;

            /// Span since an earlier instant; zero if `earlier` is later.
            fn sub(self, earlier: Self) -> Duration {
                Duration::from_micros(self.micros_since(earlier))
            }
        }
    };
}

instant! {
    /// An instant of the arm's clock: microseconds since power-up or, for a virtual arm, since it
    /// was created.
    ///
    /// ```
    /// use core::time::Duration;
    /// use magician_protocol::ArmInstant;
    ///
    /// let begun = ArmInstant::from_micros(1_500_000);
    /// let ended = begun + Duration::from_millis(20);
    /// assert_eq!(ended.as_micros(), 1_520_000);
    /// assert_eq!(ended - begun, Duration::from_millis(20));
    /// assert_eq!(begun - ended, Duration::ZERO);
    /// ```
    ///
    /// The host's clock has a separate type:
    ///
    /// ```compile_fail
    /// # use magician_protocol::{ArmInstant, HostInstant};
    /// let deadline: HostInstant = ArmInstant::ZERO;
    /// ```
    ArmInstant
}

instant! {
    /// An instant of the host's clock: microseconds since an origin of the caller's choice.
    HostInstant
}

/// Whole microseconds of a span, saturating.
fn whole_micros(span: Duration) -> u64 {
    u64::try_from(span.as_micros()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arithmetic_saturates_and_drops_nanoseconds() {
        let late = ArmInstant::MAX + Duration::MAX;
        assert_eq!(late, ArmInstant::MAX);
        assert_eq!(ArmInstant::ZERO - Duration::from_secs(1), ArmInstant::ZERO);
        let one = HostInstant::ZERO + Duration::from_nanos(1_999);
        assert_eq!(one.as_micros(), 1);
        assert_eq!(HostInstant::ZERO.micros_since(one), 0);
    }
}
