//! S3: many arms in real time in one process, each polled for its pose 50 times and sent 10
//! commands a second.
//!
//!
//! The commands are short segments to and fro, so that every arm moves. The delay of a reply counts
//! from the instant at which its request was due, so that falling behind shows. The host's own work
//! is part of the figures.

use std::error::Error;
use std::net::SocketAddr;
use std::sync::mpsc::channel;
use std::thread;
use std::time::{Duration, Instant};

use magician::serve::{Discovery, Endpoint, Server, serve_all};
use magician_protocol::commands::{CpCmd, QueuedCmdStartExec};
use magician_protocol::{CpMode, Ctrl, FrameBuf};
use magician_sim::{Controller, HostInstant, LineTiming, Runner, Speed};
use tokio::net::UdpSocket;
use tokio::runtime::{Builder, Runtime};
use tokio::sync::oneshot;
use tokio::time::{interval_at, timeout};

use super::figure::Figure;
use super::program::{USB, frame};

/// Number of arms in memory, of arms over UDP, and of threads for the arms in memory.
const ARMS_IN_MEMORY: usize = 10_000;
const ARMS_OVER_UDP: usize = 500;
const THREADS: usize = 2;

/// Interval of polling the pose, µs.
const POLL_INTERVAL_US: u64 = 20_000;
/// Number of polls per command.
const POLLS_PER_COMMAND: u64 = 5;
/// Duration of the measurement.
const DURATION: Duration = Duration::from_secs(5);
/// Goal for the 99th percentile of delays, ms.
const P99_GOAL_MS: f64 = 5.0;

/// Frames that every host sends.
struct Frames {
    poll: FrameBuf,
    steps: [FrameBuf; 2],
}

impl Frames {
    fn new() -> Self {
        let step = |y| {
            let command = CpCmd {
                cp_mode: CpMode::Relative,
                x: 0.0,
                y,
                z: 0.0,
                velocity_or_power: 0.0,
            };
            frame(Ctrl::QUEUED, &command)
        };
        Self {
            poll: FrameBuf::new(10, Ctrl::GET, &[]).expect("a frame"),
            steps: [step(0.2), step(-0.2)],
        }
    }

    /// Returns the frames due with a poll: the request of the pose, and sometimes a command.
    fn due(&self, poll: u64) -> impl Iterator<Item = &FrameBuf> {
        let step = poll.is_multiple_of(POLLS_PER_COMMAND).then(|| {
            let nth = poll / POLLS_PER_COMMAND % 2;
            &self.steps[usize::from(nth > 0)]
        });
        [&self.poll].into_iter().chain(step)
    }
}

/// Results of one thread.
struct ThreadResult {
    /// Delays of replies after the instant at which they were due, ms.
    delays: Vec<f64>,
    /// Share of the time in which the thread was busy.
    busy: f64,
}

fn figure(name: &str, arms: usize, results: Vec<ThreadResult>) -> Figure {
    let busy: f64 = results.iter().map(|result| result.busy).sum();
    let mut delays: Vec<f64> = results
        .into_iter()
        .flat_map(|result| result.delays)
        .collect();
    delays.sort_by(f64::total_cmp);
    let part = |share: f64| {
        let at = (delays.len() as f64 * share) as usize;
        delays
            .get(at.min(delays.len().saturating_sub(1)))
            .copied()
            .unwrap_or(f64::NAN)
    };
    Figure::new(name, part(0.99), "ms p99 to a reply")
        .with("p50", part(0.5))
        .with("longest", part(1.0))
        .with("arms", arms as f64)
        .with("replies/s", delays.len() as f64 / DURATION.as_secs_f64())
        .with("cores", busy)
        .at_most(P99_GOAL_MS)
}

/// Runs one thread's arms in memory, each when it is due.
fn in_memory(arms: usize) -> ThreadResult {
    let frames = Frames::new();
    let mut runners: Vec<Runner> = (0..arms)
        .map(|_| {
            let mut runner = Runner::new(
                Controller::default(),
                Speed::default(),
                LineTiming::default(),
            );
            runner.receive(
                HostInstant::ZERO,
                USB,
                frame(Ctrl::SET, &QueuedCmdStartExec {}).bytes(),
            );
            while runner.poll_transmit(HostInstant::ZERO, USB).is_some() {}
            runner
        })
        .collect();
    let mut delays = Vec::with_capacity(arms * 60 * 6);
    let (began, mut slept) = (Instant::now(), Duration::ZERO);
    let wall = || HostInstant::ZERO + began.elapsed();
    'all: for poll in 0.. {
        for (nth, runner) in runners.iter_mut().enumerate() {
            // Polls of different arms are spread over the interval.
            let due = poll * POLL_INTERVAL_US + nth as u64 * POLL_INTERVAL_US / arms as u64;
            if Duration::from_micros(due) >= DURATION {
                break 'all;
            }
            let early = Duration::from_micros(due).saturating_sub(began.elapsed());
            if !early.is_zero() {
                let before = Instant::now();
                thread::sleep(early);
                slept += before.elapsed();
            }
            for frame in frames.due(poll) {
                runner.receive(wall(), USB, frame.bytes());
            }
            let now = wall();
            while runner.poll_transmit(now, USB).is_some() {
                delays.push(now.as_micros().saturating_sub(due) as f64 / 1e3);
            }
            while runner.controller_mut().poll_event().is_some() {}
        }
    }
    let busy = 1.0 - slept.as_secs_f64() / began.elapsed().as_secs_f64();
    ThreadResult { delays, busy }
}

