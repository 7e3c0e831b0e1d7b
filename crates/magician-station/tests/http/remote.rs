//! Clients elsewhere: requests, and drivers over a station.

use std::time::Duration;

use magician::build::{self, Axis};
use magician::commands::{Pose, PtpCommonParams};
use magician::{Arm, ErrorKind, Options};
use magician_station::client::{ClientError, Connection, StationClient, StationLine, Trust};
use magician_station::{FRAME_FIELDS, MAX_SOCKETS};
use serde_json::json;

use crate::bench::HttpStation;

async fn client(bench: &HttpStation, name: &str) -> StationClient {
    let address = format!("http://{}", bench.address);
    StationClient::connect(&address, name, None).await.unwrap()
}

/// Creates a driver over the station.
async fn arm(client: &StationClient) -> Arm {
    let (line, _) = StationLine::open(client, None, false);
    Arm::over(line, Options::default().timeout(Duration::from_secs(5)))
        .await
        .unwrap()
}

#[tokio::test]
async fn remote_arm_behaves_like_a_local_one() {
    let bench = HttpStation::new().await;
    let anna = client(&bench, "Anna").await;
    assert_eq!(anna.hello()["role"], json!("teacher"));
    let over = arm(&anna).await;
    let pose = over.get::<Pose>().await.unwrap();
    assert!((pose.x - 259.1).abs() < 0.1);
    let sessions = anna.call("session.list", json!({})).await.unwrap();
    assert_eq!(
        sessions["sessions"][0]["leases"],
        json!([]),
        "who reads needs no lease"
    );
    over.run(&[
        build::line_to(220.0, 40.0, 50.0, 0.0),
        build::jump_to(220.0, 0.0, 50.0, 0.0),
    ])
    .await
    .unwrap();
    let state = bench.arm.state();
    assert!((state.pose.x - 220.0).abs() < 0.1 && state.pose.y.abs() < 0.1);
    let faster = PtpCommonParams {
        velocity_ratio: 33.3,
        acceleration_ratio: 44.4,
    };
    over.set(&faster).await.unwrap();
    assert_eq!(over.get::<PtpCommonParams>().await.unwrap(), faster);
    let refused = over
        .run(&[build::move_to(600.0, 0.0, 0.0, 0.0)])
        .await
        .unwrap_err();
    assert_eq!(refused.kind(), ErrorKind::Unreachable);
}

#[tokio::test]
async fn remote_jog_ends_with_its_client() {
    let bench = HttpStation::new().await;
    let (anna, mut ben) = (client(&bench, "Anna").await, bench.join("Ben").await);
    let over = arm(&anna).await;
    let jog = over.jog(Axis::Y.plus()).await.unwrap();
    let state = ben.until("moving", json!(true)).await;
    assert_eq!(state["link"], json!("up"));
    let told = ben.call("arm.state", json!({})).await.unwrap();
    assert!(told["jog"].is_string(), "{told}");
    jog.stop().await.unwrap();
    assert!(!bench.arm.state().moving);
    let jog = over.jog(Axis::Y.minus()).await.unwrap();
    ben.until("moving", json!(true)).await;
    // The program ends abruptly, without stopping its jog.
    std::mem::forget(jog);
    drop((over, anna));
    ben.until("moving", json!(false)).await;
}

#[tokio::test]
async fn client_without_lease_gets_the_holder_and_may_stop() {
    let bench = HttpStation::new().await;
    let mut ben = bench.join("Ben").await;
    ben.call("lease.acquire", json!({})).await.unwrap();
    let anna = client(&bench, "Anna").await;
    let over = arm(&anna).await;
    over.stop().await.unwrap();
    let refused = over
        .run(&[build::move_to(220.0, 0.0, 50.0, 0.0)])
        .await
        .unwrap_err();
    assert_eq!(refused.kind(), ErrorKind::Port, "{refused:?}");
    let mut chain = refused.to_string();
    let mut source = std::error::Error::source(&refused);
    while let Some(cause) = source {
        chain += &format!("; {cause}");
        source = cause.source();
    }
    assert!(chain.contains("Ben has the lease"), "{chain}");
}

/// Creates a driver over the station whose arm moves slowly in one long run.
async fn running(
    bench: &HttpStation,
    client: &StationClient,
) -> (
    Arm,
    tokio::task::JoinHandle<magician::Result<magician::Ran>>,
) {
    let (line, _) = StationLine::open(client, None, false);
    let options = Options::default().end_notice(client.end_notice());
    let over = Arm::over(line, options).await.unwrap();
    let slow = PtpCommonParams {
        velocity_ratio: 1.0,
        acceleration_ratio: 20.0,
    };
    over.set(&slow).await.unwrap();
    let runner = over.clone();
    // Back and forth, for longer than the station waits.
    let moves = [150.0, -150.0].map(|y| build::move_to(200.0, y, 50.0, 0.0));
    let run = tokio::spawn(async move { runner.run(&moves.repeat(10)).await });
    while !bench.arm.state().moving {
        tokio::task::yield_now().await;
    }
    (over, run)
}

#[tokio::test]
async fn client_notified_of_the_end_stops_its_run_in_time() {
    let bench = HttpStation::new().await;
    let anna = client(&bench, "Anna").await;
    let (over, run) = running(&bench, &anna).await;
    let station = bench.station.clone();
    let ending = tokio::spawn(async move { station.end_runs().await });
    over.front_end().end_notice().given().await;
    over.stop().await.unwrap();
    let stopped = run.await.unwrap().unwrap_err();
    assert_eq!(stopped.kind(), ErrorKind::Closed);
    over.close().await;
    assert_eq!(
        ending.await.unwrap(),
        magician_station::EndReport::default()
    );
}

