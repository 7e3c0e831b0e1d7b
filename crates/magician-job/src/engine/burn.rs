//! Place where a burn that was cut short is resumed.

use magician::LaserOffPose;
use magician::commands::Pose;
use magician_program::resume::ResumePoint;
use magician_program::{BurnPlace, RemainingProgram};

use super::pause::ResumeChoice;

/// Distance between two poses from which the arm counts as moving, mm. The poses of an arm at rest
/// are equal, and an arm that has less than this left to go is so slow that its braking distance
/// leaves no gap in the burn.
const REST_TOLERANCE: f32 = 0.001;
/// Shortest length burnt twice that is reported, mm. A choice: less is not worth a note.
pub const MIN_REPORTED_OVERLAP: f64 = 0.05;

/// Resume point of an arm that stands within the last step it reports as finished.
///
/// The arm counts a step that a stop cut short as finished.
pub(super) fn resume_in_last_step(
    rest: &RemainingProgram,
    least: u64,
    pose: &Pose,
) -> Option<ResumeChoice> {
    let resume_point = ResumePoint::Again(least.checked_sub(1)?);
    let place = rest.goes_on(resume_point, pose)?;
    let (steps, _) = (place.0, place.1?);
    Some((ResumePoint::Again(steps), place))
}

/// Place where the laser went out, for an arm that stands at `stopped_at` and has finished between
/// `least` and `most` steps.
///
/// `None` if the arm already stood when the driver switched the laser off: then something else had
/// stopped the arm and the laser before.
pub(super) fn laser_off_place(
    rest: &RemainingProgram,
    (least, most): (u64, u64),
    dark: &LaserOffPose,
    stopped_at: &Pose,
) -> Option<BurnPlace> {
    let off = [
        dark.pose.x - stopped_at.x,
        dark.pose.y - stopped_at.y,
        dark.pose.z - stopped_at.z,
    ];
    let moved = off.iter().map(|off| off * off).sum::<f32>().sqrt() > REST_TOLERANCE;
    // An arm that was not stopped may have burnt on until it came to rest.
    let until = (!dark.stopped).then_some(stopped_at);
    moved.then(|| rest.dark_at((least, most), &dark.pose, dark.late, until))?
}
