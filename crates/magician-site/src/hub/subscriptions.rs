//! Subscriptions of clients to states: only the newest state is kept while a client is busy, and a
//! subscription survives the loss of its line.

use magician_protocol::HostInstant;
use magician_station::api::{Notification, RpcError, notification};
use magician_station::{Outgoing, StateFrame};
use serde_json::{Map, Value, json};

use super::requests::Call;
use super::socket::{Pending, Purpose, Subscription};
use super::{Hub, LineId, SocketId};

impl Hub {
    /// A station has accepted a subscription: assigns it a number of the hub.
    pub(super) fn subscribed(
        &mut self,
        line: LineId,
        pending: &Pending,
        params: Map<String, Value>,
        mut outcome: Result<Value, RpcError>,
    ) {
        let Some(open) = self.sockets.get_mut(&pending.socket) else {
            return;
        };
        if let Ok(result) = &mut outcome {
            let there = result["subscription"].as_u64();
            match (there, open.free_subscription()) {
                (Some(there), Some(id)) => {
                    let made = Subscription {
                        arm: pending.arm.clone().unwrap_or_default(),
                        params,
                        at: Some((line, there)),
                        lost: false,
                        change: Map::new(),
                        frame: None,
                        base: 0,
                        next: 0,
                    };
                    open.subscriptions.insert(id, made);
                    result["subscription"] = json!(id);
                }
                // All numbers are in use, or the station sent none.
                _ => outcome = Err(RpcError::new(RpcError::TOO_MANY, "too many subscriptions")),
            }
        }
        self.finish(pending.socket, pending.id.as_ref(), &outcome);
    }

    /// Ends a subscription.
    pub(super) fn unsubscribe(&mut self, call: &Call) -> Result<Option<Value>, RpcError> {
        let id = call
            .params
            .get("subscription")
            .and_then(Value::as_u64)
            .unwrap_or(0);
        let open = self.sockets.get_mut(&call.socket);
        let gone = open.and_then(|open| {
            let id = u16::try_from(id).ok()?;
            open.outbox.drop_state(id);
            open.subscriptions.remove(&id)
        });
        let gone = gone.ok_or_else(|| {
            RpcError::param("subscription", format!("there is no subscription {id}"))
        })?;
        self.unsubscribe_at_station(gone.at);
        Ok(Some(Value::Null))
    }

    fn unsubscribe_at_station(&mut self, at: Option<(LineId, u64)>) {
        if let Some((line, there)) = at {
            let params = json!({"subscription": there});
            self.request_on_line(line, "arm.unsubscribe", params, Purpose::Nothing);
        }
    }

    /// A line is up: renews the subscriptions of its client at this station.
    pub(super) fn resubscribe(&mut self, line: LineId) {
        let Some(known) = self.lines.get(&line) else {
            return;
        };
        let open = self.sockets.get(&known.socket).into_iter();
        let lost = open.flat_map(|open| &open.subscriptions);
        let lost =
            lost.filter(|(_, one)| one.at.is_none() && self.is_sole_owner(known.station, &one.arm));
        let lost = lost.map(|(id, one)| (*id, one.params.clone()));
        for (id, params) in lost.collect::<Vec<_>>() {
            self.request_on_line(
                line,
                "arm.subscribe",
                params.into(),
                Purpose::Resubscribe(id),
            );
        }
    }

    /// A station has accepted a renewed subscription.
    pub(super) fn resubscribed(
        &mut self,
        line: LineId,
        socket: SocketId,
        id: u16,
        outcome: Result<Value, RpcError>,
    ) {
        let Ok(result) = outcome else {
            return;
        };
        let at = result["subscription"].as_u64().map(|there| (line, there));
        let open = self.sockets.get_mut(&socket);
        match open.and_then(|open| open.subscriptions.get_mut(&id)) {
            Some(one) if one.at.is_none() => {
                (one.at, one.base) = (at, one.next);
            }
            // The client unsubscribed in the meantime.
            _ => self.unsubscribe_at_station(at),
        }
    }

    /// A line is lost: its subscribers get a state with `link` set to `lost`, as if the line to the
    /// arm had broken.
    pub(super) fn lose_subscriptions(&mut self, now: HostInstant, socket: SocketId, line: LineId) {
        let t = self.unix(now);
        let Some(open) = self.sockets.get_mut(&socket) else {
            return;
        };
        for (id, one) in &mut open.subscriptions {
            if one.at.is_none_or(|(of, _)| of != line) {
                continue;
            }
            one.at = None;
            (one.change, one.frame) = (Map::new(), None);
            open.outbox.drop_state(*id);
            if !std::mem::replace(&mut one.lost, true) {
                let state = json!({"subscription": id, "state": {"link": "lost", "t": t}});
                open.outbox.notice(notification("arm.state", &state));
                self.awake.insert(socket);
            }
        }
    }

    /// Handles a state as text: merges its changes with the unsent ones.
    pub(super) fn receive_state(&mut self, line: LineId, mut params: Value) {
        let Some((slot, socket)) = self.lines.get(&line).map(|line| (line.slot, line.socket))
        else {
            return;
        };
        let ids = Notification::named("arm.state").map_or(&[][..], |known| known.ids);
        self.names.rename(slot, &mut params, ids);
        let there = params["subscription"].as_u64().unwrap_or(0);
        let Value::Object(change) = params["state"].take() else {
            return;
        };
        let Some(open) = self.sockets.get_mut(&socket) else {
            return;
        };
        let Some((id, one)) = open.subscription_at(line, there) else {
            return;
        };
        if let Some(link) = change.get("link") {
            one.lost = link == "lost";
        }
        // A station may report only the arm of the subscription.
        if change.get("arm").is_some_and(|arm| arm != one.arm.as_str()) {
            return;
        }
        one.change.extend(change);
        if open.outbox.state_due(id) {
            self.awake.insert(socket);
        }
    }

    /// Handles a binary state. The newest one replaces an unsent one.
    pub fn receive_frame(&mut self, line: LineId, bytes: &[u8]) {
        let Some(socket) = self.lines.get(&line).map(|line| line.socket) else {
            return;
        };
        let (Ok(mut frame), Some(open)) = (StateFrame::read(bytes), self.sockets.get_mut(&socket))
        else {
            return;
        };
        let Some((id, one)) = open.subscription_at(line, u64::from(frame.subscription)) else {
            return;
        };
        frame.subscription = id;
        frame.sequence = frame.sequence.wrapping_add(one.base);
        one.next = frame.sequence.wrapping_add(1);
        one.lost = false;
        one.frame = Some(frame);
        if open.outbox.state_due(id) {
            self.awake.insert(socket);
        }
    }

    /// Returns the unsent state of a subscription, or `None`.
    pub(super) fn state_for(&mut self, socket: SocketId, id: u16) -> Option<Outgoing> {
        let open = self.sockets.get_mut(&socket)?;
        let one = open.subscriptions.get_mut(&id)?;
        let (change, frame) = (std::mem::take(&mut one.change), one.frame.take());
        let text = (!change.is_empty()).then(|| {
            let state = json!({"subscription": id, "state": change});
            notification("arm.state", &state)
        });
        match (frame, text) {
            (Some(frame), text) => {
                if let Some(text) = text {
                    open.outbox.notice_next(text);
                }
                Some(Outgoing::Frame(frame.to_bytes()))
            }
            (None, text) => text.map(Outgoing::Text),
        }
    }
}
