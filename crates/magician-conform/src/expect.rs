//! Expected fields of a reply: `x=200+-0.01`, `left_space=32`, `joint_angle=0,45,_,0`.

use std::fmt;

use magician_protocol::{Field, FieldType, FieldValue, LayoutInfo, Scalar};

/// Comparison of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Relation {
    Is,
    IsNot,
    Above,
    AtLeast,
    Below,
    AtMost,
}

/// Longest first, so that `>=` is not taken for `>`.
const RELATIONS: [(&str, Relation); 6] = [
    ("!=", Relation::IsNot),
    (">=", Relation::AtLeast),
    ("<=", Relation::AtMost),
    ("=", Relation::Is),
    (">", Relation::Above),
    ("<", Relation::Below),
];

/// Value to compare with.
#[derive(Clone, Debug, PartialEq)]
enum Wanted {
    /// Numbers; `None` matches any.
    Numbers(Vec<Option<f64>>),
    /// Text form of the value.
    Text(String),
}

/// Expectation of one field of a reply.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Check {
    field: &'static Field,
    relation: Relation,
    wanted: Wanted,
    tolerance: f64,
    text: String,
}

impl fmt::Display for Check {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl Check {
    /// Parses `field=value`, `field=value+-tolerance`, `field!=value`, `field>value` and the like.
    pub(crate) fn read(layout: &LayoutInfo, word: &str) -> Result<Self, String> {
        let (name, relation, value) = split(word).ok_or_else(|| {
            format!("'{word}' is not an expectation: write field=value, or field>value")
        })?;
        let field = layout
            .field(name)
            .ok_or_else(|| format!("no field '{name}' in {}", layout.name))?;
        let (value, tolerance) = match value.split_once("+-") {
            Some((value, tolerance)) => (value, parse_tolerance(tolerance)?),
            None => (value, 0.0),
        };
        let wanted = parse_wanted(field, value, tolerance > 0.0)
            .ok_or_else(|| format!("'{value}' is not a value of {}", field.name))?;
        let ordered = !matches!(relation, Relation::Is | Relation::IsNot);
        if ordered && matches!(wanted, Wanted::Text(_)) {
            return Err(format!("{} has no order", field.name));
        }
        Ok(Self {
            field,
            relation,
            wanted,
            tolerance,
            text: word.to_owned(),
        })
    }

    /// True if the parameters of a reply satisfy the expectation.
    pub(crate) fn holds(&self, layout: &LayoutInfo, params: &[u8]) -> bool {
        let Ok(mut values) = layout.values(params) else {
            return false;
        };
        let found = values.find(|(field, _)| *field == self.field);
        match (found, &self.wanted) {
            (None, _) => false,
            (Some((_, value)), Wanted::Text(text)) => {
                (value.to_string() == *text) == (self.relation == Relation::Is)
            }
            (Some((_, value)), Wanted::Numbers(wanted)) => self.compare(&numbers(&value), wanted),
        }
    }

