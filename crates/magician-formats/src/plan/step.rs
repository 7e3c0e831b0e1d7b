use magician_host::{Message, MessageValue, ToMessageValue};
use std::fmt;
use std::str::FromStr;

use magician_motion::ToolBias;
use magician_protocol::commands::EndEffectorParams;

use super::{Action, Color};
use crate::Origin;

/// One step of a plan: one command. Steps that do the same are equal, whatever their colour.
#[derive(Clone, Debug)]
pub struct Step {
    /// What is done.
    pub action: Action,
    /// Where it came from.
    pub origin: Origin,
    /// Of a burn whose power is to be in proportion to speed (M4): the speed at which it has the power that it says, mm/s.
    /// [`Plan::powered_by_speed`](super::Plan::powered_by_speed) makes the proportion, and leaves none.
    pub feed: Option<f32>,
    /// Whether its power was made in proportion to speed: at a lower speed it burns as deep with a lower power.
    pub follows_speed: bool,
    /// Colour of its line in the drawing, which a preview shows; `None` if it is unknown. Files of plans do not keep it.
    pub color: Option<Color>,
}

impl PartialEq for Step {
    fn eq(&self, other: &Self) -> bool {
        let Self {
            action,
            origin,
            feed,
            follows_speed,
            color: _,
        } = self;
        (action, origin, feed, follows_speed)
            == (
                &other.action,
                &other.origin,
                &other.feed,
                &other.follows_speed,
            )
    }
}

impl Step {
    /// A step of its own power, if it burns.
    #[must_use]
    pub fn new(action: impl Into<Action>, origin: Origin) -> Self {
        Self {
            action: action.into(),
            origin,
            feed: None,
            follows_speed: false,
            color: None,
        }
    }
}

/// A tool, and how it sits on the arm.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Tool {
    /// None: coordinates are the wrist's.
    None,
    /// The suction cup.
    Suction,
    /// The gripper.
    Gripper,
    /// The pen holder.
    Pen,
    /// The laser.
    Laser,
    /// Any other, by its bias from the wrist, mm.
    Bias([f32; 3]),
}

impl Tool {
    /// The tools that have a name.
    pub const NAMED: [(&'static str, Self); 5] = [
        ("none", Self::None),
        ("suction", Self::Suction),
        ("gripper", Self::Gripper),
        ("pen", Self::Pen),
        ("laser", Self::Laser),
    ];

    /// Its bias from the wrist.
    #[must_use]
    pub fn bias(self) -> ToolBias {
        match self {
            Self::None => ToolBias::NONE,
            Self::Suction => ToolBias::SUCTION,
            Self::Gripper => ToolBias::GRIPPER,
            Self::Pen => ToolBias::PEN,
            Self::Laser => ToolBias::LASER,
            Self::Bias([x, y, z]) => ToolBias::new(x.into(), y.into(), z.into()),
        }
    }
}

/// The tool whose bias is in force: that of a name, if it is one of these to the bit.
impl From<&EndEffectorParams> for Tool {
    fn from(bias: &EndEffectorParams) -> Self {
        let found = [bias.x_bias, bias.y_bias, bias.z_bias];
        let is = |tool: &Self| {
            let known = tool.bias();
            [known.x, known.y, known.z].map(|part| part as f32) == found
        };
        let known = Self::NAMED.into_iter().map(|(_, tool)| tool).find(is);
        known.unwrap_or(Self::Bias(found))
    }
}

/// By name, or a bias as `X,Y,Z`.
impl fmt::Display for Tool {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bias([x, y, z]) => write!(f, "{x},{y},{z}"),
            named => {
                let known = Self::NAMED.iter().find(|(_, tool)| tool == named);
                f.write_str(known.map_or("none", |(name, _)| name))
            }
        }
    }
}

/// Its name as a word, which other languages have too.
impl ToMessageValue for Tool {
    fn to_message_value(&self, decimals: Option<usize>) -> MessageValue {
        let known = Self::NAMED.iter().find(|(_, tool)| tool == self);
        match known {
            Some((name, _)) => Message::word(name).to_message_value(decimals),
            None => MessageValue::Text(self.to_string()),
        }
    }
}

impl FromStr for Tool {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let named = Self::NAMED.iter();
        let mut named = named.filter(|(name, _)| name.eq_ignore_ascii_case(text.trim()));
        if let Some((_, tool)) = named.next() {
            return Ok(*tool);
        }
        let numbers: Result<Vec<f32>, _> =
            text.split(',').map(|part| part.trim().parse()).collect();
        match numbers.as_deref() {
            Ok(&[x, y, z]) if [x, y, z].iter().all(|number| number.is_finite()) => {
                Ok(Self::Bias([x, y, z]))
            }
            _ => {
                let names = Self::NAMED.map(|(name, _)| name).join(", ");
                Err(format!("expected X,Y,Z in mm, or one of {names}"))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tools_are_known_by_their_bias() {
        let of = |x_bias, z_bias| {
            Tool::from(&EndEffectorParams {
                x_bias,
                y_bias: 0.0,
                z_bias,
            })
        };
        assert_eq!(of(0.0, 0.0), Tool::None);
        assert_eq!(of(61.0, 0.0), Tool::Pen);
        assert_eq!(of(61.0, 5.0), Tool::Bias([61.0, 0.0, 5.0]));
    }
}
