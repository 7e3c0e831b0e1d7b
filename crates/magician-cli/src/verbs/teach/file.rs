//! File of a lesson, and the rescue file with unsaved changes beside it.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use magician_job::files::replace;
use magician_program::formats::playback::Playback;
use magician_program::{Content, Format, Plan, ReadOptions};

use crate::failure::Failure;
use crate::source::Source;

/// Default name of a lesson's file.
pub(super) const DEFAULT_FILE_NAME: &str = "lesson.playback";

/// Returns the format of a file from its name. Fails if it cannot be taught.
pub(super) fn format(path: &Path) -> Result<Format, Failure> {
    match Format::of(&path.to_string_lossy(), b"") {
        Some(format @ (Format::Playback | Format::Plan)) => Ok(format),
        _ => {
            let message = format!(
                "{}: save as NAME.playback (DobotStudio reads it too) or NAME.plan.json",
                path.display()
            );
            Err(Failure::usage(message))
        }
    }
}

/// Reads the lesson of a file; `None` if the file does not exist.
pub(super) fn read(path: &Path) -> Result<Option<Plan>, Failure> {
    if !path.try_exists()? {
        return Ok(None);
    }
    let source = Source::open(path)?;
    match source.read(format(path)?, ReadOptions::default())?.content {
        Content::Plan(plan) => Ok(Some(plan)),
        _ => Err(Failure::invalid(format!(
            "{} is not a taught program",
            path.display()
        ))),
    }
}

/// Writes a plan in the format of the file's name. Returns a note if something was left out.
pub(super) fn write(path: &Path, plan: &Plan) -> Result<Option<String>, Failure> {
    let (text, note) = match format(path)? {
        Format::Playback => {
            let playback = Playback::from_plan(plan).map_err(|problem| {
                Failure::invalid(problem.to_string())
                    .hint("a name that ends in .plan.json keeps everything")
            })?;
            let note = playback
                .notes()
                .first()
                .map(|note| note.message.as_str().to_owned());
            (playback.to_xml(), note)
        }
        _ => (plan.to_json(), None),
    };
    replace(path, &text)?;
    Ok(note)
}

/// Rescue file: holds unsaved changes as a plan, beside the lesson's file.
#[derive(Clone, Debug)]
pub(super) struct RescueFile {
    path: PathBuf,
}

impl RescueFile {
    /// Returns the rescue file of a lesson.
    pub(super) fn for_lesson(path: &Path) -> Self {
        let mut name = path.as_os_str().to_owned();
        name.push("~");
        Self { path: name.into() }
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Reads the rescue file; `None` if it does not exist or is not readable.
    pub(super) fn find(&self) -> Option<Plan> {
        let bytes = fs::read(&self.path).ok()?;
        let plan = Plan::from_json(&bytes).ok()?;
        (!plan.steps.is_empty()).then_some(plan)
    }

    /// Writes the lesson's current state.
    pub(super) fn keep(&self, plan: &Plan) -> io::Result<()> {
        replace(&self.path, &plan.to_json())
    }

    /// Removes the rescue file.
    pub(super) fn forget(&self) {
        // Errors are ignored: the file may not exist, and if it remains, it is offered again.
        let _ = fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use magician_program::{Action, Origin, Travel};

    use super::*;

    fn plan() -> Plan {
        let mut plan = Plan::new("house");
        let (to, by) = ([200.0, 0.0, 10.0, 0.0], Travel::Line);
        plan.push(Action::Move { to, by }, Origin::NONE);
        plan
    }

    #[test]
    fn both_formats_round_trip_and_unsaved_changes_are_recovered() {
        let dir = tempfile::tempdir().unwrap();
        for name in ["a.playback", "b.plan.json"] {
            let path = dir.path().join(name);
            assert_eq!(read(&path).unwrap(), None);
            write(&path, &plan()).unwrap();
            let found = read(&path).unwrap().unwrap();
            assert_eq!(found.steps[0].action, plan().steps[0].action);
            let rescue = RescueFile::for_lesson(&path);
            assert_eq!(rescue.find(), None);
            rescue.keep(&plan()).unwrap();
            assert_eq!(rescue.find(), Some(plan()));
            rescue.forget();
            assert_eq!(rescue.find(), None);
        }
        let left = fs::read_dir(dir.path()).unwrap().count();
        assert_eq!(left, 2);
    }

    #[test]
    fn unsupported_names_are_refused_without_writing() {
        let dir = tempfile::tempdir().unwrap();
        for name in ["a.svg", "a", "a.gcode"] {
            assert!(write(&dir.path().join(name), &plan()).is_err(), "{name}");
        }
        let empty = Plan::new("nothing");
        assert!(write(&dir.path().join("a.playback"), &empty).is_err());
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 0);
    }
}
