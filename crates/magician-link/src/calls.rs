//! Calls of programs, translated to calls of the station.

use magician_protocol::{HostInstant, Row};
use serde_json::{Map, Value, json};

use crate::answers::{Continuation, ToolRotation};
use crate::error::{ErrorCode, LinkError};
use crate::link::{Link, PendingCall, Write, WriteAnswer};
use crate::methods::{Access, Method, VirtualAnswer};
use crate::params::{CallOptions, CheckedParams};
use crate::rpc::Request;
use crate::wire;

/// Calls that only the Magician Lite has, for sensors at its sockets.
const LITE_CALLS: [&str; 8] = [
    "GetSeeedColorSensor",
    "GetSeeedDistanceSensor",
    "GetSeeedLightSensor",
    "GetSeeedTempSensor",
    "SetSeeedColorSensor",
    "SetSeeedLightSensor",
    "SetSeeedRGBLed",
    "SetSeeedTempSensor",
];

/// Calls of the Magic Box.
const MAGIC_BOX_CALLS: [&str; 3] = ["DownloadProgram", "CheckBoxSpace", "ClearBoxSpace"];

/// Calls for DobotLink's user interface, which does not exist here. Programs stop if these calls
/// fail, so they succeed without effect.
const WINDOW_CALLS: [&str; 9] = [
    "ShowMessage",
    "ShowSerialPortTool",
    "ShowHelpMenu",
    "ShowCommMonitor",
    "ShowSystemTray",
    "CleanLogs",
    "OpenLogFile",
    "OpenLogDir",
    "SwitchLanguage",
];

impl Link {
    /// Carries out a request.
    pub(crate) fn handle_request(&mut self, now: HostInstant, request: Request) {
        let target = request.target.to_ascii_lowercase();
        let mut pending = PendingCall {
            id: request.id,
            method: format!("{}.{}", request.target, request.api),
            unknown_params: Vec::new(),
        };
        // Names come from the program and are keys of the report: anything that cannot be a name is
        // counted as unknown.
        if pending.method.len() > 80 || !pending.method.is_ascii() {
            pending.method = "unknown".to_owned();
        }
        let (api, params) = (request.api.as_str(), &request.params);
        let done = match target.as_str() {
            "magician" | "magicianlite" => self.handle_arm_call(now, &mut pending, api, params),
            "api" => self.handle_server_call(&pending, api),
            _ => {
                let why = "there is no such target: Magician, MagicianLite, api";
                Err(LinkError::new(ErrorCode::NO_TARGET, why))
            }
        };
        if let Err(error) = done {
            self.answer(&pending, &Err(error));
        }
    }

    /// Handles a call of the server itself.
    fn handle_server_call(&mut self, pending: &PendingCall, api: &str) -> Result<(), LinkError> {
        let result = match api {
            "ShowAvailablePorts" => {
                let continuation = Continuation::Ports {
                    pending: pending.clone(),
                    filter: Vec::new(),
                    status: false,
                };
                self.call("arm.list", json!({}), continuation);
                return Ok(());
            }
            "GetVersion" | "GetLatestVersion" => json!({"version": self.options.version}),
            "GetPluginList" => json!({"MagicDevice": self.options.version}),
            "GetLog" => json!({"data": ""}),
            // No effect here, but programs expect success.
            "SetLogger" | "SetProcessName" | "CloseDobotLink" | "DownloadFile" => json!(true),
            api if WINDOW_CALLS.contains(&api) => json!(true),
            // Refuses `RunCmd` too, which starts any program on the computer.
            _ => return Err(no_api(api)),
        };
        self.answer(pending, &Ok(result));
        Ok(())
    }

