//! Cost of a checked command on the host: one plan and one encoding, and a second plan with a
//! fence. The counters are global to the process, so nothing else is tested here.

use std::sync::atomic::Ordering::Relaxed;

use magician::{Arm, Fence, Options, Set, build};
use magician_host::PLANNED;
use magician_protocol::ENCODED;

/// Returns the plans and encodings of a run.
async fn counted(arm: &Arm, commands: &[Set]) -> [usize; 2] {
    let before = [PLANNED.load(Relaxed), ENCODED.load(Relaxed)];
    let ran = arm.run(commands).await.unwrap();
    assert_eq!(ran.commands, commands.len() as u64);
    [
        PLANNED.load(Relaxed) - before[0],
        ENCODED.load(Relaxed) - before[1],
    ]
}

#[tokio::test]
async fn checked_command_is_planned_and_encoded_once() {
    let there = build::line_to(220.0, 10.0, 20.0, 0.0);
    let corner = |nth: i32| build::path_to(220.0 + (nth % 2) as f32, nth as f32 * 0.1, 20.0);
    let path: Vec<Set> = (0..300).map(corner).collect();
    let fence = Fence::default().with_floor(-60.0).unwrap();
    for (fence, plans) in [(None, 1), (Some(fence), 2)] {
        let arm = Arm::connect_with("sim", Options::default().fence(fence))
            .await
            .unwrap();
        arm.run(&[build::home()]).await.unwrap();
        assert_eq!(counted(&arm, &[there]).await, [plans, 1], "{fence:?}");
        let count = path.len();
        assert_eq!(
            counted(&arm, &path).await,
            [plans * count, count],
            "{fence:?}"
        );
        arm.close().await;
    }
}
