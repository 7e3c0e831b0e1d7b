//! The end of a station: holders are notified and end their runs; the station ends the rest.

use std::time::Duration;

use magician_station::EndReport;
use serde_json::{Value, json};
use tokio::time::Instant;

use crate::bench::{LocalStation, Tester};

/// Creates a session that holds the arm, which moves slowly with more commands in its queue.
async fn holder(bench: &LocalStation, name: &str) -> (Tester, Value) {
    let mut anna = bench.join(name).await;
    let lease = anna.lease().await;
    let slow = json!({"command": "PTPCommonParams", "fields": {"velocity_ratio": 5, "acceleration_ratio": 50}});
    anna.ok("arm.set", slow).await;
    for y in [150, -150] {
        let to = json!({"to": [200, y, 50, 0], "wait": false});
        anna.ok("arm.move", to).await;
    }
    anna.listen(Duration::from_millis(500)).await;
    assert!(bench.arms[0].state().moving);
    (anna, lease)
}

fn stands(bench: &LocalStation) -> bool {
    let state = bench.arms[0].state();
    !state.moving && state.queue.waiting == 0
}

#[tokio::test(start_paused = true)]
async fn holder_finishes_its_stop_before_the_station_ends() {
    let bench = LocalStation::new(1).await;
    let (mut anna, lease) = holder(&bench, "Anna").await;
    let mut ben = bench.join("Ben").await;
    let ending = tokio::spawn({
        let station = bench.station.clone();
        async move { station.end_runs().await }
    });
    anna.listen(Duration::from_millis(20)).await;
    assert_eq!(*anna.noticed("server.ending")[0], json!({"left_s": 5.0}));
    assert!(bench.arms[0].state().moving, "the holder has its time");
    anna.ok("arm.stop", json!({})).await;
    let stood = bench.arms[0].state().pose;
    let lift = json!({"to": [0, 0, 10, 0], "by": "linear", "relative": true});
    anna.ok("arm.move", lift).await;
    assert!((bench.arms[0].state().pose.z - stood.z - 10.0).abs() < 0.1);
    assert!(!ending.is_finished());
    ben.listen(Duration::from_millis(1)).await;
    assert_eq!(
        ben.noticed("server.ending").len(),
        1,
        "viewers hear of it too"
    );
    anna.ok("lease.release", json!({"lease": lease})).await;
    assert_eq!(ending.await.unwrap(), EndReport::default());
    assert!(stands(&bench));
}

#[tokio::test(start_paused = true)]
async fn holder_without_a_stop_in_1_s_is_evicted() {
    let bench = LocalStation::new(1).await;
    let (mut anna, _) = holder(&bench, "Anna").await;
    let began = Instant::now();
    let forced_stops = bench.station.end_runs().await.forced_stops;
    assert_eq!(began.elapsed().as_secs(), 1);
    assert_eq!(
        (
            forced_stops.len(),
            &*forced_stops[0].arm,
            &*forced_stops[0].holder
        ),
        (1, "arm", "Anna")
    );
    let refused = anna.call("arm.home", json!({})).await.unwrap_err();
    assert_eq!(refused["message"], "the station ends");
    anna.listen(Duration::from_secs(1)).await;
    assert!(stands(&bench));
}

#[tokio::test(start_paused = true)]
async fn stopped_silent_holder_is_done() {
    let bench = LocalStation::new(1).await;
    let (mut anna, _) = holder(&bench, "Anna").await;
    let began = Instant::now();
    let (ended, ()) = tokio::join!(bench.station.end_runs(), async {
        anna.listen(Duration::from_millis(20)).await;
        anna.ok("arm.stop", json!({})).await;
    });
    assert_eq!(ended.forced_stops, []);
    assert!(
        began.elapsed() < Duration::from_secs(3),
        "{:?}",
        began.elapsed()
    );
}

#[tokio::test(start_paused = true)]
async fn holder_has_at_most_5_s_and_none_after_a_second_call() {
    for again in [false, true] {
        let bench = LocalStation::new(1).await;
        let (mut anna, _) = holder(&bench, "Anna").await;
        let began = Instant::now();
        let busy = async {
            anna.listen(Duration::from_millis(20)).await;
            anna.ok("arm.stop", json!({})).await;
            loop {
                let up = json!({"to": [0, 0, 0.1, 0], "relative": true});
                if anna.call("arm.move", up).await.is_err() {
                    break;
                }
            }
        };
        let ends = async {
            if again {
                tokio::select! {
                    _ = bench.station.end_runs() => panic!("it waits"),
                    () = tokio::time::sleep(Duration::from_secs(2)) => {}
                }
            }
            bench.station.end_runs().await
        };
        let ((), _) = tokio::join!(busy, ends);
        let expected = if again { 2 } else { 5 };
        assert_eq!(began.elapsed().as_secs(), expected, "{again}");
    }
}

/// Time of the stops at the end: two in a row, each until three poses 25 ms apart are equal, plus
/// 30 ms for all replies.
const STOPS: Duration = Duration::from_millis(2 * 2 * 25 + 30);

