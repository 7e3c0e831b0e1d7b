//! Methods for teaching programs on a page.
//!
//! A page shows a program as rows; a row may hold several steps of a plan file (motion, gripper,
//! suction, wait). The conversion in both directions goes through the model of `magician-job`.

use magician::{Message, message};
use magician_job::teach::{ProgramModel, TeachStep};
use magician_program::{Action, Diagnostic, Plan};
use serde_json::{Map, Value, json};

use super::dispatch::{Call, Handled};
use super::long_requests::LongRequest;
use super::{Awaited, Station};
use crate::api::{Params, RpcError};
use crate::control::{ArmId, WorkKind};
use crate::library::LibraryAct;
use crate::order::ArmOrder;

/// Members of a row that become separate steps in a plan.
const TOOL_MEMBERS: [&str; 3] = ["gripper", "suction", "wait"];

impl Station {
    /// Switches reporting of the unlock key on or off.
    pub(super) fn guide(
        &mut self,
        call: &Call<'_>,
        arm: ArmId,
        kind: WorkKind,
    ) -> Result<Handled, RpcError> {
        let (request, on) = (call.request, call.params.is_on("on"));
        let unhomed = call.params.is_on("unhomed");
        self.acquire_free_lease(call, arm);
        let begun = self
            .control
            .begin(call.now, call.session, arm, request, kind);
        begun.map_err(|refusal| self.refused(arm, refusal))?;
        self.control.guide(arm, on);
        let request = Some(request);
        self.order(
            arm,
            ArmOrder::Guide {
                request,
                on,
                unhomed,
            },
        );
        Ok(Handled::Later(call.request, Awaited::Arm(arm)))
    }

    pub(super) fn teach_call(&mut self, name: &str, call: &Call<'_>) -> Result<Handled, RpcError> {
        let params = Box::new(call.params.clone());
        let act = match name {
            "teach.output" => return output(call.params).map(Handled::Now),
            "teach.rows" => TeachAct::Rows(params),
            "teach.plan" => TeachAct::Plan(params),
            _ => return Err(RpcError::internal(format!("{name} does nothing"))),
        };
        // Programs of a megabyte take longer than a stop may wait.
        self.queue_long_request(
            call,
            LongRequest::Library(call.grant.role, LibraryAct::Teach(act)),
        )
    }
}

/// Conversion between a plan and the rows of a page, with the parameters of its method.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum TeachAct {
    /// Rows of a plan.
    Rows(Box<Params>),
    /// Plan of rows.
    Plan(Box<Params>),
}

impl TeachAct {
    /// Returns the answer. May take long.
    pub(crate) fn carry_out(self) -> Result<Value, RpcError> {
        match self {
            Self::Rows(params) => rows(&params),
            Self::Plan(params) => plan(&params),
        }
    }
}

/// Converts a plan to rows.
fn rows(params: &Params) -> Result<Value, RpcError> {
    let given = params.get("plan").cloned().unwrap_or_default();
    let plan = Plan::from_json(given.to_string().as_bytes());
    let plan = plan.map_err(|problem| param_error("plan", &problem.message))?;
    let program = ProgramModel::from_plan(&plan);
    let file = file(&program)?;
    let mut steps = file["steps"].as_array().into_iter().flatten();
    let mut rows = Vec::new();
    for (step, count) in program.steps().iter().zip(program.plan_steps()) {
        let mut row = json!({
            "name": step.name, "motion": null, "gripper": null, "suction": null, "wait": null
        });
        for planned in steps.by_ref().take(count) {
            let mut planned = planned.as_object().cloned().unwrap_or_default();
            // The name belongs to the row, which may have several steps.
            planned.remove("name");
            match TOOL_MEMBERS
                .iter()
                .find(|name| planned.contains_key(**name))
            {
                Some(name) => row[*name] = planned[*name].clone(),
                None => row["motion"] = Value::Object(planned),
            }
        }
        rows.push(row);
    }
    let member = |name: &str| file.get(name).cloned().unwrap_or_default();
    Ok(json!({
        "title": program.title,
        "tool": member("tool"),
        "surface": member("surface"),
        "rows": rows,
    }))
}

