//! A client of the hub: its session, its lines to stations, what it subscribes to, and what waits to be sent.

use std::collections::BTreeMap;
use std::time::Duration;

use magician_protocol::HostInstant;
use magician_station::api::{MessageId, Method, Role, RpcError};
use magician_station::{Outbox, StateFrame, Throttle};
use serde_json::{Map, Value};

use super::{LineId, RequestId};
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
        let pause = PAUSES.get(tries).or(PAUSES.last()).copied().unwrap_or(5000);
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
    /// The token that its request came with.
    pub(super) bearer: Option<String>,
    /// The token that it has at stations.
    pub(super) token: Option<String>,
    /// When it was sent a list of sessions last.
    pub(super) listed: Option<HostInstant>,
    /// The sessions have changed since.
    pub(super) list_waits: bool,
    /// Its session, by the id of the hub.
    pub(super) session: Option<String>,
    pub(super) role: Role,
    /// It lasts for one request, which stations get as such.
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
    pub(super) fn new(bearer: Option<String>, role: Role, once: bool) -> Self {
        Self {
            bearer,
            token: None,
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
    pub(super) socket: super::SocketId,
    pub(super) station: StationId,
    pub(super) slot: u32,
    pub(super) opened: HostInstant,
    /// Its hello was answered.
    pub(super) up: bool,
    pub(super) queue: std::collections::VecDeque<(Option<RequestId>, String)>,
    /// What waits for the answer to hello.
    pub(super) held: std::collections::VecDeque<(Option<RequestId>, String)>,
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
    /// The client's hello, and what it is called.
    Hello(String, Option<String>),
    /// The hello of a line.
    LineHello,
    /// A word of the station.
    Probe,
    /// A part of what several answer.
    Part(GatherId),
    /// A subscription of the client.
    Subscribe(Map<String, Value>),
    /// A subscription that is there has to be made at the station anew.
    Resubscribe(u16),
    /// One that is over.
    Nothing,
    /// The program of a job, which begins then with these parameters.
    Program(StationId, Map<String, Value>),
}

/// A request that was sent on.
#[derive(Debug)]
pub(super) struct Pending {
    pub(super) socket: super::SocketId,
    pub(super) id: Option<MessageId>,
    pub(super) method: &'static Method,
    pub(super) arm: Option<String>,
    pub(super) via: Via,
    pub(super) sent: bool,
    pub(super) wants: Wants,
}

/// Several requests with one answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct GatherId(pub(super) u64);

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Gathers {
    /// What pupils have made.
    Results,
    /// What was asked of some arms of each station.
    ByArms(&'static str),
    /// What all stations have alike, shown by one.
    Alike,
    /// The class that stations have, before this is made of it.
    Class(Map<String, Value>),
    /// What all stations have to take.
    Everywhere {
        /// The method that was asked of the hub.
        method: &'static str,
        /// Pupils for whom the file had another code than the one that counts.
        codes_kept: Vec<String>,
    },
    Arms,
    Sessions,
    Stops,
}

#[derive(Debug)]
pub(super) struct Gather {
    pub(super) socket: super::SocketId,
    pub(super) id: Option<MessageId>,
    pub(super) what: Gathers,
    pub(super) due: HostInstant,
    /// Requests that are not answered yet, and whom they went to; none is the hub's own part.
    pub(super) left: BTreeMap<RequestId, Option<StationId>>,
    pub(super) parts: Vec<(Option<StationId>, Result<Value, RpcError>)>,
    /// Arms that cannot be reached at all.
    pub(super) beyond: Vec<String>,
}