    /// Handles a call of an arm.
    fn handle_arm_call(
        &mut self,
        now: HostInstant,
        pending: &mut PendingCall,
        api: &str,
        params: &Map<String, Value>,
    ) -> Result<(), LinkError> {
        if LITE_CALLS.contains(&api) || MAGIC_BOX_CALLS.contains(&api) {
            return Err(LinkError::command(format!("a Magician has no {api}")));
        }
        // Needs no port, unlike the calls below.
        if api == "SearchDobot" {
            let filter = params
                .get("filter")
                .and_then(Value::as_str)
                .unwrap_or_default();
            let continuation = Continuation::Ports {
                pending: pending.clone(),
                filter: filter.split_whitespace().map(str::to_lowercase).collect(),
                status: true,
            };
            self.call("arm.list", json!({}), continuation);
            return Ok(());
        }
        let method = Method::named(api);
        let special = [
            "ConnectDobot",
            "DisconnectDobot",
            "SetCommuTimeout",
            "SetRCmd",
            "GetEndEffectorStatus",
        ];
        if method.is_none() && !special.contains(&api) {
            return Err(no_api(api));
        }
        let port = match params.get("portName") {
            Some(Value::String(port)) if !port.is_empty() => port,
            _ => {
                let why = "`portName` must name a port";
                return Err(LinkError::new(ErrorCode::PORT_NAME, why));
            }
        };
        if api == "ConnectDobot" {
            let continuation = Continuation::Find {
                pending: pending.clone(),
                port: port.clone(),
                start: params.get("queueStart") != Some(&json!(false)),
            };
            self.call("arm.list", json!({}), continuation);
            return Ok(());
        }
        let connected = { self.arms.iter() }
            .find(|(_, arm)| arm.names.iter().any(|name| name.eq_ignore_ascii_case(port)));
        let Some((name, arm)) = connected else {
            let why = "the arm is not connected: ConnectDobot comes first";
            return Err(LinkError::new(ErrorCode::NOT_CONNECTED, why));
        };
        let (name, is_virtual) = (name.clone(), arm.is_virtual);
        match (api, method) {
            ("DisconnectDobot", _) => {
                self.disconnect_arm(&name);
                self.answer(pending, &Ok(json!(true)));
            }
            // The driver's own timeouts apply.
            ("SetCommuTimeout", _) => self.answer(pending, &Ok(json!(true))),
            ("GetEndEffectorStatus", _) => {
                let continuation = Continuation::EndEffectors {
                    pending: pending.clone(),
                    arm: name.clone(),
                    read: Map::new(),
                };
                self.read_effectors(continuation);
            }
            ("SetRCmd", _) => self.rotate_tool(pending, &name, params)?,
            (_, Some(method)) => {
                let checked = CheckedParams::check(method, params)?;
                pending.unknown_params.clone_from(&checked.unknown_params);
                if self.options.strict && !checked.unknown_params.is_empty() {
                    let names = checked.unknown_params.join("`, `");
                    return Err(LinkError::params(format!("{api} has no `{names}`")));
                }
                let options = CallOptions::of(method, params)?;
                self.check_permitted(method)?;
                match (&method.command, method.access) {
                    (Some(command), Access::Read) => {
                        let mut read = json!({"arm": name, "command": command});
                        let query = checked.fields();
                        if !query.is_empty() {
                            read["query"] = Value::Object(query);
                        }
                        let pending = pending.clone();
                        self.call("arm.get", read, Continuation::Fields { pending, method });
                    }
                    (Some(_), Access::Write) => {
                        self.send_command(now, pending, &name, method, &checked, &options)
                    }
                    // The virtual arm knows only the protocol's table.
                    (None, _) if is_virtual => {
                        self.answer_for_virtual(now, pending, &name, method, &checked)?
                    }
                    (None, _) => {
                        self.send_raw_command(now, pending, &name, method, &checked, &options)?
                    }
                }
            }
            (_, None) => return Err(no_api(api)),
        }
        Ok(())
    }

    /// Checks whether a call is permitted.
    fn check_permitted(&self, method: &Method) -> Result<(), LinkError> {
        if method.refused.is_some() {
            let why = "firmware and restart are not for programs";
            return Err(LinkError::new(ErrorCode::NEVER, why));
        }
        let danger = method.row().and_then(Row::danger);
        let danger = danger.or(method
            .dangerous
            .then_some("can brick, uncalibrate or unlock the arm"));
        if let Some(danger) = danger
            // Reading, for instance a calibration, is harmless.
            && method.access == Access::Write
            && !self.options.dangerous
        {
            let why = format!("{} {danger}: start with --link-dangerous", method.name);
            return Err(LinkError::command(why));
        }
        Ok(())
    }

