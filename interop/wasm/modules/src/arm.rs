//! The driver's handle on a virtual arm in this process.

use magician::commands::Pose;
use magician::{Arm, Result, Set, Target};
use magician_protocol::{Deframer, Event};

/// Performs the frames that were given; 0 if the arm did. What was made is where it stands, or why not.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn perform() -> u32 {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_time()
        .build();
    let Ok(runtime) = runtime else {
        return 1;
    };
    match runtime.block_on(performed(&crate::given())) {
        Ok(Pose { x, y, z, r, .. }) => {
            for value in [x, y, z, r] {
                crate::made(&value.to_le_bytes());
            }
            0
        }
        Err(error) => {
            crate::made(error.to_string().as_bytes());
            2
        }
    }
}

async fn performed(bytes: &[u8]) -> Result<Pose> {
    let mut commands = Vec::new();
    let mut frames = Deframer::new();
    let mut input = bytes;
    while let Some(event) = frames.next(&mut input) {
        if let Event::Frame { frame, .. } = event {
            commands.push(Set::decode(frame.id(), frame.params())?);
        }
    }
    let target: Target = "sim".parse()?;
    let arm = Arm::connect(&target).await?;
    arm.run(&commands).await?;
    let pose = arm.get::<Pose>().await?;
    arm.close().await;
    Ok(pose)
}
