//! Recordings of arms: which are under way, and what was read in the last minutes.

use std::collections::VecDeque;
use std::fmt::Write as _;
use std::time::{Duration, UNIX_EPOCH};

use magician::ErrorKind;
use magician::message;
use magician_protocol::HostInstant;
use serde_json::{Value, json};

use super::dispatch::{Call, Handled};
use super::{Awaited, Station};
use crate::api::{ArmEvent, RpcError};
use crate::control::{ArmId, RequestId};
use crate::recording::{KEEPS, Note, RecordOrder, RecordReport, Sample};

/// How long readings are kept, s.
const KEPT: f64 = 600.0;
/// Readings that are kept: as many as there are at the highest rate.
const MOST: usize = 30_000;
/// An arm that stands is read so often for the last minutes: what moves it from elsewhere is seen by that.
const AT_REST: u32 = 5;
/// One that has moved is read as often as then for so long.
const STIRRED: Duration = Duration::from_secs(2);
/// How much of what follows an alarm is written with it.
const BEHIND: Duration = Duration::from_secs(5);
/// Alarms have no more than a file in so long.
const BETWEEN: Duration = Duration::from_secs(60);
/// The alarm begins what led to it: with less than so many seconds before it there is nothing to tell.
const BEFORE: f64 = 1.0;

/// What an arm has of recordings.
#[derive(Debug, Default)]
pub(super) struct ArmRecordings {
    under_way: Option<Recording>,
    /// What was read last, whoever asked for it.
    ring: VecDeque<Sample>,
    /// The second that the last file is named for.
    named: u64,
    /// Until when the arm is read often.
    stirred: Option<HostInstant>,
    /// Something was sent that may move it.
    expects: bool,
    /// The most free places that its queue had.
    space: u32,
    /// An alarm has come: when its file is written.
    alarm: Option<HostInstant>,
    /// When the last file for an alarm was begun, and the Unix seconds to which it goes.
    saved: Option<(HostInstant, f64)>,
    /// The file for an alarm that is being written.
    saving: Option<(RequestId, String)>,
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

    /// When something is to be done for it.
    pub(super) fn due(&self) -> Option<HostInstant> {
        self.alarm
    }

    /// Something is sent that may move the arm; whether that was not expected.
    pub(super) fn expect_motion(&mut self) -> bool {
        !std::mem::replace(&mut self.expects, true)
    }

    fn is_stirred(&self) -> bool {
        self.expects || self.stirred.is_some()
    }

