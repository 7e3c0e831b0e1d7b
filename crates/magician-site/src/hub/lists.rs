//! What several stations answer together: lists, and a stop of all.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use magician::ErrorKind;
use magician_protocol::HostInstant;
use magician_station::api::{Method, RpcError, notification};
use serde_json::{Map, Value, json};

use super::requests::Call;
use super::socket::{Gather, GatherId, Gathers, Pending, Socket, Via, Wants};
use super::{ArmPlace, Hub, HubAct, RequestId, SocketId};
use crate::site::{ArmAt, StationId};

/// A list waits for a station so long.
const LIST: Duration = Duration::from_millis(700);
/// A stop does.
const STOP: Duration = Duration::from_secs(3);

impl Hub {
    pub(super) fn gathers(&mut self, call: &Call, what: Gathers) -> GatherId {
        let id = GatherId(self.next_id());
        if let Some(open) = self.sockets.get_mut(&call.socket) {
            open.under_way += 1;
        }
        let wait = match what {
            Gathers::Arms | Gathers::Sessions | Gathers::Alike => LIST,
            _ => STOP,
        };
        let gather = Gather {
            socket: call.socket,
            id: call.id.clone(),
            what,
            due: call.now + wait,
            left: BTreeMap::new(),
            parts: Vec::new(),
            beyond: Vec::new(),
        };
        self.gathers.insert(id, gather);
        id
    }

    pub(super) fn waits_for(
        &mut self,
        gather: GatherId,
        request: Option<RequestId>,
        of: Option<StationId>,
    ) {
        if let (Some(gather), Some(request)) = (self.gathers.get_mut(&gather), request) {
            gather.left.insert(request, of);
        }
    }

    /// Asks all stations that can be asked by a line, or by themselves.
    pub(super) fn ask_all(&mut self, call: &Call, gather: GatherId) {
        let once = self.sockets.get(&call.socket).is_some_and(Socket::calls);
        let stations = self.stations.iter().filter_map(|(station, (_, arms))| {
            let arm = arms.first()?.clone();
            let station = *station;
            Some(ArmAt { arm, station })
        });
        for at in stations.collect::<Vec<_>>() {
            self.ask_at(call, gather, &at, once);
        }
    }

    /// Asks one.
    pub(super) fn ask_one(&mut self, call: &Call, gather: GatherId, station: StationId) -> bool {
        let once = self.sockets.get(&call.socket).is_some_and(Socket::calls);
        let arms = self.stations.get(&station).map(|(_, arms)| arms);
        if let Some(arm) = arms.and_then(|arms| arms.first().cloned()) {
            return self.ask_at(call, gather, &ArmAt { arm, station }, once);
        }
        false
    }

    fn ask_at(&mut self, call: &Call, gather: GatherId, at: &ArmAt, once: bool) -> bool {
        let request = if once {
            Some(self.call_beside(call, at, Wants::Part(gather)))
        } else if let Ok(line) = self.line_to(call.now, call.socket, at.station) {
            let params = call.params.clone();
            self.ask_line(line, call.method.name, params, Wants::Part(gather))
        } else {
            None
        };
        self.waits_for(gather, request, Some(at.station));
        request.is_some()
    }

    pub(super) fn list_arms(&mut self, call: &Call) -> Option<Value> {
        if let Some(open) = self.sockets.get_mut(&call.socket) {
            open.wide = true;
        }
        let gather = self.gathers(call, Gathers::Arms);
        self.ask_all(call, gather);
        self.is_complete(call.now, gather);
        None
    }

    pub(super) fn list_sessions(&mut self, call: &Call) -> Option<Value> {
        let gather = self.gathers(call, Gathers::Sessions);
        let home = self.ids + 1;
        self.ask_home(call, Wants::Part(gather));
        self.waits_for(gather, Some(RequestId(home)), None);
        self.ask_all(call, gather);
        self.is_complete(call.now, gather);
        None
    }

