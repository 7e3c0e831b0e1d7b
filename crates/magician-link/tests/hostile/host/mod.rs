//! Host of the property tests: a script plays a program and a station, which may answer calls in
//! any order. At the end the station has answered everything and the line to its arms is lost. Then
//! each call of the program must have been answered exactly once.

use std::collections::{HashMap, VecDeque};
use std::time::Duration;

use magician_link::{Link, LinkOptions};
use magician_protocol::HostInstant;
use serde_json::{Value, json};

/// Most calls to the station caused by one line of a script. More of them are an endless loop.
const MAX_CALLS: usize = 5000;
/// Error codes of the station.
const CODES: [i64; 8] = [
    -32602, -32001, -32002, -32003, -32004, -32005, -32000, -32007,
];
/// Error kinds of an arm.
const KINDS: [&str; 5] = ["queue-full", "timeout", "port", "alarm", "uncertain"];

/// Call to the station without an answer.
struct Call {
    id: u64,
    method: String,
    params: Value,
}

/// Link with the simulated program and station around it.
pub(crate) struct Harness {
    link: Link,
    now: HostInstant,
    pending: VecDeque<Call>,
    subscriptions: u64,
    /// Index of the last command that the station has queued.
    index: u64,
    /// Number of requests and of answers per id.
    asked: HashMap<String, (u32, u32)>,
}

impl Harness {
    pub(crate) fn new(options: LinkOptions) -> Self {
        let now = HostInstant::ZERO;
        let mut harness = Self {
            link: Link::new(now, options, "a script"),
            now,
            pending: VecDeque::new(),
            subscriptions: 0,
            index: 0,
            asked: HashMap::new(),
        };
        harness.collect_output();
        harness
    }

    /// Runs a script.
    pub(crate) fn run_script(&mut self, script: &str) {
        for line in script.lines() {
            self.run_line(line);
            self.collect_output();
        }
    }

    fn run_line(&mut self, line: &str) {
        let mut chars = line.chars();
        let Some(mark) = chars.next() else { return };
        let rest = chars.as_str();
        let number: usize = rest.trim().parse().unwrap_or(0);
        match mark {
            '{' => self.message(line),
            'm' => self.message(rest),
            'a' => self.answer(number, &Answer::Good),
            'A' => self.answer_all(),
            'e' => self.answer(number % 8, &Answer::Error(number / 8)),
            'v' => {
                let value = serde_json::from_str(rest).unwrap_or(Value::Null);
                self.answer(0, &Answer::Value(value));
            }
            's' => self.link.receive_from_station(self.now, rest),
            'f' => self.finish(number as u64 % 100, None),
            '!' => self.finish(0, Some(number as u64 % 256)),
            'x' => self.event(["stop", "reset", "link-lost", "link-found"][number % 4]),
            'l' => self.lose_lease(),
            'p' => self.link.pong(self.now),
            't' => self.advance(Duration::from_millis(number as u64 % 100_000)),
            _ => {}
        }
    }

    fn message(&mut self, text: &str) {
        if let Ok(Value::Object(message)) = serde_json::from_str(text)
            && let Some(id) = message.get("id").filter(|id| !id.is_null())
        {
            self.asked.entry(id.to_string()).or_default().0 += 1;
        }
        self.link.receive(self.now, text);
    }

    fn advance(&mut self, time: Duration) {
        let until = self.now + time;
        let mut rounds = 0;
        while let Some(due) = self.link.poll_timeout().filter(|due| *due <= until) {
            self.now = self.now.max(due);
            self.link.handle_timeout(self.now);
            rounds += 1;
            assert!(rounds < MAX_CALLS, "what is due is done");
            self.collect_output();
        }
        self.now = until;
    }

    /// Answers one call.
    fn answer(&mut self, at: usize, answer: &Answer) {
        if self.pending.is_empty() {
            return;
        }
        let call = self.pending.remove(at % self.pending.len());
        let call = call.expect("it is among them");
        let message = match answer {
            Answer::Good => json!({"id": call.id, "result": self.valid_result(&call)}),
            Answer::Value(value) => json!({"id": call.id, "result": value}),
            Answer::Error(number) => {
                let data = json!({"kind": KINDS[number % KINDS.len()]});
                let code = CODES[number % CODES.len()];
                json!({"id": call.id, "error": {"code": code, "message": "no", "data": data}})
            }
        };
        self.link
            .receive_from_station(self.now, &message.to_string());
    }