/// Returns a step that sets an output.
fn output(params: &Params) -> Result<Value, RpcError> {
    // The check of parameters bounds the address to 1 to 20.
    let address = params.integer("address").unwrap_or_default() as u8;
    let set = magician::build::output(address, params.is_on("high"));
    let step = TeachStep {
        motion: Some(Action::from(set)),
        ..TeachStep::default()
    };
    let file = file(&ProgramModel::from_steps("", None, None, vec![step]))?;
    Ok(json!({"step": file["steps"][0]}))
}

/// Converts rows to a plan. Also returns the first step of each row.
fn plan(params: &Params) -> Result<Value, RpcError> {
    let rows = params.get("rows").and_then(Value::as_array);
    let rows = rows.map(Vec::as_slice).unwrap_or_default();
    // One line for the head and one for each step, so that the line of an error identifies the row.
    let head = json!({
        "format": "magician-plan",
        "version": 1,
        "title": params.get("title").cloned().unwrap_or(json!("")),
        "tool": params.get("tool").cloned().unwrap_or_default(),
        "surface": params.get("surface").cloned().unwrap_or_default(),
    });
    let head = head.to_string();
    let mut lines = Vec::new();
    let mut of_rows = Vec::new();
    for (nth, row) in rows.iter().enumerate() {
        let row = row.as_object().cloned().unwrap_or_default();
        for (name, value) in row.iter().filter(|(_, value)| !value.is_null()) {
            let step = match name.as_str() {
                // Not a step: the name goes to the row, below.
                "name" if value.is_string() => continue,
                "motion" if value.is_object() => value.clone(),
                name if TOOL_MEMBERS.contains(&name) => {
                    Value::Object(Map::from_iter([(name.to_owned(), value.clone())]))
                }
                _ => {
                    let name = magician_protocol::visible(name).to_string();
                    return Err(in_row(
                        nth,
                        &message!("unknown member or value of `{name}`", name),
                    ));
                }
            };
            lines.push(step.to_string());
            of_rows.push(nth);
        }
    }
    let head = head.strip_suffix('}').unwrap_or(&head);
    let text = format!("{head},\"steps\":[\n{}\n]}}", lines.join(",\n"));
    let read = Plan::from_json(text.as_bytes()).map_err(|problem| row_error(&of_rows, &problem))?;
    let mut steps: Vec<_> = rows
        .iter()
        .map(|row| TeachStep {
            name: row["name"].as_str().unwrap_or_default().to_owned(),
            ..TeachStep::default()
        })
        .collect();
    for (planned, nth) in read.steps.into_iter().zip(&of_rows) {
        let Some(step) = steps.get_mut(*nth) else {
            continue;
        };
        match planned.action {
            Action::Gripper(grip) => step.gripper = Some(grip),
            Action::Suction(on) => step.suction = Some(on),
            Action::Wait(pause) => step.pause = pause,
            // The model has no members for other actions, so any of them, outputs included, is
            // stored as the motion of the row.
            motion => step.motion = Some(motion),
        }
    }
    let program = ProgramModel::from_steps(read.title, read.tool, read.surface, steps);
    let first = program.plan_steps().scan(0, |before, count| {
        let first = *before;
        *before += count;
        Some(first)
    });
    Ok(json!({"plan": file(&program)?, "first": first.collect::<Vec<_>>()}))
}

/// Returns a program as a plan file.
fn file(program: &ProgramModel) -> Result<Value, RpcError> {
    let text = program.plan(0).to_json();
    serde_json::from_str(&text).map_err(|error| RpcError::internal(error.to_string()))
}

/// Returns an error of the reader with the number of its row.
fn row_error(of_rows: &[usize], problem: &Diagnostic) -> RpcError {
    // Line 1 is the head, so the first step is on line 2.
    let line = (problem.origin.line as usize).checked_sub(2);
    match line.and_then(|line| of_rows.get(line)) {
        Some(nth) => in_row(*nth, &problem.message),
        None => param_error("rows", &problem.message),
    }
}

fn in_row(nth: usize, why: &Message) -> RpcError {
    let error = param_error("rows", &message!("row {row}: {why}", row = nth + 1, why));
    error.with("row", json!(nth + 1))
}

fn param_error(param: &str, why: &Message) -> RpcError {
    RpcError::param_quoting(param, &message!("`{param}`: {why}", param, why))
}
