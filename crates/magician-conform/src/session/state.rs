//! Steps about the arm's time, queue and alarms.

use std::time::Duration;

use magician_protocol::commands::{AlarmsState, DeviceTime, Pose, QueuedCmdCurrentIndex};
use magician_protocol::{AlarmSet, ArmInstant};

use super::{
    LONGEST, MAX_UNPOLLED_TIME, REST_TIME, SLACK, Session, StepError, StepResult, differs,
};
use crate::step::{Alarms, Finished};
use crate::target::Target;

impl<T: Target> Session<T> {
    /// Returns the arm's clock: exact if it is stepped, else read over the line.
    async fn clock(&mut self) -> Result<ArmInstant, StepError> {
        match self.target.stepped() {
            Some(now) => Ok(now),
            None => {
                let read = self.ask::<DeviceTime>().await?;
                Ok(ArmInstant::ZERO + Duration::from_millis(read.g_systick.into()))
            }
        }
    }

    pub(super) async fn mark_command_time(&mut self) -> StepResult {
        if self.timed {
            self.command_time = self.clock().await?;
        }
        Ok(())
    }

    /// Returns the time since the last set or queued command. A clock read over a line may wrap.
    async fn elapsed(&mut self) -> Result<Duration, StepError> {
        // A 32-bit counter of milliseconds wraps after 49.7 days.
        let wrap = Duration::from_millis(1 << 32);
        let (now, then) = (self.clock().await?, self.command_time);
        Ok(if now < then {
            now + wrap - then
        } else {
            now - then
        })
    }

    pub(super) async fn at(&mut self, span: Duration) -> StepResult {
        // A clock on a line may run at another rate than the wall clock. The loop is bounded, so
        // that an arm whose clock stands fails the case instead of hanging it.
        for _ in 0..100 {
            let left = span.saturating_sub(self.elapsed().await?);
            if left.is_zero() {
                return Ok(());
            }
            self.target.pass(left).await?;
        }
        differs("the arm's clock to run", "it stands", &[])
    }

    pub(super) async fn current(&mut self) -> Result<u64, StepError> {
        Ok(self
            .ask::<QueuedCmdCurrentIndex>()
            .await?
            .queued_cmd_current_index)
    }

    /// Lets a short time pass, at most `at_most`.
    async fn go_on(&mut self, at_most: Duration) -> StepResult {
        let before = self.target.stepped();
        self.target.go_on(at_most.min(MAX_UNPOLLED_TIME)).await?;
        // A stepped clock that is at its next event already would not move at all.
        if before.is_some() && before == self.target.stepped() {
            self.target.pass(Duration::from_millis(1)).await?;
        }
        Ok(())
    }

    pub(super) async fn done(&mut self, when: Option<(Duration, Duration)>) -> StepResult {
        let Some(last) = self.last else {
            return differs("a queued command to wait for", "none was queued", &[]);
        };
        let slack = if self.target.stepped().is_some() {
            Duration::ZERO
        } else {
            SLACK
        };
        let latest = when.map_or(LONGEST, |(at, tolerance)| at + tolerance.max(slack));
        let mut waited = Duration::ZERO;
        loop {
            let current = self.current().await?;
            let elapsed = if self.timed {
                self.elapsed().await?
            } else {
                waited
            };
            if current >= last {
                let early = when.is_some_and(|(at, tolerance)| elapsed + tolerance.max(slack) < at);
                return match (early, elapsed > latest) {
                    (false, false) => Ok(()),
                    _ => differs(
                        finish_by(last, when),
                        format!("it finished after {}", seconds(elapsed)),
                        &[],
                    ),
                };
            }
            if elapsed > latest {
                let got = format!("after {} it has finished {current}", seconds(elapsed));
                return differs(finish_by(last, when), got, &[]);
            }
            // Wait one millisecond beyond the limit, so that a late reply is noticed.
            let left = latest.saturating_sub(elapsed) + Duration::from_millis(1);
            self.go_on(left).await?;
            waited += left.min(Duration::from_millis(10));
        }
    }

    pub(super) async fn rest(&mut self) -> StepResult {
        let mut waited = Duration::ZERO;
        let mut pose = self.ask::<Pose>().await?;
        while waited < LONGEST {
            self.target.pass(REST_TIME).await?;
            waited += REST_TIME;
            let now = self.ask::<Pose>().await?;
            if now == pose {
                return Ok(());
            }
            pose = now;
        }
        differs(
            "the arm to come to rest",
            format!("it still moves after {}", seconds(waited)),
            &[],
        )
    }

    pub(super) async fn finished(&mut self, finished: Finished) -> StepResult {
        let wanted = match (finished, self.last) {
            (Finished::Nothing, _) => self.before,
            (Finished::Last(less), Some(last)) => last.saturating_sub(less),
            (Finished::Last(_), None) => {
                return differs("a queued command to look for", "none was queued", &[]);
            }
        };
        let current = self.current().await?;
        if current == wanted {
            Ok(())
        } else {
            differs(
                format!("index {wanted} finished last"),
                format!("index {current} finished last"),
                &[],
            )
        }
    }

    pub(super) async fn alarms(&mut self, wanted: &Alarms) -> StepResult {
        let standing = self.ask::<AlarmsState>().await?.alarms_state;
        let (right, expected) = match wanted {
            Alarms::Are(codes) => (
                standing.codes().eq(sorted(codes)),
                format!("alarms {}", named(codes)),
            ),
            Alarms::With(codes) => (
                codes.iter().all(|code| standing.contains(*code)),
                format!("alarms with {}", named(codes)),
            ),
            Alarms::Without(codes) => (
                !codes.iter().any(|code| standing.contains(*code)),
                format!("alarms without {}", named(codes)),
            ),
        };
        if right {
            Ok(())
        } else {
            differs(expected, format!("alarms {standing}"), standing.as_bytes())
        }
    }
}

fn sorted(codes: &[u8]) -> Vec<u8> {
    let mut codes = codes.to_vec();
    codes.sort_unstable();
    codes
}

fn named(codes: &[u8]) -> String {
    codes.iter().copied().collect::<AlarmSet>().to_string()
}

fn finish_by(last: u64, when: Option<(Duration, Duration)>) -> String {
    match when {
        Some((at, _)) => format!("index {last} to finish after {}", seconds(at)),
        None => format!("index {last} to finish within {}", seconds(LONGEST)),
    }
}

fn seconds(span: Duration) -> String {
    format!("{:.3} s", span.as_secs_f64())
}
