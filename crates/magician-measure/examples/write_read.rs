//! Compares the driver's queued commands with a loop that writes a command and reads its reply.
//!
//! `magician sim --pty ./arm --baud 115200 --turnaround 2` in one terminal, then
//! `cargo run --release -p magician-measure --example write_read -- ./arm [SECONDS [ROUNDS]]`
//!
//! The loop is the minimum that a program on a serial line can do: bare system calls, no check, no
//! reading of the queue. The command is a move to the current position, which takes the arm no
//! time, so the line is the limit and nothing moves. Loop and driver take turns, first alone, then
//! with pose, current index and left space read 20 times a second; the loop reads them between its
//! commands.

#[cfg(unix)]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    unix::main()
}

#[cfg(not(unix))]
fn main() {
    eprintln!("this example opens a terminal as a file");
}

#[cfg(unix)]
mod unix {
    use std::env::args;
    use std::error::Error;
    use std::fs::File;
    use std::io::{Read, Write};
    use std::time::{Duration, Instant};

    use magician::{Arm, Options, Progress, Target};
    use magician_protocol::commands::{Pose, PtpCmd, QueuedCmdCurrentIndex, QueuedCmdLeftSpace};
    use magician_protocol::{Ctrl, FrameBuf, NoArgs, PtpMode, Readable, Set};
    use rustix::fs::{Mode, OFlags};
    use tokio::time::{MissedTickBehavior, interval};

    type Outcome<T> = Result<T, Box<dyn Error>>;

    /// Reads of each kind per second.
    const POLL_RATE: f64 = 20.0;
    /// Unmeasured share of the time, because a stream begins by reading the arm's state.
    const WARM_UP: f64 = 0.25;
    /// Silence after which all replies to earlier requests have arrived. Choice.
    const SILENCE: Duration = Duration::from_millis(100);
    /// Bytes of a frame without parameters.
    const BARE_FRAME_LENGTH: usize = 6;
    /// Bytes of a reply with an index.
    const INDEXED_REPLY_LENGTH: usize = 14;

    pub(super) fn main() -> Outcome<()> {
        let port = args().nth(1).ok_or("which port?")?;
        let seconds = args().nth(2).map_or(Ok(4.0), |text| text.parse())?;
        let rounds: usize = args().nth(3).map_or(Ok(3), |text| text.parse())?;
        let time = Duration::from_secs_f64(seconds);
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()?;
        for polls in [0.0, POLL_RATE] {
            let mut ratios = Vec::new();
            for _ in 0..rounds.max(1) {
                let here = runtime.block_on(start_queue_in_place(&port))?;
                let loop_rate = write_read(&port, here, time, polls)?;
                let driver_rate = runtime.block_on(drive(&port, here, time, polls))?;
                let ratio = driver_rate / loop_rate;
                println!(
                    "{polls} polls/s: loop {loop_rate:.1}/s, driver {driver_rate:.1}/s, ratio {ratio:.4}"
                );
                ratios.push(ratio);
            }
            ratios.sort_by(f64::total_cmp);
            let median = ratios.get(ratios.len() / 2).copied().unwrap_or_default();
            println!("{polls} polls/s: {median:.4} of the loop");
        }
        Ok(())
    }

    async fn connect(port: &str) -> magician::Result<Arm> {
        Arm::connect_with(&Target::Serial(port.to_owned()), Options::default()).await
    }

    /// Returns a move to the current position, after starting the queue.
    async fn start_queue_in_place(port: &str) -> Outcome<Set> {
        let arm = connect(port).await?;
        let pose = arm.get::<Pose>().await?;
        let here = PtpCmd {
            ptp_mode: PtpMode::MovjXyz,
            x: pose.x,
            y: pose.y,
            z: pose.z,
            r: pose.r,
        };
        arm.start([Set::from(here)]).wait(|_| {}).await?;
        arm.detach();
        arm.close().await;
        Ok(here.into())
    }

