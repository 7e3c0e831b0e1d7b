//! What an arm says of itself as objects of JSON: the same for the command (`--json`), for a station, and for whatever comes next.
//!
//! Names and shapes are contracts: fields are added, none is renamed. Lengths are mm, angles deg.

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

/// A pose: the tip's (mm, deg) and the joints' (deg).
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct PoseReport {
    /// Away from the base, mm.
    pub x: f32,
    /// To the left, mm.
    pub y: f32,
    /// Up, mm.
    pub z: f32,
    /// About the vertical, deg.
    pub r: f32,
    /// The base, deg.
    pub j1: f32,
    /// The rear arm, deg.
    pub j2: f32,
    /// The forearm, deg.
    pub j3: f32,
    /// The tool, deg.
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

/// A state: the pose, and what else was read.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StatusReport {
    /// The pose.
    #[serde(flatten)]
    pub pose: PoseReport,
    /// The command of the queue that was finished last.
    pub current_index: u64,
    /// Free places in the queue.
    pub left_space: u32,
    /// Codes of the alarms that stand.
    pub alarms: Vec<u8>,
    /// `up`, `lost` or `closed`.
    pub link: &'static str,
    /// Whether the laser is on; null where the arm does not say.
    pub laser: Option<bool>,
    /// Whether the suction cup is on; null if not known.
    pub suction: Option<bool>,
    /// `open`, `closed` or `off`; null if not known.
    pub gripper: Option<&'static str>,
}

impl StatusReport {
    /// Of a reading, and what is known of laser and tools.
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

/// An arm's identity and state.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ArmInfo {
    /// Where it is connected.
    pub port: String,
    /// Its name.
    pub device_name: String,
    /// Its serial number.
    pub device_sn: String,
    /// Its firmware, as `3.2.2`.
    pub firmware: String,
    /// Its processor's id; null where firmware does not tell it.
    pub device_id: Option<[u32; 3]>,
    /// How long it has been switched on, ms.
    pub uptime_ms: u32,
    /// Whether it uses a rail.
    pub with_l: bool,
    /// Codes of the alarms that stand.
    pub alarms: Vec<u8>,
    /// The command of the queue that was finished last.
    pub queue_current_index: u64,
    /// Free places in the queue.
    pub queue_left_space: u32,
    /// Whether the laser is on; null where the arm does not say.
    pub laser: Option<bool>,
    /// Whether the suction cup is on; null if not known.
    pub suction: Option<bool>,
    /// `open`, `closed` or `off`; null if not known.
    pub gripper: Option<&'static str>,
    /// The fence that this computer holds it to, if there is one.
    pub fence: Option<FenceReport>,
}

impl ArmInfo {
    /// Reads it.
    ///
    /// # Errors
    /// As [`Arm::get`].
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

/// Older firmware does not answer this one.
async fn device_id(arm: &Arm) -> Result<Option<[u32; 3]>> {
    match arm.get::<DeviceId>().await {
        Ok(id) => Ok(Some(id.device_id)),
        Err(error) if error.kind() == ErrorKind::Timeout => Ok(None),
        Err(error) => Err(error),
    }
}

/// The alarms that stand.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AlarmReport {
    /// Each with what is known of it.
    pub alarms: Vec<AlarmEntry>,
    /// A pose was out of reach, and the arm was never told of a tool. Absent otherwise.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub tool_unknown: bool,
}

/// An alarm.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AlarmEntry {
    /// Its code.
    pub code: u8,
    /// Its name; null for a code that is not known, as the two that follow.
    pub name: Option<&'static str>,
    /// Why it stands.
    pub cause: Option<&'static str>,
    /// What to do about it.
    pub cure: Option<&'static str>,
    /// Whether it holds the queue.
    pub holds_queue: bool,
}

