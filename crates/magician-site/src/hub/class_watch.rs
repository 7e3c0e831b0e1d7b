//! Checks whether any station has a class. If so, users at the hub's machine need its PIN to act as
//! teachers.

use std::collections::BTreeMap;
use std::sync::Weak;
use std::time::Duration;

use serde_json::Value;
use tokio::time::sleep;

use super::driver::Shared;
use crate::site::Caller;

/// Interval between checks, and so the longest delay until a change of role takes effect.
const CLASS_CHECK_INTERVAL: Duration = Duration::from_secs(1);
/// Request for the check.
const CLASS_REQUEST: &str = r#"{"jsonrpc":"2.0","id":1,"method":"class.get","params":{}}"#;

impl Shared {
    pub(super) async fn watch_class(this: Weak<Self>) {
        loop {
            let Some(shared) = this.upgrade() else {
                return;
            };
            shared.check_class().await;
            drop(shared);
            sleep(CLASS_CHECK_INTERVAL).await;
        }
    }

    /// Asks the stations for their class until one has a class. The hub's own token of any role is
    /// enough. If some station did not reply and no other has a class, nothing changes.
    pub(super) async fn check_class(&self) {
        let token = self.lock().hub.token();
        if token.is_none() {
            // Without a token the users of the hub cannot move an arm, so their role does not
            // matter.
            return;
        }
        let caller = Caller { token };
        let stations: BTreeMap<_, _> = { self.site.arms().into_keys() }
            .map(|at| (at.station, at))
            .collect();
        let mut pin = None;
        let mut silent = false;
        for at in stations.values() {
            let asked = self.site.call(at, &caller, CLASS_REQUEST.to_owned()).await;
            let answer: Option<Value> =
                { asked.ok().flatten() }.and_then(|text| serde_json::from_str(&text).ok());
            let class = answer.as_ref().and_then(|answer| answer.get("result"));
            match class {
                Some(class) if !class["class"].is_null() => {
                    let known = class["pin"].as_str().unwrap_or_default();
                    pin = Some(known.to_owned());
                    break;
                }
                Some(_) => {}
                None => silent = true,
            }
        }
        if pin.is_some() || !silent {
            self.home.set_class_elsewhere(pin);
        }
    }
}
