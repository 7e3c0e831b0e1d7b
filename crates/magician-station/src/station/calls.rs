//! Methods of arms: parameters, checks, and the orders that follow.

use std::time::Duration;

use magician::build::{Axis, JogDirection};
use magician::{Set, burns, gate, message};
use magician_program::{SheetCorner, Travel};
use magician_protocol::Row;
use serde_json::{Map, Value, json};

use super::dispatch::{Call, Handled};
use super::{Awaited, Station, tools};
use crate::api::{ArmEvent, Feature, Method, Needs, Params, RpcError, encode};
use crate::control::{ArmId, JogId, WorkKind};
use crate::library::folder_of;
use crate::order::{ArmAct, ArmOrder, ArmRead, TouchTarget};

/// Number of jogs that are remembered by id after their end, so that a late `jog.stop` gets an
/// answer.
const MAX_REMEMBERED_JOGS: usize = 256;

impl Station {
    /// Dispatches a method that has passed the common checks.
    pub(super) fn call(
        &mut self,
        method: &'static Method,
        call: &Call<'_>,
    ) -> Result<Handled, RpcError> {
        let name = method.name;
        // Families of methods have files of their own.
        if name.starts_with("lease.") {
            return self.lease_call(name, call);
        }
        #[cfg(feature = "class")]
        if ["class.", "turn.", "schedule.", "site."]
            .iter()
            .any(|of| name.starts_with(of))
        {
            return self.class_call(name, call);
        }
        if name.starts_with("job.") {
            return self.job_call(name, call);
        }
        if name.starts_with("program.") || name.starts_with("preset.") {
            return self.library_call(name, call);
        }
        if name.starts_with("motion.") {
            return Self::motion_call(name, call.params).map(Handled::Now);
        }
        if matches!(name, "teach.rows" | "teach.output" | "teach.plan") {
            return self.teach_call(name, call);
        }
        if let Some(arm) = call.arm.filter(|_| name.starts_with("world.")) {
            return self.world_call(method, call, arm);
        }
        if let Some(arm) = call.arm.filter(|_| name.starts_with("record.")) {
            return self.record_call(name, call, arm);
        }
        if name == "arm.get"
            && let Some(ends) = self.eviction_error(call.session)
        {
            return Err(ends);
        }
        match (name, call.arm) {
            ("session.list", _) => Ok(Handled::Now(self.list_sessions())),
            ("server.info", _) => Ok(Handled::Now(self.server_info(call))),
            ("arm.list", _) => Ok(Handled::Now(self.list_arms())),
            ("arm.subscribe", Some(arm)) => {
                let subscribed = self.subscribe(call.now, call.socket, arm, call.params);
                subscribed.map(Handled::Now)
            }
            ("arm.unsubscribe", _) => {
                // 0 is never an id, so a missing parameter finds no subscription.
                let id = call.params.integer("subscription").unwrap_or(0) as u16;
                self.unsubscribe(call.socket, id).map(Handled::Now)
            }
            ("events.since", Some(arm)) => {
                let seq = call.params.integer("seq").unwrap_or(0);
                Ok(Handled::Now(self.arm(arm).events.since(seq)))
            }
            ("arm.stop", arm) => Ok(self.stop(call, arm)),
            ("arm.info", Some(arm)) => Ok(self.read(call, arm, ArmRead::Info)),
            ("arm.io", Some(arm)) => Ok(self.read(call, arm, ArmRead::Io)),
            ("arm.model", Some(arm)) => Ok(self.read(call, arm, ArmRead::Model)),
            ("arm.fence", Some(arm)) => self.fence(call, arm),
            ("arm.alarms", Some(arm)) => Ok(self.read(call, arm, ArmRead::Alarms)),
            ("arm.state", Some(arm)) => self.state(call, arm),
            ("surface.get", Some(arm)) => Ok(self.read(call, arm, ArmRead::Surface)),
            ("teach.capture", Some(arm)) => {
                let (by, unhomed) = (path(call.params), call.params.is_on("unhomed"));
                Ok(self.read(call, arm, ArmRead::Capture { by, unhomed }))
            }
            ("link.read", Some(arm)) => {
                let (id, params) = raw(call.params)?;
                Ok(self.read(call, arm, ArmRead::Raw { id, params }))
            }
            ("arm.get", Some(arm)) => {
                let read = requested_read(call)?;
                Ok(self.read(call, arm, read))
            }
            ("jog.start", Some(arm)) => self.start_jog(call, arm),
            // No error for an unknown jog: a notification has no answer, and the jog's end is
            // reported anyway.
            ("jog.keep", _) => {
                if let Some(jog) = self.jog_named(call)
                    && self.control.keep_jog(call.now, call.session, jog)
                    && let Some(arm) = self.arm_of_jog(jog)
                {
                    self.order(arm, ArmOrder::KeepJog(jog));
                }
                Ok(Handled::Now(Value::Null))
            }
            ("jog.stop", _) => self.stop_jog(call),
            (_, Some(arm)) => match method.needs {
                Needs::Lease(kind) if name == "teach.guide" => self.guide(call, arm, kind),
                Needs::Lease(kind) => self.act(call, arm, method, kind),
                Needs::Nothing => Err(RpcError::internal(format!("{name} does nothing"))),
            },
            _ => Err(RpcError::internal(format!("{name} does nothing"))),
        }
    }

