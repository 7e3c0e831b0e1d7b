//! Gathers: one request of a client that becomes requests to several stations, whose replies are
//! merged.
//!
//! A gather ends when all stations have replied or its time is up. A command is never reported as
//! done unless every station confirmed it: the error names the arms where that is unknown. Some
//! requests need several rounds, which keep the same [`GatherId`].

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use magician::ErrorKind;
use magician_protocol::HostInstant;
use magician_station::api::{Method, RpcError};
use serde_json::{Map, Value, json};

use super::requests::{Call, Handled};
use super::socket::{Socket, Wants};
use super::{Hub, RequestId};
use crate::site::{ArmAt, StationId};

/// Timeout for lists. Short, because a client shows a list with gaps rather than wait for a station
/// that is switched off.
const LIST: Duration = Duration::from_millis(700);
/// Timeout for everything else, stops above all. The error text names it, so change both together.
const STOP: Duration = Duration::from_secs(3);
/// Most items read from a list in a reply, which bounds the work that one station can cause.
const MOST: usize = 1000;

/// Id of a gather.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct GatherId(u64);

/// Purpose of a gather, which decides how the replies are merged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Gathers {
    /// List of arms.
    Arms,
    /// List of sessions.
    Sessions,
    /// Stop of one arm or of all.
    Stops,
    /// Method that takes a list of arms. The value is the name of the list in the replies.
    ByArms(&'static str),
    /// Results of pupils.
    Results,
    /// Roster: union over all stations.
    Roster,
    /// Class or schedule, which should be the same at all stations. One is shown.
    Alike,
    /// Current classes of the stations, as the base of a new one.
    Class,
    /// Value that all stations have to accept. Holds the pupils whose code in the file was
    /// replaced.
    Everywhere(Vec<String>),
    /// Roster update after a new class. Holds the class for the reply.
    Expected(Value),
}

/// Arms addressed by a request.
#[derive(Debug, Default)]
pub(super) struct Meant {
    /// Arms by station.
    pub(super) at: BTreeMap<StationId, Vec<String>>,
    /// Arms whose station is unreachable.
    pub(super) beyond: BTreeSet<String>,
}

/// Requests to several stations on behalf of one client request.
#[derive(Debug)]
pub(super) struct Gather {
    pub(super) call: Call,
    pub(super) what: Gathers,
    pub(super) due: HostInstant,
    pub(super) meant: Meant,
    /// Requests without a reply yet.
    pub(super) left: BTreeMap<RequestId, StationId>,
    pub(super) parts: BTreeMap<StationId, Result<Value, RpcError>>,
}

impl Gather {
    /// Successful replies.
    pub(super) fn answers(&self) -> impl Iterator<Item = (StationId, &Value)> {
        let parts = self.parts.iter();
        parts.filter_map(|(station, part)| Some((*station, part.as_ref().ok()?)))
    }

    pub(super) fn error(&self) -> Option<RpcError> {
        { self.parts.values() }.find_map(|part| part.as_ref().err().cloned())
    }

    /// Addressed arms of a station.
    pub(super) fn arms_at(&self, station: StationId) -> &[String] {
        self.meant.at.get(&station).map_or(&[], Vec::as_slice)
    }

    /// Arms without a reply: their station is unreachable or silent.
    pub(super) fn missing(&self) -> BTreeSet<String> {
        let silent = self
            .left
            .values()
            .flat_map(|station| self.arms_at(*station));
        silent.chain(&self.meant.beyond).cloned().collect()
    }

    /// Error that names the arms where success is unknown, with reasons. `None` if all stations
    /// succeeded.
    pub(super) fn undone(&self) -> Option<RpcError> {
        let mut undone = Vec::new();
        for (station, part) in &self.parts {
            let Err(error) = part else { continue };
            let done: Vec<_> = { error.data.get("arms").into_iter() }
                .flat_map(items)
                .map(|done| &done["arm"])
                .collect();
            let arms = self.arms_at(*station).iter();
            let arms: Vec<_> = arms
                .filter(|arm| !done.contains(&&json!(arm)))
                .map(String::as_str)
                .collect();
            let names = arms.join(", ");
            undone.push(if error.message.starts_with(&names) {
                error.message.clone()
            } else {
                format!("{names}: {}", error.message)
            });
        }
        let silent = self
            .left
            .values()
            .flat_map(|station| self.arms_at(*station));
        let silent: Vec<_> = silent.map(String::as_str).collect();
        let beyond: Vec<_> = self.meant.beyond.iter().map(String::as_str).collect();
        let kind = if silent.is_empty() && beyond.is_empty() {
            ErrorKind::Port
        } else {
            ErrorKind::Timeout
        };
        if !silent.is_empty() {
            undone.push(format!("no answer within 3 s from {}", silent.join(", ")));
        }
        if !beyond.is_empty() {
            undone.push(format!("{} cannot be reached", beyond.join(", ")));
        }
        let what = match self.what {
            Gathers::Stops => "not all arms are known to stand".to_owned(),
            _ => format!(
                "{} is not known to be done everywhere",
                self.call.method.name
            ),
        };
        let error = || RpcError::arm(kind, format!("{what}: {}", undone.join("; ")));
        let missing = || self.missing().into_iter().collect::<Vec<_>>();
        (!undone.is_empty()).then(|| error().with("missing", missing()))
    }

