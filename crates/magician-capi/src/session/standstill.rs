//! Explanation for a queue that stands still while a program waits for it.
//!
//! Programs wait by polling the current index, and nothing in the reply shows that it will never
//! advance. So the program gets the reason once, in the log and as the thread's last fault. The
//! reply itself stays as it is.
//!
//! If the index has not changed for a while, alarms and pose are read. A blocking alarm is reported
//! at once. Without one, the arm must have kept its pose for longer: the queue may be paused for a
//! moment, or execute a command during which the arm stands still.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use magician::commands::{HomeCmd, Pose};
use magician::protocol::{Effect, Row, Writable};
use magician::{Alarm, AlarmSet, QueueIndex, blocking};

use super::registry::lock;
use crate::notice;

/// Function under whose name the reason is reported.
const NAME: &str = "GetQueuedCmdCurrentIndex";
/// Factor on `timeout` after which an arm at rest without an alarm is reported. A choice: the queue
/// may be stopped for a moment on purpose.
const REST_FACTOR: u32 = 10;
/// The same factor during a command in which the arm may stand still: homing, a wait, a trigger. A
/// choice: such commands take longer than a move.
const QUIET_FACTOR: u32 = 60;
/// Largest number of such commands that are remembered: more than the queue holds.
const MAX_QUIET: usize = 64;

/// State of the queue while a program waits for it.
#[derive(Debug)]
pub(super) struct Standstill {
    /// Time without a change of the index before the reason is looked for.
    timeout: Duration,
    state: Mutex<QueueState>,
}

#[derive(Debug, Default)]
struct QueueState {
    /// Index of the last command that this program queued.
    last_queued: u64,
    /// Queued commands in which the arm may stand still, by index. True for homing, which runs
    /// despite an alarm.
    quiet: BTreeMap<u64, bool>,
    /// Current index, time of its last change, and time of the last check.
    index: Option<(u64, Instant, Instant)>,
    pose: Option<Pose>,
    reported: bool,
}

impl Standstill {
    pub(super) fn new(timeout: Duration) -> Self {
        Self {
            timeout,
            state: Mutex::default(),
        }
    }

    /// Records a queued command.
    pub(super) fn queued(&self, QueueIndex(index): QueueIndex, row: &Row) {
        let mut state = lock(&self.state);
        state.last_queued = index;
        let homes = row.id == HomeCmd::ROW.id;
        if homes || row.effect == Effect::Wait {
            state.quiet.insert(index, homes);
            if state.quiet.len() > MAX_QUIET {
                state.quiet.pop_first();
            }
        }
        // Start the measurement anew: the queue may have been waiting for this command.
        state.index = None;
    }

    /// Forgets the measurement, because the queue was started or its alarms were cleared.
    pub(super) fn reset_measurement(&self) {
        let mut state = lock(&self.state);
        (state.index, state.reported) = (None, false);
    }

    /// Forgets everything, because the queue was cleared.
    pub(super) fn queue_cleared(&self) {
        *lock(&self.state) = QueueState::default();
    }

    /// Handles a poll of the current index.
    pub(super) fn note_index(&self, current: u64, arm: &blocking::Arm) {
        let Some((unchanged_for, last_pose)) = self.time_since_change(current) else {
            return;
        };
        // No lock is held while the arm is read: another thread must be able to queue commands.
        let (Ok(alarms), Ok(pose)) = (arm.alarms(), arm.get::<Pose>()) else {
            return;
        };
        let tool_unknown = arm.front_end().tool_is_unknown(&alarms).unwrap_or(false);
        let mut state = lock(&self.state);
        state.pose = Some(pose);
        let still = last_pose == Some(pose);
        let quiet = state.quiet.get(&current.saturating_add(1)).copied();
        let rest_timeout = self.timeout
            * if quiet.is_some() {
                QUIET_FACTOR
            } else {
                REST_FACTOR
            };
        if state.reported {
            return;
        }
        let why = if alarms.blocking() && quiet != Some(true) {
            alarm_reason(&alarms, tool_unknown)
        } else if still && unchanged_for >= rest_timeout {
            "the arm is at rest. If it should move, call SetQueuedCmdStartExec, and \
                ClearAllAlarmsState before it if there was an alarm"
                .to_owned()
        } else {
            return;
        };
        state.reported = true;
        let last = state.last_queued;
        drop(state);
        notice::warn(
            NAME,
            &format!(
                "command {last} is not finished; index {current} was the last to end, and {why}"
            ),
        );
    }

    /// Returns how long the index has stood and the pose at the last check, if a check is due.
    fn time_since_change(&self, current: u64) -> Option<(Duration, Option<Pose>)> {
        let mut state = lock(&self.state);
        let now = Instant::now();
        if current >= state.last_queued {
            (state.index, state.pose, state.reported) = (None, None, false);
            return None;
        }
        match &mut state.index {
            Some((index, since, checked_at)) if *index == current => {
                if now.duration_since(*checked_at) < self.timeout {
                    return None;
                }
                *checked_at = now;
                let unchanged_for = now.duration_since(*since);
                (!state.reported).then_some((unchanged_for, state.pose))
            }
            other => {
                *other = Some((current, now, now));
                (state.pose, state.reported) = (None, false);
                None
            }
        }
    }
}

/// Describes the alarms that block the queue, with remedies.
fn alarm_reason(alarms: &AlarmSet, tool_unknown: bool) -> String {
    let codes = alarms.codes().filter(|code| Alarm::blocks(*code));
    let mut named: Vec<String> = codes
        .map(|code| match Alarm::with_code(code) {
            Some(alarm) => format!(
                "{code:#04X} {}: {} ({})",
                alarm.name, alarm.cause, alarm.remedy
            ),
            None => format!("{code:#04X}, an unknown alarm"),
        })
        .collect();
    if tool_unknown {
        named.push(Alarm::TOOL_UNKNOWN.to_owned());
    }
    let named = named.join("; ").replace("0X", "0x");
    format!("an alarm keeps the queue from running: {named}; ClearAllAlarmsState releases it")
}
