//! World of an in-process virtual arm: events caused by a person's hand, and the view for pages.

use magician::commands::DeviceTime;
use magician::message;
#[cfg(feature = "sim")]
use magician::sim::scenario::{Color, Conveyor, Table, ToolKind};
#[cfg(feature = "sim")]
use magician::sim::world::{ObjectView, Press, Stroke, StrokeKind};
#[cfg(feature = "sim")]
use magician::sim::{Controller, ExternalEvent, Scenario};
use magician::{Arm, ErrorKind};
#[cfg(feature = "sim")]
use magician_picture::{DrawingOptions, drawing_svg};
use serde_json::Value;
#[cfg(feature = "sim")]
use serde_json::json;

use super::reads;
use super::{EngineTask, TaskResult};
use crate::api::RpcError;
use crate::control::RequestId;
#[cfg(feature = "sim")]
use crate::order::Fault;
use crate::order::{ArmReport, Outcome, WorldAct};

impl EngineTask {
    /// Applies an event to the world. The answer is reported as [`ArmReport::Done`].
    pub(super) fn change_world(&mut self, request: RequestId, act: WorldAct) {
        let (arm, known) = (self.arm.clone(), self.known.clone());
        let report = move |done: Result<Value, RpcError>| {
            let outcome = done.map(Outcome::Value);
            TaskResult::Report(ArmReport::Done { request, outcome })
        };
        if let WorldAct::Scenario(_) = act {
            self.side.spawn(async move {
                // A new scenario restarts the arm's clock. Reading the clock before and after lets
                // the connection notice the reset.
                let read_clock = async || drop(arm.get::<DeviceTime>().await);
                read_clock().await;
                let done = apply_event(&arm, act);
                read_clock().await;
                if done.is_ok() {
                    // This reset was asked for: the empty run consumes the notice, so that the next
                    // move does not fail with it.
                    drop(arm.run(&[]).await);
                }
                report(done)
            });
            return;
        }
        // Applied here and not in the task, so that events caused by a person keep their order.
        let is_guide = matches!(act, WorldAct::Guide(_));
        let done = apply_event(&self.arm, act);
        self.side.spawn(async move {
            if is_guide && done.is_ok() {
                return reads::state(arm, known, request).await;
            }
            report(done)
        });
    }
}

fn unsupported() -> RpcError {
    let why = message!(
        "the arm is not a virtual arm of the station's process: it has no world that can be changed"
    );
    RpcError::arm(ErrorKind::Unsupported, why)
}

#[cfg(not(feature = "sim"))]
fn apply_event(_: &Arm, _: WorldAct) -> Result<Value, RpcError> {
    Err(unsupported())
}

#[cfg(not(feature = "sim"))]
pub(super) async fn describe(_: &Arm, _: Option<String>) -> Result<Value, RpcError> {
    Err(unsupported())
}

#[cfg(feature = "sim")]
fn apply_event(arm: &Arm, act: WorldAct) -> Result<Value, RpcError> {
    let arm = arm.virtual_arm().ok_or_else(unsupported)?;
    match act {
        WorldAct::Press(long) => arm.with(|arm| {
            arm.press(if long { Press::Long } else { Press::Short });
        }),
        WorldAct::Unlock(held) => arm.with(|arm| arm.unlock(held)),
        WorldAct::Plug(plugged) => arm.with(|arm| arm.inject(ExternalEvent::Cable { plugged })),
        WorldAct::Guide(joints) => {
            // A real arm cannot be bent while its motors hold it.
            if !arm.state().unlocked {
                let why =
                    message!("the motors hold the arm: hold the unlock key first (world.unlock)");
                return Err(RpcError::arm(ErrorKind::InvalidInput, why));
            }
            arm.with(|arm| arm.guide(joints.into()));
        }
        WorldAct::Place { name, at } => {
            if !arm.with(|arm| arm.place(&name, at)) {
                let name = magician_protocol::visible(&name).to_string();
                let why = message!("there is no object `{name}`", name);
                return Err(RpcError::param("name", why));
            }
        }
        WorldAct::Paper => arm.with(Controller::clear_drawing),
        WorldAct::Input {
            address,
            analog,
            value,
        } => arm.with(|arm| {
            if analog {
                arm.set_analog(address, value);
            } else {
                arm.set_input(address, value != 0);
            }
        }),
        WorldAct::Fault(fault) => {
            let fault = match fault {
                Fault::Alarm(code) => ExternalEvent::Alarm(code),
                Fault::Slip { joint, degrees } => ExternalEvent::Slip { joint, degrees },
                Fault::Reset => ExternalEvent::Reset,
            };
            arm.with(|arm| arm.inject(fault));
        }
        WorldAct::Scenario(text) => {
            let scenario = Scenario::from_toml(&text);
            let scenario = scenario.map_err(|error| RpcError::param("text", error.to_string()))?;
            arm.restart_in(&scenario);
            let objects = scenario.objects().iter();
            let names: Vec<_> = objects.map(|object| object.name.as_str()).collect();
            return Ok(json!({"objects": names}));
        }
    }
    Ok(Value::Null)
}

