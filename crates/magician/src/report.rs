//! State of an arm as JSON objects, the same for the command (`--json`), the station and all other
//! front ends.
//!
//! Names and structure are contracts: fields may be added, never renamed. Lengths are in mm, angles
//! in degrees.

use serde::ser::{SerializeMap, SerializeSeq};
use serde::{Deserialize, Serialize, Serializer};

use magician_protocol::commands::{
    DeviceId, DeviceName, DeviceSn, DeviceTime, DeviceVersion, DeviceWithL, Pose,
};
use magician_protocol::{Alarm, AlarmSet};

use crate::{
    Act, Arm, ArmOutputs, Cuboid, Error, ErrorKind, Fence, Given, GripperState, Link, Message,
    MessageValue, Remedy, Result, Status,
};

/// Pose of the tool tip (mm, deg) and joint angles (deg).
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct PoseReport {
    /// Distance in front of the base, mm.
    pub x: f32,
    /// Distance to the left, mm.
    pub y: f32,
    /// Height, mm.
    pub z: f32,
    /// Rotation of the tool about the vertical, deg.
    pub r: f32,
    /// Base joint, deg.
    pub j1: f32,
    /// Rear arm, deg.
    pub j2: f32,
    /// Forearm, deg.
    pub j3: f32,
    /// Tool joint, deg.
    pub j4: f32,
}

impl From<Pose> for PoseReport {
    fn from(pose: Pose) -> Self {
        let [j1, j2, j3, j4] = pose.joint_angle;
        let Pose { x, y, z, r, .. } = pose;
        Self {
            x,
            y,
            z,
            r,
            j1,
            j2,
            j3,
            j4,
        }
    }
}

/// State of an arm: the pose and other readings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StatusReport {
    /// Pose and joint angles.
    #[serde(flatten)]
    pub pose: PoseReport,
    /// Index of the queued command that finished last.
    pub current_index: u64,
    /// Free places in the queue.
    pub left_space: u32,
    /// Codes of the active alarms.
    pub alarms: Vec<u8>,
    /// `up`, `lost` or `closed`.
    pub link: &'static str,
    /// True if the laser is on; null if the arm does not report it.
    pub laser: Option<bool>,
    /// True if the suction cup is on; null if unknown.
    pub suction: Option<bool>,
    /// `open`, `closed` or `off`; null if unknown.
    pub gripper: Option<&'static str>,
}

impl StatusReport {
    /// Creates a report from a reading and the known outputs.
    #[must_use]
    pub fn new(status: &Status, outputs: &ArmOutputs) -> Self {
        Self {
            pose: PoseReport::from(status.pose),
            current_index: status.current.0,
            left_space: status.left_space,
            alarms: status.alarms.codes().collect(),
            link: match status.link {
                Link::Up => "up",
                Link::Lost { .. } => "lost",
                Link::Closed => "closed",
            },
            laser: outputs.laser,
            suction: outputs.suction,
            gripper: outputs.gripper.map(GripperState::name),
        }
    }
}

/// Identity and state of an arm.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ArmInfo {
    /// Target of the connection.
    pub port: String,
    /// Name of the arm.
    pub device_name: String,
    /// Serial number of the arm.
    pub device_sn: String,
    /// Firmware version, as `3.2.2`.
    pub firmware: String,
    /// Processor id; null if the firmware does not report it.
    pub device_id: Option<[u32; 3]>,
    /// Time since power-up, ms.
    pub uptime_ms: u32,
    /// True if a rail is configured.
    pub with_l: bool,
    /// Codes of the active alarms.
    pub alarms: Vec<u8>,
    /// Index of the queued command that finished last.
    pub queue_current_index: u64,
    /// Free places in the queue.
    pub queue_left_space: u32,
    /// True if the laser is on; null if the arm does not report it.
    pub laser: Option<bool>,
    /// True if the suction cup is on; null if unknown.
    pub suction: Option<bool>,
    /// `open`, `closed` or `off`; null if unknown.
    pub gripper: Option<&'static str>,
    /// Fence that this connection enforces; null without one.
    pub fence: Option<FenceReport>,
}

