//! A program with a test: the test runs it in a simulated world, and checks where the cube ends up.
//!
//! `cargo run -p magician --example scenario -- PORT` runs it,
//! `cargo test -p magician --example scenario` tests it. The arm moves: keep clear of it.

use std::time::Duration;

use magician::{blocking::Arm, build};

/// Stacks the cube at (220, 80) on the block at (220, -80).
fn stack(arm: &Arm) -> magician::Result<()> {
    let breathe = build::wait(Duration::from_millis(500));
    arm.run(&[
        build::tool_named("suction")?,
        build::jump_to(220.0, 80.0, -40.0, 0.0),
        build::suction(true),
        breathe,
        build::jump_to(220.0, -80.0, -10.0, 0.0),
        build::suction(false),
        breathe,
        build::line_by(0.0, 0.0, 40.0, 0.0),
    ])?;
    Ok(())
}

fn main() -> magician::Result<()> {
    let port = std::env::args().nth(1).unwrap_or_else(|| "sim".to_owned());
    let arm = Arm::connect(port)?;
    arm.home()?;
    stack(&arm)?;
    println!("the cube should be on the block now");
    Ok(())
}

#[cfg(test)]
mod tests {
    use magician::sim::Scenario;
    use magician::{Options, VirtualArm, blocking::Arm};

    const CELL: &str = r#"
        arm = { homed = true }
        tool = { kind = "suction" }
        table = { height = -60 }
        object = [
            { name = "cube", size = [20, 20, 20], at = [220, 80] },
            { name = "block", size = [40, 40, 30], at = [220, -80] },
        ]
    "#;

    #[test]
    fn the_cube_ends_on_the_block() -> Result<(), Box<dyn std::error::Error>> {
        let cell = VirtualArm::in_scenario(&Scenario::from_toml(CELL)?);
        let arm = Arm::simulated(cell.clone(), Options::default())?;
        super::stack(&arm)?;
        cell.with(|arm| {
            let look = arm.look();
            assert!(look.object("cube").unwrap().on("block"));
            assert!(look.object("block").unwrap().on_table());
            assert!(look.held().is_none());
        });
        Ok(())
    }
}
