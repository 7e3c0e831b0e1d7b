//! Record of a job, as clients see it and as it is stored.

use std::sync::Arc;

use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Value, json};

use super::jobs::is_under_way;
use crate::api::RpcError;
use crate::control::{ArmId, JobId, LeaseLossPolicy};
use crate::job_store::StoredRun;
use crate::order::{JobEnd, JobOrder};

/// Record of a job. Serialized fields are what clients see; the file has more (`to_file`).
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
    /// Number of loops; 0 for endless.
    #[serde(deserialize_with = "number_or_zero")]
    pub(super) loops: u64,
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
    /// Position in the queue of its arm, from 1.
    #[serde(default)]
    pub(super) place: Option<u64>,
    pub(super) error: Value,
    /// Notes on outputs left switched on. `None` without notes.
    #[serde(default)]
    pub(super) notes: Option<Vec<Value>>,
    /// Digest of the program. `None` until it is read.
    #[serde(default)]
    pub(super) digest: Option<String>,
    /// Program and options; only in the file.
    #[serde(skip)]
    pub(super) order: Option<Arc<JobOrder>>,
    /// Id within this station. `None` for a job of an earlier station.
    #[serde(skip)]
    pub(super) number: Option<JobId>,
    /// Arm within this station.
    #[serde(skip, default = "first_arm")]
    pub(super) at: ArmId,
    #[serde(skip)]
    pub(super) on_lost: LeaseLossPolicy,
    /// Fields that only the file has.
    #[serde(skip)]
    pub(super) hidden: Hidden,
    /// Pupil who started the job.
    #[cfg(feature = "class")]
    #[serde(skip)]
    pub(super) pupil: Option<String>,
    /// Record before a resume, until the job runs: a refused resume changes nothing.
    #[serde(skip)]
    pub(super) before: Option<Box<JobRecord>>,
    /// True once the program was read since the last start.
    #[serde(skip)]
    pub(super) is_read: bool,
    /// Finished steps over all loops.
    #[serde(skip)]
    done: u64,
}

/// Fields of a job that are stored but not shown.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Hidden {
    /// Idempotency key of the caller.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) key: Option<String>,
    /// Digest of the order. Kept longer than the order itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) digest: Option<String>,
    /// True if the job ever ran. Otherwise it has moved nothing.
    pub(super) ran: bool,
    /// Owner. `None` for a teacher.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) owner: Option<JobOwner>,
    /// Policy for the end of the lease.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) on_lost: Option<String>,
    /// Journal of the command line's run from which the job was taken over.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) run: Option<String>,
    /// True once a station has resumed that run.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub(super) went_on: bool,
}

/// Owner of a job.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum JobOwner {
    /// Pupil with this name.
    Pupil(String),
    /// Holder of the token with this name.
    Token(String),
}

const fn first_arm() -> ArmId {
    ArmId(0)
}

/// Reads a number. Files of older stations have null for an endless job.
fn number_or_zero<'de, D: Deserializer<'de>>(from: D) -> Result<u64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(0))
}

impl JobRecord {
    pub(super) fn new(
        id: String,
        (at, arm): (ArmId, String),
        number: JobId,
        order: JobOrder,
    ) -> Self {
        Self {
            id,
            arm,
            title: None,
            state: String::new(),
            step: 0,
            steps: None,
            first_step: None,
            loops: order.loops.unwrap_or(0),
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
            digest: None,
            order: Some(Arc::new(order)),
            number: Some(number),
            at,
            on_lost: LeaseLossPolicy::default(),
            hidden: Hidden::default(),
            #[cfg(feature = "class")]
            pupil: None,
            before: None,
            is_read: false,
            done: 0,
        }
    }

    /// Creates the record of an interrupted run of the command line.
    pub(super) fn of_run(id: String, of: (ArmId, String), run: StoredRun) -> Self {
        let mut record = Self::new(id, of, JobId(0), run.order.clone());
        record.number = None;
        "interrupted".clone_into(&mut record.state);
        record.first_step = Some(run.order.from + 1);
        record.hidden.ran = true;
        record.hidden.run = Some(run.name.clone());
        record.update_from_run(&run);
        record
    }

    /// Updates the progress of a run of the command line.
    pub(super) fn update_from_run(&mut self, run: &StoredRun) {
        if self.state != "interrupted" {
            return;
        }
        self.title = Some(run.title.clone()).filter(|title| !title.is_empty());
        self.steps = run.steps;
        (self.started, self.ended) = (Some(run.started), Some(run.ended));
        self.set_done(run.done);
    }

    /// Marks the job as started or resumed.
    pub(super) fn mark_started(&mut self, t: f64, holder: Value) {
        "checking".clone_into(&mut self.state);
        self.is_read = false;
        // A resumed job keeps its first start.
        self.started.get_or_insert(t);
        (self.ended, self.error, self.holder) = (None, Value::Null, holder);
        self.notes = None;
    }

    /// Sets the number of finished steps over all loops. Never decreases.
    pub(super) fn set_done(&mut self, done: u64) {
        self.done = self.done.max(done);
        let Some(steps) = self.steps.filter(|steps| *steps > 0) else {
            return;
        };
        let loops = self.done / steps;
        // The last step of a loop still belongs to it until the next loop has finished one.
        let (iteration, step) = match self.done % steps {
            0 if loops > 0 => (loops, steps),
            rest => (loops + 1, rest),
        };
        (self.iteration, self.step) = (iteration, step);
    }

