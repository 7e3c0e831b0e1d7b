//! Reads an infrared sensor and a colour sensor, and waits for a button on a digital input.
//!
//! `cargo run -p magician --example sensor -- PORT`. With `sim` the scenario below surrounds the
//! arm; on a real one connect the infrared sensor to GP4, the colour sensor to GP2, and the button
//! to EIO 19.

use magician::build::{self, Sensed};
use magician::commands::{ColorSensor, IrSwitch};
use magician::protocol::{IoFunction, Port, SensorVersion};
use magician::sim::Scenario;
use magician::{Options, VirtualArm, blocking::Arm};

const CELL: &str = r#"
    table = { height = -60 }
    object = [{ name = "cube", size = [20, 20, 20], at = [200, 100], color = "green" }]
    sensor = [
        { kind = "color", port = "GP2", at = [200, 100, -10] },
        { kind = "infrared", port = "GP4", at = [200, 60, -50], facing = 90 },
    ]
    input = [{ address = 19, level = 0 }, { address = 19, at = 5, level = 1 }]
"#;
const BUTTON: u8 = 19;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let port = std::env::args().nth(1).unwrap_or_else(|| "sim".to_owned());
    let arm = if port == "sim" {
        Arm::simulated(
            VirtualArm::in_scenario(&Scenario::from_toml(CELL)?),
            Options::default(),
        )?
    } else {
        Arm::connect(port)?
    };
    arm.run(&[
        build::color_sensor(Port::Gp2, true, SensorVersion::V2),
        build::infrared(Port::Gp4, true, SensorVersion::V2),
        build::multiplex(BUTTON, IoFunction::DigitalInput),
    ])?;

    let color = arm.get_with::<ColorSensor>(&build::color_at(Port::Gp2))?;
    println!(
        "colour: {:?} (red {}, green {}, blue {})",
        color.sensed(),
        color.r,
        color.g,
        color.b
    );
    let there = arm
        .get_with::<IrSwitch>(&build::infrared_at(Port::Gp4))?
        .sensed();
    println!(
        "infrared: {}",
        if there {
            "object detected"
        } else {
            "no object"
        }
    );

    println!(
        "button: {}",
        if arm.pins().input(BUTTON)? {
            "pressed"
        } else {
            "not pressed"
        }
    );
    println!("press it");
    arm.pins().wait_for_input(BUTTON, true)?;
    println!(
        "button: {}",
        if arm.pins().input(BUTTON)? {
            "pressed"
        } else {
            "not pressed"
        }
    );
    Ok(())
}
