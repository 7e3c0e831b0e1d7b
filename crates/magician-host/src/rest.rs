//! Rest of an arm, told by the poses that were read.

use magician_motion::MotionLaw;
use magician_protocol::commands::Pose;

use crate::connection::Micros;

/// Shortest time between two poses that count: the pose of a moving arm stands for a period, and a host's clock and line are
/// off by a few milliseconds.
pub const REST_READ_INTERVAL: Micros = PERIOD + 5_000;
/// Shortest time over which the poses of an arm at rest are equal: two periods. A speed that passes through zero shows one pose
/// for less than that.
pub const REST_TIME: Micros = 2 * PERIOD;
/// Poses that have to be equal. An arm that turns round passes each place twice, at equal times before and after its turn; it
/// shows no pose a third time.
const EQUAL_READS: u8 = 3;
const PERIOD: Micros = MotionLaw::MAGICIAN.period_us() as Micros;

/// Tells from poses whether an arm is at rest: three equal ones, over two periods of 20 ms at least.
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
    /// When the last pose that counts was read, and how many have been.
    last: Micros,
    reads: u8,
}

impl RestDetector {
    /// Takes a pose that was read at `now`, us. True if the arm is at rest.
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

    /// When the next pose counts, us; `None` if none was seen.
    #[must_use]
    pub fn next_read(&self) -> Option<Micros> {
        self.seen
            .map(|seen| seen.last.saturating_add(REST_READ_INTERVAL))
    }

    /// Forgets the poses: something may move the arm.
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

    /// Places of an axis that turns round: the speed falls by a step in each period of 20 ms, through zero or past it.
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
