//! State of a client: its session, lines to stations, subscriptions, pending requests and outbox.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use magician_protocol::HostInstant;
use magician_station::api::{MessageId, Method, Role, RpcError};
use magician_station::{Outbox, StateFrame, Throttle};
use serde_json::{Map, Value};

use super::gather::GatherId;
use super::requests::Call;
use super::{LineId, RequestId, SocketId};
use crate::site::StationId;

/// Backoff before a line is opened again, ms. The last value repeats.
const REOPEN_DELAYS_MS: [u64; 6] = [200, 400, 800, 1600, 3200, 5000];

/// Route of a client to a station.
#[derive(Debug)]
pub(super) enum Route {
    /// Over this line.
    Line(LineId),
    /// Lost. A new line may be opened from `until`.
    Waiting {
        until: HostInstant,
        tries: usize,
        why: RpcError,
    },
}

impl Route {
    /// Backoff after this number of failed attempts.
    pub(super) fn after(now: HostInstant, tries: usize, why: RpcError) -> Self {
        let pause = REOPEN_DELAYS_MS[tries.min(REOPEN_DELAYS_MS.len() - 1)];
        Self::Waiting {
            until: now + Duration::from_millis(pause),
            tries: tries + 1,
            why,
        }
    }
}

/// Subscription of a client. It survives the loss of its line.
#[derive(Debug)]
pub(super) struct Subscription {
    pub(super) arm: String,
    /// Original parameters, used to subscribe again.
    pub(super) params: Map<String, Value>,
    /// Line, and number of the subscription at the station. `None` while the line is lost.
    pub(super) at: Option<(LineId, u64)>,
    /// True if the client knows that the link is lost.
    pub(super) lost: bool,
    /// Merged changes that were not sent yet.
    pub(super) change: Map<String, Value>,
    pub(super) frame: Option<StateFrame>,
    /// Offset of sequence numbers: they continue when a new line restarts at 0.
    pub(super) base: u32,
    pub(super) next: u32,
}

/// Connection of a client.
#[derive(Debug)]
pub(super) struct Socket {
    /// Token used at stations. Before the hello this is the token of the HTTP request.
    pub(super) token: Option<String>,
    /// Time of the last list of sessions.
    pub(super) sessions_sent_at: Option<HostInstant>,
    /// True if the sessions have changed since.
    pub(super) sessions_changed: bool,
    /// Id of its session at the hub. `None` before the hello.
    pub(super) session: Option<String>,
    pub(super) role: Role,
    /// True for a socket that serves a single request.
    pub(super) is_single_request: bool,
    /// True if the client lists all arms: lines to all stations are kept open.
    pub(super) lists_all_arms: bool,
    pub(super) routes: BTreeMap<StationId, Route>,
    pub(super) subscriptions: BTreeMap<u16, Subscription>,
    pub(super) last_subscription: u16,
    /// Running jogs by the id at the hub, each with its arm and station.
    pub(super) jogs: BTreeMap<String, (String, StationId)>,
    pub(super) in_flight: usize,
    pub(super) outbox: Outbox,
    pub(super) throttle: Throttle,
}

impl Socket {
    pub(super) fn new(token: Option<String>, role: Role, is_single_request: bool) -> Self {
        Self {
            token,
            session: None,
            sessions_sent_at: None,
            sessions_changed: false,
            role,
            is_single_request,
            lists_all_arms: false,
            routes: BTreeMap::new(),
            subscriptions: BTreeMap::new(),
            last_subscription: 0,
            jogs: BTreeMap::new(),
            in_flight: 0,
            outbox: Outbox::default(),
            throttle: Throttle::default(),
        }
    }

    /// True if its requests go to stations as single requests.
    ///
    /// False for a viewer, even with one request: its token may allow more than a viewer may do,
    /// and only a session can ask for a lower role.
    pub(super) fn sends_single_requests(&self) -> bool {
        self.is_single_request && self.role > Role::Viewer
    }

    /// Returns an unused subscription number, or `None` if all are in use.
    pub(super) fn free_subscription(&mut self) -> Option<u16> {
        let taken = &self.subscriptions;
        let behind = self.last_subscription.saturating_add(1)..=u16::MAX;
        let free = behind
            .chain(1..=self.last_subscription)
            .find(|id| !taken.contains_key(id))?;
        self.last_subscription = free;
        Some(free)
    }

    /// Finds a subscription by its line and its number there.
    pub(super) fn subscription_at(
        &mut self,
        line: LineId,
        number: u64,
    ) -> Option<(u16, &mut Subscription)> {
        let mut all = self.subscriptions.iter_mut();
        let found = all.find(|(_, one)| one.at == Some((line, number)));
        found.map(|(id, one)| (*id, one))
    }
}

/// Line of one client to one station.
#[derive(Debug)]
pub(super) struct Line {
    pub(super) socket: SocketId,
    pub(super) station: StationId,
    pub(super) slot: u32,
    pub(super) opened: HostInstant,
    /// Hello of its client, until it is sent.
    pub(super) hello: Option<(RequestId, String)>,
    /// True once the hello was accepted.
    pub(super) up: bool,
    /// Messages to send. They wait until the hello is accepted.
    pub(super) queue: VecDeque<(Option<RequestId>, String)>,
    /// True if a keep-alive of the client is to be sent.
    pub(super) keep_alive_due: bool,
    /// Time of the unanswered probe, if there is one.
    pub(super) probed: Option<HostInstant>,
    pub(super) throttle: Throttle,
    pub(super) tries: usize,
    /// List of sessions from the station's last notification.
    pub(super) sessions: Value,
    pub(super) recording: bool,
}

/// Path by which a request was passed on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Via {
    Home,
    Line(LineId),
    /// Single request, outside of all lines.
    Call(StationId),
}

/// Purpose of a request that was passed on, which decides what its reply is used for.
#[derive(Debug)]
pub(super) enum Purpose {
    /// The client's own request: the reply goes to the client.
    Answer,
    /// The client's hello, with its name and token.
    Hello(String, Option<String>),
    /// The hello of a line.
    LineHello,
    /// A probe: any reply shows that the station is alive.
    Probe,
    /// Turns of a station.
    Turns,
    /// Part of a gather.
    Part(GatherId),
    /// A new subscription of the client.
    Subscribe(Map<String, Value>),
    /// An existing subscription, made again on a new line.
    Resubscribe(u16),
    /// The reply is ignored.
    Nothing,
    /// Fetches the program that this request needs. The request continues with the reply.
    Program(Call),
    /// Lists the sessions at home. With the reply, those at the stations are gathered.
    Sessions(Call),
}

impl Purpose {
    /// True if the request counts as in flight for its client.
    pub(super) fn is_client_request(&self) -> bool {
        matches!(
            self,
            Self::Answer
                | Self::Hello(..)
                | Self::Subscribe(_)
                | Self::Program(_)
                | Self::Sessions(_)
        )
    }
}

/// Request that was passed on and not answered yet.
#[derive(Debug)]
pub(super) struct Pending {
    pub(super) socket: SocketId,
    pub(super) id: Option<MessageId>,
    pub(super) method: &'static Method,
    pub(super) arm: Option<String>,
    pub(super) via: Via,
    pub(super) sent: bool,
    pub(super) purpose: Purpose,
}
