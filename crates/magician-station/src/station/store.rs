//! The jobs of a station as a store: what is kept of each arm, and what is on the disk.
//!
//! Each change of an arm's jobs has a number, its revision. The station hands out the newest state of an arm
//! ([`Station::poll_jobs`](super::Station::poll_jobs)) and is told what came of writing it
//! ([`Station::jobs_kept`](super::Station::jobs_kept)): an answer that promises something waits for that.

use std::collections::BTreeSet;
use std::time::Duration;

use magician_protocol::HostInstant;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::jobs::is_under_way;
use super::records::{JobRecord, from_file, lost_parts, to_file};
use crate::api::JOB_STATES;
use crate::control::{ArmId, JobId};
use crate::job::JobStore;

/// Form of the file that is written now. Form 1 was a list of jobs of all arms.
const VERSION: u64 = 2;
/// Jobs that `job.list` tells of.
const LISTED: usize = 50;
/// Jobs of an arm that are kept. What is older counts in the totals alone.
const KEPT: usize = 500;
/// Jobs of an arm whose program is kept, so that they can go on.
const PROGRAMS: usize = 8;
/// Time after which a disk that did not take the jobs is tried again.
const RETRY: Duration = Duration::from_secs(5);
/// Shortest time between two writes of the progress of a running job: after a crash the list of jobs is
/// this old at most, and a job of a thousand steps does not write its whole list a thousand times.
const PROGRESS_KEPT: Duration = Duration::from_secs(2);

/// Sums over jobs that ran.
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
    /// From the first start of each to its end, pauses included.
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
        if !record.hidden.ran {
            return;
        }
        *count += 1;
        self.jobs += 1;
        self.drawn_mm += record.drawn_mm.unwrap_or(0.0);
        self.travel_mm += record.travel_mm.unwrap_or(0.0);
        if let Some((started, ended)) = record.started.zip(record.ended) {
            self.seconds += (ended - started).max(0.0);
        }
    }

    fn rounded(mut self) -> Self {
        for sum in [&mut self.drawn_mm, &mut self.travel_mm, &mut self.seconds] {
            *sum = (*sum * 1000.0).round() / 1000.0;
        }
        self
    }
}

/// What is kept of one arm.
#[derive(Clone, Debug, Default)]
struct ArmShelf {
    /// True while a teacher has frozen the arm.
    frozen: bool,
    /// Sums over jobs that are kept no more.
    earlier: JobTotals,
    /// Number of the last change.
    revision: u64,
    /// The last one that was handed out to be written, and the last one that is on the disk.
    sent: u64,
    kept: u64,
    /// When a disk that failed is tried again.
    retry: Option<HostInstant>,
    /// When the progress of the running job was last handed out.
    progress: Option<HostInstant>,
}

/// The jobs of all arms, in the order in which they began.
#[derive(Debug, Default)]
pub(super) struct Records {
    all: Vec<JobRecord>,
    arms: Vec<ArmShelf>,
}

impl Records {
    /// Those that an earlier station has left, of so many arms: what was under way then is interrupted.
    pub(super) fn load(store: &dyn JobStore, names: &[&str], t: f64) -> Self {
        let mut records = Self {
            all: Vec::new(),
            arms: vec![ArmShelf::default(); names.len()],
        };
        for (at, name) in names.iter().enumerate() {
            let arm = ArmId(at as u64);
            let file = store.load(at);
            let (items, earlier) = match file {
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
                _ => continue,
            };
            records.arms[at].earlier = serde_json::from_value(earlier).unwrap_or_default();
            let mut changed = false;
            for mut record in items.into_iter().filter_map(|item| from_file(item, arm)) {
                // The arm may be called otherwise now.
                changed |= record.left(t) || record.arm != *name;
                (*name).clone_into(&mut record.arm);
                records.all.push(record);
            }
            records.arms[at].revision = u64::from(changed);
        }
        records
    }

    /// Adds a job. The oldest that is over gives way to it, and counts in the totals from then on.
    pub(super) fn push(&mut self, record: JobRecord) {
        let arm = record.at;
        self.all.push(record);
        self.has_changed(arm);
        let earlier = &mut self.arms[arm.0 as usize].earlier;
        let mut seen = 0;
        // From the newest on.
        self.all.reverse();
        self.all.retain_mut(|record| {
            if record.at != arm {
                return true;
            }
            seen += 1;
            let is_over = !is_under_way(&record.state) && record.state != "queued";
            if seen > PROGRAMS && is_over {
                record.order = None;
            }
            let stays = seen <= KEPT || !is_over;
            if !stays {
                earlier.add(record);
            }
            stays
        });
        self.all.reverse();
    }

    /// True if a teacher has frozen an arm.
    #[cfg(feature = "class")]
    pub(super) fn is_frozen(&self, arm: ArmId) -> bool {
        self.arms[arm.0 as usize].frozen
    }

    /// Notes that a teacher has frozen an arm, or freed it.
    #[cfg(feature = "class")]
    pub(super) fn set_frozen(&mut self, arm: ArmId, frozen: bool) {
        self.arms[arm.0 as usize].frozen = frozen;
        self.has_changed(arm);
    }

    /// Takes a job out, with its place; it counts in the totals all the same.
    pub(super) fn remove(&mut self, id: &str) -> Option<(usize, JobRecord)> {
        let at = self.all.iter().position(|record| record.id == id)?;
        let record = self.all.remove(at);
        self.arms[record.at.0 as usize].earlier.add(&record);
        self.has_changed(record.at);
        Some((at, record))
    }

    /// Takes that back.
    pub(super) fn put_back(&mut self, at: usize, record: JobRecord, totals: JobTotals) {
        let arm = record.at;
        self.arms[arm.0 as usize].earlier = totals;
        self.all.insert(at.min(self.all.len()), record);
        self.has_changed(arm);
    }

