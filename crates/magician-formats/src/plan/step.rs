//! Steps of a plan, and the tools that plans name.

use magician_host::{Message, MessageValue, ToMessageValue};
use std::fmt;
use std::str::FromStr;

use magician_motion::ToolBias;
use magician_protocol::commands::EndEffectorParams;

use super::{Action, Color};
use crate::Origin;

/// A step of a plan. Equality ignores the colour: steps that do the same are equal.
#[derive(Clone, Debug)]
pub struct Step {
    /// Action.
    pub action: Action,
    /// Place in the source file.
    pub origin: Origin,
    /// Speed at which a burn has its nominal power, mm/s, if its power shall be in proportion to
    /// speed (M4). [`Plan::powered_by_speed`](super::Plan::powered_by_speed) computes the power and
    /// clears it.
    pub feed: Option<f32>,
    /// True if the power was computed in proportion to speed. At a lower speed a lower power then
    /// burns just as deep.
    pub follows_speed: bool,
    /// Colour of the line in the drawing, for previews; `None` if unknown. Plan files do not store
    /// it.
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
    /// Creates a step with constant power.
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

/// A tool and its position on the arm.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Tool {
    /// No tool: coordinates refer to the wrist.
    None,
    /// The suction cup.
    Suction,
    /// The gripper.
    Gripper,
    /// The pen holder.
    Pen,
    /// The laser.
    Laser,
    /// Any other tool, by its bias from the wrist, mm.
    Bias([f32; 3]),
}

impl Tool {
    /// The tools with a name.
    pub const NAMED_TOOLS: [(&'static str, Self); 5] = [
        ("none", Self::None),
        ("suction", Self::Suction),
        ("gripper", Self::Gripper),
        ("pen", Self::Pen),
        ("laser", Self::Laser),
    ];

    /// Bias from the wrist.
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

/// Returns the tool whose bias equals the given one bit for bit, else the bias.
impl From<&EndEffectorParams> for Tool {
    fn from(bias: &EndEffectorParams) -> Self {
        let found = [bias.x_bias, bias.y_bias, bias.z_bias];
        let is = |tool: &Self| {
            let known = tool.bias();
            [known.x, known.y, known.z].map(|part| part as f32) == found
        };
        let known = Self::NAMED_TOOLS.into_iter().map(|(_, tool)| tool).find(is);
        known.unwrap_or(Self::Bias(found))
    }
}

/// Prints the name, or a bias as `X,Y,Z`.
impl fmt::Display for Tool {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bias([x, y, z]) => write!(f, "{x},{y},{z}"),
            named => {
                let known = Self::NAMED_TOOLS.iter().find(|(_, tool)| tool == named);
                f.write_str(known.map_or("none", |(name, _)| name))
            }
        }
    }
}

/// Translates a named tool as a word.
impl ToMessageValue for Tool {
    fn to_message_value(&self, decimals: Option<usize>) -> MessageValue {
        let known = Self::NAMED_TOOLS.iter().find(|(_, tool)| tool == self);
        match known {
            Some((name, _)) => Message::word(name).to_message_value(decimals),
            None => MessageValue::Text(self.to_string()),
        }
    }
}

impl FromStr for Tool {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let named = Self::NAMED_TOOLS.iter();
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
                let names = Self::NAMED_TOOLS.map(|(name, _)| name).join(", ");
                Err(format!("expected X,Y,Z in mm, or one of {names}"))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tools_are_identified_by_their_bias() {
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
