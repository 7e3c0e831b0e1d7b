//! Home, and move: there with async, back without.
//!
//! `cargo run -p magician --example 02_move -- /dev/ttyUSB0` (a virtual arm unless a port is given).
//! The arm moves: keep clear of it.

use magician::commands::Pose;
use magician::{Arm, Target, blocking, words};

async fn with_async(target: &Target) -> magician::Result<()> {
    let arm = Arm::connect(target).await?;
    arm.home().await?;
    arm.run(&[
        words::speed(50.0, 50.0),
        words::move_to(200.0, 80.0, 40.0, 0.0),
        words::line_by(0.0, -160.0, 0.0, 0.0),
    ])
    .await?;
    let pose: Pose = arm.get().await?;
    println!("now at {} {} {}", pose.x, pose.y, pose.z);
    Ok(())
}

fn without_async(target: &Target) -> magician::Result<()> {
    let arm = blocking::Arm::connect(target)?;
    arm.run(&[words::move_joints(0.0, 45.0, 45.0, 0.0)])?;
    // A target out of reach is refused before a byte of it is sent.
    if let Err(error) = arm.run(&[words::move_to(500.0, 0.0, 0.0, 0.0)]) {
        println!("as it should be: {error}");
    }
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
