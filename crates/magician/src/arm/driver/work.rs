//! Test of the work per path segment, counted instead of timed.

use std::io;
use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::task::{Context, Poll};
use std::time::Duration;

use magician_protocol::Set;

use crate::connection::Settings;
use crate::transport::{Leap, LeapTo, Line, Sim, Transport};
use crate::{Arm, Options, VirtualArm, build};

/// Line to a virtual arm that counts its calls.
struct Counted {
    sim: Sim,
    counts: Arc<Counts>,
}

#[derive(Default)]
struct Counts {
    reads: AtomicU64,
    writes: AtomicU64,
    leaps: AtomicU64,
}

fn more(count: &AtomicU64) {
    count.fetch_add(1, Ordering::Relaxed);
}

impl Transport for Counted {
    fn poll_read(&mut self, cx: &mut Context<'_>, bytes: &mut [u8]) -> Poll<io::Result<usize>> {
        more(&self.counts.reads);
        self.sim.poll_read(cx, bytes)
    }

    fn poll_write(&mut self, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        more(&self.counts.writes);
        self.sim.poll_write(cx, bytes)
    }

    fn lead(&mut self, leads: bool) -> bool {
        self.sim.lead(leads)
    }

    fn leap(&mut self, most: Duration, to: LeapTo) -> Option<Leap> {
        more(&self.counts.leaps);
        self.sim.leap(most, to)
    }
}

/// Calls per segment, and wake-ups of the caller of the run.
#[derive(Debug)]
struct Work {
    reads: f64,
    writes: f64,
    leaps: f64,
    wakes: f64,
}

async fn work(window: usize, segments: u16) -> Work {
    let counts = Arc::new(Counts::default());
    let line = Line {
        transport: Box::new(Counted {
            sim: Sim::new(VirtualArm::default()),
            counts: Arc::clone(&counts),
        }),
        settings: Settings {
            free_clock: true,
            ..Settings::ORDERED
        },
        name: "a line that counts".to_owned(),
        tried: "a line that counts",
        in_process: true,
        arm: None,
        is_shared: false,
    };
    let options = Options::default().window(window);
    let arm = Arm::greet(line, None, options).await.unwrap();
    arm.clear_alarms().await.unwrap();
    let path: Vec<Set> = (0..segments)
        .map(|nth| build::path_to(200.0 + f32::from(nth % 100) * 0.5, 0.0, 20.0))
        .collect();
    let mut run = arm.start(path);
    let (mut polls, mut run) = (0, pin!(run.wait(|_| {})));
    let before =
        [&counts.reads, &counts.writes, &counts.leaps].map(|one| one.load(Ordering::Relaxed));
    let ran = std::future::poll_fn(|cx| {
        polls += 1;
        run.as_mut().poll(cx)
    });
    assert_eq!(ran.await.unwrap().commands, u64::from(segments));
    let after =
        [&counts.reads, &counts.writes, &counts.leaps].map(|one| one.load(Ordering::Relaxed));
    let each = |count: u64| count as f64 / f64::from(segments);
    Work {
        reads: each(after[0] - before[0]),
        writes: each(after[1] - before[1]),
        leaps: each(after[2] - before[2]),
        wakes: each(polls),
    }
}

#[tokio::test(start_paused = true)]
async fn a_segment_makes_so_much_work_and_no_more() {
    for (window, segments) in [(1, 2_000), (1, 20_000), (4, 4_000)] {
        let work = work(window, segments).await;
        // The command, a queue reading when the one before has finished, and a few readings of its
        // free places.
        assert!(work.writes <= 2.5, "{work:?}");
        // A read per answer, and one per attempt without an answer.
        assert!(work.reads <= 6.0, "{work:?}");
        assert!(work.leaps <= 1.5, "{work:?}");
        // The task and the caller wake each other once per burst.
        assert!(work.wakes <= 1.0 / 16.0, "{work:?}");
    }
}