impl ArmInfo {
    /// Reads identity and state.
    ///
    /// # Errors
    /// Same as [`Arm::get`].
    pub async fn read(arm: &Arm) -> Result<Self> {
        let version = arm.get::<DeviceVersion>().await?;
        let numbers = [
            version.major_version,
            version.minor_version,
            version.revision,
        ];
        let name = arm.get::<DeviceName>().await?.device_name;
        let serial = arm.get::<DeviceSn>().await?.device_sn;
        let outputs = arm.read_outputs().await?;
        Ok(Self {
            port: arm.name().to_owned(),
            device_name: name.lossy().to_string(),
            device_sn: serial.lossy().to_string(),
            firmware: numbers.map(|number| number.to_string()).join("."),
            // An extra timeout on older firmware; nothing else identifies the processor.
            device_id: device_id(arm).await?,
            uptime_ms: arm.get::<DeviceTime>().await?.g_systick,
            with_l: arm.get::<DeviceWithL>().await?.with_l.is_on(),
            alarms: arm.alarms().await?.codes().collect(),
            queue_current_index: arm.queue().current_index().await?.0,
            queue_left_space: arm.queue().left_space().await?,
            laser: outputs.laser,
            suction: outputs.suction,
            gripper: outputs.gripper.map(GripperState::name),
            fence: arm.fence().as_ref().map(FenceReport::from),
        })
    }
}

/// Reads the processor id; `None` if the firmware is too old to answer.
async fn device_id(arm: &Arm) -> Result<Option<[u32; 3]>> {
    match arm.get::<DeviceId>().await {
        Ok(id) => Ok(Some(id.device_id)),
        Err(error) if error.kind() == ErrorKind::Timeout => Ok(None),
        Err(error) => Err(error),
    }
}

/// Active alarms.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AlarmReport {
    /// The alarms, with their descriptions.
    pub alarms: Vec<AlarmEntry>,
    /// True if a pose was out of reach and no tool was ever set. Absent otherwise.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub tool_unknown: bool,
}

/// Active alarm.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AlarmEntry {
    /// Code of the alarm.
    pub code: u8,
    /// Name; null for an unknown code, like the next two fields.
    pub name: Option<&'static str>,
    /// Cause.
    pub cause: Option<&'static str>,
    /// Remedy.
    pub remedy: Option<&'static str>,
    /// Same as `remedy`, under its former name.
    pub cure: Option<&'static str>,
    /// True if it holds the queue.
    pub holds_queue: bool,
}

impl AlarmReport {
    /// Reads the active alarms.
    ///
    /// # Errors
    /// Same as [`Arm::get`].
    pub async fn read(arm: &Arm) -> Result<Self> {
        let alarms = arm.alarms().await?;
        let tool_unknown = arm.front_end().tool_is_unknown(&alarms).await?;
        let entry = |code| {
            let alarm = Alarm::with_code(code);
            let remedy = alarm.map(|alarm| alarm.remedy);
            AlarmEntry {
                code,
                name: alarm.map(|alarm| alarm.name),
                cause: alarm.map(|alarm| alarm.cause),
                remedy,
                cure: remedy,
                holds_queue: Alarm::blocks(code),
            }
        };
        Ok(Self {
            alarms: AlarmSet::codes(&alarms).map(entry).collect(),
            tool_unknown,
        })
    }
}

/// Fence, with the names of the settings file. Null for a missing bound.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FenceReport {
    /// Lowest height of the tool tip, mm.
    pub floor: Option<f64>,
    /// Corners of the box to stay in, mm.
    #[serde(rename = "box")]
    pub within: Option<[[f64; 3]; 2]>,
    /// Corners of each box to stay out of, mm.
    pub keep_out: Vec<[[f64; 3]; 2]>,
    /// Top speed of the tool tip, mm/s.
    pub top_speed: Option<f64>,
    /// Strongest laser power, percent.
    pub strongest_laser: Option<f64>,
}

impl From<&Fence> for FenceReport {
    fn from(fence: &Fence) -> Self {
        let corners = |cuboid: &Cuboid| [cuboid.min, cuboid.max];
        Self {
            floor: fence.floor(),
            within: fence.within().as_ref().map(corners),
            keep_out: fence.keep_outs().iter().map(corners).collect(),
            top_speed: fence.top_speed(),
            strongest_laser: fence.strongest_laser(),
        }
    }
}

/// Values of an error. Values that do not apply are absent.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ErrorFigures {
    /// Error code.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub code: Option<&'static str>,
    /// Position of the command in a list, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step: Option<usize>,
    /// Command of the protocol.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub command: Option<String>,
    /// Requested value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// Limit that it exceeds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit: Option<f64>,
    /// Unit of value and limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<&'static str>,
    /// Part of the arm's fence that it violates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fence: Option<&'static str>,
    /// First queue index in doubt.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from: Option<u64>,
    /// Last queue index in doubt.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<u64>,
    /// Remedies.
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "remedies")]
    pub remedies: Vec<Remedy>,
    /// Address of the station of this machine that has the port.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub station: Option<String>,
    /// Message as a template with values, for translation.
    #[serde(skip)]
    pub sentence: SentenceReport,
    /// Message without the name of the protocol command.
    #[serde(skip)]
    pub fact: Option<String>,
}

