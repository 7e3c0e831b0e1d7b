//! Recordings of arms: which are under way, and what was read in the last minutes.

use std::collections::VecDeque;
use std::fmt::Write as _;
use std::time::{Duration, UNIX_EPOCH};

use magician::ErrorKind;
use magician_protocol::HostInstant;
use serde_json::{Value, json};

use super::dispatch::{Call, Handled};
use super::{Awaited, Station};
use crate::api::RpcError;
use crate::control::{ArmId, RequestId};
use crate::recording::{RecordOrder, RecordReport, Sample};

/// How long readings are kept, s.
const KEPT: f64 = 600.0;
/// Readings that are kept: as many as there are at the highest rate.
const MOST: usize = 30_000;

/// What an arm has of recordings.
#[derive(Debug, Default)]
pub(super) struct ArmRecordings {
    under_way: Option<Recording>,
    /// What was read last, whoever asked for it.
    ring: VecDeque<Sample>,
    /// The second that the last file is named for.
    named: u64,
}

#[derive(Debug)]
struct Recording {
    name: String,
    rate: u32,
    due: HostInstant,
    /// Unix seconds.
    began: f64,
    /// The request that began it.
    request: RequestId,
    /// Why it is not written any more.
    lost: Option<String>,
}

/// What a request about recordings comes to.
#[derive(Debug)]
pub(super) enum Recorded {
    Begun { name: String },
    Ended { name: String, seconds: f64 },
    Saved { name: String },
}

impl Recorded {
    fn answer(&self, bytes: u64) -> Value {
        match self {
            Self::Begun { name } | Self::Saved { name } => json!({"name": name}),
            Self::Ended { name, seconds } => {
                json!({"name": name, "seconds": seconds, "bytes": bytes})
            }
        }
    }
}

impl ArmRecordings {
    /// How often the arm has to be read for it.
    pub(super) fn rate(&self) -> Option<u32> {
        let under_way = self.under_way.as_ref();
        under_way
            .filter(|one| one.lost.is_none())
            .map(|one| one.rate)
    }

    /// Keeps a reading; whether it is one for the recording under way.
    fn keep(&mut self, now: HostInstant, sample: Sample) -> bool {
        let old = |kept: &Sample| sample.t - kept.t > KEPT;
        while self.ring.front().is_some_and(old) || self.ring.len() >= MOST {
            self.ring.pop_front();
        }
        self.ring.push_back(sample);
        let Some(recording) = &mut self.under_way else {
            return false;
        };
        let period = Duration::from_secs(1) / recording.rate;
        if recording.lost.is_some() || now + period / 10 < recording.due {
            return false;
        }
        let next = recording.due + period;
        recording.due = if next <= now { now + period } else { next };
        true
    }

    /// A name for a file that no other has.
    fn name(&mut self, arm: &str, t: f64) -> String {
        self.named = (t as u64).max(self.named + 1);
        let moment = UNIX_EPOCH + Duration::from_secs(self.named);
        let moment = humantime::format_rfc3339_seconds(moment).to_string();
        // `2026-11-23T15:40:00Z` without its signs.
        let digits = |sign: char| sign.is_ascii_digit() || sign == 'T';
        let stamp: String = moment.chars().filter(|sign| digits(*sign)).collect();
        format!("{arm}-{}.mcap", stamp.replace('T', "-"))
    }
}

impl Station {
    /// Something that recordings need done.
    pub fn poll_record(&mut self) -> Option<(ArmId, RecordOrder)> {
        self.record_orders.pop_front()
    }

    /// Whether an arm is being recorded.
    pub(super) fn is_recording(&self) -> bool {
        { self.arms.iter() }.any(|place| place.recordings.rate().is_some())
    }

    pub(super) fn record_call(
        &mut self,
        name: &str,
        call: &Call<'_>,
        arm: ArmId,
    ) -> Result<Handled, RpcError> {
        if !self.config.recordings.keeps() {
            let why = "this station keeps no recordings";
            return Err(RpcError::arm(ErrorKind::Unsupported, why));
        }
        match name {
            "record.start" => self.start_recording(call, arm),
            "record.stop" => self.stop_recording(call, arm),
            _ => self.save_last(call, arm),
        }
    }

    fn start_recording(&mut self, call: &Call<'_>, arm: ArmId) -> Result<Handled, RpcError> {
        let (request, t) = (call.request, self.unix(call.now));
        let rate = call.params.integer("rate").unwrap_or(20) as u32;
        let place = self.arm_mut(arm);
        let under_way = place.recordings.under_way.as_ref();
        if let Some(one) = under_way.filter(|one| one.lost.is_none()) {
            let error = RpcError::new(RpcError::BUSY, "the arm is being recorded");
            return Err(error.with("recording", one.name.clone()));
        }
        let name = place.recordings.name(&place.entry.name, t);
        place.recordings.under_way = Some(Recording {
            name: name.clone(),
            rate,
            due: call.now,
            began: t,
            request,
            lost: None,
        });
        self.record(
            arm,
            RecordOrder::Begin {
                request,
                name: name.clone(),
                epoch: t,
                rate,
            },
        );
        self.watch_anew();
        Ok(Handled::Later(
            request,
            Awaited::Record(Recorded::Begun { name }),
        ))
    }

