//! Jobs of all arms in memory, and their revisions on the disk.
//!
//! Each change of an arm's jobs gets a number, its revision. The station hands out the newest
//! version of an arm ([`Station::poll_jobs`](super::Station::poll_jobs)) and gets the result of
//! writing it ([`Station::jobs_written`](super::Station::jobs_written)). Answers that promise
//! durability wait for that revision. If the disk fails, the version is handed out again after a
//! while.

use std::collections::BTreeSet;
use std::time::Duration;

use magician_protocol::HostInstant;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::jobs::is_under_way;
use super::records::{JobRecord, from_file, lost_parts, to_file};
use crate::api::JOB_STATES;
use crate::control::{ArmId, JobId};
use crate::job_store::JobStore;

/// Version of the file that is written. Version 1 was a list of jobs of all arms.
const VERSION: u64 = 2;
/// Number of jobs in an answer to `job.list`.
const MAX_LISTED_JOBS: usize = 50;
/// Number of jobs kept per arm. Older ones count in the totals only.
const MAX_JOBS_PER_ARM: usize = 500;
/// Number of jobs per arm whose program is kept, so that they can be resumed. Programs may be
/// large.
const MAX_STORED_PROGRAMS: usize = 8;
/// Interval after which a failed write is repeated.
const RETRY_INTERVAL: Duration = Duration::from_secs(5);
/// Shortest time between two writes of the progress of a running job: after a crash the list of
/// jobs is this old at most, and a job of a thousand steps does not write its whole list a thousand
/// times.
const PROGRESS_WRITE_INTERVAL: Duration = Duration::from_secs(2);

/// Totals over jobs that ran.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct JobTotals {
    jobs: u64,
    done: u64,
    stopped: u64,
    failed: u64,
    interrupted: u64,
    drawn_mm: f64,
    travel_mm: f64,
    /// Sum of times from first start to end, pauses included, s.
    seconds: f64,
}

impl JobTotals {
    fn add(&mut self, record: &JobRecord) {
        let count = match record.state.as_str() {
            "done" => &mut self.done,
            "stopped" => &mut self.stopped,
            "failed" => &mut self.failed,
            "interrupted" => &mut self.interrupted,
            _ => return,
        };
        // Refused jobs moved nothing and do not count.
        if !record.hidden.ran {
            return;
        }
        *count += 1;
        self.jobs += 1;
        self.drawn_mm += record.drawn_mm.unwrap_or(0.0);
        self.travel_mm += record.travel_mm.unwrap_or(0.0);
        if let Some((started, ended)) = record.started.zip(record.ended) {
            // The clock may have been set back between start and end.
            self.seconds += (ended - started).max(0.0);
        }
    }

    fn rounded(mut self) -> Self {
        // Digits beyond thousandths are rounding errors of the sum.
        for sum in [&mut self.drawn_mm, &mut self.travel_mm, &mut self.seconds] {
            *sum = (*sum * 1000.0).round() / 1000.0;
        }
        self
    }
}

/// Stored state of one arm.
#[derive(Clone, Debug, Default)]
struct StoredArmState {
    /// True while a teacher has frozen the arm.
    frozen: bool,
    /// Totals over jobs that are no longer kept.
    earlier: JobTotals,
    /// Revision of the last change.
    revision: u64,
    /// Revision handed out last, and revision on the disk.
    sent: u64,
    written: u64,
    /// Instant at which a failed write is repeated.
    retry: Option<HostInstant>,
    /// When the progress of the running job was last handed out.
    progress: Option<HostInstant>,
}

/// Jobs of all arms, in the order of their start.
#[derive(Debug, Default)]
pub(super) struct Records {
    all: Vec<JobRecord>,
    arms: Vec<StoredArmState>,
}

