//! Detection of an arm at rest from the poses read.
//!
//! The protocol has no query for motion that works during jogs and after stops, so equal poses must
//! serve. Two equal poses are not enough: a moving arm reports one pose for a whole control period,
//! and an arm that reverses passes each position twice.

use magician_motion::MotionLaw;
use magician_protocol::commands::Pose;

use crate::connection::Micros;

/// Shortest time between two poses that count, us: a period, during which a moving arm reports one
/// pose, plus a few milliseconds of jitter of host and line.
pub const REST_READ_INTERVAL: Micros = PERIOD + 5_000;
/// Shortest time over which the poses of an arm at rest are equal, us: two periods. A speed that
/// passes through zero shows one pose for less.
pub const REST_TIME: Micros = 2 * PERIOD;
/// Number of equal poses required.
// An arm that reverses passes each position twice, at equal times before and after the reversal,
// and never a third time.
const EQUAL_READS: u8 = 3;
const PERIOD: Micros = MotionLaw::MAGICIAN.period_us() as Micros;

/// Detects from poses whether an arm is at rest: three equal ones over at least two periods of 20
/// ms.
///
/// ```
/// use magician_host::RestDetector;
/// use magician_host::protocol::Layout;
/// use magician_host::commands::Pose;
///
/// let pose = Pose::decode(&[0; 32])?;
/// let mut rest = RestDetector::default();
/// assert!(!rest.see(0, pose) && !rest.see(25_000, pose));
/// assert!(rest.see(50_000, pose));
/// # Ok::<(), magician_host::protocol::DecodeError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RestDetector {
    seen: Option<Seen>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Seen {
    pose: Pose,
    since: Micros,
    /// Instant of the last pose that counts, and the number of such poses.
    last: Micros,
    reads: u8,
}

impl RestDetector {
    /// Processes a pose read at `now`, us. True if the arm is at rest.
    pub fn see(&mut self, now: Micros, pose: Pose) -> bool {
        match &mut self.seen {
            Some(seen) if seen.pose == pose => {
                if now.saturating_sub(seen.last) >= REST_READ_INTERVAL {
                    seen.last = now;
                    seen.reads = seen.reads.saturating_add(1);
                }
            }
            seen => {
                *seen = Some(Seen {
                    pose,
                    since: now,
                    last: now,
                    reads: 1,
                });
            }
        }
        self.is_at_rest()
    }

    /// True if the last poses were those of an arm at rest.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.seen.is_some_and(|seen| {
            seen.reads >= EQUAL_READS && seen.last.saturating_sub(seen.since) >= REST_TIME
        })
    }

    /// Instant from which the next pose counts, us. `None` before the first pose.
    #[must_use]
    pub fn next_read(&self) -> Option<Micros> {
        self.seen
            .map(|seen| seen.last.saturating_add(REST_READ_INTERVAL))
    }

    /// Discards the poses, because something may move the arm.
    pub fn forget(&mut self) {
        self.seen = None;
    }
}

#[cfg(test)]
mod tests {
    use magician_protocol::Layout;

    use super::*;

    fn at(x: f32) -> Pose {
        Pose {
            x,
            ..Pose::decode(&[0; 32]).unwrap()
        }
    }

    /// Positions of an axis that reverses: the speed falls by one step per period of 20 ms, and is
    /// zero for one period only if `passes_zero`.
    fn turning(now: Micros, passes_zero: bool) -> f32 {
        let period = (now / PERIOD) as i32;
        let half = if passes_zero { 0 } else { 1 };
        (0..period)
            .map(|nth| (20 * (10 - nth) - 10 * half) as f32 * 0.001)
            .sum()
    }

    #[test]
    fn a_speed_that_passes_through_zero_is_never_rest() {
        for passes_zero in [true, false] {
            for interval in (1_000..=120_000).step_by(1_000) {
                for begin in (0..20_000).step_by(2_000) {
                    let mut rest = RestDetector::default();
                    let mut now = begin;
                    while now < 420_000 {
                        let pose = at(turning(now, passes_zero));
                        assert!(
                            !rest.see(now, pose),
                            "{passes_zero} {interval} {begin} {now}"
                        );
                        now += interval;
                    }
                }
            }
        }
    }

    #[test]
    fn an_arm_that_stands_is_at_rest_after_the_third_pose() {
        for (interval, reads) in [(20_000, 5), (25_000, 3), (50_000, 3), (500_000, 3)] {
            let mut rest = RestDetector::default();
            let mut count = 1;
            while !rest.see(count * interval, at(1.0)) {
                count += 1;
            }
            assert_eq!(count, reads, "{interval}");
            rest.forget();
            assert!(!rest.is_at_rest());
        }
    }

    #[test]
    fn fifty_readings_a_second_of_a_moving_arm_are_never_rest() {
        let mut rest = RestDetector::default();
        for nth in 0..500_u64 {
            // Read every 20 ms, now and then late.
            let now = nth * 20_000 + [0, 3_000, 9_000, 1_000][nth as usize % 4];
            let periods = now / PERIOD;
            assert!(!rest.see(now, at(periods as f32 * 0.1)));
        }
    }
}
