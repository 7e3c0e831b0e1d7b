//! Taught points that say where the carriage of a sliding rail is.

use magician_host::{Action as Deed, build};

use crate::{Action, Diagnostic, DiagnosticCode};

/// Follows the rail through taught points.
///
/// Files have a rail position also where no rail was in use: it is 0 throughout then, and says nothing.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RailCourse {
    used: bool,
    at: Option<f32>,
    /// The least and the greatest position, mm.
    range: [f32; 2],
}

impl RailCourse {
    /// The rail of points with these positions, mm.
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

    /// The motion to a point that takes the rail along. A point without a position leaves the carriage where it is.
    ///
    /// # Errors
    /// Why the arm cannot: the rail would have to move on an arc or a path.
    pub(super) fn lead(&mut self, motion: Action, l: Option<f32>) -> Result<Action, String> {
        let Some(l) = l.or(self.at).filter(|_| self.used) else {
            return Ok(motion);
        };
        let before = self.at.replace(l);
        if motion.marks() {
            return if before == Some(l) {
                Ok(motion)
            } else {
                Err(format!(
                    "the rail moves to {l} mm on an arc or a path; it moves only along with point-to-point moves"
                ))
            };
        }
        let along = motion.command().map(|command| build::with_rail(command, l));
        Ok(match along {
            Some(Ok(along)) => Action::from(along),
            _ => motion,
        })
    }

    /// Note that the arm has to be on a rail.
    pub(super) fn note(&self) -> Option<Diagnostic> {
        let [least, most] = self.range;
        self.used.then(|| {
            let what = if least == most {
                format!("it is played at {most} mm on the rail: the arm has to be on one")
            } else {
                format!(
                    "it moves along the rail, from {least} to {most} mm: the arm has to be on one"
                )
            };
            let note = Diagnostic::of_file(what).coded(DiagnosticCode::Assumed);
            note.remedy(Deed::UseRail, "tells the arm that it is; home it then")
        })
    }
}
