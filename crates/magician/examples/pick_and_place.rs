//! Moves three cubes with the suction cup, one by one, into a row.
//!
//! `cargo run -p magician --example pick_and_place -- PORT`: `sim`, `/dev/ttyUSB0`, `COM3`,
//! `udp:192.168.1.5`. The arm moves: keep clear of it, and adapt `PICK` and `PLACE` to your setup.

use std::time::Duration;

use magician::{blocking::Arm, build};

const PICK: [f32; 3] = [220.0, 80.0, -30.0];
const PLACE: [f32; 3] = [220.0, -80.0, -30.0];
const APART: f32 = 30.0;

fn main() -> magician::Result<()> {
    let port = std::env::args().nth(1).unwrap_or_else(|| "sim".to_owned());
    let arm = Arm::connect(port)?;
    arm.home()?;
    arm.run(&[
        build::tool_named("suction")?,
        build::speed(80.0, 80.0),
        build::jump_height(40.0, 120.0),
    ])?;
    let grip = build::wait(Duration::from_millis(300));
    for cube in 0..3 {
        let shift = APART * cube as f32;
        // All commands are checked before the first is sent: a cube out of reach is not even
        // lifted.
        let ran = arm.run(&[
            build::jump_to(PICK[0] + shift, PICK[1], PICK[2], 0.0),
            build::suction(true),
            grip,
            build::jump_to(PLACE[0] + shift, PLACE[1], PLACE[2], 0.0),
            build::suction(false),
            grip,
        ])?;
        println!("cube {}: {} commands", cube + 1, ran.commands);
    }
    arm.run(&[build::line_by(0.0, 0.0, 50.0, 0.0), build::pump_off()])?;
    let pose = arm.pose()?;
    println!("there: x {:.1} y {:.1} z {:.1}", pose.x, pose.y, pose.z);
    Ok(())
}
