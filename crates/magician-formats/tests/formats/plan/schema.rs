//! The schema of plan files against the files that are written, by a small validator that rejects
//! any keyword it does not know.

use std::collections::BTreeSet;

use magician::build;
use magician::preflight::Preflight;
use magician::{JointAngles, ToolBias};
use magician_formats::{
    Action, Color, Grip, Origin, PLAN_SCHEMA, Part, Pause, PauseCause, Plan, Tool, Travel,
};
use proptest::prelude::*;
use serde_json::Value;

use super::strategies::{cases, plan};

struct Schema {
    root: Value,
}

impl Schema {
    fn new() -> Self {
        let root = serde_json::from_str(PLAN_SCHEMA).expect("it is JSON");
        Self { root }
    }

    fn steps(&self) -> &[Value] {
        let steps = self
            .root
            .pointer("/$defs/step/oneOf")
            .and_then(Value::as_array);
        steps.expect("the kinds of steps")
    }

    fn accepts(&self, value: &Value) -> Result<(), String> {
        self.check(&self.root, value)
    }

    fn check(&self, schema: &Value, value: &Value) -> Result<(), String> {
        for (keyword, operand) in schema.as_object().expect("a schema is an object") {
            self.keyword(schema, keyword, operand, value)
                .map_err(|why| {
                    if why.contains(" in ") {
                        why
                    } else {
                        format!("{why} in {value}")
                    }
                })?;
        }
        Ok(())
    }

    fn keyword(
        &self,
        schema: &Value,
        keyword: &str,
        operand: &Value,
        value: &Value,
    ) -> Result<(), String> {
        let holds = match keyword {
            "$schema" | "$defs" | "title" | "description" => true,
            "$ref" => {
                let pointer = operand.as_str().and_then(|name| name.strip_prefix('#'));
                let target = pointer.and_then(|pointer| self.root.pointer(pointer));
                return self.check(target.expect("it refers to something"), value);
            }
            "type" => match operand.as_str() {
                Some("object") => value.is_object(),
                Some("array") => value.is_array(),
                Some("string") => value.is_string(),
                Some("boolean") => value.is_boolean(),
                Some("number") => value.is_number(),
                Some("integer") => value.is_u64() || value.is_i64(),
                Some("null") => value.is_null(),
                other => panic!("a type {other:?}"),
            },
            "const" => value == operand,
            "enum" => operand.as_array().unwrap().contains(value),
            "oneOf" => {
                let fitting = operand
                    .as_array()
                    .unwrap()
                    .iter()
                    .filter(|one| self.check(one, value).is_ok());
                fitting.count() == 1
            }
            "minimum" => value
                .as_f64()
                .is_none_or(|number| number >= operand.as_f64().unwrap()),
            "maximum" => value
                .as_f64()
                .is_none_or(|number| number <= operand.as_f64().unwrap()),
            "exclusiveMinimum" => value
                .as_f64()
                .is_none_or(|number| number > operand.as_f64().unwrap()),
            "if" => {
                return match self.check(operand, value) {
                    Ok(()) => self.check(&schema["then"], value),
                    Err(_) => Ok(()),
                };
            }
            "then" => true,
            "allOf" => {
                let all = operand.as_array().unwrap();
                return all.iter().try_for_each(|one| self.check(one, value));
            }
            "maxLength" => value
                .as_str()
                .is_none_or(|text| text.chars().count() as u64 <= operand.as_u64().unwrap()),
            "minItems" => value
                .as_array()
                .is_none_or(|items| items.len() as u64 >= operand.as_u64().unwrap()),
            "maxItems" => value
                .as_array()
                .is_none_or(|items| items.len() as u64 <= operand.as_u64().unwrap()),
            "items" => {
                let mut items = value.as_array().into_iter().flatten();
                return items.try_for_each(|item| self.check(operand, item));
            }
            "required" => {
                let mut keys = operand
                    .as_array()
                    .unwrap()
                    .iter()
                    .map(|key| key.as_str().unwrap());
                value
                    .as_object()
                    .is_none_or(|object| keys.all(|key| object.contains_key(key)))
            }
            "properties" => {
                let members = value.as_object().into_iter().flatten();
                return members
                    .filter_map(|(key, value)| Some(self.check(operand.get(key)?, value)))
                    .collect();
            }
            "additionalProperties" => {
                let known = schema.get("properties");
                let members = value.as_object().into_iter().flatten();
                let mut others = members
                    .filter(|(key, _)| known.and_then(|known| known.get(key.as_str())).is_none());
                match operand {
                    Value::Bool(false) => others.next().is_none(),
                    operand => {
                        return others.try_for_each(|(_, value)| self.check(operand, value));
                    }
                }
            }
            other => panic!("the validator does not know `{other}`"),
        };
        if holds {
            Ok(())
        } else {
            Err(format!("`{keyword}`: {operand} does not hold"))
        }
    }
}

