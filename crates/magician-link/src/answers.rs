//! Answers of the station: what each means for the program, and which call follows.
//!
//! One call of a program may need several calls of the station. Each of those carries a
//! [`Continuation`], which says what to do with its answer; it holds everything that is needed to
//! continue, so the link keeps no other state about a call.

use magician_protocol::HostInstant;
use serde_json::{Map, Value, json};

use crate::error::{ErrorCode, LinkError};
use crate::link::{ArmLink, Link, PendingCall, Write, WriteAnswer};
use crate::methods::Method;
use crate::params::CallOptions;
use crate::{results, wire};

/// Tools by their number in `EndEffectorType`.
pub(crate) const TOOLS: [&str; 3] = ["laser", "suction", "gripper"];

/// Commands that `GetEndEffectorStatus` reads, and the names of their values in its answer.
const END_EFFECTORS: [(&str, &str); 3] = [
    ("EndEffectorLaser", "laser"),
    ("EndEffectorSuctionCup", "suctionCup"),
    ("EndEffectorGripper", "gripper"),
];

/// Next action of the link once the station has answered.
#[derive(Debug)]
pub(crate) enum Continuation {
    Nothing,
    Hello,
    Ports {
        pending: PendingCall,
        filter: Vec<String>,
        /// True to include whether each port is free.
        status: bool,
    },
    /// Look for the arm to connect in the list of arms.
    Find {
        pending: PendingCall,
        port: String,
        start: bool,
    },
    /// Check that the arm answers, before it is connected.
    Probe(Box<ConnectingArm>),
    /// Connect the arm, with or without the lease.
    Connected(Box<ConnectingArm>),
    Lease(String),
    Subscribed {
        arm: String,
        fast: bool,
    },
    Fields {
        pending: PendingCall,
        method: &'static Method,
    },
    Raw {
        pending: PendingCall,
        method: &'static Method,
    },
    Written {
        arm: String,
        write: Write,
    },
    Stopped(PendingCall),
    EndEffectors {
        pending: PendingCall,
        arm: String,
        read: Map<String, Value>,
    },
    ToolRotation(ToolRotation),
    Homed(PendingCall),
    Tool(PendingCall),
    Reach(PendingCall),
    Ratio {
        pending: PendingCall,
        arm: String,
        command: &'static str,
        kind: f64,
        set: Option<f64>,
    },
}

/// Arm that is being connected.
#[derive(Debug)]
pub(crate) struct ConnectingArm {
    pending: PendingCall,
    arm: String,
    names: Vec<String>,
    is_virtual: bool,
    start: bool,
    version: String,
}

/// Rotation of the tool, to be sent once the current pose is known.
#[derive(Debug)]
pub(crate) struct ToolRotation {
    pub(crate) pending: PendingCall,
    pub(crate) arm: String,
    pub(crate) r: f64,
    pub(crate) options: CallOptions,
}

impl Continuation {
    /// Returns the program's call for which the station was called. `None` for calls of the link
    /// itself.
    pub(crate) fn pending(&self) -> Option<&PendingCall> {
        match self {
            Self::Nothing | Self::Hello | Self::Lease(_) | Self::Subscribed { .. } => None,
            Self::Probe(found) | Self::Connected(found) => Some(&found.pending),
            Self::Written { write, .. } => Some(&write.pending),
            Self::ToolRotation(rotation) => Some(&rotation.pending),
            Self::Ports { pending, .. }
            | Self::Find { pending, .. }
            | Self::Fields { pending, .. }
            | Self::Raw { pending, .. }
            | Self::Stopped(pending)
            | Self::EndEffectors { pending, .. }
            | Self::Homed(pending)
            | Self::Tool(pending)
            | Self::Reach(pending)
            | Self::Ratio { pending, .. } => Some(pending),
        }
    }
}

