//! Renaming of ids: stations choose ids on their own, so the hub prefixes each with a number for
//! its station.
//!
//! A number belongs to a *slot*. A station that restarts gets the slot of its predecessor with the
//! same arm, so that ids of its jobs stay valid. Sessions that the hub opened for its own clients
//! are shown under the client's id at the hub.

use std::collections::{BTreeMap, BTreeSet};

use magician_station::api::{ERROR_IDS, IdKind, IdPlace, RpcError, each_id};
use serde_json::{Value, json};

use crate::site::StationId;

/// Separates slot number and id of the station. Ids of the hub itself contain no such character.
const SEPARATOR: char = '.';

/// Number of a station at the hub. A restarted station takes over the slot with its arm, so that
/// the ids of its jobs stay valid.
#[derive(Debug, Default)]
struct Slot {
    station: Option<StationId>,
    arms: BTreeSet<String>,
}

/// Slots of stations, and sessions of the hub's clients at them.
#[derive(Debug, Default)]
pub(super) struct Names {
    /// Numbered from 1.
    slots: Vec<Slot>,
    /// Maps slot and session id at a station to the session id at the hub, for sessions that the
    /// hub has opened for its clients.
    own: BTreeMap<(u32, String), String>,
}

impl Names {
    /// Returns the slot number of a station with this arm, and assigns one if it has none.
    pub(super) fn assign_slot(&mut self, station: StationId, arm: &str) -> u32 {
        let at = { self.slots.iter() }.position(|slot| slot.station == Some(station));
        let free = |slot: &Slot| slot.station.is_none() && slot.arms.contains(arm);
        let at = at.or_else(|| self.slots.iter().position(free));
        let at = at.unwrap_or_else(|| {
            self.slots.push(Slot::default());
            self.slots.len() - 1
        });
        let slot = &mut self.slots[at];
        slot.station = Some(station);
        slot.arms.insert(arm.to_owned());
        at as u32 + 1
    }

    /// Frees the slot of a departed station. The next station with one of its arms gets it.
    pub(super) fn free_slot(&mut self, station: StationId) {
        for slot in &mut self.slots {
            if slot.station == Some(station) {
                slot.station = None;
            }
        }
    }

    /// Splits an id of the hub into slot, station and the id at that station. The station is `None`
    /// if it has left. Returns `None` if the id has no valid prefix.
    pub(super) fn split<'a>(&self, id: &'a str) -> Option<(u32, Option<StationId>, &'a str)> {
        let (number, rest) = id.split_once(SEPARATOR)?;
        let slot: u32 = number.parse().ok()?;
        // Reject other spellings such as `01`: two texts must not denote one id.
        if slot.to_string() != number {
            return None;
        }
        let known = self.slots.get((slot as usize).checked_sub(1)?)?;
        Some((slot, known.station, rest))
    }

    /// Comma-separated arms that the slot has ever had.
    pub(super) fn arms_of(&self, slot: u32) -> String {
        let slot = (slot as usize)
            .checked_sub(1)
            .and_then(|at| self.slots.get(at));
        let arms = slot.map(|slot| slot.arms.iter().map(String::as_str).collect::<Vec<_>>());
        arms.unwrap_or_default().join(", ")
    }

    /// Records that a session at a station belongs to a client of the hub.
    pub(super) fn record_session(&mut self, slot: u32, session: &str, of: &str) {
        self.own.insert((slot, session.to_owned()), of.to_owned());
    }

    /// Forgets the sessions of a client that cannot be resumed.
    pub(super) fn forget(&mut self, of: &str) {
        self.own.retain(|_, own| own != of);
    }

    /// Translates an id of a station to the id shown to clients of the hub.
    pub(super) fn hub_id(&self, slot: u32, kind: IdKind, id: &str) -> String {
        let own = match kind {
            IdKind::Session => self.own.get(&(slot, id.to_owned())),
            _ => None,
        };
        own.cloned()
            .unwrap_or_else(|| format!("{slot}{SEPARATOR}{id}"))
    }

    /// Translates the ids at these places of a JSON value. A malformed id becomes null.
    pub(super) fn rename(&self, slot: u32, value: &mut Value, places: &[IdPlace]) {
        each_id(value, places, &mut |kind, id| {
            // Subscriptions have numbers of their own, which the hub assigns.
            if kind != IdKind::Subscription {
                *id = id
                    .as_str()
                    .map_or(Value::Null, |text| json!(self.hub_id(slot, kind, text)));
            }
        });
    }

    /// Translates the ids in the data of an error.
    pub(super) fn rename_error(&self, slot: u32, mut error: RpcError) -> RpcError {
        let mut data = Value::Object(error.data);
        self.rename(slot, &mut data, ERROR_IDS);
        error.data = match data {
            Value::Object(data) => data,
            _ => Default::default(),
        };
        error
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_of_two_stations_differ() {
        let mut names = Names::default();
        let one = names.assign_slot(StationId(7), "a");
        let two = names.assign_slot(StationId(8), "b");
        assert_eq!(names.assign_slot(StationId(7), "c"), one);
        let [first, second] = [one, two].map(|slot| names.hub_id(slot, IdKind::Job, "j1-5"));
        assert_ne!(first, second);
        assert_eq!(names.split(&first), Some((one, Some(StationId(7)), "j1-5")));
        assert_eq!(
            names.split(&second),
            Some((two, Some(StationId(8)), "j1-5"))
        );
        for nobody in [
            "j1-5", "0.j1-5", "3.j1-5", "01.j1-5", "+1.j1-5", ".j1-5", "", "1",
        ] {
            assert_eq!(names.split(nobody), None, "{nobody}");
        }
    }

    #[test]
    fn restarted_station_keeps_its_slot_number() {
        let mut names = Names::default();
        let one = names.assign_slot(StationId(7), "a");
        // As long as the old station is present, another one with the same arm gets a new number.
        assert_ne!(names.assign_slot(StationId(9), "a"), one);
        names.free_slot(StationId(7));
        assert_eq!(names.split("1.x"), Some((1, None, "x")));
        assert_eq!(names.assign_slot(StationId(8), "a"), one);
    }

    #[test]
    fn a_client_of_the_hub_has_one_id_at_all_stations() {
        let mut names = Names::default();
        let [one, two] =
            [(7, "a"), (8, "b")].map(|(id, arm)| names.assign_slot(StationId(id), arm));
        names.record_session(one, "s1-4", "s0-1");
        names.record_session(two, "s1-9", "s0-1");
        let mut value = json!({"holder": {"session": "s1-4", "name": "Anna"}, "by": 5});
        names.rename(one, &mut value, ERROR_IDS);
        assert_eq!(
            value,
            json!({"holder": {"session": "s0-1", "name": "Anna"}, "by": null})
        );
        // The same id at another station is a different session.
        assert_eq!(names.hub_id(two, IdKind::Session, "s1-4"), "2.s1-4");
        names.forget("s0-1");
        assert_eq!(names.hub_id(one, IdKind::Session, "s1-4"), "1.s1-4");
    }
}
