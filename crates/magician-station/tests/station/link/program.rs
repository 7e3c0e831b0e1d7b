//! Program for DobotLink, as a test client.

use std::time::Duration;

use magician_station::link::{LinkOptions, LinkProgram, LinkService};
use serde_json::{Value, json};
use tokio::time::timeout;

use crate::bench::LocalStation;

/// Longest time for an answer, in virtual time.
const MESSAGE_TIMEOUT: Duration = Duration::from_secs(200);

/// Program that waits for the answer to each call.
pub(crate) struct Program {
    pub(crate) link: LinkProgram,
    next: i64,
    pub(crate) notices: Vec<Value>,
    answers: Vec<Value>,
}

impl Program {
    pub(crate) fn new(bench: &LocalStation) -> Self {
        Self::with(bench, LinkOptions::default())
    }

    pub(crate) fn with(bench: &LocalStation, options: LinkOptions) -> Self {
        Self::of(&LinkService::new(bench.station.clone(), options))
    }

    pub(crate) fn of(service: &LinkService) -> Self {
        Self {
            link: service.connect("a script", "127.0.0.1:1"),
            next: 0,
            notices: Vec::new(),
            answers: Vec::new(),
        }
    }

    /// Creates a program with a connected arm.
    pub(crate) async fn connected(bench: &LocalStation) -> Self {
        let mut program = Self::new(bench);
        program.ok("ConnectDobot", json!({})).await;
        program
    }

    pub(crate) async fn send(&mut self, api: &str, mut params: Value) -> i64 {
        self.next += 1;
        if params.get("portName").is_none() {
            params["portName"] = json!("arm");
        }
        let method = format!("dobotlink.Magician.{api}");
        let text = json!({"jsonrpc": "2.0", "id": self.next, "method": method, "params": params});
        assert!(self.link.send(text.to_string()).await);
        self.next
    }

    pub(crate) async fn call(&mut self, api: &str, params: Value) -> Result<Value, (i64, String)> {
        let id = self.send(api, params).await;
        self.answer(id).await
    }

    pub(crate) async fn ok(&mut self, api: &str, params: Value) -> Value {
        let outcome = self.call(api, params).await;
        outcome.unwrap_or_else(|error| panic!("{api}: {error:?}"))
    }

    pub(crate) async fn code(&mut self, api: &str, params: Value) -> i64 {
        self.call(api, params).await.expect_err(api).0
    }

    pub(crate) async fn answer(&mut self, id: i64) -> Result<Value, (i64, String)> {
        loop {
            if let Some(at) = { self.answers.iter() }.position(|answer| answer["id"] == json!(id)) {
                let answer = self.answers.remove(at);
                assert_eq!(answer["jsonrpc"], json!("2.0"));
                return match answer.get("error") {
                    None => Ok(answer["result"].clone()),
                    Some(error) => Err((
                        error["code"].as_i64().unwrap(),
                        error["message"].as_str().unwrap().to_owned(),
                    )),
                };
            }
            let received = self.received().await;
            match received.get("id") {
                Some(_) => self.answers.push(received),
                None => self.notices.push(received),
            }
        }
    }

    pub(crate) async fn received(&mut self) -> Value {
        let received = timeout(MESSAGE_TIMEOUT, self.link.receive())
            .await
            .expect("in time");
        serde_json::from_str(&received.expect("not cut off")).unwrap()
    }

    /// Sends text as it is.
    pub(crate) async fn raw(&mut self, text: &str) -> Value {
        self.link.send(text).await;
        self.received().await
    }
}