    fn answer_all(&mut self) {
        for _ in 0..MAX_CALLS {
            if self.pending.is_empty() {
                return;
            }
            self.answer(0, &Answer::Good);
            self.collect_output();
        }
        panic!("the calls do not end");
    }

    /// Returns a valid answer of the station.
    fn valid_result(&mut self, call: &Call) -> Value {
        match call.method.as_str() {
            "session.hello" => json!({"session": "s0-1", "role": "teacher", "arms": ["arm", "b"]}),
            "arm.list" => {
                let arm = |name: &str, port: &str, is_virtual: bool| json!({"name": name, "port": port, "virtual": is_virtual, "link": "up", "holder": null, "job": null});
                json!({"arms": [arm("arm", "sim", true), arm("b", "/dev/ttyUSB0", false)]})
            }
            "lease.acquire" => json!({"arm": call.params["arm"], "lease": "l0-1", "ttl_s": 5}),
            "arm.subscribe" => {
                self.subscriptions += 1;
                json!({"subscription": self.subscriptions, "rate": 2, "fields": []})
            }
            "arm.get" | "arm.state" => json!({
                "x": 200.0, "y": 0.0, "z": 50.0, "r": 0.0, "joint_angles": [0.0, 45.0, 45.0, 0.0], "current_index": self.index,
                "left_space": 30, "alarms": [], "link": "up", "tool": {"name": "suction", "bias": [59.7, 0.0, 0.0]},
            }),
            "arm.unsubscribe" | "lease.release" | "arm.stop" => Value::Null,
            _ => {
                self.index += 1;
                json!({"index": self.index})
            }
        }
    }

    /// Reports a state: commands up to index `self.index - 20 + more` have finished, and `alarm`
    /// holds the queue if given.
    fn finish(&mut self, more: u64, alarm: Option<u64>) {
        let index = self.index.saturating_sub(20) + more;
        let state =
            json!({"current_index": index, "alarms": alarm.into_iter().collect::<Vec<_>>()});
        for subscription in 1..=self.subscriptions.min(40) {
            let params = json!({"subscription": subscription, "state": state});
            let message = json!({"method": "arm.state", "params": params});
            self.link
                .receive_from_station(self.now, &message.to_string());
        }
    }

    fn event(&mut self, event: &str) {
        for arm in ["arm", "b"] {
            let message = json!({"method": "arm.event", "params": {"arm": arm, "event": event}});
            self.link
                .receive_from_station(self.now, &message.to_string());
        }
    }

    fn lose_lease(&mut self) {
        let params = json!({"arm": "arm", "holder": {"session": "s0-9", "name": "ben"}});
        let message = json!({"method": "lease.changed", "params": params});
        self.link
            .receive_from_station(self.now, &message.to_string());
    }

    /// Collects outgoing messages. An answer must not come twice, nor without a request.
    fn collect_output(&mut self) {
        while let Some(call) = self.link.poll_station() {
            let text: Value = serde_json::from_str(&call.text).expect("JSON");
            self.pending.push_back(Call {
                id: text["id"].as_u64().expect("a number"),
                method: text["method"].as_str().expect("a name").to_owned(),
                params: text["params"].clone(),
            });
        }
        while let Some(message) = self.link.poll_program() {
            let message: Value = serde_json::from_str(&message).expect("JSON");
            let Some(id) = message.get("id") else {
                continue;
            };
            let both = (
                message.get("result").is_some(),
                message.get("error").is_some(),
            );
            assert!(both.0 != both.1, "a result or an error: {message}");
            let (asked, answered) = self.asked.entry(id.to_string()).or_default();
            *answered += 1;
            assert!(
                answered <= asked,
                "answered more often than asked: {message}"
            );
        }
        while self.link.poll_answered().is_some() {}
    }

    /// Ends the test: the station answers everything, the arms are lost, and no call may be left.
    pub(crate) fn end(mut self) {
        self.answer_all();
        self.event("link-lost");
        self.collect_output();
        self.answer_all();
        self.advance(Duration::from_secs(100_000));
        self.answer_all();
        let open = self.asked.iter().find(|(_, (asked, came))| asked != came);
        assert!(open.is_none(), "not answered: {open:?}");
        self.link.end();
        self.collect_output();
        self.answer_all();
        assert!(
            self.link.poll_timeout().is_none(),
            "nothing is due any more"
        );
    }
}

/// Answer of the station.
enum Answer {
    Good,
    Error(usize),
    Value(Value),
}
