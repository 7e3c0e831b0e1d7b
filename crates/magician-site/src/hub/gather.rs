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
use super::socket::{Purpose, Socket};
use super::{Hub, RequestId};
use crate::site::{ArmAt, StationId};

/// Timeout for lists. Short, because a client shows a list with gaps rather than wait for a station
/// that is switched off.
const LIST_TIMEOUT: Duration = Duration::from_millis(700);
/// Timeout for everything else, stops above all.
const GATHER_TIMEOUT: Duration = Duration::from_secs(3);
/// Most items read from a list in a reply, which bounds the work that one station can cause.
const MAX_ITEMS: usize = 1000;

/// Id of a gather.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct GatherId(u64);

/// Purpose of a gather, which decides how the replies are merged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum GatherPurpose {
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
pub(super) struct AddressedArms {
    /// Arms by station.
    pub(super) at: BTreeMap<StationId, Vec<String>>,
    /// Arms whose station is unreachable.
    pub(super) unreachable: BTreeSet<String>,
}

/// Requests to several stations on behalf of one client request.
#[derive(Debug)]
pub(super) struct Gather {
    pub(super) call: Call,
    pub(super) purpose: GatherPurpose,
    pub(super) due: HostInstant,
    pub(super) addressed: AddressedArms,
    /// Requests without a reply yet.
    pub(super) outstanding: BTreeMap<RequestId, StationId>,
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
        self.addressed.at.get(&station).map_or(&[], Vec::as_slice)
    }

    /// Arms without a reply: their station is unreachable or silent.
    pub(super) fn missing(&self) -> BTreeSet<String> {
        let silent = self
            .outstanding
            .values()
            .flat_map(|station| self.arms_at(*station));
        silent.chain(&self.addressed.unreachable).cloned().collect()
    }

    /// Error that names the arms where success is unknown, with reasons. `None` if all stations
    /// succeeded.
    pub(super) fn incomplete_error(&self) -> Option<RpcError> {
        let mut reasons = Vec::new();
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
            reasons.push(if error.message.starts_with(&names) {
                error.message.clone()
            } else {
                format!("{names}: {}", error.message)
            });
        }
        let silent = self
            .outstanding
            .values()
            .flat_map(|station| self.arms_at(*station));
        let silent: Vec<_> = silent.map(String::as_str).collect();
        let unreachable: Vec<_> = self
            .addressed
            .unreachable
            .iter()
            .map(String::as_str)
            .collect();
        let kind = if silent.is_empty() && unreachable.is_empty() {
            ErrorKind::Port
        } else {
            ErrorKind::Timeout
        };
        if !silent.is_empty() {
            reasons.push(format!(
                "no answer within {} s from {}",
                GATHER_TIMEOUT.as_secs(),
                silent.join(", ")
            ));
        }
        if !unreachable.is_empty() {
            reasons.push(format!("{} cannot be reached", unreachable.join(", ")));
        }
        let fact = match self.purpose {
            GatherPurpose::Stops => "not all arms are known to stand".to_owned(),
            _ => format!(
                "{} is not known to be done everywhere",
                self.call.method.name
            ),
        };
        let error = || RpcError::arm(kind, format!("{fact}: {}", reasons.join("; ")));
        let missing = || self.missing().into_iter().collect::<Vec<_>>();
        (!reasons.is_empty()).then(|| error().with("missing", missing()))
    }

    /// Merges the named list of all replies. If some arms may not be done, returns the error of
    /// [`incomplete_error`](Self::incomplete_error) with that list attached.
    fn merged_list(&self, list: &str) -> Result<Value, RpcError> {
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
        match self.incomplete_error() {
            None => Ok(json!({ list: done })),
            Some(error) => Err(error.with(list, done)),
        }
    }
}

impl Hub {
    /// Collects the arms of a request for one arm, or for all if `arm` is `None`.
    pub(super) fn addressed(&self, arm: Option<&str>) -> AddressedArms {
        let mut addressed = AddressedArms::default();
        let known = |(name, _): &(&String, _)| arm.is_none_or(|arm| arm == name.as_str());
        for (name, entry) in self.arms.iter().filter(known) {
            if entry.at.is_empty() {
                addressed.unreachable.insert(name.clone());
            }
            for station in entry.at.keys() {
                addressed.at.entry(*station).or_default().push(name.clone());
            }
        }
        addressed
    }

    /// Starts a gather over all stations, without parameters.
    pub(super) fn gather_all(
        &mut self,
        call: Call,
        purpose: GatherPurpose,
        method: &'static str,
    ) -> Handled {
        self.gather(call, purpose, method, Map::new(), self.addressed(None))
    }