    /// The arm was read, and moves or not; whether it is read more or less often from now on.
    fn stir(&mut self, now: HostInstant, moving: bool, left_space: u32) -> bool {
        let before = self.is_stirred();
        self.space = self.space.max(left_space);
        if moving || left_space < self.space || std::mem::take(&mut self.expects) {
            self.stirred = Some(now + STIRRED);
        }
        self.stirred.take_if(|until| now >= *until);
        before != self.is_stirred()
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

    pub(super) fn keeps_recordings(&self) -> bool {
        KEEPS && self.config.recordings.keeps()
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
        if !self.keeps_recordings() {
            let why = message!("this station keeps no recordings");
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
            let error = RpcError::new(RpcError::BUSY, message!("the arm is being recorded"));
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
            let why = message!("the arm is not being recorded");
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

    /// How often an arm is read for the last minutes.
    pub(super) fn ring_rate(&self, arm: ArmId) -> Option<u32> {
        let ring = self.config.ring.min(50);
        if ring == 0 || !self.keeps_recordings() {
            return None;
        }
        let stirred = self.arm(arm).recordings.is_stirred();
        Some(if stirred { ring } else { ring.min(AT_REST) })
    }

    /// An alarm has come: what led to it, and what follows, becomes a file.
    fn alarm_came(&mut self, now: HostInstant, arm: ArmId) {
        let saves = self.config.save_on_alarm && self.ring_rate(arm).is_some();
        let t = self.unix(now);
        let recordings = &mut self.arm_mut(arm).recordings;
        let begun = recordings.ring.front().map_or(t, |sample| sample.t);
        if !saves || recordings.alarm.is_some() || t - begun < BEFORE {
            return;
        }
        let soonest = recordings.saved.map(|(at, _)| at + BETWEEN);
        recordings.alarm = Some(soonest.map_or(now + BEHIND, |at| at.max(now + BEHIND)));
    }

    /// Writes the files that alarms ask for.
    pub(super) fn save_for_alarms(&mut self, now: HostInstant) {
        if !KEEPS {
            return;
        }
        for arm in self.arm_ids() {
            let due = |at: &mut HostInstant| now >= *at;
            if self.arm_mut(arm).recordings.alarm.take_if(due).is_none() {
                continue;
            }
            let t = self.unix(now);
            // What is in a file already is not written again, however many alarms come.
            let before = self.arm(arm).recordings.saved.map(|(_, t)| t);
            let from = before.map_or(t - KEPT, |before| before.max(t - KEPT));
            self.arm_mut(arm).recordings.saved = Some((now, t));
            let request = RequestId(self.next_id());
            if let Some(name) = self.save(request, t, arm, from) {
                self.arm_mut(arm).recordings.saving = Some((request, name));
            }
        }
    }

    /// Has what is kept since then written; the name of the file, if anything is.
    fn save(&mut self, request: RequestId, t: f64, arm: ArmId, from: f64) -> Option<String> {
        let place = self.arm_mut(arm);
        let ring = place.recordings.ring.iter();
        let samples: Vec<_> = ring.filter(|sample| sample.t >= from).copied().collect();
        let (first, last) = (samples.first()?, samples.last()?);
        let rate = (samples.len() - 1) as f64 / (last.t - first.t).max(1e-3);
        let rate = rate.round().clamp(1.0, 50.0) as u32;
        let name = place.recordings.name(&place.entry.name, t);
        let notes = { place.events.after(from) }.filter_map(noted).collect();
        let order = RecordOrder::Save {
            request,
            name: name.clone(),
            rate,
            from,
            samples,
            notes,
        };
        self.record(arm, order);
        Some(name)
    }

    fn save_last(&mut self, call: &Call<'_>, arm: ArmId) -> Result<Handled, RpcError> {
        let (request, t) = (call.request, self.unix(call.now));
        let seconds = call.params.number("seconds").unwrap_or(KEPT);
        let Some(name) = self.save(request, t, arm, t - seconds) else {
            let why = message!("the arm was not read in the last {seconds} s", seconds);
            return Err(RpcError::arm(ErrorKind::InvalidInput, why));
        };
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
        let (moving, left_space) = (reading.moving, reading.left_space);
        if self.config.ring > 0 {
            let recordings = &mut self.arm_mut(arm).recordings;
            if recordings.stir(now, moving, left_space) {
                self.watch_anew();
            }
        }
        if self.keeps_recordings() && self.arm_mut(arm).recordings.keep(now, sample) {
            self.record(arm, RecordOrder::Sample(Box::new(sample)));
        }
    }

    /// Something happened to the arm: the recording says so.
    pub(super) fn record_event(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        name: &str,
        fields: &[(&'static str, Value)],
    ) {
        if !KEEPS {
            return;
        }
        if name == "alarm-raised" {
            self.alarm_came(now, arm);
        }
        if self.arm(arm).recordings.rate().is_none() {
            return;
        }
        let fields = fields.iter().map(|(name, value)| (*name, value));
        let note = note_of(self.unix(now), name, fields);
        self.record(arm, RecordOrder::Note(note));
    }

    /// What became of a recording.
    pub fn recorded(&mut self, now: HostInstant, arm: ArmId, report: RecordReport) {
        if !KEEPS {
            return;
        }
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
                let saving = &mut self.arm_mut(arm).recordings.saving;
                if let Some((_, name)) = saving.take_if(|(of, _)| *of == request) {
                    let name = ("name", json!(name));
                    match outcome {
                        Ok(bytes) => {
                            let fields = vec![name, ("bytes", json!(bytes))];
                            self.event(now, arm, ArmEvent::RecordingSaved, fields);
                        }
                        Err(why) => {
                            let fields = vec![name, ("message", json!(why))];
                            self.event(now, arm, ArmEvent::RecordingLost, fields);
                        }
                    }
                    return self.settle(now);
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
                self.event(now, arm, ArmEvent::RecordingLost, fields);
            }
        }
        self.settle(now);
    }
}

/// The disk does not take it.
fn unwritten(why: &str) -> RpcError {
    let why = message!("the recording cannot be written: {why}", why);
    RpcError::arm(ErrorKind::Unexpected, why)
}

/// An event as a recording has it.
fn note_of<'a>(t: f64, name: &str, fields: impl Iterator<Item = (&'a str, &'a Value)>) -> Note {
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
    Note { t, warning, words }
}

/// An event that was kept.
fn noted(event: &Value) -> Option<Note> {
    let (t, name) = (event["t"].as_f64()?, event["event"].as_str()?);
    let known = ["arm", "seq", "t", "event"];
    let fields = event.as_object()?.iter();
    let fields = fields.filter(|(name, _)| !known.contains(&&***name));
    Some(note_of(
        t,
        name,
        fields.map(|(name, value)| (&**name, value)),
    ))
}
