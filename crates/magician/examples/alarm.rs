//! Shows an alarm and how a program recovers: a move out of reach is sent without a check, so that
//! the arm refuses it and stops. The arm moves before and after it: keep clear of it.
//!
//! `cargo run -p magician --example alarm -- PORT`: `sim`, `/dev/ttyUSB0`, `COM3`,
//! `udp:192.168.1.5`.

use magician::{Alarm, ErrorKind, blocking::Arm, build};

fn main() -> magician::Result<()> {
    let port = std::env::args().nth(1).unwrap_or_else(|| "sim".to_owned());
    let arm = Arm::connect(port)?;
    arm.home()?;

    // With the check, nothing is sent and no alarm is raised.
    let too_far = build::move_to(900.0, 0.0, 0.0, 0.0);
    if let Err(error) = arm.run(&[too_far]) {
        println!("refused before it was sent: {error}");
    }

    match arm.start([too_far]).wait(|_| {}) {
        Err(error) if error.kind() == ErrorKind::Alarm => {
            println!("{error}");
            for code in error.alarms().into_iter().flat_map(|alarms| alarms.codes()) {
                match Alarm::with_code(code) {
                    Some(alarm) => println!("{}: {}; {}", alarm.name, alarm.cause, alarm.remedy),
                    None => println!("0x{code:02X}"),
                }
            }
        }
        Err(error) => return Err(error),
        Ok(_) => println!("this arm reaches farther than others"),
    }

    // Commands in the queue would run after the alarm, so they are dropped first.
    arm.stop()?;
    arm.clear_alarms()?;
    println!("alarms: {}", arm.alarms()?);
    arm.move_to(220.0, 0.0, 40.0, 0.0)?;
    println!("{:?}", arm.pose()?);
    Ok(())
}
