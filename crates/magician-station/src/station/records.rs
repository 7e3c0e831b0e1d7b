//! What is known of jobs, also of those of earlier stations.

use std::sync::Arc;

use magician_protocol::HostInstant;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::jobs::is_under_way;
use crate::control::{JobId, OnLost};
use crate::order::{JobEnd, JobOrder};

/// Jobs of an arm that are kept.
const KEPT: usize = 50;
/// Jobs of an arm whose program is kept, so that they can go on.
const PROGRAMS: usize = 8;

/// A job, as clients see it and as it is kept.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct JobRecord {
    #[serde(rename = "job")]
    pub(super) id: String,
    pub(super) arm: String,
    pub(super) title: Option<String>,
    pub(super) state: String,
    pub(super) step: u64,
    pub(super) steps: Option<u64>,
    pub(super) first_step: Option<u64>,
    pub(super) loops: Option<u64>,
    #[serde(rename = "loop")]
    pub(super) iteration: u64,
    pub(super) seconds_left: Option<f64>,
    pub(super) drawn_mm: Option<f64>,
    pub(super) travel_mm: Option<f64>,
    pub(super) started: Option<f64>,
    pub(super) ended: Option<f64>,
    pub(super) holder: Value,
    pub(super) part: Option<u64>,
    pub(super) reason: Option<String>,
    pub(super) text: Option<String>,
    /// Its place in the queue of its arm, from 1.
    #[serde(default)]
    pub(super) place: Option<u64>,
    pub(super) error: Value,
    /// What it has left switched on. `None` if nothing is.
    #[serde(default)]
    pub(super) notes: Option<Vec<Value>>,
    /// What it does; for the file alone.
    #[serde(skip)]
    pub(super) order: Option<Arc<JobOrder>>,
    /// Its number in this station, since it began here.
    #[serde(skip)]
    pub(super) number: Option<JobId>,
    #[serde(skip)]
    pub(super) on_lost: OnLost,
    /// The pupil who began it.
    #[cfg(feature = "class")]
    #[serde(skip)]
    pub(super) pupil: Option<String>,
    /// When it was told last.
    #[serde(skip)]
    pub(super) told: Option<HostInstant>,
    /// Steps that are done, over all loops.
    #[serde(skip)]
    done: u64,
}

impl JobRecord {
    pub(super) fn new(id: String, arm: String, number: JobId, order: JobOrder) -> Self {
        Self {
            id,
            arm,
            title: None,
            state: String::new(),
            step: 0,
            steps: None,
            first_step: None,
            loops: order.loops,
            iteration: 1,
            seconds_left: None,
            drawn_mm: None,
            travel_mm: None,
            started: None,
            ended: None,
            holder: Value::Null,
            part: None,
            reason: None,
            text: None,
            place: None,
            error: Value::Null,
            notes: None,
            order: Some(Arc::new(order)),
            number: Some(number),
            on_lost: OnLost::default(),
            #[cfg(feature = "class")]
            pupil: None,
            told: None,
            done: 0,
        }
    }

    /// It begins, or goes on.
    pub(super) fn begins(&mut self, t: f64, holder: Value) {
        "checking".clone_into(&mut self.state);
        self.started.get_or_insert(t);
        (self.ended, self.error, self.holder) = (None, Value::Null, holder);
        self.notes = None;
    }

    /// So many steps are done, over all loops. It never goes back.
    pub(super) fn reaches(&mut self, done: u64) {
        self.done = self.done.max(done);
        let Some(steps) = self.steps.filter(|steps| *steps > 0) else {
            return;
        };
        let loops = self.done / steps;
        // The last step of a loop is one of that loop, until the next loop has one.
        let (iteration, step) = match self.done % steps {
            0 if loops > 0 => (loops, steps),
            rest => (loops + 1, rest),
        };
        (self.iteration, self.step) = (iteration, step);
    }

    /// It is over.
    pub(super) fn is_over(&mut self, t: f64, end: &JobEnd) {
        end.state.clone_into(&mut self.state);
        (self.reason, self.part, self.text) = (None, None, None);
        self.seconds_left = None;
        self.ended = Some(t);
        self.notes = Some(end.notes.clone()).filter(|notes| !notes.is_empty());
        if let Some([drawn, travelled]) = end.lengths {
            (self.drawn_mm, self.travel_mm) = (Some(drawn), Some(travelled));
        }
        if end.state == "done" {
            if let (Some(steps), Some(loops)) = (self.steps, self.loops) {
                self.reaches(steps.saturating_mul(loops));
            }
            self.order = None;
        }
        self.error = end.error.as_ref().map_or(Value::Null, |error| {
            let mut told = json!({"kind": error.outcome(), "message": error.message});
            for (name, value) in &error.data {
                told[name] = value.clone();
            }
            told
        });
    }