#[tokio::test]
async fn client_ignoring_the_end_is_stopped_and_gets_the_reason() {
    let bench = HttpStation::new().await;
    let anna = client(&bench, "Anna").await;
    let (over, run) = running(&bench, &anna).await;
    let forced_stops = bench.station.end_runs().await.forced_stops;
    assert_eq!((forced_stops.len(), &*forced_stops[0].holder), (1, "Anna"));
    bench.over.send(true).unwrap();
    let failed = run.await.unwrap().unwrap_err();
    assert_eq!(failed.to_string(), "the station has ended");
    assert_eq!(failed.kind(), ErrorKind::Port);
    let again = anna.call("arm.state", json!({})).await.unwrap_err();
    assert_eq!(again, ClientError::Ended);
    drop(over);
}

#[tokio::test]
async fn lease_is_released_by_its_last_user() {
    let bench = HttpStation::new().await;
    let anna = client(&bench, "Anna").await;
    let granted = anna.lease("lease.acquire", json!({})).await.unwrap();
    let lease = granted["lease"].as_str().unwrap().to_owned();
    let (line, ended) = StationLine::open(&anna, None, false);
    let over = Arm::over(line, Options::default()).await.unwrap();
    let slower = PtpCommonParams {
        velocity_ratio: 20.0,
        acceleration_ratio: 20.0,
    };
    over.set(&slower).await.unwrap();
    over.close().await;
    ended.await.unwrap();
    let renew = json!({"lease": lease});
    anna.call("lease.renew", renew.clone()).await.unwrap();
    anna.release(&lease).await.unwrap();
    let ended = anna.call("lease.renew", renew).await.unwrap_err();
    assert_eq!(ended.kind(), Some("lease"));
}

#[tokio::test]
async fn client_refusals_state_the_cause() {
    let bench = HttpStation::new().await;
    let address = format!("http://{}", bench.address);
    let wrong = StationClient::connect(&address, "x", Some("nonsense"))
        .await
        .unwrap_err();
    assert_eq!(wrong.kind(), Some("forbidden"), "{wrong:?}");
    let nobody = StationClient::connect("http://127.0.0.1:1", "x", None)
        .await
        .unwrap_err();
    assert!(matches!(nobody, ClientError::Unreachable(_)), "{nobody:?}");
    let anna = client(&bench, "Anna").await;
    let unknown = anna.call("arm.dance", json!({})).await.unwrap_err();
    assert!(
        matches!(unknown, ClientError::Refused { code: -32601, .. }),
        "{unknown:?}"
    );
    let mut notices = anna.notices();
    anna.call("lease.acquire", json!({})).await.unwrap();
    while notices.recv().await.unwrap().method != "lease.changed" {}
}

#[tokio::test]
async fn client_reconnects_and_requests_fail_meanwhile() {
    let bench = HttpStation::new().await;
    let anna = client(&bench, "Anna").await;
    let mut connection = anna.connection();
    bench.over.send(true).unwrap();
    connection
        .wait_for(|connection| *connection == Connection::Lost)
        .await
        .unwrap();
    let lost = anna.call("server.info", json!({})).await.unwrap_err();
    assert_eq!(lost, ClientError::Ended);
}

#[tokio::test]
async fn client_receives_binary_frames() {
    let bench = HttpStation::new().await;
    let anna = client(&bench, "Anna").await;
    let mut frames = anna.frames();
    let wanted = json!({"rate": 50, "frame": "binary"});
    let made = anna.call("arm.subscribe", wanted).await.unwrap();
    let first = frames.recv().await.unwrap();
    assert_eq!(json!(first.subscription), made["subscription"]);
    assert_eq!(first.sequence, 0);
    let names: Vec<_> = FRAME_FIELDS.iter().map(|name| json!(name)).collect();
    assert_eq!(made["fields"], json!(names));
    let x = bench.arm.state().pose.x as f32;
    assert_eq!(first.value("x"), Some(f64::from(x)));
    assert!(first.value("rail").unwrap().is_nan());
    assert!(frames.recv().await.unwrap().sequence > 0);
}

#[tokio::test]
async fn sessionless_stop_works_when_all_sessions_are_in_use() {
    let bench = HttpStation::new().await;
    let mut all = Vec::new();
    for _ in 0..MAX_SOCKETS {
        all.push(client(&bench, "Anna").await);
    }
    let address = format!("http://{}", bench.address);
    let beyond = StationClient::connect(&address, "Ben", None)
        .await
        .unwrap_err();
    assert!(matches!(beyond, ClientError::Busy(_)), "{beyond:?}");
    let call = async |method, token| {
        StationClient::call_once(&address, token, &Trust::System, method, json!({})).await
    };
    let stopped = call("arm.stop", None).await.unwrap();
    assert_eq!(stopped["arms"][0]["stood"], json!(true), "{stopped}");
    let unknown = call("arm.dance", None).await.unwrap_err();
    assert!(
        matches!(unknown, ClientError::Refused { code: -32601, .. }),
        "{unknown:?}"
    );
    let wrong = call("arm.stop", Some("nonsense")).await.unwrap_err();
    assert!(matches!(wrong, ClientError::Unreachable(_)), "{wrong:?}");
}
