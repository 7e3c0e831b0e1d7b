//! Parameters of calls, converted to fields of commands.
//!
//! Programs send values of another type (1 for true), use older names, and leave parameters out.
//! Known variants are accepted; older names are counted as unknown parameters. Anything that would
//! change a motion silently, such as a missing coordinate, is an error.

use magician_protocol::FieldType;
use serde_json::{Map, Value, json};

use crate::error::LinkError;
use crate::link::WriteAnswer;
use crate::methods::{AnswerTime, Method, Param, ParamType};

/// Parameters that every call may have.
const COMMON_PARAMS: [&str; 5] = [
    "portName",
    "isQueued",
    "isWaitForFinish",
    "timeout",
    "slaveIndex",
];

/// Checked parameters of a call under their names in the table, and names that the call does not
/// have.
pub(crate) struct CheckedParams {
    values: Vec<(&'static Param, Value)>,
    /// Names that the call does not have, or has under another name.
    pub(crate) unknown_params: Vec<String>,
}

impl CheckedParams {
    /// Checks the parameters of a call.
    ///
    /// # Errors
    /// A parameter is missing or has the wrong type.
    pub(crate) fn check(
        method: &'static Method,
        params: &Map<String, Value>,
    ) -> Result<Self, LinkError> {
        let mut values = Vec::with_capacity(method.params.len());
        let mut unknown_params = Vec::new();
        for param in &method.params {
            let names = std::iter::once(&param.name).chain(&param.aliases);
            let found = { names }.find_map(|name| Some((name, find(params, name)?)));
            let value = match found {
                Some((name, value)) => {
                    if *name != param.name {
                        unknown_params.push(name.clone());
                    }
                    normalise(param, value)?
                }
                // Only parameters that known programs leave out have a default.
                None => { param.default.clone() }
                    .ok_or_else(|| LinkError::params(format!("`{}` is missing", param.name)))?,
            };
            check_enum_value(method, param, &value)?;
            values.push((param, value));
        }
        let known = |name: &str| {
            let top = |path: &str| path.split('.').next() == Some(name);
            COMMON_PARAMS.contains(&name) || { method.params.iter() }
                .any(|param| top(&param.name) || param.aliases.iter().any(|alias| alias == name))
        };
        unknown_params.extend(params.keys().filter(|name| !known(name)).cloned());
        Ok(Self {
            values,
            unknown_params,
        })
    }

    /// Returns a parameter.
    pub(crate) fn get(&self, name: &str) -> Option<&Value> {
        let found = self.values.iter().find(|(param, _)| param.name == name);
        found.map(|(_, value)| value)
    }

    /// Returns a parameter as a number, or 0 if it is not one.
    pub(crate) fn number(&self, name: &str) -> f64 {
        self.get(name).and_then(Value::as_f64).unwrap_or_default()
    }

    /// Returns the fields of the command.
    pub(crate) fn fields(&self) -> Map<String, Value> {
        let real_time = self.get("isRealTimeTrack") == Some(&json!(true));
        let mut fields = Map::new();
        for (param, value) in &self.values {
            // `period` and `acc` are the same field; `isRealTimeTrack` says which of them applies.
            let other = match param.name.as_str() {
                "period" => !real_time,
                "acc" => real_time,
                _ => false,
            };
            if let Some(field) = param.field.as_ref().filter(|_| !other) {
                fields.insert(field.clone(), value.clone());
            }
        }
        fields
    }

    /// Returns the values with their encodings, in the order of the frame.
    pub(crate) fn in_frame_order(&self) -> impl Iterator<Item = (&'static Param, &Value)> {
        self.values.iter().map(|(param, value)| (*param, value))
    }
}

/// Checks that a number for an enumeration is one of its values. The controller would treat an
/// unknown mode as a move that has finished.
fn check_enum_value(method: &Method, param: &Param, value: &Value) -> Result<(), LinkError> {
    let layout = method.row().and_then(|row| row.set.or(row.query));
    let fields = layout.map_or(&[][..], |layout| layout.fields);
    let field = { fields.iter() }.find(|field| Some(field.name) == param.field.as_deref());
    let Some(field) = field.filter(|field| matches!(field.ty, FieldType::Enum(..))) else {
        return Ok(());
    };
    let bounds = field.range.bounds();
    let (least, most) = (bounds.minimum.unwrap_or(0), bounds.maximum.unwrap_or(255));
    match value.as_i64() {
        Some(number) if (i64::from(least)..=i64::from(most)).contains(&number) => Ok(()),
        _ => {
            let name = &param.name;
            Err(LinkError::params(format!(
                "`{name}` must be {least} to {most}"
            )))
        }
    }
}

/// Returns the value at a path.
fn find<'a>(params: &'a Map<String, Value>, path: &str) -> Option<&'a Value> {
    match path.split_once('.') {
        None => params.get(path),
        Some((object, member)) => params.get(object)?.get(member),
    }
}

