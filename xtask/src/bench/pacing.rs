//! S6: accuracy of the virtual line's timing at 115,200 baud.

use std::error::Error;
use std::net::UdpSocket;
use std::time::{Duration, Instant};

use magician_protocol::{BAUD_RATE, Ctrl, FrameBuf};
use magician_sim::{Controller, HostInstant, LineTiming, Runner, Speed};

use super::figure::Figure;
use super::many_arms::with_served_arms;
use super::program::USB;

const LINE: LineTiming = LineTiming {
    baud: Some(BAUD_RATE),
    turnaround: Duration::ZERO,
};
/// Duration of a GetPose exchange with ten bits per byte, s.
const EXCHANGE: f64 = (6.0 + 38.0) * 10.0 / BAUD_RATE as f64;
/// Number of exchanges in a row. A choice: 3.8 s of line time.
const EXCHANGES: u32 = 1_000;

/// Measures S6: consecutive GetPose exchanges, in the arm's time and over a socket in real time.
pub(super) fn measure() -> Result<Vec<Figure>, Box<dyn Error>> {
    let look = FrameBuf::new(10, Ctrl::GET, &[])?;
    let mut runner = Runner::new(Controller::default(), Speed::default(), LINE);
    let mut now = HostInstant::ZERO;
    for _ in 0..EXCHANGES {
        runner.receive(now, USB, look.bytes());
        while runner.poll_transmit(now, USB).is_none() {
            now = runner.poll_timeout().ok_or("a reply is due")?;
            runner.handle_timeout(now);
        }
    }
    let in_theory = (now - HostInstant::ZERO).as_secs_f64();
    let real = with_served_arms(1, LINE, |addresses| {
        let host = UdpSocket::bind("127.0.0.1:0")?;
        // Fails instead of hanging if the arm does not answer.
        host.set_read_timeout(Some(Duration::from_secs(5)))?;
        host.connect(addresses)?;
        let mut times = Vec::new();
        for _ in 0..EXCHANGES {
            let began = Instant::now();
            host.send(look.bytes())?;
            host.recv(&mut [0; 512])?;
            times.push(began.elapsed().as_secs_f64());
        }
        Ok(times)
    })?;
    let mean = |times: &[f64]| times.iter().sum::<f64>() / times.len() as f64;
    let mut sorted = real.clone();
    sorted.sort_by(f64::total_cmp);
    let median = sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN);
    let error = |took: f64| 100.0 * (took / EXCHANGE - 1.0);
    let figure = |name: &str, took: f64| {
        Figure::new(name, error(took).abs(), "% off 115200 baud")
            .with("exchanges/s", 1.0 / took)
            .at_most(2.0)
    };
    // A preempted process is late, so the median describes the line better than the mean.
    Ok(vec![
        figure("S6 in virtual time", in_theory / f64::from(EXCHANGES)),
        figure("S6 over UDP in real time, median", median).with("mean, %", error(mean(&real))),
    ])
}
