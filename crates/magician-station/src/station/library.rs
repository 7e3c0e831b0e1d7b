//! Methods of the library of programs.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use magician::message;
use magician_program::{Format, SetupOptions};
use magician_protocol::HostInstant;
use serde_json::json;

use super::dispatch::{Call, Handled};
use super::long_requests::LongRequest;
use super::{Awaited, Station};
use crate::api::RpcError;
use crate::control::{ArmId, RequestId};
use crate::job::setup_and_preset;
use crate::library::{LibraryAct, OverwritePolicy, ProgramName};
use crate::presets::PresetAct;

impl Station {
    pub(super) fn library_call(
        &mut self,
        name: &str,
        call: &Call<'_>,
    ) -> Result<Handled, RpcError> {
        let params = call.params;
        if name == "program.options" {
            // Answered at once: a table holds the options, so no file is read.
            let format = params.text("format").unwrap_or_default().parse();
            let format: Format =
                format.map_err(|error: String| RpcError::param("format", error))?;
            let mut options = SetupOptions::options_for(format);
            options.retain(|option| option.usual || params.is_on("all"));
            return Ok(Handled::Now(json!({"options": options})));
        }
        let (setup, preset) = match name {
            "program.convert" => setup_and_preset(params.object("setup"))?,
            _ => (None, None),
        };
        // Replacing is the default, as for PUT.
        let overwrite = match params.switch("replace") {
            Some(false) => OverwritePolicy::Refuse,
            _ => OverwritePolicy::Replace,
        };
        let act = match name {
            "program.list" => LibraryAct::List,
            "program.get" => LibraryAct::Get(program(call, "name")?),
            "program.delete" => LibraryAct::Delete(program(call, "name")?),
            "program.put" => {
                let bytes = match (params.text("text"), params.text("data")) {
                    (Some(text), None) => text.as_bytes().to_vec(),
                    (None, Some(data)) => STANDARD.decode(data).map_err(|_| {
                        RpcError::param("data", message!("`data` must be bytes in base64"))
                    })?,
                    _ => {
                        let why = message!("one of `text` and `data` has to be given");
                        return Err(RpcError::param("text", why));
                    }
                };
                LibraryAct::Put(program(call, "name")?, bytes, overwrite)
            }
            "program.convert" => LibraryAct::Convert {
                from: program(call, "name")?,
                to: program(call, "to")?,
                setup,
                preset,
                overwrite,
            },
            _ if name.starts_with("preset.") => LibraryAct::Presets(preset_act(name, call)?),
            _ => return Err(RpcError::internal(format!("{name} does nothing"))),
        };
        self.queue_long_request(call, LongRequest::Library(call.grant.role, act))
    }
}

impl Station {
    /// Checks that a job's program and preset exist before anything else happens, so that errors in
    /// parameters are answered first.
    pub(super) fn check_program_exists(
        &mut self,
        call: &Call<'_>,
        arm: ArmId,
        program: Option<ProgramName>,
        preset: Option<String>,
    ) -> Result<Handled, RpcError> {
        let find = LibraryAct::Find { program, preset };
        // In turn as well, because looking up a file may block.
        self.queue_long_request(call, LongRequest::Library(call.grant.role, find))?;
        let params = Box::new(call.params.clone());
        Ok(Handled::Later(call.request, Awaited::Program(arm, params)))
    }

    pub(super) fn waits_for_program(&self, request: RequestId) -> bool {
        let pending = self.pending.get(&request);
        pending.is_some_and(|pending| matches!(pending.awaits, Awaited::Program(..)))
    }

    /// Continues a start whose program was found: the remaining checks, and the start itself.
    pub(super) fn continue_start(&mut self, now: HostInstant, request: RequestId) {
        let Some(pending) = self.pending.get_mut(&request) else {
            return;
        };
        let socket = pending.socket;
        // A placeholder until the start says what the request waits for.
        let waits = std::mem::replace(&mut pending.awaits, Awaited::Library);
        let Awaited::Program(arm, params) = waits else {
            return;
        };
        // Looked up again: the rights of now count, because they may have been withdrawn meanwhile.
        let session = self.session_of(socket);
        let known = session.and_then(|session| Some((session, self.sessions.get(&session)?)));
        let Some((session, grant)) = known.map(|(id, session)| (id, session.grant.clone())) else {
            // The socket is gone.
            self.pending.remove(&request);
            return;
        };
        let call = Call {
            now,
            socket,
            session,
            grant,
            arm: Some(arm),
            params: &params,
            request,
        };
        match self.start_job(&call, arm, true) {
            Ok(Handled::Now(value)) => self.finish(now, request, Ok(value)),
            Ok(Handled::Later(_, waits)) => {
                if let Some(pending) = self.pending.get_mut(&request) {
                    pending.awaits = waits;
                }
            }
            Err(error) => self.finish(now, request, Err(error)),
        }
    }

    /// Answers starts that still wait for their program, because a stop came first.
    pub(super) fn cancel_pending_starts(&mut self, now: HostInstant, arm: ArmId, error: &RpcError) {
        let waiting = self.pending.iter().filter_map(|(request, pending)| {
            let waits = matches!(&pending.awaits, Awaited::Program(of, _) if *of == arm);
            waits.then_some(*request)
        });
        for request in waiting.collect::<Vec<_>>() {
            self.finish(now, request, Err(error.clone()));
        }
    }
}

/// Returns the program named by a parameter.
pub(super) fn program(call: &Call<'_>, param: &str) -> Result<ProgramName, RpcError> {
    let name = call.params.text(param).unwrap_or_default();
    ProgramName::new(name).ok_or_else(|| {
        let why = message!(
            "`{param}` must be a name of 1 to 80 letters, digits, points, blanks, `_` and `-`, \
                with no point first and no blank first or last",
            param
        );
        RpcError::param(param, why)
    })
}

/// Returns the operation of a preset method.
fn preset_act(method: &str, call: &Call<'_>) -> Result<PresetAct, RpcError> {
    let params = call.params;
    let name = params.text("name").unwrap_or_default().to_owned();
    Ok(
        match (method, params.object("setup"), params.text("text")) {
            ("preset.list", ..) => PresetAct::List,
            ("preset.show", ..) => PresetAct::Show(name),
            ("preset.remove", ..) => PresetAct::Remove(name),
            ("preset.save", Some(fields), None) => {
                let (options, of_preset) = setup_and_preset(Some(fields))?;
                if of_preset.is_some() {
                    let why = message!("`setup`: a preset has no preset");
                    return Err(RpcError::param("setup.preset", why));
                }
                let note = params.text("note").map(str::to_owned);
                PresetAct::Save(name, note, options.unwrap_or_default())
            }
            ("preset.save", None, Some(text)) if params.text("note").is_none() => {
                PresetAct::SaveText(name, text.to_owned())
            }
            ("preset.save", ..) => {
                let why = message!(
                    "either `setup`, with or without a `note`, or `text` alone has to be given"
                );
                return Err(RpcError::param("setup", why));
            }
            _ => return Err(RpcError::internal(format!("{method} does nothing"))),
        },
    )
}
