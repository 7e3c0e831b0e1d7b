use std::iter::{self, repeat_n};
use std::sync::Arc;
use std::time::Duration;

use magician_host::Set;
use magician_host::commands::Pose;
use magician_host::preflight::{Guards, Preflight};

use super::{Program, StepNumbering, Timetable};
use crate::continuation::{Continuation, lights, within};
use crate::resume::{ResumePoint, StepCounter};
use crate::turns::{AtOnce, SLICE, Turns, at_once};
use crate::{Action, Diagnostic, Part, Pause, Plan, Report, Step};

/// How far from where it should an arm may stand, mm: no further than a gap in a line may be, for what was cut off so near
/// its end counts as done.
const NEAR: f64 = 0.2;
/// An arm that came to the end of a step by itself stands this near to it, mm: rounding of the arm's numbers and of the plan's.
const EXACT: f64 = 0.01;
/// A joint that has turned by less has not moved, deg.
const STILL: f64 = 0.02;

/// What is left of a [`Program`] from one of its steps on, for an arm that stands in a certain way: what comes before the
/// first step, the rest of the iteration that it is in, and the iterations after it.
#[derive(Clone, Debug)]
pub struct RemainingProgram {
    settings: Vec<Set>,
    /// The part of the plan that comes first, with what has to be done before it.
    pub(super) first: Arc<Plan>,
    /// Commands that stand among the steps of the first part, before the one that it is from.
    added: u64,
    from: u64,
    /// The place within its first step that it begins at.
    within: Option<[f64; 3]>,
    pub(super) whole: Arc<Plan>,
    /// Rounds that follow; none is for ever.
    pub(super) follow: Option<u64>,
    /// The last step is left out: the pen stays down.
    stays: bool,
    numbering: StepNumbering,
    start: Preflight,
    /// The start when the arm has been told the settings.
    pub(super) told: Preflight,
}

/// The place where a burn goes on that ended before its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BurnPlace {
    /// Steps that are finished.
    pub steps: u64,
    /// The place within the next step (x, y, z); `None` at its beginning.
    pub within: Option<[f64; 3]>,
    /// Largest length from there on that has been burnt already, mm.
    pub twice: f64,
}

impl RemainingProgram {
    pub(super) fn of(
        program: &Program,
        from: u64,
        at: Option<[f64; 3]>,
        start: Preflight,
    ) -> Result<Self, Diagnostic> {
        let mut told = start.clone();
        for setting in &program.settings {
            let taken = told.check(setting);
            taken.map_err(|error| Diagnostic::of_file(error.to_string()))?;
        }
        let iteration = program.steps_per_iteration().max(1);
        let (done, step) = (from / iteration, from % iteration);
        let first = match usize::try_from(step).unwrap_or(usize::MAX) {
            0 if at.is_none() => Arc::clone(&program.plan),
            step => Arc::new(Continuation::within_step(&program.plan, step, at, &told)?.plan),
        };
        let added = match step {
            0 if at.is_none() => 0,
            step => (first.steps.len() as u64).saturating_sub(iteration.saturating_sub(step)),
        };
        Ok(Self {
            settings: program.settings.clone(),
            first,
            added,
            from,
            within: at,
            whole: Arc::clone(&program.plan),
            follow: (program.iterations)
                .map(|iterations| iterations.saturating_sub(done.saturating_add(1))),
            stays: program.stays,
            numbering: program.numbering.clone(),
            start,
            told,
        })
    }

    /// The step that it begins with.
    #[must_use]
    pub fn from(&self) -> u64 {
        self.from
    }

    /// The place within that step (x, y, z) at which it begins, if not at the step's beginning.
    #[must_use]
    pub fn within(&self) -> Option<[f64; 3]> {
        self.within
    }

    /// Where the arm stands before all of it, for `Run::along`.
    #[must_use]
    pub fn start(&self) -> &Preflight {
        &self.start
    }

    /// The same when the arm has been told the settings that come before the plan.
    #[must_use]
    pub fn told(&self) -> &Preflight {
        &self.told
    }

    /// The first part, as a plan of its own: what comes before the first step, and the rest of its iteration.
    #[must_use]
    pub fn first(&self) -> &Plan {
        &self.first
    }

    /// What is added to the place of a step in [`first`](Self::first) to have its number in the program.
    pub(super) fn offset(&self) -> i64 {
        self.from
            .cast_signed()
            .saturating_sub(self.added.cast_signed())
    }