    /// Marks the job as over.
    pub(super) fn mark_over(&mut self, t: f64, end: &JobEnd) {
        end.state.clone_into(&mut self.state);
        (self.reason, self.part, self.text) = (None, None, None);
        self.seconds_left = None;
        self.ended = Some(t);
        self.notes = Some(end.notes.clone()).filter(|notes| !notes.is_empty());
        if let Some([drawn, travelled]) = end.lengths {
            (self.drawn_mm, self.travel_mm) = (Some(drawn), Some(travelled));
        }
        if end.state == "done" {
            self.hidden.ran = true;
            if let Some(steps) = self.steps.filter(|_| self.loops > 0) {
                self.set_done(steps.saturating_mul(self.loops));
            }
            // A completed job cannot be resumed, so its program need not be kept.
            self.order = None;
        }
        self.error = end.error.as_ref().map_or(Value::Null, |error| {
            let mut details = json!({"kind": error.outcome(), "message": error.message});
            for (name, value) in &error.data {
                details[name] = value.clone();
            }
            details
        });
    }

    /// Returns the record as clients see it.
    pub(super) fn shown(&self) -> Value {
        serde_json::to_value(self).unwrap_or(Value::Null)
    }

    /// Returns the error with which the start was refused. `None` unless the job failed before it
    /// ran.
    pub(super) fn refusal(&self) -> Option<RpcError> {
        if self.state != "failed" || self.hidden.ran {
            return None;
        }
        let mut data = self.error.as_object()?.clone();
        let message = data.remove("message")?.as_str()?.to_owned();
        // The record stores the kind of the error. Its code follows from the kind.
        let of_kind = |code: &&i32| RpcError::new(**code, "").data.get("kind") == data.get("kind");
        let code = RpcError::CODES.iter().find(of_kind);
        let code = code.copied().unwrap_or(RpcError::ARM);
        Some(RpcError {
            code,
            message,
            data,
        })
    }

    /// Updates a record of an earlier station: a job that was in progress is interrupted. A queued
    /// job stays queued until a person resumes it. Returns true if it has changed.
    pub(super) fn restore(&mut self, t: f64) -> bool {
        if !is_under_way(&self.state) {
            return false;
        }
        "interrupted".clone_into(&mut self.state);
        (self.reason, self.part, self.text) = (None, None, None);
        self.place = None;
        (self.ended, self.seconds_left) = (Some(t), None);
        true
    }
}

/// Returns the digest of an order. The start position, which the station adds, is left out.
pub(super) fn digest(order: &JobOrder) -> String {
    let mut order = order.clone();
    order.start = None;
    let text = serde_json::to_string(&order).unwrap_or_default();
    crate::digest::digest(text.as_bytes(), &[])
}

/// Record in the form of the file.
#[derive(Serialize)]
struct StoredRecord<'a> {
    #[serde(flatten)]
    record: &'a JobRecord,
    kept: &'a Hidden,
    #[serde(skip_serializing_if = "Option::is_none")]
    order: Option<&'a JobOrder>,
}

/// Returns a record in the form of the file. A job that is being resumed has not moved yet, so it
/// is written as it was before.
pub(super) fn to_file(record: &JobRecord) -> Value {
    let record = record.before.as_deref().unwrap_or(record);
    let mut kept = StoredRecord {
        record,
        kept: &record.hidden,
        order: record.order.as_deref(),
    };
    let mut hidden = record.hidden.clone();
    hidden.on_lost = Some(record.on_lost.name().to_owned());
    kept.kept = &hidden;
    serde_json::to_value(kept).unwrap_or(Value::Null)
}

/// Returns the names of the parts that [`from_file`] drops, because they are damaged or belong to a
/// version with other parameters.
pub(super) fn lost_parts(item: &Value) -> Vec<&'static str> {
    let mut lost = Vec::new();
    if item
        .get("kept")
        .is_some_and(|kept| Hidden::deserialize(kept).is_err())
    {
        lost.push("kept");
    }
    if item
        .get("order")
        .is_some_and(|order| JobOrder::deserialize(order).is_err())
    {
        lost.push("order");
    }
    lost
}

/// Reads a record from a file. `None` if it is damaged. If only the order cannot be read, it is
/// dropped and the job stays in the list.
pub(super) fn from_file(mut item: Value, at: ArmId) -> Option<JobRecord> {
    let mut taken = |name| item.as_object_mut().and_then(|fields| fields.remove(name));
    let (order, hidden) = (taken("order"), taken("kept"));
    let mut record: JobRecord = serde_json::from_value(item).ok()?;
    record.at = at;
    let order = order.and_then(|order| serde_json::from_value(order).ok());
    record.order = order.map(Arc::new);
    let hidden = hidden.and_then(|hidden| serde_json::from_value(hidden).ok());
    // Files of older stations have no `kept`.
    record.hidden = hidden.unwrap_or_else(|| Hidden {
        ran: record.step > 0 || record.state == "done",
        ..Hidden::default()
    });
    record.on_lost = LeaseLossPolicy::named(record.hidden.on_lost.as_deref());
    Some(record)
}