    fn server_info(&self, call: &Call<'_>) -> Value {
        let arms: Vec<_> = self
            .arms
            .iter()
            .map(|arm| arm.entry.name.as_str())
            .collect();
        json!({
            "version": self.config.version,
            "api": 1,
            "uptime_s": call.now.as_micros() as f64 / 1e6,
            "arms": arms,
            "programs": folder_of(&*self.config.programs),
            "recording": self.is_recording(),
            "features": self.features().map(Feature::name).collect::<Vec<_>>(),
        })
    }

    /// Returns the optional features that this station has.
    fn features(&self) -> impl Iterator<Item = Feature> {
        let has = |feature: &Feature| match feature {
            Feature::BinaryFrames | Feature::Events | Feature::Presets => true,
            Feature::JobQueue | Feature::Classes => cfg!(feature = "class"),
            Feature::Library => self.config.programs.is_enabled(),
            Feature::Recording => self.keeps_recordings(),
            Feature::Worlds => {
                cfg!(feature = "sim") && self.arms.iter().any(|arm| arm.entry.is_virtual)
            }
            Feature::Control => !self.config.read_only,
        };
        Feature::ALL.iter().copied().filter(has)
    }

    fn list_arms(&self) -> Value {
        let list = self.arm_ids().map(|arm| {
            let place = self.arm(arm);
            let waiting = self.control.waiting(arm).map(|(session, asks)| {
                let mut waiter = self.name_of(Some(session));
                waiter["asks"] = json!(asks);
                waiter
            });
            json!({
                "name": place.entry.name,
                "port": place.entry.port,
                "virtual": place.entry.is_virtual,
                "link": if place.link { "up" } else { "lost" },
                "holder": self.holder(arm),
                "waiting": waiting.collect::<Vec<_>>(),
                "job": self.job_at(arm).map(|(job, _)| job.id.clone()),
            })
        });
        json!({"arms": list.collect::<Vec<_>>()})
    }

    pub(super) fn read(&mut self, call: &Call<'_>, arm: ArmId, read: ArmRead) -> Handled {
        let request = call.request;
        self.order(arm, ArmOrder::Read { request, read });
        Handled::Later(request, Awaited::Arm(arm))
    }

    fn state(&mut self, call: &Call<'_>, arm: ArmId) -> Result<Handled, RpcError> {
        if !self.arm(arm).link {
            return Err(line_lost());
        }
        // The tool is not in every reading. Until it was read once, the arm is asked.
        let known = self.arm(arm).reading.as_ref();
        let known = known.is_some_and(|reading| reading.tool.bias.is_some());
        let fresh = known && self.is_fresh(call.now, arm);
        if fresh && let Some(state) = self.whole_state(arm) {
            return Ok(Handled::Now(state));
        }
        Ok(self.read(call, arm, ArmRead::State))
    }

    /// Returns the state from the last reading. `None` if there was none since the line was found.
    pub(super) fn whole_state(&mut self, arm: ArmId) -> Option<Value> {
        let state = self.shared_state(arm)?;
        Some(Value::Object(Map::clone(state.fields())))
    }

