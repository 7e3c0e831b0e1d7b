//! Rest of a program from one of its steps on.
//!
//! A remaining program consists of settings, the first part (an approach and the rest of the
//! current iteration) and the following iterations. It can be endless, so commands are iterated and
//! never collected. It also finds the place at which an interrupted run resumes: it follows its
//! commands without sending them and compares their end points and lines with the arm's pose.

use std::iter::{self, repeat_n};
use std::sync::Arc;
use std::time::Duration;

use magician_host::Set;
use magician_host::commands::Pose;
use magician_host::preflight::{Guards, Preflight};

use super::{Program, StepNumbering, Timetable};
use crate::continuation::{Continuation, laser_off, partial_step};
use crate::resume::{ResumePoint, StepCounter};
use crate::yielding::{NeverYield, STEPS_PER_SLICE, Yield, run_to_end};
use crate::{Action, Diagnostic, Part, Pause, Plan, Report, Step};

/// Largest distance of an arm from the end of a step at which the step counts as done, mm: equal to
/// the largest acceptable gap in a line.
const DONE_TOLERANCE: f64 = 0.2;
/// Largest distance from the end of a step at which the arm counts as having finished it without a
/// stop, mm: rounding of the arm's and the plan's coordinates.
const REST_TOLERANCE: f64 = 0.01;
/// Largest change of a joint that counts as standstill, deg.
const STANDSTILL_TOLERANCE: f64 = 0.02;

/// Rest of a [`Program`] from one of its steps on, for an arm in a known state: the approach to the
/// first step, the rest of the current iteration, and the iterations after it.
#[derive(Clone, Debug)]
pub struct RemainingProgram {
    settings: Vec<Set>,
    /// Plan of the first part, with the approach before it.
    pub(super) first: Arc<Plan>,
    /// Number of approach steps within the first part.
    approach_steps: u64,
    from: u64,
    /// Position within the first step at which the rest begins.
    within: Option<[f64; 3]>,
    pub(super) whole: Arc<Plan>,
    /// Number of iterations after the first part; `None` is endless.
    pub(super) following: Option<u64>,
    /// True if the last step is left out so that the pen stays down.
    pen_stays_down: bool,
    numbering: StepNumbering,
    start: Preflight,
    /// Start state after the settings are sent.
    pub(super) start_with_settings: Preflight,
}

/// Place where a burn that ended early is resumed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BurnPlace {
    /// Number of finished steps.
    pub steps: u64,
    /// Position within the next step (x, y, z); `None` for its beginning.
    pub within: Option<[f64; 3]>,
    /// Upper bound of the length from there on that is burnt already, mm.
    pub twice: f64,
}

impl RemainingProgram {
    pub(super) fn of(
        program: &Program,
        from: u64,
        at: Option<[f64; 3]>,
        start: Preflight,
    ) -> Result<Self, Diagnostic> {
        let mut start_with_settings = start.clone();
        // Settings precede the approach, which depends on speeds and tool.
        for setting in &program.settings {
            let taken = start_with_settings.check(setting);
            taken.map_err(|error| Diagnostic::of_file(error.to_string()))?;
        }
        let iteration = program.steps_per_iteration().max(1);
        let (done, step) = (from / iteration, from % iteration);
        let first = match usize::try_from(step).unwrap_or(usize::MAX) {
            // At the first step of an iteration the plan itself begins: no approach is needed.
            0 if at.is_none() => Arc::clone(&program.plan),
            step => Arc::new(
                Continuation::within_step(&program.plan, step, at, &start_with_settings)?.plan,
            ),
        };
        let approach_steps = match step {
            0 if at.is_none() => 0,
            step => (first.steps.len() as u64).saturating_sub(iteration.saturating_sub(step)),
        };
        Ok(Self {
            settings: program.settings.clone(),
            first,
            approach_steps,
            from,
            within: at,
            whole: Arc::clone(&program.plan),
            following: (program.iterations)
                .map(|iterations| iterations.saturating_sub(done.saturating_add(1))),
            pen_stays_down: program.pen_stays_down,
            numbering: program.numbering.clone(),
            start,
            start_with_settings,
        })
    }

