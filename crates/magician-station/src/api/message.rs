//! Messages of JSON-RPC 2.0, one object per message. Batches are not supported.

use serde_json::{Map, Value, json};

use super::RpcError;

/// Id of a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MessageId {
    /// A text.
    Text(String),
    /// A whole number. Fractions are not allowed, because the answer has to repeat the id exactly.
    Number(i64),
}

impl MessageId {
    fn to_value(&self) -> Value {
        match self {
            Self::Text(text) => json!(text),
            Self::Number(number) => json!(number),
        }
    }
}

/// Request, or notification if it has no id.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// Id for the answer. `None` for a notification.
    pub id: Option<MessageId>,
    /// The method.
    pub method: String,
    /// Parameters.
    pub params: Map<String, Value>,
}

/// Text that cannot be parsed as a request.
#[derive(Clone, Debug, PartialEq)]
pub struct BadMessage {
    /// Id for the answer, if the text has a valid one.
    pub id: Option<MessageId>,
    /// Explanation of the fault.
    pub error: RpcError,
}

impl Message {
    /// Parses a message.
    ///
    /// # Errors
    /// [`BadMessage`] if the text is not JSON, not an object, or not a request.
    pub fn parse(text: &str) -> Result<Self, BadMessage> {
        let bad = |id, error| BadMessage { id, error };
        let value: Value = serde_json::from_str(text).map_err(|_| {
            bad(
                None,
                RpcError::new(RpcError::PARSE, "the message is no JSON"),
            )
        })?;
        let Value::Object(mut object) = value else {
            let why = "a message is one object: arrays of requests are not taken";
            return Err(bad(None, RpcError::request(why)));
        };
        let id = match object.remove("id") {
            None => None,
            Some(Value::String(text)) => Some(MessageId::Text(text)),
            // A fraction may change when it is printed, and the client would not find its request.
            Some(Value::Number(number)) if number.is_i64() => {
                number.as_i64().map(MessageId::Number)
            }
            Some(_) => {
                let why = "`id` must be a string or a whole number";
                return Err(bad(None, RpcError::request(why)));
            }
        };
        let refuse = |why: &str| Err(bad(id.clone(), RpcError::request(why)));
        if object.remove("jsonrpc") != Some(json!("2.0")) {
            return refuse("`jsonrpc` must be \"2.0\"");
        }
        let Some(Value::String(method)) = object.remove("method") else {
            return refuse("`method` must be a string");
        };
        let params = match object.remove("params") {
            None => Map::new(),
            Some(Value::Object(params)) => params,
            Some(_) => return refuse("`params` must be an object"),
        };
        match object.keys().next() {
            // Unknown members are refused: a misspelt `params` would otherwise call with defaults.
            Some(key) => refuse(&format!("a request has no `{key}`")),
            None => Ok(Self { id, method, params }),
        }
    }
}

/// Returns the answer to a request. Without an id, the answer to a message whose id cannot be read.
#[must_use]
pub fn answer(id: Option<&MessageId>, outcome: &Result<Value, RpcError>) -> String {
    let id = id.map_or(Value::Null, MessageId::to_value);
    match outcome {
        Ok(result) => json!({"jsonrpc": "2.0", "id": id, "result": result}),
        Err(error) => json!({"jsonrpc": "2.0", "id": id, "error": error.to_value()}),
    }
    .to_string()
}

/// Returns the answer to a message. `None` for a notification, except if it is not a valid request:
/// then its id is unknown, and the client has to be told.
#[must_use]
pub fn answer_due(id: Option<&MessageId>, outcome: &Result<Value, RpcError>) -> Option<String> {
    let is_no_request =
        |error: &RpcError| [RpcError::REQUEST, RpcError::PARSE].contains(&error.code);
    let due = id.is_some() || outcome.as_ref().is_err_and(is_no_request);
    due.then(|| answer(id, outcome))
}

/// Returns a notification of the station.
#[must_use]
pub fn notification(method: &str, params: &Value) -> String {
    json!({"jsonrpc": "2.0", "method": method, "params": params}).to_string()
}
