//! A queue that stands while a program waits for it.
//!
//! Every program waits by asking for the current index again and again, and nothing in the answer says that it will never
//! come to more. So the caller is told why, once: in the log, and as the thread's last fault. The answer stays as it
//! is.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use magician::commands::{HomeCmd, Pose};
use magician::protocol::{Effect, Row, Writable};
use magician::{Alarm, AlarmSet, QueueIndex, blocking};

use super::registry::lock;
use crate::notice;

/// Where the reason is reported.
const NAME: &str = "GetQueuedCmdCurrentIndex";
/// So many times as long may it stand without an alarm: it may be stopped for a moment.
const PAUSE: u32 = 10;
/// The same where the command that runs is one that lets the arm stand: homing, a wait, a trigger.
const QUIET: u32 = 60;
/// So many of those are remembered: more than a queue holds.
const MOST_QUIET: usize = 64;

/// What is known of a queue that is waited for.
#[derive(Debug)]
pub(super) struct Standstill {
    /// How long the index stands still before the reason is looked for.
    patience: Duration,
    seen: Mutex<Seen>,
}

#[derive(Debug, Default)]
struct Seen {
    /// The last command that this program has queued.
    last: u64,
    /// Its commands that let the arm stand, and whether they run under an alarm, as homing does.
    quiet: BTreeMap<u64, bool>,
    /// The current index, since when, and when it was looked into.
    index: Option<(u64, Instant, Instant)>,
    pose: Option<Pose>,
    told: bool,
}

impl Standstill {
    pub(super) fn new(patience: Duration) -> Self {
        Self {
            patience,
            seen: Mutex::default(),
        }
    }

    /// A command went into the queue.
    pub(super) fn queued(&self, QueueIndex(index): QueueIndex, row: &Row) {
        let mut seen = lock(&self.seen);
        seen.last = index;
        let homes = row.id == HomeCmd::ROW.id;
        if homes || row.effect == Effect::Wait {
            seen.quiet.insert(index, homes);
            if seen.quiet.len() > MOST_QUIET {
                seen.quiet.pop_first();
            }
        }
        // It may be what the queue waits for.
        seen.index = None;
    }

    /// What is in the queue was dropped, or everything may go on.
    pub(super) fn begin_anew(&self) {
        let mut seen = lock(&self.seen);
        (seen.index, seen.told) = (None, false);
    }

    /// The queue was dropped: nothing is waited for.
    pub(super) fn dropped(&self) {
        *lock(&self.seen) = Seen::default();
    }

    /// The program has asked for the current index.
    pub(super) fn saw(&self, current: u64, arm: &blocking::Arm) {
        let Some((stood, before)) = self.stands(current) else {
            return;
        };
        // No lock is held while the arm is asked.
        let (Ok(alarms), Ok(pose)) = (arm.alarms(), arm.get::<Pose>()) else {
            return;
        };
        let tool_unknown = arm.front_end().tool_is_unknown(&alarms).unwrap_or(false);
        let mut seen = lock(&self.seen);
        seen.pose = Some(pose);
        let still = before == Some(pose);
        let quiet = seen.quiet.get(&current.saturating_add(1)).copied();
        let pause = self.patience * if quiet.is_some() { QUIET } else { PAUSE };
        if seen.told {
            return;
        }
        let why = if alarms.blocking() && quiet != Some(true) {
            held(&alarms, tool_unknown)
        } else if still && stood >= pause {
            "the arm is at rest. If it should move, call SetQueuedCmdStartExec, and \
                ClearAllAlarmsState before it if there was an alarm"
                .to_owned()
        } else {
            return;
        };
        seen.told = true;
        let last = seen.last;
        drop(seen);
        notice::warn(
            NAME,
            &format!(
                "command {last} is not finished; index {current} was the last to end, and {why}"
            ),
        );
    }

    /// Since when the index has stood and where the arm was, if it is time to look at it.
    fn stands(&self, current: u64) -> Option<(Duration, Option<Pose>)> {
        let mut seen = lock(&self.seen);
        let now = Instant::now();
        if current >= seen.last {
            (seen.index, seen.pose, seen.told) = (None, None, false);
            return None;
        }
        match &mut seen.index {
            Some((index, since, looked)) if *index == current => {
                if now.duration_since(*looked) < self.patience {
                    return None;
                }
                *looked = now;
                let stood = now.duration_since(*since);
                (!seen.told).then_some((stood, seen.pose))
            }
            other => {
                *other = Some((current, now, now));
                (seen.pose, seen.told) = (None, false);
                None
            }
        }
    }
}

/// Which alarms hold the queue, and what to do.
fn held(alarms: &AlarmSet, tool_unknown: bool) -> String {
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
