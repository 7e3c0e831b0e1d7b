//! The schedule: who may have which arm when, by the clock of this station.

use std::collections::BTreeSet;

use magician_protocol::HostInstant;
use serde_json::{Value, json};

use super::Station;
use super::class::{ANEW, Person};
use crate::control::{PersonId, Slot};

impl Station {
    /// Counts the slots of the schedule out, from now on.
    pub(super) fn count_out(&mut self, now: HostInstant) {
        let Some(schedule) = self.class.schedule.clone() else {
            return;
        };
        let unix = self.unix(now).floor() as i64;
        let at = |time: i64| {
            let since = time as f64 - self.config.unix_zero;
            HostInstant::from_micros((since.max(0.0) * 1e6) as u64)
        };
        let mut all = Vec::new();
        for arm in self.arm_ids() {
            let windows = schedule.windows(&self.arm(arm).entry.name, unix);
            let windows = windows.map(|windows| {
                let windows = windows.iter();
                windows
                    .map(|window| (at(window.from), at(window.until), window.who.to_vec()))
                    .collect::<Vec<_>>()
            });
            all.push((arm, windows));
        }
        for (arm, windows) in all {
            let slots = windows.map(|windows| {
                let slots = windows.into_iter().map(|(from, until, who)| Slot {
                    from: Some(from).filter(|from| now < *from),
                    until,
                    who: self.people(&who),
                });
                slots.collect()
            });
            self.control.set_slots(now, arm, slots);
        }
        self.class.anew = Some(now + ANEW);
    }

    /// The persons whom names mean: pupils, groups, tokens.
    pub(super) fn people(&mut self, names: &[String]) -> BTreeSet<PersonId> {
        let mut out = BTreeSet::new();
        for name in names {
            let pupils = self.class.file.iter().flat_map(|file| &file.pupil);
            let of =
                pupils.filter(|pupil| pupil.name == *name || pupil.group.as_ref() == Some(name));
            let pupils: Vec<_> = of.map(|pupil| Person::Pupil(pupil.name.clone())).collect();
            let token = Person::Token(name.clone());
            out.extend({ pupils.into_iter().chain([token]) }.map(|person| self.number_of(person)));
        }
        out
    }

    pub(super) fn shown_schedule(&self, now: HostInstant) -> Value {
        let schedule = self.class.schedule.clone().unwrap_or_default();
        json!({"text": schedule.text(), "slots": schedule.shown(), "now": self.unix(now)})
    }
}
