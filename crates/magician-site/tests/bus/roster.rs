//! Rosters: the union of the expected arms over all stations.

use magician_site::{Roster, Site};
use serde_json::{Value, json};

use crate::bench::{Lab, free_port, request, wait_for_arm, wait_until};

fn names(roster: &Roster) -> Vec<&str> {
    roster.arms().map(|(arm, _)| arm).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn roster_is_stored_by_stations() {
    let lab = Lab::new();
    let port = free_port();
    let config = lab.config("a", Some(port), &[]);
    let (station, node) = lab.node("a", &config).await;
    let site = lab.site(&[port]).await;
    let mut events = site.watch();
    let (at, _) = wait_for_arm(&mut events, "a").await;
    assert!(site.roster().await.is_empty());

    let expected = json!({"arms": [{"arm": "a", "machine": "m"}, {"arm": "b", "machine": "m"}]});
    let write = |params: &Value| request("site.expect", params);
    let refused = site.call(&at, &lab.caller(), write(&expected)).await;
    assert!(refused.unwrap().unwrap().contains("-32001"));
    assert!(site.roster().await.is_empty());
    let written = site.call(&at, &lab.teacher(), write(&expected)).await;
    assert!(written.unwrap().unwrap().contains("result"));
    assert_eq!(names(&site.roster().await), ["a", "b"]);

    node.leave().await;
    drop(station);
    // A restarted station still has its roster.
    let (_station, _node) = lab.node("a", &config).await;
    wait_until(async || names(&site.roster().await) == ["a", "b"]).await;
}