impl Records {
    /// Loads the jobs of an earlier station. Jobs that were in progress become interrupted.
    pub(super) fn load(store: &dyn JobStore, names: &[&str], t: f64) -> Self {
        let mut records = Self {
            all: Vec::new(),
            arms: vec![StoredArmState::default(); names.len()],
        };
        for (at, name) in names.iter().enumerate() {
            let arm = ArmId(at as u64);
            let file = store.load(at);
            let (items, earlier) = match file {
                // Version 1.
                Value::Array(items) => (items, Value::Null),
                Value::Object(mut file) => {
                    records.arms[at].frozen = file.get("frozen") == Some(&Value::Bool(true));
                    let jobs = file.remove("jobs");
                    let earlier = file.remove("earlier").unwrap_or_default();
                    let items = jobs.and_then(|jobs| match jobs {
                        Value::Array(items) => Some(items),
                        _ => None,
                    });
                    (items.unwrap_or_default(), earlier)
                }
                // No file, or one of a form that `check_jobs` has already refused.
                _ => continue,
            };
            records.arms[at].earlier = serde_json::from_value(earlier).unwrap_or_default();
            let mut changed = false;
            for mut record in items.into_iter().filter_map(|item| from_file(item, arm)) {
                // The arm may have been renamed.
                changed |= record.restore(t) || record.arm != *name;
                (*name).clone_into(&mut record.arm);
                records.all.push(record);
            }
            records.arms[at].revision = u64::from(changed);
        }
        records
    }

    /// Adds a job. If there are too many, the oldest that is over is dropped and added to the
    /// totals.
    pub(super) fn push(&mut self, record: JobRecord) {
        let arm = record.at;
        self.all.push(record);
        self.note_change(arm);
        let earlier = &mut self.arms[arm.0 as usize].earlier;
        let mut seen = 0;
        // Newest first, so that counting stops at the limits.
        self.all.reverse();
        self.all.retain_mut(|record| {
            if record.at != arm {
                return true;
            }
            seen += 1;
            let is_over = !is_under_way(&record.state) && record.state != "queued";
            if seen > MAX_STORED_PROGRAMS && is_over {
                record.order = None;
            }
            let stays = seen <= MAX_JOBS_PER_ARM || !is_over;
            if !stays {
                earlier.add(record);
            }
            stays
        });
        self.all.reverse();
    }

    /// True if a teacher has frozen the arm.
    #[cfg(feature = "class")]
    pub(super) fn is_frozen(&self, arm: ArmId) -> bool {
        self.arms[arm.0 as usize].frozen
    }

    /// Records that a teacher has frozen or freed an arm.
    #[cfg(feature = "class")]
    pub(super) fn set_frozen(&mut self, arm: ArmId, frozen: bool) {
        self.arms[arm.0 as usize].frozen = frozen;
        self.note_change(arm);
    }

    /// Removes a job and adds it to the totals. Returns it with its position.
    pub(super) fn remove(&mut self, id: &str) -> Option<(usize, JobRecord)> {
        let at = self.all.iter().position(|record| record.id == id)?;
        let record = self.all.remove(at);
        self.arms[record.at.0 as usize].earlier.add(&record);
        self.note_change(record.at);
        Some((at, record))
    }

    /// Undoes [`remove`](Self::remove).
    pub(super) fn restore_job(&mut self, at: usize, record: JobRecord, totals: JobTotals) {
        let arm = record.at;
        self.arms[arm.0 as usize].earlier = totals;
        // Other jobs may have been dropped since.
        self.all.insert(at.min(self.all.len()), record);
        self.note_change(arm);
    }

    /// Returns the last jobs of an arm, as clients see them.
    pub(super) fn of(&self, arm: ArmId) -> Vec<Value> {
        let of: Vec<_> = { self.all.iter() }
            .filter(|record| record.at == arm)
            .collect();
        let from = of.len().saturating_sub(MAX_LISTED_JOBS);
        of[from..].iter().map(|record| record.shown()).collect()
    }

    /// Returns jobs of an arm without the `skip` newest, and the totals.
    pub(super) fn history(&self, arm: ArmId, skip: usize, limit: usize) -> Value {
        let of: Vec<_> = { self.all.iter() }
            .filter(|record| record.at == arm)
            .collect();
        let until = of.len().saturating_sub(skip);
        let from = until.saturating_sub(limit);
        let jobs: Vec<_> = of[from..until].iter().map(|job| job.shown()).collect();
        let mut totals = self.earlier(arm);
        of.iter().for_each(|record| totals.add(record));
        json!({"jobs": jobs, "more": from > 0, "totals": totals.rounded()})
    }

    /// Returns the totals over jobs of an arm that are no longer kept.
    pub(super) fn earlier(&self, arm: ArmId) -> JobTotals {
        self.arms[arm.0 as usize].earlier.clone()
    }

    pub(super) fn find(&self, id: &str) -> Option<&JobRecord> {
        self.all.iter().find(|record| record.id == id)
    }