impl Link {
    pub(crate) fn resume_call(
        &mut self,
        now: HostInstant,
        continuation: Continuation,
        outcome: Result<Value, LinkError>,
    ) {
        match continuation {
            Continuation::Nothing => {}
            Continuation::Hello => {
                self.session = text_member(&outcome, "session");
            }
            Continuation::Ports {
                pending,
                filter,
                status,
            } => {
                let list = outcome.map(|value| self.ports(&value, &filter, status));
                self.answer(&pending, &list);
            }
            Continuation::Find {
                pending,
                port,
                start,
            } => self.find_arm(pending, &port, start, outcome),
            Continuation::Probe(found) => self.handle_probe(*found, outcome),
            Continuation::Connected(found) => self.complete_connection(*found, outcome),
            Continuation::Lease(name) => self.handle_lease(&name, outcome),
            Continuation::Subscribed { arm, fast } => {
                let id = { outcome.as_ref().ok() }
                    .and_then(|value| value.get("subscription"))
                    .and_then(Value::as_u64);
                if let Some(id) = id {
                    self.subscribed(&arm, fast, id);
                }
            }
            Continuation::Fields { pending, method } => {
                let result = outcome.map(|fields| results::result(method, &fields));
                self.answer(&pending, &result);
            }
            Continuation::Raw { pending, method } => {
                let result = outcome.map(|value| raw_result(method, &value));
                self.answer(&pending, &result);
            }
            Continuation::Written { arm, write } => {
                self.handle_write_result(now, &arm, write, outcome)
            }
            Continuation::Stopped(pending) => self.answer(&pending, &outcome.map(|_| json!(true))),
            Continuation::EndEffectors {
                pending,
                arm,
                mut read,
            } => match outcome {
                Err(error) => self.answer(&pending, &Err(error)),
                Ok(fields) => {
                    if let Some((command, name)) = END_EFFECTORS.get(read.len()) {
                        let method = Method::named(&format!("Get{command}"));
                        let value = method.map(|method| results::result(method, &fields));
                        read.insert((*name).to_owned(), value.unwrap_or_default());
                    }
                    self.read_effectors(Continuation::EndEffectors { pending, arm, read });
                }
            },
            Continuation::ToolRotation(rotation) => self.rotate_at_pose(now, rotation, outcome),
            Continuation::Homed(pending) => {
                let is_at_rest = |state: Value| state.get("moving") != Some(&json!(true));
                let result = outcome.map(|state| json!({"isFinished": is_at_rest(state)}));
                self.answer(&pending, &result);
            }
            Continuation::Tool(pending) => {
                let result = outcome.and_then(|state| {
                    let name = state.get("tool").and_then(|tool| tool.get("name"));
                    let name = name.and_then(Value::as_str).unwrap_or_default();
                    let at = TOOLS.iter().position(|tool| *tool == name);
                    let why = "the arm has a tool without a number";
                    at.map(|at| json!({"type": at}))
                        .ok_or_else(|| LinkError::command(why))
                });
                self.answer(&pending, &result);
            }
            Continuation::Reach(pending) => {
                let result = match outcome {
                    Ok(_) => Ok(json!({"isLimited": false})),
                    // Out of reach is the answer to this question, not an error.
                    Err(error) if error.code == ErrorCode::COMMAND => {
                        Ok(json!({"isLimited": true}))
                    }
                    Err(error) => Err(error),
                };
                self.answer(&pending, &result);
            }
            Continuation::Ratio {
                pending,
                arm,
                command,
                kind,
                set,
            } => self.handle_ratio(now, &pending, &arm, command, (kind, set), outcome),
        }
    }

    /// Returns the list of arms as a list of ports.
    fn ports(&self, value: &Value, filter: &[String], status: bool) -> Value {
        let list = value.get("arms").and_then(Value::as_array);
        let ports = list.into_iter().flatten().filter_map(|arm| {
            let text = |name: &str| arm.get(name).and_then(Value::as_str);
            let (name, port) = (text("name")?, text("port")?);
            let port_name = port_name(name, port);
            let lower = port_name.to_lowercase();
            if filter.iter().any(|word| lower.contains(word)) {
                return None;
            }
            let is_virtual = arm.get("virtual") == Some(&json!(true));
            // The description is for people; programs use `portName`.
            let kind = if is_virtual {
                "virtual Magician"
            } else {
                "Magician"
            };
            let mut entry = json!({"portName": port_name, "description": format!("{kind} {name}")});
            if status {
                let held = arm.get("holder").is_some_and(|holder| !holder.is_null());
                entry["status"] = json!(match (self.arms.contains_key(name), held) {
                    (true, _) => "connected",
                    (false, true) => "occupied",
                    (false, false) => "unconnected",
                });
            }
            Some(entry)
        });
        json!(ports.collect::<Vec<_>>())
    }

