//! What is in the file, read for the place where it is to run.

use magician::JointAngles;
use magician_program::{
    Diagnostic, DiagnosticCode, FileRead, Format, Origin, Reading, Setup, UnknownStart,
};

use super::{Job, Where, notes};
use crate::context::{Context, StopPolicy};
use crate::failure::Failure;
use crate::source::Source;

/// A file that is there, and understood as far as that does not depend on where it is to run.
pub(super) struct Opened {
    pub(super) source: Source,
    format: Format,
    reading: Option<FileRead>,
}

/// What was in a file.
pub(super) struct Read {
    pub(super) source: Source,
    pub(super) file: FileRead,
    /// How a virtual arm stands where it begins, if it depends on that.
    pub(super) standing: Option<JointAngles>,
}

impl Job {
    /// Opens the file: what is wrong with it is told before an arm is looked for.
    pub(super) fn opened(&self) -> Result<Opened, Failure> {
        let source = match &self.text {
            Some(text) if self.file.format == Some(Format::TestGrid) => Source::of_test_grid(text),
            Some(text) => Source::of_text(text),
            None => Source::open(&self.file.file)?,
        };
        let format = source.format(self.file.format)?;
        let reading = match format {
            Format::Gcode => None,
            _ => match self.first_reading(&source, format, &Setup::default())? {
                Reading::Done(read) => Some(read),
                Reading::UnknownStart(_) => None,
            },
        };
        Ok(Opened {
            source,
            format,
            reading,
        })
    }

    fn first_reading(
        &self,
        source: &Source,
        format: Format,
        setup: &Setup,
    ) -> Result<Reading, Failure> {
        let read = self
            .options
            .read(format, source.bytes(), &source.title, setup);
        read.map_err(|problem| source.failure(&problem))
    }

    /// Reads it for a place, and tells what of it was taken in a certain way.
    pub(super) fn read(
        &self,
        opened: Opened,
        place: &Where,
        context: &mut Context,
    ) -> Result<Read, Failure> {
        let Opened {
            source,
            format,
            reading,
        } = opened;
        let (file, standing) = match reading {
            Some(reading) => (reading, None),
            None => {
                let setup = self.setup(place, context)?;
                match self.first_reading(&source, format, &setup)? {
                    Reading::Done(read) => (read, None),
                    Reading::UnknownStart(unknown) => {
                        Self::from_there(&source, unknown, &setup, place, context)?
                    }
                }
            }
        };
        notes(&source, &file.notes, context);
        Ok(Read {
            source,
            file,
            standing,
        })
    }

    /// Some G-code depends on where the tool stands when it begins: that place comes with it.
    fn from_there(
        source: &Source,
        unknown: UnknownStart,
        setup: &Setup,
        place: &Where,
        context: &mut Context,
    ) -> Result<(FileRead, Option<JointAngles>), Failure> {
        let (begins, virtually) = match place {
            Where::Arm => {
                let begins = context.arm(StopPolicy::Look, async |arm, _| {
                    Ok(arm.preflight_for(&[]).await?)
                })?;
                (begins, false)
            }
            _ => (unknown.on_stage(setup)?, true),
        };
        let standing = begins.arm().filter(|_| virtually).map(|arm| arm.joints);
        let read = unknown.from(source.bytes(), setup, &begins);
        let mut read = read.map_err(|problem| source.failure(&problem))?;
        let Some([x, y, z]) = read.begun.as_ref().map(|begun| begun.at) else {
            return Ok((read, None));
        };
        let what = format!("it begins at the tool's position, {x:.3},{y:.3},{z:.3}");
        let note = Diagnostic::new(Origin::NONE, what)
            .coded(DiagnosticCode::Assumed)
            .help(format!(
                "--start {x:.3},{y:.3},{z:.3} begins there again from any position"
            ));
        read.notes.insert(0, note);
        Ok((read, standing))
    }
}
