//! Kind of work that a frame traces.

use magician_host::message;
use magician_host::{Setting, SettingValue};

use super::{SetupDefaults, SetupOptions, WorkOption};
use crate::{Diagnostic, DiagnosticCode, Tool};

impl SetupOptions {
    /// True if the frame depends on the tool set on the arm, because neither work nor tool was
    /// given.
    #[must_use]
    pub fn needs_tool_in_force(&self) -> bool {
        self.frame.is_some() && self.work.is_none() && self.tool.is_none()
    }

    /// Chooses the work that a frame traces, if neither the work nor the tool was given: the work
    /// that the pen or laser set on the arm would do with the file, otherwise the work of the usual
    /// tool.
    ///
    /// Returns a note about the choice, to be shown first; `None` if there is no frame or nothing
    /// to choose.
    ///
    /// ```
    /// use magician_program::{FrameShape, SetupDefaults, SetupOptions, Tool, WorkOption};
    ///
    /// let mut options = SetupOptions::default();
    /// options.frame = Some(FrameShape::Box);
    /// let note = options.frame_for(&SetupDefaults::default(), Some(Tool::Laser)).unwrap();
    /// assert_eq!(options.work, Some(WorkOption::Engrave));
    /// assert_eq!(
    ///     note.message,
    ///     "the frame goes round what would be engraved: the arm has the laser"
    /// );
    /// ```
    pub fn frame_for(
        &mut self,
        defaults: &SetupDefaults,
        in_force: Option<Tool>,
    ) -> Option<Diagnostic> {
        if self.frame.is_none() || self.work.is_some() {
            return None;
        }
        let marks = |tool: &Tool| matches!(tool, Tool::Pen | Tool::Laser);
        let known = in_force.filter(|tool| marks(tool) || Some(*tool) == defaults.tool);
        let mut usual = defaults.clone();
        usual.tool = known.or(defaults.tool);
        let work = self.choice(&usual);
        self.work = Some(work);
        if self.tool.is_some() || self.image.is_some() {
            return None;
        }
        let (made, tool, other, otherwise) = match work {
            WorkOption::Engrave => (message!("engraved"), message!("laser"), "pen", "drawn"),
            _ => (message!("drawn"), message!("pen"), "laser", "engraved"),
        };
        let why = match (known, defaults.tool) {
            (Some(_), _) => message!("the arm has the {tool}", tool),
            (None, Some(_)) => {
                message!(
                    "the {tool} is the usual tool, and that of the arm is unknown",
                    tool
                )
            }
            (None, None) => message!(
                "the tool of the arm is unknown, so the {tool} is assumed",
                tool
            ),
        };
        let note = Diagnostic::of_file(message!(
            "the frame goes round what would be {made}: {why}",
            made,
            why
        ));
        Some(note.coded(DiagnosticCode::Assumed).remedy(
            (Setting::Tool, SettingValue::Word(other)),
            format!("goes round what would be {otherwise}"),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FrameShape;

    fn framed(in_force: Option<Tool>, usual: Option<Tool>) -> (Option<WorkOption>, String) {
        let mut options = SetupOptions {
            frame: Some(FrameShape::Box),
            ..SetupOptions::default()
        };
        let defaults = SetupDefaults {
            tool: usual,
            ..SetupDefaults::default()
        };
        let note = options.frame_for(&defaults, in_force);
        (options.work, note.expect("a note").message.into())
    }

    #[test]
    fn frame_follows_the_tool_in_force_then_the_usual_one_then_the_pen() {
        let [draw, engrave] = [Some(WorkOption::Draw), Some(WorkOption::Engrave)];
        for (in_force, usual, work, why) in [
            (Some(Tool::Laser), None, engrave, "the arm has the laser"),
            (
                Some(Tool::Laser),
                Some(Tool::Pen),
                engrave,
                "the arm has the laser",
            ),
            (
                Some(Tool::Pen),
                Some(Tool::Laser),
                draw,
                "the arm has the pen",
            ),
            (
                Some(Tool::Suction),
                Some(Tool::Laser),
                engrave,
                "is the usual tool",
            ),
            (
                Some(Tool::None),
                None,
                draw,
                "is unknown, so the pen is assumed",
            ),
            (None, None, draw, "is unknown, so the pen is assumed"),
        ] {
            let (found, told) = framed(in_force, usual);
            assert_eq!(found, work, "{in_force:?} {usual:?}");
            assert!(told.contains(why), "{told}");
        }
    }

    #[test]
    fn frame_of_given_work_or_tool_has_no_note() {
        let mut options = SetupOptions {
            frame: Some(FrameShape::Box),
            tool: Some(Tool::Laser),
            ..SetupOptions::default()
        };
        let defaults = SetupDefaults::default();
        assert_eq!(options.frame_for(&defaults, Some(Tool::Pen)), None);
        assert_eq!(options.work, Some(WorkOption::Engrave));
        assert_eq!(options.frame_for(&defaults, None), None);
    }
}
