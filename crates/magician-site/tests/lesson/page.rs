//! Page of a pupil: a session with the station of the pupil's arm, over the site.

use std::sync::Arc;
use std::time::Duration;

use magician_site::{Channel, FromStation, Site as _, StationId, ToStation, channel};
use serde_json::{Value, json};
use tokio::time::{Instant, timeout_at};

use crate::class::Pupil;
use crate::room::{Room, Span};

pub(crate) struct Page {
    room: Arc<Room>,
    pupil: Pupil,
    channel: Channel,
    next: u64,
    answers: Vec<Value>,
    /// Time since which the pupil has the turn, as far as this page knows.
    turn: Option<Duration>,
    place: Option<u64>,
    pub(crate) closed: bool,
}

impl Page {
    /// Loads the page and signs in.
    pub(crate) async fn load(room: &Arc<Room>, pupil: &Pupil, code: &str) -> Result<Self, Value> {
        let channel = room.site.open(StationId(pupil.station)).await;
        let channel = channel.map_err(|error| json!({"message": error.to_string()}))?;
        let mut page = Self {
            room: Arc::clone(room),
            pupil: pupil.clone(),
            channel,
            next: 0,
            answers: Vec::new(),
            turn: None,
            place: None,
            closed: false,
        };
        let hello =
            json!({"client": {"name": "page"}, "pupil": {"name": pupil.name, "code": code}});
        page.call("session.hello", hello).await?;
        let turns = page.call("turn.list", json!({})).await?;
        page.sees(&turns);
        Ok(page)
    }

    pub(crate) fn has_turn(&self) -> bool {
        self.turn.is_some()
    }

    /// Place in the queue. `None` if the pupil does not wait.
    pub(crate) fn place(&self) -> Option<u64> {
        self.place
    }

    pub(crate) async fn call(&mut self, method: &str, params: Value) -> Result<Value, Value> {
        self.next += 1;
        let id = self.next;
        let message = json!({"jsonrpc": "2.0", "id": id, "method": method, "params": params});
        self.channel
            .send(ToStation::Text(message.to_string()))
            .await;
        loop {
            let known = self.answers.iter().position(|answer| answer["id"] == id);
            if let Some(at) = known {
                let mut answer = self.answers.remove(at);
                return match answer.get("error") {
                    Some(error) => Err(error.clone()),
                    None => Ok(answer["result"].take()),
                };
            }
            if self.closed {
                return Err(json!({"code": 0, "message": "the page has lost its station"}));
            }
            let next = self.channel.receive().await;
            self.takes(next);
        }
    }

    pub(crate) async fn ok(&mut self, method: &str, params: Value) -> Value {
        let outcome = self.call(method, params).await;
        outcome.unwrap_or_else(|error| panic!("{}: {method}: {error}", self.pupil.name))
    }

    pub(crate) async fn keep(&mut self, jog: &Value) {
        let message = json!({"jsonrpc": "2.0", "method": "jog.keep", "params": {"jog": jog}});
        self.channel
            .send(ToStation::Text(message.to_string()))
            .await;
    }

    /// Closes the tablet: the socket ends without a message.
    pub(crate) fn shut(&mut self) {
        self.channel = channel().0;
        self.closed = true;
        self.has(false);
    }

    /// Keeps the page open for this time.
    pub(crate) async fn run_for(&mut self, time: Duration) {
        let until = Instant::now() + time;
        while Instant::now() < until && !self.closed {
            self.channel.send(ToStation::KeepAlive).await;
            let pause = (Instant::now() + Duration::from_secs(1)).min(until);
            while let Ok(next) = timeout_at(pause, self.channel.receive()).await {
                self.takes(next);
                if self.closed {
                    break;
                }
            }
        }
    }

    fn takes(&mut self, next: FromStation) {
        match next {
            FromStation::Text(text) => {
                let message: Value = serde_json::from_str(&text).unwrap();
                match message["method"].as_str() {
                    Some("turn.changed") => self.sees(&message["params"]),
                    Some(_) => {}
                    None => self.answers.push(message),
                }
            }
            FromStation::Frame(_) => {}
            FromStation::Closed(_) => {
                self.closed = true;
                self.has(false);
            }
        }
    }

    fn sees(&mut self, turns: &Value) {
        let arms = turns["arms"].as_array().unwrap();
        let mine = |row: &&Value| row["person"] == self.pupil.name;
        let row = arms.iter().find(mine);
        self.has(row.is_some_and(|row| row["state"] == "running"));
        let queue = turns["queue"].as_array().unwrap();
        // The station's queue covers all its arms. The place counts only pupils who wait for this
        // arm.
        let waits = queue
            .iter()
            .filter(|one| one["arms"] == json!([self.pupil.arm]));
        let mut waits = (1..).zip(waits);
        self.place = waits
            .find(|(_, one)| one["person"] == self.pupil.name)
            .map(|(place, _)| place);
    }

    fn has(&mut self, turn: bool) {
        let now = self.room.now();
        match (turn, self.turn) {
            (true, None) => self.turn = Some(now),
            (false, Some(from)) => {
                self.turn = None;
                self.room.notes.lock().unwrap().spans.push(Span {
                    arm: self.pupil.arm.to_owned(),
                    person: self.pupil.name,
                    from,
                    until: now,
                });
            }
            _ => {}
        }
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        self.has(false);
    }
}
