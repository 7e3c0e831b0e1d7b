//! Class and schedule over all stations of a site.
//!
//! Pupils, turns and codes belong to the stations. The hub distributes class, schedule and roster
//! to all of them, merges what they reply, and reports stations that differ. A change is made in
//! rounds: read the class of all stations, write the merged one, then make all expect the arms
//! that are present.

use std::collections::{BTreeMap, BTreeSet};

use magician::ErrorKind;
use magician_protocol::{HostInstant, visible};
use magician_station::api::RpcError;
use magician_station::class::{ClassError, ClassFile, Schedule};
use serde_json::{Value, json};

use super::Hub;
use super::arms::ArmEntry;
use super::gather::{AddressedArms, Gather, GatherId, GatherPurpose, items};
use super::requests::{Call, Handled};
use crate::Roster;
use crate::site::StationId;

/// Most machines named in one refusal, to keep the sentence readable.
const MAX_NAMED_MACHINES: usize = 20;

impl Hub {
    /// Error for a method that only the arm's own station offers.
    pub(super) fn station_only_error(&self, method: &str, arm: Option<&str>) -> RpcError {
        let (page, machines) = self.describe_page(arm);
        let why = format!("{method} is not for a hub: it is done {page}");
        RpcError::arm(ErrorKind::Unsupported, why).with("machines", machines)
    }

    /// Describes where to find the page of the station with this arm (of any station if `None`),
    /// and lists the machines.
    pub(super) fn describe_page(&self, arm: Option<&str>) -> (String, Vec<String>) {
        let addressed = |(name, _): &(&String, _)| arm.is_none_or(|arm| arm == name.as_str());
        let places = self.arms.iter().filter(addressed);
        let machines: BTreeSet<_> = places.filter_map(|(_, entry)| entry.machine()).collect();
        let machines = machines.into_iter().take(MAX_NAMED_MACHINES);
        let machines: Vec<_> = machines.map(|name| visible(name).to_string()).collect();
        let mut page = "at the page of the computer that has the arm".to_owned();
        if !machines.is_empty() {
            page = format!("{page}: {}", machines.join(", "));
        }
        (page, machines)
    }

    /// Sends a method that takes a list of arms to the stations of these arms, all at the same
    /// time.
    pub(super) fn call_by_arms(&mut self, call: Call) -> Handled {
        let mut addressed = AddressedArms::default();
        let names: Vec<String> = match call.params.get("arms") {
            Some(names) => { items(names) }
                .filter_map(|name| name.as_str().map(str::to_owned))
                .collect(),
            None => self.arms.keys().cloned().collect(),
        };
        let method = call.method.name;
        for name in names {
            match self.station_of(Some(&name)) {
                Ok(at) => addressed.at.entry(at.station).or_default().push(at.arm),
                Err(error) if error.code == RpcError::PARAMS => return Err(error),
                Err(_) => {
                    // Like a stop, a freeze reaches every arm with this name.
                    if method == "class.freeze" {
                        for (station, arms) in self.addressed(Some(&name)).at {
                            addressed.at.entry(station).or_default().extend(arms);
                        }
                    }
                    addressed.unreachable.insert(name);
                }
            }
        }
        let list = match method {
            "class.send" => "jobs",
            _ => "arms",
        };
        let params = call.params.clone();
        self.gather(call, GatherPurpose::ByArms(list), method, params, addressed)
    }

    /// Checks a schedule and sends it to all stations.
    pub(super) fn set_schedule(&mut self, call: Call) -> Handled {
        let text = call.params.get("text").and_then(Value::as_str);
        let schedule = Schedule::parse(text.unwrap_or_default());
        let checked = schedule.and_then(|schedule| {
            schedule.check_arms("the site", |arm| self.arms.contains_key(arm))
        });
        checked.map_err(|error| param_error("text", &error))?;
        let mut params = call.params.clone();
        params.insert("elsewhere".to_owned(), json!(true));
        let purpose = GatherPurpose::Everywhere(Vec::new());
        self.gather(call, purpose, "schedule.set", params, self.addressed(None))
    }

