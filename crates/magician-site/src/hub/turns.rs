//! A class on a site: pupils sign in at all stations, and take turns at any of them. What is known of that the stations know.

use std::collections::BTreeMap;

use magician::ErrorKind;
use magician_protocol::HostInstant;
use magician_station::CloseCode;
use magician_station::api::{Method, Role, RpcError};
use serde_json::{Map, Value, json};

use super::requests::Call;
use super::socket::{Gather, Gathers, Wants, Way};
use super::{Hub, HubAct, LineId, SocketId, TURNS};
use crate::site::StationId;

/// What a turn without an end is taken for, s, where waits are compared.
const LONG: f64 = 3600.0;
/// Persons and arms that are looked at, at most.
const MOST: usize = 1000;

impl Hub {
    /// A pupil signs in: at all stations, of which one has to know the pupil.
    pub(super) fn sign_in(&mut self, call: Call) -> Result<Option<Value>, RpcError> {
        let (now, socket) = (call.now, call.socket);
        let hello = Method::named("session.hello").map_or(&[][..], |method| method.params);
        magician_station::api::Params::check(hello, call.params.clone())?;
        let Some(open) = self.sockets.get_mut(&socket) else {
            return Ok(None);
        };
        if open.session.is_some() || open.signing.is_some() {
            return Err(RpcError::request("`session.hello` came already"));
        }
        if self.stations.is_empty() {
            let why = "no station of the site can be reached: try again";
            return Err(RpcError::arm(ErrorKind::Port, why));
        }
        open.pupil = call.params.get("pupil").cloned();
        open.signing = Some((call, None));
        open.ways.clear();
        for station in self.stations.keys().copied().collect::<Vec<_>>() {
            let _ = self.line_to(now, socket, station);
        }
        Ok(None)
    }

    /// The session of a pupil whose page comes back.
    pub(super) fn comes_back(
        &self,
        hello: &Map<String, Value>,
        pupil: Option<&Value>,
    ) -> Option<String> {
        let secret = hello.get("resume")?.as_str()?;
        let name = pupil?.get("name")?.as_str()?.to_lowercase();
        let is = |person: &super::Person| {
            let known = person.pupil.as_ref().map(|known| known.to_lowercase());
            person.secret == secret && known.as_ref() == Some(&name)
        };
        let mut people = self.people.iter();
        let (session, _) = people.find(|(_, person)| is(person))?;
        Some(session.clone())
    }

    /// A station has let the pupil in: so does the hub's own.
    pub(super) fn pupil_is_in(&mut self, socket: SocketId) {
        let Some(open) = self.sockets.get_mut(&socket) else {
            return;
        };
        let Some((mut call, _)) = open.signing.take() else {
            return;
        };
        let pupil = open.pupil.clone();
        let name = pupil.as_ref().and_then(|pupil| pupil["name"].as_str());
        let name = name.unwrap_or_default().to_owned();
        if self.comes_back(&call.params, pupil.as_ref()).is_none() {
            call.params.remove("resume");
        }
        call.params.remove("pupil");
        call.params.insert("token".to_owned(), json!("pupil"));
        if let Some(client) = call.params.get_mut("client")
            && client.is_object()
        {
            client["name"] = json!(name);
        }
        self.acts.push_back(HubAct::Vouch(socket));
        // Lines are opened meanwhile, and may be: home says no more than what the session is called.
        if let Some(open) = self.sockets.get_mut(&socket) {
            open.role = Role::Student;
        }
        self.ask_home(&call, Wants::Hello(name, None));
    }

