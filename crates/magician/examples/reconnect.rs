//! A run that outlives its line: the cable is pulled, and once it is back the run goes on at the very command that the arm did
//! not take.
//!
//! `cargo run -p magician --example reconnect -- PORT`: pull the cable while it runs. With `sim` a fault pulls it, now and
//! then (`faults` is a feature of its own), and it is in again by itself.
//! The arm moves 60 mm backwards from where it stands: keep clear of it.

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
        // A program that draws or carries asks the user here: nothing goes on by itself.
        println!("it is back");
    }
    println!("{} commands done, each of them once", run.ran().commands);
    Ok(())
}
