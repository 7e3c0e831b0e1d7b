//! Place where a burn was cut short.
//!
//! When the driver switches the laser off, it knows a pose that is up to one period old, and the
//! time since then. When something else stops the arm, only the pose at rest is known, and the
//! laser went out somewhere on the braking distance. This module computes from speeds and
//! decelerations the earliest place at which the laser may have gone out: the burn is resumed
//! there, so there is never a gap. The length that may be burnt twice is reported.

use std::time::Duration;

use magician_host::commands::Pose;
use magician_host::preflight::{Preflight, Stopping};
use magician_host::{Set, VelocityProfile, commands::CpLeCmd};
use magician_motion::MotionLaw;

use super::partial_step::{PEN_TOLERANCE, StraightMove, distance, is_straight};

/// Largest distance of a pose from a line at which it counts as on it, mm: rounding of the arm's
/// and the plan's coordinates.
const LINE_TOLERANCE: f64 = 0.05;
/// Number of slots before the current slot that are searched for a pose: the arm may have finished
/// short pieces since its last report.
const SLOTS_BEFORE: usize = 8;
/// Slots searched backwards: more than the pieces of any braking distance.
const MAX_BRAKING_SLOTS: usize = 400;
/// Number of slots after the last slot that determine the arm's speed: its queue holds no more.
const LOOKAHEAD_SLOTS: usize = 32;
/// Places on a braking distance at which the speed is evaluated.
const BRAKING_SAMPLES: f64 = 100.0;
/// Period of the controller, s: it reports one pose for this long while the arm moves on to the
/// next.
const PERIOD: f64 = MotionLaw::MAGICIAN.period_us() as f64 / 1e6;

/// Place in a program where a burn is resumed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ResumePlace {
    /// Number of slots that are completed.
    pub(crate) passed: usize,
    /// Position within the next slot; `None` for its beginning.
    pub(crate) at: Option<[f64; 3]>,
    /// Length from there on that may be burnt already, mm.
    pub(crate) twice: f64,
}

/// Straight motion of one slot.
struct Line {
    motion: StraightMove,
    burns: bool,
    stopping: Option<Stopping>,
    /// Velocity profile of a path segment; `None` for other motion.
    profile: Option<VelocityProfile>,
}

impl Line {
    fn of(command: &Set, course: &mut Preflight, stops: bool) -> Option<Self> {
        if !is_straight(command) {
            let _ = course.check(command);
            return None;
        }
        let stopping = stops.then(|| course.stopping(command)).flatten();
        let from = course.arm().copied();
        // A command that the check refuses was never sent.
        let step = course.check(command).ok()?;
        let motion = StraightMove::between(from?.pose, step.end?.pose);
        let burns = match command {
            Set::CpLeCmd(CpLeCmd {
                velocity_or_power, ..
            }) => *velocity_or_power > 0.0,
            // Other straight moves burn only while the laser is switched on.
            _ => step.laser,
        };
        Some(Self {
            motion,
            burns,
            stopping,
            profile: None,
        })
    }

    /// Largest distance covered in the last `seconds` before a share of the line, mm, and the part
    /// of `seconds` before the start of the line.
    fn distance_before(&self, share: f64, seconds: f64) -> (f64, f64) {
        let gone = share * self.motion.length();
        match (&self.profile, self.stopping) {
            (Some(profile), _) => {
                let at = profile.time_at(gone);
                (
                    gone - profile.position(at - seconds).min(gone),
                    seconds - at,
                )
            }
            (None, Some(Stopping { speed, .. })) if speed > 0.0 => {
                let covered = (speed * seconds).min(gone);
                (covered, seconds - covered / speed)
            }
            // The speed is unknown: claim no distance, and stop here.
            _ => (0.0, 0.0),
        }
    }

    /// Like `distance_before`, after a share of the line.
    fn distance_after(&self, share: f64, seconds: f64) -> (f64, f64) {
        let length = self.motion.length();
        let left = (1.0 - share) * length;
        match (&self.profile, self.stopping) {
            (Some(profile), _) => {
                let at = profile.time_at(share * length);
                let covered = profile.position(at + seconds) - share * length;
                (covered.clamp(0.0, left), at + seconds - profile.duration())
            }
            (None, Some(Stopping { speed, .. })) if speed > 0.0 => {
                let covered = (speed * seconds).min(left);
                (covered, seconds - covered / speed)
            }
            _ => (0.0, 0.0),
        }
    }
}