    /// As clients see it.
    pub(super) fn shown(&self) -> Value {
        serde_json::to_value(self).unwrap_or(Value::Null)
    }
}

/// A job as its file has it: with what it does, so that it can go on.
#[derive(Serialize)]
struct Kept<'a> {
    #[serde(flatten)]
    record: &'a JobRecord,
    #[serde(skip_serializing_if = "Option::is_none")]
    order: Option<&'a JobOrder>,
}

impl<'a> From<&'a JobRecord> for Kept<'a> {
    fn from(record: &'a JobRecord) -> Self {
        let order = record.order.as_deref();
        Self { record, order }
    }
}

/// Reads one.
fn kept(mut item: Value) -> Option<JobRecord> {
    let order = item
        .as_object_mut()
        .and_then(|fields| fields.remove("order"));
    let mut record: JobRecord = serde_json::from_value(item).ok()?;
    if let Some(order) = order {
        record.order = Some(Arc::new(serde_json::from_value(order).ok()?));
    }
    Some(record)
}

/// The jobs of all arms, in the order in which they began.
#[derive(Debug, Default)]
pub(super) struct Records {
    all: Vec<JobRecord>,
    changed: bool,
}

impl Records {
    /// Those that an earlier station has left: what was under way then is interrupted.
    pub(super) fn load(jobs: Value, t: f64) -> Self {
        let items = match jobs {
            Value::Array(items) => items,
            _ => Vec::new(),
        };
        let mut all: Vec<_> = items.into_iter().filter_map(kept).collect();
        let mut changed = false;
        let left =
            |record: &&mut JobRecord| is_under_way(&record.state) || record.state == "queued";
        for record in all.iter_mut().filter(left) {
            "interrupted".clone_into(&mut record.state);
            (record.reason, record.part, record.text) = (None, None, None);
            record.place = None;
            (record.ended, record.seconds_left) = (Some(t), None);
            changed = true;
        }
        Self { all, changed }
    }

    pub(super) fn push(&mut self, record: JobRecord) {
        let arm = record.arm.clone();
        self.all.push(record);
        let mut seen = 0;
        // From the newest on.
        self.all.reverse();
        self.all.retain_mut(|record| {
            if record.arm != arm {
                return true;
            }
            seen += 1;
            let waits = record.state == "queued";
            if seen > PROGRAMS && !is_under_way(&record.state) && !waits {
                record.order = None;
            }
            seen <= KEPT
        });
        self.all.reverse();
    }

    /// The jobs of an arm, as clients see them.
    pub(super) fn of(&self, arm: &str) -> Vec<Value> {
        let of = self.all.iter().filter(|record| record.arm == arm);
        of.map(JobRecord::shown).collect()
    }

    pub(super) fn find(&self, id: &str) -> Option<&JobRecord> {
        self.all.iter().find(|record| record.id == id)
    }

    pub(super) fn named(&mut self, id: &str) -> Option<&mut JobRecord> {
        self.all.iter_mut().find(|record| record.id == id)
    }

    pub(super) fn numbered(&mut self, job: JobId) -> Option<&mut JobRecord> {
        { self.all.iter_mut() }.find(|record| record.number == Some(job))
    }

    pub(super) fn id_of(&self, job: JobId) -> Option<String> {
        let record = { self.all.iter() }.find(|record| record.number == Some(job));
        record.map(|record| record.id.clone())
    }

    /// The job of an arm that is not over.
    pub(super) fn under_way(&self, arm: &str) -> Option<&JobRecord> {
        let mut of = self.all.iter().filter(|record| record.arm == arm);
        of.find(|record| is_under_way(&record.state))
    }

    pub(super) fn has_changed(&mut self) {
        self.changed = true;
    }

    /// What is to be kept now, if it is something else than before.
    pub(super) fn take_changed(&mut self) -> Option<JobsToKeep> {
        std::mem::take(&mut self.changed).then(|| JobsToKeep(self.all.clone()))
    }
}

/// The jobs of a station as they were once, to be kept. Their programs are shared with the station, not copied.
#[derive(Clone, Debug)]
pub struct JobsToKeep(Vec<JobRecord>);

impl JobsToKeep {
    /// As a file has them. This copies the programs: not to be asked where others wait.
    #[must_use]
    pub fn to_value(&self) -> Value {
        let all: Vec<_> = self.0.iter().map(Kept::from).collect();
        serde_json::to_value(all).unwrap_or(Value::Null)
    }

    #[cfg(test)]
    pub(crate) fn of_ids(ids: &[&str]) -> Self {
        let record = |id: &&str| json!({"job": id, "arm": "", "state": "", "step": 0, "loop": 1, "holder": null, "error": null});
        Self(ids.iter().filter_map(|id| kept(record(id))).collect())
    }
}