    /// First step, counted over all iterations.
    #[must_use]
    pub fn from(&self) -> u64 {
        self.from
    }

    /// Position within the first step (x, y, z) at which the rest begins; `None` for its beginning.
    #[must_use]
    pub fn within(&self) -> Option<[f64; 3]> {
        self.within
    }

    /// State of the arm before the rest begins, for `Run::along`.
    #[must_use]
    pub fn start(&self) -> &Preflight {
        &self.start
    }

    /// State of the arm after the settings that precede the plan.
    #[must_use]
    pub fn start_with_settings(&self) -> &Preflight {
        &self.start_with_settings
    }

    /// First part as a plan: the approach, and the rest of the current iteration.
    #[must_use]
    pub fn first(&self) -> &Plan {
        &self.first
    }

    /// Offset from an index in [`first`](Self::first) to the step number in the program.
    pub(super) fn offset(&self) -> i64 {
        self.from
            .cast_signed()
            .saturating_sub(self.approach_steps.cast_signed())
    }

    /// Number of commands before the first step, for
    /// [`StepCounter::new`](crate::resume::StepCounter::new).
    #[must_use]
    pub fn lead(&self) -> u64 {
        let tool = u64::from(self.first.tool.is_some());
        self.settings.len() as u64 + tool + self.approach_steps
    }

    /// Counter for its steps; `mixed` as in [`StepCounter::new`].
    #[must_use]
    pub fn counter(&self, mixed: bool) -> StepCounter {
        StepCounter::new(self.lead(), mixed).numbered(self.numbering.clone(), self.from)
    }

    /// Number of steps, from the first one, that this many commands after the [`lead`](Self::lead)
    /// complete.
    #[must_use]
    pub fn steps_of(&self, commands: u64) -> u64 {
        let before = self.numbering.commands(self.from);
        let steps = self.numbering.steps(before.saturating_add(commands));
        match commands {
            0 => 0,
            _ => steps.saturating_sub(self.from),
        }
    }