/// Consecutive slots of a program with their straight motions.
pub(crate) struct Lines {
    /// First slot.
    first: usize,
    /// Motion by slot; `None` for a slot without a straight motion.
    lines: Vec<Option<Line>>,
}

impl Lines {
    /// Collects the motions of the last slots up to `last`, from `lead` on. `course` is the state
    /// before the first slot.
    pub(crate) fn of(
        course: &mut Preflight,
        slots: impl Iterator<Item = Option<Set>>,
        lead: usize,
        last: usize,
    ) -> Self {
        let first = last.saturating_sub(MAX_BRAKING_SLOTS).max(lead);
        let near = last.saturating_sub(2 * SLOTS_BEFORE);
        let mut lines = Vec::new();
        let slots: Vec<_> = slots
            .take(last.saturating_add(1 + LOOKAHEAD_SLOTS))
            .collect();
        let commands: Vec<Set> = slots.iter().flatten().copied().collect();
        let mut profiles = course.path_profiles(&commands).into_iter();
        for (nth, slot) in slots.into_iter().enumerate().take(last.saturating_add(1)) {
            let profile = slot.and_then(|_| profiles.next()).flatten();
            if nth >= first {
                let line = slot.and_then(|command| Line::of(&command, course, nth >= near));
                lines.push(line.map(|line| Line { profile, ..line }));
            } else if let Some(command) = slot {
                // A command that the check refuses was never sent.
                let _ = course.check(&command);
            }
        }
        Self { first, lines }
    }

    fn line(&self, slot: usize) -> Option<&Line> {
        self.lines.get(slot.checked_sub(self.first)?)?.as_ref()
    }

    /// Place where the laser went out. It was off when the arm was at `pose`, and went out at most
    /// `late` earlier, or during the period for which the arm reports this pose.
    ///
    /// `current_slot` is the slot that the arm did not finish, or finished last. The laser may have
    /// stayed on until the arm reached `until`.
    pub(crate) fn laser_off_place(
        &self,
        current_slot: usize,
        pose: &Pose,
        late: Duration,
        until: Option<&Pose>,
    ) -> Option<ResumePlace> {
        let (off, slot, share) = self.nearest(current_slot, pose)?;
        if off > PEN_TOLERANCE {
            return None;
        }
        let mut place = self.before(
            slot,
            share,
            self.distance_before(slot, share, late.as_secs_f64()),
        );
        // The arm was moving from this pose to the next one when the laser went out or the stop
        // came.
        let mut moving_place = (slot, share);
        if let Some((_, end, there)) = until.and_then(|until| self.nearest(slot, until)) {
            moving_place = (end, there);
            for nth in slot..=end {
                let from = if nth == slot { share } else { 0.0 };
                let to = if nth == end { there } else { 1.0 };
                if let Some(line) = self.line(nth).filter(|line| line.burns) {
                    place.twice += (to - from).max(0.0) * line.motion.length();
                }
            }
        }
        // At the end of a segment the arm has come to rest by itself.
        if let (slot, share @ ..1.0) = moving_place {
            place.twice += self.burnt_after(slot, share, PERIOD);
        }
        Some(place)
    }

    /// Largest distance covered in the last `seconds` before a place, mm.
    fn distance_before(&self, mut slot: usize, mut share: f64, mut seconds: f64) -> f64 {
        let mut sum = 0.0;
        while let Some(line) = self.line(slot) {
            let (covered, left) = line.distance_before(share, seconds);
            sum += covered;
            if left <= 0.0 || slot == self.first {
                break;
            }
            (slot, share, seconds) = (slot - 1, 1.0, left);
        }
        sum
    }

    /// Largest length burnt in the `seconds` after a place, mm.
    fn burnt_after(&self, mut slot: usize, mut share: f64, mut seconds: f64) -> f64 {
        let mut sum = 0.0;
        while let Some(line) = self.line(slot) {
            let (covered, left) = line.distance_after(share, seconds);
            sum += if line.burns { covered } else { 0.0 };
            if left <= 0.0 {
                break;
            }
            (slot, share, seconds) = (slot + 1, 0.0, left);
        }
        sum
    }