    /// Stops an arm, wherever it is, or all.
    pub(super) fn stop(
        &mut self,
        call: &Call,
        arm: Option<&str>,
    ) -> Result<Option<Value>, RpcError> {
        let known = |(name, _): &(&String, &ArmPlace)| arm.is_none_or(|arm| arm == name.as_str());
        let meant: Vec<_> = self
            .arms
            .iter()
            .filter(known)
            .map(|(name, place)| (name.clone(), place.at.keys().copied().collect::<Vec<_>>()))
            .collect();
        if let (Some(_), []) = (arm, meant.as_slice()) {
            return self.station_of(arm).map(|_| None);
        }
        let gather = self.gathers(call, Gathers::Stops);
        let mut stations = BTreeMap::new();
        for (name, at) in &meant {
            if at.is_empty()
                && let Some(gather) = self.gathers.get_mut(&gather)
            {
                gather.beyond.push(name.clone());
            }
            for station in at {
                stations
                    .entry(*station)
                    .or_insert_with(Vec::new)
                    .push(name.clone());
            }
        }
        // The stops go out before anything else is done; one of a station is of all its arms.
        for (station, names) in &stations {
            let mut params = Map::new();
            if let Some(arm) = arm {
                params.insert("arm".to_owned(), json!(arm));
            }
            let at = ArmAt {
                arm: names.first().cloned().unwrap_or_default(),
                station: *station,
            };
            let one = Call {
                now: call.now,
                socket: call.socket,
                id: Some(magician_station::api::MessageId::Number(0)),
                method: call.method,
                params,
            };
            let request = self.call_beside(&one, &at, Wants::Part(gather));
            self.waits_for(gather, Some(request), Some(*station));
        }
        for (station, names) in &stations {
            for name in names {
                self.stop_behind(call, *station, name);
            }
        }
        self.is_complete(call.now, gather);
        Ok(None)
    }

