//! Leases as clients see them.

use std::time::Duration;

use magician_station::Role;
use serde_json::{Value, json};

use crate::bench::LocalStation;

#[tokio::test(start_paused = true)]
async fn second_session_asks_for_and_gets_the_lease() {
    let bench = LocalStation::new(1).await;
    let (mut anna, mut ben) = (bench.join("Anna").await, bench.join("Ben").await);
    anna.lease().await;
    let refused = ben.call("lease.acquire", json!({})).await.unwrap_err();
    assert_eq!(
        (&refused["code"], &refused["data"]["holder"]["name"]),
        (&json!(-32002), &json!("Anna"))
    );
    let asked = ben.send("lease.ask", json!({"message": "please"}));
    anna.listen(Duration::from_millis(10)).await;
    let question = anna.noticed("lease.asked")[0].clone();
    assert_eq!(
        (&question["name"], &question["message"]),
        (&json!("Ben"), &json!("please"))
    );
    let grant = json!({"session": question["session"], "grant": true});
    anna.ok("lease.answer", grant).await;
    assert_eq!(ben.answer(asked).await.unwrap()["granted"], json!(true));
    ben.ok("arm.move", json!({"to": [220, 0, 50, 0]})).await;
    assert_eq!(
        anna.code("arm.move", json!({"to": [220, 0, 60, 0]})).await,
        -32002
    );
    let holders: Vec<_> = anna
        .noticed("lease.changed")
        .iter()
        .map(|change| change["holder"]["name"].clone())
        .collect();
    assert_eq!(holders, [json!("Anna"), json!("Ben")]);
}

#[tokio::test(start_paused = true)]
async fn unanswered_lease_request_is_granted() {
    let bench = LocalStation::new(1).await;
    let (mut anna, mut ben) = (bench.join("Anna").await, bench.join("Ben").await);
    anna.lease().await;
    let asked = ben.send("lease.ask", json!({}));
    for _ in 0..19 {
        ben.listen(Duration::from_secs(1)).await;
        anna.client.pong();
    }
    assert!(ben.noticed("answer").is_empty());
    assert_eq!(ben.answer(asked).await.unwrap()["granted"], json!(true));
    assert_eq!(anna.code("arm.home", json!({})).await, -32002);
}

#[tokio::test(start_paused = true)]
async fn repeated_lease_request_is_one_question_with_all_answers() {
    let bench = LocalStation::new(1).await;
    let (mut anna, mut ben) = (bench.join("Anna").await, bench.join("Ben").await);
    let mut cleo = bench.join_as("Cleo", Role::Teacher).await;
    anna.lease().await;
    let asked = [0; 3].map(|_| ben.send("lease.ask", json!({"message": "please"})));
    anna.listen(Duration::from_millis(10)).await;
    assert_eq!(anna.noticed("lease.asked").len(), 1);
    // The next holder is asked once as well.
    cleo.ok("lease.take", json!({})).await;
    cleo.listen(Duration::from_millis(10)).await;
    let questions = cleo.noticed("lease.asked");
    assert_eq!(questions.len(), 1);
    let no = json!({"session": questions[0]["session"], "grant": false});
    cleo.ok("lease.answer", no).await;
    for request in asked {
        assert_eq!(ben.answer(request).await.unwrap()["granted"], json!(false));
    }
}

#[tokio::test(start_paused = true)]
async fn arm_list_names_waiting_and_asking_sessions() {
    let bench = LocalStation::new(1).await;
    let (mut anna, mut ben) = (bench.join("Anna").await, bench.join("Ben").await);
    let mut cleo = bench.join("Cleo").await;
    let waiting = |list: &Value| {
        let waiting = list["arms"][0]["waiting"].as_array().unwrap().iter();
        let told = waiting.map(|waiter| (waiter["name"].clone(), waiter["asks"].clone()));
        told.collect::<Vec<_>>()
    };
    anna.lease().await;
    let list = anna.ok("arm.list", json!({})).await;
    assert_eq!(waiting(&list), []);
    cleo.send("lease.ask", json!({}));
    ben.send("lease.acquire", json!({"wait_s": 60}));
    anna.listen(Duration::from_millis(50)).await;
    let list = anna.ok("arm.list", json!({})).await;
    let both = [("Ben", false), ("Cleo", true)].map(|(name, asks)| (json!(name), json!(asks)));
    assert_eq!(waiting(&list), both);
}

#[tokio::test(start_paused = true)]
async fn silent_holder_loses_the_lease_and_its_move_stops() {
    let bench = LocalStation::new(1).await;
    let (mut anna, mut ben) = (bench.join("Anna").await, bench.join("Ben").await);
    anna.lease().await;
    let slow = json!({"command": "PTPCommonParams", "fields": {"velocity_ratio": 1, "acceleration_ratio": 1}});
    anna.ok("arm.set", slow).await;
    anna.ok("arm.move", json!({"to": [200, 200, 50, 0], "wait": false}))
        .await;
    ben.listen(Duration::from_millis(4900)).await;
    assert!(bench.arms[0].state().moving);
    ben.listen(Duration::from_millis(150)).await;
    assert_eq!(bench.arms[0].state().queue.waiting, 0);
    // The arm brakes with the acceleration that was set.
    ben.listen(Duration::from_secs(1)).await;
    assert!(!bench.arms[0].state().moving, "what it queued is stopped");
    assert_eq!(
        ben.noticed("lease.changed").last().unwrap()["holder"],
        json!(null)
    );
    // No motion continues under the next holder.
    ben.lease().await;
    let stood = bench.arms[0].state().pose;
    ben.listen(Duration::from_secs(4)).await;
    assert_eq!(bench.arms[0].state().pose, stood);
}

