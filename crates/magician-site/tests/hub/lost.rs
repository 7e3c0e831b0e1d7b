//! Stations, hubs and lines that disappear and come back.

use std::time::Duration;

use serde_json::{Value, json};
use tokio::time::Instant;

use crate::bench::TestHub;

#[tokio::test(start_paused = true)]
async fn station_lost_during_a_move_fails_the_request_without_retransmission() {
    let bench = TestHub::new(3, 1).await;
    let mut anna = bench.join("Anna").await;
    anna.take_arm("arm1").await;
    let moving = anna.send("arm.move", json!({"arm": "arm1", "to": [0, 220, 20, 0]}));
    anna.run_for(Duration::from_millis(200)).await;
    bench.site.cut(2);
    let begun = Instant::now();
    let error = anna.answer(moving).await.unwrap_err();
    assert!(begun.elapsed() < Duration::from_millis(100));
    assert_eq!(
        (&error["code"], &error["data"]["kind"]),
        (&json!(-32000), &json!("port"))
    );
    assert!(
        error["message"]
            .as_str()
            .unwrap()
            .contains("arm1: its station"),
        "{error}"
    );
    // Other stations are not affected.
    anna.ok("arm.state", json!({"arm": "arm0"})).await;
    anna.run_for(Duration::from_secs(10)).await;
    let station = bench.site.station(2);
    let before = station.y("arm1").await;
    bench.site.restore_station(magician_site::StationId(2));
    anna.run_for(Duration::from_secs(10)).await;
    let after = station.y("arm1").await;
    assert_eq!(before, after);
    assert_eq!(anna.row("arm1").await["link"], "up");
}

#[tokio::test(start_paused = true)]
async fn line_reopened_in_time_keeps_lease_and_subscription() {
    let bench = TestHub::new(2, 1).await;
    let mut anna = bench.join("Anna").await;
    let lease = anna.take_arm("arm1").await;
    for frame in ["json", "binary"] {
        anna.ok(
            "arm.subscribe",
            json!({"arm": "arm1", "rate": 10, "frame": frame}),
        )
        .await;
    }
    anna.run_for(Duration::from_secs(1)).await;
    bench.site.end_lines(magician_site::StationId(2));
    anna.notices.clear();
    let frames = anna.frames.len();
    anna.run_for(Duration::from_secs(2)).await;
    let states = anna.noticed("arm.state");
    assert_eq!(states[0]["state"]["link"], "lost");
    let up = states
        .iter()
        .find(|params| params["state"]["link"] == "up")
        .expect("found again");
    assert_eq!(up["state"]["arm"], "arm1");
    assert!(anna.frames.len() > frames + 5);
    let numbers: Vec<_> = anna
        .frames
        .iter()
        .map(|frame| magician_station::StateFrame::read(frame).unwrap().sequence)
        .collect();
    assert!(
        numbers.is_sorted_by(|one, other| one < other),
        "{numbers:?}"
    );
    anna.ok("lease.renew", json!({"lease": lease})).await;
    anna.ok("arm.move", json!({"arm": "arm1", "to": [220, 40, 20, 0]}))
        .await;
}

#[tokio::test(start_paused = true)]
async fn restarted_station_keeps_its_slot() {
    let bench = TestHub::new(2, 1).await;
    let mut anna = bench.join("Anna").await;
    anna.ok("arm.subscribe", json!({"arm": "arm1", "rate": 10}))
        .await;
    bench.site.cut(2);
    bench
        .site
        .start(magician_site::StationId(9), &["arm1".to_owned()])
        .await;
    anna.run_for(Duration::from_secs(2)).await;
    let states = anna.noticed("arm.state");
    assert!(
        states
            .iter()
            .any(|params| params["state"]["link"] == "lost")
    );
    assert_eq!(states.last().unwrap()["subscription"], 1);
    assert!(
        states
            .iter()
            .rev()
            .any(|params| params["state"]["link"] == "up")
    );
    anna.take_arm("arm1").await;
    let job = json!({"arm": "arm1", "text": json!({"format": "magician-plan", "version": 1, "steps": [{"move": [220, 1, 20, 0]}]}).to_string()});
    let job = anna.ok("job.start", job).await["job"].clone();
    assert!(job.as_str().unwrap().starts_with("2."), "{job}");
}