    /// Commands before the first step, for [`StepCounter::new`](crate::resume::StepCounter::new).
    #[must_use]
    pub fn lead(&self) -> u64 {
        let tool = u64::from(self.first.tool.is_some());
        self.settings.len() as u64 + tool + self.added
    }

    /// The counter of its steps: `mixed` as [`StepCounter::new`] has it.
    #[must_use]
    pub fn counter(&self, mixed: bool) -> StepCounter {
        StepCounter::new(self.lead(), mixed).numbered(self.numbering.clone(), self.from)
    }

    /// The steps, from its first, up to the last of so many commands behind the [`lead`](Self::lead).
    #[must_use]
    pub fn steps_of(&self, commands: u64) -> u64 {
        let before = self.numbering.commands(self.from);
        let steps = self.numbering.steps(before.saturating_add(commands));
        match commands {
            0 => 0,
            _ => steps.saturating_sub(self.from),
        }
    }

    /// The commands up to the end of the first part.
    pub fn first_commands(&self) -> impl Iterator<Item = Set> + Clone + '_ {
        self.settings.iter().copied().chain(self.first.commands())
    }

    /// The steps behind the first part.
    fn later(&self) -> impl Iterator<Item = &Step> + '_ {
        let times = usize::try_from(self.follow.unwrap_or(u64::MAX)).unwrap_or(usize::MAX);
        repeat_n(&*self.whole, times).flat_map(|plan| &plan.steps)
    }

    /// The first part, as [`slots`](Self::slots) has it.
    fn first_slots(&self) -> impl Iterator<Item = Option<Set>> + '_ {
        let before = self.settings.iter().copied().chain(self.first.preamble());
        let steps = self.first.steps.iter().map(|step| step.action.command());
        before.map(Some).chain(steps)
    }

    /// Everything in its order: each command, and a `None` for each step that has none.
    fn slots(&self) -> impl Iterator<Item = Option<Set>> + '_ {
        let later = self.later().map(|step| step.action.command());
        let slots = self.first_slots().chain(later);
        slots.take(if self.stays { self.count() } else { usize::MAX })
    }

    /// All commands, in order.
    pub fn commands(&self) -> impl Iterator<Item = Set> + '_ {
        self.slots().flatten()
    }

    /// The commands up to its first [`pause`](Self::pause), in order; all without one.
    pub fn commands_to_pause(&self) -> impl Iterator<Item = Set> + '_ {
        let steps = self.pause().map(|(step, _)| step.saturating_sub(self.from));
        let slots = steps.map(|steps| steps.saturating_add(self.lead()));
        let slots = slots.map_or(usize::MAX, |slots| {
            usize::try_from(slots).unwrap_or(usize::MAX)
        });
        self.slots().take(slots).flatten()
    }

    /// The command that is sent next when so many of its steps are finished.
    #[must_use]
    pub fn next_command(&self, steps: u64) -> Option<Set> {
        let slots = usize::try_from(steps.saturating_add(self.lead())).ok()?;
        self.slots().skip(slots).flatten().next()
    }

    /// The steps from the first one on, over all iterations; of a program without end no more than the first and one whole iteration.
    fn ahead(&self) -> impl Iterator<Item = (u64, &Step)> + '_ {
        let added = usize::try_from(self.added).unwrap_or(usize::MAX);
        let first = self.first.steps.iter().skip(added);
        let later = Some(&self.whole).filter(|_| self.follow != Some(0));
        let later = later.into_iter().flat_map(|plan| &plan.steps);
        (self.from..).zip(first.chain(later))
    }

    /// The first step that waits for a person, over all iterations.
    #[must_use]
    pub fn pause(&self) -> Option<(u64, &Pause)> {
        self.ahead().find_map(|(nth, step)| match &step.action {
            Action::Pause(pause) => Some((nth, &**pause)),
            _ => None,
        })
    }

    /// Whether it waits for a person before it sends anything.
    #[must_use]
    pub fn begins_with_pause(&self) -> bool {
        let mut silent = self.ahead().take_while(|(_, step)| step.action.is_silent());
        silent.any(|(_, step)| matches!(step.action, Action::Pause(_)))
    }

    /// The part that begins behind a step before anything is sent, if one does.
    #[must_use]
    pub fn part_after(&self, step: u64) -> Option<&Part> {
        let behind = self.ahead().skip_while(|(nth, _)| *nth <= step);
        let mut silent = behind.take_while(|(_, step)| step.action.is_silent());
        silent.find_map(|(_, step)| match &step.action {
            Action::Part(part) => Some(&**part),
            _ => None,
        })
    }

    /// How many commands and steps there are without the last lift.
    fn count(&self) -> usize {
        let iterations = self.follow.unwrap_or(u64::MAX);
        let later = iterations.saturating_mul(self.whole.steps.len() as u64);
        let tool = u64::from(self.first.tool.is_some());
        let first = (self.settings.len() + self.first.steps.len()) as u64 + tool;
        let all = first.saturating_add(later).saturating_sub(1);
        usize::try_from(all).unwrap_or(usize::MAX)
    }

    /// The arm as it is after the last step, as far as that is known.
    #[must_use]
    pub fn end(&self) -> Preflight {
        let mut course = self.told.clone().guards(Guards::NONE).summing();
        let later = Some(&self.whole).filter(|_| self.follow != Some(0));
        for plan in iter::once(&self.first).chain(later) {
            for command in plan.commands() {
                // What the arm cannot do is told by the check.
                let _ = course.check(&command);
            }
        }
        course.guards(Guards::default())
    }

    /// Whether the arm has moved since the rest began: it stands elsewhere, or it has finished a command that leads away from
    /// where it stood, wherever it is by now. Yes where it is not known where the rest began.
    #[must_use]
    pub fn has_moved(&self, counter: &StepCounter, index: u64, pose: &Pose) -> bool {
        let Some(began) = self.start.arm() else {
            return true;
        };
        let began = began.joints.to_array();
        let elsewhere = |now: [f64; 4]| {
            let mut pairs = began.into_iter().zip(now);
            pairs.any(|(began, now)| (began - now).abs() > STILL)
        };
        let mut course = self.start.clone().guards(Guards::NONE);
        let done = usize::try_from(counter.commands(index).least).unwrap_or(usize::MAX);
        let mut ends = self.commands().take(done).map(|command| {
            // What could not be checked was not sent.
            let _ = course.check(&command);
            course.arm().map(|arm| arm.joints.to_array())
        });
        elsewhere(pose.joint_angle.map(f64::from)) || ends.any(|end| end.is_none_or(elsewhere))
    }

    /// The plan of one iteration.
    pub(crate) fn whole(&self) -> &Plan {
        &self.whole
    }

    /// The commands that change settings of the arm, for `SettingsBackup::read`.
    pub fn changes(&self) -> impl Iterator<Item = &Set> {
        let later = Some(&self.whole).filter(|_| self.follow != Some(0));
        let plans = iter::once(&self.first).chain(later);
        self.settings
            .iter()
            .chain(plans.flat_map(|plan| plan.settings()))
    }

    /// How long is left of it at each of its steps, when [`check`](Self::check) has found this.
    #[must_use]
    pub fn timetable(&self, report: &Report) -> Timetable {
        at_once(self.timetable_in_turns(report, &AtOnce))
    }

    /// [`timetable`](Self::timetable), with turns for others.
    pub async fn timetable_in_turns(&self, report: &Report, turns: &impl Turns) -> Timetable {
        let Some(all) = report.time else {
            return Timetable::default();
        };
        let mut course = self.start.clone().guards(Guards::NONE);
        let first = sums(&mut course, self.first_slots(), turns).await;
        let iteration = match self.follow {
            Some(0) => Vec::new(),
            _ => {
                let steps = self.whole.steps.iter();
                let commands = steps.map(|step| step.action.command());
                sums(&mut course, commands, turns).await
            }
        };
        let lead = usize::try_from(self.lead()).unwrap_or(usize::MAX);
        Timetable::new(all, lead, first, iteration)
    }

    /// The [`timetable`](Self::timetable) where every command is changed before it is sent, and these are sent before the first; with
    /// turns for others.
    pub async fn timetable_with(
        &self,
        unchanged: &Timetable,
        before: &[Set],
        change: impl Fn(Set) -> Set + Send + Sync,
        turns: &impl Turns,
    ) -> Timetable {
        if unchanged.left(0).is_none() {
            return Timetable::default();
        }
        let mut course = self.start.clone().guards(Guards::NONE);
        let sooner = sums(&mut course, before.iter().copied().map(Some), turns).await;
        let first = self.first_slots().map(|slot| slot.map(&change));
        let first = sums(&mut course, first, turns).await;
        let (mut iteration, mut iterations) = (Vec::new(), 0);
        if let Some(follow @ 1..) = self.follow {
            let steps = self.whole.steps.iter();
            let commands = steps.map(|step| step.action.command().map(&change));
            (iteration, iterations) = (sums(&mut course, commands, turns).await, follow);
        }
        let last = |sums: &[f64]| sums.last().copied().unwrap_or_default();
        let all = last(&sooner) + last(&first) + iterations as f64 * last(&iteration);
        let lead = usize::try_from(self.lead()).unwrap_or(usize::MAX);
        let all = Duration::try_from_secs_f64(all).unwrap_or(Duration::MAX);
        Timetable::new(all, lead, first, iteration)
    }

    /// Where a run goes on that ended like this and left the arm there: the steps that are finished, and the place within the
    /// next, if it goes on from within. It does not where the step that was cut short leads nowhere straight, or the arm
    /// stands beside its line.
    #[must_use]
    pub fn goes_on(
        &self,
        resume_point: ResumePoint,
        pose: &Pose,
    ) -> Option<(u64, Option<[f64; 3]>)> {
        match resume_point {
            // It has not come to where it was to begin.
            ResumePoint::After(steps) if steps == self.from => Some((steps, self.within)),
            ResumePoint::After(steps) => Some((steps, None)),
            ResumePoint::Again(steps) => Some(match self.place_after(steps, pose) {
                Some((steps, at)) => (steps, Some(at)),
                None => (steps, None),
            }),
            ResumePoint::Doubt(_) => None,
        }
    }

    /// The place where the arm stands within the steps that follow so many.
    fn place_after(&self, steps: u64, pose: &Pose) -> Option<(u64, [f64; 3])> {
        let done = self.slots_before(steps)?;
        let mut course = self.start.clone().guards(Guards::NONE);
        let mut slots = self.slots();
        for command in slots.by_ref().take(done).flatten() {
            // What could not be checked was not sent.
            let _ = course.check(&command);
        }
        let (passed, at) = within::place_on(&mut course, slots, pose)?;
        Some((steps + passed, at))
    }

    /// Where a burn goes on whose light was out when the arm was at this pose, and went out so much before at most. Between
    /// `least` and `most` steps are finished, the one under way counted as one of them. The laser may have burnt on `until` another
    /// pose. `None` if the pose is on none of their lines.
    #[must_use]
    pub fn dark_at(
        &self,
        (least, most): (u64, u64),
        pose: &Pose,
        late: Duration,
        until: Option<&Pose>,
    ) -> Option<BurnPlace> {
        let under_way = least.checked_sub(1).filter(|step| *step >= self.from);
        let under_way = self.slots_before(under_way.unwrap_or(self.from))?;
        let last = self.slots_before(most.max(self.from))?;
        let place = self.lines(last).dark_at(under_way, pose, late, until)?;
        Some(self.burn_place(place))
    }

    /// Where a burn goes on that was stopped, if it is not known where its light went out: a braking way before the place where
    /// it stands, which is `within` a step, or near the end of so many steps. `None` if nothing burns there, or the arm came to
    /// that end by itself.
    #[must_use]
    pub fn before_braking(
        &self,
        resume_point: ResumePoint,
        within: Option<(u64, [f64; 3])>,
        pose: &Pose,
    ) -> Option<BurnPlace> {
        let (steps, at) = match (within, resume_point) {
            (Some(within), _) => within,
            (None, ResumePoint::After(steps)) if steps > self.from => {
                // What ends by itself ends exactly.
                self.off_end(steps, pose).1.filter(|off| *off > EXACT)?;
                (steps - 1, [pose.x, pose.y, pose.z].map(f64::from))
            }
            _ => return None,
        };
        let slot = self.slots_before(steps)?;
        let place = self.lines(slot).before_braking(slot, at)?;
        (place.twice > 0.0).then(|| self.burn_place(place))
    }

    /// Where a burn goes on that was stopped before it had certainly come to its beginning within a step: there again, with
    /// the length from there to where the arm stands. `None` if it begins with a whole step, or the arm stands elsewhere.
    #[must_use]
    pub fn from_its_beginning(&self, pose: &Pose) -> Option<BurnPlace> {
        let begin = self.within?;
        let (steps, at) = self.place_after(self.from, pose)?;
        (steps == self.from).then(|| BurnPlace {
            steps,
            within: Some(begin),
            twice: within::distance(begin, at),
        })
    }

    fn lines(&self, last: usize) -> lights::Lines {
        let mut course = self.start.clone().guards(Guards::NONE);
        let lead = usize::try_from(self.lead()).unwrap_or(usize::MAX);
        lights::Lines::of(&mut course, self.slots(), lead, last)
    }

    fn burn_place(&self, place: lights::Place) -> BurnPlace {
        let steps = (place.passed as u64)
            .saturating_sub(self.lead())
            .saturating_add(self.from);
        // What is left of the first step begins within it.
        let first = self.within.filter(|_| steps == self.from);
        BurnPlace {
            steps,
            within: place.at.or(first),
            twice: place.twice,
        }
    }

    /// Where a burn goes on that is to overlap by so many mm what was burnt before it stopped: the steps that are finished, the place
    /// within the next, and how many mm are burnt twice. It stops where the burn began.
    #[must_use]
    pub fn overlapped(
        &self,
        (steps, within): (u64, Option<[f64; 3]>),
        overlap: f64,
    ) -> (u64, Option<[f64; 3]>, f64) {
        let back = || {
            let passed = self.slots_before(steps)?;
            let mut course = self.start.clone().guards(Guards::NONE);
            within::back_along(&mut course, self.slots(), passed, within, overlap)
        };
        match (overlap > 0.0).then(back).flatten() {
            Some((earlier, place, twice)) if twice > 0.0 => {
                (steps.saturating_sub(earlier), place, twice)
            }
            _ => (steps, within, 0.0),
        }
    }

    /// How many mm the step behind so many burns, if it burns along a line.
    #[must_use]
    pub fn burn_after(&self, steps: u64) -> Option<f64> {
        let passed = self.slots_before(steps)?;
        let mut course = self.start.clone().guards(Guards::NONE);
        within::burn_of(&mut course, self.slots(), passed)
    }

    fn slots_before(&self, steps: u64) -> Option<usize> {
        let done = steps.checked_sub(self.from)?.saturating_add(self.lead());
        usize::try_from(done).ok()
    }

    /// Steps up to the first that moves the arm, with it; `None` if none does.
    #[must_use]
    pub fn first_motion(&self) -> Option<u64> {
        let mut ahead = self.ahead();
        let moves = ahead.find(|(_, step)| {
            let command = step.action.command();
            command.is_some_and(|command| command.row().effect.moves_arm())
        });
        moves.map(|(nth, _)| nth + 1)
    }

    /// Whether an arm that stands there stands where so many finished steps of the program leave it; not known where the
    /// steps lead nowhere that is known, and before the first one. `stopped`: the arm was stopped, and a wait or a
    /// trigger was cut short then, wherever the arm stands.
    #[must_use]
    pub fn stands_after(&self, steps: u64, pose: &Pose, stopped: bool) -> Option<bool> {
        match self.off_end(steps, pose) {
            (Some(Set::WaitCmd(_) | Set::TrigCmd(_)), _) if stopped => Some(false),
            (_, off) => Some(off? <= NEAR),
        }
    }

    /// The last command of so many finished steps, and how far from their end an arm stands, mm, where that is known.
    fn off_end(&self, steps: u64, pose: &Pose) -> (Option<Set>, Option<f64>) {
        let mut last = None;
        let off = self.off_end_of(steps, pose, &mut last);
        (last, off)
    }

    fn off_end_of(&self, steps: u64, pose: &Pose, last: &mut Option<Set>) -> Option<f64> {
        let done = steps.checked_sub(self.from).filter(|done| *done > 0)?;
        let count = usize::try_from(done.saturating_add(self.lead())).ok()?;
        let mut course = self.start.clone().guards(Guards::NONE);
        for command in self.slots().take(count).flatten() {
            // What could not be checked was not sent.
            let _ = course.check(&command);
            *last = Some(command);
        }
        let at = course.arm()?.pose;
        let [x, y, z] = [pose.x, pose.y, pose.z].map(f64::from);
        let off = [x - at.x, y - at.y, z - at.z];
        Some(off.iter().map(|off| off * off).sum::<f64>().sqrt())
    }
}

/// How long steps take up to each of them, seconds; what has no command, or no end that is known, counts nothing. Within a continuous
/// path a segment counts when it is settled, some segments later.
async fn sums(
    course: &mut Preflight,
    mut slots: impl Iterator<Item = Option<Set>> + Send,
    turns: &impl Turns,
) -> Vec<f64> {
    *course = course.clone().summing();
    let mut sum = 0.0;
    let mut sums = Vec::new();
    loop {
        let before = sums.len();
        sums.extend(slots.by_ref().take(SLICE).map(|slot| {
            let done = slot.and_then(|command| course.check(&command).ok());
            let known = done
                .map(|step| step.time)
                .filter(|time| *time < Duration::MAX);
            sum += known.map_or(0.0, |time| time.as_secs_f64());
            sum
        }));
        if sums.len() < before + SLICE {
            if let Some(last) = sums.last_mut() {
                *last += course.clone().rest().as_secs_f64();
            }
            return sums;
        }
        turns.give().await;
    }
}

#[cfg(test)]
pub(super) mod tests;
