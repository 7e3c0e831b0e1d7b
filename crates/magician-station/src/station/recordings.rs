//! Recordings: which are running, and the history of the last ten minutes.
//!
//! All readings, for whatever purpose they were made, go into a ring. An arm at rest is read slowly
//! for it and faster as soon as it may move, so that an idle arm costs little. An alarm saves the
//! ring to a file, together with the seconds that follow.

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
use crate::recording::{IS_SUPPORTED, Note, RecordOrder, RecordReport, Sample};

/// Length of the history, s.
const HISTORY_LENGTH: f64 = 600.0;
/// Most readings in the history: ten minutes at the highest rate, 50/s.
const MAX_HISTORY_READINGS: usize = 30_000;
/// Rate at which an arm at rest is read for the history, 1/s. Motion that another host causes is
/// noticed by it.
const REST_READ_RATE: u32 = 5;
/// Time after the last sign of motion for which an arm is read at the full rate.
const MOTION_LINGER: Duration = Duration::from_secs(2);
/// Time after an alarm that its file includes.
const ALARM_TAIL: Duration = Duration::from_secs(5);
/// Shortest interval between two files of alarms, so that a bouncing alarm does not fill the disk.
const MIN_ALARM_FILE_INTERVAL: Duration = Duration::from_secs(60);
/// Shortest history for which an alarm is worth a file, s.
const MIN_HISTORY: f64 = 1.0;

/// Recordings of an arm.
#[derive(Debug, Default)]
pub(super) struct ArmRecordings {
    under_way: Option<Recording>,
    /// Last readings, for whatever purpose they were made.
    ring: VecDeque<Sample>,
    /// Unix second in the name of the last file, because names must differ.
    named: u64,
    /// Instant until which the arm is read at the full rate.
    motion_until: Option<HostInstant>,
    /// True if something that may move the arm was sent since the last reading.
    expects_motion: bool,
    /// Largest number of free places that the arm's queue has had.
    space: u32,
    /// Instant at which the file of an alarm is written.
    alarm: Option<HostInstant>,
    /// Start of the last file of an alarm, and the Unix time to which it reaches.
    saved: Option<(HostInstant, f64)>,
    /// File of an alarm that is being written.
    saving: Option<(RequestId, String)>,
}

#[derive(Debug)]
struct Recording {
    name: String,
    rate: u32,
    due: HostInstant,
    /// Start of the recording, Unix seconds.
    began: f64,
    /// Request that started it.
    request: RequestId,
    /// Reason why writing has failed.
    lost: Option<String>,
}

/// Result of a request about recordings.
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
    /// Returns the rate at which the arm must be read for a running recording.
    pub(super) fn rate(&self) -> Option<u32> {
        let under_way = self.under_way.as_ref();
        under_way
            .filter(|one| one.lost.is_none())
            .map(|one| one.rate)
    }

    /// Returns the next deadline.
    pub(super) fn due(&self) -> Option<HostInstant> {
        self.alarm
    }

    /// Records that something was sent that may move the arm. Returns true if that is new.
    pub(super) fn expect_motion(&mut self) -> bool {
        !std::mem::replace(&mut self.expects_motion, true)
    }

    fn has_recent_motion(&self) -> bool {
        self.expects_motion || self.motion_until.is_some()
    }

    /// Records a reading. Returns true if the rate of reading has to change.
    fn note_reading(&mut self, now: HostInstant, moving: bool, left_space: u32) -> bool {
        let before = self.has_recent_motion();
        self.space = self.space.max(left_space);
        // Fewer free places than ever seen means that commands are waiting, possibly of another
        // host.
        if moving || left_space < self.space || std::mem::take(&mut self.expects_motion) {
            self.motion_until = Some(now + MOTION_LINGER);
        }
        self.motion_until.take_if(|until| now >= *until);
        before != self.has_recent_motion()
    }

    /// Appends a reading to the history. Returns true if it is due for the running recording.
    fn add_reading(&mut self, now: HostInstant, sample: Sample) -> bool {
        let old = |kept: &Sample| sample.t - kept.t > HISTORY_LENGTH;
        while self.ring.front().is_some_and(old) || self.ring.len() >= MAX_HISTORY_READINGS {
            self.ring.pop_front();
        }
        self.ring.push_back(sample);
        let Some(recording) = &mut self.under_way else {
            return false;
        };
        let period = Duration::from_secs(1) / recording.rate;
        // Up to a tenth of a period early counts as due, because readings jitter.
        if recording.lost.is_some() || now + period / 10 < recording.due {
            return false;
        }
        let next = recording.due + period;
        // On a grid like subscriptions; after a gap it starts anew.
        recording.due = if next <= now { now + period } else { next };
        true
    }

    /// Returns a name for a file that no other file has.
    fn name(&mut self, arm: &str, t: f64) -> String {
        // Two files within a second would get the same name.
        self.named = (t as u64).max(self.named + 1);
        let moment = UNIX_EPOCH + Duration::from_secs(self.named);
        let moment = humantime::format_rfc3339_seconds(moment).to_string();
        // `2026-11-23T15:40:00Z` without separators.
        let digits = |sign: char| sign.is_ascii_digit() || sign == 'T';
        let stamp: String = moment.chars().filter(|sign| digits(*sign)).collect();
        format!("{arm}-{}.mcap", stamp.replace('T', "-"))
    }
}