    /// Returns the job of an arm with this idempotency key.
    pub(super) fn keyed(&self, arm: ArmId, key: &str) -> Option<&JobRecord> {
        let mut of = { self.all.iter().rev() }.filter(|record| record.at == arm);
        of.find(|record| record.hidden.key.as_deref() == Some(key))
    }

    pub(super) fn named(&mut self, id: &str) -> Option<&mut JobRecord> {
        self.all.iter_mut().find(|record| record.id == id)
    }

    pub(super) fn numbered(&mut self, job: JobId) -> Option<&mut JobRecord> {
        { self.all.iter_mut() }.find(|record| record.number == Some(job))
    }

    pub(super) fn with_number(&self, job: JobId) -> Option<&JobRecord> {
        self.all.iter().find(|record| record.number == Some(job))
    }

    pub(super) fn id_of(&self, job: JobId) -> Option<String> {
        self.with_number(job).map(|record| record.id.clone())
    }

    /// Returns the job of an arm that is in progress.
    pub(super) fn under_way(&self, arm: ArmId) -> Option<&JobRecord> {
        let mut of = { self.all.iter() }.filter(|record| record.at == arm);
        of.find(|record| is_under_way(&record.state))
    }

    /// Returns all jobs, for changes at the start.
    pub(super) fn each(&mut self) -> impl Iterator<Item = &mut JobRecord> {
        self.all.iter_mut()
    }

    /// Keeps only the jobs for which `keeps` holds.
    pub(super) fn retain(&mut self, keeps: impl Fn(&JobRecord) -> bool) {
        for at in 0..self.arms.len() {
            let goes = |record: &JobRecord| record.at.0 as usize == at && !keeps(record);
            if self.all.iter().any(goes) {
                self.note_change(ArmId(at as u64));
            }
        }
        self.all.retain(keeps);
    }

    /// Records a change of an arm's jobs. Returns its revision.
    pub(super) fn note_change(&mut self, arm: ArmId) -> u64 {
        let shelf = &mut self.arms[arm.0 as usize];
        shelf.revision += 1;
        shelf.revision
    }

    /// Keeps the progress of the running job, at most once each [`PROGRESS_WRITE_INTERVAL`].
    pub(super) fn note_progress(&mut self, now: HostInstant, arm: ArmId) {
        let shelf = &mut self.arms[arm.0 as usize];
        if shelf
            .progress
            .is_none_or(|last| now >= last + PROGRESS_WRITE_INTERVAL)
        {
            shelf.progress = Some(now);
            self.note_change(arm);
        }
    }

    /// Returns the revision of an arm's jobs.
    pub(super) fn revision(&self, arm: ArmId) -> u64 {
        self.arms[arm.0 as usize].revision
    }

    /// True if this revision is on the disk.
    pub(super) fn is_written(&self, arm: ArmId, revision: u64) -> bool {
        self.arms[arm.0 as usize].written >= revision
    }

    /// Records the result of writing a revision. After a failure the newest version is handed out
    /// again with the next change, or after [`RETRY_INTERVAL`].
    pub(super) fn note_written(&mut self, now: HostInstant, arm: ArmId, revision: u64, ok: bool) {
        let shelf = &mut self.arms[arm.0 as usize];
        if ok {
            shelf.written = shelf.written.max(revision);
            shelf.retry = None;
        } else {
            shelf.retry = Some(now + RETRY_INTERVAL);
        }
    }

    /// Returns the next time at which a failed write is repeated.
    pub(super) fn due(&self) -> Option<HostInstant> {
        self.arms.iter().filter_map(|shelf| shelf.retry).min()
    }

    /// Hands out versions again that the disk refused, if that is due. `at_once` ignores the
    /// interval, for the end of the program.
    pub(super) fn retry_writes(&mut self, now: HostInstant, at_once: bool) {
        for shelf in &mut self.arms {
            if shelf.retry.is_some_and(|retry| at_once || retry <= now) {
                // `poll_jobs` then finds the newest revision unsent.
                (shelf.retry, shelf.sent) = (None, shelf.written);
            }
        }
    }

    /// Returns the jobs of an arm that have changed since they were handed out.
    pub(super) fn take_changed(&mut self) -> Option<JobsSnapshot> {
        let at = { self.arms.iter() }.position(|shelf| shelf.revision > shelf.sent)?;
        let shelf = &mut self.arms[at];
        shelf.sent = shelf.revision;
        let arm = ArmId(at as u64);
        let jobs = self.all.iter().filter(|record| record.at == arm);
        Some(JobsSnapshot {
            arm,
            revision: shelf.revision,
            frozen: shelf.frozen,
            earlier: shelf.earlier.clone(),
            jobs: jobs.cloned().collect(),
        })
    }
}

