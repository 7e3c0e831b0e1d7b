//! What is wrong in a file, as people see it: the place underlined, and what to do about it.

use std::fmt;

use magician_program::{Origin, Problem};
use magician_protocol::{is_deceptive, visible, visible_lines};
use miette::{
    Diagnostic, GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteError,
    MietteSpanContents, Severity, SourceCode, SourceSpan, SpanContents,
};

use crate::output::{Paint, draws_on_stderr, width_of_stderr};
use crate::voice::Command;

/// So much narrower than the terminal is what is shown of a line.
const MARGIN: usize = 10;

/// Draws a problem: `text` is the file's, if it is one. Ends without a line feed.
pub(crate) fn draw(
    problem: &Problem,
    severity: Severity,
    file: &str,
    text: Option<&str>,
) -> String {
    draw_with(problem, severity, file, text, style(), width_of_stderr())
}

fn draw_with(
    problem: &Problem,
    severity: Severity,
    file: &str,
    text: Option<&str>,
    style: GraphicalTheme,
    width: usize,
) -> String {
    let most = width.saturating_sub(MARGIN);
    let excerpt = text.and_then(|text| Excerpt::of(file, text, &problem.origin, most));
    let message = match &excerpt {
        Some(_) => problem.message.clone(),
        None => format!("{file}: {problem}"),
    };
    // The library colours the drawing, so that what it is given has to be harmless before.
    let figure = Figure {
        message: visible_lines(message).to_string(),
        severity,
        help: problem
            .advice(&Command)
            .map(|advice| visible_lines(advice).to_string()),
        label: problem.name.as_ref().map(|name| visible(name).to_string()),
        excerpt,
    };
    let mut drawn = String::new();
    let handler = GraphicalReportHandler::new_themed(style).with_width(width);
    // Writing to a string cannot fail; a figure that does is told in words.
    match handler.render_report(&mut drawn, &figure) {
        Ok(()) => drawn.trim_end().to_owned(),
        Err(fmt::Error) => figure.message,
    }
}

/// With colours where there are any, and without more than ASCII where the terminal is dumb or none.
fn style() -> GraphicalTheme {
    match (draws_on_stderr(), Paint::for_stderr().is_on()) {
        (true, true) => GraphicalTheme::unicode(),
        (true, false) => GraphicalTheme::unicode_nocolor(),
        (false, true) => GraphicalTheme::ascii(),
        (false, false) => GraphicalTheme::none(),
    }
}

/// A problem as the drawing takes it.
#[derive(Debug)]
struct Figure {
    message: String,
    severity: Severity,
    help: Option<String>,
    label: Option<String>,
    excerpt: Option<Excerpt>,
}

/// The line that it is about, or as much of it as fits.
#[derive(Debug)]
struct Excerpt {
    file: String,
    line: usize,
    column: usize,
    text: String,
    /// The bytes of it that are underlined.
    span: SourceSpan,
}

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Figure {}

impl Diagnostic for Figure {
    fn severity(&self) -> Option<Severity> {
        Some(self.severity)
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        let help = self.help.as_ref()?;
        Some(Box::new(help))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        let excerpt = self.excerpt.as_ref()?;
        Some(excerpt)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let span = self.excerpt.as_ref()?.span;
        let label = LabeledSpan::new_primary_with_span(self.label.clone(), span);
        Some(Box::new(std::iter::once(label)))
    }
}

impl SourceCode for Excerpt {
    fn read_span<'a>(
        &'a self,
        _: &SourceSpan,
        _: usize,
        _: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let whole = SourceSpan::from(0..self.text.len());
        let (line, column) = (self.line.saturating_sub(1), self.column.saturating_sub(1));
        let name = self.file.clone();
        let contents =
            MietteSpanContents::new_named(name, self.text.as_bytes(), whole, line, column, 1);
        Ok(Box::new(contents))
    }
}

