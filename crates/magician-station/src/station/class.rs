//! Classes at the station: the files of a class, freezing, and the fence for pupils. Signing in is
//! in `sign_in`.
//!
//! Control decides about turns and slots by numbers of persons; this module maps names, tokens and
//! codes to those numbers. A class, its schedule, the roster and the results are files. They are
//! read once at the start and written through `ClassFiles`; a change takes effect only when its
//! file is on the disk. A damaged file never gives pupils more rights than a good one would.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use magician::{Fence, message};
use magician_protocol::HostInstant;
use serde_json::{Value, json};

use super::class_files::{ClassChange, ClassFiles};
use super::dispatch::{Call, Handled};
use super::held_work::WriteFailurePolicy;
use super::queue::QueuedJob;
use super::sessions::RoleSource;
use super::socket::CloseCode;
use super::{Station, StationConfig};
use crate::api::{Role, RpcError};
use crate::class::{ClassError, ClassFile, Schedule};
use crate::control::{ArmId, JobClaim, JobId, PersonId, RequestId, WrongCodes};
use crate::roster::Roster;

/// Names of the files in the [`JobStore`](crate::JobStore).
pub(super) const CLASS_FILE: &str = "class.toml";
pub(super) const SCHEDULE_FILE: &str = "schedule.toml";
pub(super) const ROSTER_FILE: &str = "roster.json";
pub(super) const RESULTS_FILE: &str = "results.json";
const DAMAGED_RESULTS_FILE: &str = "results-damaged.json";
/// Time for the job of a frozen arm to pause, at the end of a short step. Then the job is ended.
const FREEZE_PAUSE_TIMEOUT: Duration = Duration::from_secs(1);
/// Interval of expanding the schedule into slots again. Slots are expanded eight days ahead, so
/// once a day suffices.
pub(super) const SLOT_REFRESH_INTERVAL: Duration = Duration::from_secs(24 * 3600);

/// State of the class of a station.
#[derive(Debug, Default)]
pub(super) struct StationClass {
    pub(super) file: Option<ClassFile>,
    /// Teacher's PIN of the class held by the stations behind a hub.
    pub(super) elsewhere: Option<String>,
    pub(super) schedule: Option<Schedule>,
    /// Reason why the schedule from the last start or from the flag cannot be read. Until another
    /// one is set, the arms are open to teachers alone: a damaged file must not give pupils more
    /// than a good one.
    pub(super) schedule_error: Option<ClassError>,
    /// Arms expected on the site.
    pub(super) roster: Roster,
    /// Instant at which slots have to be expanded again.
    pub(super) slots_due: Option<HostInstant>,
    /// Instants at which the jobs of frozen arms have had their time to pause.
    pub(super) pauses_end: BTreeMap<ArmId, HostInstant>,
    /// Known persons. The index is the [`PersonId`].
    pub(super) persons: Vec<Person>,
    pub(super) wrong: WrongCodes,
    /// Fence for all arms while others than teachers move them.
    pub(super) fence: Option<Fence>,
    /// Fence that each arm has now.
    pub(super) fences: Vec<Option<Fence>>,
    /// Programs of the jobs that wait.
    pub(super) queue: BTreeMap<JobId, QueuedJob>,
    /// True once the program ends: the queue is kept for its next start.
    pub(super) closed: bool,
    /// Running jobs that came from the queue.
    pub(super) from_queue: BTreeMap<JobId, (JobClaim, QueuedJob)>,
    pub(super) results: Vec<Value>,
    /// Requests that wait for the picture of a result.
    pub(super) pictures: BTreeMap<RequestId, String>,
    pub(super) files: ClassFiles,
    /// True if turns have changed since the last notification.
    pub(super) turns_changed: bool,
}

/// Person who takes turns.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Person {
    Pupil(String),
    /// Holder of a token with this name.
    Token(String),
}

impl Person {
    pub(super) fn name(&self) -> &str {
        match self {
            Self::Pupil(name) | Self::Token(name) => name,
        }
    }
}