    /// Builds the class file for all stations. Empty text ends the class.
    ///
    /// Also returns the pupils whose code in the given file was replaced by their existing code.
    /// New codes are generated here and not at the stations, so that all stations have the same
    /// ones.
    pub(super) fn class_to_set(&self, gather: &Gather) -> Result<(String, Vec<String>), RpcError> {
        let params = &gather.call.params;
        let known = gather.answers();
        let known = known.filter_map(|(_, class)| ClassFile::parse(class["text"].as_str()?).ok());
        let known: Vec<_> = known.collect();
        let texts = |name: &str| -> Option<Vec<&str>> {
            let texts = params.get(name)?.as_array()?;
            Some(texts.iter().filter_map(Value::as_str).collect())
        };
        let text = params.get("text").and_then(Value::as_str);
        let (param, read) = match (text, texts("names")) {
            (None, Some(names)) => {
                let arms = texts("arms").unwrap_or_default();
                let offset = params.get("offset").and_then(Value::as_str);
                let turn_s = params.get("turn_s").and_then(Value::as_u64);
                let turn_s = turn_s.and_then(|turn_s| u32::try_from(turn_s).ok());
                let of_names = ClassFile::of_names(&names, &arms, turn_s, offset, known.first());
                ("names", of_names)
            }
            (text, _) if text.unwrap_or_default().trim().is_empty() => {
                return Ok((String::new(), Vec::new()));
            }
            (text, _) => ("text", ClassFile::parse(text.unwrap_or_default())),
        };
        let mut file = read.map_err(|error| param_error(param, &error))?;
        let arms = file.check_arms("the site", |arm| self.arms.contains_key(arm));
        arms.map_err(|error| param_error(param, &error))?;
        let mut before = ClassFile::default();
        for pupil in known.iter().flat_map(|known| &known.pupil) {
            if !before.pupil.iter().any(|one| one.name == pupil.name) {
                before.pupil.push(pupil.clone());
            }
        }
        if let Some(known) = known.first() {
            before.class.pin.clone_from(&known.class.pin);
        }
        let uses_own = params.get("use_codes") == Some(&json!(true));
        let codes_kept = file.keep_codes(&before, uses_own);
        file.make_codes(self.random);
        Ok((file.to_text(), codes_kept))
    }

    /// Sends the class to all stations.
    pub(super) fn set_class(
        &mut self,
        now: HostInstant,
        id: GatherId,
        call: Call,
        (text, codes_kept): (String, Vec<String>),
    ) {
        let params = [
            ("text", json!(text)),
            ("elsewhere", json!(true)),
            ("use_codes", json!(true)),
        ];
        let params = params.map(|(name, value)| (name.to_owned(), value));
        let call = Call { now, ..call };
        let purpose = GatherPurpose::Everywhere(codes_kept);
        let addressed = self.addressed(None);
        self.send_round(
            id,
            call,
            purpose,
            "class.set",
            params.into_iter().collect(),
            addressed,
        );
    }

    /// Builds the reply after a class, schedule or roster was sent to all stations. Unless all of
    /// them have accepted it, returns the error that names the others.
    pub(super) fn distribution_answer(
        &mut self,
        gather: &Gather,
        codes_kept: &[String],
    ) -> Result<Value, RpcError> {
        if let Some(error) = gather.incomplete_error() {
            return Err(error);
        }
        let (_, shown) = gather.answers().next().ok_or_else(no_answer_error)?;
        let mut shown = without_turns(shown);
        // Empty at the stations, because the request makes them use the codes of the file.
        if shown.get("codes_kept").is_some() {
            shown["codes_kept"] = json!(codes_kept);
        }
        if gather.call.method.name == "site.expect" {
            for entry in self.arms.values_mut() {
                entry.expected = false;
            }
            self.expect_roster(&parse_roster(&shown));
            // Forget arms that were known only because the old roster listed them.
            let is_known = |entry: &ArmEntry| {
                entry.expected || !entry.at.is_empty() || entry.departed_at.is_some()
            };
            self.arms.retain(|_, entry| is_known(entry));
        }
        Ok(shown)
    }

    /// Adds the arms that are present to the roster of all stations. Last round of setting a class;
    /// its reply is the class.
    pub(super) fn expect_present(
        &mut self,
        now: HostInstant,
        id: GatherId,
        call: Call,
        class: Value,
    ) {
        let mut roster = Roster::default();
        for (name, entry) in &self.arms {
            if entry.expected || !entry.at.is_empty() {
                roster.expect(name.clone(), entry.machine().unwrap_or_default());
            }
        }
        self.expect_roster(&roster);
        let params = roster.to_value().as_object().cloned().unwrap_or_default();
        let (call, addressed) = (Call { now, ..call }, self.addressed(None));
        self.send_round(
            id,
            call,
            GatherPurpose::Expected(class),
            "site.expect",
            params,
            addressed,
        );
    }

