//! Turns on a site: pupils take them at the arms of any station. What is known of that the stations know.

use magician::ErrorKind;
use magician_protocol::HostInstant;
use magician_station::api::RpcError;
use serde_json::{Map, Value, json};

use super::requests::Call;
use super::socket::{Gather, Gathers, Wants, Way};
use super::{Hub, LineId, SocketId, TURNS};
use crate::site::{ArmAt, StationId};

/// What a turn without an end is taken for, s, where waits are compared.
const LONG: f64 = 3600.0;
/// Persons and arms that are looked at, at most.
const MOST: usize = 1000;

impl Hub {
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
    pub(super) fn merged_turns(
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

    pub(super) fn own_names(&self, station: StationId, names: &Value) -> Vec<Value> {
        let own = |name: &&Value| self.has_alone(station, name.as_str().unwrap_or_default());
        items(names).filter(own).cloned().collect()
    }

    pub(super) fn known_or(&self, socket: SocketId, turns: Value) -> Value {
        match self.sockets.get(&socket) {
            Some(open) if !open.once => self.known_turns(socket),
            _ => turns,
        }
    }

    /// The stations have said where a person has a turn or a place: it is there at most once after this, too.
    pub(super) fn joins(
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
            return Some(Err(nobody_answers()));
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

    /// The pupil of a client, in small letters.
    pub(super) fn pupil_of(&self, socket: SocketId) -> Option<String> {
        let pupil = self.sockets.get(&socket)?.pupil.as_ref()?;
        Some(pupil["name"].as_str()?.to_lowercase())
    }

    /// One page of a pupil after the other: two that ask in the same moment would both find nothing.
    pub(super) fn asks_alone(&self, socket: SocketId) -> Result<(), RpcError> {
        let Some(pupil) = self.pupil_of(socket) else {
            return Ok(());
        };
        let asks = |gather: &Gather| {
            let asks = matches!(
                gather.what,
                Gathers::Join(_) | Gathers::Moves(..) | Gathers::Joined | Gathers::Acquire(..)
            );
            asks && self.pupil_of(gather.socket).as_ref() == Some(&pupil)
        };
        if self.gathers.values().any(asks) {
            let why = "a turn is being asked for at this moment: try again";
            return Err(RpcError::new(RpcError::BUSY, why));
        }
        Ok(())
    }

    /// A pupil takes an arm without the queue: first the stations are asked whether the pupil has another one.
    pub(super) fn acquires(&mut self, mut call: Call) -> Result<Option<Value>, RpcError> {
        let at = self.station_of(call.params.get("arm").and_then(Value::as_str))?;
        self.asks_alone(call.socket)?;
        call.params.insert("arm".to_owned(), json!(at.arm));
        let what = Gathers::Acquire(at, call.params.clone());
        let gather = self.gathers(&call, what);
        let asks = self.asks(call.now, call.socket, "turn.list", Map::new());
        self.ask_all(&asks, gather);
        self.is_complete(call.now, gather);
        Ok(None)
    }

    /// The stations have said where a pupil has a turn or a place, who takes an arm. About the arms of one station that decides.
    pub(super) fn acquired(
        &mut self,
        now: HostInstant,
        gather: &Gather,
        at: &ArmAt,
        params: Map<String, Value>,
        lists: &[(StationId, Value)],
    ) -> Option<Result<Value, RpcError>> {
        let others = { lists.iter() }.filter(|(station, _)| *station != at.station);
        let mut queues = Vec::new();
        for (station, turns) in others {
            let person = turns["you"]["person"].as_str();
            let is = |one: &&Value| person.is_some() && one["person"].as_str() == person;
            if let Some(arm) = items(&turns["arms"]).find(is) {
                let arm = arm["arm"].as_str().unwrap_or_default();
                let arm = magician_protocol::visible(arm);
                let why = format!("you have your turn at {arm}: give it back first");
                return Some(Err(RpcError::new(RpcError::LEASE, why)));
            }
            if items(&turns["queue"]).any(|place| is(&place)) {
                queues.push(*station);
            }
        }
        let call = self.continued(now, gather, "lease.acquire", params);
        match self.pass_on(&call, at, Wants::Acquire(queues)) {
            Ok(_) => None,
            Err(error) => {
                self.respond(gather.socket, gather.id.as_ref(), &Err(error));
                None
            }
        }
    }

    /// The places of a pupil in the queues of these stations are given up.
    pub(super) fn leave_queues(&mut self, socket: SocketId, stations: &[StationId]) {
        let ways = self.sockets.get(&socket).map(|open| &open.ways);
        let line = |station| match ways?.get(station)? {
            Way::Line(line) => Some(*line),
            _ => None,
        };
        let lines: Vec<_> = stations.iter().filter_map(line).collect();
        for line in lines {
            self.ask_line(line, "turn.leave", Map::new(), Wants::Nothing);
        }
    }

    /// A turn is asked for at one station.
    pub(super) fn join_there(
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
}

pub(super) fn nobody_answers() -> RpcError {
    RpcError::arm(ErrorKind::Port, "no station of the site answers")
}

/// The items of a list; what is none has none.
pub(super) fn items(value: &Value) -> impl Iterator<Item = &Value> {
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
