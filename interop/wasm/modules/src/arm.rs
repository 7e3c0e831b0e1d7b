//! Driver with a virtual arm in the same process.

use magician::commands::Pose;
use magician::{Arm, Result, Set, Target};
use magician_protocol::{Deframer, Event};

/// Sends the given frames as commands. Returns 0, with the arm's position as output; 1 if there is
/// no runtime; or 2, with the error as output.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn perform() -> u32 {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_time()
        .build();
    let Ok(runtime) = runtime else {
        return 1;
    };
    match runtime.block_on(run_frames(&crate::take_input())) {
        Ok(Pose { x, y, z, r, .. }) => {
            for value in [x, y, z, r] {
                crate::set_output(&value.to_le_bytes());
            }
            0
        }
        Err(error) => {
            crate::set_output(error.to_string().as_bytes());
            2
        }
    }
}

async fn run_frames(bytes: &[u8]) -> Result<Pose> {
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
