//! Sessions over the network behave like a WebSocket to the station.

use magician_site::{FromStation, Site, SiteEvent, ToStation};
use serde_json::json;
use tokio::time::timeout;

use crate::bench::{OneArm, WAIT_TIMEOUT, answer, request, wait_for_event, wait_until};

#[tokio::test(flavor = "multi_thread")]
async fn session_behaves_like_a_websocket() {
    let OneArm {
        lab,
        station,
        node,
        site,
        mut events,
        ..
    } = OneArm::new().await;

    let mut channel = site.open(node.id()).await.unwrap();
    let hello = json!({"client": {"name": "pupil"}, "token": lab.token});
    channel
        .send(ToStation::Text(request("session.hello", &hello)))
        .await;
    let greeted = answer(&mut channel, 1).await;
    assert_eq!(greeted["result"]["role"], "student", "{greeted}");
    // The second socket is the node's own, which reads states.
    wait_until(async || station.sockets() == 2).await;
    let lease = request("lease.acquire", &json!({"arm": "a"}));
    channel.send(ToStation::Text(lease)).await;
    answer(&mut channel, 1).await;
    wait_for_event(&mut events, |event| match event {
        SiteEvent::Report(_, report) => (report.state["holder"]["name"] == "pupil").then_some(()),
        _ => None,
    })
    .await;

    // Read more frames than fit the window, so that the reader frees room for the next ones.
    let subscribe = json!({"arm": "a", "rate": 50, "frame": "binary"});
    channel
        .send(ToStation::Text(request("arm.subscribe", &subscribe)))
        .await;
    let mut frames = 0;
    while frames < 150 {
        match timeout(WAIT_TIMEOUT, channel.receive()).await.unwrap() {
            FromStation::Frame(bytes) => {
                assert_eq!(bytes.len(), magician_station::FRAME_SIZE);
                frames += 1;
            }
            FromStation::Text(_) => {}
            FromStation::Closed(closed) => panic!("{closed}"),
        }
    }
    // Dropping the channel closes the socket and so releases the lease.
    drop(channel);
    wait_for_event(&mut events, |event| match event {
        SiteEvent::Report(_, report) => report.state["holder"].is_null().then_some(()),
        _ => None,
    })
    .await;
    wait_until(async || station.sockets() == 1).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_wrong_token_closes_a_session_with_its_code() {
    let bench = OneArm::new().await;
    let mut channel = bench.site.open(bench.node.id()).await.unwrap();
    let hello = json!({"client": {"name": "pupil"}, "token": "x".repeat(40)});
    channel
        .send(ToStation::Text(request("session.hello", &hello)))
        .await;
    loop {
        if let FromStation::Closed(closed) = timeout(WAIT_TIMEOUT, channel.receive()).await.unwrap()
        {
            assert_eq!(closed.code, 4401, "{closed}");
            return;
        }
    }
}