    /// Commands up to the end of the first part.
    pub fn first_commands(&self) -> impl Iterator<Item = Set> + Clone + '_ {
        self.settings.iter().copied().chain(self.first.commands())
    }

    /// Steps after the first part.
    fn later_steps(&self) -> impl Iterator<Item = &Step> + '_ {
        let times = usize::try_from(self.following.unwrap_or(u64::MAX)).unwrap_or(usize::MAX);
        repeat_n(&*self.whole, times).flat_map(|plan| &plan.steps)
    }

    /// First part, as in [`slots`](Self::slots).
    fn first_slots(&self) -> impl Iterator<Item = Option<Set>> + '_ {
        let before = self.settings.iter().copied().chain(self.first.preamble());
        let steps = self.first.steps.iter().map(|step| step.action.command());
        before.map(Some).chain(steps)
    }

    /// Commands in order, with `None` for each step that sends nothing.
    fn slots(&self) -> impl Iterator<Item = Option<Set>> + '_ {
        let later = self.later_steps().map(|step| step.action.command());
        let slots = self.first_slots().chain(later);
        slots.take(if self.pen_stays_down {
            self.count()
        } else {
            usize::MAX
        })
    }

    /// All commands in order.
    pub fn commands(&self) -> impl Iterator<Item = Set> + '_ {
        self.slots().flatten()
    }

    /// Commands up to the first [`pause`](Self::pause), in order; without a pause, all.
    pub fn commands_to_pause(&self) -> impl Iterator<Item = Set> + '_ {
        let steps = self.pause().map(|(step, _)| step.saturating_sub(self.from));
        let slots = steps.map(|steps| steps.saturating_add(self.lead()));
        let slots = slots.map_or(usize::MAX, |slots| {
            usize::try_from(slots).unwrap_or(usize::MAX)
        });
        self.slots().take(slots).flatten()
    }

    /// Next command once `steps` of its steps are finished; `None` at the end.
    #[must_use]
    pub fn next_command(&self, steps: u64) -> Option<Set> {
        let slots = usize::try_from(steps.saturating_add(self.lead())).ok()?;
        self.slots().skip(slots).flatten().next()
    }

    /// Steps from the first one over all iterations. For an endless program: the first part and one
    /// whole iteration.
    fn upcoming_steps(&self) -> impl Iterator<Item = (u64, &Step)> + '_ {
        let approach_steps = usize::try_from(self.approach_steps).unwrap_or(usize::MAX);
        let first = self.first.steps.iter().skip(approach_steps);
        let later = Some(&self.whole).filter(|_| self.following != Some(0));
        let later = later.into_iter().flat_map(|plan| &plan.steps);
        (self.from..).zip(first.chain(later))
    }

    /// First step that waits for a person, counted over all iterations.
    #[must_use]
    pub fn pause(&self) -> Option<(u64, &Pause)> {
        self.upcoming_steps()
            .find_map(|(nth, step)| match &step.action {
                Action::Pause(pause) => Some((nth, &**pause)),
                _ => None,
            })
    }

    /// True if a pause comes before any command.
    #[must_use]
    pub fn begins_with_pause(&self) -> bool {
        let mut silent = self
            .upcoming_steps()
            .take_while(|(_, step)| step.action.is_silent());
        silent.any(|(_, step)| matches!(step.action, Action::Pause(_)))
    }

    /// Part that begins after a step before any further command, if any.
    #[must_use]
    pub fn part_after(&self, step: u64) -> Option<&Part> {
        let behind = self.upcoming_steps().skip_while(|(nth, _)| *nth <= step);
        let mut silent = behind.take_while(|(_, step)| step.action.is_silent());
        silent.find_map(|(_, step)| match &step.action {
            Action::Part(part) => Some(&**part),
            _ => None,
        })
    }

    /// Number of commands and steps without the last lift.
    fn count(&self) -> usize {
        let iterations = self.following.unwrap_or(u64::MAX);
        let later = iterations.saturating_mul(self.whole.steps.len() as u64);
        let tool = u64::from(self.first.tool.is_some());
        let first = (self.settings.len() + self.first.steps.len()) as u64 + tool;
        let all = first.saturating_add(later).saturating_sub(1);
        usize::try_from(all).unwrap_or(usize::MAX)
    }

    /// State of the arm after the last step, as far as known.
    #[must_use]
    pub fn end(&self) -> Preflight {
        let mut course = self
            .start_with_settings
            .clone()
            .guards(Guards::NONE)
            .summing();
        let later = Some(&self.whole).filter(|_| self.following != Some(0));
        for plan in iter::once(&self.first).chain(later) {
            for command in plan.commands() {
                // Steps that the arm cannot do are reported by the check.
                let _ = course.check(&command);
            }
        }
        course.guards(Guards::default())
    }

    /// True if the arm has moved since the rest began: its pose differs, or it has finished a
    /// command that moves away from the start. Also true if the start is unknown.
    #[must_use]
    pub fn has_moved(&self, counter: &StepCounter, index: u64, pose: &Pose) -> bool {
        let Some(began) = self.start.arm() else {
            return true;
        };
        let began = began.joints.to_array();
        let elsewhere = |now: [f64; 4]| {
            let mut pairs = began.into_iter().zip(now);
            pairs.any(|(began, now)| (began - now).abs() > STANDSTILL_TOLERANCE)
        };
        let mut course = self.start.clone().guards(Guards::NONE);
        let done = usize::try_from(counter.commands(index).least).unwrap_or(usize::MAX);
        let mut ends = self.commands().take(done).map(|command| {
            // A command that the check refuses was never sent.
            let _ = course.check(&command);
            course.arm().map(|arm| arm.joints.to_array())
        });
        elsewhere(pose.joint_angle.map(f64::from)) || ends.any(|end| end.is_none_or(elsewhere))
    }

    /// Plan of one iteration.
    pub(crate) fn whole(&self) -> &Plan {
        &self.whole
    }

    /// Commands that change settings of the arm, for `SettingsBackup::read`.
    pub fn changes(&self) -> impl Iterator<Item = &Set> {
        let later = Some(&self.whole).filter(|_| self.following != Some(0));
        let plans = iter::once(&self.first).chain(later);
        self.settings
            .iter()
            .chain(plans.flat_map(|plan| plan.settings()))
    }

    /// Timetable of the time left at each step; `report` comes from [`check`](Self::check).
    #[must_use]
    pub fn timetable(&self, report: &Report) -> Timetable {
        run_to_end(self.timetable_yielding(report, &NeverYield))
    }

    /// Like [`timetable`](Self::timetable), yielding to other tasks between slices.
    pub async fn timetable_yielding(&self, report: &Report, yields: &impl Yield) -> Timetable {
        let Some(all) = report.time else {
            return Timetable::default();
        };
        let mut course = self.start.clone().guards(Guards::NONE);
        let first = cumulative_times(&mut course, self.first_slots(), yields).await;
        let iteration = match self.following {
            Some(0) => Vec::new(),
            _ => {
                let steps = self.whole.steps.iter();
                let commands = steps.map(|step| step.action.command());
                cumulative_times(&mut course, commands, yields).await
            }
        };
        let lead = usize::try_from(self.lead()).unwrap_or(usize::MAX);
        Timetable::new(all, lead, first, iteration)
    }

    /// Like [`timetable`](Self::timetable), with `before` sent first and `change` applied to every
    /// command. Yields to other tasks between slices.
    pub async fn timetable_with(
        &self,
        unchanged: &Timetable,
        before: &[Set],
        change: impl Fn(Set) -> Set + Send + Sync,
        yields: &impl Yield,
    ) -> Timetable {
        // An end unknown at full speed is unknown at any other speed too.
        if unchanged.left(0).is_none() {
            return Timetable::default();
        }
        let mut course = self.start.clone().guards(Guards::NONE);
        let sooner = cumulative_times(&mut course, before.iter().copied().map(Some), yields).await;
        let first = self.first_slots().map(|slot| slot.map(&change));
        let first = cumulative_times(&mut course, first, yields).await;
        let (mut iteration, mut iterations) = (Vec::new(), 0);
        if let Some(following @ 1..) = self.following {
            let steps = self.whole.steps.iter();
            let commands = steps.map(|step| step.action.command().map(&change));
            (iteration, iterations) = (
                cumulative_times(&mut course, commands, yields).await,
                following,
            );
        }
        let last = |sums: &[f64]| sums.last().copied().unwrap_or_default();
        let all = last(&sooner) + last(&first) + iterations as f64 * last(&iteration);
        let lead = usize::try_from(self.lead()).unwrap_or(usize::MAX);
        let all = Duration::try_from_secs_f64(all).unwrap_or(Duration::MAX);
        Timetable::new(all, lead, first, iteration)
    }

    /// Place at which a run with this resume point continues: number of finished steps, and
    /// position within the next one. The position is `None` if the step was not cut short, does not
    /// move straight, or the arm is not on its line.
    #[must_use]
    pub fn resume_place(
        &self,
        resume_point: ResumePoint,
        pose: &Pose,
    ) -> Option<(u64, Option<[f64; 3]>)> {
        match resume_point {
            // The approach was cut short: the arm had not arrived at the position where the step
            // resumes.
            ResumePoint::After(steps) if steps == self.from => Some((steps, self.within)),
            ResumePoint::After(steps) => Some((steps, None)),
            ResumePoint::Again(steps) => Some(match self.place_after(steps, pose) {
                Some((steps, at)) => (steps, Some(at)),
                None => (steps, None),
            }),
            ResumePoint::Doubt(_) => None,
        }
    }

    /// Position of the arm within the steps after `steps`, if it is on their lines.
    fn place_after(&self, steps: u64, pose: &Pose) -> Option<(u64, [f64; 3])> {
        let done = self.slots_before(steps)?;
        let mut course = self.start.clone().guards(Guards::NONE);
        let mut slots = self.slots();
        for command in slots.by_ref().take(done).flatten() {
            // A command that the check refuses was never sent.
            let _ = course.check(&command);
        }
        let (passed, at) = partial_step::place_on(&mut course, slots, pose)?;
        Some((steps + passed, at))
    }

    /// Place where an interrupted burn resumes. The laser was off when the arm was at `pose`, and
    /// had gone out at most `late` before.
    ///
    /// Between `least` and `most` steps are finished, counting the one in progress. The laser may
    /// have stayed on until the arm reached `until`. `None` if the pose is on none of the lines.
    #[must_use]
    pub fn laser_off_place(
        &self,
        (least, most): (u64, u64),
        pose: &Pose,
        late: Duration,
        until: Option<&Pose>,
    ) -> Option<BurnPlace> {
        let under_way = least.checked_sub(1).filter(|step| *step >= self.from);
        let under_way = self.slots_before(under_way.unwrap_or(self.from))?;
        let last = self.slots_before(most.max(self.from))?;
        let place = self
            .lines(last)
            .laser_off_place(under_way, pose, late, until)?;
        Some(self.burn_place(place))
    }

    /// Place where a stopped burn resumes if the place where the laser went out is unknown: one
    /// braking distance before the arm, which stands `within` a step or near the end of the last
    /// finished one.
    ///
    /// `None` if nothing burns there, or the arm reached that end by itself.
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
                // A step that ends by itself ends exactly at its target.
                self.distance_to_end(steps, pose)
                    .1
                    .filter(|off| *off > REST_TOLERANCE)?;
                (steps - 1, [pose.x, pose.y, pose.z].map(f64::from))
            }
            _ => return None,
        };
        let slot = self.slots_before(steps)?;
        let place = self.lines(slot).before_braking(slot, at)?;
        (place.twice > 0.0).then(|| self.burn_place(place))
    }

    /// Place where a burn resumes if it may have been stopped before it reached its start position
    /// within a step: that position, with the length from there to the arm. `None` if the rest
    /// begins with a whole step, or the arm stands elsewhere.
    #[must_use]
    pub fn from_start_position(&self, pose: &Pose) -> Option<BurnPlace> {
        let begin = self.within?;
        let (steps, at) = self.place_after(self.from, pose)?;
        (steps == self.from).then(|| BurnPlace {
            steps,
            within: Some(begin),
            twice: partial_step::distance(begin, at),
        })
    }

    fn lines(&self, last: usize) -> laser_off::Lines {
        let mut course = self.start.clone().guards(Guards::NONE);
        let lead = usize::try_from(self.lead()).unwrap_or(usize::MAX);
        laser_off::Lines::of(&mut course, self.slots(), lead, last)
    }

    fn burn_place(&self, place: laser_off::ResumePlace) -> BurnPlace {
        let steps = (place.passed as u64)
            .saturating_sub(self.lead())
            .saturating_add(self.from);
        // The rest of the first step begins at that position, not at the step's start.
        let first = self.within.filter(|_| steps == self.from);
        BurnPlace {
            steps,
            within: place.at.or(first),
            twice: place.twice,
        }
    }

    /// Place where a burn resumes with an overlap of `overlap` mm over the earlier burn: number of
    /// finished steps, position within the next one, and the length burnt twice, mm. Does not go
    /// back beyond the start of the burn.
    #[must_use]
    pub fn overlapped(
        &self,
        (steps, within): (u64, Option<[f64; 3]>),
        overlap: f64,
    ) -> (u64, Option<[f64; 3]>, f64) {
        let back = || {
            let passed = self.slots_before(steps)?;
            let mut course = self.start.clone().guards(Guards::NONE);
            partial_step::step_back(&mut course, self.slots(), passed, within, overlap)
        };
        match (overlap > 0.0).then(back).flatten() {
            Some((earlier, place, twice)) if twice > 0.0 => {
                (steps.saturating_sub(earlier), place, twice)
            }
            _ => (steps, within, 0.0),
        }
    }

    /// Length burnt by the step after `steps`, mm; `None` unless that step burns a line.
    #[must_use]
    pub fn burn_after(&self, steps: u64) -> Option<f64> {
        let passed = self.slots_before(steps)?;
        let mut course = self.start.clone().guards(Guards::NONE);
        partial_step::burn_length(&mut course, self.slots(), passed)
    }

    fn slots_before(&self, steps: u64) -> Option<usize> {
        let done = steps.checked_sub(self.from)?.saturating_add(self.lead());
        usize::try_from(done).ok()
    }

    /// Number of steps up to and including the first that moves the arm; `None` if no step does.
    #[must_use]
    pub fn first_motion(&self) -> Option<u64> {
        let mut ahead = self.upcoming_steps();
        let moves = ahead.find(|(_, step)| {
            let command = step.action.command();
            command.is_some_and(|command| command.row().effect.moves_arm())
        });
        moves.map(|(nth, _)| nth + 1)
    }

    /// True if an arm at `pose` stands where `steps` finished steps leave it. `None` if that place
    /// is unknown, and for no steps at all.
    ///
    /// With `stopped`, a final wait or trigger was interrupted and counts as unfinished at any
    /// pose.
    #[must_use]
    pub fn stands_after(&self, steps: u64, pose: &Pose, stopped: bool) -> Option<bool> {
        match self.distance_to_end(steps, pose) {
            (Some(Set::WaitCmd(_) | Set::TrigCmd(_)), _) if stopped => Some(false),
            (_, off) => Some(off? <= DONE_TOLERANCE),
        }
    }

    /// Last command of the finished steps, and the arm's distance from its end, mm, if known.
    fn distance_to_end(&self, steps: u64, pose: &Pose) -> (Option<Set>, Option<f64>) {
        let mut last = None;
        let off = self.distance_to_end_of(steps, pose, &mut last);
        (last, off)
    }

    fn distance_to_end_of(&self, steps: u64, pose: &Pose, last: &mut Option<Set>) -> Option<f64> {
        let done = steps.checked_sub(self.from).filter(|done| *done > 0)?;
        let count = usize::try_from(done.saturating_add(self.lead())).ok()?;
        let mut course = self.start.clone().guards(Guards::NONE);
        for command in self.slots().take(count).flatten() {
            // A command that the check refuses was never sent.
            let _ = course.check(&command);
            *last = Some(command);
        }
        let at = course.arm()?.pose;
        let [x, y, z] = [pose.x, pose.y, pose.z].map(f64::from);
        let off = [x - at.x, y - at.y, z - at.z];
        Some(off.iter().map(|off| off * off).sum::<f64>().sqrt())
    }
}

/// Cumulative durations of steps, s. Steps without a command or a known end count as 0. A segment
/// of a continuous path counts once it is settled, some segments later.
async fn cumulative_times(
    course: &mut Preflight,
    mut slots: impl Iterator<Item = Option<Set>> + Send,
    yields: &impl Yield,
) -> Vec<f64> {
    *course = course.clone().summing();
    let mut sum = 0.0;
    let mut sums = Vec::new();
    loop {
        let before = sums.len();
        sums.extend(slots.by_ref().take(STEPS_PER_SLICE).map(|slot| {
            let done = slot.and_then(|command| course.check(&command).ok());
            let known = done
                .map(|step| step.time)
                .filter(|time| *time < Duration::MAX);
            sum += known.map_or(0.0, |time| time.as_secs_f64());
            sum
        }));
        if sums.len() < before + STEPS_PER_SLICE {
            if let Some(last) = sums.last_mut() {
                *last += course.clone().rest().as_secs_f64();
            }
            return sums;
        }
        yields.yield_now().await;
    }
}

#[cfg(test)]
pub(super) mod tests;