    /// Stops one arm, or all arms.
    fn stop(&mut self, call: &Call<'_>, arm: Option<ArmId>) -> Handled {
        let request = call.request;
        let arms = self.arm_or_all(arm);
        let by = Some(call.session);
        for arm in &arms {
            // The stop leaves before anything else is done.
            self.order(
                *arm,
                ArmOrder::Stop {
                    request: Some(request),
                },
            );
            for ended in self.control.stop(call.now, *arm) {
                let error = self.ended_error(*arm, crate::control::WorkEnd::Stop(by));
                self.finish(call.now, ended, Err(error));
            }
            let error = self.ended_error(*arm, crate::control::WorkEnd::Stop(by));
            self.cancel_pending_starts(call.now, *arm, &error);
            let by = self.session_id_value(by);
            if self.arm_mut(*arm).events.should_record_stop(call.now) {
                self.event(call.now, *arm, ArmEvent::Stop, vec![("by", by)]);
            }
            #[cfg(feature = "class")]
            self.hold_queue(call.now, *arm);
        }
        let waits = Awaited::Stops {
            left: arms,
            arms: Vec::new(),
            failed: None,
        };
        Handled::Later(request, waits)
    }

    fn start_jog(&mut self, call: &Call<'_>, arm: ArmId) -> Result<Handled, RpcError> {
        let params = call.params;
        let axis = params.text("axis").unwrap_or_default();
        let direction: JogDirection = axis
            .parse()
            .map_err(|_| RpcError::param("axis", message!("unknown axis `{axis}`", axis)))?;
        // A choice: long enough for the delays of a wireless network, short enough to bound the
        // motion after the client has died.
        let keep = Duration::from_millis(params.integer("keep_ms").unwrap_or(250));
        let percent = params.number("percent").map(|percent| percent as f32);
        let begun = self.control.start_jog(call.now, call.session, arm, keep);
        let jog = begun.map_err(|refusal| self.refused(arm, refusal))?;
        self.jogs.insert(jog, arm);
        while self.jogs.len() > MAX_REMEMBERED_JOGS {
            self.jogs.pop_first();
        }
        // Effects of the replaced jog first: its stop must leave before the new start.
        self.carry_out_effects(call.now);
        let request = call.request;
        self.order(
            arm,
            ArmOrder::StartJog {
                request,
                jog,
                direction,
                keep,
                percent,
            },
        );
        let fields = vec![("jog", json!(self.jog_id(jog))), ("axis", json!(axis))];
        self.event(call.now, arm, ArmEvent::Jog, fields);
        self.mark_state_changed(arm);
        Ok(Handled::Later(request, Awaited::Jog(arm, jog)))
    }

    fn stop_jog(&mut self, call: &Call<'_>) -> Result<Handled, RpcError> {
        let (arm, jog) = match call.params.text("jog") {
            Some(_) => {
                let unknown = || RpcError::param("jog", message!("there is no such jog"));
                let jog = self.jog_named(call).ok_or_else(unknown)?;
                let arm = self.jogs.get(&jog).copied().ok_or_else(unknown)?;
                (arm, Some(jog))
            }
            // A jog that waits for the arm to rest has an id that the client does not know yet.
            None => {
                let arm = match call.arm {
                    Some(arm) => arm,
                    None => self.arm_named(None)?,
                };
                (arm, self.control.jog(arm).map(|(jog, _)| jog))
            }
        };
        if let Some(jog) = jog {
            self.control.stop_jog(jog);
        }
        self.carry_out_effects(call.now);
        Ok(self.read(call, arm, ArmRead::Stand))
    }

    fn jog_named(&self, call: &Call<'_>) -> Option<JogId> {
        let text = call.params.text("jog")?;
        self.number('g', text).map(JogId)
    }

    /// Returns the arm that a jog moves.
    fn arm_of_jog(&self, jog: JogId) -> Option<ArmId> {
        self.arm_ids()
            .find(|arm| self.control.jog(*arm).is_some_and(|(id, _)| id == jog))
    }

