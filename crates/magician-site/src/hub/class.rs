//! What a class asks of several stations at once, and what they answer together. Pupils, turns and codes are the stations' own.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

use magician::ErrorKind;
use magician_protocol::{HostInstant, visible};
use magician_station::api::{Method, RpcError};
use magician_station::class::{ClassError, ClassFile, Schedule};
use serde_json::{Map, Value, json};

use super::requests::Call;
use super::socket::{Gather, GatherId, Gathers};
use super::{ArmPlace, Hub, HubAct, RequestId, SocketId};
use crate::message::EXPECT;
use crate::roster::Roster;
use crate::site::{ArmAt, StationId};

/// Items of a list of a station that are looked at, at most.
const MOST: usize = 1000;
/// Machines that a refusal names, at most.
const MACHINES: usize = 20;

impl Hub {
    /// The refusal of what is the arm's station's to do.
    pub(super) fn at_station(&self, method: &str, arm: Option<&str>) -> RpcError {
        let why = format!(
            "{method} is not for a hub: it is done {}",
            self.page_of(arm)
        );
        RpcError::arm(ErrorKind::Unsupported, why)
    }

    /// Where the page of an arm's own computer is, or of any arm's, in words.
    pub(super) fn page_of(&self, arm: Option<&str>) -> String {
        let known = self.arms.iter();
        let meant = known.filter(|(name, _)| arm.is_none_or(|arm| arm == name.as_str()));
        let news = meant.flat_map(|(_, place)| place.at.values().flatten());
        let machines: BTreeSet<_> = news
            .map(|(_, news)| visible(&news.machine).to_string())
            .collect();
        let machines: Vec<_> = machines.into_iter().take(MACHINES).collect();
        let of = "at the page of the computer that has the arm";
        if machines.is_empty() {
            return of.to_owned();
        }
        format!("{of}: {}", machines.join(", "))
    }