impl Excerpt {
    /// The line of an origin, at most so many characters of it; none for a place that the text does not have.
    fn of(file: &str, text: &str, origin: &Origin, most: usize) -> Option<Self> {
        let line = (origin.line as usize).checked_sub(1)?;
        let first = (origin.column as usize).checked_sub(1)?;
        let line: Vec<char> = text.lines().nth(line)?.chars().map(plain).collect();
        let length = (origin.length as usize).max(1);
        let from = match line.len() > most {
            true => first.saturating_sub(most / 3),
            false => 0,
        };
        let shown = line.iter().skip(from).take(most);
        let (mut text, mut span) = (String::new(), (0, 0));
        for (at, sign) in shown.enumerate() {
            if at + from == first {
                span.0 = text.len();
            }
            text.push(*sign);
            if at + from < first.saturating_add(length) {
                span.1 = text.len();
            }
        }
        // A place behind the last character: the line ends too early.
        if first >= from + text.chars().count() {
            text.push(' ');
            span = (text.len() - 1, text.len());
        }
        Some(Self {
            file: visible(file).to_string(),
            line: origin.line as usize,
            column: origin.column as usize,
            text,
            span: SourceSpan::from(span.0..span.1),
        })
    }
}

/// What a terminal would obey is not shown to it. One sign stays one, so that the columns are those of the file.
fn plain(sign: char) -> char {
    match sign {
        '\t' => ' ',
        sign if is_deceptive(sign) => char::REPLACEMENT_CHARACTER,
        sign => sign,
    }
}

#[cfg(test)]
mod tests {
    use magician::{Given, Setting};

    use super::*;

    fn drawn(text: &str, origin: Origin) -> String {
        let problem = Problem::new(origin, "joint 2 would be at 95.0 deg, limit 90.0 deg")
            .named("outline")
            .help("move it nearer")
            .remedy((Setting::Scale, Given::Number(0.5)), "would do");
        let style = GraphicalTheme::none();
        draw_with(&problem, Severity::Error, "pen.nc", Some(text), style, 80)
    }

    fn place(line: u32, column: u32, length: u32) -> Origin {
        Origin {
            line,
            column,
            length,
            ..Origin::NONE
        }
    }

    #[test]
    fn the_place_is_underlined_and_named() {
        let shown = drawn("G0 X1\nG1 X400 Y2\n", place(2, 4, 4));
        for part in [
            "joint 2 would be at 95.0 deg",
            "pen.nc:2:4",
            "2 | G1 X400 Y2",
            "outline",
            "help: move it nearer; --scale 0.5 would do",
        ] {
            assert!(shown.contains(part), "{part}: {shown}");
        }
        let lines: Vec<_> = shown.lines().collect();
        let at = lines
            .iter()
            .position(|line| line.contains("G1 X400"))
            .expect("the line");
        assert_eq!(lines[at].find("X400"), lines[at + 1].find("^"), "{shown}");
    }

    #[test]
    fn a_long_line_is_cut_and_its_column_is_that_of_the_file() {
        let text = format!("{}PLACE{}", "x".repeat(5000), "y".repeat(5000));
        let shown = drawn(&text, place(1, 5001, 5));
        assert!(shown.contains("pen.nc:1:5001"), "{shown}");
        assert!(shown.contains("PLACE") && shown.len() < 1000, "{shown}");
    }

    #[test]
    fn places_that_are_not_there_are_told_in_words() {
        for origin in [place(9, 1, 1), place(1, 0, 0), Origin::NONE] {
            let shown = drawn("G0\n", origin);
            assert!(shown.contains("pen.nc: "), "{shown}");
        }
        assert!(drawn("G0\n", place(1, 70, 9)).contains("pen.nc:1:70"));
    }

    #[test]
    fn a_terminal_obeys_nothing_in_a_file() {
        let shown = drawn("G1 \x1b[2J X4\n", place(1, 4, 1));
        assert!(!shown.contains('\x1b'), "{shown:?}");
    }
}
