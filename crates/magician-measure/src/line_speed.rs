//! Effective speed of a line, from two kinds of round trips.

use std::time::Duration;

use magician_protocol::BAUD_RATE;

use crate::{Exchange, Timed};

/// Effective speed of a line, computed from two round trips of different length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineSpeed {
    /// Bits per second at 8N1; `None` if the time of bytes is within the noise: a pseudo-terminal
    /// without pacing, a network.
    pub baud: Option<f64>,
    /// Round trip minus wire time at 115200 baud, or the whole round trip if bytes take no time.
    pub turnaround: Duration,
    /// 99th percentile of the round trip minus its median.
    pub jitter: Duration,
}

/// Smallest ratio of the longer round trip to the wire time of its bytes on a line with a baud
/// rate. Choice: leaves room for errors of the clocks.
const MIN_WIRE_TIME_RATIO: f64 = 0.9;
/// Percentile of undisturbed round trips. Choice.
const QUIET: u8 = 10;

impl LineSpeed {
    /// Computes the speed from round trips of the pose and of the current index; `None` without
    /// any.
    #[must_use]
    pub fn of(pose: &Timed, index: &Timed) -> Option<Self> {
        // Other load of the computer makes round trips longer, never shorter.
        let (long, short) = (
            pose.times.percentile(QUIET)?,
            index.times.percentile(QUIET)?,
        );
        let bits = |exchange: Exchange| f64::from(10 * (exchange.request + exchange.reply));
        let difference_s = long.saturating_sub(short).as_secs_f64();
        let baud = (bits(Exchange::POSE) - bits(Exchange::CURRENT_INDEX)) / difference_s;
        let wire = Exchange::POSE.wire_time(BAUD_RATE);
        // Above 4 Mbaud the difference is noise: no serial adapter of arms is faster.
        let paced = difference_s > 0.0
            && long.as_secs_f64() >= MIN_WIRE_TIME_RATIO * wire.as_secs_f64()
            && baud <= 4e6;
        let typical = pose.times.p50()?;
        Some(Self {
            baud: paced.then_some(baud),
            turnaround: if paced {
                typical.saturating_sub(wire)
            } else {
                typical
            },
            jitter: pose.times.p99()?.saturating_sub(typical),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Timings;

    fn timed(micros: u64) -> Timed {
        Timed {
            times: Timings::from(vec![Duration::from_micros(micros); 9]),
            ..Timed::default()
        }
    }

    #[test]
    fn a_line_shows_its_speed_and_a_network_none() {
        let line = LineSpeed::of(&timed(3_819 + 2_000), &timed(1_736 + 2_000)).unwrap();
        let baud = line.baud.unwrap();
        assert!((baud / 115_200.0 - 1.0).abs() < 1e-3, "{baud}");
        assert!(line.turnaround.abs_diff(Duration::from_micros(2_000)) < Duration::from_micros(2));
        let network = LineSpeed::of(&timed(300), &timed(290)).unwrap();
        assert_eq!(network.baud, None);
        assert_eq!(network.turnaround, Duration::from_micros(300));
        assert_eq!(LineSpeed::of(&Timed::default(), &timed(1)), None);
    }
}
