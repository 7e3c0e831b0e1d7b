//! Schedule: which persons may have which arm when, by the station's clock.

use std::collections::BTreeSet;

use magician::{Message, message};
use magician_protocol::HostInstant;
use serde_json::{Value, json};

use super::Station;
use super::class::{Person, SLOT_REFRESH_INTERVAL};
use crate::class::{ClassError, Schedule, local_time, offset_of};
use crate::control::{ArmId, PersonId, Slot};

/// Open slot.
pub(super) struct OpenSlot {
    /// Names that may have the arm: pupils, groups, tokens, or `teacher`.
    pub(super) who: Vec<String>,
    /// End, Unix seconds. `None` without end.
    pub(super) until: Option<i64>,
}

/// State of an arm in the schedule.
pub(super) enum SlotNow {
    /// Open to everyone.
    Free,
    /// In a slot.
    Open(OpenSlot),
    /// Between slots. Start of the next one, Unix seconds; `None` if none is known.
    Closed(Option<i64>),
}

impl Station {
    /// Expands the schedule into slots, from now on. An arm that the class does not give to pupils
    /// has no slots, nor has any arm while the schedule cannot be read.
    pub(super) fn expand_slots(&mut self, now: HostInstant) {
        let schedule = self.class.schedule.clone().unwrap_or_default();
        let unix = self.unix(now).floor() as i64;
        let at = |time: i64| {
            let since = time as f64 - self.config.unix_zero;
            // A slot that began before the station started begins at its start.
            HostInstant::from_micros((since.max(0.0) * 1e6) as u64)
        };
        let mut all = Vec::new();
        for arm in self.arm_ids() {
            // An empty list of slots closes the arm to everyone but teachers; `None` opens it.
            let windows = if self.is_for_pupils(arm) && self.class.schedule_error.is_none() {
                schedule.windows(&self.arm(arm).entry.name, unix)
            } else {
                Some(Vec::new())
            };
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
                    who: self.persons_named(&who),
                });
                slots.collect()
            });
            self.control.set_slots(now, arm, slots);
        }
        self.control.drop_closed_places(now);
        self.class.slots_due = Some(now + SLOT_REFRESH_INTERVAL);
    }

    /// Bars pupils from arms outside their group's list. A group without a list may use all arms.
    pub(super) fn bar_groups(&mut self, now: HostInstant) {
        for arm in self.arm_ids() {
            let name = &self.arm(arm).entry.name;
            let file = self.class.file.iter();
            let barred = file.flat_map(|file| {
                let pupils = file.pupil.iter();
                pupils.filter(|pupil| {
                    let arms = pupil
                        .group
                        .as_ref()
                        .and_then(|group| file.groups.get(group));
                    arms.is_some_and(|arms| !arms.contains(name))
                })
            });
            let barred: Vec<_> = barred
                .map(|pupil| Person::Pupil(pupil.name.clone()))
                .collect();
            let barred = barred.into_iter().map(|person| self.number_of(person));
            let barred = barred.collect();
            self.control.bar(now, arm, barred);
        }
    }

    /// Returns the reason why a person is barred from an arm. `None` if the person is not.
    pub(super) fn barred(&self, arm: ArmId, person: PersonId) -> Option<Message> {
        if !self.control.is_barred(arm, person) {
            return None;
        }
        let name = &self.arm(arm).entry.name;
        let group = self.group_of(self.person_name(person)).unwrap_or_default();
        let file = self.class.file.as_ref();
        let arms = file.and_then(|file| file.groups.get(group));
        let arms = arms.map_or_else(String::new, |arms| arms.join(", "));
        Some(message!(
            "{name} is no arm of your group {group}, which has {arms}: ask for one of these, or the teacher",
            name,
            group,
            arms
        ))
    }

    /// Formats Unix seconds as local time, with the offset from UTC given by the schedule, or else
    /// by the class.
    pub(super) fn local_time(&self, time: i64) -> String {
        let of_schedule = self.class.schedule.as_ref().and_then(Schedule::offset);
        let of_class = || offset_of(self.class.file.as_ref()?.class.offset.as_deref()?);
        local_time(time, of_schedule.or_else(of_class))
    }

    /// True if the class lets pupils use the arm.
    fn is_for_pupils(&self, arm: ArmId) -> bool {
        let file = self.class.file.as_ref();
        file.is_none_or(|file| file.has_arm(&self.arm(arm).entry.name))
    }

    /// Returns the current state of an arm in the schedule, with the names used there.
    pub(super) fn slot(&self, now: HostInstant, arm: ArmId) -> SlotNow {
        if !self.is_for_pupils(arm) || self.class.schedule_error.is_some() {
            let who = vec!["teacher".to_owned()];
            return SlotNow::Open(OpenSlot { who, until: None });
        }
        let unix = self.unix(now).floor() as i64;
        let schedule = self.class.schedule.as_ref();
        let name = &self.arm(arm).entry.name;
        let Some(windows) = schedule.and_then(|schedule| schedule.windows(name, unix)) else {
            return SlotNow::Free;
        };
        let open = windows.iter().filter(|window| window.from <= unix);
        // Of several open slots the first to end changes who may have the arm.
        let Some(until) = open.clone().map(|window| window.until).min() else {
            return SlotNow::Closed(windows.first().map(|window| window.from));
        };
        let who: BTreeSet<_> = open.flat_map(|window| window.who).cloned().collect();
        SlotNow::Open(OpenSlot {
            who: who.into_iter().collect(),
            until: Some(until),
        })
    }

    /// Returns the persons denoted by names of pupils, groups and tokens.
    pub(super) fn persons_named(&mut self, names: &[String]) -> BTreeSet<PersonId> {
        let mut out = BTreeSet::new();
        for name in names {
            let pupils = self.class.file.iter().flat_map(|file| &file.pupil);
            let of =
                pupils.filter(|pupil| pupil.name == *name || pupil.group.as_ref() == Some(name));
            let pupils: Vec<_> = of.map(|pupil| Person::Pupil(pupil.name.clone())).collect();
            // A name may be that of a token, which no file lists.
            let token = Person::Token(name.clone());
            out.extend({ pupils.into_iter().chain([token]) }.map(|person| self.number_of(person)));
        }
        out
    }

    pub(super) fn shown_schedule(&self, now: HostInstant) -> Value {
        let schedule = self.class.schedule.clone().unwrap_or_default();
        json!({
            "text": schedule.text(), "slots": schedule.shown(), "now": self.unix(now),
            "error": self.schedule_error_sentence().map(String::from),
        })
    }

    /// Returns the reason why only teachers may have arms, and what to do. `None` if the schedule
    /// could be read.
    pub(super) fn schedule_error_sentence(&self) -> Option<Message> {
        let ClassError(error) = self.class.schedule_error.as_ref()?;
        // Errors of the TOML reader have several lines, with an excerpt of the file.
        let line = error.split_whitespace().collect::<Vec<_>>().join(" ");
        let line = magician_protocol::visible(&line).to_string();
        let error = if *error == line {
            error.clone()
        } else {
            line.into()
        };
        Some(message!(
            "the schedule cannot be read, so that arms are for teachers alone: a teacher sets another one \
             (schedule.set; an empty one opens all arms). {error}",
            error
        ))
    }
}
