//! State of an arm as sent to subscribers. Each text is made once per reading, however many
//! subscribers get it.

use std::sync::Arc;

use serde_json::{Map, Value};

use super::Station;
use crate::control::ArmId;
use crate::reading::{StateContext, changes, fields_outside_frames};

/// State with the texts made from it so far.
#[derive(Debug)]
pub(super) struct SharedState {
    /// Part of the state that the reading lacks.
    context: StateContext,
    fields: Arc<Map<String, Value>>,
    whole: Option<Arc<str>>,
    /// Differences to earlier states. Each keeps its earlier state alive, so that no other state
    /// can take that address: states are compared by pointer.
    changes: Vec<Change>,
}

#[derive(Debug)]
struct Change {
    since: Arc<Map<String, Value>>,
    outside_frames: bool,
    text: Option<Arc<str>>,
}

impl SharedState {
    pub(super) fn new(context: StateContext, fields: Map<String, Value>) -> Self {
        Self {
            context,
            fields: Arc::new(fields),
            whole: None,
            changes: Vec::new(),
        }
    }

    pub(super) fn fields(&self) -> &Arc<Map<String, Value>> {
        &self.fields
    }

    /// Returns the whole state as text.
    pub(super) fn whole(&mut self) -> Arc<str> {
        let fields = &self.fields;
        Arc::clone(self.whole.get_or_insert_with(|| text(fields)))
    }

    /// Returns the difference to an earlier state as text. With `context`, without the fields of
    /// binary frames; `None` if no other field has changed.
    pub(super) fn change(
        &mut self,
        since: &Arc<Map<String, Value>>,
        context: bool,
    ) -> Option<Arc<str>> {
        let made = { self.changes.iter() }
            .find(|one| one.outside_frames == context && Arc::ptr_eq(&one.since, since));
        if let Some(made) = made {
            return made.text.clone();
        }
        let text = if context {
            let changed = changes(
                &fields_outside_frames(since),
                &fields_outside_frames(&self.fields),
            );
            // `t` is always included; alone it is not a change.
            (changed.len() > 1).then(|| text(&changed))
        } else {
            Some(text(&changes(since, &self.fields)))
        };
        self.changes.push(Change {
            since: Arc::clone(since),
            outside_frames: context,
            text: text.clone(),
        });
        text
    }
}

fn text(fields: &Map<String, Value>) -> Arc<str> {
    // Cannot fail for maps of text and numbers.
    serde_json::to_string(fields).unwrap_or_default().into()
}

/// Returns the notification of a state.
pub(super) fn state_notification(subscription: u16, state: &str) -> String {
    format!(
        r#"{{"jsonrpc":"2.0","method":"arm.state","params":{{"subscription":{subscription},"state":{state}}}}}"#
    )
}

impl Station {
    /// Returns the state from the last reading. `None` if there was none since the line was found.
    pub(super) fn shared_state(&mut self, arm: ArmId) -> Option<&mut SharedState> {
        let context = self.state_context(arm);
        let place = self.arm_mut(arm);
        let reading = place.reading.as_ref().filter(|_| place.link)?;
        let made = place.state.take().filter(|made| made.context == context);
        let made = made.unwrap_or_else(|| {
            let fields = reading.fields(&context);
            SharedState::new(context, fields)
        });
        Some(place.state.insert(made))
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn fields(x: f64, index: u64) -> Map<String, Value> {
        let fields = json!({"t": x, "x": x, "current_index": index, "alarms": [index]});
        match fields {
            Value::Object(fields) => fields,
            _ => Map::new(),
        }
    }

    #[test]
    fn state_texts_are_cached() {
        let mut before = SharedState::new(StateContext::default(), fields(1.0, 1));
        let mut now = SharedState::new(StateContext::default(), fields(2.0, 1));
        assert!(Arc::ptr_eq(&before.whole(), &before.whole()));
        let since = Arc::clone(before.fields());
        let change = now.change(&since, false).unwrap();
        assert_eq!(&*change, r#"{"t":2.0,"x":2.0}"#);
        assert!(Arc::ptr_eq(&change, &now.change(&since, false).unwrap()));
        // Equal fields in another state: compared by pointer, so not shared.
        let same = Arc::new(fields(1.0, 1));
        assert!(!Arc::ptr_eq(&change, &now.change(&same, false).unwrap()));
        assert_eq!(now.change(&since, true), None);
        let mut later = SharedState::new(StateContext::default(), fields(2.0, 2));
        let change = later.change(&since, true).unwrap();
        assert_eq!(&*change, r#"{"t":2.0,"alarms":[2]}"#);
        assert_eq!(
            state_notification(3, "{}"),
            r#"{"jsonrpc":"2.0","method":"arm.state","params":{"subscription":3,"state":{}}}"#
        );
    }
}
