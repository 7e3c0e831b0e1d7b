//! TOML file of the pens for the parts of a drawing.

use std::path::Path;

use magician_program::{PenOptions, SetupOptions};
use serde::Deserialize;

use crate::files::read_text;

/// Largest size of a file that is read, bytes. An arbitrary limit far above that of real files.
const MAX_FILE_SIZE: u64 = 1 << 20;

/// Content of the file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Pens {
    /// Pens in order; the first that matches a part applies.
    pen: Vec<PenOptions>,
}

/// Reads a file of pens.
///
/// # Errors
/// The path, and why the file cannot be read or parsed (see [`from_text`]).
pub fn read(path: &Path) -> Result<Vec<PenOptions>, String> {
    let shown = path.display();
    let read_error = |error: std::io::Error| format!("cannot read {shown}: {error}");
    let text = read_text(path, MAX_FILE_SIZE)
        .map_err(read_error)?
        .ok_or_else(|| format!("{shown}: no file of pens is larger than {MAX_FILE_SIZE} bytes"))?;
    from_text(&text).map_err(|problem| format!("{shown}: {problem}"))
}

/// Parses the text of a file of pens.
///
/// # Errors
/// Line and column of a syntax error or unknown field, or the number of a pen whose value is out of
/// range.
pub fn from_text(text: &str) -> Result<Vec<PenOptions>, String> {
    let pens: Pens = toml::from_str(text).map_err(|error| {
        let offset = error.span().map_or(0, |span| span.start);
        let before = text.get(..offset).unwrap_or_default();
        let line = before.matches('\n').count() + 1;
        let last_line = before.rsplit('\n').next().unwrap_or_default();
        let column = last_line.chars().count() + 1;
        let message = error.message().trim();
        format!("line {line}, column {column}: {message}")
    })?;
    let mut options = SetupOptions::default();
    options.pens = pens.pen;
    options.check().map_err(|error| error.message)?;
    Ok(options.pens)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn endless_device_file_is_too_large() {
        let refused = read(Path::new("/dev/zero")).unwrap_err();
        assert!(refused.contains("larger than 1048576"), "{refused}");
    }

    #[test]
    fn error_in_a_pen_file_has_line_and_column() {
        let problem = |text: &str| from_text(text).expect_err("it is wrong");
        let unknown = problem("[[pen]]\nmatch = \"red\"\n  colour = \"red\"\n");
        assert!(
            unknown.starts_with("line 3, column 3: unknown field `colour`"),
            "{unknown}"
        );
        for (text, expected_start) in [
            (
                "[[pen]]\nlift = 3\n",
                "line 1, column 1: missing field `match`",
            ),
            (
                "[[pen]]\nmatch = 1\nlift = -3\n",
                "pens: pen 1: lift is a number above 0 and at most 10000 mm, not -3",
            ),
            (
                "[[pen]]\nmatch = 0\n",
                "pens: pen 1: match counts parts from 1",
            ),
            (
                "[[pen]]\nmatch = 1.5\n",
                "line 2, column 9: expected a name, a colour, or a whole number from 1",
            ),
            (
                "[[pen]]\nmatch = 1\npower = nan\n",
                "pens: pen 1: power is percent above 0, not NaN",
            ),
            (
                "[[pen]]\nmatch = 1\nsurface_offset = inf\n",
                "pens: pen 1: surface_offset is -100 to 100 mm, not inf",
            ),
            (
                "[[pen]]\nmatch = 1\npasses = 0\n",
                "pens: pen 1: passes is a whole number from 1 to 1000, not 0",
            ),
            (
                "[[pen]]\nmatch = 1\nfill = \"dots\"\n",
                "line 3, column 8: fill is 'none'",
            ),
            ("[pen]\nmatch = 1\n", "line 1, column 1: "),
            ("pencil = 1\n", "line 1, column 1: unknown field `pencil`"),
            ("[[pen", "line 1, column "),
            ("\0", "line 1, column "),
        ] {
            let found = problem(text);
            assert!(found.starts_with(expected_start), "{text:?}: {found}");
        }
    }

    #[test]
    fn pen_file_is_parsed() {
        let text = "[[pen]]\nmatch = 'red'\nsurface_offset = -0.5\nlift = 4\nspeed = 20\nfill = 'hatch'\n\n[[pen]]\nmatch = 2\npower = 40\npasses = 3\n";
        let pens = from_text(text).expect("two pens");
        assert_eq!(pens.len(), 2);
        assert_eq!(
            (pens[0].lift, pens[0].surface_offset),
            (Some(4.0), Some(-0.5))
        );
        assert_eq!((pens[1].power, pens[1].passes), (Some(40.0), Some(3)));
    }
}
