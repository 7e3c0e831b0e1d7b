use std::time::Duration;

use magician_protocol::BAUD_RATE;

use crate::{Exchange, Timed};

/// How fast the bytes of a line really are: found from two round trips of different length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineSpeed {
    /// Bits a second at 8N1; `None` when bytes take no time that can be told from chance: a pseudo-terminal without
    /// pacing, a network.
    pub baud: Option<f64>,
    /// All of a round trip that is not wire time at 115200 baud, or the whole round trip when bytes take no time.
    pub turnaround: Duration,
    /// How much one answer in a hundred is later than the middle one.
    pub jitter: Duration,
}

/// The shorter round trip may be this much of what its bytes alone take, and still be of a line with a speed.
const LEAST: f64 = 0.9;
/// The percentile of undisturbed round trips.
const QUIET: u8 = 10;

impl LineSpeed {
    /// From round trips of the pose and of the current index.
    #[must_use]
    pub fn of(pose: &Timed, index: &Timed) -> Option<Self> {
        // What else the computer does makes round trips longer, never shorter.
        let (long, short) = (
            pose.times.percentile(QUIET)?,
            index.times.percentile(QUIET)?,
        );
        let bits = |exchange: Exchange| f64::from(10 * (exchange.request + exchange.reply));
        let more = long.saturating_sub(short).as_secs_f64();
        let baud = (bits(Exchange::POSE) - bits(Exchange::CURRENT_INDEX)) / more;
        let wire = Exchange::POSE.wire_time(BAUD_RATE);
        let paced = more > 0.0 && long.as_secs_f64() >= LEAST * wire.as_secs_f64() && baud <= 4e6;
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
    use crate::Spread;

    fn timed(micros: u64) -> Timed {
        Timed {
            times: Spread::from(vec![Duration::from_micros(micros); 9]),
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