    /// Merges the named list of all replies. If some arms may not be done, returns the error of
    /// [`undone`](Self::undone) with that list attached.
    fn done(&self, list: &str) -> Result<Value, RpcError> {
        let of = |part: &Result<Value, RpcError>| match part {
            Ok(part) => part.get(list).cloned(),
            Err(error) => error.data.get(list).cloned(),
        };
        let lists: Vec<_> = self.parts.values().filter_map(of).collect();
        let mut done: Vec<_> = lists.iter().flat_map(items).cloned().collect();
        done.sort_by_key(|one| {
            one.as_str()
                .or(one["arm"].as_str())
                .unwrap_or_default()
                .to_owned()
        });
        match self.undone() {
            None => Ok(json!({ list: done })),
            Some(error) => Err(error.with(list, done)),
        }
    }
}

impl Hub {
    /// Collects the arms of a request for one arm, or for all if `arm` is `None`.
    pub(super) fn meant(&self, arm: Option<&str>) -> Meant {
        let mut meant = Meant::default();
        let known = |(name, _): &(&String, _)| arm.is_none_or(|arm| arm == name.as_str());
        for (name, place) in self.arms.iter().filter(known) {
            if place.at.is_empty() {
                meant.beyond.insert(name.clone());
            }
            for station in place.at.keys() {
                meant.at.entry(*station).or_default().push(name.clone());
            }
        }
        meant
    }

    /// Starts a gather over all stations, without parameters.
    pub(super) fn ask_all(&mut self, call: Call, what: Gathers, method: &'static str) -> Handled {
        self.gather(call, what, method, Map::new(), self.meant(None))
    }

    /// Starts a gather: asks the stations of the addressed arms, and merges their replies into the
    /// reply to `call`.
    pub(super) fn gather(
        &mut self,
        call: Call,
        what: Gathers,
        method: &'static str,
        params: Map<String, Value>,
        meant: Meant,
    ) -> Handled {
        let id = GatherId(self.next_id());
        if let Some(open) = self.sockets.get_mut(&call.socket) {
            open.under_way += 1;
        }
        self.ask(id, call, what, method, params, meant);
        Ok(None)
    }

    /// Sends the requests of one round.
    pub(super) fn ask(
        &mut self,
        id: GatherId,
        call: Call,
        what: Gathers,
        method: &'static str,
        params: Map<String, Value>,
        meant: Meant,
    ) {
        let Some(method) = Method::named(method) else {
            return;
        };
        let wait = match what {
            Gathers::Arms | Gathers::Sessions | Gathers::Alike | Gathers::Roster => LIST,
            _ => STOP,
        };
        let calls = { self.sockets.get(&call.socket) }.is_some_and(Socket::calls);
        // A stop must not wait behind other messages on a line.
        let beside = calls || what == Gathers::Stops;
        let by_arms = matches!(what, Gathers::ByArms(_));
        let asks = Call {
            method,
            params,
            ..call.clone()
        };
        let mut gather = Gather {
            due: call.now + wait,
            call,
            what,
            meant,
            left: BTreeMap::new(),
            parts: BTreeMap::new(),
        };
        for (station, arms) in &gather.meant.at {
            let mut asks = asks.clone();
            if by_arms {
                asks.params.insert("arms".to_owned(), json!(arms));
            }
            let wants = Wants::Part(id);
            let request = if beside {
                let (arm, station) = (arms[0].clone(), *station);
                Some(self.call_beside(&asks, &ArmAt { arm, station }, wants))
            } else {
                let line = self.line_to(asks.now, asks.socket, *station).ok();
                line.and_then(|line| self.ask_line(line, method.name, asks.params.into(), wants))
            };
            match request {
                Some(request) => drop(gather.left.insert(request, *station)),
                None => gather.meant.beyond.extend(arms.iter().cloned()),
            }
        }
        let now = gather.call.now;
        self.gathers.insert(id, gather);
        self.is_complete(now, id);
    }

    /// Stores the reply of one station.
    pub(super) fn part(
        &mut self,
        now: HostInstant,
        id: GatherId,
        request: RequestId,
        outcome: Result<Value, RpcError>,
    ) {
        if let Some(gather) = self.gathers.get_mut(&id) {
            if let Some(station) = gather.left.remove(&request) {
                gather.parts.insert(station, outcome);
            }
            self.is_complete(now, id);
        }
    }

    fn is_complete(&mut self, now: HostInstant, id: GatherId) {
        if { self.gathers.get(&id) }.is_some_and(|gather| gather.left.is_empty()) {
            self.gathered(now, id);
        }
    }

    /// Merges the replies that have arrived: replies to the client, or starts the next round.
    pub(super) fn gathered(&mut self, now: HostInstant, id: GatherId) {
        let Some(gather) = self.gathers.remove(&id) else {
            return;
        };
        let outcome = match &gather.what {
            Gathers::Arms => Ok(self.arms_listed(now, &gather)),
            Gathers::Sessions => {
                let parts = gather.answers();
                let parts = parts.map(|(_, part)| part["sessions"].clone());
                Ok(self.merged_sessions(parts))
            }
            Gathers::Stops => gather.done("arms"),
            Gathers::ByArms(list) => gather.done(list),
            Gathers::Results => self.results(&gather),
            Gathers::Alike => self.alike(&gather),
            Gathers::Roster => Ok(self.roster(&gather)),
            Gathers::Class => match self.class_to_set(&gather) {
                Ok(class) => return self.set_class(now, id, gather.call, class),
                Err(error) => Err(error),
            },
            Gathers::Everywhere(codes_kept) => match self.taken(&gather, codes_kept) {
                Ok(class) if gather.call.method.name == "class.set" => {
                    return self.expect_present(now, id, gather.call, class);
                }
                outcome => outcome,
            },
            Gathers::Expected(class) => gather.undone().map_or_else(|| Ok(class.clone()), Err),
        };
        self.finish(gather.call.socket, gather.call.id.as_ref(), &outcome);
    }
}

/// Items of a JSON array. Empty for any other value.
pub(super) fn items(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten().take(MOST)
}
