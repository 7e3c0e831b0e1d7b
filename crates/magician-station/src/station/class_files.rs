//! Files of a class, and changes that wait for them.
//!
//! A change takes effect when its file is on the disk, and is answered then. So a positive answer
//! promises that the change survives a crash of the program, and a change that the disk refuses has
//! changed nothing. One change of a file waits at a time: a second one would be based on a version
//! that may never take effect.

use std::collections::BTreeMap;

use magician::{ErrorKind, message};
use magician_protocol::HostInstant;
use serde_json::{Value, json};

use super::class::{CLASS_FILE, ROSTER_FILE, SCHEDULE_FILE};
use super::dispatch::{Call, Handled};
use super::held_work::refused_change_error;
use super::sessions::RoleSource;
use super::store::FileSnapshot;
use super::{Awaited, Station};
use crate::api::{Role, RpcError};
use crate::class::{ClassFile, Schedule};
use crate::control::{RequestId, SessionId};
use crate::roster::Roster;

/// Files to write, and changes that wait for them.
#[derive(Debug, Default)]
pub(super) struct ClassFiles {
    /// Revision of the last text, over all files.
    revision: u64,
    /// Newest texts that were not handed out yet, by name.
    waiting: BTreeMap<&'static str, FileSnapshot>,
    held: Vec<HeldChange>,
}

/// Change that takes effect, and is answered, once its file is on the disk.
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
        /// The new class. `None` ends the class.
        file: Option<Box<ClassFile>>,
        /// Session that made the change.
        maker: Option<SessionId>,
        /// Pupils whose code in the file differs from the valid code.
        codes_kept: Vec<String>,
    },
    Schedule(Schedule),
    /// Arms expected on the site.
    Roster(Roster),
}

impl ClassFiles {
    /// Queues a file for writing. Returns the revision of its text.
    pub(super) fn write(&mut self, name: &'static str, text: String) -> u64 {
        self.revision += 1;
        let revision = self.revision;
        self.waiting.insert(name, FileSnapshot { revision, text });
        revision
    }
}

impl Station {
    /// Returns the files that have changed and must be written, by name, each readable by its owner
    /// alone. [`file_written`](Self::file_written) takes the results.
    pub fn poll_files(&mut self) -> BTreeMap<&'static str, FileSnapshot> {
        std::mem::take(&mut self.class.files.waiting)
    }

    /// Takes the result of writing a file up to this revision.
    pub fn file_written(
        &mut self,
        now: HostInstant,
        name: &str,
        revision: u64,
        outcome: Result<(), String>,
    ) {
        // A file is written whole, so a later revision contains the change as well.
        let is_meant = |held: &mut HeldChange| held.name == name && held.revision <= revision;
        let held: Vec<_> = { &mut self.class.files.held }
            .extract_if(.., is_meant)
            .collect();
        for HeldChange {
            request, change, ..
        } in held
        {
            let outcome = match &outcome {
                Ok(()) => Ok(self.apply_change(now, change)),
                // The change is dropped, so that the station and the disk stay equal.
                Err(why) => Err(refused_change_error(why)),
            };
            self.finish(now, request, outcome);
        }
        self.carry_out_effects(now);
    }

    /// Writes the file of a change. Change and answer wait for the disk.
    ///
    /// # Errors
    /// [`ErrorKind::QueueFull`] while another change of the same file waits, because the new one is
    /// not based on it.
    pub(super) fn change_class(
        &mut self,
        call: &Call<'_>,
        change: ClassChange,
        text: String,
    ) -> Result<Handled, RpcError> {
        let name = match &change {
            ClassChange::Class { .. } => CLASS_FILE,
            ClassChange::Schedule(_) => SCHEDULE_FILE,
            ClassChange::Roster(_) => ROSTER_FILE,
        };
        let files = &mut self.class.files;
        if files.held.iter().any(|held| held.name == name) {
            let why = message!(
                "another change of the class is being written: try again after its answer"
            );
            return Err(RpcError::arm(ErrorKind::QueueFull, why));
        }
        let held = HeldChange {
            request: call.request,
            name,
            revision: files.write(name, text),
            change,
        };
        files.held.push(held);
        Ok(Handled::Later(call.request, Awaited::Saved))
    }

    /// Applies a change. Returns the answer to its request.
    fn apply_change(&mut self, now: HostInstant, change: ClassChange) -> Value {
        match change {
            ClassChange::Class {
                file,
                maker,
                codes_kept,
            } => {
                if let Some(maker) = maker.and_then(|maker| self.sessions.get_mut(&maker))
                    && file.is_some()
                    && maker.role_source == RoleSource::Place
                {
                    // The answer contains the PIN, so the maker of the class counts as signed in
                    // with it and stays a teacher.
                    maker.role_source = RoleSource::Pin;
                }
                self.begin_class(now, file.map(|file| *file));
                self.expand_slots(now);
                let mut shown = self.shown_class(now, Role::Teacher);
                shown["codes_kept"] = json!(codes_kept);
                shown
            }
            ClassChange::Schedule(schedule) => {
                self.class.schedule = Some(schedule);
                self.class.schedule_error = None;
                self.expand_slots(now);
                self.shown_schedule(now)
            }
            ClassChange::Roster(roster) => {
                self.class.roster = roster;
                self.class.roster.to_value()
            }
        }
    }
}