    /// A line of a pupil was not opened, or is lost: if all stations refuse the pupil, so does the hub.
    pub(super) fn pupil_is_refused(&mut self, socket: SocketId, why: RpcError) {
        let Some(open) = self.sockets.get_mut(&socket) else {
            return;
        };
        if open.pupil.is_none() {
            return;
        }
        let refuses =
            |why: &RpcError| [RpcError::FORBIDDEN, RpcError::TOO_MANY].contains(&why.code);
        let hopes = |way: &Way| matches!(way, Way::Line(_));
        if let Some((_, worst)) = &mut open.signing {
            // What a person can do something about.
            if worst.as_ref().is_none_or(|worst| !refuses(worst)) {
                *worst = Some(why);
            }
            if open.ways.values().any(hopes) {
                return;
            }
            let Some((call, why)) = open.signing.take() else {
                return;
            };
            let why =
                why.unwrap_or_else(|| RpcError::new(RpcError::INTERNAL, "no station has answered"));
            let (refused, id) = (refuses(&why), call.id.clone());
            open.pupil = None;
            open.ways.clear();
            self.respond(socket, id.as_ref(), &Err(why));
            if refused {
                self.home_closes(socket, CloseCode::TOKEN);
            }
        } else if open.session.is_some()
            && open.ways.values().all(|way| matches!(way, Way::Closed(_)))
        {
            // The code is not good any more.
            self.home_closes(socket, CloseCode::REVOKED);
        }
    }

    /// The sessions that a client has at stations are its own.
    pub(super) fn has_sessions(&mut self, socket: SocketId) {
        let session = { self.sockets.get(&socket) }.and_then(|open| open.session.clone());
        let Some(session) = session else {
            return;
        };
        let lines = self.lines.values().filter(|line| line.socket == socket);
        for line in lines {
            let Some((secret, there)) = &line.session else {
                continue;
            };
            self.names.is_own(line.slot, there, &session);
            if let Some(person) = self.people.get_mut(&session) {
                let at = (secret.clone(), there.clone());
                person.at.insert(line.station, at);
            }
        }
    }

    /// A station tells of its turns.
    pub(super) fn hears_turns(&mut self, now: HostInstant, line: LineId, turns: Value) {
        if let Some(line) = self.lines.get_mut(&line) {
            line.turns = Some((now, turns));
        }
    }

    /// A client hears of the turns of all stations.
    pub(super) fn turns_changed(&mut self, now: HostInstant, socket: SocketId) {
        self.told = now;
        let Some(open) = self.sockets.get_mut(&socket) else {
            return;
        };
        if !std::mem::replace(&mut open.turns, true) {
            // Of the other stations nothing is known yet.
            let unknown = self
                .lines
                .iter()
                .filter(|(_, line)| line.socket == socket && line.up && line.turns.is_none());
            for line in unknown.map(|(id, _)| *id).collect::<Vec<_>>() {
                self.ask_line(line, "turn.list", Map::new(), Wants::Turns);
            }
        }
        if let Some(open) = self.sockets.get_mut(&socket)
            && open.session.is_some()
            && open.outbox.state_due(TURNS)
        {
            self.awake.insert(socket);
        }
    }

    /// The turns of all stations, as they were told last.
    pub(super) fn known_turns(&self, socket: SocketId) -> Value {
        let lines = { self.lines.values() }.filter(|line| line.socket == socket && line.up);
        let parts = lines.filter_map(|line| {
            let (heard, turns) = line.turns.as_ref()?;
            Some((line.station, *heard, turns))
        });
        let mut turns = self.merged_turns(self.told, parts.collect());
        // Stations tell of changes without it.
        if let Some(turns) = turns.as_object_mut() {
            turns.remove("you");
        }
        turns
    }