    fn stop_recording(&mut self, call: &Call<'_>, arm: ArmId) -> Result<Handled, RpcError> {
        let (request, t) = (call.request, self.unix(call.now));
        let Some(one) = self.arm_mut(arm).recordings.under_way.take() else {
            let why = "the arm is not being recorded";
            return Err(RpcError::arm(ErrorKind::InvalidInput, why));
        };
        if let Some(why) = one.lost {
            return Err(unwritten(&why));
        }
        self.record(arm, RecordOrder::End { request });
        self.watch_anew();
        let seconds = ((t - one.began) * 1000.0).round() / 1000.0;
        let name = one.name;
        let waits = Awaited::Record(Recorded::Ended { name, seconds });
        Ok(Handled::Later(request, waits))
    }

    fn save_last(&mut self, call: &Call<'_>, arm: ArmId) -> Result<Handled, RpcError> {
        let (request, t) = (call.request, self.unix(call.now));
        let seconds = call.params.number("seconds").unwrap_or(KEPT);
        let place = self.arm_mut(arm);
        let ring = place.recordings.ring.iter();
        let samples: Vec<_> = ring
            .filter(|sample| t - sample.t <= seconds)
            .copied()
            .collect();
        let (Some(first), Some(last)) = (samples.first(), samples.last()) else {
            let why = format!("nothing has watched the arm in the last {seconds} s");
            return Err(RpcError::arm(ErrorKind::InvalidInput, why));
        };
        let rate = (samples.len() - 1) as f64 / (last.t - first.t).max(1e-3);
        let rate = rate.round().clamp(1.0, 50.0) as u32;
        let name = place.recordings.name(&place.entry.name, t);
        self.record(
            arm,
            RecordOrder::Save {
                request,
                name: name.clone(),
                rate,
                samples,
            },
        );
        Ok(Handled::Later(
            request,
            Awaited::Record(Recorded::Saved { name }),
        ))
    }

    fn record(&mut self, arm: ArmId, order: RecordOrder) {
        self.record_orders.push_back((arm, order));
    }

    /// The arm was read.
    pub(super) fn record_reading(&mut self, now: HostInstant, arm: ArmId) {
        let place = self.arm(arm);
        let Some(reading) = &place.reading else {
            return;
        };
        let sample = Sample::of(reading, self.unix(place.read_at));
        if self.config.recordings.keeps() && self.arm_mut(arm).recordings.keep(now, sample) {
            self.record(arm, RecordOrder::Sample(Box::new(sample)));
        }
    }

    /// Something happened to the arm: the recording says so.
    pub(super) fn record_event(
        &mut self,
        t: f64,
        arm: ArmId,
        name: &str,
        fields: &[(&'static str, Value)],
    ) {
        if self.arm(arm).recordings.rate().is_none() {
            return;
        }
        let warns = [
            "alarm-raised",
            "link-lost",
            "unaccounted",
            "reset",
            "missed",
        ];
        let mut words = name.to_owned();
        for (name, value) in fields {
            let _ = write!(words, " {name} {value}");
        }
        let warning = warns.contains(&name);
        self.record(arm, RecordOrder::Note { t, warning, words });
    }

    /// What became of a recording.
    pub fn recorded(&mut self, now: HostInstant, arm: ArmId, report: RecordReport) {
        match report {
            RecordReport::Done { request, outcome } => {
                let begins = |one: &mut Recording| one.request == request;
                if outcome.is_err()
                    && self
                        .arm_mut(arm)
                        .recordings
                        .under_way
                        .take_if(begins)
                        .is_some()
                {
                    self.watch_anew();
                }
                let Some(pending) = self.pending.get(&request) else {
                    return;
                };
                let Awaited::Record(wanted) = &pending.waits else {
                    return;
                };
                let outcome = outcome.map(|bytes| wanted.answer(bytes));
                self.finish(now, request, outcome.map_err(|why| unwritten(&why)));
            }
            RecordReport::Lost(why) => {
                let Some(one) = &mut self.arm_mut(arm).recordings.under_way else {
                    return;
                };
                one.lost = Some(why.clone());
                let fields = vec![("name", json!(one.name)), ("message", json!(why))];
                self.watch_anew();
                self.event(now, arm, "recording-lost", fields);
            }
        }
        self.settle(now);
    }
}

/// The disk does not take it.
fn unwritten(why: &str) -> RpcError {
    let why = format!("the recording cannot be written: {why}");
    RpcError::arm(ErrorKind::Unexpected, why)
}
