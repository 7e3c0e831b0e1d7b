//! Floods: other clients are served within a bounded number of a flooding sender's turns.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use futures_util::SinkExt;
use magician::admission::Origin;
use magician_station::{Grant, Outgoing, Peer, Role};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::runtime::Builder;
use tokio::task::{JoinSet, yield_now};
use tokio_tungstenite::tungstenite::Message;

use crate::bench::HttpStation;

/// Most requests of a flood served while another request is answered. That request takes about ten
/// steps, each of which may wait for one turn, and more turns pass while the system carries bytes.
/// Without turns the flood has a thousand or more.
const MAX_TURNS: usize = 400;

/// Urgent request for which no arm has to come to rest.
const URGENT: &str = r#"{"jsonrpc":"2.0","id":1,"method":"job.stop","params":{"job":"j0-1"}}"#;

/// Requests that a stranger may send in a row.
fn pipelined(kind: usize, host: &str) -> String {
    let (method, path, body) = match kind {
        0 => ("GET", "/api/v1/openrpc.json", ""),
        1 => ("GET", "/healthz", ""),
        2 => ("GET", "/", ""),
        3 => ("GET", "/nothing", ""),
        4 => ("POST", "/api/v1/rpc", "no JSON"),
        _ => (
            "POST",
            "/api/v1/rpc",
            r#"{"jsonrpc":"2.0","id":1,"method":"server.info"}"#,
        ),
    };
    let length = body.len();
    format!(
        "{method} {path} HTTP/1.1\r\nhost: {host}\r\ncontent-type: application/json\r\n\
         content-length: {length}\r\n\r\n{body}"
    )
}

/// Opens connections that send these requests without pause and read the answers. Returns a counter
/// of started answers.
async fn flood(bench: &HttpStation, kinds: &[usize]) -> (Arc<AtomicUsize>, JoinSet<()>) {
    let (answers, mut senders) = (Arc::new(AtomicUsize::new(0)), JoinSet::new());
    for kind in kinds {
        let requests = pipelined(*kind, &bench.address.to_string()).repeat(20);
        let stream = TcpStream::connect(bench.address).await.unwrap();
        let (mut reads, mut writes) = stream.into_split();
        senders.spawn(async move { while writes.write_all(requests.as_bytes()).await.is_ok() {} });
        let answers = Arc::clone(&answers);
        senders.spawn(async move {
            let mut bytes = vec![0; 16 * 1024];
            while let Ok(count) = reads.read(&mut bytes).await {
                let begun = bytes[..count].windows(9).filter(|at| at == b"HTTP/1.1 ");
                answers.fetch_add(begun.count(), Ordering::Relaxed);
            }
        });
    }
    while answers.load(Ordering::Relaxed) < kinds.len() {
        yield_now().await;
    }
    (answers, senders)
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 6,
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn urgent_request_overtakes_pipelined_requests(
        kinds in proptest::collection::vec(0..6_usize, 1..24),
    ) {
        let runtime = Builder::new_current_thread().enable_all().build().unwrap();
        let served = runtime.block_on(async {
            let bench = HttpStation::new().await;
            let (answers, _senders) = flood(&bench, &kinds).await;
            let before = answers.load(Ordering::Relaxed);
            let answer = bench.post("/api/v1/rpc", "", URGENT).await;
            assert_eq!(answer.status, 200, "{}", answer.body);
            answers.load(Ordering::Relaxed) - before
        });
        prop_assert!(served <= MAX_TURNS, "{served} answers to {kinds:?}");
    }
}

/// Returns an upper bound of the requests that the station has handled: each has an id, and so has
/// the asking session.
fn handled(bench: &HttpStation) -> u64 {
    let grant = Some(Grant {
        role: Role::Viewer,
        token: None,
    });
    let client = bench.station.connect(Peer {
        grant,
        origin: Origin::Loopback,
        address: "here".to_owned(),
        secret: "0123456789abcdef".to_owned(),
    });
    client.send(
        r#"{"jsonrpc":"2.0","id":1,"method":"session.hello","params":{"client":{"name":"x"}}}"#,
    );
    let Some(Outgoing::Text(hello)) = client.try_receive() else {
        panic!("no answer");
    };
    let hello: Value = serde_json::from_str(&hello).unwrap();
    let session = hello["result"]["session"].as_str().unwrap();
    session.strip_prefix("s0-").unwrap().parse().unwrap()
}

#[tokio::test]
async fn session_message_is_not_delayed_by_busy_viewers() {
    const LIST: &str = r#"{"jsonrpc":"2.0","id":7,"method":"session.list"}"#;
    let bench = HttpStation::new().await;
    let mut student = bench.join("student").await;
    let mut viewers = Vec::new();
    for name in ["a", "b", "c", "d", "e", "f"] {
        viewers.push(bench.join(name).await);
    }
    for viewer in &mut viewers {
        for _ in 0..190 {
            viewer.socket.feed(Message::text(LIST)).await.unwrap();
        }
        viewer.socket.flush().await.unwrap();
    }
    let begun = handled(&bench);
    let job = json!({"job": "j0-1"});
    student.call("job.stop", job).await.unwrap_err();
    student.call("arm.list", json!({})).await.unwrap();
    let others = handled(&bench) - begun;
    assert!(others <= MAX_TURNS as u64, "{others}");
    // The viewers get all their answers.
    for viewer in &mut viewers {
        for _ in 0..190 {
            viewer.answer(7).await.unwrap();
        }
    }
}