/// Returns the objects, their surroundings, the drawing, and the state of the keys. The drawing is
/// omitted if `mark` still identifies it, because pages poll often and drawings are long.
#[cfg(feature = "sim")]
pub(super) async fn describe(arm: &Arm, mark: Option<String>) -> Result<Value, RpcError> {
    let arm = arm.virtual_arm().ok_or_else(unsupported)?;
    let (mut answer, drawing) = arm.with(|arm| {
        let view = arm.look();
        let objects: Vec<_> = view.objects().map(|object| object_of(&object)).collect();
        let (state, line) = (arm.state(), arm.line());
        let scenario = arm.world().scenario();
        let answer = json!({
            "objects": objects,
            "title": scenario.and_then(Scenario::title),
            "table": scenario.and_then(Scenario::table).map(table_of),
            "draws": scenario.and_then(drawing_tool),
            "belt": scenario.and_then(Scenario::conveyor).map(|belt| belt_of(belt, view.belt_travel())),
            "unlocked": state.unlocked,
            "plugged": line.plugged,
        });
        (answer, arm.drawing())
    });
    let strokes = drawing.strokes();
    let points: usize = strokes.iter().map(|stroke| stroke.points.len()).sum();
    // The number of points changes while a stroke grows. The last point distinguishes drawings with
    // the same number.
    let last = strokes.last().and_then(|stroke| stroke.points.last());
    let current_mark = last.map_or_else(String::new, |[x, y]| format!("{points}:{x:.2}:{y:.2}"));
    let is_known = mark.as_deref() == Some(&current_mark);
    answer["mark"] = json!(current_mark);
    if is_known {
        (answer["drawing"], answer["strokes"]) = (Value::Null, Value::Null);
        return Ok(answer);
    }
    // Off the arm's task: the arm goes on while the picture is drawn.
    let (svg, strokes) = super::run_blocking(move || {
        let strokes: Vec<_> = { drawing.strokes().iter() }
            .map(|stroke| stroke_of(stroke, points.div_ceil(MAX_POINTS)))
            .collect();
        (drawing_svg(&drawing, &DrawingOptions::default()), strokes)
    })
    .await?;
    answer["drawing"] = json!(svg);
    answer["strokes"] = json!(strokes);
    Ok(answer)
}

/// Returns how often the tool has gripped. Zero for a real arm, of which this is unknown.
pub(super) fn grip_count(arm: &Arm) -> GripCount {
    #[cfg(feature = "sim")]
    if let Some(arm) = arm.virtual_arm() {
        let (grips, picks) = arm.with(|arm| {
            let count = arm.look().grip_count();
            (count.begun, count.taken)
        });
        return GripCount { grips, picks };
    }
    let _ = arm;
    GripCount::default()
}

/// Number of times the tool began to grip, and picked something up.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct GripCount {
    pub(super) grips: u64,
    pub(super) picks: u64,
}

/// Approximate number of points of a drawing that are sent as strokes. Longer drawings are thinned
/// out.
#[cfg(feature = "sim")]
const MAX_POINTS: usize = 20_000;

#[cfg(feature = "sim")]
fn round_to_millionth(value: f64) -> f64 {
    (value * 1e6).round() / 1e6 + 0.0
}

#[cfg(feature = "sim")]
fn object_of(object: &ObjectView<'_>) -> Value {
    let place = object.place();
    let at = [place.x, place.y, place.z].map(round_to_millionth);
    let Color([red, green, blue]) = object.color();
    json!({
        "name": object.name(),
        "at": at,
        "turn": round_to_millionth(place.yaw),
        "size": object.size(),
        "color": format!("#{red:02x}{green:02x}{blue:02x}"),
        "held": object.is_held(),
    })
}

#[cfg(feature = "sim")]
fn table_of(table: &Table) -> Value {
    json!({"height": table.height, "x": table.x, "y": table.y})
}

/// Returns the tool with which the arm of a scenario leaves lines. `None` if it leaves none: a pen
/// needs paper, and paper needs a table.
#[cfg(feature = "sim")]
fn drawing_tool(scenario: &Scenario) -> Option<&'static str> {
    match scenario.tool().kind {
        ToolKind::Pen => scenario.table().map(|_| "pen"),
        ToolKind::Laser => Some("laser"),
        _ => None,
    }
}

#[cfg(feature = "sim")]
fn belt_of(belt: &Conveyor, travel: f64) -> Value {
    json!({
        "start": belt.start,
        "direction": belt.direction,
        "length": belt.length,
        "width": belt.width,
        "height": belt.height,
        "travel": round_to_millionth(travel),
    })
}

/// Returns a stroke with every `stride`-th of its points, and its last point.
#[cfg(feature = "sim")]
fn stroke_of(stroke: &Stroke, stride: usize) -> Value {
    let rounded = |[x, y]: &[f64; 2]| [x, y].map(|value| (value * 100.0).round() / 100.0 + 0.0);
    let mut points: Vec<_> = { stroke.points.iter().step_by(stride.max(1)) }
        .map(rounded)
        .collect();
    if let Some(last) = stroke.points.last().map(rounded)
        && points.last() != Some(&last)
    {
        points.push(last);
    }
    let power = (stroke.power * 10.0).round() / 10.0;
    json!({"burnt": stroke.kind == StrokeKind::Burn, "power": power, "points": points})
}