    /// One list of arms, one queue. A place is that in the queue of its station: who has the same comes by the station's order.
    fn merged_turns(
        &self,
        now: HostInstant,
        parts: Vec<(StationId, HostInstant, &Value)>,
    ) -> Value {
        let (mut turn_s, mut you) = (Value::Null, Value::Null);
        let (mut arms, mut queue) = (Vec::new(), Vec::new());
        for (station, heard, turns) in parts {
            if turn_s.is_null() && turns["turn_s"].is_u64() {
                turn_s = turns["turn_s"].clone();
            }
            if turns["you"]["person"].is_string() {
                if you.is_null() {
                    you = json!({"person": turns["you"]["person"], "arms": []});
                }
                if let Some(all) = you["arms"].as_array_mut() {
                    all.extend(self.own_names(station, &turns["you"]["arms"]));
                }
            }
            for arm in items(&turns["arms"]) {
                // A station has a say on its own arms alone.
                if !self.has_alone(station, arm["arm"].as_str().unwrap_or_default()) {
                    continue;
                }
                let mut arm = arm.clone();
                if arm["state"] == "running"
                    && arm["frozen"] != true
                    && let Some(left) = arm["left_s"].as_f64()
                {
                    arm["left_s"] = json!((left - (now - heard).as_secs_f64()).max(0.0));
                }
                arms.push(arm);
            }
            for place in items(&turns["queue"]) {
                let (Some(at), true) = (place["place"].as_u64(), place["person"].is_string())
                else {
                    continue;
                };
                let mut place = place.clone();
                place["arms"] = json!(self.own_names(station, &place["arms"]));
                queue.push((at, station, place));
            }
        }
        arms.sort_by(|one, other| one["arm"].as_str().cmp(&other["arm"].as_str()));
        queue.sort_by_key(|(at, station, _)| (*at, *station));
        let queue: Vec<_> = queue.into_iter().map(|(_, _, place)| place).collect();
        let mut turns = json!({"turn_s": turn_s, "arms": arms, "queue": queue});
        if !you.is_null() {
            turns["you"] = you;
        }
        turns
    }

    fn own_names(&self, station: StationId, names: &Value) -> Vec<Value> {
        let own = |name: &&Value| self.has_alone(station, name.as_str().unwrap_or_default());
        items(names).filter(own).cloned().collect()
    }

    /// A method of classes that several stations answer.
    pub(super) fn of_class(&mut self, call: Call) -> Result<Option<Value>, RpcError> {
        let (what, method) = match call.method.name {
            "turn.list" => (Gathers::Turns, "turn.list"),
            "turn.join" => {
                if let Some(arm) = call.params.get("arm").and_then(Value::as_str) {
                    self.station_of(Some(arm))?;
                }
                (Gathers::Join(call.params.clone()), "turn.list")
            }
            "turn.leave" => (Gathers::Leaves, "turn.leave"),
            "class.get" => (Gathers::Alike, "class.get"),
            "schedule.get" => (Gathers::Alike, "schedule.get"),
            _ => (Gathers::Results, "class.results"),
        };
        if let Some(open) = self.sockets.get_mut(&call.socket) {
            open.turns |= method == "turn.list";
        }
        let gather = self.gathers(&call, what);
        let mut params = Map::new();
        if let Some(group) = call.params.get("group") {
            params.insert("group".to_owned(), group.clone());
        }
        let now = call.now;
        let asks = self.asks(now, call.socket, method, params);
        self.ask_all(&asks, gather);
        self.is_complete(now, gather);
        Ok(None)
    }

    /// What is asked of arms, by the stations that have them: of all at once.
    pub(super) fn by_arms(&mut self, call: &Call) -> Result<Option<Value>, RpcError> {
        let mut stations: BTreeMap<StationId, Vec<String>> = BTreeMap::new();
        let mut beyond = Vec::new();
        let names: Vec<String> = match call.params.get("arms").and_then(Value::as_array) {
            Some(names) => { names.iter() }
                .filter_map(|name| name.as_str().map(str::to_owned))
                .collect(),
            None => self.arms.keys().cloned().collect(),
        };
        let freezes = call.method.name == "class.freeze";
        for name in names {
            match self.station_of(Some(&name)) {
                Ok(at) => stations.entry(at.station).or_default().push(at.arm),
                Err(error) if error.code == RpcError::PARAMS => return Err(error),
                // As a stop, a freeze reaches all that have the name.
                Err(_) => {
                    let at = self.arms.get(&name).map(|place| place.at.keys().copied());
                    for station in at.into_iter().flatten().filter(|_| freezes) {
                        stations.entry(station).or_default().push(name.clone());
                    }
                    beyond.push(name);
                }
            }
        }
        let gather = self.gathers(call, Gathers::ByArms(call.method.name));
        if let Some(gather) = self.gathers.get_mut(&gather) {
            gather.beyond = beyond;
        }
        for (station, arms) in stations {
            let mut params = call.params.clone();
            params.insert("arms".to_owned(), json!(arms));
            let asks = self.asks(call.now, call.socket, call.method.name, params);
            if !self.ask_one(&asks, gather, station)
                && let Some(gather) = self.gathers.get_mut(&gather)
            {
                gather.beyond.extend(arms);
            }
        }
        self.is_complete(call.now, gather);
        Ok(None)
    }

