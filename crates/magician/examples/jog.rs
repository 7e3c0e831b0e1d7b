//! Turns the base while a key is held: Enter, whose repeats every terminal sends.
//!
//! `cargo run -p magician --example jog -- PORT`. If stdin is not a terminal, the key counts as
//! held for ten readings. The arm moves: keep clear of it.

use std::io::{IsTerminal, stdin};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use magician::build::Axis;
use magician::{JogOptions, blocking::Arm};

/// Longest time between two repeats of a held key.
const REPEAT: Duration = Duration::from_millis(600);

/// Returns a function that reports if the key is held; it is called once per reading.
fn key() -> impl FnMut() -> bool {
    let pressed = Arc::new(Mutex::new(Instant::now()));
    let terminal = stdin().is_terminal();
    if terminal {
        println!("hold Enter");
        stdin().read_line(&mut String::new()).ok();
        *pressed.lock().unwrap() = Instant::now();
        let pressed = Arc::clone(&pressed);
        thread::spawn(move || {
            for _ in stdin().lines() {
                *pressed.lock().unwrap() = Instant::now();
            }
        });
    }
    let mut ticks = 10;
    move || {
        if terminal {
            pressed.lock().unwrap().elapsed() < REPEAT
        } else {
            ticks -= 1;
            ticks >= 0
        }
    }
}

fn main() -> magician::Result<()> {
    let port = std::env::args().nth(1).unwrap_or_else(|| "sim".to_owned());
    let arm = Arm::connect(port)?;
    let mut state = arm.state(20.0)?;
    let mut held = key();

    let jog = arm.jog_with(Axis::J1.plus(), JogOptions::default().ratio(20.0))?;
    while held() {
        jog.keep()?; // without this the arm stops by itself after 0.3 s
        println!("J1 at {:.1} deg", state.changed()?.pose.joint_angle[0]);
    }
    jog.stop()?;
    println!("stands at {:.1} deg", arm.pose()?.joint_angle[0]);
    Ok(())
}
