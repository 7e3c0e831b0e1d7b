//! The arms of the site, and the stations that have them.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use magician::ErrorKind;
use magician_protocol::{HostInstant, visible};
use magician_station::api::{Method, RpcError};
use serde_json::{Value, json};

use super::gather::{Gather, items};
use super::socket::Socket;
use super::{Hub, keys_where};
use crate::Roster;
use crate::site::{ArmAt, ArmNews, SiteEvent, StationId};

/// Time that an arm that is gone is shown, and named by a stop of all.
pub(super) const GONE: Duration = Duration::from_secs(600);
/// Arms that are gone, at most.
const MOST_GONE: usize = 1000;
/// Age of a state that counts as that of now. A station tells one of each arm every second at least.
const FRESH: Duration = Duration::from_millis(1500);

/// An arm, as far as it is known.
#[derive(Debug, Default)]
pub(super) struct ArmPlace {
    /// The stations that have it: one, but where two have the same name.
    pub(super) at: BTreeMap<StationId, Option<(HostInstant, ArmNews)>>,
    /// The machine that it is at, or was at last, or is expected at; empty if none is known.
    machine: String,
    /// What was listed of it last.
    row: Option<Value>,
    pub(super) gone: Option<HostInstant>,
    /// A teacher has frozen it, as its station told last.
    is_frozen: bool,
    /// It is in the roster: it is named as missing until it comes, however long that takes.
    pub(super) expected: bool,
}

impl ArmPlace {
    /// The station that has it. `None` if there is none, or more than one.
    fn only(&self) -> Option<StationId> {
        let mut at = self.at.keys();
        at.next().filter(|_| at.next().is_none()).copied()
    }

    pub(super) fn machine(&self) -> Option<&str> {
        (!self.machine.is_empty()).then_some(self.machine.as_str())
    }
}

impl Hub {
    /// Something happens on the site. Of [`SiteEvent::Missed`] nothing follows: [`on_site`](Self::on_site) tells what is there.
    pub fn site(&mut self, now: HostInstant, event: SiteEvent) {
        match event {
            SiteEvent::Arrived(at) => self.arrives(now, at),
            SiteEvent::Left(at) => self.leaves(now, &at),
            SiteEvent::News(at, news) => {
                if let Some(place) = self.arms.get_mut(&at.arm)
                    && let Some(known) = place.at.get_mut(&at.station)
                {
                    place.machine.clone_from(&news.machine);
                    *known = Some((now, news));
                }
            }
            SiteEvent::Missed => {}
        }
    }

    /// These arms are on the site, and no others.
    pub fn on_site(&mut self, now: HostInstant, arms: BTreeSet<ArmAt>) {
        let known = self.arms.iter().flat_map(|(arm, place)| {
            let stations = place.at.keys().copied();
            stations.map(move |station| (arm.clone(), station))
        });
        let known = known.map(|(arm, station)| ArmAt { arm, station });
        for gone in known.filter(|at| !arms.contains(at)).collect::<Vec<_>>() {
            self.leaves(now, &gone);
        }
        for at in arms {
            self.arrives(now, at);
        }
    }

    /// These arms are expected on the site: whatever is asked of all names those that are missing.
    pub fn expects(&mut self, roster: &Roster) {
        for (arm, machine) in roster.arms() {
            let place = self.arms.entry(arm.to_owned()).or_default();
            place.expected = true;
            if place.machine.is_empty() {
                place.machine = machine.to_owned();
            }
        }
    }

    fn arrives(&mut self, now: HostInstant, at: ArmAt) {
        let ArmAt { arm, station } = at;
        let slot = self.names.arrives(station, &arm);
        let (_, arms) = self
            .stations
            .entry(station)
            .or_insert((slot, BTreeSet::new()));
        arms.insert(arm.clone());
        let place = self.arms.entry(arm.clone()).or_default();
        place.gone = None;
        place.at.entry(station).or_insert(None);
        let wants = |socket: &Socket| {
            let subscribes = || socket.subscriptions.values().any(|one| one.arm == arm);
            socket.session.is_some() && (socket.wide || subscribes())
        };
        for socket in keys_where(&self.sockets, wants) {
            let _ = self.line_to(now, socket, station);
        }
    }

    fn leaves(&mut self, now: HostInstant, at: &ArmAt) {
        if let Some(place) = self.arms.get_mut(&at.arm) {
            place.at.remove(&at.station);
            if place.at.is_empty() && !place.expected {
                place.gone = Some(now);
            }
        }
        let Some((_, arms)) = self.stations.get_mut(&at.station) else {
            return;
        };
        arms.remove(&at.arm);
        if arms.is_empty() {
            self.stations.remove(&at.station);
            for line in keys_where(&self.lines, |line| line.station == at.station) {
                let why = "its station is not on the site any more";
                self.lose_line(now, line, RpcError::arm(ErrorKind::Port, why));
            }
            self.names.leaves(at.station);
            for socket in self.sockets.values_mut() {
                socket.ways.remove(&at.station);
            }
        }
        let gone = self.arms.values().filter(|place| place.gone.is_some());
        if gone.count() > MOST_GONE {
            self.arms.retain(|_, place| place.gone.is_none());
        }
    }

