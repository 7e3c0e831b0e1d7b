//! Readings: the state of the arm, single values, identity.
//!
//! A subscription gets a reading at each status of the driver. The status does not say reliably
//! whether the arm moves: another host may move it, and its pose is updated only every 20 ms.
//! `Known` therefore watches the poses themselves.

use std::time::{Duration, Instant};

use magician::commands::{DeviceWithL, Pose, PoseL};
use magician::report::{AlarmReport, ArmInfo};
use magician::{
    Arm, ArmOutputs, ArmSnapshot, Ctrl, ErrorCode, GripperState, Level, RestDetector, Result,
    Status, ToolBias, message,
};
use magician_job::teach::ProgramModel;
use magician_program::Travel;
use magician_protocol::{Direction, describe};
use serde_json::{Value, json};

use super::TaskResult;
use super::acts::standing_answer;
use crate::api::RpcError;
use crate::control::RequestId;
use crate::order::{ArmRead, Outcome};
use crate::reading::{ArmReading, ToolReading, pin_kind, to_value};
use crate::surface::ArmSurface;

/// Values that the engine keeps between two readings.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Known {
    /// Position on the rail, mm. `None` without a rail. Not read with every status, because only
    /// commands change it, and rarely.
    pub(super) rail: Option<f32>,
    /// Pose of the last reading, and when it was read.
    before: Option<(Pose, Instant)>,
    /// Detector of rest, started when a pose differed from the previous one. `None` while the arm
    /// is at rest.
    moves: Option<RestDetector>,
    /// Previous pose, and its time since the first reading, us.
    last: Option<(Pose, u64)>,
    first_read_at: Option<Instant>,
}

/// Least time between two equal poses that shows an arm at rest, us. Ten times the 20 ms for which
/// a moving arm may report the same pose.
const REST_AFTER: u64 = 200_000;

impl Known {
    /// Reads the values that the driver's status does not contain. The driver stores tools and
    /// speed in its picture of the arm.
    pub(super) async fn read(arm: &Arm) -> Result<Self> {
        // Also loads the stored homing, so that later statuses report it.
        arm.homing().is_homed().await?;
        arm.read_outputs().await?;
        // An arm without a rail has no position on it.
        let on_rail = arm.get::<DeviceWithL>().await?.with_l.is_on();
        let rail = if on_rail {
            Some(arm.get::<PoseL>().await?.pose_l)
        } else {
            None
        };
        Ok(Self {
            rail,
            ..Self::default()
        })
    }

    /// Combines a status with the known values. `None` if the status is older than the last
    /// reading.
    pub(super) fn reading(&mut self, status: &Status, arm: &Arm) -> Option<ArmReading> {
        let seen = (status.pose, status.at);
        if self.before.is_some_and(|(_, at)| status.at < at) {
            return None;
        }
        // Motion caused by another host shows in the pose alone.
        self.before = Some(seen);
        let moved = self.is_moving(status.pose, status.at);
        Some(self.build(&arm.snapshot(), status, moved, status.at.elapsed()))
    }

    /// Forgets the last poses: the arm has come to rest, or was not read for a while, so comparing
    /// the next pose with the last one would be misleading.
    pub(super) fn reset_poses(&mut self) {
        self.before = None;
        (self.moves, self.last) = (None, None);
    }

    /// True from the first pose that differs from the previous one until the arm is at rest. Two
    /// equal readings do not suffice: a moving arm reports the same pose for 20 ms.
    fn is_moving(&mut self, pose: Pose, at: Instant) -> bool {
        let first_read_at = *self.first_read_at.get_or_insert(at);
        let now = at.saturating_duration_since(first_read_at).as_micros();
        let now = u64::try_from(now).unwrap_or(u64::MAX);
        let last = self.last.replace((pose, now));
        let differs = last.is_some_and(|(last, _)| last != pose);
        let far = last.is_some_and(|(_, at)| now.saturating_sub(at) >= REST_AFTER);
        let moves = match (&mut self.moves, differs) {
            // Moving until the detector sees rest, or until two equal poses are `REST_AFTER` apart.
            (Some(rest), _) => !rest.see(now, pose) && (differs || !far),
            // The first difference starts a new detector.
            (None, true) => {
                let mut rest = RestDetector::default();
                rest.see(now, pose);
                self.moves = Some(rest);
                return true;
            }
            (None, false) => false,
        };
        if !moves {
            self.moves = None;
        }
        moves
    }

    /// Builds a reading: motion and outputs from `now`, everything else from the status.
    fn build(&self, now: &ArmSnapshot, status: &Status, moved: bool, age: Duration) -> ArmReading {
        ArmReading {
            age,
            pose: status.pose,
            current_index: status.current.0,
            left_space: status.left_space,
            alarms: status.alarms.codes().collect(),
            alarm_holds: status.alarms.blocking(),
            link: true,
            moving: now.moving || moved,
            homed: status.homed,
            rail: self.rail,
            tool: tool(&now.outputs),
            speed: now.outputs.speed,
            pins: status.pins.iter().map(pin).collect(),
        }
    }
}