    /// Line that a pose is on: distance from it, slot, and share. Among several lines the one
    /// nearest to the current slot counts.
    fn nearest(&self, current_slot: usize, pose: &Pose) -> Option<(f64, usize, f64)> {
        let place = [pose.x, pose.y, pose.z].map(f64::from);
        let last = self.first + self.lines.len();
        let earlier = (current_slot.saturating_sub(SLOTS_BEFORE)..current_slot).rev();
        let nearest = |slot: usize| {
            let line = self.line(slot)?;
            let (share, _) = line.motion.nearest(place);
            let share = share.clamp(0.0, 1.0);
            Some((distance(line.motion.at(share), place), slot, share))
        };
        let all: Vec<_> = (current_slot..last)
            .chain(earlier)
            .filter_map(nearest)
            .collect();
        let on = all.iter().find(|(off, ..)| *off <= LINE_TOLERANCE);
        let best = all.iter().min_by(|one, other| one.0.total_cmp(&other.0));
        on.or(best).copied()
    }

    /// Longest distance over which the arm may have braked to a place, mm. The braking distance
    /// from an earlier place follows from the speed there and the deceleration of `fastest`.
    fn braking_distance(&self, slot: usize, share: f64, fastest: Stopping) -> f64 {
        let step = fastest.braking / BRAKING_SAMPLES;
        let comes_here = |back: f64| {
            let speed = self.speed_before(slot, share, back);
            let speed = speed.map_or(1.0, |speed| speed / fastest.speed);
            fastest.braking * speed * speed >= back - step
        };
        let looks = (1..=BRAKING_SAMPLES as u32).rev();
        let ways = looks.map(|nth| f64::from(nth) * step);
        ways.into_iter()
            .find(|back| comes_here(*back))
            .unwrap_or(0.0)
    }

    /// Highest speed on a path at a distance before a place; `None` if unknown.
    fn speed_before(&self, mut slot: usize, mut share: f64, mut back: f64) -> Option<f64> {
        loop {
            let line = self.line(slot)?;
            let gone = share * line.motion.length();
            if back <= gone || slot == self.first {
                let profile = line.profile.as_ref()?;
                let at = profile.time_at(gone - back);
                // The velocity of a period is that at its end, so neighbours are evaluated too.
                let near = [at - PERIOD, at, at + PERIOD].map(|at| profile.velocity(at));
                return Some(near.into_iter().fold(0.0, f64::max));
            }
            (back, slot, share) = (back - gone, slot - 1, 1.0);
        }
    }

    /// Place one braking distance before the place where the arm stands: the laser went out between
    /// the two.
    pub(crate) fn before_braking(&self, slot: usize, at: [f64; 3]) -> Option<ResumePlace> {
        let line = self.line(slot)?;
        let (share, _) = line.motion.nearest(at);
        let near = [slot.checked_sub(1), Some(slot)].into_iter().flatten();
        let stopping = near.filter_map(|slot| self.line(slot)?.stopping);
        let fastest = stopping.max_by(|one, other| one.braking.total_cmp(&other.braking))?;
        let share = share.clamp(0.0, 1.0);
        let mut place = self.before(slot, share, self.braking_distance(slot, share, fastest));
        if place.twice > 0.0 {
            // The arm brakes from the pose of the period and was already moving to the next one,
            // which at low speed adds more than the braking distance.
            place.twice += self.burnt_after(slot, share, PERIOD);
        }
        Some(place)
    }

    /// Place at a distance before another one, limited to the part that burns.
    fn before(&self, slot: usize, share: f64, by: f64) -> ResumePlace {
        let here = |slot: usize, share: f64, twice: f64| ResumePlace {
            passed: slot,
            at: match self.line(slot) {
                Some(line) if share > 0.0 => Some(line.motion.at(share)),
                _ => None,
            },
            twice,
        };
        let mut best = here(slot, share, 0.0);
        let (mut slot, mut share, mut left, mut twice) = (slot, share, by, 0.0);
        while let Some(line) = self.line(slot) {
            let length = line.motion.length();
            let back = left.min(share * length);
            let to = if length > 0.0 {
                share - back / length
            } else {
                0.0
            };
            if line.burns && back > 0.0 {
                twice += back;
                best = here(slot, to, twice);
            }
            left -= back;
            if left <= 0.0 || slot == self.first {
                break;
            }
            (slot, share) = (slot - 1, 1.0);
        }
        best
    }
}