    /// Orders an action that needs the lease and is over when the arm has done it.
    fn act(
        &mut self,
        call: &Call<'_>,
        arm: ArmId,
        method: &Method,
        kind: WorkKind,
    ) -> Result<Handled, RpcError> {
        let act = act_of(method.name, call)?;
        self.refuse_unattended(call, arm, &act)?;
        let command = match &act {
            ArmAct::Set(set) | ArmAct::Enqueue(set) | ArmAct::Tool(set) => Some(set),
            _ => None,
        };
        let laser = self.laser(call, arm, command)?;
        let kind = match &act {
            // Answered before it is done, so the command stays behind in the queue.
            ArmAct::Move { wait: false, .. } => WorkKind::Queued,
            ArmAct::Set(set) if magician::sets_in_motion(set) => WorkKind::Queued,
            // The laser would burn on when the holder is gone, so it counts as left behind, like a
            // queued command.
            ArmAct::Set(set) | ArmAct::Tool(set) if burns(set, true) => WorkKind::Queued,
            // During a job only its speed as a whole may change.
            ArmAct::Set(_) if kind == WorkKind::JobSetting => WorkKind::Setting,
            _ => kind,
        };
        // After the checks of parameters: a wrong request takes no lease.
        self.acquire_free_lease(call, arm);
        let begun = self
            .control
            .begin(call.now, call.session, arm, call.request, kind);
        begun.map_err(|refusal| self.refused(arm, refusal))?;
        let request = call.request;
        self.order(
            arm,
            ArmOrder::Act {
                request,
                act: Box::new(act),
                laser,
            },
        );
        Ok(Handled::Later(request, Awaited::Arm(arm)))
    }

    /// Refuses what would go on without a holder: a raw jog of any session, and a motor or the
    /// laser if the lease ends with the call.
    fn refuse_unattended(&self, call: &Call<'_>, arm: ArmId, act: &ArmAct) -> Result<(), RpcError> {
        let (ArmAct::Set(set) | ArmAct::Enqueue(set) | ArmAct::Tool(set)) = act else {
            return Ok(());
        };
        // A raw jog has no keep-alive at the station.
        if gate::jogs(set) {
            let why =
                message!("a jog that nothing holds goes on to the end of its axis: use jog.start");
            return Err(RpcError::param("command", why).with("method", "jog.start"));
        }
        if !self.is_one_shot(call) {
            return Ok(());
        }
        // A motor with a counted number of pulses ends by itself.
        let turns = matches!(set, Set::EMotor(_)) && gate::turns_motor(set);
        let why = if turns {
            message!("a motor runs on while the lease of its session does: use a WebSocket")
        } else if burns(set, self.arm(arm).entry.laser_pins) {
            message!("the laser stays on while the lease of its session does: use a WebSocket")
        } else {
            return Ok(());
        };
        Err(RpcError::request(why).with("command", set.row().set_name))
    }
}

pub(super) fn line_lost() -> RpcError {
    RpcError::arm(
        magician::ErrorKind::Port,
        message!("the line to the arm is lost"),
    )
}

/// Returns the frame named in the parameters.
fn raw(params: &Params) -> Result<(u8, Vec<u8>), RpcError> {
    let id = params.integer("id").and_then(|id| u8::try_from(id).ok());
    let text = params.text("params").unwrap_or_default();
    let bytes = text.as_bytes().chunks(2).map(|pair| {
        let digits = std::str::from_utf8(pair)
            .ok()
            .filter(|digits| digits.len() == 2)?;
        u8::from_str_radix(digits, 16).ok()
    });
    let bytes: Option<Vec<u8>> = bytes.collect();
    let bytes = bytes.ok_or_else(|| RpcError::param("params", message!("`params` must be hex")))?;
    Ok((id.unwrap_or_default(), bytes))
}

/// Returns the kind of motion named by `by`.
fn path(params: &Params) -> Travel {
    match params.text("by") {
        Some("linear") => Travel::Line,
        Some("jump") => Travel::Jump,
        // The check of parameters admits no other word; joints is the default.
        _ => Travel::Joints,
    }
}

