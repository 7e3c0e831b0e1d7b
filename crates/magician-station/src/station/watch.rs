//! Subscriptions: readings at the rate that each subscriber asks for.
//!
//! Each arm is read at the highest rate that any subscriber needs. A subscription gets a reading
//! when its own period is over. States are sent as differences, with a whole state from time to
//! time; if several are due before the client reads, only the newest is sent.

use std::sync::Arc;
use std::time::Duration;

use magician::{Pin, message};
use magician_protocol::HostInstant;
use serde_json::{Value, json};

use super::newest::Newest;
use super::socket::{MAX_SUBSCRIPTIONS, Subscription};
use super::state::state_notification;
use super::{Outgoing, SocketId, Station};
use crate::api::{Notice, Params, RpcError};
use crate::control::ArmId;
use crate::frame::FRAME_FIELDS;
use crate::order::ArmOrder;
use crate::reading::STATE_FIELDS;

/// A whole state is sent once per this number of states, so that a client that lost track recovers.
const WHOLE_STATE_PERIOD: u32 = 100;
/// EIO addresses of the arm.
const PIN_ADDRESSES: std::ops::RangeInclusive<u64> = 1..=20;

impl Station {
    pub(super) fn subscribe(
        &mut self,
        now: HostInstant,
        socket: SocketId,
        arm: ArmId,
        params: &Params,
    ) -> Result<Value, RpcError> {
        // 50/s is the highest rate at which an arm is read.
        let rate = params.integer("rate").unwrap_or(1).clamp(1, 50) as u32;
        let binary = params.text("frame") == Some("binary");
        let pins = pins(params.get("pins"))?;
        let Some(open) = self.sockets.get_mut(&socket) else {
            return Err(RpcError::internal("the socket is gone"));
        };
        if open.subscriptions.len() >= MAX_SUBSCRIPTIONS {
            let why = message!(
                "a socket has at most {most} subscriptions",
                most = MAX_SUBSCRIPTIONS
            );
            let error = RpcError::new(RpcError::TOO_MANY, why);
            return Err(error.with("limit", MAX_SUBSCRIPTIONS));
        }
        let id = open.next_subscription();
        open.subscriptions.push(Subscription {
            id,
            arm,
            period: Duration::from_secs(1) / rate,
            binary,
            pins,
            due: now,
            sent: Arc::default(),
            sequence: 0,
            lost: false,
        });
        self.update_read_rates();
        let fields: Vec<_> = if binary {
            FRAME_FIELDS.to_vec()
        } else {
            STATE_FIELDS.to_vec()
        };
        Ok(json!({"subscription": id, "rate": rate, "fields": fields}))
    }

    /// Sends the first state of new subscriptions after the answer: at once if a fresh reading
    /// exists, otherwise with the first reading.
    pub(super) fn first_states(&mut self, now: HostInstant, socket: SocketId) {
        let Some(open) = self.sockets.get(&socket) else {
            return;
        };
        let first = { open.subscriptions.iter() }.filter(|one| one.sequence == 0);
        let first: Vec<_> = first.map(|one| (one.arm, one.id)).collect();
        for (arm, id) in first {
            if self.is_fresh(now, arm) {
                self.mark_state_due(socket, id);
            }
        }
    }

    pub(super) fn unsubscribe(&mut self, socket: SocketId, id: u16) -> Result<Value, RpcError> {
        let Some(open) = self.sockets.get_mut(&socket) else {
            return Err(RpcError::internal("the socket is gone"));
        };
        let before = open.subscriptions.len();
        open.subscriptions
            .retain(|subscription| subscription.id != id);
        if open.subscriptions.len() == before {
            let why = message!("there is no subscription {id}", id);
            return Err(RpcError::param("subscription", why));
        }
        self.update_read_rates();
        Ok(Value::Null)
    }

    /// Orders the rate of reading of each arm from its subscribers, recordings and history.
    pub(super) fn update_read_rates(&mut self) {
        for arm in self.arm_ids() {
            let all = self
                .sockets
                .values()
                .flat_map(|socket| &socket.subscriptions);
            let kept = self.ring_rate(arm);
            let recorded = self.arm(arm).recordings.rate();
            let (mut rate, mut pins) = (kept.max(recorded), Vec::new());
            for subscription in all.filter(|subscription| subscription.arm == arm) {
                let wanted = (1.0 / subscription.period.as_secs_f64()).round() as u32;
                rate = rate.max(Some(wanted));
                for pin in &subscription.pins {
                    if !pins.contains(pin) {
                        pins.push(*pin);
                    }
                }
            }
            let wanted = (rate, pins);
            // An order only if something changes: each one restarts the watch.
            if self.arm(arm).watched != wanted {
                self.arm_mut(arm).watched = wanted.clone();
                let (rate, pins) = wanted;
                self.order(arm, ArmOrder::Watch { rate, pins });
            }
        }
    }

    /// Handles a reading: subscriptions whose next state is due get it.
    pub(super) fn distribute_reading(&mut self, now: HostInstant, arm: ArmId) {
        let mut due = Vec::new();
        for (socket, open) in &mut self.sockets {
            for subscription in { open.subscriptions.iter_mut() }.filter(|one| one.arm == arm) {
                // Slightly early counts as due: waiting for the next reading would cost a whole
                // period.
                let early = subscription.period / 10;
                if now + early < subscription.due {
                    continue;
                }
                // Due times lie on a grid, so that the rate is kept on average. After a gap the
                // grid starts anew.
                let next = subscription.due + subscription.period;
                subscription.due = if next <= now {
                    now + subscription.period
                } else {
                    next
                };
                due.push((*socket, subscription.id));
            }
        }
        for (socket, id) in due {
            self.mark_state_due(socket, id);
        }
    }