    /// All have done it, or those are named that may not have.
    fn done_by_arms(&self, method: &str, gather: &Gather) -> Result<Value, RpcError> {
        let list = if method == "class.send" {
            "jobs"
        } else {
            "arms"
        };
        let arms_of = |station: &StationId| {
            let arms = self.stations.get(station).map(|(_, arms)| arms);
            let arms = arms.into_iter().flatten().map(String::as_str);
            arms.collect::<Vec<_>>().join(", ")
        };
        let (mut done, mut failed) = (Vec::new(), Vec::new());
        for (of, part) in &gather.parts {
            match part {
                Ok(part) => done.extend(items(&part[list]).cloned()),
                Err(error) => {
                    let arms = of.as_ref().map(arms_of).unwrap_or_default();
                    failed.push(format!("{arms}: {}", error.message));
                }
            }
        }
        let name = |one: &Value| match one {
            Value::String(name) => name.clone(),
            one => one["arm"].as_str().unwrap_or_default().to_owned(),
        };
        done.sort_by_key(name);
        let silent: Vec<_> = gather.left.values().flatten().map(arms_of).collect();
        if !silent.is_empty() {
            failed.push(format!("no answer within 3 s from {}", silent.join(", ")));
        }
        if !gather.beyond.is_empty() {
            failed.push(format!("{} cannot be reached", gather.beyond.join(", ")));
        }
        if failed.is_empty() {
            return Ok(json!({ list: done }));
        }
        let why = format!(
            "{method} is not known to be done everywhere: {}",
            failed.join("; ")
        );
        let kind = if silent.is_empty() {
            ErrorKind::Port
        } else {
            ErrorKind::Timeout
        };
        Err(RpcError::arm(kind, why).with(list, done))
    }

    /// A request of the hub's own for a client.
    fn asks(
        &self,
        now: HostInstant,
        socket: SocketId,
        method: &'static str,
        params: Map<String, Value>,
    ) -> Call {
        let method = Method::named(method).unwrap_or(&magician_station::api::METHODS[0]);
        let id = Some(magician_station::api::MessageId::Number(0));
        Call {
            now,
            socket,
            id,
            method,
            params,
        }
    }

