//! Text files written by users: bounded in size, with the position of an error.

/// Largest accepted text, bytes. A stored program of 65,536 commands takes 7 MB; twice that is room
/// enough, and a device that never ends (`/dev/zero`) is refused early.
pub const MOST_BYTES: usize = 16 << 20;

/// Reason why bytes are not accepted as text.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DocumentError {
    /// Larger than [`MOST_BYTES`]: a device that does not end, or not a text file.
    #[error("it is larger than 16 MB: is it the right file?")]
    TooLarge,
    /// Not UTF-8.
    #[error(
        "line {line}, column {column}: this is not UTF-8: save it as UTF-8, unless it is not a \
            text file"
    )]
    NotUtf8 {
        /// Line, from 1.
        line: usize,
        /// Column in characters, from 1.
        column: usize,
    },
}

/// Converts the bytes of a scenario, a profile or a flash file to text.
///
/// A caller with an endless source may stop reading one byte after [`MOST_BYTES`].
///
/// # Errors
/// [`DocumentError`]; its message is meant to be shown after the name of the file.
pub fn text(bytes: Vec<u8>) -> Result<String, DocumentError> {
    if bytes.len() > MOST_BYTES {
        return Err(DocumentError::TooLarge);
    }
    // The error of this conversion gives the position of the first bad byte.
    String::from_utf8(bytes).map_err(|error| {
        let valid_up_to = error.utf8_error().valid_up_to();
        let bytes = error.into_bytes();
        let before = String::from_utf8_lossy(bytes.get(..valid_up_to).unwrap_or_default());
        let (line, column) = place(&before, valid_up_to);
        DocumentError::NotUtf8 { line, column }
    })
}

/// Line and column, from 1, of a byte offset in a text.
pub(crate) fn place(text: &str, offset: usize) -> (usize, usize) {
    let before = text.char_indices().take_while(|(at, _)| *at < offset);
    before.fold((1, 1), |(line, column), (_, char)| match char {
        '\n' => (line + 1, 1),
        _ => (line, column + 1),
    })
}

/// Position and message of a TOML error, in words for the author of the file.
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

/// Key of the value that starts at a byte offset. `None` if the value is not at the start of its
/// entry.
fn key(text: &str, offset: usize) -> Option<&str> {
    let line = text.get(..offset)?.rsplit('\n').next()?;
    let (before, between) = line.rsplit_once('=')?;
    let is_key_char = |char: char| char.is_ascii_alphanumeric() || char == '_';
    let key = before.trim_end().rsplit(|char| !is_key_char(char)).next()?;
    // Only the first value after `=`: a later one in a list or table has another key, or none.
    let is_first_value = between.trim_start_matches([' ', '\t', '[', '{']).is_empty();
    (is_first_value && !key.is_empty()).then_some(key)
}

/// Translates the parser's message: it names Rust types, and may have a second line.
fn in_words(message: &str) -> String {
    const REPLACEMENTS: [(&str, &str); 8] = [
        ("type: map", "type: table"),
        ("expected a sequence", "expected a list, [..]"),
        ("expected an array", "expected a list"),
        ("expected u8", "expected a whole number from 0 to 255"),
        ("expected f64", "expected a number"),
        ("expected f32", "expected a number"),
        ("expected a boolean", "expected true or false"),
        ("expected struct ", "expected a table, as for "),
    ];
    const INTEGER_TYPES: [&str; 4] = ["i64", "u64", "u32", "usize"];
    let message = message.trim().replace('\n', "; ");
    let message = REPLACEMENTS
        .iter()
        .fold(message, |message, (from, to)| message.replace(from, to));
    INTEGER_TYPES.iter().fold(message, |message, word| {
        message.replace(&format!("expected {word}"), "expected a whole number")
    })
}