    /// Merges the rosters of all stations. `missing` lists the arms whose stations did not reply.
    pub(super) fn roster(&mut self, gather: &Gather) -> Value {
        let mut roster = Roster::default();
        for (_, part) in gather.answers() {
            roster.add(&parse_roster(part));
        }
        self.expect_roster(&roster);
        with_missing(roster.to_value(), gather)
    }

    /// Merges the results of all pupils, oldest first. `missing` lists the arms whose stations did
    /// not reply.
    pub(super) fn results(&self, gather: &Gather) -> Result<Value, RpcError> {
        let of = |(station, part): (StationId, &Value)| -> Vec<Value> {
            let own =
                |one: &&Value| self.is_sole_owner(station, one["arm"].as_str().unwrap_or_default());
            items(&part["results"]).filter(own).cloned().collect()
        };
        let mut all: Vec<_> = gather.answers().flat_map(of).collect();
        let time = |one: &Value| one["time"].as_f64().unwrap_or(0.0);
        all.sort_by(|one, other| time(one).total_cmp(&time(other)));
        match gather.error() {
            Some(error) if gather.answers().next().is_none() => Err(error),
            _ => Ok(with_missing(json!({ "results": all }), gather)),
        }
    }

    /// Returns the class or schedule that most stations have. An empty one counts only if no
    /// station has another.
    ///
    /// `differ` lists the stations with another one or none, by their arms; `missing` the arms
    /// whose stations did not reply.
    pub(super) fn majority(&self, gather: &Gather) -> Result<Value, RpcError> {
        let text = |answer: &Value| {
            let text = answer.get("text").unwrap_or(answer).clone();
            let is_blank = text.as_str().is_some_and(|text| text.trim().is_empty());
            if is_blank { Value::Null } else { text }
        };
        let texts: Vec<_> = { gather.answers() }
            .map(|(station, answer)| (station, text(answer), answer))
            .collect();
        let weight = |most: &Value| {
            let like = texts.iter().filter(|(_, text, _)| text == most).count();
            (!most.is_null(), like)
        };
        // `max_by_key` returns the last maximum: reversed, so that the first station wins a tie.
        let most = texts.iter().rev().max_by_key(|(_, text, _)| weight(text));
        let Some((_, most, shown)) = most else {
            return Err(gather.error().unwrap_or_else(no_answer_error));
        };
        let others = texts.iter().filter(|(_, text, _)| text != most);
        // Keyed by arms: people know those, and not the ids of stations.
        let differ: BTreeMap<_, _> = others
            .map(|(station, text, _)| {
                let (arms, machine) = (gather.arms_at(*station), self.machine_of(*station));
                let shown = json!({"arms": arms, "machine": machine, "none": text.is_null()});
                ((arms, *station), shown)
            })
            .collect();
        let mut shown = without_turns(shown);
        if !differ.is_empty() {
            shown["differ"] = differ.into_values().collect();
        }
        Ok(with_missing(shown, gather))
    }
}

/// Parses the roster in a reply. A malformed one counts as empty.
fn parse_roster(answer: &Value) -> Roster {
    let arms = answer["arms"].as_array();
    let roster = arms.map(|arms| Roster::of(arms));
    roster.and_then(Result::ok).unwrap_or_default()
}

/// Removes from a class the state of its pupils at one station, because they may be signed in at
/// another.
fn without_turns(shown: &Value) -> Value {
    let mut shown = shown.clone();
    let pupils = shown.get_mut("pupils").and_then(Value::as_array_mut);
    for pupil in pupils.into_iter().flatten() {
        for known in ["here", "place", "arm"] {
            pupil[known] = Value::Null;
        }
    }
    shown
}

/// Adds `missing`: the arms of stations that did not reply or replied with an error.
fn with_missing(mut shown: Value, gather: &Gather) -> Value {
    let refused = gather.parts.iter().filter(|(_, part)| part.is_err());
    let refused = refused.flat_map(|(station, _)| gather.arms_at(*station).iter().cloned());
    let missing: BTreeSet<_> = gather.missing().into_iter().chain(refused).collect();
    if !missing.is_empty() {
        shown["missing"] = json!(missing);
    }
    shown
}

fn no_answer_error() -> RpcError {
    RpcError::arm(ErrorKind::Port, "no station of the site answers")
}

fn param_error(param: &str, error: &ClassError) -> RpcError {
    RpcError::param(param, visible(&error.0).to_string())
}
