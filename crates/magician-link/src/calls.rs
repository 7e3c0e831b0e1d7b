//! Calls of programs, translated to calls of the station.

use magician_protocol::{HostInstant, Row};
use serde_json::{Map, Value, json};

use crate::answers::{Then, Turn};
use crate::error::{ErrorCode, LinkError};
use crate::link::{Asked, Link, Write, WriteEnd};
use crate::methods::{Access, Method, VirtualAnswer};
use crate::params::{CallParams, Manner};
use crate::rpc::Request;
use crate::wire;

/// Calls that only the Magician Lite has, for sensors at its sockets.
const OF_LITE: [&str; 8] = [
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
const OF_BOX: [&str; 3] = ["DownloadProgram", "CheckBoxSpace", "ClearBoxSpace"];

/// Calls that open a window. There is no window, so they succeed without effect, or programs would
/// stop.
const WINDOWS: [&str; 9] = [
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
    pub(crate) fn take(&mut self, now: HostInstant, request: Request) {
        let target = request.target.to_ascii_lowercase();
        let mut asked = Asked {
            id: request.id,
            method: format!("{}.{}", request.target, request.api),
            odd: Vec::new(),
        };
        // Names come from the program and are keys of the report: anything that cannot be a name is
        // counted as unknown.
        if asked.method.len() > 80 || !asked.method.is_ascii() {
            asked.method = "unknown".to_owned();
        }
        let (api, params) = (request.api.as_str(), &request.params);
        let done = match target.as_str() {
            "magician" | "magicianlite" => self.device(now, &mut asked, api, params),
            "api" => self.server(&asked, api),
            _ => {
                let why = "there is no such target: Magician, MagicianLite, api";
                Err(LinkError::new(ErrorCode::NO_TARGET, why))
            }
        };
        if let Err(error) = done {
            self.answer(&asked, &Err(error));
        }
    }

    /// Handles a call of the server itself.
    fn server(&mut self, asked: &Asked, api: &str) -> Result<(), LinkError> {
        let result = match api {
            "ShowAvailablePorts" => {
                let then = Then::Ports {
                    asked: asked.clone(),
                    filter: Vec::new(),
                    status: false,
                };
                self.call("arm.list", json!({}), then);
                return Ok(());
            }
            "GetVersion" | "GetLatestVersion" => json!({"version": self.options.version}),
            "GetPluginList" => json!({"MagicDevice": self.options.version}),
            "GetLog" => json!({"data": ""}),
            // No effect here, but programs expect success.
            "SetLogger" | "SetProcessName" | "CloseDobotLink" | "DownloadFile" => json!(true),
            api if WINDOWS.contains(&api) => json!(true),
            // Also `RunCmd`, which starts any program on the computer.
            _ => return Err(no_api(api)),
        };
        self.answer(asked, &Ok(result));
        Ok(())
    }

    /// Handles a call of an arm.
    fn device(
        &mut self,
        now: HostInstant,
        asked: &mut Asked,
        api: &str,
        params: &Map<String, Value>,
    ) -> Result<(), LinkError> {
        if OF_LITE.contains(&api) || OF_BOX.contains(&api) {
            return Err(LinkError::command(format!("a Magician has no {api}")));
        }
        // Needs no port, unlike the calls below.
        if api == "SearchDobot" {
            let filter = params
                .get("filter")
                .and_then(Value::as_str)
                .unwrap_or_default();
            let then = Then::Ports {
                asked: asked.clone(),
                filter: filter.split_whitespace().map(str::to_lowercase).collect(),
                status: true,
            };
            self.call("arm.list", json!({}), then);
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
            let then = Then::Find {
                asked: asked.clone(),
                port: port.clone(),
                start: params.get("queueStart") != Some(&json!(false)),
            };
            self.call("arm.list", json!({}), then);
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
                self.leave(&name);
                self.answer(asked, &Ok(json!(true)));
            }
            // The driver's own timeouts apply.
            ("SetCommuTimeout", _) => self.answer(asked, &Ok(json!(true))),
            ("GetEndEffectorStatus", _) => {
                let then = Then::Effectors {
                    asked: asked.clone(),
                    arm: name.clone(),
                    read: Map::new(),
                };
                self.effectors(then);
            }
            ("SetRCmd", _) => self.turn(asked, &name, params)?,
            (_, Some(method)) => {
                let given = CallParams::check(method, params)?;
                asked.odd.clone_from(&given.odd);
                if self.options.strict && !given.odd.is_empty() {
                    let names = given.odd.join("`, `");
                    return Err(LinkError::params(format!("{api} has no `{names}`")));
                }
                let manner = Manner::of(method, params)?;
                self.allowed(method)?;
                match (&method.command, method.access) {
                    (Some(command), Access::Read) => {
                        let mut read = json!({"arm": name, "command": command});
                        let query = given.fields();
                        if !query.is_empty() {
                            read["query"] = Value::Object(query);
                        }
                        let asked = asked.clone();
                        self.call("arm.get", read, Then::Fields { asked, method });
                    }
                    (Some(_), Access::Write) => {
                        self.command(now, asked, &name, method, &given, &manner)
                    }
                    // The virtual arm knows only the protocol's table.
                    (None, _) if is_virtual => self.pretend(now, asked, &name, method, &given)?,
                    (None, _) => self.raw(now, asked, &name, method, &given, &manner)?,
                }
            }
            (_, None) => return Err(no_api(api)),
        }
        Ok(())
    }

    /// Checks whether a call is permitted.
    fn allowed(&self, method: &Method) -> Result<(), LinkError> {
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
    fn command(
        &mut self,
        now: HostInstant,
        asked: &Asked,
        name: &str,
        method: &'static Method,
        given: &CallParams,
        manner: &Manner,
    ) {
        let command = method.command.as_deref().unwrap_or_default();
        let stops = matches!(
            command,
            "QueuedCmdStopExec" | "QueuedCmdForceStopExec" | "QueuedCmdClear"
        );
        // Some programs force a stop by a parameter instead of the other call.
        let forced = given.get("forceStop") == Some(&json!(true));
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
                let then = Then::Stopped(asked.clone());
                return self.call("arm.stop", json!({"arm": name}), then);
            }
        }
        // Jogs become jogs of the station, with a keep-alive; command 0 ends a jog.
        if command == "JOGCmd" && given.number("cmd") != 0.0 {
            return match axis_of(given, manner) {
                Ok(axis) => self.start_jog(now, asked, name, &axis),
                Err(error) => self.answer(asked, &Err(error)),
            };
        }
        // Only a jog of this program is ended as a jog; otherwise the command goes to the arm.
        if command == "JOGCmd" && self.arms.get(name).is_some_and(|arm| arm.jogs) {
            return self.stop_jog(name, Then::Stopped(asked.clone()));
        }
        let fields = if stops { Map::new() } else { given.fields() };
        let mut params = json!({"arm": name, "command": command});
        if !fields.is_empty() {
            params["fields"] = Value::Object(fields);
        }
        // Two separate flags: `row.dangerous` allows dangerous commands (checked above), `laser`
        // allows burning. The station asks for `yes` in both cases.
        if method.row().is_some_and(|row| row.dangerous) || self.options.laser {
            params["yes"] = json!(true);
        }
        let end = match command {
            _ if stops => WriteEnd::Ends,
            _ => manner.end(command == "HOMECmd"),
        };
        let write = Write::new(asked, manner.method(), params, end).by(manner);
        self.write(now, name, write);
    }

    /// Sends a command without a row in the protocol's table to a real arm.
    fn raw(
        &mut self,
        now: HostInstant,
        asked: &Asked,
        name: &str,
        method: &'static Method,
        given: &CallParams,
        manner: &Manner,
    ) -> Result<(), LinkError> {
        let mut params = json!({"arm": name, "id": method.id, "params": wire::encode(given)?});
        if method.access == Access::Read {
            let asked = asked.clone();
            self.call("link.read", params, Then::Raw { asked, method });
            return Ok(());
        }
        params["queued"] = json!(manner.queued);
        params["moves"] = json!(method.moves);
        let end = match (method.results.is_empty(), manner.queued) {
            (false, _) => WriteEnd::Raw(method),
            (true, true) => WriteEnd::Index,
            (true, false) => WriteEnd::True,
        };
        let write = Write::new(asked, "link.write", params, end).by(manner);
        self.write(now, name, write);
        Ok(())
    }

    /// Answers a command without a row in the protocol's table for a virtual arm.
    fn pretend(
        &mut self,
        now: HostInstant,
        asked: &Asked,
        name: &str,
        method: &'static Method,
        given: &CallParams,
    ) -> Result<(), LinkError> {
        let asked = asked.clone();
        let reads = method.access == Access::Read;
        let get = |command: &str| json!({"arm": name, "command": command});
        let which = given.number("type");
        match method.virtual_answer {
            Some(VirtualAnswer::ProductName) => {
                self.answer(&asked, &Ok(json!({"productName": "Magician"})));
            }
            Some(VirtualAnswer::Homing) => {
                let then = Then::Homed(asked);
                self.call("arm.state", json!({"arm": name}), then);
            }
            Some(VirtualAnswer::Tool) if reads => {
                self.call("arm.state", json!({"arm": name}), Then::Tool(asked));
            }
            Some(VirtualAnswer::Tool) => {
                let tool = crate::answers::TOOLS.get(which as usize);
                let tool = tool.ok_or_else(|| LinkError::params("`type` is 0 to 2"))?;
                let write = Write::new(
                    &asked,
                    "arm.tool",
                    json!({"arm": name, "tool": tool}),
                    WriteEnd::True,
                );
                self.write(now, name, write);
            }
            Some(VirtualAnswer::ArmSpeed | VirtualAnswer::RailSpeed) => {
                let rail = method.virtual_answer == Some(VirtualAnswer::RailSpeed);
                let command = match (rail, which == 0.0) {
                    (false, true) => "JOGCommonParams",
                    (false, false) => "PTPCommonParams",
                    (true, true) => "JOGLParams",
                    (true, false) => "PTPLParams",
                };
                let set = (!reads).then(|| given.number("value"));
                let then = Then::Ratio {
                    asked,
                    arm: name.to_owned(),
                    command,
                    kind: which,
                    set,
                };
                self.call("arm.get", get(command), then);
            }
            Some(VirtualAnswer::Reach) => {
                let numbers = ["x", "y", "z", "r"].map(|axis| given.number(axis));
                let joints = given.get("isJoint") == Some(&json!(true));
                let (name, params) = if joints {
                    ("motion.forward", json!({"joints": numbers}))
                } else {
                    ("motion.inverse", json!({"pose": numbers}))
                };
                self.call(name, params, Then::Reach(asked));
            }
            None => {
                let why = format!("a virtual arm has no {}", method.name);
                return Err(LinkError::command(why));
            }
        }
        Ok(())
    }

    /// Turns the tool at the current position.
    fn turn(
        &mut self,
        asked: &Asked,
        name: &str,
        params: &Map<String, Value>,
    ) -> Result<(), LinkError> {
        // The protocol has no command for `SetRCmd`: send a move with the same options.
        let turned = Method::named("SetPTPCmd").ok_or_else(|| no_api("SetRCmd"))?;
        let manner = Manner::of(turned, params)?;
        let r = { params.get("r") }
            .and_then(Value::as_f64)
            .ok_or_else(|| LinkError::params("`r` must be a number"))?;
        let then = Then::Turn(Turn {
            asked: asked.clone(),
            arm: name.to_owned(),
            r,
            manner,
        });
        self.call("arm.get", json!({"arm": name, "command": "Pose"}), then);
        Ok(())
    }
}

/// Returns axis and direction of a jog in the station's form (document 1.9.4, errata E25).
fn axis_of(given: &CallParams, manner: &Manner) -> Result<String, LinkError> {
    if manner.queued {
        let why = "a jog in the queue only ends at a limit: leave out `isQueued`";
        return Err(LinkError::command(why));
    }
    let cmd = given.number("cmd");
    let joint = { given.get("isJoint") }
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
        // The name is repeated in the message, and comes from outside.
        .take(60)
        .collect();
    LinkError::new(ErrorCode::NO_API, format!("there is no {name}"))
}
