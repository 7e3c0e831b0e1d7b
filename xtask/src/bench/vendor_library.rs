//! Calls per second through the vendor's C interface, compared with the driver behind it.
//!
//!
//! A C program loads the built library and times its loops; the same calls of the driver are timed
//! here. Both alternate in batches at the same virtual arm: in the caller's process, behind a
//! pseudo-terminal without pacing, and paced at 115,200 baud. Motions take no time on the arm's
//! clock, so that the queue always has room.

use std::error::Error;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};
use std::{env, fs, process, thread};

use magician::Target;
use magician::blocking::Arm;
use magician::commands::{Pose, PtpCmd, QueuedCmdStartExec};
use magician::protocol::{BAUD_RATE, PtpMode};
use magician::serve::Server;
use magician_sim::{Controller, LineTiming, Speed};
use tokio::runtime::Builder;
use tokio::sync::oneshot;

use super::figure::Figure;
use crate::library;

const PACED: LineTiming = LineTiming {
    baud: Some(BAUD_RATE),
    turnaround: Duration::ZERO,
};
const UNPACED: LineTiming = LineTiming {
    baud: None,
    turnaround: Duration::ZERO,
};
/// Number of batches of each.
const BATCHES: usize = 7;

/// Calls per batch for each kind of line.
const CALLS_PER_BATCH: [(&str, Option<LineTiming>, usize); 3] = [
    ("in the process", None, 20_000),
    ("at a pseudo-terminal", Some(UNPACED), 5_000),
    ("at 115200 baud", Some(PACED), 200),
];

/// Measures calls per second of both, and their ratio.
pub(super) fn measure(docs: &Path) -> Result<Vec<Figure>, Box<dyn Error>> {
    let built = build(&docs.join(".."))?;
    let mut figures = Vec::new();
    for (place, line, count) in CALLS_PER_BATCH {
        figures.extend(match line {
            None => measure_both(&built, place, "sim", count)?,
            Some(line) => with_served_arm(line, |port| measure_both(&built, place, port, count))?,
        });
    }
    Ok(figures)
}

/// Paths of the C program and of the library that it loads.
struct CProgram {
    program: String,
    library: String,
}

fn build(root: &Path) -> Result<CProgram, Box<dyn Error>> {
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let words = [
        "build",
        "--quiet",
        "--release",
        "--package",
        "magician-capi-v1",
    ];
    run_command(Command::new(cargo).current_dir(root).args(words))?;
    // Beside this program, wherever that was built.
    let here = env::current_exe()?;
    let folder = here.parent().ok_or("a folder of built programs")?;
    let include = folder.join("vendor-include");
    library::write_headers(&include)?;
    let program = folder.join("vendor-rate");
    run_command(
        Command::new("cc")
            .args(["-O2", "-DFAMILY=1", "-I"])
            .arg(include.join("v1"))
            .arg(root.join("interop/vendor/rate.c"))
            .arg("-o")
            .arg(&program)
            .arg("-ldl"),
    )?;
    let library = format!(
        "{}dobotdll_v1{}",
        env::consts::DLL_PREFIX,
        env::consts::DLL_SUFFIX
    );
    Ok(CProgram {
        program: program.display().to_string(),
        library: folder.join(library).display().to_string(),
    })
}

fn run_command(command: &mut Command) -> Result<(), Box<dyn Error>> {
    match command.status()? {
        status if status.success() => Ok(()),
        status => Err(format!("{command:?} ended with {status}").into()),
    }
}

/// Runs both alternately at the same arm.
fn measure_both(
    built: &CProgram,
    place: &str,
    port: &str,
    count: usize,
) -> Result<Vec<Figure>, Box<dyn Error>> {
    let mut child = Command::new(&built.program)
        .args([&built.library, port, &count.to_string(), &count.to_string()])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()?;
    let mut ask = child.stdin.take().ok_or("a way in")?;
    let mut told = BufReader::new(child.stdout.take().ok_or("a way out")?);
    let target: Target = port.parse()?;
    let mut figures = Vec::new();
    for (call, letter) in [("GetPose", "g"), ("SetPTPCmd, queued", "m")] {
        let (mut ours, mut theirs) = (Vec::new(), Vec::new());
        for _ in 0..BATCHES {
            writeln!(ask, "{letter}")?;
            let mut line = String::new();
            told.read_line(&mut line)?;
            theirs.push(count as f64 / line.trim().parse::<f64>()?);
            ours.push(count as f64 / driver_batch(&target, letter, count)?);
        }
        let (driver, door) = (median(ours), median(theirs));
        figures.push(
            Figure::new(format!("{call}, {place}"), door, "calls/s")
                .with("the driver's", driver)
                .with("ratio", door / driver),
        );
    }
    drop(ask);
    child.wait()?;
    Ok(figures)
}

/// Returns the duration of a batch through the driver, s.
fn driver_batch(target: &Target, letter: &str, count: usize) -> Result<f64, Box<dyn Error>> {
    let arm = Arm::connect(target)?;
    arm.set(&QueuedCmdStartExec {})?;
    let lot = |count: usize| -> Result<(), Box<dyn Error>> {
        for at in 0..count {
            if letter == "g" {
                arm.get::<Pose>()?;
            } else {
                let y = if at % 2 == 1 { 1.0 } else { -1.0 };
                let ptp_mode = PtpMode::MovlXyz;
                let (x, z, r) = (200.0, 50.0, 0.0);
                arm.enqueue(&PtpCmd {
                    ptp_mode,
                    x,
                    y,
                    z,
                    r,
                })?;
            }
        }
        Ok(())
    };
    lot(10)?;
    let began = Instant::now();
    lot(count)?;
    let took = began.elapsed().as_secs_f64();
    arm.detach();
    arm.close();
    Ok(took)
}

fn median(mut rates: Vec<f64>) -> f64 {
    rates.sort_by(f64::total_cmp);
    rates.get(rates.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Serves a virtual arm behind a pseudo-terminal while `talk` runs.
fn with_served_arm<T>(
    line: LineTiming,
    talk: impl FnOnce(&str) -> Result<T, Box<dyn Error>>,
) -> Result<T, Box<dyn Error>> {
    let folder = env::temp_dir().join(format!("magician-door-{}", process::id()));
    fs::create_dir_all(&folder)?;
    let path = folder.join("arm");
    let port = path.display().to_string();
    let (ready, is_ready) = channel();
    let (stop, stopped) = oneshot::channel::<()>();
    let server = thread::spawn(move || {
        let server = Server::new(Controller::default())
            .speed(Speed::Max)
            .line(line)
            .pty(path)
            .on_ready(move |_| {
                let _ = ready.send(());
            });
        let runtime = Builder::new_current_thread().enable_all().build();
        let runtime = runtime.map_err(|error| error.to_string())?;
        let serve = server.serve_until(async {
            let _ = stopped.await;
        });
        runtime.block_on(serve).map_err(|error| error.to_string())
    });
    let told = match is_ready.recv() {
        Ok(()) => talk(&port),
        // The thread ended before the arm was ready, and reports the reason.
        Err(_) => Err("the arm is not served".into()),
    };
    drop(stop);
    server
        .join()
        .map_err(|_| "the server's thread has ended")??;
    fs::remove_dir_all(&folder)?;
    told
}