    /// The last jobs of an arm, as clients see them.
    pub(super) fn of(&self, arm: ArmId) -> Vec<Value> {
        let of: Vec<_> = { self.all.iter() }
            .filter(|record| record.at == arm)
            .collect();
        let from = of.len().saturating_sub(LISTED);
        of[from..].iter().map(|record| record.shown()).collect()
    }

    /// Jobs of an arm that are kept, without so many of the newest.
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

    /// Sums over jobs of an arm that are kept no more.
    pub(super) fn earlier(&self, arm: ArmId) -> JobTotals {
        self.arms[arm.0 as usize].earlier.clone()
    }

    pub(super) fn find(&self, id: &str) -> Option<&JobRecord> {
        self.all.iter().find(|record| record.id == id)
    }

    /// The job of an arm to which its caller gave this key.
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

    /// The job of an arm that is not over.
    pub(super) fn under_way(&self, arm: ArmId) -> Option<&JobRecord> {
        let mut of = { self.all.iter() }.filter(|record| record.at == arm);
        of.find(|record| is_under_way(&record.state))
    }

    /// All jobs, to be taken up or judged at the start.
    pub(super) fn each(&mut self) -> impl Iterator<Item = &mut JobRecord> {
        self.all.iter_mut()
    }

    /// Keeps those of which this holds.
    pub(super) fn retain(&mut self, keeps: impl Fn(&JobRecord) -> bool) {
        for at in 0..self.arms.len() {
            let goes = |record: &JobRecord| record.at.0 as usize == at && !keeps(record);
            if self.all.iter().any(goes) {
                self.has_changed(ArmId(at as u64));
            }
        }
        self.all.retain(keeps);
    }

    /// A job of the arm has changed; the number of that.
    pub(super) fn has_changed(&mut self, arm: ArmId) -> u64 {
        let shelf = &mut self.arms[arm.0 as usize];
        shelf.revision += 1;
        shelf.revision
    }

    /// Keeps the progress of the running job, at most once each [`PROGRESS_KEPT`].
    pub(super) fn progressed(&mut self, now: HostInstant, arm: ArmId) {
        let shelf = &mut self.arms[arm.0 as usize];
        if shelf
            .progress
            .is_none_or(|last| now >= last + PROGRESS_KEPT)
        {
            shelf.progress = Some(now);
            self.has_changed(arm);
        }
    }

    /// Number of the last change of an arm's jobs.
    pub(super) fn revision(&self, arm: ArmId) -> u64 {
        self.arms[arm.0 as usize].revision
    }

    /// True if this change is on the disk.
    pub(super) fn is_kept(&self, arm: ArmId, revision: u64) -> bool {
        self.arms[arm.0 as usize].kept >= revision
    }

    /// What came of writing a revision. After a failure the newest is handed out again, with the next change or a moment
    /// later.
    pub(super) fn was_written(&mut self, now: HostInstant, arm: ArmId, revision: u64, ok: bool) {
        let shelf = &mut self.arms[arm.0 as usize];
        if ok {
            shelf.kept = shelf.kept.max(revision);
            shelf.retry = None;
        } else {
            shelf.retry = Some(now + RETRY);
        }
    }

    /// When a disk that failed is tried again.
    pub(super) fn due(&self) -> Option<HostInstant> {
        self.arms.iter().filter_map(|shelf| shelf.retry).min()
    }

    /// Hands out again what a disk did not take, if that is due. `at_once`: it is, for this is the end.
    pub(super) fn try_again(&mut self, now: HostInstant, at_once: bool) {
        for shelf in &mut self.arms {
            if shelf.retry.is_some_and(|retry| at_once || retry <= now) {
                (shelf.retry, shelf.sent) = (None, shelf.kept);
            }
        }
    }

    /// What is to be kept now, if it is something else than before.
    pub(super) fn take_changed(&mut self) -> Option<JobsToKeep> {
        let at = { self.arms.iter() }.position(|shelf| shelf.revision > shelf.sent)?;
        let shelf = &mut self.arms[at];
        shelf.sent = shelf.revision;
        let arm = ArmId(at as u64);
        let jobs = self.all.iter().filter(|record| record.at == arm);
        Some(JobsToKeep {
            arm,
            revision: shelf.revision,
            frozen: shelf.frozen,
            earlier: shelf.earlier.clone(),
            jobs: jobs.cloned().collect(),
        })
    }
}

/// The jobs of an arm as they were once, and whether it is frozen, to be kept. Their programs are shared with the station, not copied.
#[derive(Clone, Debug)]
pub struct JobsToKeep {
    arm: ArmId,
    revision: u64,
    frozen: bool,
    earlier: JobTotals,
    jobs: Vec<JobRecord>,
}

impl JobsToKeep {
    /// The arm that they are of, by its place among those of the station.
    #[must_use]
    pub fn arm(&self) -> usize {
        self.arm.0 as usize
    }

    /// Number of the change that it has; later ones are of a higher number.
    #[must_use]
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// As a file has them. This copies the programs: not to be asked where others wait.
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

/// A file of a station's class as it was once, to be kept.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileToKeep {
    /// Number of the text; later ones are of a higher number.
    pub revision: u64,
    /// Its content.
    pub text: String,
}

/// Checks that a station of this version reads a file of jobs as a whole.
///
/// # Errors
/// A sentence that says why it does not: damaged, or of a later version.
pub fn check_jobs(file: &Value) -> Result<(), String> {
    let items = match file {
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
        if !known.insert(job.id) {
            return Err(format!("its job {number} has the id of another one"));
        }
    }
    Ok(())
}

/// What of a file of jobs that is good as a whole is lost to a station that reads it: a sentence for each job.
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
