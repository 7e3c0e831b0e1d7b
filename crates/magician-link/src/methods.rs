//! The vendor's calls as data.

use std::sync::OnceLock;

use magician_protocol::Row;
use serde::Deserialize;
use serde_json::Value;

/// A call of DobotLink for the Magician.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Method {
    /// As in `dobotlink.Magician.NAME`.
    pub name: String,
    /// Id of the command on the wire.
    pub id: u8,
    /// Whether it reads or writes.
    pub access: Access,
    /// How it is answered.
    pub class: Class,
    /// The row of the protocol's table that it is.
    pub command: Option<String>,
    /// How a virtual arm answers, where there is no row.
    #[serde(rename = "virtual")]
    pub virtual_answer: Option<VirtualAnswer>,
    /// Whether it moves the arm, where there is no row to tell.
    #[serde(default)]
    pub moves: bool,
    /// Whether it is dangerous, where there is no row to tell.
    #[serde(default)]
    pub dangerous: bool,
    /// Never sent.
    pub refused: Option<Refused>,
    /// What it takes beside the parameters of all calls.
    #[serde(default)]
    pub params: Vec<Param>,
    /// What a reading answers.
    #[serde(default)]
    pub results: Vec<ResultField>,
}

/// Whether a call reads or writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Access {
    /// It reads.
    Read,
    /// It writes.
    Write,
}

/// How a call is answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Class {
    /// At once.
    Plain,
    /// At once; with `isQueued` by its index.
    Queue,
    /// Queued, and answered when it has ended, unless `isWaitForFinish` is false.
    Action,
}

/// How a virtual arm answers what is no row of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum VirtualAnswer {
    /// "Magician".
    ProductName,
    /// The kind of tool, by its bias.
    Tool,
    /// Ratios of moves and jogs.
    ArmSpeed,
    /// Speed of the rail.
    RailSpeed,
    /// Whether a pose is beyond what the arm reaches.
    Reach,
    /// Whether homing has ended.
    Homing,
}

/// Why a call is never sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Refused {
    /// It changes or restarts the firmware.
    Firmware,
}

/// A parameter.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Param {
    /// Its name; with a dot it is a member of an object.
    pub name: String,
    /// What it may be.
    pub kind: Kind,
    /// The field of the row.
    pub field: Option<String>,
    /// How it is laid out, where there is no row.
    pub wire: Option<Wire>,
    /// What stands for it when it is left out; without one it must be given.
    pub default: Option<Value>,
    /// Other names that programs use.
    #[serde(default)]
    pub aliases: Vec<String>,
}

/// What a parameter may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// A number.
    Number,
    /// A whole number.
    Integer,
    /// True or false, 1 or 0.
    Bool,
    /// A text.
    Text,
    /// Numbers.
    Numbers,
    /// An object x, y, z, r.
    Point,
    /// Objects ratio, port, level.
    Outputs,
}

impl Kind {
    /// What it is, as in "must be ..".
    pub(crate) const fn wanted(self) -> &'static str {
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

/// How a value lies in a frame, where the protocol's table has no row: little endian.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Wire {
    /// A byte.
    U8,
    /// A float of four bytes.
    F32,
    /// The rest, to the first zero byte.
    Text,
}

/// A value of an answer.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResultField {
    /// Its name.
    pub name: String,
    /// The field of the row.
    pub field: Option<String>,
    /// How it is laid out, where there is no row.
    pub wire: Option<Wire>,
    /// What is made of the number.
    #[serde(default)]
    pub kind: Shape,
}

/// What is made of a field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// Itself.
    #[default]
    Value,
    /// True or false.
    Bool,
    /// Milliseconds as `hh:mm:ss.z`.
    Clock,
    /// The byte of the hardware's version in what follows the three of the firmware's.
    Hardware,
    /// There while the path follows in real time.
    Period,
    /// There while it does not.
    Acceleration,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    method: Vec<Method>,
}

/// All calls, in the order of their ids.
///
/// # Panics
/// Never: the file is part of this crate, and read by its tests.
#[must_use]
pub fn methods() -> &'static [Method] {
    static METHODS: OnceLock<Vec<Method>> = OnceLock::new();
    METHODS.get_or_init(|| {
        let table: Table = toml::from_str(include_str!("../methods.toml")).expect("methods.toml");
        table.method
    })
}

impl Method {
    /// The row of the protocol's table that it is.
    #[must_use]
    pub fn row(&self) -> Option<&'static Row> {
        Row::find(self.command.as_deref()?).ok()
    }

    /// The call of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        methods().iter().find(|method| method.name == name)
    }
}
