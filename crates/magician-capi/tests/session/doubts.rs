//! Lost replies: calls to an arm behind a bridge that drops some of its replies.

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
    NextQueued,
    /// The next reply to a queued command, and all after it.
    FromNextQueued,
    Everything,
}

/// Timeout of calls whose reply arrives, ms. Long, for a machine under load.
const LONG_MS: u32 = 120_000;
/// Timeout of calls whose reply is dropped, ms. Long enough for the request to reach the arm.
const SHORT_MS: u32 = 1_500;

/// A virtual arm behind a TCP bridge.
struct Bridge {
    arm: VirtualArm,
    address: SocketAddr,
    drops: Arc<AtomicU8>,
    stop_server: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Bridge {
    fn new() -> Self {
        let arm = VirtualArm::default();
        let drops = Arc::new(AtomicU8::new(Drops::Nothing as u8));
        let (send_address, receive_address) = channel();
        let (stop_server, end) = oneshot::channel::<()>();
        let (bridged_arm, bridge_drops) = (arm.clone(), Arc::clone(&drops));
        let thread = std::thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_current_thread()
                .enable_all()
                .build()
                .unwrap();
            runtime.block_on(async {
                let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
                send_address.send(listener.local_addr().unwrap()).unwrap();
                let serve = async {
                    loop {
                        let (client, _) = listener.accept().await.unwrap();
                        carry_bytes(client, &bridged_arm, &bridge_drops).await;
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
            address: receive_address.recv().unwrap(),
            drops,
            stop_server: Some(stop_server),
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
            Drops::Nothing | Drops::NextQueued => LONG_MS,
            Drops::FromNextQueued | Drops::Everything => SHORT_MS,
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
        drop(self.stop_server.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

async fn carry_bytes(mut client: TcpStream, arm: &VirtualArm, drops: &AtomicU8) {
    let line = RawLine::simulated(arm.clone(), LineOptions::default());
    let mut line = line.await.unwrap();
    let (mut to_arm, mut from_arm) = ([0; 1024], [0; 1024]);
    loop {
        tokio::select! {
            read = client.read(&mut to_arm) => match read {
                Ok(count) if count > 0 => line.send(&to_arm[..count]).await.unwrap(),
                _ => return,
            },
            read = line.receive(&mut from_arm) => {
                let frame = &from_arm[..read.unwrap()];
                // Bytes of a frame: two of header, length, id, Ctrl.
                let queued = frame[4] & 2 != 0;
                let what = drops.load(Ordering::SeqCst);
                let next = match what {
                    what if what == Drops::NextQueued as u8 && queued => Drops::Nothing,
                    what if what == Drops::FromNextQueued as u8 && queued => Drops::Everything,
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
fn connecting_starts_the_queue_only_if_it_is_empty() {
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
        bridge.set_drops(&registry, Drops::NextQueued);
        assert_eq!(home(&registry), (0, index));
    }
    assert_eq!(bridge.queued(), 5, "each was taken once");
}

#[test]
fn lost_reply_of_the_first_command_is_recovered_at_rest() {
    let bridge = Bridge::new();
    let registry = bridge.registry();
    bridge.set_drops(&registry, Drops::NextQueued);
    // The first index of an arm is 1 or 2, and the lost reply leaves open which. The library
    // returns 1: a program that waits for index 1 never waits too long.
    assert_eq!(home(&registry), (0, 1));
    assert_eq!(home(&registry), (0, 3));
    assert_eq!(bridge.queued(), 2, "each was taken once");
}

#[test]
fn commands_in_doubt_are_never_retransmitted() {
    let bridge = Bridge::new();
    let registry = bridge.registry();
    assert_eq!(home(&registry), (0, 2));
    bridge.set_drops(&registry, Drops::FromNextQueued);
    assert_eq!(home(&registry), (2, 0));
    let first = fault();
    assert!(first.contains("look at the arm"), "{first}");
    bridge.set_drops(&registry, Drops::Nothing);
    // The vendor's wrapper retries a failed call like this.
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
    bridge.set_drops(&registry, Drops::FromNextQueued);
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
    bridge.set_drops(&registry, Drops::FromNextQueued);
    assert_eq!(home(&registry).0, 2);
    bridge.set_drops(&registry, Drops::Nothing);
    assert_eq!(jog(0), 0, "it ends whatever is in doubt");
}

#[test]
fn lost_reply_of_an_immediate_command_leaves_a_doubt() {
    let bridge = Bridge::new();
    let registry = bridge.registry();
    let allowed = with_text("QueuedCmdStartDownload", |names| registry.allow(names));
    assert_eq!(allowed, 0);
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
    bridge.set_drops(&registry, Drops::FromNextQueued);
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
    bridge.set_drops(&registry, Drops::FromNextQueued);
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
fn forced_stop_does_not_wait_for_a_pending_call() {
    let bridge = Bridge::new();
    let registry = bridge.registry();
    let start = || {
        call::set(
            &registry.find(Family::V1, 0).unwrap(),
            &QueuedCmdStartExec {},
        )
    };
    start().unwrap();
    bridge.set_drops(&registry, Drops::FromNextQueued);
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