    /// The arm that is meant, and its station.
    pub(super) fn station_of(&self, arm: Option<&str>) -> Result<ArmAt, RpcError> {
        let known = match arm {
            Some(arm) => self.arms.get_key_value(arm),
            None if self.arms.len() == 1 => self.arms.first_key_value(),
            None => None,
        };
        let Some((arm, place)) = known else {
            let names: Vec<_> = self.arms.keys().map(String::as_str).collect();
            let names = names.join(", ");
            let why = match arm {
                Some(arm) => format!("there is no arm `{}`: the site has {names}", visible(arm)),
                None => format!("`arm` is missing: the site has {names}"),
            };
            return Err(RpcError::param("arm", why));
        };
        let arm = arm.clone();
        if let Some(station) = place.only() {
            return Ok(ArmAt { arm, station });
        }
        let why = if place.at.is_empty() {
            format!("the station of {arm} cannot be reached")
        } else {
            format!("two stations have an arm named {arm}: only a stop reaches both")
        };
        Err(RpcError::arm(ErrorKind::Port, why))
    }

    /// True if an arm is of this station, and of no other: a station has a say on its own arms alone.
    pub(super) fn has_alone(&self, station: StationId, arm: &str) -> bool {
        let place = self.arms.get(arm);
        place.and_then(ArmPlace::only) == Some(station)
    }

    /// Any arm of a station.
    pub(super) fn any_arm(&self, station: StationId) -> Option<String> {
        let (_, arms) = self.stations.get(&station)?;
        arms.first().cloned()
    }

    /// The machine of a station, as far as it has said so.
    pub(super) fn machine_of(&self, station: StationId) -> Option<&str> {
        let mut known = self
            .arms
            .values()
            .filter_map(|place| place.at.get(&station));
        known.find_map(|news| news.as_ref().map(|(_, news)| news.machine.as_str()))
    }

    /// The state of an arm, as its station told it on the site: it tells each change at once, so that this is the state now.
    pub(super) fn state_now(
        &self,
        now: HostInstant,
        at: &ArmAt,
    ) -> Option<Result<Value, RpcError>> {
        let (heard, news) = self.arms.get(&at.arm)?.at.get(&at.station)?.as_ref()?;
        if now - *heard > FRESH {
            return None;
        }
        if news.state.is_null() {
            let why = format!("the line to {} is lost", at.arm);
            return Some(Err(RpcError::arm(ErrorKind::Port, why)));
        }
        let mut state = news.state.clone();
        let slot = self.stations.get(&at.station).map_or(0, |(slot, _)| *slot);
        let ids = Method::named("arm.state").map_or(&[][..], Method::result_ids);
        self.names.rename(slot, &mut state, ids);
        Some(Ok(state))
    }

    /// A station tells of its turns: of them the hub shows which arms are frozen.
    pub(super) fn hears_turns(&mut self, station: StationId, turns: &Value) {
        for turn in items(&turns["arms"]) {
            let arm = turn["arm"].as_str().unwrap_or_default();
            if self.has_alone(station, arm)
                && let Some(place) = self.arms.get_mut(arm)
            {
                place.is_frozen = turn["frozen"] == true;
            }
        }
    }

    /// The arms: as their stations list them, else by what is known otherwise.
    pub(super) fn arms_listed(&mut self, now: HostInstant, gather: &Gather) -> Value {
        for (station, part) in gather.answers() {
            for row in items(&part["arms"]) {
                let name = row["name"].as_str().unwrap_or_default();
                if self.has_alone(station, name)
                    && let Some(place) = self.arms.get_mut(name)
                {
                    place.row = Some(row.clone());
                }
            }
        }
        let answered: BTreeSet<_> = gather.answers().map(|(station, _)| station).collect();
        let rows = self.arms.iter().map(|(name, place)| {
            let row = place.only().and_then(|station| {
                if answered.contains(&station) {
                    return place.row.clone();
                }
                self.row_by_news(now, name, station)
            });
            let mut row = row.unwrap_or_else(|| lost(name, place.row.as_ref()));
            if let Some(machine) = place.machine() {
                row["machine"] = json!(machine);
            }
            if place.is_frozen {
                row["frozen"] = json!(true);
            }
            row
        });
        json!({"arms": rows.collect::<Vec<_>>()})
    }

    /// A row of an arm whose station does not answer this session.
    fn row_by_news(&self, now: HostInstant, name: &str, station: StationId) -> Option<Value> {
        let arm = name.to_owned();
        let (_, news) = self.arms.get(name)?.at.get(&station)?.as_ref()?;
        let state = self.state_now(now, &ArmAt { arm, station });
        let state = state.and_then(Result::ok).unwrap_or_default();
        Some(json!({
            "name": name,
            "port": news.port,
            "virtual": news.is_virtual,
            "link": if state.is_null() { "lost" } else { "up" },
            "holder": state["holder"],
            "waiting": [],
            "job": state["job"],
        }))
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
