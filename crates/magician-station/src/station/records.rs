//! A job as clients see it and as it is kept.

use std::sync::Arc;

use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Value, json};

use super::jobs::is_under_way;
use crate::api::RpcError;
use crate::control::{ArmId, JobId, OnLost};
use crate::job::KeptRun;
use crate::order::{JobEnd, JobOrder};

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
    /// Number of times; 0 until it is stopped.
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
    /// The arm that it is of, in this station.
    #[serde(skip, default = "first_arm")]
    pub(super) at: ArmId,
    #[serde(skip)]
    pub(super) on_lost: OnLost,
    /// What the file alone has.
    #[serde(skip)]
    pub(super) hidden: Hidden,
    /// The pupil who began it.
    #[cfg(feature = "class")]
    #[serde(skip)]
    pub(super) pupil: Option<String>,
    /// The job as it was before it was resumed, until it runs: a refused resume changes nothing.
    #[serde(skip)]
    pub(super) before: Option<Box<JobRecord>>,
    /// True once its program was read, since it began last.
    #[serde(skip)]
    pub(super) is_read: bool,
    /// Steps that are done, over all loops.
    #[serde(skip)]
    done: u64,
}

/// What is kept of a job beside what clients see.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Hidden {
    /// Name that its caller chose for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) key: Option<String>,
    /// Digest of its order, which outlives the order.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) digest: Option<String>,
    /// True once it ran. One that did not moved nothing.
    pub(super) ran: bool,
    /// Whose it is; `None`: a teacher's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) owner: Option<JobOwner>,
    /// Policy for the end of the lease.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) on_lost: Option<String>,
    /// Run of the command line that it was taken over from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) run: Option<String>,
    /// True once a station has gone on with that.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub(super) went_on: bool,
}

/// Whose a job is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum JobOwner {
    /// A pupil of this name.
    Pupil(String),
    /// Whoever has the token of this name.
    Token(String),
}

const fn first_arm() -> ArmId {
    ArmId(0)
}

/// Older stations wrote null for a job without end.
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
            order: Some(Arc::new(order)),
            number: Some(number),
            at,
            on_lost: OnLost::default(),
            hidden: Hidden::default(),
            #[cfg(feature = "class")]
            pupil: None,
            before: None,
            is_read: false,
            done: 0,
        }
    }

    /// A run of the command line that was interrupted.
    pub(super) fn of_run(id: String, of: (ArmId, String), run: KeptRun) -> Self {
        let mut record = Self::new(id, of, JobId(0), run.order.clone());
        record.number = None;
        "interrupted".clone_into(&mut record.state);
        record.first_step = Some(run.order.from + 1);
        record.hidden.ran = true;
        record.hidden.run = Some(run.name.clone());
        record.ran_on(&run);
        record
    }

    /// How far a run of the command line is.
    pub(super) fn ran_on(&mut self, run: &KeptRun) {
        if self.state != "interrupted" {
            return;
        }
        self.title = Some(run.title.clone()).filter(|title| !title.is_empty());
        self.steps = run.steps;
        (self.started, self.ended) = (Some(run.started), Some(run.ended));
        self.reaches(run.done);
    }

    /// It begins, or goes on.
    pub(super) fn begins(&mut self, t: f64, holder: Value) {
        "checking".clone_into(&mut self.state);
        self.is_read = false;
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
            self.hidden.ran = true;
            if let Some(steps) = self.steps.filter(|_| self.loops > 0) {
                self.reaches(steps.saturating_mul(self.loops));
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

    /// The error with which its start was refused: it ended before it ran. `None` for any other job.
    pub(super) fn refusal(&self) -> Option<RpcError> {
        if self.state != "failed" || self.hidden.ran {
            return None;
        }
        let mut data = self.error.as_object()?.clone();
        let message = data.remove("message")?.as_str()?.to_owned();
        let of_kind = |code: &&i32| RpcError::new(**code, "").data.get("kind") == data.get("kind");
        let code = RpcError::CODES.iter().find(of_kind);
        let code = code.copied().unwrap_or(RpcError::ARM);
        Some(RpcError {
            code,
            message,
            data,
        })
    }

    /// What a station that comes after the one that kept it makes of it: what was under way is interrupted, what waited still
    /// waits, until a person says that it may begin.
    pub(super) fn left(&mut self, t: f64) -> bool {
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

/// Digest of what a job does: FNV-1a with 128 bits of it as JSON. Where it began, which the station adds, does not count.
pub(super) fn digest(order: &JobOrder) -> String {
    let mut order = order.clone();
    order.start = None;
    let text = serde_json::to_string(&order).unwrap_or_default();
    let offset: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    let prime = 0x0100_0000_0000_0000_0000_013b;
    let step = |hash: u128, byte: u8| (hash ^ u128::from(byte)).wrapping_mul(prime);
    format!("{:032x}", text.bytes().fold(offset, step))
}

/// A job as its file has it: with what it does, so that it can go on.
#[derive(Serialize)]
struct Kept<'a> {
    #[serde(flatten)]
    record: &'a JobRecord,
    kept: &'a Hidden,
    #[serde(skip_serializing_if = "Option::is_none")]
    order: Option<&'a JobOrder>,
}

/// The form in which a file has it. A job that is being resumed has moved nothing yet: it is kept as it was.
pub(super) fn to_file(record: &JobRecord) -> Value {
    let record = record.before.as_deref().unwrap_or(record);
    let mut kept = Kept {
        record,
        kept: &record.hidden,
        order: record.order.as_deref(),
    };
    let mut hidden = record.hidden.clone();
    hidden.on_lost = Some(record.on_lost.name().to_owned());
    kept.kept = &hidden;
    serde_json::to_value(kept).unwrap_or(Value::Null)
}

/// Names of the parts of a job in a file that [`from_file`] leaves out, because they are damaged or of a version that knew
/// other parameters.
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

/// Reads one. An order of a version that knew other parameters costs the order alone: the job stays in the list.
pub(super) fn from_file(mut item: Value, at: ArmId) -> Option<JobRecord> {
    let mut taken = |name| item.as_object_mut().and_then(|fields| fields.remove(name));
    let (order, hidden) = (taken("order"), taken("kept"));
    let mut record: JobRecord = serde_json::from_value(item).ok()?;
    record.at = at;
    let order = order.and_then(|order| serde_json::from_value(order).ok());
    record.order = order.map(Arc::new);
    let hidden = hidden.and_then(|hidden| serde_json::from_value(hidden).ok());
    // Older stations did not say it.
    record.hidden = hidden.unwrap_or_else(|| Hidden {
        ran: record.step > 0 || record.state == "done",
        ..Hidden::default()
    });
    record.on_lost = OnLost::named(record.hidden.on_lost.as_deref());
    Some(record)
}
