//! The vendor's calls as data, read from `methods.toml`.

use std::sync::OnceLock;

use magician_protocol::Row;
use serde::Deserialize;
use serde_json::Value;

/// Call of DobotLink for the Magician.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Method {
    /// Name, as in `dobotlink.Magician.NAME`.
    pub name: String,
    /// Id of the command in the frame.
    pub id: u8,
    /// Read or write.
    pub access: Access,
    /// Way in which it is answered.
    pub class: AnswerTime,
    /// Name of the command's row in the protocol's table. `None` without a row.
    pub command: Option<String>,
    /// Answer of a virtual arm to a command without a row. `None` if it has no answer.
    #[serde(rename = "virtual")]
    pub virtual_answer: Option<VirtualAnswer>,
    /// True if the call moves the arm; used for commands without a row.
    #[serde(default)]
    pub moves: bool,
    /// True if the call is dangerous; used for commands without a row.
    #[serde(default)]
    pub dangerous: bool,
    /// Reason why the call is never sent. `None` for calls that are.
    pub refused: Option<Refusal>,
    /// Parameters, besides those of all calls.
    #[serde(default)]
    pub params: Vec<Param>,
    /// Values in the answer to a read.
    #[serde(default)]
    pub results: Vec<ResultField>,
}

/// Direction of a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Access {
    /// Reads a value.
    Read,
    /// Writes a value or a command.
    Write,
}

/// Way in which a call is answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AnswerTime {
    /// Immediately.
    Plain,
    /// Immediately; with `isQueued` by the index of the command.
    Queue,
    /// Queued, and answered when the command has finished, unless `isWaitForFinish` is false.
    Action,
}

/// Answer of a virtual arm to a command without a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum VirtualAnswer {
    /// The text "Magician".
    ProductName,
    /// Number of the tool, derived from the offset of its tip.
    Tool,
    /// Ratios of moves and jogs.
    ArmSpeed,
    /// Speed of the rail.
    RailSpeed,
    /// True if a pose is out of reach.
    Reach,
    /// True if homing has finished.
    Homing,
}

/// Reason why a call is never sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Refusal {
    /// Changes or restarts the firmware.
    Firmware,
}

/// Parameter of a call.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Param {
    /// Name. With a point it is a member of an object.
    pub name: String,
    /// Type.
    pub kind: ParamType,
    /// Field of the command. `None` if the table does not have the command.
    pub field: Option<String>,
    /// Encoding, for commands without a row.
    pub wire: Option<WireType>,
    /// Default. `None` if the parameter is required.
    pub default: Option<Value>,
    /// Other names that known programs use.
    #[serde(default)]
    pub aliases: Vec<String>,
}

/// Type of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ParamType {
    /// A number.
    Number,
    /// A whole number.
    Integer,
    /// True, false, 1 or 0.
    Bool,
    /// A text.
    Text,
    /// Array of numbers.
    Numbers,
    /// Object with x, y, z, r.
    Point,
    /// Array of objects with ratio, port, level.
    Outputs,
}

impl ParamType {
    /// Returns the type in words, as in "must be ..".
    pub(crate) const fn description(self) -> &'static str {
        match self {
            Self::Number => "a number",
            Self::Integer => "a whole number",
            Self::Bool => "true or false",
            Self::Text => "a text",
            Self::Numbers => "numbers",
            Self::Point => "an object of the numbers x, y, z, r",
            Self::Outputs => "objects of the whole numbers ratio, port, level",
        }
    }
}

/// Encoding of a value in a frame, little endian, for commands without a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum WireType {
    /// Byte.
    U8,
    /// Single-precision number, four bytes.
    F32,
    /// Text up to the first zero byte. Takes the rest of the frame.
    Text,
}

/// Value of an answer.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResultField {
    /// Name.
    pub name: String,
    /// Field of the command. `None` if the table does not have the command.
    pub field: Option<String>,
    /// Encoding, for commands without a row.
    pub wire: Option<WireType>,
    /// Conversion of the value.
    #[serde(default)]
    pub kind: Conversion,
}

/// Conversion of a field to the value in an answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Conversion {
    /// Unchanged.
    #[default]
    Value,
    /// True or false.
    Bool,
    /// Milliseconds as `hh:mm:ss.z`.
    Clock,
    /// Hardware version: one of the bytes that follow the three numbers of the firmware version.
    Hardware,
    /// Present only while the path is tracked in real time.
    Period,
    /// Present only while the path is not tracked in real time.
    Acceleration,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    method: Vec<Method>,
}

/// Returns all calls, sorted by id.
///
/// # Panics
/// Never: the file is part of the crate, and the tests read it.
#[must_use]
pub fn methods() -> &'static [Method] {
    static METHODS: OnceLock<Vec<Method>> = OnceLock::new();
    METHODS.get_or_init(|| {
        let table: Table = toml::from_str(include_str!("../methods.toml")).expect("methods.toml");
        table.method
    })
}

impl Method {
    /// Returns the command in the protocol's table. `None` if the table does not have it.
    #[must_use]
    pub fn row(&self) -> Option<&'static Row> {
        Row::find(self.command.as_deref()?).ok()
    }

    /// Returns the call with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        methods().iter().find(|method| method.name == name)
    }
}
