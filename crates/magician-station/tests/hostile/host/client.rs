//! Client end of a socket, and reports of arms.

use std::collections::HashMap;
use std::time::Duration;

use magician::ErrorKind;
use magician_protocol::commands::Pose;
use magician_station::api::RpcError;
use magician_station::{ArmReading, SocketId, ToolReading};
use serde_json::{Map, Value, json};

/// Client end of a socket.
pub(super) struct Client {
    pub(super) socket: SocketId,
    pub(super) session: Option<String>,
    pub(super) closed: bool,
    /// Number of requests and of answers, by id as JSON.
    pub(super) asked: HashMap<String, (usize, usize)>,
    /// Number of messages sent, and of answers received.
    pub(super) sent: usize,
    pub(super) answers: usize,
}

impl Client {
    pub(super) fn hears(&mut self, text: &str) {
        let message: Value = serde_json::from_str(text).expect("JSON");
        assert_eq!(message["jsonrpc"], json!("2.0"));
        if message.get("method").is_some() {
            return;
        }
        assert!(message.get("result").is_some() != message.get("error").is_some());
        self.answers += 1;
        assert!(self.answers <= self.sent, "more answers than messages");
        let id = &message["id"];
        if !id.is_null() {
            let known = self.asked.get_mut(&id.to_string());
            let (asked, came) = known.expect("an answer is to a request");
            *came += 1;
            assert!(came <= asked, "{id} is answered twice");
        }
        if let Some(session) = message["result"]["session"].as_str()
            && message["result"].get("resume").is_some()
        {
            self.session = Some(session.to_owned());
        }
    }
}

/// Returns a reading with this `x`, and numbers that are hard to format.
pub(crate) fn reading(x: f32) -> ArmReading {
    ArmReading {
        age: Duration::ZERO,
        pose: Pose {
            x,
            y: f32::NAN,
            z: f32::INFINITY,
            r: -0.0,
            joint_angle: [0.0; 4],
        },
        current_index: u64::MAX,
        left_space: u32::MAX,
        alarms: vec![0, 255],
        alarm_holds: true,
        link: true,
        moving: true,
        homed: None,
        rail: Some(f32::MAX),
        tool: ToolReading::default(),
        speed: None,
        pins: Vec::new(),
    }
}

/// Returns the error of an arm that does not answer.
pub(super) fn failed() -> RpcError {
    RpcError {
        code: RpcError::ARM,
        message: "no answer".to_owned(),
        data: Map::from_iter([("kind".to_owned(), json!(ErrorKind::Timeout.name()))]),
    }
}
