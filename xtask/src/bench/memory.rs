//! S4: memory of an idle arm.

use std::error::Error;
use std::net::UdpSocket;
use std::time::Duration;

use magician_protocol::{Ctrl, FrameBuf};
use magician_sim::{ArmInstant, Controller, LineTiming};

use super::figure::Figure;
use super::many_arms::with_served_arms;
use super::program::{USB, send};

/// Number of arms over which memory is averaged, because resident memory grows by whole pages.
const ARMS: usize = 1_000;

/// Returns the resident memory of this process, KiB.
fn resident() -> Result<f64, Box<dyn Error>> {
    let status = std::fs::read_to_string("/proc/self/status")
        .map_err(|error| format!("only Linux reports resident memory: {error}"))?;
    let line = (status.lines()).find_map(|line| line.strip_prefix("VmRSS:"));
    let number = line.and_then(|rest| rest.split_whitespace().next());
    Ok(number.ok_or("no VmRSS")?.parse()?)
}

/// Measures S4: the growth of resident memory by a thousand arms, each of which has answered one
/// request.
pub(super) fn measure() -> Result<Vec<Figure>, Box<dyn Error>> {
    let request = FrameBuf::new(10, Ctrl::GET, &[])?;
    let before = resident()?;
    let mut arms: Vec<Controller> = Vec::with_capacity(ARMS);
    for _ in 0..ARMS {
        let mut arm = Controller::default();
        send(&mut arm, &request);
        arms.push(arm);
    }
    let without_socket = (resident()? - before) / ARMS as f64;
    assert!(arms.iter().all(|arm| arm.state().events_lost == 0
        && arm.poll_timeout().is_none()
        && arm.now() == ArmInstant::ZERO));
    drop(std::hint::black_box((arms, USB)));
    let before = resident()?;
    let with_socket = with_served_arms(ARMS, LineTiming::default(), |addresses| {
        let host = UdpSocket::bind("127.0.0.1:0")?;
        // Fails instead of hanging if an arm does not answer.
        host.set_read_timeout(Some(Duration::from_secs(5)))?;
        for arm in addresses {
            host.send_to(request.bytes(), arm)?;
            host.recv_from(&mut [0; 512])?;
        }
        Ok((resident()? - before) / ARMS as f64)
    })?;
    Ok(vec![
        Figure::new("S4 an idle arm", without_socket, "KiB").at_most(16.0),
        Figure::new("S4 with its task and socket", with_socket, "KiB").at_most(64.0),
    ])
}
