//! JSON-RPC messages of both sides as text.

use serde_json::{Map, Value, json};

use crate::error::{ErrorCode, LinkError};

/// Request of a program.
#[derive(Debug)]
pub(crate) struct Request {
    /// Id for the answer. Without one there is no answer.
    pub(crate) id: Option<Value>,
    /// Target as written: `Magician`, `api`.
    pub(crate) target: String,
    /// Name of the call.
    pub(crate) api: String,
    /// Parameters.
    pub(crate) params: Map<String, Value>,
}

/// Invalid request: the id to answer with, and the error.
pub(crate) type InvalidRequest = (Option<Value>, LinkError);

impl Request {
    /// Parses a message. `None` if it is not JSON, which is not answered.
    pub(crate) fn parse(text: &str) -> Option<Result<Self, InvalidRequest>> {
        let value: Value = serde_json::from_str(text).ok()?;
        Some(Self::of(value))
    }

    fn of(value: Value) -> Result<Self, InvalidRequest> {
        let Value::Object(mut object) = value else {
            let why = "a message is one object: arrays of requests are not taken";
            return Err((None, LinkError::new(ErrorCode::NO_METHOD, why)));
        };
        // Null counts as no id, so there is no answer.
        let id = object.remove("id").filter(|id| !id.is_null());
        let Some(Value::String(method)) = object.remove("method") else {
            let why = "`method` must be a text";
            return Err((id, LinkError::new(ErrorCode::NO_METHOD, why)));
        };
        // The name of the call may contain further points.
        let mut parts = method.splitn(3, '.');
        let (Some("dobotlink"), Some(target), Some(api)) =
            (parts.next(), parts.next(), parts.next())
        else {
            let why = "a method is `dobotlink.TARGET.API`";
            return Err((id, LinkError::new(ErrorCode::NO_METHOD, why)));
        };
        let params = match object.remove("params") {
            None | Some(Value::Null) => Map::new(),
            Some(Value::Object(params)) => params,
            Some(_) => return Err((id, LinkError::params("`params` must be an object"))),
        };
        Ok(Self {
            id,
            target: target.to_owned(),
            api: api.to_owned(),
            params,
        })
    }
}

/// Returns the answer to a request.
pub(crate) fn answer(id: &Value, outcome: &Result<Value, LinkError>) -> String {
    match outcome {
        Ok(result) => json!({"jsonrpc": "2.0", "id": id, "result": result}),
        Err(error) => json!({"jsonrpc": "2.0", "id": id, "error": error.to_value()}),
    }
    .to_string()
}

/// Returns a notification to a program.
pub(crate) fn notification(name: &str, params: &Value) -> String {
    let method = format!("dobotlink.notification.{name}");
    json!({"jsonrpc": "2.0", "method": method, "params": params}).to_string()
}

/// Returns a call of the station's API.
pub(crate) fn call(id: u64, method: &str, params: &Value) -> String {
    json!({"jsonrpc": "2.0", "id": id, "method": method, "params": params}).to_string()
}