/// Converts a value to the normal form of its type.
fn normalise(param: &Param, value: &Value) -> Result<Value, LinkError> {
    let wrong = || {
        let (name, description) = (&param.name, param.kind.description());
        Err(LinkError::params(format!("`{name}` must be {description}")))
    };
    match (param.kind, value) {
        (ParamType::Text, Value::String(_)) => Ok(value.clone()),
        (ParamType::Number, Value::Number(number)) => match number.as_f64() {
            // The arm stores single-precision numbers. A number beyond their range would become
            // infinity, which moves nothing.
            Some(number) if (number as f32).is_finite() => Ok(value.clone()),
            _ => wrong(),
        },
        (ParamType::Bool, Value::Bool(_)) => Ok(value.clone()),
        (ParamType::Bool, _) if value.as_f64() == Some(0.0) => Ok(json!(false)),
        (ParamType::Bool, _) if value.as_f64() == Some(1.0) => Ok(json!(true)),
        (ParamType::Integer, Value::Bool(on)) => Ok(json!(i64::from(*on))),
        (ParamType::Integer, Value::Number(number)) => match (number.as_i64(), number.as_f64()) {
            (Some(_), _) => Ok(value.clone()),
            // Some programs send whole numbers as `1.0`.
            (None, Some(number)) if number.fract() == 0.0 && number.abs() < 9e15 => {
                Ok(json!(number as i64))
            }
            _ => wrong(),
        },
        (ParamType::Numbers, Value::Array(items)) if items.iter().all(Value::is_number) => {
            Ok(value.clone())
        }
        (ParamType::Point, Value::Object(point)) => {
            let numbers = ["x", "y", "z", "r"].map(|name| point.get(name));
            if numbers
                .iter()
                .all(|number| number.is_some_and(Value::is_number))
            {
                Ok(json!(numbers))
            } else {
                wrong()
            }
        }
        (ParamType::Outputs, Value::Array(items)) => {
            let output = |item: &Value| {
                let [ratio, port, level] =
                    ["ratio", "port", "level"].map(|name| item.get(name).and_then(as_integer));
                Some(json!({"ratio": ratio?, "address": port?, "level": level?}))
            };
            let outputs: Option<Vec<_>> = items.iter().map(output).collect();
            match outputs {
                Some(outputs) => Ok(json!(outputs)),
                None => wrong(),
            }
        }
        _ => wrong(),
    }
}

fn as_integer(value: &Value) -> Option<i64> {
    match value {
        Value::Bool(on) => Some(i64::from(*on)),
        value => value.as_i64(),
    }
}

/// Way in which a call is to be carried out.
#[derive(Debug)]
pub(crate) struct CallOptions {
    /// True if the command goes to the queue.
    pub(crate) queued: bool,
    /// True if the call is answered when the command has finished.
    pub(crate) waits: bool,
    /// Time limit of the command from the moment that it is the next one in the queue, ms.
    pub(crate) timeout_ms: u64,
}

/// Default time for an action, ms.
const DEFAULT_TIMEOUT_MS: u64 = 5_000;
/// Default time for homing, ms.
const DEFAULT_HOMING_TIMEOUT_MS: u64 = 30_000;
/// Id of the homing command.
const HOMING_ID: u8 = 31;

impl CallOptions {
    /// Returns the station's method.
    pub(crate) fn method(&self) -> &'static str {
        if self.queued {
            "arm.enqueue"
        } else {
            "arm.set"
        }
    }

    /// Returns the way in which it is answered. An alarm ends a wait, except for homing.
    pub(crate) fn answer(&self, homing: bool) -> WriteAnswer {
        match (self.waits, self.queued) {
            (true, _) => WriteAnswer::Wait { homing },
            (false, true) => WriteAnswer::Index,
            (false, false) => WriteAnswer::True,
        }
    }

    /// Reads the options of a call: queue, wait and timeout.
    ///
    /// # Errors
    /// An invalid switch or time.
    pub(crate) fn of(method: &Method, params: &Map<String, Value>) -> Result<Self, LinkError> {
        let flag = |name: &str, default: bool| match params.get(name) {
            None | Some(Value::Null) => Ok(default),
            Some(Value::Bool(on)) => Ok(*on),
            // Some programs send switches as numbers.
            Some(value) if value.as_f64() == Some(0.0) => Ok(false),
            Some(value) if value.as_f64() == Some(1.0) => Ok(true),
            Some(_) => Err(LinkError::params(format!("`{name}` must be true or false"))),
        };
        let action = method.class == AnswerTime::Action;
        // A call that cannot be queued ignores `isQueued`, valid or not.
        let queued = method.class != AnswerTime::Plain && flag("isQueued", action)?;
        let default_timeout_ms = if method.id == HOMING_ID {
            DEFAULT_HOMING_TIMEOUT_MS
        } else {
            DEFAULT_TIMEOUT_MS
        };
        let timeout_ms = match params.get("timeout") {
            None | Some(Value::Null) => default_timeout_ms,
            Some(value) => match value.as_f64() {
                // Below 2^53, so the conversion is exact.
                Some(ms) if (0.0..9e15).contains(&ms) => ms as u64,
                _ => return Err(LinkError::params("`timeout` must be a time in ms")),
            },
        };
        Ok(Self {
            queued,
            waits: queued && action && flag("isWaitForFinish", true)?,
            timeout_ms,
        })
    }
}
