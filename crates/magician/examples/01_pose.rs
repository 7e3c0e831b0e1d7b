//! Where is the arm? First with async, then without.
//!
//! `cargo run -p magician --example 01_pose -- /dev/ttyUSB0` (a virtual arm unless a port is given)

use magician::commands::{DeviceVersion, Pose};
use magician::{Arm, Target, blocking};

async fn with_async(target: &Target) -> magician::Result<()> {
    let arm = Arm::connect(target).await?;
    let version: DeviceVersion = arm.get().await?;
    let pose: Pose = arm.get().await?;
    println!(
        "firmware {}.{}",
        version.major_version, version.minor_version
    );
    println!("x {} y {} z {} r {}", pose.x, pose.y, pose.z, pose.r);
    Ok(())
}

fn without_async(target: &Target) -> magician::Result<()> {
    let arm = blocking::Arm::connect(target)?;
    let pose: Pose = arm.get()?;
    println!("joints {:?}", pose.joint_angle);
    println!("alarms: {}", arm.alarms()?);
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