    /// What stations have answered; none where more is asked of them first.
    pub(super) fn class_gathered(
        &mut self,
        now: HostInstant,
        gather: &mut Gather,
    ) -> Option<Result<Value, RpcError>> {
        let what = std::mem::replace(&mut gather.what, Gathers::Turns);
        let ok = |part: &(Option<StationId>, Result<Value, RpcError>)| {
            Some((part.0?, part.1.as_ref().ok()?.clone()))
        };
        let lists: Vec<(StationId, Value)> = gather.parts.iter().filter_map(ok).collect();
        let error = { gather.parts.iter() }.find_map(|(_, part)| part.as_ref().err().cloned());
        if let Gathers::Turns | Gathers::Join(_) | Gathers::Joined = &what {
            for (station, turns) in &lists {
                let ways = self.sockets.get(&gather.socket).map(|open| &open.ways);
                if let Some(Way::Line(line)) = ways.and_then(|ways| ways.get(station)) {
                    let line = *line;
                    self.hears_turns(now, line, turns.clone());
                }
            }
            self.told = now;
        }
        let merged = |hub: &Self| {
            let parts = lists.iter().map(|(station, turns)| (*station, now, turns));
            hub.merged_turns(now, parts.collect())
        };
        Some(match what {
            Gathers::Join(params) => {
                return self.joins(now, gather, params, &lists, merged(self));
            }
            Gathers::Moves(station, params) => {
                if error.is_some() || !gather.left.is_empty() {
                    let why = "the place at another station could not be given up: no other one was taken";
                    return Some(Err(
                        error.unwrap_or_else(|| RpcError::arm(ErrorKind::Timeout, why))
                    ));
                }
                return self.join_there(now, gather, station, params);
            }
            Gathers::Joined => match error {
                Some(error) => Err(error),
                None if lists.is_empty() => {
                    let why =
                        "the station does not answer; whether the turn was asked for is not known";
                    Err(RpcError::arm(ErrorKind::Timeout, why))
                }
                None => Ok(self.known_or(gather.socket, merged(self))),
            },
            Gathers::Leaves => match error {
                Some(error) => Err(error),
                None if !gather.left.is_empty() => {
                    let why = "not all stations have answered within 3 s";
                    Err(RpcError::arm(ErrorKind::Timeout, why))
                }
                None => Ok(Value::Null),
            },
            Gathers::Results => {
                let mut all: Vec<_> = { lists.iter() }
                    .flat_map(|(station, part)| {
                        items(&part["results"]).filter(|one| {
                            self.has_alone(*station, one["arm"].as_str().unwrap_or_default())
                        })
                    })
                    .cloned()
                    .collect();
                let time = |one: &Value| one["time"].as_f64().unwrap_or(0.0);
                all.sort_by(|one, other| time(one).total_cmp(&time(other)));
                match error {
                    Some(error) if lists.is_empty() => Err(error),
                    _ => Ok(json!({ "results": all })),
                }
            }
            Gathers::ByArms(method) => self.done_by_arms(method, gather),
            Gathers::Alike => match (lists.into_iter().next(), error) {
                (Some((_, shown)), _) => Ok(shown),
                (None, Some(error)) => Err(error),
                (None, None) => {
                    let why = "no station of the site answers";
                    Err(RpcError::arm(ErrorKind::Port, why))
                }
            },
            _ => Ok(merged(self)),
        })
    }

    fn known_or(&self, socket: SocketId, turns: Value) -> Value {
        match self.sockets.get(&socket) {
            Some(open) if !open.once => self.known_turns(socket),
            _ => turns,
        }
    }