    /// What was handed over before a stop, by whomever, does not move the arm after it: what waits here is ended, and what may be
    /// on its way gets a stop behind it.
    fn stop_behind(&mut self, call: &Call, station: StationId, arm: &str) {
        let by = self
            .sockets
            .get(&call.socket)
            .and_then(|open| open.session.clone());
        let of_station = |hub: &Self, pending: &Pending| match (&pending.wants, pending.via) {
            (Wants::Program(of, _), _) => *of == station,
            (_, Via::Line(line)) => hub
                .lines
                .get(&line)
                .is_some_and(|line| line.station == station),
            _ => false,
        };
        let mut waiting = Vec::new();
        let mut on_their_way = Vec::new();
        for (request, pending) in &self.pending {
            let at_station = of_station(self, pending);
            if !at_station || !Self::is_ended_by_stop(pending, arm, at_station) {
                continue;
            }
            match pending.via {
                Via::Line(line) if pending.sent => on_their_way.push(line),
                _ => waiting.push(*request),
            }
        }
        for request in waiting {
            let Some(pending) = self.pending.remove(&request) else {
                continue;
            };
            if let Via::Line(line) = pending.via
                && let Some(line) = self.lines.get_mut(&line)
            {
                line.queue.retain(|(id, _)| *id != Some(request));
                line.held.retain(|(id, _)| *id != Some(request));
            }
            let error = RpcError::new(RpcError::STOPPED, "a stop ended it").with("by", json!(by));
            self.finish(pending.socket, pending.id.as_ref(), &Err(error));
        }
        on_their_way.dedup();
        let text = notification("arm.stop", &json!({"arm": arm}));
        for line in on_their_way {
            if let Some(open) = self.lines.get_mut(&line) {
                open.queue.push_back((None, text.clone()));
                self.acts.push_back(HubAct::Awake(line));
            }
        }
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
            if let Some(of) = gather.left.remove(&request) {
                gather.parts.push((of, outcome));
            }
            self.is_complete(now, id);
        }
    }

    pub(super) fn is_complete(&mut self, now: HostInstant, id: GatherId) {
        if { self.gathers.get(&id) }.is_some_and(|gather| gather.left.is_empty()) {
            self.gathered(now, id);
        }
    }

    /// Answers with what is there.
    pub(super) fn gathered(&mut self, now: HostInstant, id: GatherId) {
        let Some(mut gather) = self.gathers.remove(&id) else {
            return;
        };
        let outcome = match gather.what {
            Gathers::Results
            | Gathers::ByArms(_)
            | Gathers::Class(..)
            | Gathers::Everywhere { .. }
            | Gathers::Alike => match self.class_gathered(now, &mut gather) {
                Some(outcome) => outcome,
                // It goes on.
                None => return,
            },
            Gathers::Arms => Ok(self.arms_of(now, &gather)),
            Gathers::Sessions => {
                let parts = gather
                    .parts
                    .iter()
                    .filter_map(|(of, part)| Some((*of, part.as_ref().ok()?)));
                let parts = parts.map(|(of, part)| (of, part["sessions"].clone()));
                Ok(Self::merged_sessions(parts.collect()))
            }
            Gathers::Stops => self.stopped(&gather),
        };
        self.finish(gather.socket, gather.id.as_ref(), &outcome);
    }

    /// The arms: as their stations list them, else by what is known otherwise.
    fn arms_of(&mut self, now: HostInstant, gather: &Gather) -> Value {
        for (of, part) in &gather.parts {
            let (Some(station), Ok(part)) = (of, part) else {
                continue;
            };
            for row in part["arms"].as_array().into_iter().flatten() {
                let name = row["name"].as_str().unwrap_or_default();
                // A station has a say on its own arms alone.
                if self.has_alone(*station, name)
                    && let Some(place) = self.arms.get_mut(name)
                {
                    place.row = Some(row.clone());
                }
            }
        }
        let answered = |station: &StationId| {
            let mut parts = gather.parts.iter();
            parts.any(|(of, part)| of.as_ref() == Some(station) && part.is_ok())
        };
        let rows = self.arms.iter().map(|(name, place)| {
            let mut stations = place.at.keys();
            let row = match (stations.next(), stations.next()) {
                (Some(station), None) if answered(station) => {
                    return place.row.clone().unwrap_or_else(|| lost(name, None));
                }
                (Some(station), None) => self.row_by_news(now, name, *station),
                (None, _) => place.row.clone(),
                _ => None,
            };
            row.map_or_else(
                || lost(name, place.row.as_ref()),
                |row| {
                    if place.at.is_empty() {
                        lost(name, Some(&row))
                    } else {
                        row
                    }
                },
            )
        });
        json!({"arms": rows.collect::<Vec<_>>()})
    }

    /// A row of an arm whose station does not answer this session.
    fn row_by_news(&self, now: HostInstant, name: &str, station: StationId) -> Option<Value> {
        let at = ArmAt {
            arm: name.to_owned(),
            station,
        };
        let (_, news) = self.arms.get(name)?.at.get(&station)?.as_ref()?;
        let state = self.state_now(now, &at).and_then(Result::ok);
        let state = state.as_ref();
        let of = |member: &str| state.map_or(Value::Null, |state| state[member].clone());
        Some(json!({
            "name": name,
            "port": news.port,
            "virtual": news.is_virtual,
            "link": if state.is_some() { "up" } else { "lost" },
            "holder": of("holder"),
            "waiting": [],
            "job": of("job"),
        }))
    }

    /// All stand, or the arms are named that may not.
    fn stopped(&self, gather: &Gather) -> Result<Value, RpcError> {
        let stood = |part: &Result<Value, RpcError>| match part {
            Ok(part) => part["arms"].as_array().cloned(),
            Err(error) => error.data.get("arms")?.as_array().cloned(),
        };
        let parts = gather.parts.iter().filter_map(|(_, part)| stood(part));
        let mut arms: Vec<_> = parts.flatten().collect();
        arms.sort_by(|one: &Value, other| one["arm"].as_str().cmp(&other["arm"].as_str()));
        match self.undone(gather) {
            None => Ok(json!({ "arms": arms })),
            Some((kind, which)) => {
                let why = format!("not all arms are known to stand: {which}");
                let missing = self.missing(gather);
                Err(RpcError::arm(kind, why)
                    .with("arms", arms)
                    .with("missing", missing))
            }
        }
    }

    /// The arms that have not answered: their station cannot be reached, or says nothing.
    pub(super) fn missing(&self, gather: &Gather) -> Vec<String> {
        let silent = gather.left.values().flatten();
        let silent = silent.filter_map(|station| self.stations.get(station));
        let silent = silent.flat_map(|(_, arms)| arms);
        let missing: BTreeSet<_> = silent.chain(&gather.beyond).cloned().collect();
        missing.into_iter().collect()
    }

    /// The arms at which something is not known to be done, and why.
    pub(super) fn undone(&self, gather: &Gather) -> Option<(ErrorKind, String)> {
        let names_but = |station: &StationId, done: &Value| {
            let (_, arms) = self.stations.get(station)?;
            let is_done = |arm: &&String| {
                let mut done = done.as_array().into_iter().flatten();
                done.any(|done| done["arm"] == arm.as_str())
            };
            let arms = arms.iter().filter(|arm| !is_done(arm));
            let arms: Vec<_> = arms.map(String::as_str).collect();
            Some(arms.join(", "))
        };
        let names = |station: &StationId| names_but(station, &Value::Null);
        let mut undone = Vec::new();
        for (of, part) in &gather.parts {
            let Err(error) = part else {
                continue;
            };
            let done = error.data.get("arms").unwrap_or(&Value::Null);
            undone.push(match of.as_ref().and_then(|of| names_but(of, done)) {
                Some(names) if !error.message.starts_with(&names) => {
                    format!("{names}: {}", error.message)
                }
                _ => error.message.clone(),
            });
        }
        let silent: Vec<_> = gather.left.values().flatten().filter_map(names).collect();
        let kind = if silent.is_empty() && gather.beyond.is_empty() {
            ErrorKind::Port
        } else {
            ErrorKind::Timeout
        };
        if !silent.is_empty() {
            undone.push(format!("no answer within 3 s from {}", silent.join(", ")));
        }
        if !gather.beyond.is_empty() {
            undone.push(format!("{} cannot be reached", gather.beyond.join(", ")));
        }
        (!undone.is_empty()).then(|| (kind, undone.join("; ")))
    }

    /// The sessions as they were told last.
    pub(super) fn known_sessions(&self, socket: SocketId) -> Value {
        let ids = Method::named("session.list").map_or(&[][..], Method::result_ids);
        let lines = self
            .lines
            .values()
            .filter(|line| line.socket == socket && line.up);
        let lines = lines.map(|line| {
            let mut part = json!({"sessions": line.sessions});
            self.names.rename(line.slot, &mut part, ids);
            (Some(line.station), part["sessions"].take())
        });
        let home = std::iter::once((None, self.sessions.clone()));
        Self::merged_sessions(home.chain(lines).collect())
    }

    /// One list: a client of the hub is in it once, with its leases at all stations.
    fn merged_sessions(mut parts: Vec<(Option<StationId>, Value)>) -> Value {
        // Those of home first.
        parts.sort_by_key(|(of, _)| *of);
        let mut all: Vec<Value> = Vec::new();
        for session in parts
            .into_iter()
            .filter_map(|(_, part)| match part {
                Value::Array(sessions) => Some(sessions),
                _ => None,
            })
            .flatten()
        {
            let known = all
                .iter_mut()
                .find(|one| one["session"] == session["session"]);
            match (known, session["leases"].as_array()) {
                (Some(known), Some(more)) => {
                    if let Some(leases) = known["leases"].as_array_mut() {
                        leases.extend(more.iter().cloned());
                    }
                }
                (Some(_), None) => {}
                (None, _) => all.push(session),
            }
        }
        json!({ "sessions": all })
    }
}

/// An arm that nothing is known of at present, beside what was known before.
fn lost(name: &str, before: Option<&Value>) -> Value {
    let of = |member: &str, unknown: Value| before.map_or(unknown, |row| row[member].clone());
    json!({
        "name": name,
        "port": of("port", json!("")),
        "virtual": of("virtual", json!(false)),
        "link": "lost",
        "holder": null,
        "waiting": [],
        "job": null,
    })
}
