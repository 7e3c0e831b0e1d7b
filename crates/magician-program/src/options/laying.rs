//! A file that becomes a program before an arm, with all that this depends on: what a station does for its clients, here or in
//! another module.

use std::sync::Arc;

use magician_host::Error;
use magician_motion::Fence;

use super::{Reading, SetupDefaults, SetupOptions};
use crate::{
    AppliedPlacement, Diagnostic, Ending, Format, PartSummary, Program, Setup, WouldFit, tip,
};

/// A file that is to be read and laid before an arm.
#[derive(Clone, Debug, PartialEq)]
pub struct FileToLay {
    /// What it is.
    pub format: Format,
    /// What it is called, unless it says so itself.
    pub title: String,
    /// What is in it.
    pub bytes: Arc<[u8]>,
    /// How it is to be done.
    pub options: SetupOptions,
    /// What holds where the options leave it open.
    pub defaults: SetupDefaults,
    /// The fence of the arm.
    pub fence: Option<Fence>,
    /// Where it begins, if it depends on that and the options do not say it.
    pub begins: Begins,
}

/// Where a program begins that depends on it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub enum Begins {
    /// It is to be asked for, if the program depends on it.
    #[default]
    Ask,
    /// Where the tip of the tool is, mm.
    At([f64; 3]),
    /// Unknown: the arm does not know it either.
    Unknown,
    /// Where a virtual arm of its own stands.
    OnStage,
}

/// What came of laying a file.
#[derive(Clone, Debug, PartialEq)]
pub enum Laying {
    /// A program.
    Done(Box<LaidProgram>),
    /// It depends on where it begins: it is to be laid again with that.
    NeedsStart,
}

/// A program that lies before an arm.
#[derive(Clone, Debug, PartialEq)]
pub struct LaidProgram {
    /// What it does, once.
    pub program: Program,
    /// Where the tool was, if the program depends on it and the options did not say it, mm.
    pub start: Option<[f64; 3]>,
    /// What of it was taken in a certain way.
    pub notes: Vec<Diagnostic>,
    /// How it lies, if it was placed.
    pub placed: Option<AppliedPlacement>,
    /// Why it does not fit there.
    pub misfit: Option<Diagnostic>,
    /// In which size it would.
    pub would_fit: Option<WouldFit>,
    /// Its parts, layers unless the options say what they are, as they are in the file: without how long they take.
    pub parts: Vec<PartSummary>,
}

impl FileToLay {
    /// A file that is done as it is.
    #[must_use]
    pub fn new(format: Format, bytes: &[u8]) -> Self {
        Self {
            format,
            title: String::new(),
            bytes: bytes.into(),
            options: SetupOptions::by_file(),
            defaults: SetupDefaults::default(),
            fence: None,
            begins: Begins::default(),
        }
    }

    /// How it is laid.
    #[must_use]
    pub fn setup(&self) -> Setup {
        let mut setup = self.options.setup(&self.defaults);
        setup.fence = self.fence;
        setup
    }

    /// Reads it, and lays it before the arm.
    ///
    /// ```
    /// use magician_program::{FileToLay, Format, Laying};
    ///
    /// let mut file = FileToLay::new(Format::Gcode, b"G90\nG1 X220 Y0 Z20 F600\n");
    /// assert!(matches!(file.lay()?, Laying::Done(_)));
    /// file.bytes = (*b"G91\nG1 X5 F600\n").into();
    /// assert!(matches!(file.lay()?, Laying::NeedsStart));
    /// # Ok::<(), magician_program::Diagnostic>(())
    /// ```
    ///
    /// # Errors
    /// What is wrong with it, or cannot be done so.
    pub fn lay(&self) -> Result<Laying, Diagnostic> {
        let setup = self.setup();
        let Self {
            format,
            bytes,
            title,
            options,
            ..
        } = self;
        let mut file = match options.read(*format, bytes, title, &setup)? {
            Reading::Done(file) => file,
            Reading::UnknownStart(unknown) => {
                let at = match self.begins {
                    Begins::Ask => return Ok(Laying::NeedsStart),
                    Begins::At(at) => Some(at),
                    Begins::Unknown => None,
                    Begins::OnStage => {
                        let stands = unknown.on_stage(&setup);
                        let wrong = |error: Error| Diagnostic::of_file(error.to_string());
                        tip(&stands.map_err(wrong)?, setup.tool.or(setup.default_tool))
                    }
                };
                unknown.begun_at(bytes, &setup, at)?
            }
        };
        let begun = file.begun.as_ref().filter(|begun| !begun.said);
        let start = begun.map(|begun| begun.at);
        file.content = setup.followed(*format, file.content)?;
        let mut notes = file.notes.clone();
        let mut parts = setup.parts_in(&file.content, 1.0)?;
        let fills = setup.fills(&file.content);
        let mut laid = options.lay(&setup, file)?;
        if fills {
            PartSummary::count(&mut parts, &laid.plan);
        }
        let scale = laid.placed.map_or(1.0, |placed| placed.scale);
        { parts.iter_mut() }.for_each(|part| part.drawn_mm *= scale);
        notes.append(&mut laid.notes);
        let (placed, would_fit) = (laid.placed, laid.would_fit);
        let misfit = laid.misfit.take();
        let program = laid.program(options, &self.ending(&setup), 0, Some(1))?;
        Ok(Laying::Done(Box::new(LaidProgram {
            program,
            start,
            notes,
            placed,
            misfit,
            would_fit,
            parts,
        })))
    }

    /// What becomes of the pen and the arm at its end.
    #[must_use]
    pub fn ending(&self, setup: &Setup) -> Ending {
        let drawing = self.options.is_drawing(setup, self.format);
        self.options.ending(&self.defaults, drawing)
    }
}
