//! Computed rates of a serial line, from the bytes of requests and replies.

use std::time::Duration;

use magician_protocol::BAUD_RATE;

/// Bits on a serial line per byte at 8N1 (document 1.1).
const BITS_PER_BYTE: f64 = 10.0;

/// Request and reply, by their number of bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Exchange {
    /// Bytes of the request.
    pub request: u32,
    /// Bytes of the reply.
    pub reply: u32,
}

/// Returns the seconds a byte takes.
fn byte_time(baud: u32) -> f64 {
    // At least 1, so that a rate of 0 gives a long time and no division by zero.
    BITS_PER_BYTE / f64::from(baud.max(1))
}

impl Exchange {
    /// Pose: eight floats.
    pub const POSE: Self = Self::new(6, 38);
    /// Index of the last finished command.
    pub const CURRENT_INDEX: Self = Self::new(6, 14);
    /// Free places in the queue.
    pub const LEFT_SPACE: Self = Self::new(6, 10);
    /// Queued continuous-path segment.
    pub const SEGMENT: Self = Self::new(23, 14);

    const fn new(request: u32, reply: u32) -> Self {
        Self { request, reply }
    }

    /// Returns the time of its bytes at a baud rate, 8N1.
    #[must_use]
    pub fn wire_time(self, baud: u32) -> Duration {
        Duration::from_secs_f64(f64::from(self.request + self.reply) * byte_time(baud))
    }

    /// Returns the time of the request's bytes on the arm's line.
    #[must_use]
    pub fn request_time(self) -> Duration {
        Self { reply: 0, ..self }.wire_time(BAUD_RATE)
    }

    /// Returns the exchanges per second if each waits for the one before. `turnaround` is
    /// everything but wire time.
    #[must_use]
    pub fn stop_and_wait(self, turnaround: Duration) -> f64 {
        1.0 / (self.wire_time(BAUD_RATE) + turnaround).as_secs_f64()
    }

    /// Returns the exchanges per second that the busier direction of the line allows.
    #[must_use]
    pub fn pipelined(self) -> f64 {
        1.0 / (f64::from(self.request.max(self.reply)) * byte_time(BAUD_RATE))
    }
}

/// Stream of segments with polls in between: pose, current index and left space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mixed {
    /// Rounds of polls per second.
    pub rounds: f64,
}

impl Mixed {
    const ROUND: [Exchange; 3] = [
        Exchange::POSE,
        Exchange::CURRENT_INDEX,
        Exchange::LEFT_SPACE,
    ];

    /// Returns the segments per second if every exchange waits for the one before.
    #[must_use]
    pub fn stop_and_wait(self, turnaround: Duration) -> f64 {
        let round: Duration = Self::ROUND
            .iter()
            .map(|exchange| exchange.wire_time(BAUD_RATE) + turnaround)
            .sum();
        let free = 1.0 - self.rounds * round.as_secs_f64();
        // Polls alone may need more than the whole line.
        free.max(0.0) * Exchange::SEGMENT.stop_and_wait(turnaround)
    }

    /// Returns the segments per second that the busier direction of the line allows.
    #[must_use]
    pub fn pipelined(self) -> f64 {
        let sum = |bytes: fn(&Exchange) -> u32| Self::ROUND.iter().map(bytes).sum::<u32>();
        let free = |bytes: u32, own: u32| {
            let free = 1.0 / byte_time(BAUD_RATE) - self.rounds * f64::from(bytes);
            free.max(0.0) / f64::from(own)
        };
        let there = free(sum(|one| one.request), Exchange::SEGMENT.request);
        there.min(free(sum(|one| one.reply), Exchange::SEGMENT.reply))
    }
}

#[cfg(test)]
mod tests {
    use magician_protocol::commands::{CpCmd, Pose, QueuedCmdCurrentIndex, QueuedCmdLeftSpace};
    use magician_protocol::{FrameBuf, Layout, LayoutInfo, NoArgs, QueuedCmdIndex, Readable};

    use super::*;

    const TURNAROUNDS: [u64; 3] = [0, 2, 4];

    fn rounded(rate: impl Fn(Duration) -> f64) -> [f64; 3] {
        TURNAROUNDS.map(|milliseconds| rate(Duration::from_millis(milliseconds)).round())
    }

    #[test]
    fn the_rates_are_those_of_the_frame_sizes() {
        let rates = |exchange: Exchange| rounded(|turnaround| exchange.stop_and_wait(turnaround));
        assert_eq!(rates(Exchange::POSE), [262.0, 172.0, 128.0]);
        assert_eq!(rates(Exchange::SEGMENT), [311.0, 192.0, 139.0]);
        assert_eq!(rates(Exchange::CURRENT_INDEX), [576.0, 268.0, 174.0]);
        let mixed = Mixed { rounds: 20.0 };
        assert_eq!(
            rounded(|turnaround| mixed.stop_and_wait(turnaround)),
            [268.0, 142.0, 86.0]
        );
        let bounds = [
            Exchange::POSE.pipelined(),
            Exchange::SEGMENT.pipelined(),
            Exchange::CURRENT_INDEX.pipelined(),
            mixed.pipelined(),
        ];
        assert_eq!(bounds.map(f64::round), [303.0, 501.0, 823.0, 485.0]);
    }

    #[test]
    fn the_bytes_are_those_of_the_table() {
        let empty = FrameBuf::get(&NoArgs, Pose::ROW).unwrap().bytes().len();
        let bytes = |of: &LayoutInfo| empty + of.size().unwrap();
        let sizes = |exchange: Exchange| (exchange.request as usize, exchange.reply as usize);
        let index = bytes(QueuedCmdIndex::INFO);
        assert_eq!(sizes(Exchange::POSE), (empty, bytes(Pose::INFO)));
        assert_eq!(
            sizes(Exchange::CURRENT_INDEX),
            (empty, bytes(QueuedCmdCurrentIndex::INFO))
        );
        assert_eq!(
            sizes(Exchange::LEFT_SPACE),
            (empty, bytes(QueuedCmdLeftSpace::INFO))
        );
        assert_eq!(sizes(Exchange::SEGMENT), (bytes(CpCmd::INFO), index));
    }
}