proptest! {
    #![proptest_config(cases(200))]

    /// The schema refuses a written plan only if the preflight check does too, because of a value
    /// out of range.
    #[test]
    fn written_plans_match_the_schema(plan in plan()) {
        let schema = Schema::new();
        let written: Value = serde_json::from_str(&plan.to_json()).unwrap();
        if let Err(why) = schema.accepts(&written) {
            let mut arm = Preflight::at(JointAngles::HOME, ToolBias::NONE);
            let passes = plan.commands().all(|command| arm.check(&command).is_ok());
            prop_assert!(!passes, "{}", why);
        }
    }
}

/// Returns one action of every kind. The match below does not compile for a new kind until the list
/// has it.
fn one_of_each() -> Vec<Action> {
    let all = vec![
        Action::Move {
            to: [1.0; 4],
            by: Travel::Jump,
        },
        Action::Joints {
            to: [1.0; 4],
            by: Travel::Line,
        },
        Action::Shift {
            by: [1.0; 4],
            line: true,
        },
        Action::Arc {
            via: [1.0; 4],
            to: [2.0; 4],
        },
        Action::Path { to: [1.0; 3] },
        Action::Burn {
            to: [1.0; 3],
            power: 10.0,
        },
        Action::Suction(true),
        Action::Gripper(Grip::Close),
        Action::Laser(false),
        Action::Wait(20),
        Action::Home,
        Action::Command(Box::new(build::output(3, true))),
        Action::Part(Box::new(Part {
            n: 1,
            name: Some("outline".to_owned()),
            color: Some(Color([255, 0, 0])),
            pass: Some(2),
        })),
        Action::Pause(Box::new(Pause {
            text: "mount the red pen".to_owned(),
            cause: PauseCause::Part,
        })),
    ];
    for action in &all {
        match action {
            Action::Move { .. }
            | Action::Joints { .. }
            | Action::Shift { .. }
            | Action::Arc { .. } => {}
            Action::Path { .. } | Action::Burn { .. } | Action::Suction(_) | Action::Gripper(_) => {
            }
            Action::Laser(_) | Action::Wait(_) | Action::Home | Action::Command(_) => {}
            Action::Part(_) | Action::Pause(_) => {}
        }
    }
    all
}

#[test]
fn every_kind_of_step_matches_one_schema_branch() {
    let schema = Schema::new();
    let mut kinds = BTreeSet::new();
    for action in one_of_each() {
        let mut plan = Plan::new("one");
        plan.push(action, Origin::NONE);
        let written: Value = serde_json::from_str(&plan.to_json()).unwrap();
        schema.accepts(&written).unwrap();
        let step = &written["steps"][0];
        let fitting = schema.steps().iter().enumerate();
        kinds.extend(
            fitting
                .filter(|(_, kind)| schema.check(kind, step).is_ok())
                .map(|(at, _)| at),
        );
    }
    assert_eq!(
        kinds.len(),
        schema.steps().len(),
        "each kind of the schema is written"
    );
}

#[test]
fn schema_refuses_everything_the_reader_refuses() {
    let schema = Schema::new();
    for text in [
        r#"{"format":"magician-plan","version":3,"steps":[]}"#,
        r#"{"format":"magician-plan","version":1,"steps":[{}]}"#,
        r#"{"format":"magician-plan","version":2,"steps":[{"part":{"n":0}}]}"#,
        r#"{"format":"magician-plan","version":2,"steps":[{"pause":"wait"}]}"#,
        r#"{"format":"magician-plan","version":2,"steps":[{"pause":"wait","reason":"lunch"}]}"#,
        r#"{"format":"magician-plan","version":1,"steps":[{"move":[1,2,3]}]}"#,
        r#"{"format":"magician-plan","version":1,"steps":[{"home":true,"wait":1}]}"#,
        r#"{"format":"magician-plan","version":1,"steps":[{"shift":[1,2,3,4],"by":"jump"}]}"#,
        r#"{"format":"magician-plan","version":1,"steps":[],"extra":1}"#,
        r#"{"format":"magician-plan","version":1,"tool":"spoon","steps":[]}"#,
        r#"{"format":"magician-plan","version":1}"#,
    ] {
        assert!(Plan::from_json(text.as_bytes()).is_err(), "{text}");
        assert!(
            schema
                .accepts(&serde_json::from_str(text).unwrap())
                .is_err(),
            "{text}"
        );
    }
    let tools = Tool::NAMED_TOOLS.map(|(name, _)| Value::from(name));
    assert_eq!(
        schema.root.pointer("/properties/tool/oneOf/1/enum"),
        Some(&Value::from(tools.to_vec()))
    );
}
