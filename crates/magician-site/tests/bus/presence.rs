//! Presence and states of arms on the bus, and requests to their stations.

use magician_site::carrier::{CarrierError, LINGER_WARNING};
use magician_site::{Caller, Site, SiteError, SiteEvent};
use serde_json::{Value, json};

use crate::bench::{BENCH, Lab, OneArm, free_port, request, wait_for_arm, wait_for_event};

#[test]
fn builds_of_the_repository_close_links_without_lingering() {
    assert_eq!(LINGER_WARNING, None);
}

#[tokio::test(flavor = "multi_thread")]
async fn site_reports_its_arms_and_their_states() {
    let OneArm {
        lab,
        station: _station,
        node,
        site,
        mut events,
        at,
        state,
        ..
    } = OneArm::new().await;
    assert_eq!(at.station, node.id());
    assert_eq!(state["link"], "up");
    assert_eq!(state["holder"], Value::Null);

    let stop = request("arm.stop", &json!({}));
    let nobody = Caller::default();
    let refused = site.call(&at, &nobody, stop.clone()).await;
    assert!(matches!(refused, Err(SiteError::Network(_))), "{refused:?}");
    let wrong = Caller {
        token: Some("x".repeat(40)),
    };
    let refused = site.call(&at, &wrong, stop.clone()).await;
    assert!(matches!(refused, Err(SiteError::Network(_))), "{refused:?}");
    let stopped = site.call(&at, &lab.caller(), stop).await.unwrap().unwrap();
    assert!(stopped.contains("\"result\""), "{stopped}");

    let moved = request("arm.move", &json!({"arm": "a", "to": [220, 0, 50, 0]}));
    let moved = site.call(&at, &lab.caller(), moved).await.unwrap().unwrap();
    assert!(moved.contains("\"x\":220"), "{moved}");
    wait_for_event(&mut events, |event| match event {
        SiteEvent::Report(_, report) => (report.state["x"] == 220.0).then_some(()),
        _ => None,
    })
    .await;

    node.leave().await;
    wait_for_event(&mut events, |event| {
        (event == SiteEvent::Left(at.clone())).then_some(())
    })
    .await;
    let gone = request("arm.stop", &json!({}));
    let gone = site.call(&at, &lab.caller(), gone).await;
    assert_eq!(gone, Err(SiteError::Gone));
}

#[tokio::test(flavor = "multi_thread")]
async fn second_arm_of_one_name_is_refused() {
    let lab = Lab::new();
    let port = free_port();
    let (_station, node) = lab.node("a", &lab.config("a", Some(port), &[])).await;
    let (_other, refused) = {
        let config = lab.config("b", None, &[port]);
        lab.try_node("a", &config, lab.identity.clone()).await
    };
    match refused {
        Err(CarrierError::Taken {
            arm,
            station,
            machine,
            ..
        }) => {
            assert_eq!((arm.as_str(), station), ("a", node.id()));
            assert_eq!(machine, BENCH);
        }
        other => panic!("{other:?}"),
    }
    // A new name is accepted, and so is a released one.
    let (_third, beside) = lab.node("c", &lab.config("c", None, &[port])).await;
    beside.leave().await;
    let (_again, _node) = lab.node("c", &lab.config("d", None, &[port])).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn journal_names_the_machine_that_asked() {
    let lab = Lab::new();
    let port = free_port();
    let (_station, _node) = lab.node("a", &lab.config("a", Some(port), &[])).await;
    let site = lab.site_of(Some(lab.machine("desk").await), &[port]).await;
    let (at, _) = wait_for_arm(&mut site.watch(), "a").await;
    let stop = request("arm.stop", &json!({}));
    site.call(&at, &lab.caller(), stop).await.unwrap();
    let journal = lab.journal.lock().unwrap().clone();
    let line = journal
        .iter()
        .find(|line| line.method == "arm.stop")
        .unwrap();
    assert!(line.peer.ends_with(" desk"), "{}", line.peer);
}
