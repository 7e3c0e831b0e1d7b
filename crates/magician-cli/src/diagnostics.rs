//! Errors in files for people: the excerpt with the place underlined, and what to do about it.

use annotate_snippets::renderer::DecorStyle;
use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use magician_program::{Diagnostic, Origin};
use magician_protocol::{is_deceptive, visible, visible_lines};

use crate::paint::{Paint, draws_on_stderr, width_of_stderr};
use crate::voice::Command;

/// Longest line, in characters, of which an excerpt is drawn. The library lays out every character
/// before it cuts the line, so longer ones are described in words.
const MAX_LINE: usize = 20_000;

/// Severity of a problem.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Severity {
    /// The file is refused.
    Error,
    /// The file is accepted, with this interpretation.
    Note,
}

impl Severity {
    fn level(self) -> Level<'static> {
        match self {
            Self::Error => Level::ERROR,
            Self::Note => Level::NOTE,
        }
    }
}

/// Draws a problem, without a line feed at its end. `text` is the content of the file if it is
/// text.
pub(crate) fn draw(
    problem: &Diagnostic,
    severity: Severity,
    file: &str,
    text: Option<&str>,
) -> String {
    // Colours only if stderr supports them, and only ASCII on a dumb terminal or in a file.
    let renderer = if Paint::for_stderr().is_on() {
        Renderer::styled()
    } else {
        Renderer::plain()
    };
    let decor = if draws_on_stderr() {
        DecorStyle::Unicode
    } else {
        DecorStyle::Ascii
    };
    let renderer = renderer.decor_style(decor).term_width(width_of_stderr());
    draw_by(&renderer, problem, severity, file, text)
}

fn draw_by(
    renderer: &Renderer,
    problem: &Diagnostic,
    severity: Severity,
    file: &str,
    text: Option<&str>,
) -> String {
    let excerpt = text.and_then(|text| Excerpt::of(text, &problem.origin));
    let message = match &excerpt {
        Some(_) => problem.message.as_str().to_owned(),
        None => format!("{file}: {problem}"),
    };
    // The library adds escape sequences for colours, so control characters must be made visible
    // before.
    let message = visible_lines(message).to_string();
    let file = visible(file).to_string();
    let label = problem.name.as_ref().map(|name| visible(name).to_string());
    let advice = problem.advice(&Command);
    let advice = advice.map(|advice| visible_lines(advice).to_string());
    let help = advice.map(|advice| Level::HELP.message(advice));
    let title = severity.level().primary_title(message);
    let Some(excerpt) = excerpt else {
        return renderer.render(&[title.elements(help)]);
    };
    let place = AnnotationKind::Primary.span(excerpt.span);
    let shown = Snippet::source(excerpt.line)
        .line_start(problem.origin.line as usize)
        .path(file)
        .annotation(place.label(label));
    renderer.render(&[title.element(shown).elements(help)])
}

/// Line that a problem is about.
struct Excerpt {
    line: String,
    /// Bytes of the line that are underlined.
    span: std::ops::Range<usize>,
}

impl Excerpt {
    /// Cuts the line of an origin out of the text; `None` if the text has no such place.
    fn of(text: &str, origin: &Origin) -> Option<Self> {
        let line = (origin.line as usize).checked_sub(1)?;
        let first = (origin.column as usize).checked_sub(1)?;
        let mut line: String = text.lines().nth(line)?.chars().map(plain).collect();
        let count = line.chars().count();
        if count.max(first) > MAX_LINE {
            return None;
        }
        // A place behind the last character means that the line ends too early: pad it to underline
        // there.
        line.extend(std::iter::repeat_n(' ', (first + 1).saturating_sub(count)));
        let length = (origin.length as usize).max(1);
        let mut places = line.char_indices().map(|(at, _)| at).skip(first);
        let from = places.next()?;
        let to = places.nth(length - 1).unwrap_or(line.len());
        Some(Self {
            line,
            span: from..to,
        })
    }
}

/// Replaces characters that a terminal would obey. One character stays one, so that columns match
/// the file.
fn plain(sign: char) -> char {
    match sign {
        '\t' => ' ',
        sign if is_deceptive(sign) => char::REPLACEMENT_CHARACTER,
        sign => sign,
    }
}

#[cfg(test)]
mod tests {
    use magician::{Setting, SettingValue};

    use super::*;

    fn drawn(text: &str, origin: Origin) -> String {
        let problem = Diagnostic::new(origin, "joint 2 would be at 95.0 deg, limit 90.0 deg")
            .named("outline")
            .help("move it nearer")
            .remedy((Setting::Scale, SettingValue::Number(0.5)), "fits there");
        let renderer = Renderer::plain().term_width(80);
        draw_by(&renderer, &problem, Severity::Error, "pen.nc", Some(text))
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
            "help: move it nearer; --scale 0.5 fits there",
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
    fn missing_positions_are_described_in_words() {
        for origin in [place(9, 1, 1), place(1, 0, 0), Origin::NONE] {
            let shown = drawn("G0\n", origin);
            assert!(shown.contains("pen.nc: "), "{shown}");
        }
        assert!(drawn("G0\n", place(1, 70, 9)).contains("pen.nc:1:70"));
    }

    #[test]
    fn control_characters_of_a_file_are_escaped() {
        let shown = drawn("G1 \x1b[2J X4\n", place(1, 4, 1));
        assert!(!shown.contains('\x1b'), "{shown:?}");
    }
}