impl AlarmReport {
    /// Reads them.
    ///
    /// # Errors
    /// As [`Arm::get`].
    pub async fn read(arm: &Arm) -> Result<Self> {
        let alarms = arm.alarms().await?;
        let tool_unknown = arm.front_end().tool_is_unknown(&alarms).await?;
        let entry = |code| {
            let alarm = Alarm::with_code(code);
            AlarmEntry {
                code,
                name: alarm.map(|alarm| alarm.name),
                cause: alarm.map(|alarm| alarm.cause),
                cure: alarm.map(|alarm| alarm.remedy),
                holds_queue: Alarm::blocks(code),
            }
        };
        Ok(Self {
            alarms: AlarmSet::codes(&alarms).map(entry).collect(),
            tool_unknown,
        })
    }
}

/// A fence: its bounds by their names in the file of settings; what is not bounded is null.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FenceReport {
    /// The least height of the tip, mm.
    pub floor: Option<f64>,
    /// The corners of what it has to stay in, mm.
    #[serde(rename = "box")]
    pub within: Option<[[f64; 3]; 2]>,
    /// The corners of each part that it has to stay out of, mm.
    pub keep_out: Vec<[[f64; 3]; 2]>,
    /// Of the tip, mm/s.
    pub top_speed: Option<f64>,
    /// Percent.
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

/// What an error is about, in figures. What does not apply is absent.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ErrorFigures {
    /// Which error it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub code: Option<&'static str>,
    /// The place of the command in a list, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step: Option<usize>,
    /// The command of the protocol.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub command: Option<String>,
    /// What was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// What is possible.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit: Option<f64>,
    /// The unit of both.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<&'static str>,
    /// The part of the arm's fence that it would break.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fence: Option<&'static str>,
    /// First queue index in doubt.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from: Option<u64>,
    /// Last queue index in doubt.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<u64>,
    /// What to do about it.
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "remedies")]
    pub remedies: Vec<Remedy>,
    /// Address of the station of this machine that has the port.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub station: Option<String>,
    /// What is wrong as a sentence that other languages can say.
    #[serde(skip)]
    pub sentence: SentenceReport,
    /// What is wrong, without the command of the protocol before it.
    #[serde(skip)]
    pub fact: Option<String>,
}

impl ErrorFigures {
    /// The parts of an error.
    #[must_use]
    pub fn of(error: &Error) -> Self {
        Self {
            code: Some(error.code().name()),
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
            fact: error.command().map(|_| error.message().to_owned()),
        }
    }
}

/// A sentence as data beside its text: with the template and the values a program says it in another language, or calls
/// options by its own names.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SentenceReport {
    /// English sentence with the names of its values in braces; a sentence that was made without a template is its own.
    pub template: String,
    /// Its values.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<SentenceValue>,
}

/// A value in a sentence. One of `text`, `option` and `sentence` is there.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SentenceValue {
    /// Its name in the template.
    pub name: String,
    /// A number or a quotation, as it is printed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub text: Option<String>,
    /// The name of an option, in `snake_case`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub option: Option<String>,
    /// Words that are a sentence of their own.
    #[serde(flatten)]
    pub sentence: Option<SentenceReport>,
}

impl SentenceReport {
    /// The parts of a message.
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
            #[cfg(not(magician_workspace))]
            _ => unreachable!(),
        }
    }
}

/// What to do, as JSON: `{"action":"home","effect":".."}`, `{"option":"scale","value":0.5}`, `{"without":"raw"}`,
/// `{"system":"sudo .."}`.
///
/// # Errors
/// Those of the serializer.
pub fn remedies<S: Serializer>(remedies: &[Remedy], to: S) -> Result<S::Ok, S::Error> {
    let mut list = to.serialize_seq(Some(remedies.len()))?;
    for remedy in remedies {
        list.serialize_element(&Told(remedy))?;
    }
    list.end()
}

struct Told<'r>(&'r Remedy);

impl Serialize for Told<'_> {
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
                    // The person chooses it.
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
            // A line that is typed, in whichever program the error came up.
            Act::UseStation(url) => {
                map.serialize_entry("system", &format!("magician --station {url} VERB"))?;
            }
            #[cfg(not(magician_workspace))]
            _ => unreachable!(),
        }
        if !self.0.effect.is_empty() {
            map.serialize_entry("effect", &self.0.effect)?;
        }
        map.end()
    }
}
