//! Senders that never pause: what others send is served within a bounded number of their turns.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use futures_util::stream::SplitStream;
use futures_util::{SinkExt, StreamExt};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use serde_json::json;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::runtime::Builder;
use tokio::task::{JoinSet, yield_now};
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::Message;

use crate::bench::Bench;

/// Most answers that a flood may get while one urgent request is answered. It takes some ten steps from the first byte to the
/// last, each of which one turn may precede.
const MOST_TURNS: usize = 40;

/// An urgent request that no arm has to come to rest for.
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

/// Connections that send such requests without a pause and take the answers, and how many of these have begun.
async fn flood(bench: &Bench, kinds: &[usize]) -> (Arc<AtomicUsize>, JoinSet<()>) {
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
    fn urgent_request_is_answered_within_few_turns_of_any_pipelined_requests(
        kinds in proptest::collection::vec(0..6_usize, 1..24),
    ) {
        let runtime = Builder::new_current_thread().enable_all().build().unwrap();
        let served = runtime.block_on(async {
            let bench = Bench::new().await;
            let (answers, _senders) = flood(&bench, &kinds).await;
            let before = answers.load(Ordering::Relaxed);
            let answer = bench.post("/api/v1/rpc", "", URGENT).await;
            assert_eq!(answer.status, 200, "{}", answer.body);
            answers.load(Ordering::Relaxed) - before
        });
        prop_assert!(served <= MOST_TURNS, "{served} answers to {kinds:?}");
    }
}

/// Answers that viewers were given: those that came, and those that the station still has for them.
#[derive(Default)]
struct Given {
    came: AtomicUsize,
    /// Bytes of one.
    length: AtomicUsize,
}

impl Given {
    async fn count(&self, mut socket: SplitStream<WebSocketStream<TcpStream>>) {
        while let Some(Ok(message)) = socket.next().await {
            if let Message::Text(text) = message
                && text.contains("\"id\":7")
            {
                self.length.store(text.len(), Ordering::Relaxed);
                self.came.fetch_add(1, Ordering::Relaxed);
            }
        }
    }

    fn all(&self, bench: &Bench) -> usize {
        let length = self.length.load(Ordering::Relaxed).max(1);
        self.came.load(Ordering::Relaxed) + bench.station.size().0.unsent / length
    }
}

#[tokio::test]
async fn message_of_a_session_is_answered_within_few_turns_of_viewers_with_many() {
    const LIST: &str = r#"{"jsonrpc":"2.0","id":7,"method":"session.list"}"#;
    let bench = Bench::new().await;
    let (given, mut viewers) = (Arc::new(Given::default()), JoinSet::new());
    let mut student = bench.join("student").await;
    let mut sinks = Vec::new();
    for name in ["a", "b", "c", "d", "e", "f"] {
        let (sink, stream) = bench.join(name).await.socket.split();
        let given = Arc::clone(&given);
        viewers.spawn(async move { given.count(stream).await });
        sinks.push(sink);
    }
    // The first answer of each tells how long one is.
    for sink in &mut sinks {
        sink.send(Message::text(LIST)).await.unwrap();
    }
    while given.came.load(Ordering::Relaxed) < sinks.len() {
        yield_now().await;
    }
    for sink in &mut sinks {
        for _ in 0..150 {
            sink.feed(Message::text(LIST)).await.unwrap();
        }
        sink.flush().await.unwrap();
    }
    let before = given.all(&bench);
    let job = json!({"job": "j0-1"});
    student.call("job.stop", job).await.unwrap_err();
    let served = given.all(&bench) - before;
    assert!(served <= MOST_TURNS, "{served}");
    let before = given.all(&bench);
    student.call("arm.list", json!({})).await.unwrap();
    let served = given.all(&bench) - before;
    assert!(served <= MOST_TURNS, "{served}");
    // The viewers lose nothing by it.
    while given.came.load(Ordering::Relaxed) < 6 * 151 {
        yield_now().await;
    }
}