fn runtime() -> Result<Runtime, std::io::Error> {
    Builder::new_current_thread().enable_all().build()
}

/// Serves arms over UDP on another thread while `talk` runs.
pub(super) fn with_served_arms<T>(
    arms: usize,
    line: LineTiming,
    talk: impl FnOnce(&[SocketAddr]) -> Result<T, Box<dyn Error>>,
) -> Result<T, Box<dyn Error>> {
    let (ready, is_ready) = channel();
    let (stop, stopped) = oneshot::channel::<()>();
    let server = thread::spawn(move || {
        let servers = (0..arms).map(|_| {
            let ready = ready.clone();
            Server::new(Controller::default())
                .line(line)
                .udp("127.0.0.1:0")
                .discovery(Discovery::Off)
                .on_ready(move |endpoints| {
                    let _ = ready.send(endpoints.to_vec());
                })
        });
        let runtime = runtime().map_err(|error| error.to_string())?;
        let serve = serve_all(servers, async {
            let _ = stopped.await;
        });
        runtime.block_on(serve).map_err(|error| error.to_string())
    });
    let mut addresses = Vec::new();
    while addresses.len() < arms {
        // The thread ended before all endpoints were ready, and reports the reason.
        let Ok(endpoints) = is_ready.recv() else {
            break;
        };
        addresses.extend(endpoints.iter().filter_map(|endpoint| match endpoint {
            Endpoint::Udp(address) => Some(*address),
            _ => None,
        }));
    }
    let told = if addresses.len() == arms {
        talk(&addresses)
    } else {
        Err("not all arms are served".into())
    };
    drop(stop);
    server
        .join()
        .map_err(|_| "the server's thread has ended")??;
    told
}

/// Runs one host over UDP. Returns the delays of its replies.
async fn run_host(
    arm: SocketAddr,
    first: tokio::time::Instant,
) -> Result<Vec<f64>, std::io::Error> {
    let frames = Frames::new();
    let socket = UdpSocket::bind("127.0.0.1:0").await?;
    socket.connect(arm).await?;
    let mut reply = [0; 512];
    socket
        .send(frame(Ctrl::SET, &QueuedCmdStartExec {}).bytes())
        .await?;
    socket.recv(&mut reply).await?;
    let mut delays = Vec::new();
    let mut polls = interval_at(first, Duration::from_micros(POLL_INTERVAL_US));
    let until = first + DURATION;
    for poll in 0.. {
        // The runtime's timer has a resolution of 1 ms, so the delay counts from the actual tick.
        if polls.tick().await >= until {
            break;
        }
        for request in frames.due(poll) {
            let sent = Instant::now();
            socket.send(request.bytes()).await?;
            // A request lost on a loopback socket means that the server is overloaded: the
            // measurement fails.
            match timeout(Duration::from_secs(1), socket.recv(&mut reply)).await {
                Ok(received) => drop(received?),
                Err(_) => return Err(std::io::ErrorKind::TimedOut.into()),
            }
            delays.push(sent.elapsed().as_secs_f64() * 1e3);
        }
    }
    Ok(delays)
}

/// Returns the CPU time of this process so far, s; `None` if the system does not report it.
fn cpu_time() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // After the name in parentheses; fields 14 and 15 of all, in hundredths of a second.
    let fields: Vec<&str> = stat.rsplit(')').next()?.split_whitespace().collect();
    let ticks = |at: usize| fields.get(at)?.parse::<f64>().ok();
    Some((ticks(11)? + ticks(12)?) / 100.0)
}

fn over_sockets(addresses: &[SocketAddr]) -> Result<Vec<ThreadResult>, Box<dyn Error>> {
    let before = cpu_time();
    let (began, arms) = (Instant::now(), addresses.len() as u64);
    let hosts = async {
        let start = tokio::time::Instant::now() + Duration::from_millis(200);
        let hosts: Vec<_> = (addresses.iter().zip(0u64..))
            .map(|(arm, nth)| {
                tokio::spawn(run_host(
                    *arm,
                    start + Duration::from_micros(nth * POLL_INTERVAL_US / arms),
                ))
            })
            .collect();
        let mut delays = Vec::new();
        for host in hosts {
            delays.extend(host.await??);
        }
        Ok::<_, Box<dyn Error>>(delays)
    };
    let delays = runtime()?.block_on(hosts)?;
    let spent = cpu_time()
        .zip(before)
        .map_or(f64::NAN, |(after, before)| after - before);
    let busy = spent / began.elapsed().as_secs_f64();
    Ok(vec![ThreadResult { delays, busy }])
}

/// Measures S3.
pub(super) fn measure() -> Result<Vec<Figure>, Box<dyn Error>> {
    let threads: Vec<_> = (0..THREADS)
        .map(|_| thread::spawn(|| in_memory(ARMS_IN_MEMORY / THREADS)))
        .collect();
    let mut results = Vec::new();
    for thread in threads {
        results.push(thread.join().map_err(|_| "a thread has ended")?);
    }
    let memory = figure("S3 in memory", ARMS_IN_MEMORY, results);
    let results = with_served_arms(ARMS_OVER_UDP, LineTiming::default(), over_sockets)?;
    Ok(vec![memory, figure("S3 over UDP", ARMS_OVER_UDP, results)])
}
