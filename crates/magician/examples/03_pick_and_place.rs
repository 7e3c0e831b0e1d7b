//! Carries three parts from left to right with the suction cup, and shows how far it is.
//!
//! `cargo run -p magician --example 03_pick_and_place -- /dev/ttyUSB0` (a virtual arm unless a port
//! is given). The arm moves: keep clear of it, and choose a height that suits your table.

use std::time::Duration;

use magician::{Arm, Set, Target, blocking, words};

const TABLE: f32 = -40.0;

/// One part from here to there.
fn carry(from: [f32; 2], to: [f32; 2]) -> [Set; 6] {
    let breath = Duration::from_millis(300);
    [
        words::jump_to(from[0], from[1], TABLE, 0.0),
        words::suction(true),
        words::wait(breath),
        words::jump_to(to[0], to[1], TABLE, 0.0),
        words::suction(false),
        words::wait(breath),
    ]
}

/// Words are values: the same program for both kinds of handle.
fn program() -> magician::Result<Vec<Set>> {
    let mut all = vec![
        words::tool_named("suction")?,
        words::jump_height(30.0, 100.0),
    ];
    for part in [0.0, 25.0, 50.0] {
        all.extend(carry([200.0 + part, 90.0], [200.0 + part, -90.0]));
    }
    Ok(all)
}

async fn with_async(target: &Target) -> magician::Result<()> {
    let arm = Arm::connect(target).await?;
    let program = program()?;
    let time = arm.preflight().await?.program(&program)?;
    println!("takes {:.1} s", time.as_secs_f64());
    arm.start(program)
        .wait(|progress| println!("{} done", progress.current.0))
        .await?;
    Ok(())
}

fn without_async(target: &Target) -> magician::Result<()> {
    let arm = blocking::Arm::connect(target)?;
    let ran = arm.run(&program()?)?;
    println!("{} commands", ran.commands);
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let port = std::env::args().nth(1).unwrap_or_else(|| "sim".into());
    let target: Target = port.parse()?;
    tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()?
        .block_on(with_async(&target))?;
    without_async(&target)?;
    Ok(())
}