impl Station {
    /// Returns the next order for the recorder.
    pub fn poll_record(&mut self) -> Option<(ArmId, RecordOrder)> {
        self.record_orders.pop_front()
    }

    pub(super) fn keeps_recordings(&self) -> bool {
        IS_SUPPORTED && self.config.recordings.is_enabled()
    }

    /// True if any arm is being recorded.
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
        self.update_read_rates();
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
            return Err(write_error(&why));
        }
        self.record(arm, RecordOrder::End { request });
        self.update_read_rates();
        let seconds = ((t - one.began) * 1000.0).round() / 1000.0;
        let name = one.name;
        let waits = Awaited::Record(Recorded::Ended { name, seconds });
        Ok(Handled::Later(request, waits))
    }

    /// Returns the rate at which an arm is read for the history. `None` if there is no history.
    pub(super) fn ring_rate(&self, arm: ArmId) -> Option<u32> {
        // 50/s is the highest rate at which an arm is read.
        let ring = self.config.ring.min(50);
        if ring == 0 || !self.keeps_recordings() {
            return None;
        }
        let motion_until = self.arm(arm).recordings.has_recent_motion();
        Some(if motion_until {
            ring
        } else {
            ring.min(REST_READ_RATE)
        })
    }

    /// Schedules the file of an alarm: what led to it, and what follows.
    fn schedule_alarm_file(&mut self, now: HostInstant, arm: ArmId) {
        let saves = self.config.save_on_alarm && self.ring_rate(arm).is_some();
        let t = self.unix(now);
        let recordings = &mut self.arm_mut(arm).recordings;
        let begun = recordings.ring.front().map_or(t, |sample| sample.t);
        if !saves || recordings.alarm.is_some() || t - begun < MIN_HISTORY {
            return;
        }
        let soonest = recordings.saved.map(|(at, _)| at + MIN_ALARM_FILE_INTERVAL);
        recordings.alarm = Some(soonest.map_or(now + ALARM_TAIL, |at| at.max(now + ALARM_TAIL)));
    }

    /// Writes the files of alarms that are due.
    pub(super) fn save_for_alarms(&mut self, now: HostInstant) {
        if !IS_SUPPORTED {
            return;
        }
        for arm in self.arm_ids() {
            let due = |at: &mut HostInstant| now >= *at;
            if self.arm_mut(arm).recordings.alarm.take_if(due).is_none() {
                continue;
            }
            let t = self.unix(now);
            // Starts after the previous file, so that a series of alarms writes nothing twice.
            let before = self.arm(arm).recordings.saved.map(|(_, t)| t);
            let from = before.map_or(t - HISTORY_LENGTH, |before| before.max(t - HISTORY_LENGTH));
            self.arm_mut(arm).recordings.saved = Some((now, t));
            let request = RequestId(self.next_id());
            if let Some(name) = self.save(request, t, arm, from) {
                self.arm_mut(arm).recordings.saving = Some((request, name));
            }
        }
    }

    /// Orders the history since `from` as a file. Returns its name. `None` if there are no
    /// readings.
    fn save(&mut self, request: RequestId, t: f64, arm: ArmId, from: f64) -> Option<String> {
        let place = self.arm_mut(arm);
        let ring = place.recordings.ring.iter();
        let samples: Vec<_> = ring.filter(|sample| sample.t >= from).copied().collect();
        let (first, last) = (samples.first()?, samples.last()?);
        // The rate in the file is the mean, because the history is read at changing rates.
        let rate = (samples.len() - 1) as f64 / (last.t - first.t).max(1e-3);
        let rate = rate.round().clamp(1.0, 50.0) as u32;
        let name = place.recordings.name(&place.entry.name, t);
        let notes = { place.events.after(from) }
            .filter_map(event_note)
            .collect();
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
        let seconds = call.params.number("seconds").unwrap_or(HISTORY_LENGTH);
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

    /// Handles a reading of an arm.
    pub(super) fn record_reading(&mut self, now: HostInstant, arm: ArmId) {
        let place = self.arm(arm);
        let Some(reading) = &place.reading else {
            return;
        };
        let sample = Sample::of(reading, self.unix(place.read_at));
        let (moving, left_space) = (reading.moving, reading.left_space);
        if self.config.ring > 0 {
            let recordings = &mut self.arm_mut(arm).recordings;
            if recordings.note_reading(now, moving, left_space) {
                self.update_read_rates();
            }
        }
        if self.keeps_recordings() && self.arm_mut(arm).recordings.add_reading(now, sample) {
            self.record(arm, RecordOrder::Sample(Box::new(sample)));
        }
    }

    /// Adds an event to the running recording.
    pub(super) fn record_event(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        name: &str,
        fields: &[(&'static str, Value)],
    ) {
        if !IS_SUPPORTED {
            return;
        }
        if name == "alarm-raised" {
            self.schedule_alarm_file(now, arm);
        }
        if self.arm(arm).recordings.rate().is_none() {
            return;
        }
        let fields = fields.iter().map(|(name, value)| (*name, value));
        let note = note_of(self.unix(now), name, fields);
        self.record(arm, RecordOrder::Note(note));
    }

    /// Takes a report of the recorder.
    pub fn recorded(&mut self, now: HostInstant, arm: ArmId, report: RecordReport) {
        if !IS_SUPPORTED {
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
                    self.update_read_rates();
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
                    return self.carry_out_effects(now);
                }
                let Some(pending) = self.pending.get(&request) else {
                    return;
                };
                let Awaited::Record(wanted) = &pending.awaits else {
                    return;
                };
                let outcome = outcome.map(|bytes| wanted.answer(bytes));
                self.finish(now, request, outcome.map_err(|why| write_error(&why)));
            }
            RecordReport::Lost(why) => {
                let Some(one) = &mut self.arm_mut(arm).recordings.under_way else {
                    return;
                };
                // Kept until `record.stop`, which then answers with the reason.
                one.lost = Some(why.clone());
                let fields = vec![("name", json!(one.name)), ("message", json!(why))];
                self.update_read_rates();
                self.event(now, arm, ArmEvent::RecordingLost, fields);
            }
        }
        self.carry_out_effects(now);
    }
}

/// Error of a recording that the disk refuses.
fn write_error(why: &str) -> RpcError {
    let why = message!("the recording cannot be written: {why}", why);
    RpcError::arm(ErrorKind::Unexpected, why)
}

/// Returns an event as a note of a recording.
fn note_of<'a>(t: f64, name: &str, fields: impl Iterator<Item = (&'a str, &'a Value)>) -> Note {
    let warns = [
        "alarm-raised",
        "link-lost",
        "unaccounted",
        "reset",
        "missed",
    ];
    let mut text = name.to_owned();
    for (name, value) in fields {
        let _ = write!(text, " {name} {value}");
    }
    let warning = warns.contains(&name);
    Note { t, warning, text }
}

/// Returns a logged event as a note.
fn event_note(event: &Value) -> Option<Note> {
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
