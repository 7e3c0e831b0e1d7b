//! Listener of the link: silent programs do not keep others out.

use std::time::Duration;

use futures_util::{SinkExt, StreamExt};
use magician_station::http::Admission;
use magician_station::link::{LinkListener, LinkOptions, LinkService};
use serde_json::{Value, json};
use tokio::net::TcpStream;
use tokio::sync::watch;
use tokio::time::{Instant, timeout};
use tokio_tungstenite::tungstenite::Message;

use crate::bench::HttpStation;

#[tokio::test(start_paused = true)]
async fn link_program_is_served_despite_silent_connections() {
    let bench = HttpStation::new().await;
    let listener = LinkListener::bind(Some("127.0.0.1:0")).await.unwrap();
    let address = listener.addresses()[0];
    let (_over, ends) = watch::channel(false);
    let service = LinkService::new(bench.station.clone(), LinkOptions::default());
    tokio::spawn(listener.serve(service, Admission::default(), ends));
    let mut silent = Vec::new();
    for _ in 0..100 {
        silent.push(TcpStream::connect(address).await.unwrap());
    }
    let url = format!("ws://{address}/");
    let mut programs = Vec::new();
    for _ in 0..70 {
        let stream = TcpStream::connect(address).await.unwrap();
        let (program, _) = tokio_tungstenite::client_async(&url, stream).await.unwrap();
        programs.push(program);
    }
    let began = Instant::now();
    let params = json!({"portName": "arm"});
    let call = json!({"jsonrpc": "2.0", "id": 1, "method": "dobotlink.Magician.ConnectDobot", "params": params});
    let program = programs.last_mut().unwrap();
    program.send(Message::text(call.to_string())).await.unwrap();
    let answer = async {
        loop {
            if let Message::Text(text) = program.next().await.unwrap().unwrap() {
                return serde_json::from_str::<Value>(&text).unwrap();
            }
        }
    };
    let answer = timeout(Duration::from_secs(60), answer)
        .await
        .expect("an answer");
    assert!(answer.get("error").is_none(), "{answer}");
    assert!(
        began.elapsed() < Duration::from_secs(1),
        "{:?}",
        began.elapsed()
    );
}
