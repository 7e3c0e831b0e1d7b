//! A machine whose certificate is revoked.

use magician_site::carrier::{CarrierError, distribute_revoked};
use magician_site::{FromStation, Site, SiteError, ToStation};
use serde_json::json;
use tokio::time::timeout;

use crate::bench::{
    Lab, WAIT_TIMEOUT, answer, answers, free_port, request, wait_for_arm, wait_until,
};

#[tokio::test(flavor = "multi_thread")]
async fn stations_with_the_list_refuse_a_revoked_machine() {
    let lab = Lab::new();
    let port = free_port();
    let (_station, _node) = lab.node("a", &lab.config("a", Some(port), &[])).await;
    let (lost, desk) = (lab.machine("lost").await, lab.machine("desk").await);
    let (of_lost, of_desk) = (
        lab.site_of(Some(lost.clone()), &[port]).await,
        lab.site_of(Some(desk), &[port]).await,
    );
    let (at, _) = wait_for_arm(&mut of_lost.watch(), "a").await;
    wait_for_arm(&mut of_desk.watch(), "a").await;
    let caller = lab.caller();
    assert!(answers(&of_lost, &at, &caller).await);
    let mut channel = of_lost.open(at.station).await.unwrap();
    let hello = json!({"client": {"name": "lost"}, "token": lab.token});
    channel
        .send(ToStation::Text(request("session.hello", &hello)))
        .await;
    assert_eq!(answer(&mut channel, 1).await["result"]["role"], "student");

    let identity = lab.identity.clone().unwrap();
    lab.authority().revoke("lost").unwrap();
    let config = lab.config("authority", None, &[port]);
    distribute_revoked("lab".parse().unwrap(), Some(&config), &identity)
        .await
        .unwrap();
    // The session of the revoked machine ends and cannot be opened again. Other machines reconnect.
    let ended = async { while !matches!(channel.receive().await, FromStation::Closed(_)) {} };
    timeout(WAIT_TIMEOUT, ended).await.unwrap();
    wait_until(async || answers(&of_desk, &at, &caller).await).await;
    let refused = of_lost
        .call(&at, &caller, request("arm.state", &json!({})))
        .await;
    assert!(
        matches!(
            refused,
            Err(SiteError::NoAnswer | SiteError::Network(_) | SiteError::Unproved(_))
        ),
        "{refused:?}"
    );
    assert!(of_lost.open(at.station).await.is_err());
    // The revoked machine cannot join as a station either.
    wait_until(async || lost.is_revoked()).await;
    let config = lab.config("b", None, &[port]);
    let (_other, joined) = lab.try_node("b", &config, Some(lost)).await;
    assert!(matches!(joined, Err(CarrierError::Certificate(_))));
}