impl StationClass {
    /// Reads the class from the flags, or else from the files of an earlier station.
    pub(super) fn load(config: &StationConfig) -> Self {
        let kept = |name| {
            { config.jobs.load_text(name) }.map_err(|error| ClassError(error.to_string().into()))
        };
        let noted =
            |what: &str, error: &ClassError| tracing::warn!(%error, "the {what} is not used");
        let before = match kept(CLASS_FILE) {
            // An empty file is written when a class is ended.
            Ok(text) => {
                { text.filter(|text| !text.trim().is_empty()) }.map(|text| ClassFile::parse(&text))
            }
            Err(error) => Some(Err(error)),
        };
        let given = config.class.as_deref().map(ClassFile::parse);
        // A file from the flags replaces the stored one, except for its codes (below).
        let mut file = given.or_else(|| before.clone()).map(|file| {
            file.unwrap_or_else(|error| {
                noted("class", &error);
                // A class that cannot be read counts as an empty class. So anonymous clients of
                // this machine stay viewers until another class is set.
                ClassFile::default()
            })
        });
        if let (Some(file), Some(Ok(before))) = (&mut file, &before) {
            let kept = file.keep_codes(before, false);
            if !kept.is_empty() {
                let pupils = kept.join(", ");
                tracing::warn!(
                    pupils,
                    "the class file has other codes for these pupils: those of the last start count, until `class set` \
                     is told to take the file's"
                );
            }
        }
        // Only a warning: the file may be shared by several stations.
        let has = |arm: &str| config.arms.iter().any(|known| known.name == arm);
        if let Some(Err(error)) = { file.as_ref() }.map(|file| file.check_arms("this station", has))
        {
            tracing::warn!(error = error.0.as_str(), "another station may have it");
        }
        let schedule = match &config.schedule {
            Some(text) => Ok(Some(text.clone())),
            None => kept(SCHEDULE_FILE),
        };
        let schedule =
            schedule.and_then(|text| text.map(|text| Schedule::parse(&text)).transpose());
        let (schedule, schedule_error) = match schedule {
            Ok(schedule) => (schedule, None),
            Err(error) => {
                tracing::warn!(
                    %error,
                    "the schedule cannot be read: no pupil has an arm until another one is set"
                );
                (None, Some(error))
            }
        };
        let roster = kept(ROSTER_FILE).and_then(|text| {
            let roster = text.map(|text| Roster::parse(&text).map_err(ClassError));
            roster.unwrap_or_else(|| Ok(Roster::default()))
        });
        let roster = roster.unwrap_or_else(|error| {
            noted("roster", &error);
            Roster::default()
        });
        let mut files = ClassFiles::default();
        let results = kept(RESULTS_FILE).unwrap_or_else(|error| {
            noted("file of results", &error);
            None
        });
        let results = results.map_or_else(Vec::new, |text| {
            serde_json::from_str(&text).unwrap_or_else(|error| {
                tracing::warn!(%error, "the results cannot be read: they are kept as {DAMAGED_RESULTS_FILE}");
                files.write(DAMAGED_RESULTS_FILE, text);
                Vec::new()
            })
        });
        Self {
            files,
            file,
            schedule,
            schedule_error,
            roster,
            // Expanded at the first call with a time, because the station has no clock.
            slots_due: Some(HostInstant::ZERO),
            fences: config.arms.iter().map(|arm| arm.fence).collect(),
            results,
            ..Self::default()
        }
    }

    pub(super) fn next(&self) -> Option<HostInstant> {
        self.pauses_end
            .values()
            .copied()
            .chain(self.slots_due)
            .min()
    }
}

