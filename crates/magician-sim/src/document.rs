//! Text that people write: taken with bounds, and saying where it is wrong.

/// The largest text that is taken, bytes: a program for the flash of 65536 commands has 7 MB.
pub const MOST_BYTES: usize = 16 << 20;

/// Why bytes cannot be taken as text.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DocumentError {
    /// It is a device that does not end, or something else than text.
    #[error("it is larger than 16 MB: is it the right file?")]
    TooLarge,
    /// It is not UTF-8.
    #[error(
        "line {line}, column {column}: this is not UTF-8: save it as UTF-8, unless it is not a \
            text file"
    )]
    NotUtf8 {
        /// The line, from 1.
        line: usize,
        /// The column in characters, from 1.
        column: usize,
    },
}

/// The text of a scenario, a profile or a flash, from the bytes of its file. A file that may not end need not be
/// read further than one byte above [`MOST_BYTES`].
///
/// # Errors
/// [`DocumentError`], whose message goes on after the file's name.
pub fn text(bytes: Vec<u8>) -> Result<String, DocumentError> {
    if bytes.len() > MOST_BYTES {
        return Err(DocumentError::TooLarge);
    }
    String::from_utf8(bytes).map_err(|error| {
        let good = error.utf8_error().valid_up_to();
        let bytes = error.into_bytes();
        let before = String::from_utf8_lossy(bytes.get(..good).unwrap_or_default());
        let (line, column) = place(&before, good);
        DocumentError::NotUtf8 { line, column }
    })
}

/// Line and column, from 1, of what is so many bytes into a text.
pub(crate) fn place(text: &str, offset: usize) -> (usize, usize) {
    let before = text.char_indices().take_while(|(at, _)| *at < offset);
    before.fold((1, 1), |(line, column), (_, char)| match char {
        '\n' => (line + 1, 1),
        _ => (line, column + 1),
    })
}

/// Where TOML is wrong, and why, in words for its author.
pub(crate) fn locate(text: &str, error: &toml::de::Error) -> (usize, usize, String) {
    let offset = error.span().map_or(0, |span| span.start);
    let (line, column) = place(text, offset);
    let message = in_words(error.message());
    let message = match key(text, offset) {
        Some(key) => format!("{key}: {message}"),
        None => message,
    };
    (line, column, message)
}

/// The name of the value that begins so many bytes into a text.
fn key(text: &str, offset: usize) -> Option<&str> {
    let line = text.get(..offset)?.rsplit('\n').next()?;
    let (before, between) = line.rsplit_once('=')?;
    let named = |char: char| char.is_ascii_alphanumeric() || char == '_';
    let key = before.trim_end().rsplit(|char| !named(char)).next()?;
    let begins = between.trim_start_matches([' ', '\t', '[', '{']).is_empty();
    (begins && !key.is_empty()).then_some(key)
}

/// The parser speaks of its own types, and some of its messages have a second line.
fn in_words(message: &str) -> String {
    const WORDS: [(&str, &str); 8] = [
        ("type: map", "type: table"),
        ("expected a sequence", "expected a list, [..]"),
        ("expected an array", "expected a list"),
        ("expected u8", "expected a whole number from 0 to 255"),
        ("expected f64", "expected a number"),
        ("expected f32", "expected a number"),
        ("expected a boolean", "expected true or false"),
        ("expected struct ", "expected a table, as for "),
    ];
    const WHOLE: [&str; 4] = ["i64", "u64", "u32", "usize"];
    let message = message.trim().replace('\n', "; ");
    let message = WORDS
        .iter()
        .fold(message, |message, (from, to)| message.replace(from, to));
    WHOLE.iter().fold(message, |message, word| {
        message.replace(&format!("expected {word}"), "expected a whole number")
    })
}