/// Snapshot of an arm's jobs, to be written. Programs are shared with the station, not copied.
#[derive(Clone, Debug)]
pub struct JobsSnapshot {
    arm: ArmId,
    revision: u64,
    frozen: bool,
    earlier: JobTotals,
    jobs: Vec<JobRecord>,
}

impl JobsSnapshot {
    /// Returns the index of the arm.
    #[must_use]
    pub fn arm(&self) -> usize {
        self.arm.0 as usize
    }

    /// Returns the revision of the snapshot. Later ones have higher numbers.
    #[must_use]
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Returns the content of the file. Copies the programs: do not call it on the station's
    /// thread.
    #[must_use]
    pub fn to_value(&self) -> Value {
        let jobs: Vec<_> = self.jobs.iter().map(to_file).collect();
        let mut file = json!({"version": VERSION, "earlier": self.earlier, "jobs": jobs});
        if self.frozen {
            file["frozen"] = true.into();
        }
        file
    }

    #[cfg(test)]
    pub(crate) fn of_ids(ids: &[&str]) -> Self {
        let record = |id: &&str| {
            let item = json!({"job": id, "arm": "", "state": "", "step": 0, "loops": 1, "loop": 1, "holder": null, "error": null});
            from_file(item, ArmId(0))
        };
        Self {
            arm: ArmId(0),
            revision: 1,
            frozen: false,
            earlier: JobTotals::default(),
            jobs: ids.iter().filter_map(record).collect(),
        }
    }
}

/// Snapshot of a file of a class, to be written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileSnapshot {
    /// Revision of the text. Later ones have higher numbers.
    pub revision: u64,
    /// Content.
    pub text: String,
}

/// Checks that this version can read the whole file of jobs.
///
/// # Errors
/// Sentence that says why not: it is damaged, or of a later version.
pub fn check_jobs(file: &Value) -> Result<(), String> {
    let items = match file {
        // Version 1 was a bare list.
        Value::Array(items) => items,
        Value::Object(members) => {
            match members.get("version").and_then(Value::as_u64) {
                Some(VERSION) => {}
                Some(other) => {
                    return Err(format!(
                        "it is of version {other}, and this program reads up to {VERSION}"
                    ));
                }
                None => return Err("it names no version".to_owned()),
            }
            if members
                .get("frozen")
                .is_some_and(|frozen| !frozen.is_boolean())
            {
                return Err("it does not say whether its arm is frozen".to_owned());
            }
            let earlier = members.get("earlier").unwrap_or(&Value::Null);
            if !earlier.is_null() && JobTotals::deserialize(earlier).is_err() {
                return Err("its sums of earlier jobs are no sums".to_owned());
            }
            let jobs = members.get("jobs").and_then(Value::as_array);
            jobs.ok_or("it has no list of jobs")?
        }
        _ => return Err("it is no list of jobs".to_owned()),
    };
    let mut known = BTreeSet::new();
    for (at, item) in items.iter().enumerate() {
        let number = at + 1;
        let job = from_file(item.clone(), ArmId(0));
        let job = job.ok_or_else(|| format!("its job {number} is no job"))?;
        if !JOB_STATES.contains(&job.state.as_str()) {
            return Err(format!("its job {number} has no state that is known"));
        }
        // Clients name a job by its id, so a second job with the same id could never be named.
        if !known.insert(job.id) {
            return Err(format!("its job {number} has the id of another one"));
        }
    }
    Ok(())
}

/// Returns a sentence for each job in a readable file that has lost some of its parts.
#[must_use]
pub fn damaged_jobs(file: &Value) -> Vec<String> {
    let items = file.get("jobs").unwrap_or(file).as_array();
    let sentence = |item: &Value| {
        let parts = lost_parts(item);
        let lost = |part: &&str| match *part {
            "order" => "its program, so it cannot go on",
            _ => "whose it is, its key and its rules, so it is a teacher's",
        };
        let lost: Vec<_> = parts.iter().map(lost).collect();
        let job = magician_protocol::visible(item["job"].as_str().unwrap_or_default());
        (!lost.is_empty()).then(|| format!("job {job} has lost {}", lost.join("; and ")))
    };
    items.into_iter().flatten().filter_map(sentence).collect()
}