    /// Starts a gather: asks the stations of the addressed arms, and merges their replies into the
    /// reply to `call`.
    pub(super) fn gather(
        &mut self,
        call: Call,
        purpose: GatherPurpose,
        method: &'static str,
        params: Map<String, Value>,
        addressed: AddressedArms,
    ) -> Handled {
        let id = GatherId(self.next_id());
        if let Some(open) = self.sockets.get_mut(&call.socket) {
            open.in_flight += 1;
        }
        self.send_round(id, call, purpose, method, params, addressed);
        Ok(None)
    }

    /// Sends the requests of one round.
    pub(super) fn send_round(
        &mut self,
        id: GatherId,
        call: Call,
        purpose: GatherPurpose,
        method: &'static str,
        params: Map<String, Value>,
        addressed: AddressedArms,
    ) {
        let Some(method) = Method::named(method) else {
            return;
        };
        let wait = match purpose {
            GatherPurpose::Arms
            | GatherPurpose::Sessions
            | GatherPurpose::Alike
            | GatherPurpose::Roster => LIST_TIMEOUT,
            _ => GATHER_TIMEOUT,
        };
        let sends_single =
            { self.sockets.get(&call.socket) }.is_some_and(Socket::sends_single_requests);
        // A stop must not wait behind other messages on a line.
        let is_single = sends_single || purpose == GatherPurpose::Stops;
        let call_by_arms = matches!(purpose, GatherPurpose::ByArms(_));
        let request = Call {
            method,
            params,
            ..call.clone()
        };
        let mut gather = Gather {
            due: call.now + wait,
            call,
            purpose,
            addressed,
            outstanding: BTreeMap::new(),
            parts: BTreeMap::new(),
        };
        for (station, arms) in &gather.addressed.at {
            let mut request = request.clone();
            if call_by_arms {
                request.params.insert("arms".to_owned(), json!(arms));
            }
            let purpose = Purpose::Part(id);
            let request = if is_single {
                let (arm, station) = (arms[0].clone(), *station);
                Some(self.forward_single(&request, &ArmAt { arm, station }, purpose))
            } else {
                let line = self.line_to(request.now, request.socket, *station).ok();
                line.and_then(|line| {
                    self.request_on_line(line, method.name, request.params.into(), purpose)
                })
            };
            match request {
                Some(request) => drop(gather.outstanding.insert(request, *station)),
                None => gather.addressed.unreachable.extend(arms.iter().cloned()),
            }
        }
        let now = gather.call.now;
        self.gathers.insert(id, gather);
        self.finish_if_complete(now, id);
    }

    /// Stores the reply of one station.
    pub(super) fn store_part(
        &mut self,
        now: HostInstant,
        id: GatherId,
        request: RequestId,
        outcome: Result<Value, RpcError>,
    ) {
        if let Some(gather) = self.gathers.get_mut(&id) {
            if let Some(station) = gather.outstanding.remove(&request) {
                gather.parts.insert(station, outcome);
            }
            self.finish_if_complete(now, id);
        }
    }

    fn finish_if_complete(&mut self, now: HostInstant, id: GatherId) {
        if { self.gathers.get(&id) }.is_some_and(|gather| gather.outstanding.is_empty()) {
            self.finish_gather(now, id);
        }
    }

    /// Merges the replies that have arrived: replies to the client, or starts the next round.
    pub(super) fn finish_gather(&mut self, now: HostInstant, id: GatherId) {
        let Some(gather) = self.gathers.remove(&id) else {
            return;
        };
        let outcome = match &gather.purpose {
            GatherPurpose::Arms => Ok(self.arm_list_answer(now, &gather)),
            GatherPurpose::Sessions => {
                let parts = gather.answers();
                let parts = parts.map(|(_, part)| part["sessions"].clone());
                Ok(self.merged_sessions(parts))
            }
            GatherPurpose::Stops => gather.merged_list("arms"),
            GatherPurpose::ByArms(list) => gather.merged_list(list),
            GatherPurpose::Results => self.results(&gather),
            GatherPurpose::Alike => self.majority(&gather),
            GatherPurpose::Roster => Ok(self.roster(&gather)),
            GatherPurpose::Class => match self.class_to_set(&gather) {
                Ok(class) => return self.set_class(now, id, gather.call, class),
                Err(error) => Err(error),
            },
            GatherPurpose::Everywhere(codes_kept) => {
                match self.distribution_answer(&gather, codes_kept) {
                    Ok(class) if gather.call.method.name == "class.set" => {
                        return self.expect_present(now, id, gather.call, class);
                    }
                    outcome => outcome,
                }
            }
            GatherPurpose::Expected(class) => gather
                .incomplete_error()
                .map_or_else(|| Ok(class.clone()), Err),
        };
        self.finish(gather.call.socket, gather.call.id.as_ref(), &outcome);
    }
}

/// Items of a JSON array. Empty for any other value.
pub(super) fn items(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten().take(MAX_ITEMS)
}
