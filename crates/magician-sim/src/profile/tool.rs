//! A tool in a profile: a name, or a bias in mm.

use std::fmt;

use magician_motion::ToolBias;
use serde::de::{Deserializer, Error, SeqAccess, Unexpected, Visitor};
use serde::{Serialize, Serializer};

/// Reads `"suction"` or `[59.7, 0.0, 0.0]`.
pub(super) fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<ToolBias, D::Error> {
    deserializer.deserialize_any(ToolVisitor)
}

/// Writes the first name with this bias, else the bias itself.
pub(super) fn write<S: Serializer>(tool: &ToolBias, serializer: S) -> Result<S::Ok, S::Error> {
    // Suction cup and gripper share a bias (model section 1); the first name is written for both.
    match ToolBias::NAMED.iter().find(|(_, bias)| bias == tool) {
        Some((name, _)) => serializer.serialize_str(name),
        None => [tool.x, tool.y, tool.z].serialize(serializer),
    }
}

struct ToolVisitor;

impl<'de> Visitor<'de> for ToolVisitor {
    type Value = ToolBias;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a tool (none, suction, gripper, pen or laser) or its bias [x, y, z] in mm")
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<ToolBias, E> {
        text.parse()
            .map_err(|_| E::invalid_value(Unexpected::Str(text), &self))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<ToolBias, A::Error> {
        let mut bias = [0.0_f64; 3];
        for (at, part) in bias.iter_mut().enumerate() {
            *part = seq
                .next_element()?
                .ok_or_else(|| A::Error::invalid_length(at, &self))?;
        }
        let [x, y, z] = bias;
        match seq.next_element::<f64>()? {
            None => Ok(ToolBias::new(x, y, z)),
            Some(_) => Err(A::Error::invalid_length(4, &self)),
        }
    }
}
