//! Test bench: a page with its input, its output and a clock that the test advances.

use std::collections::BTreeMap;

use arm::table;
use magician::sim::{Controller, HostInstant, LineTiming, LinkId, Profile, Runner, Speed};
use magician_program::wire::answer;
use serde_json::{Value, json};

/// Interval between turns, us.
const TURN_INTERVAL: f64 = 4_000.0;
/// Time within which every answer must arrive, us. A choice far above any job in these tests.
const ANSWER_TIMEOUT: f64 = 120e6;

/// The far end of the page's serial line: a virtual arm that the page takes for a real one.
pub(crate) struct FarEndArm {
    pub(crate) runner: Runner,
    /// Drops all output of the arm.
    pub(crate) mute: bool,
}

impl FarEndArm {
    pub(crate) fn new() -> Self {
        Self::at(115_200)
    }

    pub(crate) fn at(baud: u32) -> Self {
        let line = LineTiming {
            baud: Some(baud),
            ..LineTiming::default()
        };
        let arm = Controller::new(Profile::default());
        Self {
            runner: Runner::new(arm, Speed::Times(1.0), line),
            mute: false,
        }
    }
}

#[derive(Default)]
pub(crate) struct Page {
    pub(crate) handle: u32,
    /// Time, us.
    pub(crate) now: f64,
    ids: u64,
    /// Texts that arrived for each session and were not taken yet.
    pub(crate) texts: BTreeMap<u16, Vec<Value>>,
    pub(crate) frames: Vec<(u16, Vec<u8>)>,
    pub(crate) closed: Vec<(u16, u16)>,
    /// Latest trace file.
    pub(crate) trace: Vec<u8>,
    /// Requests to read a file. The page answers them with the files' contents unless
    /// `skips_requests` is set.
    pub(crate) asked: Vec<(u32, Vec<u8>)>,
    pub(crate) skips_requests: bool,
    pub(crate) far: Option<FarEndArm>,
    /// Number of bytes sent to the arm, and the command identifiers among them.
    pub(crate) said: usize,
    pub(crate) commands: Vec<u8>,
}

impl Page {
    /// Opens a station with this configuration, before its first turn.
    pub(crate) fn of(config: &Value) -> Self {
        let handle = table::station_open(config.to_string().as_bytes());
        assert!(handle > 0, "{:?}", refusal());
        Self {
            handle,
            // Any clock that has run for a while.
            now: 77e6,
            ..Self::default()
        }
    }

    /// Opens a station with one virtual arm, and waits until it is ready.
    pub(crate) fn ready() -> Self {
        let arms = json!([{"name": "arm", "sim": {}}]);
        let mut page = Self::of(&json!({"arms": arms, "epoch": "t", "unix_zero": 1_000_000.0}));
        page.wait_until_ready();
        page
    }

    pub(crate) fn wait_until_ready(&mut self) {
        let told = self.own();
        assert_eq!(told["ready"], json!(true), "{told}");
    }

    /// Returns the next text of the station itself, which is session 0.
    pub(crate) fn own(&mut self) -> Value {
        let end = self.now + ANSWER_TIMEOUT;
        while self.now < end {
            self.turn();
            if let Some(told) = self.texts.get_mut(&0).and_then(Vec::pop) {
                return told;
            }
        }
        panic!("it never becomes ready");
    }

    /// Advances the clock by one turn, and returns when the next one is due.
    pub(crate) fn turn(&mut self) -> f64 {
        self.turn_at(self.now + TURN_INTERVAL)
    }

