//! In steady state a connection and a stream allocate nothing, on a good line and on a lossy one,
//! nor does a run through the driver to a virtual arm.
#![allow(
    unsafe_code,
    reason = "counting allocations takes an allocator, and an allocator is unsafe"
)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::collections::VecDeque;

use magician::commands::{CpCmd, DeviceTime, QueuedCmdCurrentIndex, QueuedCmdLeftSpace, WaitCmd};
use magician::connection::{Connection, Event, Request, Settings};
use magician::protocol::{CpMode, NoArgs, Writable};
use magician::stream::{Item, Stream, StreamEvent, StreamSettings};
use magician::{Arm, Ctrl, FrameBuf, Options, VirtualArm, build};

thread_local! {
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

struct Counting;

fn count() {
    // While a thread ends, its counter no longer exists.
    let _ = COUNT.try_with(|count| count.set(count.get() + 1));
}

// SAFETY: everything is left to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: as promised by the caller.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: as promised by the caller.
        unsafe { System.dealloc(memory, layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: as promised by the caller.
        unsafe { System.realloc(memory, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const TICK: u64 = 1_000;

/// A host that always has requests, and an arm that executes them at once, on a line with a delay
/// of one tick.
struct StreamLoop {
    host: Connection,
    tick: u64,
    next: u64,
    line: VecDeque<FrameBuf>,
    /// Loses one frame in this many.
    loss: u64,
    frames: u64,
    answered: u64,
    /// End position of the last accepted command, as in the answer to GetPose.
    pose: [u8; 32],
}

impl StreamLoop {
    fn new(window: usize, loss: u64) -> Self {
        let settings = Settings {
            window,
            baud: Some(115_200),
            ..Settings::ORDERED
        };
        Self {
            host: Connection::new(settings),
            tick: 0,
            next: 1,
            line: VecDeque::with_capacity(64),
            loss,
            frames: 0,
            answered: 0,
            pose: [0; 32],
        }
    }

    fn answer(&mut self, request: &FrameBuf) -> FrameBuf {
        let view = request.frame();
        let last = (self.next - 1).to_le_bytes();
        let clock = ((self.tick * TICK / 1000) as u32).to_le_bytes();
        let room = 32u32.to_le_bytes();
        let params: &[u8] = match (view.id(), view.ctrl().queued()) {
            (id, true) => {
                self.next += 1;
                if id == CpCmd::ROW.id {
                    // x, y, z follow the mode.
                    self.pose[..12].copy_from_slice(&view.params()[1..13]);
                }
                &(self.next - 1).to_le_bytes()
            }
            (246, _) => &last,
            (247, _) => &room,
            (4, _) => &clock,
            (10, false) => &self.pose,
            _ => &[],
        };
        FrameBuf::new(view.id(), Ctrl(view.ctrl().0), params).unwrap()
    }

    fn pass(&mut self) {
        self.ask();
        self.exchange();
        while let Some(event) = self.host.poll_event() {
            self.answered += u64::from(matches!(event, Event::Done { .. }));
        }
    }

    /// Passes one tick as [`pass`](Self::pass) does, with the commands of a stream.
    fn pass_stream(&mut self, stream: &mut Stream) {
        self.tick += 1;
        let now = self.tick * TICK;
        while stream.room() > 0 {
            stream.offer(segment(self.tick)).unwrap();
        }
        stream.advance(now, &mut self.host);
        self.exchange();
        while let Some(Event::Done { ticket, result }) = self.host.poll_event() {
            self.answered += u64::from(stream.answered(now, ticket, &result, &mut self.host));
        }
        while let Some(event) = stream.poll_event() {
            assert!(!matches!(event, StreamEvent::Failed(_)), "{event:?}");
        }
    }

    fn ask(&mut self) {
        self.tick += 1;
        let now = self.tick * TICK;
        let deadline = now + 10_000_000;
        let command = Request::queued(&WaitCmd { timeout: 0 }).unwrap();
        let command = match self.tick % 50 {
            0 => command,
            _ => command.repeatable(),
        };
        self.host.submit(command.deadline(deadline));
        if self.tick.is_multiple_of(20) {
            let reads = [
                Request::get::<QueuedCmdCurrentIndex>(&NoArgs),
                Request::get::<QueuedCmdLeftSpace>(&NoArgs),
                Request::get::<DeviceTime>(&NoArgs),
            ];
            for read in reads {
                self.host.submit(read.unwrap().deadline(deadline));
            }
        }
    }

    fn exchange(&mut self) {
        let now = self.tick * TICK;
        while let Some(reply) = self.line.pop_front() {
            self.host.receive(now, reply.bytes());
        }
        if self.host.poll_timeout().is_some_and(|at| at <= now) {
            self.host.handle_timeout(now);
        }
        while let Some(frame) = self.host.poll_transmit(now) {
            self.frames += 1;
            let lost = |number: u64| self.loss > 0 && number.is_multiple_of(self.loss);
            let (to_arm, to_host) = (lost(self.frames), lost(self.frames + 17));
            if !to_arm {
                let reply = self.answer(&frame);
                if !to_host {
                    self.line.push_back(reply);
                }
            }
        }
    }
}

fn segment(count: u64) -> Item {
    let command = CpCmd {
        cp_mode: CpMode::Absolute,
        x: 200.0 + (count % 100) as f32 * 0.2,
        y: 0.0,
        z: 20.0,
        velocity_or_power: 0.0,
    };
    Item {
        command: command.into(),
        time: 2_000,
        end: None,
        laser: false,
    }
}

#[test]
fn a_stream_allocates_nothing_whatever_the_line_loses() {
    // The first reply must not be lost: the first command could never be confirmed.
    for (window, loss) in [(1, 0), (4, 0), (1, 23), (4, 101)] {
        let mut bench = StreamLoop::new(window, loss);
        let mut stream = Stream::new(StreamSettings {
            window,
            ..StreamSettings::default()
        });
        (0..3_000).for_each(|_| bench.pass_stream(&mut stream));
        let (before, answered) = (COUNT.get(), bench.answered);
        (0..20_000).for_each(|_| bench.pass_stream(&mut stream));
        assert_eq!(COUNT.get() - before, 0, "window {window}, loss {loss}");
        assert!(
            bench.answered > answered + 1_000,
            "{}",
            bench.answered - answered
        );
    }
}

#[test]
fn a_steady_state_allocates_nothing() {
    for (window, loss) in [(1, 0), (4, 0), (8, 0), (1, 23), (4, 101)] {
        let mut bench = StreamLoop::new(window, loss);
        (0..3_000).for_each(|_| bench.pass());
        let (before, answered) = (COUNT.get(), bench.answered);
        (0..20_000).for_each(|_| bench.pass());
        assert_eq!(COUNT.get() - before, 0, "window {window}, loss {loss}");
        assert!(bench.answered > answered + 10_000);
        assert!(bench.frames > 2_000);
    }
}

/// Covers the commands, their way to the task, the arm that executes them, and the task's reports.
#[test]
fn a_segment_through_the_driver_allocates_nothing() {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_time()
        .start_paused(true)
        .build()
        .unwrap();
    for window in [1, 4] {
        let seen = Cell::new([0; 2]);
        let path = (0..30_000).map(|nth| {
            match nth {
                10_000 => seen.set([COUNT.get(), 0]),
                29_000 => seen.set([seen.get()[0], COUNT.get()]),
                _ => {}
            }
            build::path_to(200.0 + (nth % 100) as f32 * 0.5, 0.0, 20.0)
        });
        runtime.block_on(async {
            let options = Options::default().window(window);
            let arm = Arm::simulated(VirtualArm::default(), options)
                .await
                .unwrap();
            arm.clear_alarms().await.unwrap();
            assert_eq!(arm.start(path).wait(|_| {}).await.unwrap().commands, 30_000);
        });
        let [before, after] = seen.get();
        assert_eq!(after - before, 0, "window {window}");
    }
}