    /// Notifies the subscribers of an arm once that its line broke.
    pub(super) fn notify_line_loss(&mut self, now: HostInstant, arm: ArmId) {
        let t = self.unix(now);
        let mut notified = Vec::new();
        for (socket, open) in &mut self.sockets {
            for subscription in { open.subscriptions.iter_mut() }.filter(|one| one.arm == arm) {
                if !std::mem::replace(&mut subscription.lost, true) {
                    notified.push((*socket, subscription.id));
                }
                // Marked as down, so that the next state reports the line as up again.
                if subscription.sent.contains_key("link") {
                    let sent = Arc::make_mut(&mut subscription.sent);
                    sent.insert("link".to_owned(), json!("lost"));
                }
            }
        }
        for (socket, id) in &notified {
            if let Some(open) = self.sockets.get_mut(socket) {
                // A waiting state would be made from later data but sent before this notification.
                open.outbox.drop_state(Newest::State(*id));
            }
        }
        for (socket, id) in notified {
            let state = json!({"subscription": id, "state": {"link": "lost", "t": t}});
            self.notify_socket(socket, Notice::ArmState.message(&state));
        }
    }

    /// Sends the state after a change outside the reading, without waiting for the period.
    pub(super) fn mark_state_changed(&mut self, arm: ArmId) {
        let all = self.sockets.iter().flat_map(|(socket, open)| {
            let of_arm = open.subscriptions.iter().filter(|one| one.arm == arm);
            of_arm.map(|one| (*socket, one.id))
        });
        let all: Vec<_> = all.collect();
        if self.arm(arm).reading.is_some() && self.arm(arm).link {
            for (socket, id) in all {
                self.mark_state_due(socket, id);
            }
        }
    }

    fn mark_state_due(&mut self, socket: SocketId, id: u16) {
        let Some(open) = self.sockets.get_mut(&socket) else {
            return;
        };
        if let Some(subscription) = { open.subscriptions.iter_mut() }.find(|one| one.id == id) {
            let reading = self.arms[subscription.arm.0 as usize].reading.as_ref();
            let knows_pins = reading.is_some_and(|reading| reading.has(&subscription.pins));
            // The first state is whole, so it waits for a reading that includes its pins.
            if subscription.sequence == 0 && !knows_pins {
                // Due with the next reading, whenever that comes.
                subscription.due = HostInstant::ZERO;
                return;
            }
            // Counted even if never sent: a gap in the numbers shows that states were replaced.
            subscription.sequence = subscription.sequence.wrapping_add(1);
            subscription.lost = false;
        }
        if open.outbox.state_due(Newest::State(id)) {
            self.awake.insert(socket);
        }
    }

    /// Makes the state for a subscription from the newest reading.
    pub(super) fn state_for(&mut self, socket: SocketId, id: u16) -> Option<Outgoing> {
        let open = self.sockets.get(&socket)?;
        let subscription = open.subscriptions.iter().find(|one| one.id == id)?;
        let (arm, binary) = (subscription.arm, subscription.binary);
        let sent = Arc::clone(&subscription.sent);
        // The sequence was increased when the state became due.
        let number = subscription.sequence.wrapping_sub(1);
        let shared = self.shared_state(arm)?;
        let fields = Arc::clone(shared.fields());
        // A binary subscription also gets the fields that its frame lacks, when they change.
        let text = match (sent.is_empty(), binary) {
            (true, _) => Some(shared.whole()),
            (_, false) if number.is_multiple_of(WHOLE_STATE_PERIOD) => Some(shared.whole()),
            (_, binary) => shared.change(&sent, binary),
        };
        let frame = if binary {
            let reading = self.arm(arm).reading.as_ref()?;
            Some(reading.frame(&self.state_context(arm), id, number))
        } else {
            None
        };
        let open = self.sockets.get_mut(&socket)?;
        let subscription = open.subscriptions.iter_mut().find(|one| one.id == id)?;
        let text = text.map(|state| state_notification(id, &state));
        if text.is_some() {
            subscription.sent = fields;
        }
        match (frame, text) {
            (Some(frame), text) => {
                if let Some(text) = text {
                    open.outbox.notice_next(text);
                }
                Some(Outgoing::Frame(frame))
            }
            (None, text) => text.map(Outgoing::Text),
        }
    }

    /// True if the arm was read within the last 100 ms.
    pub(super) fn is_fresh(&self, now: HostInstant, arm: ArmId) -> bool {
        let place = self.arm(arm);
        let age = now - place.read_at;
        place.reading.is_some() && place.link && age <= Duration::from_millis(100)
    }
}

/// Parses the pins of a subscription.
fn pins(given: Option<&Value>) -> Result<Vec<Pin>, RpcError> {
    let wrong = || {
        let why = message!("a pin is `kind` (input, output, analog) and `address` (1 to 20)");
        RpcError::param("pins", why)
    };
    let items = given.and_then(Value::as_array).cloned().unwrap_or_default();
    let pin = |item: &Value| {
        let address = item
            .get("address")?
            .as_u64()
            .filter(|at| PIN_ADDRESSES.contains(at))? as u8;
        let known = item.as_object()?.len() == 2;
        match item.get("kind")?.as_str()? {
            // A further member would be a misspelt one.
            _ if !known => None,
            "input" => Some(Pin::Input(address)),
            "output" => Some(Pin::Output(address)),
            "analog" => Some(Pin::Analog(address)),
            _ => None,
        }
    };
    items
        .iter()
        .map(|item| pin(item).ok_or_else(wrong))
        .collect()
}
