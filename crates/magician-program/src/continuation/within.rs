//! Steps that were begun and stopped: where on their line they go on.

use std::collections::VecDeque;

use magician_host::build;
use magician_host::preflight::Preflight;
use magician_host::{ArmState, Set, commands};
use magician_motion::Pose;
use magician_protocol::{CpMode, PtpMode};

use crate::Action;
use magician_formats::simplify::{dot, length};

/// How far beside its line a pen may stand and is on it, mm: no further than a gap in a line may be.
pub(super) const BESIDE: f64 = 0.2;
/// So far a pen may run on when it is stopped, mm: a path goes through its corners, and so does what brakes on it.
const RUN_ON: f64 = 2.0;

/// A straight way, from one pose to another.
pub(super) struct StraightMove {
    from: Pose,
    to: Pose,
}

impl StraightMove {
    pub(super) const fn between(from: Pose, to: Pose) -> Self {
        Self { from, to }
    }

    /// The way of a command from where the course is, which it follows.
    fn of(command: &Set, course: &mut Preflight) -> Option<Self> {
        let from = course.arm()?.pose;
        course.check(command).ok()?;
        let to = course.arm()?.pose;
        Some(Self { from, to })
    }

    pub(super) fn length(&self) -> f64 {
        self.from.distance_to(&self.to)
    }

    /// The share of it up to the point nearest to a place on its endless line, and how far that is.
    pub(super) fn nearest(&self, place: [f64; 3]) -> (f64, f64) {
        let (from, to) = (xyz(&self.from), xyz(&self.to));
        let way = [0, 1, 2].map(|axis| to[axis] - from[axis]);
        let off = [0, 1, 2].map(|axis| place[axis] - from[axis]);
        let square = dot(way, way);
        let share = if square > 0.0 {
            dot(way, off) / square
        } else {
            0.0
        };
        (share, distance(self.at(share), place))
    }

    pub(super) fn at(&self, share: f64) -> [f64; 3] {
        let (from, to) = (xyz(&self.from), xyz(&self.to));
        [0, 1, 2].map(|axis| from[axis] + share * (to[axis] - from[axis]))
    }
}

fn xyz(pose: &Pose) -> [f64; 3] {
    [pose.x, pose.y, pose.z]
}

pub(crate) fn distance(one: [f64; 3], other: [f64; 3]) -> f64 {
    length([0, 1, 2].map(|axis| one[axis] - other[axis]))
}

/// Whether the tool goes straight to the end of a command.
pub(super) fn is_straight(command: &Set) -> bool {
    match command {
        Set::CpCmd(_) | Set::CpLeCmd(_) => true,
        Set::PtpCmd(ptp) => ptp.ptp_mode.is_line() && ptp.ptp_mode.is_pose(),
        _ => false,
    }
}

/// Where an arm stands on the lines of the steps that come next, of which the first was under way when it was stopped: so many are
/// passed, and the place on the one after them. The arm may have run on, over short lines to others, or beyond a corner.
pub(crate) fn place_on(
    course: &mut Preflight,
    steps: impl Iterator<Item = Option<Set>>,
    pose: &commands::Pose,
) -> Option<(u64, [f64; 3])> {
    let place = [pose.x, pose.y, pose.z].map(f64::from);
    let mut best: Option<(f64, (u64, [f64; 3]))> = None;
    let (mut beyond, mut passed) = (0.0, 0);
    // Not beyond a step that sends nothing: it may be a pause.
    for command in steps.map_while(|step| step).take_while(is_straight) {
        let line = StraightMove::of(&command, course)?;
        let (share, off) = line.nearest(place);
        let within = share.clamp(0.0, 1.0);
        let at = line.at(within);
        let away = distance(at, place);
        if away <= BESIDE && best.is_none_or(|(least, _)| away < least) {
            best = Some((away, (passed, at)));
        }
        let ran_on = (share - 1.0) * line.length();
        if passed == 0 && off <= BESIDE && (0.0..=RUN_ON).contains(&ran_on) && best.is_none() {
            // The next line may pass nearer: this is how far it is beyond the corner.
            best = Some((BESIDE, (passed, line.at(1.0))));
        }
        if passed > 0 {
            beyond += line.length();
        }
        passed += 1;
        if beyond > RUN_ON {
            break;
        }
    }
    best.map(|(_, found)| found)
}