    /// Writes a command that is in the protocol's table.
    fn send_command(
        &mut self,
        now: HostInstant,
        pending: &PendingCall,
        name: &str,
        method: &'static Method,
        checked: &CheckedParams,
        options: &CallOptions,
    ) {
        let command = method.command.as_deref().unwrap_or_default();
        let stops = matches!(
            command,
            "QueuedCmdStopExec" | "QueuedCmdForceStopExec" | "QueuedCmdClear"
        );
        // Some programs force a stop with a parameter of `QueuedCmdStop` instead of calling
        // `QueuedCmdForceStop`.
        let forced = checked.get("forceStop") == Some(&json!(true));
        let command = if forced {
            "QueuedCmdForceStopExec"
        } else {
            command
        };
        if stops {
            // Calls made before the stop must not run after it.
            self.cancel(name, &LinkError::cancelled("the queue was stopped"));
            let holds = self.arms.get(name).is_some_and(|arm| arm.lease.is_some());
            if !holds && command != "QueuedCmdClear" {
                // Stopping needs no lease.
                let continuation = Continuation::Stopped(pending.clone());
                return self.call("arm.stop", json!({"arm": name}), continuation);
            }
        }
        // Jogs become jogs of the station, with a keep-alive; command 0 ends a jog.
        if command == "JOGCmd" && checked.number("cmd") != 0.0 {
            return match jog_axis(checked, options) {
                Ok(axis) => self.start_jog(now, pending, name, &axis),
                Err(error) => self.answer(pending, &Err(error)),
            };
        }
        // Only a jog of this program is ended as a jog; otherwise the command goes to the arm.
        if command == "JOGCmd" && self.arms.get(name).is_some_and(|arm| arm.is_jogging) {
            return self.stop_jog(name, Continuation::Stopped(pending.clone()));
        }
        let fields = if stops { Map::new() } else { checked.fields() };
        let mut params = json!({"arm": name, "command": command});
        if !fields.is_empty() {
            params["fields"] = Value::Object(fields);
        }
        // Two separate flags: `row.dangerous` allows dangerous commands (checked above), `laser`
        // allows burning. The station asks for `yes` in both cases.
        if method.row().is_some_and(|row| row.dangerous) || self.options.laser {
            params["yes"] = json!(true);
        }
        let answer = match command {
            _ if stops => WriteAnswer::StopQueue,
            _ => options.answer(command == "HOMECmd"),
        };
        let write = Write::new(pending, options.method(), params, answer).with_options(options);
        self.write(now, name, write);
    }

    /// Sends a command without a row in the protocol's table to a real arm.
    fn send_raw_command(
        &mut self,
        now: HostInstant,
        pending: &PendingCall,
        name: &str,
        method: &'static Method,
        checked: &CheckedParams,
        options: &CallOptions,
    ) -> Result<(), LinkError> {
        let mut params = json!({"arm": name, "id": method.id, "params": wire::encode(checked)?});
        if method.access == Access::Read {
            let pending = pending.clone();
            self.call("link.read", params, Continuation::Raw { pending, method });
            return Ok(());
        }
        params["queued"] = json!(options.queued);
        params["moves"] = json!(method.moves);
        let answer = match (method.results.is_empty(), options.queued) {
            (false, _) => WriteAnswer::Raw(method),
            (true, true) => WriteAnswer::Index,
            (true, false) => WriteAnswer::True,
        };
        let write = Write::new(pending, "link.write", params, answer).with_options(options);
        self.write(now, name, write);
        Ok(())
    }