impl Station {
    pub(super) fn class_timeout(&mut self, now: HostInstant) {
        let control = &mut self.control;
        self.class.pauses_end.retain(|arm, end| {
            let is_over = *end <= now;
            if is_over {
                control.stop_frozen(*arm);
            }
            !is_over
        });
        if self.class.slots_due.is_some_and(|anew| anew <= now) {
            let first = self.class.slots_due == Some(HostInstant::ZERO);
            self.class.slots_due = None;
            // A schedule from the flag replaces the stored one, unless it is damaged.
            let is_good = self.class.schedule_error.is_none();
            if let Some(text) = self.config.schedule.clone().filter(|_| first && is_good) {
                self.class.files.write(SCHEDULE_FILE, text);
            }
            if first && let Some(mut file) = self.class.file.take() {
                file.make_codes(self.config.random);
                self.class.files.write(CLASS_FILE, file.to_text());
                self.begin_class(now, Some(file));
            }
            self.expand_slots(now);
        }
    }

    pub(super) fn class_call(&mut self, name: &str, call: &Call<'_>) -> Result<Handled, RpcError> {
        let now = call.now;
        let answer = match name {
            _ if name.starts_with("turn.") => self.turn_call(name, call)?,
            "class.get" => self.shown_class(now, call.grant.role),
            "class.set" => return self.set_class(call),
            "class.codes" => {
                let names = call.params.texts("pupils");
                let mut file = self.class.file.clone().ok_or_else(no_class)?;
                let dropped = file.drop_codes(names.as_deref());
                dropped.map_err(|error| class_error("pupils", error))?;
                file.make_codes(self.config.random);
                let text = file.to_text();
                let change = ClassChange::Class {
                    file: Some(Box::new(file)),
                    maker: None,
                    codes_kept: Vec::new(),
                };
                return self.change_class(call, change, text);
            }
            "class.freeze" | "class.free" => {
                let arms = self.selected_arms(call)?;
                let freezes = name == "class.freeze";
                for arm in arms.iter().copied() {
                    self.records.set_frozen(arm, freezes);
                    if !freezes {
                        self.control.free(now, arm);
                        continue;
                    }
                    self.control.freeze(now, arm, Some(call.session));
                    self.class
                        .pauses_end
                        .insert(arm, now + FREEZE_PAUSE_TIMEOUT);
                    let error = self.frozen(arm);
                    self.cancel_pending_starts(now, arm, &error);
                }
                let told = json!({"arms": self.names_of(&arms)});
                // In effect at once. The answer waits until the next start would know it as well.
                return Ok(self.answer_when_saved(call, arms, told, WriteFailurePolicy::Keep));
            }
            "class.send" => return self.send_to_arms(call),
            "class.results" => self.shown_results(),
            "schedule.get" => self.shown_schedule(now),
            "schedule.set" => {
                let text = call.params.text("text").unwrap_or_default();
                let schedule = Schedule::parse(text).map_err(|error| class_error("text", error))?;
                if !call.params.is_on("elsewhere") {
                    let has = |arm: &str| self.arm_named(Some(arm)).is_ok();
                    let arms = schedule.check_arms("this station", has);
                    arms.map_err(|error| class_error("text", error))?;
                }
                let change = ClassChange::Schedule(schedule);
                return self.change_class(call, change, text.to_owned());
            }
            "site.roster" => self.class.roster.to_value(),
            "site.expect" => {
                let roster = Roster::of(call.params.objects("arms"));
                let roster = roster.map_err(|why| RpcError::param("arms", why))?;
                let text = roster.to_value().to_string();
                return self.change_class(call, ClassChange::Roster(roster), text);
            }
            _ => return Err(RpcError::internal(format!("{name} does nothing"))),
        };
        Ok(Handled::Now(answer))
    }

