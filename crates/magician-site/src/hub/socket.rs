//! What the hub keeps of a client: its session, its lines to stations, what it subscribes to, and what waits to be sent.

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

/// Pauses before a line is opened again, ms: they grow to the last.
const PAUSES: [u64; 6] = [200, 400, 800, 1600, 3200, 5000];

/// How a client reaches a station.
#[derive(Debug)]
pub(super) enum Way {
    /// By this line.
    Line(LineId),
    /// Not at present.
    Waiting {
        until: HostInstant,
        tries: usize,
        why: RpcError,
    },
}

impl Way {
    /// After so many tries in vain.
    pub(super) fn after(now: HostInstant, tries: usize, why: RpcError) -> Self {
        let pause = PAUSES[tries.min(PAUSES.len() - 1)];
        Self::Waiting {
            until: now + Duration::from_millis(pause),
            tries: tries + 1,
            why,
        }
    }
}

/// A subscription of a client, which lasts while the line to its arm comes and goes.
#[derive(Debug)]
pub(super) struct Subscription {
    pub(super) arm: String,
    /// What was asked for, so that it can be asked for again.
    pub(super) params: Map<String, Value>,
    /// The line that it has, and its number there.
    pub(super) at: Option<(LineId, u64)>,
    /// Whether its client was told that nothing comes.
    pub(super) lost: bool,
    /// What has changed and was not sent yet.
    pub(super) change: Map<String, Value>,
    pub(super) frame: Option<StateFrame>,
    /// What is added to the numbers of frames: they go on when a line begins anew.
    pub(super) base: u32,
    pub(super) next: u32,
}

/// A connection of a client.
#[derive(Debug)]
pub(super) struct Socket {
    /// The token that it has at stations; until its hello that of its request.
    pub(super) token: Option<String>,
    /// When it was sent a list of sessions last.
    pub(super) listed: Option<HostInstant>,
    /// The sessions have changed since.
    pub(super) list_waits: bool,
    /// Its session, by the id of the hub.
    pub(super) session: Option<String>,
    pub(super) role: Role,
    /// It lasts for one request.
    pub(super) once: bool,
    /// It looks at all arms: lines to all stations are kept.
    pub(super) wide: bool,
    pub(super) ways: BTreeMap<StationId, Way>,
    pub(super) subscriptions: BTreeMap<u16, Subscription>,
    pub(super) last_subscription: u16,
    /// Jogs under way, by the id of the hub: the arm, and its station.
    pub(super) jogs: BTreeMap<String, (String, StationId)>,
    pub(super) under_way: usize,
    pub(super) outbox: Outbox,
    pub(super) throttle: Throttle,
}

impl Socket {
    pub(super) fn new(token: Option<String>, role: Role, once: bool) -> Self {
        Self {
            token,
            session: None,
            listed: None,
            list_waits: false,
            role,
            once,
            wide: false,
            ways: BTreeMap::new(),
            subscriptions: BTreeMap::new(),
            last_subscription: 0,
            jogs: BTreeMap::new(),
            under_way: 0,
            outbox: Outbox::default(),
            throttle: Throttle::default(),
        }
    }

    /// True if its requests go to stations as single ones. A viewer's do not: the token that goes along may allow more than a
    /// viewer may, and a session alone can be told to take less.
    pub(super) fn calls(&self) -> bool {
        self.once && self.role > Role::Viewer
    }

    /// A number for a subscription; none where all are taken.
    pub(super) fn free_subscription(&mut self) -> Option<u16> {
        let taken = &self.subscriptions;
        let behind = self.last_subscription.saturating_add(1)..=u16::MAX;
        let free = behind
            .chain(1..=self.last_subscription)
            .find(|id| !taken.contains_key(id))?;
        self.last_subscription = free;
        Some(free)
    }

    /// The subscription of a line by its number there.
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

/// A line to a station for one client.
#[derive(Debug)]
pub(super) struct Line {
    pub(super) socket: SocketId,
    pub(super) station: StationId,
    pub(super) slot: u32,
    pub(super) opened: HostInstant,
    /// The hello of its client, until it goes.
    pub(super) hello: Option<(RequestId, String)>,
    /// Its hello was answered.
    pub(super) up: bool,
    /// What waits to go: all of it for the answer to hello.
    pub(super) queue: VecDeque<(Option<RequestId>, String)>,
    /// A sign of life of the client waits to be sent.
    pub(super) alive: bool,
    /// When the station was asked for a word that it has not said yet.
    pub(super) probed: Option<HostInstant>,
    pub(super) throttle: Throttle,
    pub(super) tries: usize,
    /// The sessions that it told of last.
    pub(super) sessions: Value,
    pub(super) recording: bool,
}

/// How a request was sent on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Via {
    Home,
    Line(LineId),
    /// By itself, beside all lines.
    Call(StationId),
}

/// What a request is for.
#[derive(Debug)]
pub(super) enum Wants {
    /// Its answer goes to the client.
    Answer,
    /// The client's hello: what it is called, and its token.
    Hello(String, Option<String>),
    /// The hello of a line.
    LineHello,
    /// A word of the station.
    Probe,
    /// The turns of a station.
    Turns,
    /// A part of what several answer.
    Part(GatherId),
    /// A subscription of the client.
    Subscribe(Map<String, Value>),
    /// A subscription that is there has to be made at the station anew.
    Resubscribe(u16),
    /// One that is over.
    Nothing,
    /// The program of this request, which goes on with it.
    Program(Call),
    /// The sessions of home, before those of the stations are asked for.
    Sessions(Call),
}

impl Wants {
    /// True if a client waits for it by itself.
    pub(super) fn is_clients(&self) -> bool {
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

/// A request that was sent on.
#[derive(Debug)]
pub(super) struct Pending {
    pub(super) socket: SocketId,
    pub(super) id: Option<MessageId>,
    pub(super) method: &'static Method,
    pub(super) arm: Option<String>,
    pub(super) via: Via,
    pub(super) sent: bool,
    pub(super) wants: Wants,
}
