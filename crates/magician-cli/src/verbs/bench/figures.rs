//! Measured figures of `bench`, their goals, and their JSON form.

use std::time::Duration;

use magician::Target;
use magician_measure::{Exchange, LineSpeed, Mixed, Stops, StreamResult};
use serde::Serialize;

/// Polls of the arm a second beside a stream.
pub(super) const POLL_RATE: f64 = 20.0;
/// Goal: share of the computed rates (h1).
const RATE_SHARE_GOAL: f64 = 0.95;
/// Goal: segments a second with polls at a window of 4 (h2).
const FULL_LINE_GOAL: f64 = 460.0;
const FULL_LINE_WINDOW: usize = 4;
/// Segments a second of the two streams of h3 and h5. Below the share `MIN_RATE_SHARE` of it the
/// line or the arm was the limit, so the measurement proves nothing about the driver.
const DENSE_RATE: f64 = 450.0;
const FAST_RATE: f64 = 200.0;
const MIN_RATE_SHARE: f64 = 0.97;
/// Goal: share of a core, % (h5).
const CORE_PERCENT_GOAL: f64 = 2.0;
/// Goal: longest delay of a stop beyond the line's own time, which is the frame being sent and the
/// longest frame of this host (h4).
const STOP_MARGIN: Duration = Duration::from_millis(1);
/// Goal: latency added by the driver, µs at p50 and p99 (h7).
#[cfg(unix)]
const ADDED_LATENCY_GOAL_US: [f64; 2] = [50.0, 200.0];

/// Measured rate beside the computed one.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct RateComparison {
    pub(super) per_s: f64,
    /// `None` if the line has no speed to compute with (not a serial line).
    pub(super) computed_per_s: Option<f64>,
    pub(super) ratio: Option<f64>,
}

/// h1: rates compared with the computed stop-and-wait rates.
#[derive(Debug, Default, Serialize)]
pub(super) struct H1 {
    pub(super) get_pose: Option<RateComparison>,
    pub(super) current_index: Option<RateComparison>,
    pub(super) enqueue: Option<RateComparison>,
    pub(super) enqueue_polled: Option<RateComparison>,
    pub(super) goal: f64,
    pub(super) unit: &'static str,
    pub(super) met: Option<bool>,
}

/// h2: throughput of a full line.
#[derive(Debug, Serialize)]
pub(super) struct H2 {
    pub(super) enqueue_polled_per_s: f64,
    pub(super) bound_per_s: f64,
    /// True if the indices of all commands are consecutive.
    pub(super) in_a_row: bool,
    pub(super) goal: f64,
    pub(super) unit: &'static str,
    pub(super) met: bool,
}

/// Stream during which the host pauses at intervals.
#[derive(Debug, Serialize)]
pub(super) struct Starvation {
    pub(super) segments_per_s: f64,
    pub(super) fewest_queued: Option<u32>,
    pub(super) dry_looks: u64,
    pub(super) looks: u64,
}

/// h3: whether the queue runs dry.
#[derive(Debug, Serialize)]
pub(super) struct H3 {
    pub(super) dense: Starvation,
    pub(super) fast: Starvation,
    pub(super) goal: u64,
    pub(super) unit: &'static str,
    /// `None` if the arm was the limit.
    pub(super) met: Option<bool>,
}

/// h4: delay until a stop is on the line.
#[derive(Debug, Serialize)]
pub(super) struct H4 {
    pub(super) stops: usize,
    pub(super) on_the_line_p50_ms: Option<f64>,
    pub(super) on_the_line_p99_ms: Option<f64>,
    pub(super) answered_p50_ms: Option<f64>,
    pub(super) answered_p99_ms: Option<f64>,
    pub(super) goal: f64,
    pub(super) unit: &'static str,
    pub(super) met: Option<bool>,
}

/// h5: processor time.
#[derive(Debug, Serialize)]
pub(super) struct H5 {
    pub(super) segments_per_s: f64,
    pub(super) core_percent: Option<f64>,
    pub(super) goal: f64,
    pub(super) unit: &'static str,
    /// `None` if the line could not carry the segments.
    pub(super) met: Option<bool>,
}

/// h7: latency that the driver adds to a round trip.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct AddedFigures {
    pub(super) bare_p50_us: Option<f64>,
    pub(super) bare_p99_us: Option<f64>,
    pub(super) added_p50_us: f64,
    pub(super) added_p99_us: f64,
    pub(super) goal_p50: f64,
    pub(super) goal_p99: f64,
    pub(super) unit: &'static str,
    pub(super) met: bool,
}