    /// Sets the class from a file or from names, or ends it.
    fn set_class(&mut self, call: &Call<'_>) -> Result<Handled, RpcError> {
        let (text, names) = (call.params.text("text"), call.params.texts("names"));
        let (param, read) = match (text, &names) {
            (Some(text), None) if text.trim().is_empty() => ("text", None),
            (Some(text), None) => ("text", Some(ClassFile::parse(text))),
            (None, Some(names)) => {
                let arms = call.params.texts("arms").unwrap_or_default();
                let turn_s = call.params.integer("turn_s").map(|turn| turn as u32);
                let before = self.class.file.as_ref();
                let offset = call.params.text("offset");
                let file = ClassFile::of_names(names, &arms, turn_s, offset, before);
                ("names", Some(file))
            }
            _ => {
                let why = message!("a class is `text`, its file, or `names`, those of its pupils");
                return Err(RpcError::param("text", why));
            }
        };
        let file = read.transpose();
        let mut file = file.map_err(|error| class_error(param, error))?;
        let mut codes_kept = Vec::new();
        if let Some(file) = &mut file {
            if !call.params.is_on("elsewhere") {
                let has = |arm: &str| self.arm_named(Some(arm)).is_ok();
                let arms = file.check_arms("this station", has);
                arms.map_err(|error| class_error(param, error))?;
            }
            if let Some(before) = &self.class.file {
                // Pupils already have their codes on paper: a new file does not change them unless
                // asked to.
                codes_kept = file.keep_codes(before, call.params.is_on("use_codes"));
            }
            file.make_codes(self.config.random);
        }
        let text = file.as_ref().map_or_else(String::new, ClassFile::to_text);
        let change = ClassChange::Class {
            file: file.map(Box::new),
            maker: Some(call.session),
            codes_kept,
        };
        self.change_class(call, change, text)
    }

    /// Freezes the arms that were frozen when the last station ended, and stops what they still do.
    pub(super) fn restore_freezes(&mut self) {
        for arm in self.arm_ids() {
            if self.records.is_frozen(arm) {
                self.control.freeze(HostInstant::ZERO, arm, None);
            }
        }
    }

    /// Replaces the class. `None` ends it.
    pub(super) fn begin_class(&mut self, now: HostInstant, file: Option<ClassFile>) {
        let rules = file.as_ref().map(ClassFile::turns);
        self.class.fence = file.as_ref().and_then(|file| file.fence().ok()?);
        let before = std::mem::replace(&mut self.class.file, file);
        let file = self.class.file.as_ref();
        // Pupils whose code has changed have to sign in again.
        let is_same = |name: &str| {
            let (was, is) = (
                before.as_ref().and_then(|file| file.named(name)),
                file.and_then(|file| file.named(name)),
            );
            is.is_some() && was.is_none_or(|was| is.is_some_and(|is| was.code == is.code))
        };
        // Without a class before or after, no session has to sign in with another PIN.
        let is_pin_same = match (&before, file) {
            (Some(before), Some(file)) => before.class.pin == file.class.pin,
            _ => true,
        };
        let out: Vec<_> = { self.sessions.iter() }
            .filter(|(_, session)| match &session.pupil {
                Some(name) => !is_same(name),
                None => session.role_source == RoleSource::Pin && !is_pin_same,
            })
            .map(|(id, session)| (*id, session.socket))
            .collect();
        let is_gone = |person: &Person| matches!(person, Person::Pupil(name) if file.is_none_or(|file| file.named(name).is_none()));
        let has_to_sign_in =
            |person: &Person| matches!(person, Person::Pupil(name) if !is_same(name));
        let anew: Vec<_> = { (0..).map(PersonId).zip(&self.class.persons) }
            .filter(|(_, person)| has_to_sign_in(person))
            .map(|(id, _)| id)
            .collect();
        let gone: Vec<_> = { (0..).map(PersonId).zip(&self.class.persons) }
            .filter(|(_, person)| is_gone(person))
            .map(|(id, _)| id)
            .collect();
        for (session, socket) in out {
            if let Some(socket) = socket {
                self.end_socket(socket, CloseCode::REVOKED);
            }
            self.control.expel(now, session);
        }
        for person in anew {
            for arm in self.arm_ids() {
                self.end_queued_job(arm, Some(person));
            }
        }
        for person in gone {
            self.control.leave_turn(now, person);
            self.stop_queued_of(now, person);
        }
        self.identify_tokens(now);
        self.bar_groups(now);
        self.anonymous_role_changed(now);
        // Last, because it grants turns to the persons identified above.
        self.control.set_turns(now, rules);
    }

