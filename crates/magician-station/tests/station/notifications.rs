//! Examples of notifications and events, each on a fresh station.

use std::collections::BTreeMap;
use std::time::Duration;

use magician_station::Role;
use magician_station::api::{EVENTS, ExampleCall, NOTIFICATIONS, NotificationExample};
use serde_json::{Value, json};

use crate::bench::{LocalStation, Tester};
use crate::examples::alike;
use crate::schema_check;

/// Time after which the arm has been read.
const READ: Duration = Duration::from_millis(200);
/// Length of a turn in the examples.
const TURN: Duration = Duration::from_secs(91);

/// Returns the parameters with ids of earlier results.
fn with_ids(params: &Value, results: &[Value]) -> Value {
    let id_of = |name: &str| results.iter().rev().find_map(|result| result.get(name));
    let ids = ["job", "jog", "lease", "session", "subscription"];
    let members = params.as_object().into_iter().flatten();
    let members = members.map(|(name, value)| {
        let id = id_of(name).filter(|_| ids.contains(&name.as_str()));
        (name.clone(), id.unwrap_or(value).clone())
    });
    Value::Object(members.collect())
}

async fn client<'t>(
    bench: &LocalStation,
    testers: &'t mut BTreeMap<String, Tester>,
    said: &ExampleCall,
) -> &'t mut Tester {
    if !testers.contains_key(&said.client) {
        let tester = if said.method == "session.hello" {
            bench.socket(Some(Role::Teacher))
        } else {
            bench.join_as(&said.client, Role::Teacher).await
        };
        testers.insert(said.client.clone(), tester);
    }
    testers.get_mut(&said.client).unwrap()
}

/// Returns what the client of an example receives of a notification.
async fn received(example: &NotificationExample, method: &str) -> Vec<Value> {
    let bench = LocalStation::new(1).await;
    let mut testers = BTreeMap::new();
    let mut results = Vec::new();
    let comes_later = example
        .after
        .iter()
        .any(|said| said.client == example.recipient && said.method == "session.hello");
    if !comes_later {
        let tester = bench.join_as(&example.recipient, Role::Teacher).await;
        testers.insert(example.recipient.clone(), tester);
    }
    for said in &example.after {
        if said.method == "server.ending" {
            let listener = testers.get_mut(&example.recipient).unwrap();
            tokio::join!(bench.station.end_runs(), listener.listen(TURN));
            continue;
        }
        let tester = client(&bench, &mut testers, said).await;
        let params = with_ids(&said.params, &results);
        let waits = said.method == "lease.ask" || said.params.get("wait_s").is_some();
        if waits {
            tester.send(&said.method, params);
        } else {
            results.push(tester.ok(&said.method, params).await);
        }
        // Read first, so that the effects of the call are changes.
        tester.listen(READ).await;
    }
    // A holder has to send signs of life.
    let mut passed = Duration::ZERO;
    let step = Duration::from_secs(1);
    while passed < TURN {
        passed += step;
        let share = step / testers.len() as u32;
        for tester in testers.values_mut() {
            tester.listen(share).await;
        }
        for (who, tester) in &mut testers {
            // Closed, or waiting for an answer.
            if tester.closed.is_none() && who != "Ben" || method == "turn.ending" {
                tester.ok("server.info", json!({})).await;
            }
        }
        let listener = &testers[&example.recipient];
        let found = listener.noticed(method);
        let event = |params: &Value| params.get("event").cloned();
        let is_it = |params: &&&Value| event(params) == event(&example.params);
        if { found.iter() }
            .filter(is_it)
            .any(|params| alike(&example.params, params))
        {
            break;
        }
    }
    let listener = testers.remove(&example.recipient).unwrap();
    listener.noticed(method).into_iter().cloned().collect()
}

#[tokio::test(start_paused = true)]
async fn every_notification_matches_its_example() {
    let mut wrong = Vec::new();
    for row in NOTIFICATIONS {
        let example = NotificationExample::of(row.name).expect(row.name);
        let received = received(&example, row.name).await;
        if !received.iter().any(|params| alike(&example.params, params)) {
            wrong.push(format!("{}: {received:?}", row.name));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[tokio::test(start_paused = true)]
async fn every_event_matches_its_example() {
    let mut wrong = Vec::new();
    for row in EVENTS {
        let example = NotificationExample::of(row.name).expect(row.name);
        if example.after.is_empty() {
            // No client can cause this event.
            let message =
                json!({"jsonrpc": "2.0", "method": "arm.event", "params": example.params});
            schema_check::check_notification(&message);
            continue;
        }
        let received = received(&example, "arm.event").await;
        let is_it = |params: &&Value| params["event"] == row.name;
        let found = received.iter().filter(is_it).collect::<Vec<_>>();
        if !found.iter().any(|params| alike(&example.params, params)) {
            wrong.push(format!("{}: {found:?} of {received:?}", row.name));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