/// All figures of a run.
#[derive(Debug, Serialize)]
pub(super) struct Figures {
    pub(super) port: String,
    pub(super) window: usize,
    pub(super) seconds: f64,
    pub(super) line_baud: Option<f64>,
    /// Measured turnaround.
    pub(super) turnaround_ms: Option<f64>,
    pub(super) jitter_ms: Option<f64>,
    /// Turnaround that the computed rates assume.
    pub(super) computed_for_ms: Option<f64>,
    pub(super) get_pose_per_s: Option<f64>,
    pub(super) current_index_per_s: Option<f64>,
    pub(super) enqueue_per_s: Option<f64>,
    pub(super) enqueue_polled_per_s: Option<f64>,
    pub(super) h1: Option<H1>,
    pub(super) h2: Option<H2>,
    pub(super) h3: Option<H3>,
    pub(super) h4: Option<H4>,
    pub(super) h5: Option<H5>,
    /// Comparison with other libraries: measured by `interop/bench_pydobot.py`.
    pub(super) h6: Option<()>,
    pub(super) h7: Option<AddedFigures>,
    /// True if the arm was allowed to draw.
    #[serde(skip)]
    pub(super) drawn: bool,
    #[serde(skip)]
    turnaround: Option<Duration>,
}

/// True if the stream never ran dry at its full rate; `None` if the arm was the limit.
fn fed(seen: &StreamResult, rate: f64) -> Option<bool> {
    let kept_full = seen.fewest? >= seen.capacity / 2;
    match (seen.dry, seen.rate.per_second() >= MIN_RATE_SHARE * rate) {
        (0, true) => Some(true),
        (0, false) if kept_full => None,
        _ => Some(false),
    }
}

/// Rounds to this many decimals.
fn rounded(value: f64, digits: i32) -> f64 {
    let scale = 10_f64.powi(digits);
    (value * scale).round() / scale
}

pub(super) fn milliseconds(time: Duration) -> f64 {
    rounded(time.as_secs_f64() * 1e3, 3)
}

#[cfg(unix)]
fn microseconds(time: Duration) -> f64 {
    rounded(time.as_secs_f64() * 1e6, 1)
}

impl Figures {
    pub(super) fn new(target: &Target, window: usize, seconds: Duration) -> Self {
        Self {
            port: target.to_string(),
            window,
            seconds: seconds.as_secs_f64(),
            line_baud: None,
            turnaround_ms: None,
            jitter_ms: None,
            computed_for_ms: None,
            get_pose_per_s: None,
            current_index_per_s: None,
            enqueue_per_s: None,
            enqueue_polled_per_s: None,
            h1: None,
            h2: None,
            h3: None,
            h4: None,
            h5: None,
            h6: None,
            h7: None,
            drawn: false,
            turnaround: None,
        }
    }

    /// True if the line has a speed, so that bytes take time.
    pub(super) fn paced(&self) -> bool {
        self.line_baud.is_some()
    }

    pub(super) fn set_drawing_allowed(&mut self, drawn: bool) {
        self.drawn = drawn;
    }

    /// Records the measured line, and a turnaround known otherwise, which takes precedence.
    pub(super) fn line(&mut self, line: LineSpeed, known: Option<Duration>) {
        self.line_baud = line.baud.map(f64::round);
        self.turnaround_ms = Some(milliseconds(line.turnaround));
        self.jitter_ms = Some(milliseconds(line.jitter));
        // Without a line speed there are no computed rates.
        self.turnaround = line.baud.map(|_| known.unwrap_or(line.turnaround));
        self.computed_for_ms = self.turnaround.map(milliseconds);
    }

    fn compare(
        &self,
        per_s: f64,
        computed: impl FnOnce(Duration) -> f64,
    ) -> Option<RateComparison> {
        let computed = self.turnaround.map(computed);
        let ratio = computed.filter(|computed| *computed > 0.0);
        Some(RateComparison {
            per_s: rounded(per_s, 1),
            computed_per_s: computed.map(|rate| rounded(rate, 1)),
            ratio: ratio.map(|computed| rounded(per_s / computed, 3)),
        })
    }

    fn h1(&mut self) -> &mut H1 {
        self.h1.get_or_insert_with(|| H1 {
            goal: RATE_SHARE_GOAL,
            unit: "share of the computed rate",
            ..H1::default()
        })
    }

    fn judge_h1(&mut self) {
        let h1 = self.h1();
        let all = [h1.get_pose, h1.current_index, h1.enqueue, h1.enqueue_polled];
        let mut ratios = all.iter().flatten().map(|one| one.ratio);
        h1.met = ratios.try_fold(true, |met, ratio| Some(met && ratio? >= RATE_SHARE_GOAL));
    }

