//! Ids of several stations side by side: each has the number of its station before it, and nobody else makes such ids.

use std::collections::{BTreeMap, BTreeSet};

use magician_station::api::{ERROR_IDS, IdKind, IdPlace, RpcError, each_id};
use serde_json::{Value, json};

use crate::site::StationId;

/// What stands between the number of a station and its id. The hub's own ids have none.
const MARK: char = '.';

/// A place that a station has on the hub. One that starts anew takes that of the one before, so that its jobs keep their ids.
#[derive(Debug, Default)]
struct Slot {
    station: Option<StationId>,
    arms: BTreeSet<String>,
}

/// The numbers of stations, and who is who.
#[derive(Debug, Default)]
pub(super) struct Names {
    /// The first is number 1.
    slots: Vec<Slot>,
    /// Sessions that the hub has at stations for its own clients, by the station's number and its id there.
    own: BTreeMap<(u32, String), String>,
}

impl Names {
    /// The number of a station that has this arm.
    pub(super) fn arrives(&mut self, station: StationId, arm: &str) -> u32 {
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

    /// A station is gone; its number waits for it.
    pub(super) fn leaves(&mut self, station: StationId) {
        for slot in &mut self.slots {
            if slot.station == Some(station) {
                slot.station = None;
            }
        }
    }

    /// The station behind an id, with the id that it has there. Without a station it is one of a station that is gone, and
    /// `None` of nobody.
    pub(super) fn split<'a>(&self, id: &'a str) -> Option<(u32, Option<StationId>, &'a str)> {
        let (number, rest) = id.split_once(MARK)?;
        let slot: u32 = number.parse().ok()?;
        // In one form only.
        if slot.to_string() != number {
            return None;
        }
        let known = self.slots.get((slot as usize).checked_sub(1)?)?;
        Some((slot, known.station, rest))
    }

    /// The arms that a number has had.
    pub(super) fn arms_of(&self, slot: u32) -> String {
        let slot = (slot as usize)
            .checked_sub(1)
            .and_then(|at| self.slots.get(at));
        let arms = slot.map(|slot| slot.arms.iter().map(String::as_str).collect::<Vec<_>>());
        arms.unwrap_or_default().join(", ")
    }

    /// A session at a station is that of a client of the hub.
    pub(super) fn is_own(&mut self, slot: u32, session: &str, of: &str) {
        self.own.insert((slot, session.to_owned()), of.to_owned());
    }

    /// A client of the hub is gone for good.
    pub(super) fn forget(&mut self, of: &str) {
        self.own.retain(|_, own| own != of);
    }

    /// The id of a station as clients of the hub have it.
    pub(super) fn outward(&self, slot: u32, kind: IdKind, id: &str) -> String {
        let own = match kind {
            IdKind::Session => self.own.get(&(slot, id.to_owned())),
            _ => None,
        };
        own.cloned().unwrap_or_else(|| format!("{slot}{MARK}{id}"))
    }

    /// The ids at these places as clients of the hub have them; what is no id is null.
    pub(super) fn rename(&self, slot: u32, value: &mut Value, places: &[IdPlace]) {
        each_id(value, places, &mut |kind, id| {
            // A subscription has a number of its own, which the hub knows to which arm it belongs.
            if kind != IdKind::Subscription {
                *id = id
                    .as_str()
                    .map_or(Value::Null, |text| json!(self.outward(slot, kind, text)));
            }
        });
    }

    /// The same for an error.
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
    fn ids_of_two_stations_are_never_the_same() {
        let mut names = Names::default();
        let one = names.arrives(StationId(7), "a");
        let two = names.arrives(StationId(8), "b");
        assert_eq!(names.arrives(StationId(7), "c"), one);
        let [first, second] = [one, two].map(|slot| names.outward(slot, IdKind::Job, "j1-5"));
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
    fn a_station_that_starts_anew_keeps_its_number() {
        let mut names = Names::default();
        let one = names.arrives(StationId(7), "a");
        // While it is there another one with its arm has another number.
        assert_ne!(names.arrives(StationId(9), "a"), one);
        names.leaves(StationId(7));
        assert_eq!(names.split("1.x"), Some((1, None, "x")));
        assert_eq!(names.arrives(StationId(8), "a"), one);
    }

    #[test]
    fn a_client_of_the_hub_has_one_id_at_all_stations() {
        let mut names = Names::default();
        let [one, two] = [(7, "a"), (8, "b")].map(|(id, arm)| names.arrives(StationId(id), arm));
        names.is_own(one, "s1-4", "s0-1");
        names.is_own(two, "s1-9", "s0-1");
        let mut value = json!({"holder": {"session": "s1-4", "name": "Anna"}, "by": 5});
        names.rename(one, &mut value, ERROR_IDS);
        assert_eq!(
            value,
            json!({"holder": {"session": "s0-1", "name": "Anna"}, "by": null})
        );
        // The same text at another station is somebody else.
        assert_eq!(names.outward(two, IdKind::Session, "s1-4"), "2.s1-4");
        names.forget("s0-1");
        assert_eq!(names.outward(one, IdKind::Session, "s1-4"), "1.s1-4");
    }
}
