//! Latency added by the driver: the same exchange with bare system calls and with the driver, over
//! a pseudo-terminal whose other end answers at once.

use std::fs::File;
use std::io::{self, Read, Write};
use std::os::fd::OwnedFd;
use std::thread::JoinHandle;
use std::time::Duration;

use magician::{Arm, Error, Options, Result, Target};
use magician_protocol::commands::Pose;
use magician_protocol::{Deframer, Event, FrameBuf, NoArgs, Readable};
use rustix::fs::{Mode, OFlags};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use tokio::time::Instant;

use crate::Timings;

/// Round trips of GetPose to a bare responder.
#[derive(Clone, Debug, Default)]
pub struct AddedLatency {
    /// Times of a bare write and read.
    pub bare: Timings,
    /// Times with the driver.
    pub driver: Timings,
}

impl AddedLatency {
    /// Returns the latency that the driver adds at a percentile; `None` without measurements.
    #[must_use]
    pub fn at(&self, percent: u8) -> Option<Duration> {
        let (bare, driver) = (
            self.bare.percentile(percent)?,
            self.driver.percentile(percent)?,
        );
        Some(driver.saturating_sub(bare))
    }
}

/// Measures `count` round trips of each kind, in turns. `tick` is called with the number of
/// finished ones.
///
/// # Errors
/// [`ErrorKind::Port`](magician::ErrorKind::Port) if the system provides no pseudo-terminal.
pub async fn added_latency(count: usize, mut tick: impl FnMut(usize)) -> Result<AddedLatency> {
    let failed = |error: io::Error| {
        let message = format!("the system cannot create a pseudo-terminal: {error}");
        Error::port(message, error)
    };
    let (path, keep, responder) = responder().map_err(failed)?;
    let outcome = measure(&path, count, &mut tick).await;
    // The responder reads until the line is closed everywhere.
    drop(keep);
    let _ = responder.join();
    outcome.map_err(|error| match error {
        MeasureError::System(error) => failed(error),
        MeasureError::Driver(error) => error,
    })
}

enum MeasureError {
    System(io::Error),
    Driver(Error),
}

/// Round trips per turn, so that other load of the computer affects both kinds alike. Choice.
const ROUND_TRIPS_PER_TURN: usize = 100;

async fn measure(
    path: &str,
    count: usize,
    tick: &mut impl FnMut(usize),
) -> std::result::Result<AddedLatency, MeasureError> {
    let (mut bare, mut driver) = (Vec::new(), Vec::new());
    while bare.len() < count {
        let turn = ROUND_TRIPS_PER_TURN.min(count - bare.len());
        bare_trips(path, turn, &mut bare).map_err(MeasureError::System)?;
        let target = Target::Serial(path.to_owned());
        // Not probed: the responder is no arm, and its version would not decode.
        let arm = Arm::connect_with(&target, Options::default().probe(false));
        let arm = arm.await.map_err(MeasureError::Driver)?;
        // No stop at the end of each turn, which the responder would have to answer.
        arm.detach();
        for _ in 0..turn {
            let begun = Instant::now();
            arm.get::<Pose>().await.map_err(MeasureError::Driver)?;
            driver.push(begun.elapsed());
        }
        arm.close().await;
        tick(bare.len());
    }
    Ok(AddedLatency {
        bare: Timings::from(bare),
        driver: Timings::from(driver),
    })
}

fn bare_trips(path: &str, count: usize, times: &mut Vec<Duration>) -> io::Result<()> {
    let mut line = open_line(path)?;
    let request = FrameBuf::get(&NoArgs, Pose::ROW).map_err(io::Error::other)?;
    let mut reply = [0; 64];
    for _ in 0..count {
        let begun = Instant::now();
        line.write_all(request.bytes())?;
        let mut seen = 0;
        while seen < usize::try_from(crate::Exchange::POSE.reply).unwrap_or(usize::MAX) {
            match line.read(&mut reply)? {
                0 => return Err(io::ErrorKind::UnexpectedEof.into()),
                some => seen += some,
            }
        }
        times.push(begun.elapsed());
    }
    Ok(())
}

/// Opens a terminal without making it the controlling terminal of this process, because its hangup
/// would then signal the session leader (SIGHUP).
fn open_line(path: &str) -> io::Result<File> {
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
    Ok(File::from(rustix::fs::open(path, flags, Mode::empty())?))
}

/// Creates a pseudo-terminal whose other end answers every request on a thread: returns its path, a
/// descriptor that keeps it open, and the thread.
fn responder() -> io::Result<(String, OwnedFd, JoinHandle<()>)> {
    let server = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
    grantpt(&server)?;
    unlockpt(&server)?;
    let path = ptsname(&server, Vec::new())?.to_string_lossy().into_owned();
    let keep = OwnedFd::from(open_line(&path)?);
    let mut modes = tcgetattr(&keep)?;
    modes.make_raw();
    tcsetattr(&keep, OptionalActions::Now, &modes)?;
    let thread = std::thread::spawn(move || {
        // Ends when the last descriptor of the line is closed.
        let _ = respond(File::from(server));
    });
    Ok((path, keep, thread))
}

fn respond(mut line: File) -> io::Result<()> {
    let mut deframer = Deframer::new();
    let mut bytes = [0; 256];
    loop {
        let count = line.read(&mut bytes)?;
        if count == 0 {
            return Ok(());
        }
        let mut rest = bytes.get(..count).unwrap_or_default();
        while let Some(event) = deframer.next(&mut rest) {
            let Event::Frame { frame, .. } = event else {
                continue;
            };
            // Long enough for any value; readers accept surplus bytes.
            let reply = FrameBuf::new(frame.id(), frame.ctrl(), &[0; 32]);
            line.write_all(reply.map_err(io::Error::other)?.bytes())?;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn both_ways_are_measured_as_often_as_asked() {
        let mut told = 0;
        let added = added_latency(150, |done| told = done).await.unwrap();
        assert_eq!(
            (added.bare.count(), added.driver.count(), told),
            (150, 150, 150)
        );
        assert!(added.at(50).is_some());
    }
}
