//! A plan, how often it is done, and from which step on.

use magician::Set;
use magician_program::{Action, Plan};

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
    first: std::borrow::Cow<'p, Plan>,
    /// Commands before the first step.
    pub(super) lead: u64,
    /// The step that comes first, over all loops, from 0.
    pub(super) from: u64,
    whole: &'p Plan,
    /// Times that the whole plan follows; none is for ever.
    follow: Option<u64>,
}

impl Program {
    /// Steps of one loop.
    pub(super) fn round(&self) -> u64 {
        self.plan.steps.len() as u64
    }

    /// Steps in all.
    pub(super) fn steps(&self) -> Option<u64> {
        Some(self.loops?.saturating_mul(self.round()))
    }

    /// The step of the plan that is this one of the program.
    pub(super) fn step_of_plan(&self, step: u64) -> u64 {
        step.checked_rem(self.round()).unwrap_or(0)
    }

    /// From a step on, counted over all loops.
    pub(super) fn rest(&self, from: u64) -> Rest<'_> {
        let round = self.round().max(1);
        let (done, step) = (from / round, from % round);
        let first = match usize::try_from(step).unwrap_or(usize::MAX) {
            0 => std::borrow::Cow::Borrowed(&self.plan),
            step => std::borrow::Cow::Owned(self.plan.from_step(step)),
        };
        let told = first.preamble().into_iter().count() as u64;
        let added = (first.steps.len() as u64).saturating_sub(self.round().saturating_sub(step));
        Rest {
            lead: told + added,
            from,
            whole: &self.plan,
            follow: self.loops.map(|loops| loops.saturating_sub(done + 1)),
            first,
        }
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

    /// The same for what it is, whatever it is called: a name for its journal.
    pub(super) fn key(&self) -> String {
        // FNV-1a with 128 bits.
        let mut hash: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
        let mut take = |bytes: &[u8]| {
            for byte in bytes {
                hash = (hash ^ u128::from(*byte)).wrapping_mul(0x0000_0000_0100_0000_0000_0000_0000_013b);
            }
        };
        take(&self.loops.unwrap_or(0).to_le_bytes());
        for command in self.plan.commands() {
            if let Ok(frame) = magician::FrameBuf::set(&command, magician::Ctrl::QUEUED) {
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

    /// How often the whole plan follows.
    pub(super) fn follow(&self) -> Option<u64> {
        self.follow
    }

    /// All commands, in order.
    pub(super) fn commands(&self) -> impl Iterator<Item = Set> + '_ {
        let times = self.follow;
        let rounds = std::iter::repeat(self.whole).enumerate();
        let rounds = rounds.take_while(move |(nth, _)| times.is_none_or(|times| (*nth as u64) < times));
        let later = rounds.flat_map(|(_, plan)| plan.steps.iter().map(|step| step.action.command()));
        self.first.commands().chain(later)
    }
}
