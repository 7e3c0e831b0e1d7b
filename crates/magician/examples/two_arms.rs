//! Moves two arms at once from one task: each waits for the other after every move.
//!
//! `cargo run -p magician --example two_arms -- PORT [PORT]`. Each `sim` is a separate virtual arm.
//! The arms move: keep clear of them.

use magician::{Arm, build};

/// Moves to a position and back; returns the y that was reached.
async fn visit(arm: &Arm, y: f32) -> magician::Result<f32> {
    arm.run(&[
        build::line_to(220.0, y, 20.0, 0.0),
        build::line_by(0.0, 0.0, 30.0, 0.0),
    ])
    .await?;
    Ok(arm.pose().await?.y)
}

#[tokio::main(flavor = "current_thread")]
async fn main() -> magician::Result<()> {
    let mut ports = std::env::args().skip(1);
    let left = ports.next().unwrap_or_else(|| "sim".to_owned());
    let right = ports.next().unwrap_or_else(|| "sim".to_owned());
    let (left, right) = tokio::try_join!(Arm::connect(left), Arm::connect(right))?;

    tokio::try_join!(left.home(), right.home())?;
    for turn in 1..=3 {
        let aside = 20.0 * turn as f32;
        // Returns when both have arrived, or with the first error; the other arm is then stopped by
        // dropping its handle.
        let (a, b) = tokio::try_join!(visit(&left, aside), visit(&right, -aside))?;
        println!("turn {turn}: left at y {a:.1}, right at y {b:.1}");
    }
    Ok(())
}