    pub(super) fn reads(&mut self, poses: f64, indices: f64) {
        self.get_pose_per_s = Some(rounded(poses, 1));
        self.current_index_per_s = Some(rounded(indices, 1));
        self.h1().get_pose = self.compare(poses, |time| Exchange::POSE.stop_and_wait(time));
        self.h1().current_index =
            self.compare(indices, |time| Exchange::CURRENT_INDEX.stop_and_wait(time));
        self.judge_h1();
    }

    pub(super) fn segments(&mut self, seen: &StreamResult) {
        let rate = seen.rate.per_second();
        self.enqueue_per_s = Some(rounded(rate, 1));
        self.h1().enqueue = self.compare(rate, |time| Exchange::SEGMENT.stop_and_wait(time));
        self.judge_h1();
    }

    pub(super) fn polled_segments(&mut self, seen: &StreamResult) {
        let (rate, mixed) = (seen.rate.per_second(), Mixed { rounds: POLL_RATE });
        self.enqueue_polled_per_s = Some(rounded(rate, 1));
        self.h1().enqueue_polled = self.compare(rate, |time| mixed.stop_and_wait(time));
        self.judge_h1();
        self.h2 = (self.window >= FULL_LINE_WINDOW).then(|| H2 {
            enqueue_polled_per_s: rounded(rate, 1),
            bound_per_s: rounded(mixed.pipelined(), 1),
            in_a_row: seen.in_a_row,
            goal: FULL_LINE_GOAL,
            unit: "1/s",
            met: rate >= FULL_LINE_GOAL && seen.in_a_row,
        });
    }

    pub(super) fn starvation(&mut self, dense: &StreamResult, fast: &StreamResult) {
        let of = |seen: &StreamResult| Starvation {
            segments_per_s: rounded(seen.rate.per_second(), 1),
            fewest_queued: seen.fewest,
            dry_looks: seen.dry,
            looks: seen.looks,
        };
        self.h3 = Some(H3 {
            dense: of(dense),
            fast: of(fast),
            goal: 0,
            unit: "looks at a dry queue",
            met: fed(dense, DENSE_RATE).and_then(|met| Some(met && fed(fast, FAST_RATE)?)),
        });
    }

    pub(super) fn stops(&mut self, seen: &Stops) {
        let goal = milliseconds(Exchange::SEGMENT.request_time() + STOP_MARGIN);
        let late = seen.on_the_line.p99().map(milliseconds);
        self.h4 = Some(H4 {
            stops: seen.on_the_line.count(),
            on_the_line_p50_ms: seen.on_the_line.p50().map(milliseconds),
            on_the_line_p99_ms: late,
            answered_p50_ms: seen.answered.p50().map(milliseconds),
            answered_p99_ms: seen.answered.p99().map(milliseconds),
            goal,
            unit: "ms to the line, p99",
            met: late.map(|late| late <= goal),
        });
    }

    pub(super) fn processor(&mut self, seen: &StreamResult) {
        let rate = seen.rate.per_second();
        let share = |used: Duration| 100.0 * used.as_secs_f64() / seen.took.as_secs_f64();
        let percent = seen.processor.map(|used| rounded(share(used), 2));
        let carried = rate >= MIN_RATE_SHARE * DENSE_RATE;
        self.h5 = Some(H5 {
            segments_per_s: rounded(rate, 1),
            core_percent: percent,
            goal: CORE_PERCENT_GOAL,
            unit: "percent of a core",
            met: percent
                .filter(|_| carried)
                .map(|percent| percent <= CORE_PERCENT_GOAL),
        });
    }

    pub(super) fn set_driver_latency(&mut self, added: &Option<AddedFigures>) {
        self.h7 = *added;
    }
}

#[cfg(unix)]
impl AddedFigures {
    pub(super) fn new(added: &magician_measure::AddedLatency, at: (Duration, Duration)) -> Self {
        let [p50, p99] = [at.0, at.1].map(microseconds);
        let [goal_p50, goal_p99] = ADDED_LATENCY_GOAL_US;
        Self {
            bare_p50_us: added.bare.p50().map(microseconds),
            bare_p99_us: added.bare.p99().map(microseconds),
            added_p50_us: p50,
            added_p99_us: p99,
            goal_p50,
            goal_p99,
            unit: "us",
            met: p50 <= goal_p50 && p99 <= goal_p99,
        }
    }
}
