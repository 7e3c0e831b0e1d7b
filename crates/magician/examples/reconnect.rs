//! A run that survives a pulled cable: after the reconnect it continues with the first command that
//! the arm did not accept.
//!
//! `cargo run -p magician --example reconnect -- PORT`: pull the cable while it runs. With `sim` an
//! injected fault pulls it now and then (feature `faults`), and plugs it in again. The arm moves 60
//! mm backwards from its position: keep clear of it.

use magician::faults::Faults;
use magician::{ErrorKind, Options, blocking::Arm, build};

fn main() -> magician::Result<()> {
    let port = std::env::args().nth(1).unwrap_or_else(|| "sim".to_owned());
    let faults: Faults = match port.as_str() {
        "sim" => "unplug=0.01,seed=3".parse()?,
        _ => Faults::default(),
    };
    let arm = Arm::connect_with(port, Options::default().faults(faults))?;
    let start = arm.pose()?;

    let path = (1..=300).map(|step| build::path_to(start.x - 0.2 * step as f32, start.y, start.z));
    let mut run = arm.start(path);
    while let Err(error) = run.wait(|_| {}) {
        if error.kind() != ErrorKind::Port || !run.is_interrupted() {
            return Err(error);
        }
        println!("{error}");
        println!(
            "{} commands taken; waiting for the cable",
            run.ran().commands
        );
        arm.reconnected()?;
        // A program that draws or carries asks the user here: nothing continues by itself.
        println!("it is back");
    }
    println!("{} commands done, each of them once", run.ran().commands);
    Ok(())
}