    /// The stations have said where a person has a turn or a place: it is there at most once after this, too.
    fn joins(
        &mut self,
        now: HostInstant,
        gather: &Gather,
        params: Map<String, Value>,
        lists: &[(StationId, Value)],
        merged: Value,
    ) -> Option<Result<Value, RpcError>> {
        // Whoever has a turn keeps it. Teachers need none.
        let is = |turns: &Value, of: &Value| turns["you"]["person"] == of["person"];
        let person = |turns: &Value| turns["you"]["person"].is_string();
        let persons = || lists.iter().filter(|(_, turns)| person(turns));
        let arm = params.get("arm").and_then(Value::as_str).map(str::to_owned);
        if lists.is_empty() {
            let why = "no station of the site answers";
            return Some(Err(RpcError::arm(ErrorKind::Port, why)));
        }
        let has = persons().any(|(_, turns)| items(&turns["arms"]).any(|arm| is(turns, arm)));
        if has {
            return Some(Ok(merged));
        }
        let waits = |turns: &Value| items(&turns["queue"]).any(|place| is(turns, place));
        let waiting: Vec<_> = { persons() }
            .filter(|(_, turns)| waits(turns))
            .map(|(station, _)| *station)
            .collect();
        let station = match &arm {
            Some(arm) => match self.station_of(Some(arm)) {
                Ok(at) => at.station,
                Err(error) => return Some(Err(error)),
            },
            None => {
                let open = { persons() }.filter_map(|(station, turns)| {
                    let wait = wait(turns)?;
                    Some((waiting.first() != Some(station), wait, *station))
                });
                let best =
                    open.min_by(|one, other| one.0.cmp(&other.0).then(one.1.total_cmp(&other.1)));
                match best {
                    Some((_, _, station)) => station,
                    // The station has the words for it.
                    None => lists[0].0,
                }
            }
        };
        let elsewhere: Vec<_> = { waiting.iter() }.filter(|of| **of != station).collect();
        if elsewhere.is_empty() {
            return self.join_there(now, gather, station, params);
        }
        let call = self.continued(now, gather, "turn.leave", Map::new());
        let next = self.gathers(&call, Gathers::Moves(station, params));
        let asks = self.asks(now, gather.socket, "turn.leave", Map::new());
        for of in elsewhere {
            if !self.ask_one(&asks, next, *of) {
                self.gathers.remove(&next);
                let why =
                    "the place at another station cannot be given up now: no other one was taken";
                let outcome = Err(RpcError::arm(ErrorKind::Port, why));
                self.finish(gather.socket, gather.id.as_ref(), &outcome);
                return None;
            }
        }
        self.is_complete(now, next);
        None
    }

    /// A turn is asked for at one station.
    fn join_there(
        &mut self,
        now: HostInstant,
        gather: &Gather,
        station: StationId,
        params: Map<String, Value>,
    ) -> Option<Result<Value, RpcError>> {
        let call = self.continued(now, gather, "turn.join", Map::new());
        let next = self.gathers(&call, Gathers::Joined);
        let asks = self.asks(now, gather.socket, "turn.join", params);
        self.ask_one(&asks, next, station);
        self.is_complete(now, next);
        None
    }

    /// The same request of a client, which waits on.
    fn continued(
        &mut self,
        now: HostInstant,
        gather: &Gather,
        method: &'static str,
        params: Map<String, Value>,
    ) -> Call {
        if let Some(open) = self.sockets.get_mut(&gather.socket) {
            open.under_way = open.under_way.saturating_sub(1);
        }
        let id = gather.id.clone();
        Call {
            id,
            ..self.asks(now, gather.socket, method, params)
        }
    }
}

/// The items of a list; what is none has none.
fn items(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten().take(MOST)
}

/// How long somebody who comes now waits at a station, s: each who waits gets the arm that is free first. None where the station
/// has no arm for this person.
fn wait(turns: &Value) -> Option<f64> {
    let length = { turns["turn_s"].as_f64() }.filter(|length| *length > 0.0);
    let length = length.unwrap_or(LONG);
    let mut arms: Vec<(&Value, f64)> = items(&turns["arms"])
        .map(|arm| {
            let left = arm["left_s"]
                .as_f64()
                .unwrap_or(length)
                .clamp(0.0, LONG * 24.0);
            let busy = if arm["person"].is_null() { 0.0 } else { left };
            let frozen = if arm["frozen"] == true { length } else { 0.0 };
            (&arm["arm"], busy + frozen)
        })
        .collect();
    let mine: Vec<_> = items(&turns["you"]["arms"]).collect();
    for place in items(&turns["queue"]) {
        let wanted: Vec<_> = items(&place["arms"]).collect();
        let free = { arms.iter_mut() }.filter(|(name, _)| wanted.contains(name));
        if let Some((_, at)) = free.min_by(|one, other| one.1.total_cmp(&other.1)) {
            *at += length;
        }
    }
    let free = arms.iter().filter(|(name, _)| mine.contains(name));
    free.map(|(_, at)| *at).min_by(f64::total_cmp)
}
