//! Measurements of a virtual arm on a paced line, in virtual time.

use std::time::Duration;

use magician::{Arm, Options};
use magician_protocol::commands::{CpParams, Pose, QueuedCmdCurrentIndex};
use magician_sim::{Controller, LineTiming, Profile, Runner, Speed};

use super::*;

/// Returns an arm on a line of 115200 baud with a turnaround. It has no 20 ms periods, so the times
/// measured are those of the line.
async fn paced(turnaround: Duration) -> Arm {
    let line = LineTiming {
        baud: Some(115_200),
        turnaround,
    };
    let runner = Runner::new(
        Controller::new(Profile::continuous()),
        Speed::Times(1.0),
        line,
    );
    Arm::simulated(runner, Options::default()).await.unwrap()
}

fn near(found: f64, wanted: f64, share: f64) {
    assert!(
        (found / wanted - 1.0).abs() < share,
        "{found}, not {wanted}"
    );
}

#[tokio::test(start_paused = true)]
async fn a_paced_line_is_found_with_its_turnaround_and_its_rates() {
    let turnaround = Duration::from_millis(2);
    let arm = paced(turnaround).await;
    let mut reported = 0;
    let pose = round_trips::<Pose>(&arm, 50, |done| reported = done)
        .await
        .unwrap();
    let index = round_trips::<QueuedCmdCurrentIndex>(&arm, 50, |_| {})
        .await
        .unwrap();
    assert!(pose.clean() && index.clean());
    assert_eq!((pose.times.count(), reported), (50, 50));
    // The clock of the tests has steps of a millisecond.
    let line = LineSpeed::of(&pose, &index).unwrap();
    assert!(
        line.turnaround.abs_diff(turnaround) <= Duration::from_millis(1),
        "{line:?}"
    );
    let rate = reads::<Pose>(&arm, Duration::from_secs(2)).await.unwrap();
    near(
        rate.per_second(),
        Exchange::POSE.stop_and_wait(turnaround),
        0.2,
    );
}

#[tokio::test(start_paused = true)]
async fn stream_reports_rate_and_fewest_queued_commands() {
    let arm = paced(Duration::ZERO).await;
    let ring = Ring::here(&arm, 0.5, 50.0).await.unwrap();
    arm.set(&ring.speeds()).await.unwrap();
    let load = Load {
        poses: 5.0,
        queue: 10.0,
        pause: Duration::from_millis(20),
    };
    let pause = async |time| tokio::time::sleep(time).await;
    let seen = streamed(&arm, ring, Duration::from_secs(4), load, pause)
        .await
        .unwrap();
    // The arm limits the rate, not the line: segments of half a millimetre at 50 mm/s.
    near(seen.rate.per_second(), ring.segments_per_second(), 0.05);
    assert!(seen.in_a_row && seen.looks > 20, "{seen:?}");
    assert_eq!(seen.dry, 0);
    assert!(seen.fewest.unwrap() > 2, "{seen:?}");
    let speeds = arm.get::<CpParams>().await.unwrap();
    assert_eq!(speeds, ring.speeds());
}

#[tokio::test(start_paused = true)]
async fn a_line_that_is_too_slow_for_the_arm_shows() {
    let arm = paced(Duration::from_millis(4)).await;
    let ring = Ring::here(&arm, 0.05, 100.0).await.unwrap();
    arm.set(&ring.speeds()).await.unwrap();
    let load = Load {
        queue: 20.0,
        ..Load::default()
    };
    let pause = async |_| {};
    let seen = streamed(&arm, ring, Duration::from_secs(3), load, pause)
        .await
        .unwrap();
    assert!(seen.rate.per_second() < 140.0, "{seen:?}");
    assert!(seen.fewest.unwrap() <= 2, "{seen:?}");
}

#[tokio::test(start_paused = true)]
async fn stops_are_timed_on_the_line_and_to_their_answer() {
    let target = "sim:1".parse().unwrap();
    let pose = magician_protocol::Layout::decode(&[0; 32]);
    let pose = Pose {
        x: 200.0,
        ..pose.unwrap()
    };
    let ring = Ring::through(&pose, 0.2, 90.0);
    let seen = stops(&target, Options::default(), false, ring, 3, |_| {})
        .await
        .unwrap();
    assert_eq!((seen.on_the_line.count(), seen.answered.count()), (3, 3));
    assert!(seen.on_the_line.percentile(100) <= seen.answered.percentile(100));
}
