//! Lines that are silent, foreign, broken or stuck.

use std::time::Duration;

use magician::commands::Pose;
use magician::{Arm, ErrorKind, Options, build};
use tokio::io::{AsyncReadExt, AsyncWriteExt, duplex};
use tokio::time::Instant;

#[tokio::test(start_paused = true)]
async fn a_silent_port_is_said_to_be_silent() {
    let (near, mut far) = duplex(4096);
    let begun = Instant::now();
    let error = Arm::over(near, Options::default()).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Timeout);
    assert!(begun.elapsed() <= Duration::from_millis(3010));
    let message = error.to_string();
    assert!(
        message.contains("GetDeviceVersion") && message.contains("no reply"),
        "{message}"
    );
    let mut heard = Vec::new();
    far.read_to_end(&mut heard).await.unwrap();
    assert!(heard.starts_with(&[0xAA, 0xAA, 0x02, 0x02]));
}

#[tokio::test(start_paused = true)]
async fn a_port_that_talks_nonsense_is_said_to_do_so() {
    let (near, mut far) = duplex(1 << 16);
    let flood = tokio::spawn(async move {
        while far
            .write_all(b"GRBL 1.1\r\nok\r\n\xAA\xAA\xAA")
            .await
            .is_ok()
        {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
    });
    let begun = Instant::now();
    let error = Arm::over(near, Options::default()).await.unwrap_err();
    assert!(begun.elapsed() <= Duration::from_millis(3010));
    assert!(error.to_string().contains("not from this arm"), "{error}");
    flood.abort();
}

#[tokio::test(start_paused = true)]
async fn a_line_that_breaks_ends_every_call() {
    let (near, far) = duplex(4096);
    let options = Options::default().probe(false);
    let arm = Arm::over(near, options).await.unwrap();
    drop(far);
    for _ in 0..3 {
        let error = arm.get::<Pose>().await.unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Port, "{error}");
    }
}

#[tokio::test(start_paused = true)]
async fn a_line_that_takes_no_more_bytes_holds_nobody_up() {
    let (near, _far) = duplex(4);
    let options = Options::default().probe(false);
    let arm = Arm::over(near, options).await.unwrap();
    let begun = Instant::now();
    let error = arm.get::<Pose>().await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Timeout);
    assert!(begun.elapsed() <= Duration::from_millis(3010));
    let _ = arm
        .enqueue_set(&build::move_to(200.0, 0.0, 50.0, 0.0))
        .await;
    let begun = Instant::now();
    arm.close().await;
    assert!(begun.elapsed() <= Duration::from_millis(510));
}

#[tokio::test(start_paused = true)]
async fn a_jog_on_a_line_that_broke_is_given_up_at_once() {
    let (near, far) = duplex(4096);
    let arm = Arm::over(near, Options::default().probe(false))
        .await
        .unwrap();
    drop(far);
    let begun = Instant::now();
    let error = arm.stop_jog().await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Port, "{error}");
    assert!(begun.elapsed() < Duration::from_millis(100));
}

#[cfg(not(feature = "ble"))]
#[tokio::test]
async fn bluetooth_is_a_matter_of_the_build() {
    let error = Arm::connect("ble:Dobot").await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Unsupported);
}
