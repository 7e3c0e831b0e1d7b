//! File that the user names: read completely, parsed, and with errors shown at their place.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::sync::Arc;

use magician::report::ErrorFigures;
use magician_program::{Content, Diagnostic, Format, Parsed, ReadOptions, foreign, source_text};

use crate::diagnostics::{self, Severity};
use crate::failure::Failure;

/// Largest file that is read, bytes. A choice: far above real drawings, small enough for memory.
const MAX_FILE_SIZE: u64 = 256 << 20;

/// Longest quotation of a line in a sentence, in characters.
const MAX_QUOTE_LENGTH: usize = 40;

/// File that has been read.
#[derive(Debug)]
pub(crate) struct Source {
    /// Name as the user wrote it; `stdin` for `-`.
    pub(crate) name: String,
    /// Name without folder and extension.
    pub(crate) title: String,
    bytes: Arc<[u8]>,
}

impl Source {
    /// Reads a file, or standard input for `-`.
    pub(crate) fn open(path: &Path) -> Result<Self, Failure> {
        let is_stdin = path.as_os_str() == "-";
        let name = if is_stdin {
            "stdin".to_owned()
        } else {
            path.display().to_string()
        };
        let wrong = |error: &dyn std::fmt::Display| {
            Failure::invalid(format!("{name} cannot be read: {error}"))
        };
        let mut bytes = Vec::new();
        let read = if is_stdin {
            io::stdin()
                .lock()
                .take(MAX_FILE_SIZE + 1)
                .read_to_end(&mut bytes)
        } else {
            let file = File::open(path).map_err(|error| wrong(&error))?;
            file.take(MAX_FILE_SIZE + 1).read_to_end(&mut bytes)
        };
        let count = read.map_err(|error| wrong(&error))?;
        if count as u64 > MAX_FILE_SIZE {
            return Err(wrong(&format!(
                "it is larger than {} MB",
                MAX_FILE_SIZE >> 20
            )));
        }
        let title = Format::title(&name).to_owned();
        Ok(Self {
            name,
            title,
            bytes: bytes.into(),
        })
    }

    /// Creates a source from text given on the command line.
    pub(crate) fn of_text(text: &str) -> Self {
        let first = text.lines().next().unwrap_or_default();
        Self {
            name: "text".to_owned(),
            title: first.chars().take(MAX_QUOTE_LENGTH).collect(),
            bytes: text.as_bytes().into(),
        }
    }

    /// Creates a source from a test grid that flags describe.
    pub(crate) fn of_test_grid(text: &str) -> Self {
        Self {
            name: "test grid".to_owned(),
            title: "test grid".to_owned(),
            bytes: text.as_bytes().into(),
        }
    }

    /// Returns the file's name without its folder.
    pub(crate) fn short_name(&self) -> &str {
        let name = Path::new(&self.name).file_name();
        name.and_then(|name| name.to_str()).unwrap_or(&self.name)
    }

    /// Returns the format: `said` if given, otherwise derived from the name and the first bytes.
    pub(crate) fn format(&self, requested: Option<Format>) -> Result<Format, Failure> {
        let known = requested.or_else(|| Format::of(&self.name, &self.bytes));
        known.ok_or_else(|| {
            if let Some(foreign) = foreign(&self.name, &self.bytes) {
                return self.failure(&foreign);
            }
            let message = format!("{}: unrecognised file type", self.name);
            let endings = Format::ALL.iter().flat_map(|format| format.endings());
            let endings: Vec<_> = endings.copied().collect();
            let hint = format!(
                "known extensions: {}; otherwise give the type with `--format`",
                endings.join(" ")
            );
            Failure::invalid(message).hint(hint)
        })
    }

    /// Returns the content.
    pub(crate) fn bytes(&self) -> Arc<[u8]> {
        Arc::clone(&self.bytes)
    }

    /// Parses the content.
    pub(crate) fn read(
        &self,
        format: Format,
        mut options: ReadOptions,
    ) -> Result<Parsed<Content>, Failure> {
        options.title.clone_from(&self.title);
        magician_program::read(format, &self.bytes, &options)
            .map_err(|problem| self.failure(&problem))
    }

    /// Returns a line of the content, shortened for a sentence; `None` if the content is not text.
    pub(crate) fn quoted_line(&self, line: u32) -> Option<String> {
        let text = source_text(&self.bytes)?;
        let nth = (line as usize).checked_sub(1)?;
        let words = text.lines().nth(nth)?.trim();
        let short: String = words.chars().take(MAX_QUOTE_LENGTH).collect();
        let short = if short.len() < words.len() {
            format!("{}..", short.trim_end())
        } else {
            short
        };
        (!short.is_empty()).then_some(short)
    }

    /// Converts a problem into a failure with its drawing and remedies.
    pub(crate) fn failure(&self, problem: &Diagnostic) -> Failure {
        let failure = Failure::invalid(format!("{}: {problem}", self.name));
        let figures = ErrorFigures::of(&magician::Error::from(problem.clone()));
        failure
            .about(figures)
            .drawn(self.draw(problem, Severity::Error))
    }

    /// Draws a problem with the excerpt of the file.
    pub(crate) fn draw(&self, problem: &Diagnostic, severity: Severity) -> String {
        let text = source_text(&self.bytes);
        diagnostics::draw(problem, severity, &self.name, text.as_deref())
    }
}
