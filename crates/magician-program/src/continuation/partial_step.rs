//! Place at which an interrupted step continues.

use std::collections::VecDeque;

use magician_host::build;
use magician_host::preflight::Preflight;
use magician_host::{ArmState, Set, commands};
use magician_motion::Pose;
use magician_protocol::{CpMode, PtpMode};

use crate::Action;
use magician_formats::simplify::{dot, length};

/// Largest distance of a pen from its line at which it counts as on it, mm: equal to the largest
/// acceptable gap in a line.
pub(super) const PEN_TOLERANCE: f64 = 0.2;
/// Largest distance by which a stopped pen overruns a corner, mm: a path does not stop at its
/// corners, and neither does braking on it.
const MAX_OVERRUN: f64 = 2.0;

/// Straight motion between two poses.
pub(super) struct StraightMove {
    from: Pose,
    to: Pose,
}

impl StraightMove {
    pub(super) const fn between(from: Pose, to: Pose) -> Self {
        Self { from, to }
    }

    /// Motion of a command from the pose of `course`, which is advanced.
    fn of(command: &Set, course: &mut Preflight) -> Option<Self> {
        let from = course.arm()?.pose;
        course.check(command).ok()?;
        let to = course.arm()?.pose;
        Some(Self { from, to })
    }

    pub(super) fn length(&self) -> f64 {
        self.from.distance_to(&self.to)
    }

    /// Share of the motion at the point nearest to `place` on its infinite line, and the distance
    /// from that line.
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

/// True if the tool goes straight to the end of a command.
pub(super) fn is_straight(command: &Set) -> bool {
    match command {
        Set::CpCmd(_) | Set::CpLeCmd(_) => true,
        Set::PtpCmd(ptp) => ptp.ptp_mode.is_line() && ptp.ptp_mode.is_pose(),
        _ => false,
    }
}

/// Place of an arm on the lines of the steps from the one in progress at the stop: number of
/// completed steps, and the place on the following one.
///
/// The arm may have passed several short lines or a corner while braking.
pub(crate) fn place_on(
    course: &mut Preflight,
    steps: impl Iterator<Item = Option<Set>>,
    pose: &commands::Pose,
) -> Option<(u64, [f64; 3])> {
    let place = [pose.x, pose.y, pose.z].map(f64::from);
    let mut best: Option<(f64, (u64, [f64; 3]))> = None;
    let (mut beyond, mut passed) = (0.0, 0);
    // Ends at a step that sends nothing: it may be a pause, which was not passed.
    for command in steps.map_while(|step| step).take_while(is_straight) {
        let line = StraightMove::of(&command, course)?;
        let (share, off) = line.nearest(place);
        let within = share.clamp(0.0, 1.0);
        let at = line.at(within);
        let away = distance(at, place);
        if away <= PEN_TOLERANCE && best.is_none_or(|(least, _)| away < least) {
            best = Some((away, (passed, at)));
        }
        let ran_on = (share - 1.0) * line.length();
        if passed == 0
            && off <= PEN_TOLERANCE
            && (0.0..=MAX_OVERRUN).contains(&ran_on)
            && best.is_none()
        {
            // A nearer match on a later line takes precedence, so this one counts as if at the
            // largest distance.
            best = Some((PEN_TOLERANCE, (passed, line.at(1.0))));
        }
        if passed > 0 {
            beyond += line.length();
        }
        passed += 1;
        if beyond > MAX_OVERRUN {
            break;
        }
    }
    best.map(|(_, found)| found)
}

/// True if a command burns along a straight line.
fn is_burn(command: &Set) -> bool {
    matches!(command, Set::CpLeCmd(burn) if burn.velocity_or_power > 0.0)
}

/// Length of the line after `passed` slots, mm, if it is a burn.
pub(crate) fn burn_length(
    course: &mut Preflight,
    mut slots: impl Iterator<Item = Option<Set>>,
    passed: usize,
) -> Option<f64> {
    for command in slots.by_ref().take(passed).flatten() {
        // A command that the check refuses was never sent.
        let _ = course.check(&command);
    }
    let next = slots.next()?.filter(is_burn)?;
    Some(StraightMove::of(&next, course)?.length())
}

/// Place at a distance before another, back along a burn: number of slots earlier, place within the
/// slot there (`None` for its beginning), and the length between the two, mm.
///
/// Does not go back over motion that does not burn, nor over a step that sends nothing.
pub(crate) fn step_back(
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

/// State of the arm at a place on the line of an action that begins at `course`, and the action for
/// the rest of the line if it differs from the original. `None` if the place is not on the line.
pub(super) fn continue_from(
    action: &Action,
    course: &Preflight,
    place: [f64; 3],
) -> Option<(ArmState, Option<Action>)> {
    let command = action.command()?;
    let line = StraightMove::of(&command, &mut course.clone())?;
    let (share, _) = line.nearest(place);
    let share = share.clamp(0.0, 1.0);
    let at = line.at(share);
    if !is_straight(&command) || distance(at, place) > PEN_TOLERANCE {
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