#[tokio::test(start_paused = true)]
async fn unreachable_holder_is_not_waited_for() {
    let bench = LocalStation::new(1).await;
    let (anna, _) = holder(&bench, "Anna").await;
    drop(anna);
    let began = Instant::now();
    assert_eq!(bench.station.end_runs().await.forced_stops.len(), 1);
    assert!(began.elapsed() < STOPS);

    // The same if its socket was still open when the end began.
    let bench = LocalStation::new(1).await;
    let (anna, _) = holder(&bench, "Anna").await;
    let began = Instant::now();
    let (ended, ()) = tokio::join!(bench.station.end_runs(), async {
        tokio::time::sleep(Duration::from_millis(300)).await;
        drop(anna);
    });
    assert_eq!(ended.forced_stops.len(), 1);
    assert!(began.elapsed() < Duration::from_millis(300) + STOPS);

    // A request by POST receives no notification.
    let bench = LocalStation::new(1).await;
    let began = Instant::now();
    let (answer, ended) = tokio::join!(bench.once("arm.home", json!({})), async {
        tokio::time::sleep(Duration::from_millis(300)).await;
        bench.station.end_runs().await
    });
    assert_eq!(answer["error"]["message"], "the station ends");
    assert_eq!(ended.forced_stops, []);
    assert!(began.elapsed() < Duration::from_millis(300) + STOPS);
}

#[tokio::test(start_paused = true)]
async fn ending_station_starts_nothing() {
    let bench = LocalStation::new(1).await;
    let (mut anna, _) = holder(&bench, "Anna").await;
    let mut ben = bench.join("Ben").await;
    let waits = ben.send("lease.acquire", json!({"wait_s": 60}));
    ben.listen(Duration::from_millis(10)).await;
    let ending = tokio::spawn({
        let station = bench.station.clone();
        async move { station.end_runs().await }
    });
    let denied = ben.answer(waits).await.unwrap_err();
    assert_eq!(
        (&denied["code"], &denied["message"]),
        (&json!(-32007), &json!("the station ends"))
    );
    assert_eq!(ben.code("lease.acquire", json!({})).await, -32007);
    assert_eq!(ben.code("lease.ask", json!({})).await, -32007);
    anna.ok("arm.stop", json!({})).await;
    assert_eq!(anna.code("jog.start", json!({"axis": "x+"})).await, -32007);
    let plan =
        json!({"format": "magician-plan", "version": 1, "steps": [{"move": [220, 0, 20, 0]}]});
    let job = json!({"text": plan.to_string()});
    assert_eq!(anna.code("job.start", job).await, -32007);
    let posted = bench.once("arm.move", json!({"to": [220, 0, 20, 0]})).await;
    assert_eq!(posted["error"]["code"], -32007, "{posted}");
    // A client that connects now is notified as well.
    let mut carl = bench.join("Carl").await;
    carl.listen(Duration::from_millis(10)).await;
    assert_eq!(carl.noticed("server.ending").len(), 1);
    ending.await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn jog_ends_when_the_station_starts_to_end() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    anna.ok("jog.start", json!({"axis": "y+", "keep_ms": 1000}))
        .await;
    anna.listen(Duration::from_millis(300)).await;
    assert!(bench.arms[0].state().moving);
    let (_, ()) = tokio::join!(bench.station.end_runs(), async {
        anna.listen(Duration::from_millis(900)).await;
        assert_eq!(anna.noticed("jog.ended")[0]["why"], "stopped");
        assert!(stands(&bench));
    });
}

/// Calls of a drawing client at the start of a job, in order.
fn start_of_a_job() -> Vec<(&'static str, Value)> {
    let set = |command: &str| json!({"command": command, "fields": {}});
    let fields = json!({"velocity_ratio": 30, "acceleration_ratio": 30});
    let mut calls = vec![
        ("lease.acquire", json!({})),
        (
            "arm.set",
            json!({"command": "PTPCommonParams", "fields": fields}),
        ),
        ("arm.set", set("QueuedCmdStopExec")),
    ];
    for y in [150, -150, 100, -100] {
        let fields = json!({"ptp_mode": "MOVL_XYZ", "x": 200, "y": y, "z": 50, "r": 0});
        calls.push((
            "arm.enqueue",
            json!({"command": "PTPCmd", "fields": fields}),
        ));
    }
    calls.push(("arm.set", set("QueuedCmdStartExec")));
    for y in [50, -50] {
        let to = json!({"to": [200, y, 50, 0], "wait": false});
        calls.push(("arm.move", to));
    }
    calls
}

/// A client suspended by the system neither reads nor answers, but what it has sent is still in
/// flight.
#[tokio::test(start_paused = true)]
async fn ended_station_leaves_an_empty_queue() {
    let calls = start_of_a_job();
    for sent in 0..=calls.len() {
        for (answered, late) in [(false, 0), (true, 0), (true, 3), (true, 40), (false, 990)] {
            let bench = LocalStation::new(1).await;
            let mut anna = bench.join("Anna").await;
            for (method, params) in &calls[..sent] {
                let call = anna.send(method, params.clone());
                if answered {
                    anna.answer(call).await.unwrap();
                }
            }
            let in_flight = async {
                tokio::time::sleep(Duration::from_millis(late)).await;
                for (method, params) in &calls[sent..] {
                    anna.send(method, params.clone());
                }
            };
            let (ended, ()) = tokio::join!(bench.station.end_runs(), in_flight);
            let what = format!("{sent} {answered} {late}");
            assert_eq!(ended.unconfirmed, [], "{what}");
            assert!(stands(&bench), "{what}");
            for (method, params) in &calls {
                anna.send(method, params.clone());
            }
            anna.listen(Duration::from_secs(1)).await;
            assert!(stands(&bench), "{what}");
        }
    }
}