    fn find_arm(
        &mut self,
        pending: PendingCall,
        port: &str,
        start: bool,
        outcome: Result<Value, LinkError>,
    ) {
        let value = match outcome {
            Ok(value) => value,
            Err(error) => return self.answer(&pending, &Err(error)),
        };
        let list = value.get("arms").and_then(Value::as_array);
        let found = list.into_iter().flatten().find_map(|arm| {
            let text = |name: &str| arm.get(name).and_then(Value::as_str);
            let (name, at) = (text("name")?, text("port")?);
            // The program sees the first of these names, so the order matters.
            let names = vec![port_name(name, at), name.to_owned(), at.to_owned()];
            // Port names on Windows ignore case.
            let is_it = names.iter().any(|name| name.eq_ignore_ascii_case(port));
            is_it.then(|| {
                (
                    name.to_owned(),
                    names,
                    arm.get("virtual") == Some(&json!(true)),
                )
            })
        });
        let Some((arm, names, is_virtual)) = found else {
            let why = "no arm of this station has that port";
            return self.answer(&pending, &Err(LinkError::new(ErrorCode::NOT_FOUND, why)));
        };
        // A cheap read that every arm answers. The program gets the version in the answer to
        // ConnectDobot.
        let probe = json!({"arm": arm, "command": "DeviceVersion"});
        let found = ConnectingArm {
            pending,
            arm,
            names,
            is_virtual,
            start,
            version: String::new(),
        };
        self.call("arm.get", probe, Continuation::Probe(Box::new(found)));
    }

    fn handle_probe(&mut self, mut found: ConnectingArm, outcome: Result<Value, LinkError>) {
        let fields = match outcome {
            Ok(fields) => fields,
            Err(error) => {
                let why = format!("no arm answers: {}", error.message);
                let error = LinkError::new(ErrorCode::NOT_CONNECTED, why);
                return self.answer(&found.pending, &Err(error));
            }
        };
        let number = |name: &str| fields.get(name).and_then(Value::as_u64).unwrap_or(0);
        found.version = format!(
            "{}.{}.{}",
            number("major_version"),
            number("minor_version"),
            number("revision")
        );
        let lease = json!({"arm": found.arm});
        self.call(
            "lease.acquire",
            lease,
            Continuation::Connected(Box::new(found)),
        );
    }

    /// Completes the connection. With the lease the program may move the arm; without it, the
    /// program may only read and stop it.
    fn complete_connection(&mut self, found: ConnectingArm, outcome: Result<Value, LinkError>) {
        let again = self.arms.contains_key(&found.arm);
        let arm = self
            .arms
            .entry(found.arm.clone())
            .or_insert_with(|| ArmLink {
                port_name: found.names.first().cloned().unwrap_or_default(),
                names: found.names.clone(),
                is_virtual: found.is_virtual,
                ..ArmLink::default()
            });
        let lease = text_member(&outcome, "lease");
        // A second ConnectDobot keeps a lease that the session already has.
        arm.lease = lease.or(arm.lease.take());
        arm.starts_queue = found.start;
        if found.start && arm.lease.is_some() {
            self.start_queue(&found.arm);
        }
        // A second ConnectDobot keeps the slow subscription of the first one.
        if !again {
            self.subscribe_slow(&found.arm);
        }
        let empty = self.options.empty_connect;
        let text = |text: &str| {
            if empty {
                String::new()
            } else {
                text.to_owned()
            }
        };
        let result = json!({
            "productName": text("Magician"),
            "firmwareName": text("Dobot"),
            "firmwareVersion": text(&found.version),
        });
        self.answer(&found.pending, &Ok(result));
    }

