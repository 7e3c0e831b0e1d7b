//! Test arms, and the far end of the line to one.

use std::io;
use std::time::Duration;

use magician::commands::Pose;
use magician::protocol::FrameBuf;
use magician::sim::{Controller, LineTiming, Profile, Runner, Speed};
use magician::{Arm, Ctrl, Options};
use tokio::io::{AsyncReadExt, DuplexStream};

pub(crate) fn runner(speed: Speed) -> Runner {
    let line = LineTiming {
        baud: Some(115_200),
        turnaround: Duration::from_millis(2),
    };
    Runner::new(Controller::new(Profile::default()), speed, line)
}

/// Returns an arm in real time, on a line with real timing; the test's clock jumps.
pub(crate) async fn real_time() -> Arm {
    Arm::simulated(runner(Speed::Times(1.0)), Options::default())
        .await
        .unwrap()
}

pub(crate) async fn fast() -> Arm {
    Arm::connect("sim").await.unwrap()
}

/// Reads the next request at the far end of a pipe that the test holds.
pub(crate) async fn next_request(far: &mut DuplexStream) -> FrameBuf {
    request(far).await.unwrap()
}

/// Reads the next request; an error at the end of the line.
pub(crate) async fn request(far: &mut DuplexStream) -> io::Result<FrameBuf> {
    let mut head = [0; 3];
    far.read_exact(&mut head).await?;
    let mut rest = vec![0; usize::from(head[2]) + 1];
    far.read_exact(&mut rest).await?;
    Ok(FrameBuf::new(rest[0], Ctrl(rest[1]), &rest[2..rest.len() - 1]).unwrap())
}

pub(crate) fn pose_at(x: f32) -> Pose {
    Pose {
        x,
        y: 0.0,
        z: 0.0,
        r: 0.0,
        joint_angle: [0.0; 4],
    }
}