    pub(crate) fn turn_at(&mut self, now: f64) -> f64 {
        self.now = now;
        if let Some(far) = &mut self.far {
            let now = HostInstant::from_micros(now as u64);
            far.runner.handle_timeout(now);
            while let Some(bytes) = far.runner.poll_transmit(now, LinkId(0)) {
                if !far.mute {
                    table::line_in(self.handle, bytes.bytes());
                }
            }
        }
        let next = table::station_turn(self.handle, now);
        while let Some(bytes) = table::station_out(self.handle, <[u8]>::to_vec) {
            let (kind, session) = (bytes[0], u16::from_le_bytes([bytes[1], bytes[2]]));
            let payload = bytes[3..].to_vec();
            match kind {
                0 => {
                    let text = serde_json::from_slice(&payload).expect("JSON");
                    self.texts.entry(session).or_default().push(text);
                }
                1 => self.frames.push((session, payload)),
                2 => {
                    self.said += payload.len();
                    // A frame is never split between two outputs.
                    let mut rest = &payload[..];
                    while let [_, _, length, id, ..] = *rest {
                        self.commands.push(id);
                        rest = &rest[usize::from(length) + 4..];
                    }
                    if let Some(far) = &mut self.far {
                        let now = HostInstant::from_micros(now as u64);
                        far.runner.receive(now, LinkId(0), &payload);
                    }
                }
                3 => {
                    let code = u16::from_le_bytes([payload[0], payload[1]]);
                    self.closed.push((session, code));
                }
                4 => self.trace = payload,
                5 => {
                    let id = u32::from_le_bytes(payload[..4].try_into().unwrap());
                    let request = payload[4..].to_vec();
                    if !self.skips_requests && !request.is_empty() {
                        table::file_in(self.handle, id, &answer(&request));
                    }
                    self.asked.push((id, request));
                }
                other => panic!("kind {other}"),
            }
        }
        next
    }

    /// Advances the clock, s.
    pub(crate) fn wait(&mut self, seconds: f64) {
        let end = self.now + seconds * 1e6;
        while self.now < end {
            self.turn();
        }
    }

    pub(crate) fn send(&mut self, session: u16, method: &str, params: &Value) -> u64 {
        self.ids += 1;
        let text = json!({"jsonrpc": "2.0", "id": self.ids, "method": method, "params": params});
        table::station_rpc(self.handle, u32::from(session), text.to_string().as_bytes());
        self.ids
    }

    pub(crate) fn notify(&mut self, session: u16, method: &str, params: &Value) {
        let text = json!({"jsonrpc": "2.0", "method": method, "params": params});
        table::station_rpc(self.handle, u32::from(session), text.to_string().as_bytes());
    }

    /// True if a request was answered.
    pub(crate) fn has(&self, session: u16, id: u64) -> bool {
        let mut texts = self.texts.get(&session).into_iter().flatten();
        texts.any(|text| text["id"] == json!(id))
    }

    /// Waits for the answer to a request.
    pub(crate) fn answer(&mut self, session: u16, id: u64) -> Result<Value, Value> {
        let end = self.now + ANSWER_TIMEOUT;
        while self.now < end {
            self.turn();
            let texts = self.texts.entry(session).or_default();
            let found = texts.iter().position(|text| text["id"] == json!(id));
            if let Some(at) = found {
                let answer = texts.remove(at);
                return match answer.get("error") {
                    Some(error) => Err(error.clone()),
                    None => Ok(answer["result"].clone()),
                };
            }
        }
        panic!("no answer to {id}");
    }

    pub(crate) fn call(
        &mut self,
        session: u16,
        method: &str,
        params: &Value,
    ) -> Result<Value, Value> {
        let id = self.send(session, method, params);
        self.answer(session, id)
    }

    pub(crate) fn ok(&mut self, session: u16, method: &str, params: &Value) -> Value {
        let outcome = self.call(session, method, params);
        outcome.unwrap_or_else(|error| panic!("{method}: {error}"))
    }

    /// Returns the recent traffic as a trace file.
    pub(crate) fn trace(&mut self) -> Vec<u8> {
        table::station_rpc(self.handle, 0, b"trace");
        self.turn();
        std::mem::take(&mut self.trace)
    }

    /// Introduces a session by `session.hello`.
    pub(crate) fn join(&mut self, session: u16) -> Value {
        self.ok(
            session,
            "session.hello",
            &json!({"client": {"name": "page"}}),
        )
    }

    /// Returns the parameters of a session's notifications of one method.
    pub(crate) fn notifications(&self, session: u16, method: &str) -> Vec<&Value> {
        let texts = self.texts.get(&session).into_iter().flatten();
        texts
            .filter(|text| text["method"] == json!(method))
            .map(|text| &text["params"])
            .collect()
    }
}

/// Returns the reason why the last station was not opened.
pub(crate) fn refusal() -> Option<Value> {
    table::station_out(0, |bytes| {
        assert_eq!(bytes[..3], [0, 0, 0]);
        serde_json::from_slice(&bytes[3..]).expect("JSON")
    })
}
