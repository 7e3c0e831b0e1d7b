//! Errors of geometry and fence as messages. `magician-motion` has the same sentences without
//! templates; assertions keep both equal.

use magician_motion::{Breach, FenceError, FencePart, MotionError, Unreachable};

use crate::{Message, message};

/// Returns the message for a motion that cannot be planned.
pub(crate) fn of_motion(error: &MotionError) -> Message {
    let message = match *error {
        MotionError::Unreachable(Unreachable::TooFar { distance, limit }) => message!(
            "out of reach: {distance:.1} mm from the shoulder, limit {limit:.1} mm",
            distance,
            limit
        ),
        MotionError::Unreachable(Unreachable::TooNear { distance, limit }) => message!(
            "too close to the arm: {distance:.1} mm, limit {limit:.1} mm",
            distance,
            limit
        ),
        MotionError::Unreachable(Unreachable::NotFinite) => {
            message!("out of reach: the target is not a finite number")
        }
        MotionError::Limit {
            bound,
            value,
            limit,
        } => {
            let joint = Message::word(bound.subject());
            message!(
                "{joint} would be at {value:.1} deg, limit {limit:.1} deg",
                joint,
                value,
                limit
            )
        }
        MotionError::Coincident => message!("two of the three points of the arc are the same"),
        MotionError::Collinear => message!("the three points of the arc are on a straight line"),
        // The messages of the other variants have no template.
        _ => error.to_string().into(),
    };
    debug_assert_eq!(message, error.to_string());
    message
}

/// Returns the message for a breach of the fence.
pub(crate) fn of_breach(breach: &Breach) -> Message {
    let Breach {
        part, value, limit, ..
    } = *breach;
    let message = match part {
        FencePart::Floor => message!(
            "the tool tip would be at z {value:.1} mm, the fence's floor is {limit:.1} mm",
            value,
            limit
        ),
        FencePart::Box { axis, upper } => {
            let axis = axis_name(axis);
            if upper {
                message!(
                    "the tool tip would be at {axis} {value:.1} mm, the fence's box ends at {limit:.1} mm",
                    axis,
                    value,
                    limit
                )
            } else {
                message!(
                    "the tool tip would be at {axis} {value:.1} mm, the fence's box begins at {limit:.1} mm",
                    axis,
                    value,
                    limit
                )
            }
        }
        FencePart::KeepOut(nth) => {
            let [x, y, z] = breach.at.unwrap_or_default();
            message!(
                "the tool tip would be at x {x:.1}, y {y:.1}, z {z:.1} mm, {value:.1} mm inside keep-out {number} of the fence",
                x,
                y,
                z,
                value,
                number = nth + 1
            )
        }
        FencePart::TopSpeed => message!(
            "the tool tip would go at {value:.1} mm/s, the fence's top speed is {limit:.1} mm/s",
            value,
            limit
        ),
        FencePart::Laser => message!(
            "the laser would burn at {value:.1} %, the fence allows {limit:.1} %",
            value,
            limit
        ),
        #[allow(unreachable_patterns)] // Exhaustive within the workspace only.
        _ => breach.to_string().into(),
    };
    debug_assert_eq!(message, breach.to_string());
    message
}

/// The sentence for an invalid fence.
impl From<FenceError> for Message {
    fn from(error: FenceError) -> Self {
        let message = match error {
            FenceError::NotFinite(part) => {
                message!("{part}: expected finite numbers", part = part.name())
            }
            FenceError::Inverted { part, axis } => message!(
                "{part}: the first corner must be below the second, and is not on {axis}",
                part = part.name(),
                axis = axis_name(axis)
            ),
            FenceError::OutOfRange(FencePart::Laser, value) => {
                message!("strongest_laser: {value} is not 0 to 100 %", value)
            }
            FenceError::OutOfRange(part, value) => {
                message!("{part}: {value} must be above 0", part = part.name(), value)
            }
            // Too many boxes: only `magician-motion` knows their limit.
            _ => error.to_string().into(),
        };
        debug_assert_eq!(message, error.to_string());
        message
    }
}

fn axis_name(axis: usize) -> &'static str {
    ["x", "y", "z"].get(axis).copied().unwrap_or("z")
}