#[tokio::test(start_paused = true)]
async fn a_jog_ends_with_its_line_and_with_its_hub() {
    let bench = TestHub::new(2, 1).await;
    let mut anna = bench.join("Anna").await;
    anna.take_arm("arm0").await;
    let jog = anna
        .ok(
            "jog.start",
            json!({"arm": "arm0", "axis": "y+", "keep_ms": 250}),
        )
        .await["jog"]
        .clone();
    for _ in 0..10 {
        anna.run_for(Duration::from_millis(100)).await;
        anna.notify("jog.keep", json!({"jog": jog}));
    }
    let station = bench.site.station(1);
    let kept = station.y("arm0").await;
    assert!(kept > 5.0, "{kept}");
    assert!(anna.noticed("jog.ended").is_empty());
    let stood = anna.ok("jog.stop", json!({"jog": jog})).await;
    assert_eq!(stood["stood"], true);
    assert_eq!(anna.noticed("jog.ended")[0]["jog"], jog);
    // A second jog, running when the hub dies.
    anna.ok(
        "jog.start",
        json!({"arm": "arm0", "axis": "y-", "keep_ms": 250}),
    )
    .await;
    let TestHub { site, hub, .. } = bench;
    drop((anna, hub));
    tokio::time::sleep(Duration::from_secs(1)).await;
    let stands = station.y("arm0").await;
    tokio::time::sleep(Duration::from_secs(2)).await;
    assert_eq!(stands, station.y("arm0").await);
    drop(site);
}

#[tokio::test(start_paused = true)]
async fn jog_end_is_notified_when_its_line_is_lost() {
    let bench = TestHub::new(2, 1).await;
    let mut anna = bench.join("Anna").await;
    anna.take_arm("arm0").await;
    let jog = anna
        .ok(
            "jog.start",
            json!({"arm": "arm0", "axis": "y+", "keep_ms": 1000}),
        )
        .await["jog"]
        .clone();
    bench.site.cut(1);
    anna.run_for(Duration::from_millis(50)).await;
    let expected = json!({"arm": "arm0", "jog": jog, "why": "link"});
    assert_eq!(anna.noticed("jog.ended"), [&expected]);
    let error = anna.fails("jog.stop", json!({"jog": jog})).await;
    assert_eq!(error["data"]["kind"], "port");
}

#[tokio::test(start_paused = true)]
async fn lease_lasts_only_while_the_client_answers_pings() {
    let bench = TestHub::new(2, 1).await;
    let mut anna = bench.join("Anna").await;
    anna.take_arm("arm1").await;
    anna.run_for(Duration::from_secs(60)).await;
    assert_ne!(anna.row("arm1").await["holder"], Value::Null);
    // The client answers no ping, and the hub must not answer for it.
    tokio::time::sleep(Duration::from_secs(8)).await;
    let mut ben = bench.join("Ben").await;
    assert_eq!(ben.row("arm1").await["holder"], Value::Null);
}

#[tokio::test(start_paused = true)]
async fn reloaded_page_keeps_its_leases() {
    let bench = TestHub::new(2, 1).await;
    let mut anna = bench.socket();
    let hello = anna
        .ok("session.hello", json!({"client": {"name": "Anna"}}))
        .await;
    anna.take_arm("arm1").await;
    drop(anna);
    tokio::time::sleep(Duration::from_secs(2)).await;
    let mut again = bench.socket();
    let resumed = again
        .ok(
            "session.hello",
            json!({"client": {"name": "Anna"}, "resume": hello["resume"]}),
        )
        .await;
    assert_eq!(
        (&resumed["session"], &resumed["resumed"]),
        (&hello["session"], &json!(true))
    );
    again.run_for(Duration::from_secs(20)).await;
    assert_eq!(
        again.row("arm1").await["holder"]["session"],
        hello["session"]
    );
    again
        .ok("arm.move", json!({"arm": "arm1", "to": [220, 40, 20, 0]}))
        .await;
}

#[tokio::test(start_paused = true)]
async fn requests_to_a_silent_station_time_out() {
    let bench = TestHub::new(3, 1).await;
    let mut anna = bench.join("Anna").await;
    bench.site.silence(2);
    let begun = Instant::now();
    let list = anna.ok("arm.list", json!({})).await;
    assert!(begun.elapsed() < Duration::from_secs(1));
    let links: Vec<_> = list["arms"]
        .as_array()
        .unwrap()
        .iter()
        .map(|row| row["link"].clone())
        .collect();
    assert_eq!(links, [json!("up"), json!("lost"), json!("up")]);
    let silent_request = anna.send("arm.state", json!({"arm": "arm1"}));
    anna.ok("arm.state", json!({"arm": "arm2"})).await;
    let error = anna.answer(silent_request).await.unwrap_err();
    assert_eq!(error["data"]["kind"], "port");
    assert!(begun.elapsed() < Duration::from_secs(6));
    // Reconnects happen with backoff, not at every request.
    let opened = bench.site.opened();
    for _ in 0..20 {
        let error = anna.fails("arm.info", json!({"arm": "arm1"})).await;
        assert_eq!(error["data"]["kind"], "port");
    }
    assert!(bench.site.opened() <= opened + 1);
}
