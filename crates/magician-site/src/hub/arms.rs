//! Arms of the site, and the stations that own them.

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
use crate::site::{ArmAt, ArmReport, SiteEvent, StationId};

/// Time for which a departed arm is still listed, and reported as unreachable by a stop of all
/// arms. A choice: long enough that a station that restarts or a cable that is plugged in again
/// keeps its place in a lesson.
pub(super) const DEPARTED_LISTED_TIME: Duration = Duration::from_secs(600);
/// Most departed arms that are kept. Names of arms are not authenticated, so their number has to be
/// bounded; above it all of them are dropped.
const MAX_DEPARTED: usize = 1000;
/// Largest age of a state that counts as current. A station publishes one at least every second;
/// the rest is for delays of the network.
const MAX_STATE_AGE: Duration = Duration::from_millis(1500);

/// Known facts about one arm name.
#[derive(Debug, Default)]
pub(super) struct ArmEntry {
    /// Stations that own the arm, each with its last report. More than one if stations share a
    /// name.
    pub(super) at: BTreeMap<StationId, Option<(HostInstant, ArmReport)>>,
    /// Machine that has the arm, had it last, or is expected to have it. Empty if unknown.
    machine: String,
    /// Last row of `arm.list` for this arm from its station.
    row: Option<Value>,
    pub(super) departed_at: Option<HostInstant>,
    /// True if a teacher froze the arm, as of its station's last report.
    is_frozen: bool,
    /// True if the roster lists the arm: it is reported as missing until it appears, however long
    /// that takes.
    pub(super) expected: bool,
}

impl ArmEntry {
    /// The one station that owns the arm. `None` if there is no station, or more than one.
    fn sole_station(&self) -> Option<StationId> {
        let mut at = self.at.keys();
        at.next().filter(|_| at.next().is_none()).copied()
    }

    pub(super) fn machine(&self) -> Option<&str> {
        (!self.machine.is_empty()).then_some(self.machine.as_str())
    }
}

impl Hub {
    /// Handles an event on the site. [`SiteEvent::Missed`] has no effect: call
    /// [`set_present_arms`](Self::set_present_arms) with the present arms instead.
    pub fn site(&mut self, now: HostInstant, event: SiteEvent) {
        match event {
            SiteEvent::Arrived(at) => self.arm_arrived(now, at),
            SiteEvent::Left(at) => self.arm_left(now, &at),
            SiteEvent::Report(at, report) => {
                if let Some(entry) = self.arms.get_mut(&at.arm)
                    && let Some(known) = entry.at.get_mut(&at.station)
                {
                    entry.machine.clone_from(&report.machine);
                    *known = Some((now, report));
                }
            }
            SiteEvent::Missed => {}
        }
    }

    /// Replaces the set of present arms, after events were lost.
    pub fn set_present_arms(&mut self, now: HostInstant, arms: BTreeSet<ArmAt>) {
        let known = self.arms.iter().flat_map(|(arm, entry)| {
            let stations = entry.at.keys().copied();
            stations.map(move |station| (arm.clone(), station))
        });
        let known = known.map(|(arm, station)| ArmAt { arm, station });
        for gone in known.filter(|at| !arms.contains(at)).collect::<Vec<_>>() {
            self.arm_left(now, &gone);
        }
        for at in arms {
            self.arm_arrived(now, at);
        }
    }

    /// Adds the arms of a roster as expected. Until they appear, requests about all arms report
    /// them as missing.
    pub fn expect_roster(&mut self, roster: &Roster) {
        for (arm, machine) in roster.arms() {
            let entry = self.arms.entry(arm.to_owned()).or_default();
            entry.expected = true;
            if entry.machine.is_empty() {
                entry.machine = machine.to_owned();
            }
        }
    }

    fn arm_arrived(&mut self, now: HostInstant, at: ArmAt) {
        let ArmAt { arm, station } = at;
        let slot = self.names.assign_slot(station, &arm);
        let (_, arms) = self
            .stations
            .entry(station)
            .or_insert((slot, BTreeSet::new()));
        arms.insert(arm.clone());
        let entry = self.arms.entry(arm.clone()).or_default();
        entry.departed_at = None;
        entry.at.entry(station).or_insert(None);
        let is_interested = |socket: &Socket| {
            let subscribes = || socket.subscriptions.values().any(|one| one.arm == arm);
            socket.session.is_some() && (socket.lists_all_arms || subscribes())
        };
        for socket in keys_where(&self.sockets, is_interested) {
            let _ = self.line_to(now, socket, station);
        }
    }

