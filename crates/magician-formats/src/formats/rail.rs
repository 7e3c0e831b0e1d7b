//! Positions of the sliding rail in taught points.

use magician_host::{Action as Deed, Message, build, message};

use crate::{Action, Diagnostic, DiagnosticCode};

/// Position of the rail's carriage along a list of taught points.
///
/// Files store a rail position even if the arm had no rail. It is then 0 in every point and is
/// ignored.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RailCourse {
    used: bool,
    at: Option<f32>,
    /// Smallest and largest position, mm.
    range: [f32; 2],
}

impl RailCourse {
    /// Creates the course from the rail positions of the points, mm. `None` means that a point has
    /// none.
    pub(super) fn of(points: impl IntoIterator<Item = Option<f32>>) -> Self {
        let mut course = Self::default();
        let mut known = points.into_iter().flatten().peekable();
        let Some(first) = known.peek().copied() else {
            return course;
        };
        course.range = [first; 2];
        for l in known {
            course.used |= l != 0.0;
            let [least, most] = course.range;
            course.range = [least.min(l), most.max(l)];
        }
        course
    }

    /// Returns the motion with the rail moved along. A point without a position leaves the carriage
    /// where it is.
    ///
    /// # Errors
    /// A sentence if the rail would have to move during an arc or a path, which the arm cannot do.
    pub(super) fn with_rail(&mut self, motion: Action, l: Option<f32>) -> Result<Action, Message> {
        let Some(l) = l.or(self.at).filter(|_| self.used) else {
            return Ok(motion);
        };
        let before = self.at.replace(l);
        if motion.marks() {
            return if before == Some(l) {
                Ok(motion)
            } else {
                Err(message!(
                    "the rail moves to {l} mm on an arc or a path; it moves only along with point-to-point moves",
                    l
                ))
            };
        }
        let along = motion.command().map(|command| build::with_rail(command, l));
        Ok(match along {
            Some(Ok(along)) => Action::from(along),
            // Only point-to-point moves have a form with the rail.
            _ => motion,
        })
    }

    /// Returns a note that the arm must be on a rail; `None` if the rail is not used.
    pub(super) fn note(&self) -> Option<Diagnostic> {
        let [least, most] = self.range;
        self.used.then(|| {
            let what = if least == most {
                message!(
                    "it is played at {most} mm on the rail: the arm has to be on one",
                    most
                )
            } else {
                message!(
                    "it moves along the rail, from {least} to {most} mm: the arm has to be on one",
                    least,
                    most
                )
            };
            let note = Diagnostic::of_file(what).coded(DiagnosticCode::Assumed);
            note.remedy(Deed::UseRail, "tells the arm that it is; home it then")
        })
    }
}
