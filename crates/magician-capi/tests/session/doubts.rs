//! Lost replies, over a bridge that drops them.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::mpsc::channel;
use std::thread::JoinHandle;

use magician::commands::{
    JogCmd, QueuedCmdForceStopExec, QueuedCmdStartDownload, QueuedCmdStartExec, QueuedCmdStopExec,
};
use magician::protocol::{Flag, FrameBuf};
use magician::{Ctrl, LineOptions, RawLine, VirtualArm};
use magician_capi::session::Registry;
use magician_capi::{Family, call};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::oneshot;

use crate::bench::{clear, connect_v1, fault, home, pose, registry, run, with_text};

/// Replies that the bridge drops.
#[derive(Clone, Copy, PartialEq)]
#[repr(u8)]
enum Drops {
    Nothing,
    /// The next reply to a queued command.
    One,
    /// The next reply to a queued command, and all after it.
    All,
    Everything,
}

/// Timeouts of calls, ms: for a reply that arrives, on however busy a machine, and for one that was
/// dropped. The short one still has to let the request reach the arm.
const LONG_MS: u32 = 120_000;
const SHORT_MS: u32 = 1_500;

/// A virtual arm behind a TCP bridge.
struct Bridge {
    arm: VirtualArm,
    address: SocketAddr,
    drops: Arc<AtomicU8>,
    over: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Bridge {
    fn new() -> Self {
        let arm = VirtualArm::default();
        let drops = Arc::new(AtomicU8::new(Drops::Nothing as u8));
        let (tell, told) = channel();
        let (over, end) = oneshot::channel::<()>();
        let (far, lost) = (arm.clone(), Arc::clone(&drops));
        let thread = std::thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_current_thread()
                .enable_all()
                .build()
                .unwrap();
            runtime.block_on(async {
                let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
                tell.send(listener.local_addr().unwrap()).unwrap();
                let serve = async {
                    loop {
                        let (client, _) = listener.accept().await.unwrap();
                        carry(client, &far, &lost).await;
                    }
                };
                tokio::select! {
                    () = serve => {}
                    _ = end => {}
                }
            });
        });
        Self {
            arm,
            address: told.recv().unwrap(),
            drops,
            over: Some(over),
            thread: Some(thread),
        }
    }

    fn drops(&self, what: Drops) {
        self.drops.store(what as u8, Ordering::SeqCst);
    }

    /// Sets which replies are dropped, and a matching timeout: short if replies are lost, long
    /// otherwise.
    fn set_drops(&self, registry: &Registry, what: Drops) {
        self.drops(what);
        let timeout_ms = match what {
            Drops::Nothing | Drops::One => LONG_MS,
            Drops::All | Drops::Everything => SHORT_MS,
        };
        registry.set_timeout(0, timeout_ms);
    }

    fn connect(&self, registry: &Registry) {
        let name = format!("tcp:{}", self.address);
        assert_eq!(connect_v1(registry, &name).code, 0);
        registry.set_timeout(0, LONG_MS);
    }

    /// Connects a registry to the bridge and stops the queue.
    fn registry(&self) -> Registry {
        let registry = registry();
        self.connect(&registry);
        assert_eq!(stop(&registry), 0);
        registry
    }

    /// Number of commands in the arm's queue.
    fn queued(&self) -> usize {
        self.arm.state().queue.waiting
    }
}

