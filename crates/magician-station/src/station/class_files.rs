//! The files of a class: what of them is to be written, and changes that count once they are on the disk. So an answer to
//! such a change promises that it outlives the program, and a change that the disk does not take has changed nothing.

use std::collections::BTreeMap;

use magician::ErrorKind;
use magician_protocol::HostInstant;
use serde_json::{Value, json};

use super::class::{CLASS, ROSTER, SCHEDULE};
use super::dispatch::{Call, Handled};
use super::keeping::unkept;
use super::sessions::Entry;
use super::store::FileToKeep;
use super::{Awaited, Station};
use crate::api::{Role, RpcError};
use crate::class::{ClassFile, Schedule};
use crate::control::{RequestId, SessionId};
use crate::roster::Roster;

/// What of the files waits.
#[derive(Debug, Default)]
pub(super) struct ClassFiles {
    /// Number of the last text of any of them.
    revision: u64,
    /// The newest texts that were not handed out yet.
    waiting: BTreeMap<&'static str, FileToKeep>,
    held: Vec<HeldChange>,
}

/// A change that counts, and is answered, once its file is on the disk.
#[derive(Debug)]
struct HeldChange {
    request: RequestId,
    name: &'static str,
    revision: u64,
    change: ClassChange,
}

#[derive(Debug)]
pub(super) enum ClassChange {
    Class {
        /// Another class, or none.
        file: Option<Box<ClassFile>>,
        /// The session that made it.
        maker: Option<SessionId>,
        /// The pupils for whom the file had another code than the one that counts.
        codes_kept: Vec<String>,
    },
    Schedule(Schedule),
    /// The arms that are expected on the site.
    Roster(Roster),
}

impl ClassFiles {
    /// Has a file written. Returns the number of its text.
    pub(super) fn write(&mut self, name: &'static str, text: String) -> u64 {
        self.revision += 1;
        let revision = self.revision;
        self.waiting.insert(name, FileToKeep { revision, text });
        revision
    }
}

impl Station {
    /// Files that have changed and are to be kept, by their names, each for its owner alone.
    /// [`file_kept`](Self::file_kept) takes what comes of it.
    pub fn poll_kept(&mut self) -> BTreeMap<&'static str, FileToKeep> {
        std::mem::take(&mut self.class.files.waiting)
    }

    /// What came of writing a file of this name, up to this number of its text.
    pub fn file_kept(
        &mut self,
        now: HostInstant,
        name: &str,
        revision: u64,
        outcome: Result<(), String>,
    ) {
        let is_meant = |held: &mut HeldChange| held.name == name && held.revision <= revision;
        let held: Vec<_> = { &mut self.class.files.held }
            .extract_if(.., is_meant)
            .collect();
        for HeldChange {
            request, change, ..
        } in held
        {
            let outcome = match &outcome {
                Ok(()) => Ok(self.put_into_effect(now, change)),
                Err(why) => Err(unkept(why)),
            };
            self.finish(now, request, outcome);
        }
        self.settle(now);
    }

    /// Writes the file of a change; the change and its answer wait for that.
    ///
    /// # Errors
    /// [`ErrorKind::QueueFull`] while another change of the same file waits: the new one was made without it.
    pub(super) fn change_class(
        &mut self,
        call: &Call<'_>,
        change: ClassChange,
        text: String,
    ) -> Result<Handled, RpcError> {
        let name = match &change {
            ClassChange::Class { .. } => CLASS,
            ClassChange::Schedule(_) => SCHEDULE,
            ClassChange::Roster(_) => ROSTER,
        };
        let files = &mut self.class.files;
        if files.held.iter().any(|held| held.name == name) {
            let why = "another change of the class is being written: try again after its answer";
            return Err(RpcError::arm(ErrorKind::QueueFull, why));
        }
        let held = HeldChange {
            request: call.request,
            name,
            revision: files.write(name, text),
            change,
        };
        files.held.push(held);
        Ok(Handled::Later(call.request, Awaited::Kept))
    }

    /// Returns the answer.
    fn put_into_effect(&mut self, now: HostInstant, change: ClassChange) -> Value {
        match change {
            ClassChange::Class {
                file,
                maker,
                codes_kept,
            } => {
                if let Some(maker) = maker.and_then(|maker| self.sessions.get_mut(&maker))
                    && file.is_some()
                    && maker.entry == Entry::Place
                {
                    // Whoever makes the class is told its PIN by the answer.
                    maker.entry = Entry::Pin;
                }
                self.begin_class(now, file.map(|file| *file));
                self.count_out(now);
                let mut shown = self.shown_class(now, Role::Teacher);
                shown["codes_kept"] = json!(codes_kept);
                shown
            }
            ClassChange::Schedule(schedule) => {
                self.class.schedule = Some(schedule);
                self.class.schedule_error = None;
                self.count_out(now);
                self.shown_schedule(now)
            }
            ClassChange::Roster(roster) => {
                self.class.roster = roster;
                self.class.roster.to_value()
            }
        }
    }
}
