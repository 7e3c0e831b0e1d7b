//! Place where a burn is resumed that was cut short.

use magician::LaserOffPose;
use magician::commands::Pose;
use magician_program::resume::ResumePoint;
use magician_program::{BurnPlace, RemainingProgram};

use super::pause::Goes;

/// An arm that was this far from where it stands was moving, mm. Poses of an arm at rest are equal, and less than this is left
/// to go only at a speed whose braking way is no gap.
const MOVED: f32 = 0.001;
/// Shortest length burnt twice that is worth telling, mm.
pub const NOTICEABLE: f64 = 0.05;

/// Resume point of an arm that stands within the last step that it has certainly finished: it counts a step that was cut short
/// as finished.
pub(super) fn cut_short(rest: &RemainingProgram, least: u64, pose: &Pose) -> Option<Goes> {
    let resume_point = ResumePoint::Again(least.checked_sub(1)?);
    let place = rest.goes_on(resume_point, pose)?;
    let (steps, _) = (place.0, place.1?);
    Some((ResumePoint::Again(steps), place))
}

/// The place where the light went out, of an arm that stands `stood` and has finished between `least` and `most` steps. `None`
/// if it stood when it was told to put the light out: something else had stopped it, and put the light out, before.
pub(super) fn goes_on_dark(
    rest: &RemainingProgram,
    (least, most): (u64, u64),
    dark: &LaserOffPose,
    stood: &Pose,
) -> Option<BurnPlace> {
    let off = [
        dark.pose.x - stood.x,
        dark.pose.y - stood.y,
        dark.pose.z - stood.z,
    ];
    let moved = off.iter().map(|off| off * off).sum::<f32>().sqrt() > MOVED;
    // One that was not stopped may have burnt on until it stood.
    let until = (!dark.stopped).then_some(stood);
    moved.then(|| rest.dark_at((least, most), &dark.pose, dark.late, until))?
}