    /// Answers a command without a row in the protocol's table for a virtual arm.
    fn answer_for_virtual(
        &mut self,
        now: HostInstant,
        pending: &PendingCall,
        name: &str,
        method: &'static Method,
        checked: &CheckedParams,
    ) -> Result<(), LinkError> {
        let pending = pending.clone();
        let reads = method.access == Access::Read;
        let get = |command: &str| json!({"arm": name, "command": command});
        let type_number = checked.number("type");
        match method.virtual_answer {
            Some(VirtualAnswer::ProductName) => {
                self.answer(&pending, &Ok(json!({"productName": "Magician"})));
            }
            Some(VirtualAnswer::Homing) => {
                let continuation = Continuation::Homed(pending);
                self.call("arm.state", json!({"arm": name}), continuation);
            }
            Some(VirtualAnswer::Tool) if reads => {
                self.call(
                    "arm.state",
                    json!({"arm": name}),
                    Continuation::Tool(pending),
                );
            }
            Some(VirtualAnswer::Tool) => {
                let tool = crate::answers::TOOLS.get(type_number as usize);
                let tool = tool.ok_or_else(|| LinkError::params("`type` is 0 to 2"))?;
                let write = Write::new(
                    &pending,
                    "arm.tool",
                    json!({"arm": name, "tool": tool}),
                    WriteAnswer::True,
                );
                self.write(now, name, write);
            }
            Some(VirtualAnswer::ArmSpeed | VirtualAnswer::RailSpeed) => {
                let rail = method.virtual_answer == Some(VirtualAnswer::RailSpeed);
                let command = match (rail, type_number == 0.0) {
                    (false, true) => "JOGCommonParams",
                    (false, false) => "PTPCommonParams",
                    (true, true) => "JOGLParams",
                    (true, false) => "PTPLParams",
                };
                let set = (!reads).then(|| checked.number("value"));
                let continuation = Continuation::Ratio {
                    pending,
                    arm: name.to_owned(),
                    command,
                    kind: type_number,
                    set,
                };
                self.call("arm.get", get(command), continuation);
            }
            Some(VirtualAnswer::Reach) => {
                let numbers = ["x", "y", "z", "r"].map(|axis| checked.number(axis));
                let joints = checked.get("isJoint") == Some(&json!(true));
                let (name, params) = if joints {
                    ("motion.forward", json!({"joints": numbers}))
                } else {
                    ("motion.inverse", json!({"pose": numbers}))
                };
                self.call(name, params, Continuation::Reach(pending));
            }
            None => {
                let why = format!("a virtual arm has no {}", method.name);
                return Err(LinkError::command(why));
            }
        }
        Ok(())
    }

    /// Turns the tool at the current position.
    fn rotate_tool(
        &mut self,
        pending: &PendingCall,
        name: &str,
        params: &Map<String, Value>,
    ) -> Result<(), LinkError> {
        // The protocol has no command for `SetRCmd`: send a move with the same options.
        let move_method = Method::named("SetPTPCmd").ok_or_else(|| no_api("SetRCmd"))?;
        let options = CallOptions::of(move_method, params)?;
        let r = { params.get("r") }
            .and_then(Value::as_f64)
            .ok_or_else(|| LinkError::params("`r` must be a number"))?;
        let continuation = Continuation::ToolRotation(ToolRotation {
            pending: pending.clone(),
            arm: name.to_owned(),
            r,
            options,
        });
        self.call(
            "arm.get",
            json!({"arm": name, "command": "Pose"}),
            continuation,
        );
        Ok(())
    }
}

/// Returns axis and direction of a jog in the station's form (document 1.9.4, errata E25).
fn jog_axis(checked: &CheckedParams, options: &CallOptions) -> Result<String, LinkError> {
    if options.queued {
        let why = "a jog in the queue only ends at a limit: leave out `isQueued`";
        return Err(LinkError::command(why));
    }
    let cmd = checked.number("cmd");
    let joint = { checked.get("isJoint") }
        .is_some_and(|joint| joint.as_bool() == Some(true) || joint.as_f64() == Some(1.0));
    let axes = if joint {
        ["j1", "j2", "j3", "j4", "l"]
    } else {
        ["x", "y", "z", "r", "l"]
    };
    let number = (1.0..=10.0).contains(&cmd).then(|| cmd as usize - 1);
    let axis = number.and_then(|number| Some((axes.get(number / 2)?, number % 2)));
    match axis {
        Some((axis, 0)) => Ok(format!("{axis}+")),
        Some((axis, _)) => Ok(format!("{axis}-")),
        None => Err(LinkError::params("`cmd` is 0 to 10")),
    }
}

fn no_api(api: &str) -> LinkError {
    let name: String = api
        .chars()
        .filter(char::is_ascii_graphic)
        // Bounded, because the name comes from the program and is repeated in the message.
        .take(60)
        .collect();
    LinkError::new(ErrorCode::NO_API, format!("there is no {name}"))
}