    pub(super) fn shown_class(&self, now: HostInstant, role: Role) -> Value {
        let Some(file) = &self.class.file else {
            return json!({"class": null, "groups": {}, "pupils": [], "pin": null, "text": null});
        };
        let teaches = role == Role::Teacher;
        let pupils = file.pupil.iter().map(|pupil| {
            let mut shown = json!({
                "name": pupil.name, "group": pupil.group, "code": null, "here": null, "place": null, "arm": null,
            });
            if teaches {
                let of = |person: &Person| matches!(person, Person::Pupil(name) if *name == pupil.name);
                shown["here"] = json!(self.is_here(&pupil.name));
                let number = self.class.persons.iter().position(of);
                let person = number.map(|at| PersonId(at as u64));
                let waits = |person| self.control.places().position(|place| place.person == person);
                shown["place"] = json!(person.and_then(waits).map(|at| at + 1));
                let has = |person| {
                    let turn = |arm: &ArmId| self.control.turn(now, *arm).map(|(turn, _)| turn.person);
                    self.arm_ids().find(|arm| turn(arm) == Some(person))
                };
                let arm = person.and_then(has).map(|arm| self.arm(arm).entry.name.as_str());
                shown["arm"] = json!(arm);
                shown["code"] = json!(pupil.code);
            }
            shown
        });
        let rules = &file.class;
        let class = json!({
            "turn_s": rules.turn_s, "grace_s": file.turns().grace.as_secs(),
            "finish_job": rules.finish_job, "speed": rules.speed, "fence": rules.fence, "arms": rules.arms,
        });
        json!({
            "class": class, "groups": file.groups, "pupils": pupils.collect::<Vec<_>>(),
            "pin": teaches.then_some(&file.class.pin), "text": teaches.then(|| file.to_text()),
        })
    }

    /// Returns the arm of a request, or those in `arms`, or all.
    pub(super) fn selected_arms(&self, call: &Call<'_>) -> Result<Vec<ArmId>, RpcError> {
        if let Some(arm) = call.arm {
            return Ok(vec![arm]);
        }
        let Some(names) = call.params.texts("arms") else {
            return Ok(self.arm_ids().collect());
        };
        let arms = names.iter().map(|name| self.arm_named(Some(name)));
        // A set: an arm that is named twice is used once.
        let arms: Result<BTreeSet<_>, _> = arms.collect();
        Ok(arms?.into_iter().collect())
    }

    pub(super) fn names_of(&self, arms: &[ArmId]) -> Vec<&str> {
        let names = arms.iter().map(|arm| self.arm(*arm).entry.name.as_str());
        names.collect()
    }

    pub(super) fn frozen(&self, arm: ArmId) -> RpcError {
        let name = &self.arm(arm).entry.name;
        let why = message!(
            "the teacher has frozen {name}: wait until it is freed",
            name
        );
        RpcError::new(RpcError::FROZEN, why).with("arm", name.clone())
    }

    /// True if the pupil has signed in and has a socket.
    fn is_here(&self, pupil: &str) -> bool {
        let mut sessions = self.sessions.values();
        sessions.any(|session| session.socket.is_some() && session.pupil.as_deref() == Some(pupil))
    }

    /// Returns the group of a pupil. `None` if the pupil has none.
    pub(super) fn group_of(&self, pupil: &str) -> Option<&str> {
        self.class.file.as_ref()?.named(pupil)?.group.as_deref()
    }
}

pub(super) fn class_error(param: &str, error: ClassError) -> RpcError {
    RpcError::param_quoting(param, &error.0)
}

pub(super) fn no_class() -> RpcError {
    let why = message!("this station has no class: a teacher gives it one first (class.set)");
    RpcError::arm(magician::ErrorKind::InvalidInput, why)
}