impl Drop for Bridge {
    fn drop(&mut self) {
        drop(self.over.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

async fn carry(mut client: TcpStream, arm: &VirtualArm, drops: &AtomicU8) {
    let line = RawLine::simulated(arm.clone(), LineOptions::default());
    let mut line = line.await.unwrap();
    let (mut there, mut back) = ([0; 1024], [0; 1024]);
    loop {
        tokio::select! {
            came = client.read(&mut there) => match came {
                Ok(count) if count > 0 => line.send(&there[..count]).await.unwrap(),
                _ => return,
            },
            came = line.receive(&mut back) => {
                let frame = &back[..came.unwrap()];
                // Bytes of a frame: two of header, length, id, Ctrl.
                let queued = frame[4] & 2 != 0;
                let what = drops.load(Ordering::SeqCst);
                let next = match what {
                    what if what == Drops::One as u8 && queued => Drops::Nothing,
                    what if what == Drops::All as u8 && queued => Drops::Everything,
                    what if what == Drops::Everything as u8 => Drops::Everything,
                    _ => {
                        client.write_all(frame).await.unwrap();
                        continue;
                    }
                };
                let _ = drops.compare_exchange(what, next as u8, Ordering::SeqCst, Ordering::SeqCst);
            }
        }
    }
}

fn stop(registry: &Registry) -> i32 {
    run(registry, "SetQueuedCmdStopExec", 0, |arm| {
        call::set(arm, &QueuedCmdStopExec {})
    })
}

/// An empty queue is started, as programs expect. A queue with commands of another program is not.
#[test]
fn connecting_starts_an_empty_queue_and_no_other() {
    let bridge = Bridge::new();
    let started = || bridge.arm.state().queue.started;
    assert!(!started(), "as at power-up");
    let registry = registry();
    bridge.connect(&registry);
    assert!(started());
    assert_eq!(stop(&registry), 0);
    bridge.connect(&registry);
    assert!(started(), "nothing waits in it");
    assert_eq!(stop(&registry), 0);
    assert_eq!(home(&registry), (0, 2));
    bridge.connect(&registry);
    assert_eq!((started(), bridge.queued()), (false, 1));
}

#[test]
fn lost_reply_is_recovered() {
    let bridge = Bridge::new();
    let registry = bridge.registry();
    assert_eq!(home(&registry), (0, 2));
    for index in 3..7 {
        bridge.set_drops(&registry, Drops::One);
        assert_eq!(home(&registry), (0, index));
    }
    assert_eq!(bridge.queued(), 5, "each was taken once");
}

#[test]
fn lost_reply_of_the_first_command_is_recovered_at_rest() {
    let bridge = Bridge::new();
    let registry = bridge.registry();
    bridge.set_drops(&registry, Drops::One);
    // The first index of an arm is 1 or 2. Take 1, so that waiting for it ends.
    assert_eq!(home(&registry), (0, 1));
    assert_eq!(home(&registry), (0, 3));
    assert_eq!(bridge.queued(), 2, "each was taken once");
}

#[test]
fn commands_in_doubt_are_never_retransmitted() {
    let bridge = Bridge::new();
    let registry = bridge.registry();
    assert_eq!(home(&registry), (0, 2));
    bridge.set_drops(&registry, Drops::All);
    assert_eq!(home(&registry), (2, 0));
    let first = fault();
    assert!(first.contains("look at the arm"), "{first}");
    bridge.set_drops(&registry, Drops::Nothing);
    // A stock wrapper retries like this.
    for _ in 0..20 {
        assert_eq!(home(&registry), (2, 0));
    }
    assert!(
        fault().contains("not sent") && fault().contains("SetQueuedCmdClear"),
        "{}",
        fault()
    );
    assert_eq!(
        bridge.queued(),
        2,
        "it had been taken, and none of the others"
    );
    assert_eq!(pose(&registry).0, 0, "looking is free");
    assert_eq!(stop(&registry), 0);
    let halt = |arm: &magician_capi::session::Session| call::set(arm, &QueuedCmdForceStopExec {});
    assert_eq!(run(&registry, "SetQueuedCmdForceStopExec", 0, halt), 0);
    assert_eq!(
        home(&registry).0,
        2,
        "what waits stays in the queue after a stop"
    );
    assert_eq!(clear(&registry), 0);
    assert_eq!(bridge.queued(), 0);
    assert_eq!(home(&registry), (0, 4));
}

#[test]
fn new_connection_clears_the_doubt() {
    let bridge = Bridge::new();
    let registry = bridge.registry();
    bridge.set_drops(&registry, Drops::All);
    assert_eq!(home(&registry).0, 2);
    bridge.set_drops(&registry, Drops::Nothing);
    assert_eq!(home(&registry).0, 2);
    assert_eq!(
        connect_v1(&registry, &format!("tcp:{}", bridge.address)).code,
        0
    );
    assert_eq!(home(&registry), (0, 3));
}

#[test]
fn jog_may_be_repeated_and_always_stopped() {
    let bridge = Bridge::new();
    let registry = bridge.registry();
    let jog = |cmd: u8| {
        run(&registry, "SetJOGCmd", 0, |arm| {
            call::set(
                arm,
                &JogCmd {
                    is_joint: Flag::ON,
                    cmd: cmd.into(),
                },
            )
        })
    };
    bridge.set_drops(&registry, Drops::Everything);
    assert_eq!(jog(1), 2);
    bridge.set_drops(&registry, Drops::Nothing);
    assert_eq!(jog(0), 0);
    assert_eq!(home(&registry).0, 0);
    bridge.set_drops(&registry, Drops::All);
    assert_eq!(home(&registry).0, 2);
    bridge.set_drops(&registry, Drops::Nothing);
    assert_eq!(jog(0), 0, "it ends whatever is in doubt");
}

#[test]
fn lost_reply_of_an_immediate_command_leaves_a_doubt() {
    let bridge = Bridge::new();
    let registry = bridge.registry();
    let named = with_text("QueuedCmdStartDownload", |names| registry.allow(names));
    assert_eq!(named, 0);
    let download = || {
        let start = QueuedCmdStartDownload {
            total_loop: 1,
            line_per_loop: 1,
        };
        run(&registry, "SetQueuedCmdStartDownload", 0, |arm| {
            call::set(arm, &start)
        })
    };
    bridge.set_drops(&registry, Drops::Everything);
    assert_eq!(download(), 2);
    bridge.set_drops(&registry, Drops::Nothing);
    assert_eq!(download(), 2);
    assert!(fault().contains("not sent"), "{}", fault());
}

#[test]
fn raw_frames_are_refused_while_in_doubt() {
    let bridge = Bridge::new();
    let registry = bridge.registry();
    bridge.set_drops(&registry, Drops::All);
    assert_eq!(home(&registry).0, 2);
    bridge.set_drops(&registry, Drops::Nothing);
    let arm = registry.find(magician_capi::Family::V1, 0).unwrap();
    let frame: Result<FrameBuf, _> = arm.raw(31, Ctrl::QUEUED, &[0; 4]);
    assert_eq!(frame.unwrap_err().code as i32, 2);
    assert_eq!(bridge.queued(), 1);
}

#[test]
fn call_without_reply_times_out_and_writes_nothing() {
    let bridge = Bridge::new();
    let registry = bridge.registry();
    bridge.set_drops(&registry, Drops::Everything);
    let (code, bytes) = pose(&registry);
    assert_eq!(code, 2);
    assert!(bytes.iter().all(|byte| *byte == crate::bench::UNTOUCHED));
    assert!(fault().contains("GetPose"), "{}", fault());
}

#[test]
fn waiting_command_is_refused_after_one_in_doubt() {
    let bridge = Bridge::new();
    let registry = bridge.registry();
    bridge.set_drops(&registry, Drops::All);
    std::thread::scope(|scope| {
        let first = scope.spawn(|| home(&registry).0);
        while bridge.queued() == 0 {
            std::thread::yield_now();
        }
        registry.set_timeout(0, 2 * SHORT_MS);
        let second = scope.spawn(|| (home(&registry).0, fault()));
        assert_eq!(first.join().unwrap(), 2);
        let (code, fault) = second.join().unwrap();
        assert_eq!(code, 2);
        assert!(fault.contains("not sent"), "{fault}");
    });
    assert_eq!(bridge.queued(), 1);
}

#[test]
fn excess_callers_get_a_retry_error() {
    let bridge = Bridge::new();
    let registry = bridge.registry();
    bridge.set_drops(&registry, Drops::Everything);
    let codes: Vec<i32> = std::thread::scope(|scope| {
        let callers: Vec<_> = (0..150)
            .map(|_| scope.spawn(|| pose(&registry).0))
            .collect();
        let codes = callers.into_iter().map(|caller| caller.join().unwrap());
        codes.collect()
    });
    assert!(codes.iter().all(|code| [1, 2].contains(code)), "{codes:?}");
}

#[test]
fn a_forced_stop_waits_for_no_answer() {
    let bridge = Bridge::new();
    let registry = bridge.registry();
    let start = || {
        call::set(
            &registry.find(Family::V1, 0).unwrap(),
            &QueuedCmdStartExec {},
        )
    };
    start().unwrap();
    bridge.set_drops(&registry, Drops::All);
    registry.set_timeout(0, 4 * SHORT_MS);
    std::thread::scope(|scope| {
        let first = scope.spawn(|| (home(&registry).0, fault()));
        while bridge.drops.load(Ordering::SeqCst) != Drops::Everything as u8 {
            std::thread::yield_now();
        }
        registry.set_timeout(0, SHORT_MS);
        assert!(bridge.arm.state().queue.started);
        let stop = run(&registry, "SetQueuedCmdForceStopExec", 0, |arm| {
            call::set(arm, &QueuedCmdForceStopExec {})
        });
        assert_eq!(stop, 2, "its answer is lost too");
        while bridge.arm.state().queue.started {
            assert!(!first.is_finished(), "it waited for the first");
            std::thread::yield_now();
        }
        let (code, fault) = first.join().unwrap();
        assert_eq!(code, 2);
        assert!(fault.contains("may or may not have the command"), "{fault}");
    });
}