    fn arm_left(&mut self, now: HostInstant, at: &ArmAt) {
        if let Some(entry) = self.arms.get_mut(&at.arm) {
            entry.at.remove(&at.station);
            if entry.at.is_empty() && !entry.expected {
                entry.departed_at = Some(now);
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
            self.names.free_slot(at.station);
            for socket in self.sockets.values_mut() {
                socket.routes.remove(&at.station);
            }
        }
        let gone = self
            .arms
            .values()
            .filter(|entry| entry.departed_at.is_some());
        if gone.count() > MAX_DEPARTED {
            self.arms.retain(|_, entry| entry.departed_at.is_none());
        }
    }

    /// Resolves an arm name to its station. `None` means the only arm of the site.
    pub(super) fn station_of(&self, arm: Option<&str>) -> Result<ArmAt, RpcError> {
        let known = match arm {
            Some(arm) => self.arms.get_key_value(arm),
            None if self.arms.len() == 1 => self.arms.first_key_value(),
            None => None,
        };
        let Some((arm, entry)) = known else {
            let names: Vec<_> = self.arms.keys().map(String::as_str).collect();
            let names = names.join(", ");
            let why = match arm {
                Some(arm) => format!("there is no arm `{}`: the site has {names}", visible(arm)),
                None => format!("`arm` is missing: the site has {names}"),
            };
            return Err(RpcError::param("arm", why));
        };
        let arm = arm.clone();
        if let Some(station) = entry.sole_station() {
            return Ok(ArmAt { arm, station });
        }
        let why = if entry.at.is_empty() {
            format!("the station of {arm} cannot be reached")
        } else {
            format!("two stations have an arm named {arm}: only a stop reaches both")
        };
        Err(RpcError::arm(ErrorKind::Port, why))
    }

    /// True if this station alone owns the arm. Reports of a station about other arms are ignored.
    pub(super) fn is_sole_owner(&self, station: StationId, arm: &str) -> bool {
        let entry = self.arms.get(arm);
        entry.and_then(ArmEntry::sole_station) == Some(station)
    }

    /// Returns any arm of a station, or `None` if it has none.
    pub(super) fn any_arm(&self, station: StationId) -> Option<String> {
        let (_, arms) = self.stations.get(&station)?;
        arms.first().cloned()
    }

    /// Machine of a station. `None` until it has reported a state.
    pub(super) fn machine_of(&self, station: StationId) -> Option<&str> {
        let mut known = self
            .arms
            .values()
            .filter_map(|entry| entry.at.get(&station));
        known.find_map(|report| report.as_ref().map(|(_, report)| report.machine.as_str()))
    }

    /// Current state of an arm from the bus, in place of asking its station. `None` if the last
    /// report is too old. Stations publish each change at once, so a recent report is current.
    pub(super) fn state_now(
        &self,
        now: HostInstant,
        at: &ArmAt,
    ) -> Option<Result<Value, RpcError>> {
        let (heard, report) = self.arms.get(&at.arm)?.at.get(&at.station)?.as_ref()?;
        if now - *heard > MAX_STATE_AGE {
            return None;
        }
        if report.state.is_null() {
            let why = format!("the line to {} is lost", at.arm);
            return Some(Err(RpcError::arm(ErrorKind::Port, why)));
        }
        let mut state = report.state.clone();
        let slot = self.stations.get(&at.station).map_or(0, |(slot, _)| *slot);
        let ids = Method::named("arm.state").map_or(&[][..], Method::result_ids);
        self.names.rename(slot, &mut state, ids);
        Some(Ok(state))
    }

    /// Handles the turns of a station. The hub only needs to know which arms are frozen.
    pub(super) fn note_turns(&mut self, station: StationId, turns: &Value) {
        for turn in items(&turns["arms"]) {
            let arm = turn["arm"].as_str().unwrap_or_default();
            if self.is_sole_owner(station, arm)
                && let Some(entry) = self.arms.get_mut(arm)
            {
                entry.is_frozen = turn["frozen"] == true;
            }
        }
    }

    /// Builds the reply to `arm.list`: rows of the stations that answered, and rows from the last
    /// state for the others.
    pub(super) fn arm_list_answer(&mut self, now: HostInstant, gather: &Gather) -> Value {
        for (station, part) in gather.answers() {
            for row in items(&part["arms"]) {
                let name = row["name"].as_str().unwrap_or_default();
                if self.is_sole_owner(station, name)
                    && let Some(entry) = self.arms.get_mut(name)
                {
                    entry.row = Some(row.clone());
                }
            }
        }
        let answered: BTreeSet<_> = gather.answers().map(|(station, _)| station).collect();
        let rows = self.arms.iter().map(|(name, entry)| {
            let row = entry.sole_station().and_then(|station| {
                if answered.contains(&station) {
                    return entry.row.clone();
                }
                self.row_from_report(now, name, station)
            });
            let mut row = row.unwrap_or_else(|| unreachable_row(name, entry.row.as_ref()));
            if let Some(machine) = entry.machine() {
                row["machine"] = json!(machine);
            }
            if entry.is_frozen {
                row["frozen"] = json!(true);
            }
            row
        });
        json!({"arms": rows.collect::<Vec<_>>()})
    }

    /// Row of an arm whose station did not reply in this session, built from its last state.
    fn row_from_report(&self, now: HostInstant, name: &str, station: StationId) -> Option<Value> {
        let arm = name.to_owned();
        let (_, report) = self.arms.get(name)?.at.get(&station)?.as_ref()?;
        let state = self.state_now(now, &ArmAt { arm, station });
        let state = state.and_then(Result::ok).unwrap_or_default();
        Some(json!({
            "name": name,
            "port": report.port,
            "virtual": report.is_virtual,
            "link": if state.is_null() { "lost" } else { "up" },
            "holder": state["holder"],
            "waiting": [],
            "job": state["job"],
        }))
    }
}

/// Row of an unreachable arm, with the fields of its last known row.
fn unreachable_row(name: &str, before: Option<&Value>) -> Value {
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
