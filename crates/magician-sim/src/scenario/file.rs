//! The scenario file as written: names and shapes, without meaning.
//!
//! Values that can be checked by themselves have their type in `setting.rs`. The types here hold
//! values whose meaning depends on other parts of the file.

use magician_protocol::Port;
use serde::Deserialize;
use serde::de::{Error, SeqAccess, Visitor};

use super::color::Color;
use super::setting::{Arm, Conveyor, SensorKind, Table, ToolKind};
use crate::world::Press;

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    pub(super) title: Option<String>,
    pub(super) arm: Option<Arm>,
    pub(super) tool: Option<Tool>,
    pub(super) table: Option<Table>,
    pub(super) conveyor: Option<Conveyor>,
    #[serde(default)]
    pub(super) object: Vec<Object>,
    #[serde(default)]
    pub(super) sensor: Vec<Sensor>,
    #[serde(default)]
    pub(super) input: Vec<Input>,
    #[serde(default)]
    pub(super) hand: Vec<Hand>,
    #[serde(default)]
    pub(super) key: Vec<Key>,
    #[serde(default)]
    pub(super) fault: Vec<Fault>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Tool {
    pub(super) kind: ToolKind,
    pub(super) give: Option<f64>,
    pub(super) opening: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Object {
    pub(super) name: String,
    pub(super) size: [f64; 3],
    pub(super) at: [f64; 2],
    pub(super) yaw: Option<f64>,
    pub(super) color: Option<Color>,
    pub(super) on: Option<String>,
    pub(super) z: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Sensor {
    pub(super) kind: SensorKind,
    #[serde(with = "PortName")]
    pub(super) port: Port,
    pub(super) at: Option<[f64; 3]>,
    pub(super) facing: Option<Facing>,
    pub(super) range: Option<f64>,
    pub(super) belt_at: Option<f64>,
    pub(super) above: Option<f64>,
}

/// Connectors, by the names printed on the arm.
#[derive(Deserialize)]
#[serde(remote = "Port", rename_all = "UPPERCASE")]
enum PortName {
    Gp1,
    Gp2,
    Gp4,
    Gp5,
}

/// Direction of a sensor: `"up"`, `"down"`, or the heading of a level beam in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Facing {
    Up,
    Down,
    Level(f64),
}

impl<'de> Deserialize<'de> for Facing {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(FacingVisitor)
    }
}

struct FacingVisitor;

impl Visitor<'_> for FacingVisitor {
    type Value = Facing;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("\"up\", \"down\" or the direction of a level beam in degrees")
    }

    fn visit_str<E: Error>(self, word: &str) -> Result<Facing, E> {
        match word {
            "up" => Ok(Facing::Up),
            "down" => Ok(Facing::Down),
            _ => Err(E::invalid_value(serde::de::Unexpected::Str(word), &self)),
        }
    }

    fn visit_f64<E: Error>(self, degrees: f64) -> Result<Facing, E> {
        Ok(Facing::Level(degrees))
    }

    // A direction is often a whole number, which TOML keeps apart from a float.
    fn visit_i64<E: Error>(self, degrees: i64) -> Result<Facing, E> {
        Ok(Facing::Level(degrees as f64))
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Input {
    pub(super) address: i64,
    pub(super) level: Option<i64>,
    pub(super) value: Option<i64>,
    pub(super) at: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum HandKind {
    Unlock,
    Guide,
    Release,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Hand {
    pub(super) kind: HandKind,
    pub(super) at: f64,
    pub(super) joints: Option<[f64; 4]>,
    pub(super) over: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Key {
    pub(super) press: Press,
    pub(super) at: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum FaultKind {
    Slip,
    Cable,
    Reset,
    Slow,
    Alarm,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Fault {
    pub(super) kind: FaultKind,
    pub(super) at: Option<f64>,
    pub(super) index: Option<i64>,
    pub(super) joint: Option<i64>,
    pub(super) degrees: Option<f64>,
    #[serde(rename = "for")]
    pub(super) lasting: Option<f64>,
    pub(super) delay: Option<f64>,
    pub(super) alarm: Option<Alarm>,
}

/// An alarm, by code or by name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Alarm {
    Code(i64),
    Name(String),
}

impl<'de> Deserialize<'de> for Alarm {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(AlarmVisitor)
    }
}

struct AlarmVisitor;

impl Visitor<'_> for AlarmVisitor {
    type Value = Alarm;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("an alarm's code, as 0x40, or its name, as \"LimitAxis1Pos\"")
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<Alarm, E> {
        Ok(Alarm::Name(name.to_owned()))
    }

    fn visit_i64<E: Error>(self, code: i64) -> Result<Alarm, E> {
        Ok(Alarm::Code(code))
    }
}

impl<'de> Deserialize<'de> for Color {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ColorVisitor)
    }
}

struct ColorVisitor;

impl<'de> Visitor<'de> for ColorVisitor {
    type Value = Color;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "a colour: [r, g, b] from 0 to 255, \"#rrggbb\", or one of {}",
            Color::names()
        )
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Color, E> {
        Color::parse(text).ok_or_else(|| E::invalid_value(serde::de::Unexpected::Str(text), &self))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Color, A::Error> {
        let mut rgb = [0_u8; 3];
        for (at, byte) in rgb.iter_mut().enumerate() {
            *byte = seq
                .next_element()?
                .ok_or_else(|| A::Error::invalid_length(at, &self))?;
        }
        // A fourth number would be an alpha value, which objects do not have.
        match seq.next_element::<u8>()? {
            None => Ok(Color(rgb)),
            Some(_) => Err(A::Error::invalid_length(4, &self)),
        }
    }
}