/// Returns the tools in the form of the API.
pub(super) fn tool(outputs: &ArmOutputs) -> ToolReading {
    ToolReading {
        name: outputs.tool.and_then(tool_name),
        bias: outputs.tool,
        suction: outputs.suction,
        gripper: outputs.gripper.map(GripperState::name),
        laser: outputs.laser,
    }
}

/// Returns the name of the tool with this offset of its tip. `None` if it is not a known one.
pub(super) fn tool_name(bias: [f32; 3]) -> Option<&'static str> {
    let [x, y, z] = bias.map(f64::from);
    let own = |named: &ToolBias| {
        let apart = [named.x - x, named.y - y, named.z - z];
        // The controller stores single-precision numbers, so offsets are compared to 0.01 mm.
        apart.iter().all(|apart| apart.abs() < 0.01)
    };
    let mut named = ToolBias::NAMED.iter();
    named.find(|(_, named)| own(named)).map(|(name, _)| *name)
}

fn pin(level: &Level) -> (&'static str, u8, u16) {
    (pin_kind(level.pin), level.pin.address(), level.value)
}

/// Reads the state once. The replies update the driver's picture, whose status is then current.
pub(super) async fn reading(arm: &Arm, known: &mut Known) -> Result<ArmReading> {
    arm.queue().current_index().await?;
    arm.queue().left_space().await?;
    arm.alarms().await?;
    arm.get::<Pose>().await?;
    let status = arm.status().ok_or_else(|| {
        let message = message!("the arm has not told all of its state");
        magician::Error::new(ErrorCode::BadAnswer, message)
    })?;
    known.before = Some((status.pose, status.at));
    let moved = known.is_moving(status.pose, status.at);
    Ok(known.build(&arm.snapshot(), &status, moved, Duration::ZERO))
}

/// Answers a request with the state.
pub(super) async fn state(arm: Arm, known: Known, request: RequestId) -> TaskResult {
    let outcome = async {
        let mut known = Known::read(&arm).await?;
        let reading = reading(&arm, &mut known).await?;
        Ok::<_, magician::Error>((known, reading))
    };
    match outcome.await {
        Ok((known, reading)) => {
            let (known, reading) = (Box::new(known), Box::new(reading));
            TaskResult::Read(request, Ok(Outcome::State), known, Some(reading))
        }
        Err(error) => TaskResult::Read(request, Err(error.into()), Box::new(known), None),
    }
}

/// Answers a request to read.
pub(super) async fn answer(
    arm: Arm,
    known: Known,
    surface: ArmSurface,
    request: RequestId,
    read: ArmRead,
) -> TaskResult {
    if read == ArmRead::State {
        return state(arm, known, request).await;
    }
    let outcome = value(&arm, surface, read).await.map(Outcome::Value);
    TaskResult::Report(crate::order::ArmReport::Done { request, outcome })
}

async fn value(
    arm: &Arm,
    surface: ArmSurface,
    read: ArmRead,
) -> std::result::Result<Value, RpcError> {
    match read {
        ArmRead::Info => to_value(&ArmInfo::read(arm).await?),
        ArmRead::Model => super::model::model(arm).await,
        ArmRead::World { mark } => super::world::describe(arm, mark).await,
        ArmRead::Io => super::io::io(arm).await,
        ArmRead::Alarms => to_value(&AlarmReport::read(arm).await?),
        ArmRead::Stand => {
            arm.wait_still().await?;
            Ok(standing_answer(&arm.get::<Pose>().await?))
        }
        ArmRead::Capture { by, unhomed } => {
            if !unhomed {
                arm.homing().check().await?;
            }
            arm.wait_still().await?;
            capture(&arm.get::<Pose>().await?, by)
        }
        ArmRead::Get { id, params } => {
            let reply = arm.raw(id, Ctrl::GET, &params).await?;
            let answer = describe(&reply.frame(), Direction::Reply).map_err(|error| {
                RpcError::arm(magician::ErrorKind::Unexpected, error.to_string())
            })?;
            to_value(&answer)
        }
        ArmRead::Raw { id, params } => {
            let reply = arm.raw(id, Ctrl::GET, &params).await?;
            Ok(json!({"params": hex(reply.frame().params())}))
        }
        ArmRead::Surface => surface.shown().await,
        // Handled by `answer` above.
        ArmRead::State => Err(RpcError::internal("a state is a reading")),
    }
}

/// Formats bytes as hexadecimal digits.
pub(super) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Returns a pose as a step of a plan file.
pub(super) fn capture(pose: &Pose, by: Travel) -> std::result::Result<Value, RpcError> {
    let wrong = |error: String| RpcError::internal(error);
    let mut taught = ProgramModel::new("", None);
    taught.reach_by(by);
    taught.store(pose);
    let file: Value = serde_json::from_str(&taught.plan(0).to_json())
        .map_err(|error| wrong(error.to_string()))?;
    Ok(json!({"step": file["steps"][0]}))
}