    /// Returns the driver's commands per second.
    async fn drive(port: &str, here: Set, time: Duration, polls: f64) -> Outcome<f64> {
        let arm = connect(port).await?;
        let begun = Instant::now();
        let commands = std::iter::repeat(here).take_while(|_| begun.elapsed() < time);
        // A reading of the index often shows several commands finished at once. Until the next
        // reading the same number is reported again, and is skipped here.
        let mut readings: Vec<(u64, Instant)> = Vec::new();
        let mut run = arm.start(commands);
        let note = |progress: Progress| {
            let (finished, age) = (progress.current.0, begun.elapsed());
            let is_new = readings.last().is_none_or(|(before, _)| finished > *before);
            if is_new && age < time && age >= time.mul_f64(WARM_UP) {
                readings.push((finished, Instant::now()));
            }
        };
        tokio::select! {
            ran = run.wait(note) => ran.map(drop)?,
            polled = poll(&arm, polls) => polled?,
        }
        drop(run);
        arm.close().await;
        // The first entry is left out: its number may come from a reading long before its
        // timestamp.
        let (Some(first), Some(last)) = (readings.get(1), readings.last()) else {
            return Err("too short".into());
        };
        Ok((last.0 - first.0) as f64 / (last.1 - first.1).as_secs_f64())
    }

    async fn poll(arm: &Arm, polls: f64) -> Outcome<()> {
        if polls <= 0.0 {
            return std::future::pending().await;
        }
        let mut ticks = interval(Duration::from_secs_f64(1.0 / polls));
        ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
        loop {
            ticks.tick().await;
            arm.get::<Pose>().await?;
            arm.get::<QueuedCmdCurrentIndex>().await?;
            arm.get::<QueuedCmdLeftSpace>().await?;
        }
    }

    /// Returns commands per second if each is written after the reply to the previous one was read.
    fn write_read(port: &str, here: Set, time: Duration, polls: f64) -> Outcome<f64> {
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        let mut line = File::from(rustix::fs::open(port, flags, Mode::empty())?);
        // A reply left over from before would let the loop run one command ahead.
        std::thread::sleep(SILENCE);
        rustix::termios::tcflush(&line, rustix::termios::QueueSelector::IFlush)?;
        let reads = [
            (FrameBuf::get(&NoArgs, Pose::ROW)?, BARE_FRAME_LENGTH + 32),
            (
                FrameBuf::get(&NoArgs, QueuedCmdCurrentIndex::ROW)?,
                INDEXED_REPLY_LENGTH,
            ),
            (
                FrameBuf::get(&NoArgs, QueuedCmdLeftSpace::ROW)?,
                BARE_FRAME_LENGTH + 4,
            ),
        ];
        let poll_interval = (polls > 0.0).then(|| Duration::from_secs_f64(1.0 / polls));
        let (mut count, mut reply) = (0_u32, [0; 64]);
        let begun = Instant::now();
        let mut due = begun;
        while begun.elapsed() < time {
            let frame = FrameBuf::set(&here, Ctrl::QUEUED)?;
            exchange(&mut line, &frame, reply.get_mut(..INDEXED_REPLY_LENGTH))?;
            if reply.get(5..13) == Some(&[0; 8]) {
                return Err("the queue is full: the line is not the limit".into());
            }
            count += 1;
            if let Some(poll_interval) = poll_interval
                && due <= Instant::now()
            {
                due = Instant::now() + poll_interval;
                for (request, length) in &reads {
                    exchange(&mut line, request, reply.get_mut(..*length))?;
                }
            }
        }
        Ok(f64::from(count) / begun.elapsed().as_secs_f64())
    }

    fn exchange(line: &mut File, request: &FrameBuf, reply: Option<&mut [u8]>) -> Outcome<()> {
        line.write_all(request.bytes())?;
        line.read_exact(reply.ok_or("a longer reply")?)?;
        Ok(())
    }
}
