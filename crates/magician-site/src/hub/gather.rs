//! What several stations answer together, with the arms at which something is not known to be done.

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

/// Time that lists wait for a station.
const LIST: Duration = Duration::from_millis(700);
/// Time that everything else waits, a stop above all.
const STOP: Duration = Duration::from_secs(3);
/// Items of a list of a station that are read, at most.
const MOST: usize = 1000;

/// Several requests with one answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct GatherId(u64);

/// What the answers are for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Gathers {
    /// The list of arms.
    Arms,
    /// The list of sessions.
    Sessions,
    /// A stop, of one arm or of all.
    Stops,
    /// What was asked of some arms of each station: the name of the list that they answer.
    ByArms(&'static str),
    /// What pupils have made.
    Results,
    /// The arms that any of the stations expects.
    Roster,
    /// What all stations have alike, shown by one.
    Alike,
    /// The class that stations have, before another one is made of it.
    Class,
    /// What all stations have to take: the pupils for whom the file had another code than the one that counts.
    Everywhere(Vec<String>),
    /// The roster, before a class that all stations have taken is shown.
    Expected(Value),
}

/// The arms that are meant by a request.
#[derive(Debug, Default)]
pub(super) struct Meant {
    /// By their stations.
    pub(super) at: BTreeMap<StationId, Vec<String>>,
    /// Those whose station cannot be asked.
    pub(super) beyond: BTreeSet<String>,
}

/// Requests to several stations, which become the answer to one.
#[derive(Debug)]
pub(super) struct Gather {
    pub(super) call: Call,
    pub(super) what: Gathers,
    pub(super) due: HostInstant,
    pub(super) meant: Meant,
    /// The requests without an answer yet.
    pub(super) left: BTreeMap<RequestId, StationId>,
    pub(super) parts: BTreeMap<StationId, Result<Value, RpcError>>,
}

impl Gather {
    /// The answers that are no errors.
    pub(super) fn answers(&self) -> impl Iterator<Item = (StationId, &Value)> {
        let parts = self.parts.iter();
        parts.filter_map(|(station, part)| Some((*station, part.as_ref().ok()?)))
    }

    pub(super) fn error(&self) -> Option<RpcError> {
        { self.parts.values() }.find_map(|part| part.as_ref().err().cloned())
    }

    /// The arms at a station that are meant.
    pub(super) fn arms_at(&self, station: StationId) -> &[String] {
        self.meant.at.get(&station).map_or(&[], Vec::as_slice)
    }

    /// The arms that have not answered: their station cannot be asked, or says nothing.
    pub(super) fn missing(&self) -> BTreeSet<String> {
        let silent = self
            .left
            .values()
            .flat_map(|station| self.arms_at(*station));
        silent.chain(&self.meant.beyond).cloned().collect()
    }

    /// The error that names the arms at which it is not known to be done, and why. `None` if all have done it.
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

    /// What was done at all arms, as this list; else the error that names those at which it may not be, with the list.
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
    /// The arms that are meant by a request for one, or for all.
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

    /// Asks all stations, without parameters.
    pub(super) fn ask_all(&mut self, call: Call, what: Gathers, method: &'static str) -> Handled {
        self.gather(call, what, method, Map::new(), self.meant(None))
    }

    /// Asks the stations of the arms that are meant; together their answers become that to `call`.
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

    /// Asks, in a first round or in another one.
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

    /// A part of an answer is there.
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

    /// Answers with what is there, or asks on.
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

/// The items of a list; what is none has none.
pub(super) fn items(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten().take(MOST)
}
