//! Stops the arm from another thread, in the middle of an endless program.
//!
//! `cargo run -p magician --example stop -- PORT`. Enter stops it; if stdin is not a terminal, the
//! twentieth command does. The arm moves: keep clear of it.

use std::io::{IsTerminal, stdin};
use std::sync::mpsc;
use std::thread;

use magician::{ErrorCode, blocking::Arm, build};

fn main() -> magician::Result<()> {
    let port = std::env::args().nth(1).unwrap_or_else(|| "sim".to_owned());
    let arm = Arm::connect(port)?;
    arm.home()?;

    let stopper = arm.stopper();
    let (enough, heard) = mpsc::channel();
    let guard = thread::spawn(move || {
        if stdin().is_terminal() {
            println!("press Enter to stop");
            stdin().read_line(&mut String::new()).ok();
        } else {
            heard.recv().ok();
        }
        stopper.stop_blocking()
    });

    let to_and_fro = (0..).map(|turn| {
        let y = if turn % 2 == 0 { 60.0 } else { -60.0 };
        build::line_to(220.0, y, 30.0, 0.0)
    });
    let mut run = arm.start(to_and_fro);
    let ended = run.wait(|progress| {
        if progress.sent >= 20 {
            enough.send(()).ok();
        }
    });
    match ended {
        Err(error) if error.code() == ErrorCode::Stopped => println!("stopped: {error}"),
        Err(error) => return Err(error),
        Ok(_) => println!("it came to its end"),
    }
    guard.join().expect("it does not panic")?;

    // The stop is confirmed, but the arm may still brake.
    arm.wait_still()?;
    let pose = arm.pose()?;
    println!(
        "{} commands done, the arm stands at y {:.1}",
        run.ran().commands,
        pose.y
    );
    Ok(())
}