#[tokio::test(start_paused = true)]
async fn move_in_progress_counts_as_keep_alive() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    let slow = json!({"command": "PTPCommonParams", "fields": {"velocity_ratio": 2, "acceleration_ratio": 2}});
    anna.ok("arm.set", slow).await;
    let begun = tokio::time::Instant::now();
    anna.ok("arm.move", json!({"to": [180, 180, 50, 0]})).await;
    assert!(
        begun.elapsed() > Duration::from_secs(6),
        "{:?}",
        begun.elapsed()
    );
    anna.ok("arm.move", json!({"to": [220, 0, 50, 0], "wait": false}))
        .await;
}

#[tokio::test(start_paused = true)]
async fn waiting_sessions_get_the_lease_in_order_with_their_place() {
    let bench = LocalStation::new(1).await;
    let (mut anna, mut ben) = (bench.join("Anna").await, bench.join("Ben").await);
    let mut carl = bench.join("Carl").await;
    let lease = anna.lease().await;
    let bens = ben.send("lease.acquire", json!({"wait_s": 60}));
    let carls = carl.send("lease.acquire", json!({"wait_s": 60}));
    carl.listen(Duration::from_millis(10)).await;
    assert_eq!(carl.noticed("lease.queue")[0]["place"], json!(2));
    anna.ok("lease.release", json!({"lease": lease})).await;
    let lease = ben.answer(bens).await.unwrap()["lease"].clone();
    carl.listen(Duration::from_millis(10)).await;
    assert_eq!(carl.noticed("lease.queue")[1]["place"], json!(1));
    ben.ok("lease.release", json!({"lease": lease})).await;
    carl.answer(carls).await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn resumed_socket_keeps_the_lease() {
    let bench = LocalStation::new(1).await;
    let mut ben = bench.join("Ben").await;
    let mut anna = bench.socket(Some(Role::Student));
    let hello = anna
        .ok("session.hello", json!({"client": {"name": "Anna"}}))
        .await;
    anna.lease().await;
    drop(anna);
    ben.listen(Duration::from_millis(4800)).await;
    assert_eq!(ben.code("lease.acquire", json!({})).await, -32002);
    let mut back = bench.socket(Some(Role::Student));
    let client = json!({"client": {"name": "Anna"}, "resume": hello["resume"]});
    let again = back.ok("session.hello", client).await;
    assert_eq!(
        (&again["resumed"], &again["session"]),
        (&json!(true), &hello["session"])
    );
    assert_ne!(again["resume"], hello["resume"]);
    back.ok("arm.move", json!({"to": [220, 0, 50, 0]})).await;
    drop(back);
    ben.listen(Duration::from_millis(5100)).await;
    ben.lease().await;
    let mut late = bench.socket(Some(Role::Student));
    let client = json!({"client": {"name": "Anna"}, "resume": again["resume"]});
    let new = late.ok("session.hello", client).await;
    assert_eq!(new["resumed"], json!(false));
}

#[tokio::test(start_paused = true)]
async fn teacher_takes_the_lease_and_stops_the_holders_work() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let mut teacher = bench.join_as("Teacher", Role::Teacher).await;
    anna.lease().await;
    assert_eq!(anna.code("lease.take", json!({})).await, -32001);
    let moving = anna.send("arm.move", json!({"to": [200, 200, 50, 0]}));
    teacher.listen(Duration::from_millis(300)).await;
    teacher.ok("lease.take", json!({})).await;
    let ended = anna.answer(moving).await.unwrap_err();
    assert_eq!(
        (&ended["code"], &ended["data"]["holder"]["name"]),
        (&json!(-32002), &json!("Teacher"))
    );
    let state = teacher.ok("arm.move", json!({"to": [220, 0, 50, 0]})).await;
    assert_eq!(state["x"], json!(220.0));
}

/// People read the sentence; the method is for programs.
#[tokio::test(start_paused = true)]
async fn lease_refusal_names_the_holder_but_no_method() {
    let bench = LocalStation::new(1).await;
    let (mut anna, mut ben) = (bench.join("Anna").await, bench.join("Ben").await);
    let to = json!({"to": [200, 0, 50, 0]});
    let free = ben.call("arm.move", to.clone()).await.unwrap_err();
    assert_eq!(free["message"], "moving arm needs its lease");
    assert_eq!(free["data"]["method"], "lease.acquire");
    anna.lease().await;
    for (method, params) in [("lease.acquire", json!({})), ("arm.move", to)] {
        let held = ben.call(method, params).await.unwrap_err();
        assert_eq!(held["message"], "Anna has the lease of arm", "{method}");
        assert_eq!(held["data"]["method"], "lease.ask", "{method}");
        assert_eq!(held["data"]["free_in_s"], json!(null), "{method}");
    }
    drop(anna);
    ben.listen(Duration::from_secs(2)).await;
    let gone = ben.call("lease.acquire", json!({})).await.unwrap_err();
    let free = gone["data"]["free_in_s"].as_f64().unwrap();
    assert!((2.5..=3.0).contains(&free), "{gone}");
    ben.ok("lease.acquire", json!({"wait_s": free + 0.5})).await;
}
