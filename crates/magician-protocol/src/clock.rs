//! The two clocks, each with instants of its own type, so that the one cannot be passed for the other.
//!
//! * **The host's**, [`HostInstant`]: what timeouts, deadlines, a line's bytes and silences, and the dead man of a jog count
//!   in. A shell reads it off the wall, a test lets it pass; its origin is theirs to choose. (`magician-host` counts it in
//!   plain microseconds, which are no instant of the arm's clock either.)
//! * **The arm's**, [`ArmInstant`]: what motion, WAIT, DeviceTime and estimates count in, from power-up on. A virtual arm's
//!   may run faster or slower than the host's, or stand.
//! * A span is a [`Duration`], whichever clock it was taken from: an instant and a span make an instant of the same clock,
//!   two instants of one clock a span, and two of different clocks nothing at all.
//! * Both count whole microseconds in integers, so that sums do not depend on how time is cut; what a span has beyond is
//!   dropped. Nothing overflows: sums stop at the first and the last instant there is.
//! * One clock becomes the other where a speed or a leap says how, and nowhere else: `ArmClock` and `Runner` of
//!   `magician-sim` (the speed of a virtual arm), `Pair` of `magician-host` (both are one), its stream (`stream/clock.rs`: who leads).

use core::ops::{Add, AddAssign, Sub};
use core::time::Duration;

macro_rules! instant {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(u64);

        impl $name {
            /// The first instant.
            pub const ZERO: Self = Self(0);
            /// The last instant, which never comes.
            pub const MAX: Self = Self(u64::MAX);

            /// So many microseconds after the first.
            #[must_use]
            pub const fn from_micros(micros: u64) -> Self {
                Self(micros)
            }

            /// Microseconds since the first.
            #[must_use]
            pub const fn as_micros(self) -> u64 {
                self.0
            }

            /// So many microseconds later.
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

            /// The span since an earlier instant; none if that is later.
            fn sub(self, earlier: Self) -> Duration {
                Duration::from_micros(self.micros_since(earlier))
            }
        }
    };
}

instant! {
    /// An instant of the arm's clock: microseconds since it was switched on or, in a virtual one, since it was made.
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
    /// It is no instant of the host's clock:
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

/// The whole microseconds of a span, up to the last that there is.
fn whole_micros(span: Duration) -> u64 {
    u64::try_from(span.as_micros()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_stop_at_the_ends_and_drop_what_is_below_a_microsecond() {
        let late = ArmInstant::MAX + Duration::MAX;
        assert_eq!(late, ArmInstant::MAX);
        assert_eq!(ArmInstant::ZERO - Duration::from_secs(1), ArmInstant::ZERO);
        let one = HostInstant::ZERO + Duration::from_nanos(1_999);
        assert_eq!(one.as_micros(), 1);
        assert_eq!(HostInstant::ZERO.micros_since(one), 0);
    }
}