/// Returns the action of a method.
fn act_of(name: &str, call: &Call<'_>) -> Result<ArmAct, RpcError> {
    let params = call.params;
    match name {
        "arm.set" => Ok(ArmAct::Set(command(call, false)?)),
        "arm.enqueue" => Ok(ArmAct::Enqueue(command(call, true)?)),
        "link.write" => {
            let (id, bytes) = raw(params)?;
            Ok(ArmAct::Raw {
                id,
                params: bytes,
                queued: params.is_on("queued"),
                moves: params.is_on("moves"),
            })
        }
        "link.start" => Ok(ArmAct::StartEmptyQueue),
        "arm.home" => Ok(ArmAct::Home),
        "arm.clear_alarms" => Ok(ArmAct::ClearAlarms),
        "surface.touch" if params.is_on("forget") => Ok(ArmAct::ForgetSurface),
        "surface.touch" => Ok(ArmAct::Touch {
            takes: TouchTarget::Height {
                adds: params.is_on("add"),
            },
            unhomed: params.is_on("unhomed"),
        }),
        "surface.corner" => {
            let name = params.text("corner").unwrap_or_default();
            let corner = SheetCorner::ALL
                .into_iter()
                .find(|corner| corner.name() == name);
            let corner =
                corner.ok_or_else(|| RpcError::param("corner", message!("no such corner")))?;
            Ok(ArmAct::Touch {
                takes: TouchTarget::Corner(corner),
                unhomed: params.is_on("unhomed"),
            })
        }
        "arm.speed" => tools::speed(call),
        "arm.tool" => tools::tool(call),
        "arm.move" => {
            let to = params.numbers("to").unwrap_or_default();
            let [x, y, z, r, rest @ ..] = to.as_slice() else {
                return Err(RpcError::param(
                    "to",
                    message!("`to` must be 4 to 5 numbers"),
                ));
            };
            Ok(ArmAct::Move {
                to: [*x as f32, *y as f32, *z as f32, *r as f32],
                rail: rest.first().map(|rail| *rail as f32),
                by: path(params),
                joints: params.text("frame") == Some("joints"),
                relative: params.is_on("relative"),
                // Waiting is the default, because the answer is then the pose that was reached.
                wait: params.switch("wait").unwrap_or(true),
            })
        }
        "jog.step" => {
            let axis = params.text("axis").unwrap_or_default();
            let turned = params.text("frame") == Some("tool");
            let axis: Axis = axis
                .parse()
                .map_err(|_| RpcError::param("axis", message!("unknown axis `{axis}`", axis)))?;
            if turned && !matches!(axis, Axis::X | Axis::Y | Axis::Z | Axis::R) {
                let why = message!("the tool frame is for steps along x, y, z and r");
                return Err(RpcError::param("frame", why));
            }
            Ok(ArmAct::Step {
                axis,
                by: params.number("by").unwrap_or(0.0) as f32,
                turned,
                percent: params.number("percent").map(|percent| percent as f32),
            })
        }
        _ => Err(RpcError::internal(format!("{name} does nothing"))),
    }
}

/// Returns the reading that `arm.get` asks for.
fn requested_read(call: &Call<'_>) -> Result<ArmRead, RpcError> {
    let name = call.params.text("command").unwrap_or_default();
    let row = Row::find_readable(name).map_err(|_| unknown_name("command", name, false))?;
    let given = call.params.object("query").cloned().unwrap_or_default();
    let params = match row.query {
        Some(layout) => encode(layout, &given).map_err(|why| RpcError::param("query", why))?,
        None if given.is_empty() => Vec::new(),
        None => {
            return Err(RpcError::param(
                "query",
                message!("{name} is asked for nothing", name),
            ));
        }
    };
    let id = row.id;
    Ok(ArmRead::Get { id, params })
}

/// Returns the command in the parameter `command`, with its fields.
fn command(call: &Call<'_>, queued: bool) -> Result<Set, RpcError> {
    named_command(call, "command", queued)
}

/// Returns the command in this parameter, with its fields.
pub(super) fn named_command(call: &Call<'_>, param: &str, queued: bool) -> Result<Set, RpcError> {
    let name = call.params.text(param).unwrap_or_default();
    let row = Row::find_writable(name).map_err(|_| unknown_name(param, name, true))?;
    let layout = row.set.ok_or_else(|| unknown_name(param, name, true))?;
    if queued && !row.queueable {
        return Err(RpcError::param(
            param,
            message!("{name} cannot be queued", name = row.set_name),
        ));
    }
    let given = call.params.object("fields").cloned().unwrap_or_default();
    let params = encode(layout, &given).map_err(|why| RpcError::param("fields", why))?;
    let set = Set::decode(row.id, &params);
    set.map_err(|error| RpcError::param("fields", format!("{name}: {error}")))
}

fn unknown_name(param: &str, name: &str, sets: bool) -> RpcError {
    let name = magician_protocol::visible(name).to_string();
    let why = if sets {
        message!("there is no command `{name}` that can be set", name)
    } else {
        message!("there is no command `{name}` that can be read", name)
    };
    RpcError::param(param, why)
}
