//! Tests of a suspended process, and of a reactor that reports late what has arrived.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll, Waker};
use std::time::Duration;

use magician_protocol::commands::{DeviceTime, Pose, QueuedCmdLeftSpace};
use magician_protocol::{Ctrl, FrameBuf, Readable};
use tokio::task::yield_now;
use tokio::time::{Instant, advance, sleep};

use crate::connection::Settings;
use crate::transport::{Line, ReadGap, Sim, Transport};
use crate::{Arm, Options, VirtualArm};

/// A line whose reactor reports no bytes while `deaf` is set.
struct SilentReactor {
    sim: Sim,
    away: ReadGap,
    deaf: Arc<AtomicBool>,
}

impl Transport for SilentReactor {
    fn poll_read(&mut self, cx: &mut Context<'_>, bytes: &mut [u8]) -> Poll<io::Result<usize>> {
        let told = if self.deaf.load(Ordering::SeqCst) {
            Poll::Pending
        } else {
            self.sim.poll_read(cx, bytes)
        };
        let mut nobody = Context::from_waker(Waker::noop());
        (self.away).look(told, || match self.sim.poll_read(&mut nobody, bytes) {
            Poll::Ready(Ok(count)) => Some(count),
            _ => None,
        })
    }

    fn poll_write(&mut self, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        self.sim.poll_write(cx, bytes)
    }
}

/// A datagram line whose reactor reports arrivals only after the next write; the system has them
/// when asked.
struct LateReactor {
    sim: Sim,
    away: ReadGap,
    come: Arc<Mutex<Vec<u8>>>,
    told: bool,
}

impl Transport for LateReactor {
    fn poll_read(&mut self, cx: &mut Context<'_>, bytes: &mut [u8]) -> Poll<io::Result<usize>> {
        let mut take = || {
            let come = std::mem::take(&mut *self.come.lock().unwrap());
            bytes[..come.len()].copy_from_slice(&come);
            Some(come.len()).filter(|count| *count > 0)
        };
        let told = match std::mem::take(&mut self.told).then(&mut take).flatten() {
            Some(count) => Poll::Ready(Ok(count)),
            None => Poll::Pending,
        };
        let found = self.away.look(told, take);
        if found.is_ready() {
            found
        } else {
            self.sim.poll_read(cx, bytes)
        }
    }

    fn ask(&mut self) {
        self.away.ask();
    }

    fn poll_write(&mut self, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        self.told = true;
        self.sim.poll_write(cx, bytes)
    }
}

/// A duplicate answer that arrived before a call is not taken for the answer to that call.
#[tokio::test(start_paused = true)]
async fn received_bytes_are_read_before_messages() {
    let come = Arc::new(Mutex::new(Vec::new()));
    let line = Line {
        transport: Box::new(LateReactor {
            sim: Sim::new(VirtualArm::default()),
            away: ReadGap::default(),
            come: Arc::clone(&come),
            told: false,
        }),
        settings: Settings::DATAGRAMS,
        name: "a tardy line".to_owned(),
        tried: "a tardy line",
        in_process: false,
        arm: None,
        is_shared: true,
    };
    let options = Options::default().probe(false);
    let arm = Arm::greet(line, None, options).await.unwrap();
    for nth in 0..20 {
        let before = arm.get::<Pose>().await.unwrap();
        let other = Pose { x: 1.0, ..before };
        let double = FrameBuf::encode(Pose::ROW.id, Ctrl::GET, &other).unwrap();
        come.lock().unwrap().extend(double.bytes());
        let pose = arm.get::<Pose>().await.unwrap();
        assert_eq!(pose, before, "{nth}");
    }
}

async fn deaf(settings: Settings) -> (Arm, Arc<AtomicBool>) {
    let deaf = Arc::new(AtomicBool::new(false));
    let line = Line {
        transport: Box::new(SilentReactor {
            sim: Sim::new(VirtualArm::default()),
            away: ReadGap::default(),
            deaf: Arc::clone(&deaf),
        }),
        settings,
        name: "a deaf line".to_owned(),
        tried: "a deaf line",
        in_process: false,
        arm: None,
        is_shared: true,
    };
    let arm = Arm::greet(line, None, Options::default()).await.unwrap();
    // No request is in flight any more.
    sleep(Duration::from_secs(1)).await;
    deaf.store(true, Ordering::SeqCst);
    (arm, deaf)
}

#[tokio::test(start_paused = true)]
async fn what_has_come_is_read_before_a_timeout_is_acted_on() {
    for settings in [Settings::ORDERED, Settings::DATAGRAMS] {
        let (arm, _deaf) = deaf(settings).await;
        let asked = Instant::now();
        arm.get::<Pose>().await.unwrap();
        assert!(asked.elapsed() < Duration::from_secs(1));
        let (stats, _) = arm.stats().await.unwrap();
        assert_eq!(stats.resent, 0);
    }
}

/// Every call that was in flight when the process was suspended gets its answer: the one whose
/// answer has arrived, and requests not yet sent.
#[tokio::test(start_paused = true)]
async fn a_host_that_was_held_up_gives_nothing_up() {
    for settings in [Settings::ORDERED, Settings::DATAGRAMS] {
        for slept in [2, 5, 100] {
            let (arm, deaf) = deaf(settings).await;
            let sleep = async {
                for _ in 0..100 {
                    yield_now().await;
                }
                advance(Duration::from_secs(slept)).await;
                deaf.store(false, Ordering::SeqCst);
            };
            let (pose, left, clock, ()) = tokio::join!(
                arm.get::<Pose>(),
                arm.get::<QueuedCmdLeftSpace>(),
                arm.get::<DeviceTime>(),
                sleep
            );
            let ended = [pose.map(drop), left.map(drop), clock.map(drop)];
            assert!(ended.iter().all(Result::is_ok), "{slept} s: {ended:?}");
        }
    }
}

/// A call still ends by its deadline if the line is silent, not the host.
#[tokio::test(start_paused = true)]
async fn a_line_that_is_silent_is_given_up_in_time() {
    let line = Line {
        transport: Box::new(crate::transport::Stream(tokio::io::duplex(64).0)),
        settings: Settings::ORDERED,
        name: "a silent line".to_owned(),
        tried: "a silent line",
        in_process: false,
        arm: None,
        is_shared: true,
    };
    let arm = Arm::greet(line, None, Options::default().probe(false)).await;
    let asked = Instant::now();
    assert!(arm.unwrap().get::<Pose>().await.is_err());
    let late = asked.elapsed().saturating_sub(Options::default().timeout);
    assert!(late <= Duration::from_millis(10), "{late:?}");
}