    /// A method of classes that several stations answer.
    pub(super) fn of_class(&mut self, call: Call) -> Result<Option<Value>, RpcError> {
        let (what, method) = match call.method.name {
            "class.get" => (Gathers::Alike, "class.get"),
            "class.set" => (Gathers::Class(call.params.clone()), "class.get"),
            "schedule.get" => (Gathers::Alike, "schedule.get"),
            _ => (Gathers::Results, "class.results"),
        };
        let gather = self.gathers(&call, what);
        let now = call.now;
        let asks = self.asks(now, call.socket, method, Map::new());
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
    pub(super) fn done_by_arms(&self, method: &str, gather: &Gather) -> Result<Value, RpcError> {
        let list = if method == "class.send" {
            "jobs"
        } else {
            "arms"
        };
        let parts = gather
            .parts
            .iter()
            .filter_map(|(_, part)| part.as_ref().ok());
        let mut done: Vec<_> = parts.flat_map(|part| items(&part[list]).cloned()).collect();
        done.sort_by_key(|one| match one {
            Value::String(name) => name.clone(),
            one => one["arm"].as_str().unwrap_or_default().to_owned(),
        });
        match self.undone(gather) {
            None => Ok(json!({ list: done })),
            Some((kind, which)) => {
                let error = RpcError::arm(kind, not_everywhere(method, &which));
                let missing = self.missing(gather);
                Err(error.with(list, done).with("missing", missing))
            }
        }
    }

    /// All stations get the schedule.
    pub(super) fn set_schedule(&mut self, mut call: Call) -> Result<Option<Value>, RpcError> {
        let text = call.params.get("text").and_then(Value::as_str);
        let schedule = Schedule::parse(text.unwrap_or_default());
        let checked = schedule.and_then(|schedule| {
            schedule.check_arms("the site", |arm| self.arms.contains_key(arm))
        });
        checked.map_err(|error| wrong("text", &error))?;
        call.params.insert("elsewhere".to_owned(), json!(true));
        let gather = self.gathers(
            &call,
            Gathers::Everywhere {
                method: "schedule.set",
                codes_kept: Vec::new(),
            },
        );
        let stations = self.stations.keys().copied().collect();
        self.set_everywhere(&call, gather, stations);
        Ok(None)
    }

    /// Stations are asked to take something, and no one is left out without a word.
    fn set_everywhere(&mut self, asks: &Call, gather: GatherId, stations: Vec<StationId>) {
        let gone = |(name, place): (&String, &ArmPlace)| place.at.is_empty().then(|| name.clone());
        let mut beyond: Vec<_> = self.arms.iter().filter_map(gone).collect();
        for station in stations {
            if !self.ask_one(asks, gather, station) {
                let arms = self.stations.get(&station).map(|(_, arms)| arms.clone());
                beyond.extend(arms.into_iter().flatten());
            }
        }
        if let Some(gather) = self.gathers.get_mut(&gather) {
            gather.beyond = beyond;
        }
        self.is_complete(asks.now, gather);
    }

    /// The class that stations have is known: another one is made of it, with the same codes everywhere, and they get it.
    fn class_known(
        &mut self,
        now: HostInstant,
        gather: &Gather,
        params: &Map<String, Value>,
        known: &[(StationId, Value)],
    ) -> Result<(), RpcError> {
        let files = known.iter();
        let files = files.filter_map(|(_, class)| ClassFile::parse(class["text"].as_str()?).ok());
        let files: Vec<_> = files.collect();
        let stations = self.stations.keys().copied().collect();
        let mut codes_kept = Vec::new();
        let file = self.class_to_set(params, &files, &mut codes_kept)?;
        let text = file.map_or_else(String::new, |mut file| {
            file.make_codes(self.random);
            file.to_text()
        });
        // The codes are made or kept here, alike for all stations.
        let params = [
            ("text", json!(text)),
            ("elsewhere", json!(true)),
            ("use_codes", json!(true)),
        ];
        let params = params.map(|(name, value)| (name.to_owned(), value));
        let call = self.continued(now, gather, "class.set", params.into_iter().collect());
        let method = "class.set";
        let what = Gathers::Everywhere { method, codes_kept };
        let next = self.gathers(&call, what);
        let asks = self.asks(now, gather.socket, "class.set", call.params);
        self.set_everywhere(&asks, next, stations);
        Ok(())
    }

    /// The class that is given, none where it ends; pupils have the codes that a station knows.
    fn class_to_set(
        &self,
        params: &Map<String, Value>,
        known: &[ClassFile],
        codes_kept: &mut Vec<String>,
    ) -> Result<Option<ClassFile>, RpcError> {
        let texts = |name: &str| -> Option<Vec<&str>> {
            let texts = params.get(name)?.as_array()?;
            Some(texts.iter().filter_map(Value::as_str).collect())
        };
        let (param, read) = match (params.get("text").and_then(Value::as_str), texts("names")) {
            (None, Some(names)) => {
                let arms = texts("arms").unwrap_or_default();
                let offset = params.get("offset").and_then(Value::as_str);
                let turn_s = params.get("turn_s").and_then(Value::as_u64);
                let turn_s = turn_s.and_then(|turn_s| u32::try_from(turn_s).ok());
                (
                    "names",
                    ClassFile::of_names(&names, &arms, turn_s, offset, known.first()),
                )
            }
            (text, _) if text.unwrap_or_default().trim().is_empty() => return Ok(None),
            (text, _) => ("text", ClassFile::parse(text.unwrap_or_default())),
        };
        let mut file = read.map_err(|error| wrong(param, &error))?;
        let arms = file.check_arms("the site", |arm| self.arms.contains_key(arm));
        arms.map_err(|error| wrong(param, &error))?;
        let uses_own = params.get("use_codes") == Some(&json!(true));
        let mut before = ClassFile::default();
        for pupil in known.iter().flat_map(|known| &known.pupil) {
            if !before.pupil.iter().any(|one| one.name == pupil.name) {
                before.pupil.push(pupil.clone());
            }
        }
        if let Some(known) = known.first() {
            before.class.pin.clone_from(&known.class.pin);
        }
        *codes_kept = file.keep_codes(&before, uses_own);
        Ok(Some(file))
    }

    /// A request of the hub's own for a client.
    pub(super) fn asks(
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

    /// All stations are told to expect the arms that are there, beside those that are expected already. Nobody waits for it.
    fn expect_present(&mut self, socket: SocketId) {
        let mut roster = Roster::default();
        for (name, place) in &self.arms {
            let mut news = place.at.values().flatten();
            let machine = news.next().map_or("", |(_, news)| &news.machine);
            if place.expected || !place.at.is_empty() {
                roster.expect(name.clone(), machine);
            }
        }
        let params: Value = serde_json::from_str(&roster.to_text()).unwrap_or_default();
        let text = json!({"jsonrpc": "2.0", "id": 0, "method": EXPECT, "params": params});
        let token = { self.sockets.get(&socket) }.and_then(|open| open.token.clone());
        let stations = self.stations.iter().filter_map(|(station, (_, arms))| {
            let (arm, station) = (arms.first()?.clone(), *station);
            Some(ArmAt { arm, station })
        });
        for at in stations.collect::<Vec<_>>() {
            let request = RequestId(self.next_id());
            self.acts.push_back(HubAct::Call {
                request,
                socket,
                at,
                token: token.clone(),
                text: text.to_string(),
                ends: false,
            });
        }
        self.expects(&roster);
    }

    /// What stations have answered; none where more is asked of them first.
    pub(super) fn class_gathered(
        &mut self,
        now: HostInstant,
        gather: &mut Gather,
    ) -> Option<Result<Value, RpcError>> {
        let what = std::mem::replace(&mut gather.what, Gathers::Arms);
        let ok = |part: &(Option<StationId>, Result<Value, RpcError>)| {
            Some((part.0?, part.1.as_ref().ok()?.clone()))
        };
        let lists: Vec<(StationId, Value)> = gather.parts.iter().filter_map(ok).collect();
        let error = { gather.parts.iter() }.find_map(|(_, part)| part.as_ref().err().cloned());
        Some(match what {
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
            Gathers::Class(params) => match self.class_known(now, gather, &params, &lists) {
                Ok(()) => return None,
                Err(error) => Err(error),
            },
            Gathers::Everywhere { method, codes_kept } => {
                match (self.undone(gather), lists.into_iter().next()) {
                    (None, Some((_, mut shown))) => {
                        // The stations were given codes that they had to take.
                        if shown.get("codes_kept").is_some() {
                            shown["codes_kept"] = json!(codes_kept);
                        }
                        if method == "class.set" {
                            self.expect_present(gather.socket);
                        }
                        Ok(shown)
                    }
                    (None, None) => Err(nobody_answers()),
                    (Some((kind, which)), _) => {
                        let error = RpcError::arm(kind, not_everywhere(method, &which));
                        Err(error.with("missing", self.missing(gather)))
                    }
                }
            }
            Gathers::Alike => match (self.alike(gather, &lists), error) {
                (Some(shown), _) => Ok(shown),
                (None, Some(error)) => Err(error),
                (None, None) => Err(nobody_answers()),
            },
            Gathers::Arms | Gathers::Sessions | Gathers::Stops => return None,
        })
    }

    /// The class or schedule that most of the stations with one have, with the arms of those that have another or none (`differ`)
    /// and of those that do not answer (`missing`), where there are such.
    fn alike(&self, gather: &mut Gather, lists: &[(StationId, Value)]) -> Option<Value> {
        let text = |answer: &Value| {
            let text = answer.get("text").unwrap_or(answer).clone();
            let is_blank = text.as_str().is_some_and(|text| text.trim().is_empty());
            if is_blank { Value::Null } else { text }
        };
        let texts: Vec<_> = lists.iter().map(|(_, answer)| text(answer)).collect();
        let weight = |at: usize| {
            let like = texts.iter().filter(|other| **other == texts[at]).count();
            (!texts[at].is_null(), like, Reverse(at))
        };
        let most = (0..lists.len()).max_by_key(|at| weight(*at))?;
        let mut shown = lists[most].1.clone();
        let arms_of = |station: &StationId| {
            let known = self.stations.get(station);
            known.map(|(_, arms)| arms.clone()).unwrap_or_default()
        };
        let others = { lists.iter().zip(&texts) }.filter(|(_, text)| **text != texts[most]);
        // By their arms: numbers of stations say nothing to a person.
        let differ: BTreeMap<_, _> = others
            .map(|((station, _), text)| {
                let (arms, machine) = (arms_of(station), self.machine_of(*station));
                let shown = json!({"arms": arms, "machine": machine, "none": text.is_null()});
                ((arms, *station), shown)
            })
            .collect();
        let differ: Vec<_> = differ.into_values().collect();
        let gone = { self.arms.iter() }.filter(|(_, place)| place.at.is_empty());
        gather.beyond.extend(gone.map(|(name, _)| name.clone()));
        let refused = gather.parts.iter().filter(|(_, part)| part.is_err());
        let refused = refused.filter_map(|(station, _)| station.as_ref());
        gather.beyond.extend(refused.flat_map(arms_of));
        for (member, value) in [
            ("differ", json!(differ)),
            ("missing", json!(self.missing(gather))),
        ] {
            if value != json!([]) {
                shown[member] = value;
            }
        }
        Some(shown)
    }

    /// The machine of a station, as far as it has said so.
    fn machine_of(&self, station: StationId) -> Option<&str> {
        let mut known = self
            .arms
            .values()
            .filter_map(|place| place.at.get(&station));
        known.find_map(|news| news.as_ref().map(|(_, news)| news.machine.as_str()))
    }

    /// The same request of a client, which waits on.
    pub(super) fn continued(
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

fn nobody_answers() -> RpcError {
    RpcError::arm(ErrorKind::Port, "no station of the site answers")
}

/// The items of a list; what is none has none.
fn items(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten().take(MOST)
}

fn wrong(param: &str, error: &ClassError) -> RpcError {
    RpcError::param(param, visible(&error.0).to_string())
}

fn not_everywhere(method: &str, which: &str) -> String {
    format!("{method} is not known to be done everywhere: {which}")
}