    fn compare(&self, found: &[f64], wanted: &[Option<f64>]) -> bool {
        let near = |found: f64, wanted: f64| {
            found == wanted
                || (found - wanted).abs() <= self.tolerance
                // NaN is a value like any other here: some cases set it on purpose.
                || found.is_nan() && wanted.is_nan()
        };
        let mut pairs = found
            .iter()
            .zip(wanted)
            .filter_map(|(found, wanted)| Some((*found, (*wanted)?)));
        found.len() == wanted.len()
            && match self.relation {
                Relation::Is => pairs.all(|(found, wanted)| near(found, wanted)),
                Relation::IsNot => pairs.any(|(found, wanted)| !near(found, wanted)),
                Relation::Above => pairs.all(|(found, wanted)| found > wanted),
                Relation::AtLeast => pairs.all(|(found, wanted)| found >= wanted),
                Relation::Below => pairs.all(|(found, wanted)| found < wanted),
                Relation::AtMost => pairs.all(|(found, wanted)| found <= wanted),
            }
    }
}

fn split(word: &str) -> Option<(&str, Relation, &str)> {
    let at = word.find(['=', '!', '<', '>'])?;
    let (name, rest) = word.split_at(at);
    let (operator, relation) = RELATIONS
        .into_iter()
        .find(|(operator, _)| rest.starts_with(operator))?;
    Some((name, relation, rest.strip_prefix(operator)?))
}

fn parse_tolerance(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok();
    number
        .filter(|number| number.is_finite() && *number > 0.0)
        .ok_or_else(|| format!("'{text}' is not a tolerance: write a number above 0"))
}

fn parse_wanted(field: &Field, text: &str, has_tolerance: bool) -> Option<Wanted> {
    let one = |text: &str| number(field.ty, text, has_tolerance);
    Some(match field.ty {
        FieldType::Text | FieldType::Bytes | FieldType::Alarms | FieldType::Outputs => {
            Wanted::Text(text.to_owned())
        }
        // By name or by number, because some cases send values without a name.
        FieldType::Enum(info) => match info.value_of(text) {
            Some(value) => Wanted::Numbers(vec![Some(value.into())]),
            None => Wanted::Numbers(vec![one(text)?]),
        },
        FieldType::Array(_, count) => {
            let items: Option<Vec<_>> = text.split(',').map(one).collect();
            Wanted::Numbers(items.filter(|items| items.len() == count)?)
        }
        _ => Wanted::Numbers(vec![one(text)?]),
    })
}

/// Parses a number, `Some(None)` for `_`. Without a tolerance it is rounded to what the wire can
/// represent.
fn number(ty: FieldType, text: &str, has_tolerance: bool) -> Option<Option<f64>> {
    let float = matches!(
        ty,
        FieldType::Scalar(Scalar::F32) | FieldType::Array(Scalar::F32, _)
    );
    match text {
        "_" => Some(None),
        // Rounded like the value on the wire, or 0.1 would never equal it.
        text if float && !has_tolerance => {
            text.parse::<f32>().ok().map(|number| Some(number.into()))
        }
        text => text.parse::<f64>().ok().map(Some),
    }
}

fn numbers(value: &FieldValue<'_>) -> Vec<f64> {
    match *value {
        FieldValue::Unsigned(number) => vec![number as f64],
        FieldValue::Signed(number) => vec![number.into()],
        FieldValue::Float(number) => vec![number.into()],
        FieldValue::Flag(byte) | FieldValue::Enum(_, byte) => vec![byte.into()],
        FieldValue::Array(..) => value.items().flat_map(|item| numbers(&item)).collect(),
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use magician_protocol::commands::{Pose, QueuedCmdLeftSpace};
    use magician_protocol::{Layout, MAX_PARAMS, Writer};

    use super::*;

    fn encoded<L: Layout>(layout: &L) -> Vec<u8> {
        let mut bytes = [0; MAX_PARAMS];
        let mut writer = Writer::new(&mut bytes);
        layout.encode(&mut writer);
        let count = writer.finish().unwrap();
        bytes[..count].to_vec()
    }

    fn holds<L: Layout>(layout: &L, word: &str) -> bool {
        let check = Check::read(L::INFO, word).unwrap();
        check.holds(L::INFO, &encoded(layout))
    }

    #[test]
    fn numbers_hold_within_their_tolerance_only() {
        let pose = Pose {
            x: 200.125,
            y: 0.1,
            z: -8.5,
            r: 0.0,
            joint_angle: [0.0, 45.0, 45.0, 0.0],
        };
        for word in [
            "x=200.125",
            "y=0.1",
            "x=200+-0.2",
            "x>200",
            "x>=200.125",
            "x<200.2",
            "x<=200.125",
            "x!=200",
            "joint_angle=0,45,_,0",
            "joint_angle=0.1,45,45.1,0+-0.11",
            "jointAngle!=0,45,45,1",
        ] {
            assert!(holds(&pose, word), "{word}");
        }
        for word in [
            "x=200",
            "y=0.10001",
            "x=200+-0.1",
            "x>200.125",
            "x!=200.125",
            "x<200.125",
            "joint_angle=0,45,_,1",
            "joint_angle=0,45,46,0+-0.9",
            "joint_angle!=0,45,45,0",
        ] {
            assert!(!holds(&pose, word), "{word}");
        }
        assert!(holds(
            &QueuedCmdLeftSpace { left_space: 32 },
            "left_space=32"
        ));
        assert!(!holds(
            &QueuedCmdLeftSpace { left_space: 31 },
            "left_space=32"
        ));
    }

    #[test]
    fn invalid_expectations_are_errors() {
        for (word, why) in [
            ("x", "not an expectation"),
            ("w=1", "no field"),
            ("x=one", "not a value"),
            ("x=1+-0", "not a tolerance"),
            ("joint_angle=0,45,45", "not a value"),
        ] {
            let message = Check::read(Pose::INFO, word).unwrap_err();
            assert!(message.contains(why), "{word}: {message}");
        }
    }
}