    fn handle_lease(&mut self, name: &str, outcome: Result<Value, LinkError>) {
        let lease = text_member(&outcome, "lease");
        if let (Some(arm), Some(lease)) = (self.arms.get_mut(name), lease) {
            arm.lease = Some(lease);
        }
    }

    /// Reads the next tool, or answers with all of them.
    pub(crate) fn read_effectors(&mut self, continuation: Continuation) {
        let Continuation::EndEffectors { pending, arm, read } = continuation else {
            return;
        };
        match END_EFFECTORS.get(read.len()) {
            // In sequence, because the program gets either all values or the first error.
            Some((command, _)) => {
                let get = json!({"arm": arm, "command": command});
                self.call(
                    "arm.get",
                    get,
                    Continuation::EndEffectors { pending, arm, read },
                );
            }
            None => self.answer(&pending, &Ok(Value::Object(read))),
        }
    }

    fn rotate_at_pose(
        &mut self,
        now: HostInstant,
        rotation: ToolRotation,
        outcome: Result<Value, LinkError>,
    ) {
        let pose = match outcome {
            Ok(pose) => pose,
            Err(error) => return self.answer(&rotation.pending, &Err(error)),
        };
        // Like DobotLink: a joint move to the current position, with another r.
        let fields = json!({
            "ptp_mode": 1, "x": pose["x"], "y": pose["y"], "z": pose["z"], "r": rotation.r,
        });
        let params = json!({"arm": rotation.arm, "command": "PTPCmd", "fields": fields});
        let (options, answer) = (&rotation.options, rotation.options.answer(false));
        let write =
            Write::new(&rotation.pending, options.method(), params, answer).with_options(options);
        self.write(now, &rotation.arm, write);
    }

    fn handle_ratio(
        &mut self,
        now: HostInstant,
        pending: &PendingCall,
        arm: &str,
        command: &'static str,
        (kind, set): (f64, Option<f64>),
        outcome: Result<Value, LinkError>,
    ) {
        let mut fields = match outcome {
            Ok(fields) => fields,
            Err(error) => return self.answer(pending, &Err(error)),
        };
        let name = match fields.get("velocity_ratio") {
            Some(_) => "velocity_ratio",
            None => "velocity",
        };
        match set {
            None => {
                let value = fields.get(name).and_then(Value::as_f64).unwrap_or_default();
                // A real arm answers with one byte.
                let value = value.round().clamp(0.0, 255.0) as u8;
                self.answer(pending, &Ok(json!({"type": kind as u8, "value": value})));
            }
            Some(value) => {
                fields[name] = json!(value);
                let params = json!({"arm": arm, "command": command, "fields": fields});
                self.write(
                    now,
                    arm,
                    Write::new(pending, "arm.set", params, WriteAnswer::True),
                );
            }
        }
    }
}

/// Returns the result of a command without a row in the protocol's table.
pub(crate) fn raw_result(method: &Method, value: &Value) -> Value {
    if method.results.is_empty() {
        return json!(true);
    }
    let params = value.get("params").and_then(Value::as_str);
    wire::decode(method, params.unwrap_or_default())
}

/// Returns a text from an answer. `None` for a refusal.
fn text_member(outcome: &Result<Value, LinkError>, name: &str) -> Option<String> {
    let text = outcome.as_ref().ok()?.get(name)?.as_str()?;
    Some(text.to_owned())
}

/// Returns a port as DobotLink names it: the last part of a path, or `COM3`. The name of the arm if
/// it has no serial port.
fn port_name(name: &str, port: &str) -> String {
    let last = port.rsplit('/').next().unwrap_or(port);
    let serial = port.starts_with('/') || port.to_ascii_uppercase().starts_with("COM");
    if serial {
        last.to_owned()
    } else {
        name.to_owned()
    }
}