/// Whether the tool burns along a straight line.
fn is_burn(command: &Set) -> bool {
    matches!(command, Set::CpLeCmd(burn) if burn.velocity_or_power > 0.0)
}

/// How long the line of the step behind so many slots is, mm, if it is burnt.
pub(crate) fn burn_of(
    course: &mut Preflight,
    mut slots: impl Iterator<Item = Option<Set>>,
    passed: usize,
) -> Option<f64> {
    for command in slots.by_ref().take(passed).flatten() {
        // What could not be checked was not sent.
        let _ = course.check(&command);
    }
    let next = slots.next()?.filter(is_burn)?;
    Some(StraightMove::of(&next, course)?.length())
}

/// A place so far before another, back along a burn: how many slots earlier, the place within the one there if not at its beginning,
/// and how long the way between the two is, mm. It does not reach back over what does not burn, nor over a step that sends nothing.
pub(crate) fn back_along(
    course: &mut Preflight,
    mut slots: impl Iterator<Item = Option<Set>>,
    passed: usize,
    place: Option<[f64; 3]>,
    by: f64,
) -> Option<(u64, Option<[f64; 3]>, f64)> {
    let mut burnt: VecDeque<StraightMove> = VecDeque::new();
    let mut length = 0.0;
    for slot in slots.by_ref().take(passed) {
        let line = match slot {
            Some(command) if is_burn(&command) => StraightMove::of(&command, course),
            Some(command) => {
                let _ = course.check(&command);
                None
            }
            None => None,
        };
        let Some(line) = line else {
            burnt.clear();
            length = 0.0;
            continue;
        };
        length += line.length();
        burnt.push_back(line);
        while let Some(first) = burnt.front()
            && length - first.length() >= by
        {
            length -= first.length();
            burnt.pop_front();
        }
    }
    let next = slots.next()?.filter(is_burn)?;
    let line = StraightMove::of(&next, course)?;
    let share = place.map_or(0.0, |place| line.nearest(place).0.clamp(0.0, 1.0));
    let mut left = by - share * line.length();
    if left <= 0.0 {
        return Some((0, Some(line.at(share - by / line.length())), by));
    }
    let mut earlier = 0;
    for line in burnt.iter().rev() {
        earlier += 1;
        left -= line.length();
        if left < 0.0 {
            return Some((earlier, Some(line.at(-left / line.length())), by));
        }
    }
    Some((earlier, None, by - left))
}

/// How the arm stands at a place on the line of an action that begins where the course is, and what is left of the action
/// from there, if that is not the action itself. Nothing if the place is not on its line.
pub(super) fn from_there(
    action: &Action,
    course: &Preflight,
    place: [f64; 3],
) -> Option<(ArmState, Option<Action>)> {
    let command = action.command()?;
    let line = StraightMove::of(&command, &mut course.clone())?;
    let (share, _) = line.nearest(place);
    let share = share.clamp(0.0, 1.0);
    let at = line.at(share);
    if !is_straight(&command) || distance(at, place) > BESIDE {
        return None;
    }
    let left = |axis: usize| (1.0 - share) * (xyz(&line.to)[axis] - xyz(&line.from)[axis]);
    let left = [left(0), left(1), left(2)].map(|left| left as f32);
    let turn = line.to.r - line.from.r;
    let [x, y, z] = at.map(|at| at as f32);
    let (there, rest) = match command {
        Set::CpCmd(segment) => {
            let rest = (segment.cp_mode == CpMode::Relative).then(|| {
                let [x, y, z] = left;
                Set::from(commands::CpCmd { x, y, z, ..segment })
            });
            (build::path_to(x, y, z), rest)
        }
        Set::CpLeCmd(segment) => {
            let rest = (segment.cp_mode == CpMode::Relative).then(|| {
                let [x, y, z] = left;
                Set::from(commands::CpLeCmd { x, y, z, ..segment })
            });
            (build::path_to(x, y, z), rest)
        }
        Set::PtpCmd(ptp) => {
            let rest = (ptp.ptp_mode == PtpMode::MovlXyzInc).then(|| {
                let ([x, y, z], r) = (left, (1.0 - share) * turn);
                build::line_by(x, y, z, r as f32)
            });
            (
                build::line_to(x, y, z, (line.from.r + share * turn) as f32),
                rest,
            )
        }
        _ => return None,
    };
    let mut there_on = course.clone();
    there_on.check(&there).ok()?;
    Some((*there_on.arm()?, rest.map(Action::from)))
}