impl ErrorFigures {
    /// Returns the values of an error.
    #[must_use]
    pub fn of(error: &Error) -> Self {
        Self {
            code: Some(error.code().name()),
            // People count steps from 1.
            step: error.step().map(|step| step + 1),
            command: error.command().map(str::to_owned),
            value: error.value(),
            limit: error.limit(),
            unit: error.unit(),
            fence: error.breach().map(|breach| breach.part.name()),
            from: error.from_index(),
            to: error.to_index(),
            remedies: error.remedies().to_vec(),
            station: error.station().map(str::to_owned),
            sentence: SentenceReport::of(error.sentence()),
            // Without a command the sentence already is the bare fact.
            fact: error.command().map(|_| error.message().to_owned()),
        }
    }
}

/// Sentence as data: the template and its values let a program translate it, or use its own names
/// of options.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SentenceReport {
    /// English sentence with the names of its values in braces. A sentence without a template is
    /// its own template.
    pub template: String,
    /// Values of the template.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<SentenceValue>,
}

/// Value in a sentence. Exactly one of `text`, `option` and `sentence` is present.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SentenceValue {
    /// Name in the template.
    pub name: String,
    /// Number or quotation, as printed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub text: Option<String>,
    /// Name of an option, in `snake_case`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub option: Option<String>,
    /// Nested sentence.
    #[serde(flatten)]
    pub sentence: Option<SentenceReport>,
}

impl SentenceReport {
    /// Splits a message into template and values.
    #[must_use]
    pub fn of(message: &Message) -> Self {
        let Some(template) = message.template() else {
            return Self {
                template: message.as_str().to_owned(),
                ..Self::default()
            };
        };
        let values = message.values().iter();
        let values = values.map(|(name, value)| SentenceValue {
            name: name.to_string(),
            ..SentenceValue::from(value)
        });
        Self {
            template: template.into_owned(),
            values: values.collect(),
        }
    }
}

impl From<&MessageValue> for SentenceValue {
    fn from(value: &MessageValue) -> Self {
        match value {
            MessageValue::Text(text) => Self {
                text: Some(text.clone()),
                ..Self::default()
            },
            MessageValue::Message(message) => Self {
                sentence: Some(SentenceReport::of(message)),
                ..Self::default()
            },
            MessageValue::Option(name) => Self {
                option: Some(name.to_string()),
                ..Self::default()
            },
            // Unreachable in a published build too: the crates depend on each other by exact
            // version.
            #[cfg(not(magician_workspace))]
            _ => unreachable!(),
        }
    }
}

/// Serializes remedies as JSON: `{"action":"home","effect":".."}`,
/// `{"option":"scale","value":0.5}`, `{"without":"raw"}`, `{"system":"sudo .."}`.
///
/// # Errors
/// Errors of the serializer.
pub fn remedies<S: Serializer>(remedies: &[Remedy], to: S) -> Result<S::Ok, S::Error> {
    let mut list = to.serialize_seq(Some(remedies.len()))?;
    for remedy in remedies {
        list.serialize_element(&RemedyJson(remedy))?;
    }
    list.end()
}

struct RemedyJson<'r>(&'r Remedy);

impl Serialize for RemedyJson<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(None)?;
        match &self.0.act {
            Act::Do(action) => map.serialize_entry("action", action.name())?,
            Act::Give(setting, given) => {
                map.serialize_entry("option", setting.name())?;
                match given {
                    Given::On => map.serialize_entry("value", &true)?,
                    Given::Off => map.serialize_entry("value", &false)?,
                    Given::Number(number) => map.serialize_entry("value", number)?,
                    Given::Point(x, y) => map.serialize_entry("value", &[x, y])?,
                    Given::Position(at) => map.serialize_entry("value", at)?,
                    Given::Word(word) => map.serialize_entry("value", word)?,
                    // The user chooses the value.
                    _ => {}
                }
            }
            Act::Omit(setting) => map.serialize_entry("without", setting.name())?,
            Act::System(line) => map.serialize_entry("system", line)?,
            Act::SetPin(pin, function) => {
                map.serialize_entry("action", magician_host::SET_PIN)?;
                map.serialize_entry("pin", pin)?;
                map.serialize_entry("function", function.name())?;
            }
            // A command line to type, in whichever program the error occurred.
            Act::UseStation(url) => {
                map.serialize_entry("system", &format!("magician --station {url} VERB"))?;
            }
            // Unreachable in a published build too: the crates depend on each other by exact
            // version.
            #[cfg(not(magician_workspace))]
            _ => unreachable!(),
        }
        // An empty effect is left out: the contract has absent fields, not empty ones.
        if !self.0.effect.is_empty() {
            map.serialize_entry("effect", &self.0.effect)?;
        }
        map.end()
    }
}
