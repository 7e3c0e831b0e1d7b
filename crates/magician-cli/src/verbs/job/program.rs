//! A plan, how often it is done, and from which step on.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::time::Duration;

use magician::words::{Guards, Preflight};
use magician::{Ctrl, FrameBuf, Set};
use magician_program::{Action, Plan, Problem, Report, check};

use crate::failure::Failure;

/// What is run.
#[derive(Clone, Debug)]
pub(super) struct Program {
    pub(super) plan: Plan,
    /// How often; none is for ever.
    pub(super) loops: Option<u64>,
}

/// The commands of a program from one of its steps on.
#[derive(Debug)]
pub(super) struct Rest<'p> {
    /// The part of the plan that comes first, with what has to be done before it.
    first: Cow<'p, Plan>,
    /// Commands before the first step.
    pub(super) lead: u64,
    /// Those of them that stand among the steps of the first part.
    added: u64,
    /// The step that comes first, over all loops, from 0.
    pub(super) from: u64,
    whole: &'p Plan,
    /// Times that the whole plan follows; none is for ever.
    follow: Option<u64>,
}

/// How long the first part takes up to each of its steps, seconds.
pub(super) struct Times {
    lead: usize,
    sums: Vec<f64>,
}

impl Program {
    /// Steps in all.
    pub(super) fn steps(&self) -> Option<u64> {
        Some(self.loops?.saturating_mul(self.plan.steps.len() as u64))
    }

    /// Makes sure that it has a step, counted over all loops from 0.
    pub(super) fn has(&self, step: u64) -> Result<(), Failure> {
        match self.steps() {
            Some(steps) if step >= steps => {
                let message = format!("there is no step {}: the last is {steps}", step + 1);
                Err(Failure::usage(message))
            }
            _ => Ok(()),
        }
    }

    /// From a step on, counted over all loops, on an arm that is as `start` tells.
    pub(super) fn rest(&self, from: u64, start: &Preflight) -> Result<Rest<'_>, Problem> {
        let round = (self.plan.steps.len() as u64).max(1);
        let (done, step) = (from / round, from % round);
        let first = match usize::try_from(step).unwrap_or(usize::MAX) {
            0 => Cow::Borrowed(&self.plan),
            step => Cow::Owned(self.plan.from_step(step, start)?.plan),
        };
        let told = first.preamble().into_iter().count() as u64;
        let added = (first.steps.len() as u64).saturating_sub(round.saturating_sub(step));
        let added = if step == 0 { 0 } else { added };
        Ok(Rest {
            lead: told + added,
            added,
            from,
            whole: &self.plan,
            follow: self.loops.map(|loops| loops.saturating_sub(done + 1)),
            first,
        })
    }

    /// Checks what is left: the first part, and the whole plan after it as often as it follows. An arm that stands the same
    /// way after two rounds does so after every one.
    pub(super) fn check(&self, rest: &Rest<'_>, start: &Preflight) -> Report {
        let mut report = check(&rest.first, start);
        if rest.follow == Some(0) || !report.is_good() {
            report.time = report.time.filter(|_| rest.follow.is_some());
            return report;
        }
        let mut course = start.clone();
        for command in rest.first.commands() {
            // It has just passed.
            let _ = course.check(&command);
        }
        let round = Plan {
            tool: None,
            ..self.plan.clone()
        };
        let again = check(&round, &course);
        let times = rest.follow.unwrap_or(0);
        let count = times as f64;
        let rounds = |time: Duration| time.checked_mul(u32::try_from(times).unwrap_or(u32::MAX));
        report.time = rest
            .follow
            .and_then(|_| report.time?.checked_add(rounds(again.time?)?));
        report.drawn += count * again.drawn;
        report.travelled += count * again.travelled;
        report.refused += again.refused;
        report.complaints.extend(again.complaints);
        report
    }

    /// One command of each kind: what a check has to read of an arm depends on nothing else.
    pub(super) fn kinds(&self) -> impl Iterator<Item = Set> {
        let all = self.plan.commands();
        let kinds: BTreeMap<u8, Set> = all.map(|command| (command.row().id, command)).collect();
        kinds.into_values()
    }

    /// Whether anything of it may light the laser.
    pub(super) fn burns(&self) -> bool {
        let lit = |action: &Action| match *action {
            Action::Burn { power, .. } => power > 0.0,
            Action::Laser(on) => on,
            _ => false,
        };
        self.plan.steps.iter().any(|step| lit(&step.action))
    }

    /// The same for what is the same, whatever it is called: a name for its journal.
    pub(super) fn key(&self) -> String {
        // FNV-1a with 128 bits.
        let mut hash: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
        let mut take = |bytes: &[u8]| {
            for byte in bytes {
                hash = (hash ^ u128::from(*byte)).wrapping_mul(0x0100_0000_0000_0000_0000_013b);
            }
        };
        take(&self.loops.unwrap_or(0).to_le_bytes());
        for command in self.plan.commands() {
            if let Ok(frame) = FrameBuf::set(&command, Ctrl::QUEUED) {
                take(frame.bytes());
            }
        }
        format!("{hash:032x}")
    }
}

impl Rest<'_> {
    /// The first part, as a plan of its own.
    pub(super) fn first(&self) -> &Plan {
        &self.first
    }

    /// What is added to the place of a step in the first part to have its number, from 0.
    pub(super) fn offset(&self) -> i64 {
        self.from as i64 - self.added as i64
    }

    /// All commands, in order.
    pub(super) fn commands(&self) -> impl Iterator<Item = Set> + '_ {
        let times = self.follow;
        let rounds = std::iter::repeat(self.whole).enumerate();
        let rounds =
            rounds.take_while(move |(nth, _)| times.is_none_or(|times| (*nth as u64) < times));
        let later =
            rounds.flat_map(|(_, plan)| plan.steps.iter().map(|step| step.action.command()));
        self.first.commands().chain(later)
    }

    /// How long the first part takes up to each step, on an arm that stands there.
    pub(super) fn times(&self, start: &Preflight, settings: &[Set]) -> Times {
        let mut course = start.clone().guards(Guards::NONE);
        let mut sum = 0.0;
        let all = settings.iter().copied().chain(self.first.commands());
        let sums = all.map(|command| {
            let time = course
                .check(&command)
                .map_or(Duration::ZERO, |step| step.time);
            sum += if time == Duration::MAX {
                0.0
            } else {
                time.as_secs_f64()
            };
            sum
        });
        Times {
            sums: sums.collect(),
            lead: settings.len() + self.lead as usize,
        }
    }
}

impl Times {
    /// How much is left of so much when so many steps are done.
    pub(super) fn left(&self, all: Option<Duration>, done: u64) -> Option<Duration> {
        let all = all?.as_secs_f64();
        let whole = self.sums.last().copied().unwrap_or(0.0);
        let steps = (self.sums.len() - self.lead.min(self.sums.len())) as u64;
        let rounds = done.checked_div(steps.max(1)).unwrap_or(0);
        let within = (done % steps.max(1)) as usize;
        let spent = match (self.lead + within).checked_sub(1) {
            Some(at) => self.sums.get(at).copied().unwrap_or(whole),
            None => 0.0,
        };
        Some(Duration::from_secs_f64(
            (all - rounds as f64 * whole - spent).max(0.0),
        ))
    }
}
