//! Prints the identity, pose and state of an arm. Nothing moves.
//!
//! `cargo run -p magician --example pose -- PORT`, where PORT is `sim`, `/dev/ttyUSB0`, `COM3` or
//! `udp:192.168.1.5`.

use magician::blocking::Arm;
use magician::commands::{DeviceName, DeviceVersion};

fn main() -> magician::Result<()> {
    let port = std::env::args().nth(1).unwrap_or_else(|| "sim".to_owned());
    let arm = Arm::connect(port)?;

    let version = arm.get::<DeviceVersion>()?;
    let name = arm.get::<DeviceName>()?.device_name;
    println!(
        "{}: firmware {}.{}.{}, name '{name}'",
        arm.name(),
        version.major_version,
        version.minor_version,
        version.revision
    );

    let pose = arm.pose()?;
    println!(
        "tip     x {:.1}  y {:.1}  z {:.1} mm  r {:.1} deg",
        pose.x, pose.y, pose.z, pose.r
    );
    let [j1, j2, j3, j4] = pose.joint_angle;
    println!("joints  {j1:.1}  {j2:.1}  {j3:.1}  {j4:.1} deg");
    println!("alarms  {}", arm.alarms()?);
    println!("queue   {} places free", arm.queue().left_space()?);
    Ok(())
}
