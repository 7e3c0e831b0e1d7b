//! Single commands, and their errors.

use std::time::Duration;

use magician::commands::{AlarmsState, DeviceName, Pose, WaitCmd};
use magician::protocol::{FrameBuf, Layout, Text};
use magician::sim::Speed;
use magician::{Arm, Ctrl, ErrorKind, Options, build};
use tokio::io::{AsyncWriteExt, duplex};
use tokio::time::Instant;

use crate::bench::{fast, next_request, pose_at, real_time, runner};

#[tokio::test(start_paused = true)]
async fn the_three_verbs() {
    let arm = fast().await;
    let name = DeviceName {
        device_name: Text::new("arm of the test").unwrap(),
    };
    arm.set(&name).await.unwrap();
    let read: DeviceName = arm.get().await.unwrap();
    assert_eq!(read.device_name.as_str(), Ok("arm of the test"));
    let first = arm.enqueue(&WaitCmd { timeout: 5 }).await.unwrap();
    let second = arm.enqueue(&WaitCmd { timeout: 5 }).await.unwrap();
    assert_eq!((first.0, second.0), (2, 3));
    let raw = arm.raw(10, Ctrl::GET, &[]).await.unwrap();
    assert!(Pose::decode(raw.frame().params()).is_ok());
    arm.detach();
}

#[tokio::test(start_paused = true)]
async fn a_form_is_queued_as_it_is_given() {
    let (near, mut far) = duplex(4096);
    let options = Options::default().probe(false);
    let arm = Arm::over(near, options).await.unwrap();
    // A segment without its last value.
    let short = [&[1][..], &200_f32.to_le_bytes(), &[0; 9]].concat();
    let (error, unknown, unqueued) = (
        arm.enqueue_form(91, &short[..5]).await.unwrap_err(),
        arm.enqueue_form(250, &[]).await.unwrap_err(),
        arm.enqueue_form(240, &[]).await.unwrap_err(),
    );
    assert_eq!(error.kind(), ErrorKind::Unexpected, "{error}");
    assert_eq!(unknown.kind(), ErrorKind::Unexpected, "{unknown}");
    assert_eq!(unqueued.kind(), ErrorKind::InvalidInput, "{unqueued}");
    let queue = arm.enqueue_form(91, &short);
    let answer = async {
        let room = next_request(&mut far).await;
        assert_eq!(room.frame().id(), 247);
        let left = FrameBuf::new(247, Ctrl::GET, &32_u32.to_le_bytes()).unwrap();
        far.write_all(left.bytes()).await.unwrap();
        let segment = next_request(&mut far).await;
        assert_eq!(segment.frame().params(), short);
        let index = FrameBuf::new(91, Ctrl::QUEUED, &7_u64.to_le_bytes()).unwrap();
        far.write_all(index.bytes()).await.unwrap();
    };
    let (index, ()) = tokio::join!(queue, answer);
    assert_eq!(index.unwrap().0, 7);
    arm.detach();
}

#[tokio::test(start_paused = true)]
async fn moves_in_the_time_it_takes_and_arrives_exactly() {
    let arm = real_time().await;
    let begun = Instant::now();
    let ran = arm
        .run(&[build::line_to(259.104, 100.0, -8.485, 0.0)])
        .await
        .unwrap();
    assert_eq!(ran.commands, 1);
    // 100 mm at the power-up speeds and half ratio take 2.000 s.
    let took = begun.elapsed();
    assert!(
        took >= Duration::from_secs(2) && took < Duration::from_millis(2200),
        "{took:?}"
    );
    let pose: Pose = arm.get().await.unwrap();
    assert_eq!((pose.x, pose.y, pose.z), (259.104, 100.0, -8.485));
}

#[tokio::test(start_paused = true)]
async fn homes_and_clears_the_reset_alarm() {
    let arm = real_time().await;
    assert!(arm.alarms().await.unwrap().contains(0));
    arm.home().await.unwrap();
    assert!(arm.alarms().await.unwrap().is_empty());
}

#[tokio::test(start_paused = true)]
async fn a_full_queue_that_does_not_run_is_an_error_of_its_own() {
    let arm = fast().await;
    for _ in 0..32 {
        arm.enqueue(&WaitCmd { timeout: 1 }).await.unwrap();
    }
    let error = arm.enqueue(&WaitCmd { timeout: 1 }).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::QueueFull);
    assert_eq!(error.command(), Some("SetWAITCmd"));
}

#[tokio::test(start_paused = true)]
async fn a_call_that_is_given_up_is_withdrawn_and_leaves_no_wrong_count() {
    let (near, mut far) = duplex(1 << 16);
    let arm = Arm::over(near, Options::default().probe(false))
        .await
        .unwrap();
    // The first is sent, the second waits behind it; both callers have gone.
    let first = arm.get::<AlarmsState>();
    let second = arm.get::<DeviceName>();
    let both = async { tokio::join!(first, second) };
    assert!(
        tokio::time::timeout(Duration::from_millis(20), both)
            .await
            .is_err()
    );
    assert_eq!(next_request(&mut far).await.frame().id(), 20);
    let alarms = FrameBuf::new(20, Ctrl::GET, &[0; 16]).unwrap();
    far.write_all(alarms.bytes()).await.unwrap();
    let third = tokio::spawn(async move { arm.get::<Pose>().await.map(|_| arm) });
    assert_eq!(
        next_request(&mut far).await.frame().id(),
        10,
        "the second was withdrawn"
    );
    let pose = FrameBuf::encode(10, Ctrl::GET, &pose_at(0.0)).unwrap();
    far.write_all(pose.bytes()).await.unwrap();
    third.await.unwrap().unwrap().detach();
}

#[tokio::test(start_paused = true)]
async fn any_timeout_can_be_asked_for() {
    let options = Options::default().timeout(Duration::MAX);
    let arm = Arm::simulated(runner(Speed::Max), options).await.unwrap();
    arm.start([build::wait(Duration::from_millis(1))])
        .wait(|_| {})
        .await
        .unwrap();
}
